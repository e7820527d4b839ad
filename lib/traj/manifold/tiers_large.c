/* A start in tiers for large systems: the aims of tiers.h with sparse steps. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kinds.h"
#include "mem.h"
#include "points_random.h"
#include "sizes.h"
#include "sparse_step.h"
#include "system.h"
#include "tiers.h"
#include "watch.h"

/* While a tier is brought near its guess, later ones move this much more easily, and from where they are: in the end they cost nothing. */
static const double EASIER = 1e-3;
/* Points as near as each other. */
static const double ALIKE = 1e-9;
/* A step so short, in units, is the last one; and what is shorter than this cannot tell any more whether the sum is lower. */
static const double LAST = 1e-10, SHORT = 1e-6;

enum { SETTLE = 60, STEPS = 100, HALVES = 10, STARTS = 5, POLISH = 6 };

struct large {
    const struct traj_request *rq;
    struct sparse_step step;
    double *unit, *weight, *to, *d, *y;
    unsigned char *kind;
    signed char *tier;
    const char **name;
    enum tiers_stage stage, found_in;
};

struct found {
    double *x, score[TIERS];
    bool any;
    int ends;                /* tiers before the first without a nearest point; TIERS: each had one */
};

static double part(const struct large *s, const double *x, int j)
{
    return (x[j] - s->rq->initial[j]) / s->unit[j];
}

static double sum_of(const struct large *s, int tier, const double *x)
{
    double sum = 0;
    for (int j = 0; j < s->step.m->n; j++)
        sum += s->tier[j] == tier ? part(s, x, j) * part(s, x, j) : 0;
    return sum;
}

/* Which variables stay: what is given, and those of the tiers before; false: none of this tier is left to move. */
static bool weigh(struct large *s, int tier)
{
    bool any = false;
    for (int j = 0; j < s->step.m->n; j++) {
        s->step.fixed[j] = s->tier[j] < tier;
        s->weight[j] = s->tier[j] == tier ? 1 : EASIER;
        any |= s->tier[j] == tier;
    }
    return any;
}

/* x + d, or as much of it as makes the tier's sum lower, on the set. */
static bool advance(struct large *s, int tier, double *x)
{
    int n = s->step.m->n;
    double before = sum_of(s, tier, x), share = 1, length = 0;
    for (int j = 0; j < n; j++)
        length += s->d[j] * s->d[j];
    for (int half = 0; half < HALVES && sga_watch_ok(); half++, share /= 2) {
        for (int j = 0; j < n; j++)
            s->y[j] = s->step.fixed[j] ? x[j] : x[j] + share * s->d[j] * s->unit[j];
        if (sparse_step_settle(&s->step, s->rq->start, s->y, s->weight, SETTLE, NULL)
            && (sum_of(s, tier, s->y) < before || share * sqrt(length) < SHORT)) {
            memcpy(x, s->y, (size_t)n * sizeof *x);
            return true;
        }
    }
    return false;
}

/* To the nearest point for the tier's variables among those near x. False: no end was reached. */
static bool descend(struct large *s, int tier, double *x)
{
    int n = s->step.m->n;
    bool ok = true;
    for (int k = 0; k < STEPS && sga_watch_ok(); k++) {
        double most = 0;
        for (int j = 0; j < n; j++)
            s->to[j] = s->tier[j] == tier ? -part(s, x, j) : 0;
        if (sparse_step_find(&s->step, s->rq->start, x, s->weight, s->to, s->d, &ok) < 0 || !ok)
            return false;
        for (int j = 0; j < n; j++)
            most = s->tier[j] >= tier ? fmax(most, fabs(s->d[j]) * s->weight[j]) : most;
        if (most < LAST)
            return true;
        if (!advance(s, tier, x))
            return most < SHORT;
    }
    return false;
}

/* From a point of the set to the nearest one, tier by tier. */
static void complete(struct large *s, struct found *f)
{
    f->any = true;
    f->ends = TIERS;
    for (int tier = 0; tier < TIERS; tier++)
        if (weigh(s, tier) && !descend(s, tier, f->x) && f->ends == TIERS)
            f->ends = tier;
    for (int tier = 0; tier < TIERS; tier++)
        f->score[tier] = sum_of(s, tier, f->x);
}

