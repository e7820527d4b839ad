/* See jump_pass.h. */
#include "jump_pass.h"

#include <assert.h>
#include <float.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "jump_boxed.h"
#include "jump_exact.h"
#include "jump_fine.h"
#include "jump_over.h"
#include "jump_slope.h"
#include "jump_turn.h"
#include "mem.h"
#include "ode.h"
#include "poly.h"
#include "reduction.h"
#include "rows_kept.h"
#include "slide.h"
#include "system.h"
#include "tolerance.h"

/* What happens at the end of a piece; false: nothing that sets, or something that stops. crossing, fired: by event of the request. last: the last of the happenings, and those at its very time. */
static bool fired_at_end(const struct traj_request *rq, const struct jump_piece *q, const struct traj_result *piece, bool last, unsigned char *fired, signed char *crossing)
{
    bool any = false, stop = false;
    double t = last && piece->happened ? piece->happening[piece->happened - 1].t : piece->ended_t;
    memset(fired, 0, (size_t)rq->events + 1);
    for (int i = piece->happened - 1; i >= 0 && fabs(piece->happening[i].t - t) <= (last ? 0 : JUMP_SAME_TIME * fabs(t)); i--) {
        int e = q->whole[piece->happening[i].event];
        stop |= rq->event[e].stop;
        any |= rq->event[e].sets > 0 || rq->event[e].turns;
        fired[e] = 1;
        crossing[e] = (signed char)piece->happening[i].direction;
    }
    return any && !stop;
}

/* One that stops for good names itself. */
static void name_stop(const struct traj_request *rq, const struct jump_piece *q, const struct traj_result *piece, struct traj_result *r)
{
    for (int i = piece->happened - 1; i >= 0 && fabs(piece->happening[i].t - piece->ended_t) <= JUMP_SAME_TIME * fabs(piece->ended_t); i--)
        if (rq->event[q->whole[piece->happening[i].event]].stop)
            r->ended_event = q->whole[piece->happening[i].event];
}

static void count_jump(struct jump_pass *p, const struct traj_request *rq, double t, const unsigned char *fired)
{
    if (p->jumps == p->room) {
        p->room = 2 * p->room + 16;
        p->at = sga_realloc(p->at, (size_t)p->room * sizeof *p->at);
    }
    p->at[p->jumps++] = t;
    for (int e = 0; e < rq->events; e++)
        p->count[e] += fired[e] && rq->event[e].sets;
}

/* The sides of what is looked for in the next piece. */
static bool take_sides(struct jump_piece *q, struct turn *s, double t, struct sga_error *err)
{
    return !s->slide || slide_sides(s->slide, s->mode, t, q->x, q->all_side, err);
}

/* Along a slide, or in a mode: events whose functions its constraints hold at 0 (a tip that has landed and stays) are not looked for. */
static void take_idle(struct jump_pass *p, struct turn *s, double t, const double *x)
{
    const struct traj_request *rq = s->mode->rq;
    const struct sga_solution *sol = s->mode->sol;
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, rq->budget);
    bool slides = rq->modes->surfaces > 0, held = !slides && sol->constraints > 0;
    int events = slides ? rq->modes->own : rq->events;
    SGA_FREED expr_id *given = sga_malloc(((size_t)sol->constraints + 1) * sizeof *given);
    for (int i = 0; i < sol->constraints; i++)
        given[i] = sol->constraint[i].expr;
    for (int k = 0; k < rq->modes->surfaces; k++)
        held |= s->mode->choice[k] == TRAJ_ALONG;
    for (int e = 0; e < events; e++)
        p->idle[e] = held && (!x || jump_at_zero(&s->j, e, t, x)) && poly_vanishes_with(s->mode->sys->store, rq->event[e].expression, given, sol->constraints, &limits);
}

