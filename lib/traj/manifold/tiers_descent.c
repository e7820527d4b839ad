/* From a point of the set to the nearest one, tier by tier: see tiers_search.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "larger.h"
#include "manifold.h"
#include "mem.h"
#include "nearest.h"
#include "normal.h"
#include "tiers_search.h"

/* Values of points as near as each other, where they are one point. */
static const double SAME = 1e-7;
/* A variable stays along a direction whose component there is smaller. */
static const double STAYS = 1e-6;
/* Pivots below this are those of a double zero. */
static const double EDGE = 1e-4;

void tiers_stay(struct tiers_search *s)
{
    for (int j = 0; j < s->t.n; j++)
        s->t.fixed[j] = s->tier[j] < 0;
    s->t.bars = s->edges;
    tangent_fix(&s->t);
}

/* Whether a value was given, and may be another one for what edge_on tries. */
static bool kept(const struct tiers_search *s, int j)
{
    return s->rq->given[j] && s->tier[j] < 0 && !(s->rq->held && s->rq->held[j]);
}

/* From guess, whose kept values were moved off the set: the point x again, if what it keeps comes back to where it was. */
static bool come_back(struct tiers_search *s, const double *guess, double *x)
{
    struct nearest q = { &s->t, s->rq->start, guess, s->weight, s->by_name };
    size_t n = (size_t)s->t.n;
    double *y = memcpy(sga_malloc((n + 1) * sizeof *y), x, n * sizeof *x);
    bool back;
    nearest_descend(&q, y);
    back = nearest_least(&q, y);
    for (size_t j = 0; j < n; j++) {
        back &= s->weight[j] == 0 || fabs(y[j] - x[j]) <= ALIKE * s->unit[j];
        y[j] = s->weight[j] > 0 ? x[j] : y[j];
    }
    double before = manifold_residual(s->t.m, s->rq->start, x, s->unit, NULL), after = manifold_residual(s->t.m, s->rq->start, y, s->unit, NULL);
    back = back && after >= 0 && after <= fmax(before, ROUNDED / 10);      /* values of two points are one only as far as they are the same */
    if (back) {
        memcpy(x, y, n * sizeof *x);
        s->t.bars = 0;
        nearest_bar(&q, x, true);
        s->edges = s->t.bars;
    }
    free(y);
    return back;
}

/* Where the set is seen edge-on from the values that are kept (x = 1 on a circle), the others are a double zero, found to half
 * of the digits. They are where it turns back: nearest to values a little off the set. */
static void edge_on(struct tiers_search *s, double *x)
{
    struct tangent *t = &s->t;
    struct manifold *m = t->m;
    int n = t->n;
    tiers_stay(s);
    if (tangent_at(t, s->rq->start, x) < 0 || t->least > EDGE || !(t->rank > 0))
        return;
    double *y = sga_calloc((size_t)(m->c + 2 * n) + 1, sizeof *y), *off = y + m->c, *guess = off + n, size = 0;
    tangent_weakest(t, y);
    for (int i = 0; i < m->c; i++)
        for (int k = 0; k < m->cols[i]; k++)
            off[m->col[i][k]] += kept(s, m->col[i][k]) ? y[i] * m->step->value[i][k] : 0;
    for (int j = 0; j < n; j++) {
        s->weight[j] = kept(s, j);
        t->fixed[j] = s->tier[j] < 0 && !kept(s, j);
        size += off[j] * off[j];
    }
    tangent_fix(t);
    for (int sign = -1; sign <= 1 && size > 0; sign += 2) {
        for (int j = 0; j < n; j++)
            guess[j] = x[j] + sign * off[j] / sqrt(size) * s->unit[j];
        if (come_back(s, guess, x))
            break;
    }
    free(y);
}

/* What the tiers so far decide stays from now on: variables where no direction that is left moves them; and directions that
 * only the second derivative tells (the set is seen edge-on from the guess). all: the tier's variables stay in any case. */
