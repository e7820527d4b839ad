/* Inside the poly folder: Groebner bases of ideals over the rationals, by Buchberger's algorithm.
 *
 * Source: B. Buchberger, A criterion for detecting unnecessary reductions in the construction of Groebner bases, EUROSAM 79, LNCS 72 (1979) 3; T. Becker &
 * V. Weispfenning, Groebner Bases (1993), section 5.5. Graded reverse lexicographic order: bases of points are small in it. */
#ifndef SGA_POLY_IDEAL_H
#define SGA_POLY_IDEAL_H

#include <flint/fmpz_mpoly.h>
#include <stdbool.h>

#include "arena.h"

struct sga_budget;

struct poly_ideal {
    struct sga_arena mem;
    fmpz_mpoly_ctx_t ctx;          /* of ORD_DEGREVLEX */
    int n;                         /* variables */
    fmpz_mpoly_struct **g; int count; size_t cap;   /* primitive, without 0; after poly_ideal_basis leading monomials that do not divide each other */
    const struct sga_budget *budget;
};

void poly_ideal_init(struct poly_ideal *I, int variables, const struct sga_budget *budget);
void poly_ideal_clear(struct poly_ideal *I);
/* A copy of f becomes a generator; nothing for 0. */
void poly_ideal_add(struct poly_ideal *I, const fmpz_mpoly_t f);
/* The generators become a Groebner basis. False: more pairs, terms, digits or degrees than are worked with, or the budget ended; then
 * the ideal is good for nothing but clearing. */
bool poly_ideal_basis(struct poly_ideal *I);
/* Of a basis: r = f modulo the ideal times a number that is put into scale (> 0). */
bool poly_ideal_reduce(const struct poly_ideal *I, fmpz_mpoly_t r, fmpz_t scale, const fmpz_mpoly_t f);

#endif
