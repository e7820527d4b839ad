/* What store.h promises, asked of a store: conformance FOLDER | postgresql://... One that is empty
 * and nobody else's. Each check is the same for all of them; two threads stand for two daemons. */
#include <pthread.h>
#include <semaphore.h>
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

#include "check.h"
#include "clock.h"
#include "log.h"
#include "metrics.h"
#include "postgres.h"
#include "store.h"

static struct metrics metrics;
static struct store *store;
static const struct store_claimant ann = { .daemon = "ann", .version = "1", .lease = 60, .workers = 4, .share = 100 };
static const struct store_claimant brief = { .daemon = "bea", .version = "1", .lease = 0.2, .workers = 4, .share = 100 };
static const char dead[] = "{\"code\":\"worker_died\"}", stopped[] = "{\"code\":\"cancelled\"}";
static const struct slice none = { NULL, 0 };

/* -- Orders, waited for -- */

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

static struct store_submission asks(const char *id, const char *owner, const char *text)
{
    struct store_submission s = { .row = { .created = clock_ms(), .seconds = 10 }, .request = { text, strlen(text) }, .join = true };
    snprintf(s.row.id, sizeof s.row.id, "%032x", (unsigned)strtoul(id, NULL, 10));
    snprintf(s.row.owner, sizeof s.row.owner, "%s", owner);
    return s;
}

static enum store_kept give(struct store_submission *s)
{
    struct turn t;
    begin(&t);
    return ended(&t, store_submit(store, s, over, &t));
}

/* -1: it was not kept. */
static int submit(const char *id, const char *owner)
{
    struct store_submission s = asks(id, owner, id);
    return give(&s) == STORE_KEPT ? (int)s.outcome : -1;
}

static enum store_kept end_as(const struct job_row *run, enum job_status status, const char *result)
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

static enum store_kept release(const struct job_row *run)
{
    struct job_row row = *run;
    char error[] = "{\"code\":\"cancelled\"}";
    struct turn t;
    row.error = error;
    row.finished = clock_ms();
    begin(&t);
    return ended(&t, store_release(store, &row, NULL, over, &t));
}

static int cancel(const char *id, const char *owner)
{
    char name[ID_LENGTH + 1];
    snprintf(name, sizeof name, "%032x", (unsigned)strtoul(id, NULL, 10));
    struct store_cancel c = { .id = name, .owner = owner, .error = stopped, .now = clock_ms() };
    struct turn t;
    begin(&t);
    return ended(&t, store_cancel(store, &c, over, &t)) == STORE_KEPT ? (int)c.outcome : -1;
}

static void settle(void)
{
    struct turn t;
    begin(&t);
    CHECK(ended(&t, store_barrier(store, over, &t)) == STORE_KEPT);
}

/* The claimed row; its id is "" where there is none. */
static struct job_row claim(const struct store_claimant *who)
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

static int number(const char *id) { return (int)strtoul(id, NULL, 16); }

static int status_of(const char *id)
{
    struct job_row row = { .error = NULL };
    char name[ID_LENGTH + 1];
    snprintf(name, sizeof name, "%032x", (unsigned)strtoul(id, NULL, 10));
    enum store_answer a = store_job(store, name, &row);
    free(row.error);
    return a == STORE_FOUND ? (int)row.status : a == STORE_NONE ? -1 : -2;
}

static bool result_is(const struct job_row *run, const char *should)
{
    char *text = NULL;
    size_t length = 0;
    bool same = store_result(store, run->id, &text, &length) == STORE_FOUND && length == strlen(should) && memcmp(text, should, length) == 0;
    free(text);
    return same;
}

static long reap(void)
{
    struct store_reaping r = { .tries = 3, .died = dead, .cancelled = stopped, .now = clock_ms() };
    CHECK(store_reap(store, &r));
    return r.count;
}

static enum store_beat_answer beat(const struct store_claimant *who, const struct job_row *run, const char *stage)
{
    struct store_beat b = { .epoch = run->epoch, .progress = { .fraction = 0.5 }, .answer = BEAT_LOST };
    snprintf(b.id, sizeof b.id, "%s", run->id);
    snprintf(b.progress.stage, sizeof b.progress.stage, "%s", stage);
    CHECK(store_beat(store, who, &b, 1));
    return b.answer;
}

