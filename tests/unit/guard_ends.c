/* What values and rates at the ends of a way say: the least value of the cubic against samples, and functions that come near 0 between. */
#include <math.h>

#include "check.h"
#include "guard.h"

static unsigned long state;
static double uniform(void)
{
    state = state * 6364136223846793005ul + 1442695040888963407ul;
    return (double)(state >> 33) / (1ul << 30) - 1;
}

int main(void)
{
    state = check_seed(20261129);
    for (int run = 0; run < check_scale(2000); run++) {
        double c[4] = { uniform(), 4 * uniform(), 4 * uniform(), 4 * uniform() * (run % 5 != 0) };
        struct guard_ends e = { c[0], c[1], c[0] + c[1] + c[2] + c[3], c[1] + 2 * c[2] + 3 * c[3] };
        double least = INFINITY, side = run % 2 ? 1 : -1;
        for (int i = 0; i <= 1000; i++) {
            double s = i / 1000.0;
            least = fmin(least, side * (c[0] + s * (c[1] + s * (c[2] + s * c[3]))));
        }
        double lowest = guard_lowest(&e, side);
        CHECK(lowest <= least + 1e-12 && lowest > least - 1e-5, "run %d: %.9g, by samples %.9g", run, lowest, least);
        double sign = e.start < 0 ? -1 : 1, own = guard_lowest(&e, sign), ends = e.start * e.last > 0 ? fmin(fabs(e.start), fabs(e.last)) : 0;
        CHECK(guard_stays(&e) == (own > 0.5 * ends), "run %d", run);
        if (ends > 0.01) {
            double at = 0.38, value = c[0] + at * (c[1] + at * (c[2] + at * c[3]));
            CHECK(guard_fits(&e, at, value) && !guard_fits(&e, at, value + 0.3 * ends), "run %d", run);
        }
    }
    struct guard_ends flat = { 1, 0, 1, 0 }, through = { 1, -2, -1, -2 }, dips = { 1, -5, 1, 5 };
    CHECK(guard_stays(&flat) && !guard_stays(&through) && !guard_stays(&dips));
    return CHECK_END();
}
