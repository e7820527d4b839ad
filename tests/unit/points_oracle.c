/* Points and the zero oracle: what is found, what is proved, and what each decision rests
 * on; identities that hold, near misses that do not. */
#include "check.h"
#include "arb_ends.h"
#include "ball.h"
#include "oracle.h"
#include "parse.h"
#include "points.h"

#include <math.h>
#include <string.h>

#include "error.h"

static struct expr_store st;
static int variable[8], variables;

static void begin(const char *const *name, int n)
{
    expr_store_init(&st);
    expr_symbol_add(&st, "t", EXPR_TIME);
    for (variables = 0; variables < n; variables++) {
        expr_symbol_add(&st, name[variables], EXPR_VARIABLE);
        variable[variables] = expr_symbol_find(&st, name[variables], strlen(name[variables]));
    }
}

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

static struct points_space space_of(const expr_id *con, int count)
{
    return (struct points_space){ .st = &st, .variable = variable, .variables = variables, .time = 0,
                                  .constraint = con, .constraints = count };
}

static enum points_status find(const char *const *text, int count, slong bits, bool *certified, double *residual)
{
    expr_id con[8];
    for (int i = 0; i < count; i++)
        con[i] = parse(text[i]);
    struct points_space s = space_of(con, count);
    struct points_point p;
    uint64_t random = 11;
    enum points_status status = points_find(&s, 1, &random, bits, &p);
    *certified = p.certified;
    *residual = -1e9;
    if (status == POINTS_OK) {
        num_ball_extend(&p.ball);
        for (int i = 0; i < count; i++) {
            CHECK(arb_contains_zero(num_ball_value(&p.ball, con[i])), "%s", text[i]);
            mag_t m;
            mag_init(m);
            arb_get_mag(m, num_ball_value(&p.ball, con[i]));
            *residual = fmax(*residual, mag_is_zero(m) ? -1e9 : mag_get_d_log2_approx(m));
            mag_clear(m);
        }
    }
    points_point_clear(&p);
    return status;
}

static void finding(void)
{
    static const char *const xyz[] = { "x", "y", "z" };
    static const struct { const char *text[3]; int count; enum points_status status; } table[] = {
        { { "x^2 + y^2 - 1" }, 1, POINTS_OK },
        { { "x^2 + y^2 - 1", "x*y - z", "x + y + z - 1/3" }, 3, POINTS_OK },
        { { "sin(x) - y", "exp(z) - x^2 - 1" }, 2, POINTS_OK },
        { { "1e150*x - 3e150*y", "1e-150*z - 2e-150" }, 2, POINTS_OK },
        { { "x^2 + y^2" }, 1, POINTS_IRREGULAR },
        { { "(x - y)^2" }, 1, POINTS_IRREGULAR },
        { { "x^2 + y^2 + 1" }, 1, POINTS_NONE },
        { { "exp(x) + y^2" }, 1, POINTS_NONE },
    };
    begin(xyz, 3);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        bool certified;
        double bits;
        enum points_status got = find(table[i].text, table[i].count, 192, &certified, &bits);
        CHECK(got == table[i].status || (table[i].status == POINTS_NONE && got != POINTS_OK), "%s: %d", table[i].text[0], got);
        if (got == POINTS_OK) {
            CHECK(certified, "%s", table[i].text[0]);
            CHECK(bits < -150 || i == 3, "%s: 2^%.0f", table[i].text[0], bits);
            CHECK(find(table[i].text, table[i].count, 2000, &certified, &bits) == POINTS_OK && certified, "%s at 2000 bits", table[i].text[0]);
        }
    }
    expr_store_clear(&st);
}

struct question {
    const char *text;
    enum points_truth truth;
    enum points_basis basis;
};

static void ask(const char *const *name, int n, const char *const *con, int count, const struct question *q, int questions)
{
    begin(name, n);
    expr_id c[8];
    for (int i = 0; i < count; i++)
        c[i] = parse(con[i]);
    struct points_space s = space_of(c, count);
    struct points_oracle oracle;
    points_oracle_init(&oracle, 7);
    CHECK(points_oracle_sample(&oracle, &s) == POINTS_OK);
    for (int i = 0; i < questions; i++) {
        struct points_decision d = points_oracle_zero(&oracle, parse(q[i].text));
        CHECK(d.truth == q[i].truth, "%s: truth %d", q[i].text, d.truth);
        CHECK(d.basis == q[i].basis, "%s: %s", q[i].text, points_basis_text(d.basis));
        if (d.basis == POINTS_ZERO_NUMERIC)
            CHECK(d.digits >= 100, "%s: %d digits", q[i].text, d.digits);
    }
    points_oracle_clear(&oracle);
    expr_store_clear(&st);
}

