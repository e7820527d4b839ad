/* Dependence and sign by shape, one pass in handle order. */
#include "facts.h"

#include <stdlib.h>

#include "mem.h"

enum { DEPENDS = EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER, SEEN_NOT = 255 };
enum { SIGNS = EXPR_NONNEGATIVE | EXPR_NONPOSITIVE };

void expr_facts_init(struct expr_facts *f)
{
    *f = (struct expr_facts){ 0 };
}

void expr_facts_clear(struct expr_facts *f)
{
    free(f->flag);
    free(f->solve);
    *f = (struct expr_facts){ 0 };
}

static unsigned negate(unsigned x)
{
    unsigned s = x & EXPR_NONZERO;
    if (x & EXPR_NONNEGATIVE)
        s |= EXPR_NONPOSITIVE;
    if (x & EXPR_NONPOSITIVE)
        s |= EXPR_NONNEGATIVE;
    return s;
}

static unsigned sum(unsigned x, unsigned y)
{
    unsigned s = x & y & SIGNS;
    if (s && ((x | y) & EXPR_NONZERO))
        s |= EXPR_NONZERO;
    return s;
}

static unsigned product(unsigned x, unsigned y)
{
    unsigned s = x & y & EXPR_NONZERO;
    if ((x & SIGNS) && (y & SIGNS)) {
        bool same = !!(x & EXPR_NONNEGATIVE) == !!(y & EXPR_NONNEGATIVE);
        s |= same ? EXPR_NONNEGATIVE : EXPR_NONPOSITIVE;
    }
    return s;
}

/* The factors of a product of products, numbers and signs aside, as far as there is room: what stands in it an even
 * number of times, (2 x) x or x y x y, is a square. The sign and nonzero of all that is left besides. */
static unsigned of_product(const struct expr_store *st, expr_id e, const unsigned char *flag)
{
    enum { ROOM = 12 };
    expr_id stack[ROOM], odd[ROOM];
    int depth = 0, odds = 0;
    unsigned all = EXPR_NONZERO | EXPR_NONNEGATIVE;
    stack[depth++] = e;
    while (depth) {
        const expr_id top = stack[--depth];
        const struct expr_node *n = st->node + top;
        int k = 0;
        if (n->op == EXPR_MUL && depth + 2 <= ROOM) {
            stack[depth++] = n->a;
            stack[depth++] = n->b;
            continue;
        }
        while (k < odds && odd[k] != top)
            k++;
        if (k < odds) {
            all &= ~(unsigned)EXPR_NONZERO | (flag[top] & EXPR_NONZERO);
            odd[k] = odd[--odds];
        } else if (odds < ROOM) {
            odd[odds++] = top;
        } else {
            return 0;
        }
    }
    for (int k = 0; k < odds; k++)
        all = product(all, flag[odd[k]]);
    return all;
}

static unsigned of_constant(const fmpq *q)
{
    int sign = fmpq_sgn(q);
    if (sign == 0)
        return SIGNS;
    return EXPR_NONZERO | (sign > 0 ? EXPR_NONNEGATIVE : EXPR_NONPOSITIVE);
}

static unsigned of_symbol(enum expr_symbol_kind kind)
{
    if (kind == EXPR_PARAMETER)
        return EXPR_HAS_PARAMETER;
    return kind == EXPR_TIME || kind == EXPR_SIGNAL ? EXPR_HAS_TIME : EXPR_HAS_VARIABLE;
}

static unsigned sign_of(const struct expr_store *st, expr_id e, const unsigned char *flag)
{
    const struct expr_node *n = st->node + e;
    unsigned x, y;
    bool nested;
    switch ((enum expr_op)n->op) {
    case EXPR_CONST: return of_constant(st->constant + n->a);
    case EXPR_PI: case EXPR_UNDEF_OP: return EXPR_NONZERO | EXPR_NONNEGATIVE;
    case EXPR_SYM: case EXPR_SOLVE: return 0;
    default: break;
    }
    x = flag[n->a];
    switch ((enum expr_op)n->op) {
    case EXPR_POWI:
        if (n->b % 2 == 0)
            return EXPR_NONNEGATIVE | (x & EXPR_NONZERO) | (n->b < 0 ? EXPR_NONZERO : 0u);
        return (x & (SIGNS | EXPR_NONZERO)) | (n->b < 0 ? EXPR_NONZERO : 0u);
    case EXPR_NEG: return negate(x);
    default: break;
    }
    unsigned is = expr_op_traits((enum expr_op)n->op);
    if (is & EXPR_IS_ABOVE)        /* 0^(1/3) is 0 */
        return EXPR_NONNEGATIVE | (is & EXPR_IS_NOT_ZERO ? EXPR_NONZERO : 0u) | (is & EXPR_BENDS_AT_0 ? x & EXPR_NONZERO : 0u);
    if (is & EXPR_IS_RISING)
        return x & (SIGNS | EXPR_NONZERO);
    if (expr_op_args((enum expr_op)n->op) < 2)
        return 0;
    y = flag[n->b];
    switch ((enum expr_op)n->op) {
    case EXPR_ADD: return sum(x, y);
    case EXPR_SUB: return sum(x, negate(y));
    case EXPR_MUL:
        x = product(x, y);
        nested = st->node[n->a].op == EXPR_MUL || st->node[n->b].op == EXPR_MUL;
        return nested && !(x & SIGNS) ? x | of_product(st, e, flag) : x;
    case EXPR_DIV: return product(x, y | EXPR_NONZERO);
    default: return x & y & (SIGNS | EXPR_NONZERO) & ((x & y & SIGNS) ? 0xffu : 0u);
    }
}

static unsigned of_children(const struct expr_facts *f, const struct expr_store *st, expr_id e)
{
    unsigned d = 0;
    for (int k = 0, n = expr_children(st, e); k < n; k++)
        d |= f->flag[expr_child(st, e, k)] & DEPENDS;
    return d;
}

/* What a linear solve depends on is looked at once, not for each of its components. */
static unsigned of_solve(struct expr_facts *f, const struct expr_store *st, expr_id e)
{
    int solve = st->node[e].a;
    SGA_RESERVE(f->solve, f->solve_cap, st->solves);
    for (; f->solves < st->solves; f->solves++)
        f->solve[f->solves] = SEEN_NOT;
    if (f->solve[solve] == SEEN_NOT)
        f->solve[solve] = (unsigned char)of_children(f, st, e);
    return f->solve[solve];
}

unsigned expr_facts_of(struct expr_facts *f, const struct expr_store *st, expr_id e)
{
    SGA_RESERVE(f->flag, f->cap, st->nodes);
    for (; f->known < st->nodes; f->known++) {
        expr_id i = f->known;
        unsigned d = expr_op_of(st, i) == EXPR_SYM ? of_symbol(st->symbol[st->node[i].a].kind)
                     : expr_op_of(st, i) == EXPR_SOLVE ? of_solve(f, st, i) : of_children(f, st, i);
        f->flag[i] = (unsigned char)(d | (sign_of(st, i, f->flag) & ~(unsigned)DEPENDS));
    }
    return f->flag[e];
}
