/* Motions and starts from where relations hold: see start_relations.h. */
#include "start_relations.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "enclosed.h"
#include "error.h"
#include "mem.h"
#include "reduction.h"
#include "start_search.h"
#include "system.h"
#include "warnings.h"

/* The motion's own start may differ by rounding from the one that was found; it lies elsewhere past this, relative to 1 + |value|. */
static const double SAME = 1e-7;
/* Variables of systems whose start is looked at in longer numbers, to see how well it is known. */
enum { LOOKED = 400 };

bool start_relations_any(const struct traj_request *rq)
{
    return rq->relations > 0 || rq->low;
}

/* The request from the start that was found. */
static bool from_start(struct start_search *s, bool exact, struct traj_request *to, struct start_found *found, struct sga_error *err)
{
    size_t n = (size_t)s->sys->variables;
    expr_id *digits = sga_zeros(&s->mem, n + 1, sizeof *digits);
    struct start_found outside = { 0 };
    if (!start_search_find(s, NULL, false, found, &outside)) {
        start_culprit(s, &outside, err);
        memcpy(err->stage, "initial", 8);
        return false;
    }
    for (int j = 0; j < s->sys->variables && s->rq->low; j++)        /* what lies on a bound lies on none of its sides */
        found->x[j] = fmin(fmax(found->x[j], s->rq->low[j]), s->rq->high[j]);
    unsigned char *given = sga_take(&s->mem, n + 1);
    memset(given, 1, n + 1);
    *to = s->plain;
    to->initial = found->x;
    to->given = given;
    if (s->rq->arithmetic == TRAJ_BALL) {       /* enclosed_place says what it is */
        to->exact_initial = s->rq->exact_initial ? digits : NULL;
    } else if (exact && (s->rq->exact_initial || s->rq->exact_time || s->rq->arithmetic == TRAJ_DOUBLE_DOUBLE)) {
        if (!start_exact(s, found->x, digits, err))
            return false;
        to->exact_initial = digits;
    } else {
        struct sga_error ignored = { 0 };
        to->exact_initial = NULL;
        if (s->rq->relations && n <= LOOKED && !start_exact(s, found->x, digits, &ignored) && sga_budget_ok(s->rq->budget, err))
            sga_warn(s->rq->budget, SGA_W_START_TOUCHES, "/trajectory/start_equations", "at the start the equations touch the constraints, or each other, and do not cross them: they hold to "
                     "rounding, and the start is known to about 1e-8 of its size");
    }
    return sga_budget_ok(s->rq->budget, err);
}

/* In balls: what that start is. */
struct meant {
    struct flow flow;
    struct sga_solution with;
    struct traj_request rq;
    struct enclosed_found found;
};

/* By variable: it lies on its low bound (-1), on its high one (1), and no value that was given holds it there. */
static signed char *on_bounds(struct start_search *s, const double *x)
{
    const struct traj_request *rq = s->rq;
    signed char *at = sga_zeros(&s->mem, (size_t)s->sys->variables + 1, 1);
    for (int j = 0; j < s->sys->variables && rq->low; j++) {
        bool stays = x[j] == rq->initial[j] && (rq->given[j] || (rq->held && rq->held[j]));
        at[j] = (signed char)(stays ? 0 : (x[j] == rq->high[j]) - (x[j] == rq->low[j]));
    }
    return at;
}

/* With the relations of use (NULL: all). *full: none of them, nor of the bounds, follows from the others. flow_clear is due. */
static bool mean_these(struct start_search *s, const double *x, const unsigned char *use, struct meant *m, bool *full, struct sga_error *err)
{
    SGA_FREED unsigned char *solved = sga_calloc((size_t)s->sys->variables + 1, 1);
    start_with(s, use, on_bounds(s, x), &m->with);
    bool ok = flow_init(&m->flow, s->sys, &m->with, &m->rq, err);
    *full = ok && flow_solved(&m->flow, &m->rq, x, solved) == m->with.constraints;
    return ok;
}

/* Without relations that follow from the others. */
static bool mean(struct start_search *s, const struct start_found *found, struct meant *m, struct sga_error *err)
{
    size_t relations = (size_t)s->rq->relations;
    unsigned char *use = sga_zeros(&s->mem, relations + 1, 1);
    expr_id *also = sga_zeros(&s->mem, relations + 1, sizeof *also);
    bool full;
    m->rq = s->plain;
    m->rq.no_motion = true;
    m->found = (struct enclosed_found){ &m->flow, s->sys, &m->with, &m->rq, found->x, s->rq->low, s->rq->high, also, 0 };
    bool ok = mean_these(s, found->x, NULL, m, &full, err);
    for (size_t i = 0; i < relations && ok && !full; i++) {
        use[i] = 1;
        flow_clear(&m->flow);
        ok = mean_these(s, found->x, use, m, &full, err);
        if (!full) {
            use[i] = 0;
            also[m->found.alsos++] = s->relation[i];
        }
        full = false;
    }
    if (ok && m->found.alsos) {
        flow_clear(&m->flow);
        ok = mean_these(s, found->x, use, m, &full, err);
    }
    return ok;
}

/* What the relations miss at x, the start that the motion has. */
static bool look(struct start_search *s, const struct start_found *found, const double *x, double **residual, int *count, struct sga_error *err)
{
    *residual = sga_calloc((size_t)s->rq->relations + 1, sizeof **residual);
    *count = s->rq->relations;
    bool same = start_residuals(s, x, *residual);
    for (int j = 0; j < s->sys->variables && same; j++)
        same = fabs(x[j] - found->x[j]) <= SAME * (1 + fabs(x[j]));
    return same || sga_fail_at(err, SGA_E_INITIAL, s->rq->relations ? "/trajectory/start_equations" : "/trajectory/bounds",
                               "the start where the relations hold lies on another part of the constraint set than the one that was solved; give trajectory.initial on the part that is meant");
}

bool start_relations_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err)
{
    struct start_search s;
    struct traj_request from;
    struct start_found found = { 0 };
    struct meant meant = { .rq.relations = 0 };
    *r = (struct traj_result){ 0 };
    assert(start_relations_any(rq));
    bool ball = rq->arithmetic == TRAJ_BALL, ok = start_search_init(&s, sys, sol, rq, err) && from_start(&s, true, &from, &found, err) && (!ball || mean(&s, &found, &meant, err));
    from.found = ball ? &meant.found : NULL;
    ok = ok && traj_run(sys, sol, &from, r, err);
    if (meant.found.flow)
        flow_clear(&meant.flow);
    if (ok && !look(&s, &found, r->initial, &r->relation, &r->relations, err)) {
        traj_result_clear(r);
        ok = false;
    }
    if (ok)
        r->moved = found.moved;
    start_search_clear(&s);
    return ok;
}

bool start_relations_consistent(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_initial *r, struct sga_error *err)
{
    struct start_search s;
    struct traj_request from;
    struct start_found found = { 0 };
    *r = (struct traj_initial){ 0 };
    assert(start_relations_any(rq));
    bool ok = start_search_init(&s, sys, sol, rq, err) && from_start(&s, false, &from, &found, err) && traj_consistent(sys, sol, &from, r, err);
    if (ok && !look(&s, &found, r->x, &r->relation, &r->relations, err)) {
        traj_initial_clear(r);
        ok = false;
    }
    if (ok)
        r->moved = found.moved;
    start_search_clear(&s);
    return ok;
}
