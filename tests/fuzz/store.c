/* The store: bytes are a history of writes, reads, new starts and damage, which a model in
 * memory follows. What was written is there after a start; a job that was running is queued
 * with one try more; a result is the one that was written, or gone, never another; a damaged
 * queue is refused, or gives each request as it was, or says that it cannot be read. */
#include <fcntl.h>
#include <semaphore.h>
#include <stdbool.h>
#include <string.h>
#include <sys/stat.h>

#include "folder.h"
#include "fuzz.h"
#include "log.h"
#include "metrics.h"
#include "spool.h"
#include "store.h"

enum { JOBS = 8, TEXT = 6000 };

const char *const fuzz_words[] = { "\x00\x01\x02\x03", "\x10\x11\x12", "\x30\x31", "\x40\x41\x42", "\x50", "\x60\x05", "\x70\x55", "\x20\x21\x22",
    "\x01\x11\x32\x50", "\x02\x12\x22\x42", NULL };

struct model {
    bool there, run;                /* submitted; run: has been started */
    enum job_status status;
    int attempts;
    size_t length, result;          /* of the texts; result 0: none */
    unsigned char fill, result_fill;
};

static struct model model[JOBS];
static struct metrics metrics;
static struct store *store;
static char folder[256];
static bool trusted, cached;        /* nothing was damaged in the queue, in the cache */
static int64_t clock_now;

int LLVMFuzzerInitialize(int *argc, char ***argv)
{
    (void)argc;
    (void)argv;
    log_open(LOG_L_ERROR);
    folder_make(folder, sizeof folder);
    return 0;
}

void fuzz_end(void)
{
    folder_empty(folder, 1);
}

static void name(char *id, int k)
{
    snprintf(id, ID_LENGTH + 1, "%032x", k + 1);
}

static char *text_of(unsigned char fill, size_t length)
{
    char *text = malloc(length + 1);
    for (size_t i = 0; i < length; i++)
        text[i] = (char)('a' + (fill + i * i) % 26);
    text[length] = 0;
    return text;
}

static void set(void *ctx, enum store_kept how)
{
    (void)how;
    sem_post(ctx);
}

/* Until all that was given is on disk: readers see nothing before. */
static void settle(void)
{
    sem_t done;
    sem_init(&done, 0, 0);
    FUZZ_REQUIRE(store_barrier(store, set, &done), "no barrier");
    sem_wait(&done);
    sem_destroy(&done);
}

static struct job_row row_of(int k)
{
    struct job_row row = { .status = model[k].status, .created = 1, .started = model[k].run, .finished = ++clock_now,
                           .attempts = model[k].attempts, .epoch = store_epoch(store) };
    name(row.id, k);
    return row;
}

/* A job's id names its request: who submits a job once more brings the same text. */
static void insert(int k, unsigned char byte)
{
    struct model *m = &model[k];
    if (m->there)
        byte = m->fill;
    *m = (struct model){ .there = true, .length = 1 + (size_t)byte * byte % TEXT, .fill = byte };
    struct job_row row = row_of(k);
    char *text = text_of(m->fill, m->length);
    struct store_submission s = { .row = row, .request = { text, m->length }, .again = true };
    FUZZ_REQUIRE(store_submit(store, &s, NULL, NULL), "no memory");
    settle();
    FUZZ_REQUIRE(!trusted || s.outcome == STORE_NEW, "job %d: submitted with outcome %d", k, (int)s.outcome);
    free(text);
}

static void end(int k, unsigned char byte)
{
    static const enum job_status ends[] = { JOB_DONE, JOB_DONE, JOB_FAILED, JOB_CANCELLED };
    struct model *m = &model[k];
    m->status = ends[byte % 4];
    m->result = m->status == JOB_DONE ? 1 + (size_t)byte * byte % TEXT : 0;
    m->result_fill = byte;
    struct job_row row = row_of(k);
    char error[] = "{\"code\":\"time_limit\"}", *text = text_of(byte, m->result);
    row.error = m->result ? NULL : error;
    sem_t done;          /* a result goes another way than what the barrier waits for */
    sem_init(&done, 0, 0);
    FUZZ_REQUIRE(store_end(store, &row, (struct slice){ m->result ? text : NULL, m->result }, set, &done), "no memory");
    sem_wait(&done);
    sem_destroy(&done);
    free(text);
}

static void change(int k, enum job_status status)
{
    model[k].status = status;
    model[k].run |= status == JOB_RUNNING;
    struct job_row row = row_of(k);
    if (status == JOB_RUNNING)
        store_started(store, &row);
    else
        store_release(store, &row, NULL, NULL, NULL);
    settle();
}

static void check_text(int k, bool result)
{
    const struct model *m = &model[k];
    char id[ID_LENGTH + 1], *text = NULL;
    size_t length = 0;
    name(id, k);
    enum store_answer a = (result ? store_result : store_request)(store, id, &text, &length);
    if (a == STORE_FOUND) {
        size_t should = result ? m->result : m->length;
        char *right = text_of(result ? m->result_fill : m->fill, should);
        FUZZ_REQUIRE(m->there && length == should && memcmp(text, right, should) == 0, "job %d: another %s of %zu bytes, not %zu, %.30s, not %.30s", k, result ? "result" : "request", length, should, text, right);
        free(right);
        if (result)
            spool_free(text);
        else
            free(text);
    } else if (result ? cached && trusted : trusted) {
        FUZZ_REQUIRE(a == STORE_NONE && !(result ? m->result : m->there), "job %d: its %s is gone", k, result ? "result" : "request");
    }
}

