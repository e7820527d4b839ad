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

#include "beside.h"
#include "march.h"
#include "mem.h"

enum { MOST_FOUND = 100000, MOST_NUMBERS = 10000000 };     /* events, and numbers in all states at events */
#define SAMPLE_MOST 10.0
/* Of times: as one. */
static const double SAME_TIME = 1e-13;
/* Of a variable's size: where jumps of functions are looked for around an event's place. */
static const double PLACE = 1e-4;
/* Of a step: for a function's slope, which is one where it is so much alike on both sides. Of times: what need not be mended. */
static const double ASIDE = 1e-3, ALIKE = 4, ROUNDED = 8 * DBL_EPSILON;

static const double STEPS = 2;         /* errors allowed that places on a step may be off by */

struct track {
    signed char sign;          /* of the last value that was not 0; 0: none yet */
    bool touched;              /* 0 was touched, and not left yet */
    bool carried;              /* sign is what the motion before says; no value was far enough from 0 to tell since */
    bool jumps;                /* at the start: its value there is that of one side of a jump, or between */
    double least;              /* values up to this do not tell from 0, at the start or a touch */
    double before;             /* the last value before the present point */
};

struct place { double theta; int event, crossing; };

struct ode_watch {
    int count, places, room;
    struct track *now, *next;
    struct ode_way way;
    struct guard_table table;
    double *y, *by;
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

/* One of the functions at t beside the watch's y, which is a copy of x; the last argument is time. */
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

/* Errors of x that the function is asked with: those that are allowed, roundings, or those of a start that was found. */
enum errors { ALLOWED, TOLD, FOUND };
static const double FOUND_TO = 1e-13;      /* of a variable's size */

static double error_of(const struct ode_march *m, int j, double x, enum errors which)
{
    double size = fabs(x), unit = m->unit[j];
    return which == TOLD ? ODE_TOLD * size : which == FOUND ? FOUND_TO * fmax(size, unit) : ode_allowed(m->o->rtol, m->o->atol, unit, x, x);
}

/* By how much errors of x change the function. *jumps (or NULL): true where it jumps among them. */
static double doubt_and_jump(struct ode_march *m, int e, double t, const double *x, enum errors which, bool *jumps)
{
    struct beside at = { m, e, t };
    const struct ode_beside b = { value_beside, &at, m->p->n };
    double *y = m->watch->y;
    memmove(y, x, (size_t)m->p->n * sizeof *y);
    double g = value_beside(&at, -1, 0), sum = 4 * DBL_EPSILON * fabs(g);
    for (int j = 0; j < m->p->n; j++)
        sum += ode_beside_change(&b, g, j, error_of(m, j, y[j], which), jumps);
    return sum;
}

/* The time of the motion, of which its place in time is known to a part. */
static double time_size(const struct ode_march *m) { return fmax(fabs(m->t), fabs(m->stop - m->t)); }

static double doubt_of(struct ode_march *m, int e, double t, const double *x, enum errors which) { return doubt_and_jump(m, e, t, x, which, NULL); }

/* Whether it jumps at m->x, to what the place of an event is known to. */
static bool jumps_here(struct ode_march *m, int e)
{
    struct ode_watch *w = m->watch;
    struct beside at = { m, e, m->t };
    memcpy(w->y, m->x, (size_t)m->p->n * sizeof *w->y);
    for (int j = 0; j < m->p->n; j++)
        w->by[j] = PLACE * fmax(fabs(m->x[j]), m->unit[j]);
    w->by[m->p->n] = PLACE * time_size(m);
    return ode_beside_jumps(&(struct ode_beside){ value_beside, &at, m->p->n + 1 }, w->by);
}

static double doubt(struct ode_march *m, int e, double t, const double *x) { return doubt_of(m, e, t, x, ALLOWED); }

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
    w->y = sga_malloc(2 * (n + 1) * sizeof *w->y);
    w->by = w->y + n + 1;
}

