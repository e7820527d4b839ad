/* Inside the poly folder: the algebra of polynomials modulo an ideal with finitely many zeros, as matrices over the rationals. */
#ifndef SGA_POLY_HERMITE_H
#define SGA_POLY_HERMITE_H

#include <flint/fmpq_mat.h>

#include "ideal.h"

/* Zeros with their multiplicities. */
enum { HERMITE_MOST = 100 };

struct hermite {
    const struct poly_ideal *I;    /* a Groebner basis */
    struct sga_arena mem;
    ulong *monomial; int count;    /* count x variables: those that no leading monomial divides; the first is 1 */
    int *from, *by;                /* by monomial but the first: an earlier one times this variable */
    fmpq_mat_struct *times;        /* by variable: multiplication by it */
    fmpq_mat_struct *product;      /* by monomial j: column k is the product of the monomials j and k */
    fmpq_mat_struct *trace;        /* 1 x count: of multiplication by each monomial */
};

/* Whether the zeros over the complex numbers are finitely many. */
bool hermite_finite(const struct poly_ideal *I);
/* False: more zeros than HERMITE_MOST, or the budget ended. hermite_clear is due in every case. */
bool hermite_find(struct hermite *h, const struct poly_ideal *I);
void hermite_clear(struct hermite *h);

/* How many real zeros there are, each counted once, and how many in all. False: the numbers are too long. Cost: a characteristic polynomial. */
bool hermite_signature(const struct hermite *h, long *real, long *complex_zeros);

struct poly_real_zeros;
/* The zeros by the roots of one polynomial: fills all but out->real. Source: F. Rouillier, Solving zero-dimensional systems through the rational univariate
 * representation, AAECC 9 (1999) 433. False: no small form was found that tells all zeros from each other; out->over is NULL. */
bool hermite_by_roots(const struct hermite *h, long complex_zeros, struct poly_real_zeros *out);

#endif
