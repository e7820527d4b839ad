/* Arithmetic of k[D]: sums, products, adjoints. */
#include "ore.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"

void ore_init(struct ore *x)
{
    *x = (struct ore){ 0 };
}

void ore_clear(struct ore *x)
{
    for (int i = 0; i < x->cap; i++)
        fmpz_poly_q_clear(x->a + i);
    free(x->a);
    *x = (struct ore){ 0 };
}

static void fit(struct ore *x, int len)
{
    if (len <= x->cap)
        return;
    x->a = sga_realloc(x->a, (size_t)len * sizeof *x->a);
    while (x->cap < len)
        fmpz_poly_q_init(x->a + x->cap++);
}

/* len as it is after a change of the first n coefficients */
static void trim(struct ore *x, int n)
{
    while (n > 0 && fmpz_poly_q_is_zero(x->a + n - 1))
        n--;
    x->len = n;
}

bool ore_sane(const struct ore *x)
{
    return x->len >= 0 && x->len <= x->cap && (!x->len || !fmpz_poly_q_is_zero(x->a + x->len - 1));
}

void ore_set(struct ore *x, const struct ore *y)
{
    assert(ore_sane(y));
    if (x == y)
        return;
    fit(x, y->len);
    for (int i = 0; i < y->len; i++)
        fmpz_poly_q_set(x->a + i, y->a + i);
    for (int i = y->len; i < x->len; i++)
        fmpz_poly_q_zero(x->a + i);
    x->len = y->len;
}

void ore_swap(struct ore *x, struct ore *y)
{
    struct ore keep = *x;
    *x = *y;
    *y = keep;
}

void ore_zero(struct ore *x)
{
    for (int i = 0; i < x->len; i++)
        fmpz_poly_q_zero(x->a + i);
    x->len = 0;
}

void ore_one(struct ore *x)
{
    ore_zero(x);
    fit(x, 1);
    fmpz_poly_q_one(x->a);
    x->len = 1;
}

void ore_add_term(struct ore *x, const fmpz_poly_q_t a, int k)
{
    fit(x, k + 1);
    fmpz_poly_q_add(x->a + k, x->a + k, a);
    trim(x, x->len > k + 1 ? x->len : k + 1);
    assert(ore_sane(x));
}

bool ore_equal(const struct ore *x, const struct ore *y)
{
    bool same = x->len == y->len;
    for (int i = 0; i < x->len && same; i++)
        same = fmpz_poly_q_equal(x->a + i, y->a + i);
    return same;
}

static void combine(struct ore *x, const struct ore *y, const struct ore *z,
                    void (*op)(fmpz_poly_q_t, const fmpz_poly_q_t, const fmpz_poly_q_t))
{
    SGA_ENDS(ore_clear) struct ore r;
    int n = y->len > z->len ? y->len : z->len;
    ore_init(&r);
    fit(&r, n);
    SGA_ENDS(fmpz_poly_q_end) fmpz_poly_q_t none;
    fmpz_poly_q_init(none);
    for (int i = 0; i < n; i++)
        op(r.a + i, i < y->len ? y->a + i : none, i < z->len ? z->a + i : none);
    trim(&r, n);
    ore_swap(x, &r);
}

void ore_add(struct ore *x, const struct ore *y, const struct ore *z)
{
    combine(x, y, z, fmpz_poly_q_add);
}

void ore_sub(struct ore *x, const struct ore *y, const struct ore *z)
{
    combine(x, y, z, fmpz_poly_q_sub);
}

void ore_scale(struct ore *x, const fmpz_poly_q_t a)
{
    for (int i = 0; i < x->len; i++)
        fmpz_poly_q_mul(x->a + i, a, x->a + i);
    trim(x, x->len);
    assert(ore_sane(x));
}

void ore_derive(struct ore *x)
{
    fmpz_poly_q_t d;
    int n = x->len;
    if (!n)
        return;
    fmpz_poly_q_init(d);
    fit(x, n + 1);
    for (int i = n; i >= 0; i--) {           /* D (a D^i) = a D^(i+1) + a' D^i */
        if (i < n)
            fmpz_poly_q_derivative(d, x->a + i);
        else
            fmpz_poly_q_zero(d);
        if (i > 0)
            fmpz_poly_q_add(x->a + i, d, x->a + i - 1);
        else
            fmpz_poly_q_swap(x->a, d);
    }
    fmpz_poly_q_clear(d);
    x->len = n + 1;
    assert(ore_sane(x));
}

static void accumulate(struct ore *x, const struct ore *y, const struct ore *z, bool minus)
{
    SGA_ENDS(ore_clear) struct ore power = { 0 }, sum = { 0 };
    fmpz_poly_q_t c, p;
    if (ore_is_zero(y) || ore_is_zero(z))
        return;
    ore_init(&power);
    ore_init(&sum);
    fmpz_poly_q_init(c);
    fmpz_poly_q_init(p);
    ore_set(&power, z);
    ore_set(&sum, x);
    fit(&sum, y->len + z->len);
    int n = sum.len > y->len + z->len ? sum.len : y->len + z->len;
    for (int i = 0; i < y->len; i++) {
        if (i)
            ore_derive(&power);              /* D^i z */
        if (fmpz_poly_q_is_zero(y->a + i))
            continue;
        fmpz_poly_q_set(c, y->a + i);
        if (minus)
            fmpz_poly_q_neg(c, c);
        for (int k = 0; k < power.len; k++) {
            fmpz_poly_q_mul(p, c, power.a + k);
            fmpz_poly_q_add(sum.a + k, sum.a + k, p);
        }
    }
    trim(&sum, n);
    ore_swap(x, &sum);
    fmpz_poly_q_clear(p);
    fmpz_poly_q_clear(c);
}

void ore_addmul(struct ore *x, const struct ore *y, const struct ore *z)
{
    accumulate(x, y, z, false);
}

void ore_submul(struct ore *x, const struct ore *y, const struct ore *z)
{
    accumulate(x, y, z, true);
}

void ore_mul(struct ore *x, const struct ore *y, const struct ore *z)
{
    SGA_ENDS(ore_clear) struct ore r;
    ore_init(&r);
    accumulate(&r, y, z, false);
    ore_swap(x, &r);
    assert(ore_sane(x));
}

void ore_adjoint(struct ore *x, const struct ore *y)
{
    SGA_ENDS(ore_clear) struct ore r;
    ore_init(&r);
    for (int i = y->len - 1; i >= 0; i--) {  /* Horner: r = -D r + a_i */
        ore_derive(&r);
        for (int k = 0; k < r.len; k++)
            fmpz_poly_q_neg(r.a + k, r.a + k);
        ore_add_term(&r, y->a + i, 0);
    }
    ore_swap(x, &r);
    assert(ore_sane(x));
}

size_t ore_size(const struct ore *x)
{
    size_t bytes = 0;
    for (int i = 0; i < x->len; i++) {
        const fmpz_poly_struct *p = fmpz_poly_q_numref(x->a + i), *q = fmpz_poly_q_denref(x->a + i);
        size_t pb = (size_t)labs(fmpz_poly_max_bits(p)) / 8 + 8, qb = (size_t)labs(fmpz_poly_max_bits(q)) / 8 + 8;
        bytes += (size_t)fmpz_poly_length(p) * pb + (size_t)fmpz_poly_length(q) * qb;
    }
    return bytes;
}
