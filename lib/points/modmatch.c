/* Matching by shape. */
#include "modmatch.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "points_space.h"
#include "shape.h"

enum { UNKNOWN = -2, GUESSED = -1 };

/* Steps of all ties together: what a tie follows from may be nearly all that was matched before. */
enum { TIE_STEPS = 20000000 };

struct match {
    struct sga_arena *mem;
    const struct points_space *s;
    int *start, *variable; size_t cap; int held;   /* by constraint: the variables that it contains ... */
    unsigned char *shape;                          /* ... and how */
    unsigned char *hidden;                         /* by variable: in some constraint under a function that is not algebraic */
    int *by, *since;                               /* by variable: the constraint that it is solved from; when it became known */
    unsigned char *tied;
    int *solved, now;
    int *in, *in_start;                            /* by variable: the constraints that contain it */
    int *left, *worth, *place;                     /* by constraint that waits: variables left, what speaks against the best, its place or -1 */
    int *heap, *at, waiting;                       /* those, the next one first; by constraint: its place there, -1: matched */
    int *stack, *seen, ties; long steps;           /* of ties */
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
        points_shapes(s->st, &cone, here);
        for (int k = 0; k < cone.count; k++) {
            const struct expr_node n = s->st->node[cone.list[k]];
            int v = n.op == EXPR_SYM ? variable_of[n.a] : -1;
            if (v < 0)
                continue;
            SGA_RESERVE_IN(m->mem, m->variable, m->cap, m->held + 1);
            SGA_RESERVE_IN(m->mem, m->shape, shape_cap, m->held + 1);
            m->shape[m->held] = here[k];
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

/* Whether constraint i is matched before k: fewer variables left, then the better one to be solved for, then the first. */
static bool sooner(const struct match *m, int i, int k)
{
    if (m->left[i] != m->left[k])
        return m->left[i] < m->left[k];
    return m->worth[i] != m->worth[k] ? m->worth[i] < m->worth[k] : i < k;
}

static void put(struct match *m, int at, int i)
{
    m->heap[at] = i;
    m->at[i] = at;
}

static void rise(struct match *m, int at)
{
    int i = m->heap[at];
    for (; at && sooner(m, i, m->heap[(at - 1) / 2]); at = (at - 1) / 2)
        put(m, at, m->heap[(at - 1) / 2]);
    put(m, at, i);
}

static void sink(struct match *m, int at)
{
    int i = m->heap[at];
    for (int child = 2 * at + 1; child < m->waiting; child = 2 * at + 1) {
        child += child + 1 < m->waiting && sooner(m, m->heap[child + 1], m->heap[child]);
        if (!sooner(m, m->heap[child], i))
            break;
        put(m, at, m->heap[child]);
        at = child;
    }
    put(m, at, i);
}

/* Counts constraint i anew; it goes where that puts it. */
static void count_anew(struct match *m, int i)
{
    int best;
    m->left[i] = left_in(m, i, &best);
    m->place[i] = best;
    m->worth[i] = best < 0 ? 0 : against(m, best);
    if (m->at[i] >= 0) {
        rise(m, m->at[i]);
        sink(m, m->at[i]);
    }
}

/* All constraints wait, the next one first. */
static void queue_all(struct match *m)
{
    int c = m->s->constraints;
    for (int k = 0; k < m->held; k++)
        m->in_start[m->variable[k] + 1]++;
    for (int v = 0; v < m->s->variables; v++)
        m->in_start[v + 1] += m->in_start[v];
    int *end = sga_take(m->mem, ((size_t)m->s->variables + 1) * sizeof *end);
    memcpy(end, m->in_start, ((size_t)m->s->variables + 1) * sizeof *end);
    for (int i = 0; i < c; i++) {
        for (int k = m->start[i]; k < m->start[i + 1]; k++)
            m->in[end[m->variable[k]]++] = i;
        m->at[i] = -1;
        count_anew(m, i);
        put(m, i, i);
    }
    m->waiting = c;
    for (int at = c / 2 - 1; at >= 0; at--)
        sink(m, at);
}

static int next_constraint(struct match *m)
{
    assert(m->waiting > 0);
    int next = m->heap[0];
    m->at[next] = -1;
    if (--m->waiting) {
        put(m, 0, m->heap[m->waiting]);
        sink(m, 0);
    }
    return next;
}

/* The last free variable that constraint i follows from; -1: there is none, or so many steps were taken that no more are. */
static int tie(struct match *m, int i)
{
    int depth = 0, best = -1;
    m->stack[depth++] = i;
    m->seen[i] = ++m->ties;
    while (depth) {
        int j = m->stack[--depth];
        if ((m->steps -= m->start[j + 1] - m->start[j]) < 0)
            return -1;
        for (int k = m->start[j]; k < m->start[j + 1]; k++) {
            int v = m->variable[k], by = m->by[v];
            if (by >= 0 && m->seen[by] != m->ties) {
                m->seen[by] = m->ties;
                m->stack[depth++] = by;
            }
            if (by == GUESSED && !m->tied[v] && !m->hidden[v] && (best < 0 || m->since[v] > m->since[best]))
                best = v;
        }
    }
    return best;
}

static bool match_next(struct match *m)
{
    int i = next_constraint(m), place = m->place[i], first = m->now;
    for (int k = m->start[i]; k < m->start[i + 1]; k++) {
        int v = m->variable[k];
        if (m->by[v] != UNKNOWN)
            continue;
        m->by[v] = k == place ? i : GUESSED;
        m->since[v] = m->now++;
    }
    for (int k = m->start[i]; k < m->start[i + 1]; k++)
        for (int v = m->variable[k], e = m->in_start[v]; m->since[v] >= first && e < m->in_start[v + 1]; e++)
            if (m->at[m->in[e]] >= 0)
                count_anew(m, m->in[e]);
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
                       .in_start = sga_zeros(&mem, n, sizeof *m.in_start), .left = sga_zeros(&mem, c, sizeof *m.left),
                       .worth = sga_zeros(&mem, c, sizeof *m.worth), .place = sga_zeros(&mem, c, sizeof *m.place),
                       .heap = sga_zeros(&mem, c, sizeof *m.heap), .at = sga_zeros(&mem, c, sizeof *m.at),
                       .stack = sga_zeros(&mem, c, sizeof *m.stack), .seen = sga_zeros(&mem, c, sizeof *m.seen), .steps = TIE_STEPS };
    int *variable_of = sga_take(&mem, ((size_t)s->st->symbols + 1) * sizeof *variable_of);
    for (int i = 0; i < s->st->symbols; i++)
        variable_of[i] = -1;
    for (int j = 0; j < s->variables; j++) {
        variable_of[s->variable[j]] = j;
        m.by[j] = UNKNOWN;
    }
    read_shapes(&m, variable_of);
    m.in = sga_zeros(&mem, (size_t)m.held + 1, sizeof *m.in);
    queue_all(&m);
    bool ok = true;
    for (int k = 0; k < s->constraints && ok; k++)
        ok = match_next(&m);
    return ok;
}
