/* Switches at a point: on which side of its surface each is held, and how it is turned there. See kink.c. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kink.h"
#include "mem.h"

#define MOVES 1.0              /* in units of the error allowed, on turning */
#define GRAIN 1e-6             /* of the error allowed in x: g is not told from 0 closer than that */

void kinks_values(struct ode_march *m, double t, const double *x, double *g)
{
    m->p->switching(m->p->ctx, t, x, g);
}

static double value(struct ode_march *m, int e, double t, const double *x)
{
    kinks_values(m, t, x, m->kinks->table.g);
    return m->kinks->table.g[e];
}

void kinks_grains(struct ode_march *m, double t, const double *x)
{
    struct ode_kinks *k = m->kinks;
    double *g = k->old, *moved = k->table.g, dt = 16 * DBL_EPSILON * fmax(fabs(t), fabs(m->start->t));
    kinks_values(m, t, x, g);
    memset(k->least, 0, 2 * (size_t)k->count * sizeof *k->least);      /* and doubt */
    memcpy(k->x, x, (size_t)m->p->n * sizeof *x);
    for (int j = 0; j <= m->p->n; j++) {      /* the last one: time */
        double allowed = j < m->p->n ? ode_allowed(m->o->rtol, m->o->atol, m->unit[j], x[j], x[j]) : 0, move = 0;
        if (j < m->p->n)
            k->x[j] = x[j] + (move = fmax(16 * DBL_EPSILON * fabs(x[j]), GRAIN * allowed));
        kinks_values(m, j < m->p->n ? t : t + dt, k->x, moved);
        for (int e = 0; e < k->count; e++) {
            double change = fabs(moved[e] - g[e]);
            change = isfinite(change) ? change : 0;
            k->least[e] += change;
            k->doubt[e] += move > 0 ? change * fmax(1, allowed / move) : change;
        }
        if (j < m->p->n)
            k->x[j] = x[j];
    }
}

/* By how much g changes over the time d from the present point with the field f there; by two stages
 * (`curved`), or straight on. Not a number where that has no value. */
static double change_ahead(struct ode_march *m, int e, const double *f, double d, bool curved)
{
    struct ode_kinks *k = m->kinks;
    double g = value(m, e, m->t, m->x);
    const double *v = f;
    for (int j = 0; curved && j < m->p->n; j++)
        k->x[j] = m->x[j] + 0.5 * d * f[j];
    if (curved && !ode_eval(&m->field, m->t + 0.5 * d, k->x, k->mid))
        return NAN;
    v = curved ? k->mid : f;
    for (int j = 0; j < m->p->n; j++)
        k->x[j] = m->x[j] + d * v[j];
    return value(m, e, m->t + d, k->x) - g;
}

/* The present point lies on the surface of e: the side that the motion takes, 0 where there is none or both. */
static int side_taken(struct ode_march *m, int e, double d, double least)
{
    struct ode_kinks *k = m->kinks;
    int taken = 0;
    for (int s = -1; s <= 1; s += 2) {
        k->side[e] = (signed char)s;
        kinks_hold(m);
        double change = ode_eval(&m->field, m->t, m->x, k->f) ? change_ahead(m, e, k->f, d, true) : NAN;
        if (s * change > least)
            taken = taken ? 2 : s;
    }
    k->side[e] = 0;
    kinks_hold(m);
    return taken == 2 ? 0 : taken;
}

/* Values and rates at the present point. */
static void look(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    double d = 1e-3 * k->scale * m->direction;
    kinks_values(m, m->t, m->x, k->g);
    for (int j = 0; j < m->p->n; j++)
        k->x[j] = m->x[j] + d * m->f[j];
    kinks_values(m, m->t + d, k->x, k->rate);
    for (int e = 0; e < k->count; e++)
        k->rate[e] = (k->rate[e] - k->g[e]) / d;
}

void kinks_set_scale(struct ode_march *m, double h)
{
    struct ode_kinks *k = m->kinks;
    double since = fabs(m->t - k->turned_t);
    if (since > 0 || !(k->scale > 0))
        k->scale = since > 0 ? fmin(h, since) : h;
}

static bool end_sliding(struct ode_march *m)
{
    ode_end_at(m, ODE_NOT_SMOOTH, ode_slides);
    return false;
}

/* On the constraints of other sides a point near the surface may lie a little elsewhere, which steps would take for a loss of the
 * constraints; where they jump, algebraic variables are solved for anew. Where neither is possible x stays: false. */
