/* Inside the linear folder: gradients of many functions as one table of expressions. */
#ifndef SGA_LINEAR_LINEAR_GRADIENTS_H
#define SGA_LINEAR_LINEAR_GRADIENTS_H

#include <stdbool.h>

#include "arena.h"
#include "expr.h"

struct linear_request;

/* By rows: rows x cols, EXPR_UNDEF where it is 0. Columns are the variables, then the inputs that are tables. */
struct linear_gradients {
    struct expr_store *st;
    int cols;
    int *column;               /* by symbol, -1: none */
    unsigned char *active;     /* by symbol */
};

void linear_gradients_init(struct linear_gradients *g, struct sga_arena *mem, const struct linear_request *rq);
/* The gradients of e[0..count), simplified where they are not short; in mem. */
expr_id *linear_gradients_of(const struct linear_gradients *g, struct sga_arena *mem, const expr_id *e, int count);
/* Whether all of e are affine in what the gradients, table, are for: those are numbers, and only + - * / and whole powers are between (a
 * gradient of sign(x), or of atan(x) + atan(1/x), is 0, and these are no constants). */
bool linear_gradients_affine(const struct linear_gradients *g, const expr_id *e, int count, const expr_id *table);
/* Whether only + - * / and whole powers stand between what the gradients are for. */
bool linear_gradients_rational(const struct linear_gradients *g, const expr_id *e, int count);
/* The same as affine for gradients that are any constants, sqrt(2) and pi among them. */
bool linear_gradients_constant(const struct linear_gradients *g, const expr_id *e, int count, const expr_id *table);
/* Whether the given equations have numbers for entries, and right sides of that kind. */
bool linear_gradients_given(const struct linear_gradients *g, const struct linear_request *rq);
/* Whether some of them depends on a derivative of an input that is a table: its name, or NULL. */
const char *linear_gradients_rate(const struct linear_request *rq, const expr_id *e, int count);

#endif
