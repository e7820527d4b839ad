/* Sparse elimination in double with pivots by value and sparsity: rows filed by length,
 * columns with lists of the rows that meet them, both allowed to hold stale members. */
#include "sparse.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "sparse_work.h"

/* The rest is done by columns from so many multiplications for each entry on, and not before so many of all; never of fewer rows than these. */
enum { FEW_ROWS = 200, WORK_EACH = 300 };
static const double WORK_FEW = 1e6;

static void list_add(struct points_list *l, int item)
{
    SGA_RESERVE(l->item, l->cap, l->count + 1);
    l->item[l->count++] = item;
}

static int find(const struct points_row *r, int col)
{
    for (int k = 0; k < r->len; k++)
        if (r->col[k] == col)
            return k;
    return -1;
}

/* The largest entry, of all columns or of some. */
static double largest(const struct points_row *r, const unsigned char *of)
{
    double m = 0;
    for (int k = 0; k < r->len; k++)
        if (fabs(r->val[k]) > m && (!of || of[r->col[k]]))
            m = fabs(r->val[k]);
    return m;
}

void points_work_file(struct points_work *w, int i)
{
    int len = w->lu->row[i].len;
    list_add(w->by_length + len, i);
    if (len < w->lowest)
        w->lowest = len;
}

static bool has(const struct points_row *r, const int *at, int c)
{
    return at[c] < r->len && r->col[at[c]] == c;
}

static void append(struct points_row *r, int c, double v)
{
    if (r->len == r->cap) {
        r->cap = r->cap ? 2 * r->cap : 8;
        r->col = sga_realloc(r->col, (size_t)r->cap * sizeof *r->col);
        r->val = sga_realloc(r->val, (size_t)r->cap * sizeof *r->val);
    }
    r->col[r->len] = c;
    r->val[r->len++] = v;
}

/* row i -= f * row p; the pivot column leaves row i */
static void subtract(struct points_work *w, int i, int p, double f, int pivot_col)
{
    struct points_row *r = w->lu->row + i;
    const struct points_row *q = w->lu->row + p;
    int *at = w->at;
    for (int k = 0; k < r->len; k++)
        at[r->col[k]] = k;
    for (int k = 0; k < q->len; k++) {
        int c = q->col[k];
        if (has(r, at, c)) {
            r->val[at[c]] -= f * q->val[k];
        } else {
            at[c] = r->len;
            append(r, c, -f * q->val[k]);
            w->count[c]++;
            list_add(w->meet + c, i);
        }
    }
    r->len--;
    r->col[at[pivot_col]] = r->col[r->len];
    r->val[at[pivot_col]] = r->val[r->len];
    w->count[pivot_col]--;
}

/* Row r is none of those that are left any more. */
static void leave(struct points_work *w, int r)
{
    const struct points_row *row = w->lu->row + r;
    w->done[r] = 1;
    for (int k = 0; k < row->len; k++)
        w->count[row->col[k]]--;
}

/* The shortest row with an acceptable entry, and in it the column that meets the fewest
 * rows among the entries not below a tenth of the largest. */
static bool choose(struct points_work *w, int *out_row, int *out_col)
{
    for (int len = w->lowest; len <= w->lu->cols; len++) {
        struct points_list *l = w->by_length + len;
        w->lowest = len;
        while (l->count) {
            int i = l->item[--l->count];
            const struct points_row *r = w->lu->row + i;
            if (w->done[i] || r->len != len)
                continue;
            const unsigned char *of = w->kept;
            double big = largest(r, of);
            if (of && !(big > w->tiny * w->norm[i])) {
                of = NULL;
                big = largest(r, of);
            }
            if (!(big > w->tiny * w->norm[i])) {
                leave(w, i);          /* numerically dependent on the rows before it */
                continue;
            }
            int best = -1;
            for (int k = 0; k < r->len; k++) {
                double v = fabs(r->val[k]);
                if (v < 0.1 * big || (of && !of[r->col[k]]))
                    continue;
                if (best < 0 || w->count[r->col[k]] < w->count[r->col[best]]
                    || (w->count[r->col[k]] == w->count[r->col[best]] && v > fabs(r->val[best])))
                    best = k;
            }
            *out_row = i;
            *out_col = r->col[best];
            return true;
        }
    }
    return false;
}

