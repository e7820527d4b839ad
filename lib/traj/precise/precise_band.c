/* Exponentials between steps in double-double: as in double (ode/band.c), by the same search in doubles. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "band.h"
#include "flow.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "tape.h"

static const double PROBE = 1e-4;          /* of a step: for the rates at its ends */

struct way {
    struct precise_march *m;
    num_dd h, *x;
    double *in;
};

static void at_point(struct precise_march *m, num_dd t, const num_dd *x, double *in, double *a)
{
    for (int j = 0; j < m->n; j++)
        in[j] = x[j].hi;
    in[m->n] = t.hi;
    num_tape_eval(m->p->flow->band, in, a);
}

static void on_step(void *ctx, double theta, double *a)
{
    struct way *w = ctx;
    num_dd t = num_dd_add(w->m->here.t, num_dd_scale(w->h, theta));
    w->m->method->value(w->m->state, w->m, t, w->x);
    at_point(w->m, t, w->x, w->in, a);
}

/* Rates at an end, of which a are the values: towards the inside. */
static void rates(struct way *w, int count, double theta, const double *a, double *rate)
{
    on_step(w, theta < 0.5 ? PROBE : 1 - PROBE, rate);
    for (int k = 0; k < count; k++)
        rate[k] = theta < 0.5 ? (rate[k] - a[k]) / PROBE : (a[k] - rate[k]) / PROBE;
}

double precise_band(struct precise_march *m, num_dd h)
{
    size_t c = (size_t)m->p->flow->bands, n = (size_t)m->n;
    double place = 2;
    if (!c)
        return place;
    double *a = sga_malloc((4 * c + n + 1) * sizeof *a), *a1 = a + c, *rate = a1 + c, *rate1 = rate + c;
    num_dd *x = sga_malloc((n + 1) * sizeof *x);
    struct way way = { m, h, x, rate1 + c };
    at_point(m, m->here.t, m->here.x, way.in, a);
    at_point(m, m->there.t, m->there.x, way.in, a1);
    int outside = ode_band_outside((int)c, a, a1);
    if (outside > 1) {
        rates(&way, (int)c, 0, a, rate);
        rates(&way, (int)c, 1, a1, rate1);
    }
    double grain = 2 * NUM_DD_EPSILON * fmax(fabs(m->here.t.hi), fabs(m->there.t.hi)) / fabs(h.hi);
    struct guard_way along = { .count = (int)c, .at = on_step, .of = &way, .grain = grain, .budget = m->p->rq->budget };
    struct ode_band_way w = { .way = &along, .a = a, .a1 = a1, .rate = rate, .rate1 = rate1 };
    if (outside && ode_band_suspect(&w))
        place = ode_band_place(&w);
    assert(place > 0);       /* else the step would be tried again as it is */
    free(x);
    free(a);
    return place;
}
