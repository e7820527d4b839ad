/* Sums of squares by exact Gram matrices: found for random ones in 2 to 6 variables, with their zeros; refused where
 * a value is negative or where no such sum exists (Motzkin and others); with the ranges of kernels; and what vanishes
 * where others do. Each proof is multiplied out again here. */
#include "check.h"
#include "gram.h"
#include <flint/fmpq_mpoly.h>
#include "error.h"
#include "parse.h"

#include <string.h>

static struct expr_store st;
static const char *const NAME[] = { "x", "y", "z", "u", "v", "w" };
static unsigned long state;

static int random_below(int n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (int)((state >> 40) % (unsigned long)n);
}

static expr_id parsed(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

/* Sum of factor * weight * q^2, and multiples of 0, less f. */
static bool multiplies_out(const struct gram_proof *p, const fmpz_mpoly_t f)
{
    const struct poly_bridge *b = p->g.b;
    fmpq_mpoly_t sum, t, q;
    fmpq_mpoly_ctx_t ctx;
    fmpq_mpoly_ctx_init(ctx, fmpz_mpoly_ctx_nvars(b->ctx), ORD_LEX);
    fmpq_mpoly_init(sum, ctx);
    fmpq_mpoly_init(t, ctx);
    fmpq_mpoly_init(q, ctx);
    bool positive = true;
    fmpq_t c;
    fmpq_init(c);
    for (int i = 0; i < p->squares; i++) {
        const struct gram_square *s = p->square + i;
        positive = positive && fmpq_sgn(s->factor) > 0;
        fmpz_mpoly_set(t->zpoly, s->q, b->ctx);
        fmpq_one(t->content);
        fmpq_mpoly_reduce(t, ctx);
        fmpq_mpoly_mul(t, t, t, ctx);
        fmpz_mpoly_set(q->zpoly, p->g.block[s->block].weight, b->ctx);
        fmpq_one(q->content);
        fmpq_mpoly_reduce(q, ctx);
        fmpq_mpoly_mul(t, t, q, ctx);
        fmpq_set(c, s->factor);
        fmpq_mpoly_scalar_mul_fmpq(t, t, c, ctx);
        fmpq_mpoly_add(sum, sum, t, ctx);
    }
    for (int i = 0; i < p->g.multiples; i++) {
        fmpz_mpoly_set(t->zpoly, p->g.multiple + i, b->ctx);
        fmpq_one(t->content);
        fmpq_mpoly_reduce(t, ctx);
        fmpq_set(c, p->multiplier + i);
        fmpq_mpoly_scalar_mul_fmpq(t, t, c, ctx);
        fmpq_mpoly_add(sum, sum, t, ctx);
    }
    fmpz_mpoly_set(t->zpoly, f, b->ctx);
    fmpq_one(t->content);
    fmpq_mpoly_reduce(t, ctx);
    bool same = fmpq_mpoly_equal(sum, t, ctx);
    fmpq_clear(c);
    fmpq_mpoly_clear(sum, ctx);
    fmpq_mpoly_clear(t, ctx);
    fmpq_mpoly_clear(q, ctx);
    fmpq_mpoly_ctx_clear(ctx);
    return same && positive;
}

enum found { NOTHING, SQUARES, POSITIVE };

static enum found prove(expr_id e, const char *what)
{
    struct poly_bridge *b = poly_bridge_new(&st, &e, 1, NULL);
    struct poly_fraction f;
    struct gram_proof p;
    enum found found = NOTHING;
    CHECK(b && poly_fraction_of(b, poly_value(b, e), &f), "%s", what);
    if (gram_prove(b, f.num, &p)) {
        CHECK(multiplies_out(&p, f.num), "%s", what);
        found = p.never ? POSITIVE : SQUARES;
        gram_proof_clear(&p);
    }
    poly_fraction_clear(b, &f);
    poly_bridge_free(b);
    return found;
}

static void expect(const char *text, enum found should)
{
    enum found is = prove(parsed(text), text);
    CHECK(is == should, "%s: %d, should be %d", text, is, should);
}

/* A polynomial of degree 2 (in 2 or 3 variables) or 1 with some products, without a constant. */
static expr_id random_poly(int variables)
{
    expr_id e = expr_int(&st, 0);
    for (int i = 0; i < variables; i++) {
        expr_id x = parsed(NAME[i]);
        e = expr_add(&st, e, expr_mul(&st, expr_int(&st, random_below(7) - 3), x));
        for (int j = i; j < variables; j++)
            if (variables < 4 || random_below(5) == 0)
                e = expr_add(&st, e, expr_mul(&st, expr_int(&st, random_below(5) - 2), expr_mul(&st, x, parsed(NAME[j]))));
    }
    return e;
}

/* q1^2 + .. + qr^2 is found (but a few whose other zeros, or those at infinity, are irrational), with a positive number positive, and less 1 (negative at 0) it is not. */
static void random_squares(int count)
{
    int missed = 0;
    for (int k = 0; k < count; k++) {
        int variables = 2 + k % 5, squares = 1 + random_below(variables + 1);
        expr_id f = expr_int(&st, 0);
        char what[80];
        for (int i = 0; i < squares; i++)
            f = expr_add(&st, f, expr_powi(&st, random_poly(variables), 2));
        snprintf(what, sizeof what, "round %d: %d squares in %d variables", k, squares, variables);
        if (expr_is_zero(&st, f))
            continue;
        enum found found = prove(f, what);
        CHECK(found != POSITIVE, "%s", what);
        missed += found != SQUARES;
        found = prove(expr_add(&st, f, expr_rational(&st, 1 + random_below(9), 7)), what);
        CHECK(found != SQUARES, "%s", what);
        missed += found != POSITIVE;
        CHECK(prove(expr_sub(&st, f, expr_rational(&st, 1, 100)), what) == NOTHING, "%s", what);
    }
    CHECK(5 * missed <= 2 * count, "%d of %d were not found", missed, count);
}

/* The functions where the only factor of text vanishes. */
static void expect_zeros(const char *text, int radicals)
{
    struct poly_factors f;
    CHECK(poly_numerator_factors(&st, parsed(text), NULL, &f), "%s", text);
    CHECK(f.factors == 1 && f.factor[0].sum_of_even_powers, "%s", text);
    CHECK(f.factors == 1 && f.factor[0].radicals == radicals, "%s: %d", text, f.factor[0].radicals);
    poly_factors_clear(&f);
}

static void expect_vanishing(const char *target, const char *one, const char *other, bool should)
{
    expr_id given[2] = { parsed(one), parsed(other) };
    CHECK(poly_vanishes_with(&st, parsed(target), given, 2, NULL) == should, "%s with %s, %s", target, one, other);
    struct poly_limits few = { .max_generators = 3 };     /* too few for both targets in one bridge */
    expr_id both[2] = { parsed("x^3*y + 17*z + 1"), parsed(target) };
    CHECK(poly_any_vanishes_with(&st, both, 2, given, 2, NULL) == should, "%s among others", target);
    CHECK(poly_any_vanishes_with(&st, both, 2, given, 2, &few) == poly_vanishes_with(&st, both[1], given, 2, &few), "%s, one by one", target);
    CHECK(!poly_any_vanishes_with(&st, both, 0, given, 2, NULL), "no target");
}

static void expect_certificate(const char *text, int sign)
{
    struct poly_certificate c;
    expr_id e = parsed(text);
    CHECK(poly_certificate(&st, e, NULL, &c) && c.sign == sign, "%s", text);
    if (!c.sum)
        return;
    if (c.multiplier)
        e = expr_mul(&st, e, c.multiplier);
    if (!c.factor)
        CHECK(poly_is_zero(&st, expr_sub(&st, e, expr_mul(&st, expr_int(&st, c.sign), c.sum)), NULL) == POLY_YES, "%s", text);
}

int main(void)
{
    static const struct { const char *text; enum found found; } table[] = {
        { "x^4 + x^2*y^2 + y^4 - x*y + 1", POSITIVE }, { "x^4 + x^2*y^2 + y^4 - x*y", NOTHING },
        { "x^4 + y^4 + z^4 + 2 - 4*x*y*z", POSITIVE }, { "x^4 + y^4 + z^4 + 1 - 4*x*y*z", SQUARES },
        { "x^4 + y^4 + z^4 + 99/100 - 4*x*y*z", NOTHING },
        { "x^4*y^2 + x^2*y^4 - 3*x^2*y^2 + 1", NOTHING },                     /* Motzkin: not negative, no squares */
        { "x^4*y^2 + x^2*y^4 - 3*x^2*y^2*z^2 + z^6", NOTHING },
        { "x^2*y^2 + y^2*z^2 + z^2*x^2 + 1 - 4*x*y*z", NOTHING },             /* Choi and Lam */
        { "(x^2 + y^2 + 1)*(x^4*y^2 + x^2*y^4 - 3*x^2*y^2 + 1)", SQUARES },   /* Reznick's multiplier */
        { "x^6 + y^6 + z^6 - 3*x^2*y^2*z^2", SQUARES },                       /* Hurwitz */
        { "2*x^4 + 5*y^4 - x^2*y^2 + 2*x^3*y", SQUARES },                     /* Parrilo's example */
        { "x^8 - 2*x^4*y + y^2 + 1/1000000", POSITIVE }, { "x^6 - x^2 + 1", POSITIVE }, { "x^6 - 2*x^2 + 1", NOTHING },
        { "(x^2 + y^2 - 1)^2 + (x - y)^2", SQUARES }, { "(x*y - 1)^2 + x^2", SQUARES },   /* positive, least value 0 not taken */
        { "1000000*x^4 + x^2*y^2 + y^4/1000000 - x*y + 1", POSITIVE },
        { "x^2 + 2*x*sin(y) + 2", POSITIVE }, { "x^2 + 2*x*sin(y) + 1", SQUARES }, { "x^2 + 2*x*sin(y) + 9/10", NOTHING },
        { "6 - 3*sin(x) - 4*cos(x)", POSITIVE }, { "5 - 3*sin(x) - 4*cos(x)", SQUARES }, { "4 - 3*sin(x) - 4*cos(x)", NOTHING },
        { "x - 2*sqrt(x) + 2", POSITIVE }, { "x - 2*sqrt(x) + 1", SQUARES }, { "x - 3*sqrt(x) + 2", NOTHING },
        { "cosh(x)*y^2 - y^2 + z^2 - z + 1", POSITIVE }, { "exp(2*x) + exp(x)*y + y^2", POSITIVE },
        { "x^2 - 2*x*tanh(y) + 1", POSITIVE },
    };
    expr_store_init(&st);
    for (int i = 0; i < 6; i++)
        expr_symbol_add(&st, NAME[i], EXPR_VARIABLE);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        expect(table[i].text, table[i].found);
    expect_zeros("x^4 + y^4 + z^4 + 1 - 4*x*y*z", 4);
    expect_zeros("x^2 + y^2 - 2*x*y*cos(z)", 2);
    expect_zeros("(x^2 + y^2 - 1)^2 + (x - y)^2", 2);
    expect_vanishing("x^2 - y*z", "x", "y", true);
    expect_vanishing("2*u*u/3 + x", "u", "x", true);
    expect_vanishing("x + y", "x^2 + y*z", "x - z", false);
    expect_vanishing("x*y", "x - z", "u^2 + 1", false);
    expect_vanishing("y", "y^3", "x - z", true);
    expect_certificate("x^4 + x^2*y^2 + y^4 - x*y + 1", 1);
    expect_certificate("(x*y - x^4 - x^2*y^2 - y^4 - 1)/3", -1);
    expect_certificate("x^4*y^2 + x^2*y^4 - 3*x^2*y^2 + 2", 1);      /* Motzkin's and 1 */
    expect_certificate("-x^4 - y^4 - pi*x*y - 3", -1);
    expect_certificate("x*y*(x^4 + x^2*y^2 + y^4 - x*y + 1)", 1);
    state = check_seed(5);
    random_squares(check_scale(60));
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
