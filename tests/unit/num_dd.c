/* Double-double arithmetic against MPFR in 400 bits, its functions against Arb: random
 * arguments of all sizes, cancellation, the edges of the domains, subnormals. Errors in
 * units of 2^-104 of the result. */
#include "check.h"

#include <arb.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "dd.h"
#include "dd_lu.h"
#include "random_expr.h"

static struct random_source rng;

static num_dd random_dd(int exponents)
{
    double hi = ldexp(random_unit(&rng), random_below(&rng, 2 * exponents + 1) - exponents);
    num_dd v = num_dd_fast_two_sum(hi, hi * random_unit(&rng) * DBL_EPSILON / 2);
    return random_below(&rng, 8) ? v : num_dd_of(hi);
}

/* |v - exact| / |exact| in units of 2^-104, with an absolute floor where lo underflows. */
static double units(num_dd v, const mpfr_t exact)
{
    mpfr_t d, size;
    mpfr_inits2(400, d, size, (mpfr_ptr)0);
    num_dd_get_mpfr(d, v);
    mpfr_sub(d, d, exact, MPFR_RNDN);
    mpfr_abs(size, exact, MPFR_RNDN);
    mpfr_mul_d(size, size, NUM_DD_EPSILON, MPFR_RNDN);
    mpfr_add_d(size, size, DBL_TRUE_MIN, MPFR_RNDN);
    mpfr_div(d, d, size, MPFR_RNDN);
    double e = fabs(mpfr_get_d(d, MPFR_RNDN));
    mpfr_clears(d, size, (mpfr_ptr)0);
    return e;
}

static bool normal(num_dd v)
{
    return num_dd_finite(v) && (v.lo == 0 || fabs(v.lo) <= 0.5000001 * DBL_EPSILON * fabs(v.hi));
}

static void arithmetic(void)
{
    mpfr_t x, y, z;
    mpfr_inits2(400, x, y, z, (mpfr_ptr)0);
    for (int i = 0; i < check_scale(20000); i++) {
        num_dd a = random_dd(200), b = random_dd(200);
        if (random_below(&rng, 3) == 0)        /* cancellation */
            b = num_dd_mul_d(a, -1 - ldexp(random_unit(&rng), -random_below(&rng, 60)));
        num_dd_get_mpfr(x, a);
        num_dd_get_mpfr(y, b);
        mpfr_add(z, x, y, MPFR_RNDN);
        double e = units(num_dd_add(a, b), z);
        CHECK(e < 1 && normal(num_dd_add(a, b)), "%.17g + %.17g: %g", a.hi, b.hi, e);
        mpfr_sub(z, x, y, MPFR_RNDN);
        CHECK(units(num_dd_sub(a, b), z) < 1);
        mpfr_mul(z, x, y, MPFR_RNDN);
        e = units(num_dd_mul(a, b), z);
        CHECK(e < 2 && normal(num_dd_mul(a, b)), "%.17g * %.17g: %g", a.hi, b.hi, e);
        if (b.hi != 0) {
            mpfr_div(z, x, y, MPFR_RNDN);
            e = units(num_dd_div(a, b), z);
            CHECK(e < 4 && normal(num_dd_div(a, b)), "%.17g / %.17g: %g", a.hi, b.hi, e);
        }
        mpfr_add_d(z, x, b.hi, MPFR_RNDN);
        CHECK(units(num_dd_add_d(a, b.hi), z) < 1);
        mpfr_mul_d(z, x, b.hi, MPFR_RNDN);
        CHECK(units(num_dd_mul_d(a, b.hi), z) < 1);
        mpfr_abs(x, x, MPFR_RNDN);
        mpfr_sqrt(z, x, MPFR_RNDN);
        e = units(num_dd_sqrt(num_dd_abs(a)), z);
        CHECK(e < 2, "sqrt %.17g: %g", a.hi, e);
    }
    mpfr_clears(x, y, z, (mpfr_ptr)0);
}

typedef void (*arb_function)(arb_t, const arb_t, slong);
static void cube_root(arb_t y, const arb_t x, slong prec)
{
    arb_abs(y, x);
    arb_root_ui(y, y, 3, prec);
    if (arb_is_negative(x))
        arb_neg(y, y);
}

