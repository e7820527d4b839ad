/* What each token holds and has had, as Prometheus text. Names are those that administrators gave, of few characters. */
#include "buf.h"
#include "jobs_parts.h"

#include <string.h>

enum { NAMED = 100 };

struct sum {
    const char *name;
    unsigned long running, queued, accepted, refused;
    double ran;
};

/* Under the lock. */
static int collect(const struct jobs *js, struct sum sum[NAMED + 1])
{
    int count = 0;
    for (const struct account *a = js->accounts; a; a = a->next) {
        if (!*a->name)
            continue;
        struct sum *s = &sum[count < NAMED ? count : NAMED];
        s->name = count < NAMED ? a->name : "other";
        s->running += a->running;
        s->queued += a->alive > a->running ? a->alive - a->running : 0;
        s->accepted += a->accepted;
        s->refused += a->refused;
        s->ran += a->ran;
        count++;
    }
    return count < NAMED ? count : count > NAMED ? NAMED + 1 : NAMED;
}

static void head(struct sga_buf *out, const char *name, const char *type, const char *help)
{
    sga_buf_printf(out, "# HELP sgad_%s %s\n# TYPE sgad_%s %s\n", name, help, name, type);
}

void jobs_write_accounts(struct jobs *js, struct sga_buf *out)
{
    struct sum sum[NAMED + 1];
    memset(sum, 0, sizeof sum);
    pthread_mutex_lock(&js->lock);
    int n = collect(js, sum);
    pthread_mutex_unlock(&js->lock);      /* an account stays as long as the table */
    if (!n)
        return;
    head(out, "token_jobs", "gauge", "Jobs that have not ended, by token and state");
    for (int i = 0; i < n; i++)
        sga_buf_printf(out, "sgad_token_jobs{token=\"%s\",status=\"queued\"} %lu\nsgad_token_jobs{token=\"%s\",status=\"running\"} %lu\n",
                       sum[i].name, sum[i].queued, sum[i].name, sum[i].running);
    head(out, "token_jobs_accepted_total", "counter", "Jobs put into the queue, by token");
    for (int i = 0; i < n; i++)
        sga_buf_printf(out, "sgad_token_jobs_accepted_total{token=\"%s\"} %lu\n", sum[i].name, sum[i].accepted);
    head(out, "token_refusals_total", "counter", "Jobs refused for a quota or a full queue, by token");
    for (int i = 0; i < n; i++)
        sga_buf_printf(out, "sgad_token_refusals_total{token=\"%s\"} %lu\n", sum[i].name, sum[i].refused);
    head(out, "token_run_seconds_total", "counter", "Seconds that jobs ran and requests were checked, by token");
    for (int i = 0; i < n; i++)
        sga_buf_printf(out, "sgad_token_run_seconds_total{token=\"%s\"} %.6f\n", sum[i].name, sum[i].ran);
}
