/* Inside the points folder: the subsystem that a point is refined and proved with. */
#ifndef SGA_POINTS_SQUARE_H
#define SGA_POINTS_SQUARE_H

#include "arb_ends.h"
#include "sparse.h"

struct lin_sparse;
struct lin_stairs;
struct points_jacobian;
struct points_point;
struct points_whole;

/* Everything about one subsystem: rows scaled by 2^-exponent; the unknowns are as many variables as there are rows, or all. */
struct square {
    struct points_jacobian *j;
    struct points_point *p;
    slong *exponent;           /* by constraint */
    const int *scale;          /* by variable, or NULL: unknowns are x / 2^scale */
    struct points_lu lu;       /* of as many unknowns as rows, */
    struct points_whole *whole;     /* or the Jacobian in all variables, with factors by its generations; NULL */
    int *unknown, unknowns;    /* variables */
    int c, n;
    double *b, *x;             /* work: rows, columns */
};

static inline slong square_scale(const struct square *q, int variable)
{
    return q->scale ? q->scale[variable] : 0;
}

/* v 2^-exponent. */
static inline double square_scaled(const arf_t v, slong exponent)
{
    SGA_ENDS(arf_end) arf_t t = { 0 };
    arf_mul_2exp_si(t, v, -exponent);
    return arf_get_d(t, ARF_RND_NEAR);
}

/* The Jacobian at the present point, scaled and rounded to doubles: a column for each unknown, in their order. NULL: a value is not finite. */
struct lin_sparse *square_sparse(const struct square *q);
/* The same into one that was made so. False: a value is not finite. */
bool square_values(const struct square *q, struct lin_sparse *B);
/* A bound of |J(X) - B|, the 2-norm, with J(X) in the balls of the entries. */
double square_spread(const struct square *q, const struct lin_sparse *B);
/* B in the generations of the constraints. False: these make no stairs. To be ended by lin_stairs_clear in every case. */
bool square_stairs(const struct square *q, const struct lin_sparse *B, struct lin_stairs *stairs);

/* Whether a point of the set lies in a box about the present one, whose radii the balls of the unknowns get; other variables are exact. Cost: up
 * to some rows a dense inverse, then a sparse factor of B B^T, B the Jacobian in the unknowns; where that shows nothing and they are as many
 * as the rows the dense inverse again, up to SGA_MOST_PROOF_ROWS. */
bool points_prove(struct square *q, slong prec);

#endif
