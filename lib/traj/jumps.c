/* Motions with events that set variables: pieces, joined; and their errors, by a second motion. */
#include "jumps.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "crossing.h"
#include "jump_slope.h"
#include "jump_turn.h"
#include "larger.h"
#include "mem.h"
#include "ode.h"
#include "rows_kept.h"
#include "slide.h"
#include "system.h"
#include "tolerance.h"

/* Motions that are compared at the most; events that set in one of them; intervals of no time before they are said to have no end; and the
 * steps by which the tolerances shrink. */
enum { MOST_PASSES = 4, MOST_JUMPS = 20000, AT_ONCE = 3 };
static const double TIGHTER = 0.1;
/* Times as one, by their size; what is set is wrong by so much in the looser motion. */
static const double SAME_TIME = 1e-13, WRONG = 4 * DBL_EPSILON;
/* Times have a limit where it is so near, by the whole way, and intervals shrink by the same factor, but for this part of what it is below 1. */
static const double LIMIT_NEAR = 1e-6, ALIKE = 0.02;
/* One that ended rows of shrinking intervals without time after it: what was between was smaller than errors. */
static const double UNSEEN = 1e-3;
/* The same, for an event whose function stood still after it and that happens again at once: by roundings that fall. */
static const double STANDS = 1e-4;

/* One motion, of all its pieces. */
struct pass {
    struct traj_result r;         /* joined; `error`s are what pieces have for their own */
    double *each;                 /* rows x columns: those errors */
    double *at; int jumps, room;  /* times of events that set */
    int *count;                   /* by event: how often it did */
    double end_error;             /* of an accumulation's time */
    double direction;             /* of the motion in time: 1 or -1 */
    size_t leg_room, slide_room;
    bool stood;                   /* after the event before the last what it looks at stood still, and did so again */
    size_t happening_room;
};

bool jumps_any(const struct traj_request *rq)
{
    bool any = false;
    for (int e = 0; e < rq->events; e++)
        any |= rq->event[e].sets > 0 || rq->event[e].turns;
    return any;
}

static void pass_clear(struct pass *p)
{
    traj_result_clear(&p->r);
    free(p->each);
    free(p->at);
    free(p->count);
    *p = (struct pass){ 0 };
}

/* The request of a piece: columns are those asked for, then all variables. */
struct piece {
    struct traj_request q;
    expr_id *output;
    struct traj_event *event;
    signed char *side, *all_side;  /* by event of the piece; of the request */
    unsigned char *stands;        /* by event of the request: its function stands at 0 where the piece begins */
    int *whole;                   /* by event of the piece: that of the request */
    double *x;
    unsigned char *given, *held;
    int columns;                  /* that are kept */
};

/* Of a motion that is differentiated: variables and derivatives. */
static struct traj_mode carried(const struct traj_mode *m)
{
    const struct traj_carried *c = m->rq->carried;
    return c ? (struct traj_mode){ .sys = c->sys, .sol = c->sol, .rq = c->rq } : *m;
}

static void piece_init(struct piece *p, const struct traj_mode *mode, double tighter, double rows_until)
{
    const struct traj_mode of = carried(mode);
    const struct sys_system *sys = of.sys;
    const struct traj_request *rq = of.rq;
    size_t n = (size_t)sys->variables, events = (size_t)rq->events;
    *p = (struct piece){ .q = *rq, .columns = rq->outputs ? rq->outputs : sys->variables };
    p->output = sga_malloc((n + (size_t)rq->outputs + 1) * sizeof *p->output);
    for (int k = 0; k < rq->outputs; k++)
        p->output[k] = rq->output[k];
    for (size_t k = 0; k < n; k++)
        p->output[(size_t)rq->outputs + k] = sys->store->symbol[sys->variable[k].symbol].node;
    p->event = sga_calloc(events + 1, sizeof *p->event);
    p->side = sga_calloc(2 * events + 2, 1);
    p->all_side = p->side + events + 1;
    memset(p->all_side, ODE_SIDE_FRESH, events);
    p->stands = sga_calloc(events + 1, 1);
    p->whole = sga_calloc(events + 1, sizeof *p->whole);
    p->x = sga_calloc(n + 1, sizeof *p->x);
    p->given = sga_calloc(2 * n + 1, 1);
    p->held = p->given + n;
    memset(p->given, 1, n);
    p->q.output = p->output;
    p->q.outputs = (int)n + rq->outputs;
    p->q.event = p->event;
    p->q.event_side = p->side;
    p->q.ends_there = true;
    p->q.sized_by = rq;
    p->q.integrals = 0;
    p->q.rows_until = rows_until;
    p->q.beside = NULL;
    p->q.carried = NULL;
    p->q.exact_start = EXPR_UNDEF;
    p->q.exact_initial = p->q.exact_time = NULL;
    p->q.modes = NULL;
    p->q.single |= mode->rq->single;
    p->q.arithmetic = TRAJ_DOUBLE;
    p->q.rtol = fmax(tighter * rq->rtol, fmin(rq->rtol, 1e-14));
    p->q.atol = tighter * rq->atol;
}

