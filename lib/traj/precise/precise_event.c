/* Events in double-double. Each step is a way of their functions (guard.h), whose values are those of the solution in double-double: what passes 0, and
 * what comes near to it, is found on a table of them, and followed from step to step (guard_track.h), as in double. Places are then found to all digits on
 * the solution: a change of sign by regula falsi with halving (Illinois), a touch as a zero of the derivative along the motion, where the value says
 * whether it was a touch, two passages, or none. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "flow.h"
#include "guard_track.h"
#include "jet.h"
#include "mem.h"
#include "ode.h"
#include "precise.h"
#include "sizes.h"
#include "tolerance.h"
#include "trajectory.h"
#include "watch.h"
#include "precise_look.h"

/* Of times: as one. */
#define SAME_TIME 1e-13
/* Of a step: where the least value is looked for around its place in double, and ever wider up to this part of the way to the nodes beside it. */
#define LEAST_REACH 1e-7
#define MOST_REACH 0.999
/* Times that a root is found anew on the constraints, and the part of the step that it may move by. */
enum { REFINED = 3 };
#define NEAR_ROOT 1e-6
/* Of a variable's size: where jumps of functions are looked for around an event's place. */
#define PLACE 1e-4
/* Roundings of a time: an event so near to the last time is at it. */
#define AT_LAST 64.0

struct place { num_dd t; int event, direction; bool jump; };

struct precise_watch {
    struct guard_track *now, *next;    /* by event, where the present step begins; where the step attempted ends */
    bool over;                 /* the budget ended while events were looked for */
    bool *back;                /* by event: what was a passage at the end of the step before is a touch */
    struct guard_table table;
    struct guard_way way;
    double *noise;             /* by event; and work of three times as many */
    num_dd *x;                 /* n + 1: the solution where it was asked for last */
    struct place *place; int places; size_t place_cap;
};

static struct precise_look look_for(struct precise_march *m, int event) { return (struct precise_look){ .m = m, .event = event, .x = m->watch->x }; }

/* Into the path, with the point of the constraints there. */
static bool deliver(const struct precise_look *q, int direction, num_dd t, bool jump)
{
    struct precise_march *m = q->m;
    struct precise_path *path = m->path;
    double moved, residual;
    SGA_RESERVE(path->event, path->event_cap, path->events + 1);
    struct precise_event *e = path->event + path->events++;
    struct precise_look slope = *q;
    slope.slope = true;
    double rate = fabs(precise_look_at(&slope, t).hi);
    *e = (struct precise_event){ .event = q->event, .direction = direction, .t = t, .error = INFINITY,
                                 .floor = !direction ? 0 : jump ? precise_look_wander(q, t) : rate > 0 ? precise_look_doubt(q, t, true) / rate : 0,
                                 .x = sga_malloc((size_t)(m->n + 1) * sizeof *e->x) };
    m->method->value(m->state, m, t, e->x);
    bool ok = precise_project(m->p, t, e->x, m->scale, NULL, &moved, &residual);
    /* on the constraints it is a little beside its 0 again */
    for (int k = 0; k < REFINED && ok && e->floor > 0 && !jump; k++) {
        num_dd g = precise_look_value(q, e->t, e->x);
        double back = fabs(g.hi) / rate;
        if (!(back > e->floor && back <= fabs(num_dd_sub(m->there.t, m->here.t).hi) * NEAR_ROOT))
            break;
        num_dd next = num_dd_sub(e->t, num_dd_div(g, precise_look_at(&slope, e->t)));
        m->method->value(m->state, m, next, e->x);
        ok = precise_project(m->p, next, e->x, m->scale, NULL, &moved, &residual);
        e->t = next;
    }
    return ok;
}

/* Where in the step, in the order of the solution's values. */
static num_dd time_at(const struct precise_march *m, double s)
{
    return s <= 0 ? m->here.t : s >= 1 ? m->there.t : num_dd_add(m->here.t, num_dd_mul_d(num_dd_sub(m->there.t, m->here.t), s));
}

static void values_at(struct precise_march *m, num_dd t, const num_dd *x, double *g)
{
    struct precise *p = m->p;
    for (int j = 0; j <= p->n; j++)
        num_jet2_input(p->event, j)[0] = j < p->n ? x[j] : t;
    num_jet2_next(p->event, 0);
    for (int e = 0; e < p->rq->events; e++)
        g[e] = num_jet2_root(p->event, e)[0].hi;
}

