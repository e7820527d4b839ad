/* The bridge: one pass over the roots' cone, children first. */
#include "bridge.h"

#include <stdlib.h>

#include "budget.h"
#include "error.h"
#include "facts.h"
#include "mem.h"

static struct poly_limits filled(const struct poly_limits *given)
{
    struct poly_limits l = given ? *given : (struct poly_limits){ 0 };
    l.max_terms = l.max_terms ? l.max_terms : 1000;
    if (l.budget && l.budget->max_terms && l.budget->max_terms < l.max_terms)
        l.max_terms = l.budget->max_terms;
    l.max_bits = l.max_bits ? l.max_bits : 20000;
    l.max_degree = l.max_degree ? l.max_degree : 400;
    l.max_generators = l.max_generators ? l.max_generators : 48;
    return l;
}

static bool is_kernel(enum expr_op op)
{
    return op == EXPR_PI || op == EXPR_SYM || op == EXPR_POW || op >= EXPR_SIN;
}

/* A context is a table for each size of a word, and nothing that is owned: those of few variables are made once. */
static void context(fmpz_mpoly_ctx_t ctx, int variables)
{
    enum { KEPT = 32 };
    static _Thread_local struct { bool made; fmpz_mpoly_ctx_t is; } kept[KEPT];
    if (variables >= KEPT) {
        fmpz_mpoly_ctx_init(ctx, variables, ORD_LEX);
        return;
    }
    if (!kept[variables].made)
        fmpz_mpoly_ctx_init(kept[variables].is, variables, ORD_LEX);
    kept[variables].made = true;
    *ctx = *kept[variables].is;
}

/* On what each node depends, where both sin or cos and tan stand on one argument, and
 * how many generators there can be at most. */
static int survey(struct poly_bridge *b)
{
    int most = 0;
    for (int i = 0; i < b->count; i++) {
        expr_id e = b->list[i];
        enum expr_op op = expr_op_of(b->st, e);
        unsigned d = 0;
        if (op == EXPR_SYM) {
            enum expr_symbol_kind kind = b->st->symbol[b->st->node[e].a].kind;
            d = kind == EXPR_PARAMETER ? EXPR_HAS_PARAMETER : kind == EXPR_TIME || kind == EXPR_SIGNAL ? EXPR_HAS_TIME : EXPR_HAS_VARIABLE;
        } else if (op == EXPR_SOLVE) {     /* may depend on anything */
            d = EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER;
        } else {
            for (int k = 0, n = expr_children(b->st, e); k < n; k++)
                d |= b->depends[b->cone.place[expr_child(b->st, e, k)]];
        }
        b->depends[i] = (unsigned char)d;
        if (op == EXPR_SIN || op == EXPR_COS)
            b->mark[b->cone.place[b->st->node[e].a]] |= POLY_TRIG;
        if (op == EXPR_SINH || op == EXPR_COSH)
            b->mark[b->cone.place[b->st->node[e].a]] |= POLY_HYPERBOLIC;
        most += is_kernel(op);
    }
    return most;
}

static bool convert(struct poly_bridge *b, expr_id e, unsigned depends, struct poly_ratio *r)
{
    const struct expr_node n = b->st->node[e];
    if (e == EXPR_UNDEF)
        return false;
    if (is_kernel((enum expr_op)n.op))
        return poly_kernel(b, e, depends, r);
    if (n.op == EXPR_CONST) {
        const fmpq *q = b->st->constant + n.a;
        if ((long)(fmpz_bits(fmpq_numref(q)) + fmpz_bits(fmpq_denref(q))) > b->limits.max_bits)
            return false;
        poly_ratio_fmpq(b, r, q);
        return true;
    }
    const struct poly_ratio *x = poly_value(b, n.a);
    const struct poly_ratio *y = expr_op_args((enum expr_op)n.op) == 2 ? poly_value(b, n.b) : x;
    if (!x || !y)
        return false;
    switch ((enum expr_op)n.op) {
    case EXPR_ADD:  return poly_ratio_add(b, r, x, y, false);
    case EXPR_SUB:  return poly_ratio_add(b, r, x, y, true);
    case EXPR_MUL:  return poly_ratio_mul(b, r, x, y);
    case EXPR_POWI: return poly_ratio_pow(b, r, x, n.b);
    case EXPR_NEG:
        poly_ratio_set(b, r, x);
        fmpz_mpoly_neg(r->num, r->num, b->ctx);
        return true;
    default:
        break;
    }
    struct poly_ratio inverse;
    poly_ratio_init(b, &inverse);
    bool ok = poly_ratio_inv(b, &inverse, y) && poly_ratio_mul(b, r, x, &inverse);
    poly_ratio_clear(b, &inverse);
    return ok;
}

