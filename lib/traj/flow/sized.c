/* The solution in double in units of natural sizes (sizes.h), and what their guess missed. */
#include <math.h>
#include <stdlib.h>

#include "budget.h"
#include "flow.h"
#include "mem.h"
#include "ode.h"
#include "sizes.h"

double *traj_column_errors(const double *error, int rows, int columns)
{
    double *most = sga_calloc((size_t)columns + 1, sizeof *most);
    for (int k = 0; k < rows; k++)
        for (int j = 0; j < columns; j++)
            most[j] = fmax(most[j], error[(size_t)k * (size_t)columns + (size_t)j]);
    return most;
}

/* What the natural sizes missed shows in the motion: units shrink, and where it fell short grow, to the sizes that variables and columns
 * had. Whether any did. */
static bool look_at_sizes(struct flow *f, const struct traj_request *rq, const double *start, const struct ode_result *o, bool fell_short)
{
    int n = f->n, columns = f->sizes->columns;
    double *variable = sga_calloc((size_t)n + 2 * (size_t)columns + 1, sizeof *variable), *column = variable + n, *y = column + columns;
    for (int k = -1; k < o->count; k++) {
        const double *x = k < 0 ? start : o->samples + (size_t)k * (size_t)n;
        if (rq->outputs)
            flow_output(f, k < 0 ? rq->start : rq->times[k], x, y);
        for (int j = 0; j < n; j++)
            variable[j] = fmax(variable[j], fabs(x[j]));
        for (int j = 0; j < columns; j++)
            column[j] = fmax(column[j], fabs(rq->outputs ? y[j] : x[j]));
    }
    bool changed = sizes_shrink(f->sizes, variable, column);
    changed |= fell_short && sizes_grow(f->sizes, variable, column);
    free(variable);
    return changed;
}

bool flow_solve(struct flow *f, const struct traj_request *rq, const struct ode_problem *problem, const struct ode_start *start,
                           struct ode_options *options, struct ode_result *o, struct sga_error *err)
{
    struct ode_result again;
    options->time_unit = f->sizes->time;
    options->unit = f->sizes->any ? f->sizes->unit : NULL;
    options->output_unit = f->sizes->any ? f->sizes->column : NULL;
    if (!ode_solve(problem, start, options, o, err))
        return false;
    bool late = options->budget && options->budget->deadline > 0 && sga_now() >= options->budget->deadline;
    bool wrong = o->shortfall || o->end.reason == ODE_NOT_SMOOTH || o->end.reason == ODE_CONSTRAINT_LOST || o->end.reason == ODE_STEP_LIMIT;
    if (!f->sizes->any || late || o->end.reason == ODE_TIME_LIMIT || !look_at_sizes(f, rq, start->x, o, wrong) || !ode_solve(problem, start, options, &again, err))
        return true;
    struct ode_result *other = again.count >= o->count ? o : &again;
    ode_result_free(other);
    if (other == o)
        *o = again;
    return true;
}
