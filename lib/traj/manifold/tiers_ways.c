/* Where the search for a start in tiers begins, and how it comes to the set from there: see tiers_search.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "jacobian.h"
#include "manifold.h"
#include "mem.h"
#include "points_random.h"
#include "tiers_search.h"
#include "watch.h"

/* In units: farther than what one begins around. */
static const double FAR = 2;
/* Steps of a walk, in units. */
static const double SHORT = 0.2;

/* Operations after which a point that was found is enough: what takes a second, whatever the machine. */
static const double ENOUGH = 3e8;

/* The same of places to look for a nearer one at. */
static const double ENOUGH_AROUND = 3e7;
/* In units: not far. */
static const double NEAR = 0.5;

enum { IDLE = 16, IDLE_NONE = 48, LATER = 100, SETTLE = 60, WALK = 200, FEW = 6, ROUNDS = 3, LOOSER = 3, STARTS = 8, MORE_STARTS = 16 };

/* The k-th place to begin at: the guess, to both sides of it in every variable that was not given, some by names, farther where
 * given values move too; the guess again, for a walk; and with what equations say. wide: how far given values move, as far as it is known. */
static void begin(const struct tiers_search *s, int k, double wide, double *y)
{
    if (k == s->starts)
        memcpy(y, s->filled, (size_t)s->t.n * sizeof *y);
    for (int j = 0; j < s->t.n && k < s->starts; j++) {
        double shift = k == 0 || k == s->starts - 1 ? 0 : k == 1 ? 1 : k == 2 ? -1 : points_scatter(s->name[j], k);
        double reach = !s->rq->given[j] ? 1 : k < FEW ? 0 : wide;
        y[j] = s->rq->initial[j] + (s->tier[j] >= 0 ? shift * reach * s->unit[j] : 0);
    }
}

/* Further ways may be tried. */
static bool goes_on(const struct tiers_search *s, const struct tiers_found *best)
{
    return sga_watch_ok() && !(best->any && s->t.effort > ENOUGH);
}

/* Whether the new one is taken. */
static bool keep(const struct tiers_search *s, struct tiers_found *best, const struct tiers_found *new)
{
    if (best->any && tiers_compare(s, best, new) <= 0)
        return false;
    tiers_found_copy(s, best, new);
    best->any = true;
    return true;
}

/* To the set from y. cheap: by how much more easily values move that were not given. */
static bool reach(struct tiers_search *s, double *y, double cheap, double longest, int steps, bool *easy)
{
    s->edges = 0;
    tiers_stay(s);
    for (int j = 0; j < s->t.n; j++)
        s->loose[j] = s->unit[j] * (s->rq->given[j] ? 1 : cheap);
    s->t.unit = s->stage >= TIERS_MOVE_ALL ? s->loose : s->unit;
    bool ok = tangent_settle(&s->t, s->rq->start, y, longest, steps, easy);
    s->t.unit = s->unit;
    /* residuals were seen in the units of the moves: once more in plain ones */
    return ok && (s->stage < TIERS_MOVE_ALL || tangent_settle(&s->t, s->rq->start, y, INFINITY, SETTLE, NULL));
}

/* The constraints are affine in what moves, as far as a second point shows. */
static bool affine(struct tiers_search *s, const double *x)
{
    struct manifold *m = s->t.m;
    size_t n = (size_t)s->t.n, entries = (size_t)m->jac->nnz;
    double *slope = sga_malloc((n + entries + 1) * sizeof *slope), *y = slope + entries;
    bool same = manifold_residual(m, s->rq->start, x, s->unit, NULL) >= 0;
    memcpy(slope, m->value, entries * sizeof *slope);
    for (size_t j = 0; j < n; j++)
        y[j] = x[j] + (s->tier[j] < 0 ? 0 : points_scatter(s->name[j], 0) * s->unit[j]);
    same = same && manifold_residual(m, s->rq->start, y, s->unit, NULL) >= 0;
    for (size_t k = 0; k < entries && same; k++)
        same = s->tier[m->jac->col[k]] < 0 || fabs(m->value[k] - slope[k]) <= ALIKE * fabs(slope[k]);
    free(slope);
    return same;
}

/* No other point can be nearer, or be meant: what is left to move does so on a plane, or nothing is and it was near. */
static bool alone(struct tiers_search *s, const double *x, bool easy)
{
    tiers_stay(s);
    return easy && ((tangent_at(&s->t, s->rq->start, x) >= 0 && s->t.columns == s->t.rank) || affine(s, x));
}

