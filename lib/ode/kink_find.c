/* Does a step pass a surface of a switch, and where? See kink.c. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kink.h"
#include "mem.h"

#define NEAR_ENOUGH 0.02       /* error allowed to a switch that is turned too early or late, in units of the step's */
#define SHORTER 0.1            /* of a step that is too long to see what the motion does at its start */
#define SMOOTH 1e-2            /* of the field: no jump */
#define HARMLESS 1.0           /* the same, after TRIES tries */
#define TRIES 4                /* tries to end a step on the surface */
#define MOST_TRIES 12
#define GRAVE 1e-9             /* of a step: to a place where the motion ends */
#define PARTS_FIRST 0.41       /* see cut_at */

/* All surfaces are so far that no motion at the rates at both ends gets there. */
static bool far_from_all(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    double h = m->step.h, d = 1e-3 * h;
    kinks_values(m, m->t1, m->x1, k->g1);
    for (int j = 0; j < m->p->n; j++)
        k->x[j] = m->x1[j] + d * m->f1[j];
    kinks_values(m, m->t1 + d, k->x, k->rate1);
    bool far = true;
    for (int e = 0; e < k->count; e++) {
        k->rate1[e] = (k->rate1[e] - k->g1[e]) / d;
        double reach = fabs(k->g1[e] - k->g[e]) + fabs(h) * (fabs(k->rate[e]) + fabs(k->rate1[e]));
        far &= !k->side[e] || fmin(k->side[e] * k->g[e], k->side[e] * k->g1[e]) > reach;
    }
    return far;
}

/* Switch e stays on its side, as far as its values and rates at the ends, and at the nodes between, tell. */
static bool plainly_inside(const struct ode_march *m, int e)
{
    const struct ode_kinks *k = m->kinks;
    const struct guard_table *w = &k->table;
    struct guard_ends ends = { k->g[e], m->step.h * k->rate[e], k->g1[e], m->step.h * k->rate1[e] };
    bool inside = k->side[e] * k->g[e] > 0 && guard_stays(&ends);
    for (int i = 0; i < w->nodes && inside; i++)
        inside = guard_fits(&ends, w->theta[i], guard_value(w, i, e));
    return inside;
}

/* Whether value v of switch e at a node tells its side: it is larger than what roundings make at the step's end, or where it is, which is less where the switch varies
 * less. */
static bool tells(struct ode_march *m, int e, int node, double v)
{
    struct ode_kinks *k = m->kinks;
    const struct guard_table *w = &k->table;
    if (fabs(v) > k->least[e] || node == 0 || node + 1 == w->nodes)
        return fabs(v) > k->least[e];
    size_t n = (size_t)m->p->n, both = 2 * (size_t)k->count;
    double *kept = sga_malloc((both + n + 1) * sizeof *kept), *x = kept + both;
    memcpy(kept, k->least, both * sizeof *kept);      /* and doubt */
    m->method->dense_at(m->state, &m->step, w->theta[node], x);
    kinks_grains(m, m->t + (w->theta[node] * m->step.h + m->t_low), x);
    bool told = fabs(v) > k->least[e];
    memcpy(k->least, kept, both * sizeof *kept);
    free(kept);
    return told;
}

/* The first place in the step where switch e leaves its side; 2: none; -1: the step is too long to tell. */
static double crossing(struct ode_march *m, int e)
{
    struct ode_kinks *k = m->kinks;
    const struct guard_table *w = &k->table;
    int s = k->side[e], last = -1;
    bool armed = !k->fresh[e];
    double least = k->least[e], first = s * guard_value(w, 0, e);
    for (int i = 0; i < w->nodes && s; i++) {
        double v = s * guard_value(w, i, e);
        if (!isfinite(v)) {
            last = -1;
            continue;
        }
        if (armed && v < 0 && tells(m, e, i, v)) {
            if (last < 0)       /* none was on its side: it begins on the surface, but where it had no value */
                return isfinite(guard_value(w, 0, e)) ? 0 : w->theta[i];
            double u = s * guard_value(w, last, e);
            return guard_root(&k->way.way, e, w->theta[last], s * u, w->theta[i], s * v, k->table.g);
        }
        armed = armed || (v > 0 && tells(m, e, i, v));
        last = v > 0 ? i : last;
    }
    double v = s * guard_value(w, w->nodes - 1, e);
    if (armed || v >= -10 * fmax(least, fabs(first)))
        return 2;
    return s * k->rate[e] * m->direction > 0 ? -1 : 0;
}

/* Turned at the step's end, with all that this turns: the field there into f. 0: there is none, -1: they turn each other without end, or no
 * point of the constraints beyond is near (y = max(0, t - 1) away from t = 1), whatever the field does. */
static int turned_field(struct ode_march *m, int e, double *f)
{
    struct ode_kinks *k = m->kinks;
    size_t n = (size_t)m->p->n, c = (size_t)k->count;
    double *x = sga_malloc((n + c + 1) * sizeof *x), *g = x + n;
    signed char *side = memcpy(sga_malloc(c + 1), k->side, c);
    memcpy(x, m->x1, n * sizeof *x);
    kinks_values(m, m->t1, x, g);
    k->side[e] = (signed char)-k->side[e];
    bool on_set;
    int known = !kinks_carry(m, m->t1, x, g, &on_set) || !on_set ? -1 : ode_eval(&m->field, m->t1, x, f);
    memcpy(k->side, side, c);
    kinks_hold(m);
    kinks_values(m, m->t1, m->x1, k->g1);
    free(x);
    free(side);
    return known;
}

/* The step ends `rest` (of time) from the surface of e. What turning the switch there instead of on it does to the
 * motion, in units of the error allowed. */
