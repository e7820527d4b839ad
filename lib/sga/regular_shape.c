/* What the shape of an expression says of its zeros, without factoring it. */
#include "regular_shape.h"

#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "facts.h"

/* What can be taken off without changing the real zeros: signs, powers, roots, absolute
 * values, odd monotone functions, factors and denominators that never vanish. */
static expr_id strip(struct state *s, expr_id e)
{
    for (;;) {
        const struct expr_node n = s->st->node[e];
        switch ((enum expr_op)n.op) {
        case EXPR_NEG: case EXPR_SQRT: case EXPR_CBRT: case EXPR_ABS: case EXPR_SIGN:
        case EXPR_SINH: case EXPR_TANH: case EXPR_ASIN: case EXPR_ATAN: case EXPR_ASINH: case EXPR_ATANH:
        case EXPR_DIV:
            e = n.a;
            break;
        case EXPR_POWI:
            if (n.b < 0)
                return e;
            e = n.a;
            break;
        case EXPR_POW:      /* 0 to a positive power is 0 */
            if (!expr_is_const(s->st, n.b) || fmpq_sgn(expr_const_value(s->st, n.b)) <= 0)
                return e;
            e = n.a;
            break;
        case EXPR_MUL:
            if (state_facts(s, n.a) & EXPR_NONZERO)
                e = n.b;
            else if (state_facts(s, n.b) & EXPR_NONZERO)
                e = n.a;
            else
                return e;
            break;
        default:
            return e;
        }
    }
}

bool regular_depends(struct state *s, expr_id e, int symbol)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++)
        if (s->cone.list[k] == s->st->symbol[symbol].node)
            return true;
    return false;
}

enum graph regular_graph(struct state *s, expr_id e)
{
    state_activate(s);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    int n = expr_gradient(s->st, &s->cone, e, s->active, &term, &cap);
    enum graph graph = NOT_GRAPH;
    for (int k = 0; k < n && graph != PLAIN_GRAPH; k++) {
        unsigned f = state_facts(s, term[k].value);
        if (!(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
            graph = PLAIN_GRAPH;
        else if (f & EXPR_NONZERO && !regular_depends(s, term[k].value, term[k].symbol))
            graph = GRAPH;
    }
    return graph;
}

int regular_shape_factors(struct state *s, expr_id e, expr_id *part, int most)
{
    expr_id stack[64];
    int depth = 0, count = 0;
    stack[depth++] = e;
    while (depth) {
        const expr_id top = stack[--depth];
        const struct expr_node n = s->st->node[top];
        if (state_facts(s, top) & EXPR_NONZERO)
            continue;
        if (n.op == EXPR_MUL && depth + 2 <= 64) {
            stack[depth++] = n.b;
            stack[depth++] = n.a;
            continue;
        }
        expr_id inner = strip(s, top);
        if (inner != top && depth < 64) {
            stack[depth++] = inner;
            continue;
        }
        bool known = false;
        for (int i = 0; i < count; i++)
            known |= part[i] == top;
        if (!known && count < most)
            part[count++] = top;
    }
    return count;
}

bool regular_same_zeros(struct state *s, expr_id e, expr_id part)
{
    for (expr_id last = EXPR_UNDEF; e != part && e != last; ) {
        const struct expr_node n = s->st->node[last = e];
        if (n.op == EXPR_NEG || n.op == EXPR_DIV)
            e = n.a;
        else if (n.op == EXPR_MUL && state_facts(s, n.a) & EXPR_NONZERO)
            e = n.b;
        else if (n.op == EXPR_MUL && state_facts(s, n.b) & EXPR_NONZERO)
            e = n.a;
    }
    return e == part;
}

bool regular_has_poles(struct state *s, expr_id e)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++) {
        expr_id below = expr_divisor(s->st, s->cone.list[k]);
        if (below && !(state_facts(s, below) & EXPR_NONZERO))
            return true;
    }
    return false;
}

bool regular_fresh_graph(struct state *s, expr_id e)
{
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    state_activate(s);
    s->activated = 0;
    for (int pass = 0; pass < 2; pass++) {
        int count = pass ? s->pendings : s->sol->constraints;
        if (!count)
            continue;
        expr_cone_of(s->st, &s->cone, pass ? s->pending : s->con, count);
        for (int k = 0; k < s->cone.count; k++) {
            const struct expr_node *n = s->st->node + s->cone.list[k];
            if (n->op == EXPR_SYM)
                s->active[n->a] = 0;
        }
    }
    int n = expr_gradient(s->st, &s->cone, e, s->active, &term, &cap);
    bool fresh = false;
    for (int k = 0; k < n && !fresh; k++) {
        unsigned f = state_facts(s, term[k].value);
        bool plain = !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME));
        fresh = plain || (f & EXPR_NONZERO && !regular_depends(s, term[k].value, term[k].symbol));
    }
    return fresh;
}
