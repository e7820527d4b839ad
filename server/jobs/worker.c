/* One worker: a thread and its child process, for as long as the service lives.
 *
 * The child is watched while it runs: its messages, the eventfd by which a cancellation
 * or the end of the service makes itself known, and the deadline, whichever comes first.
 * The library keeps the job's own time limit; the deadline here is for one that does not
 * come back. */
#include "worker.h"
#include "budget.h"
#include "child.h"
#include "child_wire.h"
#include "json_scan.h"
#include "log.h"

#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

static const double DEFAULT_SECONDS = 30;        /* of a request that sets no limit */
static const double DEADLINE_GRACE = 5, CANCEL_GRACE = 0.8;
enum { FAT = 512 << 20 };                        /* a child that grew past this is replaced */

struct worker {
    pthread_t thread;
    const struct config *config;
    struct jobs *jobs;
    struct metrics *metrics;
    struct child child;
    int wake;                        /* eventfd */
};

struct workers {
    long count;
    struct worker worker[];
};

/* A message as far as it has come. */
struct inbox {
    struct wire_header head;
    size_t head_len, len;
    char *data;                      /* head.length bytes and a 0 */
};

enum received { RECEIVED_PART, RECEIVED_WHOLE, RECEIVED_END, RECEIVED_TOO_LARGE };

static enum received receive(struct inbox *in, int fd, size_t limit)
{
    if (in->head_len < sizeof in->head) {
        ssize_t n = recv(fd, (char *)&in->head + in->head_len, sizeof in->head - in->head_len, MSG_DONTWAIT);
        if (n <= 0)
            return n < 0 && (errno == EAGAIN || errno == EINTR) ? RECEIVED_PART : RECEIVED_END;
        in->head_len += (size_t)n;
        if (in->head_len < sizeof in->head)
            return RECEIVED_PART;
        if (in->head.length > limit || !(in->data = malloc((size_t)in->head.length + 1)))
            return RECEIVED_TOO_LARGE;
        in->data[in->head.length] = 0;
        in->len = 0;
    }
    while (in->len < in->head.length) {
        ssize_t n = recv(fd, in->data + in->len, in->head.length - in->len, MSG_DONTWAIT);
        if (n <= 0)
            return n < 0 && (errno == EAGAIN || errno == EINTR) ? RECEIVED_PART : RECEIVED_END;
        in->len += (size_t)n;
    }
    return RECEIVED_WHOLE;
}

static void inbox_clear(struct inbox *in)
{
    free(in->data);
    *in = (struct inbox){ 0 };
}

static void replace_child(struct worker *w)
{
    char how[128];
    child_end(&w->child, how, sizeof how);
    if (child_start(&w->child, w->config))
        metrics_add(w->metrics, METRIC_CHILD_STARTS);
    else
        log_event(LOG_L_ERROR, "child_not_started", "reason", strerror(errno), NULL);
}

static double allowed_seconds(const struct worker *w, const char *request, size_t length)
{
    struct slice limits = scan_member(scan_value(request, request + length), "limits");
    double seconds = scan_number(scan_member(limits, "seconds"), DEFAULT_SECONDS);
    double most = (double)w->config->max_seconds;
    return seconds > 0 && seconds < most ? seconds : most;
}

static void fail(struct worker *w, struct job *job, enum sga_code code, const char *detail)
{
    struct sga_error err = { .code = code, .stage = "worker" };
    snprintf(err.detail, sizeof err.detail, "%s", detail);
    jobs_failed(w->jobs, job, &err);
}

