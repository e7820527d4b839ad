/* The store: nodes, constants, symbols, hash-consing, and the sticky error. */
#include "raw_nodes.h"

#include <stdlib.h>
#include <string.h>
#include <flint/fmpz.h>

#include "budget.h"
#include "error.h"
#include "expr_rows.h"
#include "mem.h"
#include "sort.h"

enum { LOOK_EVERY = 20000 };     /* nodes: some tenths of a millisecond */

expr_id expr_divisor(const struct expr_store *st, expr_id e)
{
    const struct expr_node *n = st->node + e;
    return n->op == EXPR_DIV ? n->b : n->op == EXPR_POWI && n->b < 0 ? n->a : EXPR_UNDEF;
}

void expr_store_init(struct expr_store *st)
{
    *st = (struct expr_store){ .max_bits = 1 << 17 };
    SGA_RESERVE(st->node, st->node_cap, 64);
    st->node[0] = (struct expr_node){ .op = EXPR_UNDEF_OP };
    st->nodes = 1;
    st->hash_mask = 255;
    st->hash = sga_calloc(st->hash_mask + 1, sizeof *st->hash);
    st->names_mask = 63;
    st->names = sga_calloc(st->names_mask + 1, sizeof *st->names);
    st->marks = expr_marks_new();
    st->error = sga_calloc(1, sizeof *st->error);
}

void expr_store_clear(struct expr_store *st)
{
    for (int i = 0; i < st->constants; i++)
        fmpq_clear(st->constant + i);
    for (int i = 0; i < st->symbols; i++)
        free(st->symbol[i].name);
    for (int i = 0; i < st->solves; i++) {
        expr_rows_clear(&st->solve[i].matrix);
        free(st->solve[i].rhs);
        free(st->solve[i].child);
    }
    expr_marks_leave(st->marks);
    free(st->residue);
    free(st->node);
    free(st->constant);
    free(st->symbol);
    free(st->solve);
    free(st->hash);
    free(st->names);
    free(st->error);
    *st = (struct expr_store){ 0 };
}

bool expr_store_ok(const struct expr_store *st)
{
    return st->error->code == SGA_E_OK;
}

static uint32_t mix(uint64_t op, uint64_t a, uint64_t b)
{
    uint64_t h = op * 0x9E3779B97F4A7C15u;
    h ^= (a + 0x632BE59BD9B4E019u) * 0xC2B2AE3D27D4EB4Fu;
    h = (h << 31) | (h >> 33);
    h ^= (b + 0x9FB21C651E98DF25u) * 0x165667B19E3779F9u;
    h *= 0x9E3779B97F4A7C15u;
    return (uint32_t)(h >> 32);
}

static uint32_t constant_hash(const fmpq *q)
{
    return mix(EXPR_CONST, fmpz_fdiv_ui(fmpq_numref(q), 4294967291u),
               fmpz_fdiv_ui(fmpq_denref(q), 4294967291u));
}

/* Twice as many slots, what they have put where it now belongs. */
static void grow_table(struct expr_slot **table, uint32_t *mask)
{
    uint32_t old = *mask;
    struct expr_slot *from = *table, *to = sga_calloc(2 * ((size_t)old + 1), sizeof *to);
    *mask = 2 * old + 1;
    for (uint32_t i = 0; i <= old; i++) {
        uint32_t h = from[i].hash & *mask;
        if (!from[i].is)
            continue;
        while (to[h].is)
            h = (h + 1) & *mask;
        to[h] = from[i];
    }
    free(from);
    *table = to;
}

bool expr_store_work(struct expr_store *st, long nodes)
{
    st->work += nodes;
    if (st->work < LOOK_EVERY)
        return expr_store_ok(st);
    st->work = 0;
    double late = st->deadline > 0 ? sga_now() - st->deadline : 0;
    if (late > 0)
        sga_fail(st->error, SGA_E_LIMIT_SECONDS, "the limit of %g seconds was reached (%.1f had passed); "
                 "raise limits.seconds or ask for less in want", st->seconds, st->seconds + late);
    return expr_store_ok(st);
}

static bool room(struct expr_store *st)
{
    if (!expr_store_work(st, 1))
        return false;
    if (st->max_nodes && st->nodes >= st->max_nodes)
        return sga_fail(st->error, SGA_E_LIMIT_NODES,
                        "the limit of %d expression nodes was reached; raise limits.nodes or ask for less in want",
                        st->max_nodes);
    if ((uint64_t)st->nodes * 4 > (uint64_t)st->hash_mask * 3)
        grow_table(&st->hash, &st->hash_mask);
    SGA_RESERVE(st->node, st->node_cap, st->nodes + 1);
    return true;
}

