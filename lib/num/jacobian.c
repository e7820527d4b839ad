/* Finding the pattern of a Jacobian, and which way to accumulate it. */
#include "jacobian_plan.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "jacobian.h"
#include "mem.h"
#include "sort.h"

/* A graph over ids: the neighbours of i are to[start[i]] .. to[start[i+1]-1]. */
struct graph {
    int nodes;
    int *start, *to;
};

/* What one walk over a graph met: ids, in no order. */
struct walk {
    int *stamp, now;
    int *met, count;
};

/* The ids of the operands of a step, sink left out; returns how many (to may be NULL). */
static int operands(const struct num_jacobian_plan *p, const struct jacobian_step *s, int *to)
{
    int two[2], n = 0;
    if (s->op == TAPE_FACTOR) {
        const struct jacobian_solve *v = p->solve + s->a;
        for (int k = 0; to && k < v->edges; k++)
            to[k] = v->edge[k].id;
        return v->edges;
    }
    if (s->op == TAPE_COMPONENT) {
        two[n++] = p->solve[s->a].id;
    } else {
        if (s->a != p->sink)
            two[n++] = s->a;
        if (s->b != p->sink && s->b != s->a)
            two[n++] = s->b;
    }
    for (int k = 0; to && k < n; k++)
        to[k] = two[k];
    return n;
}

static struct graph graph_down(const struct num_jacobian_plan *p, int cols)
{
    struct graph g = { .nodes = p->sink + 1 };
    g.start = sga_calloc((size_t)g.nodes + 1, sizeof *g.start);
    for (int i = 0; i < p->steps; i++)
        g.start[cols + i + 1] = operands(p, p->step + i, NULL);
    for (int i = 0; i < g.nodes; i++)
        g.start[i + 1] += g.start[i];
    g.to = sga_malloc(((size_t)g.start[g.nodes] + 1) * sizeof *g.to);
    for (int i = 0; i < p->steps; i++)
        operands(p, p->step + i, g.to + g.start[cols + i]);
    return g;
}

static struct graph graph_reversed(const struct graph *g)
{
    struct graph r = { .nodes = g->nodes };
    int edges = g->start[g->nodes];
    r.start = sga_calloc((size_t)r.nodes + 2, sizeof *r.start);
    r.to = sga_malloc(((size_t)edges + 1) * sizeof *r.to);
    for (int k = 0; k < edges; k++)
        r.start[g->to[k] + 2]++;
    for (int i = 0; i < r.nodes; i++)
        r.start[i + 1] += r.start[i];
    for (int i = 0; i < g->nodes; i++)
        for (int k = g->start[i]; k < g->start[i + 1]; k++)
            r.to[r.start[g->to[k] + 1]++] = i;
    return r;
}

static void graph_clear(struct graph *g)
{
    free(g->start);
    free(g->to);
}

static void walk_from(struct walk *w, const struct graph *g, int from)
{
    w->now++;
    w->count = 0;
    w->stamp[from] = w->now;
    w->met[w->count++] = from;
    for (int i = 0; i < w->count; i++)
        for (int k = g->start[w->met[i]]; k < g->start[w->met[i] + 1]; k++) {
            int id = g->to[k];
            if (w->stamp[id] == w->now)
                continue;
            w->stamp[id] = w->now;
            w->met[w->count++] = id;
        }
}

/* What a sweep pays at an id: a linear solve costs as much as its matrix has entries. */
static double weight(const struct num_jacobian *j, int id)
{
    const struct num_jacobian_plan *p = j->plan;
    if (id < j->cols || id == p->sink)
        return 0;
    const struct jacobian_step *s = p->step + id - j->cols;
    return s->op == TAPE_FACTOR ? (double)p->solve[s->a].of->m * p->solve[s->a].of->m : 1;
}

/* The rows' columns, in CRS. Returns the steps of all rows together. */
static double find_pattern(struct num_jacobian *j, const struct graph *down, struct walk *w)
{
    size_t cap = 0;
    double cost = 0;
    j->start = sga_calloc((size_t)j->rows + 1, sizeof *j->start);
    for (int r = 0; r < j->rows; r++) {
        walk_from(w, down, j->plan->root[r]);
        SGA_RESERVE(j->col, cap, j->nnz + w->count);
        for (int i = 0; i < w->count; i++)
            if (w->met[i] < j->cols)
                j->col[j->nnz++] = w->met[i];
            else
                cost += weight(j, w->met[i]);
        j->start[r + 1] = j->nnz;
        sga_sort(j->col + j->start[r], (size_t)(j->nnz - j->start[r]));
    }
    return cost;
}

