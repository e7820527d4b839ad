/* The consistent start where given values had to move: the point of the final set nearest to them, proved by interval
 * Newton on Lagrange's conditions
 *     w_j (x_j - g_j) / s_j^2 + sum_i lambda_i d xi_i / d x_j = 0,   xi_i(x, t) = 0,
 * g the values given, s the units of consistent.c, held values left out. The tiers of a start (tiers.h) are what becomes of these points as w, 1 in the first tier, goes to 0
 * from each tier to the next one: it is made so small that this is not told from 0 with the bits that are asked for, in steps, because Newton's method comes from one to the next.
 * Where that fails the start is the point with w as at first. */
#include "enclosed.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "ball.h"
#include "budget.h"
#include "derive.h"
#include "error.h"
#include "flow.h"
#include "kinds.h"
#include "mem.h"
#include "reduction.h"
#include "sizes.h"
#include "system.h"
#include "tiers.h"
#include "trajectory.h"

/* log2 of 1/sqrt(w) from one tier to the next: at first, how it grows, and beyond half of the bits at the end. */
static const double FIRST = 10, GROWS = 1.5, BEYOND = 16;
/* Unknowns, whose matrices have several times the motion's bits. */
enum { MOST = 100 };
/* Beside 1 + its size, what was given is there in double. */
static const double THERE = 1e-9;

/* A double as a constant of the store. */
static expr_id exact(struct expr_store *st, double v)
{
    int e;
    double m = ldexp(frexp(v, &e), 53);
    return expr_mul(st, expr_int(st, (long)m), expr_powi(st, expr_int(st, 2), e - 53));
}

/* What the point is nearest to: of the request; or of the motion that is differentiated, whose derivatives follow. */
struct asked {
    int base, directions;
    struct traj_request rq;       /* its initial, given and held are those */
    double *unit;                 /* base */
    signed char *tier;            /* base; -1: held */
    arb_srcptr ball;              /* by variable, then derivatives: the values asked for, where they are no constants; or NULL */
    bool known;                   /* as traj_asked has it */
    unsigned char *skip;          /* by constraint: it has held variables alone, and is known to hold */
    int level[TIERS], levels;     /* by tier */
};

static void ask(const struct traj_request *rq, const struct sizes *sizes, int n, struct asked *q)
{
    const struct traj_asked *own = rq->asked;
    *q = (struct asked){ .base = own ? own->base : n, .directions = own ? own->directions : 0, .rq = *rq };
    if (own) {
        q->rq.initial = own->initial;
        q->rq.given = own->given;
        q->rq.held = own->held;
    }
    q->unit = sga_malloc((size_t)(q->base + 1) * sizeof *q->unit);
    q->tier = sga_calloc((size_t)q->base + 1, 1);
    q->known = own && own->known;
    q->ball = rq->piece ? rq->piece->asked : NULL;
    for (int j = 0; j < q->base; j++)
        q->unit[j] = own ? own->unit[j] : sizes_move(sizes, j, q->rq.initial[j]);
}

/* The tiers of a stage that have variables, one after the other. */
static void enter_stage(struct asked *q, const struct sys_system *sys, enum tiers_stage stage)
{
    SGA_FREED unsigned char *kind = sga_calloc((size_t)sys->variables + 1, 1);
    sys_kinds(sys, kind);
    tiers_of(&q->rq, kind, q->base, stage, q->tier);
    q->levels = 0;
    for (int t = 0; t < TIERS; t++) {
        bool any = false;
        for (int j = 0; j < q->base; j++)
            any |= q->tier[j] == t;
        q->level[t] = q->levels;
        q->levels += any;
    }
}

static bool held(const struct asked *q, int j)
{
    return q->tier[j % q->base] < 0;
}

static void find_skips(struct asked *q, const struct sys_system *sys, const struct sga_solution *sol)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < sol->constraints; i++) {
        bool free = !q->known;
        for (int j = 0; j < q->base && !free; j++)
            free = !held(q, j) && expr_depends(sys->store, &cone, sol->constraint[i - i % (1 + q->directions)].expr, sys->variable[j].symbol);
        q->skip[i] = !free;
    }
}

int enclosed_symbol(struct expr_store *st, const char *what, int i)
{
    char name[48];
    snprintf(name, sizeof name, "%s %d", what, i);
    expr_symbol_add(st, name, EXPR_PARAMETER);
    return expr_symbol_find(st, name, strlen(name));
}

