/* Graphs of incidence: matchings, the Dulmage-Mendelsohn parts, strong components.
 *
 * Sources: Hopcroft & Karp, SIAM J. Comput. 2 (1973); Dulmage & Mendelsohn, Canad. J. Math.
 * 10 (1958); Tarjan, SIAM J. Comput. 1 (1972). Nothing recurses: sizes are a user's. */
#ifndef SGA_GRAPH_GRAPH_H
#define SGA_GRAPH_GRAPH_H

/* Rows and columns, or vertices and their successors, by rows: the neighbours of row i are
 * to[start[i]] .. to[start[i + 1] - 1]. Not owned. */
struct graph {
    int rows, cols;
    const int *start, *to;
};

enum graph_part { GRAPH_UNDER, GRAPH_WELL, GRAPH_OVER };

/* A matching of the most edges: col_of_row[rows] and row_of_col[cols], -1 where unmatched.
 * Returns its size, the structural rank. Cost: edges times the root of the vertices. */
int graph_match(const struct graph *g, int *col_of_row, int *row_of_col);

/* The coarse Dulmage-Mendelsohn parts from a largest matching: more columns than rows
 * (whatever an unmatched column leads to), more rows than columns (an unmatched row), and
 * the rest, which is square. Linear. */
void graph_coarse(const struct graph *g, const int *col_of_row, const int *row_of_col,
                  enum graph_part *row_part, enum graph_part *col_part);

/* Strong components of the graph with rows == cols: component[v], numbered so that a
 * component's successors have smaller numbers. Returns how many. Linear. */
int graph_strong(const struct graph *g, int *component);

/* The block-triangular form: block[i] by row (-1: unmatched), numbered so that a block
 * needs columns of itself, of earlier blocks and unmatched ones only. Returns how many. */
int graph_blocks(const struct graph *g, const int *col_of_row, const int *row_of_col, int *block);

#endif
