/* A start on a stratum, where the general field is not determined: the stratum's own field may
 * be. */
#include "strata_case.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "tradeoff.h"

/* A start that has to be moved this far does not lie on the stratum. */
static const double ON_STRATUM = 1e-9;

/* The stratum's motion from the request's start; *there: the start lies on it. */
static bool motion_on(struct job *j, struct stratum *s, bool *there, struct sga_error *err)
{
    struct strata_frame f;
    if (!strata_enter(j, s, &f, err))
        return false;
    if (f.keep.start.x) {
        size_t size = (size_t)j->request.system.variables * sizeof *j->start.x;
        j->start.x = memcpy(sga_malloc(size), f.keep.start.x, size);
    }
    if (f.keep.start.given) {
        size_t size = (size_t)j->request.system.variables;
        j->start.given = memcpy(sga_malloc(size), f.keep.start.given, size);
    }
    j->start.time = f.keep.start.time;
    j->request.want = (f.keep.request.want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL)) | REQUEST_CONSTRAINTS
                      | REQUEST_VECTOR_FIELD;
    bool ok = strata_mechanical(j, err) && answer_reduce(j) && answer_texts(j) && answer_witness(j) && answer_motion(j);
    double moved = j->trajectory.has ? j->trajectory.result.moved : j->initial.has ? j->initial.result.moved : j->tradeoff ? j->tradeoff->moved : 1;
    *there = ok && moved <= ON_STRATUM;
    if (*there) {
        f.keep.trajectory = j->trajectory;
        f.keep.initial = j->initial;
        f.keep.tradeoff = j->tradeoff;
        j->trajectory.has = j->initial.has = false;
        j->tradeoff = NULL;
    }
    strata_leave(j, &f);
    return ok;
}

/* What stands where the start lies, for the refusal. */
static void say(struct sga_buf *out, const struct stratum *s, const char *why)
{
    sga_buf_printf(out, "%s%s", out->len ? "; " : "", "where ");
    for (int k = 0; k < s->wheres; k++)
        sga_buf_printf(out, "%s%.80s", k ? " = " : "", s->text[k]);
    sga_buf_printf(out, " = 0: %.160s", why);
}

/* The list of strata, where no text was wanted. */
static void list_strata(struct job *j)
{
    unsigned want = j->request.want;
    struct sga_error err = { 0 }, *keep = j->err;
    j->err = &err;
    j->request.want |= REQUEST_CONSTRAINTS;
    if (answer_texts(j))
        answer_strata(j);
    j->request.want = want;
    j->err = keep;
}

bool answer_motion_on_stratum(struct job *j)
{
    struct sga_error first = *j->err;
    bool own_texts = !j->texts.has;
    if (own_texts)
        list_strata(j);
    struct sga_buf said = { 0 };
    if (j->trajectory.has)
        traj_result_clear(&j->trajectory.result);
    if (j->initial.has)
        traj_initial_clear(&j->initial.result);
    answer_tradeoff_clear(j->tradeoff);
    j->tradeoff = NULL;
    j->trajectory.has = j->initial.has = false;
    bool done = false;
    for (int i = 0; i < j->strata.count && !done; i++) {
        struct stratum *s = j->strata.at + i;
        struct sga_error err = { 0 };
        bool there = false;
        if (strcmp(s->kind, "parameter") == 0 || !strata_solvable(s))
            continue;
        if (!j->request.strata) {
            say(&said, s, "strata \"solve\" looks for a motion there");
            continue;
        }
        bool ok = motion_on(j, s, &there, &err);
        if (ok && there) {
            j->strata.moves_on = i + 1;
            done = true;
        } else {
            say(&said, s, ok ? "the start lies elsewhere" : err.detail);
        }
    }
    if (own_texts && j->texts.has) {         /* nothing else is written of them */
        expr_names_clear(&j->texts.names);
        j->texts.has = false;
    }
    if (done) {
        *j->err = (struct sga_error){ 0 };
    } else {
        *j->err = first;
        if (said.len) {
            size_t n = strlen(j->err->detail);
            snprintf(j->err->detail + n, sizeof j->err->detail - n, " (strata: %s)", said.data);
        }
    }
    sga_buf_free(&said);
    return done;
}