/* In the next mode: what is known of the events stays. */
static void piece_turn(struct piece *p, const struct traj_mode *to, double tighter)
{
    struct piece old = *p;
    size_t events = (size_t)to->rq->events;
    piece_init(p, to, tighter, old.q.rows_until);
    memcpy(p->all_side, old.all_side, events);
    memcpy(p->stands, old.stands, events);
    free(old.output);
    free(old.event);
    free(old.side);
    free(old.whole);
    free(old.stands);
    free(old.x);
    free(old.given);
}

static void piece_clear(struct piece *p)
{
    free(p->output);
    free(p->event);
    free(p->side);
    free(p->whole);
    free(p->stands);
    free(p->x);
    free(p->given);
}

/* Events that have not acted as often as they may. */
static void piece_events(struct piece *p, const struct traj_request *rq, const int *count)
{
    p->q.events = 0;
    for (int e = 0; e < rq->events; e++) {
        const struct traj_event *from = rq->event + e;
        if (from->most && count[e] >= from->most)
            continue;
        p->whole[p->q.events] = e;
        p->side[p->q.events] = p->all_side[e];
        p->event[p->q.events++] = (struct traj_event){ .expression = from->expression, .direction = from->direction, .stop = from->stop || from->sets || from->turns };
    }
}

/* Rows and happenings of a piece are added. */
static void join(struct pass *p, const struct piece *q, const struct traj_result *piece)
{
    struct traj_result *r = &p->r;
    size_t columns = (size_t)q->columns, wide = (size_t)piece->columns, happened = (size_t)(r->happened + piece->happened);
    for (int i = 0; i < piece->rows; i++, r->rows++) {
        double *value = r->value + (size_t)r->rows * columns, *each = p->each + (size_t)r->rows * columns;
        r->t[r->rows] = piece->t[i];
        memcpy(value, piece->value + (size_t)i * wide, columns * sizeof *value);
        for (size_t k = 0; k < columns; k++)
            each[k] = piece->error ? fmin(piece->error[i], piece->column_error ? piece->column_error[k] : INFINITY) : INFINITY;
    }
    if (happened + 1 > p->happening_room) {
        p->happening_room = 2 * happened + 1;
        r->happening = sga_realloc(r->happening, p->happening_room * sizeof *r->happening);
        r->happened_value = sga_realloc(r->happened_value, p->happening_room * (columns + 1) * sizeof *r->happened_value);
    }
    for (int i = 0; i < piece->happened; i++, r->happened++) {
        r->happening[r->happened] = piece->happening[i];
        r->happening[r->happened].event = q->whole[piece->happening[i].event];
        memcpy(r->happened_value + (size_t)r->happened * columns, piece->happened_value + (size_t)i * wide, columns * sizeof(double));
    }
    r->residual = fmax(r->residual, piece->residual);
    r->steps += piece->steps;
    r->rejected += piece->rejected;
    r->evaluations += piece->evaluations;
    r->seconds += piece->seconds;
    r->method = piece->method;
    r->arithmetic = piece->arithmetic;
    r->gauge = piece->gauge;
    r->gauge_numeric = piece->gauge_numeric;
    r->inputs_examined = piece->inputs_examined;
    if (piece->shortfall)
        r->shortfall = piece->shortfall;
}

/* Nothing is said beyond t. */
static void cut(struct pass *p, double t, double direction)
{
    while (p->r.happened && direction * (p->r.happening[p->r.happened - 1].t - t) > 0)
        p->r.happened--;
    while (p->r.rows && direction * (p->r.t[p->r.rows - 1] - t) > 0)
        p->r.rows--;
    while (p->r.legs && direction * (p->r.leg[p->r.legs - 1].t - t) > 0)
        free(p->r.leg[--p->r.legs].impulse);
    while (p->r.slides && direction * (p->r.slide[p->r.slides - 1].from - t) > 0)
        p->r.slides--;
    for (int i = 0; i < p->r.slides; i++)
        if (direction * (p->r.slide[i].to - t) > 0)
            p->r.slide[i].to = NAN;
    while (p->r.passes && direction * (p->r.passed[p->r.passes - 1].t - t) > 0)
        free(p->r.passed[--p->r.passes].detail);
}

/* The times have a limit at t, known to an error; nothing is said beyond. */
static bool end_at_limit(struct pass *p, double t, double error, const char *how)
{
    assert(p->jumps > 0 && fabs(p->direction) == 1);
    cut(p, t, p->direction);
    p->r.ended = true;
    p->r.ended_t = t;
    p->r.ended_reason = "accumulation";
    p->end_error = error;
    snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%s: the motion beyond is not determined by them", how);
    return true;
}

