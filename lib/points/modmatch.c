/* Matching by shape. */
#include "modmatch.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "shape.h"

enum { UNKNOWN = -2, GUESSED = -1 };

struct match {
    struct sga_arena *mem;
    const struct points_space *s;
    int *start, *variable; size_t cap; int held;   /* by constraint: the variables that it contains ... */
    unsigned char *shape;                          /* ... and how */
    unsigned char *hidden;                         /* by variable: in some constraint under a function that is not algebraic */
    int *by, *since;                               /* by variable: the constraint that it is solved from; when it became known */
    unsigned char *tied, *done;
    int *solved, now;
};

static void read_shapes(struct match *m, int *variable_of)
{
    const struct points_space *s = m->s;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED unsigned char *here = NULL;
    size_t here_cap = 0, shape_cap = 0;
    expr_cone_init(&cone);
    for (int i = 0; i < s->constraints; i++) {
        m->start[i] = m->held;
        expr_cone_of(s->st, &cone, s->constraint + i, 1);
        expr_cone_index(&cone);
        SGA_RESERVE(here, here_cap, cone.count);
        for (int k = 0; k < cone.count; k++) {
            const struct expr_node n = s->st->node[cone.list[k]];
            int v = n.op == EXPR_SYM ? variable_of[n.a] : -1;
            if (v < 0)
                continue;
            SGA_RESERVE_IN(m->mem, m->variable, m->cap, m->held + 1);
            SGA_RESERVE_IN(m->mem, m->shape, shape_cap, m->held + 1);
            m->shape[m->held] = (unsigned char)points_shape_in(s->st, &cone, n.a, here);
            m->hidden[v] |= m->shape[m->held] == POINTS_HIDDEN;
            m->variable[m->held++] = v;
        }
    }
    m->start[s->constraints] = m->held;
}

/* What speaks against solving for the variable at this place. */
static int against(const struct match *m, int k)
{
    return 2 * m->shape[k] + m->hidden[m->variable[k]];
}

/* How many variables of constraint i are left, and the place of the best of them or -1. */
static int left_in(const struct match *m, int i, int *best)
{
    int left = 0;
    *best = -1;
    for (int k = m->start[i]; k < m->start[i + 1]; k++) {
        if (m->by[m->variable[k]] != UNKNOWN)
            continue;
        left++;
        if (m->shape[k] != POINTS_HIDDEN && (*best < 0 || against(m, k) < against(m, *best)))
            *best = k;
    }
    return left;
}

static int next_constraint(const struct match *m, int *place)
{
    int next = -1, least = 0, cost = 0, best = -1;
    for (int i = 0; i < m->s->constraints; i++) {
        int left = m->done[i] ? -1 : left_in(m, i, &best), worth = best < 0 ? 0 : against(m, best);
        if (left < 0 || (next >= 0 && (left > least || (left == least && worth >= cost))))
            continue;
        next = i;
        least = left;
        cost = worth;
        *place = best;
    }
    return next;
}

/* The last free variable that constraint i follows from; -1: there is none. */
static int tie(const struct match *m, int i)
{
    SGA_ARENA(mem);
    int c = m->s->constraints, depth = 0, best = -1, *stack = sga_take(&mem, ((size_t)c + 1) * sizeof *stack);
    unsigned char *seen = sga_zeros(&mem, (size_t)c + 1, 1);
    stack[depth++] = i;
    seen[i] = 1;
    while (depth) {
        int j = stack[--depth];
        for (int k = m->start[j]; k < m->start[j + 1]; k++) {
            int v = m->variable[k], by = m->by[v];
            if (by >= 0 && !seen[by]) {
                seen[by] = 1;
                stack[depth++] = by;
            }
            if (by == GUESSED && !m->tied[v] && !m->hidden[v] && (best < 0 || m->since[v] > m->since[best]))
                best = v;
        }
    }
    return best;
}

static bool match_next(struct match *m)
{
    int place = -1, i = next_constraint(m, &place);
    m->done[i] = 1;
    for (int k = m->start[i]; k < m->start[i + 1]; k++) {
        int v = m->variable[k];
        if (m->by[v] != UNKNOWN)
            continue;
        m->by[v] = k == place ? i : GUESSED;
        m->since[v] = m->now++;
    }
    m->solved[i] = place >= 0 ? m->variable[place] : tie(m, i);
    if (place < 0 && m->solved[i] >= 0)
        m->tied[m->solved[i]] = 1;
    return m->solved[i] >= 0;
}

bool points_match_by_shape(const struct points_space *s, int *solved)
{
    size_t c = (size_t)s->constraints + 1, n = (size_t)s->variables + 1;
    SGA_ARENA(mem);
    struct match m = { .mem = &mem, .s = s, .solved = solved, .start = sga_zeros(&mem, c, sizeof *m.start), .hidden = sga_zeros(&mem, n, 1),
                       .by = sga_take(&mem, n * sizeof *m.by), .since = sga_zeros(&mem, n, sizeof *m.since), .tied = sga_zeros(&mem, n, 1),
                       .done = sga_zeros(&mem, c, 1) };
    int *variable_of = sga_take(&mem, ((size_t)s->st->symbols + 1) * sizeof *variable_of);
    for (int i = 0; i < s->st->symbols; i++)
        variable_of[i] = -1;
    for (int j = 0; j < s->variables; j++) {
        variable_of[s->variable[j]] = j;
        m.by[j] = UNKNOWN;
    }
    read_shapes(&m, variable_of);
    bool ok = true;
    for (int k = 0; k < s->constraints && ok; k++)
        ok = match_next(&m);
    return ok;
}
