/* A bounded queue of exchanges and two threads with a child each. A suspended exchange is not
 * freed, and nobody else looks at it until it is resumed. */
#include "check_threads.h"
#include "budget.h"
#include "child.h"
#include "child_inbox.h"
#include "conns.h"
#include "exchange.h"
#include "jobs.h"
#include "log.h"
#include "metrics.h"
#include "service.h"

#include <assert.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>

#include "error.h"

enum { THREADS = 2, MOST = 64, MOST_OF_ONE = 48, TRIES = 2 };
/* The library ends by itself after about a second; what comes before, taking JSON apart, costs 0.03 for a MiB where a processor is free. */
static const double SECONDS = 10, SECONDS_PER_MIB = 1, LOOK = 0.1;
/* Of a request as the child writes it: as much as a result may have. */
static const size_t LONGEST = 1 << 30;

struct checker {
    struct check_threads *all;
    pthread_t thread;
    struct child child;
    const struct account *serves;    /* whose requests the child has read; NULL: nobody's yet */
};

struct check_threads {
    struct service *service;
    pthread_mutex_t lock;            /* guards all below but the checkers */
    pthread_cond_t work;
    struct exchange *first;          /* as they came */
    int count;
    unsigned long turn;
    bool closed;
    struct checker checker[THREADS];
    int threads;
};

/* The first of the account that was served longest ago. */
static struct exchange **whose_turn(struct check_threads *cs)
{
    struct exchange **best = &cs->first;
    for (struct exchange **e = &cs->first; *e; e = &(*e)->check.next)
        if ((*e)->account->checked < (*best)->account->checked)
            best = e;
    return best;
}

static struct exchange *next(struct check_threads *cs)
{
    pthread_mutex_lock(&cs->lock);
    while (!cs->first && !cs->closed)
        pthread_cond_wait(&cs->work, &cs->lock);
    struct exchange **at = whose_turn(cs), *e = *at;
    assert(!e == (cs->count == 0));
    if (e) {
        *at = e->check.next;
        cs->count--;
        e->account->checked = ++cs->turn;
    }
    pthread_mutex_unlock(&cs->lock);
    return e;
}

static bool closing(void *threads)
{
    struct check_threads *cs = threads;
    pthread_mutex_lock(&cs->lock);
    bool closed = cs->closed;
    pthread_mutex_unlock(&cs->lock);
    return closed;
}

/* A child that has read nothing of another account. */
static bool have_child(struct checker *c, const struct account *account)
{
    char why[256];
    bool another = c->serves && c->serves != account;
    if (another || !child_lives(&c->child)) {
        c->serves = NULL;
        if (!child_renew(&c->child, CHILD_CHECK, c->all->service->config, (struct child_patience){ closing, c->all }, why, sizeof why)) {
            log_event(LOG_L_ERROR, "child_not_started", "reason", why, NULL);
            metrics_add(c->all->service->metrics, METRIC_CHILD_FAILURES);
            return false;
        }
        metrics_add(c->all->service->metrics, METRIC_CHILD_STARTS);
    }
    c->serves = account;
    return true;
}

static double patience(const struct exchange *e)
{
    return SECONDS + SECONDS_PER_MIB * (double)e->length * 0x1p-20;
}

/* Until the child has answered, its time is over or the service ends. */
static enum received listen_to(struct checker *c, const struct exchange *e, struct child_inbox *in)
{
    double until = sga_now() + patience(e);
    enum received r;
    do
        r = child_receive_until(in, c->child.fd, LONGEST, sga_now() + LOOK);
    while (r == RECEIVED_PART && sga_now() < until && !closing(c->all));
    return r;
}

static void take_answer(struct exchange *e, struct child_inbox *in)
{
    e->check.ok = in->head.type == WIRE_DONE;
    if (e->check.ok)
        sga_buf_put(&e->check.canonical, in->data, in->head.length);
    else
        child_error(in, &e->check.err);
}

static void give_up(struct checker *c, struct exchange *e, enum received r)
{
    if (closing(c->all))
        sga_fail(&e->check.err, SGA_E_DRAINING, "The service is shutting down. Try again later.");
    else if (r == RECEIVED_PART)
        sga_fail(&e->check.err, SGA_E_LIMIT_SECONDS, "The request could not be read within %.0f seconds. Ask for a smaller system.", patience(e));
    else
        sga_fail(&e->check.err, SGA_E_LIMIT_MEMORY, "The process that read the request ended, most often because the request needs more "
                 "memory than it may have. Ask for a smaller system, or for smaller numbers.");
}