/* Where sides have turned, functions of theirs may have jumped over 0: told as the turn is. was: their values before. */
static bool jumped_over(struct jump_pass *p, struct turn *s, const double *was, const unsigned char *fired, double t, const double *x)
{
    const struct traj_request *rq = s->mode->rq;
    bool stop = false;
    for (int e = 0; e < rq->modes->own && p->r.happened; e++) {
        double now = jump_function(&s->j, e, t, x);
        int direction = was[e] * now < 0 ? (now > 0 ? 1 : -1) * (int)jump_direction(rq) : 0;
        if (fired[e] || !rq->event[e].sided || !direction || (rq->event[e].direction && rq->event[e].direction != direction))
            continue;
        jump_tell_again(p, e, direction);
        stop |= rq->event[e].stop;
        p->r.ended_event = rq->event[e].stop ? e : p->r.ended_event;
    }
    return stop;
}

/* What is set is set, and the next piece's mode entered. */
static bool turn_once(struct jump_pass *p, struct jump_piece *q, struct turn *s, const struct jump_at *at, double tighter, struct sga_error *err)
{
    struct jump_to to = { 0 };
    const struct traj_mode *was = s->mode;
    bool ok = turn_begin(s, at, &to, err), on = ok && !s->why[0];
    if (on && s->mode != was)
        jump_piece_turn(q, s->mode, tighter);
    ok = ok && (!on || turn_land(s, at, &to, q->all_side, q->stands, err));
    on &= ok && !s->why[0];
    if (on && s->mode != was && s->mode->rq->modes->landed)
        on = ok = s->mode->rq->modes->landed(s->mode->rq->modes->ctx, s->mode, at->t, to.x, err);
    if (on) {
        memcpy(q->x, to.x, (size_t)s->j.n * sizeof *q->x);
        if (s->j.slope)
            memcpy(q->x + s->j.n, to.slope, (size_t)(s->j.slope->rows.all - s->j.n) * sizeof *q->x);
        if (p->boxed)
            jump_boxed_turn(p->boxed, s, was, at, &to);
        ok = (!p->fine || jump_fine_turn(p->fine, s, at, &to, err)) && (s->stays || take_sides(q, s, at->t, err));
        if (p->idle)
            take_idle(p, s, at->t, q->x);
        jump_note_slides(p, was, s->mode, at->t, q->x);
    }
    if (on && (!s->slide || s->stays)) {
        jump_add_leg(p, at->t, s->slide ? 0 : s->mode->place, to.how, to.moved, to.impulse, s->mode->rq->mass ? s->mode->rq->mass->coordinates : 0);
        to.impulse = NULL;
    }
    turn_end(s, &to);
    return ok;
}

