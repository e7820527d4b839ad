/* Order reduction and prolongation, as text: variables, rows A | alpha, roles. The second
 * route: at random jets (x, x', x'', ...) a row's residual A v - alpha equals the equation. */
#include <math.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "equations.h"
#include "error.h"
#include "form.h"
#include "mem.h"
#include "parse.h"

struct problem {
    struct expr_store st;
    struct form_equations f;
    struct sys_system s;
    expr_id equation[8];
    int equations;
};

/* Variables and equations are 0-terminated lists separated by ';'. */
static bool read(struct problem *p, const char *variables, const char *equations, struct sga_error *err)
{
    char copy[512], *save = NULL;
    expr_store_init(&p->st);
    form_equations_init(&p->f, &p->st);
    sys_init(&p->s, &p->st);
    p->equations = 0;
    p->s.time = p->st.node[expr_symbol_add(&p->st, "t", EXPR_TIME)].a;
    snprintf(copy, sizeof copy, "%s", variables);
    for (char *w = strtok_r(copy, ";", &save); w; w = strtok_r(NULL, ";", &save))
        form_equations_unknown(&p->f, p->st.node[expr_symbol_add(&p->st, w, EXPR_VARIABLE)].a);
    struct expr_grammar g = { .derivative = form_equations_derivative, .total = form_equations_total, .ctx = &p->f };
    snprintf(copy, sizeof copy, "%s", equations);
    for (char *w = strtok_r(copy, ";", &save); w; w = strtok_r(NULL, ";", &save)) {
        expr_id e = expr_parse_equation(&p->st, w, &g, err);
        if (!e)
            return false;
        p->equation[p->equations++] = e;
        form_equations_add(&p->f, e);
    }
    return form_equations_reduce(&p->f, &p->s, 1000, err);
}

static void done(struct problem *p)
{
    form_equations_clear(&p->f);
    sys_clear(&p->s);
    expr_store_clear(&p->st);
}

/* Values of all nodes where symbols have values; enough operators for these tests. */
static double *values(const struct expr_store *st, const double *symbol)
{
    double *v = sga_calloc((size_t)st->nodes, sizeof *v);
    for (int i = 1; i < st->nodes; i++) {
        const struct expr_node *n = st->node + i;
        double a = n->a >= 0 && n->a < i ? v[n->a] : 0, b = n->b >= 0 && n->b < i ? v[n->b] : 0;
        switch (n->op) {
        case EXPR_CONST: v[i] = fmpz_get_d(fmpq_numref(st->constant + n->a)) / fmpz_get_d(fmpq_denref(st->constant + n->a)); break;
        case EXPR_SYM:   v[i] = symbol[n->a]; break;
        case EXPR_ADD:   v[i] = a + b; break;
        case EXPR_SUB:   v[i] = a - b; break;
        case EXPR_MUL:   v[i] = a * b; break;
        case EXPR_DIV:   v[i] = a / b; break;
        case EXPR_NEG:   v[i] = -a; break;
        case EXPR_POWI:  v[i] = pow(a, n->b); break;
        case EXPR_SIN:   v[i] = sin(a); break;
        case EXPR_COS:   v[i] = cos(a); break;
        case EXPR_EXP:   v[i] = exp(a); break;
        case EXPR_SIGN:  v[i] = (a > 0) - (a < 0); break;
        default:         v[i] = NAN; break;
        }
    }
    return v;
}

static double random_value(unsigned long *seed)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(*seed >> 40) / (double)(1 << 24) + 0.2;
}

/* Symbol of the derivative of a state variable: one more quote. */
static int prime_of(const struct expr_store *st, int symbol)
{
    char name[200];
    snprintf(name, sizeof name, "%s'", st->symbol[symbol].name);
    return expr_symbol_find(st, name, strlen(name));
}

