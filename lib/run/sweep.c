/* One analysis, many trajectories: the sets of initial values of `sweep`, each with its own end
 * or error. */
#include "sweep.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"

/* The reduction follows the branch, and takes the regular functions, that lie nearest to where
 * the request starts: with other starts they would be others. */
static bool one_for_all(struct job *j, const struct sga_solution *s)
{
    bool several = s->branches > 0;
    for (int i = 0; i < s->constraints; i++)
        several |= s->constraint[i].chosen || s->constraint[i].near_point;
    for (int i = 0; i < j->strata; i++)
        several |= !strcmp(j->stratum[i].kind, "branch");
    return !several || sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/sweep", "the constraints have branches, so that starts "
                                   "need analyses of their own; send one request for each");
}

static void write_error(struct sga_json *w, const struct sga_error *e)
{
    sga_json_object(w);
    sga_json_key(w, "error");
    sga_json_object(w);
    sga_json_member_string(w, "code", sga_code_text(e->code));
    sga_json_member_string(w, "detail", e->detail);
    sga_json_end_object(w);
    sga_json_end_object(w);
}

/* One member. False: the job ends. */
static bool one(struct job *j, const struct sga_solution *s, struct traj_request *r, const struct request_sweep *m, struct sga_json *w)
{
    struct request_trajectory *t = &j->request.trajectory;
    struct request_initial *keep = t->initial;
    int keeps = t->initials, n = j->request.system.variables;
    double *initial = sga_calloc((size_t)n, sizeof *initial);
    unsigned char *given = sga_calloc((size_t)n, 1);
    expr_id *exact = sga_calloc((size_t)n + 1, sizeof *exact);
    const expr_id *exact_before = r->exact_initial;
    struct sga_error err = { 0 };
    for (int k = 0; k < m->initials; k++) {
        initial[m->initial[k].variable] = m->initial[k].value;
        given[m->initial[k].variable] = 1;
        exact[m->initial[k].variable] = m->initial[k].exact;
    }
    r->exact_initial = exact_before ? exact : NULL;
    r->initial = initial;
    r->given = given;
    bool found = answer_integrate(j, s, r, &j->trajectory, &err), ok = sga_budget_ok(&j->budget, j->err);
    if (found && t->conditions)
        j->trajectory.gauge = s->free_columns ? "conditions, then least norm" : "conditions";
    t->initial = m->initial;
    t->initials = m->initials;
    if (ok && found)
        ok = answer_write_motion(j, w);
    else if (ok)
        write_error(w, &err);
    t->initial = keep;
    t->initials = keeps;
    if (found)
        traj_result_clear(&j->trajectory);
    r->exact_initial = exact_before;
    free(exact);
    free(initial);
    free(given);
    return ok && answer_fits(j, w->out);
}

bool answer_sweep(struct job *j, const struct sga_solution *s, const struct traj_request *request)
{
    struct traj_request r = *request;
    struct sga_json w;
    if (!one_for_all(j, s))
        return false;
    double begin = sga_now();
    bool ok = true;
    sga_json_begin(&w, &j->trajectories);
    sga_json_array(&w);
    for (int k = 0; k < j->request.sweeps && ok; k++)
        ok = one(j, s, &r, j->request.sweep + k, &w);
    sga_json_end_array(&w);
    j->seconds.trajectory = sga_now() - begin;
    return ok;
}
