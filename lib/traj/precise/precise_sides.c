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
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "field.h"
#include "flow.h"
#include "jacobian.h"
#include "jet.h"
#include "manifold.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "precise_series.h"
#include "precise_turn.h"
#include "switches.h"
#include "tape.h"

#define AWAKE 1e4              /* roundings: a switch that was not held is off its surface */
#define OFF_HARM 0.5           /* of the error allowed: what leaving a surface without a step may do */

void precise_sides_begin(struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    size_t c = (size_t)(q->count = m->p->flow->field->switches->count);
    if (!c)
        return;
    q->side = sga_calloc(2 * c, 1);
    q->pending = (unsigned char *)q->side + c;
    q->slopes = num_jacobian_new(m->p->flow->surface, NULL, 0);
    q->rounding = sga_calloc(2 * c + (size_t)m->n + 1 + (size_t)q->slopes->nnz, sizeof *q->rounding);
    q->doubt = q->rounding + c;
    q->in = q->doubt + c;
    q->slope = q->in + m->n + 1;
    q->surface = num_jet2_new(m->p->flow->surface, 0);
    q->argument = sga_calloc(c, sizeof *q->argument);
}

void precise_hold(struct precise_march *m)
{
    struct precise *p = m->p;
    const signed char *side = m->sides.natural ? NULL : m->sides.side;
    flow_hold(p->flow, side);
    num_tape_hold(p->field, side);
    if (m->sides.slopes)
        num_jacobian_hold(m->sides.slopes, side);
    if (p->series)
        num_jet2_hold(p->series, p->field);
    if (p->values)
        num_jet2_hold(p->values, p->flow->field->plain);
    num_jet2_hold(p->constraint, p->flow->manifold->tape);
    if (p->velocity)
        num_jet2_hold(p->velocity, p->flow->field->plain);
}

void precise_flip_pending(struct precise_march *m)
{
    for (int e = 0; e < m->sides.count; e++)
        m->sides.side[e] = (signed char)(m->sides.pending[e] ? -m->sides.side[e] : m->sides.side[e]);
    precise_hold(m);
}

void precise_sides_end(struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    if (!q->count)
        return;
    m->path->held = sga_calloc((size_t)q->count + 1, 1);
    if (!q->natural)
        memcpy(m->path->held, q->side, (size_t)q->count);
    q->natural = true;
    precise_hold(m);
    num_jet2_free(q->surface);
    num_jacobian_free(q->slopes);
    free(q->argument);
    free(q->side);
    free(q->rounding);
}

/* Where argument e leads to from its surface, where here lies; 0: it stays within roundings. */
static int leads_to(struct expansions *w, const struct precise_march *m, int e)
{
    const num_dd *g = precise_argument(w, &w->here, e);
    double sum = precise_spread(w, g, precise_argument_far(w, m, g, 1));
    return sum - fabs(w->part[0].hi) > m->sides.rounding[e] ? precise_direction(w) : 0;
}

/* The side of e that the motion takes from its surface, where here lies; 0: none, or both. */
static int side_taken(struct expansions *w, struct precise_march *m, int e, double size)
{
    int taken = 0;
    for (int s = -1; s <= 1; s += 2) {
        m->sides.side[e] = (signed char)s;
        precise_hold(m);
        if (precise_expand(w, m, &m->here, &w->here, size) && leads_to(w, m, e) == s)
            taken = taken ? 2 : s;
    }
    m->sides.side[e] = 0;
    precise_hold(m);
    return taken == 2 ? 0 : taken;
}

/* What is past its surface where these hold: the root of what is near is 0 with it, and others depend on both. */
static void hold_past(struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    bool more = true;
    for (int k = 0; k < q->count && more; k++) {
        more = false;
        precise_note_arguments(m);
        for (int e = 0; e < q->count; e++) {
            double g = q->argument[e].hi;
            bool past = q->side[e] && fabs(g) > q->rounding[e] && g * q->side[e] < 0;
            q->side[e] = (signed char)(past ? -q->side[e] : q->side[e]);
            more |= past;
        }
        precise_hold(m);
    }
}

