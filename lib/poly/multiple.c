/* Functions that are multiples of each other where others vanish: a candidate from numbers, and its proof. */
#include "poly.h"

#include <math.h>

#include "arb_ends.h"
#include "flint_ends.h"

/* The fraction is looked for that near to the number, beside its size; and no longer than so many bits. */
static const double BESIDE = 1e-9;
enum { MOST_BITS = 48 };

int poly_is_multiple(struct expr_store *st, expr_id a, expr_id b, double ratio, const expr_id *given, int n, const struct poly_limits *limits)
{
    SGA_ENDS(fmpq_end) fmpq_t low = { { 0, 1 } }, high = { { 0, 1 } }, r = { { 0, 1 } };
    if (a == b || !isfinite(ratio) || ratio == 0)
        return a == b;
    double size = fabs(ratio);
    SGA_ENDS(arf_end) arf_t d = { 0 };
    arf_set_d(d, size * (1 - BESIDE));
    arf_get_fmpq(low, d);
    arf_set_d(d, size * (1 + BESIDE));
    arf_get_fmpq(high, d);
    fmpq_simplest_between(r, low, high);
    if (fmpz_bits(fmpq_numref(r)) + fmpz_bits(fmpq_denref(r)) > MOST_BITS)
        return 0;
    expr_id times = expr_mul(st, expr_fmpq(st, r), b), off = ratio < 0 ? expr_add(st, a, times) : expr_sub(st, a, times);
    bool yes = off && (expr_is_zero(st, off) || poly_vanishes_with(st, off, given, n, limits));
    return !yes ? 0 : ratio < 0 ? -1 : 1;
}