static void on_way(void *of, double s, double *g)
{
    struct precise_march *m = of;
    num_dd t = time_at(m, s), *x = m->watch->x;
    m->method->value(m->state, m, t, x);
    values_at(m, t, x, g);
}

static void at_end(void *of, bool last, double *g)
{
    struct precise_march *m = of;
    const struct precise_point *q = last ? &m->there : &m->here;
    values_at(m, q->t, q->x, g);
}

/* One of the functions beside a point; the last argument is time. */
struct beside { struct precise_march *m; int event; num_dd t; const num_dd *x; };

static double value_beside(void *ctx, int j, double by)
{
    const struct beside *b = ctx;
    struct precise *p = b->m->p;
    for (int i = 0; i <= p->n; i++)
        num_jet2_input(p->event, i)[0] = num_dd_add_d(i < p->n ? b->x[i] : b->t, i == j ? by : 0);
    num_jet2_next(p->event, 0);
    return num_jet2_root(p->event, b->event)[0].hi;
}

static double error_of(void *ctx, int j, enum guard_errors which)
{
    const struct beside *b = ctx;
    const struct precise_march *m = b->m;
    const struct precise *p = m->p;
    bool time = j == m->n;
    double last = p->time[p->rq->samples - 1].hi, passing = fmax(fabs(b->t.hi), fabs(last - b->t.hi));
    double size = time ? passing : fabs(b->x[j].hi), unit = time ? passing : fmax(size, p->flow->sizes->unit[j]);
    return which == GUARD_TOLD ? PRECISE_ROUNDINGS * NUM_DD_EPSILON * size : which == GUARD_FOUND ? PRECISE_ROUNDINGS * NUM_DD_EPSILON * unit : which == GUARD_PLACE ? PLACE * unit
           : m->scale[j];
}

static struct guard_point point_of(struct beside *b) { return (struct guard_point){ { value_beside, b, b->m->n + 1 }, error_of, 16 * NUM_DD_EPSILON }; }

static double doubt_at(struct precise_march *m, int e, const struct precise_point *q)
{
    struct beside at = { m, e, q->t, q->x };
    const struct guard_point p = point_of(&at);
    return guard_doubt(&p, GUARD_ALLOWED, NULL);
}

static double doubt_at_end(void *of, int e, bool last)
{
    struct precise_march *m = of;
    const struct guard_table *w = &m->watch->table;
    double by_time = PRECISE_ROUNDINGS * NUM_DD_EPSILON * fmax(fabs(m->here.t.hi), fabs(m->there.t.hi)) / fabs(num_dd_sub(m->there.t, m->here.t).hi);
    return doubt_at(m, e, last ? &m->there : &m->here) + (last ? 0 : by_time * fabs(guard_value(w, 1, e) - guard_value(w, 0, e)) / w->theta[1]);
}

static void add(struct precise_march *m, int e, int crossing, num_dd t, bool jump)
{
    struct precise_watch *w = m->watch;
    int wanted = m->p->rq->event[e].direction, sense = m->direction < 0 ? -crossing : crossing;
    num_dd last = m->p->time[m->p->rq->samples - 1];
    double left = m->direction * num_dd_sub(last, t).hi;       /* what comes to 0 at the last time does not pass it */
    if ((wanted && wanted != sense) || !(left > AT_LAST * NUM_DD_EPSILON * fmax(fabs(last.hi), fabs(m->here.t.hi))))
        return;
    SGA_RESERVE(w->place, w->place_cap, w->places + 1);
    w->place[w->places++] = (struct place){ t, e, sense, jump };
}

/* The step before ended on 0, a little beyond, where a switch turned (of y, which is |x|): back on the side that it came from, it has touched 0. */
static bool was_touch(struct precise_march *m, int e, int crossing)
{
    struct precise_watch *w = m->watch;
    struct precise_path *path = m->path;
    int k = path->kept - 1, sense = m->direction < 0 ? -crossing : crossing;
    if (w->back[e] || !w->now[e].touched || m->p->rq->event[e].direction)
        return w->back[e];
    while (k >= 0 && path->event[k].event != e)
        k--;
    if (k < 0 || path->event[k].direction != -sense)
        return false;
    path->event[k].direction = 0;
    path->event[k].floor = 0;
    return w->back[e] = true;
}

