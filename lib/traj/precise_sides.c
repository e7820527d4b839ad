/* Switches (abs, sign, min, max) in double-double: on which side each is held, and where that changes.
 *
 * As lib/ode/kink.c does in double: along a step every switch is held on the side of its surface g = 0 where the
 * motion is, in the field and in the constraints, so that series and projections see smooth functions. The series of
 * g along the motion tells where it leaves that side: a step ends there, and the next one begins on the other side,
 * whatever sign rounding has left of g. Where the field beyond leads back at once the motion would slide along the
 * surface, and ends. A switch whose g is 0 to rounding at the start, with no side or with both that the motion
 * could take, is not held, and is what its argument says.
 *
 * Where the field held on one side has no series on its surface (sqrt(abs(x))), one step is made with nothing held,
 * to just beyond. (Sides: Filippov; the double version has the sources.) */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "precise_series.h"

#define SMALL 1e-28            /* of the other coefficients: no direction */
#define ROUNDINGS 64.0         /* of the state, in an argument */
#define AWAKE 1e4              /* roundings: a switch that was not held is off its surface */
#define GRAIN 4.0              /* roundings of time: no step is shorter */
/* Of the error allowed: what turning beside the surface may do; and may still do after TRIES tries to end nearer. */
#define HARMLESS 1e-6
#define HARM 0.5
#define TRIES 3

void precise_sides_begin(struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    size_t c = (size_t)(q->count = m->p->flow->field.switches.count);
    if (!c)
        return;
    q->side = sga_calloc(2 * c, 1);
    q->pending = (unsigned char *)q->side + c;
    q->rounding = sga_calloc(4 * c + (size_t)m->n + 1, sizeof *q->rounding);
    q->doubt = q->rounding + c;
    q->value = q->doubt + c;
    q->in = q->value + 2 * c;
}

static void hold(struct precise_march *m)
{
    struct precise *p = m->p;
    const signed char *side = m->sides.natural ? NULL : m->sides.side;
    flow_hold(p->flow, side);
    num_tape_hold(p->field, side);
    if (p->series)
        num_jet2_hold(p->series, p->field);
    num_jet2_hold(p->constraint, p->flow->manifold.tape);
    if (p->velocity)
        num_jet2_hold(p->velocity, p->flow->field.plain);
}

void precise_sides_end(struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    if (!q->count)
        return;
    q->natural = true;
    hold(m);
    free(q->side);
    free(q->rounding);
}

/* By how much rounding in x, and errors in x as large as allowed, change each argument at a point. */
static void grains(struct precise_march *m, const struct precise_point *at, const struct expansion *near)
{
    struct precise_sides *q = &m->sides;
    struct num_tape *surface = m->p->flow->surface;
    int n = m->n;
    double *g = q->value, *moved = g + q->count;
    for (int j = 0; j < n; j++)
        q->in[j] = at->x[j].hi;
    q->in[n] = at->t.hi;
    num_tape_eval(surface, q->in, g);
    memset(q->rounding, 0, 2 * (size_t)q->count * sizeof *q->rounding);
    for (int j = 0; j <= n; j++) {
        double x = q->in[j], size = fmax(fabs(x), fabs(j < n ? near->series[n + j].hi : near->scale)), step = 1e-6 * fmax(size, 1e-290);
        double allowed = j < n ? m->scale[j] : 0;
        q->in[j] = x + step;
        num_tape_eval(surface, q->in, moved);
        q->in[j] = x;
        for (int e = 0; e < q->count; e++) {
            double slope = fabs(moved[e] - g[e]) / step, noise = ROUNDINGS * NUM_DD_EPSILON * slope * size;
            if (!isfinite(slope))
                continue;
            q->rounding[e] += noise;
            q->doubt[e] += noise + slope * allowed;
        }
    }
}

static const num_dd *argument(const struct expansions *w, const struct expansion *q, int e)
{
    return q->argument + (size_t)e * (size_t)w->order;
}

