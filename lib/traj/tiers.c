/* A start in tiers: see tiers.h. */
#include "tiers.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "guess.h"
#include "jacobian.h"
#include "kinds.h"
#include "larger.h"
#include "manifold.h"
#include "mem.h"
#include "nearest.h"
#include "points.h"
#include "points_random.h"
#include "sizes.h"
#include "system.h"
#include "tangent.h"
#include "watch.h"

/* Towards the set, values that were not given move this much more easily. */
static const double LOOSE = 1e3;
/* Points as near as each other; and their values, where they are one point. */
static const double ALIKE = 1e-9, SAME = 1e-7;
/* A variable stays along a direction whose component there is smaller. */
static const double STAYS = 1e-6;
/* In units: farther than what one begins around. */
static const double FAR = 2;
/* Pivots below this are those of a double zero. */
static const double EDGE = 1e-4;
/* In units: nothing but rounding. */
static const double ROUNDED = 1e-13;
/* Steps of a walk, in units. */
static const double SHORT = 0.2;

/* Operations after which a point that was found is enough: what takes a second, whatever the machine. */
static const double ENOUGH = 3e8;

enum { SETTLE = 60, WALK = 200, FEW = 6, ROUNDS = 3, LOOSER = 3, STARTS = 8, MORE_STARTS = 16 };

struct search {
    const struct traj_request *rq;
    struct tangent t;
    double *unit, *loose;
    double *weight;
    unsigned char *kind;
    signed char *tier;
    int *by_name;
    const char **name;
    const double *elsewhere;
    double *filled;          /* the guess, with what equations say of values that were not given */
    int starts;
    int edges;               /* directions barred from the start: see edge_on */
    enum tiers_stage stage, found_in;
    bool dear;               /* in each tier those after it cost something */
};

struct found {
    double *x, score[TIERS];
    bool any, ended;         /* some point; and each tier had a nearest one */
};

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

/* In [-2, 2), by name and turn. */
static double scatter(const char *name, int turn)
{
    uint64_t h = 1469598103934665603u + (uint64_t)turn;
    for (; *name; name++)
        h = (h ^ (unsigned char)*name) * 1099511628211u;
    return 4 * points_uniform(&h) - 2;
}

/* The k-th place to begin at: the guess, to both sides of it in every variable that was not given, some by names, farther where
 * given values move too; the guess again, for a walk; and with what equations say. wide: how far given values move, as far as it is known. */
static void begin(const struct search *s, int k, double wide, double *y)
{
    if (k == s->starts)
        memcpy(y, s->filled, (size_t)s->t.n * sizeof *y);
    for (int j = 0; j < s->t.n && k < s->starts; j++) {
        double shift = k == 0 || k == s->starts - 1 ? 0 : k == 1 ? 1 : k == 2 ? -1 : scatter(s->name[j], k);
        double reach = !s->rq->given[j] ? 1 : k < FEW ? 0 : wide;
        y[j] = s->rq->initial[j] + (s->tier[j] >= 0 ? shift * reach * s->unit[j] : 0);
    }
}

static void fix_stayers(struct search *s)
{
    for (int j = 0; j < s->t.n; j++)
        s->t.fixed[j] = s->tier[j] < 0;
    s->t.bars = s->edges;
    tangent_fix(&s->t);
}

/* Whether a value was given, and may be another one for what edge_on tries. */
static bool kept(const struct search *s, int j)
{
    return s->rq->given[j] && s->tier[j] < 0 && !(s->rq->held && s->rq->held[j]);
}

