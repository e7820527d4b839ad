/* Hopcroft and Karp: shortest augmenting paths, a whole layer of them at a time. */
#include "graph.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"

struct search {
    const struct graph *g;
    int *of_row, *of_col;
    int *depth;            /* by row: layer, -1 out of reach */
    int *next;             /* by row: the edge to try next */
    int *list;             /* queue, then stack */
};

/* Layers of rows from the unmatched ones. True if an unmatched column is in reach. */
static int layers(struct search *s)
{
    int head = 0, tail = 0, found = 0;
    for (int i = 0; i < s->g->rows; i++) {
        s->depth[i] = s->of_row[i] < 0 ? 0 : -1;
        s->next[i] = s->g->start[i];
        if (s->of_row[i] < 0)
            s->list[tail++] = i;
    }
    while (head < tail) {
        int i = s->list[head++];
        for (int k = s->g->start[i]; k < s->g->start[i + 1]; k++) {
            int r = s->of_col[s->g->to[k]];
            if (r < 0) {
                found = 1;
            } else if (s->depth[r] < 0) {
                s->depth[r] = s->depth[i] + 1;
                s->list[tail++] = r;
            }
        }
    }
    return found;
}

/* One augmenting path from an unmatched row through the layers, depth first. */
static int augment(struct search *s, int root)
{
    int top = 0;
    s->list[top] = root;
    while (top >= 0) {
        int i = s->list[top];
        if (s->next[i] >= s->g->start[i + 1]) {
            s->depth[i] = -1;
            if (--top >= 0)
                s->next[s->list[top]]++;
            continue;
        }
        int r = s->of_col[s->g->to[s->next[i]]];
        if (r < 0) {       /* each row of the stack takes the column that it points to */
            for (; top >= 0; top--) {
                i = s->list[top];
                s->of_row[i] = s->g->to[s->next[i]];
                s->of_col[s->of_row[i]] = i;
            }
            return 1;
        }
        if (s->depth[r] == s->depth[i] + 1)
            s->list[++top] = r;
        else
            s->next[i]++;
    }
    return 0;
}

int graph_match(const struct graph *g, int *col_of_row, int *row_of_col)
{
    struct search s = { .g = g, .of_row = col_of_row, .of_col = row_of_col };
    size_t rows = (size_t)g->rows + 1;
    int size = 0;
    s.depth = sga_malloc(rows * sizeof *s.depth);
    s.next = sga_malloc(rows * sizeof *s.next);
    s.list = sga_malloc(rows * sizeof *s.list);
    for (int i = 0; i < g->rows; i++)
        col_of_row[i] = -1;
    for (int j = 0; j < g->cols; j++)
        row_of_col[j] = -1;
    while (layers(&s))
        for (int i = 0; i < g->rows; i++)
            if (col_of_row[i] < 0 && s.depth[i] == 0)
                size += augment(&s, i);
    free(s.depth);
    free(s.next);
    free(s.list);
    assert(size <= g->rows && size <= g->cols);
    return size;
}