/* Where switches are modes, sides are taken of what was set. */
static bool turn(struct jump_pass *p, struct jump_piece *q, struct turn *s, const struct jump_at *at, double tighter, struct sga_error *err)
{
    bool sets = false;
    for (int e = 0; s->slide && e < s->mode->rq->events; e++)
        sets |= at->fired[e] && s->mode->rq->event[e].sets;
    if (!sets)
        return turn_once(p, q, s, at, tighter, err);
    assert(p->boxed);              /* others are refused (check_sliding) */
    s->stays = p->boxed->setting = true;
    bool ok = turn_once(p, q, s, at, tighter, err);
    s->stays = p->boxed->setting = false;
    if (!ok || s->why[0] || p->boxed->why[0])
        return ok;
    size_t all = (size_t)q->n, events = (size_t)s->mode->rq->events;
    SGA_FREED double *x = memcpy(sga_malloc((all + 1) * sizeof *x), q->x, all * sizeof *x);
    SGA_FREED unsigned char *none = sga_calloc(events + 1, 1);
    const struct jump_at next = { at->t, x, none, (const signed char *)none, 0, NULL, at->count };
    p->boxed->again = true;
    ok = turn_once(p, q, s, &next, tighter, err);
    p->boxed->again = false;
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
static bool go_on(struct jump_pass *p, struct jump_piece *q, struct turn *s, const struct traj_request *rq, const struct traj_result *piece, double tighter, double wrong, bool *ok, struct sga_error *err)
{
    unsigned char *fired = sga_calloc((size_t)rq->events + 1, 1);
    signed char *crossing = sga_calloc((size_t)rq->events + 1, 1);
    bool set = piece->ended && piece->ended_event >= 0 && fired_at_end(rq, q, piece, p->boxed, fired, crossing), more = false;
    if (piece->ended && !set) {
        traj_take_end(&p->r, piece);
        if (piece->ended_event >= 0 && p->boxed && jump_boxed_undecided(p, rq, q->whole[piece->ended_event])) {
            p->r.ended_reason = "not_enclosed";
            snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "it is not shown whether an event happens as a switch of its function turns");
        } else if (piece->ended_event >= 0) {
            name_stop(rq, q, piece, &p->r);
        }
    } else if (set) {
        double *x = piece->happened_value + (size_t)piece->happened * (size_t)piece->columns - (s->j.slope ? s->j.slope->rows.all : s->j.n);
        if (s->slide)
            drop_dust(x, s->j.n);
        struct jump_at at = { piece->ended_t, x, fired, crossing, p->fine ? 0 : wrong, piece, p->count };
        count_jump(p, rq, piece->ended_t, fired);
        p->stood = false;
        for (int e = 0; e < rq->events; e++)
            p->stood |= fired[e] && rq->event[e].sets && q->stands[e];
        SGA_FREED double *was = sga_malloc(((size_t)rq->events + 1) * sizeof *was);
        for (int e = 0; e < rq->events && s->slide; e++)
            was[e] = jump_function(&s->j, e, at.t, x);
        *ok = turn(p, q, s, &at, tighter, err);
        if (*ok && !s->why[0] && s->slide && p->idle && jumped_over(p, s, was, fired, at.t, q->x)) {
            p->r.ended = true;
            p->r.ended_t = piece->ended_t;
            p->r.ended_reason = ode_reason_text(ODE_EVENT);
            snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "an event that stops the motion");
            *ok = true;
        }
        if (*ok && !s->why[0] && !p->fine)
            jump_exact_next(q, &s->j, piece);
        const char *shown = p->boxed ? p->boxed->why : "";
        if (*ok && (s->why[0] || shown[0])) {
            p->r.ended = true;
            p->r.ended_t = piece->ended_t;
            p->r.ended_reason = shown[0] ? "not_enclosed" : ode_reason_text(ODE_NOT_SMOOTH);
            snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%s", shown[0] ? shown : s->why);
        }
        if (p->boxed && p->r.ended)
            jump_boxed_unturned(p->boxed, &p->r);
        if (shown[0])
            p->boxed->piece.wide = true;
        more = *ok && !p->r.ended && !s->why[0] && !shown[0] && !jump_accumulates(p, rq);
        if (more && p->jumps >= JUMP_MOST) {
            p->r.ended = true;
            p->r.ended_t = piece->ended_t;
            p->r.ended_reason = ode_reason_text(ODE_STEP_LIMIT);
            snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%d events that set variables have happened, as many as are followed", JUMP_MOST);
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

/* x and the derivatives that the start has, if any. */
static double *with_derivatives(const struct turn *s, const double *x)
{
    size_t n = (size_t)s->j.n, all = s->j.slope ? (size_t)s->j.slope->rows.all : n;
    double *to = sga_malloc((all + 1) * sizeof *to);
    memcpy(to, x, n * sizeof *to);
    if (all > n)
        memcpy(to + n, s->mode->rq->carried->rq->initial + n, (all - n) * sizeof *to);
    return to;
}

/* The start by the equations as they are written, from there on by the sides of switches. */
static bool begin(struct jump_pass *p, struct jump_piece *q, struct turn *s, const struct traj_request *rq, double tighter, struct sga_error *err)
{
    struct traj_initial start;
    if (!traj_consistent(s->mode->sys, s->mode->sol, rq, &start, err))
        return false;
    SGA_FREED unsigned char *none = sga_calloc((size_t)rq->events + 1, 1);
    SGA_FREED double *x = with_derivatives(s, start.x);
    struct jump_at at = { .t = rq->start, .x = x, .fired = none, .crossing = (signed char *)none };
    if ((p->boxed && !jump_boxed_start(p->boxed, q, s->mode, err)) || (p->fine && !jump_fine_start(p->fine, q, s->mode, err))) {
        traj_initial_clear(&start);
        return false;
    }
    bool ok = turn(p, q, s, &at, tighter, err);
    if (ok && p->boxed && p->boxed->why[0])
        ok = sga_fail_at(err, SGA_E_NO_MOTION, "/trajectory/initial", "%.150s", p->boxed->why);
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
        if (p->boxed)
            ok = jump_boxed_begin(p->boxed, q, s, rq, 0, err);
        else if (p->fine)
            ok = jump_fine_begin(p->fine, q, s, 0, rq->samples, err);
        else
            jump_exact_start(q, rq);
    }
    traj_initial_clear(&start);
    return ok;
}

double jump_direction(const struct traj_request *rq)
{
    return rq->times[rq->samples - 1] < rq->start ? -1 : 1;
}

bool jump_time_ended(const struct traj_result *r)
{
    return r->ended && strcmp(r->ended_reason, ode_reason_text(ODE_TIME_LIMIT)) == 0;
}

/* It ends at its last row, for want of time. */
void jump_end_at_rows(struct jump_pass *p, const struct traj_request *rq, const char *detail)
{
    double t = p->r.rows ? p->r.t[p->r.rows - 1] : rq->start;
    jump_cut(p, t, jump_direction(rq));
    p->r.ended = true;
    p->r.ended_t = t;
    p->r.ended_event = -1;
    p->r.ended_reason = ode_reason_text(ODE_TIME_LIMIT);
    if (detail != p->r.ended_detail)
        snprintf(p->r.ended_detail, sizeof p->r.ended_detail, "%.255s", detail);
}

/* No time is left for another piece: the rows of those before are the motion's. */
static bool keeps_rows(struct jump_pass *p, const struct traj_request *rq, const struct sga_error *why)
{
    if (why->code != SGA_E_LIMIT_SECONDS || !rows_are_kept(rq) || !rows_may_end(rq, NULL) || !rows_beyond_start(rq, p->r.rows, NULL))
        return false;
    char text[120];
    snprintf(text, sizeof text, "the limit of %g seconds was reached; raise limits.seconds or ask for an earlier stop", rq->budget->seconds);
    jump_end_at_rows(p, rq, text);
    return true;
}

static bool in_time(const struct traj_request *rq, struct sga_error *err)
{
    if (!sga_budget_ok(rq->budget, err))
        return false;
    return !rows_are_kept(rq) || sga_now() < rq->rows_until
           || sga_fail(err, SGA_E_LIMIT_SECONDS, "the limit of %g seconds was reached; raise limits.seconds or ask for an earlier stop", rq->budget->seconds);
}

/* A motion that is differentiated does not start where events may or may not happen. */
static bool starts_clear(const struct turn *s, double t, const double *x, struct sga_error *err)
{
    int e;
    return !s->j.slope || jump_slope_starts(&s->j, t, x, &e)
           || sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial", "the motion starts at the zero of event %d: a change of what is differentiated by moves it to one side, where the event "
                          "happens, or to the other, where it does not; start beside it", e);
}

