/* Tables in double-double. */
#include <assert.h>
#include <math.h>

#include "arb_ends.h"
#include "mem.h"
#include "table_balls.h"

/* Coefficients have some 100 bits whatever cancels in them. */
enum { FINE_BITS = 400 };

void num_table_fine(struct expr_table *u)
{
    assert(u->knot);
    if (u->fine)
        return;
    struct num_table_balls b;
    SGA_ARENA(mem);
    arb_ptr piece = arbs_take(&mem, NUM_TABLE_PIECE);
    SGA_ENDS(arf_end) arf_t low = { 0 };
    num_table_balls_init(&b, u, FINE_BITS);
    u->fine = sga_calloc((size_t)u->knots, sizeof *u->fine);
    for (int k = 0; k + 1 < u->knots; k++) {
        num_table_balls_piece(&b, k, piece);
        for (int i = 0; i < NUM_TABLE_PIECE; i++) {
            double high = u->fine[k][2 * i] = arf_get_d(arb_midref(piece + i), ARF_RND_NEAR);
            arf_set_d(low, high);
            arf_sub(low, arb_midref(piece + i), low, FINE_BITS, ARF_RND_NEAR);
            u->fine[k][2 * i + 1] = arf_get_d(low, ARF_RND_NEAR);
        }
    }
    num_dd last = num_dd_of_fmpq(u->knot + u->knots - 1);
    u->fine[u->knots - 1][0] = last.hi;
    u->fine[u->knots - 1][1] = last.lo;
    num_table_balls_clear(&b);
}

/* Number i of interval k. */
static num_dd fine(const struct expr_table *u, int k, int i)
{
    return (num_dd){ u->fine[k][2 * i], u->fine[k][2 * i + 1] };
}

/* The interval that holds t; -1 outside. */
static int fine_interval(const struct expr_table *u, num_dd t)
{
    int low = 0, high = u->knots - 1;
    if (num_dd_less(t, fine(u, 0, 0)) || num_dd_less(fine(u, high, 0), t))
        return -1;
    while (high - low > 1) {
        int middle = low + (high - low) / 2;
        *(num_dd_less(t, fine(u, middle, 0)) ? &high : &low) = middle;
    }
    return low;
}

num_dd num_table_value(const struct expr_table *u, int order, num_dd t)
{
    if (!u->fine)
        return num_dd_of(expr_table_value(u, order, t.hi));
    int k = u->at >= 0 ? u->at : fine_interval(u, t);
    if (k < 0)
        return num_dd_of(NAN);
    num_dd x = num_dd_sub(t, fine(u, k, 0)), v = num_dd_of(0);
    for (int i = EXPR_TABLE_DEGREE; i >= order; i--) {
        double factor = 1;
        for (int n = 0; n < order; n++)
            factor *= i - n;
        v = num_dd_add(num_dd_mul(v, x), num_dd_mul_d(fine(u, k, 1 + i), factor));
    }
    return v;
}
