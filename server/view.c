/* CSV (RFC 4180: a header, CRLF, quotes where needed; null is an empty field) and NDJSON
 * (an object for each row). Numbers are copied as they stand, so no digit changes. */
#include "view.h"

#include <stdlib.h>
#include <string.h>

bool view_open(struct view *v, enum view_format format, struct slice trajectory)
{
    *v = (struct view){ .format = format, .columns = scan_member(trajectory, "columns"), .rows = scan_member(trajectory, "rows") };
    if (!v->columns.at || !v->rows.at)
        return false;
    const char *cursor = NULL;
    while (scan_next(v->columns, &cursor).at)
        v->names++;
    v->name = calloc((size_t)v->names + 1, sizeof *v->name);
    if (!v->name)
        return false;
    cursor = NULL;
    for (int i = 0; i < v->names; i++)
        v->name[i] = scan_next(v->columns, &cursor);
    return true;
}

void view_close(struct view *v)
{
    free(v->name);
    *v = (struct view){ 0 };
}

/* The text inside a JSON string. Escapes past ASCII do not occur in names and numbers. */
static void put_unescaped(struct sga_buf *out, struct slice s)
{
    for (const char *p = s.at + 1, *end = s.at + s.len - 1; p < end; p++) {
        if (*p == '\\' && p + 1 < end)
            p++;
        if (*p == '"')
            sga_buf_put(out, "\"", 1);     /* doubled, as CSV wants it */
        sga_buf_put(out, p, 1);
    }
}

void view_field(struct sga_buf *out, struct slice s)
{
    if (s.len == 4 && memcmp(s.at, "null", 4) == 0)
        return;
    if (*s.at != '"' && *s.at != '[' && *s.at != '{') {
        sga_buf_put(out, s.at, s.len);
        return;
    }
    bool text = *s.at == '"';
    bool plain = text && !memchr(s.at, ',', s.len) && !memchr(s.at, '\\', s.len);
    if (!plain)
        sga_buf_put(out, "\"", 1);
    if (text)
        put_unescaped(out, s);
    else
        sga_buf_put(out, s.at, s.len);
    if (!plain)
        sga_buf_put(out, "\"", 1);
}

static void csv_line(struct sga_buf *out, struct slice array)
{
    const char *cursor = NULL;
    struct slice s;
    for (bool first = true; (s = scan_next(array, &cursor)).at; first = false) {
        if (!first)
            sga_buf_put(out, ",", 1);
        view_field(out, s);
    }
    sga_buf_put(out, "\r\n", 2);
}

static void ndjson_line(const struct view *v, struct sga_buf *out, struct slice row)
{
    const char *cursor = NULL;
    struct slice s;
    sga_buf_put(out, "{", 1);
    for (int i = 0; i < v->names && (s = scan_next(row, &cursor)).at; i++) {
        if (i)
            sga_buf_put(out, ",", 1);
        sga_buf_put(out, v->name[i].at, v->name[i].len);
        sga_buf_put(out, ":", 1);
        sga_buf_put(out, s.at, s.len);
    }
    sga_buf_put(out, "}\n", 2);
}

bool view_line(struct view *v, struct sga_buf *out)
{
    if (v->format == VIEW_CSV && !v->head_done) {
        v->head_done = true;
        csv_line(out, v->columns);
        return true;
    }
    struct slice row = scan_next(v->rows, &v->cursor);
    if (!row.at)
        return false;
    if (v->format == VIEW_CSV)
        csv_line(out, row);
    else
        ndjson_line(v, out, row);
    return true;
}
