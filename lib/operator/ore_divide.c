/* Division on either side and the Euclidean algorithm in k[D]. */
#include <assert.h>

#include "arena.h"
#include "flint_ends.h"
#include "ore.h"

/* One kind of division; `left`: b stands left of the quotient. */
static void divide(struct ore *q, struct ore *r, const struct ore *a, const struct ore *b, bool left)
{
    assert(!ore_is_zero(b));
    SGA_ENDS(ore_clear) struct ore rest, quotient, term;
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t c;
    ore_init(&rest);
    ore_init(&quotient);
    ore_init(&term);
    fmpz_poly_q_init(c);
    ore_set(&rest, a);
    while (ore_order(&rest) >= ore_order(b)) {
        int k = ore_order(&rest) - ore_order(b);
        fmpz_poly_q_div(c, ore_leading(&rest), ore_leading(b));
        ore_zero(&term);
        ore_add_term(&term, c, k);
        ore_add_term(&quotient, c, k);
        if (left)
            ore_submul(&rest, b, &term);
        else
            ore_submul(&rest, &term, b);
    }
    ore_swap(q, &quotient);
    ore_swap(r, &rest);
    assert(ore_order(r) < ore_order(b) || r == q);
}

void ore_divide_right(struct ore *q, struct ore *r, const struct ore *a, const struct ore *b)
{
    divide(q, r, a, b, false);
}

void ore_divide_left(struct ore *q, struct ore *r, const struct ore *a, const struct ore *b)
{
    divide(q, r, a, b, true);
}

static void make_monic(struct ore *x, struct ore *u, struct ore *v)
{
    fmpz_poly_q_t c;
    if (ore_is_zero(x))
        return;
    fmpz_poly_q_init(c);
    fmpz_poly_q_inv(c, ore_leading(x));
    ore_scale(x, c);
    if (u)
        ore_scale(u, c);
    if (v)
        ore_scale(v, c);
    fmpz_poly_q_clear(c);
}

void ore_gcrd(struct ore *g, struct ore *u, struct ore *v, struct ore *m, const struct ore *a, const struct ore *b)
{
    struct ore r[2], s[2], t[2];
    SGA_ENDS(ore_clear) struct ore q, rest;      /* r[i] = s[i] a + t[i] b */
    for (int i = 0; i < 2; i++) {
        ore_init(r + i);
        ore_init(s + i);
        ore_init(t + i);
    }
    ore_init(&q);
    ore_init(&rest);
    ore_set(r, a);
    ore_set(r + 1, b);
    ore_one(s);
    ore_one(t + 1);
    while (!ore_is_zero(r + 1)) {
        ore_divide_right(&q, &rest, r, r + 1);
        ore_swap(r, r + 1);
        ore_swap(r + 1, &rest);
        ore_submul(s, &q, s + 1);
        ore_swap(s, s + 1);
        ore_submul(t, &q, t + 1);
        ore_swap(t, t + 1);
    }
    make_monic(r, s, t);
    if (m) {                                   /* s[1] a + t[1] b = 0 */
        ore_mul(m, s + 1, a);
        if (ore_is_zero(b))
            ore_zero(m);
        make_monic(m, NULL, NULL);
    }
    if (u)
        ore_swap(u, s);
    if (v)
        ore_swap(v, t);
    ore_swap(g, r);
    for (int i = 0; i < 2; i++) {
        ore_clear(r + i);
        ore_clear(s + i);
        ore_clear(t + i);
    }
}
