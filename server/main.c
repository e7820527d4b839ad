/* sgad: reads settings, starts the parts from the bottom up, waits for a signal, and takes
 * them down in the opposite order.
 *
 * A request's way through the code: net/front.c (bytes, framing) -> http/http.c -> admission.c -> routes.c -> handlers/post.c -> a child's
 * check (exchange/check_threads.c) -> jobs/jobs.c (queue) -> worker.c -> child/child_main.c -> the library's run ->
 * jobs/jobs_run.c (end) -> store/store.c (disk), memory_cache.c (memory) -> exchange/reply.c. */
#include "budget.h"
#include "check_threads.h"
#include "child.h"
#include "code_runs.h"
#include "command.h"
#include "config.h"
#include "conns.h"
#include "http.h"
#include "inherit.h"
#include "jobs.h"
#include "log.h"
#include "memory_cache.h"
#include "metrics.h"
#include "notify.h"
#include "postgres.h"
#include "run.h"
#include "sandbox.h"
#include "service.h"
#include "spool.h"
#include "successor.h"
#include "tokens.h"
#include "worker.h"

#include <errno.h>
#include <gnutls/crypto.h>
#include <gnutls/gnutls.h>
#include <microhttpd.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

enum { USAGE = 2, STORE_SECONDS = 2, HTTP_SECONDS = 10, TAKE_OVER_SECONDS = 60, LEAVE_US = 300000 };

/* What main starts, in this order. */
struct parts {
    struct config config;
    struct metrics metrics;
    struct service service;
    struct workers *workers;
    struct http *http;
    int argc;
    char **argv;              /* for reading the settings again */
};

/* Of a signal, for the log. */
struct sender {
    char pid[24], uid[24];
};

static void suspend(void *connection)
{
    MHD_suspend_connection(connection);
}

static void resume(void *connection)
{
    MHD_resume_connection(connection);
}

static bool left(void *connection)
{
    const union MHD_ConnectionInfo *info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    char next;
    ssize_t some = info ? recv(info->connect_fd, &next, 1, MSG_PEEK | MSG_DONTWAIT) : 1;
    return some == 0 || (some < 0 && errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR);
}

static void raise_descriptor_limit(void)
{
    struct rlimit r;
    if (getrlimit(RLIMIT_NOFILE, &r) == 0) {
        r.rlim_cur = r.rlim_max;
        setrlimit(RLIMIT_NOFILE, &r);
    }
}

/* Tokens of a database have no file whose time tells. One that is away leaves them as they were. */
static void read_tokens(void *tokens)
{
    char why[512];
    tokens_refresh(tokens, true, why, sizeof why);
}

static bool start_tokens(struct service *sv, char *why, size_t size)
{
    return !config_tokens(sv->config)
        || ((sv->tokens = tokens_new(sv->config->store ? sv->config->store : sv->config->state, sv->jobs)) && tokens_refresh(sv->tokens, true, why, size)
            && (jobs_chore(sv->jobs, read_tokens, sv->tokens), true));
}

/* Where long texts are while they are sent, in files without names: the state's folder, or where there is none that of temporary files. */
static const char *spool_place(const struct config *config)
{
    const char *temporary = getenv("TMPDIR");
    if (!config->store)
        return config->state;
    return temporary && *temporary ? temporary : "/var/tmp";
}

static bool start(struct parts *p, char *why, size_t size)
{
    struct service *sv = &p->service;
    struct jobs_hooks hooks = { suspend, resume, left };
    snprintf(why, size, "out of memory");
    return (sv->conns = conns_new())
        && (sv->memory_cache = memory_cache_new((size_t)sv->config->cache_memory))
        && (p->http = http_open(sv, why, size)) && (inherit_ready(), true)
        && (sv->store = sv->config->store ? postgres_open(sv->config->store, sga_version(), sv->metrics, why, size)
                                         : store_open(sv->config->state, inherited() ? (double)sv->config->grace + TAKE_OVER_SECONDS : 0, sv->metrics, why, size))
        && (spool_folder(spool_place(sv->config)), true)
        && (store_limit(sv->store, &sv->config->cache_disk), true)
        && (sv->jobs = jobs_new(sv->config, sv->store, sv->memory_cache, sv->metrics, hooks))
        && (sv->everyone = jobs_account(sv->jobs, "", &(struct quota){ 0 }))
        && jobs_recover(sv->jobs, why, size)
        && start_tokens(sv, why, size)
        && (sv->check_threads = check_threads_new(sv))
        && http_start(p->http, why, size)
        && (p->workers = workers_start(sv->config, sv->jobs, sv->metrics));
}

