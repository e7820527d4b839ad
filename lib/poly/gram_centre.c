/* The middle of a spectrahedron, in doubles: minimise t with sum y_k B_k + t I positive
 * definite, by Newton's method along the central path of
 *     t / mu - log det(sum y_k B_k + t I) - log(t + 1).
 * Nesterov and Nemirovski's barrier (Boyd and Vandenberghe, Convex Optimization, chapter 11). */
#include "gram.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "budget.h"
#include "mem.h"

struct work {
    const struct gram_parts *p;
    const struct sga_budget *budget;
    int n;                     /* unknowns: y_1 .., then t */
    double **S, **inverse;     /* by block */
    double *M;                 /* of one block */
    double *H, *g, *d, *try;
    int order;                 /* all sizes together */
};

/* Lower triangle of A = L L^T in its place. */
static bool cholesky(double *A, int n)
{
    for (int j = 0; j < n; j++) {
        double s = A[j * n + j];
        for (int k = 0; k < j; k++)
            s -= A[j * n + k] * A[j * n + k];
        if (!(s > 0))
            return false;
        double r = A[j * n + j] = sqrt(s);
        for (int i = j + 1; i < n; i++) {
            double v = A[i * n + j];
            for (int k = 0; k < j; k++)
                v -= A[i * n + k] * A[j * n + k];
            A[i * n + j] = v / r;
        }
    }
    return true;
}

static void solve(const double *L, int n, double *x)
{
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < i; k++)
            x[i] -= L[i * n + k] * x[k];
        x[i] /= L[i * n + i];
    }
    for (int i = n - 1; i >= 0; i--) {
        for (int k = i + 1; k < n; k++)
            x[i] -= L[k * n + i] * x[k];
        x[i] /= L[i * n + i];
    }
}

static void assemble(const struct work *w, const double *y)
{
    const struct gram_parts *p = w->p;
    for (int b = 0; b < p->blocks; b++) {
        int n = p->size[b];
        for (int i = 0; i < n * n; i++)
            w->S[b][i] = 0;
        for (int i = 0; i < n; i++)
            w->S[b][i * n + i] = y[w->n - 1];
    }
    for (int k = 0; k < p->parts; k++)
        for (int e = p->start[k]; e < p->start[k + 1]; e++) {
            const struct gram_entry *x = p->entry + e;
            int n = p->size[x->block];
            double v = k ? y[k - 1] * x->v : x->v;
            w->S[x->block][x->j * n + x->i] += v;
            if (x->i != x->j)
                w->S[x->block][x->i * n + x->j] += v;
        }
}

/* The barrier at y, the Cholesky factors left in S; infinity outside. */
static double barrier(const struct work *w, const double *y, double mu)
{
    double t = y[w->n - 1], value = t / mu - log1p(t);
    if (!(t > -1))
        return INFINITY;
    assemble(w, y);
    for (int b = 0; b < w->p->blocks; b++) {
        int n = w->p->size[b];
        if (!cholesky(w->S[b], n))
            return INFINITY;
        for (int i = 0; i < n; i++)
            value -= 2 * log(w->S[b][i * n + i]);
    }
    return value;
}

static void invert(const struct work *w)
{
    for (int b = 0; b < w->p->blocks; b++) {
        int n = w->p->size[b];
        for (int c = 0; c < n; c++) {
            double *x = w->inverse[b] + c * n;
            for (int i = 0; i < n; i++)
                x[i] = i == c;
            solve(w->S[b], n, x);
        }
    }
}

/* tr(B_k M) for the part's entries in block b */
static double trace_with(const struct gram_parts *p, int k, int b, const double *M)
{
    double s = 0;
    int n = p->size[b];
    for (int e = p->start[k]; e < p->start[k + 1]; e++) {
        const struct gram_entry *x = p->entry + e;
        if (x->block == b)
            s += x->v * M[x->i * n + x->j] * (x->i == x->j ? 1 : 2);
    }
    return s;
}

