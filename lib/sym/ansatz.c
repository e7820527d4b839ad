/* The functions that a search combines: those of the request, and monomials. */
#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "mem.h"
#include "sym_work.h"
#include "system.h"

/* The product of the variables that index names (nondecreasing, `degree` of them). */
static expr_id monomial(struct sym_work *w, const int *index, int degree)
{
    expr_id e = expr_int(w->st, 1);
    for (int k = 0; k < degree;) {
        int from = k, v = index[k];
        while (k < degree && index[k] == v)
            k++;
        int symbol = v < w->n ? w->variable[v] : w->sys->time;
        expr_id x = w->st->symbol[symbol].node;
        e = expr_mul(w->st, e, k - from == 1 ? x : expr_powi(w->st, x, k - from));
    }
    return e;
}

/* The next nondecreasing list of `degree` numbers below m; false after the last. */
static bool next(int *index, int degree, int m)
{
    int k = degree - 1;
    while (k >= 0 && index[k] == m - 1)
        k--;
    if (k < 0)
        return false;
    int v = index[k] + 1;
    for (; k < degree; k++)
        index[k] = v;
    return true;
}

static double count_monomials(int m, int degree)
{
    double c = 1;
    for (int k = 1; k <= degree && c < 1e12; k++)
        c *= (double)(m + k) / k;
    return c;
}

bool sym_ansatz_init(struct sym_work *w, const struct sym_search *s, int degree, int limit, struct sym_ansatz *a)
{
    int m = w->n + s->time;
    *a = (struct sym_ansatz){ 0 };
    if (s->functions + count_monomials(m, degree) > limit)
        return false;
    size_t room = (size_t)s->functions + (size_t)(count_monomials(m, degree) + 1.5), n = (size_t)w->n + 1;
    a->f = sga_malloc(room * sizeof *a->f);
    for (int k = 0; k < s->functions; k++)
        a->f[a->count++] = s->function[k];
    SGA_FREED int *index = sga_calloc((size_t)degree + 1, sizeof *index);
    for (int d = degree; d >= 0; d--) {
        for (int k = 0; k < d; k++)
            index[k] = 0;
        do
            a->f[a->count++] = monomial(w, index, d);
        while (next(index, d, m));
    }
    a->d = sga_malloc((size_t)a->count * n * sizeof *a->d);
    for (int k = 0; k < a->count; k++)
        for (size_t b = 0; b < n; b++)
            a->d[(size_t)k * n + b] = expr_diff(w->st, a->f[k], b < n - 1 ? w->variable[b] : w->sys->time);
    assert(a->count <= limit);
    return true;
}

void sym_ansatz_clear(struct sym_ansatz *a)
{
    free(a->f);
    free(a->d);
}

expr_id sym_combination(struct sym_work *w, const fmpq *q, const expr_id *f, int count, int stride)
{
    expr_id sum = expr_int(w->st, 0);
    for (int k = 0; k < count; k++)
        if (!fmpq_is_zero(q + k))
            sum = expr_add(w->st, sum, expr_mul(w->st, expr_fmpq(w->st, q + k), f[k * stride]));
    return sum;
}
