/* Events: places where a function of time and state passes 0, found on the dense output.
 *
 * In each step the functions are tabulated on the step's polynomial, at their extremes too (guard.h). A change
 * of sign is located to the rounding of time. Between
 * three values of one sign with the least in the middle, the minimum is searched: deeper
 * than the error allowed makes beyond 0, or than the steps' errors were so far, it is two passages, within it a touch. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guard_track.h"
#include "march.h"
#include "mem.h"

#define SAMPLE_MOST 10.0
/* Of times: as one. */
static const double SAME_TIME = 1e-13;
/* Of a variable's size: where jumps of functions are looked for around an event's place; what a start is found to. */
static const double PLACE = 1e-4, FOUND_TO = 1e-13;
/* Of a step: for a function's slope, which is one where it is so much alike on both sides. Of times: what need not be mended. */
static const double ASIDE = 1e-3, NEARER = 32, ALIKE = 4, ROUNDED = 8 * DBL_EPSILON;

struct place { double theta; int event, crossing; };

struct ode_watch {
    int count, places, room;
    struct guard_track *now, *next;
    struct ode_way way;
    struct guard_table table;
    double *y;
    struct place *place;
};

static double value_at(struct ode_march *m, int e, double theta)
{
    struct ode_watch *w = m->watch;
    w->way.way.at(&w->way, theta, w->table.g);
    return w->table.g[e];
}

static double root(struct ode_march *m, int e, double a, double ga, double b, double gb)
{
    return guard_root(&m->watch->way.way, e, a, ga, b, gb, m->watch->table.g);
}

static double *values(struct ode_march *m, double t, const double *x)
{
    m->p->event(m->p->ctx, t, x, m->watch->table.g);
    return m->watch->table.g;
}

/* One of the functions at t beside the watch's y, which is a copy of the state; the last argument is time. */
struct beside { struct ode_march *m; int event; double t; };

static double value_beside(void *ctx, int j, double by)
{
    const struct beside *b = ctx;
    bool time = j == b->m->p->n, one = j >= 0 && !time;
    double *y = b->m->watch->y, keep = one ? y[j] : 0;
    if (one)
        y[j] += by;
    double g = values(b->m, time ? b->t + by : b->t, y)[b->event];
    if (one)
        y[j] = keep;
    return g;
}

/* The time of the motion, of which its place in time is known to a part. */
static double time_size(const struct ode_march *m) { return fmax(fabs(m->t), fabs(m->stop - m->t)); }

static double error_of(void *ctx, int j, enum guard_errors which)
{
    const struct ode_march *m = ((struct beside *)ctx)->m;
    bool time = j == m->p->n;
    double x = time ? 0 : m->watch->y[j], size = time ? time_size(m) : fabs(x), unit = time ? size : m->unit[j];
    return which == GUARD_TOLD ? ODE_TOLD * size : which == GUARD_FOUND ? FOUND_TO * fmax(size, unit) : which == GUARD_PLACE ? PLACE * fmax(size, unit)
           : ode_allowed(m->o->rtol, m->o->atol, unit, x, x);
}

static struct guard_point point_of(struct beside *b, const double *x)
{
    memmove(b->m->watch->y, x, (size_t)b->m->p->n * sizeof *x);
    return (struct guard_point){ { value_beside, b, b->m->p->n + 1 }, error_of, 4 * DBL_EPSILON };
}

static double doubt(struct ode_march *m, int e, double t, const double *x, enum guard_errors which)
{
    struct beside at = { m, e, t };
    const struct guard_point p = point_of(&at, x);
    return guard_doubt(&p, which, NULL);
}

void ode_watch_begin(struct ode_march *m)
{
    size_t e = (size_t)m->p->events, n = (size_t)m->p->n;
    if (!e)
        return;
    struct ode_watch *w = m->watch = sga_calloc(1, sizeof *w);
    w->count = m->p->events;
    w->now = sga_calloc(2 * e, sizeof *w->now);
    w->next = w->now + e;
    ode_way_begin(&w->way, m, w->count, m->p->event);
    guard_table_init(&w->table, w->count);
    w->y = sga_malloc((n + 1) * sizeof *w->y);
}

void ode_watch_start(struct ode_march *m)
{
    for (int e = 0; m->watch && e < m->watch->count; e++) {
        int side = m->p->event_side ? m->p->event_side[e] : ODE_SIDE_FRESH;
        struct beside at = { m, e, m->t };
        const struct guard_point p = point_of(&at, m->x);
        guard_track_start(m->watch->now + e, &p, side == 1 || side == -1 ? side : 0, side == ODE_SIDE_FRESH);
    }
}

void ode_watch_end(struct ode_march *m)
{
    struct ode_watch *w = m->watch;
    if (!w)
        return;
    free(w->now < w->next ? w->now : w->next);
    ode_way_end(&w->way);
    guard_table_clear(&w->table);
    free(w->y);
    free(w->place);
    free(w);
    m->watch = NULL;
}

