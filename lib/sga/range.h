/* Inside the sga folder: ranges of expressions, symbols taken as independent real numbers. */
#ifndef SGA_SGA_RANGE_H
#define SGA_SGA_RANGE_H

#include "facts.h"

/* All values lie between lo and hi, constants of the store; EXPR_UNDEF: no bound known.
 * An end that is not `in` is certainly not taken. */
struct range {
    expr_id lo, hi;
    bool lo_in, hi_in;
};

/* Ranges of the nodes of a list (children first), by position; place[node] tells the
 * position. O(count); may add constants to the store. */
void range_of_list(struct expr_store *st, struct expr_facts *facts, const expr_id *list, int count,
                   const int *place, struct range *range);

/* Compare constants (free of symbols): -1, 0, 1, or RANGE_UNKNOWN. Equal only where that is
 * exact or shown by algebra. */
enum { RANGE_UNKNOWN = 2 };
int range_compare(struct expr_store *st, expr_id a, expr_id b);

#endif
