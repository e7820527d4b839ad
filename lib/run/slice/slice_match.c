/* Which equation gives which variable. See slice_work.h. */
#include <assert.h>
#include <stdlib.h>
#include <flint/nmod_mat.h>

#include "arena.h"
#include "derive.h"
#include "graph.h"
#include "mem.h"
#include "slice_work.h"
#include "system.h"

/* Circles of more variables are kept: a dense determinant is taken of theirs. */
static const int MOST_OF_CIRCLE = 200;
/* 2^61 - 1. */
static const mp_limb_t PRIME = 2305843009213693951UL;

static bool is_among(const struct slice_lists *l, int r, int v)
{
    for (int k = l->start ? l->start[r] : 0; l->start && k < l->start[r + 1]; k++)
        if (l->to[k] == v)
            return true;
    return false;
}

static bool from_behind(const struct slice_work *w, int r)
{
    return w->variable[r] >= 0 && !w->algebraic[r] && is_among(&w->behind, r, w->variable[r]);
}

bool slice_by_value(const struct slice_work *w, int r)
{
    return w->variable[r] >= 0 && (w->algebraic[r] || from_behind(w, r));
}

static void drop(struct slice_work *w, int v)
{
    assert(w->row_of[v] >= 0 && w->variable[w->row_of[v]] == v);
    w->variable[w->row_of[v]] = -1;
    w->row_of[v] = -1;
}

/* The paths that change who gives what, so that one row more does. */
struct paths {
    int *from;                /* by variable: the row that asks for it, or -1: not seen */
    int *seen, seens;         /* variables, in the order in which they were */
    int *queue;               /* rows */
};

/* Along the path back from v, which nobody gives, each row takes what it asked for. */
static void turn_over(struct slice_work *w, const struct paths *p, int v)
{
    while (v >= 0) {
        int r = p->from[v], was = w->variable[r];
        w->variable[r] = v;
        w->row_of[v] = r;
        v = was;
    }
}

static int ask(struct slice_work *w, struct paths *p, const struct slice_lists *l, int r, int *queued)
{
    for (int k = l->start[r]; k < l->start[r + 1]; k++) {
        int v = l->to[k];
        if (p->from[v] >= 0)
            continue;
        p->from[v] = r;
        p->seen[p->seens++] = v;
        if (w->row_of[v] < 0)
            return v;
        p->queue[(*queued)++] = w->row_of[v];
    }
    return -1;
}

/* Rows that are left over, with what stands behind velocities. What one path came by in vain no other needs to look at. */
static void augment(struct slice_work *w)
{
    SGA_ARENA(mem);
    size_t n = (size_t)w->n + 1;
    struct paths p = { .from = sga_take(&mem, n * sizeof *p.from), .seen = sga_take(&mem, n * sizeof *p.seen), .queue = sga_take(&mem, (n + 1) * sizeof *p.queue) };
    for (int v = 0; v < w->n; v++)
        p.from[v] = -1;
    for (int r = 0; r < w->rows; r++) {
        int queued = 0, found = -1, before = p.seens;
        if (!w->linked[r] || w->variable[r] >= 0)
            continue;
        p.queue[queued++] = r;
        for (int i = 0; i < queued && found < 0; i++) {
            found = ask(w, &p, &w->candidates, p.queue[i], &queued);
            if (found < 0)
                found = ask(w, &p, &w->behind, p.queue[i], &queued);
        }
        if (found >= 0) {
            turn_over(w, &p, found);
            while (p.seens > before)
                p.from[p.seen[--p.seens]] = -1;
        }
    }
}

/* What stands in a variable's row, as edges to variables that rows give. all: everything in it; otherwise what it needs to give what it gives:
 * other velocities to give a velocity, values to give a value (of what stands behind velocities nothing: that is in no circle). */
