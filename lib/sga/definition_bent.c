/* Rows that are solved for a variable although it stands under a switch: v + max(0, v) = u is v = min(u, u/2). */
#include "definition_search.h"

#include <stdlib.h>

#include "arena.h"
#include "mem.h"

/* By node: p v + q |v - c| + rest with numbers p, q and c, the same c for all; UNDEF: it is not that. */
struct bent { expr_id p, q; };

static bool is_number(struct expr_store *st, expr_id e, expr_id of)
{
    return e && of && expr_is_const(st, e) && expr_is_const(st, of);
}

/* a v + b, turned at 0: |a| and the place *c, which is to be the one known. UNDEF: another place, or none that is a number. */
static expr_id turned(struct definition_search *s, expr_id e, int symbol, expr_id a, expr_id *c)
{
    struct expr_store *st = s->st;
    expr_id b = e;
    s->map[symbol] = expr_int(st, 0);
    expr_substitute(st, &b, 1, s->map);
    s->map[symbol] = EXPR_UNDEF;
    if (!is_number(st, a, b) || expr_is_zero(st, a))
        return EXPR_UNDEF;
    expr_id place = expr_neg(st, expr_div(st, b, a));
    if (*c != EXPR_UNDEF && *c != place)
        return EXPR_UNDEF;
    *c = place;
    return expr_fun(st, EXPR_ABS, a);
}

static struct bent bent_of(struct definition_search *s, expr_id e, int symbol, struct bent a, struct bent b, expr_id *c)
{
    struct expr_store *st = s->st;
    const struct expr_node n = st->node[e];
    const struct bent none = { EXPR_UNDEF, EXPR_UNDEF };
    expr_id zero = expr_int(st, 0), half = expr_rational(st, 1, 2), turn;
    bool plain = a.q == zero && b.q == zero;
    switch ((enum expr_op)n.op) {
    case EXPR_ADD: return (struct bent){ expr_add(st, a.p, b.p), expr_add(st, a.q, b.q) };
    case EXPR_SUB: return (struct bent){ expr_sub(st, a.p, b.p), expr_sub(st, a.q, b.q) };
    case EXPR_NEG: return (struct bent){ expr_neg(st, a.p), expr_neg(st, a.q) };
    case EXPR_MUL:
        if (!expr_is_const(st, n.a) && !expr_is_const(st, n.b))
            return none;
        return expr_is_const(st, n.a) ? (struct bent){ expr_mul(st, n.a, b.p), expr_mul(st, n.a, b.q) }
                                      : (struct bent){ expr_mul(st, n.b, a.p), expr_mul(st, n.b, a.q) };
    case EXPR_DIV:
        return expr_is_const(st, n.b) ? (struct bent){ expr_div(st, a.p, n.b), expr_div(st, a.q, n.b) } : none;
    case EXPR_ABS:
        turn = plain ? turned(s, n.a, symbol, a.p, c) : EXPR_UNDEF;
        return turn ? (struct bent){ zero, turn } : none;
    case EXPR_MIN: case EXPR_MAX:        /* half of the sum, and of the distance */
        turn = plain ? turned(s, expr_sub(st, n.a, n.b), symbol, expr_sub(st, a.p, b.p), c) : EXPR_UNDEF;
        if (!turn)
            return none;
        turn = expr_mul(st, half, turn);
        return (struct bent){ expr_mul(st, half, expr_add(st, a.p, b.p)), n.op == EXPR_MIN ? expr_neg(st, turn) : turn };
    default:
        return none;
    }
}

bool definition_bent(struct definition_search *s, expr_id e, int symbol, expr_id *value, expr_id *slope)
{
    struct expr_store *st = s->st;
    expr_id zero = expr_int(st, 0), c = EXPR_UNDEF;
    int count = s->cone.count;
    SGA_FREED struct bent *at = sga_calloc((size_t)count + 1, sizeof *at);
    struct bent r;
    for (int i = 0; i < count; i++) {
        expr_id node = s->cone.list[i];
        struct bent of[2] = { { zero, zero }, { zero, zero } };
        bool in = false, known = true;
        for (int k = 0, n = expr_children(st, node); k < n; k++) {
            struct bent b = at[s->cone.place[expr_child(st, node, k)]];
            in |= b.p != zero || b.q != zero;
            known &= b.p && b.q && k < 2;
            if (k < 2)
                of[k] = b;
        }
        if (expr_op_of(st, node) == EXPR_SYM && st->node[node].a == symbol)
            at[i] = (struct bent){ expr_int(st, 1), zero };
        else
            at[i] = !in ? (struct bent){ zero, zero } : known ? bent_of(s, node, symbol, of[0], of[1], &c) : (struct bent){ EXPR_UNDEF, EXPR_UNDEF };
    }
    r = at[s->cone.place[e]];
    if (!is_number(st, r.p, r.q) || !c || fmpq_is_zero(expr_const_value(st, r.q)))
        return false;
    expr_id squares = expr_sub(st, expr_powi(st, r.p, 2), expr_powi(st, r.q, 2)), w = e;
    if (!expr_is_const(st, squares) || fmpq_sgn(expr_const_value(st, squares)) <= 0)
        return false;
    s->map[symbol] = c;
    expr_substitute(st, &w, 1, s->map);
    s->map[symbol] = EXPR_UNDEF;
    w = expr_neg(st, w);
    expr_id bend = expr_mul(st, fmpq_sgn(expr_const_value(st, r.p)) > 0 ? expr_neg(st, r.q) : r.q, expr_fun(st, EXPR_ABS, w));
    *value = expr_add(st, c, expr_div(st, expr_add(st, expr_mul(st, r.p, w), bend), squares));
    *slope = expr_add(st, r.p, expr_mul(st, r.q, expr_fun(st, EXPR_SIGN, expr_sub(st, st->symbol[symbol].node, c))));
    return *value && *slope;
}
