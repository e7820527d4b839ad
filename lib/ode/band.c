/* Exponentials between steps.
 *
 * exp(a), tanh(a), cosh(a) and high powers are 0, constant or out of all proportion but where a is within some tens of 0:
 * exp(-10^8 (x - 3/10)^2) is a pulse that no stage of a step may meet, and then no error estimate does. So the
 * arguments a are looked at after each step: where they changed their side, or came nearer to 0 at first and went away at last (the
 * step's polynomial says how near), and were inside the band |a| < BAND and much nearer to 0 than at both ends, the step is
 * taken again, to end there. What follows is seen by the error control. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "band.h"
#include "larger.h"
#include "march.h"
#include "mem.h"

static const double BAND = 40, SEEN = 4, WELL_INSIDE = 2, FURTHER = 8;      /* SEEN: e^4 times what an end shows is not seen there */
static const double PROBE = 1e-4;          /* of a step: for the rates at its ends */
enum { TURNS = 60, NODES = 8 };

struct ode_bands {
    int count;
    double *memory;
    double *a, *a1, *rate, *rate1;      /* at the step's ends: arguments, and their derivatives along the motion */
    double *x, *at;                     /* n; count */
    double cut;                         /* the next step is no longer than this; 0: no matter */
    bool known;                         /* a is that of the present point */
};

void ode_bands_begin(struct ode_march *m)
{
    size_t c = (size_t)m->p->bands, n = (size_t)m->p->n;
    if (!c || !n)
        return;
    struct ode_bands *b = m->bands = sga_calloc(1, sizeof *b);
    b->count = m->p->bands;
    b->a = b->memory = sga_calloc(5 * c + n, sizeof *b->a);
    b->a1 = b->a + c;
    b->rate = b->a1 + c;
    b->rate1 = b->rate + c;
    b->at = b->rate1 + c;
    b->x = b->at + c;
}

void ode_bands_end(struct ode_march *m)
{
    if (m->bands)
        free(m->bands->memory);
    free(m->bands);
    m->bands = NULL;
}

double ode_bands_cut(const struct ode_march *m, double h)
{
    return m->bands && m->bands->cut > 0 ? sga_smaller(h, m->bands->cut) : h;
}

void ode_bands_pass(struct ode_march *m)
{
    struct ode_bands *b = m->bands;
    if (!b)
        return;
    double *a = b->a;
    b->a = b->a1;
    b->a1 = a;
    b->cut = 0;
}

static int side(double a)
{
    return a > SEEN ? 1 : a < -SEEN ? -1 : 0;
}

static double along(const struct ode_band_way *w, int k, double theta)
{
    w->along(w->ctx, theta, w->at);
    return w->at[k];
}

/* Where in (low, high) argument k, on two sides there, is near 0; high where it jumps. */
static double crossing(const struct ode_band_way *w, int k, double low, double high, double first)
{
    for (int i = 0; i < TURNS; i++) {
        double s = 0.5 * (low + high), v = along(w, k, s);
        if (fabs(v) < WELL_INSIDE)
            return s;
        *((v > 0) == (first > 0) ? &low : &high) = s;
    }
    return high;
}

/* s a falls from low at first, and rises to high at last: its least value, by golden sections, and where. */
static double least(const struct ode_band_way *w, int k, double s, double low, double high, double *where)
{
    const double golden = 0.3819660112501051;
    double u = low + golden * (high - low), v = s * along(w, k, u);
    for (int i = 0; i < TURNS && v >= WELL_INSIDE && high - low > 1e-12; i++) {
        double next = high - u > u - low ? u + golden * (high - u) : u - golden * (u - low), value = s * along(w, k, next);
        bool better = value < v;
        *(better == (next > u) ? &low : &high) = better ? u : next;
        if (better) {
            u = next;
            v = value;
        }
    }
    *where = u;
    return v;
}

