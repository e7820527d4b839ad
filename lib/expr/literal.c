/* Exact decimals, and the domains of functions and powers of exact constants.
 *
 * The constructors fold what is exact and leave the rest as nodes; a node such as
 * asin(2) would only fail much later, at every point, so the reader refuses it. */
#include "literal.h"

#include <stdlib.h>
#include <string.h>
#include <flint/fmpz.h>

#include "error.h"
#include "mem.h"
#include "op.h"

/* The value of a decimal exponent, saturated well past the limit. */
static long read_exponent(const char *s, size_t n)
{
    bool minus = n && s[0] == '-';
    long e = 0;
    for (size_t i = n && (s[0] == '-' || s[0] == '+') ? 1 : 0; i < n; i++)
        if (e <= 10L * LITERAL_MAX_EXPONENT)
            e = 10 * e + (s[i] - '0');
    return minus ? -e : e;
}

static expr_id scaled(struct expr_store *st, const char *digits, long exponent)
{
    fmpq_t q;
    fmpz_t ten;
    fmpq_init(q);
    fmpz_init(ten);
    fmpz_set_str(fmpq_numref(q), digits, 10);
    fmpz_set_ui(ten, 10);
    fmpz_pow_ui(ten, ten, (ulong)labs(exponent));
    if (exponent >= 0) {
        fmpz_mul(fmpq_numref(q), fmpq_numref(q), ten);
    } else {
        fmpz_set(fmpq_denref(q), ten);
        fmpq_canonicalise(q);
    }
    expr_id e = expr_fmpq(st, q);
    fmpz_clear(ten);
    fmpq_clear(q);
    return e;
}

expr_id literal_number(struct expr_store *st, const char *text, size_t length, int max_digits,
                       struct sga_error *err)
{
    size_t n = 0, fraction = 0, i = 0;
    bool point = false;
    for (; i < length && text[i] != 'e' && text[i] != 'E'; i++) {
        point = point || text[i] == '.';
        n += text[i] != '.';
        fraction += point && text[i] != '.';
    }
    if (n > (size_t)max_digits) {
        sga_fail(err, SGA_E_LIMIT_BITS, "a number has %zu digits; the limit is %d", n, max_digits);
        return EXPR_UNDEF;
    }
    long exponent = i < length ? read_exponent(text + i + 1, length - i - 1) : 0;
    if (labs(exponent) > LITERAL_MAX_EXPONENT) {
        sga_fail(err, SGA_E_LIMIT_BITS, "the decimal exponent of a number lies outside the limits -%d to %d",
                 LITERAL_MAX_EXPONENT, LITERAL_MAX_EXPONENT);
        return EXPR_UNDEF;
    }
    char *digits = sga_malloc(n + 1);
    n = 0;
    for (size_t k = 0; k < i; k++)
        if (text[k] != '.')
            digits[n++] = text[k];
    digits[n] = 0;
    expr_id e = scaled(st, digits, exponent - (long)fraction);
    free(digits);
    return e;
}

/* Whether x lies beyond an end, or at one that does not belong to the interval. */
static bool outside(const struct expr_interval *i, const fmpq *x)
{
    int low = i->has_low ? fmpq_cmp_si(x, i->low) : 1, high = i->has_high ? fmpq_cmp_si(x, i->high) : -1;
    return i->closed ? low < 0 || high > 0 : low <= 0 || high >= 0;
}

const char *literal_outside(const struct expr_store *st, enum expr_op op, expr_id a, expr_id b)
{
    if (!a || !expr_is_const(st, a))
        return NULL;
    const fmpq *x = expr_const_value(st, a);
    const struct expr_interval *domain = expr_op_domain(op);
    if (op == EXPR_ATAN2 && fmpq_is_zero(x) && expr_is_zero(st, b))
        return "both arguments are 0";
    return outside(domain, x) ? domain->outside : NULL;
}

/* 0 ^ b, where b is not an integer constant. */
static expr_id power_of_zero(struct expr_store *st, expr_id b, struct sga_error *err)
{
    if (expr_is_const(st, b) && fmpq_sgn(expr_const_value(st, b)) > 0)
        return expr_int(st, 0);
    sga_fail(err, SGA_E_EXPR_UNDEFINED, "a power of 0 has a value only where the exponent is a positive constant");
    return EXPR_UNDEF;
}

static bool exponent_fits(const fmpz *n, long max_exponent, struct sga_error *err)
{
    if (fmpz_cmp_si(n, max_exponent) <= 0 && fmpz_cmp_si(n, -max_exponent) >= 0)
        return true;
    return sga_fail(err, SGA_E_LIMIT_EXPONENT, "an exponent is larger than the limit of %ld", max_exponent);
}

expr_id literal_power(struct expr_store *st, expr_id a, expr_id b, long max_exponent, struct sga_error *err)
{
    bool integer = false;
    if (expr_is_const(st, b)) {
        const fmpq *q = expr_const_value(st, b);
        integer = fmpz_is_one(fmpq_denref(q));
        if ((integer || fmpz_equal_ui(fmpq_denref(q), 2)) && !exponent_fits(fmpq_numref(q), max_exponent, err))
            return EXPR_UNDEF;
    }
    if (!integer && expr_is_const(st, a)) {
        int sign = fmpq_sgn(expr_const_value(st, a));
        if (sign == 0)
            return power_of_zero(st, b, err);
        if (sign < 0) {
            sga_fail(err, SGA_E_EXPR_UNDEFINED,
                     "a power of a negative number has a real value only where the exponent is an integer%s",
                     expr_is_const(st, b) ? "; cbrt(x) is the real cube root" : "");
            return EXPR_UNDEF;
        }
    }
    expr_id e = expr_pow(st, a, b);
    expr_id power = e && expr_op_of(st, e) == EXPR_NEG ? st->node[e].a : e;      /* of an odd function of a negative argument: its sign comes first */
    if (power && expr_op_of(st, power) == EXPR_POWI && labs(st->node[power].b) > max_exponent) {
        sga_fail(err, SGA_E_LIMIT_EXPONENT, "the exponents of a power of a power multiply to %ld; the limit is %ld",
                 labs(st->node[power].b), max_exponent);
        return EXPR_UNDEF;
    }
    return e;
}
