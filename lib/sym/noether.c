/* Noether's theorem on a closed 2-form T: first integrals F and symmetries D with dF = i_D T
 * on Pf, among the combinations of what was found. */
#include <stdlib.h>

#include "derive.h"
#include "mem.h"
#include "parts.h"

enum { MOST_VARIABLES = 60 };

/* Unknowns: factors of the integrals, then of the fields. Equations: the components of
 * sum c_l dF_l - sum d_k i_{D_k} T. */
struct potential {
    int n, cols;
    expr_id *node;             /* n x cols */
    mp_limb_t *v;
};

static void rows(void *ctx, struct num_modp *m, struct sym_spaces *s)
{
    struct potential *p = ctx;
    for (int j = 0; j < p->n; j++) {
        for (int k = 0; k < p->cols; k++)
            p->v[k] = num_modp_value(m, p->node[j * p->cols + k]);
        sym_space_insert(&s->equation, p->v);
    }
    for (int k = 0; k < p->cols && !s->points; k++) {     /* no combination counts as 0 */
        for (int i = 0; i < p->cols; i++)
            p->v[i] = i == k;
        sym_space_insert(&s->trivial, p->v);
    }
}

/* (i_D T)_j = D^i T_ij */
static expr_id contraction(struct sym_work *w, const expr_id *form, const expr_id *D, int j)
{
    expr_id sum = expr_int(w->st, 0);
    for (int i = 0; i < w->n; i++) {
        expr_id T = form ? form[i * w->n + j] : sym_entry(w, i, j);
        if (!expr_is_zero(w->st, D[i]) && !expr_is_zero(w->st, T))
            sum = expr_add(w->st, sum, expr_mul(w->st, D[i], T));
    }
    return sum;
}

static bool confirmed(struct sym_work *w, const struct potential *p, const fmpq *c, int integrals)
{
    bool some = false;
    for (int l = 0; l < integrals; l++)
        some |= !fmpq_is_zero(c + l);
    for (int j = 0; j < p->n && some; j++)
        some = sym_zero(w, sym_combination(w, c, p->node + j * p->cols, p->cols, 1)) == SYM_TRUE;
    return some;
}

static void add(struct sym_work *w, struct sym_result *out, const fmpq *c, const expr_id *field)
{
    struct sym_noether *r = out->noether + out->noethers++;
    r->integral = sym_combination(w, c, out->integral, out->integrals, 1);
    r->component = sga_malloc(((size_t)w->n + 1) * sizeof *r->component);
    for (int a = 0; a <= w->n; a++)
        r->component[a] = sym_combination(w, c + out->integrals, field + a, out->fields, w->n + 1);
}

/* The fields one after the other, n + 1 components each. */
static expr_id *all_fields(const struct sym_work *w, const struct sym_result *out)
{
    size_t m = (size_t)w->n + 1;
    expr_id *field = sga_malloc((m * (size_t)out->fields + 1) * sizeof *field);
    for (size_t k = 0; k < (size_t)out->fields; k++)
        for (size_t a = 0; a < m; a++)
            field[k * m + a] = out->field[k].component[a];
    return field;
}

bool sym_noether(struct sym_work *w, const expr_id *form, struct sym_result *out, struct sga_error *err)
{
    struct potential p = { .n = w->n, .cols = out->integrals + out->fields };
    struct sym_evidence evidence = { 0 };
    struct sym_solutions found;
    if (w->n > MOST_VARIABLES || !out->integrals || !out->fields)
        return true;
    for (int k = 0; k < out->fields; k++)
        if (!expr_is_zero(w->st, out->field[k].component[w->n]))
            return true;       /* time moves: T alone does not tell */
    p.node = sga_malloc((size_t)(p.n * p.cols) * sizeof *p.node);
    p.v = sga_malloc((size_t)p.cols * sizeof *p.v);
    for (int j = 0; j < p.n; j++) {
        for (int l = 0; l < out->integrals; l++)
            p.node[j * p.cols + l] = expr_diff(w->st, out->integral[l], w->variable[j]);
        for (int k = 0; k < out->fields; k++)
            p.node[j * p.cols + out->integrals + k] = expr_neg(w->st, contraction(w, form, out->field[k].component, j));
    }
    struct sym_problem problem = { .cols = p.cols, .node = p.node, .nodes = p.n * p.cols, .rows = rows, .ctx = &p };
    bool ok = expr_store_ok(w->st) && sym_solve(w, &problem, &found, &evidence, err);
    if (ok) {
        expr_id *field = all_fields(w, out);
        out->noether = sga_calloc((size_t)found.count + 1, sizeof *out->noether);
        for (int k = 0; k < found.count; k++)
            if (confirmed(w, &p, found.value + (slong)k * found.cols, out->integrals))
                add(w, out, found.value + (slong)k * found.cols, field);
        free(field);
        sym_solutions_clear(&found);
    }
    free(p.node);
    free(p.v);
    return ok;
}
