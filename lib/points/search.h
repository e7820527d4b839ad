/* Inside the points folder: what searches for points of one set make once: the pattern of its differentials, a tape of them, orders of its sparse
 * factors, and factors that hold as long as values are the same (those of affine constraints are). */
#ifndef SGA_POINTS_SEARCH_H
#define SGA_POINTS_SEARCH_H

#include "differentials.h"
#include "lin_stairs.h"
#include "normal.h"
#include "quick.h"

/* The differentials in all variables that constraints have, by their generations, and what is known of them with these values. */
struct points_whole {
    struct lin_sparse *J;          /* NULL: not yet */
    bool none;                     /* the pattern makes no such stairs */
    struct lin_stairs stairs;
    double *of;                    /* J's values that the bounds are of; NULL: none */
    double least[2];               /* lower bounds of its least singular value, by its generations, and as a whole; -1: not asked for */
};

struct points_search {
    struct points_jacobian j;
    struct points_whole whole;
    struct normal normal;
    struct points_quick quick;     /* of many constraints, once it is used */
    bool has_quick;
};

/* The space is borrowed. Cost: the constraints' cones. */
void points_search_init(struct points_search *w, const struct points_space *space);
void points_search_clear(struct points_search *w);
void points_whole_clear(struct points_whole *w);
struct points_quick *points_search_quick(struct points_search *w);

#endif
