/* Like terms together, numbers folded, equal factors as powers, what all terms share in front: one pass
 * over the graph, children first. Nothing is multiplied out but constants over sums. */
#include "collect.h"

#include <stdlib.h>

#include "arena.h"
#include "error.h"
#include "flint_ends.h"
#include "raw_nodes.h"

/* Sums and products longer than this stay as they are; of one power, too. */
enum { MOST = 64, MOST_EXPONENT = 64 };

struct factor {
    expr_id base;
    long n;
};

struct product {
    fmpq_t number;
    struct factor factor[MOST];
    int factors;
};

struct term {
    fmpq_t number;
    expr_id base;          /* a product without a number; the constant 1 */
};

struct sum {
    struct term term[MOST];
    int terms;
};

static bool raise_by(fmpq_t r, const fmpq_t x, long n)
{
    if (n > MOST_EXPONENT || n < -MOST_EXPONENT || (n < 0 && fmpq_is_zero(x)))
        return false;
    SGA_ENDS(fmpq_end) fmpq_t p = { { 0, 1 } };
    fmpq_pow_si(p, x, n);
    fmpq_mul(r, r, p);
    return true;
}

static bool add_factor(struct product *p, expr_id base, long n)
{
    for (int i = 0; i < p->factors; i++)
        if (p->factor[i].base == base) {
            p->factor[i].n += n;
            return true;
        }
    if (p->factors == MOST)
        return false;
    p->factor[p->factors++] = (struct factor){ base, n };
    return true;
}

/* e^power into the product. */
static bool multiply(const struct expr_store *st, struct product *p, expr_id e, long power)
{
    struct factor stack[MOST];
    int depth = 0;
    bool ok = true;
    stack[depth++] = (struct factor){ e, power };
    while (depth && ok) {
        struct factor f = stack[--depth];
        const struct expr_node n = st->node[f.base];
        ok = depth + 2 <= MOST && f.n <= MOST_EXPONENT && f.n >= -MOST_EXPONENT;
        switch (ok ? (enum expr_op)n.op : EXPR_UNDEF_OP) {
        case EXPR_UNDEF_OP:
            ok = false;
            break;
        case EXPR_CONST:
            ok = raise_by(p->number, st->constant + n.a, f.n);
            break;
        case EXPR_NEG:
            if (f.n % 2)
                fmpq_neg(p->number, p->number);
            stack[depth++] = (struct factor){ n.a, f.n };
            break;
        case EXPR_MUL: case EXPR_DIV:
            stack[depth++] = (struct factor){ n.b, n.op == EXPR_MUL ? f.n : -f.n };
            stack[depth++] = (struct factor){ n.a, f.n };
            break;
        case EXPR_POWI:
            stack[depth++] = (struct factor){ n.a, f.n * n.b };
            break;
        default:
            ok = add_factor(p, f.base, f.n);
        }
    }
    return ok;
}

static int by_base(const void *x, const void *y)
{
    expr_id a = ((const struct factor *)x)->base, b = ((const struct factor *)y)->base;
    return (a > b) - (a < b);
}

/* Without its number. */
static expr_id product_of(struct expr_store *st, struct product *p)
{
    expr_id above = expr_int(st, 1), below = above;
    qsort(p->factor, (size_t)p->factors, sizeof *p->factor, by_base);
    for (int i = 0; i < p->factors; i++) {
        struct factor f = p->factor[i];
        if (f.n > 0)
            above = expr_mul(st, above, expr_powi(st, f.base, f.n));
        else if (f.n < 0)
            below = expr_mul(st, below, expr_powi(st, f.base, -f.n));
    }
    return expr_div(st, above, below);
}

static expr_id times(struct expr_store *st, const fmpq_t number, expr_id e)
{
    if (fmpq_sgn(number) >= 0)
        return expr_mul(st, expr_fmpq(st, number), e);
    SGA_ENDS(fmpq_end) fmpq_t minus = { { 0, 1 } };
    fmpq_neg(minus, number);
    e = expr_neg(st, expr_mul(st, expr_fmpq(st, minus), e));
    return e;
}

