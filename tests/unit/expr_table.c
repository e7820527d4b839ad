/* Functions given by samples, their symbols, and copies of expressions into another store. */
#include <math.h>

#include "check.h"
#include "error.h"
#include "parse.h"
#include "signal.h"
#include "table.h"

static unsigned long state;

static double uniform(double a, double b)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return a + (b - a) * (double)(state >> 11) * 0x1p-53;
}

/* Increasing knots, at most 12. */
static int knots(double *t)
{
    int n = 2 + (int)uniform(0, 10.999);
    t[0] = uniform(-3, 0);
    for (int i = 1; i < n; i++)
        t[i] = t[i - 1] + uniform(0.05, 1);
    return n;
}

/* Polynomials that the interpolation can hold come back with all their derivatives. */
static void reproduces(void)
{
    for (int round = 0; round < check_scale(200); round++) {
        double t[12], y[12], c[4] = { uniform(-2, 2), uniform(-2, 2), uniform(-2, 2), uniform(-2, 2) };
        int n = knots(t), degree = n - 1 < 3 ? n - 1 : 3;
        enum expr_interpolation kind = round % 4 ? EXPR_CUBIC : EXPR_LINEAR;
        degree = kind == EXPR_LINEAR ? 1 : degree;
        for (int k = degree + 1; k < 4; k++)
            c[k] = 0;
        for (int i = 0; i < n; i++)
            y[i] = c[0] + t[i] * (c[1] + t[i] * (c[2] + t[i] * c[3]));
        struct expr_table *u = expr_table_new(kind, n, t, y);
        for (int k = 0; k < 10; k++) {
            double x = uniform(t[0], t[n - 1]);
            double should[4] = { c[0] + x * (c[1] + x * (c[2] + x * c[3])), c[1] + x * (2 * c[2] + 3 * x * c[3]), 2 * c[2] + 6 * x * c[3], 6 * c[3] };
            for (int d = 0; d <= degree; d++)
                CHECK(fabs(expr_table_value(u, d, x) - should[d]) < 1e-7, "order %d at %g: %g, %g", d, x, expr_table_value(u, d, x), should[d]);
        }
        CHECK(isnan(expr_table_value(u, 0, t[0] - 1e-9)) && isnan(expr_table_value(u, 0, t[n - 1] + 1e-9)), "nothing outside");
        expr_table_free(u);
    }
}

/* Any samples: they are met, and what is said to have no jumps has none at knots. */
static void smooth(void)
{
    for (int round = 0; round < check_scale(200); round++) {
        double t[12], y[12];
        int n = knots(t);
        for (int i = 0; i < n; i++)
            y[i] = uniform(-1, 1);
        struct expr_table *u = expr_table_new(round % 2 ? EXPR_CUBIC : EXPR_LINEAR, n, t, y);
        for (int i = 0; i < n; i++)
            CHECK(fabs(expr_table_value(u, 0, t[i]) - y[i]) < 1e-12, "sample %d", i);
        for (int i = 1; i + 1 < n; i++)
            for (int d = 0; d <= expr_table_smooth(u); d++) {
                u->at = i - 1;
                double left = expr_table_value(u, d, t[i]);
                u->at = i;
                double right = expr_table_value(u, d, t[i]);
                u->at = -1;
                CHECK(fabs(left - right) < 1e-9 * (1 + fabs(left)), "order %d at knot %d: %g, %g", d, i, left, right);
                CHECK(expr_table_value(u, d, t[i]) == right, "the later piece at a knot");
            }
        expr_table_free(u);
    }
}

static void derivatives(void)
{
    struct expr_store st;
    struct sga_error err = { 0 };
    expr_store_init(&st);
    int time = st.node[expr_symbol_add(&st, "t", EXPR_TIME)].a;
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_id u = expr_signal_add(&st, "u", NULL);
    CHECK(u && !expr_signal_add(&st, "x", NULL), "a name that is taken");
    expr_id e = expr_parse(&st, "x*u^2 + t*u'", NULL, &err), d = expr_time_partial(&st, e, time);
    expr_id should = expr_parse(&st, "x*(2*u)*u' + u' + t*u''", NULL, &err), rest = expr_sub(&st, d, should);
    struct expr_store other;
    expr_store_init(&other);
    expr_copy_symbols(&other, &st);
    expr_id *map = calloc((size_t)st.symbols, sizeof *map), root[2] = { rest, e };
    for (int i = 0; i < st.symbols; i++)
        map[i] = expr_int(&other, 2 * i + 3);
    expr_copy(&other, &st, root, 2, map);
    CHECK(expr_is_zero(&other, root[0]), "d/dt of x u^2 + t u'");
    CHECK(expr_is_const(&other, root[1]) && !expr_is_zero(&other, root[1]), "all symbols have numbers");
    st.signals_fixed = true;
    int last = st.node[expr_parse(&st, "u''", NULL, &err)].a;
    CHECK(expr_signal_next(&st, last) < 0 && !expr_signal_rate(&st, last) && st.error->code == SGA_E_LIMIT_GENERATIONS, "no more derivatives");
    free(map);
    expr_store_clear(&other);
    expr_store_clear(&st);
}

/* Solves are copied too, and a division that has no value any more is seen. */
static void copies(void)
{
    struct expr_store st, other;
    expr_store_init(&st);
    expr_id p = expr_symbol_add(&st, "p", EXPR_PARAMETER), x = expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_id matrix[4] = { p, expr_int(&st, 1), expr_int(&st, 1), x }, rhs[2] = { x, p };
    int solve = expr_solve_add(&st, 2, matrix, rhs);
    expr_id root[2] = { expr_add(&st, expr_solution(&st, solve, 0), expr_solution(&st, solve, 1)), expr_div(&st, x, p) };
    for (int k = 0; k < 2; k++) {
        expr_id map[2] = { 0 }, here[2] = { root[0], root[1] };
        expr_store_init(&other);
        expr_copy_symbols(&other, &st);
        map[st.node[p].a] = expr_int(&other, k);
        expr_copy(&other, &st, here, 2, map);
        CHECK(k ? expr_store_ok(&other) && other.solves == 1 : other.error->code == SGA_E_EXPR_UNDEFINED, "p = %d", k);
        expr_store_clear(&other);
    }
    expr_store_clear(&st);
}

int main(void)
{
    state = check_seed(7);
    reproduces();
    smooth();
    derivatives();
    copies();
    return CHECK_END();
}
