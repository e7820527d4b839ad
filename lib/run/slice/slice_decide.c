/* The graph of equations and variables, and what can be left out of it. See slice.h. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "graph.h"
#include "mem.h"
#include "slice.h"
#include "system.h"

/* Lists by row, one after the other. */
struct lists {
    int *start, *to;
    size_t count, cap;
};

struct work {
    const struct sys_system *sys;
    int n, rows;                  /* rows: with the restrictions, which come last */
    int *variable_of;             /* by symbol: variable, or -1 */
    struct lists mentions;        /* by row: variables */
    struct lists users;           /* by variable: rows */
    struct lists candidates;      /* by row: variables that it can be solved for */
    bool *algebraic;              /* by row: it has no velocities */
    int *row_of, *variable;       /* by variable: the row that gives it, or -1; by row: the variable */
    bool *linked;                 /* by row: it belongs to what is needed */
    bool *kept;                   /* by variable */
    int *queue, queued;
};

static void push_to(struct lists *l, int v)
{
    SGA_RESERVE(l->to, l->cap, l->count + 1);
    l->to[l->count++] = v;
}

static void clear_lists(struct lists *l)
{
    free(l->start);
    free(l->to);
}

/* The variables that row r mentions, each once; seen: by variable, the last row that had it. */
static void collect(struct work *w, struct expr_cone *cone, int r, int *seen)
{
    const struct sys_system *sys = w->sys;
    const struct sys_row *row = r < sys->rows ? sys->row + r : NULL;
    int roots = row ? row->entries + 1 : 1;
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, (size_t)roots * sizeof *root);
    root[0] = row ? row->alpha : sys->restriction[r - sys->rows];
    for (int k = 1; k < roots; k++) {
        root[k] = row->entry[k - 1].value;
        if (seen[row->entry[k - 1].col] != r)
            push_to(&w->mentions, row->entry[k - 1].col);
        seen[row->entry[k - 1].col] = r;
    }
    expr_cone_of(sys->store, cone, root, roots);
    for (int k = 0; k < cone->count; k++) {
        const struct expr_node *node = sys->store->node + cone->list[k];
        int v = node->op == EXPR_SYM ? w->variable_of[node->a] : -1;
        if (v >= 0 && seen[v] != r) {
            push_to(&w->mentions, v);
            seen[v] = r;
        }
    }
}

static void mention(struct work *w)
{
    struct expr_cone cone;
    SGA_ARENA(mem);
    int *seen = sga_take(&mem, (size_t)(w->n + 1) * sizeof *seen);
    for (int j = 0; j < w->n; j++)
        seen[j] = -1;
    expr_cone_init(&cone);
    w->mentions.start = sga_calloc((size_t)w->rows + 1, sizeof(int));
    for (int r = 0; r < w->rows; r++) {
        collect(w, &cone, r, seen);
        w->mentions.start[r + 1] = (int)w->mentions.count;
    }
    expr_cone_clear(&cone);
    /* and the other way round */
    w->users.start = sga_calloc((size_t)w->n + 2, sizeof(int));
    w->users.to = sga_malloc((w->mentions.count + 1) * sizeof(int));
    for (size_t k = 0; k < w->mentions.count; k++)
        w->users.start[w->mentions.to[k] + 2]++;
    for (int j = 0; j < w->n; j++)
        w->users.start[j + 2] += w->users.start[j + 1];
    for (int r = 0; r < w->rows; r++)
        for (int k = w->mentions.start[r]; k < w->mentions.start[r + 1]; k++)
            w->users.to[w->users.start[w->mentions.to[k] + 1]++] = r;
}

/* Everything that chains of equations link to the variables in the queue. */
static void link_all(struct work *w, bool *reached)
{
    for (int i = 0; i < w->queued; i++) {
        int v = w->queue[i];
        for (int k = w->users.start[v]; k < w->users.start[v + 1]; k++) {
            int r = w->users.to[k];
            if (w->linked[r])
                continue;
            w->linked[r] = true;
            for (int m = w->mentions.start[r]; m < w->mentions.start[r + 1]; m++)
                if (!reached[w->mentions.to[m]]) {
                    reached[w->mentions.to[m]] = true;
                    w->queue[w->queued++] = w->mentions.to[m];
                }
        }
    }
}

