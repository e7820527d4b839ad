/* Polynomials of the first and second degree that cannot factor, as their values on a line show.
 *
 * On x = a + b s modulo a prime p a polynomial of degree D becomes one in s. Where its degree stays D, factors over the rationals
 * (over the fractions without p below, by Gauss's lemma) keep theirs, and would be factors there. One of degree 2 has none where its discriminant
 * is no square modulo p: one line in about two shows it. */
#include "poly.h"

#include <assert.h>
#include <string.h>
#include <flint/ulong_extras.h>

#include "arena.h"
#include "mem.h"

enum { MOST_DEGREE = 2, WORDS = MOST_DEGREE + 1, MOST_NODES = 400, LINES = 8 };
static const ulong PRIME = 1048573;      /* products of two fit into 40 bits */

struct line {
    const struct expr_store *st;
    const struct expr_cone *cone;
    ulong (*value)[WORDS];     /* by place in the cone */
    int *degree;               /* no more than */
    int turn;                  /* -1: the origin instead */
};

/* A place on the line by the symbol, any numbers below p. */
static ulong some(int symbol, int turn, int which)
{
    uint64_t z = (uint64_t)symbol * 0x9E3779B97F4A7C15u + (uint64_t)(2 * turn + which + 1) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 31)) * 0x94D049BB133111EBu;
    return 1 + (z >> 20) % (PRIME - 1);
}

static bool constant(const struct expr_store *st, expr_id e, ulong *v)
{
    const fmpq *q = expr_const_value(st, e);
    ulong below = fmpz_fdiv_ui(fmpq_denref(q), PRIME);
    if (!below)
        return false;
    *v = fmpz_fdiv_ui(fmpq_numref(q), PRIME) * n_invmod(below, PRIME) % PRIME;
    return true;
}

static bool times(const ulong *x, int m, const ulong *y, int n, ulong *to)
{
    ulong all[WORDS] = { 0 };
    if (m + n > MOST_DEGREE)
        return false;
    for (int i = 0; i <= m; i++)
        for (int k = 0; k <= n; k++)
            all[i + k] = (all[i + k] + x[i] * y[k]) % PRIME;
    memcpy(to, all, sizeof all);
    return true;
}

static bool power(const ulong *x, int m, int n, ulong *to)
{
    ulong all[WORDS] = { 1 };
    bool ok = n >= 2 && (long)m * n <= MOST_DEGREE && n <= MOST_DEGREE;
    for (int k = 0; k < n && ok; k++)
        ok = times(all, m * k, x, m, all);
    memcpy(to, all, sizeof all);
    return ok;
}

static void add(const ulong *x, const ulong *y, bool less, ulong *to)
{
    for (int i = 0; i < WORDS; i++)
        to[i] = (x[i] + (less && y[i] ? PRIME - y[i] : y[i])) % PRIME;
}

static bool node(struct line *l, int at)
{
    static const ulong zero[WORDS] = { 0 };
    const struct expr_node n = l->st->node[l->cone->list[at]];
    int args = expr_op_args((enum expr_op)n.op), a = args > 0 ? expr_cone_place(l->cone, n.a) : -1, b = args > 1 ? expr_cone_place(l->cone, n.b) : -1;
    ulong *to = l->value[at], below[WORDS] = { 0 };
    int *deg = l->degree;
    memset(to, 0, sizeof l->value[at]);
    switch (n.op) {
    case EXPR_CONST:
        deg[at] = 0;
        return constant(l->st, l->cone->list[at], to);
    case EXPR_SYM:
        deg[at] = 1;
        to[0] = l->turn < 0 ? 0 : some(n.a, l->turn, 0);
        to[1] = l->turn < 0 ? 0 : some(n.a, l->turn, 1);
        return true;
    case EXPR_ADD: case EXPR_SUB:
        deg[at] = deg[a] > deg[b] ? deg[a] : deg[b];
        add(l->value[a], l->value[b], n.op == EXPR_SUB, to);
        return true;
    case EXPR_NEG:
        deg[at] = deg[a];
        add(zero, l->value[a], true, to);
        return true;
    case EXPR_MUL:
        deg[at] = deg[a] + deg[b];
        return times(l->value[a], deg[a], l->value[b], deg[b], to);
    case EXPR_DIV:
        deg[at] = deg[a];
        if (!expr_is_const(l->st, n.b) || !l->value[b][0])
            return false;
        below[0] = n_invmod(l->value[b][0], PRIME);
        return times(l->value[a], deg[a], below, 0, to);
    case EXPR_POWI:
        deg[at] = deg[a] * n.b;
        return power(l->value[a], deg[a], n.b, to);
    default:
        return false;
    }
}

/* Of degree 2. */
static bool irreducible(const ulong *value)
{
    ulong square = value[1] * value[1] % PRIME, four = 4 * (value[0] * value[2] % PRIME) % PRIME;
    return n_jacobi_unsigned((square + PRIME - four) % PRIME, PRIME) == -1;
}

/* The value of the last node, where all have values. */
static const ulong *values(struct line *l, int turn)
{
    l->turn = turn;
    for (int i = 0; i < l->cone->count; i++)
        if (!node(l, i))
            return NULL;
    return l->value[l->cone->count - 1];
}

bool poly_shown_irreducible(const struct expr_store *st, expr_id e, bool *at_origin)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_ARENA(mem);
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    if (cone.count > MOST_NODES || !cone.count)
        return false;
    expr_cone_index(&cone);
    struct line l = { .st = st, .cone = &cone, .value = sga_take(&mem, (size_t)cone.count * sizeof *l.value),
                      .degree = sga_zeros(&mem, (size_t)cone.count, sizeof *l.degree) };
    int last = cone.count - 1;
    assert(cone.list[last] == e);
    const ulong *v = at_origin ? values(&l, -1) : NULL;
    if (v)
        *at_origin = v[0] == 0;
    for (int turn = 0; turn < LINES && (v = values(&l, turn)); turn++) {
        int degree = l.degree[last];
        if (degree < 1 || !v[degree])
            return false;           /* terms cancel: the degree is not known, or this prime does not tell */
        if (degree == 1 || irreducible(v))
            return true;
    }
    return false;
}
