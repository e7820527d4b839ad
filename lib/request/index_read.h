/* Inside index*.c only: where reading whole numbers is. */
#ifndef SGA_REQUEST_INDEX_READ_H
#define SGA_REQUEST_INDEX_READ_H

#include <stdio.h>

#include "error.h"
#include "index.h"
#include "lex.h"

struct index_reader {
    const char *text;
    struct lex_token tok;
    const struct index_scope *scope;
    struct sga_error *err;
    bool varies;                  /* a loop name was used */
};
void index_start(struct index_reader *r, const char *text, size_t at, const struct index_scope *scope, struct sga_error *err);
void index_advance(struct index_reader *r);
bool index_is(const struct index_reader *r, char c);
bool index_fail(struct index_reader *r, size_t at, enum sga_code code, const char *what);
/* From the present token on; depth: of parentheses so far. */
bool index_expression(struct index_reader *r, int depth, long *out);

#endif
