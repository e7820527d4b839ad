/* One worker: a thread and its child process, for as long as the service lives.
 *
 * A worker takes a job once it has a child that has confined itself: where none can be started
 * jobs wait, and the service is not ready while that holds for all workers.
 *
 * The child is watched while it runs: its messages, the eventfd by which a cancellation
 * or the end of the service makes itself known, and the deadline, whichever comes first.
 * The library keeps the job's own time limit; the deadline here is for one that does not
 * come back. */
#include "worker.h"
#include "budget.h"
#include "child.h"
#include "child_inbox.h"
#include "config.h"
#include "helpers.h"
#include "jobs.h"
#include "log.h"
#include "metrics.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/wait.h>
#include <unistd.h>

#include "error.h"

static const double DEADLINE_GRACE = 5, CANCEL_GRACE = 0.8;
/* A child that grew past FAT bytes is replaced. */
enum { FAT = 512 << 20, LOOK_MS = 20 };
enum { HELPERS = 256 };                                   /* as many workers as there may be */
static const double PAUSE_LEAST = 0.1, PAUSE_MOST = 5;    /* between attempts to start one */

struct worker {
    pthread_t thread;
    const struct config *config;
    struct jobs *jobs;
    struct metrics *metrics;
    struct child child;
    const struct account *serves;    /* whose jobs the child has run; NULL: nobody's yet */
    int wake;                        /* eventfd */
    bool unable;                     /* no child can be started: jobs wait */
};

struct workers {
    long count;
    struct worker worker[];
};

static bool ending(void *jobs)
{
    return jobs_resting(jobs);
}

/* Another child for the one that is there, or none. */
static bool replace_child(struct worker *w)
{
    char why[256];
    bool started = child_renew(&w->child, CHILD_JOB, w->config, (struct child_patience){ ending, w->jobs }, why, sizeof why);
    if (!started)
        log_event(LOG_L_ERROR, "child_not_started", "reason", why, NULL);
    metrics_add(w->metrics, started ? METRIC_CHILD_STARTS : METRIC_CHILD_FAILURES);
    w->serves = NULL;
    if (started == w->unable)
        jobs_worker_unable(w->jobs, w->unable = !started);
    return started;
}

/* Comes back with a child, however long that takes, or with false where the service drains. */
static bool have_child(struct worker *w)
{
    for (double pause = PAUSE_LEAST; !child_lives(&w->child) && !replace_child(w); pause = pause < PAUSE_MOST / 2 ? 2 * pause : PAUSE_MOST)
        for (double until = sga_now() + pause; sga_now() < until; usleep(LOOK_MS * 1000))
            if (jobs_resting(w->jobs))
                return false;
    return true;
}

static void fail(struct worker *w, struct job *job, enum sga_code code, const char *detail)
{
    struct sga_error err = { .code = code, .stage = "worker" };
    snprintf(err.detail, sizeof err.detail, "%s", detail);
    jobs_failed(w->jobs, job, &err);
}

/* A process that somebody else killed, as the system does where memory ends, is no fault of the
 * job for certain: it runs once more. */
static void child_died(struct worker *w, struct job *job)
{
    char how[128] = "unknown", detail[400];
    int status = child_end(&w->child, how, sizeof how);
    log_event(LOG_L_WARN, "child_died", "job", job_id(job), "how", how,
              "said", *w->child.said ? w->child.said : NULL, NULL);
    bool again = WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL && jobs_try_again(w->jobs, job);
    metrics_add(w->metrics, METRIC_CHILD_DEATHS);      /* whoever sees it counted sees the job waiting again */
    if (again)
        return;
    snprintf(detail, sizeof detail, "The process that ran the job ended by %s, most often because the computation "
             "needed more memory than it may have. Ask for less in `want`, or for fewer samples.", how);
    fail(w, job, SGA_E_WORKER_DIED, detail);
}

static void kill_child(struct worker *w, struct job *job, const char *why)
{
    char how[128];
    metrics_add(w->metrics, METRIC_CHILD_KILLS);
    log_event(LOG_L_WARN, "child_killed", "job", job_id(job), "reason", why, NULL);
    child_end(&w->child, how, sizeof how);
}

static void child_failed(struct worker *w, struct job *job, const struct child_inbox *in)
{
    struct sga_error err;
    child_error(in, &err);
    jobs_failed(w->jobs, job, &err);
}

