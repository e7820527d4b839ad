/* Where a motion starts: on the constraints, and where the given equations hold. */
#include "flow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "all_given.h"
#include "budget.h"
#include "component_start.h"
#include "consistent.h"
#include "error.h"
#include "field.h"
#include "jacobian.h"
#include "manifold.h"
#include "mem.h"
#include "reduction.h"
#include "redundant.h"
#include "seeds.h"
#include "set_points.h"
#include "sizes.h"
#include "start_parts.h"
#include "system.h"

/* Some point of the set, for a start of last resort: found by a fresh search. */
static double *known_point(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    size_t bytes = (size_t)sys->variables * sizeof(double);
    double *value = set_points_tables(sys, rq->start);
    struct set_points on;
    struct points_point p;
    set_points_init(&on, sys, sol, sol->constraints, 0, 0);
    on.space.near = rq->initial;
    on.space.near_time = rq->start;
    on.space.scale = sol->scale;
    on.space.time_unit = sol->time_unit;
    on.space.budget = rq->budget;
    on.space.parameter_value = value;
    uint64_t random = SGA_SEED_MOTION_START;
    double *x = NULL;
    enum points_status status = points_find_staged(&on.space, on.end, on.stages, 0, &random, 64, &p);
    if (status == POINTS_NONE || status == POINTS_IRREGULAR) {       /* a pole may be between: anywhere */
        points_point_clear(&p);
        on.space.near = NULL;
        status = points_find_staged(&on.space, on.end, on.stages, 1, &random, 64, &p);
    }
    if (status == POINTS_OK)
        x = memcpy(sga_malloc(bytes), p.x, bytes);
    points_point_clear(&p);
    set_points_clear(&on);
    free(value);
    return x;
}

/* The start is on the constraints, whatever error is allowed later: a given equation that is missed by more than the second does not hold there; one
 * that is missed by more than the first may be met nearer (where parts of the set cross, another one is near). */
static const double SHARP = 1e-12, LOOSE = 1e-10;

/* Whether the given equations without derivatives hold at the start. */
static bool holds(struct flow *f, const struct traj_request *rq, const double *x, double none)
{
    double *scale = sga_malloc((size_t)(f->n + 1) * sizeof *scale);
    for (int j = 0; j < f->n; j++)
        scale[j] = none * (f->sizes->weight[j] + fabs(x[j]));
    bool ok = given_hold(f->given, rq->start, x, scale);
    free(scale);
    return ok;
}

/* The consistent start; where the guess leads nowhere, from a point that a search finds. */
static bool on_constraints(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol,
                const struct traj_request *rq, double *x, double *moved, struct sga_error *err)
{
    if (start_parts(f, sys, sol, rq, x, moved) || consistent_start(f->manifold, sys, sol, f->sizes, rq, NULL, x, moved, NULL))
        return true;
    if (!sga_budget_ok(rq->budget, err))
        return false;
    double *elsewhere = known_point(sys, sol, rq);
    bool ok = consistent_start(f->manifold, sys, sol, f->sizes, rq, elsewhere, x, moved, err);
    free(elsewhere);
    return ok;
}

bool flow_start(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol,
                const struct traj_request *rq, double *x, double *moved, struct sga_error *err)
{
    num_jacobian_compile(f->manifold->jac, rq->budget ? rq->budget->exec : NULL);       /* searches evaluate it thousands of times */
    if (!on_constraints(f, sys, sol, rq, x, moved, err))
        return false;
    sizes_met(f->sizes, x);
    f->field->unit = f->sizes->uneven_rows ? f->sizes->row : NULL;
    if (!holds(f, rq, x, SHARP))
        all_given_start(f, sys, sol, rq, x, moved);      /* where that fails, flow_given says so */
    component_start(f, sys, sol, rq, x, moved);
    return true;
}

bool flow_given(struct flow *f, const struct traj_request *rq, const double *x, struct sga_error *err)
{
    char name[40];
    if (holds(f, rq, x, LOOSE))
        return true;
    given_name(f->given, f->given->lost, name, sizeof name);
    return sga_fail_at(err, SGA_E_NO_MOTION, "/trajectory/initial", "at the consistent start the constraints hold, and %s does not, which was found to follow "
                       "from them elsewhere; give trajectory.initial on the part of the constraint set that is meant", name);
}
