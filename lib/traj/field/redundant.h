/* Inside the traj folder: given equations without derivatives that were found redundant, kept in view along a motion.
 *
 * The reduction takes some of them for consequences of others, and they are, where it looked: a motion that comes to
 * another part of the constraint set, over a change of branch or through a place where the set crosses itself, may leave
 * them. Points of a motion lie on the constraints; whether these equations hold there too is asked of doubles
 * first, and where that leaves a doubt of a point proved to lie on the constraints, in balls. */
#ifndef SGA_TRAJ_REDUNDANT_H
#define SGA_TRAJ_REDUNDANT_H

#include "reduction.h"

struct num_switches;

struct given {
    int count;                     /* equations that are none of the constraints themselves */
    const struct sys_system *sys;  /* borrowed, like the next two */
    const struct sga_solution *sol;
    const struct sga_budget *budget;
    const double *unit;            /* by variable: natural sizes, borrowed too */
    expr_id *equation;
    int *row;                      /* rows of the system, or rows + index of a restriction */
    struct num_tape *tape;         /* of variables and time */
    struct num_jacobian *jac;
    double *in, *value, *slope;
    double *rounding;              /* by equation: values up to this were found to be rounding */
    int broken;                    /* the equation that failed when it was asked last; -1: none did */
    int lost;                      /* the one that failed last of all, and when; -1: none */
    double lost_t, lost_value;
    double *held;                  /* by equation: |value| where it held last, which errors that are allowed explained; */
    double far_t, far_value;       /* and what the one that is lost came to, as far beyond as it was asked for */
};

/* w: switches that may be held (given_sides), or NULL. */
bool given_init(struct given *g, const struct sys_system *sys, const struct sga_solution *sol, const struct num_switches *w, const double *unit,
                const struct sga_budget *budget, struct sga_error *err);
/* From now on the equations are those of these sides, as num_tape_hold says: a step that tries what lies beyond a surface is on the side where the
 * motion is, and so must be what it is held against. */
void given_sides(struct given *g, const signed char *side);
void given_clear(struct given *g);
/* Whether they hold at (t, x), a point on the constraints; scale (by variable): errors that are allowed, and explain as much.
 * Cost: their values and derivatives; a point of the constraints in balls where these leave a doubt. */
bool given_hold(struct given *g, double t, const double *x, const double *scale);
/* What was lost grows from 0 by then: by how much the time t, at which it was seen to, is too late at the most. */
double given_late(const struct given *g, double t);
/* What the equation is called in the request: "equations[1]". */
void given_name(const struct given *g, int k, char *text, size_t size);

#endif
