/* The start of the derivatives of a motion, where linear equations have it: the tangents of the constraints, and what stays where it was given. */
#include "variation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "field.h"
#include "jacobian.h"
#include "kinds.h"
#include "leastnorm.h"
#include "mem.h"
#include "tape.h"

/* A given value stayed if it is the start's up to this, relative to 1 + its size; equations hold if they are missed by no more than this beside
 * the sizes of their terms. */
static const double STAYED = 1e-13, MISSED = 1e-11;

bool variation_constants(const struct expr_store *st, const expr_id *e, int count, double *value)
{
    struct sga_error ignored = { 0 };
    struct num_tape *tape = num_tape_new(st, e, count, NULL, 0, &ignored);
    bool ok = tape && num_tape_eval(tape, NULL, value);
    num_tape_free(tape);
    return ok;
}

/* The tangent equations J s = -b of the constraints at the start. */
struct tangents {
    int n, rows, directions;
    double *J, *b;             /* rows x n; rows x directions */
};

static bool tangents_at(struct tangents *q, const struct sys_system *sys, const struct sga_solution *sol, double t, const double *in, struct sga_arena *mem)
{
    int all = sys->variables, n = q->n, c = sol->constraints;
    q->rows = c / (1 + q->directions);
    q->J = sga_zeros(mem, (size_t)q->rows * (size_t)n + 1, sizeof *q->J);
    q->b = sga_zeros(mem, (size_t)c + 1, sizeof *q->b);
    expr_id *root = sga_take(mem, ((size_t)c + 1) * sizeof *root);
    double *at = sga_zeros(mem, (size_t)all + 1, sizeof *at), *out = sga_zeros(mem, (size_t)c + 1, sizeof *out);
    for (int i = 0; i < c; i++)
        root[i] = sol->constraint[i].expr;
    memcpy(at, in, (size_t)n * sizeof *at);
    at[all] = t;
    SGA_FREED int *inputs = field_inputs(sys);
    struct sga_error ignored = { 0 };
    struct num_tape *tape = num_tape_new(sys->store, root, c, inputs, all + 1, &ignored);
    struct num_jacobian *jac = tape ? num_jacobian_new(tape, NULL, 0) : NULL;
    double *value = sga_zeros(mem, (size_t)(jac ? jac->nnz : 0) + 1, sizeof *value);
    bool ok = jac && num_jacobian_eval(jac, at, out, value);
    for (int i = 0; i < q->rows && ok; i++) {
        int row = i * (1 + q->directions);
        for (int k = jac->start[row]; k < jac->start[row + 1]; k++)
            if (jac->col[k] < n)
                q->J[(size_t)i * (size_t)n + (size_t)jac->col[k]] = value[k];
        for (int d = 0; d < q->directions; d++)
            q->b[i * q->directions + d] = out[row + 1 + d];
    }
    num_jacobian_free(jac);
    num_tape_free(tape);
    return ok;
}

/* s (directions x n) with J s = -b and s = g where it stays; whether there is exactly one. */
static bool determined(const struct tangents *q, const unsigned char *stays, const double *g, double *s, struct sga_arena *mem)
{
    size_t n = (size_t)q->n;
    int m = q->rows;
    for (int j = 0; j < q->n; j++)
        m += stays[j];
    double *M = sga_zeros(mem, (size_t)m * n + 1, sizeof *M), *size = sga_zeros(mem, (size_t)m + 1, sizeof *size), *rhs = sga_zeros(mem, (size_t)m + 1, sizeof *rhs);
    double *qr = sga_zeros(mem, ((size_t)m + 1) * ((size_t)m + 1), sizeof *qr);
    int *perm = sga_zeros(mem, (size_t)m + 1, sizeof *perm), row = q->rows;
    for (int i = 0; i < q->rows; i++) {
        for (size_t j = 0; j < n; j++)
            size[i] = fmax(size[i], fabs(q->J[(size_t)i * n + j]));
        for (size_t j = 0; j < n && size[i] > 0; j++)
            M[(size_t)i * n + j] = q->J[(size_t)i * n + j] / size[i];
    }
    for (int j = 0; j < q->n; j++)
        if (stays[j])
            M[(size_t)row++ * n + (size_t)j] = 1;
    if (points_least_norm_factor(m, q->n, M, perm, qr) < q->n)
        return false;
    bool ok = true;
    for (int d = 0; d < q->directions && ok; d++) {
        double *to = s + (size_t)d * n;
        for (int i = 0; i < q->rows; i++)
            rhs[i] = size[i] > 0 ? q->b[i * q->directions + d] / size[i] : 0;
        row = q->rows;
        for (int j = 0; j < q->n; j++)
            if (stays[j])
                rhs[row++] = -g[(size_t)d * n + (size_t)j];
        points_least_norm_solve(m, q->n, M, q->n, perm, qr, rhs, to);
        double largest = 0;
        for (size_t j = 0; j < n; j++)
            largest = fmax(largest, fabs(to[j]));
        for (int i = 0; i < q->rows && ok; i++) {
            double sum = q->b[i * q->directions + d], terms = fabs(sum) + size[i] * largest;
            for (size_t j = 0; j < n; j++)
                sum += q->J[(size_t)i * n + j] * to[j];
            ok = fabs(sum) <= MISSED * terms;
        }
        for (int j = 0; j < q->n && ok; j++)
            ok = isfinite(to[j]) && (!stays[j] || fabs(to[j] - g[(size_t)d * n + (size_t)j]) <= MISSED * (1 + fabs(to[j])));
    }
    return ok;
}

