/* The branches of products, one route after the other. */
#include "state.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "components.h"
#include "error.h"
#include "facts.h"
#include "mem.h"
#include "points.h"
#include "product_routes.h"
#include "reduction.h"
#include "oracle.h"
#include "print.h"
#include "system.h"
#include "warnings.h"

enum { RESEEDS = 2 };      /* what ended in a refusal is begun anew so often: the refusal stands then */
static const double BESIDE = 0.002;      /* of a place, which is a general point: other components may be near */
static const double AT_GUESS = 1e-6;     /* relative to the variable, or to its natural size */
static const double NEARER = 0.7;        /* a branch is nearer than another if it is so much nearer: its nearest point is known about */

/* The next route: the last decision that has an option left takes it, those after it are
 * forgotten. False where there is none. */
static bool next_route(struct route *r)
{
    while (r->count && r->at[r->count - 1].chosen + 1 >= r->at[r->count - 1].options)
        r->count--;
    if (!r->count)
        return false;
    r->at[r->count - 1].chosen++;
    return true;
}

/* The same among the branches of products; alike: among those that are as near to the guess as the first. */
static bool next_branch(struct route *r, bool alike)
{
    int last = r->count - 1;
    while (last >= 0 && (r->at[last].side || r->at[last].chosen + 1 >= (alike ? r->at[last].alike : r->at[last].options)))
        last--;
    if (last < 0)
        return false;
    r->count = last + 1;
    r->at[last].chosen++;
    return true;
}

static bool has_next(const struct route *r)
{
    for (int i = 0; i < r->count; i++)
        if (r->at[i].chosen + 1 < r->at[i].options)
            return true;
    return false;
}

static void copy_route(struct route *to, const struct route *from)
{
    SGA_RESERVE(to->at, to->cap, from->count + 1);
    if (from->count)
        memcpy(to->at, from->at, (size_t)from->count * sizeof *to->at);
    to->count = from->count;
    to->far = from->far;
    to->off = from->off;
}

static bool same_route(const struct route *a, const struct route *b)
{
    bool same = a->count == b->count;
    for (int i = 0; i < a->count && same; i++)
        same = a->at[i].product == b->at[i].product && a->at[i].chosen == b->at[i].chosen;
    return same;
}

bool routes_local(enum sga_code code)
{
    return code == SGA_E_NO_REAL_POINT || code == SGA_E_IRREGULAR || code == SGA_E_UNDECIDED || code == SGA_E_SPLIT;
}

void routes_restart(struct points_oracle *oracle, uint64_t seed, struct sga_solution *solution)
{
    sga_solution_clear(solution);
    points_oracle_forget(oracle);
    oracle->random = seed;       /* the same points again */
}

struct reduction_options routes_options(const struct routes *r, const struct reduction_options *options, int place)
{
    struct reduction_options own = *options;
    if (place >= 0) {
    assert(place < r->components->places);
        own.near = r->components->place[place].x;
        own.near_given = NULL;
        own.near_time = r->components->place[place].t;
        own.near_spread = BESIDE;
        own.parameter_near = r->components->place[place].parameter;
    }
    return own;
}

/* A contradiction is one of general points: what was divided by is remembered. */
static void keep_pivots(struct routes *r, const struct sys_system *system, const struct sga_solution *solution)
{
    SGA_ENDS(expr_facts_clear) struct expr_facts facts;
    expr_facts_init(&facts);
    for (int q = 0; q < solution->pivots + solution->deads; q++) {
        expr_id v = q < solution->pivots ? solution->pivot[q].value : solution->dead[q - solution->pivots].value;
        unsigned f = expr_facts_of(&facts, system->store, v);
        bool known = f & EXPR_NONZERO || !(f & EXPR_HAS_VARIABLE);
        for (int i = 0; i < r->pivots && !known; i++)
            known = r->pivot[i] == v;
        if (known)
            continue;
        SGA_RESERVE(r->pivot, r->pivot_cap, r->pivots + 1);
        r->pivot[r->pivots++] = v;
    }
}

