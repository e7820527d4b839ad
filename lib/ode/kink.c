/* Kinks: places where a switch of the field (abs, sign, min, max) changes its branch.
 *
 * Along a step every switch is held on the side of its surface g = 0 where the motion is, so that the method sees a
 * smooth field, also in stages that lie beyond. After the step g is looked at along the step's polynomial (table.c):
 * a step that passes a surface is taken again, to end there, and the next one begins on the other side. Where both
 * fields point at the surface, the motion would slide along it, and ends. (State events; Hairer, Norsett, Wanner,
 * Solving Ordinary Differential Equations I, II.6; Filippov for the sides.)
 *
 * A switch that rests on its surface (g is 0 to rounding, and no side is the one that the motion takes, or to the
 * tolerance all along a step) is not held: it has the value that its argument says. Where a field held on one side has no values beyond (sqrt(abs(x))), steps are
 * made with nothing held, and the error control is all there is. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "march.h"
#include "mem.h"

#define GRAIN 1e-6             /* of the error allowed in x: g is not told from 0 closer than that */
#define PROBE 1e-2             /* of a step: how far ahead the sides are tried */
#define NEAR_ENOUGH 0.02       /* error allowed to a switch that is turned too early or late, in units of the step's */
#define SHORTER 0.1            /* of a step that is too long to see what the motion does at its start */
#define AT_SURFACE 1e-4        /* of the time passed, see heads_for_surface */
#define SMOOTH 1e-2            /* of the field: no jump */
#define TRIES 4                /* to end a step on the surface */
#define PARTS_FIRST 0.41       /* see ode_kink_limit */

enum { TURN = 1, REST };

struct ode_kinks {
    int count;
    signed char *side;         /* what is held; 0: nothing */
    unsigned char *fresh;      /* turned, and not yet seen off the surface */
    unsigned char *pending;    /* to be turned when the present step is committed; REST: not to be held from then on */
    double *old, *least, *doubt;     /* changes ahead, before a turn; see grains */
    double *g, *rate, *g1, *rate1;   /* at the step's ends: values, and their derivatives along the motion */
    struct ode_table table;
    double *x, *f, *mid;       /* n each */
    double cut, limit;         /* the next step is no longer than this; 0: no matter. The second until a switch is turned */
    int target, tries;         /* the switch that the step is to end at, or -1 */
    bool natural;              /* nothing is held in the present step */
    double turned_t;           /* where a switch was turned last (or the start), how many there, */
    int turned;
    double scale;              /* and a time over which the motion was the same before */
};

static void hold(struct ode_march *m)
{
    m->p->hold(m->p->ctx, m->kinks->natural ? NULL : m->kinks->side);
}

void ode_kinks_begin(struct ode_march *m)
{
    size_t c = (size_t)m->p->switches, n = (size_t)m->p->n;
    if (!c || !n)
        return;
    struct ode_kinks *k = m->kinks = sga_calloc(1, sizeof *k);
    k->count = m->p->switches;
    k->target = -1;
    k->turned_t = m->t;
    k->side = sga_calloc(3 * c, 1);
    k->fresh = (unsigned char *)k->side + c;
    k->pending = k->fresh + c;
    k->g = sga_calloc(7 * c + 3 * n, sizeof *k->g);
    k->rate = k->g + c;
    k->g1 = k->rate + c;
    k->rate1 = k->g1 + c;
    k->old = k->rate1 + c;
    k->least = k->old + c;
    k->doubt = k->least + c;
    k->x = k->doubt + c;
    k->f = k->x + n;
    k->mid = k->f + n;
    ode_table_init(&k->table, k->count, m->p->n, m->p->switching);
}

void ode_kinks_end(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    if (!k)
        return;
    m->p->hold(m->p->ctx, NULL);
    ode_table_clear(&k->table);
    free(k->side);
    free(k->g);
    free(k);
    m->kinks = NULL;
}

