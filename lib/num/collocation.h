/* Collocation at the Radau points (Radau IIA: nodes c_1 < ... < c_s = 1, order 2 s - 1,
 * L-stable for every s), in double-double for any number of stages.
 *
 * Nodes: the zeros of P_s - P_(s-1), P the Legendre polynomials on [0, 1]. Everything is
 * computed in balls of far more bits and rounded once. E. Hairer and G. Wanner, Solving
 * Ordinary Differential Equations II, IV.5. */
#ifndef SGA_NUM_COLLOCATION_H
#define SGA_NUM_COLLOCATION_H

#include "dd.h"

enum { NUM_RADAU_LEAST = 2, NUM_RADAU_MOST = 32, NUM_RADAU_TAIL = 3 };

struct num_radau {
    int s;
    num_dd *c;           /* s */
    num_dd *A;           /* s x s: a_ij, the integral of Lagrange polynomial j from 0 to c_i */
    double *inverse;     /* s x s: of A */
    num_dd *bary;        /* s + 1: barycentric weights of the nodes 0, c_1, ..., c_s */
    /* The last coefficients, P_s, P_(s-1), ..., of the polynomial through 0 at 0 and z_i at c_i:
     * row k (s entries) times z is that of P_(s-k). */
    num_dd *tail;        /* NUM_RADAU_TAIL x s */
};

/* s stages, NUM_RADAU_LEAST .. NUM_RADAU_MOST. 0.3 milliseconds for 16. */
struct num_radau *num_radau_new(int s);
void num_radau_free(struct num_radau *r);

/* weight (s entries): the polynomial through 0 at 0 and z_i at c_i is sum weight_i z_i at theta. */
void num_radau_weights(const struct num_radau *r, num_dd theta, num_dd *weight);
/* The same in double: for a guess. */
void num_radau_weights_double(const struct num_radau *r, double theta, double *weight);

#endif