static bool put_on_set(struct ode_march *m, double t, double *x)
{
    double residual, *old;
    if (!m->p->project)
        return true;
    old = sga_malloc(((size_t)m->p->n + 1) * sizeof *old);
    sga_copy(old, x, m->p->n);
    bool ok = ode_settle(m, t, x, MOVES, &residual);
    if (!ok) {
        sga_copy(x, old, m->p->n);
        ok = m->p->jump && m->p->jump(m->p->ctx, t, x) && ode_settle(m, t, x, MOVES, &residual);     /* what was given holds there too */
        if (!ok)
            sga_copy(x, old, m->p->n);
    }
    free(old);
    return ok;
}

/* Whether the argument of e jumps to where it is now, off its surface. */
static bool leaps(const struct ode_kinks *k, int e, double was, double now)
{
    return fabs(now) > k->doubt[e] && fabs(now - was) > 0.5 * fabs(now);
}

bool kinks_carry(struct ode_march *m, double t, double *x, double *g, bool *on_set)
{
    struct ode_kinks *k = m->kinks;
    for (int round = 0; round <= 2 * k->count + 2; round++) {
        int turned = 0;
        kinks_hold(m);
        *on_set = put_on_set(m, t, x);
        kinks_values(m, t, x, k->g1);
        for (int e = 0; e < k->count; e++) {
            bool turns = leaps(k, e, g[e], k->g1[e]) && k->side[e] * k->g1[e] < 0;
            g[e] = k->g1[e];
            k->side[e] = (signed char)(turns ? -k->side[e] : k->side[e]);
            turned += turns;
        }
        if (!turned)
            return true;
    }
    return false;
}

/* The field at the present point, by the sides that are held now. False: it has no value. */
static bool evaluate(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    kinks_hold(m);
    sga_copy(k->mid, m->x, m->p->n);
    put_on_set(m, m->t, m->x);
    for (int j = 0; m->p->project && j < m->p->n; j++)
        m->carry[j] = m->x[j] == k->mid[j] ? m->carry[j] : 0;
    return ode_eval(&m->field, m->t, m->x, m->f);
}

