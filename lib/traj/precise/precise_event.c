/* Events in double-double. What happens is found in double first (lib/ode/event.c), which tells several zeros in
 * one step apart; here each is located on the solution in double-double: a change of sign near the time found by
 * regula falsi with halving (Illinois), a touch as a zero of the derivative along the motion, where the value then
 * says whether it was a touch, two passages, or none. One that is not seen again within its surroundings is an
 * error: the two solutions are not the same motion there. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flow.h"
#include "mem.h"
#include "sizes.h"
#include "tolerance.h"
#include "trajectory.h"
#include "watch.h"
#include "precise_march.h"

/* Where it is looked for: so many errors of the time found at first, then ever wider; touches are known to half the digits. */
#define ERRORS 8.0
#define LEAST_REACH 1e-13
#define LEAST_TOUCH_REACH 1e-7
#define WIDER 8.0
/* Up to this part of the step, and of the way to the next event of the same function. */
#define MOST_REACH 0.1
#define APART 0.45
/* Times that a root is found anew on the constraints, and the part of the step that it may move by. */
enum { REFINED = 3 };
#define NEAR_ROOT 1e-6
/* Of a change in a bracket: one that is a jump beside the root. */
#define MUCH 1e-3
/* A step's sums are good to so many roundings. */
#define ROUNDINGS 256.0

struct look {
    struct precise_march *m;
    int event;
    bool slope;                /* the derivative along the motion, not the function */
    num_dd *x;
};

/* The solution at t, and the function or its derivative. */
static num_dd at(const struct look *q, num_dd t)
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

