/* Natural sizes from the equations and the values given. */
#include "sizes.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "natural.h"
#include "scaling.h"
#include "sort.h"
#include "system.h"
#include "warnings.h"

/* log2: sizes between are taken for 1; and what doubles hold with room. */
static const double SMALL = -10, LARGE = 20, ROOM = 6, MOST = 900;
/* The time of the motion says little of that of the equations. */
static const double TIME_WEIGHT = 0.01;
/* For values that are not given those that are say little, where equations tell sizes: what begins small need not stay so. */
static const double HINT = 0.1;
/* log2: given values that may be roundings of 0 (cos(pi/2)) are this far below the largest one, and those that are below their size. */
static const double SUSPECT = -43, ROUNDED = -47;
/* They say this much of their size: more than nothing does (scaling_rows.c: DAMP, the root), less than any equation. */
static const double SLIGHT = 0.03;
/* log2: what is given so far below the size that it has among the others happens to be small, and says as little: near a turning point or at
 * rest nearly all of a mechanism's velocities are. Then sizes are looked for again, so often at the most. */
static const double BELOW = -5;
enum { ROUNDS = 6 };
/* What became larger than its unit by more than this had the wrong one. */
static const double WRONG = 8;
/* What stayed below this part of its unit was never there. */
static const double NEVER_THERE = 1e-3;

/* What is given is what the request gives: at the start of a later piece values near 0 are roundings. */
static const struct traj_request *giver(const struct traj_request *rq) { return rq->sized_by ? rq->sized_by : rq; }

static bool has_size(const struct traj_request *from, int j)
{
    return from->given[j] && from->initial[j] != 0 && isfinite(from->initial[j]);
}

/* slight: by variable, those that say little. */
static void given(struct scaling *w, const struct traj_request *from, int n, double weight, const unsigned char *slight)
{
    double span = from->samples ? fabs(from->times[from->samples - 1] - from->start) : 0;
    for (int j = 0; j < n; j++)
        if (has_size(from, j))
            scaling_anchor(w, j, log2(fabs(from->initial[j])), slight[j] ? SLIGHT * weight : weight);
    if (span > 0)
        scaling_anchor(w, n, log2(span), TIME_WEIGHT * weight);
}

/* What is given is not far smaller than it is. */
static void at_least_given(const struct traj_request *from, int n, double *log)
{
    for (int j = 0; j < n; j++)
        if (has_size(from, j))
            log[j] = fmax(log[j], log2(fabs(from->initial[j])) + SMALL);
}

static double power(double log)
{
    return ldexp(1, (int)lrint(fmax(-MOST, fmin(MOST, log))));
}

/* What is large keeps its relative accuracy down to 1, but where it begins at 0, which has none; ROOM for a size guessed too large. */
static double unit_of(double log, bool from_zero)
{
    return log <= SMALL ? power(log) : from_zero && log > LARGE ? power(log - ROOM) : 1;
}

/* slight[j] is set for what is given far below its size log[j]. Whether any is new. */
static bool add_slight(const struct traj_request *from, int n, const double *log, unsigned char *slight)
{
    bool any = false;
    for (int j = 0; j < n; j++)
        if (has_size(from, j) && !slight[j] && log2(fabs(from->initial[j])) < log[j] + BELOW)
            slight[j] = any = true;
    return any;
}

/* log2 of the sizes into log (n + 1), from the equations and from what is given (for the others: where equations leave them open); NULL: too
 * many variables. among: what is given counts by the largest of what equations compare, not by their mean. The caller frees it. */
static struct scaling *sizes_of(const struct sys_system *sys, const struct traj_request *rq, int n, bool others, bool among, const unsigned char *slight, double *log)
{
    struct scaling *w = NULL;
    SGA_ARENA(mem);
    unsigned char *little = memcpy(sga_take(&mem, (size_t)n + 1), slight, (size_t)n);
    for (int round = 0; !round || (among && round < ROUNDS && add_slight(giver(rq), n, log, little)); round++) {
        scaling_free(w);
        w = natural_scaling(sys, true, others);
        if (!w)
            break;
        if (scaling_cut(w) && !rq->own_atol)
            sga_limit_met(rq->budget, SGA_LIMIT_SCALED_TERMS);
        given(w, giver(rq), n, others ? HINT : 1, little);
        scaling_logs(w, log);
    }
    if (w)
        at_least_given(giver(rq), n, log);
    return w;
}

