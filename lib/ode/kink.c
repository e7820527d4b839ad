/* Kinks: places where a switch of the field (abs, sign, min, max) changes its branch.
 *
 * Along a step every switch is held on the side of its surface g = 0 where the motion is, so that the method sees a
 * smooth field, also in stages that lie beyond. After the step g is looked at along the step's polynomial (guard.h):
 * a step that passes a surface is taken again, to end there, and the next one begins on the other side. Where both
 * fields point at the surface, the motion would slide along it, and ends. (State events; Hairer, Norsett, Wanner,
 * Solving Ordinary Differential Equations I, II.6; Filippov for the sides.)
 *
 * Beside a surface (x' = -50 max(x, 0) at rest, and about to leave) the polynomial of a long step may lie beyond it, by less
 * than the step's error, where the motion never is. A shorter step to that place then finds no surface there, and the steps
 * after it grow from that size on: another long one would be refused for the same cause, and so on for each such short one.
 *
 * A switch that rests on its surface (g is 0 to rounding, and no side is the one that the motion takes, or to the
 * tolerance all along a step) is not held: it has the value that its argument says. Where a field held on one side has no values beyond (sqrt(abs(x))), steps are
 * made with nothing held, and the error control is all there is. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kink.h"
#include "mem.h"

#define GROWTH 10.0            /* from a step to the next, after one that did not find the surface it was to end at */
#define AT_SURFACE 1e-4        /* of the time passed, see heads_for_surface */

void kinks_hold(struct ode_march *m)
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
    k->side = sga_calloc(4 * c, 1);
    k->fresh = (unsigned char *)k->side + c;
    k->pending = k->fresh + c;
    k->led = k->pending + c;
    k->g = sga_calloc(9 * c + 3 * n, sizeof *k->g);
    k->rate = k->g + c;
    k->g1 = k->rate + c;
    k->rate1 = k->g1 + c;
    k->old = k->rate1 + c;
    k->least = k->old + c;
    k->doubt = k->least + c;
    k->was = k->doubt + c;
    k->theta = k->was + c;
    k->x = k->theta + c;
    k->f = k->x + n;
    k->mid = k->f + n;
    ode_way_begin(&k->way, m, k->count, m->p->switching);
    k->way.way.from_end = true;        /* a step may begin on a surface that the motion is beyond for a moment */
    guard_table_init(&k->table, k->count);
}

void ode_kinks_end(struct ode_march *m)
{
    struct ode_kinks *k = m->kinks;
    if (!k)
        return;
    m->p->hold(m->p->ctx, NULL);
    m->res->helds = k->count;
    m->res->held = sga_calloc((size_t)k->count + 1, 1);
    if (!k->natural)
        memcpy(m->res->held, k->side, (size_t)k->count);
    ode_way_end(&k->way);
    guard_table_clear(&k->table);
    free(k->side);
    free(k->g);
    free(k);
    m->kinks = NULL;
}

bool ode_kinks_turned(const struct ode_march *m) { return m->kinks && m->t == m->kinks->turned_t; }

bool ode_kinks_start(struct ode_march *m, double h)
{
    if (!m->kinks)
        return true;
    kinks_set_scale(m, h);
    if (kinks_take_sides(m))
        return true;
    ode_end_at(m, m->field.why, "the vector field has no finite value at the start");
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
    assert(ode_kinks_sane(k));
    bool bound = h <= k->short_h || h >= 0.9 * GROWTH * k->short_h;
    k->short_h = k->short_h > 0 && bound ? h : 0;
    if (k->limit > 0 && (m->t - k->limit_t) * m->direction > k->limit)
        k->limit = 0;
    kinks_set_scale(m, h);
    if (k->natural) {
        if (kinks_take_sides(m))
            return true;
        ode_end_at(m, m->field.why, "the vector field has no value beyond this time");
        return false;
    }
    memcpy(k->g, k->g1, (size_t)k->count * sizeof *k->g);
    memcpy(k->rate, k->rate1, (size_t)k->count * sizeof *k->rate);
    bool ok = true, any = false, unsure = false;
    for (int e = 0; e < k->count; e++) {
        unsure |= k->fresh[e] || (!k->side[e] && !(fabs(k->g[e]) <= 0.5 * k->doubt[e]));
        if (k->pending[e] == REST && !kinks_let_go(m, e))
            return false;
    }
    if (unsure)
        kinks_grains(m, m->t, m->x);
    for (int e = 0; e < k->count && ok; e++) {
        ok = kinks_left(m, e);
        any |= k->pending[e];
    }
    return ok && any ? kinks_turn(m) : ok;
}

bool ode_kinks_turn_ahead(const struct ode_march *m)
{
    const struct ode_kinks *k = m->kinks;
    bool turn = false;
    for (int e = 0; k && !k->natural && e < k->count; e++)
        turn |= k->pending[e] == TURN;
    return turn;
}

double ode_kinks_cut(const struct ode_march *m, double h)
{
    const struct ode_kinks *k = m->kinks;
    if (k && k->cut > 0)
        h = fmin(h, k->cut);
    if (k && k->short_h > 0)
        h = fmin(h, GROWTH * k->short_h);
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
    kinks_hold(m);
    return k->natural;
}

void ode_kinks_held(struct ode_march *m)
{
    if (m->kinks && m->kinks->natural) {
        m->kinks->natural = false;
        kinks_hold(m);
    }
}