static void lapse(void)
{
    usleep(250000);
}

/* -- What is promised -- */

static void submissions(void)
{
    CHECK(status_of("1") == -1);
    CHECK(submit("1", "ann") == STORE_NEW);
    CHECK(status_of("1") == JOB_QUEUED);
    CHECK(submit("1", "ann") == STORE_JOINED && submit("1", "bob") == STORE_JOINED);
    struct job_row run = claim(&ann);
    CHECK(number(run.id) == 1 && strcmp(run.owner, "ann") == 0 && run.seconds == 10);
    CHECK(*claim(&ann).id == 0, "a job is claimed once");
    CHECK(submit("1", "bob") == STORE_JOINED && status_of("1") == JOB_RUNNING);
    CHECK(end_as(&run, JOB_DONE, "one") == STORE_KEPT && status_of("1") == JOB_DONE && result_is(&run, "one"));
    CHECK(end_as(&run, JOB_DONE, "one") == STORE_KEPT, "an end whose answer was lost may be said again");
    CHECK(end_as(&run, JOB_FAILED, NULL) == STORE_FENCED && status_of("1") == JOB_DONE, "but not another one");
    CHECK(submit("1", "cid") == STORE_DONE && store_owned(store, run.id, "cid") == STORE_FOUND);
    CHECK(store_owned(store, run.id, "dan") == STORE_NONE);
    struct store_submission again = asks("1", "ann", "1");
    again.again = true;
    CHECK(give(&again) == STORE_KEPT && again.outcome == STORE_NEW && status_of("1") == JOB_QUEUED);
    CHECK(end_as(&run, JOB_DONE, "late") == STORE_FENCED && status_of("1") == JOB_QUEUED, "of an earlier submission");
    run = claim(&ann);
    CHECK(end_as(&run, JOB_FAILED, NULL) == STORE_KEPT && status_of("1") == JOB_FAILED);
    CHECK(submit("1", "ann") == STORE_NEW, "a job that failed is run again");
    run = claim(&ann);
    CHECK(end_as(&run, JOB_DONE, "two") == STORE_KEPT && result_is(&run, "two"));
}

static void leases(void)
{
    CHECK(submit("2", "ann") == STORE_NEW);
    struct job_row first = claim(&brief), second;
    CHECK(number(first.id) == 2 && reap() == 0, "a lease that holds is nobody's");
    CHECK(beat(&brief, &first, "texts") == BEAT_HELD);
    struct job_row row;
    struct job_progress p;
    CHECK(store_look_at(store, first.id, &row, &p) == STORE_FOUND && row.status == JOB_RUNNING && strcmp(p.stage, "texts") == 0 && p.fraction == 0.5);
    lapse();
    CHECK(reap() == 1 && status_of("2") == JOB_QUEUED && reap() == 0);
    CHECK(beat(&brief, &first, "texts") == BEAT_LOST && status_of("2") == JOB_QUEUED);
    CHECK(end_as(&first, JOB_DONE, "stale") == STORE_FENCED && release(&first) == STORE_FENCED && status_of("2") == JOB_QUEUED);
    second = claim(&ann);
    CHECK(number(second.id) == 2 && second.epoch > first.epoch && second.attempts == first.attempts + 1);
    CHECK(end_as(&first, JOB_DONE, "stale") == STORE_FENCED && release(&first) == STORE_FENCED && status_of("2") == JOB_RUNNING);
    CHECK(beat(&ann, &first, "x") == BEAT_LOST && beat(&ann, &second, "x") == BEAT_HELD);
    CHECK(end_as(&second, JOB_DONE, "fresh") == STORE_KEPT && end_as(&first, JOB_DONE, "stale") == STORE_FENCED && result_is(&second, "fresh"));
    CHECK(beat(&ann, &second, "x") == BEAT_LOST, "a run that has ended");
}

