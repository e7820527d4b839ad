/* Inside the points folder: parts of a large set that share no variable. Whether Newton's method leads on from a start, each part tells for
 * itself: a step of one is not shortened for another, and a part that was met stays where it is while others are drawn anew. Of n parts
 * that are met from half of all starts, all together are from one start in 2^n. */
#ifndef SGA_POINTS_PARTS_H
#define SGA_POINTS_PARTS_H

#include "differentials.h"

struct points_parts {
    struct sga_arena mem;
    int count;                 /* 0: the set is small, or of one piece */
    int *of_constraint, *of_variable;     /* -1: a variable of none */
    double *residual, *length, *size;     /* by part, of the last step */
    double *kept;              /* by variable, where its part was met */
    unsigned char *met;        /* by part */
};

/* Sets of so many constraints only; nothing is to be done for smaller ones. Cost: linear. */
void points_parts_init(struct points_parts *q, const struct points_jacobian *j);
void points_parts_clear(struct points_parts *q);
/* By which each part's step d (in units of the variables' scales) is shortened, in q->length. */
void points_parts_damp(struct points_parts *q, const struct points_space *s, const struct points_point *p, const int *scale, const double *d);
/* After steps that led to no point: which parts were met, and where; after a new start, these are put back. */
void points_parts_keep(struct points_parts *q, const struct points_space *s, const struct points_point *p);
void points_parts_restore(const struct points_parts *q, const struct points_space *s, struct points_point *p);

#endif