/* It came to the wall of its memory or time, said so, and is gone: run_job starts another. */
static void child_walled(struct worker *w, const struct job *job)
{
    char how[128];
    child_end(&w->child, how, sizeof how);
    metrics_add(w->metrics, METRIC_CHILD_WALLS);
    log_event(LOG_L_INFO, "child_at_wall", "job", job_id(job), NULL);
}

static bool asks_for_help(const struct helpers *help, const struct child_inbox *in)
{
    return (in->head.type == WIRE_SHARE && in->head.length == sizeof(struct wire_share)) || (in->head.type == WIRE_NEXT && helpers_shares(help));
}

/* What the child asks of others. False: it is gone. */
static bool ask_helpers(struct worker *w, struct helpers *help, const struct child_inbox *in)
{
    struct wire_share share;
    if (in->head.type == WIRE_NEXT)
        return helpers_next(help, w->child.fd);
    memcpy(&share, in->data, sizeof share);
    return helpers_share(help, &share, w->child.fd);
}

static void too_large(struct worker *w, struct job *job, size_t length)
{
    char detail[200];
    kill_child(w, job, "result too large");
    snprintf(detail, sizeof detail, "The result has %.1f MB; the service keeps no more than %.1f MB. Ask for fewer samples or outputs.",
             (double)length * 0x1p-20, (double)w->config->result_limit * 0x1p-20);
    fail(w, job, SGA_E_LIMIT_RESULT, detail);
}

/* A piece of the result. False: there cannot be more of it, and the job has ended. */
static bool add_part(struct worker *w, struct job *job, struct child_parts *parts, const struct child_inbox *in)
{
    size_t length = parts->len + in->head.length;
    if (length <= (size_t)w->config->result_limit && child_parts_add(parts, in))
        return true;
    too_large(w, job, length);
    return false;
}

/* A whole message; true once it has ended the job. */
static bool handle(struct worker *w, struct job *job, struct helpers *help, struct child_inbox *in, struct child_parts *parts)
{
    bool ended = true;
    char how[128];
    if (asks_for_help(help, in)) {
        ended = !ask_helpers(w, help, in);
        if (ended)
            child_died(w, job);
    } else if (in->head.type == WIRE_PROGRESS && in->head.length == sizeof(struct wire_progress)) {
        struct wire_progress p;
        memcpy(&p, in->data, sizeof p);
        p.stage[sizeof p.stage - 1] = 0;
        jobs_progress(w->jobs, job, p.stage, p.fraction, p.t);
        ended = false;
    } else if (in->head.type == WIRE_PART) {
        ended = !add_part(w, job, parts, in);
    } else if (in->head.type == WIRE_DONE && child_parts_end(parts, in)) {
        jobs_done(w->jobs, job, &in->data, in->head.length);
    } else if (in->head.type == WIRE_DONE) {
        too_large(w, job, parts->len + in->head.length);
    } else if (in->head.type == WIRE_ERROR || in->head.type == WIRE_LAST) {
        if (in->head.type == WIRE_LAST)
            child_walled(w, job);
        child_failed(w, job, in);
    } else {
        kill_child(w, job, "malformed message");
        fail(w, job, SGA_E_INTERNAL, "The process that ran the job gave a malformed message.");
    }
    if (ended && w->child.pid && in->head.resident > FAT)
        child_end(&w->child, how, sizeof how);
    child_inbox_clear(in);
    return ended;
}

/* What the eventfd may mean. True where the job is over for this worker. */
static bool woken(struct worker *w, struct job *job, double *deadline, bool *cancelling)
{
    uint64_t count;
    ssize_t ignored = read(w->wake, &count, sizeof count);
    (void)ignored;
    if (jobs_stopping(w->jobs)) {
        kill_child(w, job, "shutdown");
        jobs_requeue(w->jobs, job);
        return true;
    }
    if (jobs_lost(w->jobs, job)) {
        kill_child(w, job, "another daemon has the job");
        return true;
    }
    if (!*cancelling && jobs_cancelled(w->jobs, job)) {
        *cancelling = true;
        *deadline = sga_now() + CANCEL_GRACE;
        wire_send(w->child.fd, WIRE_CANCEL, 0, NULL, 0);
    }
    return false;
}

/* The library keeps its own time: this is for a child that does not come back. */
static void out_of_time(struct worker *w, struct job *job)
{
    size_t length;
    const char *request = jobs_request(w->jobs, job, &length);
    char detail[200];
    snprintf(detail, sizeof detail, "The limit of %g seconds was reached, and %g seconds later the job had not come to an end. "
             "Raise limits.seconds, or ask for less in want.", request ? jobs_seconds(w->config, request, length) : 0.0, DEADLINE_GRACE);
    fail(w, job, SGA_E_LIMIT_SECONDS, detail);
}