static void poison(void)
{
    CHECK(submit("3", "ann") == STORE_NEW);
    for (int i = 0; i < 3; i++) {
        struct job_row run = claim(&brief);
        CHECK(number(run.id) == 3 && run.attempts == i);
        lapse();
        CHECK(reap() == 1);
    }
    struct job_row row = { .error = NULL };
    char name[ID_LENGTH + 1];
    snprintf(name, sizeof name, "%032x", 3);
    CHECK(status_of("3") == JOB_FAILED && store_job(store, name, &row) == STORE_FOUND && row.error && strcmp(row.error, dead) == 0 && row.finished > 0);
    free(row.error);
    CHECK(submit("4", "ann") == STORE_NEW);
    for (int i = 0; i < 5; i++) {
        struct job_row run = claim(&ann);
        CHECK(number(run.id) == 4 && run.attempts == 0 && release(&run) == STORE_KEPT && status_of("4") == JOB_QUEUED, "a release is no attempt");
        CHECK(release(&run) == STORE_FENCED && end_as(&run, JOB_DONE, "released") == STORE_FENCED && status_of("4") == JOB_QUEUED);
    }
    struct job_row run = claim(&ann);
    CHECK(end_as(&run, JOB_CANCELLED, NULL) == STORE_KEPT && status_of("4") == JOB_CANCELLED);
}

static void cancels(void)
{
    CHECK(cancel("5", NULL) == STORE_UNKNOWN);
    CHECK(submit("5", "ann") == STORE_NEW && submit("5", "bob") == STORE_JOINED);
    CHECK(cancel("5", "cid") == STORE_NOT_YOURS && cancel("5", "ann") == STORE_WITHDRAWN && status_of("5") == JOB_QUEUED);
    CHECK(cancel("5", "ann") == STORE_NOT_YOURS);
    struct job_row row;
    struct job_progress p;
    char name[ID_LENGTH + 1];
    snprintf(name, sizeof name, "%032x", 5);
    CHECK(store_look_at(store, name, &row, &p) == STORE_FOUND && strcmp(row.owner, "bob") == 0, "it waits on the account of who still wants it");
    CHECK(cancel("5", "bob") == STORE_CANCELLED && status_of("5") == JOB_CANCELLED && cancel("5", "bob") == STORE_ENDED && *claim(&ann).id == 0);
    row.error = NULL;
    CHECK(store_job(store, name, &row) == STORE_FOUND && row.error && strcmp(row.error, stopped) == 0);
    free(row.error);
    CHECK(submit("6", "ann") == STORE_NEW);
    struct job_row run = claim(&ann);
    CHECK(cancel("6", "ann") == STORE_ASKED && status_of("6") == JOB_RUNNING && beat(&ann, &run, "x") == BEAT_CANCEL);
    CHECK(release(&run) == STORE_KEPT && status_of("6") == JOB_CANCELLED, "given back, it ends");
    CHECK(submit("7", "ann") == STORE_NEW);
    run = claim(&brief);
    CHECK(cancel("7", NULL) == STORE_ASKED);
    lapse();
    CHECK(reap() == 1 && status_of("7") == JOB_CANCELLED, "and where its daemon is gone too");
    CHECK(submit("8", "ann") == STORE_NEW);
    run = claim(&ann);
    CHECK(cancel("8", NULL) == STORE_ASKED && end_as(&run, JOB_DONE, "faster") == STORE_KEPT && status_of("8") == JOB_DONE);
    CHECK(submit("6", "ann") == STORE_NEW);
    run = claim(&ann);
    CHECK(beat(&ann, &run, "x") == BEAT_HELD, "a wish to cancel is of one submission");
    CHECK(end_as(&run, JOB_DONE, "six") == STORE_KEPT);
}

/* One owner's hundred jobs delay another's by one. */
static void turns(void)
{
    char id[16];
    for (int i = 0; i < 6; i++) {
        snprintf(id, sizeof id, "%d", 100 + i);
        CHECK(submit(id, "ann") == STORE_NEW);
    }
    CHECK(submit("110", "bob") == STORE_NEW && submit("111", "bob") == STORE_NEW);
    struct job_row run[8];
    int first_of_bob = -1, bobs = 0, before = 0;
    struct store_claimant half = ann;
    half.share = store_shared(store) ? 25 : 50;      /* ann's and bea's workers are eight, where both are known */
    for (int i = 0; i < 4; i++) {
        run[i] = claim(&half);
        bool bob = strcmp(run[i].owner, "bob") == 0;
        if (bob && first_of_bob < 0)
            first_of_bob = i;
        bobs += bob;
        if (!bob) {
            CHECK(number(run[i].id) > before, "an owner's jobs in their order");
            before = number(run[i].id);
        }
    }
    CHECK(first_of_bob >= 0 && first_of_bob < 2 && bobs == 2);
    CHECK(*claim(&half).id == 0, "its share is two for each");
    run[4] = claim(&ann);
    CHECK(strcmp(run[4].owner, "ann") == 0);
    for (int i = 0; i < 5; i++)
        CHECK(end_as(&run[i], JOB_DONE, "x") == STORE_KEPT);
    struct job_row r = claim(&ann);
    for (int left = 4; *r.id && left; left--, r = claim(&ann))
        CHECK(end_as(&r, JOB_DONE, "x") == STORE_KEPT);
    CHECK(*r.id == 0);
}

