/* See alike.h. */
#include "alike.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"

/* Larger ones are rarely alike. */
enum { LONGEST_CONE = 256, MOST_SYMBOLS = 48, FIRST_TABLE = 64 };

/* A function that was factored: its nodes in order, each as its operation, its parts (by their place) and what else it has; and its symbols as they come. */
struct met {
    struct met *next;              /* of those at one place of the table */
    uint64_t hash;
    int *shape, length;
    int *symbol, symbols;
    struct poly_factors factors;
};

struct poly_alike {
    struct sga_arena mem;
    struct expr_store *st;
    struct met **table;            /* `size` places, a power of 2 */
    int count, size;
    expr_id *map;                  /* by symbol: 0 between uses */
    size_t map_cap;
    int *shape; size_t shape_cap;  /* of the function that is asked for */
    int symbol[LONGEST_CONE];
};

struct poly_alike *poly_alike_new(struct expr_store *st)
{
    struct poly_alike *a = sga_calloc(1, sizeof *a);
    a->st = st;
    return a;
}

void poly_alike_free(struct poly_alike *a)
{
    if (!a)
        return;
    for (int i = 0; i < a->size; i++)
        for (struct met *m = a->table[i]; m; m = m->next)
            poly_factors_clear(&m->factors);
    free(a->table);
    free(a->map);
    free(a->shape);
    sga_arena_end(&a->mem);
    free(a);
}

/* What a node is beside its parts; false: it is nothing that a name alone could be changed in. */
static bool own_of(const struct expr_store *st, expr_id e, int *own)
{
    const struct expr_node *n = st->node + e;
    enum expr_symbol_kind kind;
    switch ((enum expr_op)n->op) {
    case EXPR_UNDEF_OP:
    case EXPR_SOLVE:
        return false;
    case EXPR_CONST:
        *own = (int)e;
        return true;
    case EXPR_SYM:
        kind = st->symbol[n->a].kind;
        *own = (int)kind;
        return kind != EXPR_SIGNAL;
    case EXPR_POWI:
        *own = n->b;
        return true;
    default:
        *own = 0;
        return true;
    }
}

/* a->shape and a->symbol of e, by its cone; 0: it has none. Symbols come in their order, so that all that goes by it is the same for those that are alike. */
static int shape_in(struct poly_alike *a, struct expr_cone *c, expr_id e, int *symbols)
{
    const struct expr_store *st = a->st;
    int length = 0;
    *symbols = 0;
    if (!expr_cone_above_solves(st, c, &e, 1, MOST_SYMBOLS) || c->count > LONGEST_CONE)
        return 0;
    expr_cone_index(c);
    for (int i = 0; i < c->count; i++) {
        expr_id node = c->list[i];
        int parts = expr_children(st, node), own;
        if (!own_of(st, node, &own))
            return 0;
        SGA_RESERVE(a->shape, a->shape_cap, length + 2 + parts);
        a->shape[length++] = (int)expr_op_of(st, node);
        a->shape[length++] = own;
        for (int k = 0; k < parts; k++)
            a->shape[length++] = c->place[expr_child(st, node, k)];
        if (expr_op_of(st, node) != EXPR_SYM)
            continue;
        a->symbol[*symbols] = st->node[node].a;
        if (*symbols && a->symbol[*symbols] < a->symbol[*symbols - 1])
            return 0;
        ++*symbols;
    }
    return length;
}

static int shape_of(struct poly_alike *a, expr_id e, int *symbols)
{
    struct expr_cone c;
    expr_cone_init(&c);
    int length = shape_in(a, &c, e, symbols);
    expr_cone_clear(&c);
    return length;
}

static uint64_t hash_of(const int *shape, int length)
{
    uint64_t h = 1469598103934665603u;
    for (int i = 0; i < length; i++)
        h = (h ^ (uint32_t)shape[i]) * 1099511628211u;
    return h ^ h >> 29;
}

