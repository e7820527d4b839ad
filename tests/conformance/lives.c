/* The lives of jobs: submitted, claimed, held by leases, ended, cancelled, in turns. */
#include <stdlib.h>
#include <string.h>

#include "orders.h"
#include "spool.h"

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

/* As long as a piece, a row or several of them, one replaced by another. */
static void lengths(void)
{
    static const size_t sizes[] = { SPOOL_LONG - 1, SPOOL_LONG, SPOOL_LONG + 1, 3 * SPOOL_LONG + 17, 5, 2 * SPOOL_LONG, 0 };
    for (int k = 0; sizes[k]; k++) {
        char *text = malloc(sizes[k] + 1);
        for (size_t i = 0; i < sizes[k]; i++)
            text[i] = (char)('a' + (i * 2654435761u >> 9) % 26);
        text[sizes[k]] = 0;
        struct store_submission s = asks("90", "ann", "90");
        s.again = k > 0;
        CHECK(give(&s) == STORE_KEPT && s.outcome == STORE_NEW);
        struct job_row run = claim(&ann);
        CHECK(number(run.id) == 90 && end_as(&run, JOB_DONE, text) == STORE_KEPT && result_is(&run, text), "%zu bytes", sizes[k]);
        free(text);
    }
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

void check_lives(void)
{
    submissions();
    leases();
    poison();
    cancels();
    lengths();
    turns();
}
