/* One analysis, many trajectories: the sets of initial values and parameters of `sweep`, each with its own end
 * or error. */
#include "sweep.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "error.h"
#include "integrate.h"
#include "jet.h"
#include "run_job.h"
#include "mem.h"
#include "budget.h"
#include "request.h"
#include "stage_clock.h"
#include "stratum.h"
#include "sweep_case.h"
#include "sweep_team.h"
#include "warnings.h"
#include "write.h"

/* The reduction follows the branch, and takes the regular functions, that lie nearest to where
 * the request starts: with other starts they would be others, and each set is analysed by itself. Forms that are prepared for one analysis cannot be. */
static bool one_for_all(struct job *j, const struct sga_solution *s, bool *each)
{
    *each = s->branches > 0;
    for (int i = 0; i < s->constraints; i++)
        *each |= s->constraint[i].chosen || s->constraint[i].near_point;
    for (int i = 0; i < j->strata.count; i++)
        *each |= !strcmp(j->strata.at[i].kind, "branch");
    return !*each || !(j->primary || j->mechanical || j->op)
           || sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/sweep", "the constraints have branches, so that starts need analyses of their own, for which this form is not prepared; send one request for each");
}

/* What a member of the result begins with, where parameters are swept. */
void sweep_write_set(const struct job *j, const struct request_sweep *m, const char *analysis, struct sga_json *w)
{
    const struct request *r = j->request;
    if (!r->swept_count)
        return;
    sga_json_key(w, "parameters");
    sga_json_object(w);
    for (int i = 0; i < r->swept_count; i++)
        sga_json_member_double(w, r->store.symbol[r->swept[i].symbol].name, m->parameter_value[i]);
    sga_json_end_object(w);
    if (analysis)
        sga_json_member_string(w, "analysis", analysis);
}

void sweep_write_error(const struct job *j, const struct request_sweep *m, struct sga_json *w, const struct sga_error *e)
{
    sga_json_object(w);
    sweep_write_set(j, m, NULL, w);
    sga_json_key(w, "error");
    sga_json_object(w);
    sga_json_member_string(w, "code", sga_code_text(e->code));
    sga_json_member_string(w, "detail", e->detail);
    sga_json_end_object(w);
    sga_json_end_object(w);
}

/* The trajectory of a set: from the general analysis where that holds, otherwise (or `each`) from one of the system at
 * these values. *analysis: from which. single: of sweep_case_single. */
static bool at_parameters(struct job *j, const struct sga_solution *s, const struct traj_request *r, struct sweep_modes modes, const struct request_sweep *m, bool each,
                          const unsigned char *single, const char **analysis, struct sga_error *err)
{
    struct sweep_case c;
    struct sga_error general = { 0 };
    const struct sga_solution *of = &c.solution;
    int set = (int)(m - j->request->sweep);
    bool ok = sweep_case_make(&c, j, s, r, m, err);
    const struct traj_request *q = ok && c.solved && !each ? modes.set(modes.of, set, &c.system, &c.solution, &c.request, &general) : NULL;
    bool found = q && traj_run(&c.system, &c.solution, q, j->trajectory, &general);
    *analysis = "shared";
    if (found && !sweep_case_holds(&c, j->trajectory->initial, single)) {
        traj_result_clear(j->trajectory);
        found = false;
    }
    if (ok && !found && job_goes_on(j)) {
        *analysis = "own";
        of = &c.own;
        q = sweep_case_solve(&c, j, r, err) ? modes.set(modes.of, set, &c.system, &c.own, &c.request, err) : NULL;
        found = q && traj_run(&c.system, &c.own, q, j->trajectory, err);
    }
    if (found) {
        modes.further(modes.of, &c.system, of, q, j->trajectory);
        modes.tell(modes.of);
    }
    modes.unset(modes.of);
    sweep_case_clear(&c);
    return found;
}

/* The trajectory from a set's own start. */
static bool from_start(struct job *j, const struct sga_solution *s, const struct traj_request *r, struct sweep_modes modes, const struct request_sweep *m, struct sga_error *err)
{
    const struct traj_request *q = modes.set(modes.of, (int)(m - j->request->sweep), &j->request->system, s, r, err);
    bool found = q && answer_integrate(j, s, q, j->trajectory, err);
    if (found) {
        modes.further(modes.of, &j->request->system, s, q, j->trajectory);
        modes.tell(modes.of);
    }
    modes.unset(modes.of);
    return found;
}

