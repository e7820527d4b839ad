/* Functions that are equal up to names have the factors that they would have alone; those that are not, their own. */
#include "alike.h"

#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "facts.h"

enum { NAMES = 12, FUNCTIONS = 9 };

static struct expr_store st;
static expr_id x[NAMES];

static expr_id sq(expr_id e) { return expr_powi(&st, e, 2); }
static expr_id times(long n, expr_id e) { return expr_mul(&st, expr_int(&st, n), e); }

/* The k-th kind, of a, b, c; n: a number in it. */
static expr_id function(int k, expr_id a, expr_id b, expr_id c, long n)
{
    switch (k) {
    case 0: return expr_sub(&st, expr_add(&st, sq(expr_sub(&st, a, b)), sq(c)), expr_int(&st, n));
    case 1: return expr_mul(&st, expr_sub(&st, sq(a), times(n, sq(b))), expr_add(&st, c, expr_int(&st, 1)));
    case 2: return expr_sub(&st, expr_mul(&st, a, b), expr_mul(&st, c, expr_fun(&st, EXPR_SIN, a)));
    case 3: return expr_add(&st, sq(expr_sub(&st, a, b)), sq(expr_sub(&st, expr_mul(&st, b, c), expr_int(&st, n))));
    case 4: return expr_add(&st, expr_powi(&st, a, 4), expr_int(&st, n));
    case 5: return expr_div(&st, expr_sub(&st, sq(a), sq(b)), expr_add(&st, expr_int(&st, n), sq(c)));
    case 6: return expr_powi(&st, expr_add(&st, a, times(n, b)), 3);
    case 7: return expr_neg(&st, expr_mul(&st, a, expr_add(&st, b, c)));
    default: return expr_int(&st, n);
    }
}

static void same(const struct poly_factors *a, const struct poly_factors *b, int k, int at)
{
    CHECK(a->factors == b->factors && a->sign == b->sign && a->longest == b->longest, "function %d at %d", k, at);
    for (int i = 0; i < a->factors && i < b->factors; i++) {
        const struct poly_factor *f = a->factor + i, *g = b->factor + i;
        CHECK(f->expr == g->expr && f->multiplicity == g->multiplicity && f->depends == g->depends, "function %d at %d, factor %d", k, at, i);
        CHECK(f->irreducible == g->irreducible && f->never_zero == g->never_zero && f->sum_of_even_powers == g->sum_of_even_powers, "function %d at %d, factor %d: what is known",
              k, at, i);
        CHECK(f->radicals == g->radicals && (!f->radicals || !memcmp(f->radical, g->radical, (size_t)f->radicals * sizeof *f->radical)), "function %d at %d, factor %d: radicals", k, at, i);
    }
}

int main(void)
{
    static const char *const name[NAMES] = { "a", "b", "c", "d", "e", "f", "g", "h", "i", "p", "q", "r" };
    const struct poly_limits limits = poly_limits_of(POLY_AMPLE, NULL);
    expr_store_init(&st);
    for (int i = 0; i < NAMES; i++)
        x[i] = expr_symbol_add(&st, name[i], i < 9 ? EXPR_VARIABLE : EXPR_PARAMETER);
    struct poly_alike *a = poly_alike_new(&st);
    for (int at = 0; at < 3; at++)              /* the first time they are met, then with other names, and with others again */
        for (int k = 0; k < FUNCTIONS; k++)
            for (long n = 1; n < 6; n++)
                for (int order = 0; order < 3; order++) {
                    expr_id e = function(k, x[3 * at + order], x[3 * at + (order + 1) % 3], order == 2 ? x[9 + at] : x[3 * at + (order + 2) % 3], n);
                    struct poly_factors own, met;
                    CHECK(poly_alike_factors(a, e, &limits, &met) && poly_numerator_factors(&st, e, &limits, &own), "function %d at %d", k, at);
                    same(&met, &own, k, at);
                    poly_factors_clear(&met);
                    poly_factors_clear(&own);
                }
    poly_alike_free(a);
    poly_alike_free(NULL);
    expr_store_clear(&st);
    return CHECK_END();
}