static void deadline_passed(struct worker *w, struct job *job, bool cancelling)
{
    kill_child(w, job, cancelling ? "cancelled" : "deadline");
    if (cancelling)
        fail(w, job, SGA_E_CANCELLED, "The job was cancelled while it ran.");
    else
        out_of_time(w, job);
}

static void watch(struct worker *w, struct job *job, struct helpers *help, double deadline)
{
    struct child_inbox in = { .data = NULL };
    struct child_parts parts = { .text = NULL };
    bool cancelling = false;
    for (bool first = true;; first = false) {
        struct pollfd p[2 + HELPERS] = { { .fd = w->child.fd, .events = POLLIN }, { .fd = w->wake, .events = POLLIN } };
        int others = helpers_poll(help, p + 2, HELPERS);
        double left = deadline - sga_now();
        if (left <= 0) {
            deadline_passed(w, job, cancelling);
            break;
        }
        poll(p, (nfds_t)(2 + others), first ? 0 : left > 3600 ? 3600000 : (int)(left * 1000) + 1);
        /* On the first turn the eventfd is read in any case: a cancellation may have come
         * between the claim and now. */
        if ((first || p[1].revents) && woken(w, job, &deadline, &cancelling))
            break;
        if (others && !helpers_look(help, w->child.fd)) {
            child_died(w, job);
            break;
        }
        if (!p[0].revents)
            continue;
        enum received r = child_receive(&in, w->child.fd, (size_t)w->config->result_limit);
        if (r == RECEIVED_WHOLE && handle(w, job, help, &in, &parts))
            break;
        if (r == RECEIVED_END) {
            child_died(w, job);
            break;
        }
        if (r == RECEIVED_TOO_LARGE) {
            too_large(w, job, parts.len + in.head.length);
            break;
        }
    }
    child_inbox_clear(&in);
    child_parts_clear(&parts);
}

static void run_job(struct worker *w, struct job *job)
{
    size_t length;
    const char *request = jobs_request(w->jobs, job, &length);
    if (!request) {
        fail(w, job, SGA_E_STORE, "The job's request could not be read from the store.");
        return;
    }
    log_event(LOG_L_DEBUG, "job_started", "job", job_id(job), NULL);
    /* A child that died while it was idle is no fault of this job, and none that can be started neither. */
    const struct account *account = job_account(job);
    bool another = w->serves && w->serves != account;      /* nothing of one token's job is there for the next one's */
    if ((another || !child_lives(&w->child)) && !replace_child(w)) {
        jobs_requeue(w->jobs, job);
        return;
    }
    w->serves = account;
    double deadline = sga_now() + jobs_seconds(w->config, request, length) + DEADLINE_GRACE;
    struct helpers *help = helpers_new(w->config, w->jobs, w->metrics, job, request, length);
    if (!wire_send(w->child.fd, WIRE_RUN, 0, request, length))
        child_died(w, job);
    else
        watch(w, job, help, deadline);
    helpers_free(help);
}

static void *worker_main(void *arg)
{
    struct worker *w = arg;
    for (struct job *job; have_child(w) && (job = jobs_claim(w->jobs, w->wake));) {
        run_job(w, job);
        job_unref(job);
    }
    char how[128];
    child_end(&w->child, how, sizeof how);
    close(w->wake);
    return NULL;
}

struct workers *workers_start(const struct config *c, struct jobs *js, struct metrics *m)
{
    struct workers *ws = calloc(1, sizeof *ws + (size_t)c->workers * sizeof *ws->worker);
    if (!ws)
        return NULL;
    for (long i = 0; i < c->workers; i++) {
        struct worker *w = &ws->worker[i];
        *w = (struct worker){ .config = c, .jobs = js, .metrics = m, .wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK) };
        if (w->wake < 0 || pthread_create(&w->thread, NULL, worker_main, w) != 0)
            break;
        ws->count++;
    }
    if (ws->count == c->workers)
        return ws;
    jobs_drain(js);
    workers_join(ws);
    return NULL;
}

void workers_join(struct workers *ws)
{
    if (!ws)
        return;
    for (long i = 0; i < ws->count; i++)
        pthread_join(ws->worker[i].thread, NULL);
    free(ws);
}