/* The steps of all columns together, counted until they pass `enough`. */
static double forward_cost(const struct num_jacobian *j, const struct graph *up, struct walk *w, double enough)
{
    double cost = 0;
    for (int c = 0; c < j->cols && cost < enough; c++) {
        walk_from(w, up, c);
        for (int i = 0; i < w->count; i++)
            cost += weight(j, w->met[i]);
    }
    return cost;
}

/* The steps met from each of n ids. A list with more than half of all steps is not kept. */
static void make_lists(struct num_jacobian_plan *p, int cols, const struct graph *g, struct walk *w, int n)
{
    struct jacobian_lists *l = &p->lists;
    size_t cap = 0;
    int count = 0;
    l->start = sga_zeros(&p->mem, (size_t)n + 1, sizeof *l->start);
    l->all = sga_zeros(&p->mem, (size_t)n + 1, 1);
    for (int i = 0; i < n; i++) {
        walk_from(w, g, p->forward ? i : p->root[i]);
        l->all[i] = w->count > p->steps / 2 && p->steps > 16;
        if (!l->all[i]) {
            SGA_RESERVE(l->item, cap, count + w->count);
            for (int k = 0; k < w->count; k++)
                if (w->met[k] >= cols && w->met[k] != p->sink)
                    l->item[count++] = w->met[k] - cols;
            sga_sort(l->item + l->start[i], (size_t)(count - l->start[i]));
        }
        l->start[i + 1] = count;
    }
}

/* The pattern by columns: the row and the place of each entry. */
static void transpose_pattern(struct num_jacobian *j)
{
    struct num_jacobian_plan *p = j->plan;
    p->by_col = sga_zeros(&p->mem, (size_t)j->cols + 2, sizeof *p->by_col);
    p->entry = sga_take(&p->mem, ((size_t)j->nnz + 1) * sizeof *p->entry);
    p->entry_row = sga_take(&p->mem, ((size_t)j->nnz + 1) * sizeof *p->entry_row);
    for (int i = 0; i < j->nnz; i++)
        p->by_col[j->col[i] + 2]++;
    for (int c = 0; c < j->cols; c++)
        p->by_col[c + 1] += p->by_col[c];
    for (int r = 0; r < j->rows; r++)
        for (int i = j->start[r]; i < j->start[r + 1]; i++) {
            int k = p->by_col[j->col[i] + 1]++;
            p->entry[k] = i;
            p->entry_row[k] = r;
        }
}

/* The pattern; then the cheaper direction, and its lists. */
static void choose(struct num_jacobian *j)
{
    struct num_jacobian_plan *p = j->plan;
    SGA_ENDS(graph_clear) struct graph down = graph_down(p, j->cols), up = graph_reversed(&down);
    struct walk w = { 0 };
    w.stamp = sga_calloc((size_t)down.nodes, sizeof *w.stamp);
    w.met = sga_malloc((size_t)down.nodes * sizeof *w.met);
    double reverse = find_pattern(j, &down, &w);
    p->forward = forward_cost(j, &up, &w, reverse) < reverse;
    make_lists(p, j->cols, p->forward ? &up : &down, &w, p->forward ? j->cols : j->rows);
    transpose_pattern(j);
    free(w.stamp);
    free(w.met);
}

bool num_jacobian_sane(const struct num_jacobian *j)
{
    bool sane = j->start[0] == 0 && j->start[j->rows] == j->nnz;
    for (int r = 0; r < j->rows && sane; r++) {
        sane = j->start[r] <= j->start[r + 1];
        for (int k = j->start[r]; k < j->start[r + 1] && sane; k++)
            sane = j->col[k] >= (k > j->start[r] ? j->col[k - 1] + 1 : 0) && j->col[k] < j->cols;
    }
    return sane;
}

struct num_jacobian *num_jacobian_new(struct num_tape *t, const int *columns, int ncolumns)
{
    struct num_jacobian *j = sga_calloc(1, sizeof *j);
    j->plan = sga_calloc(1, sizeof *j->plan);
    j->plan->tape = t;
    j->rows = t->nroots;
    j->cols = columns ? ncolumns : t->ninputs;
    jacobian_steps(j, columns);
    choose(j);
    j->plan->sweep = sga_zeros(&j->plan->mem, (size_t)j->plan->sink + 1, sizeof *j->plan->sweep);
    j->plan->out = sga_zeros(&j->plan->mem, (size_t)j->rows + 1, sizeof *j->plan->out);
    assert(num_jacobian_sane(j));
    return j;
}

void num_jacobian_free(struct num_jacobian *j)
{
    if (!j)
        return;
    SGA_FREED struct num_jacobian_plan *p = j->plan;
    num_tape_free(p->code);
    sga_arena_end(&p->mem);
    free(p->lists.item);
    free(j->start);
    free(j->col);
    free(j);
}
