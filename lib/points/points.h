/* Certified real points of a constraint set {x : xi_1(x, t) = ... = xi_r(x, t) = 0}.
 *
 * A point is found by Gauss-Newton steps of least norm from a start (random, or near a
 * given guess), refined to the asked precision in ball arithmetic with the variables
 * that are not solved for kept exact, and proved by a Krawczyk step: inside the balls
 * lies exactly one solution. (Krawczyk 1969; Rump, Verification methods, Acta Numerica
 * 2010, section 13.) Numbers of any magnitude: rows are scaled by powers of two before
 * they become doubles. */
#ifndef SGA_POINTS_POINTS_H
#define SGA_POINTS_POINTS_H

#include "ball.h"

struct points_space;

struct points_point {
    struct num_ball ball;      /* symbols are set; values of nodes extend on demand */
    bool certified;
    bool scaled;               /* found with the space's scale, and refined with it */
    bool cheaply;               /* some variables moved more easily than others from its start */
    bool triangular;           /* solved variable by variable: refined in the same way */
    bool away;                 /* its search went ever farther: what it approached, if anything, lies at infinity */
    double *x;                 /* by variable, midpoints (may be 0 or inf if out of range) */
    double t;
    double *parameter;         /* by parameter */
    int *solved;               /* by constraint: the variable that was solved for, */
    bool unsolved;             /* unless all moved together */
    int variables, constraints, parameters;
};

/* Find one point. `spread` is how far from near (relative to 1 + |near|) the start is
 * taken: 0 for the guess itself; without near the start is random in a box of about
 * that size. random is the generator's state. On POINTS_IRREGULAR point->x holds the
 * place that was approached. The point must be cleared in every case. */
enum points_status points_find(const struct points_space *space, double spread, uint64_t *random,
                               slong prec, struct points_point *point);
/* The same in stages: first a point of the first end[0] constraints, from there one of the
 * first end[1], and so on; end[stages - 1] is all of them. Generations of constraints are
 * natural stages: each can be met by few new variables, where all at once is a long way. */
enum points_status points_find_staged(const struct points_space *space, const int *end, int stages,
                                      double spread, uint64_t *random, slong prec, struct points_point *point);
/* Raise an existing point to more bits (same point). False if it cannot be refined. */
bool points_refine(const struct points_space *space, struct points_point *point, slong prec);
/* A copy with values of symbols only, to be worked with at so many bits. */
void points_point_copy(struct points_point *to, const struct points_point *from, slong prec);
void points_point_clear(struct points_point *point);

#endif
