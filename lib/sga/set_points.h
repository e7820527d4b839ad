/* Where points of a system's sets lie: its variables, parameters and time, and the constraints that a reduction found. */
#ifndef SGA_SGA_SET_POINTS_H
#define SGA_SGA_SET_POINTS_H

#include "points.h"
#include "points_space.h"

struct sga_solution;
struct sys_system;

/* What a search of points is asked with: the caller adds to `space` where to look (near, starts, scale, budget, ...), and may put as many
 * symbols and functions of his own behind the system's as there is room for, and counts them in. Owned. */
struct set_points {
    struct points_space space;
    int *variable;             /* space.variable: the system's n, and room */
    expr_id *constraint;       /* space.constraint: the first so many of the solution, and room */
    int *end, stages;          /* of generations, as points_find_staged takes them, with room for two more */
};

/* On the first `constraints` of a solution (NULL: on none); room for more variables and constraints. Ended by set_points_clear. */
void set_points_init(struct set_points *p, const struct sys_system *sys, const struct sga_solution *sol, int constraints,
                     int more_variables, int more_constraints);
void set_points_clear(struct set_points *p);

/* Values of the parameters that are tables at time t; the others, which have values in the equations or are not asked for: 0. Malloced. */
double *set_points_tables(const struct sys_system *sys, double t);

#endif
