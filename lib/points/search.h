/* Inside the points folder: what searches for points of one set make once: the pattern of its differentials, a tape of them, orders of its sparse
 * factors, and factors that hold as long as values are the same (those of affine constraints are). */
#ifndef SGA_POINTS_SEARCH_H
#define SGA_POINTS_SEARCH_H

#include "differentials.h"
#include "normal.h"
#include "quick.h"

struct points_search {
    struct points_jacobian j;
    struct normal normal;
    struct points_quick quick;     /* of many constraints, once it is used */
    bool has_quick;
};

/* The space is borrowed. Cost: the constraints' cones. */
void points_search_init(struct points_search *w, const struct points_space *space);
void points_search_clear(struct points_search *w);
struct points_quick *points_search_quick(struct points_search *w);

/* points_kept_new, points_kept_free: see points.h. */
struct points_kept;
/* That of the space, with which it goes on; NULL: none is kept of such a space (or k is NULL). */
struct points_search *points_kept_of(struct points_kept *k, const struct points_space *space);

#endif
