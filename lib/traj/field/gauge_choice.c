/* Rates and least norm by elimination in the free functions: see gauge_choice.h. */
#include "gauge_choice.h"

#include <assert.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "expr_rows.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "system.h"

/* Nodes that a choice may add. Evaluating so many takes about as long as solving a hundred dense rows. */
enum { MOST_NODES = 100000 };
/* More gauge fields that are linked than this are solved for as a block. */
enum { ELIMINATED = 24 };

struct builder {
    struct expr_store *st;
    int n, k;
    expr_id *x;              /* n: X, with the rates so far */
    expr_id *h;              /* k x n: gauge fields; those used up are left as they were then */
    unsigned char *used;     /* by gauge field */
    int most;                /* nodes that the store may have */
    struct expr_facts facts;
};

static expr_id *at(const struct builder *b, int field, int variable)
{
    return b->h + (size_t)field * (size_t)b->n + (size_t)variable;
}

static bool room(const struct builder *b)
{
    return expr_store_ok(b->st) && b->st->nodes < b->most;
}

/* Zero for certain. */
static bool vanishes(const struct builder *b, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, NULL);
    return expr_is_zero(b->st, e) || (!expr_is_const(b->st, e) && poly_is_zero(b->st, e, &limits) == POLY_YES);
}

/* v += factor times a gauge field. */
static bool add(const struct builder *b, expr_id *v, expr_id factor, int field)
{
    for (int j = 0; j < b->n && room(b); j++)
        if (!expr_is_zero(b->st, *at(b, field, j)))
            v[j] = expr_add(b->st, v[j], expr_mul(b->st, factor, *at(b, field, j)));
    return room(b);
}

/* What is best divided by: numbers, what depends on parameters only, what never vanishes, the rest. */
static int kind_of(struct builder *b, expr_id e)
{
    unsigned f = expr_facts_of(&b->facts, b->st, e);
    return expr_is_const(b->st, e) ? 0 : !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)) ? 1 : f & EXPR_NONZERO ? 2 : 3;
}

/* The best pivot among the rates that are left: of rate *q by gauge field *a. False: none of them fixes anything more. */
static bool choose(struct builder *b, const struct traj_request *rq, const unsigned char *done, int *q, int *a)
{
    for (;;) {
        int best = INT_MAX;
        for (int r = 0; r < rq->rates; r++)
            for (int f = 0; f < b->k && !done[r] && best; f++) {
                expr_id e = *at(b, f, rq->rate[r].variable);
                if (b->used[f] || expr_is_zero(b->st, e) || kind_of(b, e) >= best)
                    continue;
                best = kind_of(b, e);
                *q = r;
                *a = f;
            }
        if (best == INT_MAX)
            return false;
        expr_id *pivot = at(b, *a, rq->rate[*q].variable);
        if (!vanishes(b, *pivot))
            return true;
        *pivot = expr_int(b->st, 0);
    }
}

/* The rates one after the other: each uses up one gauge field. False: c->why, or no room. */
static bool fix_rates(struct builder *b, const struct traj_request *rq, struct gauge_choice *c)
{
    struct expr_store *st = b->st;
    unsigned char *done = sga_calloc((size_t)rq->rates + 1, 1);
    bool ok = true;
    for (int q = 0, a = 0; ok && choose(b, rq, done, &q, &a); c->fixed++) {
        int variable = rq->rate[q].variable;
        expr_id pivot = *at(b, a, variable);
        if (!expr_is_const(st, pivot))
            c->pivot[c->pivots++] = pivot;
        ok = add(b, b->x, expr_div(st, expr_sub(st, rq->rate[q].rate, b->x[variable]), pivot), a);
        b->x[variable] = rq->rate[q].rate;
        b->used[a] = done[q] = 1;
        for (int f = 0; f < b->k && ok; f++) {
            expr_id e = *at(b, f, variable);
            if (b->used[f] || expr_is_zero(st, e))
                continue;
            ok = add(b, at(b, f, 0), expr_neg(st, expr_div(st, e, pivot)), a);
            *at(b, f, variable) = expr_int(st, 0);
        }
    }
    for (int q = 0; q < rq->rates && ok; q++)
        if (!done[q] && !vanishes(b, expr_sub(st, rq->rate[q].rate, b->x[rq->rate[q].variable]))) {
            c->why = "some rates follow from the others, or contradict them, as far as the expressions tell";
            ok = false;
        }
    free(done);
    assert(c->pivots <= c->fixed && c->fixed <= b->k);       /* each rate uses up one gauge field */
    return ok;
}

/* sum_j H_fj v_j; EXPR_UNDEF: no room. */
static expr_id dot(const struct builder *b, int f, const expr_id *v)
{
    expr_id sum = expr_int(b->st, 0);
    for (int j = 0; j < b->n && room(b); j++)
        if (!expr_is_zero(b->st, *at(b, f, j)) && !expr_is_zero(b->st, v[j]))
            sum = expr_add(b->st, sum, expr_mul(b->st, *at(b, f, j), v[j]));
    return room(b) ? sum : EXPR_UNDEF;
}

/* S u = r by elimination in the order given, S symmetric and positive definite (m x m, overwritten, like r, which is u
 * then). H_k is 1 where the others are 0, so that H H^T >= 1 and no pivot comes near 0. */
static void eliminate(struct expr_store *st, int m, expr_id *S, expr_id *r)
{
    for (int p = 0; p < m; p++)
        for (int i = p + 1; i < m; i++) {
            if (expr_is_zero(st, S[i * m + p]))
                continue;
            expr_id factor = expr_div(st, S[i * m + p], S[p * m + p]);
            for (int j = p + 1; j < m; j++)
                S[i * m + j] = expr_sub(st, S[i * m + j], expr_mul(st, factor, S[p * m + j]));
            r[i] = expr_sub(st, r[i], expr_mul(st, factor, r[p]));
        }
    for (int p = m - 1; p >= 0; p--) {
        for (int j = p + 1; j < m; j++)
            r[p] = expr_sub(st, r[p], expr_mul(st, S[p * m + j], r[j]));
        r[p] = expr_div(st, r[p], S[p * m + p]);
    }
}

