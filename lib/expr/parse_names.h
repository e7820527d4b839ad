/* Inside the expression folder only: what the parser says about names. */
#ifndef SGA_EXPR_PARSE_NAMES_H
#define SGA_EXPR_PARSE_NAMES_H

#include "expr.h"

struct lex_token;

/* Fills err for a name that is neither symbol nor function: not a number (NaN,
 * Infinity), another language's spelling, or unknown with the nearest known name.
 * `called`: a parenthesis follows. */
void parse_unknown_name(const struct expr_store *st, const char *text, struct lex_token tok, bool called,
                        struct sga_error *err);

#endif
