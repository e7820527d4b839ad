/* The search for a start: see start_search.h. */
#include "start_search.h"

#include <assert.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "consistent.h"
#include "error.h"
#include "field.h"
#include "kinds.h"
#include "manifold.h"
#include "mem.h"
#include "reduction.h"
#include "sizes.h"
#include "system.h"
#include "tape.h"
#include "tiers.h"

/* Starts beside the guess; fewer where each is dear; on a bound, and on two. */
enum { STARTS = 32, FEW = 8, AT_BOUND = 6, AT_TWO = 3, SMALL = 60, PROJECTED = 80 };
/* Outside of a bound by less, relative to 1 + |bound|, is on it; and distances that differ by less are the same. */
static const double ON = 1e-9, ALIKE = 1e-7;

/* Expressions that the gauge enters at the start. */
static bool put_in_rates(struct start_search *s, int i, expr_id *map, struct sga_error *err)
{
    const struct traj_request *rq = s->rq;
    struct expr_store *st = s->sys->store;
    struct expr_cone cone;
    const char *place = rq->relation[i].place;
    int n = s->sys->variables, open = -1;
    assert(s->sol->field);
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &rq->relation[i].value, 1);
    for (int k = 0; k < cone.count && open < 0; k++)
        for (int j = 0; j < n && open < 0 && rq->rate_symbol && expr_op_of(st, cone.list[k]) == EXPR_SYM; j++) {
            if (rq->rate_symbol[j] != st->node[cone.list[k]].a)
                continue;
            map[rq->rate_symbol[j]] = s->sol->field[j];
            bool free = s->sol->free_columns && !s->sol->gauge;
            for (int q = 0; q < s->sol->free_columns && s->sol->gauge; q++)
                free |= !expr_is_zero(st, s->sol->gauge[(size_t)q * (size_t)n + (size_t)j]);
            for (int q = 0; q < rq->rates; q++)
                if (rq->rate[q].variable == j) {
                    map[rq->rate_symbol[j]] = rq->rate[q].rate;
                    free = false;
                }
            open = free ? j : -1;
        }
    expr_cone_clear(&cone);
    if (open >= 0 && !s->sol->gauge)
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, place, "the gauge fields are too large to be written, so that it is not known whether the derivative of %.100s is a choice of the gauge; fix it in "
                           "trajectory.gauge.rates, or leave it out of the start's equations", st->symbol[s->sys->variable[open].symbol].name);
    if (open >= 0)
        return sga_fail_at(err, SGA_E_GAUGE, place, "the derivative of %.100s is not determined by the equations at the start: it is a choice of the gauge; fix it in trajectory.gauge.rates, "
                           "or leave it out of the start's equations", st->symbol[s->sys->variable[open].symbol].name);
    s->relation[i] = rq->relation[i].value;
    expr_substitute(st, s->relation + i, 1, map);
    if (expr_is_const(st, s->relation[i]) && !expr_is_zero(st, s->relation[i]))
        return sga_fail_at(err, SGA_E_INITIAL, place, "\"%.200s\" holds at no start: with the derivatives put in, left and right differ by a constant", rq->relation[i].text);
    return s->relation[i] || sga_fail_at(err, SGA_E_EXPR_UNDEFINED, place, "\"%.200s\" has no value at any start", rq->relation[i].text);
}

bool start_search_init(struct start_search *s, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err)
{
    *s = (struct start_search){ .sys = sys, .sol = sol, .rq = rq, .plain = *rq };
    s->plain.relation = NULL;
    s->plain.relations = 0;
    s->plain.low = s->plain.high = NULL;
    s->relation = sga_zeros(&s->mem, (size_t)rq->relations + 1, sizeof *s->relation);
    s->by_name = sga_zeros(&s->mem, (size_t)sys->variables + 1, sizeof *s->by_name);
    sys_by_name(sys, s->by_name);
    expr_id *map = sga_zeros(&s->mem, (size_t)sys->store->symbols + 1, sizeof *map);
    for (int i = 0; i < rq->relations; i++)
        if (!put_in_rates(s, i, map, err))
            return false;
    return expr_store_ok(sys->store) || (*err = *sys->store->error, false);
}

void start_search_clear(struct start_search *s)
{
    sga_arena_end(&s->mem);
}

