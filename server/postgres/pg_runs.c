/* Claims, beats and the reaping of what was left. */
#include "pg_parts.h"
#include "log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double SECONDS = 5;

/* Bytes of the text format as bytes. */
static char *bytes_of(const PGresult *r, int line, int column, size_t *length)
{
    unsigned char *raw = PQunescapeBytea((const unsigned char *)PQgetvalue(r, line, column), length);
    char *text = raw ? malloc(*length + 1) : NULL;
    if (text) {
        memcpy(text, raw, *length);
        text[*length] = 0;
    }
    PQfreemem(raw);
    return text;
}

static bool genuine(const char *id, const char *text, size_t length, const char *sum, size_t sum_length)
{
    unsigned char made[DIGEST_BYTES];
    digest_kept(made, id, text, length);
    return sum_length == sizeof made && memcmp(made, sum, sizeof made) == 0;
}

enum store_answer pg_claim(struct store *face, const struct store_claimant *who, struct job_row *row, char **request, size_t *length)
{
    struct pg_args a = { 0 };
    pg_text(&a, who->daemon), pg_text(&a, who->version), pg_real(&a, who->lease), pg_number(&a, who->share);
    PGresult *r = pg_ask(pg_of(face), "SELECT " PG_ROW ", request, sum FROM claim_1($1,$2,$3,$4)", &a, false, SECONDS);
    enum store_answer answer = !r ? STORE_BROKEN : PQntuples(r) == 0 ? STORE_NONE : pg_read_row(r, 0, row) ? STORE_FOUND : STORE_BROKEN;
    *request = NULL;
    *length = 0;
    if (answer == STORE_FOUND) {
        size_t sum_length = 0;
        char *sum = bytes_of(r, 0, 17, &sum_length);
        *request = bytes_of(r, 0, 16, length);
        if (!sum || !*request || !genuine(row->id, *request, *length, sum, sum_length)) {
            log_event(LOG_L_ERROR, "request_not_read", "job", row->id, "reason", "it is not what was written", NULL);
            free(*request);
            *request = NULL;          /* whoever runs it says so */
        }
        free(sum);
    }
    PQclear(r);
    return answer;
}

/* As arrays of PostgreSQL, of one run after the other: ids, epochs, stages, fractions, times reached. Stages are words of the library. */
enum { LISTS = 5 };
static char *list_of(const struct store_beat *beat, int count, int what)
{
    size_t room = (size_t)count * 64 + 3, n = 1;
    char *out = malloc(room);
    if (!out)
        return NULL;
    out[0] = '{';
    for (int i = 0; i < count; i++) {
        const struct store_beat *b = &beat[i];
        const char *comma = i ? "," : "";
        n += (size_t)(what == 0 ? snprintf(out + n, room - n, "%s%s", comma, b->id)
            : what == 1 ? snprintf(out + n, room - n, "%s%lld", comma, (long long)b->epoch)
            : what == 2 ? snprintf(out + n, room - n, "%s\"%.*s\"", comma, (int)strspn(b->progress.stage, "abcdefghijklmnopqrstuvwxyz_- "), b->progress.stage)
            : what == 3 ? snprintf(out + n, room - n, "%s%.6g", comma, b->progress.fraction)
            : b->progress.moves ? snprintf(out + n, room - n, "%s%.17g", comma, b->progress.t) : snprintf(out + n, room - n, "%sNULL", comma));
    }
    snprintf(out + n, room - n, "}");
    return out;
}

bool pg_beat(struct store *face, const struct store_claimant *who, struct store_beat *beat, int count)
{
    struct pg_args a = { 0 };
    char *list[LISTS];
    bool ok = true, reached = pg_of(face)->schema > 1;
    int lists = reached ? LISTS : LISTS - 1;
    pg_text(&a, who->daemon), pg_text(&a, who->version), pg_number(&a, who->workers), pg_real(&a, who->lease);
    for (int i = 0; i < lists; i++) {
        ok &= (list[i] = list_of(beat, count, i)) != NULL;
        pg_text(&a, list[i]);
    }
    const char *sql = reached ? "SELECT held, held_epoch, asked FROM beat_2($1,$2,$3,$4,$5,$6,$7,$8,$9)" : "SELECT held, held_epoch, asked FROM beat_1($1,$2,$3,$4,$5,$6,$7,$8)";
    PGresult *r = ok ? pg_ask(pg_of(face), sql, &a, false, SECONDS) : NULL;
    for (int i = 0; r && i < count; i++) {
        beat[i].answer = BEAT_LOST;
        for (int k = 0; k < PQntuples(r); k++)
            if (strcmp(PQgetvalue(r, k, 0), beat[i].id) == 0 && pg_int(r, k, 1) == beat[i].epoch)
                beat[i].answer = *PQgetvalue(r, k, 2) == 't' ? BEAT_CANCEL : BEAT_HELD;
    }
    for (int i = 0; i < lists; i++)
        free(list[i]);
    PQclear(r);
    return r;
}

bool pg_reap(struct store *face, struct store_reaping *reaping)
{
    struct pg_args a = { 0 };
    pg_number(&a, reaping->tries), pg_text(&a, reaping->died), pg_text(&a, reaping->cancelled), pg_number(&a, reaping->now);
    PGresult *r = pg_ask(pg_of(face), "SELECT reap_1($1,$2,$3,$4)", &a, false, SECONDS);
    reaping->count = r ? (long)pg_int(r, 0, 0) : 0;
    PQclear(r);
    return r;
}
