/* What can be seen of a node without values: on which kinds of symbols it depends, and
 * whether its sign is settled by its shape (wherever it has a value). Kept for all nodes
 * of a store in one array that grows with it. */
#ifndef SGA_EXPR_FACTS_H
#define SGA_EXPR_FACTS_H

#include "expr.h"

enum {
    EXPR_HAS_VARIABLE = 1, EXPR_HAS_TIME = 2, EXPR_HAS_PARAMETER = 4,
    EXPR_NONZERO = 8,      /* never 0 */
    EXPR_NONNEGATIVE = 16, /* never < 0 */
    EXPR_NONPOSITIVE = 32
};

struct expr_facts {
    unsigned char *flag;
    size_t cap;
    int known;
    unsigned char *solve; int solves; size_t solve_cap;   /* by linear solve: what it depends on */
};

void expr_facts_init(struct expr_facts *f);
void expr_facts_clear(struct expr_facts *f);
unsigned expr_facts_of(struct expr_facts *f, const struct expr_store *st, expr_id e);

#endif