/* A linear solve of the store, which may be there already: that of another trajectory of a sweep. */
static int solve_of(struct expr_store *st, int m, const expr_id *S, const expr_id *r)
{
    SGA_ENDS(expr_rows_clear) struct expr_rows rows = expr_rows_of(m, m, S, expr_int(st, 0));
    for (int i = 0; i < st->solves; i++)
        if (st->solve[i].m == m && !memcmp(st->solve[i].rhs, r, (size_t)m * sizeof *r) && expr_rows_same(&st->solve[i].matrix, &rows, m))
            return i;
    return expr_solve_add_rows(st, m, &rows, r);
}

static void solve(struct expr_store *st, int m, expr_id *S, expr_id *r)
{
    if (m <= ELIMINATED) {
        eliminate(st, m, S, r);
        return;
    }
    int index = solve_of(st, m, S, r);
    for (int i = 0; i < m; i++)
        r[i] = expr_solution(st, index, i);
}

/* Least norm by the gauge fields of one list, which no other one is linked to: u = -(H H^T)^-1 H x. */
static bool shorten(const struct builder *b, const int *field, int m)
{
    struct expr_store *st = b->st;
    expr_id *S = sga_malloc((size_t)m * (size_t)m * sizeof *S), *r = sga_malloc((size_t)m * sizeof *r);
    bool ok = true;
    for (int i = 0; i < m && ok; i++) {
        for (int j = 0; j <= i; j++)
            S[i * m + j] = S[j * m + i] = dot(b, field[i], at(b, field[j], 0));
        r[i] = expr_neg(st, dot(b, field[i], b->x));
        ok = room(b);
    }
    if (ok)
        solve(st, m, S, r);
    for (int i = 0; i < m && ok; i++)
        ok = add(b, b->x, r[i], field[i]);
    free(S);
    free(r);
    return ok;
}

/* By gauge field: the least one that it is linked to by a chain of variables which two of them move. */
static int *link(const struct builder *b)
{
    int *group = sga_malloc((size_t)(b->k + 1) * sizeof *group);
    for (int f = 0; f < b->k; f++)
        group[f] = f;
    for (int j = 0; j < b->n; j++)
        for (int f = 0, first = -1; f < b->k; f++) {
            if (b->used[f] || expr_is_zero(b->st, *at(b, f, j)))
                continue;
            int low = first < 0 || group[f] < group[first] ? group[f] : group[first];
            int high = first < 0 || group[f] > group[first] ? group[f] : group[first];
            for (int g = 0; g < b->k && first >= 0 && low < high; g++)
                if (group[g] == high)
                    group[g] = low;
            first = first < 0 ? f : first;
        }
    return group;
}

static bool least_norm(const struct builder *b)
{
    int *group = link(b), *field = sga_malloc((size_t)(b->k + 1) * sizeof *field);
    bool ok = true;
    for (int g = 0; g < b->k && ok; g++) {
        int m = 0;
        for (int f = g; f < b->k; f++)
            if (!b->used[f] && group[f] == g)
                field[m++] = f;
        assert(group[g] <= g && (group[g] == g || !m));       /* the least one stands for all */
        ok = m == 0 || shorten(b, field, m);
    }
    free(group);
    free(field);
    return ok;
}

static bool build(struct builder *b, const struct traj_request *rq, struct gauge_choice *c)
{
    if (fix_rates(b, rq, c) && least_norm(b) && room(b))
        return true;
    if (!c->why)
        c->why = "the gauge choice is too large to be written as expressions";
    return false;
}

void gauge_choice_make(struct gauge_choice *c, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    struct expr_store *st = sys->store;
    *c = (struct gauge_choice){ 0 };
    if (!sol->free_columns && !rq->rates)
        return;
    if (sol->free_columns && !sol->gauge) {
        c->why = "the gauge fields are too large to be written as expressions";
        return;
    }
    struct builder b = { .st = st, .n = sys->variables, .k = sol->free_columns, .most = INT_MAX };
    size_t n = (size_t)b.n, k = (size_t)b.k;
    int left = st->max_nodes ? (st->max_nodes - st->nodes) / 4 : MOST_NODES;
    if (rq->arithmetic != TRAJ_BALL)
        b.most = st->nodes + (left < MOST_NODES ? left : MOST_NODES);
    bool before = expr_store_ok(st);
    expr_facts_init(&b.facts);
    b.x = memcpy(sga_malloc((n + 1) * sizeof *b.x), sol->field, n * sizeof *b.x);
    b.h = sga_malloc((k * n + 1) * sizeof *b.h);
    if (k)
        memcpy(b.h, sol->gauge, k * n * sizeof *b.h);
    b.used = sga_calloc(k + 1, 1);
    c->pivot = sga_malloc((k + 1) * sizeof *c->pivot);
    if (before && build(&b, rq, c))
        c->field = b.x;
    else
        free(b.x);
    if (before && !expr_store_ok(st) && st->error->code != SGA_E_LIMIT_SECONDS)
        *st->error = (struct sga_error){ 0 };     /* a number with too many bits: solved numerically it is none */
    expr_facts_clear(&b.facts);
    free(b.h);
    free(b.used);
}

void gauge_choice_clear(struct gauge_choice *c)
{
    free(c->field);
    free(c->pivot);
    *c = (struct gauge_choice){ 0 };
}
