/* Digits that a numeric zero takes, from the size of what it is made of. */
#include "needed_bits.h"

#include <math.h>

#include "arb_ends.h"
#include "arena.h"

enum { LEAST = 300, CONSTANTS = 3000 };

static double most(double a, double b)
{
    return a > b ? a : b;
}

/* |log2 |v|| of a value that is known not to be 0 */
static double magnitude(const arb_t v)
{
    if (!arb_is_finite(v) || arb_contains_zero(v))
        return 0;
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_get_mag(m, v);
    return fabs(mag_get_d_log2_approx(m));
}

static double exponential(struct num_ball *b, const struct expr_node *n)
{
    if (n->op != EXPR_EXP && n->op != EXPR_SINH && n->op != EXPR_COSH && n->op != EXPR_TANH)
        return 0;
    arb_srcptr u = num_ball_value(b, n->a);      /* exp(-2 |u|) is what these leave of 1 */
    return arb_is_finite(u) ? 3 * fabs(arf_get_d(arb_midref(u), ARF_RND_NEAR)) : 0;
}

static double constant_bits(const struct expr_store *st, const struct expr_node *n)
{
    const fmpq *q = n->op == EXPR_CONST ? st->constant + n->a : NULL;
    return q ? (double)fmpz_bits(fmpq_numref(q)) + (double)fmpz_bits(fmpq_denref(q)) : 0;
}

double points_height(struct num_ball *b, const expr_id *list, int count)
{
    double constant = 0, size = 0, exponent = 0;
    for (int k = 0; k < count; k++) {
        const struct expr_node *n = b->st->node + list[k];
        constant = most(constant, constant_bits(b->st, n));
        size = most(size, magnitude(num_ball_value(b, list[k])));
        exponent = most(exponent, exponential(b, n));
    }
    return constant + size + exponent;
}

slong points_needed_bits(struct num_ball *b, const expr_id *list, int count, double height)
{
    double all = 0;
    for (int k = 0; k < count; k++)
        all += constant_bits(b->st, b->st->node + list[k]);
    double need = LEAST + fmin(all, CONSTANTS) + 4 * most(height, points_height(b, list, count));
    return need < 1e15 ? (slong)need : (slong)1e15;
}
