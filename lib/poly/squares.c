/* Polynomials that are sums of squares though their terms do not show it.
 *
 * First Lagrange's reduction, exact and cheap: where f = a g^2 + b g + c in a generator g with a > 0,
 *     4 a f = (2 a g + b)^2 + (4 a c - b^2),
 * so that f >= 0 if the rest is, and f = 0 just where 2 a g + b = 0 and the rest vanish. The
 * rest has one generator less; it is a square, a sum of even powers, or reduced again. What this
 * does not show may have an exact Gram matrix (gram.h). */
#include "gram.h"

#include <assert.h>
#include <stdlib.h>
#include <flint/fmpz_mpoly_factor.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

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
    SGA_ARENA(mem);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
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
    return found;
}

/* square = 2 a g + b, f = 4 a c - b^2 */
static bool complete(struct poly_bridge *b, fmpz_mpoly_t f, int g, fmpz_mpoly_t part[3], fmpz_mpoly_t square)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_gen(t, g, b->ctx);
    bool ok = poly_mul(b, square, part[2], t);
    fmpz_mpoly_scalar_mul_si(square, square, 2, b->ctx);
    fmpz_mpoly_add(square, square, part[1], b->ctx);
    ok = ok && poly_mul(b, f, part[2], part[0]) && poly_mul(b, t, part[1], part[1]);
    fmpz_mpoly_scalar_mul_si(f, f, 4, b->ctx);
    fmpz_mpoly_sub(f, f, t, b->ctx);
    return ok && poly_fits(b, f) && f->length <= TERMS;
}

static void make_primitive(struct poly_bridge *b, fmpz_mpoly_t f)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    poly_content(c, f);
    if (!fmpz_is_zero(c))
        fmpz_mpoly_scalar_divexact_fmpz(f, f, c, b->ctx);
}

/* Without its content, as an expression of the list. */
static void list(struct poly_bridge *b, fmpz_mpoly_t f, expr_id *out, int *count)
{
    make_primitive(b, f);
    if (f->length && fmpz_sgn(f->coeffs) < 0)
        fmpz_mpoly_neg(f, f, b->ctx);
    out[(*count)++] = poly_show_poly(b, f);
}

/* Each generator that may vanish in a term, as one product for each term. */
static void list_terms(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id *out, int *count)
{
    SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    for (slong i = 0; i < f->length; i++) {
        expr_id e = expr_int(b->st, 1);
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens; g++)
            if (exp[g] && b->gen[g].sign != POLY_POSITIVE)
                e = expr_mul(b->st, e, b->gen[g].node);
        out[(*count)++] = e;
    }
}

static bool by_completing(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id **out, int *count, bool *never)
{
    long degree = poly_degree(b, f);
    if (f->length < 3 || f->length > TERMS || degree < 2 || degree > DEGREE || degree % 2)
        return false;
    SGA_ARENA(mem);
    fmpz_mpoly_t part[3];
    fmpz_mpoly_struct *rest = mpoly_take(&mem, b->ctx), *square = mpoly_take(&mem, b->ctx);
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
    for (int k = 0; k < 3; k++)
        fmpz_mpoly_clear(part[k], b->ctx);
    if (!ok) {
        free(*out);
        *out = NULL;
        *count = 0;
    }
    return ok;
}

/* What vanishes where the squares of a proof do: weight * q, each generator of a product once. */
struct zeros { fmpz_mpoly_struct *f; int count; };

static void add_zero(struct poly_bridge *b, struct zeros *z, const struct gram_block *k, const fmpz_mpoly_t q)
{
    fmpz_mpoly_struct *f = z->f + z->count++;
    fmpz_mpoly_init(f, b->ctx);
    fmpz_mpoly_set(f, q, b->ctx);
    if (!k->positive)
        fmpz_mpoly_mul(f, f, k->weight, b->ctx);       /* small: f holds its square */
}

static bool higher(const struct poly_bridge *b, const fmpz_mpoly_t f, const fmpz_mpoly_t g)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *s = mpoly_take(&mem, b->ctx), *t = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_get_term_monomial(s, f, 0, b->ctx);
    fmpz_mpoly_get_term_monomial(t, g, 0, b->ctx);
    return fmpz_mpoly_cmp(s, t, b->ctx) > 0;
}

