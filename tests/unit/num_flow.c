/* Taylor coefficients along a flow against repeated Lie derivatives, and gradients in
 * nodes against gradients in balls: two routes each, at random points. */
#include "ball.h"
#include "check.h"
#include "derive.h"
#include "parse.h"

#include <string.h>

#include "error.h"

static struct expr_store st;
static const char *const names[] = { "x", "y", "z" };

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

/* sum of d e/d x_j X_j + d e/d t */
static expr_id lie(expr_id e, const expr_id *X)
{
    expr_id sum = expr_diff(&st, e, expr_symbol_find(&st, "t", 1));
    for (int j = 0; j < 3; j++)
        sum = expr_add(&st, sum, expr_mul(&st, expr_diff(&st, e, expr_symbol_find(&st, names[j], 1)), X[j]));
    return sum;
}

static bool same(struct num_ball *b, expr_id u, expr_id v)
{
    num_ball_extend(b);
    arb_t d;
    arb_init(d);
    arb_sub(d, num_ball_value(b, u), num_ball_value(b, v), b->prec);
    bool ok = arb_is_finite(d) && arb_contains_zero(d) && mag_cmp_2exp_si(arb_radref(d), -60) < 0;
    arb_clear(d);
    return ok;
}

static void set_point(struct num_ball *b, int k)
{
    static const double v[2][4] = { { 0.71875, 0.4375, 0.90625, 0.3125 }, { 0.34375, 0.8125, 0.5625, 0.15625 } };
    const char *const all[] = { "x", "y", "z", "t" };
    for (int i = 0; i < 4; i++)
        num_ball_set_d(b, expr_symbol_find(&st, all[i], 1), v[k][i]);
    num_ball_set_d(b, expr_symbol_find(&st, "a", 1), 1.375);
}

static void flows(void)
{
    static const char *const field[3] = { "y*sin(t) + a*z", "x*z - y^2/(1 + x^2)", "exp(-x)*cos(y) + z/3" };
    static const char *const function[] = {
        "x^2 + y^2 - 1", "x*y*z", "(x + y)/(1 + z^2)", "sin(x*y) + t", "sqrt(1 + x^2)", "log(2 + y)", "x^5", "(1 + x)^-3",
        "exp(x - z)", "tan(y/2)", "atan(x) + asin(y/2) + acos(z/3)", "sinh(x)*cosh(y) - tanh(z)",
        "asinh(x) + acosh(2 + y^2) + atanh(z/4)", "cbrt(2 + x)", "(1 + x^2)^(1/3)", "(2 + x)^y", "atan2(x, 1 + y)",
        "abs(x + 1)", "max(x, 3)*min(y, 5)", "sign(x + 5)*y", "a*t^2*x", "pi*x",
    };
    expr_id X[3];
    struct num_ball b[2];
    for (int j = 0; j < 3; j++)
        X[j] = parse(field[j]);
    for (int k = 0; k < 2; k++)
        num_ball_init(b + k, &st, 256);
    for (size_t i = 0; i < sizeof function / sizeof *function; i++) {
        struct expr_flow f;
        expr_flow_init(&f, &st);
        for (int j = 0; j < 3; j++)
            expr_flow_determine(&f, expr_symbol_find(&st, names[j], 1), X[j]);
        expr_id e = parse(function[i]), d = e;
        long factorial = 1;
        for (int k = 1; k <= 4; k++) {
            factorial *= k;
            d = lie(d, X);
            expr_id c = expr_mul(&st, expr_int(&st, factorial), expr_flow_coefficient(&f, e, k));
            for (int p = 0; p < 2; p++) {
                set_point(b + p, p);
                num_ball_forget(b + p);
                CHECK(same(b + p, c, d), "order %d of %s", k, function[i]);
            }
        }
        expr_flow_clear(&f);
    }
    for (int k = 0; k < 2; k++)
        num_ball_clear(b + k);
}

/* A coefficient made while a velocity was open must change when it is determined. */
static void taint(void)
{
    struct expr_flow f;
    expr_flow_init(&f, &st);
    int x = expr_symbol_find(&st, "x", 1), y = expr_symbol_find(&st, "y", 1);
    expr_flow_determine(&f, x, parse("y"));
    expr_id e = parse("x*y");
    CHECK(expr_flow_tainted(&f, e));
    CHECK(expr_flow_coefficient(&f, e, 1) == parse("y^2"));
    CHECK(!expr_flow_tainted(&f, parse("x + a")));
    expr_flow_determine(&f, y, parse("a"));
    CHECK(!expr_flow_tainted(&f, e));
    CHECK(expr_flow_coefficient(&f, e, 1) == expr_add(&st, parse("x*a"), parse("y^2")));
    expr_flow_clear(&f);
}