/* Whether times of events have a limit: the last intervals shrink by one factor, and what is left of them is short; or there is no time between
 * them; or they are too short for their roundings to shrink any more. */
static bool accumulates(struct pass *p, const struct traj_request *rq)
{
    static const char *const at_once = "events that set variables follow each other without time between";
    const double *t = p->at + p->jumps;
    double way = fabs(rq->times[rq->samples - 1] - rq->start);
    if (p->jumps > 1 && p->stood && fabs(t[-1] - t[-2]) <= STANDS * way)
        return end_at_limit(p, t[-2], SAME_TIME * fabs(t[-2]), at_once);
    if (p->jumps > AT_ONCE && fabs(t[-1] - t[-1 - AT_ONCE]) <= SAME_TIME * fabs(t[-1]))
        return end_at_limit(p, t[-1 - AT_ONCE], SAME_TIME * fabs(t[-1]), at_once);
    if (p->jumps < 5)
        return false;
    double d0 = t[-4] - t[-5], d1 = t[-3] - t[-4], d2 = t[-2] - t[-3], d3 = t[-1] - t[-2], q0 = d1 / d0, q1 = d2 / d1, q2 = d3 / d2;
    double most = 1 - fmax(q1, q2), left = d3 * q2 / (1 - q2), before = d2 * q1 / (1 - q1) - d3;
    bool alike = most > 0 && q0 > 0 && q1 > 0 && q2 > 0 && q0 < 1 && fabs(q2 - q1) <= ALIKE * most && fabs(q1 - q0) <= 2 * ALIKE * most;
    if (alike && fabs(left) <= LIMIT_NEAR * way) {
        char how[120];
        snprintf(how, sizeof how, "the times of events that set variables have a limit here, intervals shrinking by %.6g each", q2);
        /* roundings of times are in the factor, and what is left of it beyond one more step of it */
        return end_at_limit(p, t[-1] + left, 2 * fabs(left - before) + 8 * DBL_EPSILON * fabs(t[-1]) * (1 + fabs(left / d3)) / (1 - q2), how);
    }
    /* between the last two the motion was too small to be seen, and so it would go through: the one before was the last of a row */
    if (fabs(d3) <= SAME_TIME * fabs(t[-1]) && q0 > 0 && q1 > 0 && q0 < 1 && q1 < 1 && fabs(d2) <= UNSEEN * way) {
        double rest = d2 * q1 / (1 - q1);
        return end_at_limit(p, t[-2] + rest, 2 * fabs(rest) + SAME_TIME * fabs(t[-2]), "the times of events that set variables have a limit here, the last intervals too short to be told");
    }
    bool shrink = fabs(d3) < fabs(d2) && fabs(d2) < fabs(d1);
    if (!shrink && fabs(t[-1] - t[-4]) <= LIMIT_NEAR * way)
        return end_at_limit(p, t[-4], INFINITY, "events that set variables follow each other so fast that roundings decide when");
    return false;
}

/* What happens at the end of a piece; false: nothing that sets, or something that stops. crossing, fired: by event of the request. */
static bool fired_at_end(const struct traj_request *rq, const struct piece *q, const struct traj_result *piece, unsigned char *fired, signed char *crossing)
{
    bool any = false, stop = false;
    double t = piece->ended_t;
    memset(fired, 0, (size_t)rq->events + 1);
    for (int i = piece->happened - 1; i >= 0 && fabs(piece->happening[i].t - t) <= SAME_TIME * fabs(t); i--) {
        int e = q->whole[piece->happening[i].event];
        stop |= rq->event[e].stop;
        any |= rq->event[e].sets > 0 || rq->event[e].turns;
        fired[e] = 1;
        crossing[e] = (signed char)piece->happening[i].direction;
    }
    return any && !stop;
}

/* One that stops for good names itself. */
static void name_stop(const struct traj_request *rq, const struct piece *q, const struct traj_result *piece, struct traj_result *r)
{
    for (int i = piece->happened - 1; i >= 0 && fabs(piece->happening[i].t - piece->ended_t) <= SAME_TIME * fabs(piece->ended_t); i--)
        if (rq->event[q->whole[piece->happening[i].event]].stop)
            r->ended_event = q->whole[piece->happening[i].event];
}

static void count_jump(struct pass *p, const struct traj_request *rq, double t, const unsigned char *fired)
{
    if (p->jumps == p->room) {
        p->room = 2 * p->room + 16;
        p->at = sga_realloc(p->at, (size_t)p->room * sizeof *p->at);
    }
    p->at[p->jumps++] = t;
    for (int e = 0; e < rq->events; e++)
        p->count[e] += fired[e] && rq->event[e].sets;
}