/* The switches that were near, by their arguments at here. False: all are where they were. */
static bool hold_where(struct precise_march *m, const bool *near)
{
    struct precise_sides *q = &m->sides;
    bool any = false;
    for (int e = 0; e < q->count; e++)
        q->side[e] = (signed char)(near[e] ? 0 : q->side[e]);
    precise_hold(m);
    precise_note_arguments(m);
    for (int e = 0; e < q->count; e++) {
        double g = q->argument[e].hi;
        q->side[e] = (signed char)(!near[e] || !(fabs(g) > q->rounding[e]) ? q->side[e] : g > 0 ? 1 : -1);
        any |= near[e] && q->side[e];
    }
    precise_hold(m);
    if (any)
        hold_past(m);
    return any;
}

/* On the sides beyond the field has no series on the surface, and has them beside it (sqrt(max(0, u)), as u grows from 0): here is moved on by as little as finds one, and by no
 * more than does no harm. near: switches on whose surfaces here lies, to be held where that leads to; NULL: their sides are known. False: there is none so near, and here is as it was. */
static bool step_off(struct expansions *w, struct precise_march *m, const bool *near, double size)
{
    static const double FURTHER = 16, FIRST = 1e8;        /* roundings: steps from there are not the shortest yet */
    struct precise_point *q = &m->here;
    size_t n = (size_t)m->n;
    num_dd t = q->t, *x = memcpy(sga_malloc((n + 1) * sizeof *x), q->x, n * sizeof *x);
    double most = fabs(precise_rest(m).hi), way = FIRST * fmax(precise_grain(m, q), NUM_DD_EPSILON * size), harm = 0, *f = sga_calloc(n + 1, sizeof *f);
    bool ok = false;
    for (size_t j = 0; j < n; j++)
        m->xd[j] = x[j].hi;
    if (!field_eval(m->p->flow->field, t.hi, m->xd, f)) {        /* as from the side that the motion has come on */
        precise_flip_pending(m);
        field_eval(m->p->flow->field, t.hi, m->xd, f);
        precise_flip_pending(m);
    }
    for (; !ok && harm <= OFF_HARM && way < most; way *= FURTHER) {
        q->t = num_dd_add_d(t, way * m->direction);
        for (size_t j = 0; j < n; j++)
            q->x[j] = num_dd_add_d(x[j], isfinite(f[j]) ? way * m->direction * f[j] : 0);
        if (near && !hold_where(m, near))
            break;
        if (!near)
            hold_past(m);
        ok = precise_settle(m, q) && precise_expand(w, m, q, &w->here, way);
        harm = 0;
        for (size_t j = 0; j < n && ok; j++)
            harm = fmax(harm, way * fabs(w->here.series[n + j].hi / w->here.scale - (isfinite(f[j]) ? f[j] : 0)) / m->scale[j]);
        ok = ok && harm <= OFF_HARM;
    }
    if (!ok) {
        q->t = t;
        memcpy(q->x, x, n * sizeof *x);
        m->why = ODE_LEFT_DOMAIN;
    } else {
        field_keep_sides(m->p->flow->field, q->t.hi, m->xd);
    }
    free(x);
    free(f);
    return ok;
}

bool precise_take_sides(struct expansions *w, struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    double size = 0.75 * fabs(w->here.scale);      /* the scale comes out the same */
    if (!w->count)
        return true;
    memset(q->side, 0, (size_t)w->count);
    q->natural = false;
    precise_hold(m);
    precise_expand(w, m, &m->here, &w->here, size);      /* may have no value, where one of the sides has one beside it */
    precise_grains(m, &m->here, &w->here);
    precise_note_arguments(m);
    SGA_FREED bool *near = sga_calloc((size_t)w->count, sizeof *near);
    bool any = false;
    for (int e = 0; e < w->count; e++) {
        double g = q->argument[e].hi;
        near[e] = fabs(g) <= q->rounding[e];
        any |= near[e];
        q->side[e] = (signed char)(near[e] || !isfinite(g) ? 0 : g > 0 ? 1 : -1);
    }
    precise_hold(m);
    for (int e = 0; e < w->count && any; e++)
        if (near[e])
            q->side[e] = (signed char)side_taken(w, m, e, size);
    precise_hold(m);
    if (any) {       /* the start lies on a surface, where constraints may jump */
        precise_set_scale(m, m->here.x);
        if (!precise_carry(m, &w->here) && m->why == ODE_NOT_SMOOTH) {
            precise_end(m, m->why, ode_no_sides);
            return false;
        }
    }
    bool ok = precise_expand(w, m, &m->here, &w->here, size), leaves = any && !ok;
    for (int e = 0; e < w->count && ok; e++)
        leaves |= near[e] && !q->side[e] && leads_to(w, m, e) != 0;      /* by what holds on the surface alone, and on none of its sides */
    if (!leaves || m->p->turn)
        return ok;
    if (step_off(w, m, near, size))
        return true;
    for (int e = 0; e < w->count; e++)
        q->side[e] = near[e] ? 0 : q->side[e];
    precise_hold(m);
    return precise_expand(w, m, &m->here, &w->here, size);
}

