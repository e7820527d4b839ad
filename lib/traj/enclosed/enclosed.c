/* From bits to tolerances: the ball trajectory is run with more bits until its radii are as small as asked. */
#include "enclosed_attempt.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "enc_tables.h"
#include "error.h"
#include "flow.h"
#include "knots.h"
#include "mem.h"
#include "points_space.h"
#include "reduction.h"
#include "rows_kept.h"
#include "sizes.h"
#include "system.h"
#include "trajectory.h"

enum { FIRST_EXTRA = 48, LEAST_BITS = 80, MOST_BITS = ENCLOSED_MOST_BITS };

static void attempt_init(struct attempt *a)
{
    a->start = _arb_vec_init(a->n);
    a->time = _arb_vec_init(a->rq->samples);
    a->box = _arb_vec_init((slong)a->rq->samples * a->n);
    a->column = _arb_vec_init((slong)a->rq->samples * a->columns);
    a->before = sga_calloc((size_t)a->rq->samples + 1, sizeof *a->before);
    arb_init(a->t0);
}

static void attempt_clear(struct attempt *a)
{
    if (!a->start)      /* not begun */
        return;
    _arb_vec_clear(a->start, a->n);
    _arb_vec_clear(a->time, a->rq->samples);
    _arb_vec_clear(a->box, (slong)a->rq->samples * a->n);
    _arb_vec_clear(a->column, (slong)a->rq->samples * a->columns);
    if (a->knot)
        _arb_vec_clear(a->knot, a->knots.count);
    free(a->before);
    enclose_happened_clear(&a->happened);
    if (a->happened_column)
        _arb_vec_clear(a->happened_column, a->happened_room);
    enc_tables_clear(&a->tables);
    knots_clear(&a->knots);
    arb_clear(a->t0);
}

/* The symbols of tables among those nodes get the values that their polynomials have at t. */
static void set_tables(const struct attempt *a, struct num_ball *b, const struct expr_cone *cone, const arb_t t)
{
    const struct expr_store *st = a->sys->store;
    SGA_ENDS(arb_end) arb_t v = { 0 };
    SGA_ARENA(mem);
    arb_ptr piece = arbs_take(&mem, NUM_TABLE_PIECE);
    for (int k = 0; k < cone->count && a->tables.count; k++) {
        const struct expr_node *n = st->node + cone->list[k];
        int which = n->op == EXPR_SYM && st->symbol[n->a].table ? enc_tables_find(&a->tables, st->symbol[n->a].table) : -1;
        if (which < 0)
            continue;
        num_table_balls_piece(a->tables.balls + which, a->tables.table[which]->at, piece);
        num_table_balls_value(v, piece, st->symbol[n->a].order, t, a->prec + 20);
        num_ball_set(b, n->a, v);
    }
}

/* Values of roots where the solution is in box (n) at t, into out. */
void attempt_evaluate(const struct attempt *a, struct num_ball *b, struct expr_cone *cone, const expr_id *root, int roots, const arb_t t, arb_srcptr box,
                     arb_ptr out)
{
    set_tables(a, b, cone, t);
    for (int j = 0; j < a->n; j++)
        num_ball_set(b, a->sys->variable[j].symbol, box + j);
    num_ball_set(b, a->sys->time, t);
    num_ball_list(b, cone->list, cone->count);
    for (int k = 0; k < roots; k++)
        arb_set(out + k, num_ball_value(b, root[k]));
}

/* A sample of which it is not shown whether it lies before the piece's start: what is about the same on both sides has a value. */
static void join_early(struct attempt *a)
{
    const struct enclosed_piece *piece = a->rq->piece;
    for (int i = 0; piece && i < piece->early && i < a->end.samples; i++)
        for (int k = 0; k < a->columns; k++) {
            arb_ptr c = a->column + (size_t)i * (size_t)a->columns + (size_t)k;
            if (k < piece->columns && arb_overlaps(c, piece->before + k))
                arb_union(c, c, piece->before + k, a->prec + 20);
            else
                arb_indeterminate(c);
        }
}