/* The place passed, as the answer says it. */
static void add_passed(struct traj_result *r, const struct traj_result *piece, double t)
{
    static const char *const beyond = "the motion goes on along the curve that it has come on, which is analytic there as far as the tolerances tell";
    const char *colon = strrchr(piece->ended_detail, ':');
    int length = colon ? (int)(colon - piece->ended_detail) : (int)strlen(piece->ended_detail);
    size_t room = (size_t)length + strlen(beyond) + 3;
    r->passed = sga_realloc(r->passed, ((size_t)r->passes + 1) * sizeof *r->passed);
    r->passed[r->passes] = (struct traj_passed){ t, sga_malloc(room) };
    snprintf(r->passed[r->passes++].detail, room, "%.*s: %s", length, piece->ended_detail, beyond);
}

/* The piece ended at a singular position: the samples around it, and where the next piece begins (*t). False: it ends there. */
static bool pass_over(struct pass *p, struct piece *q, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, const struct traj_result *piece, double *t)
{
    struct crossing c;
    struct traj_result *r = &p->r;
    double direction = rq->times[rq->samples - 1] < rq->start ? -1 : 1;
    size_t columns = (size_t)q->columns;
    if (!piece->stratum || r->passes >= MOST_JUMPS || !crossing_find(sys, sol, &q->q, piece->ended_t, &c))
        return false;
    double *x = sga_malloc((size_t)(c.n + 1) * sizeof *x), *y = sga_malloc((size_t)(q->q.outputs + 1) * sizeof *y);
    while (r->rows && direction * (r->t[r->rows - 1] - c.from) > 0)
        r->rows--;
    for (int i = r->rows; i < rq->samples && direction * (rq->times[i] - c.to) <= 0; i++, r->rows++) {
        crossing_at(&c, rq->times[i], x, y);
        r->t[i] = rq->times[i];
        for (size_t k = 0; k < columns; k++) {
            r->value[(size_t)i * columns + k] = y[k];
            p->each[(size_t)i * columns + k] = c.error * sga_allowed((struct sga_tolerance){ q->q.rtol, q->q.atol }, piece->unit ? piece->unit[k] : 1, y[k]);
        }
    }
    memcpy(q->x, c.end, (size_t)c.n * sizeof *q->x);
    memset(q->all_side, ODE_SIDE_FRESH, (size_t)rq->events);
    memset(q->stands, 0, (size_t)rq->events);
    add_passed(r, piece, c.at);
    *t = c.to;
    free(x);
    free(y);
    crossing_clear(&c);
    return true;
}

/* A piece begins. */
static void add_leg(struct pass *p, double t, int mode, const char *how, double moved, double *impulse, int coordinates)
{
    SGA_RESERVE(p->r.leg, p->leg_room, p->r.legs + 1);
    p->r.leg[p->r.legs++] = (struct traj_leg){ .t = t, .mode = mode, .how = how, .moved = moved, .impulse = impulse, .coordinates = coordinates };
}

/* Values of switches of slides from a list of all variables. */
static void widen(struct traj_result *r, int surface, double value)
{
    for (int i = r->slides - 1; i >= 0; i--)
        if (r->slide[i].surface == surface && isnan(r->slide[i].to)) {
            r->slide[i].least = fmin(r->slide[i].least, value);
            r->slide[i].most = fmax(r->slide[i].most, value);
        }
}

/* Of the samples of a piece, and of its end. */
static void widen_all(struct pass *p, const struct piece *q, const struct traj_mode *m, const struct traj_result *piece)
{
    for (int k = 0; slide_any(m->rq) && k < m->rq->modes->surfaces; k++) {
        if (m->sliding[k] < 0)
            continue;
        size_t wide = (size_t)piece->columns, at = (size_t)q->q.outputs - (size_t)m->sys->variables + (size_t)m->sliding[k];
        for (int i = 0; i < piece->rows; i++)
            widen(&p->r, k, piece->value[(size_t)i * wide + at]);
        if (piece->happened)
            widen(&p->r, k, piece->happened_value[(size_t)(piece->happened - 1) * wide + at]);
    }
}

/* Slides that end at t, and those that begin there, at x of the mode `to`. */
static void note_slides(struct pass *p, const struct traj_mode *was, const struct traj_mode *to, double t, const double *x)
{
    struct traj_result *r = &p->r;
    for (int k = 0; slide_any(to->rq) && k < to->rq->modes->surfaces; k++) {
        bool before = was->choice[k] == TRAJ_ALONG, now = to->choice[k] == TRAJ_ALONG;
        for (int i = r->slides - 1; before && !now && i >= 0; i--)
            if (r->slide[i].surface == k && isnan(r->slide[i].to)) {
                r->slide[i].to = t;
                r->slide[i].left = to->choice[k] == TRAJ_ABOVE ? 1 : -1;
            }
        if (!before && now) {
            SGA_RESERVE(r->slide, p->slide_room, r->slides + 1);
            r->slide[r->slides++] = (struct traj_slide){ .surface = k, .mode = to->place, .from = t, .to = NAN, .least = x[to->sliding[k]], .most = x[to->sliding[k]] };
        } else if (now) {
            widen(r, k, x[to->sliding[k]]);
        }
    }
}

