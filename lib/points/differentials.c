/* Constraint values and sparse differentials in balls. */
#include "differentials.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"

void points_jacobian_init(struct points_jacobian *j, const struct points_space *s)
{
    const struct expr_store *st = s->st;
    int c = s->constraints;
    *j = (struct points_jacobian){ .space = s };
    j->column = sga_malloc((size_t)st->symbols * sizeof *j->column);
    for (int i = 0; i < st->symbols; i++)
        j->column[i] = -1;
    for (int i = 0; i < s->variables; i++)
        j->column[s->variable[i]] = i;
    j->cone = sga_calloc((size_t)c, sizeof *j->cone);
    j->cone_len = sga_calloc((size_t)c, sizeof *j->cone_len);
    j->col = sga_calloc((size_t)c, sizeof *j->col);
    j->cols = sga_calloc((size_t)c, sizeof *j->cols);
    j->entry = sga_calloc((size_t)c, sizeof *j->entry);
    expr_cone_init(&j->all);
    for (int i = 0; i < c; i++) {
        expr_cone_of(st, &j->all, s->constraint + i, 1);
        size_t bytes = (size_t)j->all.count * sizeof(expr_id);
        j->cone[i] = memcpy(sga_malloc(bytes), j->all.list, bytes);
        j->cone_len[i] = j->all.count;
        j->col[i] = sga_malloc((size_t)j->all.count * sizeof(int));
        for (int k = 0; k < j->all.count; k++) {
            expr_id e = j->all.list[k];
            if (expr_op_of(st, e) == EXPR_SYM && j->column[st->node[e].a] >= 0)
                j->col[i][j->cols[i]++] = j->column[st->node[e].a];
        }
        j->entry[i] = _arb_vec_init(j->cols[i]);
    }
    expr_cone_of(st, &j->all, s->constraint, c);
    j->grad = _arb_vec_init(s->variables);
    j->scratch_len = st->nodes;
    j->scratch = _arb_vec_init(st->nodes);
}

void points_jacobian_clear(struct points_jacobian *j)
{
    for (int i = 0; i < j->space->constraints; i++) {
        _arb_vec_clear(j->entry[i], j->cols[i]);
        free(j->cone[i]);
        free(j->col[i]);
    }
    _arb_vec_clear(j->grad, j->space->variables);
    _arb_vec_clear(j->scratch, j->scratch_len);
    expr_cone_clear(&j->all);
    free(j->cone);
    free(j->cone_len);
    free(j->col);
    free(j->cols);
    free(j->entry);
    free(j->column);
}

void points_jacobian_values(struct points_jacobian *j, struct num_ball *ball)
{
    num_ball_list(ball, j->all.list, j->all.count);
}

void points_jacobian_entries(struct points_jacobian *j, struct num_ball *ball)
{
    for (int i = 0; i < j->space->constraints; i++) {
        for (int k = 0; k < j->cols[i]; k++)
            arb_zero(j->grad + j->col[i][k]);
        num_ball_gradient(ball, j->space->constraint[i], j->cone[i], j->cone_len[i], j->column, j->grad, j->scratch);
        for (int k = 0; k < j->cols[i]; k++)
            arb_set(j->entry[i] + k, j->grad + j->col[i][k]);
    }
}
