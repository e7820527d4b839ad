/* Equilibria that rational arithmetic proved and Newton's method does not tell apart: what the set of equilibria is about each, and one point of each
 * family. */
#include "rest_search.h"

#include <assert.h>
#include <math.h>

#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "system.h"

/* Which of two points is easier to read: the nearer one to 0, then by coordinates. */
static bool is_simpler(const double *x, const double *y, int n)
{
    double a = 0, b = 0;
    for (int k = 0; k < n; k++) {
        a = fmax(a, fabs(x[k]));
        b = fmax(b, fabs(y[k]));
    }
    for (int k = 0; k < n && a == b; k++)
        if (x[k] != y[k])
            return x[k] > y[k];
    return a < b;
}

/* Of points of one family all but the simplest are left out. */
static void leave_out(struct rest *r, const struct equilibria *e, int k)
{
    struct rest_point *to = r->point + k;
    for (int i = 0; i < k; i++) {
        struct rest_point *other = r->point + i;
        if (other->left_out || other->shape.dimension != to->shape.dimension || !equilibrium_shape_has(&other->shape, &to->shape, &to->place))
            continue;
        if (is_simpler(e->point[k].x, e->point[i].x, r->j->request->system.variables))
            other->left_out = true;
        else
            to->left_out = true;
        return;
    }
}

void rest_families(struct rest *r, const struct equilibria *e)
{
    r->point = sga_zeros(&r->s.mem, (size_t)e->points + 1, sizeof *r->point);
    r->points = e->points;
    for (int k = 0; k < e->points && job_goes_on(r->j); k++) {
        if (e->family || !e->point[k].certified || !e->point[k].degenerate)
            continue;
        struct rest_point *p = r->point + k;
        p->placed = true;
        equilibrium_shape_find(&p->shape, &r->s.mem, &r->s.rq, r->held_zero, r->helds, e->point[k].x, &p->place);
        if (p->shape.dimension > 0)
            leave_out(r, e, k);
    }
}

void rest_families_clear(struct rest *r)
{
    for (int k = 0; k < r->points; k++)
        if (r->point[k].placed)
            linear_place_clear(&r->point[k].place);
    r->points = 0;
}

/* Whether a point that is isolated may be a zero of some family's factors, and so is not among those that are counted beside families. */
static bool may_be_on_one(struct rest *r, const struct equilibrium *p, const struct equilibrium_shape *family, int families)
{
    struct linear_guess guess = { .x = p->x, .zero = p->zero, .zeros = p->zeros, .budget = r->j->budget };
    struct linear_place place;
    bool on = !linear_place_find(&place, r->s.rq.sys, r->s.rq.sol, &guess);
    for (int f = 0; f < families && !on; f++)
        on = equilibrium_shape_may_have(family + f, &place);
    linear_place_clear(&place);
    return on;
}

bool rest_families_are_all(struct rest *r, const struct equilibria *e, int *families, long *beside)
{
    int isolated = 0, shown = 0;
    struct equilibrium_shape *family = sga_take(&r->s.mem, ((size_t)e->points + 1) * sizeof *family);
    *families = 0;
    for (int k = 0; k < e->points; k++) {
        const struct rest_point *p = r->point + k;
        shown += !p->left_out;
        if (p->shape.dimension > 0 && !p->left_out)
            family[(*families)++] = p->shape;
    }
    for (int k = 0; k < e->points; k++) {
        const struct rest_point *p = r->point + k;
        if (e->point[k].degenerate && !(p->placed && p->shape.dimension == 0))
            continue;
        if (may_be_on_one(r, e->point + k, family, *families))
            return false;
        isolated++;
    }
    assert(shown <= e->points && r->certified <= shown);
    return *families > 0 && r->certified == shown && equilibria_beside(&r->s.rq, r->held_zero, r->helds, family, *families, beside) == POLY_COUNTED && *beside == isolated;
}
