/* Inside the traj folder: constraints and other functions of a motion as numbers, constraints followed by their derivatives along directions. */
#ifndef SGA_TRAJ_LEAST_ROWS_H
#define SGA_TRAJ_LEAST_ROWS_H

#include <stdbool.h>

#include "expr.h"

struct num_jacobian;
struct num_tape;
struct sga_error;

struct least_rows {
    int n, all, q;                /* variables of the motion, and with derivatives (n (1 + q)); directions */
    int first, count;             /* the roots from `first` on are so many constraints, each followed by xi_x S + xi_k for each direction */
    int more;                     /* inputs after time: constants */
    struct num_tape *value;
    struct num_jacobian *jac;     /* by variables, time, and these */
    double *in, *out, *entry;
};

/* input: symbols of the variables, with derivatives, of time, then `more` others, whose values the caller puts behind time in rows->in. n, q, first and
 * more are set; false with err. least_rows_clear is due in any case. */
bool least_rows_init(struct least_rows *r, const struct expr_store *st, const expr_id *root, int roots, const int *input, struct sga_error *err);
void least_rows_clear(struct least_rows *r);
/* in := (x, S, t); S: 0 where NULL, q x n. */
void least_rows_load(struct least_rows *r, double t, const double *x, const double *S);
/* out and entry there. False: something has no value. */
bool least_rows_at(struct least_rows *r, double t, const double *x, const double *S);
/* The gradient of a root there by the variables of the motion (n); returns that by time. */
double least_rows_gradient(const struct least_rows *r, int root, double *g);

#endif