void ode_watch_start(struct ode_march *m)
{
    for (int e = 0; m->watch && e < m->watch->count; e++) {
        struct track *k = m->watch->now + e;
        double g = values(m, m->t, m->x)[e];
        int side = m->p->event_side ? m->p->event_side[e] : ODE_SIDE_FRESH;
        k->jumps = false;
        k->least = doubt_and_jump(m, e, m->t, m->x, side != ODE_SIDE_FRESH ? TOLD : ALLOWED, &k->jumps);
        if (side == ODE_SIDE_FRESH)        /* what is small beside the errors allowed is not small beside those of the start */
            k->least = fmin(k->least, doubt_of(m, e, m->t, m->x, FOUND));
        ode_beside_change(&(struct ode_beside){ value_beside, &(struct beside){ m, e, m->t }, m->p->n + 1 }, g, m->p->n, ODE_TOLD * time_size(m), &k->jumps);
        k->before = g;
        k->carried = side == 1 || side == -1;
        k->jumps = k->carried ? fabs(g) > k->least && jumps_here(m, e) : k->jumps;
        if (k->carried && !k->jumps)        /* the place of the event itself is known to roundings of its time only */
            k->least = 4 * (k->least + fabs(g));
        k->sign = k->carried ? (signed char)side : fabs(g) > k->least && !k->jumps ? (g > 0 ? 1 : -1) : 0;
        if (!k->sign && !k->carried && !k->jumps)      /* steps come beside 0 by what they may err (a function that constraints keep at 0) */
            k->least = fmax(k->least, STEPS * doubt(m, e, m->t, m->x));
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

/* |g| has a minimum between the nodes i-1 and i+1, where its sign is one. */
static void dip(struct ode_march *m, int e, int i, struct track *k)
{
    const struct guard_table *w = &m->watch->table;
    double left = w->theta[i - 1], right = w->theta[i + 1], s = w->theta[i];
    double ga = guard_value(w, i - 1, e), g = guard_value(w, i, e), gb = guard_value(w, i + 1, e);
    /* what a parabola says; far from 0 it need not be looked at */
    double p = s - left, q = right - s, slope = ((g - ga) / p * q + (gb - g) / q * p) / (p + q);
    double curve = ((gb - g) / q - (g - ga) / p) / (p + q), reach = curve != 0 ? slope * slope / (4 * curve) : 0;
    if (k->sign * (g - reach) > 0.5 * fabs(g) && fabs(g) > 0.5 * fmin(fabs(ga), fabs(gb)))
        return;
    const struct guard_way *way = &m->watch->way.way;
    struct guard_dip d = { .a = left, .at = s, .b = right, .value = k->sign * g, .function = e, .sense = k->sign };
    guard_least(way, &d, way->grain, m->watch->table.g);
    s = d.at;
    g = k->sign * d.value;
    double flat = fmax(fabs(value_at(m, e, d.a) - g), fabs(value_at(m, e, d.b) - g));              /* the place is not known better */
    value_at(m, e, s);
    double *x = m->watch->way.x, t = m->t + (s * m->step.h + m->t_low), unsure = doubt(m, e, t, x) + flat;
    value_at(m, e, s);
    unsure = fmin(unsure, flat + doubt_of(m, e, t, x, TOLD) + ODE_ERRORS * ode_errors(m) * unsure);
    if (k->sign * g < -unsure) {
        add(m, e, root(m, e, left, ga, s, g), -k->sign);
        add(m, e, root(m, e, s, g, right, gb), k->sign);
    } else if (fabs(g) <= unsure) {
        for (int r = 0; g == 0 && r < 60; r++) {      /* 0 from somewhere on: there */
            double u = 0.5 * (left + s);
            *(value_at(m, e, u) == 0 ? &s : &left) = u;
        }
        add(m, e, s, 0);
        k->touched = true;
        k->least = unsure;
    }
}

/* By how much roundings of the time at which a step begins, a switch of the function, change it; `after`: its value at the next node. */
static double by_time(const struct ode_march *m, double v, double after)
{
    return ODE_TOLD * fmax(fabs(m->t), fabs(m->t1)) / fabs(m->step.h) * fabs(after - v) / m->watch->table.theta[1];
}

static void scan(struct ode_march *m, int e)
{
    const struct guard_table *w = &m->watch->table;
    struct track *k = m->watch->next + e;
    double before = k->before, last = 0, at = 0;
    for (int i = 0; i < w->nodes; i++) {
        double v = guard_value(w, i, e);
        double after = i + 1 < w->nodes ? guard_value(w, i + 1, e) : NAN;
        if (!isfinite(v)) {
            k->sign = 0;
            before = NAN;
            continue;
        }
        if ((k->carried && fabs(v) <= k->least) || (k->jumps && i == 0)) {      /* 0, where the motion before ended */
            before = v;
            at = w->theta[i];
            continue;
        }
        k->carried = k->jumps = false;
        if (i == 0 && k->touched && fabs(v) <= k->least) {      /* still on it, perhaps moved by a rounding to the side it came from */
            before = v;
            at = w->theta[i];
            continue;
        }
        if (fabs(v) > k->least)
            k->touched = false;
        if (!k->sign) {
            k->sign = fabs(v) > k->least ? (v > 0 ? 1 : -1) : 0;
        } else if (i > 0 && !k->touched && v * k->sign < 0 && last * k->sign > 0 && after * k->sign > 0) {
            dip(m, e, i, k);           /* its lowest place is a node */
        } else if (v * k->sign < 0) {
            /* the last value may be 0 itself, where it was a node */
            if (!k->touched)
                add(m, e, i ? root(m, e, at, last != 0 ? last : -v, w->theta[i], v) : 0, -k->sign);
            k->sign = (signed char)-k->sign;
            k->touched = false;
            if (i + 1 == w->nodes && fabs(v) <= (k->least = doubt(m, e, m->t1, m->x1)))
                k->touched = true;      /* the next step begins on it: that is no second event */
        } else if (!k->touched && fabs(v) < fabs(before) && fabs(v) <= fabs(after) && before * k->sign >= 0 && after * k->sign >= 0) {
            if (i > 0) {
                dip(m, e, i, k);
            } else if (fabs(v) <= (k->least = doubt(m, e, m->t, m->x) + by_time(m, v, after))) {
                add(m, e, 0, 0);
                k->touched = true;
            }
        }
        before = i + 1 < w->nodes ? v : before;
        last = v;
        at = w->theta[i];
    }
    k->before = before;
}

static int by_theta(const void *a, const void *b)
{
    const struct place *p = a, *q = b;
    return p->theta != q->theta ? (p->theta > q->theta) - (p->theta < q->theta) : p->event - q->event;
}

/* How fast the function passes 0 there; 0 where it does not pass it as a line does, or jumps. */
static double slope_at(struct ode_march *m, const struct place *p)
{
    double from = fmax(p->theta - ASIDE, 0), to = fmin(p->theta + ASIDE, 1);
    if (!p->crossing || !(from < p->theta && p->theta < to))
        return 0;
    double at = value_at(m, p->event, p->theta);
    double left = (at - value_at(m, p->event, from)) / (p->theta - from), right = (value_at(m, p->event, to) - at) / (to - p->theta);
    bool line = left * right > 0 && fabs(left) < ALIKE * fabs(right) && fabs(right) < ALIKE * fabs(left);
    return line && isfinite(left + right) ? 0.5 * (left + right) / m->step.h : 0;
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
    for (int e = 0; e < w->count; e++)
        scan(m, e);
    if (w->places)
        qsort(w->place, (size_t)w->places, sizeof *w->place, by_theta);
    int before = m->res->happened, most = MOST_NUMBERS / (m->p->n + 1) < MOST_FOUND ? MOST_NUMBERS / (m->p->n + 1) : MOST_FOUND;
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
    struct track *k = w->now;
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