static void columns(struct attempt *a)
{
    if (a->happened_column)
        _arb_vec_clear(a->happened_column, a->happened_room);
    a->happened_room = (slong)a->happened.count * a->columns;
    a->happened_column = _arb_vec_init(a->happened_room);
    if (!a->rq->outputs) {
        _arb_vec_set(a->column, a->box, (slong)a->end.samples * a->n);
        for (int i = 0; i < a->happened.count; i++)
            _arb_vec_set(a->happened_column + (size_t)i * (size_t)a->n, a->happened.list[i].x, a->n);
        return;
    }
    struct num_ball b;
    struct expr_cone cone;
    num_ball_init(&b, a->sys->store, a->prec + 20);
    expr_cone_init(&cone);
    expr_cone_of(a->sys->store, &cone, a->rq->output, a->rq->outputs);
    for (int i = 0; i < a->end.samples; i++) {
        knots_around(&a->knots, instant_sample(a->rq, i));      /* what jumps has the value beyond, as in double; knots_before was sure */
        attempt_evaluate(a, &b, &cone, a->rq->output, a->columns, a->time + i, a->box + (size_t)i * (size_t)a->n, a->column + (size_t)i * (size_t)a->columns);
    }
    join_early(a);
    for (int i = 0; i < a->happened.count; i++) {
        const struct enclose_happening *h = a->happened.list + i;
        knots_enter(&a->knots, h->piece);
        attempt_evaluate(a, &b, &cone, a->rq->output, a->columns, &h->t, h->x, a->happened_column + (size_t)i * (size_t)a->columns);
    }
    expr_cone_clear(&cone);
    num_ball_clear(&b);
}

/* How many bits too wide. Columns without a value (an output outside its domain) do not count. */
static void measure(struct attempt *a)
{
    mag_t tolerance, m;
    mag_init(tolerance);
    mag_init(m);
    a->excess = -INFINITY;
    for (slong k = 0; k < (slong)a->end.samples * a->columns; k++) {
        arb_srcptr c = a->column + k;
        if (!arb_is_finite(c) || mag_is_zero(arb_radref(c)))
            continue;
        arb_get_mag_lower(m, c);
        mag_set_d_lower(tolerance, a->rq->rtol);
        mag_mul_lower(tolerance, tolerance, m);
        mag_set_d_lower(m, a->rq->atol * a->f->sizes->column[k % a->columns]);
        mag_add_lower(tolerance, tolerance, m);
        mag_div(m, arb_radref(c), tolerance);
        a->excess = fmax(a->excess, mag_get_d_log2_approx(m) + 0.2);     /* the decimal text adds a tenth */
    }
    mag_clear(tolerance);
    mag_clear(m);
}

/* The answer holds on one side of some surfaces; along the way they are shown not to be met, here the side is. */
static bool on_sides(struct attempt *a, struct sga_error *err)
{
    const struct sga_solution *sol = a->sol;
    struct num_ball b;
    struct expr_cone cone;
    bool on = true;
    num_ball_init(&b, a->sys->store, a->prec);
    expr_cone_init(&cone);
    for (int j = 0; j < a->n; j++)
        num_ball_set(&b, a->sys->variable[j].symbol, a->start + j);
    num_ball_set(&b, a->sys->time, a->t0);
    for (int i = 0; i < sol->sides && on; i++) {
        expr_cone_of(a->sys->store, &cone, &sol->side[i].function, 1);
        set_tables(a, &b, &cone, a->t0);
        num_ball_list(&b, cone.list, cone.count);
        arb_srcptr v = num_ball_value(&b, sol->side[i].function);
        on = sol->side[i].sign > 0 ? arb_is_positive(v) : arb_is_negative(v);
    }
    expr_cone_clear(&cone);
    num_ball_clear(&b);
    return on || sga_fail(err, SGA_E_NO_MOTION, "it cannot be shown that the start lies on the side of evidence.sides on which the answer "
                          "holds; give trajectory.initial well on that side");
}

/* Bits that coefficients of tables have beyond those of the motion. */
enum { TABLE_EXTRA = 32 };

static void enter(void *attempt, int piece)
{
    struct attempt *a = attempt;
    knots_enter(&a->knots, piece);
    enc_tables_enter(&a->tables);
}

static bool jump(void *attempt, const arb_t t, arb_ptr box)
{
    struct attempt *a = attempt;
    return enclosed_jump(a->f, &a->problem, a->sol, t, a->prec, box);
}

/* Where a later piece begins: in the motion's variables. */
static void take_start(struct attempt *a)
{
    const struct enclosed_piece *piece = a->rq->piece;
    arb_set(a->t0, piece->t0);
    for (int j = 0; j < a->n; j++)
        for (int k = 0; k < piece->sys->variables; k++)
            if (piece->sys->variable[k].symbol == a->sys->variable[j].symbol)
                arb_set(a->start + j, piece->start + k);
}

static bool place(struct attempt *a, const double *near, struct sga_error *err)
{
    const struct traj_request *rq = a->rq;
    if (rq->piece && rq->piece->start)
        take_start(a);
    else if (!(rq->found ? enclosed_place(rq->found, &a->problem, a->t0, a->prec, a->start, err)
                         : enclosed_start(a->f, a->sys, &a->problem, a->sol, rq, near, a->t0, a->prec, a->start, err)))
        return false;
    return on_sides(a, err);
}