/* One member. False: the job ends. */
static bool one(struct job *j, const struct sga_solution *s, struct traj_request *r, struct sweep_modes modes, const struct request_sweep *m, bool each, const unsigned char *single,
                struct sweep_left *left, struct sga_json *w)
{
    struct request_trajectory *t = &j->request->trajectory;
    struct request_initial *keep = t->initial;
    int keeps = t->initials, n = j->request->system.variables;
    double *initial = sga_calloc((size_t)n, sizeof *initial);
    unsigned char *given = sga_calloc((size_t)n, 1);
    SGA_ARENA(mem);
    expr_id *exact = sga_zeros(&mem, (size_t)n + 1, sizeof *exact);
    const expr_id *exact_before = r->exact_initial;
    const char *analysis = NULL;
    struct sga_error err = { 0 };
    for (int k = 0; k < m->initials; k++) {
        initial[m->initial[k].variable] = m->initial[k].value;
        given[m->initial[k].variable] = 1;
        exact[m->initial[k].variable] = m->initial[k].exact;
    }
    r->exact_initial = exact_before ? exact : NULL;
    r->initial = initial;
    r->given = given;
    bool found = each || j->request->swept_count ? at_parameters(j, s, r, modes, m, each, single, &analysis, &err) : from_start(j, s, r, modes, m, &err);
    bool ok = job_goes_on(j);
    t->initial = m->initial;
    t->initials = m->initials;
    if (ok && found) {
        sga_json_object(w);
        sweep_write_set(j, m, analysis, w);
        left->moved += answer_start_moved(j, j->trajectory->initial);
        left->found++;
        ok = answer_write_motion(j, w);
    } else if (ok) {
        left->late |= err.code == SGA_E_LIMIT_SECONDS;
        sweep_write_error(j, m, w, &err);
    }
    t->initial = keep;
    t->initials = keeps;
    if (found)
        traj_result_clear(j->trajectory);
    r->exact_initial = exact_before;
    free(initial);
    free(given);
    return ok && answer_fits(j, w->out);
}

/* Of what is kept for writing, the part that members may take for what is bounded by no rows (analyses of their own). */
static const double ENDING_PART = 0.5;

bool sweep_too_short(struct job *j)
{
    return sga_fail(j->err, SGA_E_LIMIT_SECONDS, "the limit of %g seconds ended before any set had what is wanted; raise limits.seconds", j->budget->seconds);
}

/* The time ended in a member (*why), or before it: it says so. False: that is no answer, as nothing had a motion before. */
static bool late(struct job *j, const struct request_sweep *m, struct sga_error *why, const struct sweep_left *left, struct sga_json *w)
{
    if (!left->found)
        return sweep_too_short(j);
    if (why->code != SGA_E_LIMIT_SECONDS)
        sga_fail(why, SGA_E_LIMIT_SECONDS, "the limit of %g seconds ended before this set was begun; raise limits.seconds, or send fewer sets", j->budget->seconds);
    sweep_write_error(j, m, w, why);
    return answer_fits(j, w->out);
}

/* A member within the time that members have. */
static bool in_time(struct job *j, const struct sga_solution *s, struct traj_request *r, struct sweep_modes modes, const struct request_sweep *m, bool each, const unsigned char *single,
                    struct sweep_left *left, struct sga_json *w)
{
    double deadline = j->budget->deadline;
    size_t before = w->out->len;
    if (!(r->rows_until > 0))
        return one(j, s, r, modes, m, each, single, left, w);
    struct sga_error why = { 0 };
    if (sga_now() >= r->rows_until)
        return late(j, m, &why, left, w);
    j->budget->deadline = r->rows_until + ENDING_PART * (deadline - r->rows_until);
    bool ok = one(j, s, r, modes, m, each, single, left, w);
    j->budget->deadline = deadline;
    if (ok || j->err->code != SGA_E_LIMIT_SECONDS || w->out->len != before || !left->found)
        return ok;
    why = *j->err;
    *j->err = (struct sga_error){ 0 };
    return late(j, m, &why, left, w);
}

/* What each member is made of. */
struct sweep {
    struct job *j;
    const struct sga_solution *solution;
    struct traj_request request;
    struct sweep_modes modes;
    bool each;                               /* each set has an analysis of its own */
    const unsigned char *single;
};

static char *make_set(void *of, int set, struct sweep_left *left)
{
    struct sweep *s = of;
    struct sga_buf out = { 0 };
    struct sga_json w;
    sga_json_begin(&w, &out);
    if (in_time(s->j, s->solution, &s->request, s->modes, s->j->request->sweep + set, s->each, s->single, left, &w))
        return sga_buf_take(&out);
    sga_buf_free(&out);
    return NULL;
}

bool answer_sweep(struct job *j, const struct sga_solution *s, const struct traj_request *request, struct sweep_modes modes)
{
    assert(j->request->sweeps > 0 && !j->trajectory);
    bool each;
    if (!one_for_all(j, s, &each))
        return false;
    stage_begin(j->clock, STAGE_TRAJECTORY);
    struct sweep_left left = { 0 };
    struct traj_result result;               /* of one after the other */
    SGA_FREED unsigned char *single = j->request->swept_count ? sweep_case_single(&j->request->store, s) : NULL;
    struct sweep sweep = { j, s, *request, modes, each, single };
    sweep.request.programs = num_jet_programs_new();
    j->trajectory = &result;
    j->sweep = sweep_all(j, j->request->sweeps, modes.keeps, (struct sweep_maker){ &sweep, make_set }, &left);
    j->trajectory = NULL;
    num_jet_programs_free(sweep.request.programs);
    if (left.moved)
        sga_warn(j->budget, SGA_W_START_MOVED, "/sweep", "the starts of %d set%s were moved onto the constraints", left.moved, left.moved > 1 ? "s" : "");
    return j->sweep && (left.found || !left.late || sweep_too_short(j));
}