/* The present field after switches were turned; dropped: what is held on a side without values here. False: it has none. */
static bool evaluate_turned(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    if (evaluate(m))
        return true;
    for (int e = 0; e < k->count; e++)
        k->side[e] = k->pending[e] ? 0 : k->side[e];
    if (evaluate(m))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

/* After some were turned, and the field evaluated: what that turns. k->g: what the arguments were. False: the motion ends. */
static bool carry_through(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    signed char *before = memcpy(sga_malloc((size_t)k->count + 1), k->side, (size_t)k->count);
    bool on_set, ok = kinks_carry(m, m->t, m->x, k->g, &on_set);
    for (int e = 0; e < k->count; e++) {
        bool turned = k->side[e] != before[e];
        k->fresh[e] = turned ? 0 : k->fresh[e];
        m->res->stats.kinks += turned;
    }
    free(before);
    if (!ok) {
        ode_end_at(m, ODE_NOT_SMOOTH, ode_no_sides);
        return false;
    }
    if (evaluate(m))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

bool kinks_take_sides(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    memset(k->side, 0, (size_t)k->count);
    k->limit = k->short_h = 0;
    k->natural = false;
    kinks_hold(m);
    kinks_grains(m, m->t, m->x);
    bool jumps = false;
    for (int e = 0; e < k->count; e++) {
        double g = value(m, e, m->t, m->x), least = k->least[e];
        k->fresh[e] = !(fabs(g) > least);
        k->side[e] = (signed char)(!isfinite(g) ? 0 : k->fresh[e] ? side_taken(m, e, PROBE * k->scale * m->direction, least) : g > 0 ? 1 : -1);
        jumps |= k->fresh[e] && k->side[e] && m->p->jump;
        k->g[e] = g;
        kinks_hold(m);
    }
    if (!(jumps ? evaluate(m) && carry_through(m) : ode_eval(&m->field, m->t, m->x, m->f))) {      /* a side without values at its edge */
        for (int e = 0; e < k->count; e++)
            k->side[e] = k->fresh[e] ? 0 : k->side[e];
        kinks_hold(m);
        if (!ode_eval(&m->field, m->t, m->x, m->f))
            return false;
    }
    look(m);
    return true;
}

/* Variables that are derivatives of others jump where those turn. False: the motion ends. */
static bool jump_derivatives(struct ode_march *m, const double *from, const double *before)
{
    struct ode_kinks *k = m->kinks;
    sga_copy(k->mid, m->x, m->p->n);
    bool ok = m->p->turned(m->p->ctx, m->t, from, before, k->led, m->x);
    for (int j = 0; j < m->p->n; j++)
        m->carry[j] = m->x[j] == k->mid[j] ? m->carry[j] : 0;
    if (ok && ode_eval(&m->field, m->t, m->x, m->f))
        return true;
    ode_end_at(m, ODE_NOT_SMOOTH, "the motion has no derivative by what is asked for beyond this time: it touches the surface where the equations change, or comes to several "
               "at once");
    return false;
}

/* kinks_turn's, where some variables are derivatives of others. */
static bool turn_with_derivatives(struct ode_march *m, bool (*turn)(struct ode_march *m))
{
    size_t n = (size_t)m->p->n;
    double *from = sga_malloc((2 * n + 1) * sizeof *from), *before = from + n;
    sga_copy(from, m->x, m->p->n);
    sga_copy(before, m->f, m->p->n);
    bool ok = turn(m) && jump_derivatives(m, from, before);
    free(from);
    return ok;
}

/* The pending switches, at the present point, which is on their surfaces, all together. slides: the field before led
 * to one of these, and the one beyond leads back to it. False: the motion ends. */
static bool turn_together(struct ode_march *m, bool *slides)
{
    struct ode_kinks *k = m->kinks;
    double d = PROBE * k->scale * m->direction;
    kinks_grains(m, m->t, m->x);
    for (int e = 0; e < k->count; e++)
        k->old[e] = k->pending[e] ? change_ahead(m, e, m->f, d, false) : 0;
    for (int e = 0; e < k->count; e++)
        k->side[e] = (signed char)(k->pending[e] ? -k->side[e] : k->side[e]);
    memcpy(k->was, k->g, (size_t)k->count * sizeof *k->g);
    if (!evaluate_turned(m) || !carry_through(m))
        return false;
    *slides = false;
    for (int e = 0; e < k->count; e++) {
        if (!k->pending[e] || !k->side[e] || leaps(k, e, k->was[e], k->g[e]))      /* from the surface (a relay with hysteresis): it is far from it now */
            continue;
        double least = k->least[e], new = change_ahead(m, e, m->f, d, false);
        *slides |= k->side[e] * k->old[e] > least && k->side[e] * new < -least;
    }
    return true;
}

/* Other switches have their surfaces here too (arguments x and 2x). */
static void join(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    double near = 1e-12 * k->scale + 64 * DBL_EPSILON * fabs(m->t), d = 1e-3 * k->scale * m->direction;
    kinks_values(m, m->t, m->x, k->g);
    for (int j = 0; j < m->p->n; j++)
        k->x[j] = m->x[j] + d * m->f[j];
    kinks_values(m, m->t + d, k->x, k->rate);
    for (int e = 0; e < k->count; e++) {
        double s = k->side[e], speed = -s * (k->rate[e] - k->g[e]) / fabs(d);
        k->pending[e] |= s != 0 && !k->fresh[e] && speed > 0 && fabs(k->g[e]) <= near * speed;
    }
}

/* The pending ones; where the motion would slide then, not all at once, but the first alone. */
static bool turn_some(struct ode_march *m, int first, bool *slides)
{
    struct ode_kinks *k = m->kinks;
    size_t n = (size_t)m->p->n, c = (size_t)k->count;
    double *x = memcpy(sga_malloc((n + 1) * sizeof *x), m->x, n * sizeof *x);
    signed char *side = memcpy(sga_malloc(c + 1), k->side, c);
    bool ok = turn_together(m, slides);
    if (ok && *slides) {
        memcpy(k->side, side, c);
        memcpy(m->x, x, n * sizeof *x);
        memset(k->pending, 0, c);
        ok = evaluate(m) || end_sliding(m);
        if (ok) {
            join(m);
            memset(k->pending, 0, c);
            k->pending[first] = TURN;
            ok = turn_together(m, slides);
        }
    }
    free(x);
    free(side);
    return ok;
}

static bool turn_pending(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    bool slides = false;
    int first = 0, all = 0;
    k->turned = m->t == k->turned_t ? k->turned + 1 : 0;
    k->turned_t = m->t;
    if (k->turned > 2 * k->count + 2)
        return end_sliding(m);
    while (first < k->count && !k->pending[first])
        first++;
    assert(first < k->count);       /* who asks for a turn says of what */
    join(m);
    for (int e = 0; e < k->count; e++)
        all += k->pending[e];
    k->limit = k->short_h = 0;
    if (m->method->forget)
        m->method->forget(m->state);
    if (all > 1 ? !turn_some(m, first, &slides) : !turn_together(m, &slides))
        return false;
    for (int e = 0; e < k->count; e++) {
        m->res->stats.kinks += k->pending[e];
        k->fresh[e] |= k->pending[e];
    }
    memcpy(k->led, k->pending, (size_t)k->count);
    memset(k->pending, 0, (size_t)k->count);
    if (slides)
        return end_sliding(m);
    m->piece = fabs(ode_goal(m) - m->t);      /* as beyond a break: solutions that are compared take other steps from here on */
    look(m);
    return true;
}

bool kinks_turn(struct ode_march *m)
{
    bool ok = m->p->turned ? turn_with_derivatives(m, turn_pending) : turn_pending(m);
    if (ok && m->p->taken)            /* what was told of the way is so on the sides beyond */
        m->p->taken(m->p->ctx, m->t, m->x);
    return ok;
}

/* Whether the argument of e is 0 and stays so by the field on either side: no side is the motion's. */
static bool stays_on(struct ode_march *m, int e)
{
    struct ode_kinks *k = m->kinks;
    signed char side = k->side[e];
    bool stays = fabs(k->g[e]) <= k->least[e];
    for (int s = -1; s <= 1 && stays; s += 2) {
        k->side[e] = (signed char)s;
        kinks_hold(m);
        stays = ode_eval(&m->field, m->t, m->x, k->f) && fabs(change_ahead(m, e, k->f, PROBE * k->scale * m->direction, true)) <= k->least[e];
    }
    k->side[e] = side;
    kinks_hold(m);
    return stays;
}

/* Time passed a break, at which arguments may have jumped: k->g is what they were. False: the motion ends. */
static bool turn_jumped(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    bool rest = false;
    k->limit = k->short_h = 0;
    if (m->method->forget)
        m->method->forget(m->state);
    if (!carry_through(m))
        return false;
    for (int e = 0; e < k->count; e++) {
        k->led[e] = k->side[e] && stays_on(m, e);
        rest |= k->led[e];
    }
    for (int e = 0; e < k->count; e++)
        if (k->led[e])
            k->side[e] = (signed char)(k->fresh[e] = k->pending[e] = 0);
    if (!rest || evaluate(m))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

bool ode_kinks_enter(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    if (!k || k->natural)
        return true;
    bool any = false;
    kinks_values(m, m->t, m->x, k->rate1);
    kinks_grains(m, m->t, m->x);
    for (int e = 0; e < k->count; e++) {
        double now = k->rate1[e];
        bool jumps = leaps(k, e, k->g1[e], now);
        k->pending[e] = jumps ? 0 : k->pending[e];      /* where it is now is off its surface */
        any |= k->side[e] && ((jumps && k->side[e] * now < 0) || fabs(now) <= k->least[e]);
        k->g[e] = k->g1[e];
    }
    if (!any)
        return true;
    bool ok = m->p->turned ? turn_with_derivatives(m, turn_jumped) : turn_jumped(m);
    if (ok && m->p->taken)
        m->p->taken(m->p->ctx, m->t, m->x);
    return ok;
}

void ode_kinks_look(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    if (!k || k->natural)
        return;
    look(m);
    memcpy(k->g1, k->g, (size_t)k->count * sizeof *k->g);
    memcpy(k->rate1, k->rate, (size_t)k->count * sizeof *k->rate);
}

bool kinks_left(struct ode_march *m, int e)
{
    struct ode_kinks *k = m->kinks;
    double g = k->g[e];
    if (k->pending[e] || !(k->fresh[e] || !k->side[e]) || !isfinite(g) || !(fabs(g) > (k->side[e] ? k->least[e] : k->doubt[e])))
        return true;
    if (k->side[e]) {
        k->fresh[e] = !(g * k->side[e] > 0);
        return true;
    }
    k->fresh[e] = false;
    k->side[e] = g > 0 ? 1 : -1;
    if (evaluate(m))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

bool kinks_let_go(struct ode_march *m, int e)
{
    struct ode_kinks *k = m->kinks;
    k->limit = k->short_h = 0;
    k->side[e] = 0;
    k->fresh[e] = k->pending[e] = 0;
    if (evaluate(m))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}
