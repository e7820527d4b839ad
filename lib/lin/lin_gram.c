/* Sparse patterns of J J^T and L; see the header. */
#include "lin_gram.h"

#include <stdlib.h>
#include <string.h>
#include <suitesparse/amd.h>

#include "lin_sparse.h"
#include "mem.h"

enum { FREE = 2000 };

/* By columns of J: its rows, and the places of the entries. */
struct transpose { int *ptr, *row, *place; };

static struct transpose transpose(const struct lin_sparse *J)
{
    int nz = J->ptr[J->rows];
    struct transpose t = { sga_calloc((size_t)J->cols + 2, sizeof(int)), sga_malloc(((size_t)nz + 1) * sizeof(int)),
                           sga_malloc(((size_t)nz + 1) * sizeof(int)) };
    for (int e = 0; e < nz; e++)
        t.ptr[J->col[e] + 2]++;
    for (int j = 0; j < J->cols; j++)
        t.ptr[j + 1] += t.ptr[j];
    for (int i = 0; i < J->rows; i++)
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++) {
            int at = t.ptr[J->col[e] + 1]++;
            t.row[at] = i;
            t.place[at] = e;
        }
    return t;
}

static void transpose_clear(struct transpose *t)
{
    free(t->ptr);
    free(t->row);
    free(t->place);
}

static bool too_many_products(const struct lin_sparse *J, const struct transpose *t, int most)
{
    double sum = 0;
    for (int j = 0; j < J->cols; j++)
        sum += (double)(t->ptr[j + 1] - t->ptr[j]) * (t->ptr[j + 1] - t->ptr[j]);
    return sum > (double)most * J->ptr[J->rows] + FREE;
}

/* Neighbours: rows that share a column. AMD's order. */
static bool find_order(struct lin_gram *s, const struct lin_sparse *J, const struct transpose *t)
{
    SGA_ARENA(mem);
    int *ptr = sga_zeros(&mem, (size_t)s->c + 1, sizeof *ptr), *to = NULL, *seen = sga_take(&mem, ((size_t)s->c + 1) * sizeof *seen);
    int count = 0;
    size_t cap = 0;
    memset(seen, -1, ((size_t)s->c + 1) * sizeof *seen);
    for (int i = 0; i < s->c; i++) {
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
            for (int q = t->ptr[J->col[e]]; q < t->ptr[J->col[e] + 1]; q++) {
                if (seen[t->row[q]] == i)
                    continue;
                seen[t->row[q]] = i;
                SGA_RESERVE(to, cap, count + 1);
                to[count++] = t->row[q];
            }
        ptr[i + 1] = count;
    }
    bool ok = count > 0 && amd_order(s->c, ptr, to, s->order, NULL, NULL) >= AMD_OK;
    free(to);
    return ok;
}

/* The products that make up each row of J J^T up to its diagonal, in the new order. */
static void list_products(struct lin_gram *s, const struct lin_sparse *J, const struct transpose *t)
{
    SGA_FREED int *rank = sga_malloc(((size_t)s->c + 1) * sizeof *rank);
    int count = 0;
    size_t cap = 0;
    for (int k = 0; k < s->c; k++)
        rank[s->order[k]] = k;
    for (int k = 0; k < s->c; k++) {
        int i = s->order[k];
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++)
            for (int q = t->ptr[J->col[e]]; q < t->ptr[J->col[e] + 1]; q++) {
                if (rank[t->row[q]] > k)
                    continue;
                SGA_RESERVE(s->product, cap, count + 1);
                s->product[count++] = (struct lin_product){ rank[t->row[q]], e, t->place[q] };
            }
        s->from[k + 1] = count;
    }
}

/* The columns of row k of L: from each column of J J^T up the elimination tree. Calls with `row`
 * NULL count; the result is how many there are, or more than `most`, of which no more are looked for. */
static double find_rows(struct lin_gram *s, int *parent, int *seen, int *fill, int *row, double most)
{
    double all = 0;
    for (int k = 0; k < s->c && all <= most; k++) {
        parent[k] = -1;
        seen[k] = k;
        for (int p = s->from[k]; p < s->from[k + 1]; p++)
            for (int i = s->product[p].j; seen[i] != k; i = parent[i]) {
                if (parent[i] < 0)
                    parent[i] = k;
                if (row)
                    row[s->column[i] + fill[i]] = k;
                fill[i]++;
                seen[i] = k;
                all++;
            }
    }
    return all;
}

static bool find_pattern(struct lin_gram *s, double most)
{
    size_t c = (size_t)s->c + 1;
    SGA_ARENA(mem);
    int *parent = sga_take(&mem, c * sizeof *parent), *seen = sga_take(&mem, c * sizeof *seen), *fill = sga_zeros(&mem, c, sizeof *fill);
    memset(seen, -1, c * sizeof *seen);
    double all = find_rows(s, parent, seen, fill, NULL, most);
    bool ok = all <= most;
    if (ok) {
        size_t nz = (size_t)all + 1;
        for (int i = 0; i < s->c; i++)
            s->column[i + 1] = s->column[i] + fill[i];
        s->row = sga_take(&s->mem, nz * sizeof *s->row);
        s->at = sga_take(&s->mem, nz * sizeof *s->at);
        s->place = sga_take(&s->mem, nz * sizeof *s->place);
        memset(seen, -1, c * sizeof *seen);
        memset(fill, 0, c * sizeof *fill);
        find_rows(s, parent, seen, fill, s->row, all);
        for (int i = 0; i < s->c; i++)
            for (int q = s->column[i]; q < s->column[i + 1]; q++)
                s->left[s->row[q] + 1]++;
        for (int k = 0; k < s->c; k++)
            s->left[k + 1] += s->left[k];
        memcpy(fill, s->left, (c - 1) * sizeof *fill);
        for (int i = 0; i < s->c; i++)
            for (int q = s->column[i]; q < s->column[i + 1]; q++) {
                int to = fill[s->row[q]]++;
                s->at[to] = i;
                s->place[to] = q;
            }
    }
    return ok;
}

bool lin_gram_init(struct lin_gram *s, const struct lin_sparse *J, struct lin_gram_most most)
{
    size_t c = (size_t)J->rows + 1;
    SGA_ENDS(transpose_clear) struct transpose t = transpose(J);
    *s = (struct lin_gram){ .c = J->rows };
    s->order = sga_take(&s->mem, c * sizeof *s->order);
    s->from = sga_zeros(&s->mem, c, sizeof *s->from);
    s->column = sga_zeros(&s->mem, c, sizeof *s->column);
    s->left = sga_zeros(&s->mem, c, sizeof *s->left);
    bool ok = !too_many_products(J, &t, most.products) && find_order(s, J, &t);
    if (ok) {
        list_products(s, J, &t);
        ok = find_pattern(s, (double)most.fill * J->ptr[s->c] + FREE);
    }
    if (!ok)
        lin_gram_clear(s);
    return ok;
}

void lin_gram_clear(struct lin_gram *s)
{
    free(s->product);
    sga_arena_end(&s->mem);
    *s = (struct lin_gram){ 0 };
}
