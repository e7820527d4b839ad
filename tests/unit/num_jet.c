/* Series on the tape, in double and in double-double, against the store's own Taylor
 * coefficients along a flow (nodes, evaluated in balls of 300 bits), with every operator. */
#include "check.h"

#include <math.h>
#include <string.h>

#include "ball.h"
#include "derive.h"
#include "error.h"
#include "jet.h"
#include "parse.h"
#include "tape.h"
#include "tape_code.h"

enum { ORDER = 7, VARIABLES = 3 };
static struct expr_store st;
static const char *const names[] = { "x", "y", "z", "t" };
static const double point[4] = { 0.71875, 0.4375, 0.90625, 0.3125 };
static const double scale = 0.125;
static int inputs[4];

static const char *const field[3] = { "y*sin(t) + z/3", "x*z - y^2/(1 + x^2)", "exp(-x)*cos(y) + z/7" };
static const char *const function[] = {
    "x^2 + y^2 - 1", "x*y*z", "(x + y)/(1 + z^2)", "sin(x*y) + t", "cos(x)*sin(x)", "cos(y + t)", "sqrt(1 + x^2)", "log(2 + y)",
    "x^5", "(1 + x)^-3", "x^3", "x^-1", "y^11", "exp(x - z)", "tan(y/2)", "atan(x) + asin(y/2) + acos(z/3)",
    "sinh(x)*cosh(y) - tanh(z)", "sinh(x)", "cosh(x)", "asinh(x) + acosh(2 + y^2) + atanh(z/4)", "cbrt(2 + x)", "cbrt(x - 9)",
    "(1 + x^2)^(1/3)", "(2 + x)^y", "(2 + x)^(pi/7)", "3^x", "atan2(x, 1 + y)", "atan2(-x, -1 - y)", "abs(x + 1)", "abs(x - 9)",
    "max(x, 3)*min(y, 5)", "min(x, 3)*max(y, 5)", "sign(x + 5)*y", "sign(x - 5)*y", "t^2*x", "pi*x", "1/3 + pi", "t", "x/3",
    "1/x", "2/(1 + x*y)", "sin(2)*x + log(3)",
};

static expr_id parse(const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e;
}

/* |v - ball| relative to 1 + |ball|. */
static double miss(num_dd v, const arb_t ball)
{
    arb_t d;
    mpfr_t x;
    arf_t q;
    arb_init(d);
    arf_init(q);
    mpfr_init2(x, 300);
    num_dd_get_mpfr(x, v);
    arf_set_mpfr(q, x);
    arb_sub_arf(d, ball, q, 300);
    double e = fabs(arf_get_d(arb_midref(d), ARF_RND_NEAR)) + mag_get_d(arb_radref(d));
    double size = 1 + fabs(arf_get_d(arb_midref(ball), ARF_RND_NEAR));
    arb_clear(d);
    arf_clear(q);
    mpfr_clear(x);
    return e / size;
}

/* Coefficient k of root e along the flow times scale^k. */
static void expected(struct expr_flow *f, struct num_ball *b, expr_id e, int k, arb_t out)
{
    expr_id c = k ? expr_flow_coefficient(f, e, k) : e;
    num_ball_extend(b);
    arb_set_d(out, scale);
    arb_pow_ui(out, out, (ulong)k, 300);
    arb_mul(out, out, num_ball_value(b, c), 300);
}

static void compare(const expr_id *root, int roots, struct expr_flow *f, struct num_ball *b)
{
    struct sga_error err = { 0 };
    struct num_tape *t = num_tape_new(&st, root, roots, inputs, 4, &err);
    struct num_jet *j = num_jet_new(t, ORDER);
    struct num_jet2 *j2 = num_jet2_new(t, ORDER);
    arb_t v;
    arb_init(v);
    num_tape_free(t);
    for (int i = 0; i < 4; i++) {
        num_jet_input(j, i)[0] = point[i];
        num_jet2_input(j2, i)[0] = num_dd_of(point[i]);
    }
    num_jet_input(j, 3)[1] = scale;
    num_jet2_input(j2, 3)[1] = num_dd_of(scale);
    for (int k = 0; k < ORDER; k++) {
        CHECK(num_jet_next(j, k) && num_jet2_next(j2, k), "order %d", k);
        for (int i = 0; i < VARIABLES; i++) {
            num_jet_input(j, i)[k + 1] = scale * num_jet_root(j, i)[k] / (k + 1);
            num_jet2_input(j2, i)[k + 1] = num_dd_div(num_dd_scale(num_jet2_root(j2, i)[k], scale), num_dd_of(k + 1));
        }
        for (int r = 0; r < roots; r++) {
            expected(f, b, root[r], k, v);
            double e = miss(num_dd_of(num_jet_root(j, r)[k]), v), e2 = miss(num_jet2_root(j2, r)[k], v);
            const char *what = r < VARIABLES ? field[r] : r - VARIABLES < (int)(sizeof function / sizeof *function) ? function[r - VARIABLES] : "a solve";
            CHECK(e < 2e-14, "order %d of %s: %g", k, what, e);
            CHECK(e2 < 4e-30, "order %d of %s in double-double: %g", k, what, e2);
        }
    }
    CHECK(isinf(num_jet_reach(j, ORDER - 1)));
    arb_clear(v);
    num_jet_free(j);
    num_jet2_free(j2);
}

