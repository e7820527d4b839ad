/* Residues modulo 2^61 - 1, kept by the store. */
#include "residue.h"

#include <stdlib.h>
#include <string.h>
#include <flint/fmpz.h>

#include "arena.h"
#include "mem.h"

static const uint64_t PRIME = (1ull << 61) - 1;
enum { POINTS = 2, SMALL = 1 << 20 };

/* By node: value + 1, or what is not known yet, or has no value. */
struct expr_residue { uint64_t at[POINTS]; };
static const uint64_t UNKNOWN = 0, NONE = UINT64_MAX;

static uint64_t reduce(unsigned __int128 v)
{
    return (uint64_t)(v % PRIME);
}

static uint64_t product(uint64_t a, uint64_t b) { return reduce((unsigned __int128)a * b); }
static uint64_t opposite(uint64_t a) { return a ? PRIME - a : 0; }

static uint64_t power(uint64_t a, uint64_t n)
{
    uint64_t v = 1;
    for (; n; n >>= 1, a = product(a, a))
        if (n & 1)
            v = product(v, a);
    return v;
}

static uint64_t inverse(uint64_t a) { return power(a, PRIME - 2); }

/* splitmix64 (Steele, Lea, Flood, OOPSLA 2014), twice. */
static uint64_t stir(uint64_t x)
{
    for (int k = 0; k < 2; k++) {
        x += 0x9E3779B97F4A7C15u;
        x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
        x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
        x ^= x >> 31;
    }
    return x;
}

/* Another one at each point, so that sin(1) is no constant: only rational ones are. */
static uint64_t unknown_value(int point, uint64_t op, uint64_t a, uint64_t b)
{
    return stir(stir(stir(op * POINTS + (uint64_t)point) ^ a) ^ b) % PRIME;
}

/* The root of a small square or cube, or 0. */
static uint64_t small_root(uint64_t v, unsigned k)
{
    for (uint64_t r = 1; r * r <= v && v <= SMALL; r++)
        if ((k == 2 ? r * r : r * r * r) == v)
            return r;
    return 0;
}

static uint64_t function(int point, enum expr_op op, uint64_t a)
{
    unsigned traits = expr_op_traits(op), undone = expr_op_traits(expr_op_undone(op));
    bool minus = a > PRIME / 2;
    if (minus && traits & EXPR_IS_EVEN)
        return function(point, op, opposite(a));
    if (minus && traits & EXPR_IS_ODD)
        return opposite(function(point, op, opposite(a)));
    if (a == 0 && traits & (EXPR_IS_ODD | EXPR_IS_1_AT_0))
        return traits & EXPR_IS_1_AT_0 ? 1 : 0;
    if (a == 1 && undone & EXPR_IS_1_AT_0)
        return 0;
    if ((op == EXPR_ABS || op == EXPR_SIGN) && a <= SMALL)
        return op == EXPR_ABS ? a : 1;
    uint64_t root = op == EXPR_SQRT || op == EXPR_CBRT ? small_root(a, op == EXPR_SQRT ? 2 : 3) : 0;
    return root || (op == EXPR_SQRT && a == 0) ? root : unknown_value(point, op, a, 0);
}

static uint64_t any_power(int point, uint64_t a, uint64_t b)
{
    if (b <= SMALL || b >= PRIME - SMALL)
        return b <= SMALL ? power(a, b) : a ? power(inverse(a), PRIME - b) : NONE;
    return a ? unknown_value(point, EXPR_POW, a, b) : 0;
}

static uint64_t constant(const fmpq *q)
{
    uint64_t d = fmpz_fdiv_ui(fmpq_denref(q), PRIME);
    return d ? product(fmpz_fdiv_ui(fmpq_numref(q), PRIME), inverse(d)) : NONE;
}

/* The value of node e at a point, its children's known. */
static uint64_t value_at(const struct expr_store *st, expr_id e, int point)
{
    const struct expr_node n = st->node[e];
    enum expr_op op = (enum expr_op)n.op;
    if (op == EXPR_CONST)
        return constant(st->constant + n.a);
    if (op == EXPR_PI || op == EXPR_SYM || op == EXPR_SOLVE || op == EXPR_UNDEF_OP)
        return unknown_value(point, op, (uint64_t)e, 0);
    uint64_t a = st->residue[n.a].at[point], b = expr_op_args(op) == 2 ? st->residue[n.b].at[point] : 1;
    if (a == NONE || b == NONE)
        return NONE;
    a--;
    b--;
    switch (op) {
    case EXPR_ADD:  return reduce((unsigned __int128)a + b);
    case EXPR_SUB:  return reduce((unsigned __int128)a + opposite(b));
    case EXPR_MUL:  return product(a, b);
    case EXPR_DIV:  return b ? product(a, inverse(b)) : NONE;
    case EXPR_NEG:  return opposite(a);
    case EXPR_POWI: return n.b >= 0 ? power(a, (uint64_t)n.b) : a ? power(inverse(a), (uint64_t)(-(int64_t)n.b)) : NONE;
    case EXPR_POW:  return any_power(point, a, b);
    case EXPR_MIN: case EXPR_MAX: return a == b ? a : unknown_value(point, op, a < b ? a : b, a < b ? b : a);
    default:        return expr_op_args(op) == 1 ? function(point, op, a) : unknown_value(point, op, a, b);
    }
}

static void make_room(struct expr_store *st)
{
    size_t old = st->residue_cap;
    SGA_RESERVE(st->residue, st->residue_cap, st->nodes);
    if (st->residue_cap > old)
        memset(st->residue + old, 0, (st->residue_cap - old) * sizeof *st->residue);
}

static bool known(const struct expr_store *st, expr_id e) { return st->residue[e].at[0] != UNKNOWN; }

bool expr_seems_constant(struct expr_store *st, expr_id e)
{
    if (expr_is_const(st, e))
        return true;
    if (expr_op_of(st, e) == EXPR_SYM)
        return false;
    make_room(st);
    SGA_FREED expr_id *work = NULL;
    size_t cap = 0, n = 0;
    SGA_RESERVE(work, cap, 1);
    work[n++] = e;
    while (n) {
        expr_id top = work[n - 1];
        int waits = 0;
        SGA_RESERVE(work, cap, n + 2);
        for (int k = 0; !known(st, top) && expr_op_of(st, top) != EXPR_SOLVE && k < expr_children(st, top); k++)
            if (!known(st, expr_child(st, top, k))) {
                work[n++] = expr_child(st, top, k);
                waits++;
            }
        if (waits)
            continue;
        for (int k = 0; k < POINTS && (k || !known(st, top)); k++) {
            uint64_t v = value_at(st, top, k);
            st->residue[top].at[k] = v == NONE ? NONE : v + 1;
        }
        n--;
        expr_store_work(st, 1);
    }
    const uint64_t *at = st->residue[e].at;
    return at[0] != NONE && at[0] == at[1];
}
