/* Charts of a motion: see charts.h. */
#include "charts.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "field.h"
#include "lin_sparse.h"
#include "manifold.h"
#include "mem.h"
#include "oracle.h"
#include "print.h"
#include "reduction.h"
#include "seeds.h"
#include "sizes.h"
#include "switches.h"
#include "system.h"
#include "tape.h"
#include "warnings.h"

/* A pivot so much smaller than it was on the way is a reason to look at the other charts, once more when it has changed by the second or
 * after so many steps; one that loses fewer digits by the third is taken. */
static const double SHRUNK = 0.5, CHANGED = 1.5, BETTER = 4, AS_GOOD = 2;
enum { LOOK_AGAIN = 8 };
/* A pivot that comes to 0 is followed to so small a part of what it is. */
static const double AT_ZERO = 1e-7, FIRST = 1e-6;     /* the second of the time passed: a first step */
/* With a pivot so small, or so many digits lost, other pivots are looked for. */
static const double SMALL = 0.03, POOR = 1e-10;
/* Nothing but a pivot so small as this where the motion ended is a reason to look for others. */
static const double AT_END = 0.1;
/* What the points and the fields of two charts may differ by where a motion goes over, where the one before has lost a digit or two. */
static const double SAME_SET = 1e-8, SAME_FIELD = 1e-6;
/* Where the field of the one before has lost so many digits, the two are compared as far as it has some; with none left, a field that the equations determine is the same on the same set. */
static const double LOST_SURE = 100, NONE_LEFT = 1e-3;

/* What a chart holds: the members of a flow that its reduction made. */
struct chart {
    struct sga_solution *solution;     /* where it stays: what was set up for it knows it; NULL in the first */
    struct points_oracle oracle;
    struct flow own;                   /* what else was set up for it; empty in the first */
    struct manifold *manifold;         /* from here on: while it is not in use */
    struct field *field;
    struct series *series;
    struct given *given;
    double *noise;
    double *size;                      /* by pivot: the largest it was */
    struct charts_exact exact;
};

static void take_out(struct flow *f, struct chart *c)
{
    c->manifold = f->manifold;
    c->field = f->field;
    c->series = f->series;
    c->given = f->given;
    c->noise = f->noise;
}

static void put_in(struct flow *f, const struct chart *c)
{
    f->manifold = c->manifold;
    f->field = c->field;
    f->series = c->series;
    f->given = c->given;
    f->noise = c->noise;
}

static void go_over(struct flow *f, int to)
{
    struct charts *q = f->charts;
    if (q->at == to)
        return;
    take_out(f, q->chart + q->at);
    put_in(f, q->chart + to);
    q->at = to;
    assert(to >= 0 && to < q->count && f->field->manifold == f->manifold);
    if (f->field->switches->count)
        flow_hold(f, q->side);
}

/* The pivot that has shrunk most at (t, x), and to which part of its size. INFINITY where there are none. */
static double smallest(struct charts *q, int k, const struct field *f, double t, const double *x, int *pivot)
{
    double least = INFINITY, *size = q->chart[k].size, *p = q->value + f->n;
    *pivot = -1;
    sga_copy(q->in, x, f->n);
    q->in[f->n] = t;
    num_tape_eval(f->direct, q->in, q->value);
    for (int i = f->sides; i < f->deep; i++) {
        double part = isfinite(p[i]) ? fabs(p[i]) / fmax(size[i], fabs(p[i])) : 0;
        if (size[i] == 0 && p[i] == 0)
            part = 0;
        if (!(part >= least)) {
            least = part;
            *pivot = i;
        }
    }
    return least;
}

/* The largest variable in its unit, 1 at the least. */
static double largest(const struct flow *f, const double *x)
{
    double most = 1;
    for (int j = 0; j < f->n; j++)
        most = fmax(most, fabs(x[j]) / f->manifold->unit[j]);
    return most;
}

static const struct field *field_of(const struct flow *f, int k)
{
    return k == f->charts->at ? f->field : f->charts->chart[k].field;
}

