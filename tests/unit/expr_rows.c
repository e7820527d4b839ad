/* Matrices by compressed rows against the same ones by all entries, and linear solves whose entries come to nothing. */
#include "check.h"
#include "expr.h"
#include "expr_rows.h"

enum { MOST = 9, ZERO = 7 };

static unsigned long state;

static int below(int n)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (int)((state >> 33) % (unsigned long)n);
}

static bool holds(const struct expr_rows *a, int rows, int cols, const expr_id *dense, bool across)
{
    bool ok = a->start[0] == 0;
    for (int i = 0; i < rows; i++) {
        for (int k = a->start[i]; k < a->start[i + 1]; k++)
            ok &= k == a->start[i] || a->column[k] > a->column[k - 1];
        for (int j = 0; j < cols; j++) {
            expr_id e = across ? dense[j * rows + i] : dense[i * cols + j];
            ok &= expr_rows_at(a, i, j) == (e == ZERO ? EXPR_UNDEF : e);
        }
    }
    return ok;
}

static void random_matrix(void)
{
    expr_id dense[MOST * MOST];
    int rows = 1 + below(MOST), cols = 1 + below(MOST), part = 1 + below(5);
    for (int k = 0; k < rows * cols; k++)
        dense[k] = below(part) ? ZERO : 10 + below(1000);
    struct expr_rows a = expr_rows_of(rows, cols, dense, ZERO), t = expr_rows_transposed(&a, rows, cols);
    CHECK(holds(&a, rows, cols, dense, false));
    CHECK(holds(&t, cols, rows, dense, true));
    struct expr_rows same = expr_rows_copy(&a, rows, ZERO);
    CHECK(expr_rows_same(&a, &same, rows));
    for (int i = 0; i < rows; i++)             /* each row the other way round, then sorted */
        for (int k = same.start[i], q = same.start[i + 1] - 1; k < q; k++, q--) {
            int column = same.column[k];
            expr_id entry = same.entry[k];
            same.column[k] = same.column[q], same.entry[k] = same.entry[q];
            same.column[q] = column, same.entry[q] = entry;
        }
    expr_rows_sort(&same, rows, cols);
    CHECK(expr_rows_same(&a, &same, rows));
    int last = a.start[rows] - 1;
    if (last >= 0) {
        same.entry[last] = ZERO;
        CHECK(!expr_rows_same(&a, &same, rows));
        struct expr_rows less = expr_rows_copy(&same, rows, ZERO);
        CHECK(less.start[rows] == last);
        expr_rows_clear(&less);
    }
    expr_rows_clear(&a);
    expr_rows_clear(&t);
    expr_rows_clear(&same);
}

/* S = [x 1; y 2] with y = 0 put in: an entry less, the rest as it was; children are what is left. */
static void solves(void)
{
    struct expr_store st;
    expr_store_init(&st);
    expr_id x = expr_symbol_add(&st, "x", EXPR_VARIABLE), y = expr_symbol_add(&st, "y", EXPR_VARIABLE);
    expr_id S[4] = { x, expr_int(&st, 1), y, expr_int(&st, 2) }, r[2] = { expr_int(&st, 3), x };
    expr_id u[2] = { expr_solution(&st, expr_solve_add(&st, 2, S, r), 0), EXPR_UNDEF };
    u[1] = expr_solution(&st, st.node[u[0]].a, 1);
    CHECK(expr_children(&st, u[0]) == 6);
    expr_id map[2] = { EXPR_UNDEF, expr_int(&st, 0) };
    expr_substitute(&st, u, 2, map);
    CHECK(expr_op_of(&st, u[0]) == EXPR_SOLVE && st.node[u[0]].a == st.node[u[1]].a, "components of one solve stay together");
    const struct expr_solve *s = st.solve + st.node[u[0]].a;
    CHECK(s->matrix.start[2] == 3 && expr_rows_at(&s->matrix, 1, 0) == EXPR_UNDEF && expr_rows_at(&s->matrix, 1, 1) == S[3]);
    CHECK(expr_children(&st, u[0]) == 5);
    expr_store_clear(&st);
}

int main(void)
{
    state = check_seed(20261130);
    for (int k = check_scale(500); k > 0; k--)
        random_matrix();
    solves();
    return CHECK_END();
}
