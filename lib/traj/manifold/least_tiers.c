/* Derivatives of a start in tiers: see least_tiers.h. */
#include "least_tiers.h"

#include <math.h>
#include <string.h>

#include "arena.h"
#include "kinds.h"
#include "least_move.h"
#include "sizes.h"
#include "system.h"
#include "tiers.h"

/* Of Newton's method: what was asked for does not move. */
enum { NEWTON = -1 };

struct search {
    const struct least_tiers *of;
    struct least_move l;
    unsigned char *kind;
    signed char *tier;
    double *W, *pull, *push, *rate;    /* n x n; n each: W (x - y), what pushes, and by what the units grow */
};

static bool begin(struct search *s, const struct least_tiers *of, struct sga_arena *mem)
{
    size_t n = (size_t)of->rows->n;
    *s = (struct search){ .of = of };
    s->kind = sga_zeros(mem, n + 1, 1);
    s->tier = sga_zeros(mem, n + 1, 1);
    s->W = sga_zeros(mem, n * n + 1, sizeof *s->W);
    s->pull = sga_zeros(mem, 3 * n + 1, sizeof *s->pull);
    s->push = s->pull + n;
    s->rate = s->push + n;
    sys_kinds(of->sys, s->kind);
    return least_move_at(&s->l, of->rows, of->t, of->x, of->tau, mem);
}

/* The tier's own metric, and what it is pulled by. */
static void weigh(struct search *s, int tier, const double *y)
{
    struct least_move *l = &s->l;
    memset(s->W, 0, (size_t)l->n * (size_t)l->n * sizeof *s->W);
    for (int k = 0; k < l->n; k++) {
        bool own = l->free[k] && s->tier[k] == tier;
        double w = own ? 1 / (l->unit[k] * l->unit[k]) : 0, off = s->of->x[k] - s->of->asked[k];
        s->W[k * l->n + k] = w;
        s->pull[k] = w * off;
        s->push[k] = own && y ? w * y[k] + 2 * w * off / l->unit[k] * s->rate[k] : 0;
    }
}

/* What pushes along direction d, the second derivatives being known: for Newton's method, what the conditions miss. */
static void add_bent(struct search *s, int d)
{
    const struct least_move *l = &s->l;
    for (int k = 0; k < l->n; k++) {
        s->push[k] -= d == NEWTON ? s->pull[k] : l->bent[k * l->q + d];
        for (int i = 0; i < l->c && d == NEWTON; i++)
            s->push[k] -= l->J[i * l->n + k] * l->lambda[i];
    }
}

/* Direction d (y: n, of what was asked for; becomes that of the start), if the start was found in this stage. */
static bool descend(struct search *s, int d, double *y)
{
    struct least_move *l = &s->l;
    SGA_ARENA(mem);
    double *to = sga_zeros(&mem, (size_t)l->n + 1, sizeof *to);
    const double *by = d == NEWTON ? l->miss : l->by + d;
    int step = d == NEWTON ? 1 : l->q;
    bool any = false;
    memcpy(to, y, (size_t)l->n * sizeof *to);
    for (int tier = 0; tier < TIERS; tier++) {
        bool has = false;
        for (int k = 0; k < l->n; k++)
            has |= l->free[k] && s->tier[k] == tier;
        if (!has)
            continue;
        weigh(s, tier, d == NEWTON ? NULL : y);
        if (!least_multipliers(l, s->pull, LEAST_NONE, &mem) || !least_bend(l, &mem))
            return false;
        add_bent(s, d);
        if (!least_solve(l, s->W, s->push, by, step, to, &mem))
            return false;
        for (int k = 0; k < l->n; k++)
            l->free[k] = l->free[k] && s->tier[k] != tier;
        any = true;
    }
    memset(s->push, 0, (size_t)l->n * sizeof *s->push);
    if (!any && !least_solve(l, s->W, s->push, by, step, to, &mem))
        return false;
    memcpy(y, to, (size_t)l->n * sizeof *y);
    return true;
}

/* Direction d, in a stage. */
static bool in_stage(struct search *s, enum tiers_stage stage, int d, double *y)
{
    struct least_move *l = &s->l;
    const double *asked = s->of->asked;
    tiers_of(s->of->rq, s->kind, l->n, stage, s->tier);
    memset(s->W, 0, (size_t)l->n * (size_t)l->n * sizeof *s->W);
    for (int k = 0; k < l->n; k++) {
        l->unit[k] = sizes_move(s->of->sizes, k, asked[k]);
        s->rate[k] = fabs(asked[k]) / 100 >= l->unit[k] ? (asked[k] < 0 ? -y[k] : y[k]) / 100 : 0;
        l->free[k] = s->tier[k] >= 0;
        if (!l->free[k] && fabs(s->of->x[k] - asked[k]) > LEAST_MISSED * l->unit[k])
            return false;
    }
    return descend(s, d, y);
}

int least_tiers_move(const struct least_tiers *of, double *y, unsigned char *done)
{
    SGA_ARENA(mem);
    struct search s;
    int found = 0, n = of->rows->n;
    if (!begin(&s, of, &mem))
        return 0;
    for (int stage = (int)tiers_stage_of(of->rq, s.kind, n, of->x); stage < TIERS_STAGES; stage++)
        for (int d = 0; d < of->rows->q; d++)
            if (!done[d] && in_stage(&s, (enum tiers_stage)stage, d, y + (size_t)d * (size_t)n)) {
                done[d] = 1;
                found++;
            }
    return found;
}

bool least_tiers_newton(const struct least_tiers *of, double *y)
{
    SGA_ARENA(mem);
    struct search s;
    bool found = false;
    if (!begin(&s, of, &mem))
        return false;
    for (int stage = (int)tiers_stage_of(of->rq, s.kind, of->rows->n, of->x); stage < TIERS_STAGES && !found; stage++) {
        memset(y, 0, (size_t)of->rows->n * sizeof *y);
        found = in_stage(&s, (enum tiers_stage)stage, NEWTON, y);
    }
    return found;
}
