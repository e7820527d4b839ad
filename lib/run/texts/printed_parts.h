/* The combination behind a constraint, as it stands beside what is printed. */
#ifndef SGA_RUN_PRINTED_PARTS_H
#define SGA_RUN_PRINTED_PARTS_H

#include <stdbool.h>

#include "expr.h"

struct job;
struct sga_constraint;
struct sga_part;

/* e in normal form where that is found. */
expr_id printed_normal(struct job *j, expr_id e);
/* The factor of a part of a sum that is `divisor` (EXPR_UNDEF: 1) times what is printed. A row leaves alpha - A v, so that left
 * less right counts with the other sign (`minus`); the tangency is that of the constraint as it is printed. */
expr_id printed_factor(struct job *j, const struct sga_part *part, bool minus, expr_id divisor);
/* What the parts of constraint i are divided by, and whether they leave what stands in `replaced` and not what is printed. */
struct printed_sum {
    expr_id divisor;
    bool stands_for;
};
struct printed_sum printed_sum(struct job *j, int constraint);

#endif
