/* Shifted systems; see the header. KLU is given our rows, that is the transpose, and
 * solves with the transpose of it. */
#include "lin_shift.h"

#include <assert.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <suitesparse/klu.h>

#include "arena.h"
#include "lin_sparse.h"
#include "mem.h"

#define DENSE_ALWAYS 30        /* unknowns up to which elimination is dense */
#define DENSE_FULL 600         /* and if a quarter of the entries are there */
#define LARGEST_GROWTH 1e3     /* of entries, with the pivots of an earlier factorisation */
#define FAR_APART 40           /* log2: sizes that are taken for one */
#define UNIT_MOST 500          /* log2: products of two hold in a double */

struct factor {
    double *a;                 /* dense: the factors, pairs of numbers if complex */
    int *pivot;
    klu_numeric *numeric;
    double *val;               /* sparse: the matrix */
};

struct lin_shift {
    int n;
    struct lin_sparse *J;      /* the pattern */
    bool dense;
    struct lin_sparse *M;      /* J's pattern and the diagonal */
    int *place, *diagonal;     /* in M, of J's entries and of the diagonal */
    klu_common common;
    klu_symbolic *symbolic;
    struct factor factor[LIN_SHIFTS];
    int *unit;                 /* by unknown: log2 of its unit; NULL: all 1 */
    double *scaled;            /* J in these units */
    const double *mass;        /* M in the order of J's entries; NULL: 1 */
    double *scaled_mass;
};

static void order(struct lin_shift *s)
{
    int n = s->n, nnz = s->J->ptr[n], count = nnz + n;
    SGA_FREED int *row = sga_malloc(((size_t)count + 1) * sizeof *row);
    int *col = sga_malloc(((size_t)count + 1) * sizeof *col);
    int *place = sga_malloc(((size_t)count + 1) * sizeof *place);
    for (int i = 0; i < n; i++) {
        for (int k = s->J->ptr[i]; k < s->J->ptr[i + 1]; k++) {
            row[k] = i;
            col[k] = s->J->col[k];
        }
        row[nnz + i] = col[nnz + i] = i;
    }
    s->M = lin_sparse_from_entries(n, n, count, row, col, place);
    s->place = place;
    s->diagonal = place + nnz;
    free(col);
    klu_defaults(&s->common);
    s->symbolic = klu_analyze(n, s->M->ptr, s->M->col, &s->common);
}

struct lin_shift *lin_shift_new(const struct lin_sparse *pattern)
{
    assert(pattern->rows == pattern->cols);
    struct lin_shift *s = sga_calloc(1, sizeof *s);
    int n = s->n = pattern->rows;
    s->J = lin_sparse_new(n, n, pattern->ptr, pattern->col);
    s->dense = n <= DENSE_ALWAYS || (n <= DENSE_FULL && (double)pattern->ptr[n] > 0.25 * n * n);
    if (!s->dense)
        order(s);
    return s;
}

void lin_shift_free(struct lin_shift *s)
{
    if (!s)
        return;
    for (int k = 0; k < LIN_SHIFTS; k++) {
        struct factor *f = s->factor + k;
        free(f->a);
        free(f->pivot);
        free(f->val);
        if (f->numeric && k == 0)
            klu_free_numeric(&f->numeric, &s->common);
        else if (f->numeric)
            klu_z_free_numeric(&f->numeric, &s->common);
    }
    if (s->symbolic)
        klu_free_symbolic(&s->symbolic, &s->common);
    free(s->unit);
    free(s->scaled);
    free(s->scaled_mass);
    lin_sparse_free(s->J);
    lin_sparse_free(s->M);
    free(s->place);
    free(s);
}

static void swap_rows(double *a, int width, int i, int j)
{
    for (int c = 0; i != j && c < width; c++) {
        double x = a[(size_t)i * (size_t)width + (size_t)c];
        a[(size_t)i * (size_t)width + (size_t)c] = a[(size_t)j * (size_t)width + (size_t)c];
        a[(size_t)j * (size_t)width + (size_t)c] = x;
    }
}

