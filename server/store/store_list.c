/* Lists: of all jobs by their own order, of one owner's by the order in which he asked. A set of
 * statuses is merged from lists of one status each, so that no rows are passed over. */
#include "store_parts.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

/* What a request calls its system, and its form; of a long one they are not looked for: a page of them is read while others wait. */
#define SHORT(request) "CASE WHEN length(" request ") <= 16384 AND json_valid(CAST(" request " AS TEXT)) THEN CAST(" request " AS TEXT) END"
#define CALLED(request) ", json_extract(" SHORT(request) ", '$.system.name'), json_extract(" SHORT(request) ", '$.system.form')"
#define LISTED STORE_ROW_COLUMNS CALLED("request")
#define MINE "SELECT j.id, i.seq, j.status, j.attempts, j.created, j.started, j.finished, j.error, j.owner, j.seconds, j.epoch" CALLED("j.request") \
             " FROM interests i JOIN jobs j ON j.id = i.id WHERE i.seq < ?1 AND i.owner = ?4 "

bool store_list_prepare(struct store_reader *r, char *why, size_t size)
{
    sqlite3 *q = r->queue;
    return (r->list = store_file_prepare(q, "SELECT " LISTED " FROM jobs WHERE seq < ?1 ORDER BY seq DESC LIMIT ?3", why, size))
        && (r->list_one = store_file_prepare(q, "SELECT " LISTED " FROM jobs WHERE seq < ?1 AND status = ?2 ORDER BY seq DESC LIMIT ?3", why, size))
        && (r->mine = store_file_prepare(q, MINE "ORDER BY i.seq DESC LIMIT ?3", why, size))
        && (r->mine_one = store_file_prepare(q, MINE "AND i.status = ?2 ORDER BY i.seq DESC LIMIT ?3", why, size))
        && (r->owners = store_file_prepare(q, "SELECT owner FROM interests WHERE id = ?1", why, size))
        && (r->owned = store_file_prepare(q, "SELECT 1 FROM interests WHERE id = ?1 AND owner = ?2", why, size));
}

static void read_called(sqlite3_stmt *s, struct job_row *row)
{
    const char *name = (const char *)sqlite3_column_text(s, 11), *form = (const char *)sqlite3_column_text(s, 12);
    row->listed = true;
    snprintf(row->name, sizeof row->name, "%s", name ? name : "");
    snprintf(row->form, sizeof row->form, "%s", form ? form : "");
}

/* Appends the rows of one statement. status: -1 where it has none. */
static int add(struct store_reader *r, sqlite3_stmt *s, const struct store_query *q, int status, struct store_page *page)
{
    int rc, most = page->rows + q->limit + 1;       /* one more tells whether there are more */
    sqlite3_bind_int64(s, 1, q->before ? q->before : INT64_MAX);
    if (status >= 0)
        sqlite3_bind_int(s, 2, status);
    sqlite3_bind_int(s, 3, q->limit + 1);
    if (q->owner)
        sqlite3_bind_text(s, 4, q->owner, -1, SQLITE_STATIC);
    while ((rc = sqlite3_step(s)) == SQLITE_ROW && page->rows < most) {
        assert(page->rows < (q->limit + 1) * JOB_STATUSES);
        struct job_row *row = &page->row[page->rows++];
        if (!store_read_row(s, row)) {
            rc = SQLITE_CORRUPT;
            break;
        }
        read_called(s, row);
        store_read_verdict(r, row);
    }
    sqlite3_reset(s);
    sqlite3_clear_bindings(s);
    return rc;
}

static int newest_first(const void *a, const void *b)
{
    const struct job_row *x = a, *y = b;
    return x->seq < y->seq ? 1 : x->seq > y->seq ? -1 : 0;
}

static int add_set(struct store_reader *r, const struct store_query *q, struct store_page *page)
{
    int rc = SQLITE_DONE;
    for (int status = 0; rc == SQLITE_DONE && status < JOB_STATUSES; status++)
        if (q->statuses & 1u << status)
            rc = add(r, q->owner ? r->mine_one : r->list_one, q, status, page);
    qsort(page->row, (size_t)page->rows, sizeof *page->row, newest_first);
    return rc;
}

enum store_answer lite_list(struct store *face, const struct store_query *q, struct store_page *page)
{
    struct lite *st = lite_of(face);
    bool all = q->statuses == (1u << JOB_STATUSES) - 1;
    *page = (struct store_page){ .row = calloc((size_t)(q->limit + 1) * JOB_STATUSES, sizeof *page->row) };
    if (!page->row)
        return STORE_BROKEN;
    struct store_reader *r = store_borrow(st);
    int rc = all ? add(r, q->owner ? r->mine : r->list, q, -1, page) : add_set(r, q, page);
    store_give_back(st, r);
    if (rc != SQLITE_DONE) {
        store_page_free(page);
        return STORE_BROKEN;
    }
    page->more = page->rows > q->limit;
    while (page->rows > q->limit)
        free(page->row[--page->rows].error);
    return STORE_FOUND;
}

bool lite_owners(struct store *face, const char *id, void (*each)(void *ctx, const char *owner), void *ctx)
{
    struct lite *st = lite_of(face);
    struct store_reader *r = store_borrow(st);
    int rc;
    sqlite3_bind_text(r->owners, 1, id, -1, SQLITE_STATIC);
    while ((rc = sqlite3_step(r->owners)) == SQLITE_ROW)
        each(ctx, (const char *)sqlite3_column_text(r->owners, 0));
    sqlite3_reset(r->owners);
    store_give_back(st, r);
    return rc == SQLITE_DONE;
}

enum store_answer lite_owned(struct store *face, const char *id, const char *owner)
{
    struct lite *st = lite_of(face);
    struct store_reader *r = store_borrow(st);
    sqlite3_bind_text(r->owned, 1, id, -1, SQLITE_STATIC);
    sqlite3_bind_text(r->owned, 2, owner, -1, SQLITE_STATIC);
    int rc = sqlite3_step(r->owned);
    sqlite3_reset(r->owned);
    store_give_back(st, r);
    return rc == SQLITE_ROW ? STORE_FOUND : rc == SQLITE_DONE ? STORE_NONE : STORE_BROKEN;
}

bool lite_used(struct store *face, int64_t since, void (*each)(void *ctx, const char *owner, int64_t ms), void *ctx)
{
    struct lite *st = lite_of(face);
    struct store_reader *r = store_borrow(st);
    sqlite3_stmt *s = NULL;
    int rc = sqlite3_prepare_v2(r->queue, "SELECT owner, sum(finished - max(started, ?1)) FROM jobs WHERE finished > ?1 AND started > 0 GROUP BY owner", -1, &s, NULL);
    if (rc == SQLITE_OK)
        sqlite3_bind_int64(s, 1, since);
    while (rc == SQLITE_OK && sqlite3_step(s) == SQLITE_ROW)
        each(ctx, (const char *)sqlite3_column_text(s, 0), sqlite3_column_int64(s, 1));
    sqlite3_finalize(s);
    store_give_back(st, r);
    return rc == SQLITE_OK;
}
