/* Inside jump_impulse*.c: the equations of an impulse. */
#ifndef SGA_TRAJ_JUMP_IMPULSE_PARTS_H
#define SGA_TRAJ_JUMP_IMPULSE_PARTS_H

#include <stdbool.h>

#include "expr.h"

struct jump;
struct num_tape;
struct sga_error;
struct traj_mass;

/* Constraints on velocities, their gradients and the masses, at a point. */
struct impulse {
    int n, coordinates, conditions;
    struct num_tape *tape;        /* of variables, time; roots: masses, conditions, then the terms of their gradients */
    expr_id *root;                /* those roots */
    int terms, *row, *col;        /* by term: condition, coordinate */
    double *in, *out, *M, *J;     /* coordinates squared; conditions x coordinates */
};

bool jump_impulse_init(struct impulse *p, const struct jump *j, struct sga_error *err);
void jump_impulse_clear(struct impulse *p);
/* The roots at in; false: one has no value. */
bool jump_impulse_look(struct impulse *p);
/* M and J from the roots in out. */
void jump_impulse_matrices(struct impulse *p, const struct traj_mass *m);
/* M dv - J^T dmu = kept where velocities are free, dv = 0 where they are set, J dv = off; each condition in units of its gradient, and masses in units of the
 * largest, so that ranks are those of directions (dependent.h: speed). dmu may be NULL. */
bool jump_impulse_solve(const struct impulse *p, const unsigned char *set, const double *kept, const double *off, double speed, double *dv, double *dmu);

#endif