static bool dense_real(double *a, int *pivot, int n)
{
    size_t m = (size_t)n;
    for (int k = 0; k < n; k++) {
        int p = k;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[(size_t)i * m + (size_t)k]) > fabs(a[(size_t)p * m + (size_t)k]))
                p = i;
        pivot[k] = p;
        swap_rows(a, n, k, p);
        const double *top = a + (size_t)k * m;
        if (!(fabs(top[k]) > 0))
            return false;
        for (int i = k + 1; i < n; i++) {
            double *row = a + (size_t)i * m, q = row[k] / top[k];
            row[k] = q;
            if (q != 0)
                for (int j = k + 1; j < n; j++)
                    row[j] -= q * top[j];
        }
    }
    return true;
}

static void dense_real_solve(const double *a, const int *pivot, int n, double *b)
{
    for (int k = 0; k < n; k++)
        swap_rows(b, 1, k, pivot[k]);
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++)
            b[i] -= a[(size_t)i * (size_t)n + (size_t)j] * b[j];
    for (int i = n - 1; i >= 0; i--) {
        for (int j = i + 1; j < n; j++)
            b[i] -= a[(size_t)i * (size_t)n + (size_t)j] * b[j];
        b[i] /= a[(size_t)i * (size_t)n + (size_t)i];
    }
}

/* x / y, scaled against overflow (Smith). */
static void divide(const double *x, const double *y, double *q)
{
    if (fabs(y[0]) >= fabs(y[1])) {
        double r = y[1] / y[0], d = y[0] + y[1] * r, re = (x[0] + x[1] * r) / d;
        q[1] = (x[1] - x[0] * r) / d;
        q[0] = re;
    } else {
        double r = y[0] / y[1], d = y[0] * r + y[1], re = (x[0] * r + x[1]) / d;
        q[1] = (x[1] * r - x[0]) / d;
        q[0] = re;
    }
}

/* y -= q x over pairs */
static inline void eliminate(double *y, const double *q, const double *x, int pairs)
{
    for (int j = 0; j < pairs; j++) {
        y[2 * j] -= q[0] * x[2 * j] - q[1] * x[2 * j + 1];
        y[2 * j + 1] -= q[0] * x[2 * j + 1] + q[1] * x[2 * j];
    }
}

static bool dense_complex(double *a, int *pivot, int n)
{
    size_t width = 2 * (size_t)n;
    for (int k = 0; k < n; k++) {
        int p = k;
        double most = -1;
        for (int i = k; i < n; i++) {
            const double *e = a + (size_t)i * width + 2 * (size_t)k;
            double size = fabs(e[0]) + fabs(e[1]);
            if (size > most) {
                most = size;
                p = i;
            }
        }
        pivot[k] = p;
        if (!(most > 0))
            return false;
        swap_rows(a, 2 * n, k, p);
        const double *top = a + (size_t)k * width + 2 * (size_t)k;
        for (int i = k + 1; i < n; i++) {
            double *row = a + (size_t)i * width + 2 * (size_t)k;
            if (row[0] == 0 && row[1] == 0)
                continue;
            divide(row, top, row);
            eliminate(row + 2, row, top + 2, n - k - 1);
        }
    }
    return true;
}

static void dense_complex_solve(const double *a, const int *pivot, int n, double *b)
{
    size_t width = 2 * (size_t)n;
    for (int k = 0; k < n; k++)
        swap_rows(b, 2, k, pivot[k]);
    for (int i = 1; i < n; i++)
        for (int j = 0; j < i; j++)
            eliminate(b + 2 * i, a + (size_t)i * width + 2 * (size_t)j, b + 2 * j, 1);
    for (int i = n - 1; i >= 0; i--) {
        const double *row = a + (size_t)i * width;
        for (int j = i + 1; j < n; j++)
            eliminate(b + 2 * i, row + 2 * j, b + 2 * j, 1);
        divide(b + 2 * i, row + 2 * i, b + 2 * i);
    }
}

/* M's values as a factorisation takes them. */
static const double *mass_values(const struct lin_shift *s)
{
    return s->unit && s->mass ? s->scaled_mass : s->mass;
}

