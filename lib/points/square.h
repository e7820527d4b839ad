/* Inside the points folder: the square subsystem that a point is refined and proved with. */
#ifndef SGA_POINTS_SQUARE_H
#define SGA_POINTS_SQUARE_H

#include "arb_ends.h"
#include "sparse.h"

struct points_point;

/* Everything about one square subsystem: rows scaled by 2^-exponent. */
struct square {
    struct points_jacobian *j;
    struct points_point *p;
    slong *exponent;           /* by constraint */
    const int *scale;          /* by variable, or NULL: unknowns are x / 2^scale */
    struct points_lu lu;
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

/* Whether exactly one point of the set lies in a box about the present one, whose radii the balls of the solved variables get. The variables
 * that are not solved for are exact. Cost: up to some rows a dense inverse, then a sparse factor of B B^T, B the square Jacobian; where that
 * shows nothing the dense inverse again, up to SGA_MOST_PROOF_ROWS. */
bool points_prove(struct square *q, slong prec);

#endif
