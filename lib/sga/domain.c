/* Zeros at which the equations have no value. */
#include "domain.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "poly.h"

expr_id domain_divisor(const struct expr_store *st, expr_id e)
{
    const struct expr_node n = st->node[e];
    if (n.op == EXPR_LOG)
        return n.a;
    if (n.op == EXPR_POW && expr_is_const(st, n.b) && fmpq_sgn(expr_const_value(st, n.b)) < 0)
        return n.a;
    return expr_divisor(st, e);
}

/* The divisors below the roots that may vanish, each once, as many as there is room for. */
static void divisors_of(struct domain *d, const expr_id *root, int roots, expr_id *list, int *count)
{
    const struct expr_store *st = d->system->store;
    expr_cone_of(st, d->cone, root, roots);
    for (int i = 0; i < d->cone->count && *count < DOMAIN_MOST; i++) {
        expr_id e = domain_divisor(st, d->cone->list[i]);
        bool known = !e || expr_is_const(st, e) || expr_facts_of(d->facts, st, e) & EXPR_NONZERO;
        for (int k = 0; k < *count && !known; k++)
            known = list[k] == e;
        if (!known)
            list[(*count)++] = e;
    }
}

static void know_divisors(struct domain *d)
{
    expr_id *root;
    if (d->known)
        return;
    int roots = sys_expressions(d->system, &root);
    divisors_of(d, root, roots, d->divisor, &d->divisors);
    free(root);
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
    unsigned char *mark = sga_calloc((size_t)st->symbols + 1, 1);
    symbols(d, f, own, mark, true);
    struct poly_limits limits = { .max_terms = 200, .max_bits = 4000, .max_degree = 40, .max_generators = 24, .budget = d->budget };
    bool outside = false;
    for (int i = 0; i < divisors && !outside; i++)
        outside = symbols(d, list + i, 1, mark, false) && poly_vanishes_with(st, list[i], f, count, &limits);
    free(mark);
    return outside;
}