static bool factor_dense(struct lin_shift *s, int k, double re, double im, const double *val)
{
    const double *mass = mass_values(s);
    struct factor *f = s->factor + k;
    size_t n = (size_t)s->n, parts = k ? 2 : 1;
    if (!f->a) {
        f->a = sga_malloc((parts * n * n + 1) * sizeof *f->a);
        f->pivot = sga_malloc((n + 1) * sizeof *f->pivot);
    }
    memset(f->a, 0, parts * n * n * sizeof *f->a);
    for (size_t i = 0; i < n; i++) {
        for (int e = s->J->ptr[i]; e < s->J->ptr[i + 1]; e++)
            f->a[parts * (i * n + (size_t)s->J->col[e])] = -val[e];
        for (int e = s->J->ptr[i]; mass && e < s->J->ptr[i + 1]; e++) {
            f->a[parts * (i * n + (size_t)s->J->col[e])] += re * mass[e];
            if (k)
                f->a[2 * (i * n + (size_t)s->J->col[e]) + 1] = im * mass[e];
        }
        if (mass)
            continue;
        f->a[parts * (i * n + i)] += re;
        if (k)
            f->a[2 * (i * n + i) + 1] += im;
    }
    return k ? dense_complex(f->a, f->pivot, s->n) : dense_real(f->a, f->pivot, s->n);
}

/* Refactoring does not look at blocks of one row. */
static bool some_pivot_zero(const double *d, int n, int parts)
{
    for (int i = 0; i < n; i++)
        if (d[parts * i] == 0 && (parts == 1 || d[2 * i + 1] == 0))
            return true;
    return false;
}

static bool old_pivots(struct lin_shift *s, struct factor *f, bool complex_values)
{
    int *p = s->M->ptr, *c = s->M->col;
    klu_common *common = &s->common;
    bool ok = complex_values ? klu_z_refactor(p, c, f->val, s->symbolic, f->numeric, common) &&
                                   klu_z_rgrowth(p, c, f->val, s->symbolic, f->numeric, common)
                             : klu_refactor(p, c, f->val, s->symbolic, f->numeric, common) &&
                                   klu_rgrowth(p, c, f->val, s->symbolic, f->numeric, common);
    ok = ok && !some_pivot_zero(f->numeric->Udiag, s->n, complex_values ? 2 : 1);
    return ok && common->status == KLU_OK && common->rgrowth * LARGEST_GROWTH > 1;
}

static bool factor_sparse(struct lin_shift *s, int k, double re, double im, const double *val)
{
    struct factor *f = s->factor + k;
    const double *mass = mass_values(s);
    int n = s->n, entries = s->M->ptr[n], parts = k ? 2 : 1;
    if (!s->symbolic)
        return false;
    if (!f->val)
        f->val = sga_malloc(((size_t)parts * (size_t)entries + 1) * sizeof *f->val);
    memset(f->val, 0, (size_t)parts * (size_t)entries * sizeof *f->val);
    for (int e = 0; e < s->J->ptr[n]; e++)
        f->val[parts * s->place[e]] = -val[e];
    for (int e = 0; mass && e < s->J->ptr[n]; e++) {
        f->val[parts * s->place[e]] += re * mass[e];
        if (k)
            f->val[2 * s->place[e] + 1] = im * mass[e];
    }
    for (int i = 0; i < n && !mass; i++) {
        f->val[parts * s->diagonal[i]] += re;
        if (k)
            f->val[2 * s->diagonal[i] + 1] += im;
    }
    if (f->numeric && old_pivots(s, f, k > 0))
        return true;
    if (k) {
        if (f->numeric)
            klu_z_free_numeric(&f->numeric, &s->common);
        f->numeric = klu_z_factor(s->M->ptr, s->M->col, f->val, s->symbolic, &s->common);
    } else {
        if (f->numeric)
            klu_free_numeric(&f->numeric, &s->common);
        f->numeric = klu_factor(s->M->ptr, s->M->col, f->val, s->symbolic, &s->common);
    }
    return f->numeric && s->common.status == KLU_OK;
}

bool lin_shift_factor(struct lin_shift *s, int k, double re, double im, const double *val)
{
    assert(k >= 0 && k < LIN_SHIFTS && (k > 0 || im == 0));
    if (s->n == 0)
        return true;
    if (!isfinite(re) || !isfinite(im))
        return false;
    for (int i = 0; s->unit && i < s->n; i++)
        for (int e = s->J->ptr[i]; e < s->J->ptr[i + 1]; e++)
            s->scaled[e] = ldexp(val[e], s->unit[s->J->col[e]] - s->unit[i]);
    for (int i = 0; s->unit && s->mass && i < s->n; i++)
        for (int e = s->J->ptr[i]; e < s->J->ptr[i + 1]; e++)
            s->scaled_mass[e] = ldexp(s->mass[e], s->unit[s->J->col[e]] - s->unit[i]);
    val = s->unit ? s->scaled : val;
    if (!lin_all_finite(s->J->ptr[s->n], val) || (s->mass && !lin_all_finite(s->J->ptr[s->n], mass_values(s))))
        return false;
    return s->dense ? factor_dense(s, k, re, im, val) : factor_sparse(s, k, re, im, val);
}

