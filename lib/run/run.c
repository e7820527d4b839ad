/* One request, stage by stage: read, reduce, print, witness, integrate, write. */
#include "run.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "share.h"
#include "lin.h"
#include "request.h"
#include "slice.h"
#include "stage_clock.h"
#include "part.h"
#include "stage_list.h"
#include "team.h"
#include "warnings.h"
#include "watch.h"
#include "write.h"

void sga_init_guest(void)
{
    lin_init();
    sga_watch_init();
}

void sga_init(void)
{
    sga_init_guest();
    sga_watch_hook();
    request_init();
}

bool sga_canonical(const char *request, size_t length, struct sga_buf *out, struct sga_error *err)
{
    struct request r;
    struct request_bounds bounds = { .seconds = REQUEST_CHECK_SECONDS, .nodes = REQUEST_CHECK_NODES };
    struct sga_error own = { 0 };
    err = err ? err : &own;
    if (request_read_within(&r, request, length, &bounds, err))
        request_clear(&r);
    else if (!bounds.met)
        return false;
    *err = (struct sga_error){ 0 };
    return request_canonical(request, length, out, err);
}

bool sga_plain(const char *request, size_t length, struct sga_buf *out, struct sga_error *err)
{
    return request_plain(request, length, out, err);
}

static const double MAX_MEMORY = 0x1p34, DEFAULT_MEGABYTES = 2048;

static void name_stage(struct sga_error *err, const char *stage)
{
    if (!err->stage[0])
        snprintf(err->stage, sizeof err->stage, "%s", stage);
}

/* One job, and what whoever asks for it allows. */
struct run {
    struct job job;
    const struct sga_run_options *options;
    struct sga_share share;
};

static void wall(void *ctx, const struct sga_error *err)
{
    const struct run *r = ctx;
    struct sga_error located = *err;
    name_stage(&located, r->job.stage);
    r->options->wall(r->options->ctx, &located);
}

/* Shares of a job's work, as the table of stages has them. */
static const double MOTION = 0.5, AFTER_MOTION = 0.9, WRITING = 0.98;

/* A motion's share of its time, while it is what the job is at. */
static void tell_share(void *ctx, double fraction, double t)
{
    struct job *j = ctx;
    if (!strcmp(j->stage, "trajectory"))
        job_progress_at(j, j->stage, fraction, t);
}

static void set_budget(struct run *r)
{
    struct job *j = &r->job;
    const struct sga_run_options *o = r->options;
    double most = o->max_seconds > 0 ? o->max_seconds : 3600;
    double seconds = j->request->limits.seconds > 0 ? fmin(j->request->limits.seconds, most) : most;
    double memory = o->max_memory ? (double)o->max_memory : MAX_MEMORY;
    double megabytes = j->request->limits.megabytes > 0 ? j->request->limits.megabytes : DEFAULT_MEGABYTES;
    *j->budget = (struct sga_budget){
        .deadline = sga_now() + seconds - j->spent, .seconds = seconds,
        .max_generations = j->request->limits.generations,
        .max_memory = (size_t)fmin(megabytes * 0x1p20, memory),
        .max_terms = j->request->limits.terms,
        .cancelled = o->cancelled,
        .cancel_ctx = o->ctx,
        .warnings = j->warnings,
        .share = r->share.tell ? &r->share : NULL,
        .exec = o->exec,
    };
    j->request->store.max_nodes = j->request->limits.nodes;
    j->request->store.deadline = j->budget->deadline;
    j->request->store.seconds = seconds;
}

/* Past a limit nothing is an answer any more; nor is a refusal, for what failed may have been stopped (watch.h). */
static bool within_limits(struct job *j)
{
    enum sga_code code = j->err->code;
    bool said = code == SGA_E_LIMIT_SECONDS || code == SGA_E_LIMIT_MEMORY || code == SGA_E_CANCELLED;
    if (!said && !job_has_left(j))
        *j->err = (struct sga_error){ 0 };
    return job_goes_on(j);
}

