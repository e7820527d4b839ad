/* From bits to tolerances: the ball trajectory is run with more bits until its radii are as small as asked. */
#include "enclosed.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "budget.h"
#include "buf.h"
#include "flow.h"
#include "mem.h"
#include "points.h"
#include "print.h"
#include "reduction.h"
#include "sizes.h"
#include "system.h"
#include "trajectory.h"

enum { FIRST_EXTRA = 48, LEAST_BITS = 80, MOST_BITS = 10000 };

struct attempt {
    struct flow *f;
    const struct sys_system *sys;
    const struct sga_solution *sol;
    const struct traj_request *rq;
    struct enclose_problem problem;
    slong prec;
    arb_ptr start, time, box, column;    /* n; samples; samples x n; samples x columns */
    arb_t t0;
    int n, columns;
    struct enclose_end end;
    double excess;                       /* log2 of the largest radius / tolerance; -INFINITY where all are exact */
};

static void attempt_init(struct attempt *a)
{
    a->start = _arb_vec_init(a->n);
    a->time = _arb_vec_init(a->rq->samples);
    a->box = _arb_vec_init((slong)a->rq->samples * a->n);
    a->column = _arb_vec_init((slong)a->rq->samples * a->columns);
    arb_init(a->t0);
}

static void attempt_clear(struct attempt *a)
{
    _arb_vec_clear(a->start, a->n);
    _arb_vec_clear(a->time, a->rq->samples);
    _arb_vec_clear(a->box, (slong)a->rq->samples * a->n);
    _arb_vec_clear(a->column, (slong)a->rq->samples * a->columns);
    arb_clear(a->t0);
}

/* Values of roots on the box of sample i, into out. */
static void evaluate(struct attempt *a, struct num_ball *b, struct expr_cone *cone, const expr_id *root, int roots, int i, arb_ptr out)
{
    for (int j = 0; j < a->n; j++)
        num_ball_set(b, a->sys->variable[j].symbol, a->box + (size_t)i * (size_t)a->n + (size_t)j);
    num_ball_set(b, a->sys->time, a->time + i);
    num_ball_list(b, cone->list, cone->count);
    for (int k = 0; k < roots; k++)
        arb_set(out + k, num_ball_value(b, root[k]));
}

static void columns(struct attempt *a)
{
    if (!a->rq->outputs) {
        _arb_vec_set(a->column, a->box, (slong)a->end.samples * a->n);
        return;
    }
    struct num_ball b;
    struct expr_cone cone;
    num_ball_init(&b, a->sys->store, a->prec + 20);
    expr_cone_init(&cone);
    expr_cone_of(a->sys->store, &cone, a->rq->output, a->rq->outputs);
    for (int i = 0; i < a->end.samples; i++)
        evaluate(a, &b, &cone, a->rq->output, a->columns, i, a->column + (size_t)i * (size_t)a->columns);
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
        num_ball_list(&b, cone.list, cone.count);
        arb_srcptr v = num_ball_value(&b, sol->side[i].function);
        on = sol->side[i].sign > 0 ? arb_is_positive(v) : arb_is_negative(v);
    }
    expr_cone_clear(&cone);
    num_ball_clear(&b);
    return on || sga_fail(err, SGA_E_NO_MOTION, "it cannot be shown that the start lies on the side of evidence.sides on which the answer "
                          "holds; give trajectory.initial well on that side");
}

static bool run(struct attempt *a, const double *near, struct sga_error *err)
{
    const struct traj_request *rq = a->rq;
    enclosed_constant(a->sys->store, rq->exact_initial ? rq->exact_start : EXPR_UNDEF, rq->start, a->prec, a->t0);
    for (int i = 0; i < rq->samples; i++)
        enclosed_constant(a->sys->store, rq->exact_time ? rq->exact_time[i] : EXPR_UNDEF, rq->times[i], a->prec + 32, a->time + i);
    if (!enclosed_start(a->f, a->sys->store, &a->problem, a->sol, rq, near, a->t0, a->prec, a->start, err) || !on_sides(a, err))
        return false;
    struct enclose_path path = { .start = a->start, .t0 = a->t0, .times = a->time, .samples = rq->samples, .prec = a->prec };
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
    if (a->end.why == ENCLOSE_WIDE)
        next = (slong)fmin(4.0 * (double)prec, fmax(1.5 * (double)prec, 1.1 * (double)prec / part_made(a)));
    else if (a->excess > 0)
        next = prec + (slong)fmin(4.0 * (double)prec, ceil(a->excess) + 16);
    return next > MOST_BITS ? (prec < MOST_BITS ? MOST_BITS : 0) : next;
}

static bool stopped(const struct attempt *a, struct sga_error *err)
{
    struct sga_error why = { 0 };
    sga_budget_ok(a->rq->budget, &why);
    if (why.code != SGA_E_LIMIT_SECONDS) {
        *err = why;
        return false;
    }
    return sga_fail(err, SGA_E_LIMIT_SECONDS, "the time limit of %.3g s passed while the solution was enclosed with %ld bits: it had come to t = %.6g of %.6g "
                    "in %ld steps; ask for a shorter time, larger tolerances or limits.seconds, or use \"double\"", a->rq->budget->seconds,
                    (long)a->prec, a->end.t, a->rq->times[a->rq->samples - 1], a->end.steps);
}

