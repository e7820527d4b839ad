/* Where switches turn along implicit steps in double-double.
 *
 * As along series (precise_sides.c), every switch is held on its side along a step, and a step ends where the first
 * leaves it. The argument of a switch along an implicit step is the polynomial through its values at the nodes, where
 * it has the digits of the solution inside of the step; the place where it leaves its side is found on that, then on
 * the solution itself, and the step is made anew to there. What holds beyond is asked of the series at that point,
 * which turn the switches as they do in steps of their own. (Nodes and interpolation: Hairer, Wanner, Solving Ordinary
 * Differential Equations II, IV.8; E. Eich-Soellner, C. Fuehrer, Numerical Methods in Multibody Dynamics, 6.3.) */
#include "precise_stage_sides.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "collocation.h"
#include "flow.h"
#include "jet.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "tape.h"

#define FAR_FROM_CHANGE 4.0    /* an argument stays on its side that is so many times what it changes by at the nodes */
#define EXPECTED_FALL 0.2      /* of coefficients */
#define LEAST_CUT 0.1
#define ROUNDINGS 16.0         /* the largest that is seen at some nodes is not the largest that there is */
#define SOLVED 1e-2            /* of the error allowed: what stages may still be off */
#define REFINED 4              /* times that a place is found anew on the solution */
#define NEAR 1e-6              /* of the step: a place is moved by no more there */

struct stage_sides *stage_sides_new(struct precise_march *m, int s)
{
    if (!m->sides.count)
        return NULL;
    struct stage_sides *q = sga_calloc(1, sizeof *q);
    q->w = precise_series.alloc(m);
    q->s = s;
    q->count = m->sides.count;
    q->g = sga_calloc((size_t)q->count * ((size_t)s + 1) + (size_t)s + 1 + (size_t)m->n, sizeof *q->g);
    q->part = q->g + (size_t)q->count * ((size_t)s + 1);
    q->x = q->part + s + 1;
    q->work = sga_calloc(3 * ((size_t)s + 1) + 2 * (size_t)q->count + (size_t)m->n + 1, sizeof *q->work);
    q->noise = q->work + 3 * (s + 1);
    q->rough = q->noise + q->count;
    q->in = q->rough + q->count;
    stage_sides_forget(q);
    return q;
}

void stage_sides_free(struct stage_sides *q)
{
    if (!q)
        return;
    precise_series.free(q->w);
    free(q->g);
    free(q->work);
    free(q);
}

void stage_sides_forget(struct stage_sides *q)
{
    for (int e = 0; e < q->count; e++)
        q->w->change[e] = num_dd_of(INFINITY);
}

/* By the values of their arguments; those on whose surfaces here lies are not held. */
static bool sides_by_values(struct stage_sides *q, struct precise_march *m)
{
    struct precise_sides *sides = &m->sides;
    memset(sides->side, 0, (size_t)q->count);
    sides->natural = false;
    precise_hold(m);
    precise_note_arguments(m);
    for (int e = 0; e < q->count; e++) {
        double g = sides->argument[e].hi;
        sides->side[e] = (signed char)(fabs(g) > sides->rounding[e] ? g > 0 ? 1 : -1 : 0);
    }
    precise_hold(m);
    return precise_allowed(m, &m->here);
}

bool stage_sides_begin(struct stage_sides *q, struct precise_march *m, double size)
{
    bool ok = precise_series.begin(q->w, m, size) || (m->path->reason == ODE_NONE && sides_by_values(q, m));
    stage_sides_forget(q);
    return ok;
}

num_dd stage_sides_size(struct stage_sides *q, struct precise_march *m, num_dd h)
{
    struct expansions *w = q->w;
    m->sides.heading = false;
    for (int e = 0; e < q->count; e++) {
        num_dd to = num_dd_mul_d(w->change[e], w->here.scale);
        if (isfinite(w->change[e].hi) && fabs(to.hi) < fabs(h.hi)) {
            h = to;
            m->sides.heading = true;
        }
    }
    return w->to = h;
}

/* What rounding leaves of the arguments shows in double, many times larger. */
static void take_noise(struct stage_sides *q, const struct precise_march *m, num_dd t, const num_dd *x, const num_dd *g)
{
    size_t step = (size_t)q->s + 1;
    for (int j = 0; j < m->n; j++)
        q->in[j] = x[j].hi;
    q->in[m->n] = t.hi;
    num_tape_eval(m->p->flow->surface, q->in, q->rough);
    for (int e = 0; e < q->count; e++) {
        double off = fabs(num_dd_add_d(g[(size_t)e * step], -q->rough[e]).hi) * (ROUNDINGS * NUM_DD_EPSILON / DBL_EPSILON);
        q->noise[e] = off > q->noise[e] ? off : q->noise[e];
    }
}

