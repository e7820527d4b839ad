/* Values of functions and constants in double arithmetic: one table of them for readers, jets and whoever
 * else computes in doubles (the interpreter of tapes has its own loop over operators). */
#include <mpfr.h>

#include "value.h"

#include <float.h>
#include <math.h>

double expr_function_value(enum expr_op op, double a)
{
    switch (op) {
#define X(sym, name) case EXPR_##sym: return name(a);
    EXPR_ELEMENTARY_TABLE(X)
#undef X
    case EXPR_SQRT:  return sqrt(a);
    case EXPR_CBRT:  return cbrt(a);
    case EXPR_ABS:   return fabs(a);
    case EXPR_SIGN:  return isnan(a) ? a : (a > 0) - (a < 0);
    default:         return NAN;
    }
}

bool expr_short_fraction(const fmpq *q)
{
    return fmpz_bits(fmpq_numref(q)) <= DBL_MANT_DIG && fmpz_bits(fmpq_denref(q)) <= DBL_MANT_DIG;
}

/* Of doubles, one division rounds right. Otherwise 80 bits cut off, an 81st that says whether anything was lost, then one rounding: right for
 * subnormal doubles too. */
double expr_nearest_double(const fmpq *q)
{
    if (expr_short_fraction(q))
        return fmpz_get_d(fmpq_numref(q)) / fmpz_get_d(fmpq_denref(q));
    mpfr_t x;
    mpfr_init2(x, 80);
    bool exact = fmpq_get_mpfr(x, q, MPFR_RNDZ) == 0;
    if (!exact) {
        mpfr_prec_round(x, 81, MPFR_RNDZ);
        if (mpfr_sgn(x) > 0)
            mpfr_nextabove(x);
        else
            mpfr_nextbelow(x);
    }
    double v = mpfr_get_d(x, MPFR_RNDN);
    mpfr_clear(x);
    return v;
}