static void add(struct ode_march *m, int e, double theta, int crossing)
{
    struct ode_watch *w = m->watch;
    int wanted = m->p->event_spec[e].direction, sense = crossing * (m->direction < 0 ? -1 : 1);
    if (wanted && wanted != sense)
        return;
    if (w->places == w->room) {
        w->room = 2 * w->room + 16;
        w->place = sga_realloc(w->place, (size_t)w->room * sizeof *w->place);
    }
    assert(theta >= 0 && theta <= 1 && e < w->count);
    w->place[w->places++] = (struct place){ theta, e, sense };
}

/* At an end of the step; where it begins, roundings of its time too, a switch of the function. */
static double doubt_at_end(void *of, int e, bool last)
{
    struct ode_march *m = of;
    const struct guard_table *w = &m->watch->table;
    if (last)
        return doubt(m, e, m->t1, m->x1, GUARD_ALLOWED);
    double by_time = ODE_TOLD * fmax(fabs(m->t), fabs(m->t1)) / fabs(m->step.h) * fabs(guard_value(w, 1, e) - guard_value(w, 0, e)) / w->theta[1];
    return doubt(m, e, m->t, m->x, GUARD_ALLOWED) + by_time;
}

static void change(void *of, int e, double a, double ga, double b, double gb, int sense)
{
    struct ode_march *m = of;
    add(m, e, b > 0 ? root(m, e, a, ga, b, gb) : 0, sense);
}

static void touch(void *of, int e) { add(of, e, 0, 0); }

/* Deeper than its errors make it: two passages. */
static double low(void *of, const struct guard_low *l)
{
    struct ode_march *m = of;
    int e = l->d.function, sign = l->d.sense;
    double s = l->d.at, g = sign * l->d.value, left = l->left;
    double flat = fmax(fabs(value_at(m, e, l->d.a) - g), fabs(value_at(m, e, l->d.b) - g));              /* the place is not known better */
    value_at(m, e, s);
    double *x = m->watch->way.x, t = m->t + (s * m->step.h + m->t_low), unsure = doubt(m, e, t, x, GUARD_ALLOWED) + flat;
    value_at(m, e, s);
    unsure = fmin(unsure, flat + doubt(m, e, t, x, GUARD_TOLD) + ODE_ERRORS * ode_errors(m) * unsure);
    if (sign * g < -unsure) {
        add(m, e, root(m, e, left, l->left_value, s, g), -sign);
        add(m, e, root(m, e, s, g, l->right, l->right_value), sign);
    } else if (fabs(g) <= unsure) {
        for (int r = 0; g == 0 && r < 60; r++) {      /* 0 from somewhere on: there */
            double u = 0.5 * (left + s);
            *(value_at(m, e, u) == 0 ? &s : &left) = u;
        }
        add(m, e, s, 0);
        return unsure;
    }
    return -1;
}

static int by_theta(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    return p->theta != q->theta ? (p->theta > q->theta) - (p->theta < q->theta) : p->event - q->event;
}

/* The function's slope between theta and so much of the step before and behind; 0: the two are not alike. */
static double slope_within(struct ode_march *m, const struct place *p, double aside)
{
    double from = fmax(p->theta - aside, 0), to = fmin(p->theta + aside, 1);
    if (!(from < p->theta && p->theta < to))
        return 0;
    double at = value_at(m, p->event, p->theta);
    double left = (at - value_at(m, p->event, from)) / (p->theta - from), right = (value_at(m, p->event, to) - at) / (to - p->theta);
    bool line = left * right > 0 && fabs(left) < ALIKE * fabs(right) && fabs(right) < ALIKE * fabs(left);
    return line && isfinite(left + right) ? 0.5 * (left + right) : 0;
}

/* How fast the function passes 0 there; 0 where it does not pass it as a line does, or jumps: what seems a slope then is steeper the nearer one looks. */
static double slope_at(struct ode_march *m, const struct place *p)
{
    double slope = p->crossing ? slope_within(m, p, ASIDE) : 0, nearer = slope != 0 ? slope_within(m, p, ASIDE / NEARER) : 0;
    return slope * nearer > 0 && fabs(nearer) < ALIKE * fabs(slope) && fabs(slope) < ALIKE * fabs(nearer) ? slope / m->step.h : 0;
}

/* The motion's point at a place of the step, on the constraints; its time. */
static bool point_at(struct ode_march *m, double theta, double *t, double *x)
{
    double residual;
    *t = theta >= 1 ? m->t1 : m->t + (theta * m->step.h + m->t_low);
    if (theta >= 1) {
        memcpy(x, m->x1, (size_t)m->p->n * sizeof *x);
        return true;
    }
    m->method->dense_at(m->state, &m->step, theta, x);
    return ode_settle(m, *t, x, SAMPLE_MOST, &residual);
}