/* Up to which s, at most far, the argument's last terms are as small against it as the state's against that. */
static double argument_far(const struct expansions *w, const struct precise_march *m, const num_dd *g, double far)
{
    enum { TURNS = 60 };
    for (int turn = 0; turn < TURNS; turn++) {
        double last[3], most = 0, power = 1;
        for (int k = 0; k < w->order; k++, power *= far)
            most = fmax(most, fabs(g[k].hi) * power);
        for (int i = 0; i < 3; i++)
            last[i] = fabs(g[w->order - 1 - i].hi) / fmax(fmax(m->rtol, NUM_DD_EPSILON) * most, 1e-300);
        double s = precise_terms(last, w->order - 1);
        if (!(s < far))
            break;
        far = s;
    }
    return far;
}

/* w->part: the argument over s / far. Returns the sum of the coefficients' sizes. */
static double spread(struct expansions *w, const num_dd *g, double far)
{
    double power = 1, sum = 0;
    for (int k = 0; k < w->order; k++, power *= far) {
        w->part[k] = num_dd_mul_d(g[k], power);
        sum += fabs(w->part[k].hi);
    }
    return sum;
}

/* Where w->part leads to from 0 (coefficient 0 left out): 1, -1, or 0 where it does not lead away. */
static int direction(const struct expansions *w)
{
    double most = 0;
    for (int k = 1; k < w->order; k++)
        most = fmax(most, fabs(w->part[k].hi));
    for (int k = 1; k < w->order; k++)
        if (fabs(w->part[k].hi) > SMALL * most)
            return w->part[k].hi > 0 ? 1 : -1;
    return 0;
}

/* Where argument e leads to from its surface, where here lies; 0: it stays within roundings. */
static int leads_to(struct expansions *w, const struct precise_march *m, int e)
{
    const num_dd *g = argument(w, &w->here, e);
    double sum = spread(w, g, argument_far(w, m, g, 1));
    return sum - fabs(w->part[0].hi) > m->sides.rounding[e] ? direction(w) : 0;
}

/* The side of e that the motion takes from its surface, where here lies; 0: none, or both. */
static int side_taken(struct expansions *w, struct precise_march *m, int e, double size)
{
    int taken = 0;
    for (int s = -1; s <= 1; s += 2) {
        m->sides.side[e] = (signed char)s;
        hold(m);
        if (precise_expand(w, m, &m->here, &w->here, size) && leads_to(w, m, e) == s)
            taken = taken ? 2 : s;
    }
    m->sides.side[e] = 0;
    hold(m);
    return taken == 2 ? 0 : taken;
}

bool precise_take_sides(struct expansions *w, struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    double size = 0.75 * fabs(w->here.scale);      /* the scale comes out the same */
    if (!w->count)
        return true;
    memset(q->side, 0, (size_t)w->count);
    q->natural = false;
    hold(m);
    if (!precise_expand(w, m, &m->here, &w->here, size))
        return false;
    grains(m, &m->here, &w->here);
    bool *near = sga_calloc((size_t)w->count, sizeof *near), any = false;
    for (int e = 0; e < w->count; e++) {
        double g = argument(w, &w->here, e)[0].hi;
        near[e] = fabs(g) <= q->rounding[e];
        any |= near[e];
        q->side[e] = (signed char)(near[e] || !isfinite(g) ? 0 : g > 0 ? 1 : -1);
    }
    hold(m);
    for (int e = 0; e < w->count && any; e++)
        if (near[e])
            q->side[e] = (signed char)side_taken(w, m, e, size);
    hold(m);
    bool ok = precise_expand(w, m, &m->here, &w->here, size);
    if (!ok) {
        for (int e = 0; e < w->count; e++)
            q->side[e] = near[e] ? 0 : q->side[e];
        hold(m);
        ok = precise_expand(w, m, &m->here, &w->here, size);
    }
    free(near);
    return ok;
}

/* The argument can leave its side within far. */
static bool may_change(const struct expansions *w, int e)
{
    const num_dd *g = argument(w, &w->here, e);
    double rest = 0;
    for (int k = w->order - 1; k > 0; k--)
        rest = (rest + fabs(g[k].hi)) * w->far;
    return !(fabs(g[0].hi) > rest);
}