static void deciding(void)
{
    static const char *const xyz[] = { "x", "y", "z" };
    static const struct question space[] = {
        { "(x + y)^2 - x^2 - 2*x*y - y^2", POINTS_ZERO, POINTS_ZERO_ALGEBRAIC },
        { "sin(x)^2 + cos(x)^2 - 1", POINTS_ZERO, POINTS_ZERO_ALGEBRAIC },
        { "sin(x + y) - sin(x)*cos(y) - cos(x)*sin(y)", POINTS_ZERO, POINTS_ZERO_NUMERIC },
        { "exp(x + y) - exp(x)*exp(y)", POINTS_ZERO, POINTS_ZERO_NUMERIC },
        { "sin(x + y) - sin(x)*cos(y) - cos(x)*sin(y) + 1e-500*x", POINTS_NONZERO, POINTS_NONZERO_PROVED },
        { "log(exp(x)) - x", POINTS_ZERO, POINTS_ZERO_NUMERIC },
        { "cosh(x)^2 - sinh(x)^2 - 1", POINTS_ZERO, POINTS_ZERO_ALGEBRAIC },
        { "0.1 + 0.2 - 0.3", POINTS_ZERO, POINTS_EXACT },
        { "1e-300*x", POINTS_NONZERO, POINTS_NONZERO_PROVED },
        { "(1 + 1e-300*x) - 1", POINTS_NONZERO, POINTS_NONZERO_PROVED },
        { "(x + 1e-40*y) - x", POINTS_NONZERO, POINTS_NONZERO_PROVED },
        { "exp(pi*sqrt(163)) - 262537412640768744", POINTS_NONZERO, POINTS_NONZERO_PROVED },
        { "sqrt(5 + 2*sqrt(6)) - sqrt(2) - sqrt(3)", POINTS_ZERO, POINTS_ZERO_ALGEBRAIC },
        { "x^2 + y^2", POINTS_NONZERO, POINTS_NONZERO_PROVED },
    };
    ask(xyz, 3, NULL, 0, space, sizeof space / sizeof *space);
    static const char *const sphere[] = { "x^2 + y^2 + z^2 - 1" };
    static const struct question on_sphere[] = {
        { "x^4 + 2*x^2*(y^2 + z^2) + (y^2 + z^2)^2 - 1", POINTS_ZERO, POINTS_ZERO_ALGEBRAIC },
        { "x^2 + y^2 + z^2 - 1 + 1e-200*z", POINTS_NONZERO, POINTS_NONZERO_PROVED },
        { "x + y + z - 1", POINTS_NONZERO, POINTS_NONZERO_PROVED },
    };
    ask(xyz, 3, sphere, 1, on_sphere, sizeof on_sphere / sizeof *on_sphere);
    static const char *const linked[] = { "x - y" };
    static const struct question on_linked[] = {
        { "sin(x) - sin(y)", POINTS_ZERO, POINTS_ZERO_ALGEBRAIC },
        { "exp(x) - exp(y) + 1e-250*z", POINTS_NONZERO, POINTS_NONZERO_PROVED },
    };
    ask(xyz, 3, linked, 1, on_linked, sizeof on_linked / sizeof *on_linked);
}

/* Starts lie where functions have values; steps that leave the domain are shortened. */
static void in_the_domain(void)
{
    static const char *const xyz[] = { "x", "y", "z" };
    begin(xyz, 3);
    expr_id defined[] = { parse("sqrt(x - 1)"), parse("log(-y)"), parse("asin(x*z/4)"), parse("sqrt(y + z)") };
    for (uint64_t seed = 1; seed <= 12; seed++) {
        struct points_space s = space_of(NULL, 0);
        s.defined = defined;
        s.defineds = 4;
        struct points_point p;
        uint64_t random = seed;
        CHECK(points_find(&s, 1, &random, 64, &p) == POINTS_OK, "a point, seed %d", (int)seed);
        num_ball_extend(&p.ball);
        SGA_ENDS(arb_end) arb_t first = { 0 };
        for (int i = 0; i < 4; i++)
            CHECK(arb_is_finite(num_ball_value(&p.ball, defined[i])), "function %d has a value, seed %d", i, (int)seed);
        arb_set(first, num_ball_value(&p.ball, defined[1]));
        num_ball_release(&p.ball);
        CHECK(!p.ball.value && !p.ball.used_cap, "values are given back");
        num_ball_extend(&p.ball);
        CHECK(arb_equal(first, num_ball_value(&p.ball, defined[1])), "and made again, seed %d", (int)seed);
        points_point_clear(&p);
    }
    expr_store_clear(&st);
    /* from x = 1 a full step for the first leads to x = -4 */
    static const char *const friction[] = { "1/sqrt(x) - 7/4 + 2*log(4/10000 + 187/(23000*sqrt(x)))/log(10)" };
    static const char *const logarithm[] = { "log(x) + log(y) + log(z) + 20", "sqrt(x) - sqrt(y)", "cbrt(z) - y" };
    bool certified;
    double residual;
    begin(xyz, 3);
    CHECK(find(friction, 1, 192, &certified, &residual) == POINTS_OK && certified && residual < -150, "friction: 2^%g", residual);
    CHECK(find(logarithm, 3, 192, &certified, &residual) == POINTS_OK && certified && residual < -150, "logarithms: 2^%g", residual);
    expr_store_clear(&st);
}

int main(void)
{
    finding();
    in_the_domain();
    deciding();
    flint_cleanup();
    return CHECK_END();
}
