/* Places where constraints cross themselves, by augmented systems. */
#include "crossing_place.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_linalg.h>

#include "field.h"
#include "flow.h"
#include "jacobian.h"
#include "mem.h"
#include "tape.h"

enum { TURNS = 8 };
/* What is no direction, by the largest; differences; the last step; what is left of gradients, and of constraints, in roundings. */
static const double NONE = 1e-9, STEP = 1e-5, SETTLED = 1e-9, SMALL = 1e-6, LEFT = 1e-7, ROUNDINGS = 32;

struct place {
    struct flow *f;
    double *unit;             /* n */
    int n, c;                 /* unknowns without u: variables and time; constraints */
    double *J, *xi;           /* c x n; c: of the last look, in the combinations W */
    double *W, *noise;        /* c x c: with them the gradients are orthonormal far from the place, whatever rows are asked; c: the roundings of these; */
    double *plain, *row;      /* c x n; c: as they are */
    bool whitened;
};

static bool look(struct place *p, const double *z)
{
    struct field *f = p->f->field;
    int n = p->n, c = p->c;
    memset(p->plain, 0, (size_t)c * (size_t)n * sizeof *p->plain);
    field_load(f, z[n - 1], z);
    if (!num_jacobian_eval(f->jac, f->in, NULL, f->jac_value) || !num_tape_eval(f->con, f->in, p->row))
        return false;
    for (int i = 0; i < c; i++)
        for (int k = f->jac->start[i]; k < f->jac->start[i + 1]; k++)
            p->plain[i * n + f->jac->col[k]] = f->jac_value[k] * p->unit[f->jac->col[k]];
    for (int i = 0; i < c && p->whitened; i++) {
        p->xi[i] = 0;
        memset(p->J + (size_t)i * (size_t)n, 0, (size_t)n * sizeof *p->J);
        for (int k = 0; k < c; k++) {
            p->xi[i] += p->W[i * c + k] * p->row[k];
            for (int j = 0; j < n; j++)
                p->J[i * n + j] += p->W[i * c + k] * p->plain[k * n + j];
        }
    }
    return true;
}

/* W = S^-1 U^T of the gradients U S V^T at `far`; its roundings, by the terms that constraints of gradients like these have. */
static bool whiten(struct place *p, const double *far)
{
    size_t n = (size_t)p->n, c = (size_t)p->c;
    if (n < c || !look(p, far))
        return false;
    gsl_matrix *a = gsl_matrix_alloc(n, c), *v = gsl_matrix_alloc(c, c);
    gsl_vector *s = gsl_vector_alloc(c), *w = gsl_vector_alloc(c);
    double *big = sga_calloc(c + 1, sizeof *big), most = 1;
    for (size_t j = 0; j < n; j++)
        most = fmax(most, j + 1 < n ? fabs(far[j]) / p->unit[j] : 0);
    for (size_t i = 0; i < c; i++)
        for (size_t j = 0; j < n; j++) {
            gsl_matrix_set(a, j, i, p->plain[i * n + j]);
            big[i] = fmax(big[i], fabs(p->plain[i * n + j]));
        }
    bool ok = gsl_linalg_SV_decomp(a, v, s, w) == 0 && gsl_vector_get(s, c - 1) > 0;
    for (size_t i = 0; i < c && ok; i++) {
        p->noise[i] = 0;
        for (size_t k = 0; k < c; k++) {
            p->W[i * c + k] = gsl_matrix_get(v, k, i) / gsl_vector_get(s, i);
            p->noise[i] += fabs(p->W[i * c + k]) * big[k] * most * DBL_EPSILON;
        }
    }
    p->whitened = ok;
    gsl_matrix_free(a);
    gsl_matrix_free(v);
    gsl_vector_free(s);
    gsl_vector_free(w);
    free(big);
    return ok;
}

static void dependence(const struct place *p, const double *u, double *g)
{
    for (int j = 0; j < p->n; j++) {
        g[j] = 0;
        for (int i = 0; i < p->c; i++)
            g[j] += u[i] * p->J[i * p->n + j];
    }
}

/* u: what makes the gradients' sum least. */
static bool least_dependence(const struct place *p, double *u)
{
    size_t n = (size_t)p->n, c = (size_t)p->c;
    if (n < c)
        return false;
    gsl_matrix *a = gsl_matrix_alloc(n, c), *v = gsl_matrix_alloc(c, c);
    gsl_vector *s = gsl_vector_alloc(c), *w = gsl_vector_alloc(c);
    for (size_t j = 0; j < n; j++)
        for (size_t i = 0; i < c; i++)
            gsl_matrix_set(a, j, i, p->J[i * n + j]);
    bool ok = gsl_linalg_SV_decomp(a, v, s, w) == 0;
    for (size_t i = 0; i < c; i++)
        u[i] = gsl_matrix_get(v, i, c - 1);
    gsl_matrix_free(a);
    gsl_matrix_free(v);
    gsl_vector_free(s);
    gsl_vector_free(w);
    return ok;
}

