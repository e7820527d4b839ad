/* Searches for other components, by the zeros of a run. */
#include "components.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "mem.h"
#include "oracle.h"
#include "poly.h"
#include "reduction.h"
#include "seeds.h"
#include "set_points.h"
#include "sides.h"
#include "system.h"
#include "warnings.h"

enum { STARTS = 3, SIDED_STARTS = 6, STUCK_STARTS = 16 };     /* of each set; where it has sides, each is to be met */
static const double BESIDE = 0.005;
enum { BESIDE_STARTS = 6 };                                    /* where constraints depend */
enum { OFF_ZEROS = 4, OFF_STARTS = 4 };                       /* of each set off what vanished on it */

static void *copy(const void *from, size_t count, size_t size)
{
    void *to = sga_malloc((count + 1) * size);
    if (count)
        memcpy(to, from, count * size);
    return to;
}

static struct component_run *keep_run(struct components *c, const struct sga_solution *sol, const struct points_oracle *oracle)
{
    SGA_RESERVE(c->run, c->run_cap, c->runs + 1);
    struct component_run *r = c->run + c->runs++;
    *r = (struct component_run){ .constraints = sol->constraints };
    r->constraint = sga_malloc((size_t)(2 * sol->constraints + 2) * sizeof *r->constraint);
    r->arose = r->constraint + sol->constraints;
    for (int i = 0; i < sol->constraints; i++) {
        const struct sga_constraint *k = sol->constraint + i;
        r->constraint[i] = k->expr;
        r->arose[i] = k->replaced ? k->replaced : k->expr;
    }
    r->arose[sol->constraints] = sol->stuck ? sol->stuck : sol->contradiction;
    r->zero = sga_malloc((size_t)(oracle->zeros + 1) * sizeof *r->zero);
    for (int i = 0; i < oracle->zeros; i++) {
        if (oracle->zero[i].constraints > sol->constraints)
            continue;
        r->zero[r->zeros].expr = oracle->zero[i].expr;
        r->zero[r->zeros].open = oracle->zero[i].decision.modular < POINTS_MODULAR;
        r->zero[r->zeros++].constraints = oracle->zero[i].constraints;
    }
    if (oracle->reals)
        points_point_copy(&r->point, oracle->real, POINTS_BITS);
    return r;
}

/* Of a ball at a point: 1 contains 0, 0 does not, -1 no value. */
static int vanishes(struct points_point *p, expr_id e)
{
    arb_srcptr v = num_ball_value(&p->ball, e);
    return !arb_is_finite(v) ? -1 : arb_contains_zero(v) != 0;
}

/* How many of the run's first constraints vanish at the point. */
static int reaches(const struct component_run *r, struct points_point *p)
{
    int n = 0;
    while (n < r->constraints && vanishes(p, r->constraint[n]) == 1)
        n++;
    assert(n <= r->constraints);
    return n;
}

/* Something that the run took for 0 on its first so many constraints, and that is not 0 at the point; or EXPR_UNDEF. */
static expr_id broken(const struct component_run *r, struct points_point *p, int constraints)
{
    for (int i = 0; i < r->zeros; i++)
        if (r->zero[i].constraints <= constraints && vanishes(p, r->zero[i].expr) == 0)
            return r->zero[i].expr;
    return EXPR_UNDEF;
}

/* What tells that p, a general point of the run's first n constraints, is on another component; or EXPR_UNDEF. */
static expr_id another(const struct component_run *r, struct points_point *p, int n)
{
    expr_id by = broken(r, p, n);
    assert(n <= r->constraints);
    if (!by && r->arose[n] && vanishes(p, r->arose[n]) == 1)
        by = r->arose[n];
    return by;
}

/* Whether some other run has been where p is, a general point of the first n constraints of run r. */
static bool known(const struct components *c, const struct component_run *r, struct points_point *p, int n, expr_id by)
{
    for (int k = 0; k < c->places; k++)
        if (c->place[k].set == (n ? r->constraint[n - 1] : EXPR_UNDEF) && c->place[k].by == by)
            return true;
    for (int k = 0; k < c->runs; k++) {
        const struct component_run *other = c->run + k;
        int same = 0;
        while (other != r && same < n && same < other->constraints && other->constraint[same] == r->constraint[same])
            same++;
        if (same == n ? !another(other, p, n) : other != r && other->constraints && reaches(other, p) >= (n < other->constraints ? n : other->constraints)
                                                  && !broken(other, p, n))
            return true;
    }
    return false;
}