/* For running jobs, until the time is over; with patience for as long as they take, unless one more signal asks for haste. */
static void let_end(struct parts *p, const sigset_t *signals, bool patient)
{
    struct service *sv = &p->service;
    struct jobs_counts counts;
    static const struct timespec tenth = { .tv_nsec = 100000000 };
    double until = sga_now() + (double)sv->config->grace;
    for (jobs_count(sv->jobs, &counts); counts.running && (patient || sga_now() < until); jobs_count(sv->jobs, &counts)) {
        int number = patient ? sigtimedwait(signals, NULL, &tenth) : 0;
        if (!patient)
            usleep(10000);
        if (number == SIGTERM || number == SIGINT) {
            patient = false;
            until = sga_now() + (double)sv->config->grace;
        }
    }
}

/* Running jobs get their grace; then they go back to the queue on disk. Who waits is
 * answered, the HTTP side stops with nobody suspended, and last of all the store. */
static void stop(struct parts *p, const sigset_t *signals, bool patient)
{
    struct service *sv = &p->service;
    struct jobs_counts counts;
    if (sv->jobs) {
        jobs_drain(sv->jobs);
        let_end(p, signals, patient);
        jobs_stop_running(sv->jobs);
        workers_join(p->workers);
        double until = sga_now() + STORE_SECONDS;
        for (jobs_count(sv->jobs, &counts); counts.ending && sga_now() < until; jobs_count(sv->jobs, &counts))
            usleep(10000);       /* who waits for an end that is on its way to the disk gets it */
        jobs_close_waiters(sv->jobs);
        if (sv->check_threads)
            check_threads_close(sv->check_threads);
    }
    if (p->http)
        http_stop(p->http);
    check_threads_free(sv->check_threads);
    tokens_free(sv->tokens);
    store_close(sv->store);
    jobs_free(sv->jobs);
    memory_cache_free(sv->memory_cache);
    conns_free(sv->conns);
}

/* Before a stop: what has been accepted or is accepted yet, its successor runs; no connection is lost. */
static void hand_over(struct parts *p, const sigset_t *signals)
{
    struct service *sv = &p->service;
    atomic_store(&sv->leaving, true);
    usleep(LEAVE_US);              /* for connections that are kept alive to be asked once more */
    jobs_leave(sv->jobs);
    let_end(p, signals, false);
    jobs_stop_running(sv->jobs);
    workers_join(p->workers);
    p->workers = NULL;
    http_leave(p->http);
}

/* SIGUSR2: false where nobody could take over, and all stays as it is. */
static bool start_successor(struct parts *p, const struct sender *by)
{
    char why[512], text[32];
    pid_t pid = successor_start(http_listeners(p->http), p->argv, why, sizeof why);
    snprintf(text, sizeof text, "%ld", (long)pid);
    if (!pid) {
        log_event(LOG_L_ERROR, "no_successor", "reason", why, NULL);
        return false;
    }
    log_event(LOG_L_AUDIT, "handing_over", "#successor", text, "#by_pid", by->pid, "#by_uid", by->uid, NULL);
    notify("MAINPID=%ld\nSTATUS=a successor takes over", (long)pid);
    return true;
}

/* SIGHUP: the limits, the tokens and the certificate anew. Settings that are wrong change nothing. */
static void reload(struct parts *p, const struct sender *by)
{
    struct service *sv = &p->service;
    struct config fresh;
    char why[512], restart[512], changed[512];
    enum log_level level;
    notify("RELOADING=1\nMONOTONIC_USEC=%llu", notify_clock());
    if (config_read(&fresh, p->argc, p->argv, why, sizeof why) != CONFIG_OK) {
        log_event(LOG_L_ERROR, "reload_refused", "reason", why, "#by_pid", by->pid, "#by_uid", by->uid, NULL);
    } else {
        config_take_live(sv->config, &fresh, changed, restart, sizeof restart);
        if (log_level_from_text(sv->config->log_level, &level))
            log_set_level(level);
        log_event(LOG_L_AUDIT, "reloaded", "changed", *changed ? changed : NULL, "needs_restart", *restart ? restart : NULL,
                  "#by_pid", by->pid, "#by_uid", by->uid, NULL);
    }
    config_free(&fresh);
    http_renew(p->http);
    if (sv->tokens && !tokens_refresh(sv->tokens, true, why, sizeof why))
        log_event(LOG_L_ERROR, "tokens_not_read", "reason", why, NULL);
    notify("READY=1");
}