/* The sides of what is looked for in the next piece. */
static bool take_sides(struct piece *q, struct turn *s, double t, struct sga_error *err)
{
    return !s->slide || slide_sides(s->slide, s->mode, t, q->x, q->all_side, err);
}

/* What is set is set, and the next piece's mode entered. */
static bool turn(struct pass *p, struct piece *q, struct turn *s, const struct jump_at *at, double tighter, struct sga_error *err)
{
    struct jump_to to = { 0 };
    const struct traj_mode *was = s->mode;
    bool ok = turn_begin(s, at, &to, err), on = ok && !s->why[0];
    if (on && s->mode != was)
        piece_turn(q, s->mode, tighter);
    ok = ok && (!on || turn_land(s, at, &to, q->all_side, q->stands, err));
    on &= ok && !s->why[0];
    if (on && s->mode != was && s->mode->rq->modes->landed)
        on = ok = s->mode->rq->modes->landed(s->mode->rq->modes->ctx, s->mode, at->t, to.x, err);
    if (on) {
        memcpy(q->x, to.x, (size_t)s->j.n * sizeof *q->x);
        if (s->j.slope)
            memcpy(q->x + s->j.n, to.slope, (size_t)(s->j.slope->all - s->j.n) * sizeof *q->x);
        ok = take_sides(q, s, at->t, err);
        note_slides(p, was, s->mode, at->t, q->x);
    }
    if (on && !s->slide) {
        add_leg(p, at->t, s->mode->place, to.how, to.moved, to.impulse, s->mode->rq->mass ? s->mode->rq->mass->coordinates : 0);
        to.impulse = NULL;
    }
    turn_end(s, &to);
    return ok;
}

/* What a slide holds at 0 is left as powers of roundings, whose size says nothing: a start that is looked for by sizes would not be found. */
static void drop_dust(double *x, int n)
{
    double largest = 0;
    for (int k = 0; k < n; k++)
        largest = fmax(largest, fabs(x[k]));
    for (int k = 0; k < n; k++)
        x[k] = fabs(x[k]) <= DBL_EPSILON * DBL_EPSILON * largest ? 0 : x[k];
}

/* The end of a piece: true where another follows. */
static bool go_on(struct pass *p, struct piece *q, struct turn *s, const struct traj_request *rq, const struct traj_result *piece, double tighter, double wrong, bool *ok, struct sga_error *err)
{
    unsigned char *fired = sga_calloc((size_t)rq->events + 1, 1);
    signed char *crossing = sga_calloc((size_t)rq->events + 1, 1);
    bool set = piece->ended && piece->ended_event >= 0 && fired_at_end(rq, q, piece, fired, crossing), more = false;
    if (piece->ended && !set) {
        p->r.ended = true;
        p->r.ended_t = piece->ended_t;
        p->r.ended_reason = piece->ended_reason;
        memcpy(p->r.ended_detail, piece->ended_detail, sizeof p->r.ended_detail);
        if (piece->ended_event >= 0)
            name_stop(rq, q, piece, &p->r);
    } else if (set) {
        double *x = piece->happened_value + (size_t)piece->happened * (size_t)piece->columns - (s->j.slope ? s->j.slope->all : s->j.n);
        if (s->slide)
            drop_dust(x, s->j.n);
        struct jump_at at = { piece->ended_t, x, fired, crossing, wrong, p->count };
        count_jump(p, rq, piece->ended_t, fired);
        p->stood = false;
        for (int e = 0; e < rq->events; e++)
            p->stood |= fired[e] && rq->event[e].sets && q->stands[e];
        *ok = turn(p, q, s, &at, tighter, err);
        if (*ok && s->why[0]) {
            p->r.ended = true;
            p->r.ended_t = piece->ended_t;
            p->r.ended_reason = ode_reason_text(ODE_NOT_SMOOTH);
            snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%s", s->why);
        }
        more = *ok && !s->why[0] && !accumulates(p, rq);
        if (more && p->jumps >= MOST_JUMPS) {
            p->r.ended = true;
            p->r.ended_t = piece->ended_t;
            p->r.ended_reason = ode_reason_text(ODE_STEP_LIMIT);
            snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%d events that set variables have happened, as many as are followed", MOST_JUMPS);
            more = false;
        }
    }
    free(fired);
    free(crossing);
    return more;
}

/* By column the largest of the pieces' units. */
static void take_units(struct traj_result *r, const struct traj_result *piece)
{
    if (!r->unit)
        r->unit = sga_calloc((size_t)r->columns + 1, sizeof(double));
    for (int k = 0; k < r->columns; k++)
        r->unit[k] = fmax(r->unit[k], piece->unit ? piece->unit[k] : 1);
}