static struct met *find(const struct poly_alike *a, uint64_t hash, int length)
{
    for (struct met *m = a->size ? a->table[hash & (uint64_t)(a->size - 1)] : NULL; m; m = m->next)
        if (m->hash == hash && m->length == length && !memcmp(m->shape, a->shape, (size_t)length * sizeof *a->shape))
            return m;
    return NULL;
}

static void grow(struct poly_alike *a)
{
    int size = a->size ? 2 * a->size : FIRST_TABLE;
    struct met **table = sga_calloc((size_t)size, sizeof(struct met *));
    for (int i = 0; i < a->size; i++)
        for (struct met *m = a->table[i], *next; m; m = next) {
            next = m->next;
            m->next = table[m->hash & (uint64_t)(size - 1)];
            table[m->hash & (uint64_t)(size - 1)] = m;
        }
    free(a->table);
    a->table = table;
    a->size = size;
}

static void copy_factors(struct poly_factors *to, const struct poly_factors *from)
{
    *to = *from;
    to->factor = sga_calloc((size_t)from->factors + 1, sizeof *to->factor);
    for (int i = 0; i < from->factors; i++) {
        const struct poly_factor *f = from->factor + i;
        to->factor[i] = *f;
        to->factor[i].radical = f->radicals ? memcpy(sga_malloc((size_t)f->radicals * sizeof *f->radical), f->radical, (size_t)f->radicals * sizeof *f->radical) : NULL;
    }
}

static void keep(struct poly_alike *a, uint64_t hash, int length, int symbols, const struct poly_factors *factors)
{
    if (a->count >= a->size)
        grow(a);
    struct met *m = sga_take(&a->mem, sizeof *m), **place = a->table + (hash & (uint64_t)(a->size - 1));
    *m = (struct met){ .next = *place, .hash = hash, .length = length, .symbols = symbols,
                       .shape = memcpy(sga_take(&a->mem, (size_t)length * sizeof *m->shape), a->shape, (size_t)length * sizeof *m->shape),
                       .symbol = memcpy(sga_take(&a->mem, ((size_t)symbols + 1) * sizeof *m->symbol), a->symbol, (size_t)symbols * sizeof *m->symbol) };
    copy_factors(&m->factors, factors);
    *place = m;
    a->count++;
}

/* The factors of m with the symbols of the function that is asked for. False: the store is full. */
static bool rename_factors(struct poly_alike *a, const struct met *m, struct poly_factors *out)
{
    struct expr_store *st = a->st;
    size_t had = a->map_cap;
    SGA_RESERVE(a->map, a->map_cap, st->symbols + 1);
    if (a->map_cap > had)
        memset(a->map + had, 0, (a->map_cap - had) * sizeof *a->map);
    for (int i = 0; i < m->symbols; i++)
        a->map[m->symbol[i]] = st->symbol[a->symbol[i]].node;
    copy_factors(out, &m->factors);
    for (int i = 0; i < out->factors; i++) {
        expr_substitute(st, &out->factor[i].expr, 1, a->map);
        expr_substitute(st, out->factor[i].radical, out->factor[i].radicals, a->map);
    }
    for (int i = 0; i < m->symbols; i++)
        a->map[m->symbol[i]] = 0;
    if (!expr_store_ok(st))
        poly_factors_clear(out);
    return expr_store_ok(st);
}

bool poly_alike_factors(struct poly_alike *a, expr_id e, const struct poly_limits *limits, struct poly_factors *out)
{
    int symbols, length = shape_of(a, e, &symbols);
    if (!length)
        return poly_numerator_factors(a->st, e, limits, out);
    uint64_t hash = hash_of(a->shape, length);
    const struct met *m = find(a, hash, length);
    if (m) {
        assert(m->symbols == symbols);
        return rename_factors(a, m, out);
    }
    bool found = poly_numerator_factors(a->st, e, limits, out);
    if (found)
        keep(a, hash, length, symbols, out);
    return found;
}
