/* On which side of which surfaces a zero holds. */
#include "sides.h"

#include <stdlib.h>

#include "arena.h"
#include "beyond.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"

bool points_switches(enum expr_op op)
{
    return expr_op_traits(op) & (EXPR_HAS_BRANCHES | EXPR_FOLDS);
}

/* sqrt(u): where u is a square, its root, which changes sign; otherwise u itself. */
static expr_id root_of(struct expr_store *st, expr_id u)
{
    struct poly_limits limits = poly_limits_of(POLY_GLANCE, NULL);
    struct poly_factors f;
    expr_id root = expr_int(st, 1);
    if (!poly_numerator_factors(st, u, &limits, &f))
        return u;
    for (int i = 0; i < f.factors && root; i++) {
        const struct poly_factor *q = f.factor + i;
        if (!q->never_zero)
            root = q->multiplicity % 2 ? EXPR_UNDEF : expr_mul(st, root, q->expr);
    }
    poly_factors_clear(&f);
    return root ? root : u;
}

/* What changes sign where the node changes its branch. */
static expr_id surface(struct expr_store *st, const struct expr_node n)
{
    const struct expr_node in = st->node[n.a];
    switch ((enum expr_op)n.op) {
    case EXPR_MIN: case EXPR_MAX: return expr_sub(st, n.a, n.b);
    case EXPR_ASIN: case EXPR_ACOS:
        if (in.op == EXPR_SIN || in.op == EXPR_COS)       /* it turns where the sine is 1 or -1 */
            return expr_fun(st, in.op == EXPR_SIN ? EXPR_COS : EXPR_SIN, in.a);
        return expr_sub(st, expr_int(st, 1), expr_powi(st, n.a, 2));
    case EXPR_ACOSH:
        return in.op == EXPR_COSH ? in.a : expr_sub(st, n.a, expr_int(st, 1));
    case EXPR_SQRT: return root_of(st, n.a);
    default: return n.a;
    }
}

static bool changes_with(const struct expr_node n, const struct expr_node key)
{
    bool pair = key.op == EXPR_MIN || key.op == EXPR_MAX;
    bool same = n.a == key.a && (!pair || n.b == key.b);
    switch ((enum expr_op)key.op) {
    case EXPR_ABS: case EXPR_SIGN: return same && (n.op == EXPR_ABS || n.op == EXPR_SIGN);
    case EXPR_MIN: case EXPR_MAX: return same && (n.op == EXPR_MIN || n.op == EXPR_MAX);
    case EXPR_ASIN: case EXPR_ACOS: return same && (n.op == EXPR_ASIN || n.op == EXPR_ACOS);
    default: return same && n.op == key.op;
    }
}

/* The other branch of a node whose value is v. */
static void other_branch(struct num_ball *b, const struct expr_node n, arb_t v)
{
    arb_ptr x = num_ball_value(b, n.a), y = num_ball_value(b, n.b);
    if (n.op == EXPR_ASIN) {
        arb_t pi;
        arb_init(pi);
        arb_const_pi(pi, b->prec);
        arb_sub(v, pi, v, b->prec);
        arb_clear(pi);
    } else if (n.op == EXPR_MIN) {
        arb_max(v, x, y, b->prec);
    } else if (n.op == EXPR_MAX) {
        arb_min(v, x, y, b->prec);
    } else {
        arb_neg(v, v);
    }
}

/* Whether e stays 0 with the other branch of the keys' nodes. b is a scratch with values. */
static bool zero_on_both(struct num_ball *b, expr_id e, const expr_id *list, int count, const struct expr_node *key, int keys)
{
    for (int k = 0; k < count; k++) {
        num_ball_list(b, list + k, 1);
        const struct expr_node n = b->st->node[list[k]];
        bool changes = false;
        for (int i = 0; i < keys; i++)
            changes |= changes_with(n, key[i]);
        if (changes)
            other_branch(b, n, num_ball_value(b, list[k]));
    }
    arb_srcptr v = num_ball_value(b, e);
    return arb_is_finite(v) && arb_contains_zero(v);
}

expr_id points_surface(struct expr_store *st, expr_id node)
{
    const struct expr_node n = st->node[node], in = st->node[n.a];
    switch ((enum expr_op)n.op) {
    case EXPR_ABS: case EXPR_SIGN: case EXPR_MIN: case EXPR_MAX: return surface(st, n);
    case EXPR_SQRT: {
        expr_id root = root_of(st, n.a);
        return root == n.a ? EXPR_UNDEF : root;
    }
    case EXPR_ASIN: case EXPR_ACOS: return in.op == EXPR_SIN || in.op == EXPR_COS ? surface(st, n) : EXPR_UNDEF;
    case EXPR_ACOSH: return in.op == EXPR_COSH ? in.a : EXPR_UNDEF;
    default: return EXPR_UNDEF;
    }
}

int points_sign_at(struct points_point *p, expr_id u)
{
    num_ball_extend(&p->ball);
    arb_srcptr v = num_ball_value(&p->ball, u);
    return !arb_is_finite(v) || arb_contains_zero(v) ? 0 : arb_is_positive(v) ? 1 : -1;
}

