/* What a store has room for, lists, and keeps. */
#include <string.h>
#include <unistd.h>

#include "orders.h"
#include "spool.h"

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
    spool_free(text);
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

void check_keeping(void)
{
    bounds();
    lists();
    kept_by_bytes();
    kept_results();
}
