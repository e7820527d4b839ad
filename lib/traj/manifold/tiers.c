/* A start in tiers: see tiers.h. */
#include "tiers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "guess.h"
#include "kinds.h"
#include "manifold.h"
#include "mem.h"
#include "sizes.h"
#include "system.h"
#include "tiers_search.h"

enum { FEW = 6 };      /* steps for the last digits */
/* In units: half of the digits. */
static const double HALF = 1e-6;

void tiers_of(const struct traj_request *rq, const unsigned char *kind, int n, enum tiers_stage stage, signed char *tier)
{
    for (int j = 0; j < n; j++) {
        bool follows = kind[j] >= SYS_ALGEBRAIC;
        if (rq->held && rq->held[j])
            tier[j] = -1;
        else if (rq->given[j])
            tier[j] = stage == TIERS_KEEP_ALL || (stage == TIERS_KEEP_STATES && !follows) || (stage == TIERS_KEEP_PLACES && kind[j] == SYS_COORDINATE) ? -1
                      : stage >= TIERS_MOVE_ALL && kind[j] == SYS_MULTIPLIER ? 2
                      : stage >= TIERS_KEEP_PLACES && kind[j] == SYS_VELOCITY ? 1 : 0;
        else
            tier[j] = follows ? 5 : kind[j] == SYS_VELOCITY ? 4 : 3;
    }
}

bool tiers_differ(const struct traj_request *rq, const unsigned char *kind, int n, enum tiers_stage stage)
{
    bool states = false, others = false, velocities = false;
    for (int j = 0; j < n; j++)
        if (rq->given[j] && !(rq->held && rq->held[j]))
            *(kind[j] >= SYS_ALGEBRAIC ? &others : kind[j] == SYS_VELOCITY ? &velocities : &states) = true;
    return stage == TIERS_KEEP_ALL || (stage == TIERS_KEEP_STATES ? others : stage == TIERS_MOVE_ALL ? states || velocities : velocities && states);
}

enum tiers_stage tiers_stage_of(const struct traj_request *rq, const unsigned char *kind, int n, const double *x)
{
    enum tiers_stage stage = TIERS_KEEP_ALL;
    for (int j = 0; j < n; j++)
        if (rq->given[j] && x[j] != rq->initial[j])
            stage = kind[j] >= SYS_ALGEBRAIC && stage != TIERS_MOVE_ALL ? TIERS_KEEP_STATES : TIERS_MOVE_ALL;
    return stage;
}

/* x becomes y, if the set does not tell them apart. */
static bool take_alike(struct tiers_search *s, const double *y, double *x)
{
    double before = manifold_residual(s->t.m, s->rq->start, x, s->loose, NULL);     /* as polish left them */
    double after = manifold_residual(s->t.m, s->rq->start, y, s->loose, NULL);
    bool alike = after >= 0 && after <= fmax(before, ROUNDED / 10);
    if (alike)
        memcpy(x, y, (size_t)s->t.n * sizeof *x);
    return alike;
}

/* Roundings away from the guess: the guess. A double zero is found to half of its digits: 0, where the set does not tell these from it. */
static void tidy(struct tiers_search *s, double *x)
{
    size_t n = (size_t)s->t.n;
    SGA_FREED double *y = memcpy(sga_malloc((n + 1) * sizeof *y), x, n * sizeof *x);
    bool any = false;
    for (size_t j = 0; j < n; j++)
        if (fabs(x[j] - s->rq->initial[j]) < ROUNDED * s->unit[j])
            y[j] = s->rq->initial[j];
    take_alike(s, y, x);
    memcpy(y, x, n * sizeof *y);
    for (size_t j = 0; j < n; j++)
        if (x[j] != 0 && x[j] != s->rq->initial[j] && fabs(x[j]) < HALF * s->unit[j]) {
            y[j] = 0;
            any = true;
        }
    if (any)
        take_alike(s, y, x);
}