void start_with(struct start_search *s, const unsigned char *use, const signed char *at, struct sga_solution *with)
{
    const struct sga_solution *sol = s->sol;
    struct expr_store *st = s->sys->store;
    int n = s->sys->variables, c = sol->constraints;
    struct sga_constraint *all = sga_zeros(&s->mem, (size_t)(c + s->rq->relations + n) + 1, sizeof *all);
    if (c)
        memcpy(all, sol->constraint, (size_t)c * sizeof *all);
    struct sga_constraint one = { .generation = sol->generations > 0 ? sol->generations : 1, .restriction = -1, .source = -1 };
    for (int i = 0; i < s->rq->relations; i++)
        if ((!use || use[i]) && !expr_is_zero(st, s->relation[i])) {
            one.expr = s->relation[i];
            all[c++] = one;
        }
    for (int j = 0; j < n && at; j++)
        if (at[j]) {
            one.expr = expr_sub(st, st->symbol[s->sys->variable[j].symbol].node, expr_double(st, at[j] < 0 ? s->rq->low[j] : s->rq->high[j]));
            all[c++] = one;
        }
    *with = *sol;
    with->constraint = all;
    with->constraints = c;
}

double start_outside(const struct traj_request *rq, const double *x, int j)
{
    if (!rq->low)
        return 0;
    double below = rq->low[j] - x[j], above = x[j] - rq->high[j];
    if (below > ON * (1 + fabs(rq->low[j])))
        return below;
    return above > ON * (1 + fabs(rq->high[j])) ? above : 0;
}

static double outside_of(const struct start_search *s, const double *x)
{
    double sum = 0;
    for (int j = 0; j < s->sys->variables; j++)
        sum += start_outside(s->rq, x, j);
    return sum;
}

bool start_residuals(const struct start_search *s, const double *x, double *residual)
{
    struct sga_error ignored = { 0 };
    int n = s->sys->variables, *inputs = field_inputs(s->sys);
    double *in = sga_calloc((size_t)n + 1, sizeof *in);
    sga_copy(in, x, n);
    in[n] = s->rq->start;
    struct num_tape *tape = s->rq->relations ? num_tape_new(s->sys->store, s->relation, s->rq->relations, inputs, n + 1, &ignored) : NULL;
    bool ok = !s->rq->relations || (tape && num_tape_eval(tape, in, residual));
    num_tape_free(tape);
    free(in);
    free(inputs);
    return ok;
}

/* One set of constraints, made ready. */
struct place {
    struct start_search *s;
    struct flow flow;
    struct sga_solution with;
    struct traj_request rq;
    bool ok;
};

static void place_init(struct place *p, struct start_search *s, const unsigned char *use, bool freed, const signed char *at)
{
    struct sga_error ignored = { 0 };
    p->s = s;
    p->rq = s->plain;
    p->rq.on = NULL;
    p->rq.no_motion = true;
    if (freed)
        p->rq.held = NULL;
    start_with(s, use, at, &p->with);
    p->ok = expr_store_ok(s->sys->store) && flow_init(&p->flow, s->sys, &p->with, &p->rq, &ignored);
}

static void place_clear(struct place *p)
{
    flow_clear(&p->flow);
}

static void measure(struct place *p, struct start_found *f)
{
    int n = p->s->sys->variables;
    double *scale = sga_calloc((size_t)n + 1, sizeof *scale), sum = 0;
    for (int j = 0; j < n; j++) {
        scale[j] = sizes_move(p->flow.sizes, j, p->rq.initial[j]);
        sum += pow((f->x[j] - p->rq.initial[j]) / scale[j], 2);
    }
    f->moved = consistent_moved(p->flow.manifold, &p->rq, scale, f->x);
    f->far = sqrt(sum);
    free(scale);
}

/* From a guess of its own (NULL: the request's) to the set, then as near to the request's guess as descent comes within the bounds. */
static bool try_from(struct place *p, const double *guess, struct start_found *f)
{
    size_t n = (size_t)p->s->sys->variables;
    struct sga_error ignored = { 0 };
    if (!p->ok || !sga_budget_ok(p->rq.budget, NULL))
        return false;
    f->x = sga_zeros(&p->s->mem, n + 1, sizeof *f->x);
    memcpy(f->x, guess ? guess : p->rq.initial, n * sizeof *f->x);
    if (guess || p->s->few ? !manifold_project(p->flow.manifold, p->rq.start, f->x, NULL, p->rq.held, PROJECTED, NULL, NULL, NULL)
                           : !flow_start(&p->flow, p->s->sys, &p->with, &p->rq, f->x, &f->moved, &ignored))
        return false;
    if (guess && !p->s->few && p->with.constraints && (int)n <= SMALL) {
        double *nearer = sga_take(&p->s->mem, (n + 1) * sizeof *nearer), far[TIERS], residual;
        memcpy(nearer, f->x, n * sizeof *nearer);
        if (tiers_descend(p->flow.manifold, p->s->sys, p->flow.sizes, &p->rq, nearer, far)
            && manifold_project(p->flow.manifold, p->rq.start, nearer, NULL, p->rq.held, 5, NULL, &residual, NULL) && outside_of(p->s, nearer) <= outside_of(p->s, f->x))
            f->x = nearer;
    }
    measure(p, f);
    return true;
}