static int bounded(const char *id, struct store_room room, const char **quota)
{
    struct store_submission s = asks(id, "eve", id);
    s.room = room;
    int outcome = give(&s) == STORE_KEPT ? (int)s.outcome : -1;
    if (quota)
        *quota = s.quota;
    CHECK(outcome != STORE_QUOTA || s.retry > 0);
    return outcome;
}

static void bounds(void)
{
    const char *quota = NULL;
    CHECK(bounded("200", (struct store_room){ .queue = 1, .jobs = 1 }, NULL) == STORE_NEW);
    CHECK(bounded("201", (struct store_room){ .queue = 1 }, NULL) == STORE_FULL && status_of("201") == -1);
    CHECK(bounded("201", (struct store_room){ .queue_bytes = 5 }, NULL) == STORE_FULL);
    CHECK(bounded("201", (struct store_room){ .jobs = 1 }, &quota) == STORE_QUOTA && strstr(quota, "jobs"));
    CHECK(bounded("201", (struct store_room){ .share = 1 }, &quota) == STORE_QUOTA && strstr(quota, "places"));
    CHECK(bounded("201", (struct store_room){ .bytes = 5 }, &quota) == STORE_QUOTA && strstr(quota, "bytes"));
    CHECK(bounded("201", (struct store_room){ .seconds = 15 }, &quota) == STORE_QUOTA && strstr(quota, "seconds"), "seconds are reserved");
    CHECK(store_owned(store, "000000000000000000000000000000c9", "eve") == STORE_NONE && status_of("201") == -1, "what is refused leaves nothing");
    CHECK(bounded("200", (struct store_room){ .queue = 1, .jobs = 1 }, NULL) == STORE_JOINED, "who joins takes no room");
    CHECK(bounded("201", (struct store_room){ .queue = 2, .queue_bytes = 6, .jobs = 2, .bytes = 6, .share = 2, .seconds = 20 }, NULL) == STORE_NEW);
    for (int i = 0; i < 2; i++) {
        struct job_row r = claim(&ann);
        r.started = clock_ms() - 3000;
        CHECK(end_as(&r, JOB_DONE, "x") == STORE_KEPT);
    }
    CHECK(bounded("202", (struct store_room){ .seconds = 6 }, &quota) == STORE_QUOTA && strstr(quota, "seconds"), "two jobs of three seconds were used");
    CHECK(bounded("202", (struct store_room){ .seconds = 17 }, NULL) == STORE_NEW && cancel("202", NULL) == STORE_CANCELLED);
}

static int listed(const char *owner, unsigned statuses, int limit, bool *more)
{
    struct store_page page;
    struct store_query q = { .statuses = statuses, .limit = limit, .owner = owner };
    int n = 0;
    int64_t before = INT64_MAX;
    if (store_list(store, &q, &page) != STORE_FOUND)
        return -1;
    for (; n < page.rows; n++) {
        CHECK(page.row[n].seq < before && statuses >> page.row[n].status & 1);
        before = page.row[n].seq;
    }
    *more = page.more;
    store_page_free(&page);
    return n;
}

