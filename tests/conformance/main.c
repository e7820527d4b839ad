/* What store.h promises, asked of a store: conformance FOLDER | postgresql://... One that is empty
 * and nobody else's. Each check is the same for all of them; two threads stand for two daemons. */
#include <pthread.h>
#include <stdatomic.h>

#include "log.h"
#include "metrics.h"
#include "orders.h"
#include "postgres.h"

int check_passed, check_failed;
static struct metrics metrics;

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
    check_lives();
    check_keeping();
    races();
    store_close(store);
    log_close();
    return CHECK_END();
}