static void to_arb(arb_t out, num_dd a)
{
    arb_t low;
    arb_init(low);
    arb_set_d(out, a.hi);
    arb_set_d(low, a.lo);
    arb_add(out, out, low, ARF_PREC_EXACT);
    arb_clear(low);
}

static double units_arb(num_dd v, const arb_t exact)
{
    mpfr_t m;
    mpfr_init2(m, 400);
    arf_get_mpfr(m, arb_midref(exact), MPFR_RNDN);
    double e = units(v, m);
    mpfr_clear(m);
    return e;
}

static void one(const char *name, enum expr_op op, arb_function f, num_dd a)
{
    arb_t x, y;
    arb_init(x);
    arb_init(y);
    to_arb(x, a);
    f(y, x, 500);
    num_dd v = num_dd_function(op, a);
    if (!arb_is_finite(y) || arf_cmpabs_2exp_si(arb_midref(y), 1023) >= 0)
        CHECK(!isfinite(v.hi), "%s(%.17g) = %.17g", name, a.hi, v.hi);
    else if (arf_cmpabs_2exp_si(arb_midref(y), -960) >= 0 || arf_is_zero(arb_midref(y)))
        CHECK(units_arb(v, y) < 1 && normal(v), "%s(%.17g + %g): %g", name, a.hi, a.lo, units_arb(v, y));
    arb_clear(x);
    arb_clear(y);
}

static void functions(void)
{
    static const struct { const char *name; enum expr_op op; arb_function f; double from, to; } table[] = {
        { "sin", EXPR_SIN, arb_sin, -1e6, 1e6 }, { "cos", EXPR_COS, arb_cos, -1e6, 1e6 }, { "tan", EXPR_TAN, arb_tan, -100, 100 },
        { "asin", EXPR_ASIN, arb_asin, -1, 1 }, { "acos", EXPR_ACOS, arb_acos, -1, 1 }, { "atan", EXPR_ATAN, arb_atan, -1e9, 1e9 },
        { "sinh", EXPR_SINH, arb_sinh, -600, 600 }, { "cosh", EXPR_COSH, arb_cosh, -600, 600 }, { "tanh", EXPR_TANH, arb_tanh, -30, 30 },
        { "asinh", EXPR_ASINH, arb_asinh, -1e9, 1e9 }, { "acosh", EXPR_ACOSH, arb_acosh, 1, 1e9 }, { "atanh", EXPR_ATANH, arb_atanh, -1, 1 },
        { "exp", EXPR_EXP, arb_exp, -600, 700 }, { "log", EXPR_LOG, arb_log, 0, 1e9 }, { "sqrt", EXPR_SQRT, arb_sqrt, 0, 1e9 },
        { "cbrt", EXPR_CBRT, cube_root, -1e9, 1e9 },
    };
    static const double edge[] = { 1, -1, 0.5, 3, 1e-3, -1e-8, 1e-100, 1e-300, 1e22, 700, 800, 1e300, 2, 3.141592653589793, 1.5707963267948966 };
    for (size_t k = 0; k < sizeof table / sizeof *table; k++) {
        for (int i = 0; i < check_scale(400); i++) {
            double u = 0.5 + 0.5 * random_unit(&rng);
            double x = random_below(&rng, 2) ? table[k].from + u * (table[k].to - table[k].from)
                                             : table[k].from + pow(u, 40) * (table[k].to - table[k].from);
            one(table[k].name, table[k].op, table[k].f, num_dd_fast_two_sum(x, x * random_unit(&rng) * DBL_EPSILON / 2));
        }
        for (size_t i = 0; i < sizeof edge / sizeof *edge; i++) {
            one(table[k].name, table[k].op, table[k].f, num_dd_of(edge[i]));
            one(table[k].name, table[k].op, table[k].f, num_dd_fast_two_sum(edge[i], edge[i] * 1e-25));
            one(table[k].name, table[k].op, table[k].f, num_dd_fast_two_sum(edge[i], -edge[i] * 1e-17));
        }
    }
}

