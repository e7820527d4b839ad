/* The coarse parts of Dulmage and Mendelsohn: what alternating paths reach from the
 * unmatched columns, and from the unmatched rows. */
#include "graph.h"

#include <stdlib.h>

#include "arena.h"
#include "mem.h"

/* The graph by columns. */
static void transpose(const struct graph *g, int **start, int **to)
{
    int *s = sga_calloc((size_t)g->cols + 2, sizeof *s);
    int *t = sga_malloc(((size_t)g->start[g->rows] + 1) * sizeof *t);
    for (int k = 0; k < g->start[g->rows]; k++)
        s[g->to[k] + 2]++;
    for (int j = 2; j <= g->cols + 1; j++)
        s[j] += s[j - 1];
    for (int i = 0; i < g->rows; i++)       /* s[j + 1] walks from the start of j to its end */
        for (int k = g->start[i]; k < g->start[i + 1]; k++)
            t[s[g->to[k] + 1]++] = i;
    *start = s;
    *to = t;
}

/* From unmatched vertices of one side along edges to the other and back along the matching. */
static void reach(const struct graph *g, const int *own, const int *other, enum graph_part part,
                  enum graph_part *own_part, enum graph_part *other_part)
{
    SGA_FREED int *list = sga_malloc(((size_t)g->rows + 1) * sizeof *list);
    int tail = 0;
    for (int i = 0; i < g->rows; i++)
        if (own[i] < 0) {
            own_part[i] = part;
            list[tail++] = i;
        }
    for (int head = 0; head < tail; head++) {
        int i = list[head];
        for (int k = g->start[i]; k < g->start[i + 1]; k++) {
            int j = g->to[k];
            if (other_part[j] == part)
                continue;
            other_part[j] = part;
            own_part[other[j]] = part;      /* the matching is largest: j is matched */
            list[tail++] = other[j];
        }
    }
}

void graph_coarse(const struct graph *g, const int *col_of_row, const int *row_of_col,
                  enum graph_part *row_part, enum graph_part *col_part)
{
    SGA_FREED int *start = NULL, *to = NULL;
    for (int i = 0; i < g->rows; i++)
        row_part[i] = GRAPH_WELL;
    for (int j = 0; j < g->cols; j++)
        col_part[j] = GRAPH_WELL;
    reach(g, col_of_row, row_of_col, GRAPH_OVER, row_part, col_part);
    transpose(g, &start, &to);
    struct graph t = { g->cols, g->rows, start, to };
    reach(&t, row_of_col, col_of_row, GRAPH_UNDER, col_part, row_part);
}
