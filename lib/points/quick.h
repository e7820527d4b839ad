/* Inside the points folder: many constraints and their differentials in doubles, for steps that balls look at again. */
#ifndef SGA_POINTS_QUICK_H
#define SGA_POINTS_QUICK_H

#include "differentials.h"

struct num_jacobian;
struct num_tape;

struct points_quick {
    struct sga_arena mem;
    struct num_tape *tape;         /* NULL: there is none of these constraints */
    struct num_jacobian *slopes;
    double *in;                    /* variables, parameters, time */
    double *value, *entry;         /* by constraint; in the order of slopes */
    int *place;                    /* of an entry, among the row's columns as points_jacobian has them */
};

/* Cost: the constraints' cones, and the nodes of the store in words. */
void points_quick_init(struct points_quick *q, const struct points_jacobian *j);
void points_quick_clear(struct points_quick *q);
/* The constraints at p->x into q->value, their differentials into row[i], in the order of j->col[i]. False: something is not finite there, or all
 * of a row is 0, or doubles are not enough to tell its size; row is not changed. */
bool points_quick_at(struct points_quick *q, const struct points_jacobian *j, const struct points_point *p, double **row);

#endif