/* The polynomial of a step lies beside the constraints, by more than its ends do: where a point of it was moved onto these, the function is 0 a little before or
 * after. */
static void polish(struct ode_march *m, int event, double slope, double theta, double *t, double *x)
{
    enum { TURNS = 3 };
    double *y = m->watch->y, u = theta, at;
    for (int turn = 0; turn < TURNS && m->p->project && slope != 0; turn++) {
        double by = -values(m, *t, x)[event] / (slope * m->step.h);
        u += by;
        if (!(fabs(by * m->step.h) > ROUNDED * fmax(fabs(m->t), fabs(m->t1))) || !(fabs(u - theta) < ASIDE) || !(u > 0 && u < 1) || !point_at(m, u, &at, y))
            return;
        *t = at;
        memcpy(x, y, (size_t)m->p->n * sizeof *x);
    }
}

static bool deliver(struct ode_march *m, const struct place *p)
{
    struct ode_result *r = m->res;
    size_t n = (size_t)m->p->n, at = (size_t)r->happened;
    double t, slope = slope_at(m, p);
    if ((at & (at + 1)) == 0) {        /* room for powers of 2 */
        r->happening = sga_realloc(r->happening, 2 * (at + 1) * sizeof *r->happening);
        r->happened_x = sga_realloc(r->happened_x, 2 * (at + 1) * (n + 1) * sizeof *r->happened_x);
    }
    double *x = r->happened_x + at * n;
    if (!point_at(m, p->theta, &t, x))
        return false;
    polish(m, p->event, slope, p->theta, &t, x);
    if (at && (t - r->happening[at - 1].t) * m->direction < 0)        /* at once */
        t = r->happening[at - 1].t;
    r->happening[r->happened++] = (struct ode_happening){ p->event, p->crossing, t, INFINITY, slope };
    return true;
}

/* A place at the time of the one that stopped the motion. */
static bool at_once(const struct ode_march *m, double from, const struct place *p)
{
    return m->p->event_side && (p->theta - from) * fabs(m->step.h) <= SAME_TIME * fmax(fabs(m->t), fabs(m->t1));
}

enum ode_refusal ode_watch_step(struct ode_march *m, int *through)
{
    struct ode_watch *w = m->watch;
    if (!w)
        return STEP_TAKEN;
    if (!m->dense_checked && !m->method->dense_begin(m->state, &m->field, &m->step))
        return FIELD_REFUSED;
    m->dense_checked = true;
    if (!(m->step.dense_error <= 1)) {
        m->error = m->step.dense_error;
        return ERROR_TOO_LARGE;
    }
    memcpy(w->next, w->now, (size_t)w->count * sizeof *w->now);
    w->places = 0;
    guard_table_fill(&w->table, ode_way_ready(&w->way));
    guard_table_monotone(&w->table, &w->way.way);
    const struct guard_scan scan = { .table = &w->table, .way = &w->way.way, .of = m, .doubt = doubt_at_end, .change = change, .touch = touch, .low = low };
    for (int e = 0; e < w->count; e++)
        guard_scan(&scan, e, w->next + e);
    if (w->places)
        qsort(w->place, (size_t)w->places, sizeof *w->place, by_theta);
    int before = m->res->happened, most = ode_most_events(m->p->n);
    m->stopped = false;
    double from = 0;
    for (int i = 0; i < w->places && (!m->stopped || at_once(m, from, w->place + i)); i++) {
        if (!deliver(m, w->place + i)) {
            m->res->happened = before;
            return MANIFOLD_REFUSED;
        }
        if (!m->stopped)
            from = w->place[i].theta;
        m->stopped |= m->p->event_spec[w->place[i].event].stop || m->res->happened >= most;
    }
    double end = m->stopped ? m->res->happening[m->res->happened - 1].t : 0;
    while (m->stopped && *through > m->next && (m->start->times[*through - 1] - end) * m->direction > 0)
        --*through;
    struct guard_track *k = w->now;
    w->now = w->next;
    w->next = k;
    return STEP_TAKEN;
}

void ode_end_event(struct ode_march *m)
{
    assert(m->res->happened > 0);        /* the one that stopped it */
    const struct ode_happening *h = m->res->happening + m->res->happened - 1, *last = h;
    while (m->p->event_side && h > m->res->happening && !m->p->event_spec[h->event].stop && fabs(h[-1].t - last->t) <= SAME_TIME * fabs(last->t))
        h--;                   /* what happened at once with it */
    bool stop = m->p->event_spec[h->event].stop;
    h = last;
    ode_end_at(m, stop ? ODE_EVENT : ODE_STEP_LIMIT,
               stop ? "an event that stops the motion" : "more events were found than a result may hold");
    m->res->end.t = h->t;
    m->res->end.variable = -1;
}
