/* The double nearest to a constant expression such as "sqrt(2)/3": exact rationals are
 * rounded once, the rest is evaluated in doubles. */
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "reader.h"
#include "value.h"

static double apply(enum expr_op op, double a, double b)
{
    switch (op) {
    case EXPR_PI:    return 3.14159265358979323846;
    case EXPR_ADD:   return a + b;
    case EXPR_SUB:   return a - b;
    case EXPR_MUL:   return a * b;
    case EXPR_DIV:   return a / b;
    case EXPR_NEG:   return -a;
    case EXPR_POW:   return a > 0 ? pow(a, b) : NAN;
    case EXPR_ATAN2: return atan2(a, b);
    case EXPR_MIN:   return a < b ? a : b;
    case EXPR_MAX:   return a > b ? a : b;
    default:         return expr_function_value(op, a);
    }
}

/* Position of node e in the sorted list of its cone. */
static int find(const struct expr_cone *c, expr_id e)
{
    int low = 0, high = c->count - 1;
    while (low < high) {
        int mid = (low + high) / 2;
        if (c->list[mid] < e)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

bool constant_value(const struct expr_store *st, expr_id e, double *out)
{
    if (expr_is_const(st, e)) {
        *out = expr_nearest_double(expr_const_value(st, e));
        return isfinite(*out);
    }
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    expr_cone_init(&c);
    expr_cone_of(st, &c, &e, 1);
    SGA_FREED double *v = sga_malloc((size_t)(c.count + 1) * sizeof *v);
    for (int i = 0; i < c.count; i++) {
        const struct expr_node *n = st->node + c.list[i];
        int args = n->op == EXPR_SYM || n->op == EXPR_SOLVE ? 0 : expr_op_args((enum expr_op)n->op);
        double a = args > 0 ? v[find(&c, n->a)] : NAN, b = args > 1 ? v[find(&c, n->b)] : NAN;
        if (n->op == EXPR_CONST)
            v[i] = expr_nearest_double(expr_const_value(st, c.list[i]));
        else
            v[i] = n->op == EXPR_POWI ? pow(a, n->b) : apply((enum expr_op)n->op, a, b);
    }
    *out = v[c.count - 1];
    return isfinite(*out);
}

unsigned symbol_kinds(const struct expr_store *st, expr_id e)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    unsigned kinds = 0;
    expr_cone_init(&c);
    expr_cone_of(st, &c, &e, 1);
    for (int i = 0; i < c.count; i++) {
        const struct expr_node *n = st->node + c.list[i];
        if (n->op == EXPR_SYM)
            kinds |= 1u << st->symbol[n->a].kind;
    }
    return kinds;
}
