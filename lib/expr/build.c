/* Constructors: local simplification, exact constants, nothing expanded. */
#include "raw_nodes.h"
#include "same_sign.h"

#include <math.h>

#include <flint/fmpz.h>

#include "error.h"

#define ST struct expr_store *st

expr_id expr_int(ST, long v)
{
    return expr_rational(st, v, 1);
}

expr_id expr_rational(ST, long p, long q)
{
    fmpq_t r;
    fmpq_init(r);
    if (q < 0) {
        p = -p;
        q = -q;
    }
    fmpq_set_si(r, p, (ulong)q);
    expr_id e = expr_fmpq(st, r);
    fmpq_clear(r);
    return e;
}

expr_id expr_double(ST, double v)
{
    int exponent;
    double part = ldexp(frexp(v, &exponent), 53);
    fmpq_t r;
    fmpq_init(r);
    fmpq_set_si(r, (slong)part, 1);
    if (exponent >= 53)
        fmpq_mul_2exp(r, r, (flint_bitcnt_t)(exponent - 53));
    else
        fmpq_div_2exp(r, r, (flint_bitcnt_t)(53 - exponent));
    expr_id e = expr_fmpq(st, r);
    fmpq_clear(r);
    return e;
}

expr_id expr_pi(ST)
{
    return expr_node_make(st, EXPR_PI, 0, 0);
}

static enum expr_op op_of(const ST, expr_id e) { return (enum expr_op)st->node[e].op; }

/* Bits that a product of two constants may need: refused before it is formed. */
static bool product_fits(ST, const fmpq *x, const fmpq *y)
{
    size_t n = fmpz_bits(fmpq_numref(x)) + fmpz_bits(fmpq_numref(y));
    size_t d = fmpz_bits(fmpq_denref(x)) + fmpz_bits(fmpq_denref(y));
    size_t most = n > d ? n : d;
    return most <= 2 * (size_t)st->max_bits || expr_bits_ok(st, (double)most);
}

static expr_id fold(ST, enum expr_op op, expr_id a, expr_id b)
{
    const fmpq *x = expr_const_value(st, a), *y = expr_const_value(st, b);
    if (!product_fits(st, x, y))
        return EXPR_UNDEF;
    fmpq_t r;
    fmpq_init(r);
    switch (op) {
    case EXPR_ADD: fmpq_add(r, x, y); break;
    case EXPR_SUB: fmpq_sub(r, x, y); break;
    case EXPR_MUL: fmpq_mul(r, x, y); break;
    default:       fmpq_div(r, x, y); break;
    }
    expr_id e = expr_fmpq(st, r);
    fmpq_clear(r);
    return e;
}

expr_id expr_neg(ST, expr_id a)
{
    if (!a)
        return a;
    if (expr_is_const(st, a))
        return fold(st, EXPR_MUL, expr_int(st, -1), a);
    if (op_of(st, a) == EXPR_NEG)
        return st->node[a].a;
    if (op_of(st, a) == EXPR_SUB)
        return expr_node_make(st, EXPR_SUB, st->node[a].b, st->node[a].a);
    return expr_node_make(st, EXPR_NEG, a, 0);
}

expr_id expr_add(ST, expr_id a, expr_id b)
{
    if (!a || !b)
        return EXPR_UNDEF;
    if (expr_is_zero(st, a))
        return b;
    if (expr_is_zero(st, b))
        return a;
    if (expr_is_const(st, a) && expr_is_const(st, b))
        return fold(st, EXPR_ADD, a, b);
    if (op_of(st, b) == EXPR_NEG)
        return expr_sub(st, a, st->node[b].a);
    if (op_of(st, a) == EXPR_NEG)
        return expr_sub(st, b, st->node[a].a);
    if (op_of(st, a) == EXPR_SUB && st->node[a].b == b)
        return st->node[a].a;
    if (op_of(st, b) == EXPR_SUB && st->node[b].b == a)
        return st->node[b].a;
    if (a == b)
        return expr_mul(st, expr_int(st, 2), a);
    if (a > b) {
        expr_id c = a;
        a = b;
        b = c;
    }
    return expr_node_make(st, EXPR_ADD, a, b);
}