/* The chain x_i' = x_{i+1} + 1 + x_i^2, 0 = x_1 - t: nodes grow as the square of the depth. */
static void chain_size(void)
{
    struct expr_store own;
    expr_store_init(&own);
    enum { N = 40 };
    int symbol[N];
    struct expr_flow f;
    expr_symbol_add(&own, "t", EXPR_TIME);
    for (int i = 0; i < N; i++) {
        char name[16];
        snprintf(name, sizeof name, "x%d", i);
        expr_symbol_add(&own, name, EXPR_VARIABLE);
        symbol[i] = expr_symbol_find(&own, name, strlen(name));
    }
    expr_flow_init(&f, &own);
    for (int i = 0; i + 1 < N; i++) {
        expr_id x = own.symbol[symbol[i]].node;
        expr_flow_determine(&f, symbol[i], expr_add(&own, own.symbol[symbol[i + 1]].node,
                            expr_add(&own, expr_int(&own, 1), expr_powi(&own, x, 2))));
    }
    expr_id xi = expr_sub(&own, own.symbol[symbol[0]].node, own.symbol[0].node);
    for (int k = 1; k < N; k++)
        expr_flow_coefficient(&f, xi, k);
    CHECK(own.nodes < 12 * N * N * N / 6, "%d nodes", own.nodes);
    expr_flow_clear(&f);
    expr_store_clear(&own);
}

static void gradients(void)
{
    static const char *const function[] = {
        "x^3*y - z/(x + y^2)", "sin(x)*exp(y*z)", "atan2(x, y) + (x + 2)^z", "sqrt(x + y)*log(z + 1)", "tan(x)*cbrt(y + 1) + z^2",
        "max(x, 2*z) + min(y, 9)", "asin(x/2) - acos(y/2) + atanh(z/2)", "acosh(1 + x)*asinh(y)*atan(z)",
    };
    unsigned char *active = calloc((size_t)st.symbols, 1);
    int *column = malloc((size_t)st.symbols * sizeof *column);
    for (int i = 0; i < st.symbols; i++)
        column[i] = -1;
    for (int j = 0; j < 3; j++) {
        int s = expr_symbol_find(&st, names[j], 1);
        active[s] = 1;
        column[s] = j;
    }
    for (size_t i = 0; i < sizeof function / sizeof *function; i++) {
        struct expr_cone cone;
        struct expr_term *term = NULL;
        size_t cap = 0;
        expr_cone_init(&cone);
        expr_id e = parse(function[i]);
        int n = expr_gradient(&st, &cone, e, active, &term, &cap);
        struct num_ball b;
        num_ball_init(&b, &st, 200);
        set_point(&b, 0);
        num_ball_extend(&b);
        arb_ptr grad = _arb_vec_init(3);
        struct num_ball_room room = { 0 };
        expr_cone_of(&st, &cone, &e, 1);
        num_ball_gradient(&b, e, cone.list, cone.count, column, grad, &room);
        CHECK(n == 3, "%s", function[i]);
        for (int k = 0; k < n; k++)
            CHECK(arb_overlaps(num_ball_value(&b, term[k].value), grad + column[term[k].symbol]), "%s", function[i]);
        _arb_vec_clear(grad, 3);
        num_ball_room_clear(&room);
        num_ball_clear(&b);
        expr_cone_clear(&cone);
        free(term);
    }
    free(active);
    free(column);
}

/* A linear solve kept as a node: its derivative against that of the closed form. */
static void solves(void)
{
    expr_id m[4] = { parse("2 + x"), parse("y"), parse("z"), parse("3") }, r[2] = { parse("x*y"), parse("1 + t") };
    int s = expr_solve_add(&st, 2, m, r);
    expr_id y0 = expr_solution(&st, s, 0);
    expr_id closed = parse("(3*x*y - y*(1 + t))/(3*(2 + x) - y*z)");
    expr_id X[3] = { parse("y"), parse("z"), parse("x*y") };
    struct expr_flow f;
    expr_flow_init(&f, &st);
    for (int j = 0; j < 3; j++)
        expr_flow_determine(&f, expr_symbol_find(&st, names[j], 1), X[j]);
    struct num_ball b;
    num_ball_init(&b, &st, 256);
    set_point(&b, 0);
    for (int k = 0; k <= 3; k++)
        CHECK(same(&b, expr_flow_coefficient(&f, y0, k), expr_flow_coefficient(&f, closed, k)), "order %d", k);
    for (int j = 0; j < 3; j++)
        CHECK(same(&b, expr_diff(&st, y0, expr_symbol_find(&st, names[j], 1)),
                   expr_diff(&st, closed, expr_symbol_find(&st, names[j], 1))), "by %s", names[j]);
    num_ball_clear(&b);
    expr_flow_clear(&f);
}

int main(void)
{
    expr_store_init(&st);
    expr_symbol_add(&st, "t", EXPR_TIME);
    for (int j = 0; j < 3; j++)
        expr_symbol_add(&st, names[j], EXPR_VARIABLE);
    expr_symbol_add(&st, "a", EXPR_PARAMETER);
    flows();
    taint();
    chain_size();
    gradients();
    solves();
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