/* Where to cut decades: in the middle of the widest gap between the fractions (ascending, from 0 to 1) of what is told apart by them. Of gaps about
 * as wide, the one nearest to the middle between two powers of ten, then the upper one. */
static double cut(const double *fraction, int count)
{
    static const double ALIKE = 0.05;      /* sizes are known to some hundredths of a decade */
    double best = 0.5, widest = 0;
    for (int k = 0; k < count; k++) {
        double next = k + 1 < count ? fraction[k + 1] : fraction[0] + 1, gap = next - fraction[k], middle = (next + fraction[k]) / 2;
        middle -= floor(middle);
        double nearer = fabs(best - 0.5) - fabs(middle - 0.5);
        if (gap > widest + ALIKE || (gap > widest - ALIKE && (nearer > ALIKE || (nearer > -ALIKE && middle > best)))) {
            widest = gap;
            best = middle;
        }
    }
    return best;
}

/* Of values that were not given. Powers of ten, so that a start does not depend on units: another one, by a power of ten, shifts them by
 * as much. Sizes that are alike stay so: decades begin where no size is near. */
static void weigh_others(struct sizes *s, const struct traj_request *from, const double *log)
{
    static const double TEN = 3.321928094887362, FINE = 1e9;     /* log2 10 */
    const double most = 140;
    SGA_ARENA(mem);
    int *order = sga_take(&mem, ((size_t)s->n + 1) * sizeof *order), count = 0;
    double *fraction = sga_take(&mem, ((size_t)s->n + 1) * sizeof *fraction);
    for (int j = 0; j < s->n; j++)
        if (!from->given[j])
            order[count++] = (int)(FINE * (log[j] / TEN - floor(log[j] / TEN)));
    sga_sort(order, (size_t)count);
    for (int k = 0; k < count; k++)
        fraction[k] = order[k] / FINE;
    double at = cut(fraction, count);
    for (int j = 0; j < s->n; j++)
        if (!from->given[j])
            s->weight[j] = pow(10, ceil(fmax(-most, fmin(most, log[j] / TEN)) - at));
}

/* slight[j] (n, zero on entry): given values that are roundings of 0 beside the sizes that the others and the equations tell. A start that is
 * moved by their size would move all else: a velocity of 1 is nothing to stop then. */
static void find_roundings(const struct sys_system *sys, const struct traj_request *rq, int n, unsigned char *slight, double *log)
{
    const struct traj_request *from = giver(rq);
    double most = 0;
    bool any = false;
    for (int j = 0; j < n; j++)
        most = has_size(from, j) ? fmax(most, fabs(from->initial[j])) : most;
    for (int j = 0; j < n; j++) {
        slight[j] = has_size(from, j) && log2(fabs(from->initial[j])) < log2(most) + SUSPECT;
        any |= slight[j];
    }
    struct scaling *w = any ? sizes_of(sys, rq, n, false, true, slight, log) : NULL;
    for (int j = 0; j < n; j++)
        slight[j] = slight[j] && w && log2(fabs(from->initial[j])) < log[j] + ROUNDED;
    scaling_free(w);
}

static void find(struct sizes *s, const struct sys_system *sys, const struct traj_request *rq)
{
    int n = s->n;
    const struct traj_request *from = giver(rq);
    SGA_ARENA(mem);
    double *log = sga_take(&mem, (size_t)(n + 2) * sizeof *log);
    unsigned char *slight = sga_zeros(&mem, (size_t)n + 1, 1);
    find_roundings(sys, rq, n, slight, log);
    struct scaling *w = sizes_of(sys, rq, n, true, true, slight, log);
    if (!w && !rq->own_atol)
        sga_limit_met(rq->budget, SGA_LIMIT_SCALED);
    if (w)
        weigh_others(s, from, log);
    scaling_free(w);
    w = sizes_of(sys, rq, n, false, false, slight, log);
    for (int j = 0; j < n && w; j++)
        if (from->given[j])
            s->weight[j] = log[j] <= SMALL || log[j] >= LARGE ? power(log[j]) : 1;
    for (int j = 0; j < n; j++)
        s->uneven |= s->weight[j] != 1;
    for (int j = 0; j < n && w; j++)
        s->unit[j] = rq->own_atol ? 1 : unit_of(log[j], from->initial[j] == 0 || slight[j]);
    for (int k = 0; k < s->columns && w && !rq->own_atol; k++)
        s->column[k] = rq->outputs ? unit_of(scaling_size(w, rq->output[k], log), false) : s->unit[k];
    scaling_free(w);
}

