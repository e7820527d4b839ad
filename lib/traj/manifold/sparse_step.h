/* Inside the traj folder: steps of least weighted length onto the final set, sparse, where rows may depend on each other. */
#ifndef SGA_TRAJ_SPARSE_STEP_H
#define SGA_TRAJ_SPARSE_STEP_H

#include "manifold.h"

struct sparse_step {
    struct manifold *m;
    const double *unit;            /* n, borrowed: what a move of 1 is */
    unsigned char *fixed;          /* n: variables that stay; the caller writes it */
    bool *held;                    /* the same for lin */
    int *row, rows;                /* independent ones, ascending */
    bool chosen;
    struct lin_kkt *kkt;           /* of their pattern */
    double *value, *r;             /* of these rows, packed */
    int *before;                   /* c: the last choice */
    int befores;
};

void sparse_step_init(struct sparse_step *s, struct manifold *m, const double *unit);
void sparse_step_clear(struct sparse_step *s);

/* d (n, in units) that brings the constraints, linearised at x, to 0 with the least sum of (weight_j (d_j - to_j))^2 (to: NULL: 0),
 * 0 where fixed. Dependent rows are left out: they hold with the others, or cannot hold. Returns the largest residual at x in
 * units, -1 where there is no value; *ok: whether a step was found. Cost: a sparse elimination, an ordering where other rows are chosen
 * than before, and a factorisation. */
double sparse_step_find(struct sparse_step *s, double t, const double *x, const double *weight, const double *to, double *d, bool *ok);
/* Onto the set by such steps, x as it was where it fails. *easy: the first was nearly all; or NULL. */
bool sparse_step_settle(struct sparse_step *s, double t, double *x, const double *weight, int steps, bool *easy);

#endif
