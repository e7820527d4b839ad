/* Orders, waited for: see orders.h. */
#include "orders.h"
#include "spool.h"

#include <semaphore.h>
#include <string.h>
#include <unistd.h>

struct store *store;
const struct store_claimant ann = { .daemon = "ann", .version = "1", .lease = 60, .workers = 4, .share = 100 };
const struct store_claimant brief = { .daemon = "bea", .version = "1", .lease = 0.2, .workers = 4, .share = 100 };
const char dead[] = "{\"code\":\"worker_died\"}", stopped[] = "{\"code\":\"cancelled\"}";
static const struct slice none = { NULL, 0 };

struct turn { sem_t over; enum store_kept how; };

static void over(void *ctx, enum store_kept how)
{
    struct turn *t = ctx;
    t->how = how;
    sem_post(&t->over);
}

static void begin(struct turn *t)
{
    t->how = STORE_LOST;
    sem_init(&t->over, 0, 0);
}

static enum store_kept ended(struct turn *t, bool given)
{
    while (given && sem_wait(&t->over) != 0)
        continue;
    sem_destroy(&t->over);
    return t->how;
}

struct store_submission asks(const char *id, const char *owner, const char *text)
{
    struct store_submission s = { .row = { .created = clock_ms(), .seconds = 10 }, .request = { text, strlen(text) }, .join = true };
    snprintf(s.row.id, sizeof s.row.id, "%032x", (unsigned)strtoul(id, NULL, 10));
    snprintf(s.row.owner, sizeof s.row.owner, "%s", owner);
    return s;
}

enum store_kept give(struct store_submission *s)
{
    struct turn t;
    begin(&t);
    return ended(&t, store_submit(store, s, over, &t));
}

int submit(const char *id, const char *owner)
{
    struct store_submission s = asks(id, owner, id);
    return give(&s) == STORE_KEPT ? (int)s.outcome : -1;
}

enum store_kept end_as(const struct job_row *run, enum job_status status, const char *result)
{
    struct job_row row = *run;
    char error[] = "{\"code\":\"singular\"}";
    struct turn t;
    row.status = status;
    row.finished = clock_ms();
    row.error = status == JOB_DONE ? NULL : error;
    begin(&t);
    return ended(&t, store_end(store, &row, result ? (struct slice){ result, strlen(result) } : none, over, &t));
}

enum store_kept release(const struct job_row *run)
{
    struct job_row row = *run;
    char error[] = "{\"code\":\"cancelled\"}";
    struct turn t;
    row.error = error;
    row.finished = clock_ms();
    begin(&t);
    return ended(&t, store_release(store, &row, NULL, over, &t));
}

int cancel(const char *id, const char *owner)
{
    char name[ID_LENGTH + 1];
    snprintf(name, sizeof name, "%032x", (unsigned)strtoul(id, NULL, 10));
    struct store_cancel c = { .id = name, .owner = owner, .error = stopped, .now = clock_ms() };
    struct turn t;
    begin(&t);
    return ended(&t, store_cancel(store, &c, over, &t)) == STORE_KEPT ? (int)c.outcome : -1;
}

void settle(void)
{
    struct turn t;
    begin(&t);
    CHECK(ended(&t, store_barrier(store, over, &t)) == STORE_KEPT);
}

struct job_row claim(const struct store_claimant *who)
{
    struct job_row row = { .id = "" };
    char *text = NULL;
    size_t length = 0;
    enum store_answer a = store_claim(store, who, &row, &text, &length);
    CHECK(a != STORE_BROKEN);
    if (a == STORE_FOUND) {
        char whole[ID_LENGTH + 1];
        snprintf(whole, sizeof whole, "%032x", (unsigned)strtoul(text, NULL, 10));     /* requests are their numbers */
        CHECK(strcmp(whole, row.id) == 0 && length == strlen(text), "a claim brings its request, not %s", text);
        CHECK(row.status == JOB_RUNNING && row.epoch > 0 && row.started > 0);
    } else {
        row = (struct job_row){ .id = "" };
    }
    free(text);
    free(row.error);
    row.error = NULL;
    return row;
}

int number(const char *id) { return (int)strtoul(id, NULL, 16); }

int status_of(const char *id)
{
    struct job_row row = { .error = NULL };
    char name[ID_LENGTH + 1];
    snprintf(name, sizeof name, "%032x", (unsigned)strtoul(id, NULL, 10));
    enum store_answer a = store_job(store, name, &row);
    free(row.error);
    return a == STORE_FOUND ? (int)row.status : a == STORE_NONE ? -1 : -2;
}

bool result_is(const struct job_row *run, const char *should)
{
    char *text = NULL;
    size_t length = 0;
    bool same = store_result(store, run->id, &text, &length) == STORE_FOUND && length == strlen(should) && memcmp(text, should, length) == 0;
    spool_free(text);
    return same;
}

long reap(void)
{
    struct store_reaping r = { .tries = 3, .died = dead, .cancelled = stopped, .now = clock_ms() };
    CHECK(store_reap(store, &r));
    return r.count;
}

enum store_beat_answer beat(const struct store_claimant *who, const struct job_row *run, const char *stage)
{
    struct store_beat b = { .epoch = run->epoch, .progress = { .fraction = 0.5 }, .answer = BEAT_LOST };
    snprintf(b.id, sizeof b.id, "%s", run->id);
    snprintf(b.progress.stage, sizeof b.progress.stage, "%s", stage);
    CHECK(store_beat(store, who, &b, 1));
    return b.answer;
}

void lapse(void)
{
    usleep(250000);
}