/* A number that is not 0. */
static bool is_number(const struct expr_store *st, expr_id e)
{
    return expr_is_const(st, e) && !expr_is_zero(st, e);
}

/* For which variables each linked row can be solved, given any motion of the others. */
static void find_candidates(struct work *w, bool none)
{
    const struct sys_system *sys = w->sys;
    struct expr_store *st = sys->store;
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    struct expr_term *term = NULL;
    struct expr_cone cone;
    size_t cap = 0;
    expr_cone_init(&cone);
    for (int j = 0; j < w->n; j++)
        active[sys->variable[j].symbol] = 1;
    w->candidates.start = sga_calloc((size_t)w->rows + 1, sizeof(int));
    for (int r = 0; r < w->rows; r++) {
        const struct sys_row *row = r < sys->rows ? sys->row + r : NULL;
        w->algebraic[r] = !row || row->entries == 0;
        if (none) {
            w->candidates.start[r + 1] = 0;
            continue;
        }
        if (w->linked[r] && w->algebraic[r]) {
            int terms = expr_gradient(st, &cone, row ? row->alpha : sys->restriction[r - sys->rows], active, &term, &cap);
            for (int k = 0; k < terms; k++)
                if (is_number(st, term[k].value))
                    push_to(&w->candidates, w->variable_of[term[k].symbol]);
        } else if (w->linked[r] && row->entries == 1 && is_number(st, row->entry[0].value)) {
            push_to(&w->candidates, row->entry[0].col);
        }
        w->candidates.start[r + 1] = (int)w->candidates.count;
    }
    expr_cone_clear(&cone);
    free(term);
}

/* Circles among the variables given by rows without velocities: these rows give nothing. */
static void break_circles(struct work *w)
{
    struct lists edges = { .start = sga_calloc((size_t)w->n + 1, sizeof(int)) };
    for (int v = 0; v < w->n; v++) {
        int r = w->row_of[v];
        for (int k = r >= 0 && w->algebraic[r] ? w->mentions.start[r] : 0; r >= 0 && w->algebraic[r] && k < w->mentions.start[r + 1]; k++) {
            int u = w->mentions.to[k];
            if (u != v && w->row_of[u] >= 0 && w->algebraic[w->row_of[u]])
                push_to(&edges, u);
        }
        edges.start[v + 1] = (int)edges.count;
    }
    struct graph g = { .rows = w->n, .cols = w->n, .start = edges.start, .to = edges.to };
    SGA_ARENA(mem);
    int *component = sga_take(&mem, (size_t)(w->n + 1) * sizeof *component);
    int *size = sga_zeros(&mem, (size_t)w->n + 1, sizeof *size);
    graph_strong(&g, component);
    for (int v = 0; v < w->n; v++)
        size[component[v]]++;
    for (int v = 0; v < w->n; v++)
        if (size[component[v]] > 1) {
            w->variable[w->row_of[v]] = -1;
            w->row_of[v] = -1;
        }
    clear_lists(&edges);
}

static void assign(struct work *w)
{
    struct graph g = { .rows = w->rows, .cols = w->n, .start = w->candidates.start, .to = w->candidates.to };
    graph_match(&g, w->variable, w->row_of);
    break_circles(w);
}

static void keep(struct work *w, int v)
{
    if (w->kept[v])
        return;
    w->kept[v] = true;
    w->queue[w->queued++] = v;
}

static void keep_row(struct work *w, int r)
{
    for (int k = w->mentions.start[r]; k < w->mentions.start[r + 1]; k++)
        keep(w, w->mentions.to[k]);
}

