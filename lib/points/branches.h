/* Inside the points folder: on which branches of the constraints' abs, sign, min, max a point lies. */
#ifndef SGA_POINTS_BRANCHES_H
#define SGA_POINTS_BRANCHES_H

#include "points.h"

struct points_branches {
    struct expr_cone cone;         /* of the constraints */
    signed char *now, *before;     /* by node of the cone: the branch, -1 or 1; 0 near its change */
    signed char *guess;            /* the same at the guess itself */
    bool asked;                    /* the space asks for points on the branches of their starts, and has switches */
};

void points_branches_init(struct points_branches *b, const struct points_space *s);
void points_branches_clear(struct points_branches *b);
/* The branches at p, now; those that were now are before. */
void points_branches_at(struct points_branches *b, const struct points_space *s, struct points_point *p);
/* The guess of the space has its own; p, a start beside it, has other values again. */
void points_branches_at_guess(struct points_branches *b, const struct points_space *s, struct points_point *p);
/* Whether p is on the branches of the guess, and where that decides none on those that were asked for last, where these were decided. */
bool points_branches_kept(struct points_branches *b, const struct points_space *s, struct points_point *p);

#endif