/* The start by the equations as they are written, from there on by the sides of switches. */
static bool begin(struct pass *p, struct piece *q, struct turn *s, const struct traj_request *rq, double tighter, struct sga_error *err)
{
    struct traj_initial start;
    if (!traj_consistent(s->mode->sys, s->mode->sol, rq, &start, err))
        return false;
    SGA_FREED unsigned char *none = sga_calloc((size_t)rq->events + 1, 1);
    struct jump_at at = { .t = rq->start, .x = start.x, .fired = none, .crossing = (signed char *)none };
    bool ok = turn(p, q, s, &at, tighter, err);
    if (ok && s->why[0])
        ok = sga_fail_at(err, SGA_E_NO_MOTION, "/trajectory/initial", "%.300s", s->why);
    if (ok) {
        p->r.initial = start.x;
        p->r.moved = start.moved;
        start.x = NULL;
        q->q.start = rq->start;
        q->q.initial = q->x;
        q->q.given = q->given;
        q->q.held = q->held;
        memset(q->all_side, ODE_SIDE_FRESH, (size_t)rq->modes->own);
    }
    traj_initial_clear(&start);
    return ok;
}

static double direction_of(const struct traj_request *rq)
{
    return rq->times[rq->samples - 1] < rq->start ? -1 : 1;
}

static bool time_ended(const struct traj_result *r)
{
    return r->ended && strcmp(r->ended_reason, ode_reason_text(ODE_TIME_LIMIT)) == 0;
}

/* It ends at its last row, for want of time. */
static void end_at_rows(struct pass *p, const struct traj_request *rq, const char *detail)
{
    double t = p->r.rows ? p->r.t[p->r.rows - 1] : rq->start;
    cut(p, t, direction_of(rq));
    p->r.ended = true;
    p->r.ended_t = t;
    p->r.ended_event = -1;
    p->r.ended_reason = ode_reason_text(ODE_TIME_LIMIT);
    snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%.255s", detail);
}

/* No time is left for another piece: the rows of those before are the motion's. */
static bool keeps_rows(struct pass *p, const struct traj_request *rq, const struct sga_error *why)
{
    if (why->code != SGA_E_LIMIT_SECONDS || !rows_are_kept(rq) || !sga_budget_ok(rq->budget, NULL) || !rows_beyond_start(rq, p->r.rows, NULL))
        return false;
    char text[120];
    snprintf(text, sizeof text, "the limit of %g seconds was reached; raise limits.seconds or ask for an earlier stop", rq->budget->seconds);
    end_at_rows(p, rq, text);
    return true;
}

/* A motion that is differentiated does not start where events may or may not happen. */
static bool starts_clear(const struct turn *s, double t, const double *x, struct sga_error *err)
{
    int e;
    return !s->j.slope || jump_slope_starts(&s->j, t, x, &e)
           || sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial", "the motion starts at the zero of event %d: a change of what is differentiated by moves it to one side, where the event "
                          "happens, or to the other, where it does not; start beside it", e);
}

/* The whole motion once. *p is cleared where it fails. */
static bool pass_run(struct pass *p, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double tighter, double wrong,
                     struct sga_error *err)
{
    struct piece q;
    struct turn s;
    const struct traj_mode own = { .sys = sys, .sol = sol, .rq = rq };
    const struct traj_mode *first = rq->modes ? rq->modes->start : &own;
    *p = (struct pass){ .direction = direction_of(rq) };
    piece_init(&q, first, tighter, rq->rows_until);
    size_t rows = (size_t)rq->samples, columns = (size_t)q.columns;
    p->r.columns = q.columns;
    p->r.ended_event = -1;
    p->r.t = sga_calloc(rows + 1, sizeof(double));
    p->r.value = sga_calloc((rows + 1) * (columns + 1), sizeof(double));
    p->each = sga_calloc((rows + 1) * (columns + 1), sizeof(double));
    p->count = sga_calloc((size_t)rq->events + 1, sizeof *p->count);
    bool ok = turn_init(&s, first, err), more = ok;
    if ((rq->modes && !slide_any(rq)) || rq->mass)
        add_leg(p, rq->start, 0, "start", 0, NULL, 0);
    if (ok && slide_any(rq))
        ok = more = begin(p, &q, &s, rq, tighter, err);
    for (int done = 0; more;) {
        struct traj_result piece;
        piece_events(&q, carried(s.mode).rq, p->count);
        ok = sga_budget_ok(rq->budget, err) && traj_run(carried(s.mode).sys, carried(s.mode).sol, &q.q, &piece, err);
        if (!ok && keeps_rows(p, rq, err)) {
            *err = (struct sga_error){ 0 };
            ok = true;
            break;
        }
        if (!ok)
            break;
        if (!p->r.initial) {
            p->r.initial = piece.initial;
            p->r.moved = piece.moved;
            piece.initial = NULL;
            ok = starts_clear(&s, rq->start, p->r.initial, err);
        }
        join(p, &q, &piece);
        widen_all(p, &q, s.mode, &piece);
        double t = piece.ended_t, direction = direction_of(rq);
        more = ok && ((!s.j.slope && pass_over(p, &q, s.mode->sys, s.mode->sol, rq, &piece, &t)) || go_on(p, &q, &s, s.mode->rq, &piece, tighter, wrong, &ok, err));
        take_units(&p->r, &piece);
        traj_result_clear(&piece);
        while (more && done < rq->samples && (rq->times[done] - t) * direction <= 0)
            done++;
        more &= done < rq->samples;
        double late = wrong * fabs(t);        /* times of events are roundings wrong too, all to one side at the worst */
        q.q.start = more && (rq->times[done] - t) * direction > 2 * late ? t + direction * late : t;
        q.q.times = rq->times + done;
        q.q.samples = rq->samples - done;
        q.q.initial = q.x;
        q.q.given = q.given;
        q.q.held = q.held;
    }
    if (!ok && p->r.initial && keeps_rows(p, rq, err)) {        /* in what a mode needs */
        *err = (struct sga_error){ 0 };
        ok = true;
    }
    turn_clear(&s);
    piece_clear(&q);
    if (!ok)
        pass_clear(p);
    return ok;
}

