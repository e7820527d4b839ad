/* Which variables are defined by equations, and the system with these put in. */
#include "definition_search.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "mem.h"
#include "range.h"
#include "system.h"

/* Whether the node has several branches, or no derivative where its argument is 0, at places that can be met. */
static bool is_kink(struct definition_search *s, const struct expr_node n)
{
    unsigned is = expr_op_traits((enum expr_op)n.op);
    if (!(is & (EXPR_HAS_BRANCHES | EXPR_IS_STEEP)))
        return false;
    return !(is & EXPR_BENDS_AT_0) || !(expr_facts_of(&s->facts, s->st, n.a) & EXPR_NONZERO);
}

/* Whether e has such nodes that depend on variables or time. */
static bool has_kink(struct definition_search *s, expr_id e)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++)
        if (is_kink(s, s->st->node[s->cone.list[k]])
            && expr_facts_of(&s->facts, s->st, s->cone.list[k]) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME))
            return true;
    return false;
}

/* The slope of a node whose children have these: 0 is none, UNDEF is not a number, or not one number. */
static expr_id slope_of(struct expr_store *st, expr_id e, expr_id a, expr_id b)
{
    const struct expr_node n = st->node[e];
    switch ((enum expr_op)n.op) {
    case EXPR_ADD: return expr_add(st, a, b);
    case EXPR_SUB: return expr_sub(st, a, b);
    case EXPR_NEG: return expr_neg(st, a);
    case EXPR_MUL: return expr_is_const(st, n.a) ? expr_mul(st, n.a, b) : expr_is_const(st, n.b) ? expr_mul(st, a, n.b) : EXPR_UNDEF;
    case EXPR_DIV: return expr_is_const(st, n.b) ? expr_div(st, a, n.b) : EXPR_UNDEF;
    default: return EXPR_UNDEF;
    }
}

/* e = slope * symbol + the rest, by e's shape; the constant 0 where the symbol is not in it, UNDEF where it is in it in another way. Derivatives
 * would not tell: that of sign(v) is 0. The cone is e's, indexed. */
static expr_id slope_in(struct definition_search *s, expr_id e, int symbol)
{
    struct expr_store *st = s->st;
    expr_id zero = expr_int(st, 0);
    SGA_RESERVE_IN(&s->mem, s->slope, s->slope_cap, s->cone.count + 1);
    for (int i = 0; i < s->cone.count; i++) {
        expr_id at = s->cone.list[i], of[2] = { zero, zero };
        int children = expr_children(st, at);
        bool none = true;
        for (int k = 0; k < children; k++) {
            expr_id c = s->slope[s->cone.place[expr_child(st, at, k)]];
            none &= c == zero;
            if (k < 2)
                of[k] = c;
        }
        if (!children)
            s->slope[i] = expr_op_of(st, at) == EXPR_SYM && st->node[at].a == symbol ? expr_int(st, 1) : zero;
        else
            s->slope[i] = none ? zero : of[0] && of[1] && children <= 2 ? slope_of(st, at, of[0], of[1]) : EXPR_UNDEF;
    }
    return s->slope[s->cone.place[e]];
}

/* Value of the variable by the row: what is left of it with the variable put to 0, over -slope. */
static expr_id value_of(struct definition_search *s, expr_id e, int symbol, expr_id slope)
{
    expr_id rest = e;
    s->map[symbol] = expr_int(s->st, 0);
    expr_substitute(s->st, &rest, 1, s->map);
    s->map[symbol] = EXPR_UNDEF;
    return expr_neg(s->st, expr_div(s->st, rest, slope));
}

bool definition_by(struct definition_search *s, int row, struct definition *best)
{
    expr_id e = s->alpha[row];
    bool found = false;
    expr_cone_of(s->st, &s->cone, &e, 1);
    int count = 0;
    SGA_FREED int *symbol = sga_malloc(((size_t)s->cone.count + 1) * sizeof *symbol);
    for (int k = 0; k < s->cone.count; k++)
        if (expr_op_of(s->st, s->cone.list[k]) == EXPR_SYM)
            symbol[count++] = s->st->node[s->cone.list[k]].a;
    for (int k = 0; k < count; k++) {
        int v = s->column[symbol[k]];
        if (v < 0 || s->moves[v] || (found && s->met[v] >= s->met[best->variable]) || definition_comes_back(s, row, v))
            continue;
        expr_cone_of(s->st, &s->cone, &e, 1);
        expr_cone_index(&s->cone);
        expr_id slope = slope_in(s, e, symbol[k]), value = EXPR_UNDEF;
        if (slope && expr_is_zero(s->st, slope))
            continue;
        if (slope)
            value = value_of(s, e, symbol[k], slope);
        else if (s->asked != DEFINITIONS_KINKED || !definition_bent(s, e, symbol[k], &value, &slope))
            continue;
        if (!value || (s->asked == DEFINITIONS_KINKED && !has_kink(s, value)))
            continue;
        *best = (struct definition){ v, row, value, slope, s->factor[row], s->factor[row] ? s->rest[row] : EXPR_UNDEF };
        found = true;
    }
    return found;
}

