/* What the algorithm divided by, and where that can vanish. */
#include "strata_listing.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ball.h"
#include "cases.h"
#include "definition.h"
#include "domain.h"
#include "error.h"
#include "facts.h"
#include "points.h"
#include "run_job.h"
#include "alike.h"
#include "mem.h"
#include "poly.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "oracle.h"
#include "stage_clock.h"
#include "strata.h"
#include "stratum.h"
#include "texts.h"
#include "warnings.h"

/* One more function that vanishes on a stratum; false where it is too long to be written. */
static bool push(struct job *j, struct stratum *s, expr_id e)
{
    struct sga_buf text = { 0 };
    for (int i = 0; i < s->wheres; i++)
        if (s->where[i] == e)
            return true;
    if (!expr_print(&j->request->store, e, SGA_MOST_STRATUM_BYTES, &text)) {
        sga_buf_free(&text);
        sga_limit_met(j->budget, SGA_LIMIT_STRATUM_BYTES);
        return false;
    }
    s->where = sga_realloc(s->where, (size_t)(s->wheres + 1) * sizeof *s->where);
    s->text = sga_realloc(s->text, (size_t)(s->wheres + 1) * sizeof *s->text);
    s->where[s->wheres] = e;
    s->text[s->wheres++] = sga_buf_take(&text);
    return true;
}

bool stratum_sane(const struct stratum *s)
{
    bool where = s->wheres > 0 ? s->where && s->text : s->description || s->point;
    bool kept = s->state == STRATUM_SOLVED ? s->result.len > 0 : s->state == STRATUM_UNSOLVED ? s->error.code != SGA_E_OK
              : s->state != STRATUM_EMPTY || s->note.len > 0;
    for (int i = 0; i < s->wheres; i++)
        where &= s->where[i] != EXPR_UNDEF && s->text[i][0];
    return s->kind && where && kept;
}

static void stratum_clear(struct stratum *s)
{
    for (int i = 0; i < s->wheres; i++)
        free(s->text[i]);
    free(s->text);
    free(s->where);
    free(s->point);
    free(s->description);
    cases_part_clear(&s->part);
    sga_buf_free(&s->sample);
    sga_buf_free(&s->result);
    sga_buf_free(&s->note);
    sga_buf_free(&s->also);
}

void answer_strata_clear(struct job *j)
{
    for (int i = 0; i < j->strata.count; i++)
        stratum_clear(j->strata.at + i);
    free(j->strata.at);
    free(j->strata.determinant);
    strata_constraints_free(j->strata.constraints);
    j->strata.constraints = NULL;
    j->strata.determinant = NULL;
    j->strata.at = NULL;
    j->strata.count = 0;
    free(j->place.not_zero);
    j->place.not_zero = NULL;
    j->place.not_zeros = 0;
}

/* A function too long to be written is not left out: the point tells where it vanishes. */
static bool describe_long(struct stratum *s)
{
    if (strcmp(s->kind, "pivot") != 0 || !s->point)
        return false;
    s->description = strdup("a pivot vanishes that is too long to be written out");
    return true;
}

void strata_add(struct job *j, expr_id factor, int before, struct stratum as)
{
    const struct sga_solution *sol = j->solution;
    assert(before <= sol->constraints);
    bool ok = !factor || push(j, &as, factor) || describe_long(&as);
    for (int i = 0; i < before && ok && !as.description; i++)
        if (sol->constraint[i].chosen)
            ok = push(j, &as, sol->constraint[i].expr);
    for (int i = 0; i < sol->specials && ok && before >= 0 && !as.description; i++)
        ok = push(j, &as, sol->special[i]);
    for (int i = 0; i < j->strata.count && ok; i++)
        ok = !factor || !j->strata.at[i].wheres || j->strata.at[i].where[0] != factor;
    if (!ok) {
        stratum_clear(&as);
        return;
    }
    j->strata.at = sga_realloc(j->strata.at, (size_t)(j->strata.count + 1) * sizeof *j->strata.at);
    j->strata.at[j->strata.count++] = as;
}

bool strata_add_case(struct job *j, struct cases_part *part)
{
    struct stratum as = { .kind = "parameter", .part = *part };
    bool ok = true;
    *part = (struct cases_part){ 0 };
    for (int i = 0; i < as.part.wheres && ok; i++)
        ok = push(j, &as, as.part.where[i]);
    if (!ok) {
        sga_limit_met(j->budget, SGA_LIMIT_PARAMETER_CASES);
        stratum_clear(&as);
        return false;
    }
    j->strata.at = sga_realloc(j->strata.at, (size_t)(j->strata.count + 1) * sizeof *j->strata.at);
    j->strata.at[j->strata.count++] = as;
    return true;
}

static void keep_point(struct stratum *as, const struct points_point *p, int n)
{
    as->point = memcpy(sga_malloc((size_t)n * sizeof *as->point), p->x, (size_t)n * sizeof *as->point);
    as->time = p->t;
}

