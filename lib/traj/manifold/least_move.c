/* Derivatives of points that move as little as constraints let them: see least_move.h. */
#include "least_move.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "arena.h"
#include "dependent.h"

/* How well equations that depend on others must agree, by those digits that dependent_solve asks for. */
static const double AGREE = 1e3;

static int row_of(const struct least_move *l, int i, int d) { return l->rows->first + i * (1 + l->q) + d; }

bool least_move_at(struct least_move *l, struct least_rows *rows, double t, const double *x, const double *tau, struct sga_arena *mem)
{
    size_t n = (size_t)rows->n, c = (size_t)rows->count, q = (size_t)rows->q;
    *l = (struct least_move){ .rows = rows, .t = t, .x = x, .n = rows->n, .c = rows->count, .q = rows->q, .tau = tau };
    l->J = sga_zeros(mem, c * n + 1, sizeof *l->J);
    l->by = sga_zeros(mem, c * q + 1, sizeof *l->by);
    l->miss = sga_zeros(mem, c + 1, sizeof *l->miss);
    l->unit = sga_zeros(mem, n + 1, sizeof *l->unit);
    l->use = sga_zeros(mem, c + 1, 1);
    l->free = sga_zeros(mem, n + 1, 1);
    l->lambda = sga_zeros(mem, c + 1, sizeof *l->lambda);
    l->H = sga_zeros(mem, n * n + 1, sizeof *l->H);
    l->bent = sga_zeros(mem, n * q + 1, sizeof *l->bent);
    if (!least_rows_at(rows, t, x, NULL))
        return false;
    for (int i = 0; i < l->c; i++) {
        double by_time = least_rows_gradient(rows, row_of(l, i, 0), l->J + (size_t)i * n);
        for (int d = 0; d < l->q; d++)
            l->by[i * l->q + d] = rows->out[row_of(l, i, 1 + d)] + (tau ? by_time * tau[d] : 0);
        l->miss[i] = rows->out[row_of(l, i, 0)];
        l->use[i] = 1;
    }
    return true;
}

/* The second derivatives in the direction lambda: the derivative of xi_x S + xi_k, by variables and time, at S = 0 and at unit vectors S. */
bool least_bend(struct least_move *l, struct sga_arena *mem)
{
    size_t n = (size_t)l->n, q = (size_t)l->q;
    double *S = sga_zeros(mem, n * q + 1, sizeof *S), *g = sga_zeros(mem, 3 * n + 1, sizeof *g), *still = g + n, *by_time = still + n, at_zero = 0;
    memset(l->H, 0, n * n * sizeof *l->H);
    memset(l->bent, 0, n * q * sizeof *l->bent);
    if (!least_rows_at(l->rows, l->t, l->x, NULL))
        return false;
    for (int i = 0; i < l->c; i++)
        for (int d = 0; d < l->q && l->lambda[i] != 0; d++) {
            double t = least_rows_gradient(l->rows, row_of(l, i, 1 + d), g);
            for (size_t k = 0; k < n; k++) {
                l->bent[k * q + (size_t)d] += l->lambda[i] * g[k];
                still[k] += d ? 0 : l->lambda[i] * g[k];
            }
            at_zero += d ? 0 : l->lambda[i] * t;
        }
    for (size_t m = 0; m < n; m++) {
        S[m] = 1;
        if (!least_rows_at(l->rows, l->t, l->x, S))
            return false;
        S[m] = 0;
        for (int i = 0; i < l->c; i++) {
            if (l->lambda[i] == 0)
                continue;
            by_time[m] += l->lambda[i] * least_rows_gradient(l->rows, row_of(l, i, 1), g);
            for (size_t k = 0; k < n; k++)
                l->H[k * n + m] += l->lambda[i] * g[k];
        }
        by_time[m] -= at_zero;
        for (size_t k = 0; k < n; k++)
            l->H[k * n + m] -= still[k];
    }
    for (size_t k = 0; k < n; k++)
        for (size_t d = 0; d < q; d++)
            l->bent[k * q + d] += l->tau ? by_time[k] * l->tau[d] : 0;
    return true;
}

/* What moves, and the constraints in use, by the sizes of their gradients. */
struct places { int *moves, *constraint; int count, constraints; double *size; };