static bool may_look(struct precise_march *m)
{
    struct precise_watch *w = m->watch;
    w->over = w->over || !sga_watch_ok();
    return !w->over;
}

/* What it jumps by is no matter of the state there. */
static bool begins_at_knot(const struct precise_march *m) { return m->passed_knots > 0 && num_dd_sub(m->here.t, m->p->knot[m->passed_knots - 1]).hi == 0; }

static void change(void *of, int e, double a, double ga, double b, double gb, int sense)
{
    struct precise_march *m = of;
    const struct precise_look q = look_for(m, e);
    bool first = a == 0 && !m->watch->next[e].touched;
    if (!may_look(m) || (first && was_touch(m, e, sense)))
        return;
    if (b == 0) {
        add(m, e, sense, m->here.t, !begins_at_knot(m));
        return;
    }
    num_dd bracket[4] = { time_at(m, a), num_dd_of(ga), time_at(m, b), num_dd_of(gb) };
    num_dd t = precise_look_root(&q, bracket[0], bracket[1], bracket[2], bracket[3]);
    add(m, e, sense, t, precise_look_jumps(&q, t, bracket));
}

static void touch(void *of, int e)
{
    struct precise_march *m = of;
    add(m, e, 0, m->here.t, false);
}

static double low(void *of, const struct guard_low *l)
{
    struct precise_march *m = of;
    int e = l->d.function, sign = l->d.sense;
    struct precise_look q = look_for(m, e);
    if (!may_look(m))
        return -1;
    double step = fabs(num_dd_sub(m->there.t, m->here.t).hi);
    num_dd left = time_at(m, l->left), right = time_at(m, l->right), s = time_at(m, l->d.at), b[4];
    q.slope = true;
    if (precise_look_bracket(&q, s, LEAST_REACH * step, MOST_REACH * step * fmin(l->d.at - l->left, l->right - l->d.at), b))
        s = precise_look_root(&q, b[0], b[1], b[2], b[3]);
    q.slope = false;
    num_dd g = precise_look_at(&q, s);
    double unsure = precise_look_doubt(&q, s, false);
    if (sign * g.hi < -unsure) {
        add(m, e, -sign, precise_look_root(&q, left, num_dd_of(l->left_value), s, g), false);
        add(m, e, sign, precise_look_root(&q, s, g, right, num_dd_of(l->right_value)), false);
    } else if (fabs(g.hi) <= unsure) {
        add(m, e, 0, g.hi == 0 ? precise_look_first(&q, left, s) : s, false);
        return unsure;
    }
    return -1;
}

void precise_watch_begin(struct precise_march *m)
{
    size_t events = m->p->event ? (size_t)m->p->rq->events : 0;
    if (!events)
        return;
    struct precise_watch *w = m->watch = sga_calloc(1, sizeof *w);
    w->now = sga_calloc(2 * events, sizeof *w->now);
    w->next = w->now + events;
    w->back = sga_calloc(events, sizeof *w->back);
    w->noise = sga_calloc(4 * events, sizeof *w->noise);
    w->x = sga_malloc(((size_t)m->n + 1) * sizeof *w->x);
    guard_table_init(&w->table, (int)events);
    w->way = (struct guard_way){ .count = (int)events, .at = on_way, .end = at_end, .of = m, .noise = w->noise, .budget = m->p->rq->budget };
    for (int e = 0; e < (int)events; e++) {
        int side = m->p->rq->event_side ? m->p->rq->event_side[e] : ODE_SIDE_FRESH;
        struct beside at = { m, e, m->here.t, m->here.x };
        const struct guard_point p = point_of(&at);
        guard_track_start(w->now + e, &p, side == 1 || side == -1 ? side : 0, side == ODE_SIDE_FRESH);
    }
}

void precise_watch_end(struct precise_march *m)
{
    struct precise_watch *w = m->watch;
    if (!w)
        return;
    free(w->now < w->next ? w->now : w->next);
    free(w->back);
    free(w->noise);
    free(w->x);
    free(w->place);
    guard_table_clear(&w->table);
    free(w);
    m->watch = NULL;
}

