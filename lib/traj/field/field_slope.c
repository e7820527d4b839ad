/* The Jacobian of the reduced field from its expressions: sparse, exact to rounding. Linear
 * solves inside the expressions are differentiated through their factors (num/jacobian).
 * Where the field is solved from its defining rows there is none here, and the integrator
 * takes differences along the constraint set. */
#include "field.h"

#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "lin_sparse.h"
#include "mem.h"
#include "system.h"
#include "tape.h"

bool field_slope_init(struct field *f, struct sga_error *err)
{
    if (!f->fast || f->slope)
        return true;
    int n = f->n, *inputs = field_inputs(f->sys), *columns = sga_malloc(((size_t)n + 1) * sizeof *columns);
    for (int j = 0; j < n; j++)
        columns[j] = j;
    f->plain = num_tape_new_switched(f->sys->store, field_switches(f), f->root, n, inputs, n + 1, err);
    if (f->plain)
        f->slope = num_jacobian_new(f->plain, columns, n);
    free(inputs);
    free(columns);
    if (!f->slope)
        return false;
    f->pattern = lin_sparse_new(n, n, f->slope->start, f->slope->col);
    return true;
}

bool field_expressions_hold(struct field *f, double t, const double *x)
{
    memcpy(f->in, x, (size_t)f->n * sizeof *x);
    f->in[f->n] = t;
    return f->fast && num_tape_eval(f->direct, f->in, f->direct_out) && field_pivots_well(f);
}

bool field_slope(struct field *f, double t, const double *x, double *value)
{
    if (!field_expressions_hold(f, t, x))
        return false;
    return num_jacobian_eval(f->slope, f->in, NULL, value);
}
