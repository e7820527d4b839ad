/* What happens along a step over a singular position: zeros of the events' functions on its curve, which guards find as on other steps. */
#include "jump_over_events.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "crossing_fine.h"
#include "flow.h"
#include "guard.h"
#include "jet.h"
#include "mem.h"
#include "sizes.h"
#include "tape.h"
#include "tolerance.h"

#define ROUNDINGS 8.0          /* of variables: what a function may be by these is 0 */
#define SURE 4                 /* times what steps of different points differ by */
#define GRAIN 1e-14            /* of the step */
#define REFINED 6              /* times that a root is found anew in double-double */
#define APART 1e-3             /* of the step: two places that its slope is from */

struct over {
    const struct crossing *c;
    const struct jump_piece *q;
    double from, way, *x, *g;  /* g: work, as many as events */
};

struct found { double s, slope; int event, direction; };

static void on_curve(void *of, double s, double *g)
{
    const struct over *w = of;
    double t = w->from + s * w->way;
    crossing_at(w->c, t, w->x, NULL);
    w->x[w->c->n] = t;
    num_tape_eval(w->c->flow->event, w->x, g);
}

/* By how much each function changes at s where variables change by so many roundings and so much of what the tolerances allow. */
static void spread(struct over *w, double s, double roundings, double allowed, double *most)
{
    enum { WAYS = 3 };
    int n = w->c->n;
    const struct sga_tolerance tolerance = { w->q->q.rtol, w->q->q.atol };
    SGA_FREED double *at = sga_malloc((size_t)w->q->q.events * sizeof *at);
    on_curve(w, s, at);
    SGA_FREED double *x = memcpy(sga_malloc(((size_t)n + 1) * sizeof *x), w->x, ((size_t)n + 1) * sizeof *x);
    for (int k = 0; k < WAYS; k++) {
        for (int j = 0; j < n; j++) {
            double unit = w->c->flow->sizes->unit[j];
            double by = roundings * DBL_EPSILON * fmax(fabs(x[j]), unit) + allowed * sga_allowed(tolerance, unit, x[j]);
            w->x[j] = x[j] + (k == 0 || (k == 1 && j % 2) || (k == 2 && j % 3 == 1) ? by : -by);
        }
        num_tape_eval(w->c->flow->event, w->x, w->g);
        for (int e = 0; e < w->q->q.events; e++)
            most[e] = fmax(most[e], fabs(w->g[e] - at[e]));
    }
}

/* Near the place points are known less well on the constraints: what is not smooth in a function there is that. */
static void add_flicker(struct over *w, double *noise)
{
    enum { HALVINGS = 14 };
    static const double BESIDE = 1e-7;         /* of the step: what is smooth is a line so far */
    int events = w->q->q.events;
    SGA_FREED double *sum = sga_malloc((size_t)events * sizeof *sum);
    double aside = 0.4;
    for (int k = 0; k < 2 * HALVINGS; k++, aside *= k % 2 ? 1 : 0.5)
        for (int i = -1; i <= 1; i++) {
            on_curve(w, 0.5 + (k % 2 ? aside : -aside) + i * BESIDE, w->g);
            for (int e = 0; e < events; e++) {
                sum[e] = (i < 0 ? 0 : sum[e]) + (i ? w->g[e] : -2 * w->g[e]);
                noise[e] = i > 0 ? fmax(noise[e], 2 * fabs(sum[e])) : noise[e];
            }
        }
}

static double slope_at(struct over *w, int e, double s)
{
    double a = fmax(s - APART, 0), b = fmin(s + APART, 1), ga;
    on_curve(w, a, w->g);
    ga = w->g[e];
    on_curve(w, b, w->g);
    return (w->g[e] - ga) / ((b - a) * w->way);
}

/* Where the function has its extreme near s: that of the parabola through three places. */
static double touched(struct over *w, int e, double s)
{
    static const double ASIDE[] = { 1e-3, 3e-5, 3e-5 };
    for (size_t k = 0; k < sizeof ASIDE / sizeof *ASIDE; k++) {
        double g[3];
        for (int i = 0; i < 3; i++) {
            on_curve(w, s + (i - 1) * ASIDE[k], w->g);
            g[i] = w->g[e];
        }
        double by = 0.5 * ASIDE[k] * (g[0] - g[2]) / (g[0] - 2 * g[1] + g[2]);
        s = fabs(by) <= APART && s + by > APART && s + by < 1 - APART ? s + by : s;
    }
    return s;
}