expr_id expr_sub(ST, expr_id a, expr_id b)
{
    if (!a || !b)
        return EXPR_UNDEF;
    if (expr_is_zero(st, b))
        return a;
    if (a == b)
        return expr_int(st, 0);
    if (expr_is_zero(st, a))
        return expr_neg(st, b);
    if (expr_is_const(st, a) && expr_is_const(st, b))
        return fold(st, EXPR_SUB, a, b);
    if (op_of(st, b) == EXPR_NEG)
        return expr_add(st, a, st->node[b].a);
    if (op_of(st, a) == EXPR_ADD) {
        if (st->node[a].a == b)
            return st->node[a].b;
        if (st->node[a].b == b)
            return st->node[a].a;
    }
    return expr_node_make(st, EXPR_SUB, a, b);
}

/* How deep in a product a factor is looked for. */
enum { FACTORS = 12 };

/* The product with u instead of this factor in it; EXPR_UNDEF: it has none, as far as it was looked for. */
static expr_id put_for_factor(ST, expr_id product, expr_id factor, expr_id u, int depth)
{
    enum expr_op op = op_of(st, product);
    expr_id a = st->node[product].a, b = st->node[product].b;
    if (product == factor)
        return u;
    if (op == EXPR_POWI && a == factor && b > 0)
        return expr_mul(st, u, expr_powi(st, a, b - 1));
    if ((op != EXPR_MUL && op != EXPR_DIV) || !depth)
        return EXPR_UNDEF;
    expr_id by = put_for_factor(st, a, factor, u, depth - 1);
    if (by)
        return op == EXPR_MUL ? expr_mul(st, by, b) : expr_div(st, by, b);
    by = op == EXPR_MUL ? put_for_factor(st, b, factor, u, depth - 1) : EXPR_UNDEF;
    return by ? expr_mul(st, a, by) : EXPR_UNDEF;
}

expr_id expr_put_for_factor(ST, expr_id product, expr_id factor, expr_id by)
{
    return put_for_factor(st, product, factor, by, FACTORS);
}

/* The product of two where one has a factor sign(u), and the other u: |u|, without a jump, instead of both. EXPR_UNDEF: it is not so. */
static expr_id without_jump(ST, expr_id signs, expr_id other, int depth)
{
    enum expr_op op = op_of(st, signs);
    expr_id a = st->node[signs].a, b = st->node[signs].b;
    if (op == EXPR_SIGN)
        return put_for_factor(st, other, a, expr_fun(st, EXPR_ABS, a), FACTORS);
    if ((op != EXPR_MUL && op != EXPR_DIV) || !depth)
        return EXPR_UNDEF;
    expr_id by = without_jump(st, a, other, depth - 1);
    if (by)
        return op == EXPR_MUL ? expr_mul(st, b, by) : expr_div(st, by, b);
    by = op == EXPR_MUL ? without_jump(st, b, other, depth - 1) : EXPR_UNDEF;
    return by ? expr_mul(st, a, by) : EXPR_UNDEF;
}