static double harm(struct ode_march *m, int e, double rest)
{
    struct ode_kinks *k = m->kinks;
    double sum = 0;
    int known = turned_field(m, e, k->f);
    if (known < 0)
        return rest / (GRAVE * fabs(m->step.h));
    for (int j = 0; known && j < m->p->n; j++) {
        double a = rest * (k->f[j] - m->f1[j]) / ode_allowed(m->o->rtol, m->o->atol, m->unit[j], m->x[j], m->x1[j]);
        sum += a * a;
    }
    return known ? sqrt(sum / m->p->n) : 0;      /* no field there: as near as it gets */
}

/* All along the step g is no further from 0 than errors may take it. */
static bool stays_near(const struct ode_kinks *k, int e)
{
    bool near = true;
    for (int i = 0; i < k->table.nodes; i++)
        near &= fabs(guard_value(&k->table, i, e)) <= k->doubt[e];
    return near;
}

/* So it does (x - y where a constraint says that y = x): its changes of sign mean nothing, where the field does not jump there. */
static bool rests(struct ode_march *m, int e)
{
    if (!stays_near(m->kinks, e))
        return false;
    double sum = 0, jump = harm(m, e, 1);
    for (int j = 0; j < m->p->n; j++) {
        double a = m->f1[j] / ode_allowed(m->o->rtol, m->o->atol, m->unit[j], m->x[j], m->x1[j]);
        sum += a * a;
    }
    return jump <= SMOOTH * sqrt(sum / m->p->n);
}

/* Times that are told from each other differ by more. */
static double grain_at(const struct ode_march *m) { return (m->beside ? 12 : 4) * DBL_EPSILON * fmax(fabs(m->t), fabs(m->t1)); }

static bool near_enough(struct ode_march *m, int e, double rest)
{
    double h = fabs(m->step.h);
    return rest <= grain_at(m) || (rest < 0.1 * h && harm(m, e, rest) <= (m->kinks->tries >= TRIES ? HARMLESS : NEAR_ENOUGH));
}

/* The next try ends at the surface of e, which is `size` from the step's start. */
static enum ode_refusal cut_at(struct ode_march *m, int e, double size)
{
    struct ode_kinks *k = m->kinks;
    double grain_t = 2 * DBL_EPSILON * fmax(fabs(m->t), fabs(m->t1));
    assert(size > 0);          /* ahead */
    k->target = e;
    k->cut = m->beside && size > 20 * grain_t ? size - (double)(1 + m->res->stats.kinks % 3) * grain_t : size;    /* roundings, on purpose */
    k->tries++;
    if (m->level && k->limit == 0) {      /* solutions that are compared take different steps to it */
        k->limit = size * PARTS_FIRST / (0.4 + 0.6 * m->level);
        k->limit_t = m->t + size * m->direction;
    }
    return STEP_CUT;
}

/* The step was to end at the surface of k->target, and does not reach it. */
static enum ode_refusal falls_short(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    int e = k->target, s = k->side[e];
    double h = fabs(m->step.h), speed = -s * k->rate1[e] * m->direction, rest = s * k->g1[e] / speed;
    k->target = -1;
    if (s && fabs(rest) <= grain_at(m)) {      /* whatever the rate: it is one over a part of the step, within which it may turn (a narrow pulse) */
        k->pending[e] = TURN;
        return STEP_TAKEN;
    }
    if (!s || !(speed > 0) || fabs(rest) > 0.1 * h) {       /* behind the end too: rates there say little of a surface so far */
        k->short_h = h;
        return STEP_TAKEN;
    }
    if (near_enough(m, e, fabs(rest)))
        k->pending[e] = TURN;
    else if (k->tries < MOST_TRIES)
        return cut_at(m, e, h + rest);
    return STEP_TAKEN;
}

enum ode_refusal ode_kinks_step(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    if (!k || k->natural)
        return STEP_TAKEN;
    memset(k->pending, 0, (size_t)k->count);
    if (far_from_all(m)) {
        k->short_h = k->target >= 0 ? fabs(m->step.h) : k->short_h;
        return STEP_TAKEN;
    }
    if (!m->method->dense_begin(m->state, &m->field, &m->step))
        return FIELD_REFUSED;
    m->dense_checked = true;
    guard_table_fill(&k->table, ode_way_ready(&k->way));
    double first = 2, cut = 2, h = fabs(m->step.h);
    int which = -1, there = -1;
    bool known = false, turns = false;
    for (int e = 0; e < k->count; e++) {
        k->theta[e] = 2;
        if (!k->side[e] || (!k->fresh[e] && plainly_inside(m, e)))
            continue;
        if (!known)
            kinks_grains(m, m->t1, m->x1);
        known = true;
        if (!turns && !stays_near(k, e)) {
            guard_table_monotone(&k->table, &k->way.way);
            turns = true;
        }
        double theta = crossing(m, e);
        if (theta < 2 && rests(m, e)) {
            k->pending[e] = REST;
            continue;
        }
        k->theta[e] = theta;
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
        memset(k->pending, 0, (size_t)k->count);      /* what rests is seen again in the next step */
        k->pending[which] = TURN;
        if (!kinks_turn(m))
            return ENDED;
        k->cut = 0;
        k->target = -1;
        return STEP_CUT;
    }
    for (int e = 0; e < k->count; e++)         /* the first that the end is not near enough to: others, of no matter there, may come before */
        if (k->theta[e] < cut && !near_enough(m, e, (1 - k->theta[e]) * h)) {
            cut = k->theta[e];
            there = e;
        }
    if (there >= 0) {
        if (k->tries < MOST_TRIES)
            return cut_at(m, there, cut * h);
        k->cut = SHORTER * h;      /* from nearer by, then */
        k->target = -1;
        return STEP_CUT;
    }
    k->pending[which] = TURN;
    return STEP_TAKEN;
}