static void check_job(int k)
{
    const struct model *m = &model[k];
    struct job_row row = { .error = NULL };
    char id[ID_LENGTH + 1];
    name(id, k);
    enum store_answer a = store_job(store, id, &row);
    if (trusted) {
        FUZZ_REQUIRE(a == (m->there ? STORE_FOUND : STORE_NONE), "job %d: answer %d", k, (int)a);
        FUZZ_REQUIRE(!m->there || (row.status == m->status && row.attempts == m->attempts), "job %d: status %d, attempts %d, not %d, %d", k,
                     (int)row.status, row.attempts, (int)m->status, m->attempts);
        FUZZ_REQUIRE(!m->there || (row.error != NULL) == (m->status > JOB_DONE), "job %d: its error", k);
    }
    if (a == STORE_FOUND)
        free(row.error);
    check_text(k, false);
    check_text(k, true);
}

static void check_list(unsigned statuses, int limit)
{
    struct store_page page;
    int there = 0;
    if (store_list(store, &(struct store_query){ .statuses = statuses, .limit = limit }, &page) != STORE_FOUND) {
        FUZZ_REQUIRE(!trusted, "no list");
        return;
    }
    for (int k = 0; k < JOBS; k++)
        there += model[k].there && statuses >> model[k].status & 1;
    for (int i = 0; trusted && i < page.rows; i++)
        FUZZ_REQUIRE((i == 0 || page.row[i].seq < page.row[i - 1].seq) && statuses >> page.row[i].status & 1, "row %d of the list", i);
    FUZZ_REQUIRE(!trusted || (page.rows == (there < limit ? there : limit) && page.more == (there > limit)), "%d rows of %d", page.rows, there);
    store_page_free(&page);
}

/* -- New starts and damage -- */

static void recovered(void *ctx, const struct job_row *row)
{
    (void)row;
    ++*(int *)ctx;
}

static bool start(void)
{
    char why[512] = "";
    int queued = 0, should = 0;
    store = store_open(folder, 0, &metrics, why, sizeof why);
    FUZZ_REQUIRE(store || (!trusted && *why), "the store does not open: %s", why);
    if (!store)
        return false;
    bool ok = store_recover(store, recovered, &queued, why, sizeof why);
    FUZZ_REQUIRE(ok || (!trusted && *why), "the store does not recover: %s", why);
    for (int k = 0; k < JOBS; k++) {
        struct model *m = &model[k];
        if (m->there && m->status == JOB_RUNNING) {
            m->status = JOB_QUEUED;
            m->attempts++;
        }
        should += m->there && m->status == JOB_QUEUED;
    }
    FUZZ_REQUIRE(!trusted || queued == should, "%d jobs are queued, not %d", queued, should);
    return ok;
}

static void damage(const char *file, const uint8_t *data, size_t size)
{
    char path[300];
    struct stat st;
    snprintf(path, sizeof path, "%s/%s", folder, file);
    int fd = open(path, O_RDWR | O_CLOEXEC);
    if (fd < 0 || fstat(fd, &st) != 0)
        abort();
    for (size_t i = 0; i + 3 < size && i < 40; i += 4) {
        off_t at = (off_t)((data[i] | (size_t)data[i + 1] << 8 | (size_t)data[i + 2] << 16) % (size_t)(st.st_size + 1));
        if (at < 100)
            at += 100;              /* the versions stand in the header: their meaning is tested elsewhere */
        if (pwrite(fd, &data[i + 3], 1, at) != 1)
            abort();
    }
    close(fd);
}

/* One step; false ends the history. */
static bool step(uint8_t what, uint8_t with, const uint8_t *rest, size_t size)
{
    int k = what % JOBS;
    switch (what >> 4) {
    case 0:
    case 1:
        if (!model[k].there || model[k].status > JOB_DONE)
            insert(k, with);
        return true;
    case 2:
        if (model[k].there && model[k].status == JOB_QUEUED)
            change(k, JOB_RUNNING);
        return true;
    case 3:
        if (model[k].there && model[k].status == JOB_RUNNING)
            end(k, with);
        return true;
    case 4:
        if (model[k].there && model[k].status == JOB_RUNNING)
            change(k, JOB_QUEUED);
        return true;
    case 5:
        check_list(with % 31 + 1u, 1 + with % 5);
        return true;
    case 6:
        store_close(store);
        if (with % 2) {
            cached = false;
            damage("cache.db", rest, size);
        }
        return start();
    case 7:
        store_close(store);
        trusted = false;
        damage("queue.db", rest, size);
        return start();
    default:
        check_job(k);
        return true;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    memset(model, 0, sizeof model);
    folder_empty(folder, 0);
    trusted = cached = true;
    bool going = start();
    for (size_t i = 0; going && i + 1 < size && i < 120; i += 2)
        going = step(data[i], data[i + 1], data + i + 2, size - i - 2);
    for (int k = 0; going && k < JOBS; k++)
        check_job(k);
    store_close(store);
    store = NULL;
    return 0;
}
