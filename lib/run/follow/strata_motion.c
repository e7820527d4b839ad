/* A start on a stratum, where the general field is not determined: the stratum's own field may
 * be. */
#include "strata_case.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "follow.h"
#include "run_job.h"
#include "reduce.h"
#include "request.h"
#include "strata.h"
#include "stratum.h"
#include "stratum_frame.h"
#include "texts.h"
#include "trajectory.h"

/* A start that has to be moved this far does not lie on the stratum. */
static const double ON_STRATUM = 1e-9;

/* The stratum's motion from the request's start; *there: the start lies on it. */
static bool motion_on(struct job *j, struct stratum *s, bool *there, struct sga_error *err)
{
    struct strata_frame f;
    if (!strata_enter(j, s, &f, err))
        return false;
    if (f.keep.start.x) {
        size_t size = (size_t)j->request->system.variables * sizeof *j->start.x;
        j->start.x = memcpy(sga_take(&j->mem, size), f.keep.start.x, size);
    }
    if (f.keep.start.given) {
        size_t size = (size_t)j->request->system.variables;
        j->start.given = memcpy(sga_take(&j->mem, size), f.keep.start.given, size);
    }
    j->start.time = f.keep.start.time;
    j->request->want = (f.request.want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL)) | REQUEST_CONSTRAINTS
                      | REQUEST_VECTOR_FIELD;
    bool ok = strata_mechanical(j, err) && answer_reduce(j) && answer_texts(j) && answer_witness(j) && answer_own_motion(j);
    *there = ok && answer_moved(j, 1) <= ON_STRATUM;
    if (*there) {
        if (j->trajectory)
            f.keep.trajectory = memcpy(sga_take(&f.keep.mem, sizeof *j->trajectory), j->trajectory, sizeof *j->trajectory);
        if (j->initial)
            f.keep.initial = memcpy(sga_take(&f.keep.mem, sizeof *j->initial), j->initial, sizeof *j->initial);
        f.keep.tradeoff = j->tradeoff;
        j->trajectory = NULL;
        j->initial = NULL;
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
    unsigned want = j->request->want;
    struct sga_error err = { 0 }, *keep = j->err;
    j->err = &err;
    j->request->want |= REQUEST_CONSTRAINTS;
    if (answer_texts(j))
        answer_strata(j);
    j->request->want = want;
    j->err = keep;
}

bool answer_motion_on_stratum(struct job *j)
{
    assert(j->err->code == SGA_E_NO_MOTION);
    struct sga_error first = *j->err;
    bool own_texts = !texts_written(j);
    if (own_texts)
        list_strata(j);
    struct sga_buf said = { 0 };
    answer_motion_drop(j);
    bool done = false;
    for (int i = 0; i < j->strata.count && !done; i++) {
        struct stratum *s = j->strata.at + i;
        struct sga_error err = { 0 };
        bool there = false;
        if (strcmp(s->kind, "parameter") == 0 || !strata_solvable(s))
            continue;
        if (!j->request->strata) {
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
    if (own_texts)                           /* nothing else is written of them */
        answer_texts_clear(j);
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