static void keep_place(struct components *c, const struct points_space *space, const struct points_point *p, expr_id by)
{
    if (c->places >= SGA_MOST_COMPONENTS) {
        sga_limit_met(space->budget, SGA_LIMIT_COMPONENTS);
        return;
    }
    SGA_RESERVE(c->place, c->place_cap, c->places + 1);
    assert(p->x);
    c->place[c->places++] = (struct component_place){
        .x = copy(p->x, (size_t)space->variables, sizeof *p->x), .t = p->t,
        .parameter = copy(p->parameter, (size_t)space->parameters, sizeof *p->parameter),
        .set = space->constraints ? space->constraint[space->constraints - 1] : EXPR_UNDEF, .by = by };
}

/* q becomes a point a little beside p on the space's constraints, the run's first n: what tells that it is on another component, or EXPR_UNDEF. p
 * may be a special point (a kink, a crossing, one on which constraints of another run hold too). */
static expr_id another_beside(const struct component_run *r, const struct points_space *space, const struct points_point *p, int n,
                              uint64_t *random, struct points_point *q)
{
    struct points_space beside = *space;
    beside.near = p->x;
    beside.near_time = p->t;
    if (points_find(&beside, BESIDE, random, POINTS_BITS, q) != POINTS_OK)
        return EXPR_UNDEF;
    num_ball_extend(&q->ball);
    return another(r, q, n);
}

/* Keeps such a point as a place. Whether it is on another component. */
static bool keep_beside(struct components *c, const struct component_run *r, const struct points_space *space,
                        const struct points_point *p, int n, uint64_t *random)
{
    SGA_ENDS(points_point_clear) struct points_point q;
    expr_id by = another_beside(r, space, p, n, random, &q);
    if (by && !known(c, r, &q, n, by))
        keep_place(c, space, &q, by);
    return by != EXPR_UNDEF;
}

/* p, where the differentials of the run's first n constraints depend on each other: it may be on a component of the n - 1 before on which
 * the last one holds by itself. */
static void depend(struct components *c, const struct component_run *r, struct points_space *space, int n, const struct points_point *p,
                   uint64_t *random)
{
    const double *near = space->near;
    bool there = false;
    space->constraints = n - 1;
    space->before = NULL;
    for (int k = 0; k < BESIDE_STARTS && !there; k++)        /* other components may go through p, or near it */
        there = keep_beside(c, r, space, p, n - 1, random);
    space->constraints = n;
    space->near = near;
}

/* What a search goes along with: points from so many starts, each met by the next set too. */
struct walk {
    struct points_point at[STUCK_STARTS];
    double *opposite;        /* by variable: to the point found last */
    int starts;
    bool anew;               /* each set from starts of its own */
    bool sided;              /* every other start opposite to the point before: its sides are to be met */
    uint64_t random;
};

static enum points_status step_to(struct walk *w, struct points_space *space, int k, struct points_point *p)
{
    struct points_point *from = w->at + k;
    bool walks = !w->anew && from->x;
    space->before = walks ? from : NULL;
    space->near = w->sided && k % 2 ? w->opposite : NULL;
    space->by_shape = k % 4 == 0;
    return points_find(space, space->near ? 0.3 : 1 + k / 2, &w->random, POINTS_BITS, p);
}

/* p, a point of the run's first n constraints: where something tells that it is on another component, a place beside it is kept. */
static void arrive(struct components *c, const struct component_run *r, struct points_space *space, int n, struct points_point *p, uint64_t *random)
{
    num_ball_extend(&p->ball);
    expr_id by = another(r, p, n);
    if (by && !known(c, r, p, n, by)) {
        space->near = NULL;
        space->before = NULL;
        keep_beside(c, r, space, p, n, random);
    }
}

/* Parts of the first n constraints that are 0 at the run's point, and zeros of the run that no algebra proves: each once. Returns how many. */
static int vanishing(const struct component_run *r, struct points_space *space, int n, expr_id *list, int most)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    int count = 0;
    expr_cone_init(&cone);
    expr_cone_of(space->st, &cone, r->constraint, n);
    num_ball_extend((struct num_ball *)&r->point.ball);
    for (int k = 0; k < cone.count && count < most; k++) {
        expr_id e = cone.list[k];
        bool constraint = expr_is_const(space->st, e);
        for (int i = 0; i < n; i++)
            constraint |= e == r->constraint[i];
        if (!constraint && vanishes((struct points_point *)&r->point, e) == 1)
            list[count++] = e;
    }
    for (int i = 0; i < r->zeros && count < most; i++)
        if (r->zero[i].open && r->zero[i].constraints == n)
            list[count++] = r->zero[i].expr;
    return count;
}

