/* Whole numbers in names: what stands between [ and ], the values of loop names and sizes in texts, and loops over them.
 *
 *   index := term (('+'|'-') term)*   term := unary (('*'|'/') unary)*   unary := ('+'|'-')* (digits | name | '(' index ')')
 *   loop  := name '=' index ':' index (',' name '=' index ':' index)*
 *   sum   := 'sum' '(' loop ',' text ')'
 * A quotient must be whole. A name is a size or a loop's. Texts are those of the expression grammar (lex.h), errors have line and
 * column in them; the pointer is the caller's. */
#ifndef SGA_REQUEST_INDEX_H
#define SGA_REQUEST_INDEX_H

#include <stdbool.h>
#include <stddef.h>

struct sga_buf;
struct sga_error;

enum {
    INDEX_MOST = 999999999,       /* an index, a bound, a size */
    INDEX_NESTED = 32,            /* parentheses in an index */
    INDEX_LOOPS = 8,              /* indices of one name, names of one loop */
    INDEX_SIZES = 64,
    INDEX_WRITTEN = 1 << 28       /* bytes of a text with its sums written out */
};

/* What names stand for: sizes first, then the names of a loop, the outermost first. */
struct index_scope {
    struct index_name { const char *text; size_t length; long value; } name[INDEX_SIZES + INDEX_LOOPS];
    int sizes, names;
    bool (*taken)(const void *of, const char *name); const void *of;   /* names that a sum's loop may not have; or NULL */
    long *terms, most_terms;      /* that sums make: counted and bounded; or NULL */
};
/* The place of a name, or -1. */
int index_find(const struct index_scope *scope, const char *text, size_t length);

/* The whole text as one index; false with err. */
bool index_value(const char *text, const struct index_scope *scope, long *out, struct sga_error *err);
/* Appends the text with values in place of names, names with their indices worked out, and sums as their terms: `x[i+1]*h^i` to `x[4]*h^3`,
 * `sum(i = 1:2, i*x[i])` to `((1*x[1]) + (2*x[2]))`. Ranges are refused. Linear in what is written. */
bool index_write(const char *text, const struct index_scope *scope, struct sga_buf *out, struct sga_error *err);
/* Where byte `at` of what index_write makes comes from in the text. */
size_t index_source(const char *text, const struct index_scope *scope, size_t at);
/* Whether index_write changes the text, or may refuse it: it has a name of the scope, a sum, or indices that are not plain numbers. */
bool index_touches(const char *text, const struct index_scope *scope);

/* A loop, or the indices of one name with ranges: x[1:3], x[i = 1:n, 2]'. The scope's names grow by those of the loop. */
struct index_loop {
    const char *text;             /* must outlive it */
    struct index_scope *scope;
    struct index_dim { size_t name_at, name_length, low_at; bool range; long low, high, value; } dim[INDEX_LOOPS];
    int dims, known;              /* names that have a value: all in a pass */
    size_t base, quotes_at;       /* of a name: bytes before [, and where its quotes start */
    long turns;                   /* bounds that were worked out */
};
/* "i = 1:n, j = 1:i". */
bool index_loop_read(struct index_loop *l, const char *text, struct index_scope *scope, struct sga_error *err);
/* A text that is one name with indices, at least one of them a range; *is says whether it is. False: it starts like one, and is wrong. */
bool index_range_read(struct index_loop *l, const char *text, struct index_scope *scope, bool *is, struct sga_error *err);
/* The first pass and the next: the scope has its values. False: there is none (any more), or err. */
bool index_first(struct index_loop *l, struct sga_error *err);
bool index_next(struct index_loop *l, struct sga_error *err);
/* How many passes there are; more than `most`, none, or an index out of its limits: false with err. Ends the loop. */
bool index_count(struct index_loop *l, long most, long *out, struct sga_error *err);
/* The names of the loop leave the scope. */
void index_end(struct index_loop *l);
/* Of a name: appends it with this pass's indices. */
void index_put_name(const struct index_loop *l, struct sga_buf *out);
/* "i = 3, j = 4"; of a name without names in it, the name. */
void index_put_pass(const struct index_loop *l, struct sga_buf *out);

#endif
