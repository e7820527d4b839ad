/* Named subexpressions: read back in order, they give the roots again. */
#include <math.h>
#include <string.h>

#include "buf.h"
#include "check.h"
#include "error.h"
#include "expr_rows.h"
#include "parse.h"
#include "print.h"

static struct expr_store st;
static unsigned long state;

static unsigned next(unsigned n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(state >> 33) % n;
}

/* Values by a loop over the store; SOLVE by elimination with the largest pivot. */
static void solve(const struct expr_solve *s, const double *v, double *y)
{
    int m = s->m;
    double a[8][9];
    for (int i = 0; i < m; i++) {
        for (int j = 0; j < m; j++)
            a[i][j] = expr_rows_at(&s->matrix, i, j) ? v[expr_rows_at(&s->matrix, i, j)] : 0;
        a[i][m] = v[s->rhs[i]];
    }
    for (int k = 0; k < m; k++) {
        int p = k;
        for (int i = k; i < m; i++)
            p = fabs(a[i][k]) > fabs(a[p][k]) ? i : p;
        for (int j = 0; j <= m; j++) {
            double t = a[k][j];
            a[k][j] = a[p][j];
            a[p][j] = t;
        }
        for (int i = 0; i < m; i++)
            for (int j = m; i != k && j >= k; j--)
                a[i][j] -= a[i][k] / a[k][k] * a[k][j];
    }
    for (int k = 0; k < m; k++)
        y[k] = a[k][m] / a[k][k];
}

static double *values(const double *at)
{
    double *v = calloc((size_t)st.nodes, sizeof *v);
    for (expr_id i = 1; i < st.nodes; i++) {
        const struct expr_node n = st.node[i];
        switch ((enum expr_op)n.op) {
        case EXPR_CONST: v[i] = fmpq_get_d(st.constant + n.a); break;
        case EXPR_SYM: v[i] = at[n.a]; break;
        case EXPR_ADD: v[i] = v[n.a] + v[n.b]; break;
        case EXPR_SUB: v[i] = v[n.a] - v[n.b]; break;
        case EXPR_MUL: v[i] = v[n.a] * v[n.b]; break;
        case EXPR_DIV: v[i] = v[n.a] / v[n.b]; break;
        case EXPR_NEG: v[i] = -v[n.a]; break;
        case EXPR_POWI: v[i] = pow(v[n.a], n.b); break;
        case EXPR_SIN: v[i] = sin(v[n.a]); break;
        case EXPR_SOLVE: {
            double y[8];
            solve(st.solve + n.a, v, y);
            v[i] = y[n.b];
            break;
        }
        default: v[i] = NAN; break;
        }
    }
    return v;
}

/* Reads the definitions in order, each name a node, then the roots; compares values. */
static void check_names(const struct expr_names *names, const expr_id *roots, int nroots)
{
    struct sga_error err = { 0 };
    expr_id value[200] = { 0 };
    int before = st.symbols;
    for (int i = 0; i < names->count; i++) {
        struct expr_grammar g = { .value = value, .values = st.symbols };
        expr_id e = expr_parse(&st, names->text[i], &g, &err);
        CHECK(e, "%s = %s: %s", names->name[i], names->text[i], err.detail);
        CHECK(expr_symbol_find(&st, names->name[i], strlen(names->name[i])) < 0, "%s is new", names->name[i]);
        expr_symbol_add(&st, names->name[i], EXPR_VARIABLE);
        value[st.symbols - 1] = e;
    }
    double at[200];
    for (int i = 0; i < 200; i++)
        at[i] = 0.4 + 0.13 * next(9);
    CHECK(names->roots == nroots, "%d", names->roots);
    expr_id back[10];
    for (int i = 0; i < nroots; i++) {
        struct expr_grammar g = { .value = value, .values = st.symbols };
        back[i] = expr_parse(&st, names->root[i], &g, &err);
        CHECK(back[i], "%s: %s", names->root[i], err.detail);
    }
    double *v = values(at);
    for (int i = 0; i < nroots; i++)
        CHECK(fabs(v[back[i]] - v[roots[i]]) <= 1e-8 * (1 + fabs(v[roots[i]])), "root %d: %.12g %.12g", i, v[back[i]], v[roots[i]]);
    free(v);
    CHECK(st.symbols == before + names->count, "symbols");
}

