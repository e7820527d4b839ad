/* The field from its defining rows: the equations, the tangencies of the constraints and the rates, in least norm.
 *
 * Where the matrix of the rows is the same as before (linear systems with constant coefficients, such as discretised
 * partial differential equations), its factors are too: they are kept, and only the right side is new. */
#include "field.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "definition.h"
#include "jacobian.h"
#include "kinds.h"
#include "larger.h"
#include "leastnorm.h"
#include "mem.h"
#include "system.h"
#include "tape.h"
#include "told.h"
#include "watch.h"
#include "whole.h"

/* Of a value of the start, beside its size: how far it is from the nearest point. */
static const double FOUND = 1e-14;
/* And where the start was moved by so much of its size: then the nearest point that the constraints have is often on their fold, which is found to fewer digits. */
static const double FAR_OFF = 1e-3, FOUND_FAR = 1e-10;
/* Of the largest entry: a change over so small a way that is no rounding. */
static const double STEP_SEEN = 1e-8;
enum { FEW_ROWS = 24 };         /* that are solved in no time */
/* Roundings of a row, beside its terms. */
static const double ROUNDED = 64 * DBL_EPSILON;

static void reserve(struct field *f, int m)
{
    size_t rows = (size_t)m + 1, entries = (size_t)f->jac->nnz + 1;
    for (int i = 0; i < f->rows; i++)
        entries += (size_t)f->sys->row[i].entries;
    f->M = f->whole ? NULL : sga_malloc(rows * (size_t)f->n * sizeof *f->M);
    f->rhs = sga_malloc(2 * rows * sizeof *f->rhs);
    f->row_size = f->rhs + rows;
    f->qr = f->whole ? NULL : sga_malloc(rows * rows * sizeof *f->qr);
    f->perm = sga_malloc(rows * sizeof *f->perm);
    f->kept = sga_malloc(entries * sizeof *f->kept);
    f->kept_rank = -1;
}

void field_rows_forget(struct field *f)
{
    free(f->M);
    free(f->rhs);
    free(f->qr);
    free(f->kept);
    free(f->perm);
    f->M = f->rhs = f->qr = f->kept = NULL;
    f->perm = NULL;
}

/* Right sides into f->rhs, with the sign of points_least_norm, matrix entries into f->kept. *same: these are as before. */
static bool evaluate(struct field *f, bool *same)
{
    int at = 0, q = 0;
    *same = f->kept_rank >= 0 && f->kept_unit == f->unit;
    if (!field_general_values(f) || !num_jacobian_eval(f->jac, f->in, NULL, f->jac_value)) {
        f->kept_rank = -1;
        return false;
    }
    for (int i = 0; i < f->rows; i++) {
        for (int k = 0; k < f->sys->row[i].entries; k++, q++) {
            *same &= f->kept[q] == f->general_out[at];
            f->kept[q] = f->general_out[at++];
        }
        f->rhs[i] = -f->general_out[at++];
    }
    for (int i = 0; i < f->c; i++) {
        f->rhs[f->rows + i] = 0;
        for (int k = f->jac->start[i]; k < f->jac->start[i + 1]; k++)
            if (f->jac->col[k] < f->n) {
                *same &= f->kept[q] == f->jac_value[k];
                f->kept[q++] = f->jac_value[k];
            } else {
                f->rhs[f->rows + i] = f->jac_value[k];
            }
    }
    for (int k = 0; k < f->rates; k++)
        f->rhs[f->rows + f->c + k] = -f->general_out[at++];
    assert(at + f->sums == num_tape_roots(f->general));
    return true;
}

/* Of a row of the equations: beside a zero it is this much smaller, however well the place is known. */
static const double VANISHED = 1e-10;

