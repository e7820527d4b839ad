/* Where switches change their sides along a step in double-double: see precise_sides.c. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"
#include "flow.h"
#include "jacobian.h"
#include "jet.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "precise_series.h"
#include "tape.h"

#define SMALL 1e-28            /* of the other coefficients: no direction */
#define ROUNDINGS 64.0         /* of the state, in an argument */
#define GRAIN 4.0              /* roundings of time: no step is shorter */
/* Of the error allowed: what turning beside the surface may do; and may still do after TRIES tries to end nearer. */
#define HARMLESS 1e-6
#define HARM 0.5
#define TRIES 3
#define CORRECTED 0.1          /* of the way: a try may come nearer by so much */

void precise_grains(struct precise_march *m, const struct precise_point *at, const struct expansion *near)
{
    struct precise_sides *q = &m->sides;
    const struct num_jacobian *jac = q->slopes;
    int n = m->n;
    for (int j = 0; j < n; j++)
        q->in[j] = at->x[j].hi;
    q->in[n] = at->t.hi;
    num_jacobian_eval(q->slopes, q->in, NULL, q->slope);
    memset(q->rounding, 0, 2 * (size_t)q->count * sizeof *q->rounding);
    for (int e = 0; e < q->count; e++)
        for (int k = jac->start[e]; k < jac->start[e + 1]; k++) {
            int j = jac->col[k];
            double size = fmax(fabs(q->in[j]), fabs(j < n ? near->series[n + j].hi : near->scale));
            double slope = fabs(q->slope[k]), noise = ROUNDINGS * NUM_DD_EPSILON * slope * size;
            if (!isfinite(slope))
                continue;
            q->rounding[e] += noise;
            q->doubt[e] += noise + slope * (j < n ? m->scale[j] : 0);
        }
}

double precise_grain(const struct precise_march *m, const struct precise_point *at)
{
    return GRAIN * NUM_DD_EPSILON * fmax(fabs(at->t.hi), fabs(num_dd_sub(at->t, m->p->start).hi));
}

double precise_argument_far(const struct expansions *w, const struct precise_march *m, const num_dd *g, double far)
{
    enum { TURNS = 60 };
    for (int turn = 0; turn < TURNS; turn++) {
        double last[3] = { 0 }, most = 0, power = 1;
        for (int k = 0; k < w->order; k++, power *= far) {      /* over s / far: coefficients on a scale far beyond overflow */
            double term = fabs(g[k].hi) * power;
            most = fmax(most, term);
            if (k >= w->order - 3)
                last[w->order - 1 - k] = term;
        }
        for (int i = 0; i < 3; i++)
            last[i] /= fmax(fmax(m->rtol, NUM_DD_EPSILON) * most, 1e-300);
        double s = far * precise_terms(last, w->order - 1);
        if (!(s < far))
            break;
        far = s;
    }
    return far;
}

double precise_spread(struct expansions *w, const num_dd *g, double far)
{
    double power = 1, sum = 0;
    for (int k = 0; k < w->order; k++, power *= far) {
        w->part[k] = num_dd_mul_d(g[k], power);
        sum += fabs(w->part[k].hi);
    }
    return sum;
}

int precise_direction(const struct expansions *w)
{
    double most = 0;
    for (int k = 1; k < w->order; k++)
        most = fmax(most, fabs(w->part[k].hi));
    for (int k = 1; k < w->order; k++)
        if (fabs(w->part[k].hi) > SMALL * most)
            return w->part[k].hi > 0 ? 1 : -1;
    return 0;
}

/* The argument can leave its side within far. */
static bool may_change(const struct expansions *w, int e)
{
    const num_dd *g = precise_argument(w, &w->here, e);
    double rest = 0;
    for (int k = w->order - 1; k > 0; k--)
        rest = (rest + fabs(g[k].hi)) * w->far;
    return !(fabs(g[0].hi) > rest);
}