expr_id expr_mul(ST, expr_id a, expr_id b)
{
    if (!a || !b)
        return EXPR_UNDEF;
    if (expr_is_zero(st, a))
        return a;
    if (expr_is_zero(st, b))
        return b;
    if (expr_is_one(st, a))
        return b;
    if (expr_is_one(st, b))
        return a;
    bool ca = expr_is_const(st, a), cb = expr_is_const(st, b);
    if (ca && cb)
        return fold(st, EXPR_MUL, a, b);
    if (expr_is_int(st, a, -1))
        return expr_neg(st, b);
    if (expr_is_int(st, b, -1))
        return expr_neg(st, a);
    bool na = op_of(st, a) == EXPR_NEG, nb = op_of(st, b) == EXPR_NEG;
    if (na && nb)
        return expr_mul(st, st->node[a].a, st->node[b].a);
    if (na)
        return cb ? expr_mul(st, st->node[a].a, expr_neg(st, b))
                  : expr_neg(st, expr_mul(st, st->node[a].a, b));
    if (nb)
        return ca ? expr_mul(st, expr_neg(st, a), st->node[b].a)
                  : expr_neg(st, expr_mul(st, a, st->node[b].a));
    /* constants gather: c * (d * x) */
    if (cb) {
        expr_id c = a;
        a = b;
        b = c;
        ca = true;
    }
    if (ca && op_of(st, b) == EXPR_MUL && expr_is_const(st, st->node[b].a))
        return expr_mul(st, fold(st, EXPR_MUL, a, st->node[b].a), st->node[b].b);
    if (!ca && op_of(st, a) == EXPR_DIV && st->node[a].b == b)
        return st->node[a].a;
    if (!ca && op_of(st, b) == EXPR_DIV && st->node[b].b == a)
        return st->node[b].a;
    if (a == b)
        return expr_powi(st, a, 2);
    expr_id smooth = st->signs ? without_jump(st, a, b, FACTORS) : EXPR_UNDEF;
    smooth = smooth || !st->signs ? smooth : without_jump(st, b, a, FACTORS);
    if (smooth)
        return smooth;
    if (!ca && a > b) {
        expr_id c = a;
        a = b;
        b = c;
    }
    return expr_node_make(st, EXPR_MUL, a, b);
}

expr_id expr_div(ST, expr_id a, expr_id b)
{
    while (a && b && op_of(st, b) == EXPR_DIV) {       /* a / (p / q) */
        a = expr_mul(st, a, st->node[b].b);
        b = st->node[b].a;
    }
    if (!a || !b)
        return EXPR_UNDEF;
    if (expr_is_const(st, b)) {
        if (expr_is_zero(st, b)) {
            sga_fail(st->error, SGA_E_EXPR_UNDEFINED, "a division by zero");
            return EXPR_UNDEF;
        }
        if (expr_is_const(st, a))
            return fold(st, EXPR_DIV, a, b);
        return expr_mul(st, fold(st, EXPR_DIV, expr_int(st, 1), b), a);
    }
    if (expr_is_zero(st, a))
        return a;
    if (a == b)
        return expr_int(st, 1);
    bool na = op_of(st, a) == EXPR_NEG, nb = op_of(st, b) == EXPR_NEG;
    if (na && nb)
        return expr_div(st, st->node[a].a, st->node[b].a);
    if (na)
        return expr_neg(st, expr_div(st, st->node[a].a, b));
    if (nb)
        return expr_neg(st, expr_div(st, a, st->node[b].a));
    return expr_node_make(st, EXPR_DIV, a, b);
}

static expr_id constant_power(ST, expr_id a, long n)
{
    const fmpq *x = expr_const_value(st, a);
    ulong m = n < 0 ? 0ul - (ulong)n : (ulong)n;
    if (fmpq_is_zero(x) && n < 0) {
        sga_fail(st->error, SGA_E_EXPR_UNDEFINED, "a negative power of zero");
        return EXPR_UNDEF;
    }
    bool unit = fmpz_is_pm1(fmpq_numref(x)) || fmpz_is_zero(fmpq_numref(x));
    ulong nb = unit ? 1 : fmpz_bits(fmpq_numref(x)), db = fmpz_is_one(fmpq_denref(x)) ? 1 : fmpz_bits(fmpq_denref(x));
    ulong limit = (ulong)st->max_bits;
    if ((nb > 1 && m > limit / (nb - 1)) || (db > 1 && m > limit / (db - 1))) {
        expr_bits_ok(st, (double)m * (double)((nb > db ? nb : db) - 1));
        return EXPR_UNDEF;
    }
    fmpq_t r;
    fmpq_init(r);
    fmpz_pow_ui(fmpq_numref(r), fmpq_numref(x), m);
    fmpz_pow_ui(fmpq_denref(r), fmpq_denref(x), m);
    if (n < 0)
        fmpq_inv(r, r);
    expr_id e = expr_fmpq(st, r);
    fmpq_clear(r);
    return e;
}

