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

#include <stdbool.h>
#include <stdint.h>

#include "ball.h"
#include "expr.h"

/* The answer holds where the function has this sign: 1 or -1. */
struct points_side {
    expr_id function;
    int sign;
    bool unseen;              /* what holds beyond is not known: no point of the set was found there */
};

enum { POINTS_BITS = 192 };    /* of points at which functions are asked first */

/* What is sampled. Nothing here is owned. */
struct points_space {
    const struct expr_store *st;
    const int *variable;   int variables;     /* symbols */
    const int *parameter;  int parameters;    /* symbols left symbolic */
    const signed char *parameter_sign;        /* by parameter, 1 or -1; NULL: positive first, then any */
    const double *parameter_value;            /* by parameter: instead of random ones; or NULL */
    const double *parameter_near;             /* by parameter: a guess, NAN where there is none; or NULL */
    int time;                                 /* symbol; -1: it is among the variables (points_find only) */
    const expr_id *constraint; int constraints;
    const expr_id *defined; int defineds;     /* functions that should have values at points, too: starts are chosen so */
    const double *near;                       /* by variable: a guess, or NULL */
    double near_time;
    const signed char *cheap;                 /* by variable: log2 of how much more easily it leaves the guess than others; or NULL */
    double near_spread;                       /* how far from the guess the oracle's points are drawn, relatively; 0: as from a guess that may be special */
    const struct points_point *before;        /* a point of a larger set: tried first, or NULL */
    const int *scale;                         /* by variable: log2 of its natural size, or NULL */
    double time_unit;                         /* over which equations change with time, where that is far from 1; 0: 1 */
    bool by_shape;                            /* the set is solved variable by variable (triangular.h) from the first start on,
                                               * and not by steps, which go to the part that is nearest */
    int starts;                               /* random ones to try; 0: the usual number */
    bool by_name;                             /* starts are drawn by the names of variables, whatever their order */
    long *steps;                              /* Newton steps left, counted down: none is found past them; NULL: any number */
    const struct points_side *side; int sides;   /* points on other sides are not taken */
    bool same_branches;                       /* nor, of the first few starts near a guess, those where abs, sign, min, max of the
                                               * constraints have another branch than at the start */
    const struct sga_budget *budget;
};

enum points_status {
    POINTS_OK,
    POINTS_NONE,        /* no start led to a point: not a proof that there is none */
    POINTS_IRREGULAR,   /* the differentials become dependent where the constraints vanish */
    POINTS_STOPPED      /* budget */
};

struct points_point {
    struct num_ball ball;      /* symbols are set; values of nodes extend on demand */
    bool certified;
    bool scaled;               /* found with the space's scale, and refined with it */
    bool cheaply;               /* some variables moved more easily than others from its start */
    bool triangular;           /* solved variable by variable: refined in the same way */
    double *x;                 /* by variable, midpoints (may be 0 or inf if out of range) */
    double t;
    double *parameter;         /* by parameter */
    int *solved;               /* by constraint: the variable that was solved for */
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

/* splitmix64, and a double in (0, 1) with 30 bits, exact in every arithmetic here. */
uint64_t points_random(uint64_t *state);
double points_uniform(uint64_t *state);
/* v rounded to 24 bits: enough for a generic value, and exact values stay short. */
double points_short(double v);

#endif
