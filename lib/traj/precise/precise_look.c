/* Places on a step in double-double: see precise_look.h. */
#include "precise_look.h"

#include <assert.h>
#include <math.h>

#include "jet.h"
#include "precise.h"

#define WIDER 8.0              /* times: brackets around a place */
/* Of a change in a bracket: one that is a jump beside the root. */
#define MUCH 1e-3
/* A bracket comes to the rounding of its ends in so many halvings; it is halved in three turns. */
enum { HALVINGS = 120, TURNS = 3 * HALVINGS };

num_dd precise_look_at(const struct precise_look *q, num_dd t)
{
    struct precise *p = q->m->p;
    int n = p->n;
    q->m->method->value(q->m->state, q->m, t, q->x);
    for (int j = 0; j <= n; j++) {
        num_jet2_input(p->event, j)[0] = j < n ? q->x[j] : t;
        num_jet2_input(p->velocity, j)[0] = j < n ? q->x[j] : t;
    }
    bool ok = num_jet2_next(p->event, 0);
    if (!q->slope)
        return num_jet2_root(p->event, q->event)[0];
    ok = num_jet2_next(p->velocity, 0) && ok;
    for (int j = 0; j <= n; j++)
        num_jet2_input(p->event, j)[1] = j < n ? num_jet2_root(p->velocity, j)[0] : num_dd_of(1);
    ok = ok && num_jet2_next(p->event, 1);
    return ok ? num_jet2_root(p->event, q->event)[1] : num_dd_of(NAN);
}

num_dd precise_look_root(const struct precise_look *q, num_dd a, num_dd ga, num_dd b, num_dd gb)
{
    assert(!(ga.hi * gb.hi > 0));
    double least = 2 * NUM_DD_EPSILON * fmax(fabs(a.hi), fabs(q->m->there.t.hi - q->m->here.t.hi)), before = INFINITY;
    for (int k = 0; k < TURNS && gb.hi != 0 && fabs(num_dd_sub(b, a).hi) > least; k++) {
        bool slow = k % 3 == 2 && fabs(num_dd_sub(b, a).hi) > 0.5 * before;
        before = k % 3 == 2 ? fabs(num_dd_sub(b, a).hi) : before;
        num_dd way = num_dd_sub(b, a), s = num_dd_add(a, num_dd_mul(way, num_dd_div(ga, num_dd_sub(ga, gb))));
        double part = num_dd_sub(s, a).hi / way.hi;
        if (!(part > 0 && part < 1) || slow)
            s = num_dd_add(a, num_dd_scale(way, 0.5));
        num_dd g = precise_look_at(q, s);
        if (!num_dd_finite(g) || g.hi == 0)
            return s;
        if ((g.hi > 0) == (ga.hi > 0)) {
            a = s;
            ga = g;
            gb = num_dd_scale(gb, 0.5);
        } else {
            b = s;
            gb = g;
            ga = num_dd_scale(ga, 0.5);
        }
    }
    return b;
}

bool precise_look_bracket(const struct precise_look *q, num_dd t, double from, double most, num_dd out[4])
{
    for (double reach = fmin(from, most); ; reach = fmin(WIDER * reach, most)) {
        num_dd a = num_dd_add_d(t, -reach), b = num_dd_add_d(t, reach), ga = precise_look_at(q, a), gb = precise_look_at(q, b);
        if (ga.hi * gb.hi <= 0) {
            out[0] = a, out[1] = ga, out[2] = b, out[3] = gb;
            return true;
        }
        if (!(reach < most))
            return false;
    }
}

double precise_look_doubt(const struct precise_look *q, num_dd t, bool rounding)
{
    const struct precise_march *m = q->m;
    struct precise *p = m->p;
    num_dd g = precise_look_at(q, t);
    double sum = 16 * NUM_DD_EPSILON * fabs(g.hi);
    for (int j = 0; j < p->n; j++) {
        double size = fmax(fabs(q->x[j].hi), fmax(fabs(m->here.x[j].hi), fabs(m->there.x[j].hi)));
        num_jet2_input(p->event, j)[0] = num_dd_add_d(q->x[j], rounding ? PRECISE_ROUNDINGS * NUM_DD_EPSILON * size : m->scale[j]);
        if (num_jet2_next(p->event, 0))
            sum += fabs(num_dd_sub(num_jet2_root(p->event, q->event)[0], g).hi);
        num_jet2_input(p->event, j)[0] = q->x[j];
    }
    return sum;
}

num_dd precise_look_value(const struct precise_look *q, num_dd t, const num_dd *x)
{
    struct precise *p = q->m->p;
    for (int j = 0; j <= p->n; j++)
        num_jet2_input(p->event, j)[0] = j < p->n ? x[j] : t;
    num_jet2_next(p->event, 0);
    return num_jet2_root(p->event, q->event)[0];
}

/* The sign of the function at t, also where x is another by roundings; 0: it has no one sign. */
static int steady_sign(const struct precise_look *q, num_dd t)
{
    const struct precise_march *m = q->m;
    struct precise *p = m->p;
    int sign = precise_look_at(q, t).hi > 0 ? 1 : -1;
    bool steady = true;
    for (int j = 0; j < p->n && steady; j++) {
        double by = PRECISE_ROUNDINGS * NUM_DD_EPSILON * fmax(fabs(q->x[j].hi), fmax(fabs(m->here.x[j].hi), fabs(m->there.x[j].hi)));
        for (int side = -1; side <= 1; side += 2) {
            num_jet2_input(p->event, j)[0] = num_dd_add_d(q->x[j], side * by);
            steady &= num_jet2_next(p->event, 0) && num_jet2_root(p->event, q->event)[0].hi * sign > 0;
        }
        num_jet2_input(p->event, j)[0] = q->x[j];
    }
    return steady ? sign : 0;
}

double precise_look_wander(const struct precise_look *q, num_dd t)
{
    double step = fabs(num_dd_sub(q->m->there.t, q->m->here.t).hi), s = 16 * NUM_DD_EPSILON * fmax(fabs(t.hi), step);
    while (s < step && steady_sign(q, num_dd_add_d(t, s)) * steady_sign(q, num_dd_add_d(t, -s)) >= 0)
        s *= 4;
    return s;
}

/* Beside it, the function changes by much of what it does in the bracket. */
bool precise_look_jumps(const struct precise_look *q, num_dd t, const num_dd b[4])
{
    double aside = pow(NUM_DD_EPSILON, 0.75) * fmax(fabs(t.hi), fabs(num_dd_sub(q->m->there.t, q->m->here.t).hi));
    double change = fabs(num_dd_sub(precise_look_at(q, num_dd_add_d(t, aside)), precise_look_at(q, num_dd_add_d(t, -aside))).hi);
    return fabs(num_dd_sub(b[2], b[0]).hi) > 4 * aside && change > MUCH * fabs(num_dd_sub(b[3], b[1]).hi);
}

num_dd precise_look_first(const struct precise_look *q, num_dd a, num_dd b)
{
    for (int k = 0; k < HALVINGS; k++) {
        num_dd s = num_dd_scale(num_dd_add(a, b), 0.5);
        *(precise_look_at(q, s).hi == 0 ? &b : &a) = s;
    }
    return b;
}
