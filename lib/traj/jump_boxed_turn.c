/* Between two pieces in balls: what is set, and where the motion goes on. See jump_boxed.h. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "field.h"
#include "jump_boxed_between.h"
#include "jump_turn.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "sizes.h"
#include "system.h"

/* The point that is proved is that of double, beside 1 + its size. */
static const double SAME_POINT = 1e-6;

static bool say(const struct between *w, const char *why)
{
    snprintf(w->b->why, sizeof w->b->why, "%s", why);
    return false;
}

static bool assign(const struct between *w)
{
    const struct traj_request *rq = w->from->rq;
    int n = w->from->n;
    expr_id *root = sga_take(w->mem, ((size_t)w->from->sets + 1) * sizeof *root);
    arb_ptr value = arbs_take(w->mem, w->from->sets), set = arbs_take(w->mem, n);
    unsigned char *changed = sga_zeros(w->mem, (size_t)n + 1, 1);
    int roots = 0;
    for (int e = 0; e < rq->events; e++)
        for (int k = 0; k < rq->event[e].sets && w->at->fired[e]; k++)
            root[roots++] = rq->event[e].set[k].value;
    if (!enclosed_values(w->from->sys, &w->b->t, w->x, root, roots, w->b->piece.prec, value))
        return say(w, "what is set here is not shown to have a value");
    _arb_vec_set(set, w->x, n);
    for (int e = 0, i = 0; e < rq->events; e++)
        for (int k = 0; k < rq->event[e].sets && w->at->fired[e]; k++, i++)
            if (rq->event[e].set[k].variable >= 0) {
                arb_set(set + rq->event[e].set[k].variable, value + i);
                changed[rq->event[e].set[k].variable] = 1;
            }
    for (int k = 0; k < n; k++) {
        int v = jump_same(w->from, k, w->to);
        if (v < 0)
            continue;
        arb_set(w->asked + v, set + k);
        w->stays[v] = !changed[k];
    }
    return true;
}

static bool near_double(const struct between *w, arb_srcptr x)
{
    bool near = true;
    for (int k = 0; k < w->to->n && near; k++)
        near = fabs(arf_get_d(arb_midref(x + k), ARF_RND_NEAR) - w->landed->x[k]) <= SAME_POINT * (1 + fabs(w->landed->x[k]));
    return near;
}

/* Constraints that have an unknown are as many as the unknowns that they have: those are solved for. */
static bool solve(const struct between *w, const struct enclose_problem *p, const struct traj_request *q)
{
    const struct jump *j = w->to;
    int n = j->n, functions = 0, unknowns = 0;
    expr_id *function = sga_take(w->mem, ((size_t)j->sol->constraints + 1) * sizeof *function);
    unsigned char *solved = w->solved;
    struct sga_error ignored = { 0 };
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < j->sol->constraints; i++) {
        bool has = false;
        for (int k = 0; k < n; k++)
            if (!q->held[k] && expr_depends(j->sys->store, &cone, j->sol->constraint[i].expr, j->sys->variable[k].symbol))
                has = (solved[k] = true);
        w->used[i] = has;
        if (has)
            function[functions++] = j->sol->constraint[i].expr;
    }
    _arb_vec_set(w->y, w->asked, n);
    for (int k = 0; k < n; k++) {
        unknowns += solved[k];
        if (solved[k] || !w->landed->known[k])
            arb_set_d(w->y + k, w->landed->x[k]);
        if (!solved[k] && !w->landed->known[k])
            return false;
    }
    return functions == unknowns && (!functions || enclose_zero(p, function, functions, &w->b->t, solved, w->b->piece.prec, w->y, &ignored)) && near_double(w, w->y);
}

/* The nearest point to what was set. */
static bool nearest(struct between *w, const struct enclose_problem *p)
{
    const struct jump *j = w->to;
    size_t n = (size_t)j->n;
    struct sizes sizes;
    struct traj_request rq = w->q;
    struct enclosed_piece piece = { .asked = w->asked };
    w->unit = sga_zeros(w->mem, n + 1, sizeof *w->unit);
    w->steady = !j->sys->signals;
    sizes_init(&sizes, j->sys, &w->q);
    for (size_t k = 0; k < n; k++) {
        w->unit[k] = sizes_move(&sizes, (int)k, w->q.initial[k]);
        w->steady &= !w->q.given[k] || w->unit[k] == sizes_move(&sizes, (int)k, 0);
    }
    sizes_clear(&sizes);
    const struct traj_asked of = { true, true, (int)n, 0, w->q.initial, w->unit, w->q.given, w->q.held };
    rq.asked = &of;
    rq.piece = &piece;
    return enclosed_nearest(j->sys, p, j->sol, &rq, NULL, w->landed->x, &w->b->t, w->b->piece.prec, w->y) && near_double(w, w->y);
}

/* What constraints there are among values that were set, and ones that stay: they hold as far as the bits tell. */
static bool agrees(const struct between *w)
{
    const struct jump *j = w->to;
    int c = j->sol->constraints;
    expr_id *root = sga_take(w->mem, ((size_t)c + 1) * sizeof *root);
    arb_ptr v = arbs_take(w->mem, c);
    for (int i = 0; i < c; i++)
        root[i] = j->sol->constraint[i].expr;
    bool all = enclosed_values(j->sys, &w->b->t, w->y, root, c, w->b->piece.prec, v);
    for (int i = 0; i < c && all; i++)
        all = arb_contains_zero(v + i);
    return all;
}