/* How far a place is from the guess, in the values that were given: a square. */
static double how_far(const double *x, int variables, const struct reduction_options *o)
{
    double sum = 0;
    for (int j = 0; j < variables; j++)
        if (!o->near_given || o->near_given[j])
            sum += pow((x[j] - o->near[j]) / fmax(1, fabs(o->near[j])), 2);
    return sum;
}

/* The last route takes branches that are as near to the guess as the first ones. */
static bool is_alike(const struct route *r)
{
    bool alike = true;
    for (int i = 0; i < r->count && alike; i++)
        alike = r->at[i].side || r->at[i].chosen == 0 || r->at[i].chosen < r->at[i].alike;
    return alike;
}

/* Of the largest dimension; of two alike the one that leaves less free. Near a guess the first one, but for another that is nearer where both meet at the guess, or
 * that keeps all values that were given (how far the first is, is known at the most). */
static bool is_best(const struct routes *r, const struct sga_solution *solution, int final)
{
    if (r->others)
        return final >= 0 && r->now.far >= 0 && (r->now.far <= AT_GUESS || (is_alike(&r->now) && r->now.far < NEARER * r->best.far));
    return final > r->final || (final == r->final && final >= 0 && solution->verdict < r->verdict);
}

/* Regular functions took the place of irregular ones near a point. */
static bool rests_on_points(const struct sga_solution *sol)
{
    bool rests = false;
    for (int i = 0; i < sol->constraints; i++)
        rests |= sol->constraint[i].near_point;
    return rests;
}

/* Sides that the last run found its answer, or its failure, to rest on: beyond them another route begins. */
static void add_sides(struct routes *r, const struct points_oracle *oracle)
{
    for (int k = 0; k < oracle->sides; k++) {
        const struct points_side *side = oracle->side + k;
        bool known = side->unseen;
        for (int i = 0; i < r->now.count && !known; i++)
            known = r->now.at[i].side && r->now.at[i].product == side->function;
        if (known)
            continue;
        SGA_RESERVE(r->now.at, r->now.cap, r->now.count + 1);
        r->now.at[r->now.count++] = (struct decision){ .product = side->function, .options = 2, .side = (signed char)side->sign };
    }
}

/* Isolated points that are not proved to be some: where branches meet, the constraints of each are met by steps, and by nothing else. */
static bool no_points(const struct sga_solution *sol, const struct points_oracle *oracle, struct sga_error *err)
{
    if (sol->verdict != SGA_ISOLATED || rests_on_points(sol) || !oracle->reals || points_oracle_certified(oracle))
        return false;
    sga_fail(err, SGA_E_IRREGULAR, "the constraints hold at isolated points where their differentials depend on each other, as where branches "
             "of the set meet; write the constraints in a form whose gradients are independent there");
    return true;
}

/* A contradiction on one branch of a product, while no point was found on another one: it says nothing of that. */
static bool passed_over(const struct sys_system *system, const struct sga_solution *sol, struct sga_error *err)
{
    if (sol->verdict != SGA_INCONSISTENT || !sol->passed)
        return false;
    SGA_FREED char *text = expr_text(system->store, sol->passed, 300);
    sga_fail(err, SGA_E_NO_REAL_POINT, "the constraints contradict each other on one branch of a product, and on the branch where %s is 0 no regular point was found "
             "(this is not a proof that there is none); give trajectory.initial near such a point", text);
    return true;
}

/* Whether a run near a guess ended at a point, and not at the guess: another component may have it. */
static bool point_elsewhere(const struct sys_system *system, const struct reduction_options *o, const struct points_oracle *oracle,
                            const struct sga_solution *sol, int final)
{
    bool away = false;
    for (int j = 0; j < system->variables && final == 0 && sol->verdict == SGA_ISOLATED && oracle->reals; j++)
        away |= (!o->near_given || o->near_given[j])
                && fabs(oracle->real[0].x[j] - o->near[j]) > AT_GUESS * fmax(sol->scale ? ldexp(1, sol->scale[j]) : 1, fabs(o->near[j]));
    return away;
}

