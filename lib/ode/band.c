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

static const double BAND = 40, SEEN = 4, FURTHER = 8;      /* SEEN: e^4 times what an end shows is not seen there */
static const double PROBE = 1e-4;          /* of a step: for the rates at its ends */

struct ode_bands {
    int count;
    double *memory;
    double *a, *a1, *rate, *rate1;      /* at the step's ends: arguments, and their derivatives along the motion */
    double *x;                          /* n */
    struct ode_way way;
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
    b->a = b->memory = sga_calloc(4 * c + n, sizeof *b->a);
    b->a1 = b->a + c;
    b->rate = b->a1 + c;
    b->rate1 = b->rate + c;
    b->x = b->rate1 + c;
    ode_way_begin(&b->way, m, b->count, m->p->band);
}

void ode_bands_end(struct ode_march *m)
{
    if (m->bands) {
        ode_way_end(&m->bands->way);
        free(m->bands->memory);
    }
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

/* The first place where argument k was much nearer to 0 than at both ends. 2: none. */
static double place_of(const struct ode_band_way *w, struct guard_table *t, int k)
{
    double s = w->a[k] > 0 ? 1 : -1, ends = fmin(s * w->a[k], s * w->a1[k]);
    for (int i = 0; i + 1 < t->nodes; i++) {
        double v = s * guard_value(t, i, k), after = s * guard_value(t, i + 1, k);
        if (v > 0 && after < 0)
            return guard_root(w->way, k, t->theta[i], s * v, t->theta[i + 1], s * after, t->g);
        if (i > 0 && v <= s * guard_value(t, i - 1, k) && v <= after && v < fmin(BAND, ends - SEEN))
            return t->theta[i];
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
    for (int k = 0; k < w->way->count && !any; k++)
        any = side(w->a[k]) * side(w->a1[k]) < 0 || moves(w, k);
    return any;
}

double ode_band_place(const struct ode_band_way *w)
{
    double first = 2;
    struct guard_table t;
    guard_table_init(&t, w->way->count);
    for (int k = 0; k < w->way->count; k++) {
        if (side(w->a[k]) * side(w->a1[k]) < 0) {
            first = fmin(first, guard_root(w->way, k, 0, w->a[k], 1, w->a1[k], t.g));
        } else if (moves(w, k)) {
            if (!t.nodes) {
                guard_table_fill(&t, w->way);
                guard_table_monotone(&t, w->way);
            }
            first = fmin(first, place_of(w, &t, k));
        }
    }
    guard_table_clear(&t);
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
    struct ode_band_way w = { .way = ode_way_ready(&b->way), .a = b->a, .a1 = b->a1, .rate = b->rate, .rate1 = b->rate1 };
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