/* How many happenings both have, in the same order. */
static int alike(const struct traj_result *a, const struct traj_result *b)
{
    int k = 0;
    while (k < a->happened && k < b->happened && a->happening[k].event == b->happening[k].event && a->happening[k].direction == b->happening[k].direction)
        k++;
    return k;
}

/* Errors of the tighter motion by the looser one; the largest, in units of what is allowed. */
static double compare(struct pass *p, const struct pass *loose, const struct traj_request *rq)
{
    struct traj_result *r = &p->r;
    const struct traj_result *o = &loose->r;
    const struct sga_tolerance asked = { rq->rtol, rq->atol };
    double direction = direction_of(rq), known = INFINITY, worst = 0;
    int same = alike(r, o), columns = r->columns, jumped = 0;
    SGA_FREED double *largest = sga_calloc((size_t)columns + 1, sizeof *largest);
    if (same < r->happened)
        known = direction * r->happening[same].t;
    if (same < o->happened)
        known = fmin(known, direction * o->happening[same].t);
    r->error = sga_calloc((size_t)r->rows + 1, sizeof(double));
    r->column_error = sga_calloc((size_t)columns + 1, sizeof(double));
    r->error_estimate = 0;
    for (int i = 0; i < r->rows; i++) {
        bool there = i < o->rows && direction * r->t[i] < known;
        while (jumped < p->jumps && direction * (p->at[jumped] - r->t[i]) <= 0)
            jumped++;
        for (int k = 0; k < columns; k++) {
            size_t at = (size_t)i * (size_t)columns + (size_t)k;
            largest[k] = sga_larger(largest[k], fabs(r->value[at]));
            /* each piece begins with roundings of what the values there are, and both motions may have them alike */
            double rounding = 4 * DBL_EPSILON * (fabs(r->value[at]) + jumped * largest[k]);
            double e = there ? fabs(r->value[at] - o->value[at]) + p->each[at] + rounding : INFINITY;
            e = isnan(e) ? INFINITY : e;
            r->error[i] = fmax(r->error[i], e);
            r->column_error[k] = fmax(r->column_error[k], e);
            worst = fmax(worst, sga_error_ratio(e, asked, r->unit ? r->unit[k] : 1, r->value[at]));
        }
        r->error_estimate = fmax(r->error_estimate, r->error[i]);
    }
    for (int i = 0; i < r->slides; i++) {
        struct traj_slide *a = r->slide + i;
        const struct traj_slide *b = i < o->slides && o->slide[i].surface == a->surface ? o->slide + i : NULL;
        a->error = b ? fabs(a->from - b->from) + (isnan(a->to) && isnan(b->to) ? 0 : fabs(a->to - b->to)) + 16 * DBL_EPSILON * fmax(fabs(a->from), isnan(a->to) ? 0 : fabs(a->to)) : INFINITY;
        a->error = isnan(a->error) ? INFINITY : a->error;
    }
    for (int i = 0; i < r->happened; i++) {
        struct traj_happening *h = r->happening + i;
        h->error = i < same ? fabs(h->t - o->happening[i].t) + (isfinite(h->error) ? h->error : 0) + 4 * DBL_EPSILON * fabs(h->t) : INFINITY;
        if (i < same && !rq->event[h->event].turns)      /* of those slides say it, and what it does to the motion is in the samples */
            worst = fmax(worst, sga_error_ratio(h->error, asked, 1, h->t));
    }
    return worst;
}

