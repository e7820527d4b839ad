/* Values of parameters for which functions that are no polynomials stop to be independent. */
#include "conditions.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "cases.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "state.h"
#include "warnings.h"

/* A function for special values: what vanishes for these, and the function as it is then. */
struct special {
    expr_id *where; int wheres;
    expr_id g;
};

struct kernels {
    struct state *s;
    struct sga_conditions *to;
    unsigned of;
    struct special *list; int count, done; size_t cap;
    struct poly_limits limits;
};

static bool moves_with_parameters(struct state *s, expr_id e)
{
    unsigned f = state_facts(s, e);
    return f & EXPR_HAS_PARAMETER && f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME);
}

/* The arguments of such functions in g, and where there are two of one kind their differences and sums, into *out. */
static int arguments(struct kernels *w, expr_id g, expr_id **out)
{
    struct state *s = w->s;
    struct expr_store *st = s->st;
    size_t cap = 0;
    int n = 0;
    *out = NULL;
    expr_cone_of(st, &s->cone, &g, 1);
    int first = 0;
    SGA_FREED int *op = sga_malloc(((size_t)s->cone.count + 1) * sizeof *op);
    for (int i = 0; i < s->cone.count; i++) {
        const struct expr_node node = st->node[s->cone.list[i]];
        bool power = node.op == EXPR_POW;
        if ((!power && (node.op < EXPR_SIN || node.op == EXPR_SOLVE)) || !moves_with_parameters(s, power ? node.b : node.a))
            continue;
        SGA_RESERVE(*out, cap, n + 1);
        op[n] = node.op;
        (*out)[n++] = power ? node.b : node.a;
    }
    for (int many = n; first < many; first++)
        for (int k = first + 1; k < many; k++) {
            if (op[k] != op[first] || (*out)[k] == (*out)[first])
                continue;
            SGA_RESERVE(*out, cap, n + 2);
            (*out)[n++] = expr_sub(st, (*out)[first], (*out)[k]);
            (*out)[n++] = expr_add(st, (*out)[first], (*out)[k]);
        }
    return n;
}

/* What must vanish of the parameters for e not to move. Returns how many, -1: over budget. */
static int at_rest(struct kernels *w, expr_id e, expr_id **out)
{
    struct poly_coefficients k = { 0 };
    struct poly_numerator *n = poly_numerator_new(w->s->st, e, &w->limits);
    bool ok = n && poly_coefficients_of(n, &k);
    int count = 0;
    poly_numerator_free(n);
    for (int i = 0; ok && i < k.count; i++)
        if (k.of[i])
            k.coefficient[count++] = k.coefficient[i];
    *out = k.coefficient;
    free(k.of);
    return ok ? count : -1;
}

static void push(struct kernels *w, const struct special *from, const struct cases_part *part, expr_id g)
{
    if (w->count >= SGA_MOST_KERNELS) {
        sga_limit_met(w->s->options->budget, SGA_LIMIT_KERNELS);
        return;
    }
    SGA_RESERVE(w->list, w->cap, w->count + 1);
    struct special *to = w->list + w->count++;
    int old = from->wheres;
    *to = (struct special){ .g = g, .wheres = old + part->wheres };
    to->where = sga_malloc(((size_t)to->wheres + 1) * sizeof *to->where);
    if (old)
        memcpy(to->where, w->list[w->done].where, (size_t)old * sizeof *to->where);
    memcpy(to->where + old, part->where, (size_t)part->wheres * sizeof *to->where);
}

/* What g says where it is looked at: its terms vanish together with the functions of where. */
static void note_special(struct kernels *w, const struct special *p)
{
    struct state *s = w->s;
    struct poly_coefficients k;
    struct poly_numerator *n = poly_numerator_new(s->st, p->g, &w->limits);
    if (n && poly_coefficients_of(n, &k)) {
        int count = p->wheres;
        SGA_FREED expr_id *f = sga_malloc(((size_t)(count + k.count) + 1) * sizeof *f);
        memcpy(f, p->where, (size_t)count * sizeof *f);
        for (int i = 0; i < k.count; i++)
            if (!w->of || k.of[i] & w->of)
                f[count++] = k.coefficient[i];
        conditions_add(w->to, s->st, s->facts, f, count);
        poly_coefficients_clear(&k);
    }
    poly_numerator_free(n);
}

/* The places where an argument of special p comes to rest. */
static void look(struct kernels *w, expr_id argument)
{
    struct state *s = w->s;
    struct special p = w->list[w->done];
    SGA_FREED expr_id *f = NULL;
    int count = at_rest(w, argument, &f);
    SGA_ENDS(cases_clear) struct cases c = { .part = NULL };
    if (count > 0)
        cases_of(s->sys, f, count, NULL, 0, s->options->budget, &c);
    for (int i = 0; i < c.parts; i++) {
        expr_id g = c.part[i].open ? EXPR_UNDEF : cases_at(s->st, p.g, c.part[i].put, c.part[i].puts);
        if (g)
            push(w, &p, c.part + i, g);
    }
}

void conditions_kernels(struct state *s, struct sga_conditions *to, expr_id g, unsigned of)
{
    struct kernels w = { .s = s, .to = to, .of = of };
    w.limits = poly_limits_of(POLY_SMALL, s->options->budget);
    SGA_RESERVE(w.list, w.cap, 1);
    w.list[w.count++] = (struct special){ .g = g };
    for (; w.done < w.count; w.done++) {
        SGA_FREED expr_id *argument = NULL;
        int n = arguments(&w, w.list[w.done].g, &argument);
        if (w.done)
            note_special(&w, w.list + w.done);
        for (int i = 0; i < n; i++)
            look(&w, argument[i]);
    }
    for (int i = 0; i < w.count; i++)
        free(w.list[i].where);
    free(w.list);
}
