/* CSV (RFC 4180: a header, CRLF, quotes where needed; null is an empty field) and NDJSON
 * (an object for each row). Numbers are copied as they stand, so no digit changes. */
#include "view.h"
#include "spool.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"

/* The next member of a sweep. */
static bool next_set(struct view *v)
{
    struct slice one = scan_next(v->sets, &v->set_cursor);
    if (!one.at)
        return false;
    v->set++;
    v->cursor = NULL;
    v->rows = scan_member(one, "rows");
    v->error = scan_member(one, "error");
    return true;
}

/* The columns are those of the first that has any. */
static void open_sweep(struct view *v, struct slice list)
{
    const char *cursor = NULL;
    struct slice one;
    v->sets = list;
    v->set = -1;
    v->columns = v->rows = (struct slice){ "[]", 2 };
    while ((one = scan_next(list, &cursor)).at)
        if (scan_member(one, "columns").at) {
            v->columns = scan_member(one, "columns");
            break;
        }
    snprintf(v->set_name, sizeof v->set_name, "set");
}

/* A column may have the name already. */
static void name_set(struct view *v)
{
    char quoted[sizeof v->set_name + 2];
    for (int i = 0; i < v->names && strlen(v->set_name) < sizeof v->set_name - 1; i++) {
        snprintf(quoted, sizeof quoted, "\"%s\"", v->set_name);
        if (v->name[i].len == strlen(quoted) && memcmp(v->name[i].at, quoted, v->name[i].len) == 0) {
            strcat(v->set_name, "_");
            i = -1;
        }
    }
}

bool view_open(struct view *v, enum view_format format, struct slice trajectory)
{
    *v = (struct view){ .format = format };
    if (*trajectory.at == '[') {
        open_sweep(v, trajectory);
    } else {
        v->columns = scan_member(trajectory, "columns");
        v->rows = scan_member(trajectory, "rows");
    }
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
        v->name_bytes += (v->name[i] = scan_next(v->columns, &cursor)).len;
    if (v->sets.at)
        name_set(v);
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

/* Numbers alone: then the fields are what stands between the brackets. */
static bool only_numbers(struct slice array)
{
    for (size_t i = 1; i + 1 < array.len; i++)
        if (array.at[i] > '9' ? array.at[i] != 'e' && array.at[i] != 'E' : array.at[i] < '+')
            return false;
    return array.len > 2;
}

static void csv_line(struct sga_buf *out, struct slice array)
{
    const char *cursor = NULL;
    struct slice s;
    if (only_numbers(array)) {
        sga_buf_put(out, array.at + 1, array.len - 2);
        sga_buf_put(out, "\r\n", 2);
        return;
    }
    for (bool first = true; (s = scan_next(array, &cursor)).at; first = false) {
        if (!first)
            sga_buf_put(out, ",", 1);
        view_field(out, s);
    }
    sga_buf_put(out, "\r\n", 2);
}

/* Before each value its name, a colon, and a comma or the bracket. */
static void ndjson_line(const struct view *v, struct sga_buf *out, struct slice row)
{
    const char *cursor = NULL;
    struct slice s;
    char *begin = sga_buf_room(out, row.len + v->name_bytes + 2 * (size_t)v->names + sizeof v->set_name + 32), *p = begin;
    *p++ = '{';
    if (v->sets.at)
        p += sprintf(p, "\"%s\":%d", v->set_name, v->set);
    for (int i = 0; i < v->names && (s = scan_next(row, &cursor)).at; i++) {
        if (i || v->sets.at)
            *p++ = ',';
        memcpy(p, v->name[i].at, v->name[i].len);
        p += v->name[i].len;
        *p++ = ':';
        memcpy(p, s.at, s.len);
        p += s.len;
    }
    memcpy(p, "}\n", 3);
    out->len += (size_t)(p + 2 - begin);
}

static struct slice next_row(struct view *v)
{
    struct slice row = scan_next(v->rows, &v->cursor);
    if (row.at && (!v->rested || row.at >= v->rested + SPOOL_STEP)) {
        if (v->rested)
            spool_rest(v->rested, (size_t)(row.at - v->rested));
        v->rested = row.at;
    }
    return row;
}

struct slice view_row(struct view *v)
{
    struct slice row = next_row(v);
    while (!row.at && v->sets.at && next_set(v)) {
        if (!v->rows.at)
            v->rows = (struct slice){ "[]", 2 };
        row = next_row(v);
    }
    return row;
}

bool view_line(struct view *v, struct sga_buf *out)
{
    if (v->format == VIEW_CSV && !v->head_done) {
        v->head_done = true;
        if (v->sets.at)
            sga_buf_printf(out, "%s%s", v->set_name, v->names ? "," : "");
        csv_line(out, v->columns);
        return true;
    }
    struct slice row = next_row(v);
    while (!row.at) {
        if (!v->sets.at || !next_set(v))
            return false;
        if (v->error.at && v->format == VIEW_NDJSON) {
            sga_buf_printf(out, "{\"%s\":%d,\"error\":", v->set_name, v->set);
            sga_buf_put(out, v->error.at, v->error.len);
            sga_buf_put(out, "}\n", 2);
            v->rows = (struct slice){ "[]", 2 };
            return true;
        }
        if (!v->rows.at)
            v->rows = (struct slice){ "[]", 2 };
        row = next_row(v);
    }
    if (v->format == VIEW_CSV) {
        if (v->sets.at)
            sga_buf_printf(out, "%d,", v->set);
        csv_line(out, row);
    } else {
        ndjson_line(v, out, row);
    }
    return true;
}
