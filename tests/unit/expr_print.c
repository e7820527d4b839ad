/* Printing: known texts, round trips through the parser by value, budgets, names. */
#include <string.h>
#include <math.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "parse.h"
#include "print.h"

static struct expr_store st;
static expr_id x, y, z, a;
static unsigned long state;

static unsigned next(unsigned n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(state >> 33) % n;
}

/* The value of a node in floating point, by a loop over the whole store. */
static double value_of(const struct expr_store *s, expr_id e, const double *at)
{
    double *v = calloc((size_t)s->nodes, sizeof *v);
    for (expr_id i = 1; i <= e; i++) {
        const struct expr_node n = s->node[i];
        double p = expr_op_args((enum expr_op)n.op) > 0 ? v[n.a] : 0, q = expr_op_args((enum expr_op)n.op) > 1 ? v[n.b] : 0;
        switch ((enum expr_op)n.op) {
        case EXPR_CONST: v[i] = fmpq_get_d(s->constant + n.a); break;
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
        case EXPR_EXP: v[i] = exp(p); break;
        case EXPR_ABS: v[i] = fabs(p); break;
        case EXPR_MAX: v[i] = fmax(p, q); break;
        case EXPR_ATAN2: v[i] = atan2(p, q); break;
        default: v[i] = NAN; break;
        }
    }
    double r = v[e];
    free(v);
    return r;
}

static expr_id random_tree(int size)
{
    expr_id leaf[] = { x, y, z, a, expr_int(&st, (long)next(7) - 3), expr_rational(&st, (long)next(9) - 4, 1 + next(5)) };
    if (size <= 1)
        return leaf[next(6)];
    int left = 1 + (int)next((unsigned)size - 1);
    expr_id p = random_tree(left), q = random_tree(size - left);
    switch (next(12)) {
    case 0: case 1: return expr_add(&st, p, q);
    case 2: case 3: return expr_sub(&st, p, q);
    case 4: case 5: return expr_mul(&st, p, q);
    case 6: return expr_is_zero(&st, q) ? p : expr_div(&st, p, q);
    case 7: return expr_is_zero(&st, p) ? q : expr_powi(&st, p, (long)next(7) - 3);
    case 8: return expr_neg(&st, expr_add(&st, p, q));
    case 9: return expr_fun(&st, EXPR_SIN, expr_sub(&st, p, q));
    case 10: return expr_fun2(&st, EXPR_MAX, p, q);
    default: return expr_pow(&st, expr_fun(&st, EXPR_EXP, expr_fun(&st, EXPR_COS, p)), q);
    }
}

static bool close_to(double u, double v)
{
    return (isnan(u) && isnan(v)) || u == v || fabs(u - v) <= 1e-7 * (1 + fabs(u) + fabs(v));
}

/* Does a rounding of its parts leave the value alone? A cosine of 1e12 takes all of its digits. */
static bool is_steady(expr_id e, const double at[4])
{
    double u = value_of(&st, e, at);
    for (int j = 0; j < 4; j++) {
        double beside[4] = { at[0], at[1], at[2], at[3] };
        beside[j] *= 1 + 1e-14;
        if (!(fabs(value_of(&st, e, beside) - u) <= 1e-9 * (1 + fabs(u))))
            return false;
    }
    return true;
}

static void round_trips(void)
{
    int tried = check_scale(4000), compared = 0;
    for (int i = 0; i < tried; i++) {
        expr_id e = random_tree(1 + (int)next(14));
        if (!expr_store_ok(&st)) {      /* a division by zero on the way: not the matter here */
            *st.error = (struct sga_error){ 0 };
            continue;
        }
        struct sga_buf text = { 0 };
        struct sga_error err = { 0 };
        CHECK(expr_print(&st, e, 0, &text), "case %d", i);
        expr_id back = expr_parse(&st, text.data, NULL, &err);
        double anywhere[4] = { 0.7, 1.9, 1.1, 0.3 };
        bool has_value = fabs(value_of(&st, e, anywhere)) < 1e9;     /* what divides by z - (z - y) - y has none */
        CHECK(back || (err.code == SGA_E_EXPR_UNDEFINED && !has_value), "%s: %s", text.data, err.detail);
        for (int k = 0; back && k < 3; k++) {
            double at[4];
            for (int j = 0; j < 4; j++)
                at[j] = 0.5 + 0.37 * next(10);
            double u = value_of(&st, e, at), v = value_of(&st, back, at);
            if (!isfinite(u) || fabs(u) > 1e6 || (fabs(u) < 1e-3 && u != 0) || !is_steady(e, at))
                continue;
            compared++;
            CHECK(close_to(u, v), "%s: %.15g %.15g", text.data, u, v);
        }
        sga_buf_free(&text);
    }
    CHECK(compared > tried, "%d of %d", compared, tried);
}

/* A random text whose parts cancel often. */
static void random_text(struct sga_buf *out, int depth)
{
    static const char *const atom[] = { "x", "y", "x", "y", "x^2", "1", "2", "x*y" }, *const join[] = { " + ", " - ", " - ", "*", "*", "/", "/", "^" };
    static const char *const function[] = { "sqrt", "log", "asin", "sin", "cos", "abs", "-" };
    if (depth == 0 || next(6) == 0) {
        sga_buf_puts(out, atom[next(8)]);
        return;
    }
    if (next(7) == 0)
        sga_buf_puts(out, function[next(7)]);
    sga_buf_puts(out, "(");
    random_text(out, depth - 1);
    sga_buf_puts(out, join[next(8)]);
    random_text(out, depth - 1);
    sga_buf_puts(out, ")");
}

