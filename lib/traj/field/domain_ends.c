/* The ends of the domains of functions in expressions: see domain_ends.h. */
#include "domain_ends.h"

#include <stdlib.h>

#include "arena.h"
#include "collect.h"
#include "facts.h"
#include "op.h"

struct search {
    struct expr_store *st;
    struct expr_facts facts;
    struct field_list *l;
};

static void add(struct search *s, expr_id e)
{
    expr_collect(s->st, &e, 1);        /* 1 - (1 - u) */
    unsigned facts = expr_facts_of(&s->facts, s->st, e);
    if (facts & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME) && !(facts & EXPR_NONNEGATIVE))
        field_list_add(s->l, e);
}

static int ascending(const void *a, const void *b)
{
    const expr_id *p = a, *q = b;
    return (*p > *q) - (*p < *q);
}

static void each_once(struct field_list *l, int from)
{
    int kept = from;
    if (l->count > from)
        qsort(l->e + from, (size_t)(l->count - from), sizeof *l->e, ascending);
    for (int k = from; k < l->count; k++)
        if (k == from || l->e[k] != l->e[kept - 1])
            l->e[kept++] = l->e[k];
    l->count = kept;
}

void domain_ends(struct expr_store *st, const expr_id *root, int roots, struct field_list *l)
{
    struct search s = { .st = st, .l = l };
    int from = l->count;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    expr_facts_init(&s.facts);
    expr_cone_of(st, &cone, root, roots);
    for (int i = 0; i < cone.count; i++) {
        const struct expr_node e = st->node[cone.list[i]];
        if (e.op == EXPR_POW)          /* of a base >= 0 */
            add(&s, e.a);
        if (expr_op_args((enum expr_op)e.op) != 1 || e.op == EXPR_POWI)
            continue;
        const struct expr_interval *domain = expr_op_domain((enum expr_op)e.op);
        if (domain->has_low)
            add(&s, expr_sub(st, e.a, expr_interval_end(st, domain, false)));
        if (domain->has_high)
            add(&s, expr_sub(st, expr_interval_end(st, domain, true), e.a));
    }
    each_once(l, from);
    expr_facts_clear(&s.facts);
}
