/* Factors that keep one sign: found for polynomials that do, by squares or by counting
 * real roots, and never claimed for those that have a zero. */
#include "check.h"
#include "parse.h"
#include "poly.h"

#include <math.h>
#include <string.h>

#include "error.h"

static struct expr_store st;

static void expect(const char *text, bool never)
{
    struct sga_error err = { 0 };
    struct poly_factors f;
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    CHECK(poly_numerator_factors(&st, e, NULL, &f), "%s", text);
    bool all = true;
    for (int i = 0; i < f.factors; i++)
        all &= f.factor[i].never_zero;
    CHECK(all == never, "%s", text);
    poly_factors_clear(&f);
}

/* (p1 x + p2 y + p3)^2 + (q1 x + q2 y)^2 + c written out: positive for c > 0; for c <= 0
 * there is a zero, because the squares reach every value from their least one. */
static void random_squares(int count, unsigned long seed)
{
    for (int k = 0; k < count; k++) {
        int v[6];
        for (int i = 0; i < 6; i++) {
            seed = seed * 6364136223846793005ul + 1442695040888963407ul;
            v[i] = (int)(seed >> 59) % 9 - 4;
        }
        if (v[0] * v[4] - v[1] * v[3] == 0)
            continue;
        char text[400];
        int c = v[5];
        snprintf(text, sizeof text, "%d*x^2 + %d*y^2 + %d*x*y + %d*x + %d*y + %d",
                 v[0] * v[0] + v[3] * v[3], v[1] * v[1] + v[4] * v[4], 2 * (v[0] * v[1] + v[3] * v[4]),
                 2 * v[0] * v[2], 2 * v[1] * v[2], v[2] * v[2] + c);
        if (c > 0)
            expect(text, true);
        else if (c < 0)
            expect(text, false);
    }
}

int main(void)
{
    static const struct { const char *text; bool never; } table[] = {
        { "x^2 + 2*x + 2", true }, { "x^2 + 2*x + 1", false }, { "x^2 - 2", false },
        { "x^4 + x + 1", true }, { "x^4 - 3*x + 1", false }, { "-x^2 + x - 1", true },
        { "x^3 + x + 1", false }, { "(x + 2*y)^2 + 3", true }, { "(x + 2*y)^2 - 3", false },
        { "x^2 + x*y + y^2 + 1", true }, { "x^2 + 3*x*y + y^2 + 1", false }, { "x^2 + y + 1", false },
        { "x^2 + y^2 - 2*x*y + 4", true }, { "2*x^2 + 2*y^2 + z^2 - 2*x*z + 2*y*z + 1", true },
        { "x*y + 1", false }, { "(x - y)^2 + z + 5", false }, { "(x^2 + x + 1)*(y^2 - y + 3)", true },
        { "exp(x)^2 + exp(x) + 1", true },
    };
    expr_store_init(&st);
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_symbol_add(&st, "y", EXPR_VARIABLE);
    expr_symbol_add(&st, "z", EXPR_VARIABLE);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        expect(table[i].text, table[i].never);
    random_squares(check_scale(200), check_seed(11));
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