/* The reduced echelon form of their span over the numbers: x^2 - 1, y^2 - 1 rather than x^2 + y^2 - 2, y^2 - 1. */
static void echelon(struct poly_bridge *b, struct zeros *z)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 }, d = { 0 };
    SGA_ARENA(mem);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    for (int i = 0; i < z->count; i++) {
        for (int k = i + 1; k < z->count; k++)        /* the highest leading monomial first */
            if (fmpz_mpoly_is_zero(z->f + i, b->ctx)
                || (!fmpz_mpoly_is_zero(z->f + k, b->ctx) && higher(b, z->f + k, z->f + i)))
                fmpz_mpoly_swap(z->f + i, z->f + k, b->ctx);
        if (fmpz_mpoly_is_zero(z->f + i, b->ctx))
            break;
        fmpz_mpoly_get_term_monomial(t, z->f + i, 0, b->ctx);
        for (int k = 0; k < z->count; k++) {
            if (k == i)
                continue;
            fmpz_mpoly_get_coeff_fmpz_monomial(c, z->f + k, t, b->ctx);
            if (fmpz_is_zero(c))
                continue;
            fmpz_neg(c, c);
            fmpz_mpoly_get_term_coeff_fmpz(d, z->f + i, 0, b->ctx);
            fmpz_mpoly_scalar_fmma(z->f + k, z->f + k, d, z->f + i, c, b->ctx);
            make_primitive(b, z->f + k);
        }
    }
    while (z->count && fmpz_mpoly_is_zero(z->f + z->count - 1, b->ctx))
        fmpz_mpoly_clear(z->f + --z->count, b->ctx);
}

/* Those that vanish with the others are left out, the longest first. */
static void keep_needed(struct poly_bridge *b, struct zeros *z)
{
    SGA_FREED const fmpz_mpoly_struct **other = sga_malloc(((size_t)z->count + 1) * sizeof *other);
    for (int i = 1; i < z->count; i++)
        for (int k = i; k > 0 && z->f[k].length > z->f[k - 1].length; k--)
            fmpz_mpoly_swap(z->f + k, z->f + k - 1, b->ctx);
    for (int i = 0; i < z->count; i++) {
        int n = 0;
        for (int k = 0; k < z->count; k++)
            if (k != i)
                other[n++] = z->f + k;
        if (!n || !poly_vanish(b, z->f + i, other, n))
            continue;
        for (int k = i; k + 1 < z->count; k++)
            fmpz_mpoly_swap(z->f + k, z->f + k + 1, b->ctx);
        fmpz_mpoly_clear(z->f + --z->count, b->ctx);
        i--;
    }
}

static void collect(struct poly_bridge *b, const struct gram_proof *p, struct zeros *z)
{
    for (int k = 0; k < p->g.blocks && p->definite; k++)
        for (int i = 0; i < p->g.block[k].count; i++)
            add_zero(b, z, p->g.block + k, p->g.block[k].q + i);
    for (int i = 0; i < p->squares && !p->definite; i++)
        add_zero(b, z, p->g.block + p->square[i].block, p->square[i].q);
    echelon(b, z);
    keep_needed(b, z);
}

/* By an exact Gram matrix (gram.h), of f or of f times what is positive. */
static bool by_gram(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id **out, int *count, bool *never)
{
    struct gram_proof p;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *multiplier = mpoly_take(&mem, b->ctx);
    bool found = gram_prove_times(b, f, multiplier, &p);
    if (!found)
        return false;
    int most = p.squares;
    for (int k = 0; k < p.g.blocks; k++)
        most += p.g.block[k].count;
    struct zeros z = { .f = sga_malloc(((size_t)most + 1) * sizeof *z.f) };
    *never = p.never;
    *out = sga_malloc(((size_t)most + 1) * sizeof **out);
    if (!p.never)
        collect(b, &p, &z);
    for (int i = 0; i < z.count; i++) {
        if (z.f[i].length == 1)
            list_terms(b, z.f + i, *out, count);
        else
            list(b, z.f + i, *out, count);
        fmpz_mpoly_clear(z.f + i, b->ctx);
    }
    free(z.f);
    gram_proof_clear(&p);
    return true;
}

bool poly_squares(struct poly_bridge *b, const fmpz_mpoly_t f, expr_id **out, int *count, bool *never)
{
    *out = NULL;
    *count = 0;
    *never = false;
    bool found = by_completing(b, f, out, count, never) || by_gram(b, f, out, count, never);
    assert(!found || *never || *count > 0);
    return found;
}
