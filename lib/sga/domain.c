/* Zeros at which the equations have no value. */
#include "domain.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "facts.h"
#include "mem.h"
#include "modmatch.h"
#include "modpoint.h"
#include "poly.h"
#include "seeds.h"
#include "set_points.h"
#include "system.h"

expr_id domain_divisor(const struct expr_store *st, expr_id e)
{
    const struct expr_node n = st->node[e];
    if (n.op == EXPR_LOG)
        return n.a;
    if (n.op == EXPR_POW && expr_is_const(st, n.b) && fmpq_sgn(expr_const_value(st, n.b)) < 0)
        return n.a;
    return expr_divisor(st, e);
}

static bool open_end(const struct expr_store *st, const struct expr_node *n)
{
    return n->op == EXPR_POW && (!expr_is_const(st, n->b) || fmpq_sgn(expr_const_value(st, n->b)) <= 0);
}

/* e = 0 in simpler words, by what it is made of: sqrt(u), abs(u), u^2 are 0 where u is, log(u) where u - 1 is. A product
 * has two parts: the other one is *other, otherwise EXPR_UNDEF. */
static expr_id simpler(struct expr_store *st, expr_id e, expr_id *other)
{
    const struct expr_node n = st->node[e];
    *other = EXPR_UNDEF;
    switch ((enum expr_op)n.op) {
    case EXPR_MUL:
        *other = n.b;
        return n.a;
    case EXPR_LOG:
        return expr_sub(st, n.a, expr_int(st, 1));
    case EXPR_POWI:
        return n.b > 0 ? n.a : e;
    case EXPR_POW:
        return open_end(st, &n) ? e : n.a;
    case EXPR_NEG: case EXPR_DIV: case EXPR_SQRT: case EXPR_CBRT: case EXPR_ABS: case EXPR_SIGN: case EXPR_SINH:
    case EXPR_TANH: case EXPR_ASIN: case EXPR_ATAN: case EXPR_ASINH: case EXPR_ATANH:
        return n.a;
    default:
        return e;
    }
}

/* e and its factors, those that may vanish, each once, as many as there is room for. */
static void add_divisor(struct domain *d, expr_id e, expr_id *list, int *count)
{
    enum { ROOM = 16 };
    struct expr_store *st = d->system->store;
    expr_id stack[ROOM], other;
    int depth = 0;
    stack[depth++] = e;
    while (depth) {
        expr_id top = stack[--depth], next = top;
        for (; next && depth < ROOM; top = next) {
            next = simpler(st, top, &other);
            if (other)
                stack[depth++] = other;
            if (next == top)
                break;
        }
        bool known = !top || expr_is_const(st, top) || expr_facts_of(d->facts, st, top) & EXPR_NONZERO;
        for (int k = 0; k < *count && !known; k++)
            known = list[k] == top;
        d->cut |= !known && *count == DOMAIN_MOST;
        if (!known && *count < DOMAIN_MOST)
            list[(*count)++] = top;
    }
}

/* The divisors below the roots. */
static void divisors_of(struct domain *d, const expr_id *root, int roots, expr_id *list, int *count)
{
    const struct expr_store *st = d->system->store;
    bool before = d->cut;
    d->cut = false;
    expr_cone_of(st, d->cone, root, roots);
    for (int i = 0; i < d->cone->count && !d->cut; i++) {
        expr_id e = domain_divisor(st, d->cone->list[i]);
        if (e && !expr_is_const(st, e) && !(expr_facts_of(d->facts, st, e) & EXPR_NONZERO))
            add_divisor(d, e, list, count);
    }
    d->cut |= before;
}

static void know_divisors(struct domain *d)
{
    SGA_FREED expr_id *root = NULL;
    if (d->known)
        return;
    int roots = sys_expressions(d->system, &root);
    divisors_of(d, root, roots, d->divisor, &d->divisors);
    divisors_of(d, d->system->restriction, d->system->restrictions, d->divisor, &d->divisors);
    d->known = true;
}

/* Symbols below the roots: marks them, or tells whether any is marked. */
static bool symbols(struct domain *d, const expr_id *root, int roots, unsigned char *mark, bool set)
{
    const struct expr_store *st = d->system->store;
    bool any = false;
    expr_cone_of(st, d->cone, root, roots);
    for (int i = 0; i < d->cone->count; i++) {
        const struct expr_node *n = st->node + d->cone->list[i];
        if (n->op != EXPR_SYM)
            continue;
        any |= mark[n->a];
        mark[n->a] |= set;
    }
    return any;
}

/* Marks what f[0 .. own) are made with, and what is tied to it by the others. */
static void mark_tied(struct domain *d, const expr_id *f, int own, int count, unsigned char *mark)
{
    bool more = true;
    SGA_FREED bool *in = sga_calloc((size_t)count + 1, sizeof *in);
    symbols(d, f, own, mark, true);
    while (more) {
        more = false;
        for (int i = own; i < count; i++)
            if (!in[i] && symbols(d, f + i, 1, mark, false)) {
                symbols(d, f + i, 1, mark, true);
                in[i] = more = true;
            }
    }
}

/* Whether none of the functions is zero at some point, modulo a prime, where f[0 .. count) are: then none vanishes with them. Without
 * algebra, and said of algebraic functions only. */
static bool apart_somewhere(const struct domain *d, const expr_id *list, int n, const expr_id *f, int count)
{
    SGA_FREED int *solved = sga_malloc(((size_t)count + 1) * sizeof *solved);
    SGA_ENDS(set_points_clear) struct set_points on;
    SGA_ENDS(points_modpoint_clear) struct points_modpoint p = { 0 };
    set_points_init(&on, d->system, NULL, 0, 0, 0);
    on.space.constraint = f;
    on.space.constraints = count;
    on.space.budget = d->budget;
    uint64_t random = SGA_SEED_DOMAIN;
    bool apart = points_match_by_shape(&on.space, solved) && points_modpoint_find_modulo(&p, &on.space, solved, 5, &random);
    for (int i = 0; i < n && apart; i++) {
        bool chance;
        apart = points_modpoint_zero(&p, list[i], &chance) == 0 && !num_modp_kernel(p.value, list[i]);
    }
    for (int i = 0; i < count && apart; i++)
        apart = !num_modp_kernel(p.value, f[i]);
    return apart;
}

bool domain_leaves_out(struct domain *d, expr_id e, const expr_id *f, int own, int count)
{
    struct expr_store *st = d->system->store;
    expr_id list[DOMAIN_MOST];
    know_divisors(d);
    int divisors = d->divisors;
    memcpy(list, d->divisor, (size_t)divisors * sizeof *list);
    divisors_of(d, &e, 1, list, &divisors);
    if (!divisors || !own || count > DOMAIN_GIVEN)
        return false;
    SGA_FREED unsigned char *mark = sga_calloc((size_t)st->symbols + 1, 1);
    mark_tied(d, f, own, count, mark);
    struct poly_limits limits = poly_limits_of(POLY_MODEST, d->budget);
    int asked = 0;
    for (int i = 0; i < divisors; i++)
        if (symbols(d, list + i, 1, mark, false))
            list[asked++] = list[i];
    return asked && !apart_somewhere(d, list, asked, f, count) && poly_any_vanishes_with(st, list, asked, f, count, &limits);
}
