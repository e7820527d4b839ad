/* Zeros and least values between two places: see guard.h. */
#include <assert.h>
#include <float.h>
#include <math.h>

#include "guard.h"

/* A bracket falls below the rounding of its ends in so many halvings, and golden sections do so in so many. */
enum { TURNS = 200, SECTIONS = 80 };
static const double GOLDEN = 0.3819660112501051;

double guard_root(const struct guard_way *way, int k, double a, double ga, double b, double gb, double *g)
{
    assert(0 <= a && a <= b && b <= 1 && !(ga * gb > 0));
    for (int turn = 0; turn < TURNS && b - a > fmax(way->grain, DBL_EPSILON); turn++) {
        double s = a + (b - a) * (ga / (ga - gb));
        if (!(s > a && s < b) || turn % 4 == 3)
            s = 0.5 * (a + b);
        way->at(way->of, s, g);
        if (g[k] == 0)
            return s;
        if ((g[k] > 0) == (ga > 0)) {
            a = s;
            ga = g[k];
            gb *= 0.5;
        } else {
            b = s;
            gb = g[k];
            ga *= 0.5;
        }
    }
    return b;
}

void guard_least(const struct guard_way *way, struct guard_dip *d, double near, double *g)
{
    assert(d->a <= d->at && d->at <= d->b && (d->sense == 1 || d->sense == -1));
    for (int turn = 0; turn < SECTIONS && d->b - d->a > fmax(near, DBL_EPSILON); turn++) {
        bool right = d->b - d->at > d->at - d->a;
        double s = d->at + GOLDEN * (right ? d->b - d->at : d->a - d->at);
        way->at(way->of, s, g);
        bool better = d->sense * g[d->function] < d->value;
        *(better == right ? &d->a : &d->b) = better ? d->at : s;
        if (better) {
            d->at = s;
            d->value = d->sense * g[d->function];
        }
    }
}
