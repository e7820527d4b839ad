/* The consistent start where given values had to move: the point of the final set nearest to them, proved by interval
 * Newton on Lagrange's conditions
 *     (x_j - g_j) / s_j^2 + sum_i lambda_i d xi_i / d x_j = 0,   xi_i(x, t) = 0,
 * g the values given, s the units of consistent.c, held values left out. */
#include "enclosed.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "derive.h"
#include "mem.h"
#include "reduction.h"
#include "sizes.h"
#include "trajectory.h"

/* A double as a constant of the store. */
static expr_id exact(struct expr_store *st, double v)
{
    int e;
    double m = ldexp(frexp(v, &e), 53);
    return expr_mul(st, expr_int(st, (long)m), expr_powi(st, expr_int(st, 2), e - 53));
}

/* As consistent.c weighs what a value moves by. */
static double unit_of(const struct traj_request *rq, const struct sizes *sizes, int j)
{
    return sizes_move(sizes, j, rq->initial[j]) * (rq->given[j] ? 1 : 1e3);
}

/* A symbol that no request can name. */
static int multiplier(struct expr_store *st, int i)
{
    char name[48];
    snprintf(name, sizeof name, "multiplier of constraint %d", i);
    expr_symbol_add(st, name, EXPR_PARAMETER);
    return expr_symbol_find(st, name, strlen(name));
}

static bool held(const struct traj_request *rq, int j)
{
    return rq->held && rq->held[j];
}

/* The conditions into function; returns how many. */
static int conditions(struct expr_store *st, const struct sga_solution *sol, const struct traj_request *rq, const struct sizes *sizes, const int *symbol, int n,
                      expr_id *function)
{
    int c = sol->constraints, count = 0;
    expr_id sum = expr_int(st, 0);
    for (int i = 0; i < c; i++) {
        function[count++] = sol->constraint[i].expr;
        sum = expr_add(st, sum, expr_mul(st, st->symbol[symbol[n + i]].node, sol->constraint[i].expr));
    }
    for (int j = 0; j < n; j++) {
        if (held(rq, j))
            continue;
        bool known = rq->given[j] && rq->exact_initial && rq->exact_initial[j];
        expr_id g = known ? rq->exact_initial[j] : exact(st, rq->initial[j]), s = exact(st, unit_of(rq, sizes, j));
        expr_id far = expr_div(st, expr_sub(st, st->symbol[symbol[j]].node, g), expr_powi(st, s, 2));
        function[count++] = expr_add(st, far, expr_diff(st, sum, symbol[j]));
    }
    return count;
}

bool enclosed_nearest(struct expr_store *st, const struct enclose_problem *p, const struct sga_solution *sol, const struct traj_request *rq,
                      const struct sizes *sizes, const double *near, const arb_t t0, slong prec, arb_ptr x)
{
    int n = p->n, c = sol->constraints, *symbol = sga_malloc((size_t)(n + c + 1) * sizeof *symbol);
    unsigned char *solved = sga_malloc((size_t)(n + c) + 1);
    expr_id *function = sga_malloc((size_t)(n + c + 1) * sizeof *function);
    arb_ptr u = _arb_vec_init(n + c);
    memcpy(symbol, p->variable, (size_t)n * sizeof *symbol);
    for (int i = 0; i < c; i++)
        symbol[n + i] = multiplier(st, i);
    for (int j = 0; j < n + c; j++) {
        solved[j] = j >= n || !held(rq, j);
        if (j < n && held(rq, j))
            enclosed_constant(st, rq->exact_initial ? rq->exact_initial[j] : EXPR_UNDEF, rq->initial[j], prec, u + j);
        else if (j < n)
            arb_set_d(u + j, near[j]);
    }
    int count = conditions(st, sol, rq, sizes, symbol, n, function);
    int unknowns = 0;
    for (int j = 0; j < n + c; j++)
        unknowns += solved[j];
    assert(count == unknowns);       /* interval Newton is for as many conditions */
    struct enclose_problem q = { .st = st, .variable = symbol, .n = n + c, .time = p->time, .tables = p->tables, .budget = p->budget };
    struct sga_error ignored = { 0 };
    bool ok = expr_store_ok(st) && enclose_zero(&q, function, count, t0, solved, prec, u, &ignored);
    if (ok)
        _arb_vec_set(x, u, n);
    _arb_vec_clear(u, n + c);
    free(symbol);
    free(solved);
    free(function);
    return ok;
}