/* Variable i (or derivative of one) of what was asked. */
static expr_id asked_value(struct expr_store *st, const struct asked *q, int i)
{
    int j = i % q->base;
    if (q->ball)
        return st->symbol[enclosed_symbol(st, "value asked for", i)].node;
    bool known = q->rq.given[j] && q->rq.exact_initial && q->rq.exact_initial[i];
    return known ? q->rq.exact_initial[i] : i < q->base ? exact(st, q->rq.initial[j]) : expr_int(st, 0);
}

/* The conditions of direction d (0: of the point itself) into function; returns how many. symbol: variables, their derivatives, multipliers of the constraints, each before those of its
 * derivatives, and w. With L = sum lambda_i xi_i the conditions' derivatives along a direction are
 *     w (S - g') / s^2 + (sum Lambda_i xi_i + lambda_i (xi_i,x S + xi_i,k))_x = 0,   xi_i,x S + xi_i,k = 0. */
static int conditions(struct expr_store *st, const struct sga_solution *sol, const struct asked *q, const int *symbol, int d, expr_id *function)
{
    int each = 1 + q->directions, n = q->base * each, count = 0;
    expr_id w = st->symbol[symbol[n + sol->constraints]].node, sum = expr_int(st, 0);
    assert(sol->constraints % each == 0);       /* each is followed by its derivatives */
    for (int i = 0; i < sol->constraints; i += each) {
        if (q->skip[i])
            continue;
        expr_id lambda = st->symbol[symbol[n + i]].node;
        function[count++] = sol->constraint[i + d].expr;
        sum = expr_add(st, sum, expr_mul(st, d ? st->symbol[symbol[n + i + d]].node : lambda, sol->constraint[i].expr));
        sum = d ? expr_add(st, sum, expr_mul(st, lambda, sol->constraint[i + d].expr)) : sum;
    }
    for (int j = 0; j < q->base; j++) {
        if (held(q, j))
            continue;
        int i = q->base * d + j, level = q->level[q->tier[j]];
        expr_id far = expr_div(st, expr_sub(st, st->symbol[symbol[i]].node, asked_value(st, q, i)), expr_powi(st, exact(st, q->unit[j]), 2));
        far = level ? expr_mul(st, far, expr_powi(st, w, level)) : far;
        function[count++] = expr_add(st, far, expr_diff(st, sum, symbol[j]));
    }
    return count;
}

/* What is searched: unknowns and w. */
struct point {
    struct expr_store *st;
    struct enclose_problem q;
    const struct sga_solution *sol;
    const struct asked *asked;
    const arb_struct *t0;
    slong prec;
    expr_id *function; unsigned char *solved;      /* of one direction */
    arb_ptr u;
};

/* Direction d with w = 2^(-2 r) from tier to tier; 0 comes first, and then each by itself, for all points in the ball of that. */
static bool search(const struct point *w, int d, double r)
{
    const struct asked *q = w->asked;
    int each = 1 + q->directions, n = q->base * each, unknowns = 0;
    struct sga_error ignored = { 0 };
    arb_ptr loose = w->u + n + w->sol->constraints;
    arb_one(loose);
    arb_mul_2exp_si(loose, loose, -2 * (slong)r);
    memset(w->solved, 0, (size_t)w->q.n);
    for (int j = 0; j < q->base; j++)
        unknowns += w->solved[q->base * d + j] = !held(q, j);
    for (int i = d; i < w->sol->constraints; i += each)
        unknowns += w->solved[n + i] = !q->skip[i];
    int functions = conditions(w->st, w->sol, q, w->q.variable, d, w->function);
    assert(functions == unknowns);       /* interval Newton is for as many conditions */
    return expr_store_ok(w->st) && enclose_zero(&w->q, w->function, functions, w->t0, w->solved, w->prec + 2 * (slong)r * q->levels, w->u, &ignored);
}

/* From tier to tier as told from nothing. *last: the r at which that is so. */
static bool tighten(const struct point *w, double *last)
{
    double r = FIRST;
    *last = (double)w->prec / 2 + BEYOND;
    while (r < *last) {
        r = fmin(GROWS * r, *last);
        if (!search(w, 0, r))
            return false;
    }
    return true;
}

