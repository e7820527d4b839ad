/* The jobs table over a store that several daemons share, which is the test's own: what comes late, twice or not at all. */
#include "check.h"
#include "spool.h"
#include "config.h"
#include "jobs.h"
#include "memory_cache.h"
#include "metrics.h"
#include "store_ops.h"

#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

static const char ID[] = "0123456789abcdef0123456789abcdef", REQUEST[] = "{\"limits\":{\"seconds\":3}}", RESULT[] = "{\"verdict\":\"unique\"}";

/* What was given to the store and not answered yet; what a claim gives. */
static struct {
    struct store face;
    struct store_submission *submission;
    store_done *submitted, *ended;
    void *submitted_ctx, *ended_ctx;
    int noted, released;
    int64_t epoch;
} fake;

static bool submit(struct store *st, struct store_submission *s, store_done *done, void *ctx)
{
    (void)st;
    fake.submission = s;
    fake.submitted = done;
    fake.submitted_ctx = ctx;
    return true;
}

static bool end(struct store *st, const struct job_row *row, struct slice result, store_done *done, void *ctx)
{
    (void)st, (void)result;
    CHECK(row->epoch == fake.epoch && row->status == JOB_DONE);
    fake.ended = done;
    fake.ended_ctx = ctx;
    return true;
}

static bool let_go(struct store *st, const struct job_row *row, int64_t *next, store_done *done, void *ctx)
{
    (void)st, (void)row, (void)next, (void)done, (void)ctx;
    fake.released++;
    return true;
}

static bool note(struct store *st, const char *id, const char *owner)
{
    (void)st;
    CHECK(strcmp(id, ID) == 0 && strcmp(owner, "ann") == 0);
    fake.noted++;
    return true;
}

static enum store_answer claim(struct store *st, const struct store_claimant *who, struct job_row *row, char **request, size_t *length)
{
    (void)st, (void)who;
    *row = (struct job_row){ .status = JOB_RUNNING, .epoch = ++fake.epoch, .created = 1, .started = 2, .seconds = 4 };
    snprintf(row->id, sizeof row->id, "%s", ID);
    snprintf(row->owner, sizeof row->owner, "ann");
    *request = strdup(REQUEST);
    *length = sizeof REQUEST - 1;
    return STORE_FOUND;
}

static void hint(struct store *st)
{
    (void)st;
}

static const struct store_ops ops = { .shared = true, .submit = submit, .end = end, .release = let_go, .note = note, .claim = claim, .hint = hint };

static void nothing(void *connection)
{
    (void)connection;
}

static bool never(void *connection)
{
    (void)connection;
    return false;
}

static struct config config = { .workers = 1, .queue = 10, .queue_bytes = 1 << 20, .token_queue = 50, .token_workers = 100, .max_seconds = 60, .lease = 15,
                                .unsaved_memory = 1 << 20 };
static struct metrics metrics;

struct scene {
    struct jobs *jobs;
    struct memory_cache *cache;
    struct account *ann;
    struct job *posted;
    int wake;
};

static struct scene scene(void)
{
    static const struct quota none;
    struct scene s = { .cache = memory_cache_new(1 << 20), .wake = eventfd(0, EFD_NONBLOCK) };
    memset(&fake, 0, sizeof fake);
    fake.face.ops = &ops;
    s.jobs = jobs_new(&config, &fake.face, s.cache, &metrics, (struct jobs_hooks){ nothing, nothing, never });
    s.ann = jobs_account(s.jobs, "ann", &none);
    return s;
}

static void leave(struct scene *s)
{
    jobs_free(s->jobs);
    memory_cache_free(s->cache);
    close(s->wake);
}

static void post(struct scene *s)
{
    struct submission m = { .id = ID, .request = strdup(REQUEST), .length = sizeof REQUEST - 1, .account = s->ann, .request_id = "", .traceparent = "" };
    CHECK(jobs_submit(s->jobs, &m) == SUBMIT_NEW && fake.submitted);
    s->posted = m.job;
    free(m.request);
}

static struct job_look look(struct scene *s, struct job *job)
{
    struct job_look l;
    jobs_look(s->jobs, job, &l);
    return l;
}

/* Its end reaches the store: then everybody is told, and it leaves the table. */
static void ends(struct scene *s, struct job *run)
{
    char *result = memcpy(spool_new(sizeof RESULT - 1), RESULT, sizeof RESULT);
    jobs_done(s->jobs, run, &result, sizeof RESULT - 1);
    spool_free(result);
    CHECK(fake.ended && !look(s, run).finished);
    if (fake.ended)
        fake.ended(fake.ended_ctx, STORE_KEPT);
    struct job_look l = look(s, s->posted);
    CHECK(l.finished && l.row.status == JOB_DONE, "status %d", l.row.status);
    finished_unref(l.finished);
    CHECK(!jobs_find(s->jobs, ID));
    struct jobs_counts c;
    jobs_count(s->jobs, &c);
    CHECK(c.running == 0 && c.ending == 0 && c.ending_bytes == 0 && c.queued == 0);
}

