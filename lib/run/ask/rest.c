/* Whether all equilibria were found: by affine functions, or as many as algebra counts. */
#include "rest_search.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "buf.h"
#include "error.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "warnings.h"

bool rest_certified(const struct equilibrium *p, const struct linearization *l)
{
    bool free = p->by_factors || (l->states == p->states && memcmp(l->state, p->state, (size_t)l->states * sizeof *l->state) == 0);
    return free && p->certified && l->place.basis != LINEAR_NUMERIC;
}

bool rest_has_parts(const struct sga_solution *s)
{
    return s->branches || s->elsewheres || s->specials || s->others || s->sides || s->sides_not_searched || s->not_factored;
}

/* Why all equilibria are known without a search, or NULL. */
static const char *known(const struct rest *r, const struct equilibria *e)
{
    const struct expr_store *st = r->s.rq.sys->store;
    if (rest_has_parts(r->j->solution))
        return NULL;
    for (int k = 0; k < r->base.states; k++)
        if (expr_is_const(st, r->base.rate[k]) && !expr_is_zero(st, r->base.rate[k]))
            return "a rate is a constant that is not 0: there are none";
    if (r->base.motion_constant && e->points == 1 && e->point[0].certified && !e->point[0].degenerate)
        return e->family ? "all functions are affine: the family is an affine space" : "all functions are affine, and their matrix is regular: there is one";
    return NULL;
}

struct equilibria_request rest_request(const struct rest *r, const struct equilibria_algebra *a)
{
    return (struct equilibria_request){ .rq = &r->s.rq, .rate = r->base.rate, .rates = r->base.states, .held = r->held_zero, .helds = r->helds, .near = r->near,
                                        .low = r->ask->low, .high = r->ask->high, .starts = r->ask->starts, .place = a->place, .places = a->places };
}

static bool is_within(const struct rest *r, const double *x)
{
    bool within = true;
    for (int k = 0; k < r->j->request->system.variables; k++)
        within = within && x[k] >= r->ask->low[k] && x[k] <= r->ask->high[k];
    return within;
}

/* How many are proved within no bounds, and how many of these within those asked for: the others count too where all are counted. */
static int certified_anywhere(struct rest *r, const struct equilibria_algebra *a, int *within)
{
    int n = r->j->request->system.variables, count = 0;
    double *low = sga_take(&r->s.mem, ((size_t)n + 1) * sizeof *low), *high = sga_take(&r->s.mem, ((size_t)n + 1) * sizeof *high);
    struct sga_error why = { .code = SGA_E_OK };
    struct equilibria_request q = rest_request(r, a);
    struct equilibria e;
    for (int k = 0; k < n; k++) {
        low[k] = -INFINITY;
        high[k] = INFINITY;
    }
    q.low = low;
    q.high = high;
    bool ok = equilibria_search(&e, &q, &why);
    for (int k = 0; k < e.points && ok; k++) {
        struct linearization l;
        struct linear_guess guess = { .x = e.point[k].x, .zero = e.point[k].zero, .zeros = e.point[k].zeros, .budget = r->j->budget };
        bool proved = e.point[k].kink || (ask_linearize(&r->s, &l, &guess, &why) && rest_certified(e.point + k, &l));
        count += proved;
        *within += proved && is_within(r, e.point[k].x);
        if (!e.point[k].kink)
            linearization_clear(&l);
        why.code = SGA_E_OK;
    }
    equilibria_clear(&e);
    return ok ? count : 0;
}

static bool has_bounds(const struct rest *r)
{
    bool has = false;
    for (int k = 0; k < r->j->request->system.variables; k++)
        has |= isfinite(r->ask->low[k]) || isfinite(r->ask->high[k]);
    return has;
}

/* As many as algebra counts, or fewer. */
static bool counted(struct rest *r, const struct equilibria *e, const struct equilibria_algebra *a, struct sga_buf *why)
{
    int proved = r->certified, within = r->certified;
    assert(proved <= a->real);
    if (proved < a->real && has_bounds(r)) {
        within = 0;
        proved = certified_anywhere(r, a, &within);
    }
    if (!a->real)
        sga_buf_puts(why, "the polynomials have no real zero in common");
    else
        sga_buf_printf(why, "by Hermite's quadratic form the polynomials have %ld real zero%s", a->real, a->real > 1 ? "s" : "");
    bool told = within == r->certified && r->certified == e->points;
    if (proved == a->real && told) {
        if (a->real)
            sga_buf_printf(why, ", and as many equilibria were found and proved%s", r->certified < proved ? ", those outside of the bounds among them" : "");
        return true;
    }
    if (proved == a->on_part && told)
        sga_buf_printf(why, ": the %d on the part of the constraints' zeros that was solved were found and proved; the others lie on other parts, for which see strata", proved);
    else
        sga_buf_printf(why, ", and %d equilibria were found and proved: a search from starts may miss some, and others may lie on parts of the constraints' zeros that were not solved", proved);
    return false;
}

static void warn_of_none(struct rest *r, const struct equilibria *e, bool proved)
{
    const char *where = has_bounds(r) ? "/equilibria/bounds" : "/equilibria";
    if (proved)
        sga_warn(r->j->budget, SGA_W_NO_EQUILIBRIUM, where, "there is no equilibrium%s: free an input in equilibria.free, or hold other values", has_bounds(r) ? " within the bounds" : "");
    else if (e->irregulars)
        sga_warn(r->j->budget, SGA_W_NO_EQUILIBRIUM, where, "no equilibrium was proved; searched.irregular_places lists where the search came to rest: equilibria without a proof, or none. Give a guess in trajectory.initial, or free an input in "
                 "equilibria.free");
    else
        sga_warn(r->j->budget, SGA_W_NO_EQUILIBRIUM, where, "no equilibrium was found from %d starts: give a guess in trajectory.initial, more equilibria.starts%s, or free an input in equilibria.free",
                 e->tried, has_bounds(r) ? ", wider equilibria.bounds" : "");
}

/* Infinitely many: by the families that were found. */
static bool all_families(struct rest *r, const struct equilibria *e, const struct equilibria_algebra *a, struct sga_buf *why)
{
    int families = 0;
    long beside = 0;
    if (e->family || a->status != POLY_MANY || rest_has_parts(r->j->solution) || has_bounds(r) || !rest_families_are_all(r, e, &families, &beside))
        return false;
    sga_buf_printf(why, "by Groebner bases all real zeros of the polynomials are on the %d famil%s of which a point is shown", families, families > 1 ? "ies" : "y");
    if (beside)
        sga_buf_printf(why, ", but for %ld, which were found and proved", beside);
    return true;
}

static bool judge(struct rest *r, const struct equilibria *e, const struct equilibria_algebra *a, struct sga_buf *why)
{
    const char *by = known(r, e);
    if (!by && all_families(r, e, a, why))
        return true;
    if (!by && !e->family && a->status == POLY_COUNTED)
        return counted(r, e, a, why);
    sga_buf_puts(why, by ? by : e->family ? "one point of a family; there may be other families" : a->status == POLY_NOT_COUNTED ? "a search from starts may miss some; to count all by algebra was too much" : "a search from starts may miss some");
    return by != NULL;
}

bool rest_complete(struct rest *r, const struct equilibria *e, const struct equilibria_algebra *a, struct sga_buf *why)
{
    bool all = judge(r, e, a, why);
    if (!e->points)
        warn_of_none(r, e, all);
    return all;
}