/* What is defined is put in wherever it is. */
static void put_in(struct definition_search *s, struct definition now)
{
    struct definitions *d = s->d;
    int symbol = s->sys->variable[now.variable].symbol;
    s->map[symbol] = now.value;
    for (int i = 0; i < d->count; i++)
        expr_substitute(s->st, &d->at[i].value, 1, s->map);
    for (int i = 0; i < s->sys->rows; i++)
        if (!s->used[i])
            expr_substitute(s->st, s->alpha + i, 1, s->map);
    s->map[symbol] = EXPR_UNDEF;
    SGA_RESERVE_IN(&d->mem, d->at, d->cap, d->count + 1);
    d->at[d->count++] = now;
    s->moves[now.variable] = 1;
    s->used[now.row] = 1;
}

/* Whether the bound is beyond 0 on its side: 1 above, -1 below. */
static bool beyond(struct definition_search *s, expr_id bound, bool taken, int side)
{
    int c = bound ? range_compare(s->st, bound, expr_int(s->st, 0)) : RANGE_UNKNOWN;
    return c == side || (c == 0 && !taken);
}

/* Whether e is nowhere 0, by facts or by its range. */
static bool never_zero(struct definition_search *s, expr_id e)
{
    if (expr_facts_of(&s->facts, s->st, e) & EXPR_NONZERO)
        return true;
    expr_cone_of(s->st, &s->cone, &e, 1);
    expr_cone_index(&s->cone);
    SGA_FREED struct range *range = sga_calloc((size_t)s->cone.count + 1, sizeof *range);
    struct range r;
    range_of_list(s->st, &s->facts, s->cone.list, s->cone.count, s->cone.place, range);
    r = range[s->cone.place[e]];
    return beyond(s, r.lo, r.lo_in, 1) || beyond(s, r.hi, r.hi_in, -1);
}

/* Whether e is nowhere 0, and nowhere without a value. */
static bool harmless(struct definition_search *s, expr_id e)
{
    if (!never_zero(s, e))
        return false;
    bool total = true;
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count && total; k++) {
        const struct expr_node n = s->st->node[s->cone.list[k]];
        total = n.op == EXPR_POWI ? n.b > 0 : (expr_op_traits((enum expr_op)n.op) & EXPR_IS_TOTAL) != 0;
    }
    return total;
}

/* The row without factors that say nothing. */
static void split_factor(struct definition_search *s, int row)
{
    expr_id e = s->sys->row[row].alpha, factor = EXPR_UNDEF;
    for (bool more = true; more; ) {
        const struct expr_node n = s->st->node[e];
        expr_id off = n.op == EXPR_NEG ? expr_int(s->st, -1)
                      : n.op != EXPR_MUL || expr_is_const(s->st, n.a) || expr_is_const(s->st, n.b) ? EXPR_UNDEF
                      : harmless(s, n.a) ? n.a : harmless(s, n.b) ? n.b : EXPR_UNDEF;
        more = off != EXPR_UNDEF;
        if (more) {
            e = n.op == EXPR_NEG || off != n.a ? n.a : n.b;
            factor = factor ? expr_mul(s->st, factor, off) : off;
        }
    }
    bool any = factor && !expr_is_const(s->st, factor);
    s->factor[row] = any ? factor : EXPR_UNDEF;
    s->rest[row] = any ? e : s->sys->row[row].alpha;
}

