/* Changes of functions beside a point, of which jumps are none, and jumps themselves: bends and roots at, just off and far off their places, against what is known of them. */
#include <math.h>

#include "guard_beside.h"
#include "check.h"

enum which { SLOPE, BEND, SQUARE, ROOT, JUMP, STEEP_JUMP, BETWEEN, WHICH };
static enum which which;
static double x[2];

static double value(void *ctx, int j, double by)
{
    (void)ctx;
    double u = x[0] + (j == 0 ? by : 0), v = x[1] + (j == 1 ? by : 0);
    switch (which) {
    case SLOPE:      return 3 * u;
    case BEND:       return fabs(u);
    case SQUARE:     return u * u;
    case ROOT:       return sqrt(fabs(u));
    case JUMP:       return (u > 0 ? 2 : -1) + 1e-3 * v;
    case STEEP_JUMP: return (u > 0 ? 1 : -1) + 100 * u;
    default:         return (u > 0) - (u < 0) + 0.5;
    }
}

static double change(enum which w, double u, double by)
{
    const struct guard_beside b = { value, NULL, 2 };
    which = w;
    x[0] = u;
    x[1] = 1;
    return guard_beside_change(&b, value(NULL, -1, 0), 0, by, NULL);
}

/* Values that do not tell from 0 are no larger than the doubt of them, which is what a slope makes of the error. */
static void changes(void)
{
    const double by = 1e-6;
    for (double part = 0; part < 0.9; part += 0.01) {
        CHECK(fabs(change(SLOPE, part * by, by) - 3 * by) <= 1e-12 * by, "a slope, %g", part);
        double bend = change(BEND, part * by, by), square = change(SQUARE, part * by, by), root = change(ROOT, part * by, by);
        CHECK(bend >= 0.5 * part * by && bend <= 2 * by, "a bend, %g: %g", part, bend);
        CHECK(square <= 8 * by * by, "a square, %g: %g", part, square);
        CHECK(root <= 8 * sqrt(by), "a root, %g: %g", part, root);
    }
    for (double part = -3; part <= 3; part += 0.01)
        CHECK(change(JUMP, part * by, by) <= 1e-2 && change(BETWEEN, part * by, by) <= 1e-2, "beside a jump, %g", part);
    CHECK(change(BETWEEN, 0, by) == 0 && change(JUMP, 0, by) == 0, "at a jump");
    CHECK(change(SLOPE, 1, by) > 2.9 * by, "far from 0");
}

static void jumps(void)
{
    const double by[] = { 1e-4, 1e-4 };
    const struct guard_beside b = { value, NULL, 2 };
    for (int w = 0; w < WHICH; w++)
        for (int k = -1; k <= 1; k++) {
            which = (enum which)w;
            x[0] = 1e-9 * k;
            x[1] = 1;
            bool jump = w == JUMP || w == STEEP_JUMP || w == BETWEEN;
            CHECK(guard_beside_jumps(&b, by) == jump, "function %d, %d", w, k);
            CHECK(!guard_beside_steady(&b, by) == (w != SQUARE && w != ROOT && w != BEND) || (k == 0 && !jump), "function %d, %d: steady", w, k);
            x[0] = 1;
            CHECK(!guard_beside_jumps(&b, by) && guard_beside_steady(&b, by), "function %d, far off", w);
        }
}

int main(void)
{
    changes();
    jumps();
    return CHECK_END();
}
