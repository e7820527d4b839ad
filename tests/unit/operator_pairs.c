/* Pairs of operators with their greatest common right divisor, least common left multiple and both divisions, for
 * Singular to compare (tests/jacobson_check.py): a line "pair" of eight operators, as lists of coefficients. */
#include "check.h"

#include <stdint.h>
#include <stdlib.h>

#include "buf.h"
#include "ore.h"
#include "text.h"

static uint64_t state;

static int draw(int n)
{
    state = state * 6364136223846793005u + 1442695040888963407u;
    return (int)((state >> 33) % (uint64_t)n);
}

static void random_ore(struct ore *x, int order)
{
    fmpz_poly_q_t a;
    fmpz_poly_q_init(a);
    ore_zero(x);
    for (int k = 0; k <= order; k++) {
        fmpz_poly_q_zero(a);
        for (int i = draw(3); i >= 0; i--)
            fmpz_poly_set_coeff_si(fmpz_poly_q_numref(a), i, draw(7) - 3);
        if (k == order && fmpz_poly_q_is_zero(a))
            fmpz_poly_q_one(a);
        ore_add_term(x, a, k);
    }
    fmpz_poly_q_clear(a);
}

static void print(const struct ore *x)
{
    struct sga_buf text = { 0 };
    for (int k = 0; k < x->len; k++) {
        sga_buf_puts(&text, k ? ";" : "");
        op_text_ratio(&text, x->a + k, "t");
    }
    printf("|%s", text.len ? text.data : "");
    sga_buf_free(&text);
}

/* q b + r = a, r of lower order; b q + r = a on the left. */
static bool divides_out(const struct ore *a, const struct ore *b, const struct ore *q, const struct ore *r, bool left)
{
    struct ore z;
    ore_init(&z);
    if (left)
        ore_mul(&z, b, q);
    else
        ore_mul(&z, q, b);
    ore_add(&z, &z, r);
    bool ok = ore_equal(&z, a) && ore_order(r) < ore_order(b);
    ore_clear(&z);
    return ok;
}

int main(void)
{
    struct ore x[9], c;
    state = check_seed(20261121);
    for (int k = 0; k < 9; k++)
        ore_init(x + k);
    ore_init(&c);
    for (int round = 0; round < check_scale(25); round++) {
        random_ore(x, draw(3));
        random_ore(x + 1, 1 + draw(2));
        random_ore(&c, draw(2));
        ore_mul(x, x, &c);
        ore_mul(x + 1, x + 1, &c);
        ore_gcrd(x + 2, x + 7, x + 8, x + 3, x, x + 1);
        ore_divide_right(x + 4, x + 5, x, x + 1);
        CHECK(divides_out(x, x + 1, x + 4, x + 5, false));
        ore_divide_left(x + 6, x + 7, x, x + 1);
        CHECK(divides_out(x, x + 1, x + 6, x + 7, true));
        CHECK(ore_order(x + 2) + ore_order(x + 3) == ore_order(x) + ore_order(x + 1));
        printf("pair");
        for (int k = 0; k < 8; k++)
            print(x + k);
        printf("\n");
    }
    for (int k = 0; k < 9; k++)
        ore_clear(x + k);
    ore_clear(&c);
    flint_cleanup();
    return CHECK_END();
}
