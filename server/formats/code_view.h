/* A result, with its request, as source for another language: what lib/export writes, out of their JSON. */
#ifndef SERVER_CODE_VIEW_H
#define SERVER_CODE_VIEW_H

#include "export.h"
#include "json_scan.h"

/* Where the answer is from. */
struct code_origin {
    const char *job, *version;
};

/* Appends the source. False: err (no_code) says what the answer lacks, or why it cannot be written; nothing is appended. */
bool code_view(struct slice request, struct slice result, struct code_origin origin, enum export_language language, struct sga_buf *out, struct sga_error *err);

#endif
