/* Motions and starts from where relations hold: see start_relations.h. */
#include "start_relations.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "mem.h"
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
    if (s->rq->arithmetic == TRAJ_BALL)
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/accuracy/arithmetic", "a start that is searched for (start_equations, bounds) is not enclosed in balls; use \"double-double\", or give the start itself in trajectory.initial");
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
    if (exact && (s->rq->exact_initial || s->rq->exact_time || s->rq->arithmetic == TRAJ_DOUBLE_DOUBLE)) {
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
    *r = (struct traj_result){ 0 };
    assert(start_relations_any(rq));
    bool ok = start_search_init(&s, sys, sol, rq, err) && from_start(&s, true, &from, &found, err) && traj_run(sys, sol, &from, r, err);
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