/* Work space for all, and the sizes of chart k's pivots: where it began. */
static void set_up(struct flow *f, int k)
{
    struct charts *q = f->charts;
    int most = 0;
    for (int i = 0; i < q->count; i++)
        most = num_tape_roots(field_of(f, i)->direct) > most ? num_tape_roots(field_of(f, i)->direct) : most;
    q->value = sga_realloc(q->value, ((size_t)most + 1) * sizeof *q->value);
    const struct field *a = field_of(f, k);
    q->chart[k].size = sga_calloc((size_t)a->pivots + 1, sizeof *q->chart[k].size);
    sga_copy(q->chart[k].size, a->pivot_start, a->pivots);
}

/* Chart k, which is not in use, has the set and the field of the one that is at (t, x), a point of the motion. lost: digits of the latter (charts_noise). */
static bool same_there(struct flow *f, int k, double lost, double t, const double *x)
{
    int n = f->n, from = f->charts->at;
    double *y = sga_malloc(3 * ((size_t)n + 1) * sizeof *y), *v = y + n + 1, *w = v + n + 1, moved = 0, left = 0;
    memcpy(y, x, (size_t)n * sizeof *y);
    bool known = field_eval(f->field, t, x, v) && lost < NONE_LEFT, ok = known || !f->charts->first->free_columns;
    double same = SAME_FIELD + LOST_SURE * lost;
    field_forget_trial(f->field);
    go_over(f, k);
    bool on = !f->manifold->c || manifold_project(f->manifold, t, y, NULL, NULL, 8, &moved, &left, NULL);      /* roundings of its rows may be larger than those it looks for */
    ok = ok && (on || (left >= 0 && left <= SAME_SET)) && moved <= SAME_SET * largest(f, y);
    field_load(f->field, t, y);
    ok = ok && num_tape_eval(f->field->direct, f->field->in, f->field->direct_out);
    field_take_sides(f->field, t, y);
    ok = ok && field_eval(f->field, t, y, w);
    double size = ok && known ? fmax(field_size(f->field, v), field_size(f->field, w)) : 0;
    for (int j = 0; j < n && ok && known; j++)
        ok = fabs(v[j] - w[j]) <= same * size * (f->field->unit ? f->field->unit[j] : 1);
    go_over(f, from);
    free(y);
    return ok;
}

static void add_ahead(struct flow *f, int pivot, double t, const double *x);

bool charts_choose(struct flow *f, double t, double *x)
{
    struct charts *q = f->charts;
    int pivot, ignored, best = -1;
    if (!q || q->stop)
        return false;
    double now = smallest(q, q->at, f->field, t, x, &pivot), least = 0;
    for (int i = 0; i < f->field->pivots; i++)
        if (isfinite(q->value[f->n + i]))
            q->chart[q->at].size[i] = fmax(q->chart[q->at].size[i], fabs(q->value[f->n + i]));
    if (!(now < SHRUNK) || !f->field->fast || (now * CHANGED > q->looked && now < q->looked * CHANGED && ++q->since < LOOK_AGAIN))
        return false;
    q->looked = now;
    q->since = 0;
    double lost = charts_noise(&q->chart[q->at].exact, f->field, f->manifold, t, x);
    least = lost / BETTER;
    for (int k = 0; k < q->count; k++) {
        struct chart *c = q->chart + k;
        if (k == q->at || !c->field->fast)
            continue;
        double noise = charts_noise(&c->exact, c->field, c->manifold, t, x);
        double other = noise <= AS_GOOD * lost ? smallest(q, k, c->field, t, x, &ignored) : 0;
        /* not to where a pivot comes to 0 as soon; and one on its way there is left in time, whatever it has cost so far */
        if ((noise < least && (other > now || other > SMALL)) || (best < 0 && now < SMALL && other > BETTER * now)) {
            least = noise < least ? noise : least;
            best = k;
        }
    }
    if (best < 0 && (now < SMALL || lost > POOR))
        add_ahead(f, pivot, t, x);
    if (best < 0 || !same_there(f, best, lost, t, x))
        return false;
    SGA_RESERVE(q->change, q->change_cap, q->changes + 1);
    assert(!q->changes || fabs(t - q->start) >= fabs(q->change[q->changes - 1].t - q->start));      /* in the order of the motion */
    q->change[q->changes++] = (struct charts_change){ t, pivot, q->at };
    go_over(f, best);
    q->looked = 0;
    if (f->manifold->c)
        manifold_project(f->manifold, t, x, NULL, NULL, 8, NULL, NULL, NULL);
    field_load(f->field, t, x);
    num_tape_eval(f->field->direct, f->field->in, f->field->direct_out);
    field_take_sides(f->field, t, x);
    f->field->start_t = NAN;
    return true;
}

