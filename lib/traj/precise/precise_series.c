/* Steps in double-double by Taylor series. As lib/ode/taylor.c, and simpler: steps end where
 * the series wants them to, samples are values of the polynomial. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "jet.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "precise_series.h"

#define LEAST_ORDER 8
#define MOST_ORDER 40
#define LAST_TERMS 3
#define LONGER 2               /* orders */
#define EXPECTED_FALL 0.2
#define SAFETY 0.95
#define FAR_BEYOND 1e-3        /* of the scale: a first step that asks for another one */
#define SCALES 4               /* tries of a scale on which the series is finite */

static void *series_alloc(struct precise_march *m)
{
    struct expansions *w = sga_calloc(1, sizeof *w);
    double tol = m->rtol > 0 ? m->rtol : fmin(1e-3, m->atol);
    struct precise *p = m->p;
    w->n = m->n;
    /* Steps that end where switches turn are the same in solutions that are compared, whose errors must not be (cos has no odd terms). */
    double more = m->sides.count && !m->beside ? 2 + LONGER : 2;
    w->order = (int)fmin(MOST_ORDER, fmax(LEAST_ORDER, ceil(-log(tol) / 2 + more)));
    if (!p->series || p->order != w->order) {
        num_jet2_free(p->series);
        p->series = num_jet2_new(p->field, w->order);
        p->order = w->order;
    }
    size_t count = (size_t)(w->order + 1) * (size_t)w->n;
    w->here.series = sga_calloc(count + 1, sizeof *w->here.series);
    w->there.series = sga_calloc(count + 1, sizeof *w->there.series);
    w->slope = sga_calloc((size_t)w->n + 1, sizeof *w->slope);
    w->part = sga_calloc((size_t)w->order + 1, sizeof *w->part);
    w->work = sga_calloc(3 * (size_t)w->order + 1, sizeof *w->work);
    w->count = m->sides.count;
    w->here.argument = sga_calloc((size_t)w->count * (size_t)w->order + 1, sizeof *w->here.argument);
    w->there.argument = sga_calloc((size_t)w->count * (size_t)w->order + 1, sizeof *w->there.argument);
    w->change = sga_calloc((size_t)w->count + 1, sizeof *w->change);
    return w;
}

static void series_free(void *state)
{
    struct expansions *w = state;
    free(w->here.series);
    free(w->there.series);
    free(w->here.argument);
    free(w->there.argument);
    free(w->change);
    free(w->slope);
    free(w->part);
    free(w->work);
    free(w);
}

static bool series_at(struct expansions *w, struct precise_march *m, const struct precise_point *at, struct expansion *q)
{
    struct num_jet2 *jet = m->p->series;
    int n = w->n;
    num_dd *time = num_jet2_input(jet, n);
    memset(time, 0, (size_t)(w->order + 1) * sizeof *time);
    time[0] = at->t;
    time[1] = num_dd_of(q->scale);
    for (int j = 0; j < n; j++)
        q->series[j] = num_jet2_input(jet, j)[0] = at->x[j];
    for (int k = 0; k < w->order; k++) {
        if (!num_jet2_next(jet, k))
            return false;
        for (int j = 0; j < n; j++) {
            num_dd c = num_dd_div(num_dd_scale(num_jet2_root(jet, j)[k], q->scale), num_dd_of(k + 1));
            if (m->beside)
                c = num_dd_mul(c, (num_dd){ 1, j % 2 ? -NUM_DD_EPSILON : NUM_DD_EPSILON });
            num_jet2_input(jet, j)[k + 1] = q->series[(size_t)(k + 1) * (size_t)n + (size_t)j] = c;
        }
    }
    for (int e = 0; e < w->count; e++)
        memcpy(q->argument + (size_t)e * (size_t)w->order, num_jet2_root(jet, n + e), (size_t)w->order * sizeof *q->argument);
    q->reach = num_jet2_reach(jet, w->order - 1);
    return true;
}

/* The last terms have a size in units of the error allowed. */
static bool measurable(const struct expansions *w, const struct precise_march *m, const struct expansion *q)
{
    for (int i = 0; i < LAST_TERMS; i++)
        if (isinf(precise_weighted(m, q->series + (size_t)(w->order - i) * (size_t)w->n)))
            return false;
    return true;
}

bool precise_expand(struct expansions *w, struct precise_march *m, const struct precise_point *at, struct expansion *q, double size)
{
    int e;
    frexp(size, &e);
    q->scale = ldexp(m->direction, e);
    for (int turn = 0; turn < SCALES; turn++, q->scale *= 1.0 / 256) {
        m->path->evaluations += w->order;
        if (series_at(w, m, at, q) && measurable(w, m, q))
            return true;
    }
    return false;
}

/* The polynomial at s; slope (or NULL): its derivative by s. */
static void polynomial(const struct expansions *w, num_dd s, num_dd *x, num_dd *slope)
{
    for (int j = 0; j < w->n; j++) {
        num_dd v = num_dd_of(0), d = num_dd_of(0);
        for (int k = w->order; k > 0; k--) {
            num_dd c = w->here.series[(size_t)k * (size_t)w->n + (size_t)j];
            v = num_dd_mul(num_dd_add(v, c), s);
            if (slope)
                d = num_dd_add(num_dd_mul(d, s), num_dd_mul_d(c, k));
        }
        x[j] = num_dd_add(w->here.series[j], v);
        if (slope)
            slope[j] = d;
    }
}

