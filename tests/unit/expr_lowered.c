/* Functions and conditions that are written by others: values against the C library's on both sides of every comparison and on it, branches that are not taken,
 * precedences, refusals with their place. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "error.h"
#include "parse.h"
#include "same_sign.h"
#include "value.h"

static struct expr_store st;

/* Of node e, children first; symbols have the values at[]. */
static double expr_value(expr_id e, const double *at)
{
    double *v = calloc((size_t)e + 1, sizeof *v);
    for (expr_id i = 1; i <= e; i++) {
        struct expr_node n = st.node[i];
        double a = n.a <= e && n.a > 0 && n.a < i ? v[n.a] : 0, b = n.b > 0 && n.b < i ? v[n.b] : 0;
        switch ((enum expr_op)n.op) {
        case EXPR_CONST: v[i] = expr_nearest_double(expr_const_value(&st, i)); break;
        case EXPR_PI:    v[i] = acos(-1); break;
        case EXPR_SYM:   v[i] = n.a < 2 ? at[n.a] : NAN; break;
        case EXPR_ADD:   v[i] = a + b; break;
        case EXPR_SUB:   v[i] = a - b; break;
        case EXPR_MUL:   v[i] = a * b; break;
        case EXPR_DIV:   v[i] = a / b; break;
        case EXPR_NEG:   v[i] = -a; break;
        case EXPR_POWI:  v[i] = pow(a, n.b); break;
        case EXPR_POW:   v[i] = pow(a, b); break;
        case EXPR_ATAN2: v[i] = atan2(a, b); break;
        case EXPR_MIN:   v[i] = fmin(a, b); break;
        case EXPR_MAX:   v[i] = fmax(a, b); break;
        default:         v[i] = expr_function_value((enum expr_op)n.op, a); break;
        }
    }
    double value = v[e];
    free(v);
    return value;
}

static double value(const char *text, double x, double y)
{
    struct sga_error err = { 0 };
    double at[] = { x, y };
    expr_id e = expr_parse(&st, text, NULL, &err);
    CHECK(e, "%s: %s", text, err.detail);
    return e ? expr_value(e, at) : NAN;
}

static void same(const char *text, double x, double y, double right)
{
    double v = value(text, x, y);
    CHECK(fabs(v - right) <= 4e-16 * (1 + fabs(right)), "%s at %g, %g: %.17g, not %.17g", text, x, y, v, right);
}

static void comparisons(void)
{
    static const double at[] = { -2, -1, 0, 1, 3 };
    for (int i = 0; i < 5; i++)
        for (int j = 0; j < 5; j++) {
            double x = at[i], y = at[j];
            same("if(x < y, 1, -1)", x, y, x < y ? 1 : -1);
            same("if(x <= y, 1, -1)", x, y, x <= y ? 1 : -1);
            same("if(x > y, 1, -1)", x, y, x > y ? 1 : -1);
            same("if(x >= y, 1, -1)", x, y, x >= y ? 1 : -1);
            same("if(x == y, 1, -1)", x, y, x == y ? 1 : -1);
            same("if(x != y, 1, -1)", x, y, x != y ? 1 : -1);
            same("if(x > 0 and y > 0, 1, -1)", x, y, x > 0 && y > 0 ? 1 : -1);
            same("if(x > 0 or y > 0 and x < y, 1, -1)", x, y, x > 0 || (y > 0 && x < y) ? 1 : -1);
            same("if((x > 0 or y > 0) and x < y, 1, -1)", x, y, (x > 0 || y > 0) && x < y ? 1 : -1);
            same("if(not x > 0 and y > 0, 1, -1)", x, y, !(x > 0) && y > 0 ? 1 : -1);
            same("if(not (x > 0 and not y > 0), 1, -1)", x, y, !(x > 0 && !(y > 0)) ? 1 : -1);
            same("if(x + 1 > 2*y - x^2, 1, -1)", x, y, x + 1 > 2 * y - x * x ? 1 : -1);
            same("2*if(x > 0, if(y > 0, 3, 2), if(y > x, 1, 0)) + 1", x, y, 2 * (x > 0 ? (y > 0 ? 3 : 2) : y > x ? 1 : 0) + 1);
        }
}