/* Points where something that is 0 at those known is not: those of f = 0 off z = 0, f the last constraint, are zeros of f/z, and as a rule
 * nothing else is, so that Newton's method does not come to the component that is known. */
static void search_off(struct components *c, const struct component_run *r, struct points_space *space, int n, struct walk *w)
{
    struct expr_store *st = (struct expr_store *)space->st;
    expr_id zero[OFF_ZEROS];
    SGA_FREED expr_id *off = sga_malloc(((size_t)n + 1) * sizeof *off);
    int zeros = n && r->point.x ? vanishing(r, space, n, zero, OFF_ZEROS) : 0;
    if (n)
        memcpy(off, r->constraint, (size_t)n * sizeof *off);
    for (int i = 0; i < zeros; i++) {
        off[n - 1] = expr_div(st, r->constraint[n - 1], zero[i]);
        for (int k = 0; k < OFF_STARTS && expr_store_ok(st) && sga_budget_ok(space->budget, NULL); k++) {
            SGA_ENDS(points_point_clear) struct points_point p;
            space->constraint = off;
            space->by_shape = false;
            space->near = k % 2 ? r->point.x : NULL;      /* beside what is known, too */
            space->near_time = r->point.t;
            bool found = points_find(space, space->near ? 0.5 * k : 1 + k, &w->random, POINTS_BITS, &p) == POINTS_OK && p.certified;
            space->constraint = r->constraint;
            space->near = NULL;
            if (found)
                arrive(c, r, space, n, &p, &w->random);
        }
    }
}

/* Points of the parts that algebra splits the set into: those of a part on which the next constraint holds by itself are as a rule few among those
 * that steps lead to. */
static void search_chains(struct components *c, const struct component_run *r, struct points_space *space, int n, struct walk *w)
{
    struct expr_store *st = (struct expr_store *)space->st;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, space->budget);
    struct poly_chains chains;
    if (n < 2 || !poly_chains_of(st, r->constraint, n, &limits, &chains))
        return;
    for (int k = 0; k < chains.chains && chains.chains > 1; k++) {
        SGA_ENDS(points_point_clear) struct points_point p;
        space->constraint = chains.chain[k].poly;
        space->constraints = chains.chain[k].count;
        space->near = NULL;
        space->by_shape = true;
        enum points_status status = points_find(space, 1, &w->random, POINTS_BITS, &p);
        space->constraint = r->constraint;
        space->constraints = n;
        space->by_shape = false;
        if (status == POINTS_OK) {
            space->near = p.x;
            space->near_time = p.t;
            SGA_ENDS(points_point_clear) struct points_point q;
            if (points_find(space, 0, &w->random, POINTS_BITS, &q) == POINTS_OK && q.certified)
                arrive(c, r, space, n, &q, &w->random);
            space->near = NULL;
        }
    }
    poly_chains_clear(&chains);
}

/* Whether something was found to be 0 on the run's first n constraints at points only. */
static bool any_open(const struct component_run *r, int n)
{
    bool any = false;
    for (int i = 0; i < r->zeros; i++)
        any |= r->zero[i].open && r->zero[i].constraints == n;
    return any;
}

/* One set, the run's first n constraints. */
static void search(struct components *c, const struct component_run *r, struct points_space *space, int n, struct walk *w)
{
    space->constraint = r->constraint;
    space->constraints = n;
    for (int k = 0; k < w->starts && sga_budget_ok(space->budget, NULL); k++) {
        struct points_point p;
        enum points_status status = step_to(w, space, k, &p);
        if (status != POINTS_OK || (n && !p.certified)) {
            if (status == POINTS_IRREGULAR && n)
                depend(c, r, space, n, &p, &w->random);
            points_point_clear(&p);
            continue;
        }
        for (int i = 0; i < space->variables; i++)
            w->opposite[i] = -p.x[i];
        arrive(c, r, space, n, &p, &w->random);
        points_point_clear(w->at + k);
        w->at[k] = p;
    }
    space->near = NULL;
    space->before = NULL;
    if (any_open(r, n))
        search_off(c, r, space, n, w);
    search_chains(c, r, space, n, w);
}

