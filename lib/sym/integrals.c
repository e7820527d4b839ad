/* First integrals among the combinations of given functions: F with X0(F) = 0 (with the
 * derivative in time) and K(F) = 0 on Pf, modulo what is constant on Pf. */
#include <stdlib.h>

#include "budget.h"
#include "mem.h"
#include "modp.h"
#include "sym_work.h"

enum { MOST_UNKNOWNS = 1200 };

struct functions {
    struct sym_work *w;
    struct sym_ansatz a;
    expr_id *node; int nodes;
    mp_limb_t *first;          /* values at the first point of this prime */
    mp_limb_t *v;
};

static void rows(void *ctx, struct num_modp *m, struct sym_spaces *s)
{
    struct functions *d = ctx;
    int n = d->w->n;
    for (int y = 0; y <= d->w->gauges; y++) {
        const expr_id *Y = y ? d->w->gauge + (size_t)(y - 1) * (size_t)(n + 1) : d->w->field;
        for (int f = 0; f < d->a.count; f++) {
            mp_limb_t sum = 0;
            for (int b = 0; b <= n; b++)
                sum = nmod_add(sum, nmod_mul(num_modp_value(m, Y[b]), num_modp_value(m, d->a.d[f * (n + 1) + b]), m->mod), m->mod);
            d->v[f] = sum;
        }
        sym_space_insert(&s->equation, d->v);
    }
    for (int f = 0; f < d->a.count; f++) {
        mp_limb_t value = num_modp_value(m, d->a.f[f]);
        if (!s->points)
            d->first[f] = value;
        d->v[f] = nmod_sub(value, d->first[f], m->mod);
    }
    sym_space_insert(&s->trivial, d->v);
}

static bool table(void *ctx, int most, struct sym_table *t)
{
    struct functions *d = ctx;
    struct sym_work *w = d->w;
    size_t cols = (size_t)d->a.count;
    t->equations = w->gauges + 1;
    t->trivials = 1;
    t->differences = true;
    if ((double)(t->equations + 1) * (double)cols > most)
        return false;
    t->equation = sga_malloc(((size_t)t->equations * cols + 1) * sizeof *t->equation);
    t->trivial = sga_malloc((cols + 1) * sizeof *t->trivial);
    for (size_t k = 0; k < cols; k++) {
        t->trivial[k] = d->a.f[k];
        for (int y = 0; y <= w->gauges; y++)
            t->equation[(size_t)y * cols + k] = sym_derive(w, y ? w->gauge + (size_t)(y - 1) * (size_t)(w->n + 1) : w->field, d->a.f[k]);
    }
    return true;
}

static void prepare(struct functions *d)
{
    size_t n = (size_t)d->w->n + 1, count = (size_t)d->a.count, g = (size_t)d->w->gauges + 1;
    d->node = sga_malloc((n * g + count * (n + 1) + 1) * sizeof *d->node);
    d->first = sga_calloc(count + 1, sizeof *d->first);
    d->v = sga_malloc((count + 1) * sizeof *d->v);
    for (size_t b = 0; b < n; b++)
        d->node[d->nodes++] = d->w->field[b];
    for (size_t b = 0; b < n * (g - 1); b++)
        d->node[d->nodes++] = d->w->gauge[b];
    for (size_t k = 0; k < count * n; k++)
        d->node[d->nodes++] = d->a.d[k];
    for (size_t k = 0; k < count; k++)
        d->node[d->nodes++] = d->a.f[k];
}

static bool constant_along_solutions(struct sym_work *w, expr_id F)
{
    expr_id e = sym_derive(w, w->field, F);
    bool ok = sym_zero(w, e) == SYM_TRUE;
    for (int k = 0; k < w->gauges && ok; k++)
        ok = sym_zero(w, sym_derive(w, w->gauge + (size_t)k * (size_t)(w->n + 1), F)) == SYM_TRUE;
    return ok;
}

bool sym_search_integrals(struct sym_work *w, const struct sym_search *s, struct sym_result *out, struct sga_error *err)
{
    struct functions d = { .w = w };
    struct sym_solutions found;
    if (!sym_ansatz_init(w, s, s->integral_degree, MOST_UNKNOWNS, &d.a)) {
        out->of_integrals.why_not = "there are too many functions of this degree; ask for a smaller integral_degree";
        return true;
    }
    prepare(&d);
    struct sym_problem p = { .cols = d.a.count, .node = d.node, .nodes = d.nodes, .rows = rows, .table = table, .ctx = &d };
    bool ok = expr_store_ok(w->st) && sym_solve(w, &p, &found, &out->of_integrals, err);
    if (ok) {
        out->integral = sga_calloc((size_t)found.count + 1, sizeof *out->integral);
        for (int k = 0; k < found.count && (ok = sga_budget_ok(w->budget, err)); k++) {
            expr_id F = sym_combination(w, found.value + (slong)k * found.cols, d.a.f, d.a.count, 1);
            if (constant_along_solutions(w, F))
                out->integral[out->integrals++] = F;
            else
                out->of_integrals.dropped++;
        }
        sym_solutions_clear(&found);
    }
    sym_ansatz_clear(&d.a);
    free(d.node);
    free(d.first);
    free(d.v);
    return ok;
}
