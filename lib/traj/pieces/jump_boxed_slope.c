/* Derivatives of a motion in balls at an event that sets variables: the formulas of jump_slope.h. See jump_boxed.h. */
#include "arb_ends.h"
#include "arena.h"
#include "derive.h"
#include "error.h"
#include "field.h"
#include "jump_boxed_between.h"
#include "mem.h"
#include "reduction.h"
#include "signal.h"
#include "system.h"
#include "tables_ahead.h"

struct sloping {
    const struct between *w;
    const struct traj_carried *from, *to;   /* variables and derivatives */
    int n, m, q;                  /* variables before, and after; directions */
    slong prec;
    arb_ptr field, tau;           /* n; q */
    arb_ptr y;                    /* q x m: along the event; then where the motion goes on */
};

/* Gradient and derivative by time of e along the motion before the event, at it: into rate. */
static bool rate_of(const struct sloping *s, expr_id e, arb_t rate)
{
    const struct sys_system *sys = s->from->sys;
    struct expr_store *st = sys->store;
    SGA_ARENA(mem);
    expr_id *part = sga_take(&mem, ((size_t)s->n + 1) * sizeof *part);
    arb_ptr v = arbs_take(&mem, s->n + 1);
    for (int k = 0; k < s->n; k++)
        part[k] = expr_diff(st, e, sys->variable[k].symbol);
    part[s->n] = expr_time_partial(st, e, sys->time);
    if (!expr_store_ok(st) || !enclosed_values(sys, &s->w->b->t, s->w->x, part, s->n + 1, s->prec, v))
        return false;
    arb_dot(rate, v + s->n, 0, v, 1, s->field, 1, s->n, s->prec + 20);
    return true;
}

/* How the time of the event changes. */
static bool times(const struct sloping *s)
{
    const struct traj_request *rq = s->from->rq;
    SGA_ENDS(arb_end) arb_t rate = { 0 };
    int e = 0;
    while (e < rq->events && !(s->w->at->fired[e] && (rq->event[e].sets || rq->event[e].turns)))
        e++;
    if (e == rq->events || !rate_of(s, rq->event[e].expression, rate)
        || !enclosed_values(s->from->sys, &s->w->b->t, s->w->x, rq->slopes->event + e * s->q, s->q, s->prec, s->tau))
        return false;
    for (int d = 0; d < s->q; d++) {
        bool still = arb_is_zero(s->tau + d);
        arb_div(s->tau + d, s->tau + d, rate, s->prec + 20);
        arb_neg(s->tau + d, s->tau + d);
        if (still)
            arb_zero(s->tau + d);
    }
    return true;
}

/* What is kept, and what is set, along the event: z (q x n), of the variables before it. */
static bool assigned(const struct sloping *s, arb_ptr z)
{
    const struct traj_request *rq = s->from->rq;
    SGA_ARENA(mem);
    arb_ptr slope = arbs_take(&mem, s->q);
    SGA_ENDS(arb_end) arb_t rate = { 0 };
    for (int i = 0; i < s->q * s->n; i++) {
        arb_mul(z + i, s->field + i % s->n, s->tau + i / s->n, s->prec + 20);
        arb_add(z + i, z + i, s->w->x + s->n + i, s->prec + 20);
    }
    for (int e = 0, place = 0; e < rq->events; e++)
        for (int k = 0; k < rq->event[e].sets; k++, place++) {
            int v = rq->event[e].set[k].variable;
            if (!s->w->at->fired[e] || v < 0)
                continue;
            if (!rate_of(s, rq->event[e].set[k].value, rate) || !enclosed_values(s->from->sys, &s->w->b->t, s->w->x, rq->slopes->set + place * s->q, s->q, s->prec, slope))
                return false;
            for (int d = 0; d < s->q; d++) {
                arb_ptr to = z + d * s->n + v;
                arb_mul(to, rate, s->tau + d, s->prec + 20);
                arb_add(to, to, slope + d, s->prec + 20);
            }
        }
    return true;
}

