/* The store's readers: a few read-only connections, lent one at a time. */
#include "store_parts.h"
#include "log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool open_cache(struct store_reader *r, const char *folder, char *why, size_t size)
{
    return (r->cache = store_file_open(folder, FILE_CACHE, false, why, size))
        && (r->result = store_file_prepare(r->cache, "SELECT result, sum FROM results WHERE id=?1", why, size));
}

bool store_readers_open(struct store *st, const char *folder, char *why, size_t size)
{
    for (int i = 0; i < STORE_READERS; i++) {
        struct store_reader *r = &st->reader[i];
        bool ok = (r->queue = store_file_open(folder, FILE_QUEUE, false, why, size))
            && (r->job = store_file_prepare(r->queue, "SELECT " STORE_ROW_COLUMNS " FROM jobs WHERE id=?1", why, size))
            && (r->request = store_file_prepare(r->queue, "SELECT request, sum FROM jobs WHERE id=?1", why, size))
            && (r->list = store_file_prepare(r->queue, "SELECT " STORE_ROW_COLUMNS " FROM jobs WHERE seq < ?1"
                                             " AND ((1 << status) & ?2) AND (?4 IS NULL OR owner = ?4) ORDER BY seq DESC LIMIT ?3", why, size))
            && (r->list_one = store_file_prepare(r->queue, "SELECT " STORE_ROW_COLUMNS " FROM jobs WHERE seq < ?1"
                                                 " AND status = ?2 AND (?4 IS NULL OR owner = ?4) ORDER BY seq DESC LIMIT ?3", why, size))
            && open_cache(r, folder, why, size);
        if (!ok)
            return false;
    }
    return true;
}

/* The writer may have started another cache file since. False: it cannot be opened now. */
static bool renew(struct store *st, struct store_reader *r)
{
    char why[512];
    unsigned age = atomic_load(&st->cache_age);
    if (r->cache && r->cache_age == age)
        return true;
    sqlite3_finalize(r->result);
    sqlite3_close(r->cache);
    r->result = NULL;
    r->cache = NULL;
    r->cache_age = age;
    return open_cache(r, st->folder, why, sizeof why);
}

void store_readers_close(struct store *st)
{
    for (int i = 0; i < STORE_READERS; i++) {
        struct store_reader *r = &st->reader[i];
        sqlite3_stmt *const statements[] = { r->job, r->request, r->list, r->list_one, r->result };
        for (size_t k = 0; k < sizeof statements / sizeof *statements; k++)
            sqlite3_finalize(statements[k]);
        sqlite3_close(r->queue);
        sqlite3_close(r->cache);
    }
}

static struct store_reader *borrow(struct store *st)
{
    struct store_reader *r = NULL;
    pthread_mutex_lock(&st->read_lock);
    for (;;) {
        for (int i = 0; i < STORE_READERS && !r; i++)
            if (!st->reader[i].busy)
                r = &st->reader[i];
        if (r)
            break;
        pthread_cond_wait(&st->read_free, &st->read_lock);
    }
    r->busy = true;
    pthread_mutex_unlock(&st->read_lock);
    return r;
}

static void give_back(struct store *st, struct store_reader *r)
{
    pthread_mutex_lock(&st->read_lock);
    r->busy = false;
    pthread_cond_signal(&st->read_free);
    pthread_mutex_unlock(&st->read_lock);
}

bool store_read_row(sqlite3_stmt *s, struct job_row *row)
{
    memset(row, 0, sizeof *row);
    const char *id = (const char *)sqlite3_column_text(s, 0), *error = (const char *)sqlite3_column_text(s, 7);
    const char *owner = (const char *)sqlite3_column_text(s, 8);
    int status = sqlite3_column_int(s, 2);
    if (!id || strlen(id) != ID_LENGTH || status < 0 || status >= JOB_STATUSES)
        return false;
    memcpy(row->id, id, ID_LENGTH);
    row->seq = sqlite3_column_int64(s, 1);
    row->status = (enum job_status)status;
    row->attempts = sqlite3_column_int(s, 3);
    row->created = sqlite3_column_int64(s, 4);
    row->started = sqlite3_column_int64(s, 5);
    row->finished = sqlite3_column_int64(s, 6);
    snprintf(row->owner, sizeof row->owner, "%s", owner ? owner : "");
    return !error || (row->error = strdup(error));
}

/* Is the text what was written under this id? */
static bool genuine(sqlite3_stmt *s, const char *id)
{
    unsigned char sum[DIGEST_BYTES];
    const void *kept = sqlite3_column_blob(s, 1), *text = sqlite3_column_blob(s, 0);
    digest_kept(sum, id, text ? text : "", (size_t)sqlite3_column_bytes(s, 0));
    return kept && sqlite3_column_bytes(s, 1) == sizeof sum && memcmp(kept, sum, sizeof sum) == 0;
}

