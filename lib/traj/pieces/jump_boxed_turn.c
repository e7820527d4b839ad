/* Between two pieces in balls: what is set, and where the motion goes on. See jump_boxed.h. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "error.h"
#include "field.h"
#include "flint_ends.h"
#include "jump_boxed_between.h"
#include "jump_pass.h"
#include "jump_turn.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "sizes.h"
#include "slide.h"
#include "system.h"
#include "tables_ahead.h"

/* The point that is proved is that of double, beside 1 + its size. */
static const double SAME_POINT = 1e-6;
/* Coefficients of tables have so many times the bits of the motion, as searches from tier to tier have several times them. */
enum { TABLES = 16 };

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
                int variable = rq->event[e].set[k].variable;
                bool itself = root[i] == w->from->sys->store->symbol[w->from->sys->variable[variable].symbol].node;
                arb_set(set + variable, value + i);
                changed[variable] |= !itself;
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
    w->steady = true;
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

/* Other switches turn than the surface's. */
static bool others_turn(const struct between *w, int k)
{
    int others = 0;
    for (int i = 0; i < w->mode->rq->modes->surfaces; i++)
        others += i != k && w->was->choice[i] != w->mode->choice[i] && w->was->choice[i] != TRAJ_AS_WRITTEN;
    return others > 0;
}

/* One switch turns, and the point beyond is the one before. */
static bool point_stays(const struct between *w)
{
    const struct traj_modes *modes = w->to->rq->modes;
    if (!slide_any(w->to->rq) || w->b->setting || w->b->again || w->from->n != w->to->n)
        return false;
    for (int k = 0; k < modes->surfaces; k++)
        if (w->at->fired[modes->own + 2 * k])
            return w->was->choice[k] != TRAJ_ALONG && !others_turn(w, k) && modes->meets(modes->ctx, w->was, w->mode, k);
    return false;
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
    bool stays = point_stays(w);
    p.tables = &w->ahead->balls;
    w->nearest = !(w->tables && solve(w, &p, &w->q)) && !stays;
    if (stays)
        _arb_vec_set(w->y, w->asked, w->to->n);
    if (w->nearest && !(w->tables && nearest(w, &p)))
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

/* Whether the function of event e, which happens at its 0, is 0 after it too, by what is set alone: v, where -v/5 is set for v. */
static bool set_to_zero(const struct between *w, int e)
{
    struct expr_store *st = w->to->sys->store;
    const struct traj_request *rq = w->from->rq;
    const struct sys_variable *variable = w->from->sys->variable;
    expr_id before = rq->event[e].expression, after = w->to->rq->event[e].expression;
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, rq->budget);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    if (w->from->sys->store != st || expr_has_branches(st, &before, 1) || expr_has_branches(st, &after, 1))
        return false;
    expr_id *map = sga_zeros(w->mem, (size_t)st->symbols + 1, sizeof *map);
    for (int f = 0; f < rq->events; f++)
        for (int k = 0; k < rq->event[f].sets && w->at->fired[f]; k++)
            if (rq->event[f].set[k].variable >= 0)
                map[variable[rq->event[f].set[k].variable].symbol] = rq->event[f].set[k].value;
    for (int k = 0; k < w->to->n; k++)
        if (expr_depends(st, &cone, after, w->to->sys->variable[k].symbol)
            && !(arb_equal(w->y + k, w->asked + k) && (w->stays[k] || map[w->to->sys->variable[k].symbol])))
            return false;
    expr_substitute(st, &after, 1, map);
    return expr_store_ok(st) && poly_vanishes_with(st, after, &before, 1, &limits);
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

/* By values x (of j) that are known exactly, and the constraints. */
static bool exactly_zero(const struct between *w, const struct jump *j, arb_srcptr x, expr_id e)
{
    struct expr_store *st = j->sys->store;
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, j->rq->budget);
    SGA_ENDS(fmpq_end) fmpq_t q = { 0 };
    if (!arb_is_exact(&w->b->t))
        return false;
    expr_id *map = sga_zeros(w->mem, (size_t)st->symbols + 1, sizeof *map), *f = sga_take(w->mem, ((size_t)j->sol->constraints + 2) * sizeof *f);
    arf_get_fmpq(q, arb_midref(&w->b->t));
    map[j->sys->time] = expr_fmpq(st, q);
    for (int k = 0; k < j->n; k++)
        if (arb_is_exact(x + k)) {
            arf_get_fmpq(q, arb_midref(x + k));
            map[j->sys->variable[k].symbol] = expr_fmpq(st, q);
        }
    for (int i = 0; i < j->sol->constraints; i++)
        f[i] = j->sol->constraint[i].expr;
    f[j->sol->constraints] = e;
    expr_substitute(st, f, j->sol->constraints + 1, map);
    return expr_store_ok(st) && poly_vanishes_with(st, f[j->sol->constraints], f, j->sol->constraints, &limits);
}

