/* Elimination by the zero oracle. */
#include "weak.h"

#include <assert.h>
#include <limits.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "oracle.h"
#include "poly.h"
#include "print.h"

#include <stdlib.h>

int weak_zero(const struct weak *w, expr_id e)
{
    if (expr_is_const(w->st, e))
        return expr_is_zero(w->st, e);
    struct points_decision d = points_oracle_zero(w->oracle, e);
    if (d.truth == POINTS_ZERO || d.truth == POINTS_NONZERO)
        return d.truth == POINTS_ZERO;
    if (!sga_budget_ok(w->budget, w->err))
        return -1;
    char *text = expr_text(w->st, e, 300);
    sga_fail(w->err, SGA_E_UNDECIDED, "whether %s vanishes on the constraints was not decided", text);
    free(text);
    return -1;
}

expr_id weak_normal(const struct weak *w, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, w->budget);
    expr_id normal = e;
    return e && !expr_is_const(w->st, e) && poly_normal(w->st, e, &limits, &normal) ? normal : e;
}

expr_id weak_on_set(const struct weak *w, expr_id e, const expr_id *by, int count)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, w->budget);
    expr_id out = e;
    if (expr_is_const(w->st, e) || count == 0)
        return e;
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, ((size_t)count + 1) * sizeof *root);
    memcpy(root, by, (size_t)count * sizeof *root);
    root[count] = e;
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(w->st, root, count + 1, &limits);
    return b && poly_bridge_on_set(b, e, by, count, LONG_MAX / 4, &out) ? weak_normal(w, out) : e;
}

/* The row below `from` whose entry serves best as a pivot: a constant first; -1: none, -2: undecided. */
static int choose(const struct weak *w, expr_id *m, int rows, int width, int column, int from)
{
    int best = -1;
    for (int i = from; i < rows; i++) {
        expr_id *e = m + (long)i * width + column;
        int zero = weak_zero(w, *e);
        if (zero < 0)
            return -2;
        if (zero) {
            *e = expr_int(w->st, 0);
            continue;
        }
        if (expr_is_const(w->st, *e))
            return i;
        if (best < 0)
            best = i;
    }
    return best;
}

static void swap(expr_id *a, expr_id *b, int n)
{
    for (int k = 0; k < n; k++) {
        expr_id t = a[k];
        a[k] = b[k];
        b[k] = t;
    }
}

/* row -= factor * by, in normal forms. */
static void subtract(const struct weak *w, expr_id *row, const expr_id *by, expr_id factor, int width)
{
    for (int k = 0; k < width; k++)
        if (!expr_is_zero(w->st, by[k]))
            row[k] = weak_normal(w, expr_sub(w->st, row[k], expr_mul(w->st, factor, by[k])));
}

static void log_pivot(struct weak_pivots *p, expr_id e)
{
    SGA_RESERVE_IN(p->mem, p->e, p->cap, (size_t)p->count + 1);
    p->e[p->count++] = e;
}

bool weak_eliminate(const struct weak *w, expr_id *m, int rows, int columns, int width, int *pivot_of)
{
    assert(columns <= width);
    int rank = 0;
    for (int c = 0; c < columns; c++) {
        int p = choose(w, m, rows, width, c, rank);
        pivot_of[c] = -1;
        if (p == -2 || !sga_budget_ok(w->budget, w->err))
            return false;
        if (p < 0)
            continue;
        expr_id *pivot = m + (long)rank * width;
        if (p != rank)
            swap(pivot, m + (long)p * width, width);
        expr_id by = pivot[c];
        if (w->pivots)
            log_pivot(w->pivots, by);
        for (int k = 0; k < width; k++)
            pivot[k] = expr_is_zero(w->st, pivot[k]) ? pivot[k] : weak_normal(w, expr_div(w->st, pivot[k], by));
        for (int i = 0; i < rows; i++)
            if (i != rank && !expr_is_zero(w->st, m[(long)i * width + c]))
                subtract(w, m + (long)i * width, pivot, m[(long)i * width + c], width);
        assert(p >= rank && rank <= c);
        pivot_of[c] = rank++;
    }
    return true;
}
