/* Double-double numbers: unevaluated sums hi + lo of two doubles with |lo| <= ulp(hi)/2,
 * about 31 digits (relative error of an operation at most a few 2^-106 while nothing
 * underflows: below 1e-290 in size digits are lost one by one, as those of lo are).
 *
 * Sums and products are error-free transformations (Knuth; Dekker, Veltkamp; with a fused
 * multiply-add where the compiler may use one), the algorithms those that Joldes, Muller and
 * Popescu (ACM TOMS 44, 2017) prove: AccurateDWPlusDW, DWTimesDW1, DWDivDW2. They need a
 * compiler that neither contracts nor reorders (-ffp-contract=off, no -ffast-math).
 * Elementary functions, in dd.c, are MPFR's at more bits, rounded. */
#ifndef SGA_NUM_DD_H
#define SGA_NUM_DD_H

#include <flint/fmpq.h>
#include <mpfr.h>
#include <stdbool.h>

#include "expr.h"

typedef struct num_dd {
    double hi, lo;
} num_dd;

/* 2^-104: a relative error that no single operation reaches. */
#define NUM_DD_EPSILON 4.930380657631324e-32

static inline num_dd num_dd_of(double x) { return (num_dd){ x, 0 }; }
static inline num_dd num_dd_neg(num_dd a) { return (num_dd){ -a.hi, -a.lo }; }
static inline num_dd num_dd_abs(num_dd a) { return a.hi < 0 ? num_dd_neg(a) : a; }
/* By a power of two. */
static inline num_dd num_dd_scale(num_dd a, double two_power) { return (num_dd){ a.hi * two_power, a.lo * two_power }; }
static inline bool num_dd_less(num_dd a, num_dd b) { return a.hi < b.hi || (a.hi == b.hi && a.lo < b.lo); }
static inline bool num_dd_finite(num_dd a) { return a.hi * 0 == 0 && a.lo * 0 == 0; }

/* a + b = sum + error exactly; fast: |a| >= |b|. */
static inline num_dd num_dd_two_sum(double a, double b)
{
    double s = a + b, v = s - a;
    return (num_dd){ s, (a - (s - v)) + (b - v) };
}

static inline num_dd num_dd_fast_two_sum(double a, double b)
{
    double s = a + b;
    return (num_dd){ s, b - (s - a) };
}

/* a b = product + error, exactly while nothing over- or underflows (|a|, |b| < 2^996
 * without a fused multiply-add). */
static inline num_dd num_dd_two_product(double a, double b)
{
    double p = a * b;
#ifdef __FMA__
    return (num_dd){ p, __builtin_fma(a, b, -p) };
#else
    double c = 134217729.0 * a, d = 134217729.0 * b;       /* 2^27 + 1 */
    double ah = c - (c - a), bh = d - (d - b), al = a - ah, bl = b - bh;
    return (num_dd){ p, ((ah * bh - p) + ah * bl + al * bh) + al * bl };
#endif
}

static inline num_dd num_dd_add(num_dd a, num_dd b)
{
    num_dd s = num_dd_two_sum(a.hi, b.hi), t = num_dd_two_sum(a.lo, b.lo);
    s = num_dd_fast_two_sum(s.hi, s.lo + t.hi);
    return num_dd_fast_two_sum(s.hi, s.lo + t.lo);
}

static inline num_dd num_dd_add_d(num_dd a, double b)
{
    num_dd s = num_dd_two_sum(a.hi, b);
    return num_dd_fast_two_sum(s.hi, s.lo + a.lo);
}

static inline num_dd num_dd_sub(num_dd a, num_dd b) { return num_dd_add(a, num_dd_neg(b)); }

static inline num_dd num_dd_mul(num_dd a, num_dd b)
{
    num_dd p = num_dd_two_product(a.hi, b.hi);
    return num_dd_fast_two_sum(p.hi, p.lo + (a.hi * b.lo + a.lo * b.hi));
}

static inline num_dd num_dd_mul_d(num_dd a, double b)
{
    num_dd p = num_dd_two_product(a.hi, b);
    return num_dd_fast_two_sum(p.hi, p.lo + a.lo * b);
}

static inline num_dd num_dd_div(num_dd a, num_dd b)
{
    double q = a.hi / b.hi;
    num_dd r = num_dd_sub(a, num_dd_mul_d(b, q));
    double q2 = r.hi / b.hi;
    r = num_dd_sub(r, num_dd_mul_d(b, q2));
    num_dd s = num_dd_fast_two_sum(q, q2);
    return num_dd_add_d(s, r.hi / b.hi);
}

/* dd.c. Correctly rounded but for the last bits of lo. */
num_dd num_dd_sqrt(num_dd a);
/* op: a function of the operator table with one, two arguments; EXPR_POWI: b an integer;
 * NaN outside of its domain. */
num_dd num_dd_function(enum expr_op op, num_dd a);
num_dd num_dd_function2(enum expr_op op, num_dd a, num_dd b);
/* The nearest to an exact rational, pi, decimal digits. */
num_dd num_dd_of_fmpq(const fmpq_t q);
num_dd num_dd_pi(void);
/* The nearest to a decimal text; NaN where it is none. */
num_dd num_dd_parse(const char *text);
#define NUM_DD_DIGITS 32
/* x with so many significant decimal digits, as a malloced text "-1.25e-7"; NULL if not finite. */
char *num_dd_text(num_dd x, int digits);
void num_dd_get_mpfr(mpfr_t x, num_dd a);      /* exact in 2200 bits; rounded to x's own */
num_dd num_dd_set_mpfr(const mpfr_t x);

#endif