/* What is known of an accumulation's time. */
static void say_limit(struct pass *p, const struct pass *loose)
{
    struct traj_result *r = &p->r;
    if (!r->ended || strcmp(r->ended_reason, "accumulation") != 0)
        return;
    bool both = loose->r.ended && strcmp(loose->r.ended_reason, "accumulation") == 0;
    double e = p->end_error + (both ? fabs(r->ended_t - loose->r.ended_t) : INFINITY);
    size_t end = strlen(r->ended_detail);
    if (isfinite(e))
        snprintf(r->ended_detail + end, sizeof r->ended_detail - end, " (the time is known to %.2g)", e);
    else
        snprintf(r->ended_detail + end, sizeof r->ended_detail - end, " (how well the time is known is not)");
}

/* What happened at surfaces is said by slides. */
static void drop_turns(struct traj_result *r, const struct traj_request *rq)
{
    int kept = 0;
    for (int i = 0; i < r->happened; i++) {
        if (rq->event[r->happening[i].event].turns)
            continue;
        r->happening[kept] = r->happening[i];
        memmove(r->happened_value + (size_t)kept * (size_t)r->columns, r->happened_value + (size_t)i * (size_t)r->columns, (size_t)r->columns * sizeof(double));
        kept++;
    }
    r->happened = kept;
}

/* A pass after the first: tighter, compared with it. */
enum later { COMPARED, LAST_STAYS, FAILED };
static enum later later_pass(struct pass *p, struct pass *loose, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double tighter,
                             struct sga_error *err)
{
    bool errors = loose->r.error, ok = pass_run(p, sys, sol, rq, tighter, 0, err);
    bool stays = errors && rows_are_kept(rq) && sga_budget_ok(rq->budget, NULL) && (ok ? time_ended(&p->r) && p->r.rows < loose->r.rows : err->code == SGA_E_LIMIT_SECONDS);
    if (stays) {
        pass_clear(p);
        *p = *loose;
        *err = (struct sga_error){ 0 };
        return LAST_STAYS;
    }
    if (!ok)
        pass_clear(loose);
    return ok ? COMPARED : FAILED;
}

/* The first, within its part of the time. *late: that ended, and the samples of *part are those that there are; what it is compared with has the rest. */
static bool first_pass(struct pass *loose, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_request *part, bool *late,
                       struct sga_error *err)
{
    *part = *rq;
    part->rows_until = rows_are_kept(rq) ? rows_first_until(rq->rows_until) : 0;
    if (!pass_run(loose, sys, sol, part, 1, WRONG, err))
        return false;
    part->rows_until = rows_are_kept(rq) ? rq->rows_until : 0;
    *late = time_ended(&loose->r);
    if (!*late)
        return true;
    part->samples = loose->r.rows;
    if (rows_beyond_start(rq, loose->r.rows, err))
        return true;
    pass_clear(loose);
    return false;
}

static const char *shortfall_of(double worst, bool late)
{
    return late ? rows_shortfall
           : isinf(worst) ? "the motions that were compared do not have the same events"
                          : "errors that events that set variables carry on are larger than the tolerances, at tighter ones too";
}

bool jumps_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err)
{
    struct pass loose, p;
    struct traj_request part;
    double tighter = 1, worst = INFINITY, before;
    bool late;
    *r = (struct traj_result){ 0 };
    if (rq->arithmetic == TRAJ_DOUBLE_DOUBLE || rq->arithmetic == TRAJ_BALL)
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/accuracy/arithmetic", "events that set variables are followed in double; use \"double\" or \"auto\"");
    if (rq->single) {
        bool ok = pass_run(&p, sys, sol, rq, tighter, 0, err);
        *r = ok ? p.r : *r;
        p.r = (struct traj_result){ 0 };
        if (ok)
            pass_clear(&p);
        return ok;
    }
    if (!first_pass(&loose, sys, sol, rq, &part, &late, err))
        return false;
    for (int k = 1;; k++) {
        tighter *= TIGHTER;
        before = worst;
        enum later how = later_pass(&p, &loose, sys, sol, &part, tighter, err);
        if (how == FAILED)
            return false;
        late |= how == LAST_STAYS || time_ended(&p.r);
        if (how == LAST_STAYS)
            break;
        if (late && (!p.r.ended || time_ended(&p.r)))
            end_at_rows(&p, rq, p.r.ended ? p.r.ended_detail : loose.r.ended_detail);
        worst = compare(&p, &loose, rq);
        say_limit(&p, &loose);
        pass_clear(&loose);
        if (worst <= 1 || late || k + 1 >= MOST_PASSES || (isfinite(before) && worst > 0.5 * before))
            break;
        loose = p;
    }
    if (worst <= 1)
        p.r.shortfall = NULL;
    else if (!p.r.shortfall)
        p.r.shortfall = shortfall_of(worst, late);
    drop_turns(&p.r, rq);
    p.r.out_of_time = rows_are_kept(rq) && (late || sga_now() >= rq->rows_until);
    *r = p.r;
    p.r = (struct traj_result){ 0 };
    pass_clear(&p);
    return true;
}