static bool along(const struct sloping *s)
{
    SGA_ARENA(mem);
    arb_ptr z = arbs_take(&mem, (slong)s->q * s->n);
    bool again = s->w->b->again;
    if ((s->w->happens || again) && (!enclosed_values(s->from->sys, &s->w->b->t, s->w->x, s->from->sol->field, s->n, s->prec, s->field) || (!again && !times(s))))
        return false;
    if (again)
        _arb_vec_set(s->tau, s->w->b->tau, s->q);
    if (!assigned(s, z))
        return false;
    for (int k = 0; k < s->n; k++) {
        int v = jump_same(s->w->from, k, s->w->to);
        for (int d = 0; d < s->q && v >= 0; d++)
            arb_set(s->y + d * s->m + v, z + d * s->n + k);
    }
    return true;
}

/* What was solved for with the start follows along the event too: xi_x s + xi_k + xi_t tau = 0. */
static bool follow(const struct sloping *s, int d)
{
    const struct sys_system *sys = s->to->sys;
    struct expr_store *st = sys->store;
    int each = 1 + s->q, all = s->m * each, functions = 0;
    SGA_ARENA(mem);
    SGA_FREED int *inputs = field_inputs(sys);
    int *symbol = sga_take(&mem, ((size_t)all + 2) * sizeof *symbol);
    expr_id *function = sga_take(&mem, ((size_t)s->to->sol->constraints + 1) * sizeof *function);
    unsigned char *solved = sga_zeros(&mem, (size_t)all + 2, 1);
    arb_ptr u = arbs_take(&mem, all + 1);
    struct sga_error ignored = { 0 };
    memcpy(symbol, inputs, (size_t)all * sizeof *symbol);
    symbol[all] = enclosed_symbol(st, "time of the event", d);
    _arb_vec_set(u, s->w->y, s->m);
    _arb_vec_set(u + s->m, s->y, (slong)s->q * s->m);
    arb_set(u + all, s->tau + d);
    for (int i = 0; i < s->w->to->sol->constraints; i++)
        if (s->w->used[i]) {
            expr_id by_time = expr_time_partial(st, s->to->sol->constraint[i * each].expr, sys->time);
            function[functions++] = expr_add(st, s->to->sol->constraint[i * each + 1 + d].expr, expr_mul(st, st->symbol[symbol[all]].node, by_time));
        }
    for (int k = 0; k < s->m; k++)
        if (s->w->solved[k]) {
            solved[s->m + d * s->m + k] = 1;
            arb_set_d(u + s->m + d * s->m + k, s->w->landed->slope[d * s->m + k]);
        }
    struct enclose_problem p = { .st = st, .variable = symbol, .n = all + 1, .time = sys->time, .tables = &s->w->ahead->balls, .budget = s->to->rq->budget };
    bool ok = expr_store_ok(st) && (!functions || enclose_zero(&p, function, functions, &s->w->b->t, solved, s->prec, u, &ignored));
    if (ok)
        _arb_vec_set(s->y + d * s->m, u + s->m + d * s->m, s->m);
    return ok;
}

/* Constraints, each followed by its derivatives, these along the event. tau: symbols. */
static struct sga_constraint *along_event(const struct sloping *s, const int *tau, struct sga_arena *mem)
{
    struct expr_store *st = s->to->sys->store;
    int each = 1 + s->q, c = s->to->sol->constraints;
    struct sga_constraint *to = sga_zeros(mem, (size_t)c + 1, sizeof *to);
    memcpy(to, s->to->sol->constraint, (size_t)c * sizeof *to);
    for (int i = 0; i < c; i += each)
        for (int d = 1; d < each; d++)
            to[i + d].expr = expr_add(st, to[i + d].expr, expr_mul(st, st->symbol[tau[d - 1]].node, expr_time_partial(st, to[i].expr, s->to->sys->time)));
    return to;
}

