/* Noether's theorem on a closed 2-form T: first integrals F and symmetries D with dF = i_D T
 * on Pf, among the combinations of what was found that do not move time. Where the equations were pulled back
 * to a submanifold, dF = i_D T is asked along the vectors tangent to it only. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "mem.h"
#include "modp.h"
#include "warnings.h"
#include "sym_work.h"

/* Unknowns: factors of the integrals, then of the fields. Equations: the components of
 * sum c_l dF_l - sum d_k i_{D_k} T along each vector, and the time component sum d_k theta_k. */
struct potential {
    struct expr_store *st;
    int rows, cols;
    expr_id *node;             /* rows x cols */
    mp_limb_t *v;
};

static void rows(void *ctx, struct num_modp *m, struct sym_spaces *s)
{
    struct potential *p = ctx;
    for (int j = 0; j < p->rows; j++) {
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

/* The rows are expressions already; no combination counts as 0. */
static bool table(void *ctx, int most, struct sym_table *t)
{
    const struct potential *p = ctx;
    size_t size = (size_t)p->rows * (size_t)p->cols;
    if ((double)size > most)
        return false;
    t->equations = p->rows;
    t->equation = sga_malloc((size + 1) * sizeof *t->equation);
    memcpy(t->equation, p->node, size * sizeof *t->equation);
    t->trivials = p->cols;
    t->trivial = sga_malloc(((size_t)p->cols * (size_t)p->cols + 1) * sizeof *t->trivial);
    for (int i = 0; i < p->cols * p->cols; i++)
        t->trivial[i] = expr_int(p->st, i / p->cols == i % p->cols);
    return true;
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
    for (int j = 0; j < p->rows && some; j++)
        some = sym_zero(w, sym_combination(w, c, p->node + j * p->cols, p->cols, 1)) == SYM_TRUE;
    return some;
}

static void add(struct sym_work *w, struct sym_result *out, const fmpq *c, const expr_id *field)
{
    assert(out->integrals > 0 && out->fields > 0);
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

/* v(F), or T(D, v) with the other sign, along the vector i (of which the j-th component is 1 and the others 0 where
 * there are none). */
static expr_id along(struct sym_work *w, const struct sym_request *q, int i, expr_id F, const expr_id *D)
{
    expr_id sum = expr_int(w->st, 0);
    for (int j = 0; j < w->n; j++) {
        expr_id v = q->vector ? q->vector[(size_t)i * (size_t)w->n + (size_t)j] : expr_int(w->st, i == j);
        if (expr_is_zero(w->st, v))
            continue;
        expr_id part = D ? expr_neg(w->st, contraction(w, q->form, D, j)) : expr_diff(w->st, F, w->variable[j]);
        sum = expr_add(w->st, sum, expr_mul(w->st, v, part));
    }
    return sum;
}

static void prepare(struct sym_work *w, const struct sym_request *q, const struct sym_result *out, struct potential *p)
{
    p->node = sga_malloc((size_t)(p->rows * p->cols) * sizeof *p->node);
    p->v = sga_malloc((size_t)p->cols * sizeof *p->v);
    for (int i = 0; i < p->rows; i++) {
        bool time = i + 1 == p->rows;
        expr_id *row = p->node + (size_t)i * (size_t)p->cols;
        for (int l = 0; l < out->integrals; l++)
            row[l] = time ? expr_int(w->st, 0) : along(w, q, i, out->integral[l], NULL);
        for (int k = 0; k < out->fields; k++)
            row[out->integrals + k] = time ? out->field[k].component[w->n] : along(w, q, i, EXPR_UNDEF, out->field[k].component);
    }
}

bool sym_noether(struct sym_work *w, const struct sym_request *request, struct sym_result *out, struct sga_error *err)
{
    struct potential p = { .st = w->st, .rows = (request->vector ? request->vectors : w->n) + 1, .cols = out->integrals + out->fields };
    struct sym_evidence evidence = { 0 };
    struct sym_solutions found;
    if (w->n > SGA_MOST_NOETHER)
        sga_limit_met(w->budget, SGA_LIMIT_NOETHER);
    if (w->n > SGA_MOST_NOETHER || !out->integrals || !out->fields)
        return true;
    prepare(w, request, out, &p);
    struct sym_problem problem = { .cols = p.cols, .node = p.node, .nodes = p.rows * p.cols, .rows = rows, .table = table, .ctx = &p };
    bool ok = expr_store_ok(w->st) && sym_solve(w, &problem, &found, &evidence, err);
    if (ok) {
        SGA_FREED expr_id *field = all_fields(w, out);
        out->noether = sga_calloc((size_t)found.count + 1, sizeof *out->noether);
        for (int k = 0; k < found.count; k++)
            if (confirmed(w, &p, found.value + (slong)k * found.cols, out->integrals))
                add(w, out, found.value + (slong)k * found.cols, field);
        sym_solutions_clear(&found);
    }
    free(p.node);
    free(p.v);
    return ok;
}
