/* Polynomials that are sums of squares though their terms do not show it.
 *
 * First Lagrange's reduction, exact and cheap: where f = a g^2 + b g + c in a generator g with a > 0,
 *     4 a f = (2 a g + b)^2 + (4 a c - b^2),
 * so that f >= 0 if the rest is, and f = 0 just where 2 a g + b = 0 and the rest vanish. The
 * rest has one generator less; it is a square, a sum of even powers, or reduced again. What this
 * does not show may have an exact Gram matrix (gram.h). */
#include "gram.h"

#include <stdlib.h>
#include <flint/fmpz_mpoly_factor.h>

#include "mem.h"

enum { TERMS = 200, DEGREE = 16, ROUNDS = 12 };

/* f as a square up to a constant: f = k p^2m with k > 0, p square-free of one factor. */
static bool root_of(struct poly_bridge *b, const fmpz_mpoly_t f, fmpz_mpoly_t root)
{
    fmpz_mpoly_factor_t fac;
    fmpz_mpoly_factor_init(fac, b->ctx);
    bool ok = fmpz_mpoly_factor_squarefree(fac, f, b->ctx) && fmpz_sgn(fac->constant) > 0;
    fmpz_mpoly_one(root, b->ctx);
    for (slong i = 0; ok && i < fac->num; i++) {
        bool negative;
        if (fmpz_is_even(fac->exp + i))
            ok = poly_mul(b, root, root, fac->poly + i);
        else
            ok = poly_sign_of(b, fac->poly + i, &negative) == POLY_POSITIVE && !negative;
    }
    fmpz_mpoly_factor_clear(fac, b->ctx);
    return ok;
}

/* f = a g^2 + b g + c with a > 0 by its terms: the generator g, constant a preferred; -1 */
static int quadratic_in(struct poly_bridge *b, const fmpz_mpoly_t f, fmpz_mpoly_t part[3])
{
    int found = -1;
    fmpz_mpoly_t t;
    fmpz_mpoly_init(t, b->ctx);
    for (int g = 0; g < b->gens; g++) {
        bool negative;
        if (fmpz_mpoly_degree_si(f, g, b->ctx) != 2)
            continue;
        slong var = g;
        ulong power = 2;
        fmpz_mpoly_get_coeff_vars_ui(t, f, &var, &power, 1, b->ctx);
        if (poly_sign_of(b, t, &negative) != POLY_POSITIVE || negative)
            continue;
        bool better = found < 0 || (fmpz_mpoly_is_fmpz(t, b->ctx) && !fmpz_mpoly_is_fmpz(part[2], b->ctx));
        if (!better)
            continue;
        found = g;
        fmpz_mpoly_set(part[2], t, b->ctx);
        for (power = 0; power < 2; power++)
            fmpz_mpoly_get_coeff_vars_ui(part[power], f, &var, &power, 1, b->ctx);
    }
    fmpz_mpoly_clear(t, b->ctx);
    return found;
}

/* square = 2 a g + b, f = 4 a c - b^2 */
static bool complete(struct poly_bridge *b, fmpz_mpoly_t f, int g, fmpz_mpoly_t part[3], fmpz_mpoly_t square)
{
    fmpz_mpoly_t t;
    fmpz_mpoly_init(t, b->ctx);
    fmpz_mpoly_gen(t, g, b->ctx);
    bool ok = poly_mul(b, square, part[2], t);
    fmpz_mpoly_scalar_mul_si(square, square, 2, b->ctx);
    fmpz_mpoly_add(square, square, part[1], b->ctx);
    ok = ok && poly_mul(b, f, part[2], part[0]) && poly_mul(b, t, part[1], part[1]);
    fmpz_mpoly_scalar_mul_si(f, f, 4, b->ctx);
    fmpz_mpoly_sub(f, f, t, b->ctx);
    fmpz_mpoly_clear(t, b->ctx);
    return ok && poly_fits(b, f) && f->length <= TERMS;
}

/* Without its content, as an expression of the list. */
static void list(struct poly_bridge *b, fmpz_mpoly_t f, expr_id *out, int *count)
{
    fmpz_t c;
    fmpz_init(c);
    poly_content(c, f);
    fmpz_mpoly_scalar_divexact_fmpz(f, f, c, b->ctx);
    if (f->length && fmpz_sgn(f->coeffs) < 0)
        fmpz_mpoly_neg(f, f, b->ctx);
    out[(*count)++] = poly_show_poly(b, f);
    fmpz_clear(c);
}