/* In double-double: the state where the piece ended, before its texts go into the motion's. */
static bool read_end(struct jump_pass *p, const struct turn *s, const struct traj_result *piece, struct sga_error *err)
{
    if (!piece->digits || (piece->happened && !piece->happened_digits))
        return sga_fail(err, SGA_E_NOT_SUPPORTED, "the motion has no digits beyond those of a double; use \"double\"");
    return piece->ended_event < 0 || jump_fine_end(p->fine, piece, jump_carried(s->mode).sys->variables)
           || sga_fail(err, SGA_E_NOT_SUPPORTED, "at %.10g the motion has no digits beyond those of a double; use \"double\"", piece->ended_t);
}

/* How far the next sample lies behind the last event. */
static double behind_event(const struct jump_pass *p, const struct traj_request *rq)
{
    const struct traj_result *r = &p->r;
    double way = p->fine ? num_dd_sub(p->fine->time[r->rows], p->fine->t).hi : rq->times[r->rows] - r->happening[r->happened - 1].t;
    return p->direction * way;
}

/* Samples at the time of the event that ended a piece, to the roundings of the arithmetic, have the values before it. error: of the piece's samples. */
static void fill_samples(struct jump_pass *p, const struct traj_request *rq, double error)
{
    struct traj_result *r = &p->r;
    size_t columns = (size_t)r->columns, last = (size_t)r->happened - 1;
    const struct traj_happening *h = r->happening + last;
    double told = !p->fine ? jump_at_once(p, rq, h->t) : isfinite(h->error) ? h->error : 0;
    while (r->rows < rq->samples && behind_event(p, rq) <= told) {
        size_t row = (size_t)r->rows * columns;
        r->t[r->rows] = rq->times[r->rows];
        r->rows++;
        memcpy(r->value + row, r->happened_value + last * columns, columns * sizeof *r->value);
        for (size_t k = 0; k < columns; k++) {
            if (p->fine) {
                const char *text = r->happened_digits[last * (columns + 1) + k + 1];
                r->digits[row + k] = text ? sga_strdup(text) : NULL;
            }
            p->each[row + k] = fmax(error, 0) + told * (1 + fabs(r->value[row + k]));
        }
    }
}

