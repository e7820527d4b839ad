/* Derivatives of a start that is a nearest point, by the implicit function theorem: Lagrange's conditions, differentiated tier by tier (least_tiers.h). */
#ifndef SGA_TRAJ_VARIATION_LEAST_H
#define SGA_TRAJ_VARIATION_LEAST_H

#include <stdbool.h>

#include "expr.h"

struct sga_error;
struct sga_solution;
struct sys_system;
struct traj_request;
struct variation_by;

/* The whole system, with everything that the derivatives are taken by as symbols, and the same at values of them. */
struct variation_start {
    const struct sys_system *sys; const struct sga_solution *sol; const struct traj_request *rq;
    const struct variation_by *by; int directions;
    const expr_id *guess;             /* directions x variables: the derivatives of given values, of parameters alone */
    const int *symbol; const double *value; int values;   /* parameters, and what they are */
    const struct sys_system *sys_at; const struct traj_request *rq_at;   /* at these values; initial: what the start was looked for from */
    const double *x;                  /* the start */
};

/* slope (directions x variables), and by how much it may be off. False: the start is none of the points that such conditions determine, or not well (or err: the store
 * ran out). Expressions go to the store of sys. Cost: the constraints times the directions, and some ten solutions of dense equations for each direction. */
bool variation_least(const struct variation_start *s, double *slope, double *off, struct sga_error *err);

#endif
