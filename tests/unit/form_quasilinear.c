/* Dense, sparse order, transposed: against the matrix itself. */
#include <string.h>

#include "check.h"
#include "form.h"

static unsigned next(unsigned long *seed, unsigned n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(*seed >> 33) % n;
}

static void one(unsigned long *seed, bool transpose)
{
    enum { MOST = 5 };
    struct expr_store st;
    struct sys_system s;
    int rows = 1 + (int)next(seed, MOST), cols = 1 + (int)next(seed, MOST), n = 0;
    long a[MOST][MOST] = { { 0 } };
    int variable[MOST];
    struct form_entry entry[60];
    expr_id alpha[MOST], restriction[1];
    expr_store_init(&st);
    sys_init(&s, &st);
    for (int i = 0; i < MOST; i++) {
        char name[] = { 'x', (char)('0' + i), 0 };
        variable[i] = st.node[expr_symbol_add(&st, name, EXPR_VARIABLE)].a;
        alpha[i] = expr_int(&st, 100 + i);
    }
    for (; n < 20; n++) {
        entry[n] = (struct form_entry){ (int)next(seed, (unsigned)rows), (int)next(seed, (unsigned)cols), 0 };
        long v = (long)next(seed, 7) - 3;
        entry[n].value = expr_int(&st, v);
        a[entry[n].row][entry[n].col] += v;
    }
    restriction[0] = alpha[0];
    struct form_quasilinear q = { .variable = variable, .variables = transpose ? rows : cols, .rows = rows, .cols = cols,
                                  .entry = entry, .entries = (size_t)n, .alpha = alpha, .restriction = restriction,
                                  .restrictions = (int)next(seed, 2), .transpose = transpose };
    form_quasilinear(&s, &q);
    CHECK(s.rows == (transpose ? cols : rows) && s.variables == q.variables && s.restrictions == q.restrictions, "sizes");
    CHECK(s.square == (rows == cols && !q.restrictions), "square");
    int good = 0;
    for (int i = 0; i < s.rows; i++)
        for (int j = 0; j < s.variables; j++) {
            long want = transpose ? a[j][i] : a[i][j];
            const struct sys_row *r = s.row + i;
            int k = 0;
            while (k < r->entries && r->entry[k].col != j)
                k++;
            good += k < r->entries ? expr_is_int(&st, r->entry[k].value, want) : want == 0;
        }
    CHECK(good == s.rows * s.variables, "entries of %d x %d, transpose %d", rows, cols, transpose);
    CHECK(s.row[s.rows - 1].alpha == alpha[s.rows - 1] && strncmp(s.row[0].source, "row 0", 6) == 0, "rows");
    sys_clear(&s);
    expr_store_clear(&st);
}

int main(void)
{
    unsigned long seed = check_seed(9);
    for (int i = 0; i < check_scale(100); i++)
        one(&seed, i % 2);
    return CHECK_END();
}