/* M = S^-1 B_k S^-1 in block b; false: the part has nothing there. */
static bool sandwich(const struct work *w, int k, int b)
{
    const struct gram_parts *p = w->p;
    const double *T = w->inverse[b];
    int n = p->size[b];
    bool any = false;
    for (int i = 0; i < n * n; i++)
        w->M[i] = 0;
    for (int e = p->start[k]; e < p->start[k + 1]; e++) {
        const struct gram_entry *x = p->entry + e;
        if (x->block != b)
            continue;
        any = true;
        for (int i = 0; i < n; i++) {
            double u = x->v * T[x->i * n + i], v = x->i == x->j ? 0 : x->v * T[x->j * n + i];
            for (int j = 0; j < n; j++)
                w->M[i * n + j] += u * T[x->j * n + j] + v * T[x->i * n + j];
        }
    }
    return any;
}

/* Gradient and Hessian of the barrier. */
static void expand(struct work *w, const double *y, double mu)
{
    const struct gram_parts *p = w->p;
    int n = w->n, K = n - 1;
    double t = y[K];
    for (int i = 0; i < n * n; i++)
        w->H[i] = 0;
    for (int i = 0; i < n; i++)
        w->g[i] = 0;
    w->g[K] = 1 / mu - 1 / (t + 1);
    w->H[K * n + K] = 1 / ((t + 1) * (t + 1));
    for (int b = 0; b < p->blocks; b++) {
        int m = p->size[b];
        const double *T = w->inverse[b];
        for (int i = 0; i < m; i++)
            w->g[K] -= T[i * m + i];
        for (int i = 0; i < m * m; i++)
            w->H[K * n + K] += T[i] * T[i];
        for (int k = 0; k < K; k++) {
            if (!sandwich(w, k + 1, b))
                continue;
            w->g[k] -= trace_with(p, k + 1, b, T);
            for (int l = 0; l <= k; l++)
                w->H[k * n + l] += trace_with(p, l + 1, b, w->M);
            for (int i = 0; i < m; i++)
                w->H[K * n + k] += w->M[i * m + i];
        }
    }
}

/* d = -H^-1 g; returns its decrement squared, or -1. */
static double direction(struct work *w)
{
    int n = w->n;
    double largest = 0, s = 0;
    for (int i = 0; i < n; i++)
        largest = fmax(largest, w->H[i * n + i]);
    for (int i = 0; i < n; i++)
        w->H[i * n + i] += 1e-14 * largest + 1e-300;
    if (!cholesky(w->H, n))
        return -1;
    for (int i = 0; i < n; i++)
        w->d[i] = -w->g[i];
    solve(w->H, n, w->d);
    for (int i = 0; i < n; i++)
        s -= w->g[i] * w->d[i];
    return s;
}

/* Newton steps to the centre for this mu. False: no further step is possible, or the budget ended. */
static bool centre(struct work *w, double *y, double mu)
{
    enum { STEPS = 30, HALVINGS = 40 };
    for (int step = 0; step < STEPS; step++) {
        if (w->budget && !sga_budget_ok(w->budget, NULL))
            return false;
        double now = barrier(w, y, mu);
        invert(w);
        expand(w, y, mu);
        double decrement = direction(w), along = 1;
        if (!(decrement >= 0))
            return false;
        if (decrement < 1e-4)
            return true;
        int h = 0;
        for (; h < HALVINGS; h++, along /= 2) {
            for (int i = 0; i < w->n; i++)
                w->try[i] = y[i] + along * w->d[i];
            if (barrier(w, w->try, mu) < now - 1e-2 * along * decrement)
                break;
        }
        if (h == HALVINGS)
            return decrement < 1e-2;
        for (int i = 0; i < w->n; i++)
            y[i] = w->try[i];
    }
    return true;
}

/* An upper bound of minus the least eigenvalue of the constant part. */
static double start_of(const struct gram_parts *p)
{
    double most = 0;
    for (int e = p->start[0]; e < p->start[1]; e++)
        most += fabs(p->entry[e].v);
    return most + 1;
}