/* What is read has a print that is read: what cancels is refused at once, or not at all. */
static void texts_read_back(void)
{
    int tried = check_scale(40000), read = 0;
    for (int i = 0; i < tried; i++) {
        struct sga_buf in = { 0 }, text = { 0 };
        struct sga_error err = { 0 };
        random_text(&in, 2 + (int)next(4));
        expr_id e = expr_parse(&st, in.data, NULL, &err);
        CHECK(e || err.line, "%s", in.data);
        if (e && expr_print(&st, e, 0, &text)) {
            read++;
            CHECK(expr_parse(&st, text.data, NULL, &err), "%s: its print %s: %s", in.data, text.data, err.detail);
        }
        sga_buf_free(&in);
        sga_buf_free(&text);
    }
    CHECK(read > tried / 3, "%d of %d", read, tried);
}

static void prints(const char *in, const char *expected)
{
    struct sga_error err = { 0 };
    struct sga_buf text = { 0 };
    expr_id e = expr_parse(&st, in, NULL, &err);
    CHECK(e, "%s: %s", in, err.detail);
    if (!e)
        return;
    CHECK(expr_print(&st, e, 0, &text) && strcmp(text.data, expected) == 0, "%s gave %s", in, text.data);
    sga_buf_free(&text);
}

static void known(void)
{
    static const char *const cases[][2] = {
        { "x - (y + z)", "x - y - z" }, { "x/(y*z)", "x/(y*z)" }, { "x/y/z", "x/(y*z)" },
        { "-x^2", "-x^2" }, { "(-x)^2", "x^2" }, { "(-x)^3", "-x^3" }, { "x^(-2)", "1/x^2" },
        { "y*x^(-2)", "y/x^2" }, { "2/3*x", "2*x/3" }, { "1/3*x", "x/3" }, { "-x/3", "-x/3" },
        { "-2", "-2" }, { "1/3", "1/3" }, { "x*(-2)", "-2*x" }, { "x^(1/3)", "x^(1/3)" },
        { "x^y^z", "x^(y^z)" }, { "(x^y)^z", "(x^y)^z" }, { "(x*y)^3", "(x*y)^3" },
        { "(1/2)^x", "(1/2)^x" }, { "pi*x", "pi*x" }, { "x*a", "a*x" }, { "sin(x)^2", "sin(x)^2" },
        { "x*(y + z)", "x*(y + z)" }, { "(x + y)/(x - y)", "(x + y)/(x - y)" },
        { "x/(y/z)", "x*z/y" }, { "y*2/(3*x)", "2*y/(3*x)" }, { "1 - x", "1 - x" },
        { "1 + x^2 - 2*x", "x^2 - 2*x + 1" }, { "-(x - y)*z", "z*(y - x)" }, { "0*x", "0" },
        { "max(x, min(y, -z))", "max(x, min(y, -z))" }, { "atan2(y, -x)", "atan2(y, -x)" },
        { "x - -2", "x + 2" }, { "(x+1)^(-1)", "1/(x + 1)" }, { "((x+1)/y)^2", "((x + 1)/y)^2" },
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        prints(cases[i][0], cases[i][1]);
}

static void budgets(void)
{
    struct sga_buf text = { 0 };
    expr_id e = x;
    for (int i = 0; i < 200; i++)       /* a tree of 2^200 leaves */
        e = expr_fun(&st, EXPR_SIN, expr_mul(&st, expr_add(&st, e, y), expr_sub(&st, e, y)));
    sga_buf_puts(&text, "kept");
    CHECK(!expr_print(&st, e, 0, &text) && strcmp(text.data, "kept") == 0, "%s", text.data);
    expr_id sum = x;
    for (int i = 0; i < 100; i++)       /* the same without functions: flattened sums of 2^100 terms */
        sum = expr_add(&st, expr_add(&st, sum, y), expr_sub(&st, sum, z));
    CHECK(!expr_print(&st, sum, 100000, &text), "flat sum");
    expr_id deep = x;
    for (int i = 0; i < 200000; i++)    /* deep, but not long */
        deep = expr_fun(&st, EXPR_EXP, deep);
    CHECK(expr_print(&st, deep, 2000000, &text) && text.len == 4 + 5 * 200000 + 1, "%zu", text.len);
    CHECK(!expr_print(&st, EXPR_UNDEF, 0, &text), "undefined");
    sga_buf_clear(&text);
    CHECK(expr_print(&st, expr_add(&st, x, y), 5, &text), "exact fit");
    CHECK(!expr_print(&st, expr_add(&st, x, y), 4, &text), "one byte short");
    sga_buf_free(&text);
}

int main(void)
{
    state = check_seed(20261);
    expr_store_init(&st);
    x = expr_symbol_add(&st, "x", EXPR_VARIABLE);
    y = expr_symbol_add(&st, "y", EXPR_VARIABLE);
    z = expr_symbol_add(&st, "z", EXPR_VARIABLE);
    a = expr_symbol_add(&st, "a", EXPR_PARAMETER);
    known();
    round_trips();
    texts_read_back();
    budgets();
    expr_store_clear(&st);
    flint_cleanup();
    return CHECK_END();
}
