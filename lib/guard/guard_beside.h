/* A function beside a point: by how much errors of its arguments change it, and whether it jumps over 0 there, of which the former says nothing: the value of a
 * function like sign(u) + 1/2 is as sure beside its jump as anywhere. */
#ifndef SGA_GUARD_BESIDE_H
#define SGA_GUARD_BESIDE_H

#include <stdbool.h>

struct guard_beside {
    /* The function where argument j (of n; -1: the point itself) is another by this. */
    double (*value)(void *ctx, int j, double by);
    void *ctx;
    int n;
};

/* Where guard_beside_jumps looks more closely, as a part. */
#define GUARD_BESIDE_NEARER 1e-3

/* The change of its value g there by an error of argument j: both ways the smaller one, as jumps beside the point are no doubt of its value; 0 where there is a jump at the point, or no value.
 * *jumps becomes true
 * where it jumps within by; NULL: no matter. One evaluation, eight where the change is much of g. */
double guard_beside_change(const struct guard_beside *b, double g, int j, double by, bool *jumps);
/* Whether errors of the arguments, each alone by by[j], leave its sign; false where that is 0. 2 n + 1 evaluations. */
bool guard_beside_steady(const struct guard_beside *b, const double *by);
/* Whether it changes by a jump within GUARD_BESIDE_NEARER by[j] of the point: its greatest change is not much less there than within by[j]. 4 n + 1 evaluations. */
bool guard_beside_jumps(const struct guard_beside *b, const double *by);

#endif
