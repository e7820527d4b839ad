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
#include "vary_slides.h"

/* How large a change of derivatives is told from the roundings of a motion, beside their size; and how much more than one choice of signs other ones may come to. */
static const double SEEN = 1e-3, SIGNS = 2;

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

/* By direction how many times `off` is added to its slopes: derivatives follow linear equations, so that what becomes of a large change tells what becomes of a small one, of which
 * the steps of two motions would tell nothing. off gets signs of its own. */
static void magnify(double *off, const double *slope, int directions, size_t n, double *times)
{
    for (int d = 0; d < directions; d++) {
        double most = 0, size = 0;
        for (size_t j = 0; j < n; j++) {
            double *o = off + (size_t)d * n + j;
            most = fmax(most, *o);
            size = fmax(size, fabs(slope[(size_t)d * n + j]));
            *o *= j * 2654435761u >> 7 & 1 ? -1 : 1;
        }
        times[d] = most > 0 ? fmax(1, SEEN * fmax(size, 1) / most) : 1;
    }
}

/* Rows of both; where the other one ended before, so does this. */
static void keep_common(struct traj_result *r, const struct traj_result *other)
{
    if (other->rows >= r->rows)
        return;
    r->rows = other->rows;
    r->ended = other->ended;
    r->ended_t = other->ended_t;
    r->ended_reason = other->ended_reason;
    memcpy(r->ended_detail, other->ended_detail, sizeof r->ended_detail);
}

/* In double-double: the start near these slopes, to its digits. False: it is not told so well, or err. */
static bool with_all_digits(const struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at, struct sweep_case *c, const double *slope, expr_id *exact,
                            struct sga_error *err)
{
    SGA_ARENA(mem);
    if (c->request.arithmetic != TRAJ_DOUBLE_DOUBLE || !to->exact_start || at->rq->relations || at->rq->low)
        return false;
    double *unit = sga_zeros(&mem, (size_t)m->request.system.variables + 1, sizeof *unit);
    bool ok = vary_start_units(m, at, unit, err) && variation_place_nearest(v, &c->request, at->x, slope, unit) && variation_digits(v, &c->system, &c->solution, &c->request, exact);
    c->request.asked = NULL;
    return ok;
}

/* From the nearest point, of relations and bounds of the start too. */
static bool run_in_balls(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at, struct vary_copies *p, const double *slope, int relations, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    SGA_ARENA(mem);
    double *unit = sga_zeros(&mem, (size_t)m->request.system.variables + 1, sizeof *unit);
    bool searched = at->rq->relations || at->rq->low;
    if (!to->exact_start || (searched && v->of_defined) || !vary_start_units(m, at, unit, err) || !variation_place_nearest(v, &c->request, at->x, slope, unit))
        return err->code != SGA_E_OK ? false : sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/initial", "the derivatives of this start are not enclosed in balls; give initial values that satisfy the "
                                                           "constraints, or use \"double\"");
    to->exact_start = true;
    if (!variation_starts_clear(v, &c->system, &c->request, err))
        return false;
    if (!searched)
        return run(p, &to->result, err);
    c->request.relations = relations;
    struct enclosed_found *found = variation_found(v, &c->system, &c->solution, &c->request, at->rq->low, at->rq->high);
    c->request.relations = 0;
    c->request.found = found;
    bool ok = run(p, &to->result, err);
    c->request.found = NULL;
    variation_found_free(found);
    return ok;
}

/* The motions from the best slopes and from ones that are off by what these may be off. */
static bool run_from_slopes(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at,
                            struct vary_copies *p, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    size_t n = (size_t)m->request.system.variables, q = (size_t)v->directions;
    struct traj_result other = { 0 };
    SGA_ARENA(mem);
    double *slope = sga_zeros(&mem, n * q + 1, sizeof *slope), *off = sga_zeros(&mem, n * q + 1, sizeof *off), *times = sga_zeros(&mem, q + 1, sizeof *times);
    int relations = c->request.relations;
    c->request.relations = 0;       /* the start that is placed has met them */
    c->request.low = c->request.high = NULL;
    if (!vary_start_slopes(m, v->by, v->directions, at, slope, off, &to->exact_start, err))
        return false;
    if (c->request.arithmetic == TRAJ_BALL)
        return run_in_balls(to, m, v, at, p, slope, relations, err);
    expr_id *exact = sga_zeros(&mem, (size_t)c->system.variables + 1, sizeof *exact);
    if (with_all_digits(to, m, v, at, c, slope, exact, err))
        return variation_starts_clear(v, &c->system, &c->request, err) && run(p, &to->result, err);
    if (err->code != SGA_E_OK)
        return false;
    variation_place_at(v, &c->request, at->x, slope);
    if (!variation_starts_clear(v, &c->system, &c->request, err) || !run(p, &to->result, err))
        return false;
    struct traj_request first = c->request;       /* sizes are those of the first motion */
    size_t all = (size_t)c->system.variables;
    first.initial = memcpy(sga_take(&mem, (all + 1) * sizeof *first.initial), first.initial, all * sizeof *first.initial);
    magnify(off, slope, v->directions, n, times);
    for (size_t i = 0; i < n * q; i++)
        slope[i] += times[i / n] * off[i];
    variation_place_at(v, &c->request, at->x, slope);
    c->request.sized_by = &first;
    bool ok = run(p, &other, err);
    c->request.sized_by = NULL;
    if (!ok)
        return false;
    size_t columns = (size_t)to->result.columns;
    keep_common(&to->result, &other);
    to->slope_error = sga_calloc((size_t)to->result.rows * columns + 1, sizeof *to->slope_error);
    /* both start at doubles, whatever they are computed in */
    for (size_t i = 0; i < (size_t)to->result.rows * columns; i++) {
        double apart = fabs(to->result.value[i] - other.value[i]), by = i % columns < q * (size_t)v->outputs ? times[i % columns % q] : 1;
        to->slope_error[i] = SIGNS * apart / by + 4 * DBL_EPSILON * fabs(to->result.value[i]);
    }
    traj_result_clear(&other);
    return true;
}

/* From a start that is solved for: where longer numbers may be needed they are tried first. False without *placed: the request is as it was. */
static bool run_from_solved(struct vary_motion *to, struct variation *v, const struct vary_at *at, struct vary_copies *p, bool *placed, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    bool longer = c->request.arithmetic == TRAJ_AUTO && c->request.exact_time && !p->has_own;
    struct sga_error ignored = { 0 };
    if (!variation_place(v, &c->system, &c->solution, &c->request, at->x))
        return false;
    *placed = to->exact_start = true;
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
    if (run(p, &to->result, err))
        return true;
    /* longer numbers have all digits of values that are given, which may be off the constraints by what doubles do not tell, and more of them than the constraints leave */
    bool off = (c->request.arithmetic == TRAJ_BALL && err->code == SGA_E_INITIAL)
               || (c->request.arithmetic == TRAJ_DOUBLE_DOUBLE && err->code == SGA_E_NOT_SUPPORTED && !strcmp(err->pointer, "/trajectory/initial"));
    *placed = !off;
    *err = *placed ? *err : (struct sga_error){ 0 };
    return false;
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
        if (at->slides)
            vary_slides_start(at->slides, at, &p);
        bool placed = false;
        ok = at->rq->relations || at->rq->low || run_from_solved(to, v, at, &p, &placed, err);      /* relations move with the parameters */
        if (!placed)
            ok = run_from_slopes(to, m, v, at, &p, err);
    }
    vary_copies_clear(&p);
    if (!ok)
        vary_motion_clear(to);
    return ok;
}