/* What is far from its guess (an angle after some turns) may be near it while all else stays: begin there, one after the other. */
static void retreat(struct tiers_search *s, struct tiers_found *best, struct tiers_found *new)
{
    bool better = true;
    for (int round = 0; round < ROUNDS && better; round++) {
        better = false;
        for (int i = 0; i < s->t.n && goes_on(s, best); i++) {
            int j = s->by_name[i];
            if (s->tier[j] < 0 || fabs(best->x[j] - s->rq->initial[j]) < FAR * s->unit[j])
                continue;
            memcpy(new->x, best->x, (size_t)s->t.n * sizeof *new->x);
            new->x[j] = s->rq->initial[j];
            if (reach(s, new->x, LOOSE, INFINITY, SETTLE, NULL)) {
                tiers_complete(s, new);
                better |= keep(s, best, new);
            }
        }
    }
}

/* From the guess with ever more of the way left to what was not given: where a small change of a given value does what only
 * a large one of another does (a stiff spring, a force of constraint in newton). */
static void loosen(struct tiers_search *s, struct tiers_found *best, struct tiers_found *new)
{
    double cheap = LOOSE;
    for (int k = 0; k < LOOSER && goes_on(s, best); k++) {
        cheap *= LOOSE;
        memcpy(new->x, s->rq->initial, (size_t)s->t.n * sizeof *new->x);
        if (reach(s, new->x, cheap, INFINITY, SETTLE, NULL)) {
            tiers_complete(s, new);
            keep(s, best, new);
        }
    }
}

/* The first tier whose values are not near their guess, of those that say where all others are (velocities and what follows are mostly solved for); -1: none. */
static int far_tier(const struct tiers_found *f)
{
    int k = 0;
    while (k <= TIERS_PLACES && f->score[k] <= NEAR * NEAR)
        k++;
    return k <= TIERS_PLACES ? k : -1;
}

/* No point was found, or the nearest one is not near, or no way led to the set from the guess itself (direct), as where all slopes are 0 there: others
 * may be nearer, which ways from far and wide have missed. From places around the guess, ever farther from it where there is none, else nearer to it
 * than that point, until a number of them find no nearer one. */
static void look_around(struct tiers_search *s, struct tiers_found *best, struct tiers_found *new, bool direct)
{
    static const double part[] = { 0.25, 0.0625, 0.125, 0.5 };
    double before = s->t.effort;
    for (int k = 0, idle = 0; idle < (best->any ? IDLE : IDLE_NONE) && s->t.effort - before < ENOUGH_AROUND && goes_on(s, best); k++) {
        int tier = best->any ? far_tier(best) : 0;
        if (tier < 0 && direct)
            return;
        double radius = best->any ? sqrt(best->score[tier < 0 ? 0 : tier]) * part[k % 4] : ldexp(0.5, k / 8);
        bool walk = k % 2;
        for (int j = 0; j < s->t.n; j++)
            new->x[j] = s->rq->initial[j] + (s->tier[j] >= (tier < 0 ? 0 : tier) ? points_scatter(s->name[j], LATER + k) * radius * s->unit[j] : 0);
        idle++;
        if (reach(s, new->x, walk ? 1 : LOOSE, walk ? SHORT * fmax(1, radius) : INFINITY, walk ? WALK : SETTLE, NULL)) {
            tiers_complete(s, new);
            if (keep(s, best, new))
                idle = 0;
        }
    }
}

/* From the guess and from places around it. */
void tiers_from_guess(struct tiers_search *s, struct tiers_found *best, struct tiers_found *new)
{
    bool only = false, direct = false, easy = false;
    s->starts = s->stage >= TIERS_MOVE_ALL ? MORE_STARTS : STARTS;
    for (int k = 0; k <= s->starts && !only && goes_on(s, best); k++) {
        bool walk = k == s->starts - 1;
        begin(s, k, best->any ? fmax(1, sqrt(best->score[0])) : 1, new->x);
        if (!reach(s, new->x, LOOSE, walk ? SHORT : INFINITY, walk ? WALK : SETTLE, &easy))
            continue;
        direct |= k == 0;
        only = k == 0 && alone(s, new->x, easy);
        tiers_complete(s, new);
        keep(s, best, new);
    }
    if (s->stage >= TIERS_MOVE_ALL)
        loosen(s, best, new);
    if (!only)
        look_around(s, best, new, direct);
    if (!only && best->any)
        retreat(s, best, new);
}

/* From a point of the set, and from places on the way to it. */
void tiers_from_elsewhere(struct tiers_search *s, struct tiers_found *best, struct tiers_found *new)
{
    static const double way[] = { 0.5, 0.9, 1 };
    for (int k = 0; k < 3 && sga_watch_ok(); k++) {
        for (int j = 0; j < s->t.n; j++)
            new->x[j] = s->tier[j] < 0 ? s->rq->initial[j] : (1 - way[k]) * s->rq->initial[j] + way[k] * s->elsewhere[j];
        if (!reach(s, new->x, LOOSE, INFINITY, WALK, NULL))
            continue;
        tiers_complete(s, new);
        keep(s, best, new);
    }
}
