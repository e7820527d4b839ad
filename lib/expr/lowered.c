/* Functions that are written by others: see lowered.h. */
#include "lowered.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "raw_nodes.h"
#include "same_sign.h"

#define ST struct expr_store *st

const struct lowered lowered_table[LOWERED_COUNT] = {
#define X(symbol, name, least, most) { LOWERED_##symbol, name, least, most },
    LOWERED_TABLE(X)
#undef X
};

const struct lowered *lowered_function(const char *name, size_t length)
{
    for (int i = 0; i < LOWERED_COUNT; i++)
        if (strlen(lowered_table[i].name) == length && !memcmp(lowered_table[i].name, name, length))
            return lowered_table + i;
    return NULL;
}

static expr_id sign_of(ST, expr_id a) { return expr_fun(st, EXPR_SIGN, a); }
static expr_id one_minus(ST, expr_id a) { return expr_sub(st, expr_int(st, 1), a); }
static expr_id half(ST, expr_id a) { return expr_mul(st, expr_rational(st, 1, 2), a); }

/* Polynomials of one sign, which has the values -1, 0, 1: so each is one switch. */
static expr_id step(ST, expr_id a)
{
    expr_id s = sign_of(st, a);
    return expr_add(st, expr_int(st, 1), half(st, expr_mul(st, s, one_minus(st, s))));
}

static expr_id above(ST, expr_id a)
{
    expr_id s = sign_of(st, a);
    return half(st, expr_mul(st, s, expr_add(st, expr_int(st, 1), s)));
}

static expr_id differs(ST, expr_id a) { return expr_powi(st, sign_of(st, a), 2); }

expr_id lowered_logic(ST, enum logic logic, expr_id a, expr_id b)
{
    switch (logic) {
    case LOGIC_LESS:          return above(st, expr_sub(st, b, a));
    case LOGIC_LESS_EQUAL:    return step(st, expr_sub(st, b, a));
    case LOGIC_GREATER:       return above(st, expr_sub(st, a, b));
    case LOGIC_GREATER_EQUAL: return step(st, expr_sub(st, a, b));
    case LOGIC_EQUAL:         return one_minus(st, differs(st, expr_sub(st, a, b)));
    case LOGIC_NOT_EQUAL:     return differs(st, expr_sub(st, a, b));
    case LOGIC_AND:           return expr_mul(st, a, b);
    case LOGIC_OR:            return one_minus(st, expr_mul(st, one_minus(st, a), one_minus(st, b)));
    case LOGIC_NOT:           return one_minus(st, a);
    default:                  return EXPR_UNDEF;
    }
}

/* c u + (1 - c) point */
static expr_id masked(ST, expr_id c, expr_id u, long point)
{
    if (expr_is_const(st, u))
        return u;
    return expr_add(st, expr_mul(st, c, u), expr_mul(st, one_minus(st, c), expr_int(st, point)));
}

/* Node n made again, its arguments a and b kept inside of its domain, and away from where it grows without bound or has no derivative, unless c is 1. */
static expr_id guarded(ST, struct expr_node n, expr_id c, expr_id a, expr_id b)
{
    enum expr_op op = (enum expr_op)n.op;
    switch (op) {
    case EXPR_DIV:   return expr_div(st, a, masked(st, c, b, 1));
    case EXPR_POWI:  return expr_powi(st, n.b < 0 ? masked(st, c, a, 1) : a, n.b);
    case EXPR_POW:   return expr_pow(st, masked(st, c, a, 1), b);
    case EXPR_ATAN2: return expr_fun2(st, op, a, masked(st, c, b, 1));
    case EXPR_TAN: case EXPR_EXP: case EXPR_SINH: case EXPR_COSH: case EXPR_ASIN: case EXPR_ACOS: case EXPR_ATANH:
        return expr_fun(st, op, masked(st, c, a, 0));
    case EXPR_SQRT: case EXPR_CBRT: case EXPR_LOG:
        return expr_fun(st, op, masked(st, c, a, 1));
    case EXPR_ACOSH:
        return expr_fun(st, op, masked(st, c, a, 2));
    default: return EXPR_UNDEF;
    }
}

