/* The parser: values against the C compiler's, and random trees printed and read back. */
#include <math.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "mem.h"
#include "parse.h"

/* A small evaluator of its own: nodes in order, symbols from a table. */
static double value_of(const struct expr_store *st, expr_id e, const double *symbol)
{
    double *v = sga_calloc((size_t)st->nodes, sizeof *v), r;
    for (int i = 1; i <= e; i++) {
        const struct expr_node *n = st->node + i;
        double a = n->a >= 0 && n->a < i ? v[n->a] : 0, b = n->b >= 0 && n->b < i ? v[n->b] : 0;
        switch (n->op) {
        case EXPR_CONST: v[i] = fmpz_get_d(fmpq_numref(st->constant + n->a)) / fmpz_get_d(fmpq_denref(st->constant + n->a)); break;
        case EXPR_PI:    v[i] = M_PI; break;
        case EXPR_SYM:   v[i] = symbol[n->a]; break;
        case EXPR_ADD:   v[i] = a + b; break;
        case EXPR_SUB:   v[i] = a - b; break;
        case EXPR_MUL:   v[i] = a * b; break;
        case EXPR_DIV:   v[i] = a / b; break;
        case EXPR_NEG:   v[i] = -a; break;
        case EXPR_POWI:  v[i] = pow(a, n->b); break;
        case EXPR_POW:   v[i] = pow(a, b); break;
        case EXPR_SIN:   v[i] = sin(a); break;
        case EXPR_COS:   v[i] = cos(a); break;
        case EXPR_EXP:   v[i] = exp(a); break;
        case EXPR_ATAN2: v[i] = atan2(a, b); break;
        case EXPR_SQRT:  v[i] = sqrt(a); break;
        case EXPR_ABS:   v[i] = fabs(a); break;
        case EXPR_MIN:   v[i] = fmin(a, b); break;
        case EXPR_MAX:   v[i] = fmax(a, b); break;
        default:         v[i] = NAN; break;
        }
    }
    r = v[e];
    free(v);
    return r;
}

static void values(void)
{
    const double x = 1.25, y = -0.75, z = 3.5;
    struct { const char *text; double value; } table[] = {
        { "x", x }, { " x\t", x }, { "1", 1 }, { "0.1", 0.1 }, { ".5", 0.5 }, { "5.", 5 }, { "1e3", 1000 }, { "2.5E-2", 0.025 },
        { "1+2*3", 7 }, { "(1+2)*3", 9 }, { "x - y - z", x - y - z }, { "x - (y - z)", x - (y - z) },
        { "x/y/z", x / y / z }, { "x/y*z", x / y * z }, { "x*y/z", x * y / z },
        { "-x^2", -(x * x) }, { "(-x)^2", x * x }, { "-2^2", -4 }, { "2^-3", 0.125 }, { "2^-x", pow(2, -x) }, { "2^3^2", 512 }, { "2**3**2", 512 },
        { "x^2*y", x * x * y }, { "x*y^2", x * y * y }, { "2^-3*8", 1 }, { "2^-x^2", pow(2, -(x * x)) },
        { "--x", x }, { "-+-x", x }, { "x - -y", x - -y }, { "x*-y", x * -y }, { "x/-y^2", x / -(y * y) }, { "+x", x },
        { "-x*y", -x * y }, { "-x - y", -x - y },
        { "sin(x)*cos(y)", sin(x) * cos(y) }, { "sin(x)^2", sin(x) * sin(x) }, { "atan2(y, x)", atan2(y, x) },
        { "min(x, y)", y }, { "max(x,y,z,2)", z }, { "min(x, y, -4, z)", -4 }, { "exp(-(x+y)/2)", exp(-(x + y) / 2) },
        { "sqrt(abs(y))", sqrt(-y) }, { "pi*x", M_PI * x }, { "x^0.5", sqrt(x) }, { "x^(1/3)", pow(x, 1.0 / 3) }, { "x^y", pow(x, y) },
        { "8^(1/3)", 2 }, { "0^(1/3)", 0 }, { "0^0", 1 }, { "((((x))))", x }, { "x\n + y", x + y }, { "1/3", 1.0 / 3 }, { "1e-300*1e300", 1 },
    };
    struct expr_store st;
    expr_store_init(&st);
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    expr_symbol_add(&st, "y", EXPR_VARIABLE);
    expr_symbol_add(&st, "z", EXPR_VARIABLE);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct sga_error err = { 0 };
        expr_id e = expr_parse(&st, table[i].text, NULL, &err);
        double v = e ? value_of(&st, e, (double[]){ x, y, z }) : NAN;
        CHECK(e && fabs(v - table[i].value) <= 1e-14 * (1 + fabs(v)), "%s: %s %g", table[i].text, err.detail, v);
    }
    struct sga_error err = { 0 };
    expr_id third = expr_parse(&st, "0.1 + 0.2 - 0.3", NULL, &err);
    CHECK(third && expr_is_zero(&st, third), "decimals are exact");
    const char *equation[] = { "x = y", "x == y", "x ~ y", "x=y\n" };
    expr_id difference = expr_parse(&st, "x - y", NULL, &err);
    for (int i = 0; i < 4; i++)
        CHECK(expr_parse_equation(&st, equation[i], NULL, &err) == difference, "%s", equation[i]);
    expr_store_clear(&st);
}