/* The motion goes on along the surface: it is there exactly, and the switch lies between its ends. v: values of its two functions. */
static bool on_surface(const struct between *w, int k, int e, arb_srcptr v)
{
    int was = w->was->choice[k];
    bool there = was == TRAJ_ALONG || (was == TRAJ_AS_WRITTEN ? exactly_zero(w, w->from, w->x, w->was->surface[k]) : w->at->fired[e] && !others_turn(w, k));
    if (!there)
        return say(w, "it is not shown that the motion is at the surface of a switch that it goes on along");
    return (arb_is_negative(v) && arb_is_positive(v + 1)) || say(w, "it is not shown that a switch lies between its ends where the motion goes on along its surface");
}

/* The sign of e at (w->y, t), as it is shown; 0: it is not. */
static int shown_sign(const struct between *w, expr_id e)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    if (!e || !enclosed_values(w->to->sys, &w->b->t, w->y, &e, 1, w->b->piece.prec, v))
        return 0;
    return arb_is_positive(v) ? 1 : arb_is_negative(v) ? -1 : 0;
}

/* Surfaces of switches: the event that has come to one is at its 0 in the mode beyond too, as no other switch turns, and so is a motion that was along it; from there the motion
 * goes to the side of the mode: by its rate, or, where the switch has come to its end, whose field is that of the side, by the rate's. */
static bool beside_surface(const struct between *w, int k, int e, arb_srcptr value)
{
    const struct traj_mode *to = w->mode;
    const struct jump *j = w->to;
    expr_id function = j->rq->event[e].expression;
    SGA_FREED int *variable = field_inputs(j->sys);
    bool above = to->choice[k] == TRAJ_ABOVE, along = w->was->choice[k] == TRAJ_ALONG, came = along || w->at->fired[e];
    int side = above ? 1 : -1;
    w->b->flat[e] = false;
    if (to->choice[k] == TRAJ_ALONG)
        return on_surface(w, k, e, value);
    w->b->zero[e] = arb_is_zero(value) || ((w->b->again ? w->b->zero[e] : came) && (along || !others_turn(w, k)) && is_kept(w, function))
                    || (!w->b->setting && exactly_zero(w, j, w->y, function));
    if (w->b->setting)
        return true;
    if (!arb_contains_zero(value))
        return (side > 0) == arb_is_positive(value) || say(w, "it is not shown on which side of a switch the motion goes on");
    if (!w->b->zero[e] || j->sol->free_columns)
        return say(w, "it is not shown to which side of a switch the motion goes on");
    expr_id rate = enclosed_rate(j->sys->store, function, variable, j->n, j->sys->time, j->sol->field);
    int sign = shown_sign(w, rate), ahead = (int)jump_direction(j->rq);
    if (!sign && along && w->at->fired[above ? e : e + 1] && !others_turn(w, k)) {
        sign = shown_sign(w, enclosed_rate(j->sys->store, rate, variable, j->n, j->sys->time, j->sol->field)) * ahead;
        w->b->flat[e] = true;
    }
    return sign * ahead == side || say(w, "it is not shown to which side of a switch the motion goes on");
}

/* Where sides turn, a function of theirs may pass its 0 in a jump, or touch it: that it has one sign on both sides says that it does not. */
static bool passes_over(const struct between *w, int e, arb_srcptr after)
{
    SGA_ENDS(arb_end) arb_t before = { 0 };
    if (!w->to->rq->event[e].sided || w->was->choice == w->mode->choice || w->was->choice[0] == TRAJ_AS_WRITTEN)
        return true;
    return enclosed_values(w->from->sys, &w->b->t, w->x, &w->from->rq->event[e].expression, 1, w->b->piece.prec, before)
           && ((arb_is_positive(before) && arb_is_positive(after)) || (arb_is_negative(before) && arb_is_negative(after)));
}

static double size_at(const struct between *w, expr_id e, arb_srcptr v)
{
    SGA_ENDS(arb_end) arb_t rate = { 0 };
    SGA_FREED int *variable = field_inputs(w->to->sys);
    if (!arb_contains_zero(v))
        return arf_get_d(arb_midref(v), ARF_RND_NEAR);
    expr_id r = enclosed_rate(w->to->sys->store, e, variable, w->to->n, w->to->sys->time, w->to->sol->field);
    return r && enclosed_values(w->to->sys, &w->b->t, w->y, &r, 1, w->b->piece.prec, rate) ? arf_get_d(arb_midref(rate), ARF_RND_NEAR) : NAN;
}