/* What w leaves, about w itself: some times it. */
static void add_rest(arb_t x, slong prec)
{
    SGA_ENDS(mag_end) mag_t rest = { 0 };
    arb_get_mag(rest, x);
    mag_add_ui(rest, rest, 1);
    mag_mul_2exp_si(rest, rest, -prec);
    arb_add_error_mag(x, rest);
}

/* In one stage: x (n), if it is proved. */
static bool in_stage(const struct sys_system *sys, const struct enclose_problem *p, const struct sga_solution *sol, const struct asked *asked, const double *near, const arb_t t0,
                     slong prec, arb_ptr x)
{
    struct expr_store *st = sys->store;
    const struct enclosed_piece *piece = asked->rq.piece;
    int n = p->n, c = sol->constraints, more = asked->ball ? n : 0, knowns = piece ? piece->knowns : 0, all = n + c + 1 + more + knowns;
    SGA_FREED int *symbol = sga_malloc((size_t)(all + 1) * sizeof *symbol);
    struct point w = { .st = st, .sol = sol, .asked = asked, .t0 = t0, .prec = prec, .u = _arb_vec_init(all), .solved = sga_calloc((size_t)all + 1, 1),
                       .function = sga_malloc((size_t)(all + 1) * sizeof(expr_id)) };
    memcpy(symbol, p->variable, (size_t)n * sizeof *symbol);
    for (int i = 0; i < c; i++)
        symbol[n + i] = enclosed_symbol(st, "multiplier of constraint", i);
    symbol[n + c] = enclosed_symbol(st, "weight of tier", 1);
    for (int j = 0; j < knowns; j++) {
        symbol[n + c + 1 + more + j] = piece->known_symbol[j];
        arb_set(w.u + n + c + 1 + more + j, piece->known + j);
    }
    for (int j = 0; j < more; j++) {
        symbol[n + c + 1 + j] = enclosed_symbol(st, "value asked for", j);
        arb_set(w.u + n + c + 1 + j, asked->ball + j);
    }
    for (int j = 0; j < n; j++)
        if (held(asked, j) && more)
            arb_set(w.u + j, asked->ball + j);
        else if (held(asked, j))
            num_ball_constant(st, asked_value(st, asked, j), 0, 2 * prec, w.u + j);
        else
            arb_set_d(w.u + j, near[j]);
    w.q = (struct enclose_problem){ .st = st, .variable = symbol, .n = all, .time = p->time, .tables = p->tables, .budget = p->budget };
    double r = FIRST;
    bool ok = search(&w, 0, FIRST);
    if (ok)
        _arb_vec_set(x, w.u, asked->base);
    bool tight = ok && asked->levels > 1 && all / (1 + asked->directions) <= MOST && tighten(&w, &r);
    ok = ok && (tight || asked->levels < 2 || !asked->directions);
    for (int d = 1; d <= asked->directions && ok; d++)
        ok = search(&w, d, r);
    for (int j = 0; j < n && ok && (tight || asked->directions); j++) {
        _arb_vec_set(x + j, w.u + j, 1);
        if (tight && !held(asked, j))
            add_rest(x + j, prec);
    }
    _arb_vec_clear(w.u, all);
    free(w.solved);
    free(w.function);
    return ok;
}

/* Whether what a stage leaves where it was given is there, as far as doubles tell. */
static bool may_be(const struct asked *q, const double *near)
{
    bool may = true;
    for (int j = 0; j < q->base; j++)
        may &= q->tier[j] >= 0 || fabs(near[j] - q->rq.initial[j]) <= THERE * (1 + fabs(near[j]));
    return may;
}

bool enclosed_nearest(const struct sys_system *sys, const struct enclose_problem *p, const struct sga_solution *sol, const struct traj_request *rq,
                      const struct sizes *sizes, const double *near, const arb_t t0, slong prec, arb_ptr x)
{
    struct asked asked;
    bool found = false;
    ask(rq, sizes, p->n, &asked);
    asked.skip = sga_calloc((size_t)sol->constraints + 1, 1);
    for (int stage = TIERS_KEEP_STATES; stage <= TIERS_MOVE_ALL && !found && sga_budget_ok(p->budget, NULL); stage++) {
        enter_stage(&asked, sys, (enum tiers_stage)stage);
        find_skips(&asked, sys, sol);
        found = may_be(&asked, near) && in_stage(sys, p, sol, &asked, near, t0, prec, x);
    }
    free(asked.unit);
    free(asked.tier);
    free(asked.skip);
    return found;
}
