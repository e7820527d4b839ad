/* Lower bounds of singular values by sparse factors of B B^T. */
#include "least_singular.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "dd.h"
#include "lin_gram.h"
#include "lin_normal.h"
#include "lin_sparse.h"
#include "lin_stairs.h"
#include "mem.h"
#include "watch.h"

enum { TURNS = 3, EIGEN_TURNS = 6 };      /* of inverse iteration, and of that of the roundings */
/* Past so many products and entries of the factor, for each entry of B, the proof would take more than the points do. */
static const struct lin_gram_most MOST = { 200, 400 };

struct work {
    const struct lin_gram *g;
    const struct lin_sparse *B;
    const struct sga_budget *budget;
    double rounding;              /* of B B^T and its factor together: a bound of |E| in units of the rounding unit */
    double *v;
    double guess;                 /* of the square of the least singular value, once there is one; 0 */
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

/* max_i (P x)_i / x_i is a bound of the largest eigenvalue of P, which has no negative entry, for any x > 0 (Collatz): here of the best of some
 * steps towards its eigenvector. times(of, x, y): y = P x. */
static double largest_of(int c, void (*times)(const void *of, const double *x, double *y), const void *of)
{
    SGA_ARENA(mem);
    double *x = sga_take(&mem, ((size_t)c + 1) * sizeof *x), *y = sga_take(&mem, ((size_t)c + 1) * sizeof *y), least = INFINITY;
    for (int k = 0; k < c; k++)
        x[k] = 1;
    for (int turn = 0; turn < EIGEN_TURNS; turn++) {
        double most = 0, size = 0;
        times(of, x, y);
        for (int k = 0; k < c; k++) {
            most = fmax(most, y[k] / x[k]);
            size = fmax(size, y[k]);
        }
        least = fmin(least, most);
        for (int k = 0; k < c && size > 0; k++)
            x[k] = fmax(y[k] / size, 1e-6);
    }
    return least * (1 + 1e-9);
}

struct roundings { const struct lin_gram *g; const double *d, *terms; };

/* P_ij = k_ij d_i d_j where L or its transpose has an entry, k_ij no fewer than the terms of the sum that makes it up. */
static void times_roundings(const void *of, const double *x, double *y)
{
    const struct roundings *r = of;
    const struct lin_gram *g = r->g;
    const double *d = r->d, *terms = r->terms;
    for (int k = 0; k < g->c; k++)
        y[k] = terms[k] * d[k] * d[k] * x[k];
    for (int i = 0; i < g->c; i++)
        for (int q = g->column[i]; q < g->column[i + 1]; q++) {
            int k = g->row[q];
            double p = fmin(terms[i], terms[k]) * d[i] * d[k];
            y[i] += p * x[k];
            y[k] += p * x[i];
        }
}

/* A bound of |E| before there is a factor. */
static double rounding_of(const struct work *w)
{
    const struct lin_gram *g = w->g;
    const struct lin_sparse *B = w->B;
    SGA_ARENA(mem);
    size_t c = (size_t)g->c + 1;
    double *d = sga_zeros(&mem, c, sizeof *d), *terms = sga_take(&mem, c * sizeof *terms);
    for (int k = 0; k < g->c; k++) {
        int i = g->order[k];
        for (int e = B->ptr[i]; e < B->ptr[i + 1]; e++)
            d[k] += B->val[e] * B->val[e];
        d[k] = sqrt(d[k]);
        terms[k] = g->from[k + 1] - g->from[k] + g->left[k + 1] - g->left[k] + 8.0;
    }
    return 4 * largest_of(g->c, times_roundings, &(struct roundings){ g, d, terms });       /* 4: products, their sum, the factor, and what is left of second order */
}

/* What L D L^T in doubles differs from B B^T - shift I by at most, in rounding units: by entry of L, and on the diagonal. */
struct running { const struct lin_gram *g; double *L, *d; };

static void times_running(const void *of, const double *x, double *y)
{
    const struct running *r = of;
    for (int k = 0; k < r->g->c; k++)
        y[k] = r->d[k] * x[k];
    for (int i = 0; i < r->g->c; i++)
        for (int q = r->g->column[i]; q < r->g->column[i + 1]; q++) {
            y[i] += r->L[q] * x[r->g->row[q]];
            y[r->g->row[q]] += r->L[q] * x[i];
        }
}

/* The factor once more, each operation with its rounding (a running error analysis: Higham, Accuracy and Stability of Numerical Algorithms,
 * 3.3): of a product, and of the product L_kp D_p that stands for what was divided, one unit each, of a sum or a difference one of what it is. */
static bool factor_running(const struct lin_gram *g, const struct lin_sparse *B, double shift, struct running *r)
{
    SGA_ARENA(mem);
    size_t c = (size_t)g->c + 1;
    double *L = sga_take(&mem, ((size_t)g->column[g->c] + 1) * sizeof *L), *D = sga_take(&mem, c * sizeof *D);
    double *y = sga_zeros(&mem, c, sizeof *y), *e = sga_zeros(&mem, c, sizeof *e);
    bool positive = true;
    for (int k = 0; k < g->c && positive; k++) {
        for (int p = g->from[k]; p < g->from[k + 1]; p++) {
            int j = g->product[p].j;
            double product = B->val[g->product[p].a] * B->val[g->product[p].b];
            y[j] += product;
            e[j] += fabs(product) + fabs(y[j]);
        }
        double d = y[k] - shift, error = e[k] + fabs(d);
        y[k] = e[k] = 0;
        for (int p = g->left[k]; p < g->left[k + 1]; p++) {
            int i = g->at[p], end = g->place[p];
            double yi = y[i];
            r->L[end] = e[i] + fabs(yi);
            y[i] = e[i] = 0;
            for (int q = g->column[i]; q < end; q++) {
                double product = L[q] * yi;
                int j = g->row[q];
                y[j] -= product;
                e[j] += 2 * fabs(product) + fabs(y[j]);
            }
            L[end] = yi / D[i];
            double product = L[end] * yi;
            d -= product;
            error += 2 * fabs(product) + fabs(d);
        }
        D[k] = d;
        r->d[k] = error;
        positive = d > 0 && d * 0 == 0 && (k % 64 || sga_watch_ok());
    }
    return positive;
}

/* The bound with the roundings that there were, where those that there may be are too many. */
static double running_bound(struct work *w)
{
    SGA_ARENA(mem);
    const struct lin_gram *g = w->g;
    struct running r = { g, sga_take(&mem, ((size_t)g->column[g->c] + 1) * sizeof(double)), sga_take(&mem, ((size_t)g->c + 1) * sizeof(double)) };
    for (double shift = w->guess / 4; shift > w->guess / 64 && sga_budget_ok(w->budget, NULL); shift /= 4) {
        if (!factor_running(g, w->B, shift, &r))
            continue;
        double error = 1.01 * DBL_EPSILON / 2 * largest_of(g->c, times_running, &r);      /* 1.01: roundings of these sums, and of second order */
        return error < shift / 2 ? sqrt(shift - error) * (1 - 0x1p-40) : 0;
    }
    return 0;
}

/* g: of B's pattern. */
static double with_gram(const struct lin_sparse *B, const struct lin_gram *g, const struct sga_budget *budget)
{
    struct work w = { .g = g, .B = B, .budget = budget };
    SGA_FREED double *v = w.v = sga_malloc(((size_t)B->rows + 1) * sizeof *v);
    w.rounding = rounding_of(&w);
    double least = double_bound(&w, DBL_EPSILON);
    if (least <= 0 && w.guess > 0)
        least = running_bound(&w);
    if (least <= 0)
        least = dd_bound(&w, NUM_DD_EPSILON);
    assert(least >= 0);
    return least;
}

double num_least_singular(const struct lin_sparse *B, const struct sga_budget *budget)
{
    struct lin_gram g;
    if (!lin_gram_init(&g, B, MOST))
        return 0;
    double least = with_gram(B, &g, budget);
    lin_gram_clear(&g);
    return least;
}

/* Upper bounds of the 2-norms of the blocks beside the diagonal, by group and earlier group, from the largest sums of rows and columns. */
static void couplings(const struct lin_stairs *s, double *C)
{
    const struct lin_sparse *J = s->J;
    int groups = s->groups;
    SGA_ARENA(mem);
    double *column = sga_take(&mem, ((size_t)J->cols + 1) * sizeof *column), *row = sga_take(&mem, (size_t)groups * sizeof *row);
    double *rows = sga_take(&mem, (size_t)groups * sizeof *rows), *columns = sga_take(&mem, (size_t)groups * sizeof *columns);
    for (int g = 0; g < groups; g++) {
        const struct lin_stair *m = s->at + g;
        memset(column, 0, (size_t)J->cols * sizeof *column);
        memset(rows, 0, (size_t)groups * sizeof *rows);
        memset(columns, 0, (size_t)groups * sizeof *columns);
        for (int i = 0; i < m->M->rows; i++) {
            memset(row, 0, (size_t)groups * sizeof *row);
            for (int e = J->ptr[m->row[i]]; e < J->ptr[m->row[i] + 1]; e++) {
                row[s->of_column[J->col[e]]] += fabs(J->val[e]);
                column[J->col[e]] += fabs(J->val[e]);
            }
            for (int h = 0; h < groups; h++)
                rows[h] = fmax(rows[h], row[h]);
        }
        for (int j = 0; j < J->cols; j++)
            if (s->of_column[j] >= 0)
                columns[s->of_column[j]] = fmax(columns[s->of_column[j]], column[j]);
        for (int h = 0; h < g; h++)
            C[g * groups + h] = sqrt(rows[h] * columns[h]) * (1 + 1e-9);
    }
}

double num_least_singular_stairs(const struct lin_stairs *s, const struct sga_budget *budget)
{
    int n = s->groups;
    SGA_ARENA(mem);
    double *C = sga_zeros(&mem, (size_t)(n * n), sizeof *C), *T = sga_zeros(&mem, (size_t)(n * n), sizeof *T), sum = 0;
    couplings(s, C);
    for (int g = 0; g < n; g++) {
        const struct lin_stair *m = s->at + g;
        double least = m->normal ? with_gram(m->M, lin_normal_gram(m->normal), budget) : num_least_singular(m->M, budget);
        if (!(least > 0))
            return 0;
        T[g * n + g] = 1 / least;
        for (int h = 0; h < g; h++) {
            for (int j = h; j < g; j++)
                T[g * n + h] += C[g * n + j] * T[j * n + h];
            T[g * n + h] /= least;
        }
    }
    for (int k = 0; k < n * n; k++)
        sum += T[k] * T[k];
    return (1 - 1e-9) / sqrt(sum);
}
