/* Incidence by value, blocks in solution order, and what each variable's motion needs. */
#include "structure_work.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "graph.h"
#include "mem.h"
#include "oracle.h"
#include "reduction.h"
#include "structure.h"
#include "system.h"

struct incidence {
    int *start, *to;
    size_t cap;
    int rows, edges;
};

static void begin(struct incidence *a, int rows)
{
    *a = (struct incidence){ .start = sga_calloc((size_t)rows + 2, sizeof(int)) };
}

static void push(struct incidence *a, int col)
{
    SGA_RESERVE(a->to, a->cap, a->edges + 1);
    a->to[a->edges++] = col;
}

static void end_row(struct incidence *a)
{
    a->start[++a->rows] = a->edges;
}

static void clear(struct incidence *a)
{
    free(a->start);
    free(a->to);
}

/* An entry that vanishes on Pf is none. */
static bool present(struct structure_work *w, expr_id e)
{
    return points_oracle_zero(w->oracle, e).truth != POINTS_ZERO;
}

/* Variables that e is made with, each once (mark is by variable: the row that saw it). */
static void push_variables(struct structure_work *w, struct incidence *a, expr_id e, int *mark, int stamp)
{
    const struct expr_store *st = w->sys->store;
    expr_cone_of(st, &w->cone, &e, 1);
    for (int k = 0; k < w->cone.count; k++) {
        if (expr_op_of(st, w->cone.list[k]) != EXPR_SYM || st->node[w->cone.list[k]].a >= w->symbols)
            continue;
        int j = w->column[st->node[w->cone.list[k]].a];
        if (j >= 0 && mark[j] != stamp) {
            mark[j] = stamp;
            push(a, j);
        }
    }
}

static int *fresh_marks(int n)
{
    int *mark = sga_malloc(((size_t)n + 1) * sizeof *mark);
    for (int j = 0; j < n; j++)
        mark[j] = -1;
    return mark;
}

/* The request's own equations: variable j is in equation i, derived or not. */
static void predict(struct structure_work *w, struct structure *out)
{
    int rows = w->sys->rows, n = w->sys->variables;
    SGA_ENDS(clear) struct incidence a;
    SGA_FREED int *mark = fresh_marks(n);
    begin(&a, rows);
    for (int i = 0; i < rows; i++) {
        const struct sys_row *r = w->sys->row + i;
        push_variables(w, &a, r->alpha, mark, i);
        for (int k = 0; k < r->entries; k++) {
            push_variables(w, &a, r->entry[k].value, mark, i);
            if (mark[r->entry[k].col] != i) {
                mark[r->entry[k].col] = i;
                push(&a, r->entry[k].col);
            }
        }
        end_row(&a);
    }
    struct graph g = { rows, n, a.start, a.to };
    SGA_ARENA(mem);
    int *of_row = sga_take(&mem, ((size_t)rows + 1) * sizeof *of_row), *of_col = sga_take(&mem, ((size_t)n + 1) * sizeof *of_col);
    out->row_part = sga_take(&out->mem, ((size_t)rows + 1) * sizeof *out->row_part);
    out->col_part = sga_take(&out->mem, ((size_t)n + 1) * sizeof *out->col_part);
    out->structural_rank = graph_match(&g, of_row, of_col);
    graph_coarse(&g, of_row, of_col, out->row_part, out->col_part);
}

/* The equations that became pivots, over the velocities; need: what else they are made with. */
static void motion_rows(struct structure_work *w, const int *source, int rows, struct incidence *a, struct incidence *need)
{
    SGA_FREED int *mark = fresh_marks(w->sys->variables);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    begin(a, rows);
    begin(need, rows);
    for (int i = 0; i < rows; i++) {
        if (source[i] < w->sys->rows) {
            const struct sys_row *r = w->sys->row + source[i];
            push_variables(w, need, r->alpha, mark, i);
            for (int k = 0; k < r->entries; k++) {
                push_variables(w, need, r->entry[k].value, mark, i);
                if (present(w, r->entry[k].value))
                    push(a, r->entry[k].col);
            }
        } else {
            expr_id e = w->sol->constraint[source[i] - w->sys->rows].expr;
            int n = expr_gradient(w->sys->store, &w->cone, e, w->active, &term, &cap);
            push_variables(w, need, e, mark, i);
            for (int k = 0; k < n; k++)
                if (present(w, term[k].value))
                    push(a, w->column[term[k].symbol]);
        }
        end_row(a);
        end_row(need);
    }
}

