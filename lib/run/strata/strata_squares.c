/* Strata of codimension two and more: zeros of factors that are sums of squares. A point of x^2 + y^2 = 0 is none that Newton's
 * method finds, for the differential vanishes there; what vanishes are x and y, so these say where the stratum is. Where they depend
 * on the constraints the set is handed to the reduction as restrictions, which sorts that out and certifies its points. */
#include "strata_listing.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "domain.h"
#include "error.h"
#include "facts.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "poly.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "seeds.h"
#include "strata_case.h"
#include "stratum.h"
#include "warnings.h"

static void keep_point(struct stratum *as, const double *x, int n, double t, bool certified)
{
    as->point = memcpy(sga_malloc((size_t)n * sizeof *as->point), x, (size_t)n * sizeof *as->point);
    as->time = t;
    as->approximate = !certified;
}

/* The same where the functions depend on the constraints or on each other. */
static bool drops_reduced(struct job *j, int c, const expr_id *e, int count, int rank, struct stratum *as)
{
    const struct sys_system *sys = &j->request->system;
    struct reduction_options options = { .near = j->start.x, .near_time = j->start.time, .parameter_near = j->start.parameter, .seed = SGA_SEED_REDUCTION, .budget = j->budget };
    struct sys_system only = *sys;
    struct points_oracle oracle;
    struct sga_solution sol = { 0 };
    struct sga_error err = { 0 };
    bool lower = false;
    only.rows = only.restrictions = 0;
    only.restriction = NULL;
    for (int i = 0; i < c + count; i++)
        sys_add_restriction(&only, i < c ? j->solution->constraint[i].expr : e[i - c]);
    expr_id *con = sga_malloc((size_t)(c + 1) * sizeof *con);
    for (int i = 0; i < c; i++)
        con[i] = j->solution->constraint[i].expr;
    points_oracle_init(&oracle, 20250104);
    if (sga_reduce(&only, &options, &oracle, &sol, &err) && sol.verdict != SGA_INCONSISTENT && oracle.reals) {
        struct points_space space = oracle.space;
        space.constraint = con;
        lower = strata_rank_at(j, &space, sys->rows, c, oracle.real) < rank;
        if (lower)
            keep_point(as, oracle.real[0].x, sys->variables, oracle.real[0].t, oracle.real[0].certified);
    }
    points_oracle_clear(&oracle);
    sga_solution_clear(&sol);
    free(only.restriction);
    free(con);
    return lower;
}

/* Whether all of the functions, whose squares make the factor, vanish somewhere on the set of the first c constraints, where the rank is
 * below `rank`: a search like those for other factors; where it only approaches a place, a reduction of the set, if that is small. */
static bool drops(struct job *j, int c, expr_id factor, const expr_id *e, int count, int rank, struct stratum *as)
{
    struct points_point p;
    int there, n = j->request->system.variables;
    enum points_status status = strata_look_at(j, (struct strata_look){ .c = c, .factor = factor, .squared = e, .squares = count }, &p, &there);
    bool lower = status == POINTS_OK && there < rank, small = n + c <= SGA_MOST_SQUARES_REDUCED;
    if (status == POINTS_IRREGULAR && !small)
        sga_limit_met(j->budget, SGA_LIMIT_SQUARES_REDUCED);
    if (status == POINTS_IRREGULAR)
        lower = small ? drops_reduced(j, c, e, count, rank, as) : true;     /* listed, to be safe */
    if (lower && !as->point)
        keep_point(as, p.x, n, p.t, status == POINTS_OK && p.certified);
    points_point_clear(&p);
    return lower;
}

static bool is_listed(const struct job *j, const expr_id *e, int count)
{
    for (int i = 0; i < j->strata.count; i++) {
        int same = 0;
        for (int k = 0; k < count; k++)
            for (int m = 0; m < j->strata.at[i].wheres; m++)
                same += j->strata.at[i].where[m] == e[k];
        if (same == count)
            return true;
    }
    return false;
}

static void list(struct job *j, const expr_id *e, int count, int before, struct stratum as)
{
    assert(count > 0);
    as.where = sga_malloc((size_t)(count + 1) * sizeof *as.where);
    as.text = sga_malloc((size_t)(count + 1) * sizeof *as.text);
    for (int k = 1; k < count; k++) {
        struct sga_buf text = { 0 };
        if (!expr_print(&j->request->store, e[k], SGA_MOST_STRATUM_BYTES, &text)) {
            sga_buf_free(&text);
            sga_limit_met(j->budget, SGA_LIMIT_STRATUM_BYTES);
            continue;      /* the set is still described by its point */
        }
        as.where[as.wheres] = e[k];
        as.text[as.wheres++] = sga_buf_take(&text);
    }
    strata_add(j, e[0], before, as);
}

/* The functions that do not vanish on all of the final set; 0: the factor is dead, or one of them cannot vanish, or is one of parameters
 * or time alone. */
static int telling(struct listing *l, const struct poly_factor *q, expr_id *e)
{
    struct job *j = l->j;
    int count = 0;
    for (int k = 0; k < q->radicals; k++) {
        unsigned f = expr_facts_of(l->facts, &j->request->store, q->radical[k]);
        if (f & EXPR_NONZERO || !(f & EXPR_HAS_VARIABLE))
            return 0;
        if (!j->oracle->reals || points_oracle_zero(j->oracle, q->radical[k]).truth != POINTS_ZERO)
            e[count++] = q->radical[k];
    }
    return count;
}

static bool sum_of_squares(struct listing *l, const struct poly_factor *q, int before)
{
    struct job *j = l->j;
    struct stratum as = { .kind = "pivot" };
    if (domain_leaves_out(l->domain, expr_int(&j->request->store, 1), q->radical, q->radicals, q->radicals))
        return true;       /* the equations have no value there; what the pivot itself divides by does not matter */
    SGA_ARENA(mem);
    expr_id *e = sga_take(&mem, (size_t)(q->radicals + 1) * sizeof *e);
    int count = telling(l, q, e), c = j->solution->constraints;
    if (count && !is_listed(j, e, count) && job_has_left(j)) {
        bool found = drops(j, c, q->expr, e, count, j->request->system.variables - j->solution->free_columns, &as);
        if (!found && j->request->strata && before < c && before >= 0)
            found = as.off = drops(j, before, q->expr, e, count, strata_general_rank(l, before), &as);
        if (found)
            list(j, e, count, before, as);
    }
    return count > 0;
}

bool strata_squares(struct listing *l, const struct poly_factor *q, int before)
{
    struct expr_store *st = &l->j->request->store;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, l->j->budget);
    struct poly_factors f;
    if (l->j->solution->verdict == SGA_INCONSISTENT)
        return false;
    if (q->sum_of_even_powers)
        return q->radicals && sum_of_squares(l, q, before);
    /* that (x^2 + y^2)/y never vanishes says nothing of places where y does: those are in the domain of the equations */
    if (!q->never_zero || !(q->depends & EXPR_HAS_VARIABLE) || !poly_numerator_factors(st, q->expr, &limits, &f))
        return q->never_zero;
    for (int i = 0; i < f.factors; i++)
        if (f.factor[i].sum_of_even_powers && f.factor[i].radicals)
            sum_of_squares(l, f.factor + i, before);
    poly_factors_clear(&f);
    return true;
}