/* q->g: by switch, at 0 and at the nodes; q->noise. */
static bool take_arguments(struct stage_sides *q, struct precise_march *m, const struct precise_stages *st, num_dd h)
{
    size_t step = (size_t)q->s + 1;
    memset(q->noise, 0, (size_t)q->count * sizeof *q->noise);
    bool ok = precise_arguments(m, m->here.t, m->here.x, q->g, step);
    for (int i = 0; i < q->s && ok; i++) {
        for (int j = 0; j < m->n; j++)
            q->x[j] = num_dd_add(m->here.x[j], st->z[i * m->n + j]);
        num_dd t = num_dd_add(m->here.t, num_dd_mul(st->formula->c[i], h));
        ok = precise_arguments(m, t, q->x, q->g + i + 1, step);
        take_noise(q, m, t, q->x, q->g + i + 1);
    }
    for (size_t k = 0; k < (size_t)q->count * step && ok; k++)
        ok = num_dd_finite(q->g[k]);
    return ok;
}

/* The largest value at the nodes, and *moved: how far the others are from that at 0. */
static double largest(const struct stage_sides *q, const num_dd *g, double *moved)
{
    double most = fabs(g->hi);
    *moved = 0;
    for (int i = 1; i <= q->s; i++) {
        most = fmax(most, fabs(g[i].hi));
        *moved = fmax(*moved, fabs(num_dd_sub(g[i], g[0]).hi));
    }
    return most;
}

/* By how much the last coefficients of an argument exceed what is allowed of it; 1 and less: by nothing. */
static double unresolved(const struct stage_sides *q, const struct precise_march *m, const struct num_radau *f, int e, double most)
{
    const num_dd *g = q->g + (size_t)e * ((size_t)q->s + 1);
    double worst = 0, fall = EXPECTED_FALL, allowed = fmax(m->rtol, NUM_DD_EPSILON) * most + m->sides.doubt[e];
    for (int k = 0; k < NUM_RADAU_TAIL; k++, fall *= EXPECTED_FALL) {
        num_dd v = num_dd_of(0);
        for (int i = 0; i < q->s; i++)
            v = num_dd_add(v, num_dd_mul(f->tail[k * q->s + i], num_dd_sub(g[i + 1], g[0])));
        worst = fmax(worst, fall * fabs(v.hi) / allowed);
    }
    return worst;
}

/* q->part: the polynomial through the values at 0 and the nodes, by Newton's divided differences. */
static void polynomial(struct stage_sides *q, const struct num_radau *f, const num_dd *g)
{
    int s = q->s;
    num_dd *a = q->part, zero = num_dd_of(0);
    memcpy(a, g, ((size_t)s + 1) * sizeof *a);
    for (int k = 1; k <= s; k++)
        for (int i = s; i >= k; i--) {
            num_dd from = i == k ? zero : f->c[i - k - 1];
            a[i] = num_dd_div(num_dd_sub(a[i], a[i - 1]), num_dd_sub(f->c[i - 1], from));
        }
    for (int k = s - 1; k >= 0; k--) {         /* (.. (a_s (x - x_(s-1)) + a_(s-1)) ..): multiplied out */
        num_dd node = k ? f->c[k - 1] : zero;
        for (int i = k; i < s; i++)
            a[i] = num_dd_sub(a[i], num_dd_mul(node, a[i + 1]));
    }
}

static double slope_at(const struct stage_sides *q, double theta)
{
    double d = 0;
    for (int k = q->s; k > 0; k--)
        d = d * theta + k * q->part[k].hi;
    return d;
}

/* Where argument e leaves its side, on the solution. */
static num_dd refined(struct stage_sides *q, struct precise_march *m, int e, num_dd h, num_dd theta)
{
    for (int k = 0; k < REFINED; k++) {
        num_dd t = num_dd_add(m->here.t, num_dd_mul(h, theta));
        m->method->value(m->state, m, t, q->x);
        bool ok = precise_arguments(m, t, q->x, q->g, 1);      /* what was there is in q->part */
        double move = -q->g[e].hi / slope_at(q, theta.hi);
        if (!ok || !(fabs(move) <= NEAR) || !(num_dd_add_d(theta, move).hi > 0))
            break;
        theta = num_dd_add_d(theta, move);
        if (fabs(move) <= NUM_DD_EPSILON)
            break;
    }
    return theta;
}

/* Where e leaves its side in (0, 1]; INFINITY: nowhere. 0: at once. g: its values at 0 and the nodes, of which q->part is the polynomial. */
static num_dd change_of(struct stage_sides *q, const struct precise_march *m, int e, const num_dd *g)
{
    int side = m->sides.side[e], first = 1;
    double lift = 2 * fmax(fmax(m->sides.rounding[e], SOLVED * m->sides.doubt[e]), -side * g->hi);
    if (!(side * g->hi > lift)) {      /* on the surface, or beyond by what steps err: what is left of the stages there is no change */
        while (first < q->s && !(fabs(g[first].hi) > lift))
            first++;
        if (!(side * g[first].hi > 0))
            return num_dd_of(0);
        q->part[0] = num_dd_of(side * lift);
    }
    return num_jet2_change(q->part, q->s, side, q->work);
}

