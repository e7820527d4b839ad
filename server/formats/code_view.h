/* A result, with its request, as source for another language, or as an FMU: what lib/export writes, out of their JSON. */
#ifndef SERVER_CODE_VIEW_H
#define SERVER_CODE_VIEW_H

#include "export.h"

struct slice;

/* Where the answer is from. */
struct code_origin {
    const char *job, *version;
};

/* The languages of an export, in their order, and behind them the archive. */
enum { CODE_FMU = EXPORT_LANGUAGES, CODE_FORMATS };
/* The one with this name; CODE_FORMATS: none. */
int code_format_find(const char *name);
const char *code_format_name(int format);
const char *code_format_type(int format);     /* media type */

/* Appends the source, or the bytes of the archive. False: err (no_code) says what the answer lacks, or why it cannot be written; nothing is appended. */
bool code_view(struct slice request, struct slice result, struct code_origin origin, int format, struct sga_buf *out, struct sga_error *err);

#endif
