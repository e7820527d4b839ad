/* Inside the form folder only: is an expression zero at a random point? */
#ifndef SGA_FORM_PROBE_H
#define SGA_FORM_PROBE_H

#include "expr.h"

/* Values modulo a prime of the rational part of the grammar; other functions take values
 * that are random but the same for equal arguments. So "zero" is certain to be right for
 * what is zero by rational identities, and wrong with a chance of 1 in 2^60 otherwise;
 * sin(x)^2 + cos(x)^2 - 1 counts as nonzero. */
struct form_probe {
    struct expr_cone cone;
    uint64_t *value; size_t value_cap;      /* by place in the cone */
};

void form_probe_init(struct form_probe *p);
void form_probe_clear(struct form_probe *p);
bool form_probe_zero(struct form_probe *p, const struct expr_store *st, expr_id e);

#endif