static void look(struct sizes *s)
{
    s->any = false;
    for (int j = 0; j < s->n; j++)
        s->any |= s->unit[j] != 1;
    for (int k = 0; k < s->columns; k++)
        s->any |= s->column[k] != 1;
}

/* All are sizes: what is measured in them has a value. */
static bool sizes_sane(const struct sizes *s)
{
    bool sane = s->time > 0;
    for (int j = 0; j < 3 * s->n + s->columns && sane; j++)       /* weight, unit, column, row */
        sane = s->weight[j] > 0 && isfinite(s->weight[j]);
    return sane;
}

void sizes_init(struct sizes *s, const struct sys_system *sys, const struct traj_request *rq)
{
    int n = sys->variables, columns = rq->outputs ? rq->outputs : n;
    double span = rq->samples ? fabs(rq->times[rq->samples - 1] - rq->start) : 0;
    *s = (struct sizes){ .n = n, .columns = columns, .time = rq->own_atol || span == 0 ? 1 : fmin(1, span) };
    s->weight = sga_malloc((3 * (size_t)n + (size_t)columns + 1) * sizeof *s->weight);
    s->unit = s->weight + n;
    s->column = s->unit + n;
    s->row = s->column + columns;
    for (int j = 0; j < 2 * n + columns; j++)
        s->weight[j] = 1;
    find(s, sys, rq);
    memcpy(s->row, s->weight, (size_t)n * sizeof *s->row);
    s->uneven_rows = s->uneven;
    look(s);
    assert(sizes_sane(s));
}

void sizes_clear(struct sizes *s)
{
    free(s->weight);
    *s = (struct sizes){ 0 };
}

static bool grow(double *unit, const double *size, int count)
{
    bool any = false;
    for (int j = 0; j < count; j++)
        if (size[j] > WRONG * unit[j] && unit[j] < 1) {
            unit[j] = fmin(1, power(log2(size[j])));
            any = true;
        }
    return any;
}

bool sizes_grow(struct sizes *s, const double *variable, const double *column)
{
    bool any = grow(s->unit, variable, s->n);
    any |= grow(s->column, column, s->columns);
    look(s);
    assert(sizes_sane(s));
    return any;
}

static bool shrink(double *unit, const double *value, int n)
{
    bool any = false;
    for (int j = 0; j < n; j++)
        if (unit[j] > 1 && value[j] < NEVER_THERE * unit[j]) {
            unit[j] = value[j] > 1 ? power(log2(value[j])) : 1;
            any = true;
        }
    return any;
}

bool sizes_shrink(struct sizes *s, const double *variable, const double *column)
{
    bool any = shrink(s->unit, variable, s->n);
    any |= shrink(s->column, column, s->columns);
    look(s);
    assert(sizes_sane(s));
    return any;
}

void sizes_met(struct sizes *s, const double *x)
{
    bool large = s->uneven;
    for (int j = 0; j < s->n; j++) {
        double own = x[j] != 0 && isfinite(x[j]) ? power(log2(fabs(x[j])) + SMALL) : 0;
        if (s->uneven)
            s->weight[j] = fmax(s->weight[j], own);
        s->row[j] = fmax(s->weight[j], own);
        large |= own > power(LARGE + SMALL) * s->weight[j];
    }
    s->uneven_rows = large;
    assert(sizes_sane(s));
}

double sizes_move(const struct sizes *s, int j, double value)
{
    return fmax(s->weight[j], fabs(value) / 100);
}