static void find_places(const struct least_move *l, struct places *p, struct sga_arena *mem)
{
    *p = (struct places){ .moves = sga_zeros(mem, (size_t)l->n + 1, sizeof(int)), .constraint = sga_zeros(mem, (size_t)l->c + 1, sizeof(int)),
                          .size = sga_zeros(mem, (size_t)l->c + 1, sizeof(double)) };
    for (int k = 0; k < l->n; k++)
        if (l->free[k])
            p->moves[p->count++] = k;
    for (int i = 0; i < l->c; i++) {
        double most = 0;
        for (int k = 0; k < l->n; k++)
            most = fmax(most, fabs(l->J[i * l->n + k]) * l->unit[k]);
        if (l->use[i] && most > 0) {
            p->size[p->constraints] = most;
            p->constraint[p->constraints++] = i;
        }
    }
}

bool least_multipliers(struct least_move *l, const double *pull, double floor, struct sga_arena *mem)
{
    struct places p;
    find_places(l, &p, mem);
    size_t f = (size_t)p.count, size = f + (size_t)p.constraints;
    double *K = sga_zeros(mem, size * size + 1, sizeof *K), *b = sga_zeros(mem, size + 1, sizeof *b), *z = sga_zeros(mem, size + 1, sizeof *z), most = 0;
    memset(l->lambda, 0, (size_t)l->c * sizeof *l->lambda);
    for (size_t a = 0; a < f; a++) {
        int k = p.moves[a];
        K[a * size + a] = 1;
        b[a] = -pull[k] * l->unit[k];
        most = fmax(most, fabs(b[a]));
        for (size_t i = f; i < size; i++)
            K[a * size + i] = K[i * size + a] = l->J[p.constraint[i - f] * l->n + k] * l->unit[k] / p.size[i - f];
    }
    if (most <= floor)
        return true;
    if (!dependent_solve(K, b, z, (int)size, AGREE * most))
        return false;
    for (size_t a = 0; a < f; a++)
        if (fabs(z[a]) > LEAST_MISSED * most + floor)
            return false;
    for (size_t i = f; i < size; i++)
        l->lambda[p.constraint[i - f]] = z[i] / p.size[i - f];
    return true;
}

bool least_solve(const struct least_move *l, const double *W, const double *push, const double *by, int step, double *s, struct sga_arena *mem)
{
    struct places p;
    find_places(l, &p, mem);
    size_t f = (size_t)p.count, size = f + (size_t)p.constraints, n = (size_t)l->n;
    double *K = sga_zeros(mem, size * size + 1, sizeof *K), *b = sga_zeros(mem, size + 1, sizeof *b), *z = sga_zeros(mem, size + 1, sizeof *z), most = DBL_MIN;
    for (size_t a = 0; a < f; a++) {
        size_t k = (size_t)p.moves[a];
        b[a] = push[k];
        for (size_t m = 0; m < n; m++)
            b[a] -= l->free[m] ? 0 : l->H[k * n + m] * s[m];
        for (size_t c = 0; c < f; c++)
            K[a * size + c] = (W[k * n + (size_t)p.moves[c]] + l->H[k * n + (size_t)p.moves[c]]) * l->unit[k] * l->unit[p.moves[c]];
        b[a] *= l->unit[k];
        most = fmax(most, fabs(b[a]));
    }
    for (size_t i = f; i < size; i++) {
        size_t row = (size_t)p.constraint[i - f];
        double sum = -by[row * (size_t)step], terms = fabs(sum);
        for (size_t a = 0; a < f; a++)
            K[a * size + i] = K[i * size + a] = l->J[row * n + (size_t)p.moves[a]] * l->unit[p.moves[a]] / p.size[i - f];
        for (size_t m = 0; m < n; m++) {
            sum -= l->free[m] ? 0 : l->J[row * n + m] * s[m];
            terms += l->free[m] ? 0 : fabs(l->J[row * n + m] * s[m]);
        }
        b[i] = sum / p.size[i - f];
        most = fmax(most, terms / p.size[i - f]);
    }
    if (!dependent_solve(K, b, z, (int)size, AGREE * most))
        return false;
    for (size_t a = 0; a < f; a++)
        s[p.moves[a]] = z[a] * l->unit[p.moves[a]];
    return true;
}