/* A request that was read, from its system to its result. *again: what was left out of the system has to
 * be looked at after all. */
static bool run_request(struct job *j, bool tied, struct sga_buf *out, bool *again)
{
    answer_warn_unused(j);
    answer_slice(j, tied);
    bool ok = job_prepare(j) && job_run(j, false);
    *again = ok && !job_slice_holds(j);
    ok = ok && !*again && job_part(j) && job_run(j, true);
    *again |= ok && !job_slice_holds(j);
    if (*again)
        return false;
    if (ok) {
        job_progress(j, "writing", WRITING);
        ok = answer_write(j, out);
    }
    return within_limits(j) && ok;
}

/* What was not found may be beyond a limit. */
static void explain_limits(struct job *j)
{
    enum sga_code code = j->err->code;
    if (code == SGA_E_NO_REAL_POINT || code == SGA_E_UNDECIDED || code == SGA_E_IRREGULAR || code == SGA_E_SPLIT)
        sga_limits_explain(j->warnings, j->err);
}

/* What a process that may leave does not give back piece by piece: a large job's end would wait for that. */
static const size_t LEFT_BEHIND = 256 << 20;

static void leave(struct run *r)
{
    enum sga_code code = r->job.err->code;
    bool limit = code == SGA_E_LIMIT_SECONDS || code == SGA_E_LIMIT_MEMORY || code == SGA_E_CANCELLED;
    if (limit && r->options->wall && sga_watch_used() > LEFT_BEHIND)
        wall(r, r->job.err);
}

/* One way through, from the text. */
static bool run_text(struct run *r, const char *request, size_t length, bool tied, struct sga_buf *out, bool *again)
{
    struct request own = { 0 };
    struct sga_warnings warnings = { 0 };
    struct job *j = &r->job;
    double begin = sga_now();
    j->request = &own;
    j->warnings = &warnings;
    j->clock = sga_zeros(&j->mem, 1, sizeof *j->clock);
    j->budget = sga_zeros(&j->mem, 1, sizeof *j->budget);
    stage_begin(j->clock, STAGE_READ);
    j->request_text = request;
    j->request_length = length;
    set_budget(r);                 /* the service's; the request's own once it is read */
    sga_watch_begin(j->budget, r->options->wall ? wall : NULL, r);
    if (!request_read(&own, request, length, j->err)) {
        leave(r);
        sga_watch_end();
        sga_arena_end(&j->mem);
        return false;
    }
    j->spent += sga_now() - begin;
    set_budget(r);
    if (own.want & (REQUEST_LINEARIZATION | REQUEST_TRANSFER | REQUEST_EQUILIBRIA))
        r->share.to = AFTER_MOTION;
    bool ok = run_request(j, tied, out, again);
    if (!ok && !*again) {
        name_stage(j->err, j->stage);
        explain_limits(j);
        leave(r);
    }
    sga_watch_end();
    job_part_clear(j);
    job_clear(j);
    request_clear(&own);
    return ok;
}

bool sga_run(const char *request, size_t length, const struct sga_run_options *options,
             struct sga_buf *out, struct sga_error *err)
{
    static const struct sga_run_options none = { 0 };
    const struct sga_run_options *o = options ? options : &none;
    struct sga_error own = { 0 };
    struct answer_flow flow = { out, o->give, o->ctx, 0 };
    const struct job first = { .host = { o->max_result, o->progress, o->ctx, o->team, o->give ? &flow : NULL }, .err = err ? err : &own, .stages = job_stages, .stage = "request",
                               .spent = o->team && o->team->member ? o->team->spent : 0 };
    struct run r = { first, o, { .from = MOTION, .to = WRITING, .tell = o->progress ? tell_share : NULL } };
    r.share.ctx = &r.job;
    double begin = sga_now();
    bool again = false, ok = run_text(&r, request, length, true, out, &again);
    if (!again)
        return ok;
    r.job = first;
    r.job.spent += sga_now() - begin;
    return run_text(&r, request, length, false, out, &again);
}