/* Members of each class, in order. */
static void group(struct sga_arena *mem, const int *of, int n, int groups, struct structure_group *g)
{
    g->groups = groups;
    g->first = sga_zeros(mem, (size_t)groups + 2, sizeof *g->first);
    g->member = sga_take(mem, ((size_t)n + 1) * sizeof *g->member);
    for (int j = 0; j < n; j++)
        g->first[of[j] + 2]++;
    for (int k = 2; k <= groups + 1; k++)
        g->first[k] += g->first[k - 1];
    for (int j = 0; j < n; j++)
        g->member[g->first[of[j] + 1]++] = j;
    assert(groups == 0 || g->first[groups] == n);
}

/* Variable v needs whatever is in the equation that v' is matched with. */
static void motion(struct structure *out, const struct incidence *a, const struct incidence *need, const int *of_col, int n)
{
    SGA_ENDS(clear) struct incidence v;
    begin(&v, n);
    for (int j = 0; j < n; j++) {
        int i = of_col[j];
        for (int k = i < 0 ? 0 : a->start[i]; i >= 0 && k < a->start[i + 1]; k++)
            push(&v, a->to[k]);
        for (int k = i < 0 ? 0 : need->start[i]; i >= 0 && k < need->start[i + 1]; k++)
            push(&v, need->to[k]);
        end_row(&v);
    }
    out->motion_group = sga_take(&out->mem, ((size_t)n + 1) * sizeof(int));
    int groups = graph_strong(&(struct graph){ n, n, v.start, v.to }, out->motion_group);
    group(&out->mem, out->motion_group, n, groups, &out->motion);
    SGA_FREED int *mark = fresh_marks(groups);
    struct incidence g;
    begin(&g, groups);
    for (int q = 0; q < groups; q++) {
        for (int m = out->motion.first[q]; m < out->motion.first[q + 1]; m++) {
            int j = out->motion.member[m];
            for (int k = v.start[j]; k < v.start[j + 1]; k++) {
                int other = out->motion_group[v.to[k]];
                if (other == q || mark[other] == q)
                    continue;
                mark[other] = q;
                push(&g, other);
            }
        }
        end_row(&g);
    }
    out->need_first = sga_keep(&out->mem, g.start);
    out->need = sga_keep(&out->mem, g.to);
}

void structure_blocks(struct structure_work *w, struct structure *out)
{
    int n = w->sys->variables, rows = 0;
    predict(w, out);
    if (w->sol->verdict == SGA_INCONSISTENT)
        return;
    SGA_ARENA(mem);
    int *source = sga_take(&mem, ((size_t)w->sol->pivots + 1) * sizeof *source);
    for (int q = 0; q < w->sol->pivots; q++)
        if (w->sol->pivot[q].col >= 0)
            source[rows++] = w->sol->pivot[q].source;
    SGA_ENDS(clear) struct incidence a, need;
    motion_rows(w, source, rows, &a, &need);
    struct graph g = { rows, n, a.start, a.to };
    int *of_row = sga_take(&mem, ((size_t)rows + 1) * sizeof *of_row), *of_col = sga_take(&mem, ((size_t)n + 1) * sizeof *of_col);
    int *block = sga_take(&mem, ((size_t)rows + 1) * sizeof *block);
    graph_match(&g, of_row, of_col);
    out->blocks = graph_blocks(&g, of_row, of_col, block);
    out->block = sga_take(&out->mem, ((size_t)n + 1) * sizeof *out->block);
    out->matched = sga_take(&out->mem, ((size_t)n + 1) * sizeof *out->matched);
    for (int j = 0; j < n; j++) {
        out->block[j] = of_col[j] < 0 ? -1 : block[of_col[j]];
        out->matched[j] = of_col[j] < 0 ? -1 : source[of_col[j]];
    }
    motion(out, &a, &need, of_col, n);
}