/* Why there is no proof beyond. */
static void say_end(const struct attempt *a, struct traj_result *r)
{
    struct sga_buf text = { 0 };
    r->ended = a->end.why != ENCLOSE_DONE;
    r->ended_t = a->end.t;
    r->ended_event = -1;
    if (!r->ended)
        return;
    r->ended_reason = "not_enclosed";
    if (a->end.why == ENCLOSE_WIDE)
        snprintf(r->ended_detail, sizeof r->ended_detail, "the enclosure grows too wide here with %ld bits: neighbouring solutions part too fast; "
                 "ask for a shorter time, or use \"double\"", (long)a->prec);
    else if (a->end.why == ENCLOSE_MAY_VANISH && expr_print(a->sys->store, a->problem.nonzero[a->end.which], 90, &text))
        snprintf(r->ended_detail, sizeof r->ended_detail, "it cannot be shown that %s, which the reduction divides by or holds on one side of, is not 0 "
                 "beyond this time", text.data);
    else
        snprintf(r->ended_detail, sizeof r->ended_detail, "beyond this time it cannot be shown that the solution exists and the field is analytic along it: "
                 "a pole, the edge of a domain, or a change of branch (abs, sign, min, max, a root of 0)");
    sga_buf_free(&text);
}

static void numbers(const struct attempt *a, struct traj_result *r)
{
    size_t total = (size_t)a->end.samples * (size_t)a->columns;
    assert(a->end.samples >= 0 && a->end.samples <= a->rq->samples && (a->end.why != ENCLOSE_DONE || a->end.samples == a->rq->samples));
    r->rows = a->end.samples;
    r->columns = a->columns;
    r->t = sga_malloc((size_t)(r->rows + 1) * sizeof *r->t);
    r->value = sga_malloc((total + 1) * sizeof *r->value);
    r->radius = sga_malloc((total + 1) * sizeof *r->radius);
    r->digits = sga_calloc(total + 1, sizeof *r->digits);
    r->error = sga_calloc((size_t)r->rows + 1, sizeof *r->error);
    for (int i = 0; i < r->rows; i++) {
        r->t[i] = a->rq->times[i];
        for (int k = 0; k < r->columns; k++) {
            size_t at = (size_t)i * (size_t)r->columns + (size_t)k;
            r->digits[at] = enclose_decimal(a->column + at, a->prec, r->radius + at);
            r->value[at] = r->digits[at] ? strtod(r->digits[at], NULL) : NAN;
            r->error[i] = fmax(r->error[i], r->radius[at]);
        }
        r->error_estimate = fmax(r->error_estimate, r->error[i]);
    }
    r->column_error = traj_column_errors(r->radius, r->rows, r->columns);
}

/* Of the midpoints, which are not on the set exactly. */
static void residual(struct attempt *a, struct traj_result *r)
{
    int c = a->sol->constraints;
    if (!c)
        return;
    struct num_ball b;
    struct expr_cone cone;
    expr_id *root = sga_malloc((size_t)c * sizeof *root);
    arb_ptr value = _arb_vec_init(c);
    mag_t m;
    for (int k = 0; k < c; k++)
        root[k] = a->sol->constraint[k].expr;
    num_ball_init(&b, a->sys->store, a->prec + 20);
    expr_cone_init(&cone);
    expr_cone_of(a->sys->store, &cone, root, c);
    mag_init(m);
    for (int i = 0; i < a->end.samples; i++) {
        for (int j = 0; j < a->n; j++)
            mag_zero(arb_radref(a->box + (size_t)i * (size_t)a->n + (size_t)j));
        evaluate(a, &b, &cone, root, c, i, value);
        for (int k = 0; k < c; k++) {
            arb_get_mag(m, value + k);
            r->residual = fmax(r->residual, enclose_above(m));
        }
    }
    mag_clear(m);
    _arb_vec_clear(value, c);
    free(root);
    expr_cone_clear(&cone);
    num_ball_clear(&b);
}

static void keep(struct attempt *a, struct traj_result *r)
{
    say_end(a, r);
    numbers(a, r);
    residual(a, r);
    for (int j = 0; j < a->n; j++)
        r->initial[j] = arf_get_d(arb_midref(a->start + j), ARF_RND_NEAR);
    if (a->excess > 0)
        r->shortfall = "the enclosures are rigorous but wider than the tolerances, with as many bits as are used at most";
    r->method = "taylor";
    r->arithmetic = "ball";
    r->steps = a->end.steps;
    r->evaluations = a->end.evaluations;
}

static bool supported(const struct traj_request *rq, struct sga_error *err)
{
    if (rq->events)
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/events", "events are not located in ball arithmetic; leave them out, or use \"double\"");
    if (rq->method && strcmp(rq->method, "auto") && strcmp(rq->method, "taylor"))
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/accuracy/method", "ball arithmetic has Taylor series only; leave the method out");
    return true;
}

bool enclosed_run(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                  struct traj_result *r, struct sga_error *err)
{
    struct attempt a = { .f = f, .sys = sys, .sol = sol, .rq = rq, .n = f->n, .columns = rq->outputs ? rq->outputs : f->n };
    if (!supported(rq, err))
        return false;
    double *near = memcpy(sga_malloc((size_t)(a.n + 1) * sizeof *near), r->initial, (size_t)a.n * sizeof *near);
    bool ok = enclosed_problem(f, sys, sol, rq, &a.problem, err);
    attempt_init(&a);
    slong next = (slong)fmax(LEAST_BITS, FIRST_EXTRA - log2(rq->rtol));
    while (ok && next) {
        a.prec = next;
        ok = run(&a, near, err) && (a.end.why != ENCLOSE_STOPPED || stopped(&a, err));
        next = ok ? more_bits(&a) : 0;
        assert(next == 0 || next > a.prec);       /* so that it ends */
    }
    if (ok)
        keep(&a, r);
    attempt_clear(&a);
    enclosed_problem_clear(&a.problem);
    free(near);
    return ok;
}
