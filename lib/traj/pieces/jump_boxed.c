/* See jump_boxed.h. */
#include "jump_boxed.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "error.h"
#include "flint_ends.h"
#include "jump_pass.h"
#include "jump_turn.h"
#include "mem.h"
#include "rows_kept.h"
#include "system.h"
#include "tolerance.h"

/* Tries with more bits that come no further, and by how much more of the way a try has to come. */
enum { TRIES = 2 };
static const double FURTHER = 1e-9;

struct jump_boxed *jump_boxed_new(const struct sys_system *sys, const struct traj_request *rq)
{
    if (rq->arithmetic != TRAJ_BALL)
        return NULL;
    struct jump_boxed *b = sga_calloc(1, sizeof *b);
    assert(rq->piece && rq->piece->prec > 0);
    b->piece.prec = rq->piece->prec;
    b->samples = rq->samples;
    b->time = _arb_vec_init(rq->samples);
    arb_init(&b->t);
    b->idle = sga_calloc(3 * (size_t)rq->events + 1, sizeof *b->idle);
    b->zero = b->idle + rq->events;
    b->flat = b->zero + rq->events;
    b->twin = sga_malloc(((size_t)rq->events + 1) * sizeof *b->twin);
    b->twin_sign = sga_calloc((size_t)rq->events + 1, 1);
    for (int e = 0; e < rq->events; e++)
        b->twin[e] = -1;
    for (int i = 0; i < rq->samples; i++)
        num_ball_constant(sys->store, rq->exact_time ? rq->exact_time[i] : EXPR_UNDEF, rq->times[i], b->piece.prec + 32, b->time + i);
    return b;
}

void jump_boxed_free(struct jump_boxed *b)
{
    if (!b)
        return;
    _arb_vec_clear(b->time, b->samples);
    if (b->x)
        _arb_vec_clear(b->x, b->n);
    if (b->before)
        _arb_vec_clear(b->before, b->columns);
    if (b->tau)
        _arb_vec_clear(b->tau, b->taus);
    arb_clear(&b->t);
    free(b->sample);
    free(b->idle);
    free(b->twin);
    free(b->twin_sign);
    free(b);
}

void jump_boxed_first(struct jump_boxed *b, struct jump_piece *q, const struct traj_request *rq)
{
    q->q.exact_start = rq->exact_start;
    q->q.exact_initial = rq->exact_initial;
    q->q.exact_time = rq->exact_time;
    q->q.piece = &b->piece;
}

/* Samples from `done` on that may lie before the next piece. */
static void count_early(struct jump_boxed *b, int done)
{
    b->piece.early = 0;
    for (int i = done; i < b->samples && arb_overlaps(b->time + i, &b->t); i++)
        b->piece.early++;
}

bool jump_boxed_undecided(struct jump_pass *p, const struct traj_request *rq, int event)
{
    struct traj_result *r = &p->r;
    const struct traj_happening *last = r->happening + r->happened - 1;
    for (int i = r->happened - 1; p->boxed->piece.at_once && i >= 0 && fabs(last->t - r->happening[i].t) <= last->error + r->happening[i].error; i--)
        if (rq->event[r->happening[i].event].sided) {
            r->happening[i].undecided = true;
            r->happening[i].direction = 0;
        }
    return p->boxed->piece.at_once && rq->event[event].sided;
}

/* What a piece left is taken over. */
static void take_end(struct jump_boxed *b)
{
    if (b->before)
        _arb_vec_clear(b->before, b->columns);
    b->before = b->piece.at;
    b->columns = b->piece.columns;
    b->piece.at = NULL;
    arb_swap(&b->t, &b->piece.t);
    arb_clear(&b->piece.t);
    b->why[0] = '\0';
}

bool jump_boxed_start(struct jump_boxed *b, const struct jump_piece *q, const struct traj_mode *mode, struct sga_error *err)
{
    struct traj_result r;
    b->piece.first = true;
    b->piece.at = NULL;
    bool ok = jump_piece_start(q, mode, &r, err);
    b->piece.first = false;
    if (!ok)
        return false;
    traj_result_clear(&r);
    if (!b->piece.at)
        return sga_fail_at(err, SGA_E_NO_MOTION, "/trajectory/initial", "the start could not be enclosed");
    take_end(b);
    count_early(b, 0);
    return true;
}

/* The last is told once more before itself, as event e. */
static void tell_twin(struct jump_piece *q, struct traj_result *r, int e, int direction)
{
    size_t wide = (size_t)r->columns, last = (size_t)r->happened - 1;
    r->happening = sga_realloc(r->happening, (last + 2) * sizeof *r->happening);
    r->happened_value = sga_realloc(r->happened_value, ((last + 2) * wide + 1) * sizeof *r->happened_value);
    r->happening[last + 1] = r->happening[last];
    memcpy(r->happened_value + (last + 1) * wide, r->happened_value + last * wide, wide * sizeof *r->happened_value);
    if (r->happened_digits) {
        r->happened_digits = sga_realloc(r->happened_digits, (last + 2) * (wide + 1) * sizeof *r->happened_digits);
        for (size_t k = 0; k <= wide; k++) {
            const char *text = r->happened_digits[last * (wide + 1) + k];
            r->happened_digits[(last + 1) * (wide + 1) + k] = text ? sga_strdup(text) : NULL;
        }
    }
    q->whole[q->q.events + r->happened] = e;
    r->happening[last].event = q->q.events + r->happened;
    r->happening[last].direction = direction;
    r->happened++;
}

