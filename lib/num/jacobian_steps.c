/* The part of a tape that a Jacobian runs over: instructions that depend on a column. */
#include "jacobian_plan.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "jacobian.h"
#include "mem.h"

static void add_solve(struct num_jacobian_plan *p, int index, const int *id, int own)
{
    struct jacobian_solve *q = p->solve + index;
    struct tape_solve *s = p->tape->solve + index;
    size_t cap = 0;
    *q = (struct jacobian_solve){ .of = s, .id = own };
    for (int row = 0; row < s->m; row++)
        for (int col = -1; col < s->m; col++) {
            int from = id[col < 0 ? s->rhs[row] : s->matrix[row * s->m + col]];
            if (from == p->sink)
                continue;
            SGA_RESERVE_IN(&p->mem, q->edge, cap, q->edges + 1);
            q->edge[q->edges].row = row;
            q->edge[q->edges].col = col;
            q->edge[q->edges++].id = from;
        }
    q->bar = sga_zeros(&p->mem, (size_t)s->m, sizeof *q->bar);
    q->work = sga_zeros(&p->mem, (size_t)s->m, sizeof *q->work);
}

static bool solve_active(const struct tape_solve *s, const int *id, int sink)
{
    bool active = false;
    for (int i = 0; i < s->m && !active; i++)
        active = id[s->rhs[i]] != sink;
    for (int i = 0; i < s->m * s->m && !active; i++)
        active = id[s->matrix[i]] != sink;
    return active;
}

/* One instruction: becomes a step if it depends on a column. id is by slot; the sink's
 * number is not known before all steps are, so until then it is -1. */
static void add_step(struct num_jacobian_plan *p, int cols, int slot, int *id)
{
    const struct num_tape *t = p->tape;
    const struct tape_code *c = t->code + slot - t->code_slot;
    struct jacobian_step s = { .op = c->op, .slot = slot, .a = c->a, .b = c->b };
    bool active;
    if (c->op == TAPE_FACTOR) {
        active = solve_active(t->solve + c->a, id, -1);
    } else if (c->op == TAPE_COMPONENT) {
        active = id[t->solve[c->a].slot] >= 0;
    } else {
        bool two = c->op < EXPR_OP_COUNT && expr_op_args((enum expr_op)c->op) == 2;
        s.a = id[c->op == TAPE_PAIRED ? c[-1].a : c->a];
        s.b = two ? id[c->b] : -1;
        active = s.a >= 0 || s.b >= 0;
    }
    if (!active)
        return;
    id[slot] = cols + p->steps;
    p->step[p->steps++] = s;
}

void jacobian_steps(struct num_jacobian *j, const int *columns)
{
    struct num_jacobian_plan *p = j->plan;
    const struct num_tape *t = p->tape;
    SGA_FREED int *id = sga_malloc(((size_t)t->slots + 1) * sizeof *id);
    assert(j->cols >= 0 && j->rows == t->nroots);
    memset(id, -1, ((size_t)t->slots + 1) * sizeof *id);
    for (int c = 0; c < j->cols; c++)
        id[columns ? columns[c] : c] = c;
    p->step = sga_take(&p->mem, ((size_t)t->ncode + 1) * sizeof *p->step);
    for (int slot = t->code_slot + t->nstatic; slot < t->slots; slot++)
        add_step(p, j->cols, slot, id);
    p->sink = j->cols + p->steps;
    assert(p->steps <= t->ncode - t->nstatic);
    for (int slot = 0; slot < t->slots; slot++)
        id[slot] = id[slot] < 0 ? p->sink : id[slot];
    for (int i = 0; i < p->steps; i++) {
        struct jacobian_step *s = p->step + i;
        if (s->op == TAPE_FACTOR || s->op == TAPE_COMPONENT)
            continue;
        s->a = s->a < 0 ? p->sink : s->a;
        s->b = s->b < 0 ? p->sink : s->b;
    }
    p->solves = t->nsolves;
    p->solve = sga_zeros(&p->mem, (size_t)p->solves + 1, sizeof *p->solve);
    for (int k = 0; k < p->solves; k++)
        add_solve(p, k, id, id[t->solve[k].slot]);
    p->root = sga_take(&p->mem, ((size_t)t->nroots + 1) * sizeof *p->root);
    for (int r = 0; r < t->nroots; r++)
        p->root[r] = id[t->root[r]];
}
