/* Interval rules with exact ends. */
#include "range.h"

#include <stdlib.h>

#include "ball.h"
#include "op.h"
#include "poly.h"

static const struct range everything = { EXPR_UNDEF, EXPR_UNDEF, false, false };

int range_compare(struct expr_store *st, expr_id a, expr_id b)
{
    if (a == b)
        return 0;
    if (expr_is_const(st, a) && expr_is_const(st, b))
        return fmpq_cmp(expr_const_value(st, a), expr_const_value(st, b));
    expr_id d = expr_sub(st, a, b);
    if (!d || expr_is_zero(st, d))
        return d ? 0 : RANGE_UNKNOWN;
    struct num_ball ball;
    struct expr_cone cone;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &d, 1);
    num_ball_init(&ball, st, 1000);
    num_ball_list(&ball, cone.list, cone.count);
    arb_srcptr v = num_ball_value(&ball, d);
    int sign = !arb_is_finite(v) || arb_contains_zero(v) ? RANGE_UNKNOWN : arb_is_positive(v) ? 1 : -1;
    bool near = arb_is_finite(v) && arb_contains_zero(v);
    num_ball_clear(&ball);
    expr_cone_clear(&cone);
    struct poly_limits limits = poly_limits_of(POLY_SMALL, NULL);
    return near && poly_is_zero(st, d, &limits) == POLY_YES ? 0 : sign;
}

static bool at_least(struct expr_store *st, expr_id a, long v)
{
    int c = a ? range_compare(st, a, expr_int(st, v)) : RANGE_UNKNOWN;
    return c == 0 || c == 1;
}

static bool at_most(struct expr_store *st, expr_id a, long v)
{
    int c = a ? range_compare(st, a, expr_int(st, v)) : RANGE_UNKNOWN;
    return c == 0 || c == -1;
}

static struct range negated(struct expr_store *st, struct range r)
{
    return (struct range){ r.hi ? expr_neg(st, r.hi) : r.hi, r.lo ? expr_neg(st, r.lo) : r.lo, r.hi_in, r.lo_in };
}

static struct range sum(struct expr_store *st, struct range a, struct range b)
{
    struct range r = everything;
    if (a.lo && b.lo) {
        r.lo = expr_add(st, a.lo, b.lo);
        r.lo_in = a.lo_in && b.lo_in;
    }
    if (a.hi && b.hi) {
        r.hi = expr_add(st, a.hi, b.hi);
        r.hi_in = a.hi_in && b.hi_in;
    }
    return r;
}

/* Least and greatest of constants that can be compared; false where some cannot. */
static bool hull(struct expr_store *st, const expr_id *v, int n, struct range *r)
{
    *r = (struct range){ v[0], v[0], true, true };
    for (int i = 1; i < n; i++) {
        int low = range_compare(st, v[i], r->lo), high = range_compare(st, v[i], r->hi);
        if (low == RANGE_UNKNOWN || high == RANGE_UNKNOWN)
            return false;
        r->lo = low < 0 ? v[i] : r->lo;
        r->hi = high > 0 ? v[i] : r->hi;
    }
    return true;
}

static struct range product(struct expr_store *st, struct range a, struct range b)
{
    struct range r = everything;
    if (a.lo && a.hi && b.lo && b.hi) {
        expr_id v[4] = { expr_mul(st, a.lo, b.lo), expr_mul(st, a.lo, b.hi), expr_mul(st, a.hi, b.lo), expr_mul(st, a.hi, b.hi) };
        return hull(st, v, 4, &r) ? r : everything;
    }
    for (int k = 0; k < 2; k++) {              /* a constant factor keeps one bound */
        struct range c = k ? b : a, x = k ? a : b;
        if (!c.lo || c.lo != c.hi)
            continue;
        if (!at_least(st, c.lo, 0)) {
            if (!at_most(st, c.lo, 0))
                return r;
            c = negated(st, c);
            x = negated(st, x);
        }
        r = x;
        r.lo = x.lo ? expr_mul(st, c.lo, x.lo) : x.lo;
        r.hi = x.hi ? expr_mul(st, c.lo, x.hi) : x.hi;
        return r;
    }
    bool pa = at_least(st, a.lo, 0), pb = at_least(st, b.lo, 0), na = at_most(st, a.hi, 0), nb = at_most(st, b.hi, 0);
    if (pa && pb)
        return (struct range){ expr_mul(st, a.lo, b.lo), EXPR_UNDEF, a.lo_in || b.lo_in, false };
    if ((pa && nb) || (na && pb))
        r.hi = expr_int(st, 0);
    else if (na && nb)
        r.lo = expr_int(st, 0);
    r.lo_in = r.hi_in = true;
    return r;
}