static void branches(void)
{
    for (double x = -3; x <= 3; x += 0.5) {
        same("if(x >= 0, sqrt(x), 1e20)", x, 0, x >= 0 ? sqrt(x) : 1e20);
        same("if(x > 0, log(x), 1/(x - 1))", x, 0, x > 0 ? log(x) : 1 / (x - 1));
        same("if(x != 0, sin(x)/x, 1)", x, 0, x != 0 ? sin(x) / x : 1);
        same("if(x < 0, x, exp(1000*x)*0 + exp(-1000*x))", fmin(x, 0), 0, fmin(x, 0) < 0 ? fmin(x, 0) : 1);
        same("if(x > 1, acosh(x), if(x < -1, log(-x - 1 + 1e-3), acos(x)))", x, 0, x > 1 ? acosh(x) : x < -1 ? log(-x - 1 + 1e-3) : acos(x));
        same("if(abs(x) <= 1, asin(x), atan2(x, 0) + x^(-3) + abs(x)^0.3)", x, 0,
             fabs(x) <= 1 ? asin(x) : atan2(x, 0) + pow(x, -3) + pow(fabs(x), 0.3));
        same("step(x)", x, 0, x >= 0);
        same("hypot(x, 3, 4)", x, 0, sqrt(x * x + 25));
    }
    CHECK(!isfinite(value("if(x > 0, sqrt(-x), 1)", 1, 0)));        /* the branch that is taken is what it says */
    CHECK(!isfinite(value("if(x > 0, 1/y, 1)", 1, 0)));
    same("log10(1000) + log10(0.01) + log2(1/8)", 0, 0, -2);
    same("log10(x)", 5, 0, log10(5));
    same("log2(x)", 5, 0, log2(5));
    same("x**2", 3, 0, 9);
    same("if(1 < 2, x, 1/0.5)", 3, 0, 3);
}

static bool has_sign(expr_id e)
{
    bool has = false;
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(&st, &cone, &e, 1);
    for (int i = 0; i < cone.count; i++)
        has |= expr_op_of(&st, cone.list[i]) == EXPR_SIGN;
    expr_cone_clear(&cone);
    return has;
}

/* A product with u and sign(u) does not jump, in whatever order it is written. */
static void signs(void)
{
    static const char *const text[] = { "x*y*sign(x)", "x*sign(x)*y", "sign(x)*y*x", "y*sign(x)*x", "sign(x)*x*y", "y*x*sign(x)", "x*(y*sign(x))", "(sign(x)*y)*x", "y*x^2*sign(x)/x", "sign(x)*(y*x)",
                                        "x/2*sign(x)*2*y", "-x*sign(x)*(-y)", "(x*y/3)*sign(x)*3", "sign(x)*(x*y/(1 + y^2))*(1 + y^2)" };
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        struct sga_error err = { 0 };
        for (double x = -2; x <= 2; x += 0.5)
            for (double y = -1.5; y <= 2; y += 1)
                if (x != 0)
                    same(text[i], x, y, fabs(x) * y);
        CHECK(!has_sign(expr_parse(&st, text[i], NULL, &err)), "%s keeps its sign", text[i]);
    }
    same("x^2*sign(x)", -3, 0, -9);
    same("sign(x)*x^3*sign(y)*y", -3, -2, 54);
    struct sga_error err = { 0 };
    CHECK(!has_sign(expr_parse(&st, "x^2*sign(x)", NULL, &err)), "x^2*sign(x) jumps nowhere");
    CHECK(!has_sign(expr_parse(&st, "sign(x)*x^3*sign(y)*y", NULL, &err)), "two signs");
    CHECK(has_sign(expr_parse(&st, "sign(x)*y", NULL, &err)), "sign(x)*y jumps");
}

/* Signs of powers and multiples are those of what has a rate at its zero; what is chosen by a sign and does not jump has none. */
static void bends(void)
{
    static const char *const same_node[][2] = { { "sign((x - y)^3)", "sign(x - y)" }, { "sign(-2*x)", "-sign(x)" }, { "sign(3*sinh(x*y))", "sign(x*y)" }, { "sign(sign(x))", "sign(x)" }, { "abs(-3*x)", "3*abs(x)" } };
    static const char *const smooth[] = { "if(x > y, x, y)", "if(x <= y, x, y)", "if(x < 0, -3*x*y, 0)", "if(x > 0, x, -x)", "if(x >= 1, (x - 1)^2*y + y, y)", "if(not x > 1, y, y + 2*(x - 1))" };
    static const char *const jump[] = { "if(x > y, x, 0)", "if(x > 0, 1, -1)", "if(x > 0, sqrt(x), 0)", "if(x != 0, x, 0)", "if(x > 0 and y > 0, x, 0)" };
    struct sga_error err = { 0 };
    for (size_t i = 0; i < sizeof same_node / sizeof *same_node; i++)
        CHECK(expr_parse(&st, same_node[i][0], NULL, &err) == expr_parse(&st, same_node[i][1], NULL, &err), "%s", same_node[i][0]);
    for (size_t i = 0; i < sizeof smooth / sizeof *smooth; i++)
        CHECK(!has_sign(expr_parse(&st, smooth[i], NULL, &err)), "%s jumps", smooth[i]);
    for (size_t i = 0; i < sizeof jump / sizeof *jump; i++)
        CHECK(has_sign(expr_parse(&st, jump[i], NULL, &err)), "%s does not jump", jump[i]);
    for (double x = -2; x <= 2; x += 0.5)
        for (double y = -2; y <= 2; y += 0.5) {
            same("if(x > y, x, y)", x, y, fmax(x, y));
            same("if(x <= y, x, y)", x, y, fmin(x, y));
            same("if(x < 0, -3*x*y, 0)", x, y, x < 0 ? -3 * x * y : 0);
            same("if(x >= 1, (x - 1)^2*y + y, y)", x, y, x >= 1 ? (x - 1) * (x - 1) * y + y : y);
            same("if(not x > 1, y, y + 2*(x - 1))", x, y, x > 1 ? y + 2 * (x - 1) : y);
            same("if(y - x > 0, 2*(x - y), 0)", x, y, y > x ? 2 * (x - y) : 0);
            same("if(x > 0 and y > 0, x, 0)", x, y, x > 0 && y > 0 ? x : 0);
        }
}

