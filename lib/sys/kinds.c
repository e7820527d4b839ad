/* Coordinates, velocities, and what follows from them: see kinds.h. */
#include "kinds.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "mem.h"
#include "system.h"

static bool has_role(const struct sys_system *s, int j, const char *role)
{
    return strcmp(s->variable[j].role, role) == 0;
}

static bool velocity_by_role(const struct sys_system *s, int j)
{
    return has_role(s, j, "velocity") || has_role(s, j, "derivative");
}

/* The variable of each symbol, or -1. */
static int *places(const struct sys_system *s)
{
    int *place = sga_malloc(((size_t)s->store->symbols + 1) * sizeof *place);
    for (int k = 0; k < s->store->symbols; k++)
        place[k] = -1;
    for (int j = 0; j < s->variables; j++)
        place[s->variable[j].symbol] = j;
    return place;
}

/* e is a variable times a positive number: which one; otherwise -1. */
static int positive_multiple(const struct sys_system *s, const int *place, expr_id e, bool *positive)
{
    const struct expr_store *st = s->store;
    *positive = true;
    for (;;) {
        const struct expr_node *v = st->node + e;
        if (v->op == EXPR_SYM)
            return place[v->a];
        if (v->op == EXPR_NEG) {
            *positive = !*positive;
            e = v->a;
        } else if ((v->op == EXPR_MUL && expr_is_const(st, v->a)) || ((v->op == EXPR_MUL || v->op == EXPR_DIV) && expr_is_const(st, v->b))) {
            bool first = v->op == EXPR_MUL && expr_is_const(st, v->a);
            *positive ^= fmpq_sgn(expr_const_value(st, first ? v->a : v->b)) < 0;
            e = first ? v->b : v->a;
        } else {
            return -1;
        }
    }
}

/* The row is x' = v: v, with x in *of; otherwise -1. */
static int defines(const struct sys_system *s, const int *place, const struct sys_row *row, int *of)
{
    bool positive;
    if (row->entries != 1 || !expr_is_const(s->store, row->entry[0].value))
        return -1;
    int v = positive_multiple(s, place, row->alpha, &positive);
    if (v < 0 || v == row->entry[0].col || positive != (fmpq_sgn(expr_const_value(s->store, row->entry[0].value)) > 0))
        return -1;
    *of = row->entry[0].col;
    return v;
}

/* By variable: in how many rows and restrictions it is, and in how many without derivatives. */
struct met {
    int *count, *bare;
};

static struct met occurrences(const struct sys_system *s, const int *place)
{
    struct met met = { sga_calloc((size_t)s->variables + 1, sizeof(int)), sga_calloc((size_t)s->variables + 1, sizeof(int)) };
    SGA_FREED int *last = sga_calloc((size_t)s->variables + 1, sizeof *last);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < s->rows + s->restrictions; i++) {
        const struct sys_row *row = i < s->rows ? s->row + i : NULL;
        int entries = row ? row->entries : 0;
        SGA_FREED expr_id *root = sga_malloc((size_t)(entries + 1) * sizeof *root);
        for (int k = 0; k < entries; k++)
            root[k] = row->entry[k].value;
        root[entries] = row ? row->alpha : s->restriction[i - s->rows];
        expr_cone_of(s->store, &cone, root, entries + 1);
        for (int k = 0; k < cone.count; k++) {
            const struct expr_node *v = s->store->node + cone.list[k];
            int j = v->op == EXPR_SYM ? place[v->a] : -1;
            if (j >= 0 && last[j] != i + 1) {
                last[j] = i + 1;
                met.count[j]++;
                met.bare[j] += entries == 0;
            }
        }
    }
    return met;
}

/* By variable: rows that ask for its derivative. */
static int *asked_for(const struct sys_system *s)
{
    int *rows = sga_calloc((size_t)s->variables + 1, sizeof *rows);
    for (int i = 0; i < s->rows; i++)
        for (int k = 0; k < s->row[i].entries; k++)
            rows[s->row[i].entry[k].col]++;
    return rows;
}

/* Which variables e has, each once, into list. Returns how many. */
static int variables_in(const struct sys_system *s, const int *place, struct expr_cone *cone, expr_id e, int *list)
{
    int n = 0;
    expr_cone_of(s->store, cone, &e, 1);
    for (int k = 0; k < cone->count; k++) {
        const struct expr_node *v = s->store->node + cone->list[k];
        int j = v->op == EXPR_SYM ? place[v->a] : -1;
        if (j >= 0)
            list[n++] = j;
    }
    return n;
}

/* Whether the row is number * w + the rest, and w a variable that no row asks the derivative of. */
static bool may_name(const struct sys_system *s, const int *rows, int i, int w)
{
    expr_id slope = rows[w] ? EXPR_UNDEF : expr_diff(s->store, s->row[i].alpha, s->variable[w].symbol);
    return slope && expr_is_const(s->store, slope) && !expr_is_zero(s->store, slope);
}

