/* Gaussian elimination over node handles, for texts that must stand without SOLVE. */
#include "names_solve.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

struct elimination {
    struct expr_store *st;
    int m;
    expr_id *a;       /* m rows of m + 1: the right side is the last column */
};

static expr_id *entry(const struct elimination *e, int row, int col)
{
    return e->a + (size_t)row * (size_t)(e->m + 1) + col;
}

static bool zero(const struct elimination *e, int row, int col)
{
    return expr_is_zero(e->st, *entry(e, row, col));
}

static int row_weight(const struct elimination *e, int row, int from)
{
    int n = 0;
    for (int j = from; j < e->m; j++)
        n += !zero(e, row, j);
    return n;
}

/* The row to pivot column k on, or -1. */
static int choose(const struct elimination *e, int k)
{
    int best = -1, best_weight = 0;
    for (int i = k; i < e->m; i++) {
        if (zero(e, i, k))
            continue;
        int w = row_weight(e, i, k) + (expr_is_const(e->st, *entry(e, i, k)) ? 0 : e->m);
        if (best < 0 || w < best_weight) {
            best = i;
            best_weight = w;
        }
    }
    return best;
}

static bool forward(struct elimination *e)
{
    for (int k = 0; k < e->m; k++) {
        int p = choose(e, k);
        if (p < 0)
            return false;
        for (int j = 0; j <= e->m && p != k; j++) {
            expr_id t = *entry(e, k, j);
            *entry(e, k, j) = *entry(e, p, j);
            *entry(e, p, j) = t;
        }
        for (int i = k + 1; i < e->m; i++) {
            if (zero(e, i, k))
                continue;
            expr_id f = expr_div(e->st, *entry(e, i, k), *entry(e, k, k));
            for (int j = k + 1; j <= e->m; j++)
                if (!zero(e, k, j))
                    *entry(e, i, j) = expr_sub(e->st, *entry(e, i, j), expr_mul(e->st, f, *entry(e, k, j)));
            if (!expr_store_ok(e->st))
                return false;
        }
    }
    return true;
}

static bool solve(struct expr_store *st, int index, const expr_id *to, expr_id *y)
{
    const struct expr_solve *s = st->solve + index;
    struct elimination e = { .st = st, .m = s->m };
    e.a = sga_malloc((size_t)s->m * (size_t)(s->m + 1) * sizeof *e.a);
    for (int i = 0; i < s->m; i++) {
        for (int j = 0; j < s->m; j++)
            *entry(&e, i, j) = expr_int(st, 0);
        for (int k = s->matrix.start[i]; k < s->matrix.start[i + 1]; k++)
            *entry(&e, i, s->matrix.column[k]) = to[s->matrix.entry[k]];
        *entry(&e, i, s->m) = to[s->rhs[i]];
    }
    bool ok = forward(&e);
    for (int i = e.m - 1; ok && i >= 0; i--) {
        expr_id r = *entry(&e, i, e.m);
        for (int j = i + 1; j < e.m; j++)
            if (!zero(&e, i, j))
                r = expr_sub(st, r, expr_mul(st, *entry(&e, i, j), y[j]));
        y[i] = expr_div(st, r, *entry(&e, i, i));
        ok = expr_store_ok(st);
    }
    free(e.a);
    return ok;
}

/* e with its children replaced. */
static expr_id rebuild(struct expr_store *st, expr_id e, const expr_id *to)
{
    const struct expr_node n = st->node[e];
    enum expr_op op = (enum expr_op)n.op;
    switch (op) {
    case EXPR_ADD:  return expr_add(st, to[n.a], to[n.b]);
    case EXPR_SUB:  return expr_sub(st, to[n.a], to[n.b]);
    case EXPR_MUL:  return expr_mul(st, to[n.a], to[n.b]);
    case EXPR_DIV:  return expr_div(st, to[n.a], to[n.b]);
    case EXPR_NEG:  return expr_neg(st, to[n.a]);
    case EXPR_POWI: return expr_powi(st, to[n.a], n.b);
    case EXPR_POW:  return expr_pow(st, to[n.a], to[n.b]);
    default:
        if (expr_op_args(op) == 1)
            return expr_fun(st, op, to[n.a]);
        return expr_op_args(op) == 2 ? expr_fun2(st, op, to[n.a], to[n.b]) : e;
    }
}

static bool has_solve(const struct expr_store *st, const struct expr_cone *c)
{
    for (int i = 0; i < c->count; i++)
        if (expr_op_of(st, c->list[i]) == EXPR_SOLVE)
            return true;
    return false;
}

static bool unchanged(const struct expr_store *st, expr_id e, const expr_id *to)
{
    for (int k = 0, n = expr_children(st, e); k < n; k++)
        if (to[expr_child(st, e, k)] != expr_child(st, e, k))
            return false;
    return true;
}

bool expr_write_out_solves(struct expr_store *st, expr_id *roots, int nroots)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(st, &c, roots, nroots);
    bool ok = true;
    if (has_solve(st, &c)) {
        SGA_ARENA(mem);
        expr_id *to = sga_take(&mem, (size_t)st->nodes * sizeof *to);
        expr_id **solution = sga_zeros(&mem, (size_t)st->solves + 1, sizeof *solution);
        for (int i = 0; ok && i < c.count; i++) {
            expr_id e = c.list[i];
            const struct expr_node n = st->node[e];
            if (n.op == EXPR_SOLVE) {
                if (!solution[n.a]) {
                    solution[n.a] = sga_calloc((size_t)st->solve[n.a].m, sizeof **solution);
                    ok = solve(st, n.a, to, solution[n.a]);
                }
                to[e] = solution[n.a][n.b];
            } else {
                to[e] = unchanged(st, e, to) ? e : rebuild(st, e, to);
            }
            ok = ok && expr_store_ok(st);
        }
        for (int i = 0; ok && i < nroots; i++)
            roots[i] = to[roots[i]];
        for (int i = 0; i < st->solves; i++)
            free(solution[i]);
    }
    return ok;
}
