/* Forms: what a user wrote, brought to A(x, t) x' = alpha(x, t).
 *
 * Input is expression handles and symbols, no JSON; sizes have been checked by the
 * caller (asserted here). Output goes to a struct sys_system that has its store and
 * its time symbol and is otherwise empty. Nothing is assumed about squareness. */
#ifndef SGA_FORM_FORM_H
#define SGA_FORM_FORM_H

#include "system.h"

/* A(x, t) x' = alpha(x, t), or its right-hand problem. */
struct form_entry {
    int row, col;                            /* of A as given, from 0 */
    expr_id value;
};

struct form_quasilinear {
    const int *variable; int variables;      /* symbols of x */
    int rows, cols;                          /* of A as given */
    const struct form_entry *entry; size_t entries;   /* any order; equal places add up */
    const expr_id *alpha;                    /* rows of them, cols if transposed */
    const expr_id *restriction; int restrictions;
    bool transpose;                          /* A^T x' = alpha: variables = rows */
};

/* Rows are named "row i". Cost: the number of entries. */
void form_quasilinear(struct sys_system *s, const struct form_quasilinear *in);

#endif
