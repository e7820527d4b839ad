/* Inside the ode folder: the Jacobian dX/dx of a problem, as it gives it or by central
 * differences. */
#ifndef SGA_ODE_PARTIALS_H
#define SGA_ODE_PARTIALS_H

#include "method.h"

struct ode_partials {
    const struct ode_problem *p;
    struct lin_sparse *pattern;    /* owned; full where the problem gives none; that of the equations where it gives these */
    int groups, *group;            /* by column: columns of a group share no row */
    int *at, *entry;               /* the pattern by columns: entry[at[j]] .. */
    double *x, *up, *down, *delta, *scale; /* n each */
};

/* known: the pattern, copied; NULL: full. */
void ode_partials_init(struct ode_partials *d, const struct ode_problem *p, const struct lin_sparse *known);
void ode_partials_clear(struct ode_partials *d);

/* value (in the order of d->pattern) at the start of the step. The size of a difference is
 * eps^(1/3) times the larger of |x_j| and ten times its allowed error: larger ones could
 * reach across a singularity. Values have about 10 digits, fewer where x_j is about 0,
 * which slows convergence down and spoils nothing. *cost: in evaluations.
 * False: not all of them are finite. */
bool ode_partials_eval(struct ode_partials *d, struct ode_field *field, const struct ode_step *step,
                       double *value, double *cost);

#endif
