/* The graph of equations and variables, and what can be left out of it. See slice.h. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "graph.h"
#include "mem.h"
#include "slice.h"
#include "slice_work.h"
#include "system.h"

void slice_lists_push(struct slice_lists *l, int v)
{
    SGA_RESERVE(l->to, l->cap, l->count + 1);
    l->to[l->count++] = v;
}

void slice_lists_clear(struct slice_lists *l)
{
    free(l->start);
    free(l->to);
}

/* The variables that row r mentions, each once; seen: by variable, the last row that had it. */
static void collect(struct slice_work *w, struct expr_cone *cone, int r, int *seen)
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
            slice_lists_push(&w->mentions, row->entry[k - 1].col);
        seen[row->entry[k - 1].col] = r;
    }
    expr_cone_of(sys->store, cone, root, roots);
    for (int k = 0; k < cone->count; k++) {
        const struct expr_node *node = sys->store->node + cone->list[k];
        int v = node->op == EXPR_SYM ? w->variable_of[node->a] : -1;
        if (v >= 0 && seen[v] != r) {
            slice_lists_push(&w->mentions, v);
            seen[v] = r;
        }
    }
}

static void mention(struct slice_work *w)
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
static void link_all(struct slice_work *w, bool *reached)
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

static void keep(struct slice_work *w, int v)
{
    if (w->kept[v])
        return;
    w->kept[v] = true;
    w->queue[w->queued++] = v;
}

static void keep_row(struct slice_work *w, int r)
{
    for (int k = w->mentions.start[r]; k < w->mentions.start[r + 1]; k++)
        keep(w, w->mentions.to[k]);
}

/* A variable is kept: what its own row mentions, and what rows that give values tie to it. */
static void close_up(struct slice_work *w, const bool *settled)
{
    for (int i = 0; i < w->queued; i++) {
        int v = w->queue[i];
        if (w->row_of[v] >= 0)
            keep_row(w, w->row_of[v]);
        for (int k = w->users.start[v]; k < w->users.start[v + 1]; k++) {
            int r = w->users.to[k];
            if (!settled[v] && slice_by_value(w, r))
                keep(w, w->variable[r]);
        }
    }
}

static void begin(struct slice_work *w, const struct sys_system *sys)
{
    *w = (struct slice_work){ .sys = sys, .n = sys->variables, .rows = sys->rows + sys->restrictions };
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

static void end(struct slice_work *w)
{
    free(w->variable_of);
    slice_lists_clear(&w->mentions);
    slice_lists_clear(&w->users);
    slice_lists_clear(&w->candidates);
    slice_lists_clear(&w->behind);
    free(w->algebraic);
    free(w->linked);
    free(w->variable);
    free(w->row_of);
    free(w->kept);
    free(w->queue);
}

/* What stands in the work, as the caller wants it. Rows that mention no variable are kept. */
static bool give(const struct slice_work *w, const bool *reached, struct slice_parts *p)
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
        for (int k = w->mentions.start[r]; w->linked[r] && out && slice_by_value(w, r) && k < w->mentions.start[r + 1]; k++)
            p->tied |= w->kept[w->mentions.to[k]];
    }
    return less;
}

/* What is kept, once it is known which row gives what. How many variables that is. */
static int keep_all(struct slice_work *w, const struct slice_wish *wish, const bool *reached)
{
    SGA_ARENA(mem);
    bool *settled = sga_zeros(&mem, (size_t)w->n + 1, sizeof *settled);
    slice_settled(w, wish->fixed, wish->tied, settled);
    memset(w->kept, 0, (size_t)w->n * sizeof *w->kept);
    w->queued = 0;
    for (int j = 0; j < w->n; j++)
        if (wish->needed[j] || (reached[j] && wish->stays[j] && w->row_of[j] >= 0 && slice_by_value(w, w->row_of[j])))
            keep(w, j);
    for (int r = 0; r < w->rows; r++)
        if (w->linked[r] && w->variable[r] < 0)
            keep_row(w, r);
    close_up(w, settled);
    return w->queued;
}

/* A linked row gives nothing: it may ask something of what is kept. */
static bool some_left(const struct slice_work *w)
{
    for (int r = 0; r < w->rows; r++)
        if (w->linked[r] && w->variable[r] < 0)
            return true;
    return false;
}

bool slice_decide(const struct sys_system *sys, const struct slice_wish *wish, struct slice_parts *parts)
{
    struct slice_work w;
    begin(&w, sys);
    SGA_ARENA(mem);
    bool *reached = sga_zeros(&mem, (size_t)w.n + 1, sizeof *reached);
    for (int j = 0; j < w.n; j++)
        if (wish->needed[j]) {
            reached[j] = true;
            w.queue[w.queued++] = j;
        }
    link_all(&w, reached);
    slice_find_candidates(&w, wish->apart_only);
    slice_assign(&w, false);
    int kept = keep_all(&w, wish, reached);
    if (!wish->apart_only && some_left(&w)) {
        slice_find_behind(&w);
        slice_assign(&w, true);
        if (keep_all(&w, wish, reached) >= kept) {
            slice_assign(&w, false);
            keep_all(&w, wish, reached);
        }
    }
    bool less = give(&w, reached, parts);
    end(&w);
    if (!less)
        slice_parts_clear(parts);
    return less;
}

bool slice_feeds(const struct sys_system *sys, const unsigned char *needed, struct slice_parts *parts)
{
    struct slice_work w;
    begin(&w, sys);
    SGA_ARENA(mem);
    const struct graph g = { w.rows, w.n, w.mentions.start, w.mentions.to };
    bool square = w.rows == w.n && graph_match(&g, w.variable, w.row_of) == w.n, *reached = sga_zeros(&mem, (size_t)w.n + 1, sizeof *reached);
    for (int j = 0; j < w.n; j++) {
        reached[j] = true;
        if (needed[j])
            keep(&w, j);
    }
    for (int i = 0; i < w.queued && square; i++)
        keep_row(&w, w.row_of[w.queue[i]]);
    bool less = square && w.queued < w.n;
    for (int r = 0; r < w.rows && less; r++)
        w.linked[r] = w.kept[w.variable[r]];
    if (less)
        give(&w, reached, parts);
    end(&w);
    return less;
}

void slice_parts_clear(struct slice_parts *p)
{
    free(p->variable);
    free(p->row);
    *p = (struct slice_parts){ 0 };
}