/* Numbers (pairs for k > 0) from units, or into them (way: 1, -1). */
static void change_units(const struct lin_shift *s, int k, int way, double *b)
{
    int parts = k ? 2 : 1;
    for (int i = 0; s->unit && i < parts * s->n; i++)
        b[i] = ldexp(b[i], way * s->unit[i / parts]);
}

void lin_shift_solve(struct lin_shift *s, int k, double *b)
{
    struct factor *f = s->factor + k;
    if (s->n == 0)
        return;
    change_units(s, k, -1, b);
    if (s->dense && k == 0)
        dense_real_solve(f->a, f->pivot, s->n, b);
    else if (s->dense)
        dense_complex_solve(f->a, f->pivot, s->n, b);
    else if (k == 0)
        klu_tsolve(s->symbolic, f->numeric, s->n, 1, b, &s->common);
    else
        klu_z_tsolve(s->symbolic, f->numeric, s->n, 1, b, 0, &s->common);
    change_units(s, k, 1, b);
}

void lin_shift_mass(struct lin_shift *s, const double *mass)
{
    s->mass = mass;
    if (mass && !s->scaled_mass)
        s->scaled_mass = sga_malloc(((size_t)s->J->ptr[s->n] + 1) * sizeof *s->scaled_mass);
}

void lin_shift_sizes(struct lin_shift *s, const double *size)
{
    int least = INT_MAX, most = INT_MIN;
    for (int i = 0; i < s->n; i++) {
        int e = ilogb(size[i]);
        least = e < least ? e : least;
        most = e > most ? e : most;
    }
    bool far = s->n > 0 && most - least > FAR_APART && least > -1100 && most < 1100;
    if (!far) {
        free(s->unit);
        s->unit = NULL;
        return;
    }
    if (!s->unit)
        s->unit = sga_malloc(((size_t)s->n + 1) * sizeof *s->unit);
    if (!s->scaled)
        s->scaled = sga_malloc(((size_t)s->J->ptr[s->n] + 1) * sizeof *s->scaled);
    for (int i = 0; i < s->n; i++) {
        int e = ilogb(size[i]) - (least + most) / 2;
        s->unit[i] = e > UNIT_MOST ? UNIT_MOST : e < -UNIT_MOST ? -UNIT_MOST : e;
    }
}

/* 1 where the permutation is even. */
static int parity(const int *p, int n)
{
    SGA_FREED unsigned char *seen = sga_calloc((size_t)n + 1, 1);
    int sign = 1;
    for (int i = 0; i < n; i++)
        for (int j = i, length = 0; !seen[j]; j = p[j], length++) {
            seen[j] = 1;
            sign = length > 0 ? -sign : sign;
        }
    return sign;
}

int lin_shift_sign(const struct lin_shift *s)
{
    const struct factor *f = s->factor;
    int sign = 1;
    for (int i = 0; s->dense && i < s->n; i++) {
        double d = f->a[(size_t)i * (size_t)s->n + (size_t)i];
        sign = (d < 0) != (f->pivot[i] != i) ? -sign : sign;
    }
    if (s->dense || s->n == 0)
        return sign;
    const double *d = f->numeric->Udiag;
    for (int i = 0; i < s->n; i++)
        sign = d[i] < 0 ? -sign : sign;
    return sign * parity(f->numeric->Pnum, s->n) * parity(s->symbolic->Q, s->n);
}

/* Entries of both factors. */
static double fill(const struct lin_shift *s)
{
    const klu_numeric *f = s->factor[0].numeric;
    return f ? (double)f->lnz + f->unz : 2.0 * s->M->ptr[s->n];
}

double lin_shift_cost(const struct lin_shift *s)
{
    double n = s->n;
    return s->dense ? n * n * n / 3 : fill(s) * fmax(1, fill(s) / (2 * fmax(1, n)));
}

double lin_shift_solve_cost(const struct lin_shift *s)
{
    return s->dense ? (double)s->n * s->n : fill(s);
}
