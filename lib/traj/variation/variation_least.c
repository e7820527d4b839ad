/* See variation_least.h. */
#include "variation_least.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "least_tiers.h"
#include "mem.h"
#include "reduction.h"
#include "sizes.h"
#include "start_search.h"
#include "system.h"
#include "tape.h"
#include "variation.h"
#include "variation_along.h"

/* Variables and constraints up to which dense equations are solved. */
enum { MOST = 400 };
/* Newton's steps to the start, and the longest that still leads to the same one, beside 1 + |x|; trials with roundings, and what these are times more than what was seen. */
enum { STEPS = 3, TRIALS = 3 };
static const double NEAR = 1e-5, MORE = 8;
/* Outside of a bound by less, relative to 1 + |bound|, is on it. */
static const double ON = 1e-9;

struct looked {
    const struct variation_start *of;
    struct least_rows rows;
    struct least_tiers tiers;
    struct traj_request rq;
    double *asked, *guess;        /* n; directions x n */
    struct sga_arena mem;
};

/* Constraints, relations, and bounds that the start lies on (if bounded), each with its derivatives. */
static int list_rows(struct looked *q, bool bounded, struct variation_along *a, expr_id **to, struct sga_error *err)
{
    const struct variation_start *s = q->of;
    struct expr_store *st = s->sys->store;
    int n = s->sys->variables, each = 1 + s->directions, rows = 0;
    struct start_search search;
    expr_id *root = sga_zeros(&q->mem, (size_t)(s->sol->constraints + s->rq->relations + n + 1) * (size_t)each, sizeof *root);
    if (!start_search_init(&search, s->sys, s->sol, s->rq, err)) {
        start_search_clear(&search);
        return -1;
    }
    for (int i = 0; i < s->sol->constraints; i++)
        root[each * rows++] = s->sol->constraint[i].expr;
    for (int i = 0; i < s->rq->relations; i++)
        if (!expr_is_zero(st, search.relation[i]))
            root[each * rows++] = search.relation[i];
    for (int j = 0; j < n && bounded; j++)
        for (int side = 0; side < 2; side++) {
            double bound = (side ? s->rq->high : s->rq->low)[j];
            if (isfinite(bound) && fabs(s->x[j] - bound) <= ON * (1 + fabs(bound)))
                root[each * rows++] = expr_sub(st, st->symbol[s->sys->variable[j].symbol].node, expr_double(st, bound));
        }
    for (int i = 0; i < rows; i++)
        along_of(a, root[each * i], root + each * i + 1);
    start_search_clear(&search);
    *to = root;
    return each * rows;
}

static int *list_inputs(struct looked *q, const expr_id *slope)
{
    const struct variation_start *s = q->of;
    const struct sys_system *sys = s->sys;
    int n = sys->variables, all = n * (1 + s->directions), *input = sga_zeros(&q->mem, (size_t)(all + 1 + s->values), sizeof *input);
    for (int j = 0; j < n; j++)
        input[j] = sys->variable[j].symbol;
    for (int k = n; k < all; k++)
        input[k] = sys->store->node[slope[k - n]].a;
    input[all] = sys->time;
    for (int i = 0; i < s->values; i++)
        input[all + 1 + i] = s->symbol[i];
    return input;
}

static bool make_rows(struct looked *q, bool bounded, struct sga_error *err)
{
    const struct variation_start *s = q->of;
    struct variation_along a;
    expr_id *root;
    expr_id *slope = along_symbols(s->sys, s->by, s->directions);
    along_begin(&a, s->sys, s->by, s->directions, slope);
    int roots = expr_store_ok(s->sys->store) ? list_rows(q, bounded, &a, &root, err) : -1;
    bool ok = roots >= 0 && expr_store_ok(s->sys->store);
    q->rows = (struct least_rows){ .n = s->sys->variables, .q = s->directions, .more = s->values };
    ok = ok && least_rows_init(&q->rows, s->sys->store, root, roots, list_inputs(q, slope), err);
    for (int i = 0; i < s->values && ok; i++)
        q->rows.in[q->rows.all + 1 + i] = s->value[i];
    if (!expr_store_ok(s->sys->store))
        *err = *s->sys->store->error;
    along_end(&a);
    free(slope);
    return ok;
}

