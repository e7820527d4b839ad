/* Points of the constraint variety modulo a prime or a power of one: the accelerator and, for algebraic
 * identities, the stronger evidence that something is zero. */
#ifndef SGA_POINTS_MODPOINT_H
#define SGA_POINTS_MODPOINT_H

#include "modp.h"

struct points_space;

struct points_modpoint {
    struct num_modp *value;
};

/* A random point: variables that are not solved for are random, the others (solved[i]
 * for constraint i, or by shape where that fails or solved is NULL) follow from the constraints block by block; modulo a prime where blocks are affine or
 * have one unknown, modulo a power of a small prime where they are coupled otherwise. False where none is found (unknowns of a
 * block under functions that are not algebraic, more than four guesses): then there is no modular opinion. */
bool points_modpoint_find(struct points_modpoint *p, const struct points_space *space,
                          const int *solved, int prime, uint64_t *random);
/* The same modulo the given prime only (0 .. NUM_MODP_PRIMES - 1; the first to be tried above), with these variables. */
bool points_modpoint_find_modulo(struct points_modpoint *p, const struct points_space *space,
                                 const int *solved, int prime, uint64_t *random);
void points_modpoint_clear(struct points_modpoint *p);
/* 1: zero; 0: not zero (which proves nothing where elementary functions take part); -1: no
 * value. *chance: another point may say otherwise, since it lies on another component or roots have other values there. */
int points_modpoint_zero(struct points_modpoint *p, expr_id e, bool *chance);

#endif
