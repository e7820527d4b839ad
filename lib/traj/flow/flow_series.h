/* Inside the traj folder: Taylor coefficients along the flow. */
#ifndef SGA_TRAJ_FLOW_SERIES_H
#define SGA_TRAJ_FLOW_SERIES_H

#include "jet.h"

struct field;

struct series {
    struct num_jet *jet;
    int order;
    struct sga_exec *memory;      /* for machine code, borrowed; NULL: none */
    struct num_jet_programs *programs;   /* of motions before, borrowed; or NULL */
};

/* As ode_problem.taylor. field_slope_init has been called. */
bool series_along(struct series *s, struct field *f, double t, const double *x, int order, double scale, double *out, double *reach);
/* Series of this field are short programs: faster than steps of Runge-Kutta from 7 or 8 digits on, measured over the references. */
bool series_fast(const struct field *f);
void series_clear(struct series *s);

#endif