/* |x - 1| and the like along x = t: where they switch, and which side follows when it starts on the border. */
static void switches(void)
{
    static const struct { const char *text; double start, reach, value[3]; } c[] = {
        { "abs(t - 1)", 0.5, 0.5, { 0.5, -1, 0 } }, { "abs(t - 1)", 1.0, INFINITY, { 0, 1, 0 } },
        { "abs(t - 1)", 1.5, INFINITY, { 0.5, 1, 0 } }, { "max(t^2, 1)", 0.5, 0.5, { 1, 0, 0 } },
        { "max(t^2, 1)", 1, INFINITY, { 1, 2, 1 } }, { "min(t^2, 1)", 0.25, 0.75, { 0.0625, 0.5, 1 } },
        { "sign(t - 1)*t", 0.75, 0.25, { -0.75, -1, 0 } }, { "abs(t - 1)*abs(t - 3/4)", 0.5, 0.25, { 0.125, -0.75, 1 } },
        { "abs(t - 9)", 0.5, INFINITY, { 8.5, -1, 0 } },
    };
    for (size_t i = 0; i < sizeof c / sizeof *c; i++) {
        struct sga_error err = { 0 };
        expr_id e = parse(c[i].text);
        struct num_tape *t = num_tape_new(&st, &e, 1, inputs, 4, &err);
        struct num_jet *j = num_jet_new(t, 2);
        struct num_jet2 *j2 = num_jet2_new(t, 2);
        num_jet_input(j, 3)[0] = c[i].start;
        num_jet2_input(j2, 3)[0] = num_dd_of(c[i].start);
        num_jet_input(j, 3)[1] = num_jet2_input(j2, 3)[1].hi = 1;
        for (int k = 0; k < 3; k++) {
            CHECK(num_jet_next(j, k) && num_jet2_next(j2, k), "%s", c[i].text);
            CHECK(num_jet_root(j, 0)[k] == c[i].value[k] && num_jet2_root(j2, 0)[k].hi == c[i].value[k], "%s, order %d: %g", c[i].text, k, num_jet_root(j, 0)[k]);
        }
        double r = num_jet_reach(j, 2);
        num_dd r2 = num_jet2_reach(j2, 2);
        CHECK(r == c[i].reach || fabs(r - c[i].reach) < 1e-14, "%s: %g", c[i].text, r);
        CHECK(r2.hi == c[i].reach || fabs(num_dd_sub(r2, num_dd_of(c[i].reach)).hi) < 1e-30, "%s: %g", c[i].text, r2.hi);
        num_tape_free(t);
        num_jet_free(j);
        num_jet2_free(j2);
    }
}