static void edges_of(const struct slice_work *w, struct slice_lists *edges, bool all)
{
    edges->start = sga_calloc((size_t)w->n + 1, sizeof(int));
    for (int v = 0; v < w->n; v++) {
        int r = w->row_of[v];
        bool velocity = r >= 0 && !slice_by_value(w, r);
        if (r >= 0 && velocity && !all) {
            for (int k = 0; k < w->sys->row[r].entries; k++) {
                int u = w->sys->row[r].entry[k].col;
                if (u != v && w->row_of[u] >= 0)
                    slice_lists_push(edges, u);
            }
        } else if (r >= 0 && (all || w->algebraic[r])) {
            for (int k = w->mentions.start[r]; k < w->mentions.start[r + 1]; k++)
                if (w->mentions.to[k] != v && w->row_of[w->mentions.to[k]] >= 0)
                    slice_lists_push(edges, w->mentions.to[k]);
        }
        edges->start[v + 1] = (int)edges->count;
    }
}

/* Strong components of such a graph: component and, one component after the other, their members. */
struct circles {
    struct sga_arena mem;
    int *component, *size, *first, *member, count;
};

static void find_circles(const struct slice_work *w, bool all, struct circles *c)
{
    struct slice_lists edges = { 0 };
    edges_of(w, &edges, all);
    struct graph g = { .rows = w->n, .cols = w->n, .start = edges.start, .to = edges.to };
    *c = (struct circles){ 0 };
    c->component = sga_take(&c->mem, (size_t)(w->n + 1) * sizeof *c->component);
    c->count = graph_strong(&g, c->component);
    c->first = sga_zeros(&c->mem, (size_t)c->count + 2, sizeof *c->first);
    c->member = sga_take(&c->mem, (size_t)(w->n + 1) * sizeof *c->member);
    for (int v = 0; v < w->n; v++)
        c->first[c->component[v] + 2]++;
    for (int k = 0; k < c->count; k++)
        c->first[k + 2] += c->first[k + 1];
    for (int v = 0; v < w->n; v++)
        c->member[c->first[c->component[v] + 1]++] = v;
    slice_lists_clear(&edges);
}

/* A number modulo PRIME; false: there is none. */
static bool residue(const struct expr_store *st, expr_id e, nmod_t mod, mp_limb_t *value)
{
    if (!expr_is_const(st, e))
        return false;
    const fmpq *q = expr_const_value(st, e);
    mp_limb_t den = fmpz_fdiv_ui(fmpq_denref(q), mod.n);
    if (den == 0)
        return false;
    *value = nmod_mul(fmpz_fdiv_ui(fmpq_numref(q), mod.n), nmod_inv(den, mod), mod);
    return true;
}

struct block {
    const int *member; int size;
    int *place;               /* by variable: in the block, or -1 */
    nmod_mat_t number;
};

/* Row i of the block's matrix: factors of velocities. */
static bool take_entries(const struct slice_work *w, struct block *b, int i, int r)
{
    const struct sys_row *row = w->sys->row + r;
    bool ok = true;
    for (int k = 0; ok && k < row->entries; k++) {
        int j = b->place[row->entry[k].col];
        mp_limb_t value;
        ok = j < 0 || residue(w->sys->store, row->entry[k].value, b->number->mod, &value);
        if (ok && j >= 0)
            nmod_mat_entry(b->number, i, j) = nmod_add(nmod_mat_entry(b->number, i, j), value, b->number->mod);
    }
    return ok;
}

/* The same for a row of values: its derivatives. */
static bool take_slopes(const struct slice_work *w, struct block *b, int i, int r)
{
    const struct sys_system *sys = w->sys;
    SGA_ARENA(mem);
    unsigned char *active = sga_zeros(&mem, (size_t)sys->store->symbols + 1, 1);
    struct expr_term *term = NULL;
    struct expr_cone cone;
    size_t cap = 0;
    bool ok = true;
    for (int k = 0; k < b->size; k++)
        active[sys->variable[b->member[k]].symbol] = 1;
    expr_cone_init(&cone);
    int terms = expr_gradient(sys->store, &cone, r < sys->rows ? sys->row[r].alpha : sys->restriction[r - sys->rows], active, &term, &cap);
    for (int k = 0; ok && k < terms; k++)
        ok = residue(sys->store, term[k].value, b->number->mod, &nmod_mat_entry(b->number, i, b->place[w->variable_of[term[k].symbol]]));
    expr_cone_clear(&cone);
    free(term);
    return ok;
}