void charts_return(struct flow *f)
{
    if (f->charts)
        go_over(f, 0);
}

void charts_begin(struct flow *f)
{
    if (!f->charts)
        return;
    charts_return(f);
    f->charts->looked = 0;
    f->field->start_t = f->charts->start;       /* sides are taken there anew */
    f->charts->changes = 0;
}

double charts_lost(struct flow *f)
{
    struct charts *q = f->charts;
    struct charts_exact own = { 0 }, *e = q ? &q->chart[q->at].exact : &own;
    bool known = f->field->fast && f->field->plain && (q ? !q->stop : f->manifold->c > 0);
    double lost = known ? charts_noise(e, f->field, f->manifold, f->field->home_t, f->field->home) : 0;
    charts_exact_clear(&own);
    return lost;
}

char *charts_pivot(struct flow *f, const struct charts_change *c)
{
    return expr_text(f->sys->store, field_of(f, c->left)->pivot_expr[c->pivot], 120);
}

/* One pattern for all charts, of which the last is new. */
static void join_patterns(struct flow *f)
{
    struct charts *q = f->charts;
    int all = 0, at = 0;
    lin_sparse_free(q->pattern);
    free(q->place);
    q->pattern = NULL;
    q->place = NULL;
    for (int k = 0; k < q->count; k++) {
        if (!field_of(f, k)->pattern)
            return;
        all += field_of(f, k)->pattern->ptr[f->n];
    }
    int *row = sga_malloc(((size_t)all + 1) * sizeof *row), *col = sga_malloc(((size_t)all + 1) * sizeof *col);
    q->place = sga_malloc(((size_t)all + 1) * sizeof *q->place);
    for (int k = 0; k < q->count; k++) {
        const struct lin_sparse *p = field_of(f, k)->pattern;
        for (int i = 0; i < f->n; i++)
            for (int e = p->ptr[i]; e < p->ptr[i + 1]; e++) {
                row[at] = i;
                col[at++] = p->col[e];
            }
    }
    q->pattern = lin_sparse_from_entries(f->n, f->n, all, row, col, q->place);
    free(row);
    free(col);
}

bool charts_slope(struct flow *f, double t, const double *x, double *value)
{
    const struct charts *q = f->charts;
    int at = 0, own = f->field->pattern->ptr[f->n];
    double *mine = sga_malloc(((size_t)own + 1) * sizeof *mine);
    bool ok = field_slope(f->field, t, x, mine);
    for (int k = 0; k < q->at; k++)
        at += q->chart[k].field->pattern->ptr[f->n];
    assert(own <= q->pattern->ptr[f->n]);       /* which is the union of all */
    memset(value, 0, (size_t)q->pattern->ptr[f->n] * sizeof *value);
    for (int e = 0; e < own && ok; e++)
        value[q->place[at + e]] = mine[e];
    free(mine);
    return ok;
}

static bool same_switches(const struct num_switches *a, const struct num_switches *b)
{
    return a->count == b->count && (!a->count || memcmp(a->argument, b->argument, (size_t)a->count * sizeof *a->argument) == 0);
}

bool charts_solve_at_start(const struct sys_system *sys, const struct sga_solution *first, const struct traj_request *rq, struct sga_solution *own,
                           struct points_oracle *oracle)
{
    struct sga_error ignored = { 0 };
    bool deep = false;
    for (int q = 0; q < first->pivots; q++)
        deep |= first->pivot[q].generation <= first->generations && !expr_is_const(sys->store, first->pivot[q].value);
    if (!deep)
        return false;
    struct reduction_options options = { .near = rq->initial, .near_given = rq->given, .near_time = rq->start, .near_pivots = true, .seed = SGA_SEED_CHART,
                                         .budget = rq->budget, .gauge_fields = first->free_columns > 0 };
    points_oracle_init(oracle, SGA_SEED_CHART);
    if (sga_reduce(sys, &options, oracle, own, &ignored) && sga_solution_same_kind(first, own))
        return true;
    sga_solution_clear(own);
    points_oracle_clear(oracle);
    return false;
}

