/* The branches of products, one route after the other. */
#include "state.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "routes.h"
#include "warnings.h"

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
}

static bool same_route(const struct route *a, const struct route *b)
{
    bool same = a->count == b->count;
    for (int i = 0; i < a->count && same; i++)
        same = a->at[i].product == b->at[i].product && a->at[i].chosen == b->at[i].chosen;
    return same;
}

/* Failures of one branch, which say nothing about another. */
static bool is_local(enum sga_code code)
{
    return code == SGA_E_NO_REAL_POINT || code == SGA_E_IRREGULAR || code == SGA_E_UNDECIDED || code == SGA_E_SPLIT;
}

void routes_restart(struct points_shadow *shadow, uint64_t seed, struct sga_solution *solution)
{
    sga_solution_clear(solution);
    points_shadow_forget(shadow);
    shadow->random = seed;
}

/* A contradiction is one of general points: what was divided by is remembered. */
static void keep_pivots(struct routes *r, const struct sys_system *system, const struct sga_solution *solution)
{
    struct expr_facts facts;
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
    expr_facts_clear(&facts);
}

/* Sides that the last run found its answer, or its failure, to rest on: beyond them another route begins. */
static void add_sides(struct routes *r, const struct points_shadow *shadow)
{
    for (int k = 0; k < shadow->sides; k++) {
        const struct points_side *side = shadow->side + k;
        bool known = side->unseen;
        for (int i = 0; i < r->now.count && !known; i++)
            known = r->now.at[i].side && r->now.at[i].product == side->function;
        if (known)
            continue;
        SGA_RESERVE(r->now.at, r->now.cap, r->now.count + 1);
        r->now.at[r->now.count++] = (struct decision){ .product = side->function, .options = 2, .side = (signed char)side->sign };
    }
}

bool routes_explore(struct routes *r, const struct sys_system *system, const struct sga_options *options,
                    struct points_shadow *shadow, struct sga_solution *solution, struct sga_error *err)
{
    for (;;) {
        struct sga_error here = { 0 };
        bool ok = state_solve(system, options, shadow, &r->now, solution, &here);
        add_sides(r, shadow);
        r->tried++;
        if (!ok && (!is_local(here.code) || !expr_store_ok(system->store))) {
            *err = here;
            return false;
        }
        if (!ok && !r->failed++)
            r->error = here;
        if (ok && solution->verdict == SGA_INCONSISTENT)
            keep_pivots(r, system, solution);
        int final = ok && solution->verdict != SGA_INCONSISTENT ? system->variables - solution->constraints : -1;
        if (final > r->final) {
            r->final = final;
            copy_route(&r->best, &r->now);
        }
        if (final >= 0 && options->near)
            return true;
        r->left = has_next(&r->now);
        if (r->left && r->tried >= SGA_MOST_ROUTES)
            sga_limit_met(options->budget, SGA_LIMIT_ROUTES);
        if (!r->left || r->tried >= SGA_MOST_ROUTES)
            return true;
        next_route(&r->now);
        routes_restart(shadow, r->seed, solution);
    }
}

void routes_clear(struct routes *r)
{
    free(r->now.at);
    free(r->best.at);
    free(r->pivot);
}

bool sga_solve(const struct sys_system *system, const struct sga_options *given,
               struct points_shadow *shadow, struct sga_solution *solution, struct sga_error *err)
{
    struct routes r = { .final = -1, .seed = shadow->random };
    struct sga_conditions conditions = { 0 };
    struct sga_options own = *given, *options = &own;
    own.conditions = &conditions;
    bool ok = routes_explore(&r, system, options, shadow, solution, err);
    if (ok && r.final < 0 && r.failed) {      /* empty as far as known, but not known of every branch */
        *err = r.error;
        ok = false;
    } else if (ok && r.final < 0 && r.left) {
        ok = sga_fail(err, SGA_E_UNDECIDED, "the constraints have many branches, and the first %d of them are empty; "
                      "give trajectory.initial on the branch that is meant", SGA_MOST_ROUTES);
    } else if (ok && r.final < 0) {
        ok = special_solve(&r, system, options, shadow, solution, err);
    } else if (ok && !same_route(&r.now, &r.best)) {
        routes_restart(shadow, r.seed, solution);
        ok = state_solve(system, options, shadow, &r.best, solution, err);
    }
    if (!ok && !err->stage[0])
        memcpy(err->stage, "sga", 4);
    if (ok)
        solution->conditions = conditions;
    else
        sga_conditions_clear(&conditions);
    routes_clear(&r);
    return ok;
}