/* Whether a is nearer than b; of those alike the one with the larger value of the first variable by name that differs. */
static bool nearer(const struct start_search *s, const struct start_found *a, const struct start_found *b)
{
    if (!b->x)
        return true;
    double size = ALIKE * (1 + b->moved), whole = ALIKE * (1 + b->far);
    if (fabs(a->moved - b->moved) > size)
        return a->moved < b->moved;
    if (fabs(a->far - b->far) > whole)
        return a->far < b->far;
    for (int k = 0; k < s->sys->variables; k++) {
        double x = a->x[s->by_name[k]], y = b->x[s->by_name[k]];
        if (fabs(x - y) > ALIKE * (1 + fabs(y)))
            return x > y;
    }
    return false;
}

static void keep(const struct start_search *s, const struct start_found *f, struct start_found *found, struct start_found *outside)
{
    double out = outside_of(s, f->x);
    if (out == 0 && nearer(s, f, found))
        *found = *f;
    double before = outside->x ? outside_of(s, outside->x) : INFINITY;
    if (out > 0 && (out < before * (1 - ALIKE) || (out <= before && nearer(s, f, outside))))
        *outside = *f;
}

/* A number from -1 to 1 that a name and a count have. */
static double drawn(const char *name, int k)
{
    uint64_t h = 14695981039346656037u;
    for (; *name; name++)
        h = (h ^ (unsigned char)*name) * 1099511628211u;
    h += 0x9e3779b97f4a7c15u * (uint64_t)(k + 1);
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
    h ^= h >> 31;
    return (double)(h >> 11) * 0x1p-52 - 1;
}

/* The k-th start: the guess mirrored at the bounds that it passes, then clipped by them, then drawn ones, wider and wider. */
static void other_start(const struct place *p, int k, const double *beside, double *x)
{
    static const double wide[] = { 1, 0.2, 3, 10 };
    const struct start_search *s = p->s;
    const struct traj_request *rq = s->rq;
    for (int j = 0; j < s->sys->variables; j++) {
        double low = rq->low ? rq->low[j] : -INFINITY, high = rq->high ? rq->high[j] : INFINITY, g = beside && k < 2 ? beside[j] : rq->initial[j];
        double u = drawn(s->sys->store->symbol[s->sys->variable[j].symbol].name, k), w = wide[k % 4] * sizes_move(p->flow.sizes, j, g);
        x[j] = k < 2 ? g : g + u * w;
        if (k == 0 && x[j] < low)
            x[j] = 2 * low - x[j];
        else if (k == 0 && x[j] > high)
            x[j] = 2 * high - x[j];
        if (k >= 2 && isfinite(low) && isfinite(high))
            x[j] = low + (high - low) * (1 + u) / 2;
        else if (x[j] < low)
            x[j] = k < 2 ? low : low + fabs(u) * w;
        else if (x[j] > high)
            x[j] = k < 2 ? high : high - fabs(u) * w;
        x[j] = fmin(fmax(x[j], low), high);
        if (p->rq.held && p->rq.held[j])
            x[j] = rq->initial[j];
    }
}

/* Starts with variables at the bounds of `at` join the others: from so many places, and, where searched, the nearest that a whole search from the guess finds,
 * which is returned; x NULL: there is none. */
static struct start_found try_at(struct start_search *s, const unsigned char *use, bool freed, const signed char *at, bool searched, int places, struct start_found *found,
                                 struct start_found *outside)
{
    struct place p;
    struct start_found nearest = { 0 };
    SGA_FREED double *x = sga_calloc((size_t)s->sys->variables + 1, sizeof *x);
    place_init(&p, s, use, freed, at);
    if (searched && try_from(&p, NULL, &nearest))
        keep(s, &nearest, found, outside);
    else
        nearest.x = NULL;
    for (int k = 0; k < places && p.ok && sga_budget_ok(s->rq->budget, NULL); k++) {
        struct start_found f = { 0 };
        other_start(&p, k, nearest.x, x);
        if (try_from(&p, x, &f))
            keep(s, &f, found, outside);
    }
    place_clear(&p);
    return nearest;
}