/* The change of sign between a and b; the values there are not of one sign. */
static num_dd root(const struct look *q, num_dd a, num_dd ga, num_dd b, num_dd gb)
{
    assert(!(ga.hi * gb.hi > 0) && !num_dd_less(b, a));
    double least = 2 * NUM_DD_EPSILON * fmax(fabs(a.hi), fabs(q->m->there.t.hi - q->m->here.t.hi));
    for (int k = 0; k < 300 && gb.hi != 0 && fabs(num_dd_sub(b, a).hi) > least; k++) {
        num_dd way = num_dd_sub(b, a), s = num_dd_add(a, num_dd_mul(way, num_dd_div(ga, num_dd_sub(ga, gb))));
        double part = num_dd_sub(s, a).hi / way.hi;
        if (!(part > 0 && part < 1) || k % 6 == 5)
            s = num_dd_add(a, num_dd_scale(way, 0.5));
        num_dd g = at(q, s);
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

/* Both ends of the first interval around the time found that the function changes its sign in: up for sense > 0, down for < 0,
 * either for 0. */
static bool bracket(const struct look *q, double t, double from, double most, int sense, num_dd out[4])
{
    for (double reach = fmin(from, most); ; reach = fmin(WIDER * reach, most)) {
        num_dd a = num_dd_sub(num_dd_of(t), num_dd_of(reach)), b = num_dd_add(num_dd_of(t), num_dd_of(reach));
        num_dd ga = at(q, a), gb = at(q, b);
        bool up = ga.hi <= 0 && gb.hi >= 0, down = ga.hi >= 0 && gb.hi <= 0;
        if ((up && sense >= 0) || (down && sense <= 0)) {
            out[0] = a, out[1] = ga, out[2] = b, out[3] = gb;
            return true;
        }
        if (reach >= most)
            return false;
    }
}

/* How far from guide k one may look. */
static double most_reach(const struct precise_march *m, int k)
{
    const struct traj_result *g = m->p->guide;
    double most = MOST_REACH * fabs(num_dd_sub(m->there.t, m->here.t).hi);
    for (int i = 0; i < g->happened; i++)
        if (i != k && g->happening[i].event == g->happening[k].event)
            most = fmin(most, APART * fabs(g->happening[i].t - g->happening[k].t));
    return most;
}

/* By how much the function changes at t with changes of x by the errors allowed, or (rounding) by some roundings of what it is in
 * the step, in each variable. */
static double doubt(const struct look *q, num_dd t, bool rounding)
{
    const struct precise_march *m = q->m;
    struct precise *p = m->p;
    num_dd g = at(q, t);
    double sum = 16 * NUM_DD_EPSILON * fabs(g.hi);
    for (int j = 0; j < p->n; j++) {
        double size = fmax(fabs(q->x[j].hi), fmax(fabs(m->here.x[j].hi), fabs(m->there.x[j].hi)));
        num_jet2_input(p->event, j)[0] = num_dd_add_d(q->x[j], rounding ? ROUNDINGS * NUM_DD_EPSILON * size : m->scale[j]);
        if (num_jet2_next(p->event, 0))
            sum += fabs(num_dd_sub(num_jet2_root(p->event, q->event)[0], g).hi);
        num_jet2_input(p->event, j)[0] = q->x[j];
    }
    return sum;
}

static num_dd value_at(const struct look *q, num_dd t, const num_dd *x)
{
    struct precise *p = q->m->p;
    for (int j = 0; j <= p->n; j++)
        num_jet2_input(p->event, j)[0] = j < p->n ? x[j] : t;
    num_jet2_next(p->event, 0);
    return num_jet2_root(p->event, q->event)[0];
}

/* The sign of the function at t, also where x is another by roundings; 0: it has no one sign. */
static int steady_sign(const struct look *q, num_dd t)
{
    const struct precise_march *m = q->m;
    struct precise *p = m->p;
    int sign = at(q, t).hi > 0 ? 1 : -1;
    bool steady = true;
    for (int j = 0; j < p->n && steady; j++) {
        double by = ROUNDINGS * NUM_DD_EPSILON * fmax(fabs(q->x[j].hi), fmax(fabs(m->here.x[j].hi), fabs(m->there.x[j].hi)));
        for (int side = -1; side <= 1; side += 2) {
            num_jet2_input(p->event, j)[0] = num_dd_add_d(q->x[j], side * by);
            steady &= num_jet2_next(p->event, 0) && num_jet2_root(p->event, q->event)[0].hi * sign > 0;
        }
        num_jet2_input(p->event, j)[0] = q->x[j];
    }
    return steady ? sign : 0;
}

/* How far from t, where the function jumps over 0, roundings of x can make it do so. */
static double wander(const struct look *q, num_dd t)
{
    double step = fabs(num_dd_sub(q->m->there.t, q->m->here.t).hi), s = 16 * NUM_DD_EPSILON * fmax(fabs(t.hi), step);
    while (s < step && steady_sign(q, num_dd_add_d(t, s)) * steady_sign(q, num_dd_add_d(t, -s)) >= 0)
        s *= 4;
    return s;
}

/* Whether the function jumps over 0 at t: beside it, it changes by much of what it does in the bracket. */
static bool jumps(const struct look *q, num_dd t, const num_dd b[4])
{
    double aside = pow(NUM_DD_EPSILON, 0.75) * fmax(fabs(t.hi), fabs(num_dd_sub(q->m->there.t, q->m->here.t).hi));
    double change = fabs(num_dd_sub(at(q, num_dd_add_d(t, aside)), at(q, num_dd_add_d(t, -aside))).hi);
    return num_dd_sub(b[2], b[0]).hi > 4 * aside && change > MUCH * fabs(num_dd_sub(b[3], b[1]).hi);
}

static bool add(const struct look *q, int direction, num_dd t, bool jump)
{
    struct precise_march *m = q->m;
    struct precise_path *path = m->path;
    int wanted = m->p->rq->event[q->event].direction;
    double moved, residual;
    if (wanted && wanted != direction)
        return true;
    SGA_RESERVE(path->event, path->event_cap, path->events + 1);
    struct precise_event *e = path->event + path->events++;
    struct look slope = *q;
    slope.slope = true;
    double rate = fabs(at(&slope, t).hi);
    *e = (struct precise_event){ .event = q->event, .direction = direction, .t = t, .error = INFINITY,
                                 .floor = !direction ? 0 : jump ? wander(q, t) : rate > 0 ? doubt(q, t, true) / rate : 0,
                                 .x = sga_malloc((size_t)(m->n + 1) * sizeof *e->x) };
    m->method->value(m->state, m, t, e->x);
    bool ok = precise_project(m->p, t, e->x, m->scale, NULL, &moved, &residual);
    /* on the constraints it is a little beside its 0 again */
    for (int k = 0; k < REFINED && ok && e->floor > 0 && !jump; k++) {
        num_dd g = value_at(q, e->t, e->x);
        double back = fabs(g.hi) / rate;
        if (!(back > e->floor && back <= fabs(num_dd_sub(m->there.t, m->here.t).hi) * NEAR_ROOT))
            break;
        num_dd next = num_dd_sub(e->t, num_dd_div(g, at(&slope, e->t)));
        m->method->value(m->state, m, next, e->x);
        ok = precise_project(m->p, next, e->x, m->scale, NULL, &moved, &residual);
        e->t = next;
    }
    return ok;
}

/* A touch where a switch turns, as that of y = |x|: the step's polynomial goes on straight there. It may be there already, or
 * be none: the value stays on its side. */
static bool touch_at_turn(const struct look *q, double t, double from)
{
    const struct precise_march *m = q->m;
    const struct precise_path *path = m->path;
    const struct precise_point *end[2] = { &m->here, &m->there };
    for (int i = 0; i < path->events; i++)
        if (path->event[i].event == q->event && path->event[i].direction == 0 && fabs(path->event[i].t.hi - t) <= from)
            return true;
    for (int i = 0; i < 2 && m->sides.count; i++) {
        if (!(fabs(end[i]->t.hi - t) <= from))
            continue;
        double g = at(q, end[i]->t).hi, least = doubt(q, end[i]->t, false), inside = (i ? -from : from) * m->direction;
        if (fabs(g) <= least)
            return add(q, 0, end[i]->t, false);
        if (g * at(q, num_dd_add_d(end[i]->t, inside)).hi > 0)
            return true;
    }
    return false;
}

/* Double may take such a touch for two passages. */
static bool one_of_two(const struct precise_march *m, int k, double from)
{
    const struct traj_result *g = m->p->guide;
    const struct traj_happening *h = g->happening + k;
    bool two = false;
    for (int i = 0; i < g->happened && m->sides.count; i++)
        two |= g->happening[i].event == h->event && g->happening[i].direction == -h->direction && fabs(g->happening[i].t - h->t) <= from;
    return two;
}

/* The function is past zero at its greatest value (side 1) or its least (-1), at s: the passages before and after it, in the
 * order of the motion. */
static bool two_passages(const struct look *q, num_dd s, int side, double from, double most)
{
    num_dd g = at(q, s);
    for (double reach = fmin(from, most); ; reach = fmin(WIDER * reach, most)) {
        num_dd a = num_dd_add_d(s, -reach), b = num_dd_add_d(s, reach), ga = at(q, a), gb = at(q, b);
        if (ga.hi * side <= 0 && gb.hi * side <= 0) {
            num_dd before = root(q, a, ga, s, g), after = root(q, s, g, b, gb);
            return q->m->direction > 0 ? add(q, side, before, false) && add(q, -side, after, false) : add(q, -side, after, false) && add(q, side, before, false);
        }
        if (reach >= most)
            return false;
    }
}

/* What was a touch in double. */
static bool touch(struct look *q, double t, double from, double most)
{
    num_dd b[4];
    q->slope = true;
    bool found = bracket(q, t, from, most, 0, b);
    num_dd s = found ? root(q, b[0], b[1], b[2], b[3]) : num_dd_of(t);
    q->slope = false;
    num_dd g = at(q, s);
    if (!found)
        return touch_at_turn(q, t, from);
    if (fabs(g.hi) <= doubt(q, s, false))
        return add(q, 0, s, false);
    int side = b[1].hi > b[3].hi ? 1 : -1;
    return g.hi * side < 0 || two_passages(q, s, side, from, most);
}

/* An event found in double is at this place, to its roundings. */
static bool is_at(const struct precise_march *m, int k, num_dd t)
{
    double size = fmax(fabs(m->there.t.hi), fabs(m->here.t.hi));
    return fabs(m->p->guide->happening[k].t - t.hi) <= LEAST_REACH * size;
}

/* The step ends at a knot of a table and so does the event: what it passes may jump over 0 there, which the next step begins with. */
static bool at_next_knot(const struct precise_march *m, int k)
{
    const struct precise *p = m->p;
    return m->passed_knots < p->knots.count && num_dd_sub(m->there.t, p->knot[m->passed_knots]).hi == 0 && is_at(m, k, m->there.t);
}

/* It began at one, where a function jumped to the side that the event leads to. */
static bool jumped(const struct look *q, int k)
{
    const struct precise_march *m = q->m;
    const struct precise *p = m->p;
    int sense = p->guide->happening[k].direction;
    bool begins = m->passed_knots > 0 && num_dd_sub(m->here.t, p->knot[m->passed_knots - 1]).hi == 0 && is_at(m, k, m->here.t);
    return begins && at(q, m->here.t).hi * sense * m->direction > 0 && add(q, sense, m->here.t, false);
}

/* Guide k, in the last step attempted. */
static bool locate(struct look *q, int k)
{
    const struct traj_happening *h = q->m->p->guide->happening + k;
    double size = fmax(fabs(h->t), fabs(q->m->there.t.hi - q->m->here.t.hi)), most = most_reach(q->m, k);
    double from = fmax((h->direction ? LEAST_REACH : LEAST_TOUCH_REACH) * size, isfinite(h->error) ? ERRORS * h->error : 0);
    num_dd b[4];
    q->event = h->event;
    if (h->direction == 0)
        return touch(q, h->t, from, most);
    if (one_of_two(q->m, k, from) && touch_at_turn(q, h->t, from))
        return true;
    if (bracket(q, h->t, from, most, h->direction, b)) {
        num_dd t = root(q, b[0], b[1], b[2], b[3]);
        return add(q, h->direction, t, jumps(q, t, b));
    }
    return jumped(q, k);
}

static void forget(struct precise_path *path, int events)
{
    while (path->events > events)
        free(path->event[--path->events].x);
}

/* What the guide has at once with the event that stops the motion, which was looked for last, is told beside it where it is seen. */
static void at_once(struct look *q)
{
    struct precise_march *m = q->m;
    const struct traj_result *g = m->p->guide;
    double t = g->happening[m->watched - 1].t;
    for (; m->watched < g->happened && fabs(g->happening[m->watched].t - t) <= LEAST_REACH * fabs(t) && sga_watch_ok(); m->watched++) {
        int before = m->path->events;
        if (!locate(q, m->watched))
            forget(m->path, before);
    }
}

bool precise_watch(struct precise_march *m, num_dd *end)
{
    const struct traj_result *g = m->p->guide;
    struct look q = { .m = m };
    bool stopped = false;
    if (!g)
        return false;
    forget(m->path, m->path->kept);
    q.x = sga_malloc((size_t)(m->n + 1) * sizeof *q.x);
    m->watched = m->passed;
    for (; m->watched < g->happened && !stopped && !m->path->lost && sga_watch_ok(); m->watched++) {
        if ((g->happening[m->watched].t - m->there.t.hi) * m->direction > 0)
            break;
        int before = m->path->events;
        if (!locate(&q, m->watched)) {
            forget(m->path, before);
            if (at_next_knot(m, m->watched))
                break;
            m->path->lost = 1 + m->watched;
        } else if (m->path->events > before && m->p->rq->event[g->happening[m->watched].event].stop) {
            forget(m->path, before + 1);      /* the first of two passages stops it */
            *end = m->path->event[before].t;
            stopped = true;
        }
    }
    if (stopped && m->p->rq->event_side)
        at_once(&q);
    free(q.x);
    return stopped;
}

void precise_watched(struct precise_march *m)
{
    assert(m->passed <= m->watched && m->path->kept <= m->path->events);
    m->passed = m->watched;
    m->path->kept = m->path->events;
}

void precise_path_clear(struct precise_path *path)
{
    forget(path, 0);
    free(path->event);
    free(path->sample);
    free(path->held);
    path->event = NULL;
    path->sample = NULL;
    path->held = NULL;
}

void precise_drop_events(struct precise_path *path, double t, double direction)
{
    int kept = path->events;
    while (kept > 0 && direction * (path->event[kept - 1].t.hi - t) > 0)
        kept--;
    forget(path, kept);
}

/* A difference may pass through 0, as those of samples do. */
#define NEIGHBOUR 30.0

double precise_event_errors(const struct precise *p, struct precise_path *a, const struct precise_path *b, double factor)
{
    double start = p->start.hi, worst = 0;
    bool alike = a->events == b->events;
    for (int i = 0; i < a->events && alike; i++)
        alike = a->event[i].event == b->event[i].event && a->event[i].direction == b->event[i].direction;
    for (int i = 0; i < a->events; i++) {
        double size = fmax(fabs(a->event[i].t.hi), fabs(a->event[i].t.hi - start)), near = 0, raw = 0;
        for (int k = i - 1; k <= i + 1 && alike; k++) {
            double d = k < 0 || k >= a->events ? 0 : fabs(num_dd_sub(a->event[k].t, b->event[k].t).hi);
            *(k == i ? &raw : &near) = k == i ? d : fmax(near, d);
        }
        a->event[i].error = alike ? factor * fmax(raw, fmin(near, NEIGHBOUR * raw)) + a->event[i].floor + 16 * NUM_DD_EPSILON * size : INFINITY;
        if (a->event[i].direction)
            worst = fmax(worst, sga_error_ratio(a->event[i].error, (struct sga_tolerance){ p->rq->rtol, p->rq->atol }, p->flow->sizes->time, size));
    }
    return worst;
}