/* The nearest point once more, with its derivatives along the event; after: the field beyond it. */
static bool move_least(const struct sloping *s, arb_srcptr after)
{
    const struct between *w = s->w;
    const struct sys_system *sys = s->to->sys;
    int all = s->m * (1 + s->q);
    SGA_ARENA(mem);
    SGA_FREED int *variable = field_inputs(sys);
    int *tau = sga_zeros(&mem, (size_t)s->q + 1, sizeof *tau);
    double *near = sga_zeros(&mem, (size_t)all + 1, sizeof *near);
    arb_ptr asked = arbs_take(&mem, all), x = arbs_take(&mem, all);
    for (int d = 0; d < s->q; d++)
        tau[d] = enclosed_symbol(sys->store, "time of the event", d);
    for (int k = 0; k < all; k++)
        near[k] = k < s->m ? w->landed->x[k] : w->landed->slope[k - s->m] + arf_get_d(arb_midref(after + k % s->m), ARF_RND_NEAR) * arf_get_d(arb_midref(s->tau + (k / s->m - 1)), ARF_RND_NEAR);
    _arb_vec_set(asked, w->asked, s->m);
    _arb_vec_set(asked + s->m, s->y, all - s->m);
    struct sga_solution sol = *s->to->sol;
    sol.constraint = along_event(s, tau, &mem);
    const struct traj_asked of = { true, true, s->m, s->q, w->q.initial, w->unit, w->q.given, w->q.held };
    struct enclosed_piece piece = { .asked = asked, .known_symbol = tau, .known = s->tau, .knowns = s->q };
    struct traj_request rq = w->q;
    rq.asked = &of;
    rq.piece = &piece;
    struct enclose_problem p = { .st = sys->store, .variable = variable, .n = all, .time = sys->time, .tables = &s->w->ahead->balls, .budget = s->to->rq->budget };
    bool ok = expr_store_ok(sys->store) && enclosed_nearest(sys, &p, &sol, &rq, NULL, near, &w->b->t, s->prec, x);
    for (int k = 0; k < s->m && ok; k++)
        ok = arb_overlaps(x + k, w->y + k);      /* it is that point */
    if (ok)
        _arb_vec_set(s->y, x + s->m, all - s->m);
    return ok;
}

/* An event whose turn is made in two has one time. */
static void keep_times(const struct sloping *s)
{
    struct jump_boxed *b = s->w->b;
    if (!b->setting)
        return;
    if (b->tau)
        _arb_vec_clear(b->tau, b->taus);
    b->taus = s->q;
    b->tau = _arb_vec_init(s->q);
    _arb_vec_set(b->tau, s->tau, s->q);
}

bool jump_boxed_slope(const struct between *w, arb_ptr slope)
{
    SGA_ARENA(mem);
    struct sloping s = { .w = w, .from = w->from->rq->carried, .to = w->to->rq->carried, .n = w->from->n, .m = w->to->n, .prec = w->b->piece.prec };
    s.q = s.from->rq->slopes->directions;
    s.field = arbs_take(&mem, s.n);
    s.tau = arbs_take(&mem, s.q);
    s.y = arbs_take(&mem, (slong)s.q * s.m);
    arb_ptr after = arbs_take(&mem, s.m), all = arbs_take(&mem, (slong)s.m * (1 + s.q));
    _arb_vec_set(all, w->y, s.m);
    if (!w->tables || !along(&s))
        return false;
    keep_times(&s);
    if ((w->to->rq->mass && w->happens && !w->b->again && !jump_impulse_boxed_slope(w, s.tau, s.y)) || !enclosed_values(s.to->sys, &w->b->t, all, s.to->sol->field, s.m, s.prec, after))
        return false;
    if (w->nearest && !(w->steady && move_least(&s, after)))
        return false;
    for (int d = 0; d < s.q && !w->nearest; d++)
        if (!follow(&s, d))
            return false;
    for (int i = 0; i < s.q * s.m; i++) {
        arb_mul(slope + i, after + i % s.m, s.tau + i / s.m, s.prec + 20);
        arb_sub(slope + i, s.y + i, slope + i, s.prec + 20);
    }
    return true;
}
