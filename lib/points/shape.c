/* Shapes from the leaves up. */
#include "shape.h"

#include "expr.h"

static enum points_shape larger(enum points_shape a, enum points_shape b)
{
    return a > b ? a : b;
}

static bool algebraic(const struct expr_store *st, const struct expr_node *n)
{
    switch ((enum expr_op)n->op) {
    case EXPR_POWI: case EXPR_SQRT: case EXPR_CBRT: case EXPR_SOLVE: return true;
    case EXPR_POW: return expr_is_const(st, n->b);
    default: return false;
    }
}

/* What a path from the last node to the k-th one says of the c-th child of that. */
static enum points_shape through(const struct expr_store *st, const struct expr_node *n, int c, enum points_shape so_far)
{
    switch ((enum expr_op)n->op) {
    case EXPR_ADD: case EXPR_SUB: case EXPR_NEG: case EXPR_MUL: return so_far;
    case EXPR_DIV: return c ? larger(POINTS_CURVED, so_far) : so_far;
    default: return algebraic(st, n) ? larger(POINTS_CURVED, so_far) : POINTS_HIDDEN;
    }
}

void points_shapes(const struct expr_store *st, const struct expr_cone *cone, unsigned char *shape)
{
    for (int k = 0; k < cone->count; k++)
        shape[k] = POINTS_FREE;
    if (cone->count)
        shape[cone->count - 1] = POINTS_AFFINE;
    for (int k = cone->count - 1; k >= 0; k--) {
        const struct expr_node *n = st->node + cone->list[k];
        int children = expr_children(st, cone->list[k]);
        for (int c = 0; c < children; c++) {
            unsigned char *of = shape + cone->place[expr_child(st, cone->list[k], c)];
            *of = (unsigned char)larger((enum points_shape)*of, through(st, n, c, (enum points_shape)shape[k]));
        }
    }
}

enum points_shape points_shape_in(const struct expr_store *st, const struct expr_cone *cone, int symbol, unsigned char *shape)
{
    for (int k = 0; k < cone->count; k++) {
        const struct expr_node n = st->node[cone->list[k]];
        enum points_shape s = POINTS_FREE, x, y;
        int children = expr_children(st, cone->list[k]);
        for (int c = 0; c < children; c++)
            s = larger(s, shape[cone->place[expr_child(st, cone->list[k], c)]]);
        switch ((enum expr_op)n.op) {
        case EXPR_SYM: s = n.a == symbol ? POINTS_AFFINE : POINTS_FREE; break;
        case EXPR_ADD: case EXPR_SUB: case EXPR_NEG: break;
        case EXPR_MUL:
            x = shape[cone->place[n.a]];
            y = shape[cone->place[n.b]];
            s = x && y ? larger(POINTS_CURVED, larger(x, y)) : larger(x, y);
            break;
        case EXPR_DIV:
            y = shape[cone->place[n.b]];
            s = y ? larger(POINTS_CURVED, s) : s;
            break;
        default:
            if (s)
                s = algebraic(st, &n) ? larger(POINTS_CURVED, s) : POINTS_HIDDEN;
            break;
        }
        shape[k] = (unsigned char)s;
    }
    return shape[cone->count - 1];
}
