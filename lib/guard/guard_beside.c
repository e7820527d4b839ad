/* See guard_beside.h. */
#include "guard_beside.h"

#include <assert.h>
#include <math.h>

/* Lengths that changes are looked at for. */
enum { LENGTHS = 4 };
/* Of a function's value: a change beside it that is looked at more closely; and what does not fall as its length does to a part. */
static const double MUCH = 0.05, STAYS = 0.75;
/* The part of the change that is left of a jump in the nearer look. */
static const double LEFT = 0.5;

static double change_by(const struct guard_beside *b, double g, int j, double by)
{
    double change = fabs(b->value(b->ctx, j, by) - g);
    return isfinite(change) ? change : 0;
}

double guard_beside_change(const struct guard_beside *b, double g, int j, double by, bool *jumps)
{
    double change = change_by(b, g, j, by), most = 0, least = INFINITY, before = INFINITY;
    bool jump = false;
    assert(j < b->n);
    if (change <= MUCH * fabs(g))
        return change;
    for (int k = 0; k < LENGTHS; k++) {
        double up = k ? change_by(b, g, j, ldexp(by, -k)) : change, down = change_by(b, g, j, -ldexp(by, -k)), both = ldexp(fmin(up, down), k);
        jump |= fmax(up, down) > STAYS * before;
        before = fmax(up, down);
        most = fmax(most, both);           /* by their slope, as a kink has it */
        least = fmin(least, both);
    }
    if (jumps && jump)
        *jumps = true;
    return !jump ? most : least <= MUCH * fabs(g) ? least : 0;
}

bool guard_beside_steady(const struct guard_beside *b, const double *by)
{
    double g = b->value(b->ctx, -1, 0);
    bool steady = g != 0 && isfinite(g);
    for (int j = 0; j < b->n && steady; j++)
        steady = g * b->value(b->ctx, j, by[j]) > 0 && g * b->value(b->ctx, j, -by[j]) > 0;
    return steady;
}

bool guard_beside_jumps(const struct guard_beside *b, const double *by)
{
    double g = b->value(b->ctx, -1, 0), far = 0, near = 0;
    for (int j = 0; j < b->n; j++) {
        far = fmax(far, fmax(change_by(b, g, j, by[j]), change_by(b, g, j, -by[j])));
        near = fmax(near, fmax(change_by(b, g, j, GUARD_BESIDE_NEARER * by[j]), change_by(b, g, j, -GUARD_BESIDE_NEARER * by[j])));
    }
    return near > LEFT * far && near > 0;
}
