/* Independent rows over the rationals, fully reduced: each has a column of its own, where all others are 0.
 *
 * A subspace has one such form for its pivot columns, and its numbers are no longer than the minors of any
 * basis; so the rows that came in may have had longer ones. Beyond the pivot columns (`linear`) rows may have
 * columns that take no pivots: right sides. Everything is exact. */
#ifndef SGA_EXACT_BASIS_H
#define SGA_EXACT_BASIS_H

#include <flint/fmpq.h>

#include "exact_row.h"

struct exact_basis {
    int linear;                /* pivots lie in columns before this one */
    struct exact_row *row; int *pivot;     /* primitive rows, and their columns */
    int rows;
    size_t row_cap, pivot_cap;
    int *row_of;               /* by column: index or -1 */
};

void exact_basis_init(struct exact_basis *b, int linear);
void exact_basis_clear(struct exact_basis *b);
/* out = factor * r - a combination of the rows, 0 in their pivot columns, primitive with its first entry positive; factor
 * is not 0. *met: whether some row took part. columns: how many there are, right sides included. Cost: rows that r meets times columns. */
void exact_basis_reduce(const struct exact_basis *b, const struct exact_row *r, int columns, struct exact_row *out, fmpq_t factor, bool *met);
/* Adds what exact_basis_reduce gave, where it has an entry before `linear`: its largest becomes the pivot, and leaves the other rows. */
void exact_basis_add(struct exact_basis *b, const struct exact_row *reduced, int columns);

/* r = +- a primitive row with its first entry positive; factor is divided by what r was divided by. */
void exact_primitive(struct exact_row *r, fmpq_t factor);

#endif
