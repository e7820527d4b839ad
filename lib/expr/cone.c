/* Walks over part of the graph: cones and substitution, without recursion. */
#include "raw_nodes.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "expr_rows.h"
#include "mem.h"
#include "sort.h"

void expr_cone_init(struct expr_cone *c)
{
    *c = (struct expr_cone){ 0 };
}

void expr_cone_clear(struct expr_cone *c)
{
    expr_marks_back(c);
    free(c->list);
    *c = (struct expr_cone){ 0 };
}

static void push(struct expr_cone *c, expr_id e)
{
    if (c->stamp[e] == c->now)
        return;
    c->stamp[e] = c->now;
    SGA_RESERVE(c->list, c->list_cap, c->count + 1);
    c->list[c->count++] = e;
}

/* By id. Most cones are dense: their stamps are read in order, which costs a fraction of sorting. */
static void in_order(struct expr_cone *c)
{
    enum { DENSE = 8 };
    expr_id low = c->list[0], high = low;
    for (int i = 1; i < c->count; i++) {
        low = c->list[i] < low ? c->list[i] : low;
        high = c->list[i] > high ? c->list[i] : high;
    }
    if ((high - low) / DENSE > (expr_id)c->count) {
        sga_sort(c->list, (size_t)c->count);
        return;
    }
    for (expr_id e = low, i = 0; i < (expr_id)c->count; e++)
        if (c->stamp[e] == c->now)
            c->list[i++] = e;
}

static void begin(const struct expr_store *st, struct expr_cone *c, const expr_id *roots, int nroots)
{
    if (!c->from)
        expr_marks_lend(st->marks, c);
    if (c->stamp_cap < (size_t)st->nodes) {
        size_t old = c->stamp_cap;
        SGA_RESERVE(c->stamp, c->stamp_cap, st->nodes);
        memset(c->stamp + old, 0, (c->stamp_cap - old) * sizeof *c->stamp);
    }
    if (++c->now == 0) {
        memset(c->stamp, 0, c->stamp_cap * sizeof *c->stamp);
        c->now = 1;
    }
    c->count = 0;
    for (int i = 0; i < nroots; i++)
        push(c, roots[i]);
}

static void push_children(const struct expr_store *st, struct expr_cone *c, expr_id e)
{
    int n = expr_children(st, e);
    for (int k = 0; k < n; k++)
        push(c, expr_child(st, e, k));
}

void expr_cone_of(const struct expr_store *st, struct expr_cone *c, const expr_id *roots, int nroots)
{
    begin(st, c, roots, nroots);
    for (int i = 0; i < c->count; i++)
        push_children(st, c, c->list[i]);
    if (c->count)
        in_order(c);
}

bool expr_cone_above_solves(const struct expr_store *st, struct expr_cone *c, const expr_id *roots, int nroots, int most)
{
    int symbols = 0;
    begin(st, c, roots, nroots);
    for (int i = 0; i < c->count && symbols <= most; i++) {
        expr_id e = c->list[i];
        symbols += expr_op_of(st, e) == EXPR_SYM;
        if (expr_op_of(st, e) != EXPR_SOLVE)
            push_children(st, c, e);
    }
    if (c->count && symbols <= most)
        in_order(c);
    return symbols <= most;
}

void expr_cone_index(struct expr_cone *c)
{
    SGA_RESERVE(c->place, c->place_cap, c->stamp_cap);
    for (int i = 0; i < c->count; i++)
        c->place[c->list[i]] = i;
}

/* In the store `st`, the node e of `from`, which may be the same store: `to` has what its children became. */
static expr_id rebuild_solve(struct expr_store *st, const struct expr_store *from, expr_id e, const expr_id *to)
{
    int index = from->node[e].a, m = from->solve[index].m, entries = from->solve[index].matrix.start[m];
    SGA_ENDS(expr_rows_clear) struct expr_rows matrix = expr_rows_copy(&from->solve[index].matrix, m, EXPR_NONE);
    SGA_FREED expr_id *rhs = sga_malloc((size_t)m * sizeof *rhs);
    bool same = st == from;
    for (int k = 0; k < entries; k++) {
        matrix.entry[k] = to[matrix.entry[k]];
        same &= matrix.entry[k] == from->solve[index].matrix.entry[k];
    }
    for (int i = 0; i < m; i++) {
        rhs[i] = to[from->solve[index].rhs[i]];
        same &= rhs[i] == from->solve[index].rhs[i];
    }
    int component = from->node[e].b;
    if (!same) {
        /* components of one solve meet here one after the other: reuse the last copy */
        SGA_ENDS(expr_rows_clear) struct expr_rows less = expr_rows_copy(&matrix, m, expr_int(st, 0));
        struct expr_solve *last = st->solves ? st->solve + st->solves - 1 : NULL;
        if (last && last->m == m && expr_rows_same(&last->matrix, &less, m) && !memcmp(last->rhs, rhs, (size_t)m * sizeof *rhs))
            index = st->solves - 1;
        else
            index = expr_solve_add_rows(st, m, &less, rhs);
    }
    return expr_solution(st, index, component);
}

