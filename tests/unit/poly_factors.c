/* Factors: known ones, products put together again, what is said about zeros. */
#include <string.h>

#include "buf.h"
#include "check_read.h"
#include "facts.h"
#include "poly.h"
#include "print.h"

static struct expr_store st;
static unsigned long state;

static unsigned next(unsigned n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(state >> 33) % n;
}

static expr_id read(const char *text)
{
    return check_read(&st, text);
}

/* "factor^multiplicity, ..." sorted by nothing: looked for one by one. */
static bool has(const struct poly_factors *f, const char *text, long multiplicity)
{
    for (int i = 0; i < f->factors; i++) {
        struct sga_buf t = { 0 };
        expr_print(&st, f->factor[i].expr, 0, &t);
        bool same = strcmp(t.data, text) == 0 && f->factor[i].multiplicity == multiplicity;
        sga_buf_free(&t);
        if (same)
            return true;
    }
    return false;
}

static void numerators(void)
{
    static const struct { const char *in, *a; long na; const char *b; long nb; int count, sign; } cases[] = {
        { "x^2 - y^2", "x + y", 1, "x - y", 1, 2, 1 }, { "6*z^2", "z", 2, "z", 2, 1, 1 },
        { "-(x - 1)^3*(x + 1)/(y + 2)", "x - 1", 3, "x + 1", 1, 2, -1 },
        { "x*y - y*x", "0", 0, "0", 0, 0, 0 }, { "7/3", "1", 0, "1", 0, 0, 1 }, { "-2", "", 0, "", 0, 0, -1 },
        { "exp(x)*(x^2 - 2*x + 1)", "x - 1", 2, "exp(x)", 1, 2, 1 },
        { "sin(x)^2*cos(x)", "sin(x)", 2, "cos(x)", 1, 2, 1 }, { "a*x + a*y", "a", 1, "x + y", 1, 2, 1 },
        { "x^2 + y^2 - 4", "x^2 + y^2 - 4", 1, "x^2 + y^2 - 4", 1, 1, 1 }, { "(9/4 - x^2 - y^2)*y", "4*x^2 + 4*y^2 - 9", 1, "y", 1, 2, -1 },
        { "3*x^2 - y^2 + 5*z^2", "3*x^2 + 5*z^2 - y^2", 1, "3*x^2 + 5*z^2 - y^2", 1, 1, 1 }, { "2*x^2 + 2*y^2 + 4*z^2", "x^2 + y^2 + 2*z^2", 1, "x^2 + y^2 + 2*z^2", 1, 1, 1 },
        { "x^2 + y^2", "x^2 + y^2", 1, "x^2 + y^2", 1, 1, 1 }, { "4*x^2 - 9", "2*x - 3", 1, "2*x + 3", 1, 2, 1 }, { "9*y^2 - 4*x^2", "2*x - 3*y", 1, "2*x + 3*y", 1, 2, -1 },
        { "x^4 + 4*y^4", "x^2 + 2*y^2 - 2*x*y", 1, "x^2 + 2*y^2 + 2*x*y", 1, 2, 1 }, { "x^2 + y^2 + 2*x*y - 9", "x + y - 3", 1, "x + y + 3", 1, 2, 1 },
        { "(x + y)/(x - y) - 1", "y", 1, "y", 1, 1, 1 }, { "2*a*x + 3*y - z", "3*y - z + 2*a*x", 0, "", 0, 1, 1 },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct poly_factors f;
        bool ok = poly_numerator_factors(&st, read(cases[i].in), NULL, &f);
        CHECK(ok && f.factors == cases[i].count && f.sign == cases[i].sign, "%s: %d, %d", cases[i].in, f.factors, f.sign);
        CHECK(cases[i].na == 0 || (has(&f, cases[i].a, cases[i].na) && has(&f, cases[i].b, cases[i].nb)), "%s", cases[i].in);
        poly_factors_clear(&f);
    }
    struct poly_factors f;
    CHECK(poly_denominator_factors(&st, read("x/((x + 1)^2*y) + 1/y"), NULL, &f) && f.factors == 2
          && has(&f, "x + 1", 2) && has(&f, "y", 1), "denominator");
    poly_factors_clear(&f);
    CHECK(!poly_numerator_factors(&st, read("(x + y + z + 1)^200"), NULL, &f), "budget");
}

static void single(const char *in, bool never_zero, bool even, int radicals, unsigned depends)
{
    struct poly_factors f;
    CHECK(poly_numerator_factors(&st, read(in), NULL, &f) && f.factors == 1, "%s", in);
    if (f.factors == 1) {
        const struct poly_factor *x = f.factor;
        CHECK(x->never_zero == never_zero && x->sum_of_even_powers == even && x->radicals == radicals, "%s: %d %d %d", in,
              x->never_zero, x->sum_of_even_powers, x->radicals);
        CHECK(x->depends == depends && x->irreducible, "%s: %u", in, x->depends);
    }
    poly_factors_clear(&f);
}