static bool others(const struct field *a, const struct field *b)
{
    if (a->pivots != b->pivots)
        return true;
    return a->pivots && memcmp(a->pivot_expr, b->pivot_expr, (size_t)a->pivots * sizeof *a->pivot_expr) != 0;
}

/* No chart that is there has the same pivots: one that could not be gone over to is not made again. */
static bool is_new(const struct flow *f, const struct field *fresh)
{
    bool is = true;
    for (int k = 0; k < f->charts->count && is; k++)
        is = others(field_of(f, k), fresh);
    return is;
}

/* A flow with the reduction whose pivots are large where one comes to 0, ready at (t, x) before that (where whole rows are 0 there is nothing to
 * be told exactly there). */
static bool make(struct flow *f, struct chart *c, const struct sga_solution *first, const struct traj_request *rq, double zero,
                 const double *at_zero, double t, double *x)
{
    struct sga_error ignored = { 0 };
    struct reduction_options options = { .near = at_zero, .near_time = zero, .near_pivots = true, .seed = SGA_SEED_CHART, .budget = rq->budget, .gauge_fields = first->free_columns > 0 };
    points_oracle_init(&c->oracle, SGA_SEED_CHART);
    c->solution = sga_calloc(1, sizeof *c->solution);
    if (!sga_reduce(f->sys, &options, &c->oracle, c->solution, &ignored) || !sga_solution_same_kind(first, c->solution))
        return false;
    bool ok = flow_init(&c->own, f->sys, c->solution, rq, &ignored);
    if (!ok || !same_switches(f->field->switches, c->own.field->switches) || c->own.bands != f->bands)
        return false;
    c->own.manifold->unit = f->sizes->weight;
    c->own.field->unit = f->field->unit;
    if (c->own.manifold->c && !manifold_project(c->own.manifold, t, x, NULL, NULL, 20, NULL, NULL, NULL))
        return false;
    if (!field_begin(c->own.field, t, x, &ignored) || !is_new(f, c->own.field) || !field_slope_init(c->own.field, &ignored))
        return false;
    c->own.field->rank = f->field->rank;
    return true;
}

static void clear_chart(struct chart *c)
{
    if (c->own.n)
        flow_clear(&c->own);
    if (c->solution)
        sga_solution_clear(c->solution);
    free(c->solution);
    points_oracle_clear(&c->oracle);
    charts_exact_clear(&c->exact);
    free(c->size);
}

void charts_init(struct flow *f, const struct sga_solution *first, const struct traj_request *rq)
{
    if (f->field->deep <= f->field->sides || !f->field->fast || !f->field->plain)
        return;
    struct charts *q = f->charts = sga_calloc(1, sizeof *q);
    q->first = first;
    q->rq = rq;
    q->count = 1;
    q->chart = sga_calloc(1, sizeof *q->chart);
    q->start = rq->start;
    q->in = sga_calloc((size_t)f->n + 1, sizeof *q->in);
    set_up(f, 0);
}

/* The pivot i of the chart in use after the time s from (t, x), by a step of the midpoint rule, which asks the field half way at the most, where
 * it has more digits (or by Euler's, where it has no value there). y: the point. Not a number where there is no field. */
static double ahead(struct flow *f, int i, double t, const double *x, double s, double *y, double *v)
{
    struct charts *q = f->charts;
    int n = f->n;
    if (s != 0) {
        if (!field_eval(f->field, t, x, v))
            return NAN;
        for (int j = 0; j < n; j++)
            y[j] = x[j] + 0.5 * s * v[j];
        if (!field_eval(f->field, t + 0.5 * s, y, v) && !field_eval(f->field, t, x, v))
            return NAN;
        f->field->lost_pivot = -1;
    }
    for (int j = 0; j < n; j++)
        y[j] = q->in[j] = x[j] + (s != 0 ? s * v[j] : 0);
    q->in[n] = t + s;
    num_tape_eval(f->field->direct, q->in, q->value);
    return q->value[n + i];
}