/* One run, near a place or where the options say. False: a failure that ends the job. */
static bool run_one(struct routes *r, const struct sys_system *system, const struct reduction_options *options, int place,
                    struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err)
{
    struct sga_error here = { 0 };
    struct reduction_options own = routes_options(r, options, place);
    bool ok = state_solve(system, &own, oracle, &r->now, solution, &here) && !no_points(solution, oracle, &here) && !passed_over(system, solution, &here);
    add_sides(r, oracle);
    r->tried++;
    r->now_at = place;
    if (!ok && (!routes_local(here.code) || !expr_store_ok(system->store))) {
        *err = here;
        return false;
    }
    if (!ok && !r->failed++)
        r->error = here;
    if (ok && solution->verdict == SGA_INCONSISTENT) {
        keep_pivots(r, system, solution);
        r->beside |= rests_on_points(solution);
    }
    int final = ok && solution->verdict != SGA_INCONSISTENT ? system->variables - solution->constraints : -1;
    /* near a guess only where nothing is there */
    bool explore = r->explore && !options->near_only && (!options->near || final < 0 || point_elsewhere(system, options, oracle, solution, final));
    if (is_best(r, solution, final)) {
        r->final = final;
        r->verdict = solution->verdict;
        r->best_at = place;
        r->best_run = explore ? r->components->runs : -1;
        copy_route(&r->best, &r->now);
    }
    if (explore)
        components_note(r->components, system, options, solution, oracle, place, final, !ok && here.code == SGA_E_SPLIT);
    r->ended = final >= 0;
    return true;
}

static bool run_products(struct routes *r, const struct sys_system *system, const struct reduction_options *options,
                         struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err)
{
    for (;;) {
        if (!run_one(r, system, options, -1, oracle, solution, err))
            return false;
        if (options->near && (r->ended || r->others)) {
            /* how far a factor's zeros are says little of where hidden constraints lead: another branch may be nearer, or keep what was given */
            r->others = r->best.far > AT_GUESS && r->tried < SGA_MOST_ROUTES && next_branch(&r->now, r->best.off);
            if (!r->others)
                return true;
            routes_restart(oracle, r->seed, solution);
            continue;
        }
        r->left = has_next(&r->now);
        if (r->left && r->tried >= SGA_MOST_ROUTES)
            sga_limit_met(options->budget, SGA_LIMIT_ROUTES);
        if (!r->left || r->tried >= SGA_MOST_ROUTES)
            return true;
        next_route(&r->now);
        routes_restart(oracle, r->seed, solution);
    }
}

/* Whether it may have been by chance of the points that no route came to an end. */
static bool unlucky(const struct routes *r)
{
    return r->final < 0 && r->failed && r->error.code != SGA_E_NO_REAL_POINT;
}

/* A place that was not tried yet; near a guess the nearest, until one leads to points. -1: none. */
static int next_place(const struct routes *r, int variables, const struct reduction_options *options)
{
    const struct components *c = r->components;
    int next = -1;
    double least = INFINITY;
    for (int k = 0; k < c->places && !(options->near && (r->final > 0 || (r->final == 0 && !c->runs))); k++) {
        double far = options->near ? how_far(c->place[k].x, variables, options) : k;
        if (!c->place[k].tried && far < least) {
            next = k;
            least = far;
        }
    }
    return next;
}