/* What is beyond the range of numbers on the way to a value that is not: in double-double as in double. */
static void beyond_range(void)
{
    static const struct { const char *text; double at, value, change; } c[] = {
        { "1/(1 + exp(t))", 800, 0, 0 }, { "2 - 3/(1 + exp(t))", 800, 2, 0 }, { "1/(1 + exp(t)^2)", 400, 0, 0 }, { "cosh(t)^(-2)", 1e6, 0, 0 },
        { "t - 5/(exp(t) - 1)", 900, 900, 1 }, { "1/(1 + exp(t))", -800, 1, 0 },
    };
    for (size_t i = 0; i < sizeof c / sizeof *c; i++) {
        struct sga_error err = { 0 };
        expr_id e = parse(c[i].text);
        struct num_tape *t = num_tape_new(&st, &e, 1, inputs, 4, &err);
        struct num_jet2 *j = num_jet2_new(t, 2);
        num_jet2_input(j, 3)[0] = num_dd_of(c[i].at);
        num_jet2_input(j, 3)[1] = num_dd_of(1);
        for (int k = 0; k < 3; k++)
            CHECK(num_jet2_next(j, k) && num_jet2_root(j, 0)[k].hi == (k == 0 ? c[i].value : k == 1 ? c[i].change : 0), "%s at %g, order %d: %g", c[i].text, c[i].at, k, num_jet2_root(j, 0)[k].hi);
        num_tape_free(t);
        num_jet2_free(j);
    }
    struct sga_error err = { 0 };
    expr_id e = parse("cosh(t)^(-2)");
    struct num_tape *t = num_tape_new(&st, &e, 1, inputs, 4, &err);
    struct num_jet2 *j = num_jet2_new(t, 0);
    num_jet2_input(j, 3)[0] = num_dd_of(350);
    CHECK(num_jet2_next(j, 0) && fabs(num_jet2_root(j, 0)[0].hi / (4 * exp(-700)) - 1) < 1e-14, "near the largest numbers: %g", num_jet2_root(j, 0)[0].hi);
    num_jet2_input(j, 3)[0] = num_dd_of(NAN);
    CHECK(!num_jet2_next(j, 0), "no number stays none");
    num_tape_free(t);
    num_jet2_free(j);
}

static double between(uint64_t *seed, double a, double b)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return a + (b - a) * (double)(*seed >> 11) * 0x1p-53;
}

/* c times (a[0] + a[1] s + a[2] s^2), up to degree order. */
static void times(double *c, int order, const double a[3])
{
    for (int k = order; k >= 0; k--)
        c[k] = a[0] * c[k] + (k > 0 ? a[1] * c[k - 1] : 0) + (k > 1 ? a[2] * c[k - 2] : 0);
}

/* Polynomials with known zeros as the argument of |.|: the first place where the sign changes is found, also where it changes
 * back shortly after, where the coefficients grow by twenty decades, and not where it is only touched. */
static void first_changes(void)
{
    enum { MOST = 20 };
    uint64_t seed = check_seed(90917);
    struct sga_error err = { 0 };
    expr_id e = parse("abs(t)");
    struct num_tape *t = num_tape_new(&st, &e, 1, inputs, 4, &err);
    struct num_jet *j = num_jet_new(t, MOST + 1);
    struct num_jet2 *j2 = num_jet2_new(t, MOST + 1);
    for (int turn = 0; turn < check_scale(4000); turn++) {
        bool plain = turn % 4 == 0;
        double grow = turn % 4 == 1 ? 1 : between(&seed, 1, 20), r = between(&seed, 0.02, 1.2) / grow, gap = plain ? 1e-5 : 1e-3;
        int kind = turn / 4 % 3;
        double sign = turn / 12 % 2 ? 1 : -1, c[MOST + 1] = { sign };
        times(c, MOST, (const double[3]){ 1, -1 / r, 0 });                                    /* a change */
        if (kind == 1)
            times(c, MOST, (const double[3]){ 1, -1 / (r * (1 + gap)), 0 });                  /* and back */
        if (kind == 2) {                                                                      /* none: two zeros beside the line */
            memset(c, 0, sizeof c);
            c[0] = sign * (1 + gap * gap), c[1] = sign * -2 / r, c[2] = sign / (r * r);
        }
        for (int k = 0; k < 9 && !plain; k++)                                                 /* no zeros where s > 0 */
            times(c, MOST, turn % 2 ? (const double[3]){ 1, 2 * grow, grow * grow } : (const double[3]){ 3, -2 * grow, grow * grow });
        for (int k = 0; k <= MOST; k++) {
            num_jet_input(j, 3)[k] = c[k];
            num_jet2_input(j2, 3)[k] = num_dd_of(c[k]);
            CHECK(num_jet_next(j, k) && num_jet2_next(j2, k));
        }
        double work[3 * (MOST + 1)], change = num_jet2_change(num_jet2_input(j2, 3), MOST, (int)sign, work).hi;
        double first = kind < 2 && r < 1 ? r : INFINITY, reach[3] = { num_jet_reach(j, MOST), num_jet2_reach(j2, MOST).hi, change };
        for (int i = 0; i < 3; i++)
            CHECK(isinf(first) ? isinf(reach[i]) : fabs(reach[i] - first) < 1e-2 * gap * first, "turn %d, %d: %.17g instead of %.17g", turn, i, reach[i], first);
    }
    num_tape_free(t);
    num_jet_free(j);
    num_jet2_free(j2);
}

