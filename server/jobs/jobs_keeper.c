/* The thread that keeps a shared table true: it listens for hints, beats, follows and reaps; see jobs_shared.h. */
#include "config.h"
#include "jobs_shared.h"
#include "budget.h"
#include "clock.h"
#include "problem.h"
#include "store.h"

#include <assert.h>
#include <stdio.h>
#include <sys/random.h>
#include <unistd.h>

#include "error.h"

static const double BEAT_LEAST = 0.3;

/* When what was done, and is to be done: sga_now(). */
struct rounds {
    double lease, looked, took, beaten;     /* took: seconds of the last look at all rows */
    double beat_at, reap_at, chore_at;
    bool due;                               /* a hint may be of a cancellation, which a beat hears of */
};

/* Until a hint comes, or a look is due; hints that come quickly are taken together. */
static void listen_on(struct jobs *js, struct rounds *r)
{
    double now = sga_now(), next = r->looked + SHARED_LOOK;
    store_listen(js->store, now < next ? next - now : 0.01);
    now = sga_now();
    r->due |= now < next;
    double pause = r->looked + (r->took > SHARED_HINT ? r->took : SHARED_HINT) - now;
    if (pause > 0)
        usleep((unsigned)(1e6 * pause));
    pthread_mutex_lock(&js->lock);
    js->hints++;
    pthread_cond_broadcast(&js->work);
    pthread_mutex_unlock(&js->lock);
}

/* A database that was away let all leases run out: who can beat again does so before anybody reaps. */
static void beat_and_look(struct jobs *js, struct rounds *r)
{
    double now = sga_now();
    if (now >= r->beat_at || (r->due && now >= r->beaten + BEAT_LEAST)) {
        r->due = false;
        r->beaten = now;
        if (shared_beat(js))
            r->beat_at = now + r->lease / 3;
        else
            r->reap_at = now + 1.5 * r->lease;
    }
    r->looked = sga_now();
    shared_follow(js);
    r->took = sga_now() - r->looked;
    if (sga_now() >= r->reap_at) {
        shared_reap(js);
        r->reap_at = sga_now() + r->lease / 3;
    }
}

static void do_chore(struct jobs *js, struct rounds *r)
{
    pthread_mutex_lock(&js->lock);
    void (*chore)(void *) = sga_now() >= r->chore_at ? js->chore : NULL;
    void *of = js->chore_of;
    pthread_mutex_unlock(&js->lock);
    if (!chore)
        return;
    chore(of);
    r->chore_at = sga_now() + SHARED_LOOK;
}

static void *keep(void *arg)
{
    struct jobs *js = arg;
    double lease = (double)js->config->lease;
    struct rounds r = { .lease = lease, .reap_at = sga_now() + lease };
    assert(js->shared && lease > 0);
    while (!atomic_load(&js->keeper_stops)) {
        listen_on(js, &r);
        beat_and_look(js, &r);
        do_chore(js, &r);
    }
    return NULL;
}

static char *problem(enum sga_code code, const char *detail)
{
    struct sga_error err = { .code = code, .stage = "queue" };
    snprintf(err.detail, sizeof err.detail, "%s", detail);
    return problem_text(&err);
}

bool shared_start(struct jobs *js, char *why, size_t size)
{
    char host[64] = "", bits[16] = "";
    unsigned number = 0;
    gethostname(host, sizeof host - 1);
    if (getrandom(&number, sizeof number, 0) != (ssize_t)sizeof number)
        number = (unsigned)clock_ms();
    snprintf(bits, sizeof bits, "%08x", number);
    snprintf(js->name, sizeof js->name, "%s-%ld-%s", host, (long)getpid(), bits);
    js->cancelled_text = problem(SGA_E_CANCELLED, "The job was cancelled before it ran.");
    js->died_text = problem(SGA_E_WORKER_DIED, "The daemons that ran this job ended or were cut off, several times; it is not tried again.");
    snprintf(why, size, js->cancelled_text && js->died_text ? "the database did not take a beat of this daemon" : "out of memory");
    return js->cancelled_text && js->died_text && shared_beat(js) && (js->keeps = pthread_create(&js->keeper, NULL, keep, js) == 0);
}

void jobs_chore(struct jobs *js, void (*chore)(void *ctx), void *ctx)
{
    pthread_mutex_lock(&js->lock);
    js->chore_of = ctx;
    js->chore = chore;
    pthread_mutex_unlock(&js->lock);
}

void shared_stop(struct jobs *js)
{
    atomic_store(&js->keeper_stops, true);
    if (js->keeps)
        pthread_join(js->keeper, NULL);
    js->keeps = false;
}