/* A variable is kept: what its own row mentions, and what rows without velocities tie to it. */
static void close_up(struct work *w, const unsigned char *fixed)
{
    for (int i = 0; i < w->queued; i++) {
        int v = w->queue[i];
        if (w->row_of[v] >= 0)
            keep_row(w, w->row_of[v]);
        for (int k = w->users.start[v]; k < w->users.start[v + 1]; k++) {
            int r = w->users.to[k];
            if (!fixed[v] && w->variable[r] >= 0 && w->algebraic[r])
                keep(w, w->variable[r]);
        }
    }
}

static void begin(struct work *w, const struct sys_system *sys)
{
    *w = (struct work){ .sys = sys, .n = sys->variables, .rows = sys->rows + sys->restrictions };
    size_t n = (size_t)w->n + 1, rows = (size_t)w->rows + 1;
    w->variable_of = sga_malloc(((size_t)sys->store->symbols + 1) * sizeof *w->variable_of);
    for (int s = 0; s < sys->store->symbols; s++)
        w->variable_of[s] = -1;
    for (int j = 0; j < w->n; j++)
        w->variable_of[sys->variable[j].symbol] = j;
    w->algebraic = sga_calloc(rows, sizeof *w->algebraic);
    w->linked = sga_calloc(rows, sizeof *w->linked);
    w->variable = sga_malloc(rows * sizeof *w->variable);
    w->row_of = sga_malloc(n * sizeof *w->row_of);
    w->kept = sga_calloc(n, sizeof *w->kept);
    w->queue = sga_malloc(n * sizeof *w->queue);
    mention(w);
}

static void end(struct work *w)
{
    free(w->variable_of);
    clear_lists(&w->mentions);
    clear_lists(&w->users);
    clear_lists(&w->candidates);
    free(w->algebraic);
    free(w->linked);
    free(w->variable);
    free(w->row_of);
    free(w->kept);
    free(w->queue);
}

/* What stands in the work, as the caller wants it. Rows that mention no variable are kept. */
static bool give(const struct work *w, const bool *reached, struct slice_parts *p)
{
    bool less = false;
    *p = (struct slice_parts){ .variable = sga_malloc((size_t)w->n + 1), .row = sga_malloc((size_t)w->rows + 1) };
    for (int j = 0; j < w->n; j++) {
        p->variable[j] = (unsigned char)(w->kept[j] ? SLICE_KEPT : reached[j] ? SLICE_FOLLOWS : SLICE_APART);
        less |= !w->kept[j];
    }
    for (int r = 0; r < w->rows; r++) {
        bool empty = w->mentions.start[r] == w->mentions.start[r + 1], out = w->variable[r] >= 0 && !w->kept[w->variable[r]];
        p->row[r] = empty || (w->linked[r] && !out);
        for (int k = w->mentions.start[r]; w->linked[r] && out && w->algebraic[r] && k < w->mentions.start[r + 1]; k++)
            p->tied |= w->kept[w->mentions.to[k]];
    }
    return less;
}

bool slice_decide(const struct sys_system *sys, const struct slice_wish *wish, struct slice_parts *parts)
{
    struct work w;
    begin(&w, sys);
    SGA_ARENA(mem);
    bool *reached = sga_zeros(&mem, (size_t)w.n + 1, sizeof *reached);
    for (int j = 0; j < w.n; j++)
        if (wish->needed[j]) {
            reached[j] = true;
            w.queue[w.queued++] = j;
        }
    link_all(&w, reached);
    find_candidates(&w, wish->apart_only);
    assign(&w);
    w.queued = 0;
    for (int j = 0; j < w.n; j++)
        if (wish->needed[j] || (reached[j] && wish->stays[j] && w.row_of[j] >= 0 && w.algebraic[w.row_of[j]]))
            keep(&w, j);
    for (int r = 0; r < w.rows; r++)
        if (w.linked[r] && w.variable[r] < 0)
            keep_row(&w, r);
    close_up(&w, wish->fixed);
    bool less = give(&w, reached, parts);
    end(&w);
    if (!less)
        slice_parts_clear(parts);
    return less;
}

void slice_parts_clear(struct slice_parts *p)
{
    free(p->variable);
    free(p->row);
    *p = (struct slice_parts){ 0 };
}
