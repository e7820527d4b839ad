/* Numbers drawn by chance, the same from the same state: what starts and values of parameters are made of. */
#ifndef SGA_POINTS_POINTS_RANDOM_H
#define SGA_POINTS_POINTS_RANDOM_H

#include <stdint.h>

/* splitmix64, and a double in (0, 1) with 30 bits, exact in every arithmetic here. */
uint64_t points_random(uint64_t *state);
double points_uniform(uint64_t *state);
/* A number in [-2, 2) that a name and a turn have: the same in any order of names. */
double points_scatter(const char *name, int turn);
/* v rounded to 24 bits: enough for a generic value, and exact values stay short. */
double points_short(double v);

#endif
