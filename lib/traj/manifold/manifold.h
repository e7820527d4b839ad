/* Inside the traj folder: the final constraint submanifold in double arithmetic. */
#ifndef SGA_TRAJ_MANIFOLD_H
#define SGA_TRAJ_MANIFOLD_H

#include <stdbool.h>

struct normal;
struct num_switches;
struct sga_error;
struct sga_solution;
struct sys_system;

struct manifold {
    int n, c;
    const double *unit;            /* by variable: what a distance of 1 is where no scale is given; set after manifold_init, borrowed */
    struct num_tape *tape;         /* inputs: variables, time; roots: constraints */
    struct num_jacobian *jac;      /* by variables */
    double *in, *r, *value;        /* n + 1; c; nnz */
    struct normal *step;           /* owned */
    int **col, *cols;              /* the pattern, by row */
    double *d, *shift;
    double *target;                /* by constraint: what it is to be instead of 0, for manifold_jump; otherwise NULL */
    double *big, *slope;           /* by constraint: largest entry of its gradient, scaled and not, where it was formed last */
    double plain;                  /* largest |xi_i| over its largest derivative in units of m->unit, of the last evaluation */
    double raw;                    /* largest |xi_i| of the last evaluation, unscaled */
    struct { double *factor, *y, *most, *least, *sum_y, *sum_r; } chord;   /* manifold_chord's; factor NULL: too many constraints */
};

/* switches: those that can be held on a side, borrowed; NULL: none. */
bool manifold_init(struct manifold *m, const struct sys_system *sys, const struct sga_solution *sol,
                   const struct num_switches *switches, struct sga_error *err);
void manifold_clear(struct manifold *m);

/* Constraint values in m->r, each divided by the largest entry of its scaled gradient, so
 * that it is about a distance in units of `scale` (by variable; NULL: m->unit). Returns the
 * largest, or -1 where they have no value. m->step->value holds the scaled rows, with held
 * columns 0. */
double manifold_residual(struct manifold *m, double t, const double *x, const double *scale, const unsigned char *held);

/* Rounding of a scaled residual, times the largest variable in its unit; and how much smaller a constraint's own terms may be than that. */
#define MANIFOLD_ROUNDING 8e-16
#define MANIFOLD_OWN 1e3

/* Whether that residual, the last one of manifold_residual, is what rounding leaves at x: of the largest variable in its unit, and of
 * each constraint's own terms, which a variable of quite another size says nothing of. */
bool manifold_settled(const struct manifold *m, const double *x, const double *scale, double residual);

/* The searches below look at the watch (watch.h), and fail past a limit. */

/* Move x onto the set by Gauss-Newton steps of least scaled norm. False if it does not get
 * there within `steps`. *moved: scaled length of what was added; *residual: the largest
 * scaled constraint at the end; *worst: its index. The pointers may be NULL. */
bool manifold_project(struct manifold *m, double t, double *x, const double *scale, const unsigned char *held,
                      int steps, double *moved, double *residual, int *worst);

/* The same for a point that is near the set already, without held variables and without care:
 * cheap. False: it is left to manifold_project, from the point as it was. m->raw is the residual, *moved
 * the scaled length of what was added. */
bool manifold_chord(struct manifold *m, double t, double *x, const double *scale, double *moved);

/* x, whose constraints have jumped, moves to the set, held variables staying: the others follow as the loss falls evenly to 0.
 * What held variables alone miss by less than 1e-6 of natural units stays as it is. False, and x as it was: they would have to jump on the way, or there
 * is no such point. */
bool manifold_jump(struct manifold *m, double t, double *x, const unsigned char *held);

/* As manifold_project with steps that are at most `longest` in each scaled variable: it stays on the
 * side where it began, where full steps may fly far (from 1.5 to a zero of sin). */
bool manifold_walk(struct manifold *m, double t, double *x, const double *scale, const unsigned char *held,
                   double longest, int steps);

/* As manifold_project, but from x to the point of the set nearest to `guess` (in the scaled norm; NULL: x as given). Held
 * values are those of x. */
bool manifold_nearest(struct manifold *m, double t, const double *guess, double *x, const double *scale, const unsigned char *held,
                      int steps, double *moved, double *residual, int *worst);

#endif
