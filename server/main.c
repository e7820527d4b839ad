/* sgad: reads settings, starts the parts from the bottom up, waits for a signal, and takes
 * them down in the opposite order.
 *
 * A request's way through the code: http.c (bytes) -> admit.c -> routes.c -> post.c ->
 * the library's check -> jobs.c (queue) -> worker.c -> child_main.c -> the library's run ->
 * jobs_run.c (end) -> store.c (disk), recent.c (memory) -> reply.c. */
#include "budget.h"
#include "child.h"
#include "http.h"
#include "log.h"
#include "run.h"
#include "sandbox.h"
#include "worker.h"

#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <microhttpd.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum { USAGE = 2 };

/* What main starts, in this order. */
struct parts {
    struct service service;
    struct workers *workers;
    struct http *http;
};

static void suspend(void *connection)
{
    MHD_suspend_connection(connection);
}

static void resume(void *connection)
{
    MHD_resume_connection(connection);
}

static void raise_descriptor_limit(void)
{
    struct rlimit r;
    if (getrlimit(RLIMIT_NOFILE, &r) == 0) {
        r.rlim_cur = r.rlim_max;
        setrlimit(RLIMIT_NOFILE, &r);
    }
}

static bool start(struct parts *p, int *port, char *why, size_t size)
{
    struct service *sv = &p->service;
    struct jobs_hooks hooks = { suspend, resume };
    snprintf(why, size, "out of memory");
    return (sv->conns = conns_new())
        && (sv->recent = recent_new((size_t)sv->config.cache_memory))
        && (sv->store = store_open(sv->config.state, &sv->metrics, why, size))
        && (sv->jobs = jobs_new(&sv->config, sv->store, sv->recent, &sv->metrics, hooks))
        && jobs_recover(sv->jobs, why, size)
        && (p->http = http_start(sv, port, why, size))
        && (p->workers = workers_start(&sv->config, sv->jobs, &sv->metrics));
}

/* Running jobs get their grace; then they go back to the queue on disk. Who waits is
 * answered, the HTTP side stops with nobody suspended, and last of all the store. */
static void stop(struct parts *p)
{
    struct service *sv = &p->service;
    struct jobs_counts counts;
    if (sv->jobs) {
        jobs_drain(sv->jobs);
        double until = sga_now() + (double)sv->config.grace;
        for (jobs_count(sv->jobs, &counts); counts.running && sga_now() < until; jobs_count(sv->jobs, &counts))
            usleep(10000);
        jobs_stop_running(sv->jobs);
        workers_join(p->workers);
        jobs_close_waiters(sv->jobs);
    }
    if (p->http)
        http_stop(p->http);
    store_close(sv->store);
    jobs_free(sv->jobs);
    recent_free(sv->recent);
    conns_free(sv->conns);
}

static void wait_for_signal(const sigset_t *set)
{
    int number;
    while (sigwait(set, &number) != 0)
        ;
    log_event(LOG_L_INFO, "draining", "signal", strsignal(number), NULL);
}

static int serve(struct parts *p, const sigset_t *signals)
{
    char why[512], host[256];
    int port = 0, status = 0;
    if (start(p, &port, why, sizeof why)) {
        http_host(&p->service.config, host, sizeof host);
        printf("listening on http://%s:%d\n", host, port);
        fflush(stdout);
        log_event(LOG_L_INFO, "started", "version", sga_version(), "state", p->service.config.state, NULL);
        wait_for_signal(signals);
    } else {
        fprintf(stderr, "sgad: %s\n", why);
        status = 1;
    }
    stop(p);
    if (status == 0)
        log_event(LOG_L_INFO, "stopped", NULL);
    return status;
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], CHILD_FLAG) == 0)
        return child_main(argc, argv);
    if (argc == 2 && strcmp(argv[1], SANDBOX_FLAG) == 0)
        return sandbox_check();

    static struct parts parts;
    struct config *c = &parts.service.config;
    char why[512];
    enum log_level level = LOG_L_INFO;
    enum config_result got = config_read(c, argc, argv, why, sizeof why);
    if (got == CONFIG_HELP || got == CONFIG_VERSION) {
        if (got == CONFIG_HELP)
            config_usage(stdout);
        else
            printf("sgad %s\n", sga_version());
        config_free(c);
        return 0;
    }
    if (got == CONFIG_OK && !log_level_from_text(c->log_level, &level)) {
        snprintf(why, sizeof why, "log-level must be error, warn, info or debug, not '%s'", c->log_level);
        got = CONFIG_BAD;
    }
    if (got == CONFIG_BAD) {
        fprintf(stderr, "sgad: %s\nsgad --help lists the options\n", why);
        config_free(c);
        return USAGE;
    }
    log_open(level);
    raise_descriptor_limit();
    gnutls_rnd(GNUTLS_RND_NONCE, &parts.service.request_prefix, sizeof parts.service.request_prefix);
    /* Blocked here, so in every thread: only sigwait below takes them. */
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    pthread_sigmask(SIG_BLOCK, &signals, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);       /* a full quota is an error of the write, no end */
    int status = serve(&parts, &signals);
    config_free(c);
    return status;
}