static void values(struct ode_march *m, double t, const double *x, double *g)
{
    m->p->switching(m->p->ctx, t, x, g);
}

static double value(struct ode_march *m, int e, double t, const double *x)
{
    values(m, t, x, m->kinks->table.g);
    return m->kinks->table.g[e];
}

/* k->least: how far from 0 roundings take each g, and errors far below the tolerance. k->doubt: errors as large as allowed. */
static void grains(struct ode_march *m, double t, const double *x)
{
    struct ode_kinks *k = m->kinks;
    double *g = k->old, *moved = k->table.g, dt = 16 * DBL_EPSILON * fmax(fabs(t), fabs(m->start->t));
    values(m, t, x, g);
    memset(k->least, 0, 2 * (size_t)k->count * sizeof *k->least);      /* and doubt */
    memcpy(k->x, x, (size_t)m->p->n * sizeof *x);
    for (int j = 0; j <= m->p->n; j++) {      /* the last one: time */
        double allowed = j < m->p->n ? ode_allowed(m->o->rtol, m->o->atol, m->unit[j], x[j], x[j]) : 0, move = 0;
        if (j < m->p->n)
            k->x[j] = x[j] + (move = fmax(16 * DBL_EPSILON * fabs(x[j]), GRAIN * allowed));
        values(m, j < m->p->n ? t : t + dt, k->x, moved);
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
        hold(m);
        double change = ode_eval(&m->field, m->t, m->x, k->f) ? change_ahead(m, e, k->f, d, true) : NAN;
        if (s * change > least)
            taken = taken ? 2 : s;
    }
    k->side[e] = 0;
    hold(m);
    return taken == 2 ? 0 : taken;
}

/* Values and rates at the present point. */
static void look(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    double d = 1e-3 * k->scale * m->direction;
    values(m, m->t, m->x, k->g);
    for (int j = 0; j < m->p->n; j++)
        k->x[j] = m->x[j] + d * m->f[j];
    values(m, m->t + d, k->x, k->rate);
    for (int e = 0; e < k->count; e++)
        k->rate[e] = (k->rate[e] - k->g[e]) / d;
}

/* The present point after a step of size h, or before the first one: how far ahead may be looked. */
static void set_scale(struct ode_march *m, double h)
{
    struct ode_kinks *k = m->kinks;
    double since = fabs(m->t - k->turned_t);
    if (since > 0 || !(k->scale > 0))
        k->scale = since > 0 ? fmin(h, since) : h;
}

/* All sides anew at the present point. False: no field there. */
static bool take_sides(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    memset(k->side, 0, (size_t)k->count);
    k->natural = false;
    hold(m);
    grains(m, m->t, m->x);
    for (int e = 0; e < k->count; e++) {
        double g = value(m, e, m->t, m->x), least = k->least[e];
        k->fresh[e] = !(fabs(g) > least);
        k->side[e] = (signed char)(!isfinite(g) ? 0 : k->fresh[e] ? side_taken(m, e, PROBE * k->scale * m->direction, least) : g > 0 ? 1 : -1);
        hold(m);
    }
    if (!ode_eval(&m->field, m->t, m->x, m->f)) {      /* a side without values at its edge */
        for (int e = 0; e < k->count; e++)
            k->side[e] = k->fresh[e] ? 0 : k->side[e];
        hold(m);
        if (!ode_eval(&m->field, m->t, m->x, m->f))
            return false;
    }
    look(m);
    return true;
}

bool ode_kinks_start(struct ode_march *m, double h)
{
    if (!m->kinks)
        return true;
    set_scale(m, h);
    if (take_sides(m))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no finite value at the start");
    return false;
}

static bool end_sliding(struct ode_march *m)
{
    ode_end_at(m, ODE_NOT_SMOOTH, "the field jumps where the argument of a sign changes its sign, and points there from both sides: "
               "the motion would have to slide along that surface, which the equations do not determine");
    return false;
}