static void child_died(struct worker *w, struct job *job)
{
    char how[128] = "unknown", detail[400];
    child_end(&w->child, how, sizeof how);
    metrics_add(w->metrics, METRIC_CHILD_DEATHS);
    log_event(LOG_L_WARN, "child_died", "job", job_id(job), "how", how, NULL);
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

/* An error object from the child: trusted no further than its size. */
static void child_failed(struct worker *w, struct job *job, const struct inbox *in)
{
    struct sga_error err;
    if (in->head.length != sizeof err) {
        fail(w, job, SGA_E_INTERNAL, "The process that ran the job gave a malformed error.");
        return;
    }
    memcpy(&err, in->data, sizeof err);
    err.detail[sizeof err.detail - 1] = err.pointer[sizeof err.pointer - 1] = err.stage[sizeof err.stage - 1] = 0;
    if (err.code <= SGA_E_OK || err.code >= SGA_E_COUNT)
        err.code = SGA_E_INTERNAL;
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

/* A whole message; true once it has ended the job. */
static bool handle(struct worker *w, struct job *job, struct inbox *in)
{
    bool ended = true;
    if (in->head.type == WIRE_PROGRESS && in->head.length == sizeof(struct wire_progress)) {
        struct wire_progress p;
        memcpy(&p, in->data, sizeof p);
        p.stage[sizeof p.stage - 1] = 0;
        jobs_progress(w->jobs, job, p.stage, p.fraction);
        ended = false;
    } else if (in->head.type == WIRE_DONE) {
        jobs_done(w->jobs, job, in->data, in->head.length);
    } else if (in->head.type == WIRE_ERROR || in->head.type == WIRE_LAST) {
        if (in->head.type == WIRE_LAST)
            child_walled(w, job);
        child_failed(w, job, in);
    } else if (in->head.type == WIRE_UNSAFE) {
        kill_child(w, job, in->data);
        fail(w, job, SGA_E_WORKER_DIED, "The process that should run the job could not confine itself, so it was not run; "
             "the service's log says why.");
    } else {
        kill_child(w, job, "malformed message");
        fail(w, job, SGA_E_INTERNAL, "The process that ran the job gave a malformed message.");
    }
    if (ended && w->child.pid && in->head.resident > FAT)
        replace_child(w);
    inbox_clear(in);
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
             "Raise limits.seconds, or ask for less in want.", request ? allowed_seconds(w, request, length) : 0.0, DEADLINE_GRACE);
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

static void too_large(struct worker *w, struct job *job, size_t length)
{
    char detail[200];
    snprintf(detail, sizeof detail, "The result has %.1f MB; the service keeps no more than %.1f MB. Ask for fewer samples or outputs.",
             (double)length * 0x1p-20, (double)w->config->result_limit * 0x1p-20);
    fail(w, job, SGA_E_LIMIT_RESULT, detail);
}

static void watch(struct worker *w, struct job *job, double deadline)
{
    struct inbox in = { .data = NULL };
    bool cancelling = false;
    for (bool first = true;; first = false) {
        struct pollfd p[2] = { { .fd = w->child.fd, .events = POLLIN }, { .fd = w->wake, .events = POLLIN } };
        double left = deadline - sga_now();
        if (left <= 0) {
            deadline_passed(w, job, cancelling);
            break;
        }
        poll(p, 2, first ? 0 : left > 3600 ? 3600000 : (int)(left * 1000) + 1);
        /* On the first turn the eventfd is read in any case: a cancellation may have come
         * between the claim and now. */
        if ((first || p[1].revents) && woken(w, job, &deadline, &cancelling))
            break;
        if (!p[0].revents)
            continue;
        enum received r = receive(&in, w->child.fd, (size_t)w->config->result_limit);
        if (r == RECEIVED_WHOLE && handle(w, job, &in))
            break;
        if (r == RECEIVED_END) {
            child_died(w, job);
            break;
        }
        if (r == RECEIVED_TOO_LARGE) {
            kill_child(w, job, "result too large");
            too_large(w, job, in.head.length);
            break;
        }
    }
    inbox_clear(&in);
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
    /* A child that died while it was idle is no fault of this job. */
    struct pollfd p = { .fd = w->child.fd, .events = POLLIN };
    if (!w->child.pid || poll(&p, 1, 0) != 0)
        replace_child(w);
    if (!w->child.pid) {
        fail(w, job, SGA_E_WORKER_DIED, "No process could be started to run the job.");
        return;
    }
    double deadline = sga_now() + allowed_seconds(w, request, length) + DEADLINE_GRACE;
    if (!wire_send(w->child.fd, WIRE_RUN, 0, request, length))
        child_died(w, job);
    else
        watch(w, job, deadline);
    if (!w->child.pid && !jobs_draining(w->jobs))
        replace_child(w);
}

static void *worker_main(void *arg)
{
    struct worker *w = arg;
    replace_child(w);
    for (struct job *job; (job = jobs_claim(w->jobs, w->wake));) {
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
