/* Linear equations of which some depend on others. */
#include "dependent.h"

#include <math.h>

#include "check.h"

/* x + y = 3, 2 x + 2 y = 6 (or not), x - y = 1 */
static bool solve(double right, double z[3])
{
    double K[9] = { 1, 1, 0, 2, 2, 0, 1, -1, 0 }, b[3] = { 3, right, 1 };
    return dependent_solve(K, b, z, 3, 1);
}

int main(void)
{
    double z[3];
    CHECK(solve(6, z));
    CHECK(fabs(z[0] - 2) < 1e-15 && fabs(z[1] - 1) < 1e-15);
    CHECK(z[2] == 0);              /* what nothing determines */
    CHECK(!solve(6.1, z));
    double small[4] = { 1e-30, 0, 0, 1e20 }, b[2] = { 3e-30, 4e20 };
    CHECK(dependent_solve(small, b, z, 2, 1) && fabs(z[0] - 3) < 1e-15 && fabs(z[1] - 4) < 1e-15);
    double none[1] = { 0 }, zero[1] = { 0 }, one[1] = { 1 };
    CHECK(dependent_solve(none, zero, z, 1, 1) && z[0] == 0);
    CHECK(!dependent_solve(none, one, z, 1, 1));
    return CHECK_END();
}