/* The surface whose multiple the event's function is: one that is looked for is enough. v: values of all functions. */
static void find_twin(const struct between *w, int e, int own, arb_srcptr v)
{
    const struct traj_request *rq = w->to->rq;
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, rq->budget);
    int c = w->to->sol->constraints;
    expr_id *given = sga_take(w->mem, ((size_t)c + 1) * sizeof *given);
    for (int i = 0; i < c; i++)
        given[i] = w->to->sol->constraint[i].expr;
    w->b->twin[e] = -1;
    for (int k = own; k < rq->events && w->b->twin[e] < 0 && !rq->event[e].sided; k += 2) {
        if (arb_contains_zero(v + e) != arb_contains_zero(v + k))
            continue;
        double ratio = size_at(w, rq->event[e].expression, v + e) / size_at(w, rq->event[k].expression, v + k);
        int sign = poly_is_multiple(w->to->sys->store, rq->event[e].expression, rq->event[k].expression, ratio, given, c, &limits);
        if (sign) {
            w->b->twin[e] = k;
            w->b->twin_sign[e] = (signed char)sign;
        }
    }
}

/* What is known of functions of events that may be 0 here. */
static bool on_sides(const struct between *w)
{
    const struct traj_request *rq = w->to->rq;
    expr_id *root = sga_take(w->mem, ((size_t)rq->events + 1) * sizeof *root);
    arb_ptr v = arbs_take(w->mem, rq->events);
    int own = slide_any(rq) ? rq->modes->own : rq->events;
    SGA_FREED int *variable = field_inputs(w->to->sys);
    for (int e = 0; e < rq->events; e++) {
        root[e] = rq->event[e].expression;
        w->b->idle[e] = w->b->flat[e] = false;
        w->b->zero[e] &= w->b->again;
    }
    if (!enclosed_values(w->to->sys, &w->b->t, w->y, root, rq->events, w->b->piece.prec, v))
        return say(w, "an event's function is not shown to have a value after what is set here");
    for (int e = own; e < rq->events; e++)
        if ((e - own) % 2 == 0 && !beside_surface(w, (e - own) / 2, e, v + e))
            return false;
    for (int e = 0; e < own; e++) {
        bool done = rq->event[e].most && w->at->count && w->at->count[e] >= rq->event[e].most, was = w->b->zero[e];
        if (!w->b->setting && !passes_over(w, e, v + e))
            return say(w, "it is not shown whether an event happens as a switch of its function turns");
        if (!w->b->setting)
            find_twin(w, e, own, v);
        w->b->idle[e] = w->b->twin[e] >= 0;
        w->b->zero[e] = false;
        if (done || w->b->idle[e] || !arb_contains_zero(v + e))
            continue;
        int way = w->at->fired[e] ? 1 : other_way(w, e);
        if (!way)
            return say(w, "two events happen at once here");
        expr_id rate = w->to->sol->free_columns ? EXPR_UNDEF : enclosed_rate(w->to->sys->store, root[e], variable, w->to->n, w->to->sys->time, w->to->sol->field);      /* unless the motion has a choice */
        w->b->zero[e] = arb_is_zero(v + e) || ((way > 0 || was) && is_kept(w, root[e])) || (w->at->fired[e] && set_to_zero(w, e));
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
    if (w->to->rq->mass && w->happens && !b->again && !jump_impulse_boxed(w, w->asked)) {
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

void jump_boxed_turn(struct jump_boxed *b, const struct turn *s, const struct traj_mode *was, const struct jump_at *at, const struct jump_to *to)
{
    SGA_ARENA(mem);
    const struct jump *from = s->changing ? &s->before : &s->j, *j = &s->j;
    struct between w = { .b = b, .from = from, .to = j, .was = was, .mode = s->mode, .at = at, .landed = to, .asked = arbs_take(&mem, j->n), .y = arbs_take(&mem, j->n), .mem = &mem };
    struct tables_ahead ahead;
    struct traj_request on = *j->rq;
    on.start = at->t;
    on.exact_start = EXPR_UNDEF;
    on.exact_initial = on.exact_time = NULL;
    w.ahead = &ahead;
    w.tables = tables_ahead_enter(&ahead, j->sys, &on, TABLES * b->piece.prec);
    w.happens = memchr(at->fired, 1, (size_t)from->rq->events) != NULL;
    w.stays = sga_zeros(&mem, 2 * (size_t)j->n + (size_t)j->sol->constraints + 3, 1);
    w.solved = w.stays + j->n + 1;
    w.used = w.solved + j->n + 1;
    w.x = b->again ? b->x : b->before + (b->columns - (from->rq->carried ? from->rq->carried->sys->variables : from->n));
    run(&w);
    tables_ahead_leave(&ahead);
}