/* (t, x) goes on to where the pivot is 0 nearly, by secants. False: it does not come to 0 soon. */
static bool to_zero(struct flow *f, int pivot, double *t, double *x)
{
    int n = f->n;
    double *y = sga_malloc(2 * ((size_t)n + 1) * sizeof *y), *v = y + n + 1;
    double from = ahead(f, pivot, *t, x, 0, y, v), passed = *t - f->charts->start, s0 = 0, p0 = from, s = FIRST * passed, p = NAN;
    for (int turn = 0; turn < 12; turn++) {
        p = ahead(f, pivot, *t, x, s, y, v);
        if (!(fabs(p) > AT_ZERO * fabs(from)) || p == p0 || !(fabs(s) <= fabs(passed)))
            break;
        double next = s - p * (s - s0) / (p - p0);
        s0 = s;
        p0 = p;
        s = next;
    }
    field_forget_trial(f->field);
    f->field->lost_pivot = -1;
    bool found = fabs(p) <= AT_ZERO * fabs(from) && s / passed > 0;
    if (found) {
        *t += s;
        memcpy(x, y, (size_t)n * sizeof *x);
    }
    free(y);
    return found;
}

/* A chart for the place of a zero, which is made ready at (t, x); x is moved. */
static bool add_at(struct flow *f, double zero, const double *at_zero, double t, double *x)
{
    struct charts *q = f->charts;
    struct chart fresh = { 0 };
    if (!make(f, &fresh, q->first, q->rq, zero, at_zero, t, x)) {
        clear_chart(&fresh);
        return false;
    }
    q->chart = sga_realloc(q->chart, ((size_t)q->count + 1) * sizeof *q->chart);
    q->chart[q->count] = fresh;
    struct chart *c = q->chart + q->count++;
    flow_code(&c->own, q->rq);
    take_out(&c->own, c);
    c->own.manifold = NULL;
    c->own.field = NULL;
    c->own.series = NULL;
    c->own.given = NULL;
    c->own.noise = NULL;
    set_up(f, q->count - 1);
    q->stop = true;
    return true;
}

/* A chart that is not in use has no small pivot at (t, x). */
static bool there_is_one(struct flow *f, double t, const double *x)
{
    struct charts *q = f->charts;
    int ignored;
    bool any = false;
    for (int k = 0; k < q->count && !any; k++)
        any = k != q->at && smallest(q, k, q->chart[k].field, t, x, &ignored) > SMALL;
    return any;
}

/* The pivot is small at (t, x), and no chart that is there is better. */
static void add_ahead(struct flow *f, int pivot, double t, const double *x)
{
    struct charts *q = f->charts;
    if (q->tries >= SGA_MOST_CHARTS) {
        sga_limit_met(q->rq->budget, SGA_LIMIT_CHARTS);
        return;
    }
    size_t n = (size_t)f->n;
    double *y = sga_malloc(2 * (n + 1) * sizeof *y), *z = y + n + 1, zero = t, start = f->field->start_t;
    memcpy(y, x, n * sizeof *y);
    memcpy(z, x, n * sizeof *z);
    if (to_zero(f, pivot, &zero, z) && !there_is_one(f, zero, z)) {
        q->tries++;
        add_at(f, zero, z, t, y);
    }
    f->field->start_t = start;
    free(y);
}

bool charts_add(struct flow *f)
{
    struct charts *q = f->charts;
    int pivot;
    if (!q)
        return false;
    q->stop = false;
    size_t n = (size_t)f->n;
    double t = f->field->home_t, *x = sga_malloc(2 * (n + 1) * sizeof *x), *place = x + n + 1;
    memcpy(x, f->field->home, n * sizeof *x);
    memcpy(place, x, n * sizeof *x);
    bool ok = (smallest(q, q->at, f->field, t, x, &pivot) < AT_END || (f->field->lost_pivot >= 0 && f->field->lost_pivot < f->field->deep)) && add_at(f, t, place, t, x);
    free(x);
    return ok;
}

void charts_again(struct flow *f)
{
    charts_begin(f);
    f->charts->stop = false;
    join_patterns(f);
}

void charts_clear(struct flow *f)
{
    struct charts *q = f->charts;
    if (!q)
        return;
    charts_begin(f);
    for (int k = 1; k < q->count; k++) {
        put_in(&q->chart[k].own, q->chart + k);
        clear_chart(q->chart + k);
    }
    charts_exact_clear(&q->chart[0].exact);
    free(q->chart[0].size);
    lin_sparse_free(q->pattern);
    free(q->place);
    free(q->chart);
    free(q->in);
    free(q->value);
    free(q->change);
    free(q);
    f->charts = NULL;
}