static int in_order(const void *a, const void *b)
{
    const struct found *p = a, *q = b;
    return p->s != q->s ? (p->s > q->s) - (p->s < q->s) : p->event - q->event;
}

/* Both ends of the step are points of the constraints, which keep the function at 0: what it is between is what the curve lies beside them. */
static bool is_kept(const struct guard_table *table, double noise, int e)
{
    static const double AT_ENDS = 0.01, BETWEEN = 16;
    double most = 0;
    for (int i = 0; i < table->nodes; i++)
        most = fmax(most, fabs(guard_value(table, i, e)));
    return fabs(guard_value(table, 0, e)) <= AT_ENDS * noise && fabs(guard_value(table, table->nodes - 1, e)) <= AT_ENDS * noise && most <= BETWEEN * noise;
}

/* Zeros of function e of the table into found: changes of its sign, and touches where these are asked for. */
static int scan(struct over *w, const struct guard_way *way, const struct guard_table *table, int e, struct found *found)
{
    const struct traj_event *event = w->q->q.event + e;
    int sign = 0, count = 0, lowest = -1;
    double a = 0, ga = 0;
    if (is_kept(table, way->noise[e], e))
        return 0;
    for (int i = 0; i < table->nodes; i++) {
        double v = guard_value(table, i, e);
        int now = fabs(v) > way->noise[e] ? v > 0 ? 1 : -1 : 0;
        if (!isfinite(v)) {
            sign = 0;
            continue;
        }
        if (!now) {            /* 0, as far as roundings tell */
            lowest = sign && (lowest < 0 || fabs(v) < fabs(guard_value(table, lowest, e))) ? i : lowest;
            continue;
        }
        int sense = w->way < 0 ? -now : now;
        if (sign && now != sign && (!event->direction || event->direction == sense)) {
            double s = guard_root(way, e, a, ga, table->theta[i], v, table->g);
            found[count++] = (struct found){ s, slope_at(w, e, s), e, sense };
        } else if (sign == now && lowest >= 0 && !event->direction) {
            double s = table->theta[lowest];
            found[count++] = (struct found){ s > 2 * APART && s < 1 - 2 * APART ? touched(w, e, s) : s, 0, e, 0 };
        }
        sign = now;
        a = table->theta[i];
        ga = v;
        lowest = -1;
    }
    return count;
}

static num_dd fine_value(struct crossing_fine *f, struct num_jet2 *jet, int e, num_dd t, num_dd *x)
{
    crossing_fine_at(f, t, x, NULL);
    for (int j = 0; j < f->p.n; j++)
        num_jet2_input(jet, j)[0] = x[j];
    num_jet2_input(jet, f->p.n)[0] = t;
    return num_jet2_next(jet, 0) ? num_jet2_root(jet, e)[0] : num_dd_of(NAN);
}

/* The extreme near t on it. */
static num_dd touched_finely(struct crossing_fine *f, struct num_jet2 *jet, int e, double t, num_dd *x)
{
    static const double ASIDE[] = { 1e-5, 1e-9, 1e-9 };         /* of the step */
    num_dd at = num_dd_of(t);
    for (size_t k = 0; k < sizeof ASIDE / sizeof *ASIDE; k++) {
        double h = ASIDE[k] * fabs(f->to - f->from);
        num_dd a = fine_value(f, jet, e, num_dd_add_d(at, -h), x), b = fine_value(f, jet, e, at, x), c = fine_value(f, jet, e, num_dd_add_d(at, h), x);
        double by = 0.5 * h * num_dd_sub(a, c).hi / num_dd_sub(num_dd_add(a, c), num_dd_scale(b, 2)).hi;
        at = fabs(by) <= 100 * h ? num_dd_add_d(at, by) : at;
    }
    return at;
}

