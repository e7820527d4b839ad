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
/* A number next to this byte would read as one number: 2i with i = 3 is not 23. */
bool index_joins(char c);

/* Which byte is asked about (`at`, of what is written from byte `from` of the output on), and where in the text it comes from. */
struct index_spot { size_t at, from, source; };
/* index_write. */
bool index_write_from(const char *text, const struct index_scope *scope, struct sga_buf *out, struct index_spot *spot, struct sga_error *err);
/* index_sum.c. Whether a sum begins with this token; whether one does somewhere in the text. */
bool index_is_sum(const char *text, struct lex_token tok);
bool index_has_sum(const char *text);
/* Appends the sum, whose name is the token, as "((...) + (...))", or "(0)" where no pass is; the token is then the ) behind it. */
bool index_write_sum(struct index_reader *r, struct sga_buf *out, struct index_spot *spot);

#endif