/* Room for what the motion will have. */
static void make_room(struct jump_pass *p, const struct traj_request *rq, int columns)
{
    size_t rows = (size_t)rq->samples + 1, cells = rows * ((size_t)columns + 1), events = (size_t)rq->events + 1;
    p->r.columns = columns;
    p->r.ended_event = -1;
    p->r.t = sga_calloc(rows, sizeof(double));
    p->r.value = sga_calloc(cells, sizeof(double));
    p->each = sga_calloc(cells, sizeof(double));
    if (p->boxed)
        p->r.radius = sga_calloc(cells, sizeof *p->r.radius);
    if (jump_is_exact(rq) || p->boxed)
        p->r.digits = sga_calloc(cells, sizeof *p->r.digits);
    p->count = sga_calloc(events, sizeof *p->count);
    p->idle = rq->modes && !p->boxed ? sga_calloc(events, sizeof *p->idle) : NULL;
}

/* The piece that was asked for goes into the motion, which has come to *t. Whether another one follows; *ok false: err. The piece is cleared. */
static bool take_piece(struct jump_pass *p, struct jump_piece *q, struct turn *s, const struct traj_request *rq, struct traj_result *piece, double tighter,
                       double wrong, double *t, bool *ok, struct sga_error *err)
{
    if (!p->r.initial) {
        p->r.initial = piece->initial;
        p->r.moved = piece->moved;
        piece->initial = NULL;
        *ok = starts_clear(s, rq->start, p->r.initial, err);
    }
    *ok = *ok && (!p->fine || read_end(p, s, piece, err));
    if (*ok && p->boxed)
        jump_boxed_twins(p->boxed, q, jump_carried(s->mode).rq, p->count, piece);
    jump_join(p, q, piece);
    if (!p->boxed && piece->ended_event >= 0)
        fill_samples(p, rq, piece->error_estimate);
    if (p->boxed && piece->ended_event >= 0)
        jump_boxed_end(p, s->mode->rq, s->mode->sys, q->whole[piece->ended_event]);
    jump_note_switches(p, q, s->mode, piece);
    *t = piece->ended_t;
    bool over = *ok && !s->j.slope && jump_over(p, q, &s->j, rq, piece, t);
    *ok = *ok && (over || !piece->stratum || in_time(rq, err));       /* what was not found for want of time may be there */
    bool more = *ok && (over || go_on(p, q, s, s->mode->rq, piece, tighter, wrong, ok, err));
    take_units(&p->r, piece);
    traj_result_clear(piece);
    return more;
}

