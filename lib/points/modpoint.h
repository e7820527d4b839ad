/* Points of the constraint variety modulo a prime: the accelerator and, for algebraic
 * identities, the stronger evidence that something is zero. */
#ifndef SGA_POINTS_MODPOINT_H
#define SGA_POINTS_MODPOINT_H

#include "points.h"
#include "modp.h"

struct points_modpoint {
    struct num_modp *value;
};

/* A random point: variables that are not solved for are random, the others (solved[i]
 * for constraint i) follow from the constraints block by block. False where none is found
 * (a block that is not affine or univariate): then there is no modular opinion. */
bool points_modpoint_find(struct points_modpoint *p, const struct points_space *space,
                          const int *solved, uint64_t *random);
/* The same modulo the given prime (0 .. NUM_MODP_PRIMES - 1). */
bool points_modpoint_find_modulo(struct points_modpoint *p, const struct points_space *space,
                                 const int *solved, int prime, uint64_t *random);
void points_modpoint_clear(struct points_modpoint *p);
/* 1: zero; 0: not zero (which proves nothing where elementary functions take part); -1: no
 * value. */
int points_modpoint_zero(struct points_modpoint *p, expr_id e);

#endif
