/* Between two pieces in double-double: what is set, where the motion goes on, and derivatives there. See jump_fine.h. */
#include "jump_fine.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "enclosed.h"
#include "error.h"
#include "field.h"
#include "jet.h"
#include "jump_impulse.h"
#include "jump_slope.h"
#include "jump_turn.h"
#include "mem.h"
#include "points.h"
#include "precise.h"
#include "reduction.h"
#include "signal.h"
#include "sizes.h"
#include "system.h"
#include "tables_ahead.h"
#include "tape.h"

enum { BITS = 256, TABLE_BITS = 16 * BITS };
/* Of a size: what is set stays on the constraints, as far as double-double tells. */
static const double STAYS = 1e-24;
/* The point that balls tell is that of double, beside 1 + its size. */
static const double SAME_POINT = 1e-6;

bool jump_fine_evaluate(const struct num_tape *tape, int inputs, num_dd t, const num_dd *x, const num_dd *speed, int speeds, num_dd *out, num_dd *rate, int roots)
{
    struct num_jet2 *j = num_jet2_new(tape, rate ? 1 : 0);
    for (int k = 0; k <= inputs; k++) {
        num_jet2_input(j, k)[0] = k < inputs ? x[k] : t;
        if (rate)
            num_jet2_input(j, k)[1] = k == inputs ? num_dd_of(1) : k < speeds ? speed[k] : num_dd_of(0);
    }
    num_jet2_hold(j, tape);
    bool ok = num_jet2_next(j, 0) && (!rate || num_jet2_next(j, 1));
    for (int r = 0; r < roots; r++) {
        out[r] = num_jet2_root(j, r)[0];
        ok = ok && isfinite(out[r].hi);
        if (rate)
            rate[r] = num_jet2_root(j, r)[1];
    }
    num_jet2_free(j);
    return ok;
}

/* A turn. */
struct between {
    struct jump_fine *f;
    const struct jump *from, *to;
    const struct jump_at *at;
    const struct jump_to *landed;
    int q;                        /* directions */
    num_dd *asked, *x;            /* of `to`: as set, and where it goes on */
    num_dd *tau, *y, *field;      /* by direction; directions x n of `to`; n of `from` */
    double *after;                /* n of `to`: the field there */
};

static bool no_value(const struct between *b, struct sga_error *err)
{
    return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/events", "at %.10g what is set, or its derivatives, have no value in double-double; use \"double\"", b->at->t);
}

/* By names from the variables before to those after. */
static void carry(const struct between *b, const num_dd *from, num_dd *to)
{
    for (int k = 0; k < b->from->n; k++) {
        int v = jump_same(b->from, k, b->to);
        if (v >= 0)
            to[v] = from[k];
    }
}

static bool assign(struct between *b, struct sga_arena *mem)
{
    const struct traj_request *rq = b->from->rq;
    int n = b->from->n, roots = b->from->sets + rq->events;
    num_dd *out = sga_zeros(mem, (size_t)roots + 1, sizeof *out), *y = sga_zeros(mem, (size_t)n + 1, sizeof *y);
    memcpy(y, b->f->x, (size_t)n * sizeof *y);
    bool ok = jump_fine_evaluate(b->from->tape, n, b->f->t, b->f->x, NULL, 0, out, NULL, roots);
    for (int e = 0, i = 0; e < rq->events; i += rq->event[e++].sets)
        for (int k = 0; k < rq->event[e].sets && b->at->fired[e]; k++)
            if (rq->event[e].set[k].variable >= 0)
                y[rq->event[e].set[k].variable] = num_dd_mul_d(out[i + k], 1 + b->f->wrong);
    carry(b, y, b->asked);
    return ok;
}

