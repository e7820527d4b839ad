/* Reading: on any thread, each with a connection of the pool. */
#include "pg_parts.h"
#include "log.h"
#include "spool.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TRIES = 2 };
static const double SECONDS = 5, RESULT_SECONDS = 60;

bool pg_read_row(const PGresult *r, int line, struct job_row *row)
{
    memset(row, 0, sizeof *row);
    int64_t status = pg_int(r, line, 2);
    if (strlen(PQgetvalue(r, line, 0)) != ID_LENGTH || status < 0 || status >= JOB_STATUSES)
        return false;
    memcpy(row->id, PQgetvalue(r, line, 0), ID_LENGTH);
    row->seq = pg_int(r, line, 1);
    row->status = (enum job_status)status;
    row->attempts = (int)pg_int(r, line, 3);
    row->created = pg_int(r, line, 4);
    row->started = pg_int(r, line, 5);
    row->finished = pg_int(r, line, 6);
    row->seconds = pg_int(r, line, 9);
    row->epoch = pg_int(r, line, 10);
    snprintf(row->owner, sizeof row->owner, "%s", PQgetvalue(r, line, 8));
    return PQgetisnull(r, line, 7) || (row->error = strdup(PQgetvalue(r, line, 7)));
}

static PGresult *row_of(struct store *face, const char *id)
{
    struct pg_args a = { .known = PG_KNOWN_ROW };
    pg_text(&a, id);
    return pg_ask(pg_of(face), pg_of(face)->schema > 1 ? "SELECT " PG_ROW ", reached FROM jobs WHERE id = $1" : "SELECT " PG_ROW ", NULL FROM jobs WHERE id = $1",
                  &a, false, SECONDS);
}

enum store_answer pg_job(struct store *face, const char *id, struct job_row *row)
{
    PGresult *r = row_of(face, id);
    enum store_answer answer = !r ? STORE_BROKEN : PQntuples(r) == 0 ? STORE_NONE : pg_read_row(r, 0, row) ? STORE_FOUND : STORE_BROKEN;
    PQclear(r);
    return answer;
}

enum store_answer pg_look_at(struct store *face, const char *id, struct job_row *row, struct job_progress *progress)
{
    PGresult *r = row_of(face, id);
    enum store_answer answer = !r ? STORE_BROKEN : PQntuples(r) == 0 ? STORE_NONE : pg_read_row(r, 0, row) ? STORE_FOUND : STORE_BROKEN;
    if (answer == STORE_FOUND) {
        bool runs = row->status == JOB_RUNNING && !PQgetisnull(r, 0, 14);
        snprintf(progress->stage, sizeof progress->stage, "%s", runs ? PQgetvalue(r, 0, 14) : job_status_text(row->status));
        progress->moves = runs && !PQgetisnull(r, 0, 16) && strcmp(progress->stage, JOB_STAGE_CLAIMED) != 0;
        progress->t = progress->moves ? strtod(PQgetvalue(r, 0, 16), NULL) : 0;
        progress->fraction = runs ? strtod(PQgetvalue(r, 0, 15), NULL) : 0;
        free(row->error);
        row->error = NULL;
    }
    PQclear(r);
    return answer;
}

/* What a row says of a text: the text or its first piece, its sum, how long all of it is, and whose pieces follow. */
enum { TEXT, SUM, LENGTH, PIECES };
#define WHOLE ", '', '0'"

/* The text is of spool_new, or of malloc where it is a request. STORE_NONE: there is none, or it was replaced while it was read. */
static enum store_answer copy_text(struct store *face, const PGresult *r, const char *what, const char *id, bool spooled, char **text, size_t *length)
{
    unsigned char sum[DIGEST_BYTES];
    struct digest_run d;
    size_t first = (size_t)PQgetlength(r, 0, TEXT);
    int64_t epoch = strtoll(PQgetvalue(r, 0, PIECES), NULL, 10);
    *length = epoch ? strtoull(PQgetvalue(r, 0, LENGTH), NULL, 10) : first;
    *text = *length < first ? NULL : spooled ? spool_new(*length) : malloc(*length + 1);
    if (!*text)
        return STORE_BROKEN;
    memcpy(*text, PQgetvalue(r, 0, TEXT), first);
    (*text)[*length] = 0;
    digest_begin(&d, id);
    digest_add(&d, *text, first);
    enum store_answer answer = epoch ? pg_pieces_get(pg_of(face), id, epoch, &d, *text + first, *length - first) : STORE_FOUND;
    digest_end(&d, sum);
    if (answer == STORE_FOUND && (PQgetlength(r, 0, SUM) != DIGEST_BYTES || memcmp(sum, PQgetvalue(r, 0, SUM), DIGEST_BYTES) != 0)) {
        log_event(LOG_L_ERROR, what, "job", id, "reason", "it is not what was written", NULL);
        answer = STORE_BROKEN;
    }
    if (answer != STORE_FOUND) {
        if (spooled)
            spool_free(*text);
        else
            free(*text);
        *text = NULL;
    }
    return answer;
}