/* Each generator that may vanish in a term, as one product for each term. */
static void list_terms(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id *out, int *count)
{
    ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    for (slong i = 0; i < f->length; i++) {
        expr_id e = expr_int(b->st, 1);
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens; g++)
            if (exp[g] && b->gen[g].sign != POLY_POSITIVE)
                e = expr_mul(b->st, e, b->gen[g].node);
        out[(*count)++] = e;
    }
    free(exp);
}

static bool by_completing(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id **out, int *count, bool *never)
{
    long degree = poly_degree(b, f);
    if (f->length < 3 || f->length > TERMS || degree < 2 || degree > DEGREE || degree % 2)
        return false;
    fmpz_mpoly_t rest, square, part[3];
    fmpz_mpoly_init(rest, b->ctx);
    fmpz_mpoly_init(square, b->ctx);
    for (int k = 0; k < 3; k++)
        fmpz_mpoly_init(part[k], b->ctx);
    fmpz_mpoly_set(rest, f, b->ctx);
    *out = sga_malloc((TERMS + ROUNDS) * sizeof **out);
    bool ok = false, negative;
    for (int round = 0; round < ROUNDS; round++) {
        if (fmpz_mpoly_is_zero(rest, b->ctx)) {
            ok = true;
            break;
        }
        enum poly_sign sign = poly_sign_of(b, rest, &negative);
        if (sign != POLY_ANY) {
            ok = !negative;
            *never = ok && sign == POLY_POSITIVE;
            if (ok && !*never)
                list_terms(b, rest, *out, count);
            break;
        }
        if (root_of(b, rest, square)) {
            list(b, square, *out, count);
            ok = true;
            break;
        }
        int g = quadratic_in(b, rest, part);
        if (g < 0 || !complete(b, rest, g, part, square))
            break;
        list(b, square, *out, count);
    }
    fmpz_mpoly_clear(rest, b->ctx);
    fmpz_mpoly_clear(square, b->ctx);
    for (int k = 0; k < 3; k++)
        fmpz_mpoly_clear(part[k], b->ctx);
    if (!ok) {
        free(*out);
        *out = NULL;
        *count = 0;
    }
    return ok;
}

/* What vanishes where weight * q^2 does. */
static void list_square(struct poly_bridge *b, const struct gram_block *k, const fmpz_mpoly_t q, expr_id *out, int *count)
{
    int before = *count;
    if (fmpz_mpoly_is_fmpz(q, b->ctx))
        out[(*count)++] = expr_int(b->st, 1);
    else if (q->length == 1)
        list_terms(b, q, out, count);
    else
        out[(*count)++] = poly_show_poly(b, q);
    if (!k->positive)
        out[before] = expr_mul(b->st, out[before], poly_show_poly(b, k->weight));
    for (int i = 0; i < before && *count > before; i++)
        if (out[i] == out[before])
            --*count;
}

/* By an exact Gram matrix (gram.h). */
static bool by_gram(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id **out, int *count, bool *never)
{
    struct gram_proof p;
    if (!gram_prove(b, f, &p))
        return false;
    int most = p.squares;
    for (int k = 0; k < p.g.blocks; k++)
        most += p.g.block[k].count;
    *never = p.never;
    *out = sga_malloc(((size_t)most + 1) * sizeof **out);
    for (int k = 0; k < p.g.blocks && p.definite && !p.never; k++)
        for (int i = 0; i < p.g.block[k].count; i++)
            list_square(b, p.g.block + k, p.g.block[k].q + i, *out, count);
    for (int i = 0; i < p.squares && !p.definite && !p.never; i++)
        list_square(b, p.g.block + p.square[i].block, p.square[i].q, *out, count);
    gram_proof_clear(&p);
    return true;
}

bool poly_squares(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id **out, int *count, bool *never)
{
    *out = NULL;
    *count = 0;
    *never = false;
    return by_completing(b, f, out, count, never) || by_gram(b, f, out, count, never);
}