/* The least step (dz in units, du) that meets the equations best at z. */
static bool best_step(struct place *p, const double *z, const double *u, const double *g, gsl_matrix *a, gsl_vector *d)
{
    int n = p->n, c = p->c;
    size_t cols = (size_t)(n + c);
    gsl_matrix *v = gsl_matrix_alloc(cols, cols);
    gsl_vector *s = gsl_vector_alloc(cols), *w = gsl_vector_alloc(cols), *b = gsl_vector_alloc(cols + 1);
    double *at = sga_malloc(((size_t)n * 3 + 1) * sizeof *at), *more = at + n, *less = more + n, uu = 0;
    bool ok = true;
    gsl_matrix_set_zero(a);
    for (int i = 0; i < c; i++) {
        for (int j = 0; j < n; j++) {
            gsl_matrix_set(a, (size_t)i, (size_t)j, p->J[i * n + j]);
            gsl_matrix_set(a, (size_t)(c + j), (size_t)(n + i), p->J[i * n + j]);
        }
        gsl_vector_set(b, (size_t)i, -p->xi[i]);
        gsl_matrix_set(a, (size_t)(c + n), (size_t)(n + i), 2 * u[i]);
        uu += u[i] * u[i];
    }
    for (int j = 0; j < n; j++)
        gsl_vector_set(b, (size_t)(c + j), -g[j]);
    gsl_vector_set(b, (size_t)(c + n), 1 - uu);
    for (int k = 0; k < n && ok; k++) {
        memcpy(at, z, (size_t)n * sizeof *at);
        at[k] = z[k] + STEP * p->unit[k];
        ok = look(p, at);
        dependence(p, u, more);
        at[k] = z[k] - STEP * p->unit[k];
        ok = ok && look(p, at);
        dependence(p, u, less);
        for (int j = 0; j < n && ok; j++)
            gsl_matrix_set(a, (size_t)(c + j), (size_t)k, (more[j] - less[j]) / (2 * STEP));
    }
    ok = ok && gsl_linalg_SV_decomp(a, v, s, w) == 0;
    for (size_t k = 0; k < cols && ok; k++)
        if (gsl_vector_get(s, k) <= NONE * gsl_vector_get(s, 0))
            gsl_vector_set(s, k, 0);
    ok = ok && gsl_linalg_SV_solve(a, v, s, b, d) == 0;
    gsl_matrix_free(v);
    gsl_vector_free(s);
    gsl_vector_free(w);
    gsl_vector_free(b);
    free(at);
    return ok;
}

bool crossing_place(struct flow *f, const double *unit, double time, const double *far, double *z)
{
    struct place p = { .f = f, .n = f->n + 1, .c = f->field->c };
    size_t n = (size_t)p.n, c = (size_t)p.c;
    double *u = sga_calloc(c + n + 1, sizeof *u), *g = u + c, step = INFINITY, slopes = 0;
    p.unit = sga_malloc((n + 1) * sizeof *p.unit);
    p.J = sga_calloc(2 * (c * n + 1) + c * c + 3 * c, sizeof *p.J);
    p.plain = p.J + c * n;
    p.W = p.plain + c * n;
    p.noise = p.W + c * c;
    p.xi = p.noise + c;
    p.row = p.xi + c;
    memcpy(p.unit, unit, (n - 1) * sizeof *unit);
    p.unit[n - 1] = time;
    gsl_matrix *a = gsl_matrix_alloc(c + n + 1, c + n);
    gsl_vector *d = gsl_vector_alloc(c + n);
    bool ok = whiten(&p, far) && look(&p, z) && least_dependence(&p, u);
    for (int turn = 0; turn < TURNS && ok && step > SETTLED; turn++) {
        ok = look(&p, z);
        dependence(&p, u, g);
        ok = ok && best_step(&p, z, u, g, a, d);
        step = 0;
        for (size_t j = 0; j < n && ok; j++) {
            z[j] += gsl_vector_get(d, j) * p.unit[j];
            step = fmax(step, fabs(gsl_vector_get(d, j)));
        }
        for (size_t i = 0; i < c && ok; i++)
            u[i] += gsl_vector_get(d, n + i);
    }
    ok = ok && step <= SMALL && look(&p, z);
    dependence(&p, u, g);
    for (size_t j = 0; j < n && ok; j++)
        slopes = fmax(slopes, fabs(g[j]));
    ok = ok && slopes <= LEFT;
    for (size_t i = 0; i < c && ok; i++)
        ok = fabs(p.xi[i]) <= ROUNDINGS * p.noise[i];
    gsl_matrix_free(a);
    gsl_vector_free(d);
    free(p.unit);
    free(p.J);
    free(u);
    return ok;
}
