/* The samples of a result in another form, line by line, without a tree. */
#ifndef SERVER_VIEW_H
#define SERVER_VIEW_H

#include "json_scan.h"

struct sga_buf;

enum view_format { VIEW_JSON, VIEW_CSV, VIEW_NDJSON };

struct view {
    enum view_format format;       /* CSV or NDJSON */
    struct slice columns, rows;    /* of the text that the caller keeps alive */
    struct slice *name;            /* the columns, with their quotes */
    int names;
    size_t name_bytes;             /* of all of them */
    bool head_done;
    const char *cursor, *rested;   /* what was read before rested is not any more (spool.h) */
    /* Of a sweep: the list, where we are in it, the number of the present one (from 0), and why it has no rows. */
    struct slice sets, error;
    const char *set_cursor;
    int set;
    char set_name[16];             /* of the column */
};

/* From {"columns": [...], "rows": [[...], ...]}, or a list of these and of {"error": {...}}: then the first column is the place in the
 * list, `set`, from 0, and what has no rows is a line of NDJSON alone. False: that is not there, or memory ended. */
bool view_open(struct view *v, enum view_format format, struct slice trajectory);
/* The next row as it stands, v->set its place in a sweep, whose sets without rows are passed over; none after the last. Not to be mixed with lines. */
struct slice view_row(struct view *v);
/* Appends the next line; false after the last. Cost: its length times a small factor. */
bool view_line(struct view *v, struct sga_buf *out);
void view_close(struct view *v);
/* Appends a JSON value as a field of CSV: texts without their quotes, null as nothing. */
void view_field(struct sga_buf *out, struct slice value);

#endif
