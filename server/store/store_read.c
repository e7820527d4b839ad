/* The store's readers: a few read-only connections, lent one at a time. */
#include "store_parts.h"
#include "log.h"
#include "spool.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A long text is not a column of the row, for which SQLite would make a copy of it: it is read into its place. */
#define STORE_LONG "65536"
#define STORE_SHORT(column) "CASE WHEN length(" column ") <= " STORE_LONG " THEN " column " END"

static bool open_cache(struct store_reader *r, const char *folder, char *why, size_t size)
{
    return (r->cache = store_file_open(folder, FILE_CACHE, false, why, size))
        && (r->result = store_file_prepare(r->cache, "SELECT " STORE_SHORT("result") ", sum, rowid, length(result), " STORE_PIECES_BYTES("?1") " FROM results WHERE id=?1", why, size))
        && (r->pieces = store_file_prepare(r->cache, STORE_PIECES, why, size));
}

bool store_readers_open(struct lite *st, const char *folder, char *why, size_t size)
{
    for (int i = 0; i < STORE_READERS; i++) {
        struct store_reader *r = &st->reader[i];
        bool ok = (r->queue = store_file_open(folder, FILE_QUEUE, false, why, size))
            && (r->job = store_file_prepare(r->queue, "SELECT " STORE_ROW_COLUMNS " FROM jobs WHERE id=?1", why, size))
            && (r->request = store_file_prepare(r->queue, "SELECT " STORE_SHORT("request") ", sum, rowid, length(request) FROM jobs WHERE id=?1", why, size))
            && store_list_prepare(r, why, size)
            && open_cache(r, folder, why, size);
        if (!ok)
            return false;
    }
    return true;
}

/* The writer may have started another cache file since. False: it cannot be opened now. */
static bool renew(struct lite *st, struct store_reader *r)
{
    char why[512];
    unsigned age = atomic_load(&st->cache_age);
    if (r->cache && r->cache_age == age)
        return true;
    sqlite3_finalize(r->result);
    sqlite3_finalize(r->pieces);
    sqlite3_close(r->cache);
    r->result = r->pieces = NULL;
    r->cache = NULL;
    r->cache_age = age;
    return open_cache(r, st->folder, why, sizeof why);
}

void store_readers_close(struct lite *st)
{
    for (int i = 0; i < STORE_READERS; i++) {
        struct store_reader *r = &st->reader[i];
        sqlite3_stmt *const statements[] = { r->job, r->request, r->list, r->list_one, r->mine, r->mine_one, r->owners, r->owned, r->result, r->pieces };
        for (size_t k = 0; k < sizeof statements / sizeof *statements; k++)
            sqlite3_finalize(statements[k]);
        sqlite3_close(r->queue);
        sqlite3_close(r->cache);
    }
}

struct store_reader *store_borrow(struct lite *st)
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

void store_give_back(struct lite *st, struct store_reader *r)
{
    pthread_mutex_lock(&st->read_lock);
    assert(r->busy && r >= st->reader && r < st->reader + STORE_READERS);
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
    row->seconds = sqlite3_column_int64(s, 9);
    row->epoch = sqlite3_column_int64(s, 10);
    snprintf(row->owner, sizeof row->owner, "%s", owner ? owner : "");
    return !error || (row->error = strdup(error));
}

/* Is the text what was written under this id? */
static bool genuine(sqlite3_stmt *s, const char *id, const char *text, size_t length)
{
    unsigned char sum[DIGEST_BYTES];
    const void *kept = sqlite3_column_blob(s, 1);
    digest_kept(sum, id, text, length);
    return kept && sqlite3_column_bytes(s, 1) == sizeof sum && memcmp(kept, sum, sizeof sum) == 0;
}

/* Where texts are; pieces: of those that are of spool_new, the statement for what is not in their row. */
struct place { sqlite3 *db; const char *table, *column; sqlite3_stmt *pieces; };

/* The column of the row that the statement is at. */
static int copy_column(struct place at, sqlite3_stmt *s, char *text, size_t length)
{
    sqlite3_blob *blob = NULL;
    if (sqlite3_column_type(s, 0) != SQLITE_NULL) {
        if ((size_t)sqlite3_column_bytes(s, 0) == length && length)
            memcpy(text, sqlite3_column_blob(s, 0), length);
        return SQLITE_OK;
    }
    int rc = sqlite3_blob_open(at.db, "main", at.table, at.column, sqlite3_column_int64(s, 2), 0, &blob);
    if (rc == SQLITE_OK)
        rc = (size_t)sqlite3_blob_bytes(blob) == length ? sqlite3_blob_read(blob, text, (int)length, 0) : SQLITE_CORRUPT;
    sqlite3_blob_close(blob);
    return rc;
}

struct filling { char *at, *end; };

static bool fill(void *ctx, const void *piece, size_t length)
{
    struct filling *f = ctx;
    if (length > (size_t)(f->end - f->at))
        return false;
    if (length)
        memcpy(f->at, piece, length);
    spool_rest(f->at, length);
    f->at += length;
    return true;
}