static bool copy_blob(sqlite3_stmt *s, char **text, size_t *length)
{
    *length = (size_t)sqlite3_column_bytes(s, 0);
    const void *blob = sqlite3_column_blob(s, 0);
    *text = malloc(*length + 1);
    if (!*text)
        return false;
    if (*length)
        memcpy(*text, blob, *length);
    (*text)[*length] = 0;
    return true;
}

static enum store_answer answer(int rc, bool taken)
{
    return rc == SQLITE_DONE ? STORE_NONE : rc == SQLITE_ROW && taken ? STORE_FOUND : STORE_BROKEN;
}

enum store_answer store_job(struct store *st, const char *id, struct job_row *row)
{
    struct store_reader *r = borrow(st);
    sqlite3_bind_text(r->job, 1, id, -1, SQLITE_STATIC);
    int rc = sqlite3_step(r->job);
    bool taken = rc == SQLITE_ROW && store_read_row(r->job, row);
    if (taken && strcmp(row->id, id) != 0) {      /* an index that is damaged */
        free(row->error);
        row->error = NULL;
        taken = false;
    }
    sqlite3_reset(r->job);
    give_back(st, r);
    return answer(rc, taken);
}

/* *rc is SQLITE_MISMATCH where the text is not what was written. */
static enum store_answer blob(sqlite3_stmt *s, const char *id, char **text, size_t *length, int *rc)
{
    sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC);
    *rc = sqlite3_step(s);
    if (*rc == SQLITE_ROW && !genuine(s, id))
        *rc = SQLITE_MISMATCH;
    bool taken = *rc == SQLITE_ROW && copy_blob(s, text, length);
    sqlite3_reset(s);
    return answer(*rc, taken);
}

enum store_answer store_request(struct store *st, const char *id, char **text, size_t *length)
{
    int rc;
    struct store_reader *r = borrow(st);
    enum store_answer a = blob(r->request, id, text, length, &rc);
    give_back(st, r);
    if (a == STORE_BROKEN)
        log_event(LOG_L_ERROR, "request_not_read", "job", id, "reason", sqlite3_errstr(rc), NULL);
    return a;
}

enum store_answer store_result(struct store *st, const char *id, char **text, size_t *length)
{
    int rc = SQLITE_CORRUPT;
    struct store_reader *r = borrow(st);
    enum store_answer a = renew(st, r) ? blob(r->result, id, text, length, &rc) : STORE_NONE;
    give_back(st, r);
    if (a == STORE_BROKEN && rc != SQLITE_ROW) {
        log_event(LOG_L_WARN, "result_not_read", "job", id, "reason", sqlite3_errstr(rc), NULL);
        if (store_file_broken(rc))
            atomic_store(&st->cache_broken, true);
        return STORE_NONE;
    }
    return a;
}

enum store_answer store_list(struct store *st, const struct store_query *q, struct store_page *page)
{
    int limit = q->limit;
    *page = (struct store_page){ .row = calloc((size_t)limit + 1, sizeof *page->row) };
    if (!page->row)
        return STORE_BROKEN;
    struct store_reader *r = borrow(st);
    /* One status alone has an index; a set is filtered along the way. */
    bool one = __builtin_popcount(q->statuses) == 1;
    sqlite3_stmt *s = one ? r->list_one : r->list;
    sqlite3_bind_int64(s, 1, q->before ? q->before : INT64_MAX);
    sqlite3_bind_int64(s, 2, one ? __builtin_ctz(q->statuses) : (int64_t)q->statuses);
    sqlite3_bind_int(s, 3, limit + 1);       /* one more tells whether there are more */
    sqlite3_bind_text(s, 4, q->owner, -1, SQLITE_STATIC);    /* NULL binds NULL */
    int rc = SQLITE_DONE;
    while (page->rows <= limit && (rc = sqlite3_step(s)) == SQLITE_ROW)
        if (!store_read_row(s, &page->row[page->rows++]))
            break;
    sqlite3_reset(s);
    sqlite3_bind_null(s, 4);
    give_back(st, r);
    if (page->rows > limit) {
        page->more = true;
        free(page->row[--page->rows].error);
    } else if (rc != SQLITE_DONE) {
        store_page_free(page);
        return STORE_BROKEN;
    }
    return STORE_FOUND;
}

void store_page_free(struct store_page *page)
{
    for (int i = 0; i < page->rows; i++)
        free(page->row[i].error);
    free(page->row);
    *page = (struct store_page){ 0 };
}