/* +-(2 + s) (s - 1/2)^2 less or more by 2^-m there: passages that are too shallow for doubles, and none. */
static void shallow_changes(void)
{
    for (int m = 10; m <= 84; m += 2)
        for (int kind = 0; kind < 4; kind++) {
            double side = kind % 2 ? 1 : -1, d = (kind < 2 ? -1 : 1) * ldexp(1, -m), work[12];
            num_dd q = num_dd_add_d(num_dd_of(0.25), d);
            num_dd x[4] = { num_dd_scale(q, 2 * side), num_dd_mul_d(num_dd_sub(q, num_dd_of(2)), side), num_dd_of(side), num_dd_of(side) };
            num_dd s = num_jet2_change(x, 3, (int)side, work);
            double off = num_dd_add_d(num_dd_sub(s, num_dd_of(0.5)), ldexp(1, -m / 2)).hi;
            CHECK(kind < 2 ? fabs(off) < 1e-30 * ldexp(1, m / 2) : isinf(s.hi), "2^-%d, %d: %.17g", m, kind, s.hi);
        }
}

/* Clusters of two, four and six zeros, as near to each other as 2^-m: the first is the answer. */
static void clustered_changes(void)
{
    enum { ZEROS = 6 };
    for (int m = 4; m <= 18; m++)
        for (int zeros = 2; zeros <= ZEROS && zeros * m < 84; zeros += 2) {
            num_dd x[ZEROS + 1] = { num_dd_of(1) };
            double work[3 * (ZEROS + 1)];
            for (int i = 0; i < zeros; i++) {
                double at = 0.4375 + i * ldexp(1 + 0.25 * (i % 2), -m);
                for (int k = i + 1; k >= 0; k--)
                    x[k] = num_dd_sub(k ? x[k - 1] : num_dd_of(0), k <= i ? num_dd_mul_d(x[k], at) : num_dd_of(0));
            }
            num_dd s = num_jet2_change(x, zeros, 1, work);
            CHECK(fabs(num_dd_sub(s, num_dd_of(0.4375)).hi) < 1e-29 * ldexp(1, (zeros - 1) * m), "%d zeros, 2^-%d apart: %.17g", zeros, m, s.hi);
        }
}

/* No series: the square root at 0, a solve that is singular. */
static void refused(void)
{
    struct sga_error err = { 0 };
    expr_id e = parse("sqrt(t - 1)");
    struct num_tape *t = num_tape_new(&st, &e, 1, inputs, 4, &err);
    struct num_jet *j = num_jet_new(t, 2);
    num_jet_input(j, 3)[0] = num_jet_input(j, 3)[1] = 1;
    CHECK(num_jet_next(j, 0));
    CHECK(!num_jet_next(j, 1));
    num_tape_free(t);
    num_jet_free(j);
}

int main(void)
{
    enum { FUNCTIONS = sizeof function / sizeof *function };
    expr_id root[VARIABLES + FUNCTIONS + 2];
    expr_store_init(&st);
    for (int i = 0; i < 4; i++) {
        expr_symbol_add(&st, names[i], i < 3 ? EXPR_VARIABLE : EXPR_TIME);
        inputs[i] = expr_symbol_find(&st, names[i], 1);
    }
    struct expr_flow f;
    expr_flow_init(&f, &st);
    for (int i = 0; i < 3; i++)
        expr_flow_determine(&f, inputs[i], root[i] = parse(field[i]));
    for (int i = 0; i < FUNCTIONS; i++)
        root[VARIABLES + i] = parse(function[i]);
    expr_id m[9] = { parse("2 + x"), parse("y"), parse("0"), parse("z"), parse("0"), parse("5 + t"), parse("x*y"), parse("3"), parse("1") };
    expr_id r[3] = { parse("x*y"), parse("1 + t"), parse("1/3") };
    int s = expr_solve_add(&st, 3, m, r);
    for (int i = 0; i < 2; i++)
        root[VARIABLES + FUNCTIONS + i] = expr_solution(&st, s, i);
    struct num_ball b;
    num_ball_init(&b, &st, 300);
    for (int i = 0; i < 4; i++)
        num_ball_set_d(&b, inputs[i], point[i]);
    compare(root, VARIABLES + FUNCTIONS + 2, &f, &b);
    num_ball_clear(&b);
    expr_flow_clear(&f);
    switches();
    beyond_range();
    first_changes();
    shallow_changes();
    clustered_changes();
    refused();
    expr_store_clear(&st);
    flint_cleanup();
    mpfr_free_cache();
    return CHECK_END();
}