/* The knot as its table has it. */
static const fmpq *lent(const struct knots *q, int knot)
{
    for (int i = 0; i < q->tables; i++)
        for (int k = 0; k < q->table[i]->knots; k++)
            if (fmpq_equal(q->table[i]->knot + k, q->knot + knot))
                return q->table[i]->knot + k;
    return NULL;
}

/* What a piece leaves. */
static void leave(const struct attempt *a)
{
    struct enclosed_piece *piece = a->rq->piece;
    int last = a->happened.count - 1;
    piece->at = NULL;
    piece->wide = a->end.why != ENCLOSE_DONE && a->end.why != ENCLOSE_STOPPED && a->end.why != ENCLOSE_EVENT;
    if (piece->first ? a->end.samples < 1 : a->end.why != ENCLOSE_EVENT)
        return;
    piece->columns = a->columns;
    if (piece->first) {
        piece->at = _arb_vec_init(a->columns);
        _arb_vec_set(piece->at, a->column, a->columns);
        arb_init(&piece->t);
        arb_set(&piece->t, a->time);
        return;
    }
    piece->at = _arb_vec_init(a->columns);
    _arb_vec_set(piece->at, a->happened_column + (size_t)last * (size_t)a->columns, a->columns);
    arb_init(&piece->t);
    arb_set(&piece->t, &a->happened.list[last].t);
    piece->at_once = a->end.at_once;
    piece->at_knot = false;
    piece->knot = NULL;
    for (int k = 0; k < a->knots.count; k++) {
        if (arb_equal(&piece->t, a->knot + k))       /* what happens there does by a jump of the table */
            piece->knot = lent(&a->knots, k);
        piece->at_knot |= arb_overlaps(&piece->t, a->knot + k);
    }
    piece->at_knot &= !piece->knot;
}

static bool run(struct attempt *a, const double *near, struct sga_error *err)
{
    const struct traj_request *rq = a->rq;
    num_ball_constant(a->sys->store, rq->exact_initial ? rq->exact_start : EXPR_UNDEF, rq->start, a->prec, a->t0);
    for (int i = 0; i < rq->samples; i++)
        num_ball_constant(a->sys->store, rq->exact_time ? rq->exact_time[i] : EXPR_UNDEF, rq->times[i], a->prec + 32, a->time + i);
    for (int k = 0; k < a->knots.count; k++)
        arb_set_fmpq(a->knot + k, a->knots.knot + k, a->prec + 32);
    enc_tables_round(&a->tables, a->prec + TABLE_EXTRA);
    enter(a, 0);
    if (!place(a, near, err))
        return false;
    struct enclose_path path = { .start = a->start, .t0 = a->t0, .times = a->time, .samples = rq->samples, .knot = a->knot, .knots = a->knots.count,
                                 .before = a->before, .enter = enter, .jump = enclosed_jumps(a->f, a->sol) ? jump : NULL, .ctx = a,
                                 .prec = a->prec, .happened = &a->happened, .strict = rq->piece && rq->piece->start, .early = rq->piece ? rq->piece->early : 0,
                                 .backward = rq->samples && rq->times[rq->samples - 1] < rq->start };
    enclose_happened_clear(&a->happened);
    if (!enclose_run(&a->problem, &path, a->box, &a->end, err))
        return false;
    columns(a);
    measure(a);
    return true;
}

/* The part of the way that was made. */
static double part_made(const struct attempt *a)
{
    double way = a->rq->times[a->rq->samples - 1] - a->rq->start;
    return way != 0 ? fmin(1, fmax(1.0 / 64, (a->end.t - a->rq->start) / way)) : 1;
}

/* What to try next; 0: more bits would not help. */
static slong more_bits(const struct attempt *a)
{
    slong prec = a->prec, next = 0;
    if (a->rq->piece)
        return 0;
    if (a->end.why == ENCLOSE_WIDE)
        next = (slong)fmin(4.0 * (double)prec, fmax(1.5 * (double)prec, 1.1 * (double)prec / part_made(a)));
    else if (a->excess > 0)
        next = prec + (slong)fmin(4.0 * (double)prec, ceil(a->excess) + 16);
    return next > MOST_BITS ? (prec < MOST_BITS ? MOST_BITS : 0) : next;
}

void attempt_say_time(const struct attempt *a, char *text, size_t room)
{
    snprintf(text, room, "the time limit of %.3g s passed while the solution was enclosed with %ld bits: it had come to t = %.6g of %.6g in %ld steps; "
             "ask for a shorter time, larger tolerances or limits.seconds, or use \"double\"", a->rq->budget->seconds, (long)a->prec, a->end.t,
             a->rq->times[a->rq->samples - 1], a->end.steps);
}

