/* The rest of an elimination by the columns of its pivots. */
#include "sparse_work.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "sparse_complete.h"

/* Rows are cut to so many entries, and to so many beside those that an earlier elimination chose. So few rows without a pivot are left as they
 * are, and with so many the guess is given up. */
enum { LEFT_ENTRIES = 64, LEFT_BESIDE = 8, FEW_LEFT = 32, MOST_TO_KEEP = 200 };
/* In columns that are a guess a row's largest entry is no pivot from here on: one in other columns may be larger. */
static const double SMALL = 1e-3;
/* Unknowns for right sides of 1: from here on they are nearly singular. */
static const double SINGULAR = 1e10;

/* With rows that are cut, except in kept columns. */
static void factor_cut(struct points_lu *lu, struct points_row *row, const struct points_problem *p, double tiny, const unsigned char *kept)
{
    SGA_ARENA(mem);
    struct points_work w;
    points_work_begin(&w, &mem, lu, row, p, tiny);
    w.first = p->first;
    w.kept = kept;
    w.others = kept ? LEFT_BESIDE : LEFT_ENTRIES;
    for (int i = 0; i < p->rows; i++) {
        points_cut_row(&w, i);
        points_work_file(&w, i);
    }
    points_work_run(&w);
    points_work_end(&w);
}

static void factor_whole(struct points_lu *lu, struct points_row *row, const struct points_problem *p, double tiny)
{
    SGA_ARENA(mem);
    struct points_work w;
    points_work_begin(&w, &mem, lu, row, p, tiny);
    points_work_run(&w);
    points_work_end(&w);
}

/* The rows, in all columns or in some. */
static struct points_row *copied(const struct points_row *row, int rows, const unsigned char *in)
{
    struct points_row *to = sga_calloc((size_t)rows + 1, sizeof *to);
    for (int i = 0; i < rows; i++) {
        to[i] = (struct points_row){ sga_malloc((size_t)(row[i].len + 1) * sizeof(int)), sga_malloc((size_t)(row[i].len + 1) * sizeof(double)),
                                     0, row[i].len + 1 };
        for (int k = 0; k < row[i].len; k++)
            if (!in || in[row[i].col[k]]) {
                to[i].col[to[i].len] = row[i].col[k];
                to[i].val[to[i].len++] = row[i].val[k];
            }
    }
    return to;
}

static void mark_pivots(const struct points_lu *lu, unsigned char *kept)
{
    memset(kept, 0, (size_t)lu->cols + 1);
    for (int s = 0; s < lu->rank; s++)
        kept[lu->pivot_col[s]] = 1;
}

/* Whether unknowns stay of moderate size, for a right side of signs. */
static bool well_conditioned(const struct points_lu *lu)
{
    SGA_ARENA(mem);
    double *b = sga_take(&mem, ((size_t)lu->rows + 1) * sizeof *b), *x = sga_zeros(&mem, (size_t)lu->cols + 1, sizeof *x);
    for (int i = 0; i < lu->rows; i++)
        b[i] = (uint32_t)i * 2654435761u >> 31 ? 1 : -1;
    points_lu_solve(lu, b, x);
    bool moderate = true;
    for (int j = 0; j < lu->cols; j++)
        moderate &= fabs(x[j]) < SINGULAR;
    return moderate;
}

/* Pivots of rows that are cut, then an elimination in their columns alone, which rows that are left complete. Where many have none, one more
 * with cuts takes these columns whole and, where they are dependent, others. False: it led to no pivots that are
 * regular, or known to be all there are. lu is to be cleared. */
static bool by_columns(struct points_lu *lu, const struct points_row *row, const struct points_problem *p)
{
    int rows = p->rows;
    SGA_ARENA(mem);
    unsigned char *kept = sga_take(&mem, (size_t)p->cols + 1);
    factor_cut(lu, copied(row, rows, NULL), p, p->tiny, NULL);
    if (rows - lu->rank > MOST_TO_KEEP)
        return false;
    if (rows - lu->rank > FEW_LEFT) {
        mark_pivots(lu, kept);
        points_lu_clear(lu);
        factor_cut(lu, copied(row, rows, NULL), p, SMALL, kept);
    }
    mark_pivots(lu, kept);
    points_lu_clear(lu);
    factor_whole(lu, copied(row, rows, kept), p, SMALL);
    int found = lu->rank;
    if (!points_complete(lu, row, p->norm, p->tiny))
        return false;
    if (lu->rank > found) {
        found = lu->rank;
        mark_pivots(lu, kept);
        points_lu_clear(lu);
        factor_whole(lu, copied(row, rows, kept), p, p->tiny);
    }
    return lu->rank == found && well_conditioned(lu);
}

/* The rows of the rest, as they are now, are eliminated by columns: their place in the whole is place[]. */
static void join(struct points_lu *lu, struct points_lu *rest, const int *place)
{
    for (int i = 0; i < rest->rows; i++) {
        struct points_row *r = lu->row + place[i], whole = *r;
        *r = rest->row[i];
        rest->row[i] = whole;
    }
    SGA_RESERVE(lu->op, lu->op_cap, lu->ops + rest->ops + 1);
    for (int k = 0; k < rest->ops; k++) {
        lu->op[lu->ops + k].row = place[rest->op[k].row];
        lu->op[lu->ops + k].step = lu->rank + rest->op[k].step;
        lu->op[lu->ops + k].factor = rest->op[k].factor;
    }
    lu->ops += rest->ops;
    for (int s = 0; s < rest->rank; s++) {
        lu->pivot_row[lu->rank + s] = place[rest->pivot_row[s]];
        lu->pivot_col[lu->rank + s] = rest->pivot_col[s];
        lu->pivot[lu->rank + s] = rest->pivot[s];
    }
    lu->rank += rest->rank;
}

/* What is left to do, by columns. False: nothing has changed. */
bool points_rest_by_columns(struct points_work *w, const unsigned char *first)
{
    SGA_ARENA(mem);
    struct points_lu *lu = w->lu;
    int *place = sga_take(&mem, ((size_t)lu->rows + 1) * sizeof *place), rows = 0;
    double *norm = sga_take(&mem, ((size_t)lu->rows + 1) * sizeof *norm);
    struct points_row *row = sga_take(&mem, ((size_t)lu->rows + 1) * sizeof *row);
    for (int i = 0; i < lu->rows; i++)
        if (!w->done[i] && lu->row[i].len > 0) {
            place[rows] = i;
            norm[rows] = w->norm[i];
            row[rows++] = lu->row[i];
        }
    SGA_ENDS(points_lu_clear) struct points_lu rest;
    bool ok = by_columns(&rest, row, &(struct points_problem){ rows, lu->cols, w->tiny, norm, first });
    if (ok)
        join(lu, &rest, place);
    return ok;
}