double gram_centre(const struct gram_parts *p, const struct sga_budget *budget, double *y)
{
    SGA_ARENA(mem);
    struct work w = { .p = p, .budget = budget, .n = p->parts };
    int n = w.n, largest = 1;
    assert(n >= 1 && p->start[0] == 0);
    w.S = sga_zeros(&mem, (size_t)p->blocks + 1, sizeof *w.S);
    w.inverse = sga_zeros(&mem, (size_t)p->blocks + 1, sizeof *w.inverse);
    for (int b = 0; b < p->blocks; b++) {
        w.S[b] = sga_zeros(&mem, (size_t)(p->size[b] * p->size[b]) + 1, sizeof **w.S);
        w.inverse[b] = sga_zeros(&mem, (size_t)(p->size[b] * p->size[b]) + 1, sizeof **w.S);
        largest = p->size[b] > largest ? p->size[b] : largest;
        w.order += p->size[b];
    }
    w.M = sga_zeros(&mem, (size_t)(largest * largest), sizeof *w.M);
    w.H = sga_zeros(&mem, (size_t)(n * n), sizeof *w.H);
    w.g = sga_zeros(&mem, 4 * (size_t)n, sizeof *w.g);
    w.d = w.g + n;
    w.try = w.d + n;
    double *z = w.try + n, t;
    z[n - 1] = start_of(p);
    bool going = true;
    for (double mu = 1; going && mu > 1e-10; mu /= 8) {
        going = centre(&w, z, mu);
        t = z[n - 1];
        if (t - 2 * mu * (w.order + 1) > 1e-6)      /* no better than that */
            break;
        if (t < -1e-3 && mu * (w.order + 1) < -0.1 * t)
            break;
    }
    t = budget && !sga_budget_ok(budget, NULL) ? NAN : z[n - 1];
    for (int k = 0; k < n - 1; k++)
        y[k] = z[k];
    return -t;
}

void gram_matrix(const struct gram_parts *p, const double *y, int block, double *Q)
{
    assert(block >= 0 && block < p->blocks);
    int n = p->size[block];
    for (int i = 0; i < n * n; i++)
        Q[i] = 0;
    for (int k = 0; k < p->parts; k++)
        for (int e = p->start[k]; e < p->start[k + 1]; e++) {
            const struct gram_entry *x = p->entry + e;
            if (x->block != block)
                continue;
            double v = k ? y[k - 1] * x->v : x->v;
            Q[x->i * n + x->j] += v;
            if (x->i != x->j)
                Q[x->j * n + x->i] += v;
        }
}

bool gram_inside(const struct gram_parts *p, const double *y, double t)
{
    bool inside = true;
    for (int b = 0; b < p->blocks && inside; b++) {
        int n = p->size[b];
        SGA_FREED double *Q = sga_malloc((size_t)(n * n + 1) * sizeof *Q);
        gram_matrix(p, y, b, Q);
        for (int i = 0; i < n; i++)
            Q[i * n + i] += t;
        inside = cholesky(Q, n);
    }
    return inside;
}

/* One rotation that clears A_pq. */
static void rotate(double *A, double *V, int n, int p, int q)
{
    double theta = (A[q * n + q] - A[p * n + p]) / (2 * A[p * n + q]);
    double t = (theta < 0 ? -1 : 1) / (fabs(theta) + sqrt(theta * theta + 1)), c = 1 / sqrt(t * t + 1), s = t * c;
    for (int k = 0; k < n; k++) {
        double x = A[k * n + p], y = A[k * n + q];
        A[k * n + p] = c * x - s * y;
        A[k * n + q] = s * x + c * y;
    }
    for (int k = 0; k < n; k++) {
        double x = A[p * n + k], y = A[q * n + k];
        A[p * n + k] = c * x - s * y;
        A[q * n + k] = s * x + c * y;
    }
    for (int k = 0; k < n; k++) {
        double x = V[k * n + p], y = V[k * n + q];
        V[k * n + p] = c * x - s * y;
        V[k * n + q] = s * x + c * y;
    }
}

void gram_eigen(double *A, int n, double *value, double *V)
{
    enum { SWEEPS = 30 };
    for (int i = 0; i < n * n; i++)
        V[i] = i % (n + 1) == 0;
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double off = 0;
        for (int p = 0; p < n; p++)
            for (int q = p + 1; q < n; q++) {
                off += fabs(A[p * n + q]);
                if (fabs(A[p * n + q]) > 1e-300)
                    rotate(A, V, n, p, q);
            }
        if (off < 1e-200)
            break;
    }
    for (int i = 0; i < n; i++)
        value[i] = A[i * n + i];
    for (int i = 1; i < n; i++)
        for (int k = i; k > 0 && value[k] < value[k - 1]; k--) {
            double v = value[k];
            value[k] = value[k - 1];
            value[k - 1] = v;
            for (int r = 0; r < n; r++) {
                v = V[r * n + k];
                V[r * n + k] = V[r * n + k - 1];
                V[r * n + k - 1] = v;
            }
        }
}
