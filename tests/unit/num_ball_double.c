/* Doubles of long numbers, against MPFR's. */
#include <math.h>
#include <stdlib.h>

#include "ball.h"
#include "check.h"

int main(void)
{
    unsigned long state = check_seed(9);
    arf_t x, y;
    arf_init(x);
    arf_init(y);
    for (int turn = 0; turn < 20000; turn++) {
        state = state * 6364136223846793005ul + 1442695040888963407ul;
        int pieces = 1 + (int)(state >> 40) % 5;
        arf_zero(x);
        for (int k = 0; k < pieces; k++) {       /* some of them far apart, so that ties are nearly met */
            state = state * 6364136223846793005ul + 1442695040888963407ul;
            arf_set_si_2exp_si(y, (slong)(state >> 20) - (1l << 43), -k * (turn % 3 ? 44 : 97));
            arf_add(x, x, y, ARF_PREC_EXACT, ARF_RND_NEAR);
        }
        slong exponent = (slong)(state >> 35) % 1800 - 900;
        arf_mul_2exp_si(y, x, -exponent);
        double right = arf_get_d(y, ARF_RND_NEAR), made = num_ball_double(x, exponent);
        bool normal = fabs(right) > 1e-307;
        CHECK(normal ? made == right : fabs(made - right) <= 5e-324, "%.17g, not %.17g", made, right);
    }
    static const slong far[] = { 1100, -1100, 5000, -5000, 100000000, -100000000, WORD_MAX / 8, -(WORD_MAX / 8) };
    for (size_t k = 0; k < sizeof far / sizeof *far; k++) {
        arf_set_si(x, -3);
        double made = num_ball_double(x, far[k]);
        CHECK(far[k] > 0 ? made == 0 : made == -INFINITY, "%ld: %g", far[k], made);
    }
    arf_zero(x);
    CHECK(num_ball_double(x, 17) == 0);
    arf_pos_inf(x);
    CHECK(num_ball_double(x, 17) == INFINITY);
    arf_neg_inf(x);
    CHECK(num_ball_double(x, -17) == -INFINITY);
    arf_nan(x);
    CHECK(isnan(num_ball_double(x, 0)));
    arf_set_d(x, 1);                         /* halves of a last place go to the even one */
    arf_set_si_2exp_si(y, 1, -53);
    arf_add(x, x, y, ARF_PREC_EXACT, ARF_RND_NEAR);
    CHECK(num_ball_double(x, 0) == 1);
    arf_set_si_2exp_si(y, 1, -200);
    arf_add(x, x, y, ARF_PREC_EXACT, ARF_RND_NEAR);
    CHECK(num_ball_double(x, 0) == 1 + 0x1p-52);
    arf_clear(x);
    arf_clear(y);
    return CHECK_END();
}