/* The guess, to both sides of it in what was not given, then some by names. */
static void begin(const struct large *s, int k, double *x)
{
    for (int j = 0; j < s->step.m->n; j++) {
        double shift = k == 0 ? 0 : k == 1 ? 1 : k == 2 ? -1 : points_scatter(s->name[j], k);
        x[j] = s->rq->initial[j] + (s->tier[j] >= 0 && !s->rq->given[j] ? shift * s->unit[j] : 0);
    }
}

/* In the tiers that have an end in both; of as near ones that which has more of those. */
static bool nearer(const struct found *a, const struct found *b)
{
    int both = a->ends < b->ends ? a->ends : b->ends;
    for (int k = 0; k < TIERS; k++) {
        if (k == both && a->ends != b->ends)
            return a->ends > b->ends;
        double x = sqrt(a->score[k]), y = sqrt(b->score[k]);
        if (fabs(x - y) > ALIKE * (1 + fmin(x, y)))
            return x < y;
    }
    return false;
}

static void keep(const struct large *s, struct found *best, const struct found *new)
{
    if (best->any && !nearer(new, best))
        return;
    memcpy(best->x, new->x, (size_t)s->step.m->n * sizeof *best->x);
    memcpy(best->score, new->score, sizeof best->score);
    best->any = true;
    best->ends = new->ends;
}

/* Nearest points of a stage. One found at the first step from the guess is the only one that can be meant. */
static void try(struct large *s, struct found *best, struct found *new)
{
    bool only = false;
    tiers_of(s->rq, s->kind, s->step.m->n, s->stage, s->tier);
    for (int k = 0; k < STARTS && !only && sga_watch_ok(); k++) {
        bool easy = false;
        begin(s, k, new->x);
        for (int j = 0; j < s->step.m->n; j++) {
            s->step.fixed[j] = s->tier[j] < 0;
            s->weight[j] = s->rq->given[j] ? 1 : EASIER;
        }
        if (!sparse_step_settle(&s->step, s->rq->start, new->x, s->weight, SETTLE, &easy))
            continue;
        only = k == 0 && easy;
        complete(s, new);
        keep(s, best, new);
    }
}

static void open(struct large *s, struct manifold *m, const struct sys_system *sys, const struct sizes *sizes)
{
    size_t n = (size_t)m->n;
    s->unit = sga_malloc((5 * n + 1) * sizeof *s->unit);
    s->weight = s->unit + n;
    s->to = s->weight + n;
    s->d = s->to + n;
    s->y = s->d + n;
    s->kind = sga_malloc(2 * n + 1);
    s->tier = (signed char *)s->kind + n;
    s->name = sga_malloc((n + 1) * sizeof *s->name);
    for (size_t j = 0; j < n; j++) {
        s->unit[j] = sizes_move(sizes, (int)j, s->rq->initial[j]);
        s->name[j] = sys->store->symbol[sys->variable[j].symbol].name;
    }
    sys_kinds(sys, s->kind);
    sparse_step_init(&s->step, m, s->unit);
}

static void close(struct large *s)
{
    sparse_step_clear(&s->step);
    free(s->unit);
    free(s->kind);
    free(s->name);
}

/* As in tiers.c: the last digits in units of what variables are. */
static void polish(struct large *s, double *x)
{
    static const double LEAST = 1e-6;
    tiers_of(s->rq, s->kind, s->step.m->n, s->found_in, s->tier);
    for (int j = 0; j < s->step.m->n; j++) {
        s->step.fixed[j] = s->tier[j] < 0;
        s->weight[j] = 1;
        s->to[j] = fmin(s->unit[j], fmax(fabs(x[j]), LEAST * s->unit[j]));
    }
    s->step.unit = s->to;
    sparse_step_settle(&s->step, s->rq->start, x, s->weight, POLISH, NULL);
    s->step.unit = s->unit;
}

bool tiers_large_start(struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq, double *x)
{
    struct large s = { .rq = rq };
    bool any = false;
    struct found best = { .x = x }, new = { .x = sga_malloc(((size_t)m->n + 1) * sizeof(double)) };
    open(&s, m, sys, sizes);
    for (int k = 0; k < TIERS_STAGES && best.ends < TIERS; k++)
        if (tiers_differ(rq, s.kind, m->n, (enum tiers_stage)k) && (!best.any || k >= TIERS_KEEP_PLACES)) {
            s.stage = (enum tiers_stage)k;
            try(&s, &best, &new);
            s.found_in = best.any && !any ? s.stage : s.found_in;
            any = best.any;
        }
    if (best.any)
        polish(&s, x);
    close(&s);
    free(new.x);
    return best.any;
}