static bool end_sliding(struct precise_march *m)
{
    precise_end(m, ODE_NOT_SMOOTH, ode_slides);
    return false;
}

/* The pending switches, all together, at here. *slides: beyond, the field leads back to one. False: there is no field. */
static bool turn_together(struct expansions *w, struct precise_march *m, double size, bool *slides)
{
    struct precise_sides *q = &m->sides;
    m->why = ODE_LEFT_DOMAIN;
    if (m->p->turn && !precise_turn_from(m))
        return false;
    precise_set_scale(m, m->here.x);
    precise_grains(m, &m->here, &w->here);
    precise_note_arguments(m);
    SGA_FREED num_dd *was = memcpy(sga_malloc(((size_t)q->count + 1) * sizeof *was), q->argument, (size_t)q->count * sizeof *was);
    SGA_FREED bool *leapt = sga_calloc((size_t)q->count + 1, sizeof *leapt);
    precise_flip_pending(m);
    if (!(m->p->turn ? precise_turn_to(m, &w->here) : precise_carry(m, &w->here)))
        return false;
    m->why = ODE_LEFT_DOMAIN;
    for (int e = 0; e < w->count; e++)
        leapt[e] = precise_leaps(q, e, was[e]);      /* from the surface (a relay with hysteresis): it is far from it now */
    if (!precise_expand(w, m, &m->here, &w->here, size))
        return false;
    precise_grains(m, &m->here, &w->here);
    *slides = false;
    for (int e = 0; e < w->count; e++)
        *slides |= q->pending[e] && !leapt[e] && leads_to(w, m, e) == -q->side[e];
    return true;
}

/* Here lies off the surface of e by what steps may be off it: beyond, what is nearly 0 there may count (the constraint v = 1000 |x|, whose v is allowed far less where it is 0). By the
 * series at here it comes onto it. */
static void close_in(const struct expansions *w, struct precise_march *m, int e)
{
    enum { TERMS = 3 };
    static const double NEAR = 1e-8;           /* of the scale: three terms have all digits */
    const num_dd *g = precise_argument(w, &w->here, e);
    double slope = g[1].hi;
    num_dd s = num_dd_neg(num_dd_mul_d(g[0], 1 / slope));
    bool ok = slope != 0 && fabs(s.hi) <= NEAR && fabs(s.hi) > 0;
    for (int k = 1; k <= TERMS && ok; k++)
        for (int j = 0; j < m->n && ok; j++)
            ok = isfinite(w->here.series[(size_t)k * (size_t)m->n + (size_t)j].hi);
    for (int j = 0; j < m->n && ok; j++) {
        num_dd sum = num_dd_of(0);
        for (int k = TERMS; k > 0; k--)
            sum = num_dd_mul(num_dd_add(sum, w->here.series[(size_t)k * (size_t)m->n + (size_t)j]), s);
        m->here.x[j] = num_dd_add(m->here.x[j], sum);
    }
    if (!ok)
        return;
    m->here.t = num_dd_add(m->here.t, num_dd_mul_d(s, w->here.scale));
    for (int j = 0; j < m->n; j++)
        m->xd[j] = m->here.x[j].hi;
    field_keep_sides(m->p->flow->field, m->here.t.hi, m->xd);
}

