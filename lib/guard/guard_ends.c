/* What values and rates at both ends of a way say of a function: see guard.h. */
#include <math.h>

#include "guard.h"

static const double DIP = 0.5;         /* of its least value at the ends: where a function comes to less between, it is looked at; */
static const double WILD = 0.25;       /* of the same: and where it is not the cubic by so much at a place inside, whose error is nowhere more than 1.2 times that at 0.38 */

/* start + rate s + bend s^2 + twist s^3 */
struct cubic { double start, rate, bend, twist; };

static struct cubic cubic_of(const struct guard_ends *e)
{
    double way = e->last - e->start;
    return (struct cubic){ e->start, e->rate, 3 * way - 2 * e->rate - e->last_rate, e->rate + e->last_rate - 2 * way };
}

static double cubic_at(const struct cubic *c, double s) { return c->start + s * (c->rate + s * (c->bend + s * c->twist)); }

/* The least of side times the cubic between 0 and 1. */
static double cubic_least(const struct cubic *c, double side)
{
    double least = fmin(side * c->start, side * cubic_at(c, 1)), root = c->bend * c->bend - 3 * c->twist * c->rate;
    if (root < 0)
        return least;
    double q = -c->bend - copysign(sqrt(root), c->bend), place[2] = { q / (3 * c->twist), c->rate / q };
    for (int i = 0; i < 2; i++)
        if (place[i] > 0 && place[i] < 1)
            least = fmin(least, side * cubic_at(c, place[i]));
    return least;
}

static double nearest(const struct guard_ends *e) { return e->start * e->last > 0 ? fmin(fabs(e->start), fabs(e->last)) : 0; }

double guard_lowest(const struct guard_ends *e, double side)
{
    struct cubic c = cubic_of(e);
    return cubic_least(&c, side);
}

bool guard_stays(const struct guard_ends *e) { return guard_lowest(e, e->start < 0 ? -1 : 1) > DIP * nearest(e); }

bool guard_fits(const struct guard_ends *e, double s, double value)
{
    struct cubic c = cubic_of(e);
    return fabs(value - cubic_at(&c, s)) < WILD * nearest(e);
}
