/* Constant matrices and control systems: against the matrices, by differentiation. */
#include "check.h"
#include "derive.h"
#include "form.h"

enum { N = 4, M = 3, ROWS = 4 };

static unsigned next(unsigned long *seed, unsigned n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(*seed >> 33) % n;
}

struct matrix {
    long value[5][5];
    struct form_entry entry[50];
    struct form_matrix view;
};

/* Some places get two entries. */
static void fill(struct matrix *m, struct expr_store *st, unsigned long *seed, int rows, int cols)
{
    *m = (struct matrix){ .view = { .rows = rows, .cols = cols, .entries = (size_t)(rows * cols) } };
    for (int k = 0; k < rows * cols; k++) {
        int i = (int)next(seed, (unsigned)rows), j = (int)next(seed, (unsigned)cols);
        long v = (long)next(seed, 9) - 4;
        m->value[i][j] += v;
        m->entry[k] = (struct form_entry){ i, j, expr_int(st, v) };
    }
}

static long entry_of(const struct sys_system *s, int row, int col)
{
    const struct sys_row *r = s->row + row;
    for (int k = 0; k < r->entries; k++)
        if (r->entry[k].col == col)
            return fmpz_get_si(fmpq_numref(expr_const_value(s->store, r->entry[k].value)));
    return 0;
}

static void names(struct expr_store *st, char letter, int n, int *symbol)
{
    for (int i = 0; i < n; i++) {
        char name[] = { letter, (char)('0' + i), 0 };
        symbol[i] = st->node[expr_symbol_add(st, name, EXPR_VARIABLE)].a;
    }
}

static void linear(unsigned long *seed, bool feedback)
{
    struct expr_store st;
    struct sys_system s;
    struct matrix A, B, C, D;
    int x[N], w[M];
    expr_id u[M];
    expr_store_init(&st);
    sys_init(&s, &st);
    names(&st, 'x', N, x);
    names(&st, 'u', M, w);
    fill(&A, &st, seed, ROWS, N);
    fill(&B, &st, seed, ROWS, N);
    fill(&C, &st, seed, ROWS, M);
    fill(&D, &st, seed, M, N);
    A.view.entry = A.entry;
    B.view.entry = B.entry;
    C.view.entry = C.entry;
    D.view.entry = D.entry;
    for (int j = 0; j < M; j++)
        u[j] = st.symbol[w[j]].node;
    struct form_linear in = { .variable = x, .variables = N, .A = A.view, .B = B.view, .C = C.view, .u = u,
                              .input = w, .inputs = feedback ? 0 : M };
    if (feedback)
        in.D = D.view;
    form_linear(&s, &in);
    CHECK(s.variables == (feedback ? N : N + M) && s.rows == ROWS && s.square == feedback, "sizes");
    int good = 0;
    for (int i = 0; i < ROWS; i++) {
        for (int j = 0; j < N; j++) {
            long want = A.value[i][j];
            for (int k = 0; k < M && feedback; k++)
                want -= C.value[i][k] * D.value[k][j];
            good += entry_of(&s, i, j) == want;
            good += expr_is_int(&st, expr_diff(&st, s.row[i].alpha, x[j]), B.value[i][j]);
        }
        for (int k = 0; k < M; k++)
            good += expr_is_int(&st, expr_diff(&st, s.row[i].alpha, w[k]), feedback ? 0 : C.value[i][k]);
    }
    CHECK(good == ROWS * (2 * N + M), "%d of %d entries, feedback %d", good, ROWS * (2 * N + M), feedback);
    sys_clear(&s);
    expr_store_clear(&st);
}

static void control(unsigned long *seed)
{
    struct expr_store st;
    struct sys_system s;
    struct matrix G;
    int x[N], u[M];
    expr_id F[N], constraint[M];
    expr_store_init(&st);
    sys_init(&s, &st);
    names(&st, 'x', N, x);
    names(&st, 'u', M, u);
    fill(&G, &st, seed, M, N);
    G.view.entry = G.entry;
    for (int i = 0; i < N; i++)
        F[i] = expr_powi(&st, st.symbol[x[i]].node, 2 + i);
    for (int i = 0; i < M; i++)
        constraint[i] = st.symbol[x[i]].node;
    int constraints = 1 + (int)next(seed, M);
    struct form_control in = { .variable = x, .variables = N, .input = u, .inputs = M, .F = F, .G = G.view,
                               .constraint = constraint, .constraints = constraints };
    form_control(&s, &in);
    CHECK(s.variables == N + M && s.rows == N + constraints && s.square == (constraints == M), "sizes");
    int good = 0;
    for (int i = 0; i < N; i++) {
        good += s.row[i].entries == 1 && entry_of(&s, i, i) == 1;
        good += expr_diff(&st, s.row[i].alpha, x[i]) == expr_diff(&st, F[i], x[i]);
        for (int k = 0; k < M; k++)
            good += expr_is_int(&st, expr_diff(&st, s.row[i].alpha, u[k]), G.value[k][i]);
    }
    for (int i = 0; i < constraints; i++)
        good += s.row[N + i].entries == 0 && s.row[N + i].alpha == constraint[i];
    CHECK(good == N * (2 + M) + constraints, "%d", good);
    sys_clear(&s);
    expr_store_clear(&st);
}

int main(void)
{
    unsigned long seed = check_seed(31);
    for (int i = 0; i < check_scale(50); i++) {
        linear(&seed, i % 2);
        control(&seed);
    }
    return CHECK_END();
}
