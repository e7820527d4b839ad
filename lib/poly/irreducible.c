/* Polynomials that cannot factor, as their values on a line modulo a prime show.
 *
 * On x = a + b s modulo a prime p a polynomial of degree D becomes one in s. Where its degree stays D, factors over the rationals
 * (over the fractions without p below, by Gauss's lemma) keep theirs, and would be factors there. Two kinds are told:
 * - of degree 2: there are none where the discriminant is no square modulo p. One line in about two shows it.
 * - of the first degree in some symbol, r + c z: a factor without z would divide c and r both, and keeps its degree where c keeps its own. There
 *   is none where they have no common factor on the line. */
#include "poly.h"

#include <assert.h>
#include <string.h>
#include <flint/ulong_extras.h>

#include "arena.h"
#include "mem.h"

enum { MOST_DEGREE = 6, WORDS = MOST_DEGREE + 1, MOST_NODES = 400, MOST_SYMBOLS = 8, LINES = 8 };

/* Below 2^20: sums of products fit. Of -1, 2, 3, 5, 7 each is no square modulo some, so that sums of squares are told as well. */
static const ulong prime[LINES] = { 1048571, 1048517, 1048447, 1048391, 1048361, 1048291, 1048213, 1048051 };

/* rest + slope z, both in s; degrees are bounds, -1: 0 for certain. */
struct pair {
    ulong rest[WORDS], slope[WORDS];
    int rests, slopes;
};

struct line {
    const struct expr_store *st;
    const struct expr_cone *cone;
    struct pair *value;        /* by place in the cone */
    ulong p;
    int turn;                  /* -1: the origin instead */
    int linear;                /* the symbol z; -1: none */
};

/* A place on the line by the symbol, any numbers below p. */
static ulong some(const struct line *l, int symbol, int which)
{
    uint64_t z = (uint64_t)symbol * 0x9E3779B97F4A7C15u + (uint64_t)(2 * l->turn + which + 1) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 31)) * 0x94D049BB133111EBu;
    return 1 + (z >> 20) % (l->p - 1);
}

static bool constant(const struct line *l, expr_id e, struct pair *to)
{
    const fmpq *q = expr_const_value(l->st, e);
    ulong below = fmpz_fdiv_ui(fmpq_denref(q), l->p);
    if (!below)
        return false;
    to->rest[0] = fmpz_fdiv_ui(fmpq_numref(q), l->p) * n_invmod(below, l->p) % l->p;
    to->rests = 0;
    return true;
}

static void symbol(const struct line *l, int which, struct pair *to)
{
    if (which == l->linear) {
        to->slope[0] = 1;
        to->slopes = 0;
    } else {
        to->rest[0] = l->turn < 0 ? 0 : some(l, which, 0);
        to->rest[1] = l->turn < 0 ? 0 : some(l, which, 1);
        to->rests = 1;
    }
}

static int larger(int a, int b)
{
    return a > b ? a : b;
}

/* to += x y; a bound of its degree. */
static int plus_product(const ulong *x, int m, const ulong *y, int n, ulong *to)
{
    if (m < 0 || n < 0)
        return -1;
    for (int i = 0; i <= m && m + n <= MOST_DEGREE; i++)
        for (int k = 0; k <= n; k++)
            to[i + k] += x[i] * y[k];
    return m + n;
}

static bool times(const struct line *l, const struct pair *x, const struct pair *y, struct pair *to)
{
    struct pair all = { .rests = -1, .slopes = -1 };
    if (x->slopes >= 0 && y->slopes >= 0)
        return false;
    all.rests = plus_product(x->rest, x->rests, y->rest, y->rests, all.rest);
    all.slopes = plus_product(x->rest, x->rests, y->slope, y->slopes, all.slope);
    all.slopes = larger(all.slopes, plus_product(x->slope, x->slopes, y->rest, y->rests, all.slope));
    if (all.rests > MOST_DEGREE || all.slopes > MOST_DEGREE)
        return false;
    for (int i = 0; i <= all.rests; i++)
        all.rest[i] %= l->p;
    for (int i = 0; i <= all.slopes; i++)
        all.slope[i] %= l->p;
    *to = all;
    return true;
}

static bool power(const struct line *l, const struct pair *x, int n, struct pair *to)
{
    struct pair all = *x;
    bool ok = n >= 2 && n <= MOST_DEGREE;
    for (int k = 1; k < n && ok; k++)
        ok = times(l, &all, x, &all);
    *to = all;
    return ok;
}

static void sum(const struct line *l, const ulong *x, const ulong *y, int degree, bool less, ulong *to)
{
    for (int i = 0; i <= degree; i++) {
        ulong v = x[i] + (less ? l->p - y[i] : y[i]);
        to[i] = v >= l->p ? v - l->p : v;
    }
}

