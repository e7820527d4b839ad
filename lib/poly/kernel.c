/* Generators: symbols and kernels, found again by their normalised arguments. */
#include <assert.h>

#include "bridge.h"

#include "arena.h"
#include "flint_ends.h"
#include "mpoly_take.h"

enum { LARGEST_ROOT = 64, OPAQUE = -1 /* as second key */ };

/* An argument in normal form: node = sign * key, key with a positive leading
 * coefficient. Where the normal form is over budget both are the raw child. */
struct argument {
    expr_id node, key;
    int sign;
    bool normal;                   /* fraction is valid: the value of node */
    struct poly_fraction fraction;
};

static void argument_of(struct poly_bridge *b, expr_id child, struct argument *a)
{
    const struct poly_ratio *r = poly_value(b, child);
    *a = (struct argument){ .node = child, .key = child, .sign = 1 };
    a->normal = r && poly_fraction_of(b, r, &a->fraction);
    if (!a->normal || expr_children(b->st, child) == 0)
        return;
    expr_id node, key;
    bool ok = poly_show(b, &a->fraction, &node);
    int sign = a->fraction.num->length > 0 && fmpz_sgn(a->fraction.num->coeffs) < 0 ? -1 : 1;
    key = node;
    if (ok && sign < 0) {
        fmpz_mpoly_neg(a->fraction.num, a->fraction.num, b->ctx);
        ok = poly_show(b, &a->fraction, &key);
        fmpz_mpoly_neg(a->fraction.num, a->fraction.num, b->ctx);
    }
    if (ok) {
        a->node = node;
        a->key = key;
        a->sign = sign;
    }
}

static void argument_clear(struct poly_bridge *b, struct argument *a)
{
    if (a->normal)
        poly_fraction_clear(b, &a->fraction);
}

static int find(const struct poly_bridge *b, enum expr_op op, expr_id key, expr_id key2)
{
    for (int g = 0; g < b->gens; g++)
        if (b->gen[g].op == op && b->gen[g].key == key && b->gen[g].key2 == key2)
            return g;
    return -1;
}

int poly_generator_add(struct poly_bridge *b, struct poly_generator g)
{
    assert(g.degree >= 0 && g.root >= 0);
    if (b->gens == b->max_gens)
        return -1;
    g.partner = g.in_base = -1;
    if (!g.flip)
        g.flip = 1;
    fmpq_init(g.content);
    fmpz_mpoly_init(g.p, b->ctx);
    fmpz_mpoly_init(g.q, b->ctx);
    b->gen[b->gens] = g;
    return b->gens++;
}

static bool signed_generator(struct poly_bridge *b, int g, int sign, struct poly_ratio *r)
{
    if (g < 0)
        return false;
    poly_ratio_gen(b, r, g);
    if (sign < 0)
        fmpz_mpoly_neg(r->num, r->num, b->ctx);
    return true;
}

/* A node that nothing is known of but that it equals itself. */
static bool opaque(struct poly_bridge *b, expr_id e, unsigned depends, struct poly_ratio *r)
{
    enum expr_op op = expr_op_of(b->st, e);
    int g = find(b, op, e, OPAQUE);
    if (g < 0) {
        bool positive = op == EXPR_PI || op == EXPR_EXP || op == EXPR_COSH;
        g = poly_generator_add(b, (struct poly_generator){
            .node = e, .op = op, .key = e, .key2 = OPAQUE, .depends = depends,
            .sign = positive ? POLY_POSITIVE : POLY_ANY });
    }
    return signed_generator(b, g, 1, r);
}

static bool odd(enum expr_op op)
{
    return expr_op_traits(op) & EXPR_IS_ODD;
}

static bool even(enum expr_op op)
{
    return expr_op_traits(op) & EXPR_IS_EVEN;
}

/* The denominator of a fraction as one polynomial, scale included. */
static bool whole_denominator(struct poly_bridge *b, const struct poly_fraction *f, fmpz_mpoly_t q)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_set_fmpz(q, f->scale, b->ctx);
    bool ok = true;
    for (int i = 0; ok && i < f->dens; i++)
        ok = poly_pow(b, t, f->den[i].f, f->den[i].n) && poly_mul(b, q, q, t);
    return ok;
}

