/* Functions and conditions that are written by others: values against the C library's on both sides of every comparison and on it, branches that are not taken,
 * precedences, refusals with their place. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "parse.h"
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
    refusals();
    own_names();
    expr_store_clear(&st);
    return CHECK_END();
}
