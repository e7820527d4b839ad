/* Twenty times a second. */
#include "ticker.h"
#include "budget.h"
#include "conns.h"
#include "jobs.h"
#include "log.h"
#include "metrics.h"
#include "notify.h"
#include "service.h"
#include "tls.h"
#include "tokens.h"

#include <unistd.h>

enum { TICK_MS = 50, TOKENS_SECONDS = 1, FILES_SECONDS = 10 };

/* By time of the files, or because it was asked for. */
static void renew_certificate(struct ticker *t)
{
    char why[512];
    enum tls_news news = tls_renew(t->service->config, atomic_exchange(&t->renew, false), why, sizeof why);
    if (news == TLS_BAD)
        log_event(LOG_L_ERROR, "certificate_refused", "reason", why, NULL);
    else if (news == TLS_NEW)
        log_event(LOG_L_INFO, "certificate_renewed", NULL);
}

static void look_at_tokens(struct service *sv)
{
    char why[512];
    if (sv->tokens && !tokens_refresh(sv->tokens, false, why, sizeof why))
        log_event(LOG_L_ERROR, "tokens_not_read", "reason", why, NULL);
}

/* After the locks were had. */
static void tell_supervisor(struct ticker *t, double now)
{
    double every = notify_watchdog();
    if (every > 0 && now >= t->alive_at) {
        notify("WATCHDOG=1");
        t->alive_at = now + every;
    }
}

static void *tick(void *arg)
{
    struct ticker *t = arg;
    struct service *sv = t->service;
    double tokens_at = 0, files_at = sga_now() + FILES_SECONDS;
    for (; !atomic_load(&t->stop); usleep(TICK_MS * 1000)) {
        double now = sga_now();
        if (now >= tokens_at) {
            look_at_tokens(sv);
            tokens_at = now + TOKENS_SECONDS;
        }
        if (now >= files_at || atomic_load(&t->renew)) {
            renew_certificate(t);
            files_at = now + FILES_SECONDS;
        }
        jobs_tick(sv->jobs, now);
        for (int cut = conns_reap(sv->conns, now, 0); cut > 0; cut--)
            metrics_add(sv->metrics, METRIC_REAPED);
        tell_supervisor(t, now);
    }
    return NULL;
}

bool ticker_start(struct ticker *t, struct service *sv)
{
    t->service = sv;
    return pthread_create(&t->thread, NULL, tick, t) == 0;
}

void ticker_stop(struct ticker *t)
{
    atomic_store(&t->stop, true);
    pthread_join(t->thread, NULL);
}
