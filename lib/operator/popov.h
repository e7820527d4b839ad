/* The Popov form of a matrix over k[D]: row reduction by unimodular operations on the left.
 *
 * U P = R, U unimodular. In the weak form the pivot of a row is the last of its entries of
 * largest order, and the pivots of different rows stand in different columns; so the rows are
 * independent, their number is the rank, and the sum of their orders is least. In the full
 * form the entries above and below a pivot have a lower order than it, and pivots are monic.
 *
 * Source: Mulders & Storjohann, J. Symb. Comput. 35 (2003) 377, which goes over word by word
 * because D^k a and a D^k have the same leading term; Beckermann, Cheng & Labahn, J. Symb.
 * Comput. 41 (2006) 513, for Ore matrices. Rows are kept primitive over Z[t]. */
#ifndef SGA_OPERATOR_POPOV_H
#define SGA_OPERATOR_POPOV_H

#include "ore_matrix.h"

struct sga_error;

/* What one analysis may use. */
struct op_limits {
    const struct sga_budget *budget;   /* may be NULL */
    size_t max_bytes;                  /* of one matrix; 0: 100 MB */
};
/* Is time left, and is the matrix within its bytes? Otherwise fills err. */
bool op_within(const struct op_limits *l, const struct ore_matrix *m, struct sga_error *err);

struct op_popov {
    struct ore_matrix R, U, inverse;   /* inverse of U; empty unless asked for */
    int rank;                          /* rows of R that are not 0; the others come last */
    int *pivot, *order;                /* by row, rank of them: its column, its order */
};

/* err says LIMIT_... where it ends early; p is then cleared. */
bool op_popov_weak(struct op_popov *p, const struct ore_matrix *P, bool inverse,
                   const struct op_limits *limits, struct sga_error *err);
/* A copy of R and U (without the inverse); p not initialised. */
void op_popov_copy(struct op_popov *p, const struct op_popov *from);
/* From weak to full. */
bool op_popov_finish(struct op_popov *p, const struct op_limits *limits, struct sga_error *err);
void op_popov_clear(struct op_popov *p);

/* a = q R + rest for a row a (cols entries), rest of lower order than every pivot in its
 * column; a in the row module of R exactly when rest is 0. q has rank entries. p full. */
void op_popov_reduce(const struct op_popov *p, struct ore *a, struct ore *q);

#endif