static expr_id collected_product(struct expr_store *st, expr_id e)
{
    struct product p = { .factors = 0 };
    fmpq_init(p.number);
    fmpq_one(p.number);
    if (multiply(st, &p, e, 1))
        e = times(st, p.number, product_of(st, &p));
    fmpq_clear(p.number);
    return e;
}

static bool add_term(struct sum *s, const fmpq_t number, expr_id base)
{
    for (int i = 0; i < s->terms; i++)
        if (s->term[i].base == base) {
            fmpq_add(s->term[i].number, s->term[i].number, number);
            return true;
        }
    if (s->terms == MOST)
        return false;
    fmpq_init(s->term[s->terms].number);
    fmpq_set(s->term[s->terms].number, number);
    s->term[s->terms++].base = base;
    return true;
}

/* number * e, no sum, into the sum. */
static bool add_product(struct expr_store *st, struct sum *s, const fmpq_t number, expr_id e)
{
    struct product p = { .factors = 0 };
    fmpq_init(p.number);
    fmpq_set(p.number, number);
    bool ok = multiply(st, &p, e, 1) && add_term(s, p.number, product_of(st, &p));
    fmpq_clear(p.number);
    return ok;
}

/* The terms of e, constants multiplied into sums. */
static bool add_terms(struct expr_store *st, struct sum *s, expr_id e)
{
    struct term stack[MOST + 2];
    int depth = 0;
    bool ok = true;
    fmpq_init(stack[0].number);
    fmpq_one(stack[0].number);
    stack[depth++].base = e;
    while (depth && ok) {
        struct term *t = stack + --depth;
        const struct expr_node n = st->node[t->base];
        expr_id child[2] = { EXPR_UNDEF, EXPR_UNDEF };
        fmpq_t number;
        fmpq_init(number);
        fmpq_set(number, t->number);
        expr_id here = t->base;
        fmpq_clear(t->number);
        if (n.op == EXPR_ADD || n.op == EXPR_SUB) {
            child[0] = n.a;
            child[1] = n.b;
        } else if (n.op == EXPR_NEG) {
            child[0] = n.a;
            fmpq_neg(number, number);
        } else if (n.op == EXPR_MUL && expr_is_const(st, n.a)) {
            child[0] = n.b;
            fmpq_mul(number, number, st->constant + st->node[n.a].a);
        } else {
            ok = add_product(st, s, number, here);
        }
        for (int k = 1; k >= 0; k--) {
            if (!child[k] || !(ok = ok && depth < MOST))
                continue;
            fmpq_init(stack[depth].number);
            fmpq_set(stack[depth].number, number);
            if (k && n.op == EXPR_SUB)
                fmpq_neg(stack[depth].number, stack[depth].number);
            stack[depth++].base = child[k];
        }
        fmpq_clear(number);
    }
    while (depth)
        fmpq_clear(stack[--depth].number);
    return ok;
}

/* What all terms have in common, above and below: `common` gets it. */
static bool shared(const struct expr_store *st, const struct sum *s, struct product *common)
{
    common->factors = 0;
    for (int i = 0; i < s->terms; i++) {
        struct product p = { .factors = 0 };
        fmpq_init(p.number);
        fmpq_one(p.number);
        bool ok = multiply(st, &p, s->term[i].base, 1);
        fmpq_clear(p.number);
        if (!ok)
            return false;
        for (int k = common->factors - 1; i && k >= 0; k--) {
            long n = 0, have = common->factor[k].n;
            for (int q = 0; q < p.factors; q++)
                n = p.factor[q].base == common->factor[k].base ? p.factor[q].n : n;
            n = have > 0 ? (n < have ? n : have) : (n > have ? n : have);
            if (n * have > 0)
                common->factor[k].n = n;
            else
                common->factor[k] = common->factor[--common->factors];
        }
        if (!i) {
            common->factors = p.factors;
            for (int k = 0; k < p.factors; k++)
                common->factor[k] = p.factor[k];
        }
        if (!common->factors)
            return false;
    }
    return s->terms > 1;
}