/* g^degree = the argument^power: of roots (power 1) and absolute values (2). */
static void relate_to_argument(struct poly_bridge *b, int g, const struct argument *a, int degree, int power, bool negate)
{
    struct poly_generator *x = b->gen + g;
    if (!a->normal || !whole_denominator(b, &a->fraction, x->q) || !poly_pow(b, x->p, a->fraction.num, power)
        || !poly_pow(b, x->q, x->q, power))
        return;
    if (negate)
        fmpz_mpoly_neg(x->p, x->p, b->ctx);
    x->degree = degree;
    b->relations++;
}

/* sin^2 = 1 - cos^2, sinh^2 = cosh^2 - 1, once both are there. */
static void relate_pair(struct poly_bridge *b, enum expr_op s_op, enum expr_op c_op, expr_id key)
{
    int s = find(b, s_op, key, 0), c = find(b, c_op, key, 0);
    if (s < 0 || c < 0)
        return;
    struct poly_generator *x = b->gen + s;
    fmpz_mpoly_one(x->q, b->ctx);
    fmpz_mpoly_gen(x->p, c, b->ctx);
    fmpz_mpoly_mul(x->p, x->p, x->p, b->ctx);
    fmpz_mpoly_sub(x->p, x->q, x->p, b->ctx);
    if (s_op == EXPR_SINH)
        fmpz_mpoly_neg(x->p, x->p, b->ctx);
    x->partner = c;
    x->degree = 2;
    b->relations++;
}

static enum poly_sign sign_of_function(struct poly_bridge *b, enum expr_op op, const struct argument *a)
{
    unsigned is = expr_op_traits(op);
    if (!(is & EXPR_IS_ABOVE))
        return POLY_ANY;
    if (is & EXPR_IS_NOT_ZERO)
        return POLY_POSITIVE;
    if (!(is & EXPR_BENDS_AT_0))
        return POLY_NONNEGATIVE;
    bool negative;
    if (a->normal && poly_sign_of(b, a->fraction.num, &negative) == POLY_POSITIVE)
        return POLY_POSITIVE;
    return POLY_NONNEGATIVE;
}

/* The generator of op(a), and the sign with op(a) = sign * generator; -1: the store
 * simplified it to something else. */
static int function_generator(struct poly_bridge *b, enum expr_op op, const struct argument *a, unsigned depends, int *sign)
{
    expr_id key = odd(op) || even(op) ? a->key : a->node;
    int own = odd(op) ? a->sign : 1, g = find(b, op, key, 0);
    if (g < 0) {
        expr_id node = expr_fun(b->st, op, a->node);
        bool negated = expr_op_of(b->st, node) == EXPR_NEG;
        if (negated)
            node = b->st->node[node].a;
        if (expr_op_of(b->st, node) != op)
            return -1;
        g = poly_generator_add(b, (struct poly_generator){
            .node = node, .op = op, .key = key, .depends = depends,
            .flip = negated ? -own : own, .sign = sign_of_function(b, op, a) });
        if (g < 0)
            return -1;
        if (op == EXPR_SQRT || op == EXPR_CBRT)
            relate_to_argument(b, g, a, op == EXPR_SQRT ? 2 : 3, 1, negated);
        else if (op == EXPR_ABS)
            relate_to_argument(b, g, a, 2, 2, false);
        else if (op == EXPR_SIN || op == EXPR_COS)
            relate_pair(b, EXPR_SIN, EXPR_COS, key);
        else if (op == EXPR_SINH || op == EXPR_COSH)
            relate_pair(b, EXPR_SINH, EXPR_COSH, key);
    }
    *sign = own * b->gen[g].flip;
    return g;
}

/* tan = sin/cos, tanh = sinh/cosh */
static bool quotient(struct poly_bridge *b, bool circular, const struct argument *a, unsigned depends, struct poly_ratio *r)
{
    struct poly_ratio s, c, ci;
    int sign_s = 1, sign_c = 1;
    int gs = function_generator(b, circular ? EXPR_SIN : EXPR_SINH, a, depends, &sign_s);
    int gc = function_generator(b, circular ? EXPR_COS : EXPR_COSH, a, depends, &sign_c);
    poly_ratio_init(b, &s);
    poly_ratio_init(b, &c);
    poly_ratio_init(b, &ci);
    bool ok = signed_generator(b, gs, sign_s, &s) && signed_generator(b, gc, sign_c, &c)
        && poly_ratio_inv(b, &ci, &c) && poly_ratio_mul(b, r, &s, &ci);
    poly_ratio_clear(b, &s);
    poly_ratio_clear(b, &c);
    poly_ratio_clear(b, &ci);
    return ok;
}

