/* Points of the final set where nothing moves: a search by Newton's method from many starts.
 *
 * With X the reduced field that holds the inputs, and z free coordinates of the final set at x (linearize.h), x is an equilibrium where the
 * constraints, the rates X_z and what is held vanish together: A x' = alpha has the solution x' = 0 there, and on the regular part of the
 * final set no other point has it. Coordinates that are free at one point need not be at another, where X_z = 0 may leave other rates: so the
 * search by coordinates of any one point only gives places, and each is proved or dropped in coordinates of its own. Where these functions are as many as the variables and a Krawczyk step proves the zero (points.h), it is isolated; where
 * they are d fewer and independent, it lies on a family of dimension d. */
#ifndef SGA_LINEAR_EQUILIBRIA_H
#define SGA_LINEAR_EQUILIBRIA_H

#include <stdint.h>

#include "arena.h"
#include "expr.h"
#include "real_zeros.h"

struct linear_request;
struct sga_error;

struct equilibria_request {
    const struct linear_request *rq;
    const expr_id *rate; int rates;        /* X_z in coordinates of some point */
    const expr_id *held; int helds;        /* that vanish too */
    const double *near;                    /* by variable: a start to try first; or 0 */
    const double *low, *high;              /* by variable; infinite: no bound */
    int starts;
    double *const *place; int places;      /* to be tried after these starts */
};

struct equilibrium {
    double *x;                             /* by variable */
    bool certified;                        /* exactly one zero is proved to be there, up to the family that it is on */
    bool degenerate;                       /* the differentials are dependent: a zero by rational arithmetic, of which it is not known whether it is isolated */
    bool kink;                             /* no rates have a derivative there: alpha is 0 by rational arithmetic, so that nothing moves; degenerate */
    bool by_factors;                       /* degenerate, and proved by factors of the functions (equilibria_shape.h): zero are these */
    bool shifted;                          /* degenerate, and some variable is in no function: it lies on a line of zeros */
    int *state; int states;                /* the coordinates: where they are not free at x, the rates prove nothing */
    expr_id *zero; int zeros;              /* rates in coordinates of the place, and what is held */
};

struct equilibria {
    struct sga_arena mem;
    struct equilibrium *point; int points; size_t cap;
    double **irregular; int irregulars;   /* places where the differentials become dependent */
    int tried, reached, outside, beside;   /* starts; that led to a zero; to one outside of the bounds; to a place where differentials are dependent */
    int family;                            /* dimension: variables less functions, at least 0 */
};

/* Zeros from all starts, each once, in the order found. Of families (family > 0) one point alone. False with err: the budget ended, too many
 * functions. equilibria_clear is due in every case. Cost: starts times Newton's method. */
bool equilibria_search(struct equilibria *e, const struct equilibria_request *q, struct sga_error *err);
void equilibria_clear(struct equilibria *e);

/* What algebra says of them, where functions are polynomials. */
struct equilibria_algebra {
    struct sga_arena mem;
    enum poly_count status;                /* of the zeros of the given equations' alpha, restrictions, and what is held: each equilibrium is one */
    long real;                             /* POLY_COUNTED: real ones, each once: as many equilibria found and proved are all */
    double **place; int places;            /* where they are, roughly */
    long on_part;                          /* of them those on the constraints: on the part of the set that was solved; -1: not known */
};

/* parts: the constraints may have other parts, so that those on this one are counted too. Source and cost: poly/real_zeros.h. equilibria_algebra_clear is due in every case. */
void equilibria_by_algebra(struct equilibria_algebra *a, const struct linear_request *rq, const expr_id *held, int helds, bool parts);
void equilibria_algebra_clear(struct equilibria_algebra *a);

#endif