/* Where e leaves its side: within far, or INFINITY. */
static num_dd change_of(struct expansions *w, const struct precise_march *m, int e)
{
    int side = m->sides.side[e];
    if (spread(w, argument(w, &w->here, e), w->far) <= m->sides.rounding[e])
        return num_dd_of(INFINITY);
    if (!(side * w->part[0].hi > 0)) {             /* on the surface, or beyond by what steps err */
        if (direction(w) != side)
            return num_dd_of(0);
        w->part[0] = num_dd_of(0);
    }
    return num_dd_mul_d(num_jet2_change(w->part, w->order - 1, side, w->work), w->far);
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
    grains(m, &m->here, &w->here);
    double far = w->far;
    for (int e = 0; e < w->count; e++)
        if (q->side[e] && may_change(w, e))
            far = argument_far(w, m, argument(w, &w->here, e), far);
    w->far = far;
    m->sides.tries = 0;
    for (int e = 0; e < w->count; e++)
        if (q->side[e] && may_change(w, e))
            w->change[e] = change_of(w, m, e);
}

static double grain(const struct precise_march *m, const struct precise_point *at)
{
    return GRAIN * NUM_DD_EPSILON * fmax(fabs(at->t.hi), fabs(num_dd_sub(at->t, m->p->start).hi));
}

static void flip_pending(struct precise_march *m)
{
    for (int e = 0; e < m->sides.count; e++)
        m->sides.side[e] = (signed char)(m->sides.pending[e] ? -m->sides.side[e] : m->sides.side[e]);
    hold(m);
}

/* At there the pending switches are off their surfaces by so much time. What turning them does to the motion in that time, in
 * units of the error allowed. */
static double harm(const struct expansions *w, struct precise_march *m)
{
    double time = 0, most = 0;
    for (int e = 0; e < w->count; e++) {
        const num_dd *g = argument(w, &w->there, e);
        if (m->sides.pending[e])
            time = fmax(time, fabs(g[0].hi) <= m->sides.rounding[e] ? 0 : fabs(g[0].hi * w->there.scale) / fabs(g[1].hi));
    }
    if (!(time > grain(m, &m->there)))
        return 0;
    double *before = memcpy(sga_malloc((size_t)m->n * sizeof *before), m->fd, (size_t)m->n * sizeof *before);
    flip_pending(m);
    if (field_eval(&m->p->flow->field, m->there.t.hi, m->xd, m->fd))
        for (int j = 0; j < m->n; j++)
            most = fmax(most, fabs(m->fd[j] - before[j]) * time / m->scale[j]);
    flip_pending(m);
    memcpy(m->fd, before, (size_t)m->n * sizeof *before);
    free(before);
    return most;
}

