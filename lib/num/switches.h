/* Switches: abs, sign, min, max, by the function whose sign decides which branch they are on, that is the argument of
 * abs and sign, and the difference of the two of min and max, the way round that a sign beside them has it. On one side of all zeros of these functions an
 * expression is as smooth as its other parts. Tapes can hold switches on a side: num_tape_hold. */
#ifndef SGA_NUM_SWITCHES_H
#define SGA_NUM_SWITCHES_H

#include "expr.h"

struct num_switches {
    int count;
    expr_id *argument;         /* by switch; several nodes may share one */
    int nodes;
    int *of;                   /* by node: its switch, or -1 */
    unsigned char *swapped;    /* by node: of min and max: the argument is the second less the first */
};

/* Those in the cones of the roots that depend on a symbol that is a variable, time or a signal. Adds differences to the
 * store. */
void num_switches_find(struct num_switches *w, struct expr_store *st, const expr_id *root, int roots);
void num_switches_clear(struct num_switches *w);
/* Of a node: its switch, or -1. */
static inline int num_switches_of(const struct num_switches *w, expr_id e)
{
    return e < w->nodes ? w->of[e] : -1;
}

#endif