/* From guess, whose kept values were moved off the set: the point x again, if what it keeps comes back to where it was. */
static bool come_back(struct search *s, const double *guess, double *x)
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
static void edge_on(struct search *s, double *x)
{
    struct tangent *t = &s->t;
    struct manifold *m = t->m;
    int n = t->n;
    fix_stayers(s);
    if (tangent_at(t, s->rq->start, x) < 0 || t->least > EDGE || !(t->rank > 0))
        return;
    double *y = sga_calloc((size_t)(m->c + 2 * n) + 1, sizeof *y), *off = y + m->c, *guess = off + n, size = 0;
    tangent_weakest(t, y);
    for (int i = 0; i < m->c; i++)
        for (int k = 0; k < m->cols[i]; k++)
            off[m->col[i][k]] += kept(s, m->col[i][k]) ? y[i] * m->step.value[i][k] : 0;
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
static void fix_tier(struct search *s, const struct nearest *q, int tier, bool all, const double *x)
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

static bool weigh(struct search *s, int tier, double later)
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
static bool descend(struct search *s, struct found *f, bool all)
{
    struct nearest q = { &s->t, s->rq->start, s->rq->initial, s->weight, s->by_name };
    double reached[TIERS];
    bool left = true, kept = true;
    fix_stayers(s);
    f->ended = true;
    for (int tier = 0; tier < TIERS; tier++) {
        reached[tier] = INFINITY;
        if (!left || !f->ended || !weigh(s, tier, s->dear ? 1 / (LOOSE * LOOSE) : 0))
            continue;
        left = tangent_at(&s->t, s->rq->start, f->x) >= 0 && s->t.columns > s->t.rank;
        if (left) {
            f->ended = nearest_descend(&q, f->x);
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

static void complete(struct search *s, struct found *f)
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

/* Negative: a is nearer; positive: b is; 0: as near as each other, and the same in all names. */
static int compare(const struct search *s, const struct found *a, const struct found *b)
{
    for (int k = 0; k < TIERS; k++)
        if (farther(a->score[k], b->score[k]) || farther(b->score[k], a->score[k]))
            return a->score[k] < b->score[k] ? -1 : 1;
    for (int k = 0; k < TIERS; k++)
        for (int i = 0; i < s->t.n; i++) {
            int j = s->by_name[i];
            double apart = a->x[j] - b->x[j];
            if (s->tier[j] == k && fabs(apart) > SAME * (s->unit[j] + fabs(a->x[j])))
                return apart > 0 ? -1 : 1;
        }
    return 0;
}

static void copy(const struct search *s, struct found *to, const struct found *from)
{
    memcpy(to->x, from->x, (size_t)s->t.n * sizeof *from->x);
    memcpy(to->score, from->score, sizeof from->score);
    to->any = from->any;
    to->ended = from->ended;
}

/* Further ways may be tried. */
static bool goes_on(const struct search *s, const struct found *best)
{
    return sga_watch_ok() && !(best->any && s->t.effort > ENOUGH);
}

/* Whether the new one is taken. */
static bool keep(const struct search *s, struct found *best, const struct found *new)
{
    if (best->any && (best->ended > new->ended || (best->ended == new->ended && compare(s, best, new) <= 0)))
        return false;
    copy(s, best, new);
    best->any = true;
    return true;
}

/* To the set from y. cheap: by how much more easily values move that were not given. */
static bool reach(struct search *s, double *y, double cheap, double longest, int steps, bool *easy)
{
    s->edges = 0;
    fix_stayers(s);
    for (int j = 0; j < s->t.n; j++)
        s->loose[j] = s->unit[j] * (s->rq->given[j] ? 1 : cheap);
    s->t.unit = s->stage >= TIERS_MOVE_ALL ? s->loose : s->unit;
    bool ok = tangent_settle(&s->t, s->rq->start, y, longest, steps, easy);
    s->t.unit = s->unit;
    /* residuals were seen in the units of the moves: once more in plain ones */
    return ok && (s->stage < TIERS_MOVE_ALL || tangent_settle(&s->t, s->rq->start, y, INFINITY, SETTLE, NULL));
}

/* The constraints are affine in what moves, as far as a second point shows. */
static bool affine(struct search *s, const double *x)
{
    struct manifold *m = s->t.m;
    size_t n = (size_t)s->t.n, entries = (size_t)m->jac->nnz;
    double *slope = sga_malloc((n + entries + 1) * sizeof *slope), *y = slope + entries;
    bool same = manifold_residual(m, s->rq->start, x, s->unit, NULL) >= 0;
    memcpy(slope, m->value, entries * sizeof *slope);
    for (size_t j = 0; j < n; j++)
        y[j] = x[j] + (s->tier[j] < 0 ? 0 : scatter(s->name[j], 0) * s->unit[j]);
    same = same && manifold_residual(m, s->rq->start, y, s->unit, NULL) >= 0;
    for (size_t k = 0; k < entries && same; k++)
        same = s->tier[m->jac->col[k]] < 0 || fabs(m->value[k] - slope[k]) <= ALIKE * fabs(slope[k]);
    free(slope);
    return same;
}

/* No other point can be nearer, or be meant: what is left to move does so on a plane, or nothing is and it was near. */
static bool alone(struct search *s, const double *x, bool easy)
{
    fix_stayers(s);
    return easy && ((tangent_at(&s->t, s->rq->start, x) >= 0 && s->t.columns == s->t.rank) || affine(s, x));
}

/* What is far from its guess (an angle after some turns) may be near it while all else stays: begin there, one after the other. */
static void retreat(struct search *s, struct found *best, struct found *new)
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
                complete(s, new);
                better |= keep(s, best, new);
            }
        }
    }
}

/* From the guess with ever more of the way left to what was not given: where a small change of a given value does what only
 * a large one of another does (a stiff spring, a force of constraint in newton). */
static void loosen(struct search *s, struct found *best, struct found *new)
{
    double cheap = LOOSE;
    for (int k = 0; k < LOOSER && goes_on(s, best); k++) {
        cheap *= LOOSE;
        memcpy(new->x, s->rq->initial, (size_t)s->t.n * sizeof *new->x);
        if (reach(s, new->x, cheap, INFINITY, SETTLE, NULL)) {
            complete(s, new);
            keep(s, best, new);
        }
    }
}

