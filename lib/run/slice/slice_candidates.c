/* What an equation can be solved for, whatever the rest does. See slice_work.h. */
#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "slice_work.h"
#include "system.h"

/* One gradient after the other. */
struct slopes {
    struct slice_work *w;
    struct expr_store *st;
    struct sga_arena mem;
    unsigned char *active;
    struct expr_term *term;
    size_t cap;
    struct expr_cone cone;
    struct expr_facts facts;
};

static void slopes_begin(struct slopes *s, struct slice_work *w)
{
    *s = (struct slopes){ .w = w, .st = w->sys->store };
    s->active = sga_zeros(&s->mem, (size_t)s->st->symbols + 1, 1);
    for (int j = 0; j < w->n; j++)
        s->active[w->sys->variable[j].symbol] = 1;
    expr_cone_init(&s->cone);
    expr_facts_init(&s->facts);
}

static void slopes_end(struct slopes *s)
{
    expr_facts_clear(&s->facts);
    expr_cone_clear(&s->cone);
    free(s->term);
    sga_arena_end(&s->mem);
}

/* A number that is not 0. */
static bool is_number(const struct expr_store *st, expr_id e)
{
    return expr_is_const(st, e) && !expr_is_zero(st, e);
}

/* A sum of terms of one sign, one of which is a number that is not 0. */
static bool away_from_zero(struct slopes *s, expr_id e)
{
    enum { ROOM = 16 };
    struct { expr_id e; bool minus; } stack[ROOM];
    int depth = 0;
    bool up = true, down = true, number = false;
    stack[depth].e = e, stack[depth++].minus = false;
    while (depth) {
        const expr_id top = stack[--depth].e;
        const bool minus = stack[depth].minus;
        const struct expr_node *n = s->st->node + top;
        if (n->op == EXPR_NEG) {
            stack[depth].e = n->a, stack[depth++].minus = !minus;
        } else if (n->op == EXPR_ADD || n->op == EXPR_SUB) {
            if (depth + 2 > ROOM)
                return false;
            stack[depth].e = n->a, stack[depth++].minus = minus;
            stack[depth].e = n->b, stack[depth++].minus = minus != (n->op == EXPR_SUB);
        } else {
            unsigned is = expr_facts_of(&s->facts, s->st, top);
            up &= !!(is & (minus ? EXPR_NONPOSITIVE : EXPR_NONNEGATIVE));
            down &= !!(is & (minus ? EXPR_NONNEGATIVE : EXPR_NONPOSITIVE));
            number |= is_number(s->st, top);
        }
    }
    return number && (up || down);
}

/* e has a value for every value of the symbol, as far as it depends on it. */
static bool is_total_in(struct slopes *s, expr_id e, int symbol)
{
    SGA_ARENA(mem);
    bool total = true;
    expr_cone_of(s->st, &s->cone, &e, 1);
    unsigned char *depends = sga_zeros(&mem, (size_t)s->cone.count + 1, 1);
    for (int k = 0; k < s->cone.count && total; k++) {
        const struct expr_node *n = s->st->node + s->cone.list[k];
        int args = expr_op_args((enum expr_op)n->op);
        bool left = args > 0 && depends[expr_cone_place(&s->cone, n->a)], right = args > 1 && depends[expr_cone_place(&s->cone, n->b)];
        bool below = left || right;
        depends[k] = below || (n->op == EXPR_SYM && n->a == symbol);
        if (n->op == EXPR_SOLVE)
            total = false;
        else if (below && n->op == EXPR_POWI)
            total = n->b > 0;
        else if (below && n->op == EXPR_DIV)
            total = !right;
        else if (below)
            total = expr_op_traits((enum expr_op)n->op) & EXPR_IS_TOTAL;
    }
    return total;
}

static void of_values(struct slopes *s, int r, expr_id f)
{
    int terms = expr_gradient(s->st, &s->cone, f, s->active, &s->term, &s->cap);
    for (int k = 0; k < terms; k++) {
        const struct expr_term t = s->term[k];
        if (is_number(s->st, t.value) || (away_from_zero(s, t.value) && is_total_in(s, f, t.symbol)))
            slice_lists_push(&s->w->candidates, s->w->variable_of[t.symbol]);
    }
    s->w->candidates.start[r + 1] = (int)s->w->candidates.count;
}

void slice_find_candidates(struct slice_work *w, bool none)
{
    const struct sys_system *sys = w->sys;
    struct slopes s;
    slopes_begin(&s, w);
    w->candidates.start = sga_calloc((size_t)w->rows + 1, sizeof(int));
    for (int r = 0; r < w->rows; r++) {
        const struct sys_row *row = r < sys->rows ? sys->row + r : NULL;
        w->algebraic[r] = !row || row->entries == 0;
        if (w->linked[r] && !none && w->algebraic[r])
            of_values(&s, r, row ? row->alpha : sys->restriction[r - sys->rows]);
        else if (w->linked[r] && !none)
            for (int k = 0; k < row->entries; k++)
                if (is_number(s.st, row->entry[k].value))
                    slice_lists_push(&w->candidates, row->entry[k].col);
        w->candidates.start[r + 1] = (int)w->candidates.count;
    }
    slopes_end(&s);
}

/* v stands in a row's left side: its velocity, or a factor of one. */
static bool stands_left(struct slopes *s, const struct sys_row *row, int v)
{
    for (int k = 0; k < row->entries; k++)
        if (row->entry[k].col == v)
            return true;
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, (size_t)row->entries * sizeof *root);
    for (int k = 0; k < row->entries; k++)
        root[k] = row->entry[k].value;
    expr_cone_of(s->st, &s->cone, root, row->entries);
    for (int k = 0; k < s->cone.count; k++) {
        const struct expr_node *n = s->st->node + s->cone.list[k];
        if (n->op == EXPR_SYM && n->a == s->w->sys->variable[v].symbol)
            return true;
    }
    return false;
}

void slice_find_behind(struct slice_work *w)
{
    struct slopes s;
    slopes_begin(&s, w);
    w->behind.start = sga_calloc((size_t)w->rows + 1, sizeof(int));
    for (int r = 0; r < w->rows; r++) {
        if (w->linked[r] && !w->algebraic[r]) {
            const struct sys_row *row = w->sys->row + r;
            int terms = expr_gradient(s.st, &s.cone, row->alpha, s.active, &s.term, &s.cap);
            for (int k = 0; k < terms; k++) {
                int v = w->variable_of[s.term[k].symbol];
                if (is_number(s.st, s.term[k].value) && !stands_left(&s, row, v))
                    slice_lists_push(&w->behind, v);
            }
        }
        w->behind.start[r + 1] = (int)w->behind.count;
    }
    slopes_end(&s);
}