/* The signal by which the service is to end. */
static int wait_for_signal(struct parts *p, const sigset_t *set)
{
    int number;
    siginfo_t info;
    struct sender by;
    do {
        while ((number = sigwaitinfo(set, &info)) < 0)
            ;
        snprintf(by.pid, sizeof by.pid, "%ld", (long)info.si_pid);
        snprintf(by.uid, sizeof by.uid, "%ld", (long)info.si_uid);
        if (number == SIGHUP)
            reload(p, &by);
    } while (number == SIGHUP || (number == SIGUSR2 && !start_successor(p, &by)));
    if (number == SIGUSR2)
        return number;
    log_event(LOG_L_AUDIT, "draining", "signal", strsignal(number), "#by_pid", by.pid, "#by_uid", by.uid, NULL);
    /* Once the supervisor asked for the end it waits as long as the running jobs may go on. */
    notify("STOPPING=1\nSTATUS=running jobs end\nEXTEND_TIMEOUT_USEC=%ld000000",
           atomic_load(&p->config.grace) + STORE_SECONDS + HTTP_SECONDS);
    return number;
}

/* Why motions take several times as long, where they do. */
static void tell_code(const struct config *c)
{
    const char *why, *mode = code_mode(atomic_load(&c->interpret_only), &why);
    log_event(why && !atomic_load(&c->interpret_only) ? LOG_L_WARN : LOG_L_INFO, "formulas", "mode", mode, "reason", why, NULL);
}

static int serve(struct parts *p, const sigset_t *signals)
{
    char why[512];
    int status = 0, number = SIGTERM;
    if (start(p, why, sizeof why)) {
        printf("listening on %s\n", http_url(p->http));
        fflush(stdout);
        notify("READY=1\nSTATUS=listening on %.400s", http_url(p->http));
        log_event(LOG_L_INFO, "started", "version", sga_version(), "state", p->config.store ? "a shared store" : p->config.state, NULL);
        tell_code(&p->config);
        number = wait_for_signal(p, signals);
    } else {
        fprintf(stderr, "sgad: %s\n", why);
        status = 1;
    }
    if (number == SIGUSR2)
        hand_over(p, signals);
    stop(p, signals, number == SIGUSR1);
    if (status == 0)
        log_event(LOG_L_INFO, "stopped", NULL);
    log_close();
    return status;
}

/* What --help and its like print. */
static void answer_instead(enum config_result asked, const struct config *c)
{
    switch (asked) {
    case CONFIG_HELP: config_usage(stdout); break;
    case CONFIG_VERSION: printf("sgad %s\n", sga_version()); break;
    case CONFIG_CHECK: printf("the settings are good\n"); break;
    case CONFIG_PRINT: config_print(c, stdout); break;
    case CONFIG_SAMPLE: config_sample(stdout); break;
    default: break;
    }
}

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], CHILD_FLAG) == 0)
        return child_main(argc, argv);
    if (argc == 2 && strcmp(argv[1], SANDBOX_FLAG) == 0)
        return sandbox_check();

    int status;
    if (command_run(argc, argv, &status))
        return status;

    static struct parts parts;
    parts.argc = argc;
    parts.argv = argv;
    struct config *c = &parts.config;
    parts.service.config = c;
    parts.service.metrics = &parts.metrics;
    char why[512];
    enum log_level level = LOG_L_INFO;
    inherit_read();
    enum config_result got = config_read(c, argc, argv, why, sizeof why);
    if (got != CONFIG_OK && got != CONFIG_BAD) {
        answer_instead(got, c);
        config_free(c);
        return 0;
    }
    if (got == CONFIG_BAD) {
        fprintf(stderr, "sgad: %s\nsgad --help lists the options\n", why);
        config_free(c);
        return USAGE;
    }
    log_level_from_text(c->log_level, &level);
    raise_descriptor_limit();
    sga_init();
    gnutls_rnd(GNUTLS_RND_NONCE, &parts.service.request_prefix, sizeof parts.service.request_prefix);
    /* Blocked here, so in every thread: only sigwait below takes them. */
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGHUP);
    sigaddset(&signals, SIGUSR1);
    sigaddset(&signals, SIGUSR2);
    pthread_sigmask(SIG_BLOCK, &signals, NULL);
    signal(SIGPIPE, SIG_IGN);
    signal(SIGXFSZ, SIG_IGN);       /* a full quota is an error of the write, no end */
    log_open(level);
    status = serve(&parts, &signals);
    config_free(c);
    return status;
}
