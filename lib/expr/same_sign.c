/* See same_sign.h. */
#include "same_sign.h"

#include "arena.h"
#include "mem.h"
#include "raw_nodes.h"

/* e where each sign of u is this. */
static expr_id at_side(struct expr_store *st, const struct expr_cone *cone, expr_id e, expr_id u, long side)
{
    SGA_ARENA(mem);
    expr_id *to = sga_zeros(&mem, (size_t)st->nodes + 1, sizeof *to), *none = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *none);
    for (int i = 0; i < cone->count && expr_store_ok(st); i++) {
        expr_id at = cone->list[i];
        bool sign = expr_op_of(st, at) == EXPR_SIGN && st->node[at].a == u;
        to[at] = sign ? expr_int(st, side) : expr_rebuild(st, st, at, to, none);
    }
    return to[e];
}

/* Of a factor beside e: 1 where it is never negative, and 0 only where e is (|e|, a positive constant); -1: a negative constant; 0: that is not known. */
static int factor_sign(const struct expr_store *st, expr_id f, expr_id e)
{
    const struct expr_node *n = st->node + f;
    if (expr_is_const(st, f))
        return fmpq_sgn(expr_const_value(st, f));
    return n->op == EXPR_ABS && n->a == e;
}

expr_id expr_peeled(const struct expr_store *st, expr_id e, bool *turns)
{
    const struct expr_node *n = st->node + e;
    switch ((enum expr_op)n->op) {
    case EXPR_NEG:
        *turns = !*turns;
        return n->a;
    case EXPR_POWI:
        return n->b > 0 && n->b % 2 == 1 ? n->a : e;
    case EXPR_SINH: case EXPR_ASINH: case EXPR_TANH: case EXPR_ATAN: case EXPR_CBRT:
        return n->a;
    case EXPR_MUL: case EXPR_DIV: {
        int b = factor_sign(st, n->b, n->a), a = n->op == EXPR_MUL ? factor_sign(st, n->a, n->b) : 0;
        bool pole = n->op == EXPR_DIV && !expr_is_const(st, n->b);
        *turns ^= a < 0 || (!a && b < 0);
        return a ? n->b : b && !pole ? n->a : e;
    }
    default:
        return e;
    }
}

expr_id expr_by_one_sign(struct expr_store *st, expr_id e, expr_id *below, expr_id *above)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_id u = EXPR_UNDEF;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    for (int i = 0; i < cone.count; i++)       /* the outermost */
        if (expr_op_of(st, cone.list[i]) == EXPR_SIGN)
            u = st->node[cone.list[i]].a;
    *below = u ? at_side(st, &cone, e, u, -1) : EXPR_UNDEF;
    *above = u ? at_side(st, &cone, e, u, 1) : EXPR_UNDEF;
    return *below && *above && expr_is_const(st, *below) && expr_is_const(st, *above) ? u : EXPR_UNDEF;
}

/* Where the sign of one u alone makes e negative and positive: u or -u; else e. */
static expr_id by_sign(struct expr_store *st, expr_id e)
{
    expr_id below, above, u = expr_by_one_sign(st, e, &below, &above);
    if (!u || expr_has_branches(st, &u, 1))
        return e;
    int low = fmpq_sgn(expr_const_value(st, below)), high = fmpq_sgn(expr_const_value(st, above));
    return low < 0 && high > 0 ? u : low > 0 && high < 0 ? expr_neg(st, u) : e;
}

expr_id expr_same_sign(struct expr_store *st, expr_id e)
{
    bool turns = false;
    for (expr_id next; (next = expr_peeled(st, e, &turns)) != e; e = next) { }
    expr_id u = by_sign(st, e);
    return turns ? expr_neg(st, u) : u;
}
