/* The sparse system: entries in order, sums, zeros dropped; against a dense matrix. */
#include "check.h"
#include "system.h"

static unsigned next(unsigned long *seed, unsigned n)
{
    *seed = *seed * 6364136223846793005ul + 1442695040888963407ul;
    return (unsigned)(*seed >> 33) % n;
}

static void random_entries(void)
{
    enum { ROWS = 7, COLS = 9 };
    unsigned long seed = check_seed(5);
    for (int round = 0; round < check_scale(50); round++) {
        struct expr_store st;
        struct sys_system s;
        long dense[ROWS][COLS] = { { 0 } };
        expr_store_init(&st);
        sys_init(&s, &st);
        for (int j = 0; j < COLS; j++) {
            char name[8];
            snprintf(name, sizeof name, "x%d", j);
            sys_add_variable(&s, st.node[expr_symbol_add(&st, name, EXPR_VARIABLE)].a, "variable");
        }
        for (int i = 0; i < ROWS; i++)
            CHECK(sys_add_row(&s, expr_int(&st, i), "row") == i, "rows count");
        for (int k = 0; k < 150; k++) {
            int i = (int)next(&seed, ROWS), j = (int)next(&seed, COLS), v = (int)next(&seed, 3) - 1;
            dense[i][j] += v;
            sys_add_entry(&s, i, j, expr_int(&st, v));
        }
        int good = 0, all = 0, stored = 0;
        for (int i = 0; i < ROWS; i++) {
            int k = 0;
            for (int j = 0; j < COLS; j++) {
                const struct sys_row *r = s.row + i;
                bool here = k < r->entries && r->entry[k].col == j;
                good += here ? expr_is_int(&st, r->entry[k].value, dense[i][j]) && dense[i][j] : dense[i][j] == 0;
                k += here;
                all++;
            }
            stored += k == s.row[i].entries;
        }
        CHECK(good == all && stored == ROWS, "%d of %d entries", good, all);
        sys_clear(&s);
        expr_store_clear(&st);
    }
}

static void lists(void)
{
    struct expr_store st;
    struct sys_system s;
    int symbol[40];
    expr_store_init(&st);
    sys_init(&s, &st);
    for (int i = 0; i < 40; i++) {
        sys_add_restriction(&s, expr_int(&st, i));
        char name[16];
        snprintf(name, sizeof name, "p%d", i);
        expr_id e = expr_symbol_add(&st, name, EXPR_PARAMETER);
        symbol[i] = st.node[e].a;
        sys_add_parameter(&s, symbol[i]);
    }
    bool kept = s.restrictions == 40 && s.parameters == 40;
    for (int i = 0; i < 40; i++)
        kept = kept && expr_is_int(&st, s.restriction[i], i) && s.parameter[i] == symbol[i];
    CHECK(kept, "lists keep what they get");
    char source[] = "row 3";
    sys_add_row(&s, expr_int(&st, 1), source);
    source[0] = 'X';
    CHECK(s.row[0].source[0] == 'r', "the source is copied");
    sys_clear(&s);
    CHECK(s.rows == 0 && s.variables == 0 && !s.row, "cleared");
    expr_store_clear(&st);
}

int main(void)
{
    random_entries();
    lists();
    return CHECK_END();
}
