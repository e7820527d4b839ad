/* Constraint values and sparse differentials in balls. */
#include "differentials.h"

#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "mem.h"
#include "points_space.h"

void points_jacobian_init(struct points_jacobian *j, const struct points_space *s)
{
    const struct expr_store *st = s->st;
    int c = s->constraints;
    *j = (struct points_jacobian){ .space = s };
    j->column = sga_take(&j->mem, (size_t)st->symbols * sizeof *j->column);
    for (int i = 0; i < st->symbols; i++)
        j->column[i] = -1;
    for (int i = 0; i < s->variables; i++)
        j->column[s->variable[i]] = i;
    j->cone = sga_zeros(&j->mem, (size_t)c, sizeof *j->cone);
    j->cone_len = sga_zeros(&j->mem, (size_t)c, sizeof *j->cone_len);
    j->col = sga_zeros(&j->mem, (size_t)c, sizeof *j->col);
    j->cols = sga_zeros(&j->mem, (size_t)c, sizeof *j->cols);
    j->entry = sga_zeros(&j->mem, (size_t)c, sizeof *j->entry);
    expr_cone_init(&j->all);
    for (int i = 0; i < c; i++) {
        expr_cone_of(st, &j->all, s->constraint + i, 1);
        size_t bytes = (size_t)j->all.count * sizeof(expr_id);
        j->cone[i] = memcpy(sga_take(&j->mem, bytes), j->all.list, bytes);
        j->cone_len[i] = j->all.count;
        j->col[i] = sga_take(&j->mem, (size_t)j->all.count * sizeof(int));
        for (int k = 0; k < j->all.count; k++) {
            expr_id e = j->all.list[k];
            if (expr_op_of(st, e) == EXPR_SYM && j->column[st->node[e].a] >= 0)
                j->col[i][j->cols[i]++] = j->column[st->node[e].a];
        }
        j->entry[i] = arbs_take(&j->mem, j->cols[i]);
    }
    expr_cone_of(st, &j->all, s->constraint, c);
    j->grad = arbs_take(&j->mem, s->variables);
}

void points_jacobian_clear(struct points_jacobian *j)
{
    expr_cone_clear(&j->all);
    num_ball_room_clear(&j->room);
    sga_arena_end(&j->mem);
}

void points_jacobian_values(struct points_jacobian *j, struct num_ball *ball)
{
    num_ball_list(ball, j->all.list, j->all.count);
}

void points_jacobian_row(struct points_jacobian *j, struct num_ball *ball, int i)
{
    for (int k = 0; k < j->cols[i]; k++)
        arb_zero(j->grad + j->col[i][k]);
    num_ball_gradient(ball, j->space->constraint[i], j->cone[i], j->cone_len[i], j->column, j->grad, &j->room);
}

void points_jacobian_entries(struct points_jacobian *j, struct num_ball *ball)
{
    for (int i = 0; i < j->space->constraints; i++) {
        points_jacobian_row(j, ball, i);
        for (int k = 0; k < j->cols[i]; k++)
            arb_swap(j->entry[i] + k, j->grad + j->col[i][k]);
    }
}

slong points_row_exponent(const struct points_jacobian *j, int i, const int *scale)
{
    slong e = -(WORD_MAX / 4);
    for (int k = 0; k < j->cols[i]; k++) {
        arb_srcptr v = j->entry[i] + k;
        if (!arb_is_finite(v) || arf_is_zero(arb_midref(v)))
            continue;
        slong x = num_ball_log2(arb_midref(v)) + (scale ? scale[j->col[i][k]] : 0);
        e = x > e ? x : e;
    }
    return e;
}

double points_scaled(const arb_t v, slong exponent)
{
    return num_ball_double(arb_midref(v), exponent);
}