/* True: the exchange has its answer, good or bad. False: the child was killed from outside. */
static bool try_check(struct checker *c, struct exchange *e, bool last)
{
    struct child_inbox in = { .data = NULL };
    char how[128];
    enum received r = wire_send(c->child.fd, e->check.review ? WIRE_REVIEW : WIRE_CHECK, 0, e->body, e->length) ? listen_to(c, e, &in) : RECEIVED_END;
    bool over = true;
    if (r == RECEIVED_WHOLE) {
        take_answer(e, &in);
    } else {
        int status = child_end(&c->child, how, sizeof how);
        log_event(LOG_L_WARN, "check_ended", "how", how, "said", *c->child.said ? c->child.said : NULL, NULL);
        over = last || r != RECEIVED_END || !WIFSIGNALED(status) || WTERMSIG(status) != SIGKILL;
        if (over)
            give_up(c, e, r);
    }
    child_inbox_clear(&in);
    return over;
}

static void check(struct checker *c, struct exchange *e)
{
    double began = sga_now();
    bool over = false;
    for (int i = 1; !over && i <= TRIES; i++) {
        over = !have_child(c, e->account);
        if (over)
            sga_fail(&e->check.err, SGA_E_BUSY, "No process can be started to read the request. Try again soon.");
        else
            over = try_check(c, e, i == TRIES);
    }
    jobs_charge(e->service->jobs, e->account, sga_now() - began);
}

static void *work(void *arg)
{
    struct checker *c = arg;
    char how[128];
    have_child(c, NULL);
    for (struct exchange *e; (e = next(c->all));) {
        assert(!e->check.done);
        check(c, e);
        e->check.done = true;
        MHD_resume_connection(e->connection);     /* from here on it is another thread's */
    }
    child_end(&c->child, how, sizeof how);
    return NULL;
}

struct check_threads *check_threads_new(struct service *sv)
{
    struct check_threads *cs = calloc(1, sizeof *cs);
    if (!cs)
        return NULL;
    cs->service = sv;
    pthread_mutex_init(&cs->lock, NULL);
    pthread_cond_init(&cs->work, NULL);
    for (struct checker *c = cs->checker; cs->threads < THREADS; c++) {
        c->all = cs;
        if (pthread_create(&c->thread, NULL, work, c) != 0)
            break;
        cs->threads++;
    }
    if (cs->threads > 0)
        return cs;
    check_threads_free(cs);
    return NULL;
}

/* Under the lock. */
static bool room(const struct check_threads *cs, const struct exchange *mine)
{
    int of_one = 0;
    for (const struct exchange *e = cs->first; e; e = e->check.next)
        of_one += e->account == mine->account;
    return cs->count < MOST && of_one < MOST_OF_ONE;
}

static void append(struct check_threads *cs, struct exchange *e)
{
    struct exchange **at = &cs->first;
    while (*at)
        at = &(*at)->check.next;
    assert(!e->check.done && cs->count < MOST);
    e->check.next = NULL;
    *at = e;
    cs->count++;
    pthread_cond_signal(&cs->work);
}

bool check_threads_submit(struct check_threads *cs, struct exchange *e)
{
    pthread_mutex_lock(&cs->lock);
    bool taken = !cs->closed && room(cs, e);
    if (taken) {
        conn_deadline(e->conn, 0);
        MHD_suspend_connection(e->connection);
        append(cs, e);
    }
    pthread_mutex_unlock(&cs->lock);
    return taken;
}

void check_threads_close(struct check_threads *cs)
{
    pthread_mutex_lock(&cs->lock);
    cs->closed = true;
    struct exchange *e = cs->first;
    cs->first = NULL;
    cs->count = 0;
    pthread_cond_broadcast(&cs->work);
    pthread_mutex_unlock(&cs->lock);
    for (struct exchange *after; e; e = after) {
        after = e->check.next;
        sga_fail(&e->check.err, SGA_E_DRAINING, "The service is shutting down. Try again later.");
        e->check.done = true;
        MHD_resume_connection(e->connection);
    }
    for (int i = 0; i < cs->threads; i++)
        pthread_join(cs->checker[i].thread, NULL);
    cs->threads = 0;
}

void check_threads_free(struct check_threads *cs)
{
    if (!cs)
        return;
    pthread_cond_destroy(&cs->work);
    pthread_mutex_destroy(&cs->lock);
    free(cs);
}