static void zeros(void)
{
    const unsigned V = EXPR_HAS_VARIABLE, P = EXPR_HAS_PARAMETER, T = EXPR_HAS_TIME;
    single("x^2 + 1", true, false, 0, V);
    single("-x^2 - y^2 - 1", true, false, 0, V);
    single("x^2 + y^2", false, true, 2, V);
    single("x^2 + 3*y^4", false, true, 2, V);
    single("x^2*y^2 + z^2", false, true, 2, V);
    single("x^2 - 1 + y", false, false, 0, V);
    single("x^2 + y", false, false, 0, V);
    single("exp(x)", true, false, 0, V);
    single("x^2 + exp(y)", true, false, 0, V);
    single("abs(x) + y^2", false, true, 2, V);
    single("sqrt(x^2 + 1) + y^2", true, false, 0, V);
    single("a", false, false, 0, P);
    single("a + t", false, false, 0, P | T);
    single("a^2 + 2", true, false, 0, P);
    single("a*x + t", false, false, 0, V | P | T);
    single("sin(a) + 2*x", false, false, 0, V | P);
    single("pi + x^2", true, false, 0, V);
    single("cosh(t)", true, false, 0, T);
    struct poly_factors f;
    CHECK(poly_numerator_factors(&st, read("x^2*y^2 + 3*z^4"), NULL, &f) && f.factors == 1 && f.factor[0].radicals == 2, "radicals");
    if (f.factors == 1 && f.factor[0].radicals == 2)
        CHECK(f.factor[0].radical[0] == read("x*y") && f.factor[0].radical[1] == read("z"), "which");
    poly_factors_clear(&f);
}

/* e = c * product of factor^multiplicity with a number c of the sign that is told. */
static void together(void)
{
    static const char *const names[] = { "x", "y", "z", "a" };
    for (int i = 0; i < check_scale(150); i++) {
        expr_id e = expr_int(&st, (long)next(5) - 2 ? (long)next(3) + 1 : -1);
        for (int k = 0; k < 2; k++) {
            expr_id s = expr_int(&st, (long)next(5) - 2);
            for (int j = 0; j < 4; j++)
                s = expr_add(&st, s, expr_mul(&st, expr_int(&st, (long)next(7) - 3), expr_powi(&st, read(names[j]), 1 + next(2))));
            if (!expr_is_zero(&st, s))
                e = expr_mul(&st, e, expr_powi(&st, s, 1 + (long)next(2)));
        }
        struct poly_factors f;
        expr_id flat = e, line[2];
        CHECK(poly_numerator_factors(&st, e, NULL, &f), "case %d", i);
        expr_id p = expr_int(&st, 1);
        for (int k = 0; k < f.factors; k++)
            p = expr_mul(&st, p, expr_powi(&st, f.factor[k].expr, f.factor[k].multiplicity));
        CHECK(poly_normal(&st, expr_div(&st, e, p), NULL, &flat) && expr_is_const(&st, flat), "case %d", i);
        CHECK(expr_is_const(&st, flat) && fmpq_sgn(expr_const_value(&st, flat)) == f.sign, "case %d: sign", i);
        CHECK(poly_linear_in(&st, flat, 0, NULL, line) && expr_is_zero(&st, line[0]), "case %d: constant", i);
        poly_factors_clear(&f);
    }
}

/* A polynomial of degree 1 to `degree`, with small coefficients, fractions among them. */
static expr_id polynomial(unsigned degree)
{
    expr_id sum = EXPR_UNDEF, name[4] = { read("x"), read("y"), read("z"), read("a") };
    for (unsigned terms = 2 + next(4), k = 0; k < terms; k++) {
        expr_id term = expr_div(&st, expr_int(&st, 1 + (long)next(9)), expr_int(&st, 1 + (long)next(3)));
        for (unsigned d = k ? next(degree + 1) : degree; d; d--)
            term = expr_mul(&st, term, name[next(4)]);
        sum = !k ? term : next(2) ? expr_add(&st, sum, term) : expr_sub(&st, sum, term);
    }
    return sum;
}