/* Bounds that the nearest start passes hold as equations, one more each time. */
static void close_in(struct start_search *s, const unsigned char *use, bool freed, signed char *at, struct start_found now, struct start_found *found, struct start_found *outside)
{
    int n = s->sys->variables;
    for (int k = 0; k < n && k < STARTS && now.x && outside_of(s, now.x) > 0; k++) {
        int worst = -1;
        for (int i = 0; i < n; i++) {
            int j = s->by_name[i];
            if (!at[j] && start_outside(s->rq, now.x, j) > 0 && (worst < 0 || start_outside(s->rq, now.x, j) > start_outside(s->rq, now.x, worst)))
                worst = j;
        }
        if (worst < 0)
            return;
        at[worst] = now.x[worst] < s->rq->low[worst] ? -1 : 1;
        now = try_at(s, use, freed, at, true, 0, found, outside);
    }
}

/* The bounds that there are, by name: places 2 j of low ones and 2 j + 1 of high ones. Returns how many, at the most STARTS. */
static int list_bounds(const struct start_search *s, bool freed, int *bound)
{
    int count = 0;
    for (int i = 0; i < 2 * s->sys->variables && s->rq->low && count < STARTS; i++) {
        int j = s->by_name[i / 2];
        if (isfinite(i % 2 ? s->rq->high[j] : s->rq->low[j]) && !(s->plain.held && s->plain.held[j] && !freed))
            bound[count++] = 2 * j + i % 2;
    }
    return count;
}

static void set_at(signed char *at, size_t n, const int *bound, int count)
{
    memset(at, 0, n);
    for (int k = 0; k < count; k++)
        at[bound[k] / 2] = bound[k] % 2 ? 1 : -1;
}

/* On the bounds: on those that the nearest start of all passes; and on each and on each two, as the nearest start within may lie on some that it does not pass. */
static void at_bounds(struct start_search *s, const unsigned char *use, bool freed, const struct start_found *first, struct start_found *found, struct start_found *outside)
{
    size_t n = (size_t)s->sys->variables;
    signed char *at = sga_zeros(&s->mem, n + 1, 1);
    int bound[STARTS], bounds = s->few || n > SMALL ? 0 : list_bounds(s, freed, bound), pairs = 0;
    if (first->x)
        close_in(s, use, freed, at, *first, found, outside);
    for (int i = 0; i < bounds && sga_budget_ok(s->rq->budget, NULL); i++) {
        set_at(at, n, bound + i, 1);
        try_at(s, use, freed, at, true, AT_BOUND, found, outside);
    }
    for (int i = 0; i < bounds; i++)
        for (int k = 0; k < i && pairs < STARTS && sga_budget_ok(s->rq->budget, NULL); k++)
            if (bound[i] / 2 != bound[k] / 2) {
                set_at(at, n, (int[]){ bound[i], bound[k] }, 2);
                try_at(s, use, freed, at, false, AT_TWO, found, outside);
                pairs++;
            }
}

bool start_search_find(struct start_search *s, const unsigned char *use, bool freed, struct start_found *found, struct start_found *outside)
{
    struct place p;
    struct start_found first = { 0 };
    int n = s->sys->variables;
    *found = *outside = (struct start_found){ 0 };
    place_init(&p, s, use, freed, NULL);
    if (!try_from(&p, NULL, &first))
        first.x = NULL;
    if (first.x)
        keep(s, &first, found, outside);
    if (!found->x && p.ok) {
        double *x = sga_calloc((size_t)n + 1, sizeof *x);
        int most = n <= SMALL && !s->few ? STARTS : FEW;
        for (int k = 0; k < most && sga_budget_ok(s->rq->budget, NULL); k++) {
            struct start_found f = { 0 };
            other_start(&p, k, first.x, x);
            if (try_from(&p, x, &f))
                keep(s, &f, found, outside);
        }
        free(x);
        at_bounds(s, use, freed, &first, found, outside);
    }
    place_clear(&p);
    assert((!found->x || outside_of(s, found->x) == 0) && (!outside->x || outside_of(s, outside->x) > 0));
    return found->x != NULL;
}