/* The first place where argument k was much nearer to 0 than at both ends. 2: none. */
static double place_of(const struct ode_band_way *w, int k)
{
    double v[NODES + 1], s = w->a[k] > 0 ? 1 : -1, ends = fmin(s * w->a[k], s * w->a1[k]), where;
    v[0] = s * w->a[k];
    v[NODES] = s * w->a1[k];
    for (int i = 1; i < NODES; i++)
        v[i] = s * along(w, k, (double)i / NODES);
    for (int i = 0; i < NODES; i++) {
        double low = (double)i / NODES, high = (double)(i + 1) / NODES;
        if (v[i] > 0 && v[i + 1] < 0)
            return crossing(w, k, low, high, s);
        /* to the left of it, it falls; to the right, it rises */
        bool falls = i ? v[i] <= v[i - 1] : s * w->rate[k] < 0, rises = i + 1 < NODES ? v[i + 2] >= v[i + 1] : s * w->rate1[k] > 0;
        if (falls && rises && least(w, k, s, low, high, &where) < fmin(BAND, ends - SEEN))
            return where;
    }
    return 2;
}

int ode_band_outside(int count, const double *a, const double *a1)
{
    int most = 0;
    for (int k = 0; k < count && most < 2; k++) {
        int both = side(a[k]) * side(a1[k]);
        most = both > 0 ? 2 : both < 0 ? 1 : most;
    }
    return most;
}

/* It moves so much that it may have come near: further than its rates at the ends say, as a logarithm does. */
static bool moves(const struct ode_band_way *w, int k)
{
    double p = fabs(w->a[k]), q = fabs(w->a1[k]), way = fabs(w->a1[k] - w->a[k]) + fabs(w->rate[k]) + fabs(w->rate1[k]);
    return side(w->a[k]) * side(w->a1[k]) > 0 && way > SEEN && (p < q ? p : q) - FURTHER * way < BAND;
}

bool ode_band_suspect(const struct ode_band_way *w)
{
    bool any = false;
    for (int k = 0; k < w->count && !any; k++)
        any = side(w->a[k]) * side(w->a1[k]) < 0 || moves(w, k);
    return any;
}

double ode_band_place(const struct ode_band_way *w)
{
    double first = 2;
    for (int k = 0; k < w->count; k++) {
        if (side(w->a[k]) * side(w->a1[k]) < 0)
            first = fmin(first, crossing(w, k, 0, 1, w->a[k]));
        else if (moves(w, k))
            first = fmin(first, place_of(w, k));
    }
    return first < 1 ? first : 2;
}

/* Derivatives along the motion, by the step's size. */
static void rates(struct ode_march *m, double t, const double *x, const double *f, const double *a, double *rate)
{
    struct ode_bands *b = m->bands;
    double d = PROBE * m->step.h;
    for (int j = 0; j < m->p->n; j++)
        b->x[j] = x[j] + d * f[j];
    m->p->band(m->p->ctx, t + d, b->x, rate);
    for (int k = 0; k < b->count; k++)
        rate[k] = (rate[k] - a[k]) / PROBE;
}

static void on_polynomial(void *ctx, double theta, double *a)
{
    struct ode_march *m = ctx;
    m->method->dense_at(m->state, &m->step, theta, m->bands->x);
    m->p->band(m->p->ctx, m->t + (theta * m->step.h + m->t_low), m->bands->x, a);
}

enum ode_refusal ode_bands_step(struct ode_march *m)
{
    struct ode_bands *b = m->bands;
    if (!b)
        return STEP_TAKEN;
    if (!b->known)
        m->p->band(m->p->ctx, m->t, m->x, b->a);
    b->known = true;
    m->p->band(m->p->ctx, m->t1, m->x1, b->a1);
    int outside = ode_band_outside(b->count, b->a, b->a1);
    if (!outside)
        return STEP_TAKEN;
    if (outside > 1) {
        rates(m, m->t, m->x, m->f, b->a, b->rate);
        rates(m, m->t1, m->x1, m->f1, b->a1, b->rate1);
    }
    struct ode_band_way w = { .count = b->count, .a = b->a, .a1 = b->a1, .rate = b->rate, .rate1 = b->rate1, .at = b->at,
                              .along = on_polynomial, .ctx = m };
    if (!ode_band_suspect(&w))
        return STEP_TAKEN;
    if (!m->dense_checked && !m->method->dense_begin(m->state, &m->field, &m->step))
        return FIELD_REFUSED;
    m->dense_checked = true;
    double place = ode_band_place(&w);
    if (place > 1)
        return STEP_TAKEN;
    assert(place > 0);       /* else the step would be tried again as it is */
    b->cut = place * fabs(m->step.h);
    return STEP_CUT;
}
