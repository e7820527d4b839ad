/* What the algorithm divided by, and where that can vanish on the final set. */
#include "answer.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "differentials.h"
#include "facts.h"
#include "lin_dense.h"
#include "mem.h"
#include "poly.h"

enum { PIVOT_BYTES = 4000 };

static void add(struct job *j, expr_id factor, const char *kind)
{
    for (int i = 0; i < j->strata; i++)
        if (j->stratum[i].factor == factor)
            return;
    struct sga_buf text = { 0 };
    if (!expr_print(&j->request.store, factor, PIVOT_BYTES, &text)) {
        sga_buf_free(&text);
        return;
    }
    j->stratum = sga_realloc(j->stratum, (size_t)(j->strata + 1) * sizeof *j->stratum);
    j->stratum[j->strata].factor = factor;
    j->stratum[j->strata].kind = kind;
    j->stratum[j->strata++].text = sga_buf_take(&text);
}

/* Numerical rank of [A; d xi] at a point of Pf: singular values above 1e-10 of the largest,
 * rows scaled to largest entry 1. The point is known to 64 bits, so what is 0 there comes
 * out far below. */
static int rank_at(struct job *j, const struct points_space *space, struct points_point *p)
{
    const struct sys_system *sys = &j->request.system;
    int n = sys->variables, c = j->solution.constraints, m = sys->rows + c;
    double *M = sga_calloc((size_t)(m + 1) * (size_t)n, sizeof *M);
    double *sv = sga_calloc((size_t)(m < n ? m : n) + 1, sizeof *sv);
    struct points_space own = *space;
    own.constraints = c;
    struct points_jacobian jac;
    points_jacobian_init(&jac, &own);
    points_jacobian_values(&jac, &p->ball);
    points_jacobian_entries(&jac, &p->ball);
    num_ball_forget(&p->ball);
    num_ball_extend(&p->ball);
    for (int i = 0; i < m; i++) {
        int len = i < sys->rows ? sys->row[i].entries : jac.cols[i - sys->rows];
        double *row = M + (size_t)i * (size_t)n, big = 0;
        for (int k = 0; k < len; k++) {
            int col = i < sys->rows ? sys->row[i].entry[k].col : jac.col[i - sys->rows][k];
            arb_srcptr v = i < sys->rows ? num_ball_value(&p->ball, sys->row[i].entry[k].value) : jac.entry[i - sys->rows] + k;
            row[col] = arf_get_d(arb_midref(v), ARF_RND_NEAR);
            big = fmax(big, fabs(row[col]));
        }
        for (int k = 0; k < n && big > 0; k++)
            row[k] /= big;
    }
    struct lin_dense dense = { .rows = m, .cols = n, .a = M };
    int rank = 0;
    if (lin_singular_values(&dense, sv))
        while (rank < (m < n ? m : n) && sv[rank] > 1e-10 * sv[0])
            rank++;
    points_jacobian_clear(&jac);
    free(M);
    free(sv);
    return rank;
}

/* Whether a real point of Pf with factor = 0 can be found at which the rank is lower than
 * on Pf in general: otherwise the pivot only happened to vanish there. */
static bool drops(struct job *j, expr_id factor)
{
    const struct sys_system *sys = &j->request.system;
    int n = sys->variables, c = j->solution.constraints;
    int *variable = sga_malloc((size_t)n * sizeof *variable);
    expr_id *con = sga_malloc((size_t)(c + 1) * sizeof *con);
    for (int i = 0; i < n; i++)
        variable[i] = sys->variable[i].symbol;
    for (int i = 0; i < c; i++)
        con[i] = j->solution.constraint[i].expr;
    con[c] = factor;
    struct points_space space = {
        .st = sys->store, .variable = variable, .variables = n, .parameter = sys->parameter, .parameters = sys->parameters,
        .time = sys->time, .constraint = con, .constraints = c + 1, .near = j->near, .near_time = j->near_time,
        .scale = j->solution.scale,
        .budget = &j->budget,
    };
    struct points_point p;
    uint64_t random = 5;
    int *end = sga_calloc((size_t)j->solution.generations + 2, sizeof *end), stages = sga_stages(&j->solution, end);
    end[stages++] = c + 1;
    enum points_status status = points_find_staged(&space, end, stages, j->near ? 0.2 : 1, &random, 64, &p);
    free(end);
    /* an irregular place was approached to about 6 digits only: listed, to be safe */
    bool lower = status == POINTS_IRREGULAR
                 || (status == POINTS_OK && rank_at(j, &space, &p) < n - j->solution.free_columns);
    points_point_clear(&p);
    free(variable);
    free(con);
    return lower;
}

static void consider(struct job *j, struct expr_facts *facts, expr_id factor)
{
    struct expr_store *st = &j->request.store;
    unsigned f = expr_facts_of(facts, st, factor);
    if (f & EXPR_NONZERO || expr_is_const(st, factor))
        return;
    if (!(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
        add(j, factor, "parameter");
    else if (j->solution.verdict != SGA_INCONSISTENT && drops(j, factor))
        add(j, factor, "pivot");
}

static void factors_of(struct job *j, struct expr_facts *facts, expr_id value)
{
    struct poly_limits limits = { .max_terms = 200, .max_bits = 2000, .max_degree = 40, .max_generators = 24, .budget = &j->budget };
    struct poly_factors f;
    if (!poly_numerator_factors(&j->request.store, value, &limits, &f)) {
        consider(j, facts, value);
        return;
    }
    for (int i = 0; i < f.factors; i++)
        if (!f.factor[i].never_zero)
            consider(j, facts, f.factor[i].expr);
    poly_factors_clear(&f);
}

void answer_strata(struct job *j)
{
    struct expr_facts facts;
    bool empty = j->solution.verdict == SGA_INCONSISTENT;
    if (!j->has_texts)
        return;
    expr_facts_init(&facts);
    if (empty && j->request.system.parameters)      /* for which parameters it is a contradiction */
        factors_of(j, &facts, j->solution.contradiction);
    for (int i = 0; i < j->solution.branches; i++)
        add(j, j->solution.branch[i], "branch");
    for (int i = 0; i < j->solution.sides; i++) {
        unsigned f = expr_facts_of(&facts, &j->request.store, j->solution.side[i].function);
        add(j, j->solution.side[i].function, f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME) ? "side" : "parameter");
    }
    for (int i = 0; i < j->solution.pivots; i++)
        if (!expr_is_const(&j->request.store, j->solution.pivot[i].value))
            factors_of(j, &facts, j->solution.pivot[i].value);
    expr_facts_clear(&facts);
}