static bool one_argument(struct poly_bridge *b, expr_id e, unsigned depends, struct poly_ratio *r)
{
    enum expr_op op = expr_op_of(b->st, e);
    expr_id child = b->st->node[e].a;
    unsigned mark = b->mark[b->cone.place[child]];
    struct argument a;
    argument_of(b, child, &a);
    bool ok;
    if ((op == EXPR_TAN && (mark & POLY_TRIG)) || (op == EXPR_TANH && (mark & POLY_HYPERBOLIC))) {
        ok = quotient(b, op == EXPR_TAN, &a, depends, r);
    } else {
        int sign = 1, g = function_generator(b, op, &a, depends, &sign);
        ok = signed_generator(b, g, sign, r);
    }
    argument_clear(b, &a);
    return ok;
}

/* The content of the generator for exp(c key): that of the step for the key, made finer where c is no multiple of it. */
static void step_for(struct poly_bridge *b, expr_id key, const fmpq_t c, fmpq_t content)
{
    enum { BITS = 8 };
    SGA_ENDS(fmpq_end) fmpq_t times = { { 0, 1 } }, most = { { 0, 1 } };
    int i = 0;
    fmpq_abs(content, c);
    while (i < b->steps && b->step[i].key != key)
        i++;
    if (i >= POLY_MAX_STEPS)
        return;
    struct poly_step *s = b->step + i;
    if (i == b->steps) {
        *s = (struct poly_step){ .key = key };
        fmpq_init(s->content);
        fmpq_set(s->content, content);
        b->steps++;
        return;
    }
    fmpq_gcd(times, s->content, content);
    fmpq_set(most, s->content);
    fmpq_div(most, most, times);
    bool near = fmpz_bits(fmpq_numref(most)) < BITS;
    fmpq_div(most, content, times);
    near = near && fmpz_bits(fmpq_numref(most)) < BITS;
    if (near && !fmpq_equal(times, s->content)) {
        fmpq_set(s->content, times);
        b->finer = true;
    }
    if (near)
        fmpq_set(content, s->content);
}

/* exp(k u) = exp(u)^k: the argument's rational content is split off. */
static bool exponential(struct poly_bridge *b, expr_id e, unsigned depends, struct poly_ratio *r)
{
    struct argument a;
    argument_of(b, b->st->node[e].a, &a);
    bool ok = a.normal && a.fraction.num->length > 0;
    expr_id key = EXPR_UNDEF;
    SGA_ENDS(fmpq_end) fmpq_t content = { { 0, 1 } }, times = { { 0, 1 } };
    if (ok) {
        struct poly_fraction *f = &a.fraction;
        poly_content(fmpq_numref(content), f->num);
        fmpz_set(fmpq_denref(content), f->scale);
        fmpz_mpoly_scalar_divexact_fmpz(f->num, f->num, fmpq_numref(content), b->ctx);
        fmpz_one(f->scale);
        if (a.fraction.num->length > 0 && fmpz_sgn(f->num->coeffs) < 0) {
            fmpz_mpoly_neg(f->num, f->num, b->ctx);
            fmpq_neg(content, content);
        }
        ok = poly_show(b, f, &key);
    }
    int g = -1;
    for (int i = 0; ok && i < b->gens && g < 0; i++) {
        if (b->gen[i].op != EXPR_EXP || b->gen[i].key != key || b->gen[i].key2 == OPAQUE)
            continue;
        fmpq_div(times, content, b->gen[i].content);
        if (fmpz_is_one(fmpq_denref(times)) && fmpz_cmpabs(fmpq_numref(times), fmpq_denref(times)) >= 0
            && fmpz_bits(fmpq_numref(times)) < 8)
            g = i;
    }
    if (ok && g < 0) {
        SGA_ENDS(fmpq_end) fmpq_t own = { { 0, 1 } };
        step_for(b, key, content, own);
        fmpq_div(times, content, own);
        fmpq_swap(content, own);
        expr_id node = expr_fun(b->st, EXPR_EXP, expr_mul(b->st, expr_fmpq(b->st, content), key));
        ok = expr_op_of(b->st, node) == EXPR_EXP;
        if (ok) {
            g = poly_generator_add(b, (struct poly_generator){
                .node = node, .op = EXPR_EXP, .key = key, .key2 = node, .depends = depends, .sign = POLY_POSITIVE });
            ok = g >= 0;
        }
        if (ok)
            fmpq_set(b->gen[g].content, content);
    }
    if (ok) {
        struct poly_ratio u;
        poly_ratio_init(b, &u);
        poly_ratio_gen(b, &u, g);
        ok = poly_ratio_pow(b, r, &u, fmpz_get_si(fmpq_numref(times)));
        poly_ratio_clear(b, &u);
    }
    argument_clear(b, &a);
    return ok;
}