/* The start after it, as jump_land has found it, to all digits. */
static bool place(struct between *b, struct sga_arena *mem, struct sga_error *err)
{
    const struct jump *j = b->to;
    struct expr_store *st = j->sys->store;
    size_t n = (size_t)j->n;
    struct traj_request q;
    double *x = sga_zeros(mem, n + 1, sizeof *x), t = b->f->t.hi;
    unsigned char *place = sga_zeros(mem, 2 * n + 2, 1);
    expr_id *exact = sga_zeros(mem, n + 1, sizeof *exact), time = jump_fine_constant(st, b->f->t);
    struct jump_to asked = *b->landed;
    asked.x = x;
    for (size_t k = 0; k < n; k++) {
        x[k] = b->landed->known[k] ? b->asked[k].hi : 0;
        exact[k] = b->landed->known[k] ? jump_fine_constant(st, b->asked[k]) : EXPR_UNDEF;
    }
    jump_request(j, b->at, &asked, b->landed->way, place, &q);
    q.start = t;
    q.times = &t;
    q.samples = 1;
    q.exact_start = time;
    q.exact_time = &time;
    q.exact_initial = exact;
    q.arithmetic = TRAJ_DOUBLE_DOUBLE;
    if (!expr_store_ok(st)) {
        *err = *st->error;
        return false;
    }
    if (precise_place(j->sys, j->sol, &q, b->x, err))
        return true;
    *err = err->code == SGA_E_NOT_SUPPORTED ? (struct sga_error){ 0 } : *err;      /* its digits are not told so: perhaps they are by balls */
    return false;
}

/* The motion begins: its time stays. */
static void as_they_are(struct between *b)
{
    int n = b->from->n;
    for (int d = 0; d < b->q; d++)
        carry(b, b->f->x + n + d * n, b->y + (size_t)d * (size_t)b->to->n);
}

/* When, and the derivatives along the event: of what is kept and what is set. */
static bool along(struct between *b, struct sga_arena *mem)
{
    const struct jump_slope *s = b->from->slope;
    const struct traj_request *rq = b->from->rq;
    int n = b->from->n, all = s->rows.all, q = b->q, roots = s->rows.first + s->rows.count * (1 + q), slopes = (rq->events + s->sets + s->masses) * q;
    num_dd *out = sga_zeros(mem, (size_t)roots + 1, sizeof *out), *rate = sga_zeros(mem, (size_t)roots + 1, sizeof *rate), *slope = sga_zeros(mem, (size_t)slopes + 1, sizeof *slope);
    num_dd *y = sga_zeros(mem, (size_t)n + 1, sizeof *y);
    jump_slope_came(b->from->slope, b->at);
    if (!jump_fine_evaluate(s->field, all, b->f->t, b->f->x, NULL, 0, b->field, NULL, n) || !jump_fine_evaluate(s->rows.value, all, b->f->t, b->f->x, b->field, n, out, rate, roots)
        || !jump_fine_evaluate(s->slope, all, b->f->t, b->f->x, NULL, 0, slope, NULL, slopes))
        return false;
    bool found = false;
    for (int e = 0; e < rq->events && !found; e++)
        for (int d = 0; d < q && b->at->fired[e] && (rq->event[e].sets || rq->event[e].turns); d++) {
            found |= slope[e * q + d].hi != 0;
            b->tau[d] = slope[e * q + d].hi != 0 ? num_dd_neg(num_dd_div(slope[e * q + d], rate[e])) : num_dd_of(0);
        }
    for (int d = 0; d < q; d++) {
        for (int k = 0; k < n; k++)
            y[k] = num_dd_add(b->f->x[n + d * n + k], num_dd_mul(b->field[k], b->tau[d]));
        for (int e = 0, root = rq->events; e < rq->events; e++)
            for (int k = 0; k < rq->event[e].sets; k++, root++)
                if (b->at->fired[e] && rq->event[e].set[k].variable >= 0)
                    y[rq->event[e].set[k].variable] = num_dd_mul_d(num_dd_add(slope[root * q + d], num_dd_mul(rate[root], b->tau[d])), 1 + b->f->wrong);
        carry(b, y, b->y + (size_t)d * (size_t)b->to->n);
    }
    return true;
}

/* What equations differentiate is where it was set. */
static bool stays(const struct between *b)
{
    bool all = true;
    for (int k = 0; k < b->to->n; k++) {
        double off = fabs(num_dd_sub(b->x[k], b->asked[k]).hi);
        all &= !b->to->moving[k] || (b->landed->known[k] && off <= STAYS * (1 + fabs(b->x[k].hi)));
    }
    return all;
}

