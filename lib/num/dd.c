/* Double-double: what is not arithmetic. The elementary functions go through MPFR with
 * 40 bits to spare: they stand once in a step of an integration whose products of series
 * cost far more, and what they return is right to the last bits for every argument. */
#include "dd.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "value.h"

#define BITS 150

void num_dd_get_mpfr(mpfr_t x, num_dd a)
{
    mpfr_set_d(x, a.hi, MPFR_RNDN);
    mpfr_add_d(x, x, a.lo, MPFR_RNDN);
}

num_dd num_dd_set_mpfr(const mpfr_t x)
{
    num_dd r = { mpfr_get_d(x, MPFR_RNDN), 0 };
    if (!isfinite(r.hi))
        return (num_dd){ r.hi, 0 };
    mpfr_t rest;
    mpfr_init2(rest, mpfr_get_prec(x) + 64);
    mpfr_sub_d(rest, x, r.hi, MPFR_RNDN);
    r.lo = mpfr_get_d(rest, MPFR_RNDN);
    mpfr_clear(rest);
    return num_dd_fast_two_sum(r.hi, r.lo);
}

num_dd num_dd_sqrt(num_dd a)
{
    if (!(a.hi > 0) || isinf(a.hi))
        return num_dd_of(sqrt(a.hi));
    double s = sqrt(a.hi);
    if (s > 1e-140 && s < 1e140) {      /* Karp and Markstein: s + (a - s^2)/(2 s) */
        num_dd rest = num_dd_sub(a, num_dd_two_product(s, s));
        return num_dd_fast_two_sum(s, rest.hi / (2 * s));
    }
    return num_dd_function(EXPR_SQRT, a);
}

static void evaluate(enum expr_op op, mpfr_t y, const mpfr_t x)
{
    switch (op) {
#define X(sym, name) case EXPR_##sym: mpfr_##name(y, x, MPFR_RNDN); break;
    EXPR_ELEMENTARY_TABLE(X)
#undef X
    case EXPR_SQRT:  mpfr_sqrt(y, x, MPFR_RNDN); break;
    case EXPR_CBRT:  mpfr_cbrt(y, x, MPFR_RNDN); break;
    default:         mpfr_set_nan(y); break;
    }
}

num_dd num_dd_function(enum expr_op op, num_dd a)
{
    if (op == EXPR_ABS)
        return num_dd_abs(a);
    if (op == EXPR_NEG)
        return num_dd_neg(a);
    if (op == EXPR_SIGN)
        return num_dd_of(isnan(a.hi) ? a.hi : (a.hi > 0) - (a.hi < 0));
    mpfr_t x, y;
    /* hi and lo may lie far apart, and near a singular point (log 1, acos 1) both count */
    mpfr_init2(x, a.lo != 0 && fabs(a.lo) < 1e-20 * fabs(a.hi) ? 2200 : BITS);
    mpfr_init2(y, BITS);
    num_dd_get_mpfr(x, a);
    evaluate(op, y, x);
    num_dd r = num_dd_set_mpfr(y);
    mpfr_clear(x);
    mpfr_clear(y);
    return r;
}

num_dd num_dd_function2(enum expr_op op, num_dd a, num_dd b)
{
    bool nan = isnan(a.hi) || isnan(b.hi);
    if (op == EXPR_MIN || op == EXPR_MAX)
        return nan ? num_dd_of(NAN) : num_dd_less(a, b) == (op == EXPR_MIN) ? a : b;
    mpfr_t x, y;
    mpfr_init2(x, BITS);
    mpfr_init2(y, BITS);
    num_dd_get_mpfr(x, a);
    num_dd_get_mpfr(y, b);
    if (op == EXPR_ATAN2)
        mpfr_atan2(x, x, y, MPFR_RNDN);
    else if (op == EXPR_POWI)
        mpfr_pow_si(x, x, (long)b.hi, MPFR_RNDN);
    else if (op == EXPR_POW && !(a.hi < 0))
        mpfr_pow(x, x, y, MPFR_RNDN);
    else
        mpfr_set_nan(x);
    num_dd r = num_dd_set_mpfr(x);
    mpfr_clear(x);
    mpfr_clear(y);
    return r;
}

num_dd num_dd_of_fmpq(const fmpq_t q)
{
    if (expr_short_fraction(q)) {        /* what a division leaves is a double */
        double n = fmpz_get_d(fmpq_numref(q)), d = fmpz_get_d(fmpq_denref(q)), high = n / d;
        return (num_dd){ high, fma(-high, d, n) / d };
    }
    mpfr_t x;
    mpfr_init2(x, BITS);
    fmpq_get_mpfr(x, q, MPFR_RNDN);
    num_dd r = num_dd_set_mpfr(x);
    mpfr_clear(x);
    return r;
}

num_dd num_dd_pi(void)
{
    return (num_dd){ 3.141592653589793116, 1.2246467991473531772e-16 };
}

num_dd num_dd_parse(const char *text)
{
    mpfr_t v;
    mpfr_init2(v, BITS);
    char *end;
    mpfr_strtofr(v, text, &end, 10, MPFR_RNDN);
    num_dd x = end == text ? num_dd_of(NAN) : num_dd_set_mpfr(v);
    mpfr_clear(v);
    return x;
}

char *num_dd_text(num_dd x, int digits)
{
    if (!num_dd_finite(x))
        return NULL;
    mpfr_t v;
    mpfr_init2(v, BITS);
    num_dd_get_mpfr(v, x);
    char *text = NULL, *own = NULL;
    if (mpfr_asprintf(&text, "%.*Re", digits > 1 ? digits - 1 : 0, v) > 0) {
        own = strcpy(sga_malloc(strlen(text) + 1), text);
        mpfr_free_str(text);
    }
    mpfr_clear(v);
    return own;
}