/* base^(k/n) = (base^(1/n))^k */
static bool rational_power(struct poly_bridge *b, expr_id e, const fmpq *exponent, unsigned depends, struct poly_ratio *r)
{
    if (fmpz_cmp_ui(fmpq_denref(exponent), LARGEST_ROOT) > 0 || fmpz_bits(fmpq_numref(exponent)) > 10)
        return false;
    long n = fmpz_get_si(fmpq_denref(exponent)), k = fmpz_get_si(fmpq_numref(exponent));
    struct argument a;
    argument_of(b, b->st->node[e].a, &a);
    expr_id root = expr_rational(b->st, 1, n);
    int g = find(b, EXPR_POW, a.node, root);
    if (g < 0) {
        expr_id node = expr_pow(b->st, a.node, root);
        if (expr_op_of(b->st, node) == EXPR_POW) {
            g = poly_generator_add(b, (struct poly_generator){
                .node = node, .op = EXPR_POW, .key = a.node, .key2 = root, .base = a.node, .root = n,
                .depends = depends, .sign = sign_of_function(b, EXPR_POW, &a) });
            if (g >= 0)
                relate_to_argument(b, g, &a, (int)n, 1, false);
        }
    }
    bool ok = g >= 0;
    if (ok) {
        struct poly_ratio u;
        poly_ratio_init(b, &u);
        poly_ratio_gen(b, &u, g);
        ok = poly_ratio_pow(b, r, &u, k);
        poly_ratio_clear(b, &u);
    }
    argument_clear(b, &a);
    return ok;
}

/* POW, ATAN2, MIN, MAX */
static bool two_arguments(struct poly_bridge *b, expr_id e, unsigned depends, struct poly_ratio *r)
{
    const struct expr_node n = b->st->node[e];
    enum expr_op op = (enum expr_op)n.op;
    struct argument a, c;
    argument_of(b, n.a, &a);
    argument_of(b, n.b, &c);
    expr_id node = op == EXPR_POW ? expr_pow(b->st, a.node, c.node) : expr_fun2(b->st, op, a.node, c.node);
    bool ok = expr_op_of(b->st, node) == op;
    if (ok) {       /* the store has put the arguments of min and max into one order */
        expr_id x = b->st->node[node].a, y = b->st->node[node].b;
        int g = find(b, op, x, y);
        if (g < 0)
            g = poly_generator_add(b, (struct poly_generator){
                .node = node, .op = op, .key = x, .key2 = y, .depends = depends,
                .sign = sign_of_function(b, op, &a) });
        ok = signed_generator(b, g, 1, r);
    }
    argument_clear(b, &a);
    argument_clear(b, &c);
    return ok;
}

bool poly_kernel(struct poly_bridge *b, expr_id e, unsigned depends, struct poly_ratio *r)
{
    const struct expr_node n = b->st->node[e];
    bool ok = false;
    if (n.op == EXPR_EXP)
        ok = exponential(b, e, depends, r);
    else if (n.op == EXPR_POW && expr_is_const(b->st, n.b))
        ok = rational_power(b, e, expr_const_value(b->st, n.b), depends, r);
    else if (expr_op_args((enum expr_op)n.op) == 2)
        ok = two_arguments(b, e, depends, r);
    else if (n.op >= EXPR_SIN && n.op <= EXPR_MAX)
        ok = one_argument(b, e, depends, r);
    return ok || opaque(b, e, depends, r);
}
