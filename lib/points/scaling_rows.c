/* Least squares for logarithms: normal equations, eliminated where they are few, and otherwise by conjugate gradients on the rows
 * (Hestenes & Stiefel 1952; the size of a variable is wanted to a factor of 2, not to digits). */
#include "scaling_rows.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

enum { DENSE = 100, LEAST_STEPS = 500, ROUNDS = 6 };

/* What nothing is known of stays near 1. */
static const double DAMP = 1e-6;
/* Of the gradient's length. */
static const double ENOUGH = 1e-10;
/* Bits: an equation that is missed by more counts by its miss, not by the square of it, so that one number out of all proportion (1e-200 in a
 * sum) does not move all sizes. Huber 1964; by reweighted least squares. */
static const double FAR = 8;

void scaling_rows_init(struct scaling_rows *r, int rows)
{
    *r = (struct scaling_rows){ 0 };
    SGA_RESERVE(r->start, r->start_cap, rows + 1);
    r->start[0] = 0;
}

void scaling_rows_clear(struct scaling_rows *r)
{
    free(r->start);
    free(r->unknown);
    free(r->power);
    free(r->log);
}

void scaling_rows_add(struct scaling_rows *r, const int *unknown, const double *power, int count, double log)
{
    int at = r->start[r->count];
    SGA_RESERVE(r->unknown, r->cap, at + count + 1);
    SGA_RESERVE(r->power, r->power_cap, at + count + 1);
    for (int k = 0; k < count; k++) {
        if (power[k] == 0)
            continue;
        r->unknown[at] = unknown[k];
        r->power[at++] = power[k];
    }
    if (at == r->start[r->count])
        return;
    SGA_RESERVE(r->start, r->start_cap, r->count + 2);
    SGA_RESERVE(r->log, r->log_cap, r->count + 1);
    r->log[r->count] = log;
    r->start[++r->count] = at;
    assert(r->start[r->count] >= at && r->start[r->count] <= at + count);
}

/* y = E^T W E x + DAMP x, W the rows' weights */
static void times(const struct scaling_rows *r, const double *weight, int n, const double *x, double *y)
{
    for (int j = 0; j < n; j++)
        y[j] = DAMP * x[j];
    for (int i = 0; i < r->count; i++) {
        double sum = 0;
        for (int k = r->start[i]; k < r->start[i + 1]; k++)
            sum += weight[i] * r->power[k] * x[r->unknown[k]];
        for (int k = r->start[i]; k < r->start[i + 1]; k++)
            y[r->unknown[k]] += r->power[k] * sum;
    }
}

/* b = -E^T W log, and the diagonal of the matrix */
static void right_side(const struct scaling_rows *r, const double *weight, int n, double *b, double *diagonal)
{
    for (int j = 0; j < n; j++) {
        b[j] = 0;
        diagonal[j] = DAMP;
    }
    for (int i = 0; i < r->count; i++)
        for (int k = r->start[i]; k < r->start[i + 1]; k++) {
            b[r->unknown[k]] -= weight[i] * r->power[k] * r->log[i];
            diagonal[r->unknown[k]] += weight[i] * r->power[k] * r->power[k];
        }
}

static double dot(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

static void by_gradients(const struct scaling_rows *r, const double *weight, int n, double *log)
{
    SGA_FREED double *g = sga_malloc(5 * (size_t)n * sizeof *g);
    double *diagonal = g + n, *p = diagonal + n, *z = p + n, *Ap = z + n;
    memset(log, 0, (size_t)n * sizeof *log);
    right_side(r, weight, n, g, diagonal);
    for (int j = 0; j < n; j++)
        p[j] = z[j] = g[j] / diagonal[j];
    double rho = dot(g, z, n), first = rho;
    for (int k = 0; k < LEAST_STEPS + 2 * n && rho > ENOUGH * ENOUGH * first && rho > 0; k++) {
        times(r, weight, n, p, Ap);
        double step = rho / dot(p, Ap, n), last = rho;
        for (int j = 0; j < n; j++) {
            log[j] += step * p[j];
            g[j] -= step * Ap[j];
            z[j] = g[j] / diagonal[j];
        }
        rho = dot(g, z, n);
        for (int j = 0; j < n; j++)
            p[j] = z[j] + rho / last * p[j];
    }
}

/* Positive definite: no pivoting. */
static void by_elimination(const struct scaling_rows *r, const double *weight, int n, double *log)
{
    SGA_FREED double *M = sga_calloc((size_t)n * (size_t)n + 2 * (size_t)n + 1, sizeof *M);
    double *b = M + (size_t)n * (size_t)n;
    right_side(r, weight, n, b, b + n);
    for (int i = 0; i < r->count; i++)
        for (int k = r->start[i]; k < r->start[i + 1]; k++)
            for (int q = r->start[i]; q < r->start[i + 1]; q++)
                M[r->unknown[k] * n + r->unknown[q]] += weight[i] * r->power[k] * r->power[q];
    for (int i = 0; i < n; i++)
        M[i * n + i] += DAMP;
    for (int k = 0; k < n; k++)
        for (int i = k + 1; i < n; i++) {
            double f = M[i * n + k] / M[k * n + k];
            for (int j = k; j < n && f != 0; j++)
                M[i * n + j] -= f * M[k * n + j];
            b[i] -= f * b[k];
        }
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            b[i] -= M[i * n + j] * log[j];
        log[i] = b[i] / M[i * n + i];
    }
}

/* Weights by what each row is missed by. Whether any row is far from it. */
static bool weigh(const struct scaling_rows *r, const double *log, double *weight)
{
    bool far = false;
    for (int i = 0; i < r->count; i++) {
        double miss = r->log[i];
        for (int k = r->start[i]; k < r->start[i + 1]; k++)
            miss += r->power[k] * log[r->unknown[k]];
        weight[i] = fabs(miss) > FAR ? FAR / fabs(miss) : 1;
        far |= fabs(miss) > FAR;
    }
    return far;
}

void scaling_rows_solve(const struct scaling_rows *r, int n, bool robust, double *log)
{
    SGA_FREED double *weight = sga_malloc(((size_t)r->count + 1) * sizeof *weight);
    bool far = true;
    for (int i = 0; i < r->count; i++)
        weight[i] = 1;
    for (int k = 0; k <= (robust ? ROUNDS : 0) && far; k++) {
        if (n <= DENSE)
            by_elimination(r, weight, n, log);
        else
            by_gradients(r, weight, n, log);
        for (int j = 0; j < n; j++)
            if (!isfinite(log[j]))
                log[j] = 0;
        far = weigh(r, log, weight);
    }
}
