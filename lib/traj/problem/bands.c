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

static int compare(const void *a, const void *b)
{
    const expr_id *p = a, *q = b;
    return *p < *q ? -1 : *p > *q;
}

int bands_find(struct expr_store *st, const expr_id *root, int roots, expr_id **argument)
{
    struct expr_cone cone;
    int count = 0, different = 0;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, root, roots);
    unsigned char *of = sga_calloc((size_t)st->nodes + 1, 1);
    for (int i = 0; i < cone.count; i++)
        of[cone.list[i]] = moves(st, of, cone.list[i]);
    expr_id *all = *argument = sga_malloc(((size_t)cone.count + 1) * sizeof *all);
    for (int i = 0; i < cone.count; i++) {
        expr_id e = cone.list[i], a = of[e] ? argument_of(st, e) : EXPR_UNDEF;
        if (a != EXPR_UNDEF)
            all[count++] = a;
    }
    qsort(all, (size_t)count, sizeof *all, compare);
    for (int k = 0; k < count; k++)
        if (!different || all[different - 1] != all[k])
            all[different++] = all[k];
    free(of);
    expr_cone_clear(&cone);
    return different;
}