/* Whether the row without derivatives gives a name to something that is met beside derivatives only, and in no other row without them. */
static bool only_names(const struct sys_system *s, const struct met *met, const int *rows, int i, const int *list, int count)
{
    bool only = false;
    for (int k = 0; k < count && !only; k++)
        only = met->bare[list[k]] == 1 && met->count[list[k]] > 1 && may_name(s, rows, i, list[k]);
    return only;
}

/* A name for what rows without derivatives have, too, is no multiplier. Whether one was found. */
static bool name_for_bare(const struct sys_system *s, struct met *met, const int *rows, int i, const int *list, int count)
{
    bool bare = false, more = false;
    for (int k = 0; k < count; k++)
        bare |= !rows[list[k]] && met->bare[list[k]] > 0;
    for (int k = 0; k < count && bare; k++)
        if (met->bare[list[k]] == 0 && may_name(s, rows, i, list[k])) {
            met->bare[list[k]] = 1;
            more = true;
        }
    return more;
}

/* Rows that only give names do not count as rows without derivatives: a multiplier in a force that has a name is one. */
static void see_through_names(const struct sys_system *s, const int *place, const int *rows, struct met *met)
{
    SGA_ARENA(mem);
    unsigned char *seen = sga_zeros(&mem, (size_t)s->rows + 1, 1);
    int *list = sga_take(&mem, (size_t)(s->variables + 1) * sizeof *list);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int names = 1; names >= 0; names--)      /* first rows that name, then what they name */
        for (bool more = true; more;) {
            more = false;
            for (int i = 0; i < s->rows; i++) {
                if (s->row[i].entries || seen[i] == names)
                    continue;
                int count = variables_in(s, place, &cone, s->row[i].alpha, list);
                if (!names) {
                    more |= name_for_bare(s, met, rows, i, list, count);
                } else if (only_names(s, met, rows, i, list, count)) {
                    for (int k = 0; k < count; k++)
                        met->bare[list[k]]--;
                    seen[i] = 1;
                    more = true;
                }
            }
        }
}

/* Rows that define what nothing else asks for. */
static void drop_definitions(const struct sys_system *s, const int *place, const int *count, int *rows, unsigned char *slack)
{
    for (int i = 0; i < s->rows; i++) {
        int of, v = defines(s, place, s->row + i, &of);
        if (v >= 0 && rows[v] == 0 && count[v] == 1 && velocity_by_role(s, v)) {
            rows[of]--;
            slack[v] = 1;
        }
    }
}

/* Definitions x' = v as a graph: what is left when sources and ends are taken off again and again lies on circles. */
static void find_velocities(const struct sys_system *s, const int *place, unsigned char *kind)
{
    SGA_ARENA(mem);
    int n = s->variables, edges = 0, *from = sga_take(&mem, (size_t)(s->rows + 1) * sizeof *from);
    int *to = sga_take(&mem, (size_t)(s->rows + 1) * sizeof *to);
    int *in = sga_zeros(&mem, (size_t)n + 1, sizeof *in);
    for (int i = 0; i < s->rows; i++) {
        int of, v = defines(s, place, s->row + i, &of);
        if (v < 0 || kind[v] >= SYS_ALGEBRAIC)
            continue;
        from[edges] = of;
        to[edges++] = v;
        in[v]++;
    }
    for (bool more = edges > 0; more;) {         /* in the order of a source's distance; chains are short */
        more = false;
        for (int e = 0; e < edges; e++)
            if (from[e] >= 0 && in[from[e]] == 0) {
                if (kind[to[e]] == SYS_COORDINATE)
                    kind[to[e]] = SYS_VELOCITY;
                if (--in[to[e]] == 0)
                    more = true;
                from[e] = -1;
            }
    }
}

void sys_kinds(const struct sys_system *s, unsigned char *kind)
{
    SGA_FREED int *place = places(s), *rows = asked_for(s);
    SGA_FREED unsigned char *slack = sga_calloc((size_t)s->variables + 1, 1);
    struct met met = occurrences(s, place);
    drop_definitions(s, place, met.count, rows, slack);
    see_through_names(s, place, rows, &met);
    for (int j = 0; j < s->variables; j++) {
        bool added = has_role(s, j, "multiplier") || has_role(s, j, "input");
        if (added || slack[j] || (rows[j] == 0 && !velocity_by_role(s, j)))
            kind[j] = added || !met.bare[j] ? SYS_MULTIPLIER : SYS_ALGEBRAIC;
        else
            kind[j] = velocity_by_role(s, j) ? SYS_VELOCITY : SYS_COORDINATE;
    }
    find_velocities(s, place, kind);
    free(met.count);
    free(met.bare);
}

struct named {
    const char *name;
    int place;
};

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct named *)a)->name, ((const struct named *)b)->name);
}

void sys_by_name(const struct sys_system *s, int *order)
{
    size_t n = (size_t)s->variables;
    SGA_FREED struct named *list = sga_malloc((n + 1) * sizeof *list);
    for (size_t j = 0; j < n; j++)
        list[j] = (struct named){ s->store->symbol[s->variable[j].symbol].name, (int)j };
    qsort(list, n, sizeof *list, by_name);
    for (size_t j = 0; j < n; j++)
        order[j] = list[j].place;
}