/* Row i (of equation i) at a random jet: A v - alpha = F; definitions hold by themselves. */
static void identity(struct problem *p, const char *what, unsigned long *seed)
{
    double *symbol = sga_calloc((size_t)p->st.symbols, sizeof *symbol);
    for (int i = 0; i < p->st.symbols; i++)
        symbol[i] = random_value(seed);
    double *v = values(&p->st, symbol);
    for (int i = 0; i < p->s.rows; i++) {
        const struct sys_row *r = p->s.row + i;
        double sum = -v[r->alpha];
        for (int k = 0; k < r->entries; k++) {
            int velocity = prime_of(&p->st, p->s.variable[r->entry[k].col].symbol);
            sum += v[r->entry[k].value] * (velocity < 0 ? NAN : symbol[velocity]);
        }
        double expect = i < p->equations ? v[p->equation[i]] : 0;
        CHECK(fabs(sum - expect) < 1e-11, "%s, row %d: %g %g", what, i, sum, expect);
    }
    free(v);
    free(symbol);
}

/* "x,y,x' | equations[0]: 0 1; definition of x': 0": variables, then each row's columns. */
static char *shape(const struct problem *p)
{
    struct sga_buf b = { 0 };
    for (int j = 0; j < p->s.variables; j++)
        sga_buf_printf(&b, "%s%s", j ? "," : "", p->st.symbol[p->s.variable[j].symbol].name);
    for (int i = 0; i < p->s.rows; i++) {
        sga_buf_printf(&b, "%s%s:", i ? "; " : " | ", p->s.row[i].source);
        for (int k = 0; k < p->s.row[i].entries; k++)
            sga_buf_printf(&b, " %d", p->s.row[i].entry[k].col);
    }
    return sga_buf_take(&b);
}

static const struct {
    const char *variables, *equations, *shape;
    bool square;
} table[] = {
    { "x;y;lam", "x'' = -lam*x; y'' = -lam*y - 9.81; x^2 + y^2 = 1",
      "x,y,lam,x',y' | equations[0]: 3; equations[1]: 4; equations[2]:; definition of x': 0; definition of y': 1", true },
    { "x", "(x')^2 + x^2 = 1", "x,x' | equations[0]:; definition of x': 0", true },
    { "x", "x = t*x' + x'^2", "x,x' | equations[0]:; definition of x': 0", true },
    { "x;y", "x'*y' = 1; x' + y = t", "x,y,x',y' | equations[0]:; equations[1]:; definition of x': 0; definition of y': 1", true },
    { "x;y", "x'^2*y' = x; y' = x'", "x,y,x' | equations[0]: 1; equations[1]: 1; definition of x': 0", true },
    { "x;y", "x' = y; y'*x + x'*y = sin(t)", "x,y | equations[0]: 0; equations[1]: 0 1", true },
    { "x;y", "x''' + y' = x'*y; y'*x'' = 1",
      "x,y,x',x'' | equations[0]: 1 3; equations[1]: 1; definition of x': 0; definition of x'': 2", true },
    { "x;y", "x^2 + y^2 = 1", "x,y | equations[0]:", false },
    { "x;y", "x = 1; x' = y; 2*x' = 2*y", "x,y | equations[0]:; equations[1]: 0; equations[2]: 0", false },
    { "x;u", "sin(x'') = u; x' + u = 0", "x,u,x',x'' | equations[0]:; equations[1]:; definition of x': 0; definition of x'': 2", true },
    { "x", "sign(x') = x", "x,x' | equations[0]:; definition of x': 0", true },
    { "x", "x'' - x'' + x' = x", "x | equations[0]: 0", true },
    { "x;y", "exp(y)*x' + x*y' - t = y*x' + x'", "x,y | equations[0]: 0 1", false },
    { "x", "x'*x/x' + x' = 1", "x,x' | equations[0]:; definition of x': 0", true },
};

static void reductions(void)
{
    unsigned long seed = check_seed(31);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct problem p;
        struct sga_error err = { 0 };
        bool ok = read(&p, table[i].variables, table[i].equations, &err);
        char *got = shape(&p);
        CHECK(ok && strcmp(got, table[i].shape) == 0, "%s\n  %s\n  %s", table[i].equations, got, err.detail);
        CHECK(p.s.square == table[i].square, "%s", table[i].equations);
        for (int k = 0; ok && k < 3; k++)
            identity(&p, table[i].equations, &seed);
        for (int j = 0; j < p.s.variables; j++) {
            const struct expr_symbol *v = p.st.symbol + p.s.variable[j].symbol;
            CHECK(v->kind == EXPR_VARIABLE
                      && strcmp(p.s.variable[j].role, strchr(v->name, '\'') ? "derivative" : "variable") == 0, "%s", v->name);
        }
        free(got);
        done(&p);
    }
}

