/* Relations between generators, and signs that the terms of a polynomial show. */
#include "bridge.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "mpoly_take.h"

/* out += coeff * g^low * p^k * q^(most - k) */
static bool add_part(struct poly_bridge *b, fmpz_mpoly_t out, fmpz_mpoly_t coeff, int g, long low,
                     const fmpz_mpoly_t p, long k, const fmpz_mpoly_t q, long most)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    bool ok = true;
    if (low > 0) {
        fmpz_mpoly_gen(t, g, b->ctx);
        fmpz_mpoly_pow_ui(t, t, (ulong)low, b->ctx);
        ok = poly_mul(b, coeff, coeff, t);
    }
    if (ok && k > 0)
        ok = poly_pow(b, t, p, k) && poly_mul(b, coeff, coeff, t);
    if (ok && most > k && !fmpz_mpoly_is_one(q, b->ctx))
        ok = poly_pow(b, t, q, most - k) && poly_mul(b, coeff, coeff, t);
    if (ok)
        fmpz_mpoly_add(out, out, coeff, b->ctx);
    return ok && poly_fits(b, out);
}

long poly_reduce_by(struct poly_bridge *b, fmpz_mpoly_t f, int g, int degree, const fmpz_mpoly_t p, const fmpz_mpoly_t q)
{
    assert(g >= 0 && g < b->gens && degree > 0);
    if (!fmpz_mpoly_degrees_fit_si(f, b->ctx))
        return -1;
    long most = fmpz_mpoly_degree_si(f, g, b->ctx) / degree;
    if (most <= 0)
        return 0;
    fmpz_mpoly_univar_t u;
    SGA_ARENA(mem);
    fmpz_mpoly_univar_init(u, b->ctx);
    fmpz_mpoly_struct *out = mpoly_take(&mem, b->ctx), *coeff = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_to_univar(u, f, g, b->ctx);
    bool ok = true;
    for (slong i = 0; ok && i < fmpz_mpoly_univar_length(u, b->ctx); i++) {
        long e = fmpz_mpoly_univar_get_term_exp_si(u, i, b->ctx);
        fmpz_mpoly_univar_swap_term_coeff(coeff, u, i, b->ctx);
        ok = add_part(b, out, coeff, g, e % degree, p, e / degree, q, most);
    }
    if (ok)
        fmpz_mpoly_swap(f, out, b->ctx);
    fmpz_mpoly_univar_clear(u, b->ctx);
    return ok ? most : -1;
}

/* r / q^k */
static bool divide_by_power(struct poly_bridge *b, struct poly_ratio *r, const fmpz_mpoly_t q, long k)
{
    struct poly_ratio u, v, w;
    poly_ratio_init(b, &u);
    poly_ratio_init(b, &v);
    poly_ratio_init(b, &w);
    bool ok = poly_pow(b, u.num, q, k) && poly_ratio_inv(b, &v, &u) && poly_ratio_mul(b, &w, r, &v);
    if (ok)
        poly_ratio_set(b, r, &w);
    poly_ratio_clear(b, &u);
    poly_ratio_clear(b, &v);
    poly_ratio_clear(b, &w);
    return ok;
}

/* From the last generator down: a relation speaks of earlier generators only (that of a
 * sine of its cosine too, which has none itself), so one pass is enough. The calls that
 * come back here through divide_by_power meet lower generators only. */
bool poly_reduce_ratio(struct poly_bridge *b, struct poly_ratio *r)
{
    for (int g = b->gens - 1; g >= 0 && b->relations > 0; g--) {
        const struct poly_generator *x = b->gen + g;
        if (!x->degree)
            continue;
        long k = poly_reduce_by(b, r->num, g, x->degree, x->p, x->q);
        if (k < 0)
            return false;
        if (k > 0 && !fmpz_mpoly_is_one(x->q, b->ctx) && !divide_by_power(b, r, x->q, k))
            return false;
    }
    return true;
}

/* A term without its coefficient: POSITIVE, NONNEGATIVE or ANY. */
static enum poly_sign term_sign(const struct poly_bridge *b, const ulong *exp)
{
    enum poly_sign s = POLY_POSITIVE;
    for (int g = 0; g < b->gens; g++) {
        if (exp[g] == 0 || b->gen[g].sign == POLY_POSITIVE)
            continue;
        if (exp[g] % 2 == 1 && b->gen[g].sign == POLY_ANY)
            return POLY_ANY;
        s = POLY_NONNEGATIVE;
    }
    return s;
}

enum poly_sign poly_sign_of(const struct poly_bridge *b, const fmpz_mpoly_t f, bool *negative)
{
    enum poly_sign all = POLY_NONNEGATIVE;
    SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    *negative = f->length > 0 && fmpz_sgn(f->coeffs) < 0;
    for (slong i = 0; i < f->length && all != POLY_ANY; i++) {
        poly_exponents(b, f, i, exp);
        enum poly_sign s = term_sign(b, exp);
        if (s == POLY_ANY || (fmpz_sgn(f->coeffs + i) < 0) != *negative)
            all = POLY_ANY;
        else if (s == POLY_POSITIVE)
            all = POLY_POSITIVE;
    }
    return all;
}
