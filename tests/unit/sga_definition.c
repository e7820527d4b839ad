/* Which variables equations define, by shape alone: chains, loops, and what only looks like a definition. */
#include "definition.h"

#include <string.h>

#include "check.h"
#include "error.h"
#include "facts.h"
#include "parse.h"
#include "system.h"

static expr_id parsed(struct expr_store *st, const char *text)
{
    struct sga_error err = { 0 };
    expr_id e = expr_parse(st, text, NULL, &err);
    CHECK(e != EXPR_UNDEF, "%s", text);
    return e;
}

/* x' = ..., and equations without derivatives in x, u, y, z: whether these variables are defined. */
static bool defined(const char *const *equation, int equations, const char *expected)
{
    static const char *const name[] = { "x", "u", "y", "z" };
    struct expr_store st;
    struct sys_system sys;
    struct definitions d;
    char found[8] = "";
    expr_store_init(&st);
    sys_init(&sys, &st);
    for (int j = 0; j < 4; j++) {
        expr_id v = expr_symbol_add(&st, name[j], EXPR_VARIABLE);
        sys_add_variable(&sys, st.node[v].a, "variable");
    }
    sys_add_row(&sys, parsed(&st, "1 - x*y"), "row 0");
    sys_add_entry(&sys, 0, 0, expr_int(&st, 1));
    for (int i = 0; i < equations; i++)
        sys_add_row(&sys, parsed(&st, equation[i]), "row");
    definitions_find(&d, &sys, DEFINITIONS_KINKED, NULL);
    for (int j = 0; j < 4; j++)
        for (int i = 0; i < d.count; i++)
            if (d.at[i].variable == j)
                strcat(found, name[j]);
    bool ok = strcmp(found, expected) == 0;
    if (!ok)
        printf("# %s: %s are defined, not %s\n", equation[0], found, expected);
    if (d.count) {       /* what is left has none of them */
        struct sys_system left;
        struct expr_cone cone;
        expr_cone_init(&cone);
        definitions_put_in(&d, &sys, &left);
        ok &= left.variables == 4 - d.count && left.rows == sys.rows - d.count;
        for (int i = 0; i < left.rows; i++) {
            expr_cone_of(&st, &cone, &left.row[i].alpha, 1);
            for (int k = 0; k < cone.count; k++)
                for (int q = 0; q < d.count; q++)
                    ok &= cone.list[k] != st.symbol[sys.variable[d.at[q].variable].symbol].node;
        }
        expr_cone_clear(&cone);
        sys_clear(&left);
    }
    definitions_clear(&d);
    sys_clear(&sys);
    expr_store_clear(&st);
    return ok;
}

int main(void)
{
    CHECK(defined((const char *const[]){ "u - x", "y - max(0, u)" }, 2, "y"), "shape");
    CHECK(defined((const char *const[]){ "y - u", "3*u - abs(x)/2" }, 2, "uy"), "shape");
    CHECK(defined((const char *const[]){ "z - min(y, 1)", "y - max(u, -1)", "u - 2*x" }, 3, "yz"), "shape");
    CHECK(defined((const char *const[]){ "u + max(0, u) - x" }, 1, "u"), "shape");              /* rises throughout */
    CHECK(defined((const char *const[]){ "u - 2*max(0, u) - x" }, 1, ""), "shape");             /* turns back */
    CHECK(defined((const char *const[]){ "u + max(0, u) + max(1, u) - x" }, 1, ""), "shape");   /* turns at two places */
    CHECK(defined((const char *const[]){ "(u - abs(x))*(2 + sin(u))" }, 1, "u"), "shape");      /* a factor that is nowhere 0 */
    CHECK(defined((const char *const[]){ "(u - abs(x))*sin(u)" }, 1, ""), "shape");
    CHECK(defined((const char *const[]){ "u - sign(u) - sign(x)" }, 1, ""), "shape");           /* whose derivative is 1 */
    CHECK(defined((const char *const[]){ "u - max(0, x - y)", "y - max(0, u)" }, 2, "u"), "shape");      /* a loop through both */
    CHECK(defined((const char *const[]){ "u*y - abs(x)" }, 1, ""), "shape");                    /* no number */
    CHECK(defined((const char *const[]){ "u - sqrt(x^2 + 1)" }, 1, ""), "shape");               /* smooth */
    CHECK(defined((const char *const[]){ "u - sqrt(x)" }, 1, "u"), "shape");
    CHECK(defined((const char *const[]){ "y - u - abs(x)", "sin(u) - x/2" }, 2, "y"), "shape");   /* u is in another equation */
    return CHECK_END();
}