static bool stopped(const struct attempt *a, struct sga_error *err)
{
    struct sga_error why = { 0 };
    char text[256];
    sga_budget_ok(a->rq->budget, &why);
    if (why.code != SGA_E_LIMIT_SECONDS) {
        *err = why;
        return false;
    }
    attempt_say_time(a, text, sizeof text);
    return sga_fail(err, SGA_E_LIMIT_SECONDS, "%s", text);
}

/* The time ended in it, and the boxes that it has are an answer: they are proved. */
static bool keeps_rows(const struct attempt *a)
{
    return rows_are_kept(a->rq) && rows_time_ended(a->rq) && rows_beyond_start(a->rq, a->end.samples, NULL);
}

static bool supported(const struct traj_request *rq, struct sga_error *err)
{
    if (rq->method && strcmp(rq->method, "auto") && strcmp(rq->method, "taylor"))
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/accuracy/method", "ball arithmetic has Taylor series only; leave the method out");
    return true;
}

/* Their exact knots, and which of them lie before the samples. */
static bool with_tables(struct attempt *a, struct sga_error *err)
{
    if (!knots_init(&a->knots, a->sys, a->rq, err) || !knots_before(&a->knots, a->rq, a->before, err))
        return false;
    enc_tables_init(&a->tables, a->knots.table, a->knots.tables);
    a->knot = _arb_vec_init(a->knots.count);
    a->problem.tables = &a->tables;
    return true;
}


slong enclosed_first_bits(double rtol)
{
    return (slong)fmax(LEAST_BITS, FIRST_EXTRA - log2(rtol));
}

/* With more and more bits. False: there is none. The attempts take turns; *best: the one that counts, the last unless the time ended in it and
 * the one before came as far. */
static bool attempts(struct attempt *a, const double *near, const struct attempt **best, struct sga_error *err)
{
    bool ok = true;
    int count = 0;
    for (slong next = a->rq->piece ? a->rq->piece->prec : enclosed_first_bits(a->rq->rtol); ok && next; count++) {
        struct attempt *now = a + count % 2, *before = count ? a + (count + 1) % 2 : NULL;
        if (count < 2) {
            attempt_init(now);
            ok = with_tables(now, err);
        }
        now->prec = next;
        ok = ok && run(now, near, err);
        *best = now;
        bool late = rows_are_kept(a->rq) && rows_time_ended(a->rq) && (!ok || now->end.why == ENCLOSE_STOPPED);
        if (late && before && (!ok || before->end.samples >= now->end.samples) && rows_beyond_start(a->rq, before->end.samples, NULL)) {
            before->last = ok = true;
            *best = before;
            *err = (struct sga_error){ 0 };
            break;
        }
        now->last = late;
        ok = ok && (now->end.why != ENCLOSE_STOPPED || keeps_rows(now) || stopped(now, err));
        next = ok && now->end.why != ENCLOSE_STOPPED ? more_bits(now) : 0;
        assert(next == 0 || next > now->prec);       /* so that it ends */
    }
    return ok;
}

bool enclosed_run(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                  struct traj_result *r, struct sga_error *err)
{
    struct traj_request timed;
    struct sga_budget until;
    if (!supported(rq, err))
        return false;
    const struct traj_request *own = rows_are_kept(rq) ? rows_request(rq, rq->rows_until, &timed, &until) : rq;
    struct attempt a[2] = { { .f = f, .sys = sys, .sol = sol, .rq = own, .n = f->n, .columns = rq->outputs ? rq->outputs : f->n } };
    const struct attempt *best = a;
    double *near = memcpy(sga_malloc((size_t)(f->n + 1) * sizeof *near), r->initial, (size_t)f->n * sizeof *near);
    bool ok = enclosed_problem(f, sys, sol, own, &a[0].problem, err);
    SGA_FREED struct enclose_watch *watch = sga_calloc((size_t)own->events + 1, sizeof *watch);
    if (ok) {
        enclosed_watch(sys->store, &a[0].problem, own, watch);
        a[0].problem.watch = watch;
        a[0].problem.watches = own->events;
        a[0].happened.n = f->n;
    }
    a[1] = a[0];
    ok = ok && attempts(a, near, &best, err);
    if (ok) {
        attempt_keep(best, r);
        if (own->piece)
            leave(best);
        r->out_of_time = rows_are_kept(rq) && (best->end.why == ENCLOSE_STOPPED || best->last || sga_now() >= rq->rows_until);
    }
    attempt_clear(a);
    attempt_clear(a + 1);
    enclosed_problem_clear(&a[0].problem);
    free(near);
    return ok;
}
