/* Values in Q(t) of a cone of nodes, children first. */
#include "from_expr.h"

#include <stdio.h>
#include <stdlib.h>

#include <flint/fmpq.h>

#include "arena.h"
#include "mem.h"

enum { MAX_DEGREE = 1000 };

static void from_constant(fmpz_poly_q_t out, const fmpq *c)
{
    fmpz_poly_set_fmpz(fmpz_poly_q_numref(out), fmpq_numref(c));
    fmpz_poly_set_fmpz(fmpz_poly_q_denref(out), fmpq_denref(c));
    if (fmpz_poly_is_zero(fmpz_poly_q_numref(out)))
        fmpz_poly_one(fmpz_poly_q_denref(out));
}

static long degree(const fmpz_poly_q_t a)
{
    long p = fmpz_poly_degree(fmpz_poly_q_numref(a)), q = fmpz_poly_degree(fmpz_poly_q_denref(a));
    return p > q ? p : q;
}

static bool power(fmpz_poly_q_t out, const fmpz_poly_q_t base, long n, char *why)
{
    if (fmpz_poly_q_is_zero(base) && n < 0)
        return snprintf(why, 160, "a division by 0"), false;
    if (labs(n) * (degree(base) > 1 ? degree(base) : 1) > MAX_DEGREE)
        return snprintf(why, 160, "its degree is above %d", MAX_DEGREE), false;
    fmpz_poly_q_pow(out, base, (ulong)labs(n));
    if (n < 0)
        fmpz_poly_q_inv(out, out);
    return true;
}

static bool quotient(fmpz_poly_q_t out, const fmpz_poly_q_t a, const fmpz_poly_q_t b, char *why)
{
    if (fmpz_poly_q_is_zero(b))
        return snprintf(why, 160, "a division by 0"), false;
    fmpz_poly_q_div(out, a, b);
    return true;
}

static bool one_node(fmpz_poly_q_struct *value, const int *place, const struct expr_store *st, expr_id e, int time, char *why)
{
    const struct expr_node *n = st->node + e;
    fmpz_poly_q_struct *out = value + place[e];
    const fmpz_poly_q_struct *a = expr_children(st, e) > 0 ? value + place[expr_child(st, e, 0)] : NULL;
    const fmpz_poly_q_struct *b = expr_children(st, e) > 1 ? value + place[expr_child(st, e, 1)] : NULL;
    switch (n->op) {
    case EXPR_CONST: from_constant(out, expr_const_value(st, e)); break;
    case EXPR_SYM:
        if (n->a != time)
            return snprintf(why, 160, "%.100s is not the time", st->symbol[n->a].name), false;
        fmpz_poly_set_coeff_si(fmpz_poly_q_numref(out), 1, 1);
        break;
    case EXPR_ADD: fmpz_poly_q_add(out, a, b); break;
    case EXPR_SUB: fmpz_poly_q_sub(out, a, b); break;
    case EXPR_MUL: fmpz_poly_q_mul(out, a, b); break;
    case EXPR_NEG: fmpz_poly_q_neg(out, a); break;
    case EXPR_DIV: return quotient(out, a, b, why);
    case EXPR_POWI: return power(out, a, n->b, why);
    default: return snprintf(why, 160, "%s is no rational operation", expr_op_text((enum expr_op)n->op)), false;
    }
    return degree(out) <= MAX_DEGREE || (snprintf(why, 160, "its degree is above %d", MAX_DEGREE), false);
}

int op_from_exprs(fmpz_poly_q_struct *out, const struct expr_store *st, const expr_id *e, int n, int time,
                  char why[static 160])
{
    int k = 0;
    for (; k < n; k++) {                       /* one by one: the first that fails is told apart */
        SGA_ENDS(expr_cone_clear) struct expr_cone cone;
        expr_cone_init(&cone);
        expr_cone_of(st, &cone, e + k, 1);
        expr_cone_index(&cone);
        SGA_FREED fmpz_poly_q_struct *value = sga_malloc(((size_t)cone.count + 1) * sizeof *value);
        bool ok = true;
        for (int i = 0; i < cone.count; i++)
            fmpz_poly_q_init(value + i);
        for (int i = 0; i < cone.count && ok; i++)
            ok = one_node(value, cone.place, st, cone.list[i], time, why);
        if (ok)
            fmpz_poly_q_set(out + k, value + cone.place[e[k]]);
        for (int i = 0; i < cone.count; i++)
            fmpz_poly_q_clear(value + i);
        if (!ok)
            break;
    }
    return k;
}