bool strata_drops(struct job *j, expr_id factor, int starts, struct stratum *as)
{
    struct points_point p;
    int rank, n = j->request->system.variables;
    if (j->oracle->reals && points_oracle_zero(j->oracle, factor).truth == POINTS_ZERO)
        return false;                  /* a pivot that died on the way to Pf */
    enum points_status status = strata_look_at(j, (struct strata_look){ .c = j->solution->constraints, .factor = factor, .starts = starts }, &p, &rank);
    /* an irregular place was approached to about 6 digits only: listed, to be safe */
    bool lower = status == POINTS_IRREGULAR || (status == POINTS_OK && rank < n - j->solution->free_columns);
    if (lower) {
        keep_point(as, &p, n);
        as->approximate = status == POINTS_IRREGULAR || !p.certified;
    }
    points_point_clear(&p);
    return lower;
}

/* Searches of a second kind are for small systems, and so many of them: what is left out is said. */
static bool too_many(struct job *j, int variables, int *done)
{
    bool large = variables > SGA_MOST_STRATA_OFF_VARIABLES, skip = large || (*done)++ >= SGA_MOST_STRATA_OFF;
    if (skip)
        sga_limit_met(j->budget, large ? SGA_LIMIT_STRATA_OFF_VARIABLES : SGA_LIMIT_STRATA_OFF);
    j->strata.skipped |= skip;
    return skip;
}

/* The same on the larger set of the first `before` constraints, on which the pivot was
 * chosen: what follows from dividing by it need not hold where it vanishes. */
static bool drops_before(struct listing *l, expr_id factor, int before, struct stratum *as)
{
    struct points_point p;
    int rank, n = l->j->request->system.variables;
    if (!l->j->request->strata || too_many(l->j, n, &l->off))
        return false;
    int general = strata_general_rank(l, before);
    enum points_status status = strata_look_at(l->j, (struct strata_look){ .c = before, .factor = factor }, &p, &rank);
    bool lower = status == POINTS_IRREGULAR || (status == POINTS_OK && rank < general);
    if (lower) {
        as->off = true;
        keep_point(as, &p, n);
    }
    points_point_clear(&p);
    return lower;
}

/* Whether the values of the parameters at a point, where these are among the variables, are a case that is listed. A point that is
 * not proved may only have been approached. */
static bool in_a_case(struct listing *l, struct points_point *p, bool approached)
{
    static const double NEAR = 1e-4;
    num_ball_extend(&p->ball);
    for (int i = 0; i < l->cases->parts; i++) {
        const struct cases_part *c = l->cases->part + i;
        bool in = true;
        for (int k = 0; k < c->wheres && in; k++) {
            arb_srcptr v = num_ball_value(&p->ball, c->where[k]);
            in = arb_contains_zero(v) || (approached && fabs(arf_get_d(arb_midref(v), ARF_RND_NEAR)) < NEAR);
        }
        if (in)
            return true;
    }
    return false;
}

/* Whether the rank drops where the factor vanishes for special values of the parameters, none
 * of which was met above; cases of their own are looked at there. as gets the point. */
static bool drops_for_some(struct listing *l, expr_id factor, struct stratum *as)
{
    struct points_point p;
    struct job *j = l->j;
    int rank;
    bool none = !j->request->system.parameters || j->request->store.symbol[j->request->system.parameter[0]].kind != EXPR_PARAMETER;
    if (none || too_many(j, j->request->system.variables, &l->moved))
        return false;
    enum points_status status = strata_look_at(j, (struct strata_look){ .c = j->solution->constraints, .factor = factor, .moving = STRATA_PARAMETERS }, &p, &rank);
    bool lower = status == POINTS_IRREGULAR || (status == POINTS_OK && rank < j->request->system.variables - j->solution->free_columns);
    lower = lower && !in_a_case(l, &p, !p.certified);
    if (lower)
        keep_point(as, &p, j->request->system.variables);
    points_point_clear(&p);
    return lower;
}

/* A factor in time only: at its zeros the rank may drop for an instant. */
static bool instant(struct job *j, expr_id factor)
{
    struct points_point p;
    int rank;
    enum points_status status = strata_look_at(j, (struct strata_look){ .c = j->solution->constraints, .factor = factor, .moving = STRATA_TIME }, &p, &rank);
    points_point_clear(&p);
    return status == POINTS_IRREGULAR || (status == POINTS_OK && rank < j->request->system.variables - j->solution->free_columns);
}