static void add(const struct line *l, const struct pair *x, const struct pair *y, bool less, struct pair *to)
{
    to->rests = larger(x->rests, y->rests);
    to->slopes = larger(x->slopes, y->slopes);
    sum(l, x->rest, y->rest, to->rests, less, to->rest);
    sum(l, x->slope, y->slope, to->slopes, less, to->slope);
}

static bool node(const struct line *l, int at)
{
    static const struct pair zero = { .rests = -1, .slopes = -1 };
    const struct expr_node n = l->st->node[l->cone->list[at]];
    int args = expr_op_args((enum expr_op)n.op);
    const struct pair *a = args > 0 ? l->value + expr_cone_place(l->cone, n.a) : NULL, *b = args > 1 ? l->value + expr_cone_place(l->cone, n.b) : NULL;
    struct pair *to = l->value + at, below = zero;
    *to = zero;
    switch (n.op) {
    case EXPR_CONST:
        return constant(l, l->cone->list[at], to);
    case EXPR_SYM:
        symbol(l, n.a, to);
        return true;
    case EXPR_ADD: case EXPR_SUB:
        add(l, a, b, n.op == EXPR_SUB, to);
        return true;
    case EXPR_NEG:
        add(l, &zero, a, true, to);
        return true;
    case EXPR_MUL:
        return times(l, a, b, to);
    case EXPR_DIV:
        if (!expr_is_const(l->st, n.b) || !b->rest[0])
            return false;
        below.rest[0] = n_invmod(b->rest[0], l->p);
        below.rests = 0;
        return times(l, a, &below, to);
    case EXPR_POWI:
        return power(l, a, n.b, to);
    default:
        return false;
    }
}

/* The value of the last node, where all have values. */
static const struct pair *values(struct line *l, int turn, int linear)
{
    l->turn = turn;
    l->p = prime[turn < 0 ? 0 : turn];
    l->linear = linear;
    for (int i = 0; i < l->cone->count; i++)
        if (!node(l, i))
            return NULL;
    return l->value + l->cone->count - 1;
}

/* Of degree 2. */
static bool no_square(const ulong *v, ulong p)
{
    ulong square = v[1] * v[1] % p, four = 4 * (v[0] * v[2] % p) % p;
    return n_jacobi_unsigned((square + p - four) % p, p) == -1;
}

static bool small_degree(struct line *l)
{
    const struct pair *v;
    for (int turn = 0; turn < LINES && (v = values(l, turn, -1)) && v->rests <= 2; turn++) {
        if (v->rests < 1 || !v->rest[v->rests])
            return false;           /* terms cancel: the degree is not known, or this prime does not tell */
        if (v->rests == 1 || no_square(v->rest, l->p))
            return true;
    }
    return false;
}

/* The degree of the greatest common factor of x and y, which are lost; -1: of zeros. */
static int common(ulong *x, int m, ulong *y, int n, ulong p)
{
    for (;;) {
        while (n >= 0 && !y[n])
            n--;
        while (m >= 0 && !x[m])
            m--;
        if (n < 0 || m < 0)
            return larger(m, n);
        if (m < n) {
            ulong *other = x;
            int degree = m;
            x = y;
            m = n;
            y = other;
            n = degree;
        }
        ulong by = x[m] * n_invmod(y[n], p) % p;
        for (int i = 0; i <= n; i++)
            x[m - n + i] = (x[m - n + i] + (p - by) * y[i]) % p;
    }
}

static bool linear_in(struct line *l, int z)
{
    bool found = false;
    for (int turn = 0; turn < 2 && !found; turn++) {       /* two, as one prime may divide a denominator */
        const struct pair *v = values(l, turn, z);
        struct pair w;
        if (!v || v->slopes < 0 || !v->slope[v->slopes])
            continue;
        w = *v;
        found = common(w.rest, w.rests, w.slope, w.slopes, l->p) == 0;
    }
    return found;
}

static bool linear_in_some(struct line *l)
{
    for (int i = 0, seen = 0; i < l->cone->count && seen < MOST_SYMBOLS; i++) {
        const struct expr_node *n = l->st->node + l->cone->list[i];
        if (n->op != EXPR_SYM)
            continue;
        if (linear_in(l, n->a))
            return true;
        seen++;
    }
    return false;
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
    struct line l = { .st = st, .cone = &cone, .value = sga_take(&mem, (size_t)cone.count * sizeof *l.value) };
    assert(cone.list[cone.count - 1] == e);
    const struct pair *v = at_origin ? values(&l, -1, -1) : NULL;
    if (v)
        *at_origin = v->rest[0] == 0;
    return (!at_origin || v) && (small_degree(&l) || linear_in_some(&l));
}