void jump_boxed_twins(struct jump_boxed *b, struct jump_piece *q, const struct traj_request *rq, const int *count, struct traj_result *piece)
{
    int surface = piece->ended_event >= 0 ? q->whole[piece->ended_event] : -1;
    for (int e = 0; e < rq->events && surface >= 0; e++) {
        bool done = rq->event[e].most && count[e] >= rq->event[e].most;
        int direction = b->twin[e] == surface && !done ? b->twin_sign[e] * piece->happening[piece->happened - 1].direction : 0;
        if (direction && (!rq->event[e].direction || rq->event[e].direction == direction))
            tell_twin(q, piece, e, direction);
    }
}

void jump_boxed_unturned(const struct jump_boxed *b, struct traj_result *r)
{
    const struct traj_happening *last = r->happening + r->happened - 1;
    for (int i = r->happened - 1; i >= 0 && r->happening[i].t == last->t; i--)
        if (b->twin[r->happening[i].event] >= 0) {
            r->happening[i].undecided = true;
            r->happening[i].direction = 0;
        }
}

/* Whether the function, of time alone, is 0 at a sample exactly. */
static bool is_zero_at(const struct sys_system *sys, const struct traj_request *rq, expr_id function, int i)
{
    struct expr_store *st = sys->store;
    SGA_ARENA(mem);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int k = 0; k < sys->variables; k++)
        if (expr_depends(st, &cone, function, sys->variable[k].symbol))
            return false;
    expr_id *map = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *map), e = function;
    map[sys->time] = rq->exact_time ? rq->exact_time[i] : expr_double(st, rq->times[i]);
    expr_substitute(st, &e, 1, map);
    return e && expr_is_zero(st, e);
}

/* The sample has the values before the event, which is at its time. */
static void fill(struct jump_pass *p, const struct traj_request *rq)
{
    struct jump_boxed *b = p->boxed;
    struct traj_result *r = &p->r;
    size_t columns = (size_t)r->columns, row = (size_t)r->rows * columns;
    r->t[r->rows] = rq->times[r->rows];
    for (size_t k = 0; k < columns; k++) {
        r->digits[row + k] = enclose_decimal(b->before + k, b->piece.prec, r->radius + row + k);
        r->value[row + k] = r->digits[row + k] ? strtod(r->digits[row + k], NULL) : NAN;
        p->each[row + k] = r->radius[row + k];
    }
    r->rows++;
}

void jump_boxed_end(struct jump_pass *p, const struct traj_request *rq, const struct sys_system *sys, int event)
{
    struct jump_boxed *b = p->boxed;
    take_end(b);
    if (b->piece.at_once)
        snprintf(b->why, sizeof b->why, "it cannot be shown which of two events happens first here");
    else if (b->piece.at_knot)
        snprintf(b->why, sizeof b->why, "it cannot be shown whether an event happens before or after a sample of a table");
    while (p->r.rows < rq->samples && arb_overlaps(b->time + p->r.rows, &b->t) && is_zero_at(sys, rq, rq->event[event].expression, p->r.rows))
        fill(p, rq);
    count_early(b, p->r.rows);
}

/* A sample's time in the store of the mode. False: it is no rational number, and the store another one. */
static bool sample_time(const struct traj_request *rq, const struct expr_store *of, int i, struct expr_store *st, expr_id *to)
{
    expr_id e = rq->exact_time ? rq->exact_time[i] : EXPR_UNDEF;
    if (st == of || !e)
        *to = e ? e : expr_double(st, rq->times[i]);
    else
        *to = expr_is_const(of, e) ? expr_fmpq(st, expr_const_value(of, e)) : EXPR_UNDEF;
    return *to != EXPR_UNDEF;
}

bool jump_boxed_begin(struct jump_boxed *b, struct jump_piece *q, const struct turn *s, const struct traj_request *rq, int done, struct sga_error *err)
{
    const struct sys_system *sys = jump_carried(s->mode).sys;
    const struct expr_store *of = (rq->modes ? rq->modes->start : s->mode)->sys->store;
    SGA_ENDS(fmpq_end) fmpq_t middle = { 0 };
    b->sample = sga_realloc(b->sample, ((size_t)rq->samples + 1) * sizeof *b->sample);
    for (int i = done; i < rq->samples; i++)
        if (!sample_time(rq, of, i, sys->store, b->sample + i))
            return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/times", "in balls motions that change their mode have samples at rational times; the time of sample %d is none", i);
    if (b->piece.knot)
        fmpq_set(middle, b->piece.knot);
    else
        arf_get_fmpq(middle, arb_midref(&b->t));
    q->q.exact_start = expr_fmpq(sys->store, middle);
    q->q.exact_time = b->sample + done;
    q->q.exact_initial = NULL;
    q->q.piece = &b->piece;
    b->piece.sys = sys;
    b->piece.start = b->x;
    b->piece.t0 = &b->t;
    b->piece.before = b->before;
    b->piece.columns = b->columns;
    return expr_store_ok(sys->store) || (*err = *sys->store->error, false);
}

