/* What variables are to a start: by roles, by rows x' = v, by columns that no row has; and the order of names. */
#include <string.h>

#include "check.h"
#include "expr.h"
#include "kinds.h"
#include "system.h"

struct one {
    struct expr_store st;
    struct sys_system s;
    expr_id v[8];
    int n;
};

static void begin(struct one *o)
{
    memset(o, 0, sizeof *o);
    expr_store_init(&o->st);
    sys_init(&o->s, &o->st);
}

static int add(struct one *o, const char *name, const char *role)
{
    o->v[o->n] = expr_symbol_add(&o->st, name, EXPR_VARIABLE);
    sys_add_variable(&o->s, o->st.node[o->v[o->n]].a, role);
    return o->n++;
}

/* col' = e; col < 0: 0 = e. */
static void row(struct one *o, int col, expr_id e)
{
    int i = sys_add_row(&o->s, e, "row");
    if (col >= 0)
        sys_add_entry(&o->s, i, col, expr_int(&o->st, 1));
}

static void end(struct one *o, const char *expected)
{
    unsigned char kind[8];
    sys_kinds(&o->s, kind);
    for (int j = 0; j < o->n; j++)
        CHECK("cvam"[kind[j]] == expected[j], "variable %d of %s is %c", j, expected, "cvam"[kind[j]]);
    sys_clear(&o->s);
    expr_store_clear(&o->st);
}

int main(void)
{
    struct one o;
    begin(&o);          /* a pendulum with named velocities */
    int x = add(&o, "x", "variable"), y = add(&o, "y", "variable"), u = add(&o, "u", "variable"), v = add(&o, "v", "variable"), l = add(&o, "l", "variable");
    row(&o, x, o.v[u]);
    row(&o, y, expr_div(&o.st, o.v[v], expr_int(&o.st, 2)));
    row(&o, u, expr_mul(&o.st, o.v[l], o.v[x]));
    row(&o, v, expr_mul(&o.st, o.v[l], o.v[y]));
    row(&o, -1, expr_sub(&o.st, expr_mul(&o.st, o.v[x], o.v[y]), expr_int(&o.st, 1)));
    int order[8];
    sys_by_name(&o.s, order);
    CHECK(order[0] == l && order[1] == u && order[2] == v && order[3] == x && order[4] == y);
    end(&o, "ccvvm");

    begin(&o);          /* velocities of each other; what algebra alone has */
    x = add(&o, "x", "variable"), y = add(&o, "y", "variable"), u = add(&o, "u", "variable");
    row(&o, x, o.v[y]);
    row(&o, y, o.v[x]);
    row(&o, -1, expr_sub(&o.st, o.v[u], expr_powi(&o.st, o.v[x], 2)));
    end(&o, "cca");

    begin(&o);          /* an oscillator: x' = -y makes no velocity */
    x = add(&o, "x", "variable"), y = add(&o, "y", "variable");
    row(&o, x, expr_neg(&o.st, o.v[y]));
    row(&o, y, o.v[x]);
    end(&o, "vc");

    begin(&o);          /* a multiplier among the coordinates, with a velocity that nothing else has; an input */
    x = add(&o, "x", "variable"), l = add(&o, "l", "variable"), u = add(&o, "x'", "velocity"), v = add(&o, "l'", "velocity");
    int w = add(&o, "w", "input");
    row(&o, x, o.v[u]);
    row(&o, l, o.v[v]);
    row(&o, u, expr_add(&o.st, expr_mul(&o.st, o.v[l], o.v[x]), o.v[w]));
    row(&o, -1, expr_sub(&o.st, o.v[x], expr_int(&o.st, 1)));
    end(&o, "cmvmm");
    begin(&o);          /* y'' = f, f = 3 - 2 l y, and an output h = x^2 that nothing else has */
    x = add(&o, "x", "variable"), y = add(&o, "y", "variable"), u = add(&o, "u", "variable"), v = add(&o, "v", "variable");
    l = add(&o, "l", "variable");
    int f = add(&o, "f", "variable"), h = add(&o, "h", "variable");
    row(&o, x, o.v[u]);
    row(&o, y, o.v[v]);
    row(&o, u, expr_mul(&o.st, o.v[l], o.v[x]));
    row(&o, v, o.v[f]);
    row(&o, -1, expr_sub(&o.st, o.v[f], expr_sub(&o.st, expr_int(&o.st, 3), expr_mul(&o.st, expr_int(&o.st, 2), expr_mul(&o.st, o.v[l], o.v[y])))));
    row(&o, -1, expr_sub(&o.st, expr_powi(&o.st, o.v[x], 2), o.v[h]));
    row(&o, -1, expr_sub(&o.st, expr_mul(&o.st, o.v[x], o.v[y]), expr_int(&o.st, 1)));
    end(&o, "ccvvmma");

    begin(&o);          /* f is a name for l, which is in an equation of its own too */
    x = add(&o, "x", "variable"), l = add(&o, "l", "variable"), f = add(&o, "f", "variable");
    row(&o, x, o.v[f]);
    row(&o, -1, expr_sub(&o.st, o.v[f], o.v[l]));
    row(&o, -1, expr_sub(&o.st, expr_powi(&o.st, o.v[l], 3), o.v[x]));
    end(&o, "caa");
    return CHECK_END();
}