static bool place(struct between *w)
{
    const struct jump *j = w->to;
    size_t n = (size_t)j->n;
    double *x = sga_zeros(w->mem, n + 1, sizeof *x);
    unsigned char *lists = sga_zeros(w->mem, 2 * n + 2, 1);
    struct jump_to asked = *w->landed;
    SGA_FREED int *variable = field_inputs(j->sys);
    struct enclose_problem p = { .st = j->sys->store, .variable = variable, .n = j->n, .time = j->sys->time, .budget = j->rq->budget };
    asked.x = x;
    for (size_t k = 0; k < n; k++)
        x[k] = w->landed->known[k] ? arf_get_d(arb_midref(w->asked + k), ARF_RND_NEAR) : 0;
    jump_request(j, w->at, &asked, w->landed->way, lists, &w->q);
    w->nearest = !solve(w, &p, &w->q);
    if (w->nearest && !nearest(w, &p))
        return say(w, "it cannot be shown where the motion goes on after what is set here");
    return agrees(w) || say(w, "what is set here lies off the constraints by more than the bits tell");
}

/* Whether e, of the functions after the event, is the same number as before it. */
static bool is_kept(const struct between *w, expr_id e)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool kept = true;
    expr_cone_init(&cone);
    for (int k = 0; k < w->to->n; k++)
        if (expr_depends(w->to->sys->store, &cone, e, w->to->sys->variable[k].symbol))
            kept &= w->stays[k] && arb_equal(w->y + k, w->asked + k);
    return kept;
}

/* Whether the constraints after the event hold e at 0. */
static bool held_at_zero(const struct between *w, expr_id e)
{
    const struct sga_solution *sol = w->to->sol;
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, w->to->rq->budget);
    expr_id *given = sga_take(w->mem, ((size_t)sol->constraints + 1) * sizeof *given);
    for (int i = 0; i < sol->constraints; i++)
        given[i] = sol->constraint[i].expr;
    return poly_vanishes_with(w->to->sys->store, e, given, sol->constraints, &limits);
}

/* 1: its function is 0 at the event because it is that of one that happens, and it crosses the other way; 0: it happens too; -1: neither is known. */
static int other_way(const struct between *w, int e)
{
    const struct traj_request *rq = w->to->rq;
    struct expr_store *st = w->to->sys->store;
    for (int f = 0; f < rq->events; f++) {
        int sign = rq->event[f].expression == rq->event[e].expression ? 1 : rq->event[f].expression == expr_neg(st, rq->event[e].expression) ? -1 : 0;
        if (w->at->fired[f] && sign)
            return rq->event[e].direction && w->at->crossing[f] && rq->event[e].direction != sign * w->at->crossing[f];
    }
    return -1;
}

/* What is known of functions of events that may be 0 here. */
static bool on_sides(const struct between *w)
{
    const struct traj_request *rq = w->to->rq;
    expr_id *root = sga_take(w->mem, ((size_t)rq->events + 1) * sizeof *root);
    arb_ptr v = arbs_take(w->mem, rq->events);
    SGA_FREED int *variable = field_inputs(w->to->sys);
    for (int e = 0; e < rq->events; e++) {
        root[e] = rq->event[e].expression;
        w->b->idle[e] = w->b->zero[e] = false;
    }
    if (!enclosed_values(w->to->sys, &w->b->t, w->y, root, rq->events, w->b->piece.prec, v))
        return say(w, "an event's function is not shown to have a value after what is set here");
    for (int e = 0; e < rq->events; e++) {
        bool done = rq->event[e].most && w->at->count && w->at->count[e] >= rq->event[e].most;
        if (done || !arb_contains_zero(v + e))
            continue;
        int way = w->at->fired[e] ? 1 : other_way(w, e);
        if (!way)
            return say(w, "two events happen at once here");
        expr_id rate = w->to->sol->free_columns ? EXPR_UNDEF : enclosed_rate(w->to->sys->store, root[e], variable, w->to->n, w->to->sys->time, w->to->sol->field);      /* unless the motion has a choice */
        w->b->zero[e] = arb_is_zero(v + e) || (way > 0 && is_kept(w, root[e]));
        w->b->idle[e] = held_at_zero(w, root[e]) || (w->b->zero[e] && rate && held_at_zero(w, rate));
    }
    return true;
}

static void run(struct between *w)
{
    struct jump_boxed *b = w->b;
    const struct traj_carried *carried = w->to->rq->carried;
    int all = carried ? carried->sys->variables : w->to->n;
    if (b->why[0] || !assign(w))
        return;
    if (w->to->rq->mass && !jump_impulse_boxed(w, w->asked)) {
        say(w, "the impulse here is not shown to be the only one");
        return;
    }
    if (!place(w) || !on_sides(w))
        return;
    arb_ptr slope = arbs_take(w->mem, all - w->to->n);
    if (carried && !jump_boxed_slope(w, slope)) {
        say(w, "derivatives are not shown to be known beyond what is set here");
        return;
    }
    if (b->x)
        _arb_vec_clear(b->x, b->n);
    b->n = all;
    b->x = _arb_vec_init(b->n);
    _arb_vec_set(b->x, w->y, w->to->n);
    _arb_vec_set(b->x + w->to->n, slope, all - w->to->n);
}

void jump_boxed_turn(struct jump_boxed *b, const struct turn *s, const struct jump_at *at, const struct jump_to *to)
{
    SGA_ARENA(mem);
    const struct jump *from = s->changing ? &s->before : &s->j, *j = &s->j;
    struct between w = { .b = b, .from = from, .to = j, .at = at, .landed = to, .asked = arbs_take(&mem, j->n), .y = arbs_take(&mem, j->n), .mem = &mem };
    w.stays = sga_zeros(&mem, 2 * (size_t)j->n + (size_t)j->sol->constraints + 3, 1);
    w.solved = w.stays + j->n + 1;
    w.used = w.solved + j->n + 1;
    w.x = b->before + (b->columns - (from->rq->carried ? from->rq->carried->sys->variables : from->n));
    run(&w);
}