/* |u|^n or an even power, n >= 1 */
static struct range folded(struct expr_store *st, struct range a, long n)
{
    if (at_most(st, a.hi, 0))
        a = negated(st, a);
    struct range r = { expr_int(st, 0), EXPR_UNDEF, true, false };
    if (at_least(st, a.lo, 0)) {
        r.lo = n > 20 ? r.lo : expr_powi(st, a.lo, n);
        r.lo_in = a.lo_in;
        r.hi = a.hi && n <= 20 ? expr_powi(st, a.hi, n) : EXPR_UNDEF;
        r.hi_in = a.hi_in;
    } else if (a.lo && a.hi && n <= 20) {
        int c = range_compare(st, expr_neg(st, a.lo), a.hi);
        if (c != RANGE_UNKNOWN)
            r.hi = expr_powi(st, c > 0 ? expr_neg(st, a.lo) : a.hi, n);
        r.hi_in = a.lo_in || a.hi_in;
    }
    return r;
}

static struct range power(struct expr_store *st, struct range a, long n)
{
    if (n < 0)
        return n % 2 ? everything : (struct range){ expr_int(st, 0), EXPR_UNDEF, false, false };
    if (n % 2 == 0)
        return folded(st, a, n);
    struct range r = a;
    r.lo = a.lo && n <= 20 ? expr_powi(st, a.lo, n) : EXPR_UNDEF;
    r.hi = a.hi && n <= 20 ? expr_powi(st, a.hi, n) : EXPR_UNDEF;
    return r;
}

static struct range of_interval(struct expr_store *st, const struct expr_interval *i)
{
    return (struct range){ i->has_low ? expr_interval_end(st, i, false) : EXPR_UNDEF, i->has_high ? expr_interval_end(st, i, true) : EXPR_UNDEF,
                           i->has_low && i->closed, i->has_high && i->closed };
}

/* Whether the function has a value at the end of its argument's range, and one that says something: a cube root only that of 0. */
static bool takes(struct expr_store *st, enum expr_op op, expr_id end)
{
    const struct expr_interval *domain = expr_op_domain(op);
    if (!end || domain->has_high || (op == EXPR_CBRT && !expr_is_zero(st, end)))
        return false;
    if (!domain->has_low)
        return true;
    return domain->closed ? at_least(st, end, domain->low) : range_compare(st, end, expr_int(st, domain->low)) == 1;
}

/* Of a function of one argument in the range a. */
static struct range of_function(struct expr_store *st, enum expr_op op, struct range a)
{
    struct range r = of_interval(st, expr_op_values(op));
    if (!(expr_op_traits(op) & EXPR_GROWS))
        return r;
    if (takes(st, op, a.lo)) {
        r.lo = expr_fun(st, op, a.lo);
        r.lo_in = a.lo_in;
    }
    if (takes(st, op, a.hi)) {
        r.hi = expr_fun(st, op, a.hi);
        r.hi_in = a.hi_in;
    }
    return r;
}

static struct range extreme(struct expr_store *st, struct range a, struct range b, bool max)
{
    if (max)
        return negated(st, extreme(st, negated(st, a), negated(st, b), false));
    struct range r = everything;
    int c = a.lo && b.lo ? range_compare(st, a.lo, b.lo) : RANGE_UNKNOWN;
    if (c != RANGE_UNKNOWN) {
        r.lo = c <= 0 ? a.lo : b.lo;
        r.lo_in = true;
    }
    c = a.hi && b.hi ? range_compare(st, a.hi, b.hi) : RANGE_UNKNOWN;
    if (c != RANGE_UNKNOWN || !a.hi || !b.hi) {
        r.hi = !a.hi ? b.hi : !b.hi ? a.hi : c <= 0 ? a.hi : b.hi;
        r.hi_in = true;
    }
    return r;
}

static struct range of_node(struct expr_store *st, expr_id e, unsigned facts, struct range x, struct range y)
{
    const struct expr_node n = st->node[e];
    if (!(facts & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER)))
        return (struct range){ e, e, true, true };
    switch ((enum expr_op)n.op) {
    case EXPR_ADD: return sum(st, x, y);
    case EXPR_SUB: return sum(st, x, negated(st, y));
    case EXPR_NEG: return negated(st, x);
    case EXPR_MUL: return n.a == n.b ? folded(st, x, 2) : product(st, x, y);
    case EXPR_DIV: return y.lo && y.lo == y.hi ? product(st, x, (struct range){ expr_div(st, expr_int(st, 1), y.lo), expr_div(st, expr_int(st, 1), y.lo), true, true }) : everything;
    case EXPR_POWI: return power(st, x, n.b);
    case EXPR_ABS: return folded(st, x, 1);
    case EXPR_MIN: return extreme(st, x, y, false);
    case EXPR_MAX: return extreme(st, x, y, true);
    default: return of_function(st, (enum expr_op)n.op, x);
    }
}

void range_of_list(struct expr_store *st, struct expr_facts *facts, const expr_id *list, int count,
                   const int *place, struct range *range)
{
    for (int k = 0; k < count; k++) {
        const struct expr_node n = st->node[list[k]];
        int args = expr_op_args((enum expr_op)n.op);
        struct range x = args > 0 ? range[place[n.a]] : everything, y = args > 1 ? range[place[n.b]] : everything;
        range[k] = of_node(st, list[k], expr_facts_of(facts, st, list[k]), x, y);
    }
}
