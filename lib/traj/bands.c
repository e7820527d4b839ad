/* Arguments of exponentials in a field. */
#include "bands.h"

#include <stdlib.h>

#include "mem.h"

enum { HIGH_POWER = 8 };

/* e's argument, EXPR_UNDEF where it has none of this kind. */
static expr_id argument_of(struct expr_store *st, expr_id e)
{
    const struct expr_node n = st->node[e];
    switch (n.op) {
    case EXPR_EXP: case EXPR_SINH: case EXPR_COSH: case EXPR_TANH: return n.a;
    case EXPR_POWI:
        if (abs(n.b) < HIGH_POWER)
            return EXPR_UNDEF;
        return expr_mul(st, expr_int(st, n.b), expr_fun(st, EXPR_LOG, expr_fun(st, EXPR_ABS, n.a)));
    default: return EXPR_UNDEF;
    }
}

/* Whether e depends on a variable, its children being known. */
static bool moves(const struct expr_store *st, const unsigned char *known, expr_id e)
{
    const struct expr_node n = st->node[e];
    bool of = n.op == EXPR_SYM && st->symbol[n.a].kind == EXPR_VARIABLE;
    for (int k = 0; k < expr_children(st, e) && !of; k++)
        of = known[expr_child(st, e, k)];
    return of;
}

int bands_find(struct expr_store *st, const expr_id *root, int roots, expr_id *argument)
{
    struct expr_cone cone;
    int count = 0;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, root, roots);
    unsigned char *of = sga_calloc((size_t)st->nodes + 1, 1);
    for (int i = 0; i < cone.count; i++)
        of[cone.list[i]] = moves(st, of, cone.list[i]);
    for (int i = 0; i < cone.count && count < BANDS_MOST; i++) {
        expr_id e = cone.list[i], a = of[e] ? argument_of(st, e) : EXPR_UNDEF;
        bool known = a == EXPR_UNDEF;
        for (int k = 0; k < count && !known; k++)
            known = argument[k] == a;
        if (!known)
            argument[count++] = a;
    }
    free(of);
    expr_cone_clear(&cone);
    return count;
}
