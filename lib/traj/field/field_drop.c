/* Whether the rank drops where a pivot comes to 0. At the place itself numbers cannot tell: where the set crosses itself (a linkage at its
 * change-over point) points near it are known to half the digits only, and a projection falls on another branch. On the way there they
 * can: with the pivot at a hundredth of what it was, what is left of the rows for the last of their rank is as much smaller, or it is not;
 * and it goes on falling with the pivot, which what happens to be smaller there does not. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "field.h"
#include "jacobian.h"
#include "larger.h"
#include "manifold.h"
#include "mem.h"
#include "system.h"
#include "tape.h"
#include "warnings.h"

static const double PART = 0.01, SMALLER = 0.1;      /* of the pivot; and of what is left, which falls as the pivot or faster, */
static const double BEFORE = 0.1, FOLLOWS = 0.4;     /* and not by chance: from a place before, too (a tenth, or a quarter as each is found to a factor 2) */
static const double TELLS = 1e-5;                    /* of the pivot at the start: nearer than this there are too few digits */

double field_left_for(double *a, int rows, int n, int rank)
{
    double last = 0;
    assert(rank <= rows && rank <= n);
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

/* The rows at the place in f->in (a: rows + c by n). far (n, or NULL): columns that are left out, and constraints that have them. False: they have no value. */
static bool rows_at(struct field *f, const unsigned char *far, double *a)
{
    int n = f->n, at = 0;
    if (!field_general_values(f) || !num_jacobian_eval(f->jac, f->in, NULL, f->jac_value))
        return false;
    for (int i = 0; i < f->rows; i++, at++)
        for (int k = 0; k < f->sys->row[i].entries; k++, at++)
            a[i * n + f->sys->row[i].entry[k].col] = f->general_out[at];
    for (int i = 0; i < f->c; i++)
        for (int k = f->jac->start[i]; k < f->jac->start[i + 1]; k++)
            if (f->jac->col[k] < n)
                a[(f->rows + i) * n + f->jac->col[k]] = f->jac_value[k];
    for (int i = 0; i < f->rows + f->c && far; i++) {
        bool has = false;
        for (int j = 0; j < n; j++) {
            has |= far[j] && a[i * n + j] != 0;
            a[i * n + j] = far[j] ? 0 : a[i * n + j];
        }
        if (has && i >= f->rows)
            memset(a + (size_t)i * (size_t)n, 0, (size_t)n * sizeof *a);
    }
    return true;
}

static double largest_in_row(const double *a, const double *column, int row, int n)
{
    double big = 0;
    for (int j = 0; j < n; j++)
        big = sga_larger(big, fabs(a[row * n + j]) * column[j]);
    return big;
}

void field_balance(const double *a, int rows, int n, double *column)
{
    enum { SWEEPS = 3 };
    static const double ROUNDING = 1e-13;      /* of the row's largest: no size of the column's own */
    SGA_FREED double *big = sga_malloc(((size_t)n + 1) * sizeof *big);
    for (int j = 0; j < n; j++)
        column[j] = 1;
    for (int k = 0; k <= SWEEPS; k++) {
        memset(big, 0, (size_t)n * sizeof *big);
        for (int i = 0; i < rows; i++) {
            double row = largest_in_row(a, column, i, n);
            for (int j = 0; j < n && row > 0; j++) {
                double part = fabs(a[i * n + j]) * column[j] / row;
                big[j] = part > ROUNDING ? sga_larger(big[j], part) : big[j];
            }
        }
        for (int j = 0; j < n; j++)
            column[j] = big[j] > 0 ? column[j] / big[j] : k < SWEEPS ? column[j] : 0;
    }
}

/* What is left at the place in f->in, columns in sizes of the first place. Equations' rows count as they are, each by its largest entry; constraints by what that
 * entry is at the first place: their gradients may vanish. size: c of these, then n of the columns. far: as above. Not a number where there is no value. */
static double left_of(struct field *f, const unsigned char *far, int rank, double *size, bool first)
{
    int n = f->n, rows = f->rows + f->c;
    double *a = sga_calloc((size_t)rows * (size_t)n + 1, sizeof *a), *column = size + f->c, left = NAN;
    if (rows_at(f, far, a)) {
        if (first)
            field_balance(a, rows, n, column);
        for (int j = 0; j < n && first; j++)
            column[j] = column[j] > 0 ? column[j] : 1;
        for (int i = 0; i < rows; i++) {
            double big = largest_in_row(a, column, i, n), *own = i >= f->rows ? size + i - f->rows : NULL;
            if (own && first)
                *own = big > 0 ? big : 1;
            for (int j = 0; j < n && big > 0; j++)
                a[i * n + j] *= column[j] / (own ? *own : big);
        }
        left = field_left_for(a, rows, n, rank);
    }
    free(a);
    return left;
}

static double left_at(struct field *f, double *size, bool first) { return left_of(f, NULL, f->generic_rank, size, first); }

double field_left_of_others(struct field *f, double start, const double *initial, const unsigned char *far, int rank)
{
    SGA_FREED double *size = sga_malloc(((size_t)f->c + (size_t)f->n + 1) * sizeof *size);
    field_load(f, start, initial);
    double whole = left_of(f, far, rank, size, true);
    field_load(f, f->home_t, f->home);
    return left_of(f, far, rank, size, false) / whole;
}

/* The same where the pivot, between the begin of the way and its part `high`, is this part of `far`, which it is at the begin with the sign of
 * `side`; not a number where no such place is found. */
static double left_where(struct field *f, const struct field_way *way, int pivot, double side, double high, double part, double far, double *size)
{
    double low = 0;
    for (int turn = 0; turn < 60; turn++) {
        double s = 0.5 * (low + high);
        way->load(f, way, s);
        num_tape_eval(f->direct, f->in, f->direct_out);
        double p = f->direct_out[f->n + pivot] * side;
        if (p > 0.5 * part * far && p < 2 * part * far)
            return left_at(f, size, false);
        if (p > part * far)
            low = s;
        else
            high = s;
    }
    return NAN;
}

bool field_rank_tells(const struct field *f) { return f->c > 0 && f->n <= SGA_MOST_ROWS_ASKED; }

bool field_falls_along(struct field *f, int pivot, const struct field_way *way, double end)
{
    double *size = sga_malloc(((size_t)f->c + (size_t)f->n + 1) * sizeof *size);
    assert(pivot >= f->sides && pivot < f->pivots);       /* beyond a side it is no rank that falls */
    way->load(f, way, 0);
    double whole = left_at(f, size, true);
    num_tape_eval(f->direct, f->in, f->direct_out);
    double p = f->direct_out[f->n + pivot], far = fabs(p), side = p < 0 ? -1 : 1;
    bool falls = far > TELLS * f->pivot_start[pivot] && whole > 0;
    double before = falls ? left_where(f, way, pivot, side, end, BEFORE, far, size) : NAN;
    double last = before > 0 ? left_where(f, way, pivot, side, end, PART, far, size) : NAN;
    falls = last < SMALLER * whole && last < FOLLOWS * before;
    for (double part = 0.1 * PART; falls && part * far > TELLS * f->pivot_start[pivot]; part *= 0.1) {      /* where branches pass each other closely */
        before = last;
        last = left_where(f, way, pivot, side, end, part, far, size);
        if (isnan(last))
            break;
        falls = last < FOLLOWS * before;
    }
    free(size);
    return falls;
}

struct chord { const double *x; double t, *y; };

static void load_chord(struct field *f, const struct field_way *way, double s)
{
    const struct chord *c = way->of;
    double at = f->home_t + s * (c->t - f->home_t);
    for (int j = 0; j < f->n; j++)
        c->y[j] = f->home[j] + s * (c->x[j] - f->home[j]);
    if (s > 0)
        manifold_project(f->manifold, at, c->y, NULL, NULL, 8, NULL, NULL, NULL);
    field_load(f, at, c->y);
}

bool field_rank_falls(struct field *f, int pivot, double t, const double *x)
{
    if (!field_rank_tells(f))
        return false;
    struct chord c = { x, t, sga_malloc(((size_t)f->n + 1) * sizeof(double)) };
    bool falls = field_falls_along(f, pivot, &(struct field_way){ &c, load_chord }, 1);
    free(c.y);
    field_load(f, t, x);
    return falls;
}