/* f->kept as a dense matrix for v over its units, each row divided by its largest entry. */
static void fill(struct field *f, int m)
{
    const double *unit = f->unit;
    size_t n = (size_t)f->n;
    int q = 0;
    memset(f->M, 0, (size_t)m * n * sizeof *f->M);
    for (int i = 0; i < f->rows; i++)
        for (int k = 0; k < f->sys->row[i].entries; k++)
            f->M[(size_t)i * n + (size_t)f->sys->row[i].entry[k].col] = f->kept[q++];
    for (int i = 0; i < f->c; i++)
        for (int k = f->jac->start[i]; k < f->jac->start[i + 1]; k++)
            if (f->jac->col[k] < f->n)
                f->M[(size_t)(f->rows + i) * n + (size_t)f->jac->col[k]] = f->kept[q++];
    for (int k = 0; k < f->rates; k++)
        f->M[(size_t)(f->rows + f->c + k) * n + (size_t)f->rate[k].variable] = 1;
    for (int i = 0; i < m; i++) {
        double *row = f->M + (size_t)i * n, big = 0;
        for (size_t j = 0; j < n && unit; j++)
            row[j] *= unit[j];
        for (size_t j = 0; j < n; j++)
            big = sga_larger(big, fabs(row[j]));
        f->row_size[i] = big > 0 ? big : 1;
        for (size_t j = 0; j < n; j++)
            row[j] /= f->row_size[i];
    }
}

static int factor(struct field *f, int m)
{
    fill(f, m);
    f->kept_unit = f->unit;
    return points_least_norm_factor(m, f->n, f->M, f->perm, f->qr);
}

/* The rank with each column in a unit of its own, which is that of f->kept without roundings: natural units may be far off. */
static int balanced_rank(struct field *f, int m)
{
    enum { SWEEPS = 3 };
    size_t n = (size_t)f->n;
    double *unit = sga_malloc((n + 1) * sizeof *unit);
    const double *natural = f->unit;
    for (size_t j = 0; j < n; j++)
        unit[j] = natural ? natural[j] : 1;
    f->unit = unit;
    for (int k = 0; k < SWEEPS; k++) {
        fill(f, m);
        for (size_t j = 0; j < n; j++) {
            double big = 0;
            for (size_t i = 0; i < (size_t)m; i++)
                big = sga_larger(big, fabs(f->M[i * n + j]));
            unit[j] /= big > 0 ? big : 1;
        }
    }
    int rank = factor(f, m);
    f->unit = natural;
    f->kept_rank = -1;
    free(unit);
    return rank;
}

static double times(const double *a, const double *b, int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += a[j] * b[j];
    return sum;
}

/* From least norm in units to Euclid's: v without its part along what the rows leave open. */
static void shorten(struct field *f, double *v)
{
    size_t n = (size_t)f->n;
    int open = f->n - f->kept_rank;
    assert(f->kept_rank >= 0 && open > 0);
    double *kernel = sga_malloc(((size_t)open * n + 1) * sizeof *kernel);
    for (int k = 0; k < open; k++) {
        double *d = kernel + (size_t)k * n;
        points_least_norm_kernel(f->n, f->M, f->kept_rank, f->perm, f->qr, k, d);
        for (size_t j = 0; j < n; j++)
            d[j] *= f->kept_unit[j];
        for (int twice = 0; twice < 2; twice++)
            for (int i = 0; i < k; i++) {
                double along = times(d, kernel + (size_t)i * n, f->n);
                for (size_t j = 0; j < n; j++)
                    d[j] -= along * kernel[(size_t)i * n + j];
            }
        double size = sqrt(times(d, d, f->n)), along = times(v, d, f->n) / size;
        for (size_t j = 0; j < n && size > 0; j++) {
            d[j] /= size;
            v[j] -= along * d[j];
        }
    }
    free(kernel);
}