/* e where c is 1; where it is 0, some number. */
static expr_id where(ST, expr_id c, expr_id e)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    SGA_ARENA(mem);
    expr_id *to = sga_zeros(&mem, (size_t)st->nodes + 1, sizeof *to), *none = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *none);
    for (int i = 0; i < cone.count && expr_store_ok(st); i++) {
        expr_id at = cone.list[i];
        struct expr_node n = st->node[at];
        enum expr_op op = (enum expr_op)n.op;
        int args = op == EXPR_POWI ? 1 : expr_op_args(op);
        bool constant = true;
        for (int k = 0; k < expr_children(st, at); k++)
            constant &= expr_is_const(st, expr_child(st, at, k));
        to[at] = constant || args < 1 ? EXPR_UNDEF : guarded(st, n, c, to[n.a], args > 1 ? to[n.b] : EXPR_UNDEF);
        if (!to[at])
            to[at] = expr_rebuild(st, st, at, to, none);
    }
    return to[e];
}

/* b + c (a - b) where c asks for the sign of u, which is a factor of a - b: there is no jump (if(u > w, u, w), if(x < 0, -k*x, 0)). EXPR_UNDEF: it is not so. */
static expr_id without_jump(ST, expr_id c, expr_id a, expr_id b)
{
    expr_id below, above, u = expr_by_one_sign(st, c, &below, &above);
    if (!u || !((expr_is_zero(st, below) && expr_is_one(st, above)) || (expr_is_one(st, below) && expr_is_zero(st, above))))
        return EXPR_UNDEF;
    expr_id part = expr_fun2(st, expr_is_one(st, above) ? EXPR_MAX : EXPR_MIN, u, expr_int(st, 0)), way = expr_sub(st, a, b), back = expr_sub(st, b, a);
    expr_id e = expr_put_for_factor(st, expr_op_of(st, way) == EXPR_NEG ? st->node[way].a : way, u, part);
    if (e)
        return expr_op_of(st, way) == EXPR_NEG ? expr_sub(st, b, e) : expr_add(st, b, e);
    e = expr_put_for_factor(st, expr_op_of(st, back) == EXPR_NEG ? st->node[back].a : back, u, part);
    return !e ? EXPR_UNDEF : expr_op_of(st, back) == EXPR_NEG ? expr_add(st, b, e) : expr_sub(st, b, e);
}

static expr_id choose(ST, expr_id c, expr_id a, expr_id b)
{
    if (expr_is_one(st, c) || expr_is_zero(st, c))
        return expr_is_one(st, c) ? a : b;
    expr_id otherwise = one_minus(st, c), first = where(st, c, a), second = where(st, otherwise, b);
    expr_id smooth = a && b && first == a && second == b ? without_jump(st, c, a, b) : EXPR_UNDEF;       /* branches with values everywhere */
    return smooth ? smooth : expr_add(st, expr_mul(st, c, first), expr_mul(st, otherwise, second));
}

/* The logarithm of a power of the base is that power. */
static expr_id logarithm(ST, expr_id a, long base)
{
    if (expr_is_const(st, a)) {
        const fmpq *q = expr_const_value(st, a);
        bool below = fmpz_is_one(fmpq_numref(q));
        if (below || fmpz_is_one(fmpq_denref(q))) {
            fmpz_t rest, b;
            fmpz_init_set(rest, below ? fmpq_denref(q) : fmpq_numref(q));
            fmpz_init_set_si(b, base);
            long power = fmpz_sgn(rest) > 0 ? fmpz_remove(rest, rest, b) : 0;
            bool whole = fmpz_is_one(rest);
            fmpz_clear(rest);
            fmpz_clear(b);
            if (whole)
                return expr_int(st, below ? -power : power);
        }
    }
    return expr_div(st, expr_fun(st, EXPR_LOG, a), expr_fun(st, EXPR_LOG, expr_int(st, base)));
}

expr_id lowered_call(ST, enum lowered_kind kind, const expr_id *arg, int args)
{
    expr_id sum;
    switch (kind) {
    case LOWERED_IF:    return choose(st, arg[0], arg[1], arg[2]);
    case LOWERED_STEP:  return step(st, arg[0]);
    case LOWERED_LOG10: return logarithm(st, arg[0], 10);
    case LOWERED_LOG2:  return logarithm(st, arg[0], 2);
    case LOWERED_HYPOT:
        sum = expr_int(st, 0);
        for (int i = 0; i < args; i++)
            sum = expr_add(st, sum, expr_powi(st, arg[i], 2));
        return expr_fun(st, EXPR_SQRT, sum);
    default: return EXPR_UNDEF;
    }
}
