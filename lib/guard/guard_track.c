/* Signs of functions from node to node: see guard_track.h. */
#include "guard_track.h"

#include <math.h>

#include "arena.h"
#include "mem.h"

#define STEPS 2                /* errors allowed that places on a step may be off by */
#define SETTLED 1e-3           /* of those: what constraints are met to where a step ends */

double guard_doubt(const struct guard_point *p, enum guard_errors which, bool *jumps)
{
    const struct guard_beside *b = &p->beside;
    double g = b->value(b->ctx, -1, 0), sum = p->rounding * fabs(g);
    for (int j = 0; j + 1 < b->n; j++)
        sum += guard_beside_change(b, g, j, p->error(b->ctx, j, which), jumps);
    return sum;
}

static bool jumps_near(const struct guard_point *p)
{
    SGA_FREED double *by = sga_malloc((size_t)p->beside.n * sizeof *by);
    for (int j = 0; j < p->beside.n; j++)
        by[j] = p->error(p->beside.ctx, j, GUARD_PLACE);
    return guard_beside_jumps(&p->beside, by);
}

void guard_track_start(struct guard_track *k, const struct guard_point *p, int side, bool fresh)
{
    const struct guard_beside *b = &p->beside;
    int time = b->n - 1;
    double g = b->value(b->ctx, -1, 0);
    k->jumps = false;
    k->least = guard_doubt(p, fresh ? GUARD_ALLOWED : GUARD_TOLD, &k->jumps);
    if (fresh)        /* what is small beside the errors allowed is not small beside those of the start */
        k->least = fmin(k->least, guard_doubt(p, GUARD_FOUND, NULL));
    guard_beside_change(b, g, time, p->error(b->ctx, time, GUARD_TOLD), &k->jumps);
    k->before = g;
    k->carried = side != 0;
    k->jumps = k->carried ? fabs(g) > k->least && jumps_near(p) : k->jumps;
    if (k->carried && !k->jumps)        /* the place of the event itself is known to roundings of its time only */
        k->least = 4 * (k->least + fabs(g));
    k->sign = k->carried ? (signed char)side : fabs(g) > k->least && !k->jumps ? (g > 0 ? 1 : -1) : 0;
    k->kept = 0;
    if (!k->sign && !k->carried && !k->jumps) {      /* steps come beside 0 by what they may err (a function that constraints keep at 0) */
        double allowed = guard_doubt(p, GUARD_ALLOWED, NULL);
        k->kept = fmax(k->least, SETTLED * allowed);
        k->least = fmax(k->least, STEPS * allowed);
    }
}

/* |g| has a minimum between the nodes i-1 and i+1, where its sign is one. */
static void dip(const struct guard_scan *s, int e, int i, struct guard_track *k)
{
    const struct guard_table *w = s->table;
    struct guard_low low = { .left = w->theta[i - 1], .left_value = guard_value(w, i - 1, e), .right = w->theta[i + 1], .right_value = guard_value(w, i + 1, e) };
    double ga = low.left_value, g = guard_value(w, i, e), gb = low.right_value;
    /* what a parabola says; far from 0 it need not be looked at */
    double p = w->theta[i] - low.left, q = low.right - w->theta[i], slope = ((g - ga) / p * q + (gb - g) / q * p) / (p + q);
    double curve = ((gb - g) / q - (g - ga) / p) / (p + q), reach = curve != 0 ? slope * slope / (4 * curve) : 0;
    if (k->sign * (g - reach) > 0.5 * fabs(g) && fabs(g) > 0.5 * fmin(fabs(ga), fabs(gb)))
        return;
    low.d = (struct guard_dip){ .a = low.left, .at = w->theta[i], .b = low.right, .value = k->sign * g, .function = e, .sense = k->sign };
    guard_least(s->way, &low.d, s->way->grain, w->g);
    double unsure = s->low(s->of, &low);
    if (unsure >= 0) {
        k->touched = true;
        k->least = unsure;
    }
}

/* 0, where the motion before ended; or still on what was touched, perhaps moved by a rounding to the side it came from; or the place of a jump, with the value of its other side. */
static bool still_there(const struct guard_track *k, double v, double after, bool first)
{
    bool other = v * k->sign < 0 && after * k->sign > 0;
    return (k->carried && fabs(v) <= k->least) || (first && (k->jumps || other || (k->touched && !k->carried && fabs(v) <= k->least)));
}

/* A function that constraints keep at 0, between the ends of a step as far off as the step's curve is. */
static bool is_kept(const struct guard_track *k, double first, double last)
{
    return !k->sign && !k->carried && !k->jumps && fabs(first) <= k->kept && fabs(last) <= k->kept;
}

void guard_scan(const struct guard_scan *s, int e, struct guard_track *k)
{
    const struct guard_table *w = s->table;
    double before = k->before, last = 0, at = 0;
    if (is_kept(k, guard_value(w, 0, e), guard_value(w, w->nodes - 1, e)))
        return;
    for (int i = 0; i < w->nodes; i++) {
        double v = guard_value(w, i, e), after = i + 1 < w->nodes ? guard_value(w, i + 1, e) : NAN;
        if (!isfinite(v)) {
            k->sign = 0;
            before = NAN;
            continue;
        }
        if (still_there(k, v, after, i == 0)) {
            before = v;
            at = w->theta[i];
            continue;
        }
        k->carried = k->jumps = false;
        if (fabs(v) > k->least)
            k->touched = false;
        if (!k->sign) {
            k->sign = fabs(v) > k->least ? (v > 0 ? 1 : -1) : 0;
        } else if (i > 0 && !k->touched && v * k->sign < 0 && last * k->sign > 0 && after * k->sign > 0) {
            dip(s, e, i, k);           /* its lowest place is a node */
        } else if (v * k->sign < 0) {
            /* the last value may be 0 itself, where it was a node */
            if (!k->touched)
                s->change(s->of, e, at, last != 0 ? last : -v, w->theta[i], v, -k->sign);
            k->sign = (signed char)-k->sign;
            k->touched = false;
            if (i + 1 == w->nodes && fabs(v) <= (k->least = s->doubt(s->of, e, true)))
                k->touched = true;      /* the next step begins on it: that is no second event */
        } else if (!k->touched && fabs(v) < fabs(before) && fabs(v) <= fabs(after) && before * k->sign >= 0 && after * k->sign >= 0) {
            if (i > 0) {
                dip(s, e, i, k);
            } else if (fabs(v) <= (k->least = s->doubt(s->of, e, false))) {
                s->touch(s->of, e);
                k->touched = true;
            }
        }
        before = i + 1 < w->nodes ? v : before;
        last = v;
        at = w->theta[i];
    }
    k->before = before;
}