/* What factoring says by another way: none that factors is called irreducible, and of others most are shown to be. */
static void shown_irreducible(void)
{
    static const char *never[] = { "x*y", "x^2 - y^2", "(x + y)^2", "x^2 + 2*x + 1", "x*(x + y) - 3*x", "7", "0", "sin(x) + y", "1/x + y", "(x^2 + 1)*(y^3 - 2)", "z*(x^2 - y^2) + (x - y)^3", "z*(x^2 + 1)*y - (x^2 + 1)*a", "z*x",
                                   "x^2 - 2*x*y + y^2 - 4", "abs(x)", "z^2*x^2 - y^4" };
    static const char *always[] = { "x", "2*x - 3*y + 1/7", "x^2 + y^2 - 7/3", "x*y - 1", "x*y - z*a", "-(x^2 + y^2)/4 + z", "x*y/3 + y*z - a*x + 2", "x^3 - y", "x/1048571 + y^2",
                                    "x^2 + y^2", "x^2 + 2*y^2", "x^2 - 3*y^2", "x^2 + 7*y^2", "-2*(z^2 - x*x*a) - 2*(y*(-y*a - 9/8) + x^2)", "z*(x^2 - y^2) + (x - y)^2 + 1" };
    for (size_t i = 0; i < sizeof never / sizeof *never; i++)
        CHECK(!poly_shown_irreducible(&st, read(never[i]), NULL), "%s", never[i]);
    for (size_t i = 0; i < sizeof always / sizeof *always; i++)
        CHECK(poly_shown_irreducible(&st, read(always[i]), NULL), "%s", always[i]);
    bool origin = true;
    CHECK(poly_shown_irreducible(&st, read("x^2 + y^2 - 7/3"), &origin) && !origin, "a constant term");
    CHECK(poly_shown_irreducible(&st, read("2*x^2 + 3*y^2 - x*z"), &origin) && origin, "none");
    int single = 0, shown = 0, products = 0;
    for (int i = 0; i < check_scale(400); i++) {
        expr_id e = next(3) ? polynomial(1 + next(3)) : expr_mul(&st, polynomial(1), polynomial(1 + next(3)));
        struct poly_factors f;
        bool yes = poly_shown_irreducible(&st, e, NULL);
        if (!poly_numerator_factors(&st, e, NULL, &f))
            continue;
        bool one = f.factors == 1 && f.factor[0].multiplicity == 1;
        CHECK(one || !yes, "a product is called irreducible: %d factors", f.factors);
        single += one;
        shown += yes;
        products += !one;
        poly_factors_clear(&f);
    }
    CHECK(10 * shown > 8 * single && single > 0 && products > 0, "%d of %d are shown, beside %d products", shown, single, products);
}

/* Degree 2: products of two linear polynomials come apart, sums of three squares of independent ones and more do not, in any coordinates. */
static expr_id linear(int terms)
{
    static const char *const name[] = { "x", "y", "z", "a", "t" };
    expr_id e = expr_int(&st, (int)next(7) - 3);
    for (int k = 0; k < terms; k++)
        e = expr_add(&st, e, expr_mul(&st, expr_int(&st, (int)next(9) - 4), read(name[(k + (int)next(2)) % 5])));
    return e;
}

static void quadrics(void)
{
    for (int turn = 0; turn < 200; turn++) {
        struct poly_factors f;
        expr_id u = expr_add(&st, linear(5), expr_mul(&st, expr_int(&st, 11), read("x"))), v = expr_add(&st, linear(5), expr_mul(&st, expr_int(&st, 13), read("y")));
        CHECK(poly_numerator_factors(&st, expr_mul(&st, u, v), NULL, &f));
        int degree = 0;
        for (int i = 0; i < f.factors; i++)
            degree += (int)f.factor[i].multiplicity;
        CHECK(degree >= 2, "a product: %d factors", f.factors);
        poly_factors_clear(&f);
        expr_id w = expr_add(&st, linear(5), expr_mul(&st, expr_int(&st, 17), read("z"))), sum = EXPR_UNDEF;
        expr_id square[] = { expr_mul(&st, u, u), expr_mul(&st, v, v), expr_mul(&st, w, w) };
        for (int i = 0; i < 3; i++) {
            expr_id term = expr_mul(&st, expr_int(&st, 1 + (int)next(3)), square[i]);
            sum = !i ? term : next(2) ? expr_add(&st, sum, term) : expr_sub(&st, sum, term);
        }
        CHECK(poly_numerator_factors(&st, sum, NULL, &f) && f.factors == 1 && f.factor[0].multiplicity == 1 && f.factor[0].irreducible, "three squares: %d factors", f.factors);
        poly_factors_clear(&f);
    }
}

int main(void)
{
    state = check_seed(11);
    expr_store_init(&st);
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_symbol_add(&st, "y", EXPR_VARIABLE);
    expr_symbol_add(&st, "z", EXPR_VARIABLE);
    expr_symbol_add(&st, "a", EXPR_PARAMETER);
    expr_symbol_add(&st, "t", EXPR_TIME);
    numerators();
    quadrics();
    zeros();
    together();
    shown_irreducible();
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
