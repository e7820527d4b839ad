/* One motion with its derivatives. */
#include "vary_motion.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "vary_copies.h"
#include "vary_modes.h"

void vary_motion_clear(struct vary_motion *v)
{
    traj_result_clear(&v->result);
    free(v->slope_error);
    *v = (struct vary_motion){ 0 };
}

static bool run(struct vary_copies *p, struct traj_result *r, struct sga_error *err)
{
    struct sweep_case *c = p->has_own ? &p->own : &p->c;
    return traj_run(&c->system, &c->solution, &c->request, r, err);
}

/* The motions from the best differences and from ones that are off by what these may be off. */
static bool run_from_differences(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at,
                                 struct vary_copies *p, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    size_t all = (size_t)m->request.system.variables * (size_t)v->directions;
    struct traj_result other = { 0 };
    SGA_ARENA(mem);
    double *slope = sga_zeros(&mem, all + 1, sizeof *slope), *off = sga_zeros(&mem, all + 1, sizeof *off);
    c->request.relations = 0;       /* the start that is placed has met them */
    c->request.low = c->request.high = NULL;
    if (!vary_start_slopes(m, v->by, v->directions, at, slope, off, err))
        return false;
    variation_place_at(v, &c->request, at->x, slope);
    if (!variation_starts_clear(v, &c->system, &c->request, err) || !run(p, &to->result, err))
        return false;
    for (size_t i = 0; i < all; i++)
        slope[i] += off[i];
    variation_place_at(v, &c->request, at->x, slope);
    if (!run(p, &other, err))
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
static bool run_from_solved(struct vary_motion *to, struct variation *v, const struct vary_at *at, struct vary_copies *p, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    bool longer = c->request.arithmetic == TRAJ_AUTO && c->request.exact_time && !p->has_own;
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
    return run(p, &to->result, err);
}

bool vary_motion_run(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at, struct sga_error *err)
{
    struct vary_copies p;
    *to = (struct vary_motion){ 0 };
    bool ok = vary_copies_make(&p, v, &(struct vary_copied){ &m->request, &m->request.system, m->solution, at->rq, at->parameter }, err);
    if (ok) {
        p.c.request.programs = m->programs;
        if (at->modes)
            vary_modes_start(at->modes, at, &p);
        ok = at->rq->relations || at->rq->low || run_from_solved(to, v, at, &p, err);      /* relations move with the parameters: differences */
        if (!to->exact_start)
            ok = run_from_differences(to, m, v, at, &p, err);
    }
    vary_copies_clear(&p);
    if (!ok)
        vary_motion_clear(to);
    return ok;
}
