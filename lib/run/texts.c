/* Readable texts: the normal form where it is short, else the expression as it arose,
 * with names for what is shared beyond a budget. */
#include "answer.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "poly.h"

enum { TEXT_BYTES = 6000, INLINE_NODES = 400 };

static size_t text_length(struct job *j, expr_id e)
{
    struct sga_buf b = { 0 };
    size_t n = expr_print(&j->request.store, e, TEXT_BYTES, &b) ? b.len : (size_t)-1;
    sga_buf_free(&b);
    return n;
}

/* root[i] becomes its normal form where that is shorter. */
static void shorten(struct job *j, expr_id *root, int n)
{
    struct sga_budget budget = j->budget;
    double limit = sga_now() + 2;
    if (!budget.deadline || budget.deadline > limit)
        budget.deadline = limit;
    struct poly_limits limits = { .max_terms = 80, .max_bits = 4000, .max_degree = 60, .max_generators = 32, .budget = &budget };
    expr_id *normal = sga_malloc((size_t)n * sizeof *normal);
    poly_normal_all(&j->request.store, root, n, &limits, normal);
    for (int i = 0; i < n; i++)
        if (normal[i] != root[i] && text_length(j, normal[i]) <= text_length(j, root[i]))
            root[i] = normal[i];
    free(normal);
}

/* A constraint is a set: where its numerator is one factor and shorter, that is shown,
 * without numeric factors and denominators; *scale is what these come to. */
static void primitive(struct job *j, expr_id *root, expr_id *scale)
{
    struct poly_limits limits = { .max_terms = 200, .max_bits = 4000, .max_degree = 40, .max_generators = 24, .budget = &j->budget };
    struct poly_factors f;
    if (!poly_numerator_factors(&j->request.store, *root, &limits, &f))
        return;
    if (f.factors == 1 && f.factor[0].multiplicity == 1 && text_length(j, f.factor[0].expr) <= text_length(j, *root)) {
        *scale = expr_div(&j->request.store, *root, f.factor[0].expr);
        poly_normal(&j->request.store, *scale, &limits, scale);
        *root = f.factor[0].expr;
    }
    poly_factors_clear(&f);
}

bool answer_texts(struct job *j)
{
    const struct sga_solution *sol = &j->solution;
    unsigned want = j->request.want;
    if (!(want & (REQUEST_CONSTRAINTS | REQUEST_VECTOR_FIELD | REQUEST_GAUGE)))
        return true;
    stage_begin(&j->clock, STAGE_TEXTS);
    int n = j->request.system.variables, c = sol->constraints;
    bool field = sol->field && want & (REQUEST_VECTOR_FIELD | REQUEST_GAUGE), gauge = field && sol->gauge && want & REQUEST_GAUGE;
    int roots = c + (field ? n : 0) + (gauge ? n * sol->free_columns : 0);
    struct mechanical_answer *mech = j->mechanical && j->mechanical->has_motion ? j->mechanical : NULL;
    int parts = mech ? j->request.mechanical.coordinates : 0;
    expr_id *root = sga_malloc((size_t)(roots + 4 * parts + 1) * sizeof *root);
    for (int i = 0; i < c; i++)
        root[i] = sol->constraint[i].expr;
    if (field)
        memcpy(root + c, sol->field, (size_t)n * sizeof *root);
    if (gauge)
        memcpy(root + c + n, sol->gauge, (size_t)n * (size_t)sol->free_columns * sizeof *root);
    if (mech) {
        const expr_id *part[4] = { mech->motion.total, mech->motion.tangent, mech->motion.orthogonal, mech->motion.reaction };
        mech->first_root = roots;
        for (int k = 0; k < 4; k++, roots += parts)
            memcpy(root + roots, part[k], (size_t)parts * sizeof *root);
    }
    j->first_field = c;
    j->first_gauge = c + n;
    shorten(j, root, roots);
    j->scale = sga_calloc((size_t)c + 1, sizeof *j->scale);
    for (int i = 0; i < c && c <= 60; i++)
        primitive(j, root + i, j->scale + i);
    struct expr_naming naming = { .prefix = "s", .inline_nodes = INLINE_NODES };
    j->has_texts = expr_print_named(&j->request.store, root, roots, &naming, &j->texts);
    free(root);
    if (!j->has_texts)
        return sga_fail(j->err, SGA_E_LIMIT_RESULT, "the answer is too large to print (more than 16 MiB); "
                        "ask for less in want, for example [\"index\", \"trajectory\"]");
    if (!expr_store_ok(&j->request.store)) {
        *j->err = j->request.store.error;
        return false;
    }
    return sga_budget_ok(&j->budget, j->err);
}