static bool turn(struct expansions *w, struct precise_march *m, double size)
{
    struct precise_sides *q = &m->sides;
    bool slides, ok;
    int first = -1, all = 0;
    q->turned = fabs(num_dd_sub(m->here.t, q->turned_t).hi) <= 4 * precise_grain(m, &m->here) ? q->turned + 1 : 0;
    q->turned_t = m->here.t;
    if (q->turned > 2 * q->count + 2)
        return end_sliding(m);
    for (int e = 0; e < q->count; e++) {
        all += q->pending[e];
        if (q->pending[e] && (first < 0 || num_dd_less(w->change[e], w->change[first])))
            first = e;
    }
    assert(first >= 0);       /* who asks for a turn says of what */
    close_in(w, m, first);
    SGA_FREED signed char *side = memcpy(sga_malloc((size_t)q->count + 1), q->side, (size_t)q->count);
    SGA_FREED num_dd *x = memcpy(sga_malloc(((size_t)m->n + 1) * sizeof *x), m->here.x, (size_t)m->n * sizeof *x);
    ok = turn_together(w, m, size, &slides);
    if (ok && slides && all > 1) {                 /* not all at once, then: that one alone */
        memcpy(q->side, side, (size_t)q->count);
        memcpy(m->here.x, x, (size_t)m->n * sizeof *x);
        precise_hold(m);
        memset(q->pending, 0, (size_t)q->count);
        q->pending[first] = 1;
        ok = turn_together(w, m, size, &slides);
    }
    bool off = !ok && m->why == ODE_LEFT_DOMAIN && !m->p->turn && step_off(w, m, NULL, size);
    memset(q->pending, 0, (size_t)q->count);
    if (ok || off)
        return off || !slides || end_sliding(m);
    precise_end(m, m->why, m->why == ODE_NOT_SMOOTH && !m->p->turn ? ode_no_sides
                           : m->why == ODE_NOT_SMOOTH ? "the motion has no derivative by what is asked for beyond this time: it touches the surface where the equations change, or comes to several at once"
                           : m->why == ODE_CONSTRAINT_LOST ? "the constraints jump here: no point near the solution satisfies those beyond this time"
                           : m->why == ODE_SINGULAR ? "a rank drops here: the field or the constraints are singular"
                           : "the vector field has no value beyond this time");
    return false;
}

bool precise_sides_cross(struct precise_march *m, double size)
{
    static const double NEXT = 8;          /* steps */
    struct precise_sides *q = &m->sides;
    if (!q->count || q->natural || m->method != &precise_series || m->p->turn)
        return false;
    struct expansions *w = m->state;
    SGA_FREED bool *near = sga_calloc((size_t)q->count, sizeof *near);
    bool any = false;
    for (int e = 0; e < q->count; e++) {
        const num_dd *g = precise_argument(w, &w->here, e);
        double time = -g[0].hi / g[1].hi * w->here.scale * m->direction;
        any |= near[e] = !q->side[e] || (time > 0 && time < NEXT * size);
    }
    return any && step_off(w, m, near, size) && precise_sides_settle(w, m, size);
}

/* Switches that are not held are off their surfaces by now? */
static void wake(struct expansions *w, struct precise_march *m)
{
    struct precise_sides *q = &m->sides;
    bool any = false, woken = false;
    for (int e = 0; e < w->count; e++)
        any |= !q->side[e];
    if (any)
        precise_grains(m, &m->here, &w->here);
    for (int e = 0; e < w->count && any; e++) {
        double g = precise_argument(w, &w->here, e)[0].hi;
        if (!q->side[e] && isfinite(g) && fabs(g) > AWAKE * q->rounding[e]) {
            q->side[e] = g > 0 ? 1 : -1;
            woken = true;
        }
    }
    if (woken)
        precise_hold(m);
}

/* Changes that come at once. */
bool precise_sides_settle(struct expansions *w, struct precise_march *m, double size)
{
    struct precise_sides *q = &m->sides;
    for (;;) {
        bool now = false;
        precise_look_ahead(w, m);
        for (int e = 0; e < w->count; e++)
            now |= q->pending[e] = w->change[e].hi * fabs(w->here.scale) <= precise_grain(m, &m->here);
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
        if (!precise_take_sides(w, m)) {
            if (m->path->reason != ODE_NONE)
                return false;
            now = precise_let_go(w, m, size);
            if (!now)
                precise_end(m, ODE_LEFT_DOMAIN, "the vector field has no series beyond this time");
            return now;
        }
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
    if (m->p->turn)       /* a step across the surface would not see the jump */
        return false;
    m->sides.natural = true;
    precise_hold(m);
    bool ok = precise_expand(w, m, &m->here, &w->here, size);
    if (!ok) {
        m->sides.natural = false;
        precise_hold(m);
        precise_expand(w, m, &m->here, &w->here, size);
    }
    precise_look_ahead(w, m);
    return ok;
}
