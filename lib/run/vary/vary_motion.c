/* One motion with its derivatives. */
#include "vary_motion.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "sweep_case.h"

void vary_motion_clear(struct vary_motion *v)
{
    traj_result_clear(&v->result);
    free(v->slope_error);
    *v = (struct vary_motion){ 0 };
}

/* The motions from the best differences and from ones that are off by what these may be off. */
static bool run_from_differences(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at,
                                 struct sweep_case *c, struct sga_error *err)
{
    size_t all = (size_t)m->request.system.variables * (size_t)v->directions;
    struct traj_result other = { 0 };
    SGA_ARENA(mem);
    double *slope = sga_zeros(&mem, all + 1, sizeof *slope), *off = sga_zeros(&mem, all + 1, sizeof *off);
    c->request.relations = 0;       /* the start that is placed has met them */
    c->request.low = c->request.high = NULL;
    if (!vary_start_slopes(m, v->by, v->directions, at, slope, off, err))
        return false;
    variation_place_at(v, &c->request, at->x, slope);
    if (!variation_starts_clear(v, &c->system, &c->request, err) || !traj_run(&c->system, &c->solution, &c->request, &to->result, err))
        return false;
    for (size_t i = 0; i < all; i++)
        slope[i] += off[i];
    variation_place_at(v, &c->request, at->x, slope);
    if (!traj_run(&c->system, &c->solution, &c->request, &other, err))
        return false;
    int columns = to->result.columns;
    to->result.rows = to->result.rows < other.rows ? to->result.rows : other.rows;
    to->slope_error = sga_calloc((size_t)to->result.rows * (size_t)columns + 1, sizeof *to->slope_error);
    /* both start at doubles, whatever they are computed in */
    for (size_t i = 0; i < (size_t)to->result.rows * (size_t)columns; i++)
        to->slope_error[i] = fabs(to->result.value[i] - other.value[i]) + 4 * DBL_EPSILON * fabs(to->result.value[i]);
    traj_result_clear(&other);
    return true;
}

/* From a start that is solved for: where longer numbers may be needed they are tried first. False without to->exact_start: the request is as it was. */
static bool run_from_solved(struct vary_motion *to, struct variation *v, const struct vary_at *at, struct sweep_case *c, struct sga_error *err)
{
    bool longer = c->request.arithmetic == TRAJ_AUTO && c->request.exact_time;
    struct sga_error ignored = { 0 };
    if (!variation_place(v, &c->system, &c->solution, &c->request, at->x))
        return false;
    to->exact_start = true;
    if (longer)
        c->request.arithmetic = TRAJ_DOUBLE_DOUBLE;
    if (!variation_starts_clear(v, &c->system, &c->request, err))
        return false;
    if (longer && traj_run(&c->system, &c->solution, &c->request, &to->result, &ignored))
        return true;
    if (longer) {
        c->request.arithmetic = TRAJ_DOUBLE;
        variation_place(v, &c->system, &c->solution, &c->request, at->x);
    }
    return traj_run(&c->system, &c->solution, &c->request, &to->result, err);
}

bool vary_motion_run(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at, struct sga_error *err)
{
    struct sweep_case c;
    *to = (struct vary_motion){ 0 };
    bool ok = sweep_case_of(&c, &m->request, &v->system, &v->solution, &v->request, at->parameter, err);
    if (ok && !c.solved)
        ok = sga_fail(err, SGA_E_EXPR_UNDEFINED, "the reduction for general values of the parameters has no value at these");
    if (ok) {
        c.request.programs = m->programs;
        ok = at->rq->relations || at->rq->low || run_from_solved(to, v, at, &c, err);      /* relations move with the parameters: differences */
        if (!to->exact_start)
            ok = run_from_differences(to, m, v, at, &c, err);
    }
    sweep_case_clear(&c);
    if (!ok)
        vary_motion_clear(to);
    return ok;
}
