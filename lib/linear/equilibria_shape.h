/* What the set of equilibria looks like about one of them where Newton's method does not tell, as the functions' differentials are dependent: a point, a
 * family (a manifold of equilibria), or neither.
 *
 * Equilibria are the common zeros of alpha, the restrictions, what is held and the constraints of the final set (equilibria.h). About x only those
 * factors of these functions count that vanish at x, each once. Factors are chosen, one of each function that does not follow from those before; where
 * they are independent at a point next to x that is proved to be a zero of them, the point is an equilibrium on a manifold of these, of
 * dimension n - r. Where all chosen factors follow from those by which alone a function can vanish there, equilibria about the point are just this
 * manifold: multiplicities, and functions that follow from others, do no harm. A family is what factors over the rationals tell: it may have several branches. */
#ifndef SGA_LINEAR_EQUILIBRIA_SHAPE_H
#define SGA_LINEAR_EQUILIBRIA_SHAPE_H

#include "arena.h"
#include "expr.h"
#include "real_zeros.h"

struct linear_place;
struct linear_request;

struct equilibrium_shape {
    int dimension;                  /* of the equilibria about the point; 0: it is isolated; -1: not told */
    bool crossing;                  /* it lies on a family, and dimension is not told */
    expr_id *factor; int factors;   /* whose common zeros the equilibria about it are, where dimension >= 0: the constraints first */
    int constraints;
};

/* Next to x; lists are in mem. False: no zero of chosen factors is proved there. linear_place_clear is due in every case. Cost: factors of all functions, and
 * eliminations among those that vanish (poly_vanishes_with). */
bool equilibrium_shape_find(struct equilibrium_shape *s, struct sga_arena *mem, const struct linear_request *rq, const expr_id *held, int helds, const double *x, struct linear_place *place);
/* Whether the point of another shape, at the place, is shown to be one of the equilibria that this one tells. */
bool equilibrium_shape_has(const struct equilibrium_shape *s, const struct equilibrium_shape *other, struct linear_place *place);

/* The functions whose zeros equilibria are, into e (room for equilibria_functions_most); their number. constraints: those of the final set too, last. */
int equilibria_functions(const struct linear_request *rq, const expr_id *held, int helds, bool constraints, expr_id *e);
int equilibria_functions_most(const struct linear_request *rq, int helds);

/* Whether the place may be one of the zeros of the shape's factors. */
bool equilibrium_shape_may_have(const struct equilibrium_shape *s, struct linear_place *place);

/* Systems of factors, the constraints and one of each further function, whose zeros together are all equilibria: where some function has several. In mem; their number, 0 where
 * there is but one, or too many. Factors that vanish with others are left out, as far as that is seen: there may be more than variables. */
struct equilibria_branch { expr_id *factor; int factors; };
int equilibria_branches(const struct linear_request *rq, const expr_id *held, int helds, struct sga_arena *mem, struct equilibria_branch **out);

/* How many equilibria are on none of these families (dimension > 0), at the most: POLY_COUNTED with *others, by the branches that are on none of them, or by the
 * ideal of the functions and 1 - w h for products h of a factor of each family; else nothing is known. */
enum poly_count equilibria_beside(const struct linear_request *rq, const expr_id *held, int helds, const struct equilibrium_shape *family, int families, long *others);

#endif
