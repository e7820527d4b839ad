/* Numerators taken apart: coefficients in parameters, powers of a symbol, resultants; put together again they are what they were. */
#include <stdlib.h>
#include <string.h>

#include "check_read.h"
#include "facts.h"
#include "poly.h"
#include "print.h"

static struct expr_store st;

static expr_id read(const char *text)
{
    return check_read(&st, text);
}

static int symbol(const char *name)
{
    return expr_symbol_find(&st, name, strlen(name));
}

static bool equal(expr_id a, expr_id b)
{
    return poly_is_zero(&st, expr_sub(&st, a, b), NULL) == POLY_YES;
}

static void coefficients(void)
{
    static const struct { const char *in; int count; const char *one; unsigned of; } cases[] = {
        { "(k - 1)*x", 1, "k - 1", EXPR_HAS_VARIABLE }, { "k*x + m*y + p", 3, "p", 0 },
        { "(k*x + k*y)/(m*x)", 2, "k", EXPR_HAS_VARIABLE },
        { "k*sin(x)^2 + k*cos(x)^2 - m", 1, "k - m", 0 }, { "(x + k)^2 - x^2 - 2*k*x - k^2", 0, "", 0 },
        { "k*exp(x) + t*m", 2, "m", EXPR_HAS_TIME },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct poly_coefficients c;
        struct poly_numerator *n = poly_numerator_new(&st, read(cases[i].in), NULL);
        CHECK(n && poly_coefficients_of(n, &c) && c.count == cases[i].count, "%s", cases[i].in);
        bool found = !c.count;
        for (int k = 0; k < c.count; k++)
            found |= equal(c.coefficient[k], read(cases[i].one)) && c.of[k] == cases[i].of;
        CHECK(found, "%s has no %s", cases[i].in, cases[i].one);
        poly_coefficients_clear(&c);
        poly_numerator_free(n);
    }
}

static void powers(void)
{
    expr_id e = read("(k*x^2 + y*x - 3)/(1 + y^2)"), *c, sum = expr_int(&st, 0);
    int degree;
    struct poly_numerator *n = poly_numerator_new(&st, e, NULL);
    CHECK(n && poly_powers_of(n, read("x"), &c, &degree) && degree == 2, "degree");
    for (int k = 0; k <= degree; k++)
        sum = expr_add(&st, sum, expr_mul(&st, c[k], expr_powi(&st, read("x"), k)));
    CHECK(equal(sum, read("k*x^2 + y*x - 3")), "put together");
    free(c);
    CHECK(!poly_powers_of(n, read("m"), &c, &degree), "a symbol that is not there");
    poly_numerator_free(n);
    n = poly_numerator_new(&st, read("x + sin(x)"), NULL);
    CHECK(n && !poly_powers_of(n, read("x"), &c, &degree), "inside a kernel");
    poly_numerator_free(n);
    n = poly_numerator_new(&st, read("4 - 2*k"), NULL);
    expr_id shown = poly_numerator_shown(n);
    poly_numerator_free(n);
    n = poly_numerator_new(&st, read("k/3 - 2/3"), NULL);
    CHECK(poly_numerator_shown(n) == shown, "multiples are written alike");
    poly_numerator_free(n);
}

static void resultants(void)
{
    expr_id r;
    CHECK(poly_resultant(&st, read("x*y - k"), read("y"), symbol("y"), NULL, &r) && equal(r, read("k")), "hyperbola and its axis");
    CHECK(poly_resultant(&st, read("x^2 + y^2 - k^2"), read("y"), symbol("y"), NULL, &r) && equal(r, read("x^2 - k^2")), "circle");
    CHECK(poly_resultant(&st, read("x - k"), read("x - m"), symbol("x"), NULL, &r)
          && (equal(r, read("k - m")) || equal(r, read("m - k"))), "two points");
    CHECK(!poly_resultant(&st, read("sin(x)"), read("x - m"), symbol("x"), NULL, &r), "inside a kernel");
}

int main(void)
{
    expr_store_init(&st);
    const char *const variable[] = { "x", "y", "z" }, *const parameter[] = { "k", "m", "p" };
    for (int i = 0; i < 3; i++) {
        expr_symbol_add(&st, variable[i], EXPR_VARIABLE);
        expr_symbol_add(&st, parameter[i], EXPR_PARAMETER);
    }
    expr_symbol_add(&st, "t", EXPR_TIME);
    coefficients();
    powers();
    resultants();
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