/* The sign of a switch's function at p, where it can change, is none of the constraints' and is not listed yet; else 0. */
static int open_sign(struct expr_store *st, struct expr_facts *facts, struct points_point *p, expr_id u, const struct points_beyond *beyond,
                     const struct points_side *side, int sides)
{
    unsigned f = expr_facts_of(facts, st, u);
    int sign = f & EXPR_NONZERO || !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER)) ? 0 : points_sign_at(p, u);
    sign = beyond && points_beyond_has(beyond, u) ? 0 : sign;
    for (int i = 0; i < sides; i++)
        sign = side[i].function == u ? 0 : sign;
    return sign;
}

static void scratch_at(struct num_ball *scratch, const struct expr_store *st, const struct points_point *p)
{
    num_ball_init(scratch, st, p->ball.prec);
    for (int i = 0; i < st->symbols && (size_t)i < p->ball.symbol_cap; i++)
        num_ball_set(scratch, i, p->ball.symbol + i);
}

void points_sides_of(struct expr_store *st, struct points_point *p, expr_id e, const expr_id *list, int count,
                     const struct points_beyond *beyond, struct points_side **side, int *sides, size_t *cap)
{
    struct num_ball scratch = { 0 };
    struct expr_facts facts;
    expr_facts_init(&facts);
    for (int k = 0; k < count; k++) {
        const struct expr_node n = st->node[list[k]];
        if (!points_switches((enum expr_op)n.op))
            continue;
        expr_id u = surface(st, n);
        int sign = open_sign(st, &facts, p, u, beyond, *side, *sides);
        if (!sign)
            continue;
        if (!scratch.st)
            scratch_at(&scratch, st, p);
        if (zero_on_both(&scratch, e, list, count, &n, 1))
            continue;
        SGA_RESERVE(*side, *cap, *sides + 1);
        (*side)[(*sides)++] = (struct points_side){ u, sign, false };
    }
    expr_facts_clear(&facts);
    num_ball_clear(&scratch);
}

int points_pairs_of(const struct sga_budget *budget, struct expr_store *st, struct points_point *p, expr_id e, const expr_id *list, int count,
                    const struct points_beyond *beyond, const struct points_side *side, int sides, struct points_side (*pair)[2])
{
    struct expr_node key[POINTS_KEYS];
    struct points_side at[POINTS_KEYS];
    struct num_ball scratch = { 0 };
    struct expr_facts facts;
    int keys = 0, pairs = 0;
    expr_facts_init(&facts);
    for (int k = 0; k < count; k++) {
        expr_id u = points_surface(st, list[k]);
        int sign = u ? open_sign(st, &facts, p, u, beyond, side, sides) : 0;
        for (int i = 0; i < keys; i++)
            sign = at[i].function == u ? 0 : sign;
        if (!sign)
            continue;
        if (keys == POINTS_KEYS) {
            sga_limit_met(budget, SGA_LIMIT_SIDE_PAIRS);
            break;
        }
        key[keys] = st->node[list[k]];
        at[keys++] = (struct points_side){ u, sign, false };
    }
    if (keys > 1)
        scratch_at(&scratch, st, p);
    for (int i = 0; i < keys; i++)
        for (int j = i + 1; j < keys; j++) {
            const struct expr_node two[2] = { key[i], key[j] };
            if (zero_on_both(&scratch, e, list, count, two, 2))
                continue;
            pair[pairs][0] = at[i];
            pair[pairs++][1] = at[j];
        }
    expr_facts_clear(&facts);
    num_ball_clear(&scratch);
    return pairs;
}

bool points_on_sides(const struct expr_store *st, struct num_ball *b, const struct points_side *side, int sides)
{
    struct expr_cone cone;
    bool on = true;
    expr_cone_init(&cone);
    for (int i = 0; i < sides && on; i++) {
        expr_cone_of(st, &cone, &side[i].function, 1);
        num_ball_list(b, cone.list, cone.count);
        arb_srcptr v = num_ball_value(b, side[i].function);
        on = !arb_is_finite(v) || arb_contains_zero(v) || arb_is_positive(v) == (side[i].sign > 0);
    }
    expr_cone_clear(&cone);
    num_ball_forget(b);
    return on;
}

bool points_at_kink(const struct points_space *s, struct points_point *p)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    bool kink = false;
    expr_cone_init(&cone);
    expr_cone_of(s->st, &cone, s->constraint, s->constraints);
    num_ball_list(&p->ball, cone.list, cone.count);
    for (int k = 0; k < cone.count && !kink; k++) {
        const struct expr_node n = s->st->node[cone.list[k]];
        if (n.op == EXPR_ABS || n.op == EXPR_SIGN)
            kink = arb_contains_zero(num_ball_value(&p->ball, n.a));
        else if (n.op == EXPR_MIN || n.op == EXPR_MAX)
            kink = arb_overlaps(num_ball_value(&p->ball, n.a), num_ball_value(&p->ball, n.b));
    }
    num_ball_forget(&p->ball);
    return kink;
}