static void consider(struct listing *l, expr_id factor, int before)
{
    struct expr_store *st = &l->j->request->store;
    unsigned f = expr_facts_of(l->facts, st, factor);
    struct stratum as = { .kind = "pivot" };
    bool number = !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME | EXPR_HAS_PARAMETER));     /* 1 - cos(1e-90): decided already */
    if (f & EXPR_NONZERO || number || !job_goes_on(l->j))
        return;
    if (!(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
        strata_condition(l, &factor, 1);
    else if (!(f & EXPR_HAS_VARIABLE)) {
        if (l->j->solution->verdict != SGA_INCONSISTENT && instant(l->j, factor))
            strata_add(l->j, factor, -1, (struct stratum){ .kind = "instant" });
    } else if (l->j->solution->verdict != SGA_INCONSISTENT && (strata_drops(l->j, factor, 0, &as) || drops_before(l, factor, before, &as)))
        strata_add(l->j, factor, before, as);
    else if (l->j->solution->verdict != SGA_INCONSISTENT && drops_for_some(l, factor, &as))
        strata_add(l->j, factor, before, as);
}

void strata_factors(struct listing *l, expr_id value, int before)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, l->j->budget);
    struct poly_factors f;
    if (!strata_through(l, value, &limits, &f)) {
        consider(l, value, before);
        return;
    }
    for (int i = 0; i < f.factors; i++)
        if (!strata_squares(l, f.factor + i, before) && !f.factor[i].never_zero)
            consider(l, f.factor[i].expr, before);
    poly_factors_clear(&f);
}

static const struct sga_pivot *pivot_of(const struct sga_solution *sol, int i) { return i < sol->pivots ? sol->pivot + i : sol->dead + (i - sol->pivots); }

/* The last generation that is spoken of: a set found empty has none left, though pivots were met on the way. */
static int latest(const struct sga_solution *sol)
{
    int last = sol->generations + 1;
    for (int i = 0; i < sol->pivots + sol->deads; i++)
        last = pivot_of(sol, i)->generation > last ? pivot_of(sol, i)->generation : last;
    return last;
}

/* How many constraints stood when the elimination of each generation began. malloced. */
static int *stood(const struct sga_solution *sol)
{
    int last = latest(sol), *before = sga_malloc(((size_t)last + 1) * sizeof *before);
    for (int g = 0, k = 0; g <= last; g++) {
        while (k < sol->constraints && (sol->constraint[k].generation < g || sol->constraint[k].origin == SGA_FROM_RESTRICTION))
            k++;
        before[g] = k;
    }
    return before;
}

static void list_strata(struct job *j)
{
    struct expr_facts facts;
    struct domain domain;
    struct cases cases = { 0 };
    struct definitions names = { 0 };
    struct listing l = { .j = j, .facts = &facts, .domain = &domain, .cases = &cases, .names = &names, .before = -1, .rank = -1 };
    const struct sga_solution *sol = j->solution;
    bool empty = sol->verdict == SGA_INCONSISTENT;
    if (!texts_written(j))
        return;
    stage_begin(j->clock, STAGE_STRATA);
    expr_facts_init(&facts);
    expr_cone_init(&l.cone);
    l.alike = poly_alike_new(&j->request->store);
    domain = (struct domain){ .system = &j->request->system, .facts = &facts, .cone = &l.cone, .budget = j->budget };
    for (int i = 0; i < sol->conditions.count; i++)
        strata_condition(&l, sol->conditions.at[i].function, sol->conditions.at[i].functions);
    for (int i = 0; i < sol->others; i++)
        if (sol->other[i] != sol->special[0])
            strata_add(j, sol->other[i], -1, (struct stratum){ .kind = "pivot", .off = true });
    for (int i = 0; i < sol->branches; i++)
        if (expr_facts_of(&facts, &j->request->store, sol->branch[i].expr) & EXPR_HAS_VARIABLE)
            strata_add(j, sol->branch[i].expr, sol->branch[i].before, (struct stratum){ .kind = "branch" });
        else
            strata_add(j, sol->branch[i].expr, -1, (struct stratum){ .kind = "instant" });
    for (int i = 0; i < sol->sides; i++) {
        if (sol->side[i].unseen)        /* nothing is known to lie beyond */
            continue;
        unsigned f = expr_facts_of(&facts, &j->request->store, sol->side[i].function);
        strata_add(j, sol->side[i].function, -1, (struct stratum){ .kind = f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME) ? "side" : "parameter" });
    }
    if (!empty)
        strata_components(&l);
    SGA_FREED int *before = stood(sol);
    for (int i = 0; i < sol->pivots + sol->deads; i++) {
        const struct sga_pivot *p = pivot_of(sol, i);
        assert(p->generation >= 0 && (empty || p->generation <= sol->generations + 1));
        if (!expr_is_const(&j->request->store, p->value))
            strata_factors(&l, p->value, before[p->generation]);
    }
    if (!empty) {
        strata_determinants(&l);
        strata_domain(&l);
        strata_lost(&l);
    }
    strata_alike(&l);
    strata_cases(&l);
    cases_clear(&cases);
    definitions_clear(&names);
    poly_alike_free(l.alike);
    expr_facts_clear(&facts);
    expr_cone_clear(&l.cone);
}

bool answer_strata(struct job *j)
{
    list_strata(j);
    for (int i = 0; i < j->strata.count; i++)
        assert(stratum_sane(j->strata.at + i));
    return true;
}
