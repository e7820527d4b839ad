/* Inside the formats folder: an answer's JSON as texts of an export. */
#ifndef SERVER_CODE_SOURCE_H
#define SERVER_CODE_SOURCE_H

#include "arena.h"
#include "code_view.h"
#include "json_scan.h"

struct code_source {
    struct sga_arena mem;
    struct slice request, result;
    struct export_source source;
    struct sga_error *err;
};

/* False: err (no_code) says what the answer lacks. To be ended all the same. */
bool code_source_read(struct code_source *r, struct slice request, struct slice result, struct code_origin origin, struct sga_error *err);
void code_source_end(struct code_source *r);
/* The text of a string or of a number, as long as r lives; NULL for null and for nothing. */
const char *code_source_text(struct code_source *r, struct slice v);
int code_source_count(struct slice array);

#endif
