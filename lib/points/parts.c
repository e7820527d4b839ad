/* Parts that share no variable, by union of the constraints' variables. */
#include "parts.h"

#include <assert.h>
#include <math.h>

#include "points_space.h"

enum { LARGE = 40 };           /* constraints */
/* As in find.c: residuals that count as 0, and steps of this many times the largest variable. */
static const double MET = 1e-12, FAR = 4;

static int root_of(int *up, int i)
{
    while (up[i] != i)
        i = up[i] = up[up[i]];
    return i;
}

void points_parts_init(struct points_parts *q, const struct points_jacobian *j)
{
    const struct points_space *s = j->space;
    int c = s->constraints, n = s->variables;
    *q = (struct points_parts){ 0 };
    if (c <= LARGE)
        return;
    SGA_ARENA(mem);
    int *up = sga_take(&mem, (size_t)n * sizeof *up), *number = sga_take(&mem, (size_t)n * sizeof *number), count = 0;
    for (int v = 0; v < n; v++) {
        up[v] = v;
        number[v] = -1;
    }
    for (int i = 0; i < c; i++)
        for (int k = 1; k < j->cols[i]; k++)
            up[root_of(up, j->col[i][k])] = root_of(up, j->col[i][0]);
    for (int i = 0; i < c; i++) {
        int r = j->cols[i] ? root_of(up, j->col[i][0]) : -1;
        if (r < 0)
            return;            /* a constraint without variables */
        if (number[r] < 0)
            number[r] = count++;
    }
    if (count < 2)
        return;
    q->count = count;
    q->of_constraint = sga_take(&q->mem, (size_t)c * sizeof *q->of_constraint);
    q->of_variable = sga_take(&q->mem, (size_t)n * sizeof *q->of_variable);
    q->residual = sga_zeros(&q->mem, (size_t)count, sizeof *q->residual);
    q->length = sga_zeros(&q->mem, (size_t)count, sizeof *q->length);
    q->size = sga_zeros(&q->mem, (size_t)count, sizeof *q->size);
    q->kept = sga_zeros(&q->mem, (size_t)n, sizeof *q->kept);
    q->met = sga_zeros(&q->mem, (size_t)count, 1);
    for (int i = 0; i < c; i++)
        q->of_constraint[i] = number[root_of(up, j->col[i][0])];
    for (int v = 0; v < n; v++)
        q->of_variable[v] = number[root_of(up, v)];
}

void points_parts_clear(struct points_parts *q)
{
    sga_arena_end(&q->mem);
}

void points_parts_damp(struct points_parts *q, const struct points_space *s, const struct points_point *p, const int *scale, const double *d)
{
    assert(q->count > 1);
    for (int k = 0; k < q->count; k++) {
        q->length[k] = 0;
        q->size[k] = 1;
    }
    for (int v = 0; v < s->variables; v++) {
        int k = q->of_variable[v];
        if (k < 0)
            continue;
        q->length[k] = fmax(q->length[k], fabs(d[v]));
        q->size[k] = fmax(q->size[k], scale ? ldexp(fabs(p->x[v]), -scale[v]) : fabs(p->x[v]));
    }
    for (int k = 0; k < q->count; k++)
        q->length[k] = q->length[k] > FAR * q->size[k] ? FAR * q->size[k] / q->length[k] : 1;
}

void points_parts_keep(struct points_parts *q, const struct points_space *s, const struct points_point *p)
{
    for (int k = 0; k < q->count; k++)
        q->met[k] = q->residual[k] < MET;
    for (int v = 0; v < s->variables && q->count; v++)
        q->kept[v] = p->x[v];
}

void points_parts_restore(const struct points_parts *q, const struct points_space *s, struct points_point *p)
{
    for (int v = 0; v < s->variables && q->count; v++) {
        if (q->of_variable[v] < 0 || !q->met[q->of_variable[v]])
            continue;
        p->x[v] = q->kept[v];
        num_ball_set_d(&p->ball, s->variable[v], p->x[v]);
    }
}
