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

/* The copies of a motion at its parameters: of variables and derivatives; and, where events set something, of the variables alone. */
struct copies {
    struct sweep_case c, own;
    struct traj_carried carried;
    bool has_own;
};

static bool copies_make(struct copies *p, struct vary_model *m, const struct variation *v, const struct vary_at *at, struct sga_error *err)
{
    bool ok = sweep_case_of(&p->c, &m->request, &v->system, &v->solution, &v->request, at->parameter, err), solved = ok && p->c.solved;
    p->has_own = ok && v->jumps;
    if (p->has_own) {
        ok = sweep_case_of(&p->own, &m->request, &m->request.system, m->solution, at->rq, at->parameter, err);
        solved &= ok && p->own.solved;
        p->own.request.single = v->request.single;
        p->own.request.budget = v->request.budget;
    }
    return ok && (solved || sga_fail(err, SGA_E_EXPR_UNDEFINED, "the reduction for general values of the parameters has no value at these"));
}

static void copies_clear(struct copies *p)
{
    sweep_case_clear(&p->c);
    if (p->has_own)
        sweep_case_clear(&p->own);
}

static bool run(struct copies *p, struct traj_result *r, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    if (!p->has_own)
        return traj_run(&c->system, &c->solution, &c->request, r, err);
    p->carried = (struct traj_carried){ &c->system, &c->solution, &c->request };
    p->own.request.carried = &p->carried;
    p->own.request.relations = 0;      /* the start that is placed has met them */
    p->own.request.low = p->own.request.high = NULL;
    p->own.request.arithmetic = TRAJ_DOUBLE;
    return traj_run(&p->own.system, &p->own.solution, &p->own.request, r, err);
}

/* The motions from the best differences and from ones that are off by what these may be off. */
static bool run_from_differences(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at,
                                 struct copies *p, struct sga_error *err)
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
static bool run_from_solved(struct vary_motion *to, struct variation *v, const struct vary_at *at, struct copies *p, struct sga_error *err)
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
    struct copies p = { .has_own = false };
    *to = (struct vary_motion){ 0 };
    bool ok = copies_make(&p, m, v, at, err);
    if (ok) {
        p.c.request.programs = m->programs;
        if (v->jumps)
            p.c.request.arithmetic = TRAJ_DOUBLE;
        ok = at->rq->relations || at->rq->low || run_from_solved(to, v, at, &p, err);      /* relations move with the parameters: differences */
        if (!to->exact_start)
            ok = run_from_differences(to, m, v, at, &p, err);
    }
    copies_clear(&p);
    if (!ok)
        vary_motion_clear(to);
    return ok;
}