bool points_work_run(struct points_work *w)
{
    struct points_lu *lu = w->lu;
    int r, c;
    while (lu->rank < lu->rows) {
        if (w->budget < 0)
            return false;
        if (!choose(w, &r, &c))
            break;
        int step = lu->rank++;
        double p = lu->row[r].val[find(lu->row + r, c)];
        lu->pivot_row[step] = r;
        lu->pivot_col[step] = c;
        lu->pivot[step] = p;
        leave(w, r);
        for (int q = 0; q < w->meet[c].count; q++) {
            int i = w->meet[c].item[q], at = w->done[i] ? -1 : find(lu->row + i, c);
            if (at < 0)
                continue;
            double f = lu->row[i].val[at] / p;
            if (f != 0) {
                SGA_RESERVE(lu->op, lu->op_cap, lu->ops + 1);
                lu->op[lu->ops].row = i;
                lu->op[lu->ops].step = step;
                lu->op[lu->ops++].factor = f;
            }
            subtract(w, i, r, f, c);
            w->budget -= lu->row[r].len;
            if (w->first)
                points_cut_row(w, i);
            points_work_file(w, i);
        }
    }
    return true;
}

void points_work_begin(struct points_work *w, struct sga_arena *mem, struct points_lu *lu, struct points_row *row, const struct points_problem *p, double tiny)
{
    int rows = p->rows, cols = p->cols;
    *lu = (struct points_lu){ .rows = rows, .cols = cols, .row = row };
    lu->pivot_row = sga_malloc((size_t)(rows + 1) * sizeof(int));
    lu->pivot_col = sga_malloc((size_t)(rows + 1) * sizeof(int));
    lu->pivot = sga_malloc((size_t)(rows + 1) * sizeof(double));
    *w = (struct points_work){ .lu = lu, .lowest = cols, .tiny = tiny, .norm = p->norm, .budget = INFINITY };
    w->done = sga_zeros(mem, (size_t)rows + 1, 1);
    w->at = sga_zeros(mem, (size_t)cols + 1, sizeof *w->at);
    w->count = sga_zeros(mem, (size_t)cols + 1, sizeof *w->count);
    w->by_length = sga_zeros(mem, (size_t)cols + 1, sizeof *w->by_length);
    w->meet = sga_zeros(mem, (size_t)cols + 1, sizeof *w->meet);
    for (int i = 0; i < rows; i++) {
        for (int k = 0; k < row[i].len; k++) {
            w->count[row[i].col[k]]++;
            list_add(w->meet + row[i].col[k], i);
        }
        points_work_file(w, i);
    }
}

void points_work_end(struct points_work *w)
{
    for (int j = 0; j <= w->lu->cols; j++) {
        free(w->by_length[j].item);
        free(w->meet[j].item);
    }
    assert(w->lu->rank <= w->lu->rows && w->lu->rank <= w->lu->cols);
}

static void rows_free(struct points_row *row, int rows)
{
    for (int i = 0; i < rows && row; i++) {
        free(row[i].col);
        free(row[i].val);
    }
    free(row);
}

/* By column: twice the logarithm of how many rows it is in. */
static void in_rows(const int *count, int cols, unsigned char *first)
{
    for (int j = 0; j < cols; j++)
        first[j] = count[j] > 0 ? (unsigned char)(2 * log2(count[j])) : 0;
}

void points_lu_factor(struct points_lu *lu, struct points_row *row, int rows, int cols, double tiny)
{
    SGA_ARENA(mem);
    double *norm = sga_take(&mem, ((size_t)rows + 1) * sizeof *norm), most = WORK_FEW;
    for (int i = 0; i < rows; i++) {
        norm[i] = largest(row + i, NULL);
        most += WORK_EACH * row[i].len;
    }
    struct points_work w;
    points_work_begin(&w, &mem, lu, row, &(struct points_problem){ rows, cols, tiny, norm, NULL }, tiny);
    unsigned char *first = NULL;
    if (rows >= FEW_ROWS) {
        w.budget = most;
        first = sga_take(&mem, (size_t)cols + 1);
        in_rows(w.count, cols, first);
    }
    if (!points_work_run(&w) && !points_rest_by_columns(&w, first)) {
        w.budget = INFINITY;
        points_work_run(&w);
    }
    points_work_end(&w);
}

void points_lu_clear(struct points_lu *lu)
{
    rows_free(lu->row, lu->rows);
    free(lu->pivot_row);
    free(lu->pivot_col);
    free(lu->pivot);
    free(lu->op);
}

void points_lu_solve(const struct points_lu *lu, double *b, double *x)
{
    assert(lu->rank <= lu->rows && lu->rank <= lu->cols);
    for (int k = 0; k < lu->ops; k++)
        b[lu->op[k].row] -= lu->op[k].factor * b[lu->pivot_row[lu->op[k].step]];
    for (int s = lu->rank - 1; s >= 0; s--) {
        const struct points_row *r = lu->row + lu->pivot_row[s];
        double v = b[lu->pivot_row[s]];
        for (int k = 0; k < r->len; k++)
            if (r->col[k] != lu->pivot_col[s])
                v -= r->val[k] * x[r->col[k]];
        x[lu->pivot_col[s]] = v / lu->pivot[s];
    }
}
