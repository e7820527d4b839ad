/* Tarjan's strong components with an explicit stack, and the block-triangular form. */
#include "graph.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"

struct tarjan {
    const struct graph *g;
    int *order, *low;      /* by vertex; order 0: not seen */
    int *edge;             /* by vertex: the next edge */
    int *call, *open;      /* stacks */
    int calls, opens, seen, found;
    int *component;
};

static void enter(struct tarjan *t, int v)
{
    t->order[v] = t->low[v] = ++t->seen;
    t->edge[v] = t->g->start[v];
    t->call[t->calls++] = v;
    t->open[t->opens++] = v;
}

static void leave(struct tarjan *t, int v)
{
    t->calls--;
    if (t->calls && t->low[v] < t->low[t->call[t->calls - 1]])
        t->low[t->call[t->calls - 1]] = t->low[v];
    if (t->low[v] != t->order[v])
        return;
    int w;
    do {
        w = t->open[--t->opens];
        t->component[w] = t->found;
    } while (w != v);
    t->found++;
}

int graph_strong(const struct graph *g, int *component)
{
    size_t n = (size_t)g->rows + 1;
    struct tarjan t = { .g = g, .component = component };
    t.order = sga_calloc(n, sizeof(int));
    t.low = sga_calloc(n, sizeof(int));
    t.edge = sga_calloc(n, sizeof(int));
    t.call = sga_malloc(n * sizeof(int));
    t.open = sga_malloc(n * sizeof(int));
    for (int i = 0; i < g->rows; i++)
        component[i] = -1;
    for (int root = 0; root < g->rows; root++) {
        if (!t.order[root])
            enter(&t, root);
        while (t.calls) {
            int v = t.call[t.calls - 1];
            if (t.edge[v] == g->start[v + 1]) {
                leave(&t, v);
                continue;
            }
            int w = g->to[t.edge[v]++];
            if (!t.order[w])
                enter(&t, w);
            else if (component[w] < 0 && t.order[w] < t.low[v])
                t.low[v] = t.order[w];
        }
    }
    free(t.order);
    free(t.low);
    free(t.edge);
    free(t.call);
    free(t.open);
    assert(t.found <= g->rows && !t.calls);
    return t.found;
}

int graph_blocks(const struct graph *g, const int *col_of_row, const int *row_of_col, int *block)
{
    int rows = 0, edges = 0;
    SGA_ARENA(mem);
    int *place = sga_take(&mem, ((size_t)g->rows + 1) * sizeof *place);
    int *start = sga_take(&mem, ((size_t)g->rows + 2) * sizeof *start);
    int *to = sga_take(&mem, ((size_t)g->start[g->rows] + 1) * sizeof *to);
    int *component = sga_take(&mem, ((size_t)g->rows + 1) * sizeof *component);
    for (int i = 0; i < g->rows; i++)
        place[i] = col_of_row[i] >= 0 ? rows++ : -1;
    rows = 0;
    for (int i = 0; i < g->rows; i++) {
        if (place[i] < 0)
            continue;
        start[rows++] = edges;
        for (int k = g->start[i]; k < g->start[i + 1]; k++)
            if (row_of_col[g->to[k]] >= 0)
                to[edges++] = place[row_of_col[g->to[k]]];
    }
    start[rows] = edges;
    int found = graph_strong(&(struct graph){ rows, rows, start, to }, component);
    for (int i = 0; i < g->rows; i++)
        block[i] = place[i] < 0 ? -1 : component[place[i]];
    assert(found <= rows);
    return found;
}
