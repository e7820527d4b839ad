/* Inside the points folder: a square block of a constraint system at work modulo a prime or a power of one.
 *
 * What it holds is solved for its own variables while all others keep their residues. Affine blocks by elimination, one
 * equation in one unknown by the roots of a polynomial, and, modulo powers, any others by tearing (tear.c). */
#ifndef SGA_POINTS_MODBLOCK_H
#define SGA_POINTS_MODBLOCK_H

#include "points.h"

enum { MODBLOCK_MOST = 400, TORN_MOST = 6, TEAR_MOST = 48 };      /* unknowns of a block, of one that is torn once, and at any number of places */

struct modblock {
    struct num_modp *m;
    const struct points_space *s;
    const int *solved;             /* by constraint: the variable that it is solved for, an index of s->variable */
    const int *member;  int n;     /* its constraints */
    struct expr_cone cone;         /* of them all */
    mp_limb_t *x, *value;          /* by member: its unknown, its residue */
    long *work;                    /* nodes that may still be worked out */
};

void modblock_begin(struct modblock *b);
void modblock_end(struct modblock *b);
/* The unknowns are put in and value[] is filled; false where some have no value. */
bool modblock_evaluate(struct modblock *b);
bool modblock_vanishes(struct modblock *b);
/* True where the unknowns are set so that it vanishes. *affine: another point may do, should this one not. */
bool modblock_affine(struct modblock *b, bool *affine, uint64_t *random);
bool modblock_univariate(struct modblock *b, uint64_t *random);
/* Blocks of up to TORN_MOST unknowns that are affine but for one equation once one unknown is given: by the roots of that equation. */
bool modblock_torn_once(struct modblock *b, uint64_t *random);
/* Modulo powers only: some unknowns are guessed modulo p, each equation is solved for one other or is a check, a guess that
 * fails a check is counted on, and the point that is left is lifted by Hensel's lemma. The block must not hold its unknowns
 * under functions that are not algebraic. Cost: about p^g evaluations for g guesses. */
bool modblock_tear(struct modblock *b, uint64_t *random);
/* Modulo powers only: the point modulo p that the unknowns have now is lifted, if it is one. */
bool modblock_lift(struct modblock *b);
/* How many guesses that would take; -1: it cannot be done. */
int modblock_guesses(struct modblock *b);

#endif