/* The derivatives of what was asked for, and this itself. */
static bool ask(struct looked *q)
{
    const struct variation_start *s = q->of;
    size_t n = (size_t)s->sys->variables, all = n * (size_t)s->directions;
    struct sga_error ignored = { 0 };
    q->asked = sga_zeros(&q->mem, n + 1, sizeof *q->asked);
    q->guess = sga_zeros(&q->mem, all + 1, sizeof *q->guess);
    memcpy(q->asked, s->rq_at->initial, n * sizeof *q->asked);
    q->rq = *s->rq_at;
    q->rq.relations = 0;
    q->rq.low = q->rq.high = NULL;
    struct num_tape *tape = num_tape_new(s->sys->store, s->guess, (int)all, s->symbol, s->values, &ignored);
    bool ok = tape && num_tape_eval(tape, s->value, q->guess);
    num_tape_free(tape);
    return ok;
}

/* y: the derivatives at x, asked being what it is. */
static bool slopes_at(struct looked *q, const double *x, double *y)
{
    size_t all = (size_t)(q->rows.n * q->rows.q);
    SGA_ARENA(mem);
    unsigned char *done = sga_zeros(&mem, (size_t)q->rows.q + 1, 1);
    memcpy(y, q->guess, all * sizeof *y);
    q->tiers.x = x;
    bool ok = least_tiers_move(&q->tiers, y, done) == q->rows.q;
    for (size_t i = 0; i < all && ok; i++)
        ok = isfinite(y[i]);
    return ok;
}

/* x comes nearer to where the conditions hold. False: they hold nowhere near. */
static bool step(struct looked *q, double *x)
{
    int n = q->rows.n;
    SGA_ARENA(mem);
    double *d = sga_zeros(&mem, (size_t)n + 1, sizeof *d);
    q->tiers.x = x;
    bool ok = least_tiers_newton(&q->tiers, d);
    for (int j = 0; j < n && ok; j++) {
        ok = fabs(d[j]) <= NEAR * (1 + fabs(x[j]));
        x[j] += d[j];
    }
    return ok;
}

static void widen(double *off, const double *a, const double *b, double times, size_t count)
{
    for (size_t i = 0; i < count; i++)
        off[i] = fmax(off[i], times * fabs(a[i] - b[i]));
}

/* Roundings of what moved, some up and some down. */
static void round_off(const struct looked *q, int trial, const double *x, double *to)
{
    for (int j = 0; j < q->rows.n; j++) {
        unsigned bits = (unsigned)(j + 1) * 2654435761u + (unsigned)(trial + 1) * 40503u;
        bool moved = x[j] != q->asked[j] || !q->rq.given[j];
        to[j] = moved ? x[j] * (1 + ((bits >> 13) & 1 ? 2 : -2) * DBL_EPSILON) : x[j];
    }
}

static bool solve(struct looked *q, double *slope, double *off)
{
    size_t n = (size_t)q->rows.n, all = n * (size_t)q->rows.q;
    SGA_ARENA(mem);
    double *x = sga_zeros(&mem, 2 * n + 1, sizeof *x), *beside = x + n, *other = sga_zeros(&mem, all + 1, sizeof *other);
    memcpy(x, q->of->x, n * sizeof *x);
    memset(off, 0, all * sizeof *off);
    if (!slopes_at(q, x, other))
        return false;
    for (int k = 0; k < STEPS; k++)
        if (!step(q, x) || (k == STEPS - 2 && !slopes_at(q, x, other)))
            return false;
    if (!slopes_at(q, x, slope))
        return false;
    widen(off, slope, other, 1, all);
    for (int k = 0; k < TRIALS; k++) {
        round_off(q, k, x, beside);
        if (!slopes_at(q, beside, other))
            return false;
        widen(off, slope, other, MORE, all);
    }
    for (size_t i = 0; i < all; i++)
        off[i] += MORE * DBL_EPSILON * fabs(slope[i]);
    return true;
}

bool variation_least(const struct variation_start *s, double *slope, double *off, struct sga_error *err)
{
    struct looked q = { .of = s };
    struct sizes sizes;
    bool found = false, bounds = s->rq->low != NULL;
    if (s->sys->variables + s->sol->constraints > MOST || !ask(&q)) {
        sga_arena_end(&q.mem);
        return false;
    }
    sizes_init(&sizes, s->sys_at, &q.rq);
    for (int bounded = 0; bounded <= bounds && !found && err->code == SGA_E_OK; bounded++) {
        if (make_rows(&q, bounded, err)) {
            q.tiers = (struct least_tiers){ &q.rows, s->sys_at, &sizes, &q.rq, s->rq_at->start, NULL, q.asked, s->x };
            found = solve(&q, slope, off);
        }
        least_rows_clear(&q.rows);
    }
    sizes_clear(&sizes);
    sga_arena_end(&q.mem);
    return found;
}