/* The step missed the surfaces by what the arguments' series there say. */
static void correct_changes(struct expansions *w, const struct precise_march *m)
{
    for (int e = 0; e < w->count; e++) {
        const num_dd *g = argument(w, &w->there, e);
        if (m->sides.pending[e])
            w->change[e] = num_dd_sub(w->change[e], num_dd_mul_d(num_dd_div(g[0], g[1]), w->there.scale / w->here.scale));
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
        q->pending[e] = turns && w->change[e].hi <= w->far && after <= grain(m, &m->there);
        near |= q->pending[e] || (q->side[e] && !(q->side[e] * argument(w, &w->there, e)[0].hi > 0));
    }
    if (!near)
        return true;
    grains(m, &m->there, &w->there);
    for (int e = 0; e < w->count; e++)
        if (q->side[e] && !q->pending[e] && q->side[e] * argument(w, &w->there, e)[0].hi < -q->doubt[e])
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

static bool end_sliding(struct precise_march *m)
{
    precise_end(m, ODE_NOT_SMOOTH, "the field jumps where the argument of a sign changes its sign, and points there from both sides: "
                "the motion would have to slide along that surface, which the equations do not determine");
    return false;
}

/* The pending switches, all together, at here. *slides: beyond, the field leads back to one. False: there is no field. */
static bool turn_together(struct expansions *w, struct precise_march *m, double size, bool *slides)
{
    struct precise_sides *q = &m->sides;
    flip_pending(m);
    precise_set_scale(m, m->here.x);
    m->why = ODE_LEFT_DOMAIN;
    if (!precise_settle(m, &m->here) || !precise_expand(w, m, &m->here, &w->here, size))
        return false;
    grains(m, &m->here, &w->here);
    *slides = false;
    for (int e = 0; e < w->count; e++)
        *slides |= q->pending[e] && leads_to(w, m, e) == -q->side[e];
    return true;
}

static bool turn(struct expansions *w, struct precise_march *m, double size)
{
    struct precise_sides *q = &m->sides;
    bool slides, ok;
    int first = -1, all = 0;
    q->turned = fabs(num_dd_sub(m->here.t, q->turned_t).hi) <= 4 * grain(m, &m->here) ? q->turned + 1 : 0;
    q->turned_t = m->here.t;
    if (q->turned > 2 * q->count + 2)
        return end_sliding(m);
    for (int e = 0; e < q->count; e++) {
        all += q->pending[e];
        if (q->pending[e] && (first < 0 || num_dd_less(w->change[e], w->change[first])))
            first = e;
    }
    ok = turn_together(w, m, size, &slides);
    if (ok && slides && all > 1) {                 /* not all at once, then: that one alone */
        flip_pending(m);
        memset(q->pending, 0, (size_t)q->count);
        q->pending[first] = 1;
        ok = turn_together(w, m, size, &slides);
    }
    memset(q->pending, 0, (size_t)q->count);
    if (ok)
        return !slides || end_sliding(m);
    precise_end(m, m->why, m->why == ODE_CONSTRAINT_LOST ? "the constraints jump here: no point near the solution satisfies those beyond this time"
                           : m->why == ODE_SINGULAR ? "a rank drops here: the field or the constraints are singular"
                           : "the vector field has no value beyond this time");
    return false;
}

/* Switches that are not held are off their surfaces by now? */
static void wake(struct expansions *w, struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    bool any = false, woken = false;
    for (int e = 0; e < w->count; e++)
        any |= !q->side[e];
    if (any)
        grains(m, &m->here, &w->here);
    for (int e = 0; e < w->count && any; e++) {
        double g = argument(w, &w->here, e)[0].hi;
        if (!q->side[e] && isfinite(g) && fabs(g) > AWAKE * q->rounding[e]) {
            q->side[e] = g > 0 ? 1 : -1;
            woken = true;
        }
    }
    if (woken)
        hold(m);
}

/* Changes that come at once. */
bool precise_sides_settle(struct expansions *w, struct precise_march *m, double size)
{
    struct precise_sides *q = &m->sides;
    for (;;) {
        bool now = false;
        precise_look_ahead(w, m);
        for (int e = 0; e < w->count; e++)
            now |= q->pending[e] = w->change[e].hi * fabs(w->here.scale) <= grain(m, &m->here);
        if (!now)
            return true;
        if (!turn(w, m, size))
            return false;
    }
}

bool precise_sides_pass(struct expansions *w, struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    double size = 0.75 * fabs(w->here.scale);
    bool now = false;
    if (!w->count) {
        precise_look_ahead(w, m);
        return true;
    }
    if (q->natural) {
        if (!precise_take_sides(w, m))
            return precise_let_go(w, m, size);
    } else {
        for (int e = 0; e < w->count; e++)
            now |= q->pending[e];
        if (now && !turn(w, m, size))
            return false;
        wake(w, m);
    }
    return precise_sides_settle(w, m, size);
}

bool precise_let_go(struct expansions *w, struct precise_march *m, double size)
{
    m->sides.natural = true;
    hold(m);
    bool ok = precise_expand(w, m, &m->here, &w->here, size);
    if (ok)
        precise_look_ahead(w, m);
    else
        precise_end(m, ODE_LEFT_DOMAIN, "the vector field has no series beyond this time");
    return ok;
}