/* What an event's function is replaced by: its zeros and signs stay. */
static void same_signs(void)
{
    static const char *const text[][2] = { { "(x + y)^3", "x + y" }, { "-(x - 2*y)", "2*y - x" }, { "3*sinh(x + y)", "x + y" }, { "-(x + y)*abs(x + y)/5", "-x - y" }, { "sign(x - 1)", "x - 1" },
                                           { "if(x > y, 3, -1/7)", "x - y" }, { "if(x > y, -3, 1/7)", "y - x" }, { "step(x)*3 - 1", "x" }, { "2*sign(x + y) - 1", "x + y" }, { "cbrt(x)^5", "x" },
                                           { "atan(sign(x)^3)", "x" } };
    static const char *const stays[] = { "x^2", "sign(x) + 2", "sign(x) + y/10", "step(x)", "sign(x)*sign(y)", "sign(max(x, 0)) - 1/2", "x/abs(x)", "x*y", "exp(x)", "5", "tan(x)", "x^(-3)" };
    struct sga_error err = { 0 };
    for (size_t i = 0; i < sizeof text / sizeof *text; i++) {
        expr_id e = expr_parse(&st, text[i][0], NULL, &err), to = expr_same_sign(&st, e);
        CHECK(!has_sign(to), "%s jumps", text[i][0]);
        for (double x = -2; x <= 2; x += 0.25)
            for (double y = -1.5; y <= 2; y += 0.5) {
                double at[] = { x, y }, other = value(text[i][1], x, y), got = expr_value(to, at);
                CHECK((got > 0) == (other > 0) && (got < 0) == (other < 0), "%s at %g, %g: %g beside %g", text[i][0], x, y, got, other);
            }
    }
    for (size_t i = 0; i < sizeof stays / sizeof *stays; i++) {
        expr_id e = expr_parse(&st, stays[i], NULL, &err);
        CHECK(e && expr_same_sign(&st, e) == e, "%s does not stay", stays[i]);
    }
}

static void refused(const char *text, enum sga_code code, int column)
{
    struct sga_error err = { 0 };
    CHECK(!expr_parse(&st, text, NULL, &err) && err.code == code && err.column == column, "%s: %s at %d: %s", text, sga_code_text(err.code), err.column, err.detail);
}

static void refusals(void)
{
    refused("x > 0", SGA_E_EXPR_SYNTAX, 3);
    refused("if(x, 1, 2)", SGA_E_EXPR_SYNTAX, 1);
    refused("if(x = 0, 1, 2)", SGA_E_EXPR_SYNTAX, 6);
    refused("if(0 < x < 1, 1, 2)", SGA_E_EXPR_SYNTAX, 10);
    refused("if(x and y, 1, 2)", SGA_E_EXPR_SYNTAX, 6);
    refused("if((x > 0) + 1, 1, 2)", SGA_E_EXPR_SYNTAX, 12);
    refused("if(x > 0, y > 0, 1)", SGA_E_EXPR_SYNTAX, 13);
    refused("if(x > 0, 1)", SGA_E_EXPR_ARITY, 1);
    refused("sin(x > 0)", SGA_E_EXPR_SYNTAX, 7);
    refused("hypot(x)", SGA_E_EXPR_ARITY, 1);
    refused("log10(-1)", SGA_E_EXPR_UNDEFINED, 1);
}

/* Names that a system has are its own. */
static void own_names(void)
{
    struct sga_error err = { 0 };
    expr_symbol_add(&st, "step", EXPR_VARIABLE);
    CHECK(expr_parse(&st, "2*step + x", NULL, &err));
    CHECK(!expr_parse(&st, "step(x)", NULL, &err));
}

int main(void)
{
    expr_store_init(&st);
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_symbol_add(&st, "y", EXPR_VARIABLE);
    comparisons();
    branches();
    signs();
    same_signs();
    bends();
    refusals();
    own_names();
    expr_store_clear(&st);
    return CHECK_END();
}