/* The changes along the step of h, whose arguments are in q->g. False: it is too long for one of them, or one leaves at once; *cut. */
static bool find_changes(struct stage_sides *q, struct precise_march *m, const struct num_radau *f, num_dd h, double *cut)
{
    struct expansions *w = q->w;
    size_t step = (size_t)q->s + 1;
    double worst = 0, moved, *rounding = m->sides.rounding;
    bool at_once = false;
    for (int e = 0; e < q->count; e++) {
        const num_dd *g = q->g + (size_t)e * step;
        double most = largest(q, g, &moved);
        if (m->sides.side[e] && most > rounding[e] && !(m->sides.side[e] * g->hi > FAR_FROM_CHANGE * moved))
            worst = fmax(worst, unresolved(q, m, f, e, most));
    }
    if (worst > 1) {
        *cut *= fmax(LEAST_CUT, 0.9 * pow(worst, -1.0 / (q->s + 1)));
        return false;
    }
    SGA_FREED num_dd *all = memcpy(sga_malloc((size_t)q->count * step * sizeof *all), q->g, (size_t)q->count * step * sizeof *all);
    for (int e = 0; e < q->count; e++) {
        const num_dd *g = all + (size_t)e * step;
        if (!m->sides.side[e] || !(largest(q, g, &moved) > rounding[e]) || m->sides.side[e] * g->hi > FAR_FROM_CHANGE * moved)
            continue;
        polynomial(q, f, g);
        num_dd change = change_of(q, m, e, g);
        at_once |= change.hi * fabs(h.hi) <= precise_grain(m, &m->here);
        if (isfinite(change.hi))
            w->change[e] = refined(q, m, e, h, change);
    }
    if (at_once) {
        stage_sides_forget(q);
        *cut *= 0.5;
    }
    return !at_once;
}

bool stage_sides_agree(struct stage_sides *q, struct precise_march *m, const struct precise_stages *st, num_dd h, double *cut)
{
    struct expansions *w = q->w;
    bool turns = m->sides.heading && h.hi == w->to.hi && h.lo == w->to.lo;
    memset(m->sides.pending, 0, (size_t)q->count);
    if (m->sides.natural)
        return true;
    if (!turns) {
        stage_sides_forget(q);
        w->here.scale = h.hi;
        w->far = 1;
        m->sides.tries = 0;
        if (!take_arguments(q, m, st, h)) {
            *cut *= 0.5;
            return false;
        }
        /* rates from the step itself: the point's own may be those of a fast part that has died out */
        num_dd *rate = w->there.series + m->n;
        for (int j = 0; j < m->n; j++)
            rate[j] = num_dd_sub(m->there.x[j], m->here.x[j]);
        w->there.scale = h.hi;
        precise_grains(m, &m->here, &w->there);
        for (int e = 0; e < q->count; e++) {
            m->sides.rounding[e] = fmax(m->sides.rounding[e], q->noise[e]);
            m->sides.doubt[e] = fmax(m->sides.doubt[e], q->noise[e]);
        }
        if (!find_changes(q, m, st->formula, h, cut))
            return false;
        bool any = false;
        for (int e = 0; e < q->count; e++)
            any |= isfinite(w->change[e].hi);
        if (any)
            *cut = 1;      /* the step is made anew, to the first of them */
        return !any;
    }
    *cut *= 0.5;
    if (!precise_expand(w, m, &m->there, &w->there, 2 * fabs(h.hi)))
        return false;
    return precise_sides_agree(w, m, turns, cut);
}

bool stage_sides_pass(struct stage_sides *q, struct precise_march *m, double size)
{
    struct precise_sides *sides = &m->sides;
    struct expansions *w = q->w;
    bool turning = false, look = sides->natural;
    for (int e = 0; e < q->count; e++)
        turning |= sides->pending[e];
    if (!turning) {
        look = !precise_arguments(m, m->here.t, m->here.x, q->g, 1) || look;
        for (int e = 0; e < q->count; e++)
            look |= !(sides->side[e] * q->g[e].hi > 0);      /* on the surface, or beyond by what steps err; or not held */
        if (look && !precise_expand(w, m, &m->here, &w->here, size))
            look = sides->natural;      /* no series here: the sides stay for another step */
    } else {
        struct expansion before = w->here;
        w->here = w->there;
        w->there = before;
    }
    bool ok = (!turning && !look) || precise_sides_pass(w, m);
    stage_sides_forget(q);
    return ok;
}