static expr_id add(const char *name) { return expr_symbol_add(&st, name, EXPR_VARIABLE); }

static void start(void)
{
    expr_store_init(&st);
    add("x");
    add("y");
    add("s2");       /* taken: the names must step over it */
    add("s01");
}

static void shared(void)
{
    start();
    expr_id x = st.symbol[0].node, y = st.symbol[1].node, e = x;
    for (int i = 0; i < 30; i++)       /* as a tree far beyond any memory */
        e = expr_add(&st, expr_fun(&st, EXPR_SIN, expr_mul(&st, e, e)), expr_mul(&st, expr_sub(&st, e, y), expr_rational(&st, 1, 3)));
    expr_id roots[] = { e, expr_mul(&st, e, y), x };
    struct expr_names names;
    struct expr_naming how = { .inline_nodes = 3 };
    CHECK(expr_print_named(&st, roots, 3, &how, &names), "printed");
    CHECK(names.count > 20 && strcmp(names.name[0], "s1") == 0 && strcmp(names.name[1], "s3") == 0, "%d", names.count);
    CHECK(strcmp(names.root[0], names.name[names.count - 1]) == 0 && strcmp(names.root[2], "x") == 0, "%s", names.root[0]);
    check_names(&names, roots, 3);
    expr_names_clear(&names);
    how.max_bytes = 100;
    CHECK(!expr_print_named(&st, roots, 3, &how, &names) && names.count == 0 && names.root == NULL, "budget");
    expr_store_clear(&st);
}

static void solves(void)
{
    for (int trial = 0; trial < check_scale(20); trial++) {
        start();
        int m = 1 + (int)next(4);
        expr_id matrix[16], rhs[4], x = st.symbol[0].node, y = st.symbol[1].node;
        for (int i = 0; i < m * m; i++)
            matrix[i] = i % (m + 1) == 0 ? expr_add(&st, expr_int(&st, 5 + next(4)), expr_mul(&st, x, y))
                : next(2) ? expr_int(&st, 0) : expr_sub(&st, expr_int(&st, next(3)), next(2) ? x : y);
        for (int i = 0; i < m; i++)
            rhs[i] = expr_add(&st, x, expr_int(&st, next(5)));
        int s = expr_solve_add(&st, m, matrix, rhs);
        expr_id roots[] = { expr_solution(&st, s, 0), expr_mul(&st, expr_solution(&st, s, m - 1), y), expr_int(&st, 0) };
        int second = expr_solve_add(&st, 1, &roots[0], &roots[1]);    /* a solve on top of a solve */
        roots[2] = expr_solution(&st, second, 0);
        struct sga_buf text = { 0 };
        CHECK(!expr_print(&st, roots[0], 0, &text), "a SOLVE has no plain text");
        sga_buf_free(&text);
        struct expr_names names;
        CHECK(expr_print_named(&st, roots, 3, NULL, &names), "trial %d", trial);
        check_names(&names, roots, 3);
        expr_names_clear(&names);
        expr_store_clear(&st);
    }
    start();
    expr_id zero[] = { expr_int(&st, 0), expr_int(&st, 0), st.symbol[0].node, expr_int(&st, 1) };
    expr_id root = expr_solution(&st, expr_solve_add(&st, 2, zero, zero), 0);
    struct expr_names names;
    CHECK(!expr_print_named(&st, &root, 1, NULL, &names) && expr_store_ok(&st), "singular by structure");
    expr_id big[] = { st.symbol[0].node, st.symbol[1].node, st.symbol[1].node, st.symbol[0].node };
    root = expr_solution(&st, expr_solve_add(&st, 2, big, big), 0);
    st.max_nodes = st.nodes + 2;
    CHECK(!expr_print_named(&st, &root, 1, NULL, &names) && expr_store_ok(&st), "no room for the steps");
    expr_store_clear(&st);
}

int main(void)
{
    state = check_seed(5);
    shared();
    solves();
    flint_cleanup();
    return CHECK_END();
}
