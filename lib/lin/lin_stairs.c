/* Group by group; see the header. */
#include "lin_stairs.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lin_normal.h"
#include "lin_sparse.h"

static void new_columns(struct lin_stairs *s, const int *group)
{
    const struct lin_sparse *J = s->J;
    s->of_column = sga_take(&s->mem, ((size_t)J->cols + 1) * sizeof *s->of_column);
    memset(s->of_column, -1, ((size_t)J->cols + 1) * sizeof *s->of_column);
    for (int i = 0; i < J->rows; i++)
        for (int e = J->ptr[i]; e < J->ptr[i + 1]; e++) {
            int *of = s->of_column + J->col[e], g = group ? group[i] : 0;
            if (*of < 0 || g < *of)
                *of = g;
        }
}

/* The block of one group on the diagonal. place (columns): work. False: it cannot have independent rows. */
static bool take_block(struct lin_stairs *s, int g, const int *group, int *place)
{
    const struct lin_sparse *J = s->J;
    struct lin_stair *m = s->at + g;
    SGA_ARENA(mem);
    int rows = 0, cols = 0, entries = 0;
    m->row = sga_take(&s->mem, ((size_t)J->rows + 1) * sizeof *m->row);
    for (int i = 0; i < J->rows; i++)
        if (!group || group[i] == g)
            m->row[rows++] = i;
    for (int j = 0; j < J->cols; j++)
        cols += s->of_column[j] == g;
    m->col = sga_take(&s->mem, ((size_t)cols + 1) * sizeof *m->col);
    cols = 0;
    for (int j = 0; j < J->cols; j++)
        if (s->of_column[j] == g) {
            place[j] = cols;
            m->col[cols++] = j;
        }
    int *ptr = sga_zeros(&mem, (size_t)rows + 1, sizeof *ptr);
    for (int i = 0; i < rows; i++) {
        for (int e = J->ptr[m->row[i]]; e < J->ptr[m->row[i] + 1]; e++)
            entries += s->of_column[J->col[e]] == g;
        if (entries == ptr[i])
            return false;
        ptr[i + 1] = entries;
    }
    m->entry = sga_take(&s->mem, ((size_t)entries + 1) * sizeof *m->entry);
    int *col = sga_take(&mem, ((size_t)entries + 1) * sizeof *col);
    entries = 0;
    for (int i = 0; i < rows; i++)
        for (int e = J->ptr[m->row[i]]; e < J->ptr[m->row[i] + 1]; e++)
            if (s->of_column[J->col[e]] == g) {
                m->entry[entries] = e;
                col[entries++] = place[J->col[e]];
            }
    if (rows > cols)
        return false;
    m->M = lin_sparse_new(rows, cols, ptr, col);
    for (int e = 0; e < entries; e++)
        m->M->val[e] = J->val[m->entry[e]];
    return true;
}

bool lin_stairs_init(struct lin_stairs *s, const struct lin_sparse *J, const int *group, int groups)
{
    *s = (struct lin_stairs){ .J = J, .groups = group ? groups : 1 };
    assert(s->groups >= 1);
    s->at = sga_zeros(&s->mem, (size_t)s->groups, sizeof *s->at);
    s->work = sga_take(&s->mem, (size_t)(J->rows + J->cols + 1) * sizeof *s->work);
    new_columns(s, group);
    SGA_ARENA(mem);
    int *place = sga_take(&mem, ((size_t)J->cols + 1) * sizeof *place);
    bool ok = true;
    for (int g = 0; g < s->groups && ok; g++)
        ok = take_block(s, g, group, place);
    return ok;
}

void lin_stairs_clear(struct lin_stairs *s)
{
    for (int g = 0; g < s->groups; g++) {
        lin_sparse_free(s->at[g].M);
        lin_normal_free(s->at[g].normal);
    }
    sga_arena_end(&s->mem);
    *s = (struct lin_stairs){ 0 };
}

void lin_stairs_take(struct lin_stairs *s)
{
    for (int g = 0; g < s->groups; g++) {
        const struct lin_stair *m = s->at + g;
        for (int e = 0; e < m->M->ptr[m->M->rows]; e++)
            m->M->val[e] = s->J->val[m->entry[e]];
    }
}

bool lin_stairs_factor(struct lin_stairs *s, double least)
{
    bool ok = true;
    for (int g = 0; g < s->groups && ok; g++) {
        struct lin_stair *m = s->at + g;
        if (!m->normal)
            m->normal = lin_normal_new(m->M);
        ok = m->normal && lin_normal_factor(m->normal, m->M->val, least);
    }
    return ok;
}

bool lin_stairs_solve(struct lin_stairs *s, const double *r, double *d)
{
    const struct lin_sparse *J = s->J;
    bool ok = true;
    memset(d, 0, (size_t)J->cols * sizeof *d);
    for (int g = 0; g < s->groups && ok; g++) {
        const struct lin_stair *m = s->at + g;
        double *left = s->work, *by = s->work + m->M->rows;
        for (int i = 0; i < m->M->rows; i++) {
            left[i] = r[m->row[i]];
            for (int e = J->ptr[m->row[i]]; e < J->ptr[m->row[i] + 1]; e++)
                left[i] += J->val[e] * d[J->col[e]];      /* of this group's own columns d is still 0 */
        }
        ok = lin_normal_solve(m->normal, m->M->val, left, by);
        for (int j = 0; j < m->M->cols; j++)
            d[m->col[j]] = by[j];
    }
    return ok;
}