static int by_term(const void *x, const void *y)
{
    expr_id a = ((const struct term *)x)->base, b = ((const struct term *)y)->base;
    return (a > b) - (a < b);
}

static expr_id sum_of(struct expr_store *st, struct sum *s)
{
    struct product common;
    expr_id e = expr_int(st, 0), over = EXPR_UNDEF;
    qsort(s->term, (size_t)s->terms, sizeof *s->term, by_term);
    if (shared(st, s, &common))
        over = product_of(st, &common);
    for (int i = 0; i < s->terms; i++) {
        expr_id base = over ? collected_product(st, expr_div(st, s->term[i].base, over)) : s->term[i].base;
        e = expr_add(st, e, times(st, s->term[i].number, base));
    }
    return over ? collected_product(st, expr_mul(st, over, e)) : e;
}

static expr_id collected_sum(struct expr_store *st, expr_id e)
{
    struct sum s = { .terms = 0 };
    int kept = 0;
    bool ok = add_terms(st, &s, e);
    for (int i = 0; i < s.terms; i++) {
        if (fmpq_is_zero(s.term[i].number))
            fmpq_clear(s.term[i].number);
        else
            s.term[kept++] = s.term[i];
    }
    s.terms = kept;
    if (ok)
        e = sum_of(st, &s);
    for (int i = 0; i < s.terms; i++)
        fmpq_clear(s.term[i].number);
    return e;
}

enum kind { ATOM, SUM, PRODUCT };

static enum kind kind_of(const struct expr_store *st, expr_id e)
{
    const struct expr_node n = st->node[e];
    switch ((enum expr_op)n.op) {
    case EXPR_ADD: case EXPR_SUB: return SUM;
    case EXPR_NEG: return kind_of(st, n.a) == SUM ? SUM : PRODUCT;
    case EXPR_MUL: case EXPR_DIV: case EXPR_POWI: return PRODUCT;
    default: return ATOM;
    }
}

/* A part of a longer sum or product is collected with that. */
static void mark_tops(const struct expr_store *st, const struct expr_cone *c, const expr_id *root, int roots, unsigned char *top)
{
    for (int i = 0; i < roots; i++)
        top[root[i]] = 1;
    for (int i = 0; i < c->count; i++) {
        expr_id e = c->list[i];
        enum kind kind = kind_of(st, e);
        for (int k = 0, n = expr_children(st, e); k < n; k++)
            if (kind == ATOM || kind_of(st, expr_child(st, e, k)) != kind)
                top[expr_child(st, e, k)] = 1;
    }
}

void expr_collect(struct expr_store *st, expr_id *root, int roots)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone c;
    struct sga_error before = *st->error;
    int nodes = st->nodes;
    SGA_ARENA(mem);
    unsigned char *top = sga_zeros(&mem, (size_t)nodes, 1);
    expr_id *to = sga_take(&mem, (size_t)nodes * sizeof *to), *none = sga_zeros(&mem, (size_t)st->symbols + 1, sizeof *none);
    expr_cone_init(&c);
    expr_cone_of(st, &c, root, roots);
    mark_tops(st, &c, root, roots, top);
    for (int i = 0; i < c.count; i++) {
        expr_id e = c.list[i], was = expr_rebuild(st, st, e, to, none), is = was;
        enum kind kind = was ? kind_of(st, was) : ATOM;
        if (top[e] && kind == SUM)
            is = collected_sum(st, was);
        else if (top[e] && kind == PRODUCT)
            is = collected_product(st, was);
        to[e] = is && expr_store_ok(st) ? is : was ? was : e;
        *st->error = before;
    }
    for (int i = 0; i < roots; i++)
        root[i] = to[root[i]];
}

expr_id expr_collect_times(struct expr_store *st, const fmpq_t number, expr_id e)
{
    expr_collect(st, &e, 1);
    bool sum = kind_of(st, e) == SUM;
    e = times(st, number, e);
    return e && sum ? collected_sum(st, e) : e;
}