static void begin(struct definition_search *s)
{
    const struct sys_system *sys = s->sys;
    int n = sys->variables;
    s->moves = sga_zeros(&s->mem, (size_t)n + 1, 1);
    s->used = sga_zeros(&s->mem, (size_t)sys->rows + 1, 1);
    s->met = sga_zeros(&s->mem, (size_t)n + 1, sizeof *s->met);
    s->column = sga_take(&s->mem, ((size_t)s->st->symbols + 1) * sizeof *s->column);
    s->map = sga_zeros(&s->mem, (size_t)s->st->symbols + 1, sizeof *s->map);
    s->alpha = sga_take(&s->mem, ((size_t)sys->rows + 1) * sizeof *s->alpha);
    s->factor = sga_zeros(&s->mem, (size_t)sys->rows + 1, sizeof *s->factor);
    s->rest = sga_zeros(&s->mem, (size_t)sys->rows + 1, sizeof *s->rest);
    memset(s->column, -1, (size_t)s->st->symbols * sizeof *s->column);
    for (int j = 0; j < n; j++)
        s->column[sys->variable[j].symbol] = j;
    for (int i = 0; i < sys->rows; i++) {
        s->used[i] = sys->row[i].entries > 0;
        split_factor(s, i);
        s->alpha[i] = s->rest[i];
        for (int k = 0; k < sys->row[i].entries; k++)
            s->moves[sys->row[i].entry[k].col] = 1;
    }
    for (int i = 0; i < sys->rows; i++) {
        if (s->used[i])
            continue;
        expr_cone_of(s->st, &s->cone, s->alpha + i, 1);
        for (int k = 0; k < s->cone.count; k++) {
            int symbol = expr_op_of(s->st, s->cone.list[k]) == EXPR_SYM ? s->st->node[s->cone.list[k]].a : -1;
            if (symbol >= 0 && s->column[symbol] >= 0)
                s->met[s->column[symbol]]++;
        }
    }
}

static void end(struct definition_search *s)
{
    expr_facts_clear(&s->facts);
    expr_cone_clear(&s->cone);
    sga_arena_end(&s->mem);
}

/* Whether any equation without derivatives has a switch or root: most systems have none. */
static bool any_kink(struct definition_search *s)
{
    for (int i = 0; i < s->sys->rows; i++)
        if (!s->sys->row[i].entries && has_kink(s, s->sys->row[i].alpha))
            return true;
    return false;
}

/* Places of what is left. */
static void places(struct definitions *d, const struct sys_system *sys)
{
    SGA_FREED unsigned char *gone = sga_calloc((size_t)(sys->variables + sys->rows) + 1, 1);
    int variables = 0, rows = 0;
    for (int i = 0; i < d->count; i++)
        gone[d->at[i].variable] = gone[sys->variables + d->at[i].row] = 1;
    d->variable = sga_take(&d->mem, ((size_t)sys->variables + 1) * sizeof *d->variable);
    d->row = sga_take(&d->mem, ((size_t)sys->rows + 1) * sizeof *d->row);
    assert(d->count <= sys->rows && d->count <= sys->variables);
    for (int j = 0; j < sys->variables; j++)
        if (!gone[j])
            d->variable[variables++] = j;
    for (int i = 0; i < sys->rows; i++)
        if (!gone[sys->variables + i])
            d->row[rows++] = i;
    assert(variables == sys->variables - d->count && rows == sys->rows - d->count);
}

void definitions_find(struct definitions *d, const struct sys_system *system, enum definitions_asked asked, const struct sga_budget *budget)
{
    struct definition_search s = { .sys = system, .budget = budget, .st = system->store, .d = d, .asked = asked };
    *d = (struct definitions){ 0 };
    expr_facts_init(&s.facts);
    expr_cone_init(&s.cone);
    if (asked == DEFINITIONS_ALL) {
        begin(&s);
        definition_all(&s);
    } else if (any_kink(&s)) {
        begin(&s);
        bool more = true;
        while (more && sga_budget_ok(budget, NULL) && expr_store_ok(s.st)) {
            more = false;
            for (int i = 0; i < system->rows && sga_budget_ok(budget, NULL) && expr_store_ok(s.st); i++) {
                struct definition now = { 0 };
                if (s.used[i] || !definition_by(&s, i, &now))
                    continue;
                put_in(&s, now);
                more = true;
            }
        }
    }
    end(&s);
    if (d->count)
        places(d, system);
}

void definitions_clear(struct definitions *d)
{
    sga_arena_end(&d->mem);
    *d = (struct definitions){ 0 };
}

/* The caller frees it. */
static expr_id *map_of(const struct definitions *d, const struct sys_system *system)
{
    expr_id *map = sga_calloc((size_t)system->store->symbols + 1, sizeof *map);
    for (int i = 0; i < d->count; i++)
        map[system->variable[d->at[i].variable].symbol] = d->at[i].value;
    return map;
}

void definitions_through(const struct definitions *d, const struct sys_system *system, expr_id *e, int count)
{
    if (!d->count)
        return;
    SGA_FREED expr_id *map = map_of(d, system);
    expr_substitute(system->store, e, count, map);
}

void definitions_put_in(const struct definitions *d, const struct sys_system *system, struct sys_system *left)
{
    SGA_FREED expr_id *map = map_of(d, system);
    struct sys_part part = { d->variable, system->variables - d->count, d->row, system->rows - d->count };
    sys_copy_part(left, system, &part, map);
}