bool routes_explore(struct routes *r, const struct sys_system *system, const struct reduction_options *options,
                    struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err)
{
    if (!r->components)
        r->components = sga_calloc(1, sizeof *r->components);
    bool ok = run_products(r, system, options, oracle, solution, err);
    r->products = r->tried;
    for (int k = 1; k <= RESEEDS && ok && unlucky(r); k++) {
        r->now.count = r->failed = r->tried = 0;
        r->seed += (uint64_t)k;
        routes_restart(oracle, r->seed, solution);
        ok = run_products(r, system, options, oracle, solution, err);
    }
    /* each place adds its own run, which may find others */
    int k;
    while (ok && (k = next_place(r, system->variables, options)) >= 0) {
        r->components->place[k].tried = true;
        r->now.count = 0;
        routes_restart(oracle, r->seed, solution);
        ok = run_one(r, system, options, k, oracle, solution, err);
    }
    return ok;
}

void routes_clear(struct routes *r)
{
    free(r->now.at);
    free(r->best.at);
    free(r->pivot);
    if (r->components)
        components_clear(r->components);
    free(r->components);
}

/* The components that were not taken, where they hold solutions and the answer does not speak of them. The branches of
 * products are listed as such. */
static void keep_elsewhere(struct routes *r, const struct sys_system *system, const struct reduction_options *options, struct sga_solution *solution)
{
    struct components *c = r->components;
    size_t variables = (size_t)system->variables;
    solution->elsewhere = sga_calloc((size_t)c->runs + 1, sizeof *solution->elsewhere);
    for (int k = 0; k < c->runs && r->best_run >= 0; k++)
        if (c->run[k].final >= 0 && k != r->best_run && (c->run[k].place >= 0 || r->products == 1)
            && components_apart(c, system, options, solution, r->best_run, k)) {
            struct sga_elsewhere *e = solution->elsewhere + solution->elsewheres++;
            e->x = memcpy(sga_malloc((variables + 1) * sizeof *e->x), c->run[k].point.x, variables * sizeof *e->x);
            e->t = c->run[k].point.t;
            e->final = c->run[k].final;
        }
}

bool sga_reduce(const struct sys_system *system, const struct reduction_options *given,
               struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err)
{
    SGA_ENDS(routes_clear) struct routes r = { .final = -1, .seed = oracle->random, .explore = true,
                                                   .best_at = -1, .now_at = -1, .best_run = -1 };
    struct sga_conditions conditions = { 0 };
    struct reduction_options own = *given, *options = &own;
    own.conditions = &conditions;
    bool ok = routes_explore(&r, system, options, oracle, solution, err);
    if (ok && r.final < 0 && (r.beside || r.failed) && own.near && !own.near_only) {  /* nothing near the guess, or nothing regular: then anywhere */
        own.near = NULL;
        own.near_given = NULL;
        r.now.count = r.failed = r.tried = 0;
        routes_restart(oracle, r.seed, solution);
        ok = routes_explore(&r, system, options, oracle, solution, err);
    }
    if (ok && r.final < 0 && r.failed) {      /* empty as far as known, but not known of every branch */
        *err = r.error;
        ok = false;
    } else if (ok && r.final < 0 && r.left) {
        ok = sga_fail(err, SGA_E_UNDECIDED, "the constraints have many branches, and the first %d of them are empty; "
                      "give trajectory.initial on the branch that is meant", SGA_MOST_ROUTES);
    } else if (ok && r.final < 0) {
        ok = special_points_solve(&r, system, options, oracle, solution, err);
    } else if (ok && (r.now_at != r.best_at || !same_route(&r.now, &r.best))) {
        struct reduction_options best = routes_options(&r, options, r.best_at);
        routes_restart(oracle, r.seed, solution);
        ok = state_solve(system, &best, oracle, &r.best, solution, err);
    }
    if (ok)
        keep_elsewhere(&r, system, options, solution);
    if (!ok && !err->stage[0])
        memcpy(err->stage, "sga", 4);
    if (ok)
        solution->conditions = conditions;
    else
        sga_conditions_clear(&conditions);
    return ok;
}