expr_id expr_node_make(struct expr_store *st, enum expr_op op, int32_t a, int32_t b)
{
    if (!room(st))
        return EXPR_UNDEF;
    uint32_t own = mix(op, (uint32_t)a, (uint32_t)b), h = own & st->hash_mask;
    for (; st->hash[h].is; h = (h + 1) & st->hash_mask) {
        const struct expr_node *n = st->node + st->hash[h].is;
        if (st->hash[h].hash == own && n->op == op && n->a == a && n->b == b)
            return st->hash[h].is;
    }
    st->node[st->nodes] = (struct expr_node){ .op = (uint8_t)op, .a = a, .b = b };
    st->hash[h] = (struct expr_slot){ st->nodes, own };
    st->signs |= op == EXPR_SIGN;
    return st->nodes++;
}

bool expr_bits_ok(struct expr_store *st, double bits)
{
    if (bits <= (double)st->max_bits)
        return true;
    return sga_fail(st->error, SGA_E_LIMIT_GROWTH, "an exact number of %.0f bits would be needed; the limit is %ld bits; "
                    "use smaller numbers or exponents", bits, st->max_bits);
}

/* Counts what constants cost to make, also where an equal one is there already. */
static bool work_ok(struct expr_store *st, size_t bits)
{
    st->work_bits += (double)bits;
    if (st->max_work_bits <= 0 || st->work_bits <= st->max_work_bits)
        return true;
    return sga_fail(st->error, SGA_E_LIMIT_GROWTH, "the exact numbers have more than %.0f bits together; "
                    "use fewer or smaller numbers", st->max_work_bits);
}

expr_id expr_fmpq(struct expr_store *st, const fmpq_t q)
{
    if (!room(st))
        return EXPR_UNDEF;
    size_t num = fmpz_bits(fmpq_numref(q)), den = fmpz_bits(fmpq_denref(q));
    if (!expr_bits_ok(st, (double)(num > den ? num : den)) || !work_ok(st, num + den))
        return EXPR_UNDEF;
    uint32_t own = constant_hash(q), h = own & st->hash_mask;
    for (; st->hash[h].is; h = (h + 1) & st->hash_mask) {
        const struct expr_node *n = st->node + st->hash[h].is;
        if (st->hash[h].hash == own && n->op == EXPR_CONST && fmpq_equal(st->constant + n->a, q))
            return st->hash[h].is;
    }
    SGA_RESERVE(st->constant, st->constant_cap, st->constants + 1);
    fmpq_init(st->constant + st->constants);
    fmpq_set(st->constant + st->constants, q);
    st->node[st->nodes] = (struct expr_node){ .op = EXPR_CONST, .a = st->constants++ };
    st->hash[h] = (struct expr_slot){ st->nodes, own };
    return st->nodes++;
}

/* FNV-1a */
static uint32_t name_hash(const char *name, size_t len)
{
    uint32_t h = 2166136261u;
    for (size_t i = 0; i < len; i++)
        h = (h ^ (unsigned char)name[i]) * 16777619u;
    return h;
}

static int find_name(const struct expr_store *st, uint32_t own, const char *name, size_t len)
{
    for (uint32_t h = own & st->names_mask; st->names[h].is; h = (h + 1) & st->names_mask) {
        if (st->names[h].hash != own)
            continue;
        const char *known = st->symbol[st->names[h].is - 1].name;
        if (strncmp(known, name, len) == 0 && known[len] == 0)
            return st->names[h].is - 1;
    }
    return -1;
}

expr_id expr_symbol_add(struct expr_store *st, const char *name, enum expr_symbol_kind kind)
{
    uint32_t own = name_hash(name, strlen(name));
    int old = find_name(st, own, name, strlen(name));
    if (old >= 0)
        return st->symbol[old].kind == kind ? st->symbol[old].node : EXPR_UNDEF;
    expr_id e = expr_node_make(st, EXPR_SYM, st->symbols, 0);
    if (!e)
        return e;
    SGA_RESERVE(st->symbol, st->symbol_cap, st->symbols + 1);
    st->symbol[st->symbols++] = (struct expr_symbol){ .name = sga_strdup(name), .kind = kind, .node = e };
    if ((uint32_t)st->symbols * 2 > st->names_mask)
        grow_table(&st->names, &st->names_mask);
    uint32_t h = own & st->names_mask;
    while (st->names[h].is)
        h = (h + 1) & st->names_mask;
    st->names[h] = (struct expr_slot){ st->symbols, own };
    return e;
}