static void limits(void)
{
    struct problem p;
    struct sga_error err = { 0 };
    expr_store_init(&p.st);
    form_equations_init(&p.f, &p.st);
    sys_init(&p.s, &p.st);
    form_equations_unknown(&p.f, p.st.node[expr_symbol_add(&p.st, "x", EXPR_VARIABLE)].a);
    struct expr_grammar g = { .derivative = form_equations_derivative, .ctx = &p.f };
    form_equations_add(&p.f, expr_parse_equation(&p.st, "der(x, 20) = 0", &g, &err));
    CHECK(!form_equations_reduce(&p.f, &p.s, 19, &err) && err.code == SGA_E_LIMIT_VARIABLES && strstr(err.detail, "19"),
          "%s", err.detail);
    struct sga_error none = { 0 };
    CHECK(!expr_parse(&p.st, "der(x, 65)", &g, &none) && none.code == SGA_E_EXPR_DERIVATIVE, "%s", none.detail);
    struct sga_error time = { 0 };
    expr_symbol_add(&p.st, "t", EXPR_TIME);
    CHECK(!expr_parse(&p.st, "t'", &g, &time) && time.code == SGA_E_EXPR_DERIVATIVE, "%s", time.detail);
    done(&p);
}

/* der of an expression against the chain rule written out, at random jets. */
static void totals(void)
{
    static const char *const pair[][2] = {
        { "der(x*y)", "x'*y + x*y'" }, { "der(x^2, 2)", "2*x'^2 + 2*x*x''" }, { "der(t*x)", "x + t*x'" },
        { "der(x' + sin(t))", "x'' + cos(t)" }, { "der(2)", "0" }, { "der(t)", "1" }, { "der(der(x)*y)", "x''*y + x'*y'" },
        { "der(sin(x)*exp(y), 1)", "cos(x)*x'*exp(y) + sin(x)*exp(y)*y'" }, { "der((x))", "x'" }, { "2*der(-x')^2", "2*x''^2" },
        { "der(x/y, 2)", "x''/y - 2*x'*y'/y^2 - x*y''/y^2 + 2*x*y'^2/y^3" }, { "der(der(x*y))", "x''*y + 2*x'*y' + x*y''" },
    };
    static const char *const wrong[] = { "der(x*y, 0)", "der(x*y, 1/2)", "der(x*y, x)", "der(x*y, 1, 2)", "der(x*y, 65)", "der()",
                                         "der(x*y", "der(x + der(x, 64))" };
    unsigned long seed = check_seed(41);
    for (size_t i = 0; i < sizeof pair / sizeof *pair; i++) {
        struct problem p;
        struct sga_error err = { 0 };
        char text[200];
        snprintf(text, sizeof text, "%s = %s", pair[i][0], pair[i][1]);
        read(&p, "x;y", text, &err);
        CHECK(p.equations == 1, "%s: %s", text, err.detail);
        double *symbol = sga_calloc((size_t)p.st.symbols, sizeof *symbol);
        for (int k = 0; k < p.st.symbols; k++)
            symbol[k] = random_value(&seed);
        double *v = values(&p.st, symbol);
        CHECK(p.equations && fabs(v[p.equation[0]]) < 1e-11, "%s: %g", text, v[p.equation[0]]);
        free(v);
        free(symbol);
        done(&p);
    }
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        struct problem p;
        struct sga_error err = { 0 };
        char text[200];
        snprintf(text, sizeof text, "%s = 0", wrong[i]);
        CHECK(!read(&p, "x;y", text, &err) && err.code != SGA_E_OK && err.line == 1, "%s: %s", text, err.detail);
        done(&p);
    }
}

int main(void)
{
    reductions();
    totals();
    limits();
    return CHECK_END();
}
