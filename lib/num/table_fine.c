/* Tables in double-double. */
#include <assert.h>
#include <math.h>

#include "arb_ends.h"
#include "mem.h"
#include "table_balls.h"

/* Coefficients have some 100 bits whatever cancels in them. */
enum { FINE_BITS = 400, GOOD_BITS = 98, DOUBLE_BITS = 36 };

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

static void add_error(arb_t r, double size, int bits)
{
    SGA_ENDS(mag_end) mag_t e = { 0 };
    mag_set_d(e, size);
    mag_mul_2exp_si(e, e, -bits);
    arb_add_error_mag(r, e);
}

/* Piece k in balls around its double-double numbers. */
static void fine_piece(const struct expr_table *u, int k, arb_ptr piece)
{
    SGA_ENDS(arb_end) arb_t low = { 0 };
    arb_set_fmpq(piece, u->knot + k, FINE_BITS);
    for (int i = 1; i < NUM_TABLE_PIECE; i++) {
        num_dd c = fine(u, k, i);
        arb_set_d(piece + i, c.hi);
        arb_set_d(low, c.lo);
        arb_add(piece + i, piece + i, low, FINE_BITS);
        add_error(piece + i, fabs(c.hi), GOOD_BITS);
    }
}

bool num_table_around(arb_t r, struct expr_table *u, int order, const arb_t t, slong prec)
{
    double about = arf_get_d(arb_midref(t), ARF_RND_NEAR);
    if (num_table_exact(u) >= 0) {
        double v = expr_table_value(u, order, about);
        arb_set_d(r, v);
        add_error(r, 1 + fabs(v), DOUBLE_BITS);
        return false;
    }
    SGA_ARENA(mem);
    SGA_ENDS(arf_end) arf_t low = { 0 };
    arb_ptr piece = arbs_take(&mem, NUM_TABLE_PIECE);
    num_table_fine(u);
    arf_set_d(low, about);
    arf_sub(low, arb_midref(t), low, FINE_BITS, ARF_RND_NEAR);
    int k = fine_interval(u, (num_dd){ about, arf_get_d(low, ARF_RND_NEAR) });
    arb_indeterminate(r);
    if (k < 0)
        return true;
    fine_piece(u, k, piece);
    num_table_balls_value(r, piece, order, t, prec);
    return true;
}