/* The present field after switches were turned; dropped: what is held on a side without values here. False: it has none. */
static bool evaluate_turned(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    hold(m);
    if (ode_eval(&m->field, m->t, m->x, m->f))
        return true;
    for (int e = 0; e < k->count; e++)
        k->side[e] = k->pending[e] ? 0 : k->side[e];
    hold(m);
    if (ode_eval(&m->field, m->t, m->x, m->f))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

/* The pending switches, at the present point, which is on their surfaces, all together. slides: the field before led
 * to one of these, and the one beyond leads back to it. False: the motion ends. */
static bool turn_together(struct ode_march *m, bool *slides)
{
    struct ode_kinks *k = m->kinks;
    double d = PROBE * k->scale * m->direction;
    grains(m, m->t, m->x);
    for (int e = 0; e < k->count; e++)
        k->old[e] = k->pending[e] ? change_ahead(m, e, m->f, d, false) : 0;
    for (int e = 0; e < k->count; e++)
        k->side[e] = (signed char)(k->pending[e] ? -k->side[e] : k->side[e]);
    if (!evaluate_turned(m))
        return false;
    *slides = false;
    for (int e = 0; e < k->count; e++) {
        if (!k->pending[e] || !k->side[e])
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
    values(m, m->t, m->x, k->g);
    for (int j = 0; j < m->p->n; j++)
        k->x[j] = m->x[j] + d * m->f[j];
    values(m, m->t + d, k->x, k->rate);
    for (int e = 0; e < k->count; e++) {
        double s = k->side[e], speed = -s * (k->rate[e] - k->g[e]) / fabs(d);
        k->pending[e] |= s != 0 && !k->fresh[e] && speed > 0 && fabs(k->g[e]) <= near * speed;
    }
}

/* The pending switches at the present point. False: the motion ends. */
static bool turn(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    bool slides = false;
    int first = 0, all = 0;
    k->turned = m->t == k->turned_t ? k->turned + 1 : 0;
    k->turned_t = m->t;
    if (k->turned > 2 * k->count + 2)
        return end_sliding(m);
    while (!k->pending[first])
        first++;
    join(m);
    for (int e = 0; e < k->count; e++)
        all += k->pending[e];
    k->limit = 0;
    if (m->method->forget)
        m->method->forget(m->state);
    if (!turn_together(m, &slides))
        return false;
    if (slides && all > 1) {       /* not all at once, then: that one alone */
        for (int e = 0; e < k->count; e++)
            k->side[e] = (signed char)(k->pending[e] && k->side[e] ? -k->side[e] : k->side[e]);
        memset(k->pending, 0, (size_t)k->count);
        hold(m);
        if (!ode_eval(&m->field, m->t, m->x, m->f))
            return end_sliding(m);
        k->pending[first] = TURN;
        if (!turn_together(m, &slides))
            return false;
    }
    for (int e = 0; e < k->count; e++) {
        m->res->stats.kinks += k->pending[e];
        k->fresh[e] |= k->pending[e];
    }
    memset(k->pending, 0, (size_t)k->count);
    if (slides)
        return end_sliding(m);
    m->piece = fabs(ode_goal(m) - m->t);      /* as beyond a break: solutions that are compared take other steps from here on */
    look(m);
    return true;
}

/* A switch that was turned, or is not held, may be well off its surface by now. False: the motion ends. */
static bool left_surface(struct ode_march *m, int e)
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
    hold(m);
    if (ode_eval(&m->field, m->t, m->x, m->f))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

/* Switch e is not held any more. */
static bool let_go(struct ode_march *m, int e)
{
    struct ode_kinks *k = m->kinks;
    k->side[e] = 0;
    k->fresh[e] = k->pending[e] = 0;
    hold(m);
    if (ode_eval(&m->field, m->t, m->x, m->f))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
    return false;
}

bool ode_kinks_pass(struct ode_march *m, double h)
{
    struct ode_kinks *k = m->kinks;
    if (!k)
        return true;
    k->cut = 0;
    k->target = -1;
    k->tries = 0;
    set_scale(m, h);
    if (k->natural) {
        if (take_sides(m))
            return true;
        ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
        return false;
    }
    memcpy(k->g, k->g1, (size_t)k->count * sizeof *k->g);
    memcpy(k->rate, k->rate1, (size_t)k->count * sizeof *k->rate);
    bool ok = true, any = false, unsure = false;
    for (int e = 0; e < k->count; e++) {
        unsure |= k->fresh[e] || (!k->side[e] && !(fabs(k->g[e]) <= 0.5 * k->doubt[e]));
        if (k->pending[e] == REST && !let_go(m, e))
            return false;
    }
    if (unsure)
        grains(m, m->t, m->x);
    for (int e = 0; e < k->count && ok; e++) {
        ok = left_surface(m, e);
        any |= k->pending[e];
    }
    return ok && any ? turn(m) : ok;
}

double ode_kinks_cut(const struct ode_march *m, double h)
{
    const struct ode_kinks *k = m->kinks;
    if (k && k->cut > 0)
        h = fmin(h, k->cut);
    return k && k->limit > 0 ? fmin(h, k->limit) : h;
}

/* A step of size h, refused for its error, leads over a surface that is very near: the field is singular on it
 * (1/cbrt(abs(x))), and steps that may cross it have more hope than steps that end there. */
static bool heads_for_surface(const struct ode_march *m, double h)
{
    const struct ode_kinks *k = m->kinks;
    double passed = fabs(m->t - k->turned_t);
    for (int e = 0; e < k->count; e++) {
        double g = k->side[e] * k->g[e], speed = -k->side[e] * k->rate[e] * m->direction;
        if (g > 0 && g < speed * h && g < speed * AT_SURFACE * passed)
            return true;
    }
    return false;
}

bool ode_kinks_natural(struct ode_march *m, enum ode_refusal cause, double h)
{
    struct ode_kinks *k = m->kinks;
    if (!k || !(cause == FIELD_REFUSED || (cause == ERROR_TOO_LARGE && heads_for_surface(m, h))))
        return false;
    k->natural = !k->natural;
    hold(m);
    return k->natural;
}

void ode_kinks_held(struct ode_march *m)
{
    if (m->kinks && m->kinks->natural) {
        m->kinks->natural = false;
        hold(m);
    }
}

/* All surfaces are so far that no motion at the rates at both ends gets there. */
static bool far_from_all(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    double h = m->step.h, d = 1e-3 * h;
    values(m, m->t1, m->x1, k->g1);
    for (int j = 0; j < m->p->n; j++)
        k->x[j] = m->x1[j] + d * m->f1[j];
    values(m, m->t1 + d, k->x, k->rate1);
    bool far = true;
    for (int e = 0; e < k->count; e++) {
        k->rate1[e] = (k->rate1[e] - k->g1[e]) / d;
        double reach = fabs(k->g1[e] - k->g[e]) + fabs(h) * (fabs(k->rate[e]) + fabs(k->rate1[e]));
        far &= !k->side[e] || fmin(k->side[e] * k->g[e], k->side[e] * k->g1[e]) > reach;
    }
    return far;
}

/* s g has a minimum between nodes i - 1 and i + 1, where it is not below -least: does it go there in between? Where. */
static bool dips(struct ode_march *m, int e, int i, int s, double least, double *where)
{
    const double golden = 0.3819660112501051;
    struct ode_table *w = &m->kinks->table;
    size_t c = (size_t)w->count, at = (size_t)i * c + (size_t)e;
    double a = w->theta[i - 1], b = w->theta[i + 1], u = w->theta[i], gu = s * w->value[at], left = a;
    double ga = s * w->value[at - c], gb = s * w->value[at + c], p = u - a, q = b - u;
    double slope = ((gu - ga) / p * q + (gb - gu) / q * p) / (p + q), curve = ((gb - gu) / q - (gu - ga) / p) / (p + q);
    if (!(gu <= ga && gu <= gb) || !(curve > 0) || gu - slope * slope / (4 * curve) > 0.5 * gu + least)
        return false;
    for (int r = 0; r < 60 && gu >= -least && b - a > 1e-9 * (p + q); r++) {
        double v = b - u > u - a ? u + golden * (b - u) : u - golden * (u - a), gv = s * ode_table_at(m, w, v)[e];
        bool better = gv < gu;
        *(better == (v > u) ? &a : &b) = better ? u : v;
        if (better) {
            u = v;
            gu = gv;
        }
    }
    if (gu >= -least)
        return false;
    *where = ode_table_root(m, w, e, left, ga > 0 ? s * ga : s * least, u, s * gu);
    return true;
}

/* All values are on the side of switch e, none with a minimum that could be beyond. */
static bool plainly_inside(const struct ode_table *w, int e, int s)
{
    size_t c = (size_t)w->count;
    for (int i = 0; i < w->nodes; i++) {
        const double *v = w->value + (size_t)i * c + (size_t)e;
        if (!(s * *v > 0))
            return false;
        if (i > 0 && i + 1 < w->nodes && s * v[0] < s * v[-(ptrdiff_t)c] && s * v[0] <= s * v[c] &&
            s * v[0] < 2 * fmax(s * v[-(ptrdiff_t)c] - s * v[0], s * v[c] - s * v[0]))
            return false;
    }
    return true;
}

/* The first place in the step where switch e leaves its side; 2: none; -1: the step is too long to tell. */
static double crossing(struct ode_march *m, int e)
{
    struct ode_kinks *k = m->kinks;
    struct ode_table *w = &k->table;
    int s = k->side[e], last = -1;
    bool armed = !k->fresh[e];
    double where, least = k->least[e], first = s * w->value[e];
    for (int i = 0; i < w->nodes && s; i++) {
        double v = s * w->value[(size_t)i * (size_t)w->count + (size_t)e];
        if (!isfinite(v)) {
            last = -1;
            continue;
        }
        if (armed && v < -least) {
            if (last < 0)
                return w->theta[i];
            double u = s * w->value[(size_t)last * (size_t)w->count + (size_t)e];
            return ode_table_root(m, w, e, w->theta[last], s * u, w->theta[i], s * v);
        }
        if (armed && i > 0 && i + 1 < w->nodes && dips(m, e, i, s, least, &where))
            return where;
        armed |= v > least;
        last = v > 0 ? i : last;
    }
    double v = s * w->value[(size_t)(w->nodes - 1) * (size_t)w->count + (size_t)e];
    if (armed || v >= -10 * fmax(least, fabs(first)))
        return 2;
    return s * k->rate[e] * m->direction > 0 ? -1 : 0;
}

/* The step ends `rest` (of time) from the surface of e. What turning the switch there instead of on it does to the
 * motion, in units of the error allowed. */
static double harm(struct ode_march *m, int e, double rest)
{
    struct ode_kinks *k = m->kinks;
    double sum = 0;
    k->side[e] = (signed char)-k->side[e];
    hold(m);
    bool known = ode_eval(&m->field, m->t1, m->x1, k->f);
    k->side[e] = (signed char)-k->side[e];
    hold(m);
    for (int j = 0; known && j < m->p->n; j++) {
        double a = rest * (k->f[j] - m->f1[j]) / ode_allowed(m->o->rtol, m->o->atol, m->unit[j], m->x[j], m->x1[j]);
        sum += a * a;
    }
    return known ? sqrt(sum / m->p->n) : 0;      /* no field there: as near as it gets */
}

/* All along the step g is no further from 0 than errors may take it (x - y where a constraint says that y = x): its changes
 * of sign mean nothing, where the field does not jump there. */
static bool rests(struct ode_march *m, int e)
{
    const struct ode_kinks *k = m->kinks;
    const struct ode_table *w = &k->table;
    bool near = true;
    for (int i = 0; i < w->nodes; i++)
        near &= fabs(w->value[(size_t)i * (size_t)w->count + (size_t)e]) <= k->doubt[e];
    if (!near)
        return false;
    double sum = 0, jump = harm(m, e, 1);
    for (int j = 0; j < m->p->n; j++) {
        double a = m->f1[j] / ode_allowed(m->o->rtol, m->o->atol, m->unit[j], m->x[j], m->x1[j]);
        sum += a * a;
    }
    return jump <= SMOOTH * sqrt(sum / m->p->n);
}

static bool near_enough(struct ode_march *m, int e, double rest)
{
    double h = fabs(m->step.h), least = (m->beside ? 12 : 4) * DBL_EPSILON * fmax(fabs(m->t), fabs(m->t1));
    return rest <= least || (rest < 0.1 * h && (m->kinks->tries >= TRIES || harm(m, e, rest) <= NEAR_ENOUGH));
}

/* The next try ends at the surface of e, which is `size` from the step's start. */
static enum ode_refusal cut_at(struct ode_march *m, int e, double size)
{
    struct ode_kinks *k = m->kinks;
    double grain_t = 2 * DBL_EPSILON * fmax(fabs(m->t), fabs(m->t1));
    k->target = e;
    k->cut = m->beside && size > 20 * grain_t ? size - (double)(1 + m->res->stats.kinks % 3) * grain_t : size;    /* roundings, on purpose */
    k->tries++;
    if (m->level && k->limit == 0)      /* solutions that are compared take different steps to it */
        k->limit = size * PARTS_FIRST / (0.4 + 0.6 * m->level);
    return STEP_CUT;
}

/* The step was to end at the surface of k->target, and does not reach it. */
static enum ode_refusal falls_short(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    int e = k->target, s = k->side[e];
    double h = fabs(m->step.h), speed = -s * k->rate1[e] * m->direction, rest = s * k->g1[e] / speed;
    k->target = -1;
    if (!s || !(speed > 0) || rest > 0.1 * h)
        return STEP_TAKEN;
    if (near_enough(m, e, fabs(rest)))
        k->pending[e] = TURN;
    else
        return cut_at(m, e, h + rest);
    return STEP_TAKEN;
}

enum ode_refusal ode_kinks_step(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    if (!k || k->natural)
        return STEP_TAKEN;
    memset(k->pending, 0, (size_t)k->count);
    if (far_from_all(m))
        return STEP_TAKEN;
    if (!m->method->dense_begin(m->state, &m->field, &m->step))
        return FIELD_REFUSED;
    m->dense_checked = true;
    ode_table_fill(m, &k->table);
    double first = 2, h = fabs(m->step.h);
    int which = -1;
    bool known = false;
    for (int e = 0; e < k->count; e++) {
        if (!k->side[e] || (!k->fresh[e] && plainly_inside(&k->table, e, k->side[e])))
            continue;
        if (!known)
            grains(m, m->t1, m->x1);
        known = true;
        double theta = crossing(m, e);
        if (theta < 2 && rests(m, e)) {
            k->pending[e] = REST;
            continue;
        }
        if (theta < first) {
            first = theta;
            which = e;
        }
    }
    if (first < 0) {
        k->cut = SHORTER * h;
        k->target = -1;
        return STEP_CUT;
    }
    if (which < 0)
        return k->target >= 0 ? falls_short(m) : STEP_TAKEN;
    if (first * h <= 4 * DBL_EPSILON * fmax(fabs(m->t), fabs(m->t1))) {
        k->pending[which] = TURN;
        if (!turn(m))
            return ENDED;
        k->cut = 0;
        k->target = -1;
        return STEP_CUT;
    }
    if (!near_enough(m, which, (1 - first) * h))
        return cut_at(m, which, first * h);
    k->pending[which] = TURN;
    return STEP_TAKEN;
}