/* A circle of velocities, or of values, by numbers that have an inverse: all of it is given together. */
static bool is_solvable(const struct slice_work *w, struct block *b)
{
    bool values = slice_by_value(w, w->row_of[b->member[0]]), ok = b->size <= MOST_OF_CIRCLE;
    for (int i = 0; ok && i < b->size; i++)
        ok = slice_by_value(w, w->row_of[b->member[i]]) == values;
    if (!ok)
        return false;
    for (int i = 0; i < b->size; i++)
        b->place[b->member[i]] = i;
    nmod_mat_init(b->number, b->size, b->size, PRIME);
    for (int i = 0; ok && i < b->size; i++) {
        int r = w->row_of[b->member[i]];
        ok = values ? take_slopes(w, b, i, r) : take_entries(w, b, i, r);
    }
    ok = ok && nmod_mat_rank(b->number) == b->size;
    nmod_mat_clear(b->number);
    for (int i = 0; i < b->size; i++)
        b->place[b->member[i]] = -1;
    return ok;
}

/* What comes from behind velocities may stand in no circle at all. */
static void break_behind(struct slice_work *w)
{
    struct circles c;
    find_circles(w, true, &c);
    for (int k = 0; k < c.count; k++)
        for (int i = c.first[k]; c.first[k + 1] - c.first[k] > 1 && i < c.first[k + 1]; i++)
            if (w->row_of[c.member[i]] >= 0 && from_behind(w, w->row_of[c.member[i]]))
                drop(w, c.member[i]);
    sga_arena_end(&c.mem);
}

static void break_circles(struct slice_work *w)
{
    struct circles c;
    find_circles(w, false, &c);
    SGA_ARENA(mem);
    struct block b = { .place = sga_take(&mem, (size_t)(w->n + 1) * sizeof *b.place) };
    for (int v = 0; v < w->n; v++)
        b.place[v] = -1;
    for (int k = 0; k < c.count; k++) {
        b.member = c.member + c.first[k];
        b.size = c.first[k + 1] - c.first[k];
        for (int i = 0; b.size > 1 && i < b.size; i++)
            assert(w->row_of[b.member[i]] >= 0);
        if (b.size > 1 && !is_solvable(w, &b))
            for (int i = 0; i < b.size; i++)
                drop(w, b.member[i]);
    }
    sga_arena_end(&c.mem);
}

void slice_assign(struct slice_work *w, bool more)
{
    struct graph g = { .rows = w->rows, .cols = w->n, .start = w->candidates.start, .to = w->candidates.to };
    graph_match(&g, w->variable, w->row_of);
    if (more) {
        augment(w);
        break_behind(w);
    }
    break_circles(w);
}

/* What a component mentions outside of itself is settled, and all of it is given by value. */
static bool rests_on_settled(const struct slice_work *w, const struct circles *c, int k, const bool *settled)
{
    bool all = true;
    for (int i = c->first[k]; all && i < c->first[k + 1]; i++) {
        int r = w->row_of[c->member[i]];
        all = r >= 0 && slice_by_value(w, r);
        for (int m = all ? w->mentions.start[r] : 0; all && m < w->mentions.start[r + 1]; m++)
            all = c->component[w->mentions.to[m]] == k || settled[w->mentions.to[m]];
    }
    return all;
}

/* In the order of components what a variable rests on comes first. */
void slice_settled(const struct slice_work *w, const unsigned char *fixed, bool more, bool *settled)
{
    struct circles c;
    find_circles(w, true, &c);
    for (int v = 0; v < w->n; v++)
        settled[v] = fixed[v];
    for (int k = 0; more && k < c.count; k++)
        if (rests_on_settled(w, &c, k, settled))
            for (int i = c.first[k]; i < c.first[k + 1]; i++)
                settled[c.member[i]] = true;
    sga_arena_end(&c.mem);
}
