/* Inside the expression folder only: writing one tree, some nodes by name. */
#ifndef SGA_EXPR_PRINT_TEXT_H
#define SGA_EXPR_PRINT_TEXT_H

#include "expr.h"

struct sga_buf;

struct print_request {
    const struct expr_store *st;
    const char *const *name;   /* by node: written in its place, or NULL; NULL: no names */
    size_t limit;              /* out->len may not pass this */
};

/* Appends the text of e (in full, even if e itself has a name). False: over the limit,
 * undefined, or a SOLVE node without a name; then *out holds a part. */
bool print_tree(const struct print_request *r, expr_id e, struct sga_buf *out);

/* One factor of a flattened product: e, or 1/e, or e^-n written as 1/e^n. */
struct print_factor {
    expr_id e;
    int power;                 /* n > 1: e^n, for a negative power moved below; otherwise 1 */
    bool below;                /* in the denominator */
};

/* A node as sign * coefficient * product of factors; coefficient > 0 (or 0). */
struct print_product {
    struct print_factor *factor; size_t cap; int count;
    struct print_work { expr_id e; bool below; } *work; size_t work_cap;
    fmpq_t coefficient;
    bool negative;
};
void print_product_init(struct print_product *p);
void print_product_clear(struct print_product *p);
/* False: more than max_factors. `top` is taken apart even if it has a name. */
bool print_product_of(struct print_product *p, const struct print_request *r, expr_id top, expr_id e, size_t max_factors);
/* Sorts the factors for display, and gives the degrees that terms are sorted by. */
void print_product_sort(struct print_product *p, const struct expr_store *st);
void print_product_degrees(const struct print_product *p, const struct expr_store *st, long *variables, long *all);

#endif
