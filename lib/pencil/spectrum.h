/* Inside the pencil folder: from residues to the structure over the rationals. */
#ifndef SGA_PENCIL_SPECTRUM_H
#define SGA_PENCIL_SPECTRUM_H

#include "staircase.h"

/* One pencil on its way; the primes run on and never come twice. */
struct search {
    struct integral p;
    struct structure_mod reference;   /* of the primes that agree */
    mp_limb_t prime;                  /* the last one */
    int agree;
    bool spectrum, gave_up;
    double max_work, work;
    const struct sga_budget *budget;
    struct sga_error *err;
    fmpz_poly_t residue; fmpz_t modulus;   /* monic characteristic polynomial, of the primes that agree */
};

/* Bits of the product of n primes, from below. */
#define PRIME_BITS 61
/* The structure modulo the next prime. False: the budget ended. */
bool search_next(struct search *s, struct structure_mod *m);

/* The monic polynomial behind the residues, made primitive; numerators and denominators are below
 * 2^bits. False: the primes are too few. */
bool spectrum_lift(const struct search *s, double bits, fmpz_poly_t out);

/* Multiplicities and Jordan blocks from the characteristic polynomial: fills factors, and lowers
 * basis where the blocks' proof would pass max_work. */
bool spectrum_factors(struct search *s, const fmpz_poly_t chi, struct pencil_structure *out);

#endif
