/* See the header. */
#include "ball_matrix.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "lin_sparse.h"
#include "mem.h"

enum { PASSES = 12 };              /* that bring rows and columns to sizes of 1 */
/* log2: sizes beyond which entries are not brought into doubles. */
static const slong SIZE_MOST = 1 << 20;

/* The entries that count: in the first columns, and not 0 in value. */
static bool counts(const struct num_ball_matrix *w, const struct num_ball *b, const struct expr_rows *at, int k)
{
    return at->column[k] < w->cols && !arb_is_zero(b->value + at->entry[k]);
}

/* -1: too many. */
static int count_entries(const struct num_ball_matrix *w, const struct num_ball *b, const struct expr_rows *at)
{
    size_t count = 0, most = (size_t)w->rows * (size_t)w->cols / NUM_BALL_MATRIX_PART;
    for (int k = 0; k < at->start[w->rows]; k++)
        count += counts(w, b, at, k);
    return count <= most ? (int)count : -1;
}

static void take_pattern(struct num_ball_matrix *w, const struct num_ball *b, const struct expr_rows *at)
{
    SGA_ARENA(mem);
    int place = 0, *ptr = sga_zeros(&mem, (size_t)w->rows + 1, sizeof *ptr), *col = sga_take(&mem, ((size_t)w->entries + 1) * sizeof *col);
    for (int i = 0; i < w->rows; i++) {
        for (int k = at->start[i]; k < at->start[i + 1]; k++)
            if (counts(w, b, at, k)) {
                w->entry[place] = b->value + at->entry[k];
                col[place++] = at->column[k];
            }
        ptr[i + 1] = place;
    }
    w->B = lin_sparse_new(w->rows, w->cols, ptr, col);
}

/* Means of logarithms of rows and columns in turn (units that differ by rows and by columns are found, which largest entries would not), then the
 * largest entry of each row. False: a row or a column is empty, or an entry not finite. */
static bool take_units(struct num_ball_matrix *w)
{
    SGA_ARENA(mem);
    const struct lin_sparse *B = w->B;
    double *size = sga_take(&mem, ((size_t)w->entries + 1) * sizeof *size);
    double *sum = sga_take(&mem, ((size_t)w->cols + 1) * sizeof *sum), *unit = sga_zeros(&mem, (size_t)w->cols + 1, sizeof *unit);
    int *count = sga_zeros(&mem, (size_t)w->cols + 1, sizeof *count);
    for (int k = 0; k < w->entries; k++) {
        if (!arb_is_finite(w->entry[k]) || arf_is_zero(arb_midref(w->entry[k])))
            return false;
        slong log2 = num_ball_log2(arb_midref(w->entry[k]));
        if (log2 > SIZE_MOST || log2 < -SIZE_MOST)
            return false;
        size[k] = (double)log2;
        count[B->col[k]]++;
    }
    for (int i = 0; i < w->rows; i++)
        if (B->ptr[i] == B->ptr[i + 1])
            return false;
    for (int j = 0; j < w->cols; j++)
        if (!count[j])
            return false;
    for (int pass = 0; pass < PASSES; pass++) {
        memset(sum, 0, (size_t)w->cols * sizeof *sum);
        for (int i = 0; i < w->rows; i++) {
            double mean = 0;
            for (int k = B->ptr[i]; k < B->ptr[i + 1]; k++)
                mean += size[k] + unit[B->col[k]];
            mean /= B->ptr[i + 1] - B->ptr[i];
            for (int k = B->ptr[i]; k < B->ptr[i + 1]; k++)
                sum[B->col[k]] += size[k] - mean;
        }
        for (int j = 0; j < w->cols; j++)
            unit[j] = -sum[j] / count[j];
    }
    for (int j = 0; j < w->cols; j++)
        w->column[j] = (slong)nearbyint(unit[j]);
    for (int i = 0; i < w->rows; i++) {
        double most = -INFINITY;
        for (int k = B->ptr[i]; k < B->ptr[i + 1]; k++)
            most = fmax(most, size[k] + (double)w->column[B->col[k]]);
        w->row[i] = -(slong)most;
    }
    return true;
}

static void take_values(struct num_ball_matrix *w)
{
    SGA_ENDS(mag_end) mag_t r = { 0 };
    double sum = 0;
    for (int i = 0; i < w->rows; i++)
        for (int k = w->B->ptr[i]; k < w->B->ptr[i + 1]; k++) {
            slong unit = w->row[i] + w->column[w->B->col[k]];
            w->B->val[k] = num_ball_double(arb_midref(w->entry[k]), -unit);
            mag_mul_2exp_si(r, arb_radref(w->entry[k]), unit);
            double e = mag_get_d(r) * (1 + 1e-9) + fabs(w->B->val[k]) * DBL_EPSILON + DBL_MIN;
            sum += e * e;
        }
    w->error = sqrt(sum) * (1 + 1e-9);
}

bool num_ball_matrix_init(struct num_ball_matrix *w, const struct num_ball *b, int rows, int cols, const struct expr_rows *at)
{
    *w = (struct num_ball_matrix){ .rows = rows, .cols = cols };
    if (rows < NUM_BALL_MATRIX_ROWS || (w->entries = count_entries(w, b, at)) < 0)
        return false;
    w->entry = sga_malloc(((size_t)w->entries + 1) * sizeof *w->entry);
    w->row = sga_calloc((size_t)rows + (size_t)cols + 1, sizeof *w->row);
    w->column = w->row + rows;
    take_pattern(w, b, at);
    if (!take_units(w))
        return false;
    take_values(w);
    return lin_all_finite(w->entries, w->B->val) && isfinite(w->error);
}

void num_ball_matrix_clear(struct num_ball_matrix *w)
{
    free(w->entry);
    free(w->row);
    lin_sparse_free(w->B);
    *w = (struct num_ball_matrix){ 0 };
}