expr_id expr_powi(ST, expr_id a, long n)
{
    if (!a)
        return a;
    if (n == 0)
        return expr_int(st, 1);
    if (n == 1)
        return a;
    if (expr_is_const(st, a))
        return constant_power(st, a, n);
    if (n == -1)
        return expr_div(st, expr_int(st, 1), a);
    if (n > INT32_MAX || n < -INT32_MAX) {
        sga_fail(st->error, SGA_E_LIMIT_EXPONENT, "the exponent %ld is too large; the limit is %d", n, INT32_MAX);
        return EXPR_UNDEF;
    }
    if (op_of(st, a) == EXPR_NEG) {
        expr_id p = expr_powi(st, st->node[a].a, n);
        return n % 2 ? expr_neg(st, p) : p;
    }
    if (op_of(st, a) == EXPR_POWI) {
        long long m = (long long)st->node[a].b * n;
        if (m <= INT32_MAX && m >= -INT32_MAX)
            return expr_powi(st, st->node[a].a, (long)m);
    }
    return expr_node_make(st, EXPR_POWI, a, (int32_t)n);
}

/* An exact root of a constant, where it is rational. */
static expr_id exact_root(ST, const fmpq *x, ulong k)
{
    fmpq_t r;
    fmpq_init(r);
    expr_id e = EXPR_UNDEF;
    if ((k % 2 == 1 || fmpq_sgn(x) >= 0) && fmpz_root(fmpq_numref(r), fmpq_numref(x), (slong)k)
        && fmpz_root(fmpq_denref(r), fmpq_denref(x), (slong)k))
        e = expr_fmpq(st, r);
    fmpq_clear(r);
    return e;
}

expr_id expr_pow(ST, expr_id a, expr_id b)
{
    if (!a || !b)
        return EXPR_UNDEF;
    if (expr_is_const(st, b)) {
        const fmpq *q = expr_const_value(st, b);
        if (fmpz_is_one(fmpq_denref(q))) {
            if (!fmpz_abs_fits_ui(fmpq_numref(q)) || fmpz_bits(fmpq_numref(q)) > 31) {
                sga_fail(st->error, SGA_E_LIMIT_EXPONENT, "an exponent is too large; the limit is %d", INT32_MAX);
                return EXPR_UNDEF;
            }
            return expr_powi(st, a, fmpz_get_si(fmpq_numref(q)));
        }
        if (fmpz_equal_ui(fmpq_denref(q), 2) && fmpz_bits(fmpq_numref(q)) <= 31)
            return expr_powi(st, expr_fun(st, EXPR_SQRT, a), fmpz_get_si(fmpq_numref(q)));
        if (expr_is_const(st, a) && fmpz_bits(fmpq_numref(q)) <= 31 && fmpz_bits(fmpq_denref(q)) <= 31
            && fmpq_sgn(expr_const_value(st, a)) > 0) {
            expr_id r = exact_root(st, expr_const_value(st, a), fmpz_get_ui(fmpq_denref(q)));
            if (r)
                return expr_powi(st, r, fmpz_get_si(fmpq_numref(q)));
        }
    }
    return expr_node_make(st, EXPR_POW, a, b);
}

static bool is_odd(enum expr_op op)
{
    return expr_op_traits(op) & EXPR_IS_ODD && !(expr_op_traits(op) & EXPR_HAS_BRANCHES);
}