/* The root near t on the curve in double-double. */
static num_dd refined(struct crossing_fine *f, struct num_jet2 *jet, const struct found *z, double t, num_dd *x)
{
    num_dd at = num_dd_of(t);
    double a = fmin(f->from, f->to), b = fmax(f->from, f->to), edge = APART * (b - a);
    if (z->slope == 0)
        return z->direction == 0 && t > a + edge && t < b - edge ? touched_finely(f, jet, z->event, t, x) : at;
    for (int k = 0; k < REFINED; k++) {
        num_dd by = num_dd_mul_d(fine_value(f, jet, z->event, at, x), -1 / z->slope), next = num_dd_add(at, by);
        if (!(fabs(by.hi) <= APART * fabs(f->to - f->from)) || !(next.hi >= a && next.hi <= b))
            break;
        at = next;
    }
    return at;
}

static void tell(struct jump_pass *p, struct over *w, const struct found *z, double doubt, struct crossing_fine *f, struct num_jet2 *jet)
{
    size_t columns = (size_t)w->q->columns, n = (size_t)w->c->n, room = columns + n + 1;
    num_dd t = num_dd_of(w->from + z->s * w->way);
    SGA_FREED double *y = sga_malloc(room * sizeof *y);
    double error = z->slope != 0 ? doubt / fabs(z->slope) : INFINITY;
    if (f) {
        SGA_FREED num_dd *x = sga_malloc(2 * room * sizeof *x);
        t = refined(f, jet, z, t.hi, x);
        crossing_fine_at(f, t, x, x + room);
        error = z->slope != 0 ? f->error * doubt / fabs(z->slope) : INFINITY;
        jump_tell_digits(p, (struct traj_happening){ w->q->whole[z->event], z->direction, t.hi, error, false }, t, x + room);
        return;
    }
    crossing_at(w->c, t.hi, w->x, y);
    jump_tell(p, (struct traj_happening){ w->q->whole[z->event], z->direction, t.hi, error + DBL_EPSILON * fabs(t.hi), false }, y);
}

static bool told_enough(const struct jump_pass *p, const struct traj_request *rq, int e)
{
    int told = 0;
    for (int i = 0; i < p->r.happened; i++)
        told += p->r.happening[i].event == e;
    return rq->event[e].most && told >= rq->event[e].most;
}

void jump_over_events(struct jump_pass *p, struct jump_piece *q, const struct traj_request *rq, const struct crossing *c, struct crossing_fine *f)
{
    size_t events = (size_t)q->q.events;
    if (!events)
        return;
    SGA_FREED double *x = sga_calloc((size_t)c->n + 1 + 3 * events, sizeof *x);
    double *noise = x + c->n + 1 + events, *doubt = noise + events;
    struct over w = { c, q, f ? f->from : c->from, f ? f->to - f->from : c->to - c->from, x, x + c->n + 1 };
    struct guard_way way = { .count = (int)events, .at = on_curve, .of = &w, .grain = GRAIN, .noise = noise, .budget = rq->budget };
    for (int k = 0; k <= 4; k++)
        spread(&w, 0.25 * k, ROUNDINGS, SURE * c->error, noise);
    add_flicker(&w, noise);
    struct guard_table table;
    guard_table_init(&table, (int)events);
    guard_table_fill(&table, &way);
    guard_table_monotone(&table, &way);
    SGA_FREED struct found *found = sga_malloc((size_t)(table.nodes + 1) * events * sizeof *found);
    int count = 0;
    for (int e = 0; e < (int)events; e++)
        count += scan(&w, &way, &table, e, found + count);
    qsort(found, (size_t)count, sizeof *found, in_order);
    struct num_jet2 *jet = f ? num_jet2_new(c->flow->event, 0) : NULL;
    for (int k = 0; k < count; k++) {
        memset(doubt, 0, events * sizeof *doubt);
        spread(&w, found[k].s, f ? 1 / DBL_EPSILON : ROUNDINGS, f ? 0 : c->error, doubt);      /* f->error: by the sizes of variables */
        if (!told_enough(p, rq, q->whole[found[k].event]))
            tell(p, &w, found + k, doubt[found[k].event], f, jet);
    }
    num_jet2_free(jet);
    guard_table_clear(&table);
}
