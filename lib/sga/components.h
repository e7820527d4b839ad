/* Inside the sga folder: components of the sets that a run went through.
 *
 * Points of a run lie on one component of each set as a rule. On another one what was found to vanish may not vanish
 * (x y = exp(x) - 1 is a curve and a line, though no product), and what became a constraint may vanish all over (z (y - x)
 * on y = |x|). Points from independent starts tell, and the reduction is run again near them. A search; sets in one piece
 * (graphs, affine sets) need none. */
#ifndef SGA_SGA_COMPONENTS_H
#define SGA_SGA_COMPONENTS_H

#include "points.h"

struct points_oracle;
struct reduction_options;
struct sga_solution;
struct sys_system;

/* A point of a component that no run was on. */
struct component_place {
    double *x, t;            /* by variable; owned */
    double *parameter;       /* by parameter; owned */
    bool tried;              /* a run began there */
    expr_id set, by;         /* the last constraint of the set that it is a point of, and the function that told */
};

/* What a run rested on: its constraints, what was 0 on how many of them, and a point of its final set. Owned. */
struct component_run {
    expr_id *constraint, *arose; int constraints;   /* arose: what each stands for, and at the end what could not be admitted, or contradicted them, or EXPR_UNDEF */
    struct { expr_id expr; int constraints; bool open; } *zero; int zeros;      /* open: no algebra says that it is one all over */
    struct points_point point;
    int place;               /* that it was run near, or -1 */
    int final;               /* its dimension; -1: it has no final set */
};

struct components {
    struct component_run *run; int runs; size_t run_cap;
    struct component_place *place; int places; size_t place_cap;   /* in the order in which they were found */
};

/* Keeps what a run near a place (-1: none) rested on, and looks for places on other components than those of all runs so
 * far. final: its dimension, or -1. split: it failed as its points lie on several components. */
void components_note(struct components *c, const struct sys_system *system, const struct reduction_options *options,
                     const struct sga_solution *solution, const struct points_oracle *oracle, int place, int final, bool split);
/* Whether the point of run k lies where run `of` has no say: what the latter rests on does not hold there, or nearby on its
 * constraints (k's own may hold there too). */
bool components_apart(struct components *c, const struct sys_system *system, const struct reduction_options *options,
                      const struct sga_solution *solution, int of, int k);
void components_clear(struct components *c);

#endif