/* From the guess and from places around it. */
static void from_guess(struct search *s, struct found *best, struct found *new)
{
    bool only = false, easy = false;
    s->starts = s->stage >= TIERS_MOVE_ALL ? MORE_STARTS : STARTS;
    for (int k = 0; k <= s->starts && !only && goes_on(s, best); k++) {
        bool walk = k == s->starts - 1;
        begin(s, k, best->any ? fmax(1, sqrt(best->score[0])) : 1, new->x);
        if (!reach(s, new->x, LOOSE, walk ? SHORT : INFINITY, walk ? WALK : SETTLE, &easy))
            continue;
        only = k == 0 && alone(s, new->x, easy);
        complete(s, new);
        keep(s, best, new);
    }
    if (s->stage >= TIERS_MOVE_ALL)
        loosen(s, best, new);
    if (!only && best->any)
        retreat(s, best, new);
}

/* From a point of the set, and from places on the way to it. */
static void from_elsewhere(struct search *s, struct found *best, struct found *new)
{
    static const double way[] = { 0.5, 0.9, 1 };
    for (int k = 0; k < 3 && sga_watch_ok(); k++) {
        for (int j = 0; j < s->t.n; j++)
            new->x[j] = s->tier[j] < 0 ? s->rq->initial[j] : (1 - way[k]) * s->rq->initial[j] + way[k] * s->elsewhere[j];
        if (!reach(s, new->x, LOOSE, INFINITY, WALK, NULL))
            continue;
        complete(s, new);
        keep(s, best, new);
    }
}

/* Roundings away from the guess: the guess, if the set does not tell them apart. */
static void tidy(struct search *s, double *x)
{
    size_t n = (size_t)s->t.n;
    double *y = memcpy(sga_malloc((n + 1) * sizeof *y), x, n * sizeof *x);
    double before = manifold_residual(s->t.m, s->rq->start, x, s->loose, NULL);     /* as polish left them */
    for (size_t j = 0; j < n; j++)
        if (fabs(x[j] - s->rq->initial[j]) < ROUNDED * s->unit[j])
            y[j] = s->rq->initial[j];
    double after = manifold_residual(s->t.m, s->rq->start, y, s->loose, NULL);
    if (after >= 0 && after <= fmax(before, ROUNDED / 10))
        memcpy(x, y, n * sizeof *x);
    free(y);
}

static void open(struct search *s, struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq)
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

static void close(struct search *s)
{
    tangent_clear(&s->t);
    free(s->unit);
    free(s->kind);
    free(s->by_name);
    free(s->name);
}

/* Sizes may have been guessed too large, and roundings are seen in units of them: the last digits in those that variables have. */
static void polish(struct search *s, double *x)
{
    static const double LEAST = 1e-6;
    tiers_of(s->rq, s->kind, s->t.n, s->found_in, s->tier);
    s->edges = 0;
    fix_stayers(s);
    for (int j = 0; j < s->t.n; j++)
        s->loose[j] = fmin(s->unit[j], fmax(fabs(x[j]), LEAST * s->unit[j]));
    s->t.unit = s->loose;
    tangent_settle(&s->t, s->rq->start, x, INFINITY, FEW, NULL);
    s->t.unit = s->unit;
}

/* Nearest points of a stage; what another one found without an end gives way to one with it. */
static void try(struct search *s, enum tiers_stage stage, struct found *best)
{
    size_t n = (size_t)s->t.n;
    struct found here = { .x = sga_malloc((2 * n + 1) * sizeof(double)) }, new = { .x = here.x + n };
    s->stage = stage;
    s->t.effort = 0;
    tiers_of(s->rq, s->kind, s->t.n, stage, s->tier);
    (s->elsewhere ? from_elsewhere : from_guess)(s, &here, &new);
    if (here.any && (!best->any || here.ended)) {
        copy(s, best, &here);
        best->any = true;
        s->found_in = stage;
    }
    free(here.x);
}

bool tiers_start(struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq,
                 const double *elsewhere, double *x)
{
    struct search s = { .elsewhere = elsewhere };
    struct found best = { .x = x };
    open(&s, m, sys, sizes, rq);
    for (int k = 0; k < TIERS_STAGES && !best.ended; k++)
        if (tiers_differ(rq, s.kind, m->n, (enum tiers_stage)k) && (!best.any || k >= TIERS_KEEP_PLACES))
            try(&s, (enum tiers_stage)k, &best);
    if (best.any && !best.ended) {
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
    struct search s = { .elsewhere = x };
    struct found f = { .x = x };
    open(&s, m, sys, sizes, rq);
    s.stage = tiers_stage_of(rq, s.kind, m->n, x);
    tiers_of(rq, s.kind, m->n, s.stage, s.tier);
    complete(&s, &f);
    memcpy(far, f.score, sizeof f.score);
    close(&s);
    return f.ended;
}