/* Functions of exact constants that are exact constants. */
static expr_id exact_function(ST, enum expr_op op, expr_id a)
{
    const fmpq *x = expr_const_value(st, a);
    if (op == EXPR_ABS)
        return fmpq_sgn(x) < 0 ? expr_neg(st, a) : a;
    if (op == EXPR_SIGN)
        return expr_int(st, fmpq_sgn(x));
    if (op == EXPR_SQRT || op == EXPR_CBRT)
        return exact_root(st, x, op == EXPR_SQRT ? 2 : 3);
    if (fmpq_is_zero(x)) {
        if (is_odd(op))
            return a;
        if (expr_op_traits(op) & EXPR_IS_1_AT_0)
            return expr_int(st, 1);
    }
    if (fmpq_is_one(x) && expr_op_traits(expr_op_undone(op)) & EXPR_IS_1_AT_0)
        return expr_int(st, 0);
    return EXPR_UNDEF;
}

/* The sign of a power or a multiple, and abs of a multiple: switches stand at the zeros of what has a rate there. */
static expr_id of_sign(ST, enum expr_op op, expr_id a)
{
    struct expr_node n = st->node[a];
    bool turns = false;
    if (op == EXPR_SIGN) {
        expr_id e = a;
        for (expr_id next; (next = expr_peeled(st, e, &turns)) != e; e = next) { }
        e = op_of(st, e) == EXPR_SIGN ? e : expr_node_make(st, op, e, 0);
        return turns ? expr_neg(st, e) : e;
    }
    if (op == EXPR_ABS && (enum expr_op)n.op == EXPR_MUL && expr_is_const(st, n.a))
        return expr_mul(st, expr_fun(st, EXPR_ABS, n.a), expr_fun(st, EXPR_ABS, n.b));
    return expr_node_make(st, op, a, 0);
}

expr_id expr_fun(ST, enum expr_op op, expr_id a)
{
    if (!a)
        return a;
    if (expr_is_const(st, a)) {
        expr_id e = exact_function(st, op, a);
        if (e || !expr_store_ok(st))
            return e;
        const fmpq *x = expr_const_value(st, a);
        if ((op == EXPR_LOG && fmpq_sgn(x) <= 0) || (op == EXPR_SQRT && fmpq_sgn(x) < 0)) {
            sga_fail(st->error, SGA_E_EXPR_UNDEFINED, "%s of a constant that is %s has no real value",
                     expr_op_text(op), fmpq_sgn(x) < 0 ? "negative" : "zero");
            return EXPR_UNDEF;
        }
    }
    if (op_of(st, a) == EXPR_NEG || (expr_is_const(st, a) && fmpq_sgn(expr_const_value(st, a)) < 0)) {
        if (is_odd(op))
            return expr_neg(st, expr_fun(st, op, expr_neg(st, a)));
        if (op == EXPR_COS || op == EXPR_COSH || op == EXPR_ABS)
            return expr_fun(st, op, expr_neg(st, a));
    }
    return op == EXPR_SIGN || op == EXPR_ABS ? of_sign(st, op, a) : expr_node_make(st, op, a, 0);
}

expr_id expr_fun2(ST, enum expr_op op, expr_id a, expr_id b)
{
    if (!a || !b)
        return EXPR_UNDEF;
    if ((op == EXPR_MIN || op == EXPR_MAX) && expr_is_const(st, a) && expr_is_const(st, b)) {
        int c = fmpq_cmp(expr_const_value(st, a), expr_const_value(st, b));
        return (c <= 0) == (op == EXPR_MIN) ? a : b;
    }
    if ((op == EXPR_MIN || op == EXPR_MAX) && a == b)
        return a;
    if ((op == EXPR_MIN || op == EXPR_MAX) && a > b)
        return expr_node_make(st, op, b, a);
    return expr_node_make(st, op, a, b);
}