/* The text of the row that the statement is at; SQLITE_ROW, or why there is none. While the statement stands there, what is read
 * is of the same moment. */
static int copy_text(struct place at, sqlite3_stmt *s, const char *id, char **text, size_t *length)
{
    size_t first = (size_t)sqlite3_column_int64(s, 3), rest = at.pieces ? (size_t)sqlite3_column_int64(s, 4) : 0;
    *length = first + rest;
    *text = at.pieces ? spool_new(*length) : malloc(*length + 1);
    if (!*text)
        return SQLITE_NOMEM;
    (*text)[*length] = 0;
    int rc = copy_column(at, s, *text, first);
    struct filling f = { *text + first, *text + *length };
    if (rc == SQLITE_OK && rest && !(store_pieces_each(at.pieces, id, fill, &f) && f.at == f.end))
        rc = SQLITE_CORRUPT;
    return rc == SQLITE_OK ? SQLITE_ROW : rc;
}

static enum store_answer answer(int rc, bool taken)
{
    return rc == SQLITE_DONE ? STORE_NONE : rc == SQLITE_ROW && taken ? STORE_FOUND : STORE_BROKEN;
}

enum store_answer lite_job(struct store *face, const char *id, struct job_row *row)
{
    struct lite *st = lite_of(face);
    struct store_reader *r = store_borrow(st);
    sqlite3_bind_text(r->job, 1, id, -1, SQLITE_STATIC);
    int rc = sqlite3_step(r->job);
    bool taken = rc == SQLITE_ROW && store_read_row(r->job, row);
    if (taken && strcmp(row->id, id) != 0) {      /* an index that is damaged */
        free(row->error);
        row->error = NULL;
        taken = false;
    }
    sqlite3_reset(r->job);
    store_give_back(st, r);
    return answer(rc, taken);
}

/* *rc is SQLITE_MISMATCH where the text is not what was written. */
static enum store_answer read_text(struct place at, sqlite3_stmt *s, const char *id, char **text, size_t *length, int *rc)
{
    sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC);
    *text = NULL;
    *rc = sqlite3_step(s);
    if (*rc == SQLITE_ROW)
        *rc = copy_text(at, s, id, text, length);
    if (*rc == SQLITE_ROW && !genuine(s, id, *text, *length))
        *rc = SQLITE_MISMATCH;
    sqlite3_reset(s);
    if (*rc != SQLITE_ROW) {
        if (at.pieces)
            spool_free(*text);
        else
            free(*text);
        *text = NULL;
    }
    return answer(*rc, *rc == SQLITE_ROW);
}

enum store_answer lite_request(struct store *face, const char *id, char **text, size_t *length)
{
    struct lite *st = lite_of(face);
    int rc;
    struct store_reader *r = store_borrow(st);
    enum store_answer a = read_text((struct place){ r->queue, "jobs", "request", NULL }, r->request, id, text, length, &rc);
    store_give_back(st, r);
    if (a == STORE_BROKEN)
        log_event(LOG_L_ERROR, "request_not_read", "job", id, "reason", sqlite3_errstr(rc), NULL);
    return a;
}

enum store_answer lite_result(struct store *face, const char *id, char **text, size_t *length)
{
    struct lite *st = lite_of(face);
    int rc = SQLITE_CORRUPT;
    struct store_reader *r = store_borrow(st);
    enum store_answer a = renew(st, r) ? read_text((struct place){ r->cache, "results", "result", r->pieces }, r->result, id, text, length, &rc) : STORE_NONE;
    store_give_back(st, r);
    if (a == STORE_BROKEN && rc != SQLITE_ROW) {
        log_event(LOG_L_WARN, "result_not_read", "job", id, "reason", sqlite3_errstr(rc), NULL);
        if (store_file_broken(rc))
            atomic_store(&st->cache_broken, true);
        return STORE_NONE;
    }
    return a;
}

/* Only what beats told: where one daemon owns the store, its memory knows better. */
enum store_answer lite_look_at(struct store *face, const char *id, struct job_row *row, struct job_progress *progress)
{
    struct lite *st = lite_of(face);
    enum store_answer a = lite_job(face, id, row);
    if (a != STORE_FOUND)
        return a;
    free(row->error);
    row->error = NULL;
    struct store_reader *r = store_borrow(st);
    sqlite3_stmt *s = NULL;
    bool ok = sqlite3_prepare_v2(r->queue, "SELECT stage, fraction FROM jobs WHERE id=?1", -1, &s, NULL) == SQLITE_OK
        && sqlite3_bind_text(s, 1, id, -1, SQLITE_STATIC) == SQLITE_OK && sqlite3_step(s) == SQLITE_ROW;
    const char *stage = ok ? (const char *)sqlite3_column_text(s, 0) : NULL;
    snprintf(progress->stage, sizeof progress->stage, "%s", stage && row->status == JOB_RUNNING ? stage : job_status_text(row->status));
    progress->moves = false;
    progress->fraction = ok && row->status == JOB_RUNNING ? sqlite3_column_double(s, 1) : 0;
    sqlite3_finalize(s);
    store_give_back(st, r);
    return ok ? STORE_FOUND : STORE_BROKEN;
}
