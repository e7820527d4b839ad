/* The analysis of the form `operator` over Q(t)[D]. */
#include "run_job.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "from_expr.h"
#include "mem.h"
#include "operator.h"
#include "operator_answer.h"
#include "ore.h"
#include "ore_matrix.h"
#include "popov.h"
#include "ratio_matrix.h"
#include "reduce.h"
#include "request.h"
#include "stage_clock.h"

enum { TERMS = 2, FACTOR_BYTES = 2 << 20 };

static bool convert(struct job *j, fmpz_poly_q_struct *out, const expr_id *e, int n, const char *where, int cols)
{
    char why[160] = "";
    int k = op_from_exprs(out, &j->request->store, e, n, j->request->system.time, why);
    if (k == n)
        return true;
    char pointer[96];
    snprintf(pointer, sizeof pointer, "%s/%d/%d", where, k / cols, k % cols);
    return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, pointer, "an entry must be a rational function of time with rational "
                       "coefficients: %s", why);
}

static bool make_system(struct job *j, struct op_system *s)
{
    const struct request_operator *op = &j->request->op;
    int p = op->unknowns;
    bool ok = true;
    *s = (struct op_system){ .unknowns = p, .sources = op->sources, .order = op->order };
    s->A = sga_calloc((size_t)op->order + 1, sizeof *s->A);
    for (int k = 0; k <= op->order; k++)
        ratio_matrix_init(s->A + k, p, p);
    ratio_matrix_init(&s->B, p, op->sources);
    for (int k = 0; k <= op->order && ok; k++) {
        char where[64];
        snprintf(where, sizeof where, "/system/coefficients/%d", k);
        ok = convert(j, s->A[k].e, op->A + (size_t)k * (size_t)p * (size_t)p, p * p, where, p);
    }
    if (ok && op->sources)
        ok = convert(j, s->B.e, op->B, p * op->sources, "/system/B", op->sources);
    while (s->order > 0 && ratio_matrix_is_zero(s->A + s->order))
        ratio_matrix_clear(s->A + s->order--);
    return ok;
}

/* Not of full rank: are there equations 0 = (something in e) that ask something of e? */
static bool asks_sources(const struct op_system *s, const struct op_popov *p)
{
    struct ore_matrix W = { 0 };
    op_right_side(&W, s, p);
    bool asks = false;
    for (int i = p->rank; i < W.rows; i++)
        for (int k = 0; k < W.cols; k++)
            asks = asks || !ore_is_zero(ore_at(&W, i, k));
    ore_matrix_clear(&W);
    return asks;
}

/* A limit of the Jacobson form is no failure of the job: the answer says it. */
static bool jacobson(struct job *j, struct operator_answer *a, const struct op_popov *full, const struct op_limits *limits)
{
    struct op_limits own = *limits;
    own.max_bytes = FACTOR_BYTES;
    struct sga_error err = { 0 };
    a->has_jacobson = op_jacobson_form(&a->jacobson, &a->system, a->solvable ? full : NULL, &a->state, &own, &err);
    if (a->has_jacobson || err.code == SGA_E_LIMIT_MEMORY || err.code == SGA_E_UNDECIDED) {
        a->no_jacobson = err;
        return true;
    }
    *j->err = err;
    return false;
}

static bool transfer(struct job *j, struct operator_answer *a, const struct op_popov *weak, const struct op_limits *limits)
{
    struct ratio_matrix leading;
    int order = 0;
    bool any = op_state_leading(&a->state, &order, &leading);
    if (!any)
        return true;
    bool ok = op_laurent_series(&a->laurent, &a->system, weak, order, TERMS, limits, j->err);
    if (ok && (a->laurent.first != order || !ratio_matrix_equal(&leading, a->laurent.coefficient)))
        ok = sga_fail(j->err, SGA_E_WITNESS, "the transfer matrix begins at order %d, the state form's at %d: this is a bug",
                      a->laurent.first, order);
    if (ok)
        op_singular_find(&a->singular, a->laurent.coefficient);
    ratio_matrix_clear(&leading);
    return ok;
}

bool answer_operator(struct job *j)
{
    struct operator_answer *a = sga_calloc(1, sizeof *a);
    struct op_limits limits = { .budget = j->budget };
    struct op_popov weak = { 0 }, full = { 0 };
    struct ore_matrix P;
    stage_begin(j->clock, STAGE_OPERATOR);
    j->op = a;
    if (!make_system(j, &a->system))
        return false;
    op_system_matrix(&a->system, &P);
    bool ok = op_popov_weak(&weak, &P, false, &limits, j->err);
    a->rank = weak.rank;
    a->solvable = ok && a->rank == P.rows;
    if (ok && a->solvable) {
        op_popov_copy(&full, &weak);
        ok = op_popov_finish(&full, &limits, j->err)
          && op_state_form(&a->state, &a->system, &full, &limits, j->err) && transfer(j, a, &weak, &limits);
        if (ok)
            op_singular_coefficients(&a->poles, &a->system, &a->state);
    } else if (ok)
        a->asks_sources = asks_sources(&a->system, &weak);
    ok = ok && jacobson(j, a, &full, &limits);
    op_popov_clear(&weak);
    op_popov_clear(&full);
    ore_matrix_clear(&P);
    if (!ok && !j->err->stage[0])
        memcpy(j->err->stage, "operator", 9);
    return ok;
}

void answer_operator_clear(struct job *j)
{
    if (!j->op)
        return;
    op_system_clear(&j->op->system);
    op_state_clear(&j->op->state);
    op_laurent_clear(&j->op->laurent);
    op_singular_clear(&j->op->singular);
    op_singular_clear(&j->op->poles);
    op_jacobson_clear(&j->op->jacobson);
    free(j->op);
    j->op = NULL;
}

bool answer_operator_is_pencil(const struct job *j)
{
    assert(!j->op || j->op->solvable == (j->op->rank == j->request->op.unknowns));
    return j->op && j->op->system.order <= 1;
}

int answer_operator_index(const struct job *j)
{
    return j->op->solvable ? j->op->state.degree + 1 : -1;
}
