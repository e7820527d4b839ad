/* What is printed of an answer, and the check of what is printed. */
#ifndef SGA_RUN_TEXTS_H
#define SGA_RUN_TEXTS_H

#include "expr.h"

struct job;

/* Texts of what is wanted: normal forms where they are cheap, named parts otherwise. */
bool answer_texts(struct job *j);
void answer_texts_clear(struct job *j);
bool texts_written(const struct job *j);
/* One printed text without names of parts as an expression of the request's store, parameters that have values put in;
 * EXPR_UNDEF: it does not read back. */
expr_id answer_text_read(struct job *j, const char *text);
/* The check at fresh points, of the printed texts where there are any, read back by the
 * parser; otherwise of the handles. */
bool answer_witness(struct job *j);
void answer_witness_clear(struct job *j);

#endif