static void two_arguments(void)
{
    arb_t x, y, z;
    arb_init(x);
    arb_init(y);
    arb_init(z);
    for (int i = 0; i < check_scale(1000); i++) {
        num_dd a = num_dd_abs(random_dd(20)), b = random_dd(4);
        to_arb(x, a);
        to_arb(y, b);
        arb_pow(z, x, y, 500);
        num_dd v = num_dd_function2(EXPR_POW, a, b);
        CHECK(units_arb(v, z) < 1, "%.17g^%.17g: %g", a.hi, b.hi, units_arb(v, z));
        if (random_below(&rng, 2))
            a = num_dd_neg(a);
        to_arb(x, a);
        arb_atan2(z, x, y, 500);
        CHECK(units_arb(num_dd_function2(EXPR_ATAN2, a, b), z) < 1, "atan2 %.17g %.17g", a.hi, b.hi);
    }
    num_dd one_up = { 1, 1e-25 }, one = { 1, 0 };
    CHECK(num_dd_function2(EXPR_MIN, one_up, one).lo == 0 && num_dd_function2(EXPR_MAX, one_up, one).lo == 1e-25);
    CHECK(isnan(num_dd_function2(EXPR_MIN, one, num_dd_of(NAN)).hi) && isnan(num_dd_function2(EXPR_POW, num_dd_of(-1), one).hi));
    CHECK(num_dd_function(EXPR_SIGN, num_dd_of(-3)).hi == -1 && num_dd_function(EXPR_SIGN, num_dd_of(0)).hi == 0);
    arb_clear(x);
    arb_clear(y);
    arb_clear(z);
}

/* Constants, their texts, and what a rational leaves after two doubles. */
static void constants(void)
{
    static const struct { long p, q; } value[] = { { 1, 3 }, { -22, 7 }, { 1, 10 }, { 3, 1 }, { 0, 1 }, { 123456789, 1000000007 } };
    mpfr_t exact;
    mpfr_init2(exact, 400);
    for (size_t i = 0; i < sizeof value / sizeof *value; i++) {
        fmpq_t q;
        fmpq_init(q);
        fmpq_set_si(q, value[i].p, (ulong)value[i].q);
        fmpq_get_mpfr(exact, q, MPFR_RNDN);
        num_dd v = num_dd_of_fmpq(q);
        CHECK(units(v, exact) < 0.5, "%ld/%ld", value[i].p, value[i].q);
        char *text = num_dd_text(v, 31);
        mpfr_t back;
        mpfr_init2(back, 400);
        mpfr_set_str(back, text, 10, MPFR_RNDN);
        CHECK(units(v, back) < 100, "%s", text);
        CHECK(units(num_dd_parse(text), back) < 0.5, "%s is read", text);
        mpfr_clear(back);
        free(text);
        fmpq_clear(q);
    }
    mpfr_const_pi(exact, MPFR_RNDN);
    CHECK(units(num_dd_pi(), exact) < 0.5);
    CHECK(isnan(num_dd_parse("x").hi) && num_dd_parse("-0.5").hi == -0.5);
    CHECK(!num_dd_text(num_dd_of(INFINITY), 5) && !num_dd_text(num_dd_of(NAN), 5));
    char *text = num_dd_text((num_dd){ -1.5, 0 }, 3);
    CHECK(strcmp(text, "-1.50e+00") == 0, "%s", text);
    free(text);
    mpfr_clear(exact);
}

/* A Hilbert matrix of order 8 loses 10 of the digits; the residual shows that the rest is there. */
static void solves(void)
{
    enum { M = 8 };
    num_dd a[M * M], lu[M * M], b[M], x[M];
    int perm[M];
    for (int i = 0; i < M; i++) {
        b[i] = num_dd_of(0);
        for (int j = 0; j < M; j++) {
            a[i * M + j] = lu[i * M + j] = num_dd_div(num_dd_of(1), num_dd_of(i + j + 1));
            b[i] = num_dd_add(b[i], num_dd_mul_d(a[i * M + j], j + 1));
        }
    }
    CHECK(num_dd_lu_factor(lu, perm, M));
    num_dd_lu_solve(lu, perm, M, b, x);
    for (int j = 0; j < M; j++)
        CHECK(fabs(num_dd_sub(x[j], num_dd_of(j + 1)).hi) < 1e-20, "%d: %g", j, num_dd_sub(x[j], num_dd_of(j + 1)).hi);
    num_dd singular[4] = { { 1, 0 }, { 2, 0 }, { 2, 0 }, { 4, 0 } };
    CHECK(!num_dd_lu_factor(singular, perm, 2));
}

int main(void)
{
    rng.state = check_seed(104);
    arithmetic();
    functions();
    two_arguments();
    constants();
    solves();
    mpfr_free_cache();
    flint_cleanup();
    return CHECK_END();
}
