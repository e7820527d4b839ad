/* Inside the pencil folder: a pencil scaled to small integers, and bounds on its minors. */
#ifndef SGA_PENCIL_INTEGRAL_H
#define SGA_PENCIL_INTEGRAL_H

#include "pencil.h"

struct integral_entry {
    int row, col;
    bool b;                        /* of B, otherwise of A */
    fmpz value;
};

struct integral {
    int rows, cols;
    struct integral_entry *entry; int entries;   /* by rows, none is 0, no place twice */
    /* Sums over the rows of log2 of a norm, each row counted with 1 at least. Of (A | B):
     * a minor of k block rows of a banded matrix made of A and B is below 2^(k * apart).
     * Of |A| + |B|: a minor of s A - B is below 2^joint where |s| = 1. */
    double apart, joint;
};

/* Rows and columns are multiplied by rational constants, which changes no invariant: first all
 * columns, then all rows get content 1, until nothing changes (at most a few times). Cost: entries log entries. */
void integral_init(struct integral *p, const struct pencil *given);
void integral_clear(struct integral *p);

#endif