/* What v misses of the rows, each over its size: off (m). Whether that is more than roundings of a row's terms in one of those that v is solved by. */
static bool missed(const struct field *f, int m, const double *v, double *off)
{
    int q = 0;
    SGA_ARENA(mem);
    double *terms = sga_take(&mem, ((size_t)m + 1) * sizeof *terms);
    for (int i = 0; i < m; i++) {
        double sum = f->rhs[i] * f->row_size[i], size = fabs(sum);
        int from = i < f->rows ? 0 : i < f->rows + f->c ? f->jac->start[i - f->rows] : 0;
        int to = i < f->rows ? f->sys->row[i].entries : i < f->rows + f->c ? f->jac->start[i - f->rows + 1] : 1;
        for (int k = from; k < to; k++) {
            int j = i < f->rows ? f->sys->row[i].entry[k].col : i < f->rows + f->c ? f->jac->col[k] : f->rate[i - f->rows - f->c].variable;
            if (j == f->n)
                continue;
            double term = (i < f->rows + f->c ? f->kept[q++] : 1) * v[j];
            sum += term;
            size += fabs(term);
        }
        off[i] = sum / f->row_size[i];
        terms[i] = size / f->row_size[i];
    }
    bool some = false;
    for (int k = 0; k < f->kept_rank; k++)
        some |= fabs(off[f->perm[k]]) > ROUNDED * terms[f->perm[k]];
    return some;
}

/* Reflections mix velocities, and round all to the largest: one that is 1e16 times smaller would be lost. Once more, by what rows are missed by, each has
 * the digits of its rows. */
static void refine(struct field *f, int m, double *v)
{
    SGA_ARENA(mem);
    double *off = sga_take(&mem, ((size_t)m + 1) * sizeof *off), *d = sga_take(&mem, ((size_t)f->n + 1) * sizeof *d);
    if (!missed(f, m, v, off))
        return;
    points_least_norm_solve(m, f->n, f->M, f->kept_rank, f->perm, f->qr, off, d);
    for (int j = 0; j < f->n; j++)
        v[j] += d[j] * (f->kept_unit ? f->kept_unit[j] : 1);
}

bool field_general(struct field *f, double *v, int *rank)
{
    int m = f->rows + f->c + f->rates;
    bool same;
    if (!f->kept)
        reserve(f, m);
    if ((f->rows + f->c > FEW_ROWS && !sga_watch_ok()) || !evaluate(f, &same))
        return false;
    if (f->whole) {
        f->kept_rank = -1;
        *rank = whole_velocities(f->whole, f->kept, f->rhs, v) ? f->n : f->n - 1;
        return true;
    }
    if (!same)
        f->kept_rank = factor(f, m);
    for (int i = 0; i < m; i++)
        f->rhs[i] /= f->row_size[i];
    *rank = f->kept_rank;
    points_least_norm_solve(m, f->n, f->M, f->kept_rank, f->perm, f->qr, f->rhs, v);
    for (int j = 0; j < f->n && f->kept_unit; j++)
        v[j] *= f->kept_unit[j];
    refine(f, m, v);
    if (f->kept_unit && f->kept_rank < f->n)
        shorten(f, v);
    for (int j = 0; j < f->n; j++)
        if (!isfinite(v[j]))
            return false;
    return true;
}

int field_rank_since(struct field *f, double t, const double *x)
{
    int m = f->rows + f->c + f->rates, n = f->n, rank = -1;
    double *there = sga_malloc(((size_t)(n + 1) + (size_t)f->rows) * sizeof *there), *was = there + n + 1;
    bool same;
    memcpy(there, f->in, (size_t)(n + 1) * sizeof *there);
    field_load(f, t, x);
    if (evaluate(f, &same)) {
        fill(f, m);
        sga_copy(was, f->row_size, f->rows);
        sga_copy(f->in, there, n + 1);
        if (evaluate(f, &same)) {
            fill(f, m);
            for (int i = 0; i < f->rows; i++)
                if (f->row_size[i] <= VANISHED * was[i])
                    memset(f->M + (size_t)i * (size_t)n, 0, (size_t)n * sizeof *f->M);
            rank = points_least_norm_factor(m, n, f->M, f->perm, f->qr);
        }
    }
    f->kept_rank = -1;
    free(there);
    return rank;
}