/* One that was replaced while it was read is there again. */
static enum store_answer text_of(struct store *face, enum pg_known known, const char *sql, const char *what, const char *id, char **text, size_t *length)
{
    enum store_answer answer = STORE_NONE;
    bool there = true;
    for (int try = 0; try < TRIES && there && answer == STORE_NONE; try++) {
        struct pg_args a = { .known = known };
        pg_text(&a, id);
        PGresult *r = pg_ask(pg_of(face), sql, &a, true, RESULT_SECONDS);
        there = r && PQntuples(r) == 1;
        answer = !r ? STORE_BROKEN : there ? copy_text(face, r, what, id, known == PG_KNOWN_RESULT, text, length) : STORE_NONE;
        PQclear(r);
    }
    return answer;
}

enum store_answer pg_request(struct store *face, const char *id, char **text, size_t *length)
{
    return text_of(face, PG_KNOWN_REQUEST, "SELECT request, sum" WHOLE " FROM jobs WHERE id = $1", "request_not_read", id, text, length);
}

/* One that is damaged can be computed again: it counts as none; where the database is away that cannot be told. */
enum store_answer pg_result(struct store *face, const char *id, char **text, size_t *length)
{
    const char *sql = pg_of(face)->schema >= PG_SCHEMA_PIECES ? "SELECT result, sum, bytes::text, pieces::text FROM results WHERE id = $1"
                                                             : "SELECT result, sum" WHOLE " FROM results WHERE id = $1";
    enum store_answer a = text_of(face, PG_KNOWN_RESULT, sql, "result_not_read", id, text, length);
    return a == STORE_BROKEN && !atomic_load(&pg_of(face)->down) ? STORE_NONE : a;
}

bool pg_owners(struct store *face, const char *id, void (*each)(void *ctx, const char *owner), void *ctx)
{
    struct pg_args a = { 0 };
    pg_text(&a, id);
    PGresult *r = pg_ask(pg_of(face), "SELECT owner FROM interests WHERE id = $1", &a, false, SECONDS);
    for (int i = 0; r && i < PQntuples(r); i++)
        each(ctx, PQgetvalue(r, i, 0));
    PQclear(r);
    return r;
}

enum store_answer pg_owned(struct store *face, const char *id, const char *owner)
{
    struct pg_args a = { 0 };
    pg_text(&a, id), pg_text(&a, owner);
    PGresult *r = pg_ask(pg_of(face), "SELECT 1 FROM interests WHERE id = $1 AND owner = $2", &a, false, SECONDS);
    enum store_answer answer = !r ? STORE_BROKEN : PQntuples(r) ? STORE_FOUND : STORE_NONE;
    PQclear(r);
    return answer;
}

/* One branch for each status of a set: each goes along its own index. */
static size_t branch(char *sql, size_t size, bool mine, int status, bool first)
{
    char one[40] = "";
    if (status >= 0)
        snprintf(one, sizeof one, "AND %s.status = %d", mine ? "i" : "j", status);
    return (size_t)snprintf(sql, size, "%s(SELECT j.id, %s.seq, j.status, attempts, created, started, finished, error, j.owner, seconds, epoch, name, form, verdict"
                                       " FROM %s WHERE %s.seq < $1 %s %s ORDER BY %s.seq DESC LIMIT $2)", first ? "" : " UNION ALL ", mine ? "i" : "j",
                            mine ? "interests i JOIN jobs j ON j.id = i.id" : "jobs j", mine ? "i" : "j", mine ? "AND i.owner = $3" : "", one, mine ? "i" : "j");
}

enum store_answer pg_list(struct store *face, const struct store_query *q, struct store_page *page)
{
    char sql[4096];
    bool all = q->statuses == (1u << JOB_STATUSES) - 1, ok = true;
    size_t n = (size_t)snprintf(sql, sizeof sql, "SELECT * FROM ("), begin = n;
    for (int status = all ? -1 : 0; status < (all ? 0 : JOB_STATUSES); status++)
        if (all || q->statuses & 1u << status)
            n += branch(sql + n, sizeof sql - n, q->owner, status, n == begin);
    snprintf(sql + n, sizeof sql - n, ") AS page ORDER BY seq DESC LIMIT $2");
    struct pg_args a = { 0 };
    pg_number(&a, q->before ? q->before : INT64_MAX), pg_number(&a, q->limit + 1);
    if (q->owner)
        pg_text(&a, q->owner);
    *page = (struct store_page){ .row = calloc((size_t)q->limit + 1, sizeof *page->row) };
    PGresult *r = page->row ? pg_ask(pg_of(face), sql, &a, false, SECONDS) : NULL;
    ok = r;
    for (int i = 0; ok && i < PQntuples(r) && i < q->limit; i++) {
        struct job_row *row = &page->row[page->rows];
        if (!(ok = pg_read_row(r, i, row)))
            break;
        page->rows++;
        row->listed = true;
        snprintf(row->name, sizeof row->name, "%s", PQgetvalue(r, i, 11));
        snprintf(row->form, sizeof row->form, "%s", PQgetvalue(r, i, 12));
        snprintf(row->verdict, sizeof row->verdict, "%s", PQgetvalue(r, i, 13));
    }
    page->more = ok && PQntuples(r) > q->limit;
    PQclear(r);
    if (ok)
        return STORE_FOUND;
    store_page_free(page);
    return STORE_BROKEN;
}
