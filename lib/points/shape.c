/* Shapes from the leaves up. */
#include "shape.h"

#include <stdint.h>
#include <string.h>

#include "arena.h"
#include "expr.h"
#include "mem.h"

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

enum { MANY = 16, BATCH = 64 };      /* more than one path leads there */

/* Up to 64 symbols in which all paths are affine: those that meet themselves in a product are not. */
static void look_for_squares(const struct expr_store *st, const struct expr_cone *cone, const int *place, int count, uint64_t *in, unsigned char *shape)
{
    uint64_t squares = 0;
    memset(in, 0, (size_t)cone->count * sizeof *in);
    for (int i = 0; i < count; i++)
        in[place[i]] = (uint64_t)1 << i;
    for (int k = place[0]; k < cone->count; k++) {
        const struct expr_node *n = st->node + cone->list[k];
        for (int c = 0, children = expr_children(st, cone->list[k]); c < children; c++) {
            uint64_t of = in[cone->place[expr_child(st, cone->list[k], c)]];
            squares |= n->op == EXPR_MUL ? in[k] & of : 0;
            in[k] |= of;
        }
    }
    for (int i = 0; i < count; i++)
        shape[place[i]] = squares >> i & 1 ? POINTS_CURVED : POINTS_AFFINE;
}

void points_shapes(const struct expr_store *st, const struct expr_cone *cone, unsigned char *shape)
{
    int last = cone->count - 1, place[BATCH], count = 0;
    memset(shape, POINTS_FREE, (size_t)cone->count);
    shape[last] = POINTS_AFFINE;
    for (int k = last; k >= 0; k--) {
        const struct expr_node *n = st->node + cone->list[k];
        int many = shape[k] & MANY, children = expr_children(st, cone->list[k]);
        enum points_shape so_far = (enum points_shape)(shape[k] & ~MANY);
        for (int c = 0; c < children; c++) {
            unsigned char *of = shape + cone->place[expr_child(st, cone->list[k], c)];
            enum points_shape is = larger((enum points_shape)(*of & ~MANY), through(st, n, c, so_far));
            *of = (unsigned char)(is | (*of ? MANY : many));
        }
    }
    SGA_FREED uint64_t *in = NULL;
    for (int k = 0; k <= last; k++) {
        if (shape[k] == (POINTS_AFFINE | MANY) && expr_op_of(st, cone->list[k]) == EXPR_SYM) {
            in = in ? in : sga_malloc((size_t)cone->count * sizeof *in);
            place[count++] = k;
        }
        if (count == BATCH || (k == last && count)) {
            look_for_squares(st, cone, place, count, in, shape);
            count = 0;
        }
        shape[k] &= (unsigned char)~MANY;
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