double precise_terms(const double last[LAST_TERMS], int order)
{
    double fall = EXPECTED_FALL, s = INFINITY;
    for (int i = 0; i < LAST_TERMS; i++, fall *= EXPECTED_FALL)
        if (fall * last[i] > 0)
            s = fmin(s, pow(fall * last[i], -1.0 / (order - i)));
    return SAFETY * s;
}

/* How far the next step may go. */
void precise_look_ahead(struct expansions *w, struct precise_march *m)
{
    double last[LAST_TERMS];
    int order = w->order - (m->sides.count && !m->beside ? LONGER : 0);       /* no longer steps for more terms: the errors of solutions that are compared are not to be alike */
    precise_set_scale(m, m->here.x);
    for (int i = 0; i < LAST_TERMS; i++)
        last[i] = precise_weighted(m, w->here.series + (size_t)(order - i) * (size_t)w->n);
    w->far = fmin(1, precise_terms(last, order));
    precise_find_changes(w, m);
}

static bool series_begin(void *state, struct precise_march *m, double size)
{
    struct expansions *w = state;
    m->why = ODE_LEFT_DOMAIN;
    precise_set_scale(m, m->here.x);
    double s = size;
    while (s > 1e-30 * size && !precise_expand(w, m, &m->here, &w->here, s))
        s *= 1e-3;
    if (!(s > 1e-30 * size)) {       /* beside it there may be one */
        w->here.scale = m->direction * size;
        return w->count && precise_take_sides(w, m) && precise_sides_settle(w, m, size);
    }
    /* coefficients on a scale far beyond the steps come near to the largest numbers */
    precise_look_ahead(w, m);
    double nearer = 4 * w->far * fabs(w->here.scale);
    if (w->far < FAR_BEYOND && nearer > 0 && precise_expand(w, m, &m->here, &w->here, nearer))
        s = nearer;
    return precise_take_sides(w, m) && precise_sides_settle(w, m, s);
}

static num_dd series_size(void *state, struct precise_march *m, double cut)
{
    struct expansions *w = state;
    double far = cut * w->far;
    assert(w->here.scale * m->direction > 0);
    num_dd s = num_dd_of(far);
    precise_set_scale(m, m->here.x);
    m->sides.heading = false;
    if (w->here.reach.hi < far)                /* with nothing held: over a place without series, if the defect allows it */
        s = m->sides.natural ? num_dd_of(fmin(far, 2 * w->here.reach.hi * cut)) : num_dd_add(w->here.reach, num_dd_of(1e-30));
    for (int e = 0; e < w->count; e++)
        if (num_dd_less(w->change[e], s)) {
            s = w->change[e];
            m->sides.heading = true;
        }
    return w->to = num_dd_scale(s, w->here.scale);
}

/* The polynomial's derivative at the end against the field there, in units of what a step may do. */
static double defect(const struct expansions *w, const struct precise_march *m, double h)
{
    double sum = 0, size = 0;
    for (int j = 0; j < w->n; j++) {
        num_dd f = num_dd_div(w->there.series[w->n + j], num_dd_of(w->there.scale));
        double miss = num_dd_sub(num_dd_div(w->slope[j], num_dd_of(w->here.scale)), f).hi * h / m->scale[j];
        sum += miss * miss;
        size += (f.hi * h / m->scale[j]) * (f.hi * h / m->scale[j]);
    }
    return fmax(0, sqrt(sum / w->n) - 500 * NUM_DD_EPSILON * sqrt(size / w->n)) / (w->order + 1);
}

static enum precise_outcome series_attempt(void *state, struct precise_march *m, num_dd h, double *cut)
{
    struct expansions *w = state;
    bool turns = m->sides.heading && h.hi == w->to.hi && h.lo == w->to.lo;
    polynomial(w, num_dd_scale(h, 1 / w->here.scale), m->there.x, w->slope);
    m->there.t = precise_after(m, h);
    *cut *= 0.5;
    bool known = precise_arrive(m);
    if (known) {
        m->why = ODE_LEFT_DOMAIN;
        known = precise_expand(w, m, &m->there, &w->there, 2 * fabs(h.hi));
    }
    if (!known) {
        if (turns && m->why == ODE_LEFT_DOMAIN && precise_let_go(w, m, 2 * fabs(h.hi)))
            *cut = 1;
        return PRECISE_REFUSED;
    }
    double miss = defect(w, m, fabs(h.hi));
    if (miss > 1) {
        *cut *= 2 * fmax(0.1, 0.9 * pow(miss, -1.0 / w->order));
        return PRECISE_TOO_LARGE;
    }
    return precise_sides_agree(w, m, turns, cut) ? PRECISE_TAKEN : PRECISE_TOO_LARGE;
}

static void series_value(const void *state, const struct precise_march *m, num_dd t, num_dd *x)
{
    const struct expansions *w = state;
    polynomial(w, num_dd_div(num_dd_sub(t, m->here.t), num_dd_of(w->here.scale)), x, NULL);
}

static bool series_accepted(void *state, struct precise_march *m)
{
    struct expansions *w = state;
    struct expansion before = w->here;
    w->here = w->there;
    w->there = before;
    return precise_sides_pass(w, m);
}

static double series_cost(const void *state, const struct precise_march *m)
{
    const struct expansions *w = state;
    return num_jet2_length(m->p->series) * (0.5 * w->order + 2) * w->order + 8.0 * w->order * w->n;
}

const struct precise_method precise_series = {
    .name = "taylor",
    .alloc = series_alloc,
    .free = series_free,
    .begin = series_begin,
    .size = series_size,
    .attempt = series_attempt,
    .value = series_value,
    .accepted = series_accepted,
    .cost = series_cost,
};
