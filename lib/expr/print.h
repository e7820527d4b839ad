/* Writing expressions in the input grammar.
 *
 * The text reads back (expr_parse) to an expression of the same value. Sums and products
 * are written flat, without parentheses that the grammar does not need: terms by falling
 * degree with a positive one first, factors with numbers first, then parameters and
 * variables, functions, sums. Shared nodes are written out where the text stays within a
 * budget; beyond it they get names, each defined before it is used. */
#ifndef SGA_EXPR_PRINT_H
#define SGA_EXPR_PRINT_H

#include "expr.h"

struct sga_buf;
struct sga_json;

/* One expression without names: the whole tree. Returns false, and writes nothing, if
 * the text would be longer than max_bytes (0: 1 MiB), or if e depends on a SOLVE node
 * (which has no text without names) or is undefined. Cost: linear in the text, times the
 * log of the longest sum. No recursion. */
bool expr_print(const struct expr_store *st, expr_id e, size_t max_bytes, struct sga_buf *out);

/* For messages: its text, or, where expr_print would fail, "(a long expression)". The caller frees it. EXPR_UNDEF is allowed. */
char *expr_text(const struct expr_store *st, expr_id e, size_t max_bytes);
/* For results: its text as a JSON string, or null where expr_print would fail or e is EXPR_UNDEF; false: null. */
bool expr_json(const struct expr_store *st, expr_id e, size_t max_bytes, struct sga_json *w);
/* A list of those that are short enough, as a JSON array of strings. */
void expr_json_list(const struct expr_store *st, const expr_id *e, int count, size_t max_bytes, struct sga_json *w);

/* Named subexpressions, for a set of roots that share much. Every node that is used
 * more than once and whose tree has more than `inline_nodes` nodes becomes a name
 * (prefix + number, skipping names that are symbols). SOLVE nodes are written as the
 * steps of Gaussian elimination with symbolic pivots. */
struct expr_naming {
    const char *prefix;   /* NULL: "s" */
    int inline_nodes;     /* 0: 8 */
    size_t max_bytes;     /* of all texts together; 0: 16 MiB */
};
struct expr_names {
    int count;
    char **name;          /* in the order of definition */
    char **text;          /* may use earlier names */
    char **root;          /* texts of the roots, in the order given */
    int roots;
};
/* naming may be NULL (defaults). False: over max_bytes, undefined, a SOLVE whose matrix is
 * structurally singular, or over the store's node limit while a SOLVE is written out; then
 * *out is empty and the store is usable as before. The caller clears *out. */
bool expr_print_named(struct expr_store *st, const expr_id *roots, int nroots,
                      const struct expr_naming *naming, struct expr_names *out);
void expr_names_clear(struct expr_names *n);

#endif