static void open(struct tiers_search *s, struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq)
{
    size_t n = (size_t)m->n;
    s->rq = rq;
    s->unit = sga_malloc((4 * n + 1) * sizeof *s->unit);
    s->loose = s->unit + n;
    s->weight = s->loose + n;
    s->filled = memcpy(s->weight + n, rq->initial, n * sizeof *s->filled);
    guess_complete(sys, rq->given, rq->start, NULL, s->filled);
    s->kind = sga_malloc(2 * n + 1);
    s->tier = (signed char *)s->kind + n;
    s->by_name = sga_malloc((n + 1) * sizeof *s->by_name);
    s->name = sga_malloc((n + 1) * sizeof *s->name);
    for (size_t j = 0; j < n; j++) {
        s->unit[j] = sizes_move(sizes, (int)j, rq->initial[j]);
        s->name[j] = sys->store->symbol[sys->variable[j].symbol].name;
    }
    sys_kinds(sys, s->kind);
    sys_by_name(sys, s->by_name);
    tangent_init(&s->t, m, s->unit);
}

static void close(struct tiers_search *s)
{
    tangent_clear(&s->t);
    free(s->unit);
    free(s->kind);
    free(s->by_name);
    free(s->name);
}

/* Sizes may have been guessed too large, and roundings are seen in units of them: the last digits in those that variables have. */
static void polish(struct tiers_search *s, double *x)
{
    static const double LEAST = 1e-6;
    tiers_of(s->rq, s->kind, s->t.n, s->found_in, s->tier);
    s->edges = 0;
    tiers_stay(s);
    for (int j = 0; j < s->t.n; j++)
        s->loose[j] = fmin(s->unit[j], fmax(fabs(x[j]), LEAST * s->unit[j]));
    s->t.unit = s->loose;
    tangent_settle(&s->t, s->rq->start, x, INFINITY, FEW, NULL);
    s->t.unit = s->unit;
}

/* Nearest points of a stage; what another one found without an end gives way to one with it. */
static void try(struct tiers_search *s, enum tiers_stage stage, struct tiers_found *best)
{
    size_t n = (size_t)s->t.n;
    struct tiers_found here = { .x = sga_malloc((2 * n + 1) * sizeof(double)) }, new = { .x = here.x + n };
    s->stage = stage;
    s->t.effort = 0;
    tiers_of(s->rq, s->kind, s->t.n, stage, s->tier);
    (s->elsewhere ? tiers_from_elsewhere : tiers_from_guess)(s, &here, &new);
    if (here.any && (!best->any || here.ends == TIERS)) {
        tiers_found_copy(s, best, &here);
        best->any = true;
        s->found_in = stage;
    }
    free(here.x);
}

bool tiers_start(struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq,
                 const double *elsewhere, double *x)
{
    struct tiers_search s = { .elsewhere = elsewhere };
    struct tiers_found best = { .x = x };
    open(&s, m, sys, sizes, rq);
    for (int k = 0; k < TIERS_STAGES && best.ends < TIERS; k++)
        if (tiers_differ(rq, s.kind, m->n, (enum tiers_stage)k) && (!best.any || k >= TIERS_KEEP_PLACES))
            try(&s, (enum tiers_stage)k, &best);
    if (best.any && best.ends < TIERS) {
        s.dear = true;
        best.any = false;
        try(&s, s.found_in, &best);
        best.any = true;         /* x holds one in any case */
    }
    if (best.any) {
        polish(&s, x);
        tidy(&s, x);
    }
    close(&s);
    return best.any;
}

bool tiers_descend(struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq, double *x,
                   double far[TIERS])
{
    struct tiers_search s = { .elsewhere = x };
    struct tiers_found f = { .x = x };
    open(&s, m, sys, sizes, rq);
    s.stage = tiers_stage_of(rq, s.kind, m->n, x);
    tiers_of(rq, s.kind, m->n, s.stage, s.tier);
    tiers_complete(&s, &f);
    memcpy(far, f.score, sizeof f.score);
    close(&s);
    return f.ends == TIERS;
}