/* The constraints after it, with their derivatives along the event: xi_x s + xi_k + xi_t tau. */
static struct sga_constraint *along_event(const struct between *b, const struct traj_mode *own, struct sga_arena *mem)
{
    struct expr_store *st = own->sys->store;
    int each = 1 + b->q, c = own->sol->constraints;
    struct sga_constraint *to = sga_zeros(mem, (size_t)c + 1, sizeof *to);
    memcpy(to, own->sol->constraint, (size_t)c * sizeof *to);
    for (int i = 0; i < c; i += each)
        for (int d = 1; d < each; d++)
            to[i + d].expr = expr_add(st, to[i + d].expr, expr_mul(st, jump_fine_constant(st, b->tau[d - 1]), expr_time_partial(st, to[i].expr, own->sys->time)));
    return to;
}

/* x (variables, then derivatives along the event): the nearest point to what was set, by balls, from what double has found. False: it is not told. */
static bool nearest(const struct between *b, const struct traj_mode *own, num_dd *x, struct sga_arena *mem)
{
    struct expr_store *st = own->sys->store;
    size_t n = (size_t)b->to->n, all = (size_t)own->sys->variables;
    double *asked = sga_zeros(mem, n + 1, sizeof *asked), *unit = sga_zeros(mem, n + 1, sizeof *unit), *near = sga_zeros(mem, all + 1, sizeof *near);
    unsigned char *place = sga_zeros(mem, 2 * n + 2, 1);
    expr_id *exact = sga_zeros(mem, all + 1, sizeof *exact);
    struct jump_to set = *b->landed;
    struct traj_request q, rq = *own->rq;
    struct sizes sizes;
    SGA_FREED int *variable = field_inputs(own->sys);
    SGA_ENDS(arb_end) arb_t t = { 0 };
    set.x = asked;
    for (size_t k = 0; k < n; k++) {
        asked[k] = b->landed->known[k] ? b->asked[k].hi : 0;
        near[k] = b->landed->x[k];
    }
    for (size_t k = 0; k < all; k++)
        exact[k] = k < n ? jump_fine_constant(st, b->asked[k]) : jump_fine_constant(st, b->y[k - n]);
    for (size_t k = n; k < all; k++)
        near[k] = b->landed->slope[k - n] + b->after[(k - n) % n] * b->tau[(k - n) / n].hi;      /* along the event */
    jump_request(b->to, b->at, &set, b->landed->way, place, &q);
    sizes_init(&sizes, b->to->sys, &q);
    bool fixed = true;
    for (size_t k = 0; k < n; k++) {
        unit[k] = sizes_move(&sizes, (int)k, asked[k]);
        fixed &= !q.given[k] || q.held[k] || unit[k] == sizes_move(&sizes, (int)k, 0);
    }
    sizes_clear(&sizes);
    const struct traj_asked of = { true, true, (int)n, b->q, asked, unit, q.given, q.held };
    struct sga_solution sol = *own->sol;
    sol.constraint = along_event(b, own, mem);
    rq.asked = &of;
    rq.exact_initial = exact;
    arb_set_d(t, b->f->t.lo);
    SGA_ENDS(arb_end) arb_t hi = { 0 };
    arb_set_d(hi, b->f->t.hi);
    arb_add(t, t, hi, ARF_PREC_EXACT);
    struct enclose_problem p = { .st = st, .variable = variable, .n = (int)all, .time = own->sys->time, .budget = own->rq->budget };
    struct tables_ahead ahead;
    arb_ptr ball = arbs_take(mem, (slong)all);
    bool ok = tables_ahead_enter(&ahead, own->sys, &q, TABLE_BITS) && fixed && expr_store_ok(st);
    p.tables = &ahead.balls;
    ok = ok && enclosed_nearest(own->sys, &p, &sol, &rq, NULL, near, t, BITS, ball);
    for (size_t k = 0; k < all && ok; k++) {
        x[k] = jump_fine_ball(ball + k);
        ok = fabs(x[k].hi - near[k]) <= SAME_POINT * (1 + fabs(near[k])) && mag_get_d(arb_radref(ball + k)) <= STAYS * (1 + fabs(near[k]));
    }
    tables_ahead_leave(&ahead);
    return ok;
}

