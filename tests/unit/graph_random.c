/* Matchings, coarse parts, components and blocks of small random graphs against brute
 * force: subsets for the matching, reachability for the components. */
#include "graph.h"

#include <string.h>

#include "check.h"

enum { MOST = 9 };

static unsigned long seed;

static int random_below(int n)
{
    seed = seed * 6364136223846793005ul + 1442695040888963407ul;
    return (int)((seed >> 33) % (unsigned long)n);
}

struct small {
    int rows, cols, start[MOST + 1], to[MOST * MOST];
    unsigned char at[MOST][MOST];
};

static void make(struct small *s, int rows, int cols, int percent)
{
    int edges = 0;
    s->rows = rows;
    s->cols = cols;
    for (int i = 0; i < rows; i++) {
        s->start[i] = edges;
        for (int j = 0; j < cols; j++) {
            s->at[i][j] = random_below(100) < percent;
            if (s->at[i][j])
                s->to[edges++] = j;
        }
    }
    s->start[rows] = edges;
}

/* The most columns that rows i.. can take apart from those in `used`; without row `skip`
 * and column `drop`. */
static int best(const struct small *s, int i, unsigned used, int skip, int drop)
{
    if (i == s->rows)
        return 0;
    int most = best(s, i + 1, used, skip, drop);
    for (int j = 0; j < s->cols && i != skip; j++)
        if (s->at[i][j] && !(used >> j & 1) && j != drop) {
            int here = 1 + best(s, i + 1, used | 1u << j, skip, drop);
            most = here > most ? here : most;
        }
    return most;
}

static void check_match(const struct small *s, const struct graph *g)
{
    int of_row[MOST], of_col[MOST], block[MOST], size = graph_match(g, of_row, of_col), pairs = 0;
    enum graph_part row_part[MOST], col_part[MOST];
    int rank = best(s, 0, 0, -1, -1);
    CHECK(size == rank, "matching of %d, the most is %d", size, rank);
    for (int i = 0; i < s->rows; i++)
        if (of_row[i] >= 0) {
            pairs++;
            CHECK(of_col[of_row[i]] == i && s->at[i][of_row[i]], "row %d", i);
        }
    CHECK(pairs == size);
    graph_coarse(g, of_row, of_col, row_part, col_part);
    /* A row lies in the overdetermined part where some largest matching does without it,
     * a column in the underdetermined one likewise (Dulmage and Mendelsohn). */
    for (int i = 0; i < s->rows; i++)
        CHECK((row_part[i] == GRAPH_OVER) == (best(s, 0, 0, i, -1) == rank), "row %d", i);
    for (int j = 0; j < s->cols; j++)
        CHECK((col_part[j] == GRAPH_UNDER) == (best(s, 0, 0, -1, j) == rank), "column %d", j);
    for (int i = 0; i < s->rows; i++)
        if (of_row[i] >= 0)
            CHECK(row_part[i] == col_part[of_row[i]]);
    int blocks = graph_blocks(g, of_row, of_col, block);
    for (int i = 0; i < s->rows; i++) {
        CHECK((block[i] < 0) == (of_row[i] < 0) && block[i] < blocks);
        for (int k = g->start[i]; k < g->start[i + 1] && block[i] >= 0; k++)
            CHECK(of_col[g->to[k]] < 0 || block[of_col[g->to[k]]] <= block[i], "row %d needs a later block", i);
    }
}

static void check_strong(const struct small *s, const struct graph *g)
{
    int component[MOST], n = s->rows, found = graph_strong(g, component), seen = 0;
    unsigned char reach[MOST][MOST];
    memcpy(reach, s->at, sizeof reach);
    for (int k = 0; k < n; k++)
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++)
                reach[i][j] |= reach[i][k] && reach[k][j];
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            CHECK((component[i] == component[j]) == (i == j || (reach[i][j] && reach[j][i])), "%d %d", i, j);
            if (reach[i][j])
                CHECK(component[j] <= component[i], "%d leads to %d", i, j);
        }
    for (int i = 0; i < n; i++)
        seen = component[i] >= seen ? component[i] + 1 : seen;
    CHECK(seen == found);
}

/* A path of 200000 vertices: nothing recurses, and the cost is linear. */
static void check_long(void)
{
    enum { N = 200000 };
    int *start = malloc((N + 1) * sizeof *start), *to = malloc(2 * N * sizeof *to), edges = 0;
    int *a = malloc(N * sizeof *a), *b = malloc(N * sizeof *b), *component = malloc(N * sizeof *component);
    for (int i = 0; i < N; i++) {       /* the wrong column first: one long augmenting chain */
        start[i] = edges;
        if (i + 1 < N)
            to[edges++] = i + 1;
        to[edges++] = i;
    }
    start[N] = edges;
    struct graph g = { N, N, start, to };
    CHECK(graph_match(&g, a, b) == N);
    CHECK(graph_strong(&g, component) == N && component[0] == N - 1);
    free(start);
    free(to);
    free(a);
    free(b);
    free(component);
}

int main(void)
{
    seed = check_seed(4711);
    for (int k = 0; k < check_scale(400); k++) {
        struct small s;
        int rows = 1 + random_below(6), cols = 1 + random_below(6);
        make(&s, rows, cols, 10 + random_below(60));
        struct graph g = { rows, cols, s.start, s.to };
        check_match(&s, &g);
        make(&s, rows, rows, 5 + random_below(40));
        check_strong(&s, &(struct graph){ rows, rows, s.start, s.to });
    }
    check_long();
    return CHECK_END();
}