/* The row was claimed by this daemon before the answer to its order came: lost, or a refusal that another daemon's
 * order for the same id has overtaken. The run is the table's, whatever the answer says. */
static void claimed_before_told(enum store_kept how, enum store_outcome outcome)
{
    struct scene s = scene();
    post(&s);
    struct job *run = jobs_claim(s.jobs, s.wake);
    CHECK(run == s.posted);
    fake.submission->outcome = outcome;
    fake.submitted(fake.submitted_ctx, how);
    CHECK(look(&s, s.posted).stored == 1 && !look(&s, s.posted).gone);
    CHECK(fake.noted == (how != STORE_KEPT || outcome == STORE_FULL || outcome == STORE_QUOTA), "%d", fake.noted);
    size_t length;
    const char *request = jobs_request(s.jobs, run, &length);
    CHECK(request && length == sizeof REQUEST - 1 && strcmp(request, REQUEST) == 0);
    struct job *found = jobs_find(s.jobs, ID);
    CHECK(found == run);
    job_unref(found);
    ends(&s, run);
    job_unref(run);
    job_unref(s.posted);
    leave(&s);
}

static void told_before_claimed(enum store_kept how, enum store_outcome outcome)
{
    struct scene s = scene();
    post(&s);
    fake.submission->outcome = outcome;
    fake.submitted(fake.submitted_ctx, how);
    bool in = how == STORE_KEPT && outcome != STORE_FULL && outcome != STORE_QUOTA;
    struct job_look l = look(&s, s.posted);
    CHECK(l.gone == !in && l.stored == (in ? 1 : -1));
    CHECK(l.refused == (outcome == STORE_FULL && how == STORE_KEPT ? SUBMIT_FULL : outcome == STORE_QUOTA && how == STORE_KEPT ? SUBMIT_QUOTA : SUBMIT_NEW));
    struct job *found = jobs_find(s.jobs, ID), *posted = s.posted;
    CHECK(found == (in ? posted : NULL));
    job_unref(found);
    if (!in) {                       /* what was lost may be in the store all the same: then it is another job of this table */
        struct job *run = jobs_claim(s.jobs, s.wake);
        CHECK(run && run != posted);
        s.posted = run;
        ends(&s, run);
        job_unref(run);
    }
    job_unref(posted);
    leave(&s);
}

/* Another daemon has the job: the end is nobody's, the job is followed from then on. */
static void fenced(void)
{
    struct scene s = scene();
    post(&s);
    fake.submission->outcome = STORE_NEW;
    fake.submitted(fake.submitted_ctx, STORE_KEPT);
    struct job *run = jobs_claim(s.jobs, s.wake);
    char *result = memcpy(spool_new(sizeof RESULT - 1), RESULT, sizeof RESULT);
    jobs_done(s.jobs, run, &result, sizeof RESULT - 1);
    spool_free(result);
    fake.ended(fake.ended_ctx, STORE_FENCED);
    struct job_look l = look(&s, run);
    CHECK(!l.finished && !l.gone);
    struct job *again = jobs_claim(s.jobs, s.wake);      /* its lease ended there, and this daemon takes it once more */
    CHECK(again == run && fake.epoch == 2);
    ends(&s, again);
    job_unref(again);
    job_unref(run);
    job_unref(s.posted);
    leave(&s);
}

/* A daemon that drains gives its run back, and takes no other. */
static void drained(void)
{
    struct scene s = scene();
    post(&s);
    fake.submission->outcome = STORE_NEW;
    fake.submitted(fake.submitted_ctx, STORE_KEPT);
    struct job *run = jobs_claim(s.jobs, s.wake);
    jobs_drain(s.jobs);
    CHECK(!jobs_claim(s.jobs, s.wake) && !jobs_lost(s.jobs, run));
    jobs_requeue(s.jobs, run);
    CHECK(fake.released == 1 && look(&s, run).row.status == JOB_QUEUED);
    job_unref(run);
    job_unref(s.posted);
    leave(&s);
}

int main(void)
{
    static const enum store_outcome outcomes[] = { STORE_NEW, STORE_JOINED, STORE_FULL, STORE_QUOTA };
    for (size_t i = 0; i < sizeof outcomes / sizeof *outcomes; i++) {
        claimed_before_told(STORE_KEPT, outcomes[i]);
        told_before_claimed(STORE_KEPT, outcomes[i]);
    }
    claimed_before_told(STORE_LOST, STORE_NEW);
    told_before_claimed(STORE_LOST, STORE_NEW);
    fenced();
    drained();
    return CHECK_END();
}