/* The field after it, of the motion's own variables. */
static bool field_after(const struct between *b, const num_dd *x, num_dd *field, struct sga_arena *mem)
{
    const struct jump_slope *s = b->to->slope;
    num_dd *in = sga_zeros(mem, (size_t)s->rows.all + 1, sizeof *in);
    double *double_x = sga_zeros(mem, (size_t)b->to->n + 1, sizeof *double_x);
    memcpy(in, x, (size_t)b->to->n * sizeof *in);
    for (int k = 0; k < b->to->n; k++)
        double_x[k] = x[k].hi;
    jump_slope_goes(b->to->slope, b->at->t, double_x);
    return jump_fine_evaluate(s->field, s->rows.all, b->f->t, in, NULL, 0, field, NULL, b->to->n);
}

/* Derivatives where what is set stays: those of what equations do not differentiate are near enough to be solved for. */
static void keep(const struct between *b, num_dd *x)
{
    int n = b->to->n;
    memcpy(x, b->x, (size_t)n * sizeof *x);
    for (int i = 0; i < b->q * n; i++)
        x[n + i] = b->to->moving[i % n] ? b->y[i] : num_dd_add(num_dd_of(b->landed->slope[i]), num_dd_mul_d(b->tau[i / n], b->after[i % n]));
}

/* x (all): where the motion goes on. */
static bool go_on(struct between *b, const struct traj_mode *own, bool there, num_dd *x, struct sga_arena *mem, struct sga_error *err)
{
    int n = b->to->n;
    num_dd *field = sga_zeros(mem, (size_t)n + 1, sizeof *field), *double_x = sga_zeros(mem, (size_t)n + 1, sizeof *double_x);
    for (int k = 0; k < n; k++)
        double_x[k] = num_dd_of(b->landed->x[k]);
    if (b->q && !field_after(b, double_x, field, mem))
        return no_value(b, err);
    for (int k = 0; k < n; k++)
        b->after[k] = field[k].hi;
    if (there && (!b->q || stays(b)))
        keep(b, x);
    else if (!nearest(b, own, x, mem))
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/events", "at %.10g what is set lies off the constraints, and the nearest point is known to a double's digits only; use \"double\", or set "
                           "values that satisfy them", b->at->t);
    if (b->q && !field_after(b, x, field, mem))
        return no_value(b, err);
    for (int i = 0; i < b->q * n; i++)
        x[n + i] = num_dd_sub(x[n + i], num_dd_mul(field[i % n], b->tau[i / n]));
    return true;
}

bool jump_fine_turn(struct jump_fine *f, const struct turn *s, const struct jump_at *at, const struct jump_to *to, struct sga_error *err)
{
    SGA_ARENA(mem);
    struct between b = { f, s->changing ? &s->before : &s->j, &s->j, at, to, s->j.slope ? s->j.slope->rows.q : 0, NULL, NULL, NULL, NULL, NULL, NULL };
    size_t n = (size_t)b.to->n, all = n * (size_t)(1 + b.q);
    b.asked = sga_zeros(&mem, n + 1, sizeof *b.asked);
    b.x = sga_zeros(&mem, n + 1, sizeof *b.x);
    b.tau = sga_zeros(&mem, (size_t)b.q + 1, sizeof *b.tau);
    b.y = sga_zeros(&mem, all + 1, sizeof *b.y);
    b.field = sga_zeros(&mem, (size_t)b.from->n + 1, sizeof *b.field);
    b.after = sga_zeros(&mem, n + 1, sizeof *b.after);
    bool happens = memchr(at->fired, 1, (size_t)b.from->rq->events) != NULL;
    if (!assign(&b, &mem) || (b.q && happens && !along(&b, &mem)))
        return no_value(&b, err);
    if (!happens)
        as_they_are(&b);
    const struct traj_mode own = jump_carried(s->mode);
    struct impulse_found found;
    if (b.to->rq->mass && (!jump_impulse_fine(b.to, f->t, b.asked, to, &found, &mem)
                           || (b.q && !jump_impulse_slope(b.to, &own, f->t, b.asked, &found, to, b.tau, b.q, b.y))))
        return no_value(&b, err);
    bool there = place(&b, &mem, err);
    if (err->code != SGA_E_OK)
        return false;
    num_dd *x = sga_calloc(all + 1, sizeof *x);
    assert((size_t)own.sys->variables == all);
    bool ok = go_on(&b, &own, there, x, &mem, err);
    free(f->x);
    f->x = x;
    f->t = num_dd_add_d(f->t, f->wrong * fabs(f->t.hi));        /* as in double, all to one side at the worst */
    return ok;
}
