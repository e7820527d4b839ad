/* One motion with its derivatives. */
#include "vary_motion.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "defined.h"
#include "error.h"
#include "mem.h"
#include "vary_copies.h"
#include "vary_modes.h"
#include "vary_slides.h"

/* How large a change of derivatives is told from the roundings of a motion, beside their size; and how much more than one choice of signs other ones may come to. */
static const double SEEN = 1e-3, SIGNS = 2;
/* Derivatives of the start: beside the largest of its numbers those that may be roundings, and beside their sizes those that are. */
static const double SUSPECT = 1e-13, ROUNDED = 1e-14;

void vary_motion_clear(struct vary_motion *v)
{
    traj_result_clear(&v->result);
    free(v->slope_error);
    *v = (struct vary_motion){ 0 };
}

/* What makes motions: copies at numbers, what they are of, and where from. */
struct maker {
    struct vary_copies *p;
    struct vary_model *m;
    const struct variation *v;
    const struct vary_at *at;
};

/* Derivatives at the start that are roundings of 0 beside their natural sizes tell none: into `initial` (all variables) with zeros for them. False: there are none,
 * or rq is a motion that carries its derivatives (struct vary_copies), and has none of them itself. */
static bool without_roundings(const struct maker *w, const struct traj_request *rq, struct sga_arena *mem, double *initial)
{
    const struct variation *v = w->v;
    size_t n = (size_t)v->n, all = n * (size_t)(1 + v->directions), whole = (size_t)w->m->request.system.variables;
    struct sga_error ignored = { 0 };
    double most = 0;
    bool any = false;
    if (w->p->has_own)
        return false;
    assert(all <= (size_t)w->p->c.system.variables);
    for (size_t i = 0; i < all; i++)
        most = fmax(most, fabs(rq->initial[i]));
    for (size_t i = n; i < all; i++)
        any |= rq->initial[i] != 0 && fabs(rq->initial[i]) < SUSPECT * most;
    double *unit = any ? sga_zeros(mem, (size_t)v->directions * whole + 1, sizeof *unit) : NULL;
    if (!any || !vary_slope_units(w->m, v->by, v->directions, w->at, unit, &ignored))
        return false;
    memcpy(initial, rq->initial, (size_t)w->p->c.system.variables * sizeof *initial);
    any = false;
    for (size_t i = n; i < all; i++) {
        size_t j = v->of_defined ? (size_t)v->defined->variable[i % n] : i % n;
        if (initial[i] != 0 && fabs(initial[i]) < ROUNDED * unit[(i / n - 1) * whole + j]) {
            initial[i] = 0;
            any = true;
        }
    }
    return any;
}

static bool run(const struct maker *w, struct traj_result *r, struct sga_error *err)
{
    struct sweep_case *c = w->p->has_own ? &w->p->own : &w->p->c;
    const struct traj_request *by = c->request.sized_by;
    SGA_ARENA(mem);
    struct traj_request plain = by ? *by : c->request;
    double *initial = sga_zeros(&mem, (size_t)c->system.variables + 1, sizeof *initial);
    if (c->request.arithmetic != TRAJ_BALL && without_roundings(w, &plain, &mem, initial)) {
        plain.initial = initial;
        plain.sized_by = NULL;
        c->request.sized_by = &plain;
    }
    bool ok = traj_run(&c->system, &c->solution, &c->request, r, err);
    c->request.sized_by = by;
    return ok;
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
    traj_take_end(r, other);
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
    const struct maker w = { p, m, v, at };
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
        return run(&w, &to->result, err);
    c->request.relations = relations;
    struct enclosed_found *found = variation_found(v, &c->system, &c->solution, &c->request, at->rq->low, at->rq->high);
    c->request.relations = 0;
    c->request.found = found;
    bool ok = run(&w, &to->result, err);
    c->request.found = NULL;
    variation_found_free(found);
    return ok;
}

/* From a start with these slopes. The motion's own start is on its constraints: it stays, and the slopes give way alone, where they can; otherwise all of it moves. */
static bool run_at(const struct maker *w, struct variation *v, const double *slope, struct traj_result *r, struct sga_error *err)
{
    struct traj_request *rq = &w->p->c.request;
    struct sga_error ignored = { 0 };
    variation_place_at(v, rq, w->at->x, slope);
    if (!variation_starts_clear(v, &w->p->c.system, rq, err))
        return false;
    if (rq->held == v->held) {
        memset(v->held, 1, (size_t)v->n);
        bool ok = run(w, r, &ignored);
        memset(v->held, 0, (size_t)v->n);
        if (ok)
            return true;
    }
    return run(w, r, err);
}

/* The motions from the best slopes and from ones that are off by what these may be off. */
static bool run_from_slopes(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at,
                            struct vary_copies *p, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    const struct maker w = { p, m, v, at };
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
        return variation_starts_clear(v, &c->system, &c->request, err) && run(&w, &to->result, err);
    if (err->code != SGA_E_OK)
        return false;
    if (!run_at(&w, v, slope, &to->result, err))
        return false;
    struct traj_request first = c->request;       /* sizes are those of the first motion */
    size_t all = (size_t)c->system.variables;
    first.initial = memcpy(sga_take(&mem, (all + 1) * sizeof *first.initial), first.initial, all * sizeof *first.initial);
    magnify(off, slope, v->directions, n, times);
    for (size_t i = 0; i < n * q; i++)
        slope[i] += times[i / n] * off[i];
    c->request.sized_by = &first;
    bool ok = run_at(&w, v, slope, &other, err);
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
static bool run_from_solved(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at, struct vary_copies *p, bool *placed, struct sga_error *err)
{
    struct sweep_case *c = &p->c;
    const struct maker w = { p, m, v, at };
    bool longer = c->request.arithmetic == TRAJ_AUTO && c->request.exact_time && !p->has_own;
    struct sga_error ignored = { 0 };
    if (!variation_place(v, &c->system, &c->solution, &c->request, at->x))
        return false;
    *placed = to->exact_start = true;
    if (longer)
        c->request.arithmetic = TRAJ_DOUBLE_DOUBLE;
    if (!variation_starts_clear(v, &c->system, &c->request, err))
        return false;
    if (longer && run(&w, &to->result, &ignored))
        return true;
    if (longer) {
        c->request.arithmetic = TRAJ_DOUBLE;
        variation_place(v, &c->system, &c->solution, &c->request, at->x);
    }
    if (run(&w, &to->result, err))
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
        ok = at->rq->relations || at->rq->low || run_from_solved(to, m, v, at, &p, &placed, err);      /* relations move with the parameters */
        if (!placed)
            ok = run_from_slopes(to, m, v, at, &p, err);
    }
    vary_copies_clear(&p);
    if (!ok)
        vary_motion_clear(to);
    return ok;
}