expr_id expr_rebuild(struct expr_store *st, const struct expr_store *from, expr_id e, const expr_id *to, const expr_id *map)
{
    struct expr_node n = from->node[e];
    switch ((enum expr_op)n.op) {
    case EXPR_UNDEF_OP: return EXPR_UNDEF;
    case EXPR_CONST: return st == from ? e : expr_fmpq(st, from->constant + n.a);
    case EXPR_PI:    return expr_pi(st);
    case EXPR_SYM:   return map[n.a] ? map[n.a] : st == from ? e : st->symbol[n.a].node;
    case EXPR_ADD:   return expr_add(st, to[n.a], to[n.b]);
    case EXPR_SUB:   return expr_sub(st, to[n.a], to[n.b]);
    case EXPR_MUL:   return expr_mul(st, to[n.a], to[n.b]);
    case EXPR_DIV:   return expr_div(st, to[n.a], to[n.b]);
    case EXPR_NEG:   return expr_neg(st, to[n.a]);
    case EXPR_POWI:  return expr_powi(st, to[n.a], n.b);
    case EXPR_POW:   return expr_pow(st, to[n.a], to[n.b]);
    case EXPR_SOLVE: return rebuild_solve(st, from, e, to);
    default:
        if (expr_op_args((enum expr_op)n.op) == 1)
            return expr_fun(st, (enum expr_op)n.op, to[n.a]);
        if (expr_op_args((enum expr_op)n.op) == 2)
            return expr_fun2(st, (enum expr_op)n.op, to[n.a], to[n.b]);
        return e;
    }
}

/* Whether the parts of e are still what they were: then e is. Most nodes are such where a few symbols are put in, and need no look-up. */
static bool stays(const struct expr_store *st, expr_id e, const expr_id *to)
{
    const struct expr_node *n = st->node + e;
    int parts = n->op == EXPR_SOLVE ? 0 : expr_op_args((enum expr_op)n->op);
    return parts && to[n->a] == n->a && (parts == 1 || to[n->b] == n->b);
}

void expr_substitute(struct expr_store *st, expr_id *roots, int nroots, const expr_id *map)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(st, &c, roots, nroots);
    SGA_RESERVE(c.place, c.place_cap, c.stamp_cap);
    expr_id *to = c.place;         /* what nodes become stands where their places would */
    for (int i = 0; i < c.count; i++)
        to[c.list[i]] = stays(st, c.list[i], to) ? c.list[i] : expr_rebuild(st, st, c.list[i], to, map);
    for (int i = 0; i < nroots; i++)
        roots[i] = to[roots[i]];
}

expr_id expr_replace(struct expr_store *st, expr_id root, const expr_id *by)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(st, &c, &root, 1);
    SGA_ARENA(mem);
    expr_id *to = sga_zeros(&mem, (size_t)st->nodes + 1, sizeof *to), *none = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *none);
    int nodes = st->nodes;          /* those that are made here are nowhere in the cone */
    for (int i = 0; i < c.count; i++) {
        expr_id e = c.list[i], new = by[e];
        to[e] = !new ? expr_rebuild(st, st, e, to, none) : new < nodes && to[new] ? to[new] : new;
    }
    return to[root];
}

void expr_copy_symbols(struct expr_store *to, const struct expr_store *from)
{
    for (int i = 0; i < from->symbols; i++) {
        expr_symbol_add(to, from->symbol[i].name, from->symbol[i].kind);
        to->symbol[i].table = from->symbol[i].table;
        to->symbol[i].order = from->symbol[i].order;
    }
    to->signals_fixed = from->signals_fixed;
}

void expr_copy(struct expr_store *to, const struct expr_store *from, expr_id *roots, int nroots, const expr_id *map)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(from, &c, roots, nroots);
    expr_cone_index(&c);
    expr_id *became = c.place;         /* lent, and written children first: a sweep copies as often as it has sets, from a store with the numbers of all */
    for (int i = 0; i < c.count; i++)
        became[c.list[i]] = expr_rebuild(to, from, c.list[i], became, map);
    for (int i = 0; i < nroots; i++)
        roots[i] = became[roots[i]];
}

bool expr_depends(const struct expr_store *st, struct expr_cone *c, expr_id e, int symbol)
{
    expr_cone_of(st, c, &e, 1);
    for (int k = 0; k < c->count; k++)
        if (c->list[k] == st->symbol[symbol].node)
            return true;
    return false;
}

bool expr_has_branches(const struct expr_store *st, const expr_id *e, int count)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool has = false;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, e, count);
    for (int i = 0; i < cone.count && !has; i++)
        has = expr_op_traits(expr_op_of(st, cone.list[i])) & EXPR_HAS_BRANCHES;
    return has;
}