/* What stays: given values; and, where they do not say everything, zeros of coordinates and velocities that were not given. */
static bool find_stays(const struct tangents *q, const struct variation *v, const struct sys_system *sys, const double *x, const double *g, unsigned char *stays, double *s,
                       struct sga_arena *mem)
{
    unsigned char *kind = sga_zeros(mem, (size_t)sys->variables + 1, 1);
    sys_kinds(sys, kind);
    for (int j = 0; j < q->n; j++)
        stays[j] = (v->guessed[j] || v->kept[j]) && fabs(x[j] - v->guess[j]) <= STAYED * (1 + fabs(x[j]));
    if (determined(q, stays, g, s, mem))
        return true;
    for (int j = 0; j < q->n; j++)
        stays[j] |= !v->guessed[j] && !v->kept[j] && fabs(x[j]) <= STAYED && (kind[j] == SYS_COORDINATE || kind[j] == SYS_VELOCITY);
    return determined(q, stays, g, s, mem);
}

bool variation_place(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, struct traj_request *rq, const double *whole)
{
    size_t n = (size_t)v->n, q = (size_t)v->directions;
    SGA_ARENA(mem);
    double *x = sga_zeros(&mem, n + 1, sizeof *x), *g = sga_zeros(&mem, n * q + 1, sizeof *g), *s = sga_zeros(&mem, n * q + 1, sizeof *s);
    unsigned char *stays = sga_zeros(&mem, n + 1, 1);
    for (int i = 0; v->of_defined && i < v->defined.sol->definitions; i++)
        if (v->defined.rq->given[v->defined.sol->definition[i].variable])
            return false;
    for (size_t j = 0; j < n; j++)
        x[j] = whole[v->of_defined ? v->defined.variable[j] : (int)j];
    struct tangents at = { .n = v->n, .directions = v->directions };
    if (!variation_constants(sys->store, rq->exact_initial + n, (int)(n * q), g) || !tangents_at(&at, sys, sol, rq->start, x, &mem) || !find_stays(&at, v, sys, x, g, stays, s, &mem))
        return false;
    for (size_t i = 0; i < n * (1 + q); i++)
        v->initial[i] = i >= n ? s[i - n] : stays[i] && v->guessed[i] ? v->guess[i] : x[i];
    /* in double the rest is what it is already; longer numbers solve for it */
    for (size_t i = 0; i < n * (1 + q); i++) {
        v->held[i] = rq->arithmetic == TRAJ_DOUBLE_DOUBLE && stays[i % n];
        v->given[i] = rq->arithmetic != TRAJ_DOUBLE_DOUBLE || stays[i % n];
    }
    return true;
}

void variation_place_at(struct variation *v, struct traj_request *rq, const double *whole, const double *slope)
{
    size_t n = (size_t)v->n, all = n * (size_t)(1 + v->directions), variables = v->of_defined ? (size_t)v->defined.sys->variables : n;
    for (size_t i = 0; i < all; i++) {
        size_t j = v->of_defined ? (size_t)v->defined.variable[i % n] : i % n;
        v->initial[i] = i < n ? whole[j] : slope[(i / n - 1) * variables + j];
        v->given[i] = 1;
        v->held[i] = 0;
    }
    rq->exact_initial = NULL;
}