/* x' by a callback, and parameters that have values. */
static expr_id prime(void *ctx, int symbol, int order)
{
    struct expr_store *st = ctx;
    char name[64];
    if (strcmp(st->symbol[symbol].name, "x") != 0)
        return EXPR_UNDEF;
    snprintf(name, sizeof name, "d%d", order);
    return expr_symbol_add(st, name, EXPR_VELOCITY);
}

static void derivatives_and_values(void)
{
    struct expr_store st;
    expr_store_init(&st);
    expr_symbol_add(&st, "r", EXPR_PARAMETER);
    expr_id value[1] = { expr_rational(&st, 1, 10) };
    expr_symbol_add(&st, "x", EXPR_VARIABLE);
    struct expr_grammar g = { .derivative = prime, .ctx = &st, .value = value, .values = 1 };
    struct sga_error err = { 0 };
    expr_id one = expr_parse(&st, "der(x)", &g, &err), two = expr_parse(&st, "x''", &g, &err);
    CHECK(one && one == expr_parse(&st, "x'", &g, &err) && one == expr_parse(&st, "der( x , 1 )", &g, &err), "x'");
    CHECK(two && two == expr_parse(&st, "der(x, 2)", &g, &err) && two == expr_parse(&st, "der(x')", &g, &err), "x''");
    CHECK(expr_parse(&st, "r*10", &g, &err) == expr_int(&st, 1), "a parameter is its value");
    CHECK(expr_parse(&st, "x'^2 - x'*x'", &g, &err) == expr_int(&st, 0), "quotes bind to the name");
    expr_store_clear(&st);
}

static unsigned next(unsigned long *seed, unsigned n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(*seed >> 33) % n;
}

/* A random tree as a fully parenthesised text, with its value by the C operators. */
static double random_text(unsigned long *seed, int depth, const double *symbol, struct sga_buf *out)
{
    static const char *const names[] = { "x", "y", "z" };
    unsigned kind = depth ? next(seed, 9) : 7 + next(seed, 2);
    double a, b;
    if (kind == 7) {
        unsigned k = next(seed, 3);
        sga_buf_puts(out, names[k]);
        return symbol[k];
    }
    if (kind == 8) {
        int n = 1 + (int)next(seed, 400);
        sga_buf_printf(out, next(seed, 2) ? "%d.%02d" : "%d.%02de0", n / 100, n % 100);
        return n / 100.0;
    }
    const char *blank = next(seed, 2) ? " " : "";
    if (kind == 4 || kind == 5) {
        sga_buf_puts(out, kind == 4 ? "sin(" : "max(1, ");
        a = random_text(seed, depth - 1, symbol, out);
        sga_buf_puts(out, ")");
        return kind == 4 ? sin(a) : fmax(1, a);
    }
    sga_buf_puts(out, kind == 6 ? "(-" : "(");
    a = random_text(seed, depth - 1, symbol, out);
    if (kind == 6) {
        sga_buf_puts(out, ")");
        return -a;
    }
    sga_buf_printf(out, "%s%c%s", blank, "+-*^"[kind], kind == 3 ? "2" : blank);
    b = kind == 3 ? 2 : random_text(seed, depth - 1, symbol, out);
    sga_buf_puts(out, ")");
    return kind == 0 ? a + b : kind == 1 ? a - b : kind == 2 ? a * b : a * a;
}

static void random_trees(void)
{
    unsigned long seed = check_seed(20241);
    const double at[3] = { 0.7, -0.4, 1.1 };
    for (int i = 0; i < check_scale(400); i++) {
        struct expr_store st;
        struct sga_buf text = { 0 };
        struct sga_error err = { 0 };
        expr_store_init(&st);
        expr_symbol_add(&st, "x", EXPR_VARIABLE);
        expr_symbol_add(&st, "y", EXPR_VARIABLE);
        expr_symbol_add(&st, "z", EXPR_VARIABLE);
        double expect = random_text(&seed, 6, at, &text);
        expr_id e = expr_parse(&st, text.data, NULL, &err);
        double v = e ? value_of(&st, e, at) : NAN;
        CHECK(e && (fabs(v - expect) <= 1e-7 * (1 + fabs(expect)) || fabs(expect) > 1e6), "%s: %g %g %s", text.data, v, expect,
              err.detail);
        sga_buf_free(&text);
        expr_store_clear(&st);
    }
}

int main(void)
{
    values();
    derivatives_and_values();
    random_trees();
    return CHECK_END();
}