/* Whether the functions are made with some that are one analytic function on each side of a surface. */
static bool has_sides(const struct expr_store *st, const expr_id *e, int count)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool has = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, e, count);
    for (int k = 0; k < cone.count; k++)
        has |= points_switches(expr_op_of(st, cone.list[k]));
    return has;
}

/* Points of a run among which something vanishes at some and not at others: each is a place of its own. */
static void keep_split(struct components *c, struct points_space *space, const struct component_run *r, const struct points_oracle *oracle)
{
    space->constraint = r->constraint;
    space->constraints = r->constraints;
    for (int k = 0; k < oracle->reals && oracle->reals > 1; k++)
        keep_place(c, space, oracle->real + k, EXPR_UNDEF);
}

/* Where the points of a search lie: to be ended by end_space. */
static void begin_space(struct set_points *on, const struct sys_system *system, const struct reduction_options *options, const struct sga_solution *sol)
{
    expr_id *defined;
    set_points_init(on, system, NULL, 0, 0, 0);
    on->space.parameter_near = options->parameter_near;
    on->space.near_time = options->near_time;
    on->space.scale = sol->scale;
    on->space.time_unit = sol->time_unit;
    on->space.starts = 2;
    on->space.budget = options->budget;
    on->space.defineds = sys_expressions(system, &defined);
    on->space.defined = defined;
}

static void end_space(struct set_points *on)
{
    free((void *)on->space.defined);
    set_points_clear(on);
}

void components_note(struct components *c, const struct sys_system *system, const struct reduction_options *options,
                     const struct sga_solution *sol, const struct points_oracle *oracle, int place, int final, bool split)
{
    struct component_run *r = keep_run(c, sol, oracle);
    int n = system->variables;
    assert(place < c->places && final >= -1 && final <= n);
    r->place = place;
    r->final = final;
    struct set_points on;
    begin_space(&on, system, options, sol);
    bool sided = has_sides(system->store, on.space.defined, on.space.defineds);
    if (sol->one_piece < sol->constraints && sol->constraints > SGA_MOST_COMPONENT_ROWS)
        sga_limit_met(options->budget, SGA_LIMIT_COMPONENT_ROWS);
    if (split && place < 0)
        keep_split(c, &on.space, r, oracle);
    bool stuck = final <= 0;      /* points, or none: what holds more may lie elsewhere */
    struct walk w = { .starts = stuck ? STUCK_STARTS : sided ? SIDED_STARTS : STARTS, .anew = sided || stuck, .sided = sided,
                      .random = SGA_SEED_COMPONENTS };
    w.opposite = sga_calloc((size_t)n + 1, sizeof *w.opposite);
    /* where something has sides, so has every set that it is asked on */
    for (int k = sided ? 0 : sol->one_piece + 1; k <= sol->constraints && sol->constraints <= SGA_MOST_COMPONENT_ROWS; k++)
        search(c, r, &on.space, k, &w);
    for (int k = 0; k < w.starts; k++)
        points_point_clear(w.at + k);
    free(w.opposite);
    end_space(&on);
}

bool components_apart(struct components *c, const struct sys_system *system, const struct reduction_options *options,
                      const struct sga_solution *sol, int of, int k)
{
    assert(of >= 0 && of < c->runs && k >= 0 && k < c->runs);
    struct component_run *r = c->run + of;
    struct points_point *p = &c->run[k].point;
    if (!p->x)
        return false;
    num_ball_extend(&p->ball);
    int n = reaches(r, p);
    if (another(r, p, n))
        return true;
    if (!n || !points_on_sides(system->store, &p->ball, sol->side, sol->sides))        /* beyond them strata of kind side speak */
        return false;
    struct set_points on;
    SGA_ENDS(points_point_clear) struct points_point q;
    begin_space(&on, system, options, sol);
    uint64_t random = SGA_SEED_BESIDE;
    on.space.constraint = r->constraint;
    on.space.constraints = n;
    bool apart = another_beside(r, &on.space, p, n, &random, &q) && q.certified;
    end_space(&on);
    return apart;
}

void components_clear(struct components *c)
{
    for (int k = 0; k < c->runs; k++) {
        free(c->run[k].constraint);
        free(c->run[k].zero);
        points_point_clear(&c->run[k].point);
    }
    for (int k = 0; k < c->places; k++) {
        free(c->place[k].x);
        free(c->place[k].parameter);
    }
    free(c->run);
    free(c->place);
}