static void fix_tier(struct tiers_search *s, const struct nearest *q, int tier, bool all, const double *x)
{
    struct tangent *t = &s->t;
    nearest_bar(q, x, false);
    if (tangent_at(t, q->time, x) < 0)
        return;
    tangent_basis(t);
    int dim = t->dim, bars = t->bars;
    for (int j = 0; j < t->n; j++) {
        double most = 0;
        for (int k = 0; k < dim; k++)
            most = sga_larger(most, fabs(t->basis[(size_t)k * (size_t)t->n + (size_t)j]));
        if (s->tier[j] == tier && (all || most < STAYS))
            t->fixed[j] = 1;
    }
    tangent_fix(t);
    t->bars = 0;
    tangent_at(t, q->time, x);
    if (t->columns - t->rank > dim)
        t->bars = bars;
}

/* Of squares of distances. */
static bool farther(double a, double b)
{
    return sqrt(a) > sqrt(b) + ALIKE * (1 + sqrt(b));
}

static bool weigh(struct tiers_search *s, int tier, double later)
{
    bool any = false;
    for (int j = 0; j < s->t.n; j++) {
        any |= s->tier[j] == tier;
        s->weight[j] = s->tier[j] == tier ? 1 : s->tier[j] > tier ? later : 0;
    }
    return any;
}

/* From a point of the set to the nearest one, tier by tier. False: where a tier left its own variables a way to move, a later
 * one spoilt it (a guess in the middle of a circle, and of a second one around it). */
static bool descend(struct tiers_search *s, struct tiers_found *f, bool all)
{
    struct nearest q = { &s->t, s->rq->start, s->rq->initial, s->weight, s->by_name };
    double reached[TIERS];
    bool left = true, kept = true;
    tiers_stay(s);
    f->ends = TIERS;
    for (int tier = 0; tier < TIERS; tier++) {
        reached[tier] = INFINITY;
        if (!left || f->ends < TIERS || !weigh(s, tier, s->dear ? 1 / (LOOSE * LOOSE) : 0))
            continue;
        left = tangent_at(&s->t, s->rq->start, f->x) >= 0 && s->t.columns > s->t.rank;
        if (left) {
            f->ends = nearest_descend(&q, f->x) ? TIERS : tier;
            fix_tier(s, &q, tier, all || s->dear, f->x);
            weigh(s, tier, 0);
            reached[tier] = nearest_sum(&q, f->x);
        }
    }
    for (int tier = 0; tier < TIERS; tier++) {
        f->score[tier] = weigh(s, tier, 0) ? nearest_sum(&q, f->x) : 0;
        kept &= !farther(f->score[tier], reached[tier]);
    }
    return kept;
}

void tiers_complete(struct tiers_search *s, struct tiers_found *f)
{
    size_t n = (size_t)s->t.n;
    double *from = sga_malloc((n + 1) * sizeof *from);
    s->edges = 0;
    edge_on(s, f->x);
    memcpy(from, f->x, n * sizeof *from);
    if (!descend(s, f, false)) {
        memcpy(f->x, from, n * sizeof *from);
        descend(s, f, true);
    }
    free(from);
}

int tiers_compare(const struct tiers_search *s, const struct tiers_found *a, const struct tiers_found *b)
{
    int both = a->ends < b->ends ? a->ends : b->ends;
    for (int k = 0; k < TIERS; k++) {
        if (k == both && a->ends != b->ends)
            return a->ends > b->ends ? -1 : 1;
        if (farther(a->score[k], b->score[k]) || farther(b->score[k], a->score[k]))
            return a->score[k] < b->score[k] ? -1 : 1;
    }
    for (int k = 0; k < TIERS; k++)
        for (int i = 0; i < s->t.n; i++) {
            int j = s->by_name[i];
            double apart = a->x[j] - b->x[j];
            if (s->tier[j] == k && fabs(apart) > SAME * (s->unit[j] + fabs(a->x[j])))
                return apart > 0 ? -1 : 1;
        }
    return 0;
}

void tiers_found_copy(const struct tiers_search *s, struct tiers_found *to, const struct tiers_found *from)
{
    memcpy(to->x, from->x, (size_t)s->t.n * sizeof *from->x);
    memcpy(to->score, from->score, sizeof from->score);
    to->any = from->any;
    to->ends = from->ends;
}