static void lists(void)
{
    bool more;
    const unsigned all = (1u << JOB_STATUSES) - 1;
    char named[] = "{\"system\":{\"form\":\"equations\",\"name\":\"arm\"}}", verdict[] = "{\"verdict\":\"solved\",\"x\":1}";
    struct store_submission s = asks("300", "zoe", named);
    CHECK(give(&s) == STORE_KEPT && s.outcome == STORE_NEW && submit("301", "zoe") == STORE_NEW && submit("302", "zoe") == STORE_NEW);
    CHECK(listed("zoe", all, 10, &more) == 3 && !more && listed("zoe", all, 2, &more) == 2 && more);
    CHECK(listed("zoe", 1u << JOB_QUEUED, 10, &more) == 3 && listed("zoe", 1u << JOB_DONE, 10, &more) == 0 && listed("nobody", all, 10, &more) == 0);
    struct job_row row = { .error = NULL };
    char *text = NULL;
    size_t length;
    CHECK(store_claim(store, &ann, &row, &text, &length) == STORE_FOUND && strcmp(text, named) == 0);
    free(text);
    CHECK(end_as(&row, JOB_DONE, verdict) == STORE_KEPT && listed("zoe", 1u << JOB_DONE, 10, &more) == 1);
    struct store_page page;
    CHECK(store_list(store, &(struct store_query){ .statuses = 1u << JOB_DONE, .limit = 1, .owner = "zoe" }, &page) == STORE_FOUND && page.rows == 1
          && strcmp(page.row[0].name, "arm") == 0 && strcmp(page.row[0].form, "equations") == 0 && strcmp(page.row[0].verdict, "solved") == 0);
    store_page_free(&page);
    int total = listed(NULL, all, 400, &more);
    CHECK(store_withdraw(store, row.id, "zoe"));
    settle();
    CHECK(listed("zoe", all, 10, &more) == 2 && listed(NULL, all, 400, &more) == total && store_owned(store, row.id, "zoe") == STORE_NONE);
    CHECK(store_note(store, row.id, "yan"));
    settle();
    CHECK(listed("yan", all, 10, &more) == 1);
    CHECK(store_forget(store, row.id));
    settle();
    CHECK(listed("yan", all, 10, &more) == 0 && listed(NULL, all, 400, &more) == total - 1);
    CHECK(cancel("301", NULL) == STORE_CANCELLED && cancel("302", NULL) == STORE_CANCELLED);
    CHECK(store_prune(store, &(struct store_keep){ .jobs = 3 }));
    settle();
    CHECK(listed(NULL, all, 400, &more) == 3, "the latest three are kept");
    CHECK(store_prune(store, &(struct store_keep){ .since = clock_ms() + 1000 }));
    settle();
    CHECK(listed(NULL, all, 400, &more) == 0);
}

/* -- What is kept -- */

enum { LARGE = 1 << 16, LARGE_JOBS = 20 };

/* Ended jobs with large requests: the oldest go until the others fit, and what waits stays. */
static void kept_by_bytes(void)
{
    bool more;
    char id[16], *text = malloc(LARGE + 1);
    unsigned all = (1u << JOB_STATUSES) - 1;
    memset(text, ' ', LARGE);
    text[LARGE] = 0;
    for (int i = 0; i < LARGE_JOBS; i++) {
        snprintf(id, sizeof id, "%d", 400 + i);
        struct store_submission s = asks(id, "ann", text);
        CHECK(give(&s) == STORE_KEPT && (!i || cancel(id, NULL) == STORE_CANCELLED));      /* the first waits */
    }
    free(text);
    int left = LARGE_JOBS;
    for (int before = left + 1; left < before;) {
        before = left;
        CHECK(store_prune(store, &(struct store_keep){ .bytes = 12 * LARGE }));
        settle();
        left = listed(NULL, all, 400, &more);
    }
    CHECK(left > 5 && left <= 13, "%d are left", left);
    for (int i = 0; i < LARGE_JOBS; i++) {
        struct job_row row = { .error = NULL };
        char wide[ID_LENGTH + 1];
        snprintf(wide, sizeof wide, "%032x", 400 + i);
        CHECK((store_job(store, wide, &row) == STORE_FOUND) == (i == 0 || i > LARGE_JOBS - left), "job %d", i);
        free(row.error);
    }
    CHECK(cancel("400", NULL) == STORE_CANCELLED && store_prune(store, &(struct store_keep){ .jobs = 1, .since = clock_ms() + 1000 }));
    settle();
    CHECK(listed(NULL, all, 400, &more) == 0);
}

static bool has_result(const char *id)
{
    char *text = NULL;
    size_t length;
    bool found = store_result(store, id, &text, &length) == STORE_FOUND;
    free(text);
    return found;
}

