/* The verdict of a stored result, from its first bytes: results can be large, and a page of a list asks for many. The writer of answers
 * puts the member first. */
#include "store_parts.h"

#include <stdio.h>
#include <string.h>

static bool first_bytes(struct store_reader *r, sqlite3_int64 row, char *head, int size)
{
    sqlite3_blob *blob = NULL;
    bool ok = sqlite3_blob_open(r->cache, "main", "results", "result", row, 0, &blob) == SQLITE_OK;
    int n = ok ? sqlite3_blob_bytes(blob) : 0;
    n = n < size - 1 ? n : size - 1;
    ok = ok && sqlite3_blob_read(blob, head, n, 0) == SQLITE_OK;
    head[ok ? n : 0] = 0;
    sqlite3_blob_close(blob);
    return ok;
}

void store_read_verdict(struct store_reader *r, struct job_row *row)
{
    static const char begins[] = "{\"verdict\":\"";
    char head[sizeof begins + sizeof row->verdict];
    sqlite3_stmt *s = NULL;
    if (!r->cache || row->status != JOB_DONE
        || sqlite3_prepare_v2(r->cache, "SELECT rowid FROM results WHERE id=?1", -1, &s, NULL) != SQLITE_OK)
        return;
    sqlite3_bind_text(s, 1, row->id, -1, SQLITE_STATIC);
    if (sqlite3_step(s) == SQLITE_ROW && first_bytes(r, sqlite3_column_int64(s, 0), head, sizeof head)
        && strncmp(head, begins, sizeof begins - 1) == 0) {
        const char *word = head + sizeof begins - 1;
        size_t n = strspn(word, "abcdefghijklmnopqrstuvwxyz_");
        if (word[n] == '"' && n < sizeof row->verdict)
            snprintf(row->verdict, sizeof row->verdict, "%.*s", (int)n, word);
    }
    sqlite3_finalize(s);
}
