/* Normal forms: known texts, exact values of input and output at rational points,
 * identities of functions in floating point, budgets. */
#include <math.h>
#include <string.h>

#include "budget.h"
#include "buf.h"
#include "check_read.h"
#include "error.h"
#include "poly.h"
#include "print.h"

static struct expr_store st;
static unsigned long state;
static struct expr_cone cone;

static unsigned next(unsigned n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(state >> 33) % n;
}

static expr_id read(const char *text)
{
    return check_read(&st, text);
}

static char *text_of(expr_id e)
{
    struct sga_buf t = { 0 };
    CHECK(expr_print(&st, e, 0, &t), "print");
    return sga_buf_take(&t);
}

/* Exact value of e; false where something divides by zero. */
static bool exact(expr_id e, const fmpq *at, fmpq_t out)
{
    fmpq *v = calloc((size_t)e + 1, sizeof *v);
    bool *ok = calloc((size_t)e + 1, sizeof *ok);
    expr_cone_of(&st, &cone, &e, 1);
    for (int k = 0; k < cone.count; k++) {
        expr_id i = cone.list[k];
        const struct expr_node n = st.node[i];
        fmpq_init(v + i);
        enum expr_op op = (enum expr_op)n.op;
        ok[i] = op == EXPR_CONST || op == EXPR_SYM
            || (op >= EXPR_ADD && op <= EXPR_POWI && ok[n.a] && (expr_op_args(op) < 2 || ok[n.b]));
        if (ok[i] && op == EXPR_DIV)
            ok[i] = !fmpq_is_zero(v + n.b);
        if (ok[i] && op == EXPR_POWI && n.b < 0)
            ok[i] = !fmpq_is_zero(v + n.a);
        if (!ok[i])
            continue;
        switch (op) {
        case EXPR_CONST: fmpq_set(v + i, st.constant + n.a); break;
        case EXPR_SYM: fmpq_set(v + i, at + n.a); break;
        case EXPR_ADD: fmpq_add(v + i, v + n.a, v + n.b); break;
        case EXPR_SUB: fmpq_sub(v + i, v + n.a, v + n.b); break;
        case EXPR_MUL: fmpq_mul(v + i, v + n.a, v + n.b); break;
        case EXPR_DIV: fmpq_div(v + i, v + n.a, v + n.b); break;
        case EXPR_NEG: fmpq_neg(v + i, v + n.a); break;
        default: fmpq_pow_si(v + i, v + n.a, n.b); break;
        }
    }
    bool result = ok[e];
    if (result)
        fmpq_set(out, v + e);
    for (int k = 0; k < cone.count; k++)
        fmpq_clear(v + cone.list[k]);
    free(v);
    free(ok);
    return result;
}

static double value_of(expr_id e, const double *at)
{
    double *v = calloc((size_t)e + 1, sizeof *v);
    expr_cone_of(&st, &cone, &e, 1);
    for (int k = 0; k < cone.count; k++) {
        expr_id i = cone.list[k];
        const struct expr_node n = st.node[i];
        double p = expr_op_args((enum expr_op)n.op) > 0 ? v[n.a] : 0, q = expr_op_args((enum expr_op)n.op) > 1 ? v[n.b] : 0;
        switch ((enum expr_op)n.op) {
        case EXPR_CONST: v[i] = fmpq_get_d(st.constant + n.a); break;
        case EXPR_PI: v[i] = acos(-1); break;
        case EXPR_SYM: v[i] = at[n.a]; break;
        case EXPR_ADD: v[i] = p + q; break;
        case EXPR_SUB: v[i] = p - q; break;
        case EXPR_MUL: v[i] = p * q; break;
        case EXPR_DIV: v[i] = p / q; break;
        case EXPR_NEG: v[i] = -p; break;
        case EXPR_POWI: v[i] = pow(p, n.b); break;
        case EXPR_POW: v[i] = pow(p, q); break;
        case EXPR_SIN: v[i] = sin(p); break;
        case EXPR_COS: v[i] = cos(p); break;
        case EXPR_TAN: v[i] = tan(p); break;
        case EXPR_SINH: v[i] = sinh(p); break;
        case EXPR_COSH: v[i] = cosh(p); break;
        case EXPR_EXP: v[i] = exp(p); break;
        case EXPR_LOG: v[i] = log(p); break;
        case EXPR_SQRT: v[i] = sqrt(p); break;
        case EXPR_CBRT: v[i] = cbrt(p); break;
        case EXPR_ABS: v[i] = fabs(p); break;
        case EXPR_MIN: v[i] = fmin(p, q); break;
        case EXPR_MAX: v[i] = fmax(p, q); break;
        case EXPR_ATAN2: v[i] = atan2(p, q); break;
        default: v[i] = NAN; break;
        }
    }
    double r = v[e];
    free(v);
    return r;
}