/* How many of them; whoever removes results may be a thread of its own: in a bounded time. */
static int results_left(char ids[][ID_LENGTH + 1], int count, int wanted)
{
    int n = -1;
    for (int i = 0; i < 1000 && n != wanted; i++, usleep(10000)) {
        n = 0;
        for (int k = 0; k < count; k++)
            n += has_result(ids[k]);
    }
    return n;
}

static void kept_results(void)
{
    enum { DONE = 5 };
    char ids[DONE][ID_LENGTH + 1], id[16];
    bool more;
    for (int i = 0; i < DONE; i++) {
        snprintf(id, sizeof id, "%d", 500 + i);
        CHECK(submit(id, "ann") == STORE_NEW);
        struct job_row row = claim(&ann);
        snprintf(ids[i], sizeof ids[i], "%s", row.id);
        CHECK(end_as(&row, JOB_DONE, "{}") == STORE_KEPT);
        usleep(3000);                    /* each at a time of its own */
    }
    CHECK(results_left(ids, DONE, DONE) == DONE);
    CHECK(store_prune(store, &(struct store_keep){ .results = 2 }));
    CHECK(results_left(ids, DONE, 2) == 2 && has_result(ids[3]) && has_result(ids[4]), "the latest results stay");
    CHECK(store_prune(store, &(struct store_keep){ .results_since = clock_ms() - 3600000 }));
    settle();
    CHECK(results_left(ids, DONE, 2) == 2, "those that are young stay");
    CHECK(store_prune(store, &(struct store_keep){ .results_since = clock_ms() + 1000 }));
    CHECK(results_left(ids, DONE, 0) == 0, "by age");
    CHECK(listed(NULL, 1u << JOB_DONE, 10, &more) == DONE, "their jobs stay");
    CHECK(store_prune(store, &(struct store_keep){ .since = clock_ms() + 1000 }));
    settle();
}

/* -- Two at once -- */

enum { RACED = 60 };
static atomic_int fresh, joined, runs, kept;

static void *race(void *who)
{
    char id[16];
    for (int i = 0; i < RACED; i++) {
        snprintf(id, sizeof id, "%d", 1000 + i);
        int outcome = submit(id, who);
        fresh += outcome == STORE_NEW;
        joined += outcome == STORE_JOINED || outcome == STORE_DONE;
        if (i % 2) {
            struct job_row r = claim(&ann);
            if (*r.id) {
                runs++;
                kept += end_as(&r, JOB_DONE, r.id) == STORE_KEPT;
            }
        }
    }
    int left = RACED;
    for (struct job_row r = claim(&ann); *r.id && left; left--, r = claim(&ann)) {
        runs++;
        kept += end_as(&r, JOB_DONE, r.id) == STORE_KEPT;
    }
    return NULL;
}

static void races(void)
{
    pthread_t t[4];
    char *who[4] = { "ann", "bob", "ann", "cid" };
    for (int i = 0; i < 4; i++)
        pthread_create(&t[i], NULL, race, who[i]);
    for (int i = 0; i < 4; i++)
        pthread_join(t[i], NULL);
    CHECK(fresh == RACED && joined == 3 * RACED, "%d new, %d joined", fresh, joined);
    CHECK(runs == RACED && kept == RACED, "%d runs, %d ends", runs, kept);
    for (int i = 0; i < RACED; i++) {
        struct job_row r = { .error = NULL };
        snprintf(r.id, sizeof r.id, "%032x", 1000 + i);
        CHECK(result_is(&r, r.id), "each has its own result");
    }
}

int main(int argc, char **argv)
{
    char why[512] = "";
    if (argc != 2)
        return 2;
    log_open(LOG_L_ERROR);
    int from, to;
    if (postgres_address(argv[1]))
        CHECK(postgres_migrate(argv[1], &from, &to, why, sizeof why) && from == 0 && postgres_migrate(argv[1], &from, &to, why, sizeof why) && from == to, "%s", why);
    store = postgres_address(argv[1]) ? postgres_open(argv[1], "1", &metrics, why, sizeof why) : store_open(argv[1], 0, &metrics, why, sizeof why);
    CHECK(store, "%s", why);
    if (!store)
        return CHECK_END();
    submissions();
    leases();
    poison();
    cancels();
    turns();
    bounds();
    lists();
    kept_by_bytes();
    kept_results();
    races();
    store_close(store);
    log_close();
    return CHECK_END();
}
