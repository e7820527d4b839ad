/* Lower bounds of singular values by sparse factors of B B^T. */
#include "least_singular.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "arena.h"
#include "budget.h"
#include "dd.h"
#include "lin_gram.h"
#include "lin_sparse.h"
#include "mem.h"
#include "watch.h"

enum { TURNS = 3 };               /* of inverse iteration */
/* Past so many products and entries of the factor, for each entry of B, the proof would take more than the points do. */
static const struct lin_gram_most MOST = { 200, 400 };

struct work {
    struct lin_gram g;
    const struct lin_sparse *B;
    const struct sga_budget *budget;
    double rounding;              /* of B B^T and its factor together: a bound of |E| in units of the rounding unit */
    double *v;
};

static void start_vector(int n, double *v)
{
    for (int i = 0; i < n; i++)
        v[i] = sin(1 + 2.3 * i);       /* as good as any, and not orthogonal to what is sought */
}

static double norm(int n, const double *v)
{
    double sum = 0;
    for (int i = 0; i < n; i++)
        sum += v[i] * v[i];
    return sqrt(sum);
}

#define NUMBER double
#define NAME(f) double_##f
#define OF_DOUBLE(x) (x)
#define ADD(a, b) ((a) + (b))
#define SUB(a, b) ((a) - (b))
#define MUL(a, b) ((a) * (b))
#define DIV(a, b) ((a) / (b))
#define HIGH(a) (a)
#include "least_singular_kernel.h"
#undef NUMBER
#undef NAME
#undef OF_DOUBLE
#undef ADD
#undef SUB
#undef MUL
#undef DIV
#undef HIGH
#define NUMBER num_dd
#define NAME(f) dd_##f
#define OF_DOUBLE(x) num_dd_of(x)
#define ADD(a, b) num_dd_add(a, b)
#define SUB(a, b) num_dd_sub(a, b)
#define MUL(a, b) num_dd_mul(a, b)
#define DIV(a, b) num_dd_div(a, b)
#define HIGH(a) ((a).hi)
#include "least_singular_kernel.h"

/* The largest sum over a row of gamma_k d_i d_j, over what is filled. */
static double rounding_of(const struct work *w)
{
    const struct lin_gram *g = &w->g;
    SGA_ARENA(mem);
    double *d = sga_zeros(&mem, (size_t)g->c + 1, sizeof *d), *sum = sga_zeros(&mem, (size_t)g->c + 1, sizeof *sum), most = 0;
    int terms = 0;
    for (int k = 0; k < g->c; k++) {
        const struct lin_sparse *B = w->B;
        int i = g->order[k], own = g->from[k + 1] - g->from[k] + g->left[k + 1] - g->left[k];
        for (int e = B->ptr[i]; e < B->ptr[i + 1]; e++)
            d[k] += B->val[e] * B->val[e];
        d[k] = sqrt(d[k]);
        sum[k] = d[k];
        terms = own > terms ? own : terms;
    }
    for (int i = 0; i < g->c; i++)
        for (int q = g->column[i]; q < g->column[i + 1]; q++) {
            sum[g->row[q]] += d[i];
            sum[i] += d[g->row[q]];
        }
    for (int k = 0; k < g->c; k++)
        most = fmax(most, d[k] * sum[k]);
    return 4 * (terms + 8.0) * most * (1 + 1e-9);       /* 4: products, their sum, the factor, and what is left of second order */
}

double num_least_singular(const struct lin_sparse *B, const struct sga_budget *budget)
{
    struct work w = { .B = B, .budget = budget };
    if (!lin_gram_init(&w.g, B, MOST))
        return 0;
    SGA_FREED double *v = w.v = sga_malloc(((size_t)B->rows + 1) * sizeof *v);
    w.rounding = rounding_of(&w);
    double least = double_bound(&w, DBL_EPSILON);
    if (least <= 0)
        least = dd_bound(&w, NUM_DD_EPSILON);
    lin_gram_clear(&w.g);
    assert(least >= 0);
    return least;
}