/* How many bits too wide, as in enclosed.c. Fills in the errors. */
static double measure(struct traj_result *r, const struct traj_request *rq)
{
    const struct sga_tolerance asked = { rq->rtol, rq->atol };
    double worst = 0;
    r->error = sga_calloc((size_t)r->rows + 1, sizeof *r->error);
    r->column_error = sga_calloc((size_t)r->columns + 1, sizeof *r->column_error);
    for (int i = 0; i < r->rows; i++)
        for (int k = 0; k < r->columns; k++) {
            size_t at = (size_t)i * (size_t)r->columns + (size_t)k;
            if (!isfinite(r->radius[at]))      /* it has no value */
                continue;
            r->error[i] = fmax(r->error[i], r->radius[at]);
            r->column_error[k] = fmax(r->column_error[k], r->radius[at]);
            worst = fmax(worst, sga_error_ratio(r->radius[at], asked, r->unit ? r->unit[k] : 1, r->value[at]));
        }
    for (int i = 0; i < r->rows; i++)
        r->error_estimate = fmax(r->error_estimate, r->error[i]);
    return worst > 1 ? log2(worst) + 0.2 : 0;
}

/* One with more bits: 0: would not help. */
static slong more_bits(const struct jump_pass *p, double excess, bool stuck)
{
    slong prec = p->boxed->piece.prec, next = 0;
    if (p->boxed->piece.wide && !stuck)
        next = 2 * prec;
    else if (excess > 0 && !p->boxed->piece.wide)
        next = prec + (slong)fmin(4.0 * (double)prec, ceil(excess) + 16);
    return next > ENCLOSED_MOST_BITS ? (prec < ENCLOSED_MOST_BITS ? ENCLOSED_MOST_BITS : 0) : next;
}

static double way_made(const struct traj_result *r, const struct traj_request *rq)
{
    double end = rq->times[rq->samples - 1], way = end - rq->start;
    return way != 0 ? ((r->ended ? r->ended_t : end) - rq->start) / way : 1;
}

/* Times of slides are those of the events that begin and end them. */
static void slide_errors(struct traj_result *r)
{
    for (int i = 0; i < r->slides; i++) {
        r->slide[i].error = 0;
        for (int k = 0; k < r->happened; k++)
            if (r->happening[k].t == r->slide[i].from || r->happening[k].t == r->slide[i].to)
                r->slide[i].error = fmax(r->slide[i].error, r->happening[k].error + DBL_EPSILON * fabs(r->happening[k].t));
    }
}

static void finish(struct jump_pass *p, const struct traj_request *rq, bool late, double excess, struct traj_result *r)
{
    p->r.shortfall = excess > 0 ? (late ? "the enclosures are rigorous but wider than the tolerances: the time granted ended before more bits could be tried"
                                        : "the enclosures are rigorous but wider than the tolerances, with as many bits as are used at most") : NULL;
    slide_errors(&p->r);
    jump_drop_turns(&p->r, rq);
    p->r.out_of_time = rows_are_kept(rq) && (late || sga_now() >= rq->rows_until);
    *r = p->r;
    p->r = (struct traj_result){ 0 };
    jump_pass_clear(p);
}

bool jump_boxed_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err)
{
    struct jump_pass best = { .jumps = 0 };
    double excess = 0;
    bool have = false, late = false;
    int stuck = 0;
    for (slong next = enclosed_first_bits(rq->rtol); next && !late;) {
        struct enclosed_piece piece = { .prec = next };
        struct traj_request own = *rq;
        struct jump_pass p;
        own.piece = &piece;
        bool ok = jump_pass_run(&p, sys, sol, &own, 1, 0, err);
        late = have && (ok ? jump_time_ended(&p.r) && p.r.rows < best.r.rows : err->code == SGA_E_LIMIT_SECONDS && rows_are_kept(rq) && rows_may_end(rq, NULL));
        if (late) {
            if (ok)
                jump_pass_clear(&p);
            *err = (struct sga_error){ 0 };
            break;
        }
        double before = have ? way_made(&best.r, rq) : 0;
        if (have)
            jump_pass_clear(&best);
        if (!ok)
            return false;
        best = p;
        have = true;
        late = jump_time_ended(&best.r);
        excess = measure(&best.r, rq);
        stuck = way_made(&best.r, rq) > before + FURTHER ? 0 : stuck + 1;
        next = more_bits(&best, excess, stuck >= TRIES);
    }
    finish(&best, rq, late, excess, r);
    return true;
}
