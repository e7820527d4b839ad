/* The motion of a part of the system. See part.h. */
#include "part.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "follow.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "slice.h"
#include "stage_list.h"
#include "system.h"
#include "tolerance.h"
#include "trajectory.h"
#include "warnings.h"

/* Of what is allowed of a solution, starts that are the same may differ by this. */
static const double SAME_START = 0.1;

/* A job inside a job, with what is its own. */
struct part {
    struct job job;
    struct request request;
    struct sga_warnings warnings;     /* none: what is said goes into the owner's */
    struct sga_error err;
};

bool job_slice_holds(const struct job *j)
{
    return !j->slice || !j->slice->tied || (answer_moved(j, 0) == 0 && j->solution->free_columns == 0);
}

static bool begin(struct part *p, struct job *of)
{
    struct request *r = &p->request;
    p->err = (struct sga_error){ 0 };
    p->job = (struct job){ .request = r, .request_text = of->request_text, .request_length = of->request_length, .host = { .most_result = of->host.most_result, .team = of->host.team, .flow = of->host.flow },
                           .stages = of->stages, .stage = of->stage, .budget = of->budget, .warnings = &p->warnings, .clock = of->clock, .err = &p->err };
    *r = (struct request){ 0 };
    if (!request_read(r, of->request_text, of->request_length, &p->err))
        return false;
    r->want &= SLICE_MOTION;
    r->store.max_nodes = of->request->store.max_nodes;
    r->store.deadline = of->request->store.deadline;
    r->store.seconds = of->request->store.seconds;
    return true;
}

static void end(struct part *p)
{
    job_clear(&p->job);
    request_clear(&p->request);
}

/* What is tried, in order: all that does not feed the outputs, which has to be shown to be right afterwards; what follows, tied to the start or not. */
enum way { FEEDS, TIED, STRICT, WAYS };

/* One way through; *less: something was left out. */
static bool run(struct part *p, enum way way, bool *less)
{
    struct job *j = &p->job;
    if (way == FEEDS)
        answer_slice_feeds(j);
    else
        answer_slice(j, way == TIED);
    *less = j->slice;
    return *less && job_prepare(j) && job_run(j, false) && (way != FEEDS || (j->solution->verdict == SGA_UNIQUE && j->solution->free_columns == 0))
           && job_slice_holds(j) && job_run(j, true) && job_slice_holds(j);
}

static const double *start_of(const struct job *j)
{
    return j->trajectory ? j->trajectory->initial : j->initial ? j->initial->x : NULL;
}

/* The start that the whole system has: into x, by its variables. False: there is none, or it is not that of what was left out before, or the job cannot go on. */
static bool whole_start(struct job *j, double *x)
{
    struct sga_error err = { 0 }, *own = j->err;
    unsigned want = j->request->want;
    j->err = &err;
    j->request->want = REQUEST_CONSISTENT_INITIAL;
    bool ok = answer_own_motion(j) && job_slice_holds(j);
    if (j->initial && ok)
        memcpy(x, j->initial->x, (size_t)j->request->system.variables * sizeof *x);
    answer_motion_drop(j);
    j->request->want = want;
    j->err = own;
    return ok;
}

/* The part's motion is that of the whole system: it is the only one from its start, those of the whole system are among its motions, and the
 * whole system has one from this very start (Pf of the whole is known: a motion leaves each of its points). */
static bool same_start(struct job *j, const struct job *part)
{
    SGA_ARENA(mem);
    const struct sys_system *sys = &j->request->system, *less = &part->request->system;
    const double *of_part = start_of(part);
    double *x = sga_zeros(&mem, (size_t)sys->variables + 1, sizeof *x);
    const struct sga_tolerance asked = { SAME_START * j->request->accuracy.rtol, SAME_START * j->request->accuracy.atol };
    if (!of_part || !whole_start(j, x))
        return false;
    int at = 0;
    for (int v = 0; v < less->variables; v++) {      /* in the same order */
        while (at < sys->variables && strcmp(answer_variable_name(j, at), answer_variable_name(part, v)) != 0)
            at++;
        if (at == sys->variables || !(fabs(x[at] - of_part[v]) <= sga_allowed(asked, 1, x[at])))
            return false;
    }
    return true;
}

bool job_part(struct job *j)
{
    assert(!j->part);
    bool beside = slice_beside(j->request);
    if (!j->request_text || j->place.depth || j->solution->verdict == SGA_INCONSISTENT || (!beside && !slice_feeds_less(j)))
        return true;
    struct part *p = sga_zeros(&j->mem, 1, sizeof *p);
    bool less = true;
    for (int way = FEEDS; way < (beside ? WAYS : TIED) && !j->part && (less || way == TIED); way++) {
        if (!begin(p, j))
            break;
        if (way == FEEDS)
            job_progress(j, "trajectory", 0.5);
        if (run(p, (enum way)way, &less) && (way != FEEDS || same_start(j, &p->job)))
            j->part = &p->job;
        else
            end(p);
        if (!job_goes_on(j))
            return false;
    }
    return true;
}

void job_part_clear(struct job *j)
{
    if (!j->part)
        return;
    end((struct part *)j->part);
    j->part = NULL;
}