/* The entries at the start, moved by so many times what a start may be off by: two tries, in what was found and not given. */
static bool entries_beside(struct field *f, const double *here, double times, int k)
{
    int *by_name = sga_malloc(((size_t)f->n + 1) * sizeof *by_name);
    bool same;
    sys_by_name(f->sys, by_name);
    for (int i = 0; i < f->n; i++) {
        int j = by_name[i];
        bool sure = f->given && f->given[j] && here[j] == f->guess[j];
        double size = fmax(fabs(here[j]), f->unit ? f->unit[j] : 1);
        bool moved = f->given && f->given[j] && fabs(here[j] - f->guess[j]) > FAR_OFF * size;
        f->in[j] = here[j] + (sure ? 0 : times * (moved ? FOUND_FAR : FOUND) * size * sin(1.3 + 2.1 * i + 0.9 * k));
    }
    free(by_name);
    return evaluate(f, &same);
}

/* What an entry may be off by, from its changes at the whole and at an eighth of the way: what does not shrink with the way
 * is a jump (the start lies at a bend), whose sides are values and no noise, as long as they have one sign. */
static double noise_of(double here, double there, double nearer, double largest)
{
    double change = fabs(there - here), less = fabs(nearer - here);
    bool jumps = less > change / 2 && less > STEP_SEEN * largest, one_sign = here * there > 0 && here * nearer > 0;
    return jumps && one_sign ? 0 : change;
}

/* How much each entry changes with what of the start was found, and not given: the larger of two tries. */
static bool found_noise(struct field *f, double *noise, int entries)
{
    double *here = sga_malloc(((size_t)f->n + 1 + 2 * (size_t)entries) * sizeof *here), *first = here + f->n + 1, *there = first + entries, largest = 0;
    bool same, ok = evaluate(f, &same);
    memcpy(here, f->in, (size_t)f->n * sizeof *here);
    sga_copy(first, f->kept, entries);
    for (int q = 0; q < entries; q++)
        largest = fmax(largest, fabs(first[q]));
    for (int k = 0; k < 2 && ok; k++) {
        ok = entries_beside(f, here, 1, k);
        sga_copy(there, f->kept, entries);
        ok = ok && entries_beside(f, here, 0.125, k);
        for (int q = 0; q < entries && ok; q++)
            noise[q] = fmax(noise[q], noise_of(first[q], there[q], f->kept[q], largest));
    }
    memcpy(f->in, here, (size_t)f->n * sizeof *here);
    free(here);
    f->kept_rank = -1;
    return ok && evaluate(f, &same);
}

/* Whether the entries of A are numbers. */
static bool all_constant(const struct field *f)
{
    bool constant = true;
    for (int i = 0; i < f->rows; i++)
        for (int k = 0; k < f->sys->row[i].entries; k++)
            constant &= expr_is_const(f->sys->store, f->sys->row[i].entry[k].value);
    return constant;
}

int field_rank_told(struct field *f)
{
    int entries = 0, q = 0, m = f->rows + f->c + f->rates;
    for (int i = 0; i < f->rows; i++)
        entries += f->sys->row[i].entries;
    for (int k = 0; k < f->jac->nnz; k++)
        entries += f->jac->col[k] < f->n;
    if (!f->M)
        reserve(f, m);
    double *noise = sga_calloc((size_t)entries + 1, sizeof *noise);
    bool ok = found_noise(f, noise, entries);
    struct definitions names = { 0 };
    if (ok && !all_constant(f))
        definitions_find(&names, f->sys, DEFINITIONS_ALL, NULL);
    struct told_place told;
    told_begin(&told, f->sys, &names, f->in);
    for (int i = 0; i < f->rows && ok; i++)
        for (int k = 0; k < f->sys->row[i].entries; k++, q++)
            if (!expr_is_const(f->sys->store, f->sys->row[i].entry[k].value))
                noise[q] = fmax(noise[q], told_rounding(&told, f->sys->row[i].entry[k].value));
    told_end(&told);
    definitions_clear(&names);
    for (q = 0; q < entries && ok; q++)
        if (fabs(f->kept[q]) <= noise[q])
            f->kept[q] = 0;
    free(noise);
    int rank = ok ? factor(f, m) : -1, balanced = ok && rank < f->generic_rank ? balanced_rank(f, m) : rank;
    f->kept_rank = -1;
    assert(rank <= m && rank <= f->n && balanced <= f->n);
    return balanced > rank ? balanced : rank;
}