static void convert_all(struct poly_bridge *b)
{
    struct sga_error before = *b->st->error, stop = { 0 };
    for (int i = 0; i < b->count; i++) {
        if (b->limits.budget && !sga_budget_ok(b->limits.budget, &stop))
            break;
        if (convert(b, b->list[i], b->depends[i], b->value + i))
            b->mark[i] |= POLY_KNOWN;
        *b->st->error = before;
    }
}

static void generators_clear(struct poly_bridge *b)
{
    for (int i = 0; i < b->bases; i++)
        fmpz_mpoly_clear(b->base[i].f, b->ctx);
    for (int g = 0; g < b->gens; g++) {
        fmpz_mpoly_clear(b->gen[g].p, b->ctx);
        fmpz_mpoly_clear(b->gen[g].q, b->ctx);
        fmpq_clear(b->gen[g].content);
    }
}

/* All but the steps, which the next pass begins with. */
static void forget(struct poly_bridge *b)
{
    generators_clear(b);
    b->bases = b->gens = b->relations = 0;
    b->finer = false;
    for (int i = 0; i < b->count; i++) {
        poly_ratio_clear(b, b->value + i);
        poly_ratio_init(b, b->value + i);
        b->mark[i] &= (unsigned char)~POLY_KNOWN;
    }
}

struct poly_bridge *poly_bridge_new(struct expr_store *st, const expr_id *roots, int nroots,
                                    const struct poly_limits *limits)
{
    struct poly_bridge *b = sga_calloc(1, sizeof *b);
    b->st = st;
    b->limits = filled(limits);
    SGA_AT_END(&b->mem, expr_cone_clear, &b->cone);
    if (expr_cone_above_solves(st, &b->cone, roots, nroots, b->limits.max_generators)) {       /* those are taken whole */
        expr_cone_index(&b->cone);
        b->list = b->cone.list;
        b->count = b->cone.count;
    }
    b->mark = sga_zeros(&b->mem, (size_t)b->count + 1, 1);
    b->depends = sga_zeros(&b->mem, (size_t)b->count + 1, 1);
    b->max_gens = survey(b);
    if (b->max_gens > b->limits.max_generators) {
        b->count = 0;
        b->max_gens = 0;
    }
    context(b->ctx, b->max_gens + 1);
    b->max_gens++;      /* FLINT wants one variable at least */
    b->gen = sga_zeros(&b->mem, (size_t)b->max_gens, sizeof *b->gen);
    b->value = sga_zeros(&b->mem, (size_t)b->count + 1, sizeof *b->value);
    for (int i = 0; i < b->count; i++)
        poly_ratio_init(b, b->value + i);
    if (b->count == 0 && nroots > 0) {
        poly_bridge_free(b);
        return NULL;
    }
    convert_all(b);
    for (int again = 0; again < POLY_MAX_STEPS && b->finer; again++) {
        forget(b);
        convert_all(b);
    }
    return b;
}

void poly_bridge_end(struct poly_bridge **b)
{
    poly_bridge_free(*b);
}

void poly_bridge_free(struct poly_bridge *b)
{
    if (!b)
        return;
    for (int i = 0; i < b->count; i++)
        poly_ratio_clear(b, b->value + i);
    generators_clear(b);
    for (int i = 0; i < b->steps; i++)
        fmpq_clear(b->step[i].content);
    fmpz_mpoly_ctx_clear(b->ctx);
    sga_arena_end(&b->mem);
    free(b);
}