static void shows(const char *in, const char *expected)
{
    expr_id e = read(in), n = EXPR_UNDEF;
    CHECK(poly_normal(&st, e, NULL, &n), "%s is over budget", in);
    if (!n)
        return;
    char *t = text_of(n);
    CHECK(strcmp(t, expected) == 0, "%s gave %s, not %s", in, t, expected);
    free(t);
    /* a normal form is its own normal form */
    expr_id again = EXPR_UNDEF;
    CHECK(poly_normal(&st, n, NULL, &again) && again == n, "%s again", in);
}

static void known(void)
{
    static const char *const cases[][2] = {
        { "x - x", "0" }, { "(x^2 - y^2)/(x - y)", "x + y" }, { "v - omega", "v - omega" },
        { "-(omega - v)*2/2", "v - omega" }, { "(x + y)/2", "x/2 + y/2" }, { "x/2 + y/3", "x/2 + y/3" },
        { "x/(2*y) + 1/y", "(x + 2)/(2*y)" }, { "1/x + 1/y", "(x + y)/(x*y)" },
        { "(x + 1)^2 - x^2 - 2*x", "1" }, { "(2*x + 2*y)/(3*x - 3*y)", "2*(x + y)/(3*(x - y))" },
        { "1/(1/x)", "x" }, { "x/(x/y)", "y" }, { "1/(x - y) - 1/(y - x)", "2/(x - y)" },
        { "sin(x)^2 + cos(x)^2", "1" }, { "1 - cos(x)^2 + 0*sin(x)", "1 - cos(x)^2" },
        { "sin(x) - sin(x)*cos(x)^2", "sin(x)^3" }, { "(1 - cos(x)^2)/sin(x)", "sin(x)" },
        { "tan(x)*cos(x)", "sin(x)" }, { "tan(x)^2", "tan(x)^2" }, { "cosh(x)^2 - sinh(x)^2", "1" },
        { "sin(x + y) - sin(y + x)", "0" }, { "sin(x - y) + sin(y - x)", "0" }, { "cos(x - y) - cos(y - x)", "0" },
        { "sqrt(x + y)^2", "x + y" }, { "sqrt(x)^3", "x*sqrt(x)" }, { "x/sqrt(x)", "sqrt(x)" },
        { "cbrt(x)^3 - x", "0" }, { "cbrt(x - y)^3 + cbrt(y - x)^3", "0" }, { "abs(x)^2", "x^2" },
        { "exp(x)*exp(-x)", "1" }, { "exp(2*x) - exp(x)^2", "0" }, { "exp(-x)*y", "y*exp(-x)" },
        { "exp(x)^2", "exp(2*x)" }, { "x^(1/3)*x^(2/3)", "x" }, { "x^(2/3)", "x^(2/3)" },
        { "sqrt(x/y)^2", "x/y" }, { "max(x + y - y, y) - max(y, x)", "0" }, { "pi*x - x*pi", "0" },
        { "x^y*x^(y + 0*x) - (x^y)^2", "0" }, { "x*a + a*x", "2*a*x" }, { "(a*x + a*y)/a", "x + y" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        shows(cases[i][0], cases[i][1]);
}

static const char *const names[] = { "x", "y", "v", "omega", "a" };

static expr_id random_tree(int size, bool functions)
{
    if (size <= 1) {
        int k = (int)next(7);
        return k < 5 ? read(names[k]) : expr_rational(&st, (long)next(9) - 4, 1 + next(4));
    }
    int left = 1 + (int)next((unsigned)size - 1);
    expr_id p = random_tree(left, functions), q = random_tree(size - left, functions);
    switch (next(functions ? 12 : 9)) {
    case 0: case 1: return expr_add(&st, p, q);
    case 2: return expr_sub(&st, p, q);
    case 3: case 4: case 5: return expr_mul(&st, p, q);
    case 6: case 7: return expr_is_zero(&st, q) ? p : expr_div(&st, p, q);
    case 8: return expr_is_zero(&st, p) ? q : expr_powi(&st, p, (long)next(6) - 2);
    case 9: return expr_mul(&st, expr_fun(&st, EXPR_SIN, p), expr_fun(&st, EXPR_COS, next(2) ? p : q));
    case 10: return expr_mul(&st, expr_fun(&st, EXPR_EXP, q), expr_fun(&st, EXPR_SQRT, expr_fun(&st, EXPR_EXP, p)));
    default: return expr_add(&st, expr_fun(&st, EXPR_TAN, p), expr_fun(&st, EXPR_ABS, q));
    }
}

/* Both sides exactly at random rational points. */
static void random_rational(void)
{
    int cases = check_scale(1500), compared = 0;
    fmpq at[8];
    fmpq_t u, v;
    fmpq_init(u);
    fmpq_init(v);
    for (int i = 0; i < 8; i++)
        fmpq_init(at + i);
    for (int i = 0; i < cases; i++) {
        expr_id e = random_tree(2 + (int)next(16), false), n = EXPR_UNDEF;
        *st.error = (struct sga_error){ 0 };
        if (!e || !poly_normal(&st, e, NULL, &n))
            continue;
        for (int k = 0; k < 3; k++) {
            for (int j = 0; j < 8; j++)
                fmpq_set_si(at + j, (long)next(41) - 20, 1 + next(7));
            if (!exact(e, at, u))
                continue;
            compared++;
            char *t = text_of(n);
            CHECK(exact(n, at, v) && fmpq_equal(u, v), "case %d: %s", i, t);
            free(t);
        }
    }
    CHECK(compared > cases, "%d of %d", compared, cases);
    for (int i = 0; i < 8; i++)
        fmpq_clear(at + i);
    fmpq_clear(u);
    fmpq_clear(v);
}

static void random_functions(void)
{
    int cases = check_scale(1500), compared = 0;
    for (int i = 0; i < cases; i++) {
        expr_id e = random_tree(2 + (int)next(12), true), n = EXPR_UNDEF;
        *st.error = (struct sga_error){ 0 };
        if (!e || !poly_normal(&st, e, NULL, &n))
            continue;
        double at[8];
        for (int j = 0; j < 8; j++)
            at[j] = 0.3 + 0.11 * next(12);
        double u = value_of(e, at), v = value_of(n, at);
        if (!isfinite(u) || fabs(u) > 1e4 || fabs(u) < 1e-4)
            continue;
        compared++;
        char *s = text_of(e), *t = text_of(n);
        CHECK(fabs(u - v) <= 1e-6 * fabs(u), "%s gave %s: %.15g %.15g", s, t, u, v);
        free(s);
        free(t);
    }
    CHECK(compared > cases / 3, "%d of %d", compared, cases);
}

/* e - normal(e) is proved zero, and a bridge for many roots agrees with one for each. */
static void one_bridge(void)
{
    expr_id e[20], one[20], all[20], d[20];
    for (int i = 0; i < 20; i++) {
        e[i] = random_tree(8, false);
        *st.error = (struct sga_error){ 0 };
        if (!e[i])
            e[i] = expr_int(&st, i);
        one[i] = e[i];
        poly_normal(&st, e[i], NULL, one + i);
    }
    CHECK(poly_normal_all(&st, e, 20, NULL, all) >= 15, "found");
    for (int i = 0; i < 20; i++) {
        d[i] = expr_sub(&st, one[i], all[i]);
        CHECK(d[i] && poly_is_zero(&st, d[i], NULL) == POLY_YES, "root %d", i);
    }
    struct poly_limits tight = { .max_generators = 3 };     /* a bridge for all is refused */
    CHECK(poly_normal_all(&st, e, 20, &tight, all) > 0, "one by one");
}

static void budgets(void)
{
    static const char *const large[] = {
        "(x + y + v + 1)^200", "((x + y + v + omega + a + 1)^9)^9", "((x + y)^300)^30", "12345^200*x^390 + (7^5000*x)^50",
        "(x + y)^1000/(x - y)^1000", "((((x + y)^20 + v)^20 + omega)^20 + a)^20",
    };
    for (size_t i = 0; i < sizeof large / sizeof *large; i++) {
        expr_id e = read(large[i]), n = -7;
        CHECK(!poly_normal(&st, e, NULL, &n) && n == -7, "%s", large[i]);
        CHECK(expr_store_ok(&st), "%s", large[i]);
        CHECK(poly_is_zero(&st, e, NULL) == POLY_UNKNOWN, "%s", large[i]);
    }
    /* what is too large somewhere does not spoil the rest */
    expr_id roots[] = { read("(x + y + v + 1)^200"), read("(x^2 - 1)/(x - 1)") }, out[2];
    CHECK(poly_normal_all(&st, roots, 2, NULL, out) == 1 && out[0] == roots[0] && out[1] == read("x + 1"), "rest");
    /* few distinct monomials: allowed */
    expr_id n;
    CHECK(poly_normal(&st, read("(1 + x + x^2)^100"), NULL, &n), "dense power in one variable");
    /* an undefined quotient is refused */
    CHECK(!poly_normal(&st, read("1/(sin(x)^2 + cos(x)^2 - 1)"), NULL, &n), "division by zero");
    struct sga_budget late = { .deadline = 1e-9, .seconds = 1 };
    struct poly_limits limits = { .budget = &late };
    CHECK(!poly_normal(&st, read("x + y - y"), &limits, &n), "deadline");
}

static void zeros(void)
{
    static const struct { const char *text; enum poly_truth truth; } cases[] = {
        { "(x + y)^3 - x^3 - 3*x^2*y - 3*x*y^2 - y^3", POLY_YES }, { "x + 1e-300", POLY_NO }, { "x*y - y*x + 1/7", POLY_NO },
        { "0.1 + 0.2 - 0.3", POLY_YES }, { "pi - 3", POLY_NO }, { "sin(2*x) - 2*sin(x)*cos(x)", POLY_UNKNOWN },
        { "sin(x)^4 - cos(x)^4 - sin(x)^2 + cos(x)^2", POLY_YES }, { "tan(x) - sin(x)/cos(x)", POLY_YES },
        { "sqrt(x*y)^2 - y*x", POLY_YES }, { "1/(1 + sqrt(x)) - (1 - sqrt(x))/(1 - x)", POLY_YES },
        { "sqrt(x^2)^2 - x^2", POLY_YES }, { "sqrt(x^2) - x", POLY_UNKNOWN }, { "sqrt(2)^2 - 2", POLY_YES },
        { "sqrt(1/x)^2 - 1/x", POLY_YES }, { "exp(x)*exp(y) - exp(x + y)", POLY_UNKNOWN },
        { "exp(x - y)*exp(y - x) - 1", POLY_YES }, { "log(x*y) - log(y*x)", POLY_YES },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        CHECK(poly_is_zero(&st, read(cases[i].text), NULL) == cases[i].truth, "%s", cases[i].text);
}

static void shapes(void)
{
    int x = expr_symbol_find(&st, "x", 1);
    long d = -5;
    CHECK(poly_degree_in(&st, read("(x + y)^3 - x^3"), x, NULL, &d) && d == 2, "%ld", d);
    CHECK(poly_degree_in(&st, read("x/(y + 1)"), x, NULL, &d) && d == 1, "%ld", d);
    CHECK(poly_degree_in(&st, read("x - x"), x, NULL, &d) && d == -1, "%ld", d);
    CHECK(poly_degree_in(&st, read("sin(y)*x^4"), x, NULL, &d) && d == 4, "%ld", d);
    CHECK(!poly_degree_in(&st, read("x + sin(x)"), x, NULL, &d), "inside a kernel");
    CHECK(!poly_degree_in(&st, read("1/(x + y)"), x, NULL, &d), "below the line");
    expr_id line[2];
    CHECK(poly_linear_in(&st, read("(2*x*y + 4*y)/6 - 1"), x, NULL, line), "linear");
    CHECK(line[0] == read("y/3"), "slope");
    CHECK(poly_is_zero(&st, expr_sub(&st, line[1], read("2*y/3 - 1")), NULL) == POLY_YES, "rest");
    CHECK(poly_linear_in(&st, read("y + 2"), x, NULL, line) && expr_is_zero(&st, line[0]) && line[1] == read("y + 2"), "absent");
    CHECK(!poly_linear_in(&st, read("x^2 + 1"), x, NULL, line), "quadratic");
}

int main(void)
{
    state = check_seed(7);
    expr_store_init(&st);
    expr_cone_init(&cone);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        expr_symbol_add(&st, names[i], strcmp(names[i], "a") ? EXPR_VARIABLE : EXPR_PARAMETER);
    known();
    zeros();
    shapes();
    budgets();
    one_bridge();
    random_rational();
    random_functions();
    expr_cone_clear(&cone);
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