/* Where e leaves its side: within far, or INFINITY. */
static num_dd change_of(struct expansions *w, const struct precise_march *m, int e)
{
    int side = m->sides.side[e];
    if (precise_spread(w, precise_argument(w, &w->here, e), w->far) <= m->sides.rounding[e])
        return num_dd_of(INFINITY);
    if (!(side * w->part[0].hi > 0)) {             /* on the surface, or beyond by what steps err */
        if (precise_direction(w) != side)
            return num_dd_of(0);
        w->part[0] = num_dd_of(0);
    }
    num_dd change = num_jet2_change(w->part, w->order - 1, side, w->work);
    return isinf(change.hi) ? change : num_dd_mul_d(change, w->far);
}

void precise_find_changes(struct expansions *w, struct precise_march *m)
{
    const struct precise_sides *q = &m->sides;
    bool any = false;
    for (int e = 0; e < w->count; e++) {
        w->change[e] = num_dd_of(INFINITY);
        any |= !q->natural && q->side[e] && may_change(w, e);
    }
    if (!any)
        return;
    precise_grains(m, &m->here, &w->here);
    double far = w->far;
    for (int e = 0; e < w->count; e++)
        if (q->side[e] && may_change(w, e))
            far = precise_argument_far(w, m, precise_argument(w, &w->here, e), far);
    w->far = far;
    m->sides.tries = 0;
    for (int e = 0; e < w->count; e++)
        if (q->side[e] && may_change(w, e))
            w->change[e] = change_of(w, m, e);
}

/* At there the pending switches are off their surfaces by so much time. What turning them does to the motion in that time, in
 * units of the error allowed. */
static double harm(const struct expansions *w, struct precise_march *m)
{
    double time = 0, most = 0;
    for (int e = 0; e < w->count; e++) {
        const num_dd *g = precise_argument(w, &w->there, e);
        if (m->sides.pending[e])
            time = fmax(time, fabs(g[0].hi) <= m->sides.rounding[e] ? 0 : fabs(g[0].hi * w->there.scale) / fabs(g[1].hi));
    }
    if (!(time > precise_grain(m, &m->there)))
        return 0;
    double *before = memcpy(sga_malloc((size_t)m->n * sizeof *before), m->fd, (size_t)m->n * sizeof *before);
    precise_flip_pending(m);
    if (field_eval(m->p->flow->field, m->there.t.hi, m->xd, m->fd))
        for (int j = 0; j < m->n; j++)
            most = fmax(most, fabs(m->fd[j] - before[j]) * time / m->scale[j]);
    precise_flip_pending(m);
    memcpy(m->fd, before, (size_t)m->n * sizeof *before);
    free(before);
    return most;
}

/* The step missed the surfaces by what the arguments' series there say. */
static void correct_changes(struct expansions *w, const struct precise_march *m)
{
    for (int e = 0; e < w->count; e++) {
        const num_dd *g = precise_argument(w, &w->there, e);
        num_dd move = num_dd_mul_d(num_dd_div(g[0], g[1]), w->there.scale / w->here.scale);
        if (m->sides.pending[e] && fabs(move.hi) <= CORRECTED * w->change[e].hi)
            w->change[e] = num_dd_sub(w->change[e], move);
    }
}

bool precise_sides_agree(struct expansions *w, struct precise_march *m, bool turns, double *cut)
{
    struct precise_sides *q = &m->sides;
    if (!w->count || q->natural)
        return true;
    num_dd first = num_dd_of(INFINITY);
    bool near = false;
    for (int e = 0; e < w->count; e++)
        first = num_dd_less(w->change[e], first) ? w->change[e] : first;
    for (int e = 0; e < w->count; e++) {
        double after = num_dd_sub(w->change[e], first).hi * fabs(w->here.scale);
        q->pending[e] = turns && w->change[e].hi <= w->far && after <= precise_grain(m, &m->there);
        near |= q->pending[e] || (q->side[e] && !(q->side[e] * precise_argument(w, &w->there, e)[0].hi > 0));
    }
    if (!near)
        return true;
    precise_grains(m, &m->there, &w->there);
    for (int e = 0; e < w->count; e++)
        if (q->side[e] && !q->pending[e] && q->side[e] * precise_argument(w, &w->there, e)[0].hi < -q->doubt[e])
            return false;
    double worst = harm(w, m);
    if (worst > HARMLESS && q->tries < TRIES) {
        q->tries++;
        *cut = 1;
        correct_changes(w, m);
        return false;
    }
    return worst <= HARM;
}