/* What roundings of the state change the functions by at the end of the step: both ways the smaller change, as jumps beside the point are none. */
static void take_noise(struct precise_march *m)
{
    struct precise_watch *w = m->watch;
    size_t events = (size_t)w->way.count;
    struct beside at = { m, 0, m->there.t, m->there.x };
    double *g = w->noise + events, *up = g + events, *down = up + events;
    values_at(m, m->there.t, m->there.x, g);
    memcpy(w->x, m->there.x, (size_t)m->n * sizeof *w->x);
    for (size_t e = 0; e < events; e++)
        w->noise[e] = 16 * NUM_DD_EPSILON * fabs(g[e]);
    for (int j = 0; j < m->n; j++) {
        double by = error_of(&at, j, GUARD_TOLD);
        w->x[j] = num_dd_add_d(m->there.x[j], by);
        values_at(m, m->there.t, w->x, up);
        w->x[j] = num_dd_add_d(m->there.x[j], -by);
        values_at(m, m->there.t, w->x, down);
        w->x[j] = m->there.x[j];
        for (size_t e = 0; e < events; e++) {
            double change = fmin(fabs(up[e] - g[e]), fabs(down[e] - g[e]));
            w->noise[e] += isfinite(change) ? change : 0;
        }
    }
}

static int in_order(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    double apart = num_dd_sub(p->t, q->t).hi;
    return apart != 0 ? (apart > 0) - (apart < 0) : p->event - q->event;
}

static int in_order_back(const void *a, const void *b) { return in_order(b, a); }

enum precise_stop precise_watch(struct precise_march *m, num_dd *end)
{
    struct precise_watch *w = m->watch;
    const struct traj_request *rq = m->p->rq;
    struct precise_path *path = m->path;
    enum precise_stop stop = PRECISE_GOES_ON;
    if (!w)
        return stop;
    precise_forget_events(path, path->kept);
    memcpy(w->next, w->now, (size_t)w->way.count * sizeof *w->now);
    w->places = 0;
    double step = fabs(num_dd_sub(m->there.t, m->here.t).hi), size = fmax(fabs(m->here.t.hi), fabs(m->there.t.hi));
    w->way.grain = fmax(2 * DBL_EPSILON, 2 * NUM_DD_EPSILON * size / step);
    take_noise(m);
    guard_table_fill(&w->table, &w->way);
    guard_table_monotone(&w->table, &w->way);
    const struct guard_scan scan = { .table = &w->table, .way = &w->way, .of = m, .doubt = doubt_at_end, .change = change, .touch = touch, .low = low };
    for (int e = 0; e < w->way.count; e++)
        guard_scan(&scan, e, w->next + e);
    if (!may_look(m))          /* not all were looked for; whose budget it is ends the motion */
        return PRECISE_NO_PLACE;
    if (w->places)
        qsort(w->place, (size_t)w->places, sizeof *w->place, m->direction < 0 ? in_order_back : in_order);
    int most = ode_most_events(m->n);
    for (int i = 0; i < w->places; i++) {
        const struct place *p = w->place + i;
        const struct precise_look q = look_for(m, p->event);
        bool at_once = rq->event_side && fabs(num_dd_sub(p->t, *end).hi) <= SAME_TIME * fabs(end->hi);
        if (stop != PRECISE_GOES_ON && !at_once)
            break;
        if (!deliver(&q, p->direction, p->t, p->jump))
            return PRECISE_NO_PLACE;
        if (stop == PRECISE_GOES_ON && (rq->event[p->event].stop || path->events >= most)) {
            stop = rq->event[p->event].stop ? PRECISE_STOPPED : PRECISE_TOO_MANY;
            *end = p->t;
        }
    }
    return stop;
}

void precise_watched(struct precise_march *m)
{
    struct precise_watch *w = m->watch;
    assert(m->path->kept <= m->path->events);
    m->path->kept = m->path->events;
    if (!w)
        return;
    struct guard_track *now = w->now;
    w->now = w->next;
    w->next = now;
    memset(w->back, 0, (size_t)w->way.count * sizeof *w->back);
}