/* The next piece is asked for, from t on; *done: samples that are behind. False: none is left, or *ok false and err. */
static bool next_piece(struct jump_pass *p, struct jump_piece *q, struct turn *s, const struct traj_request *rq, double t, double wrong, int *done, bool *ok,
                       struct sga_error *err)
{
    double direction = jump_direction(rq);
    *done = p->r.rows;
    while (!p->fine && !p->boxed && *done < rq->samples && (rq->times[*done] - t) * direction <= 0)
        ++*done;
    if (*done == rq->samples)
        return false;
    double late = p->fine ? 0 : wrong * fabs(t);        /* times of events are roundings wrong too, all to one side at the worst */
    q->q.start = (rq->times[*done] - t) * direction > 2 * late ? t + direction * late : t;
    q->q.times = rq->times + *done;
    q->q.samples = rq->samples - *done;
    q->q.initial = q->x;
    q->q.given = q->given;
    q->q.held = q->held;
    if (p->fine)
        *ok = jump_fine_begin(p->fine, q, s, *done, rq->samples, err);
    else if (p->boxed)
        *ok = jump_boxed_begin(p->boxed, q, s, rq, *done, err);
    else
        jump_exact_times(q, rq, *done);
    return *ok;
}

/* The whole motion once. *p is cleared where it fails. */
bool jump_pass_run(struct jump_pass *p, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double tighter, double wrong,
                     struct sga_error *err)
{
    struct jump_piece q;
    struct turn s;
    const struct traj_mode own = { .sys = sys, .sol = sol, .rq = rq };
    const struct traj_mode *first = rq->modes ? rq->modes->start : &own;
    *p = (struct jump_pass){ .direction = jump_direction(rq), .fine = jump_fine_new(sys, rq, wrong), .boxed = jump_boxed_new(sys, rq) };
    jump_piece_init(&q, first, tighter, rq->rows_until);
    if (p->fine)
        jump_fine_first(&q, jump_carried(first).rq);
    if (p->boxed)
        jump_boxed_first(p->boxed, &q, jump_carried(first).rq);
    make_room(p, rq, q.columns);
    bool ok = turn_init(&s, first, err), more = ok;
    if (!rq->modes && !p->fine)
        jump_exact_start(&q, rq);
    if ((rq->modes && !slide_any(rq)) || rq->mass)
        jump_add_leg(p, rq->start, 0, "start", 0, NULL, 0);
    if (ok && slide_any(rq))
        ok = more = begin(p, &q, &s, rq, tighter, err);
    else if (ok && p->idle)
        take_idle(p, &s, rq->start, NULL);
    for (int done = 0; more;) {
        struct traj_result piece;
        double t;
        q.idle = p->boxed ? p->boxed->idle : p->idle;
        q.zero = p->boxed ? p->boxed->zero : NULL;
        q.flat = p->boxed ? p->boxed->flat : NULL;
        jump_piece_events(&q, jump_carried(s.mode).rq, p->count);
        ok = sga_budget_ok(rq->budget, err) && traj_run(jump_carried(s.mode).sys, jump_carried(s.mode).sol, &q.q, &piece, err);
        more = ok && take_piece(p, &q, &s, rq, &piece, tighter, wrong, &t, &ok, err) && next_piece(p, &q, &s, rq, t, wrong, &done, &ok, err);
    }
    if (!ok && keeps_rows(p, rq, err)) {        /* no time for another piece, or for what a mode needs */
        *err = (struct sga_error){ 0 };
        ok = true;
    }
    turn_clear(&s);
    jump_piece_clear(&q);
    if (!ok)
        jump_pass_clear(p);
    return ok;
}