int expr_symbol_find(const struct expr_store *st, const char *name, size_t len)
{
    return find_name(st, name_hash(name, len), name, len);
}

enum { LARGE_SOLVE = 16 };

/* What is in a large system, each once. */
static void list_children(struct expr_solve *s)
{
    int entries = s->matrix.start[s->m];
    s->child = NULL;
    s->children = entries + s->m;
    if (s->m < LARGE_SOLVE)
        return;
    expr_id *list = s->child = sga_malloc((size_t)s->children * sizeof *list);
    memcpy(list, s->matrix.entry, (size_t)entries * sizeof *list);
    memcpy(list + entries, s->rhs, (size_t)s->m * sizeof *list);
    sga_sort(list, (size_t)s->children);
    int count = s->children;
    s->children = 0;
    for (int k = 0; k < count; k++)
        if (k == 0 || list[k] != list[k - 1])
            list[s->children++] = list[k];
    s->child = sga_realloc(list, (size_t)s->children * sizeof *list);
}

static int add_solve(struct expr_store *st, int m, struct expr_rows matrix, const expr_id *rhs)
{
    SGA_RESERVE(st->solve, st->solve_cap, st->solves + 1);
    struct expr_solve *s = st->solve + st->solves;
    *s = (struct expr_solve){ .m = m, .matrix = matrix };
    s->rhs = sga_malloc((size_t)m * sizeof *s->rhs);
    memcpy(s->rhs, rhs, (size_t)m * sizeof *s->rhs);
    list_children(s);
    return st->solves++;
}

int expr_solve_add(struct expr_store *st, int m, const expr_id *matrix, const expr_id *rhs)
{
    return add_solve(st, m, expr_rows_of(m, m, matrix, expr_int(st, 0)), rhs);
}

int expr_solve_add_rows(struct expr_store *st, int m, const struct expr_rows *matrix, const expr_id *rhs)
{
    return add_solve(st, m, expr_rows_copy(matrix, m, expr_int(st, 0)), rhs);
}

expr_id expr_solution(struct expr_store *st, int solve, int component)
{
    return expr_node_make(st, EXPR_SOLVE, solve, component);
}

bool expr_is_zero(const struct expr_store *st, expr_id e)
{
    return expr_is_const(st, e) && fmpq_is_zero(st->constant + st->node[e].a);
}

bool expr_is_one(const struct expr_store *st, expr_id e)
{
    return expr_is_const(st, e) && fmpq_is_one(st->constant + st->node[e].a);
}

bool expr_is_int(const struct expr_store *st, expr_id e, long v)
{
    if (!expr_is_const(st, e))
        return false;
    const fmpq *q = st->constant + st->node[e].a;
    return fmpz_is_one(fmpq_denref(q)) && fmpz_equal_si(fmpq_numref(q), v);
}

const fmpq *expr_const_value(const struct expr_store *st, expr_id e)
{
    return st->constant + st->node[e].a;
}

int expr_children(const struct expr_store *st, expr_id e)
{
    const struct expr_node *n = st->node + e;
    return n->op == EXPR_SOLVE ? st->solve[n->a].children : expr_op_args(n->op);
}

expr_id expr_child(const struct expr_store *st, expr_id e, int k)
{
    const struct expr_node *n = st->node + e;
    if (n->op == EXPR_SOLVE) {
        const struct expr_solve *s = st->solve + n->a;
        if (s->child)
            return s->child[k];
        int entries = s->matrix.start[s->m];
        return k < entries ? s->matrix.entry[k] : s->rhs[k - entries];
    }
    return k == 0 ? n->a : n->b;
}

static bool node_sane(const struct expr_store *st, int e)
{
    const struct expr_node n = st->node[e];
    if (n.op >= EXPR_OP_COUNT)
        return false;
    switch ((enum expr_op)n.op) {
    case EXPR_UNDEF_OP: case EXPR_PI: return true;
    case EXPR_CONST: return n.a >= 0 && n.a < st->constants;
    case EXPR_SYM: return n.a >= 0 && n.a < st->symbols && st->symbol[n.a].node == e;
    case EXPR_SOLVE: return n.a >= 0 && n.a < st->solves && n.b >= 0 && n.b < st->solve[n.a].m;
    default: break;
    }
    bool two = expr_op_args(n.op) == 2;
    return n.a > 0 && n.a < e && (!two || (n.b > 0 && n.b < e));
}

bool expr_store_sane(const struct expr_store *st, int from)
{
    bool sane = st->nodes >= 0 && (size_t)st->nodes <= st->node_cap;
    for (int e = from > 0 ? from : 0; e < st->nodes && sane; e++)
        sane = node_sane(st, e);
    return sane;
}
