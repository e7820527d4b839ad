/* Whether the rank drops where a pivot comes to 0. At the place itself numbers cannot tell: where the set crosses itself (a linkage at its
 * change-over point) points near it are known to half the digits only, and a projection falls on another branch. On the way there they
 * can: with the pivot at a hundredth of what it was, what is left of the rows for the last of their rank is as much smaller, or it is not. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"
#include "jacobian.h"
#include "larger.h"
#include "manifold.h"
#include "mem.h"
#include "system.h"
#include "tape.h"
#include "warnings.h"

static const double PART = 0.01, SMALLER = 0.1;      /* of the pivot; and of what is left, which falls as the pivot or faster */
static const double TELLS = 1e-5;                    /* of the pivot at the start: nearer than this there are too few digits */

/* What is left for the last of `rank` of the rows (rows x n), by complete pivoting; they are used up. */
static double left_for(double *a, int rows, int n, int rank)
{
    double last = 0;
    for (int k = 0; k < rank; k++) {
        int at = k, col = k;
        for (int i = k; i < rows; i++)
            for (int j = k; j < n; j++)
                if (fabs(a[i * n + j]) > fabs(a[at * n + col])) {
                    at = i;
                    col = j;
                }
        last = fabs(a[at * n + col]);
        if (!(last > 0))
            return 0;
        for (int j = 0; j < n; j++) {
            double v = a[at * n + j];
            a[at * n + j] = a[k * n + j];
            a[k * n + j] = v;
        }
        for (int i = 0; i < rows; i++) {
            double v = a[i * n + col];
            a[i * n + col] = a[i * n + k];
            a[i * n + k] = v;
        }
        for (int i = k + 1; i < rows; i++)
            for (int j = n - 1; j >= k; j--)
                a[i * n + j] -= a[i * n + k] / a[k * n + k] * a[k * n + j];
    }
    return last;
}

/* The same at the place in f->in. Equations' rows count as they are, each by its largest entry; constraints by `size` (c), which is that entry at the first
 * place: their gradients may vanish. Not a number where there is no value. */
static double left_at(struct field *f, double *size, bool first)
{
    int n = f->n, rows = f->rows + f->c, at = 0;
    double *a = sga_calloc((size_t)rows * (size_t)n + 1, sizeof *a), left = NAN;
    if (field_general_values(f) && num_jacobian_eval(f->jac, f->in, NULL, f->jac_value)) {
        for (int i = 0; i < f->rows; i++, at++) {
            const struct sys_row *r = f->sys->row + i;
            double big = 0;
            for (int k = 0; k < r->entries; k++, at++) {
                a[i * n + r->entry[k].col] = f->general_out[at] * (f->unit ? f->unit[r->entry[k].col] : 1);
                big = sga_larger(big, fabs(a[i * n + r->entry[k].col]));
            }
            for (int j = 0; j < n && big > 0; j++)
                a[i * n + j] /= big;
        }
        for (int i = 0; i < f->c; i++) {
            double *row = a + (size_t)(f->rows + i) * (size_t)n, big = 0;
            for (int k = f->jac->start[i]; k < f->jac->start[i + 1]; k++)
                if (f->jac->col[k] < n) {
                    row[f->jac->col[k]] = f->jac_value[k] * (f->unit ? f->unit[f->jac->col[k]] : 1);
                    big = sga_larger(big, fabs(row[f->jac->col[k]]));
                }
            if (first)
                size[i] = big > 0 ? big : 1;
            for (int j = 0; j < n; j++)
                row[j] /= size[i];
        }
        left = left_for(a, rows, n, f->generic_rank);
    }
    free(a);
    return left;
}

bool field_rank_falls(struct field *f, int pivot, double t, const double *x)
{
    int n = f->n;
    if (f->c == 0 || f->rates || n > SGA_MOST_ROWS_ASKED)
        return false;
    double *y = sga_malloc(((size_t)n + (size_t)f->c + 1) * sizeof *y), *size = y + n, at = 0, low = 0, high = 1, whole, p = NAN, far;
    field_load(f, f->home_t, f->home);
    whole = left_at(f, size, true);
    num_tape_eval(f->direct, f->in, f->direct_out);
    far = fabs(f->direct_out[n + pivot]);
    bool tells = far > TELLS * f->pivot_start[pivot] && whole > 0, found = false;
    for (int turn = 0; turn < 60 && tells && !found; turn++) {
        double s = 0.5 * (low + high);
        for (int j = 0; j < n; j++)
            y[j] = f->home[j] + s * (x[j] - f->home[j]);
        at = f->home_t + s * (t - f->home_t);
        manifold_project(f->manifold, at, y, NULL, NULL, 8, NULL, NULL, NULL);
        field_load(f, at, y);
        num_tape_eval(f->direct, f->in, f->direct_out);
        p = f->direct_out[n + pivot] * f->home[n + pivot];     /* by its side at home */
        found = p > 0.5 * PART * far && p < 2 * PART * far;
        if (p > PART * far)
            low = s;
        else
            high = s;
    }
    bool falls = found && left_at(f, size, false) < SMALLER * whole;
    free(y);
    field_load(f, t, x);
    return falls;
}
