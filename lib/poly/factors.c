/* Factors of numerators and denominators, with what their terms show about zeros. */
#include "gram.h"

#include <assert.h>
#include <stdlib.h>
#include <flint/fmpz_mpoly_factor.h>

#include "arena.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

/* Full factorisation within these, square-free up to more terms (then factors are not `irreducible`, which callers that look for
 * branches report), and beyond that none (false): FLINT cannot be interrupted. */
enum { FULL_TERMS = SGA_MOST_FACTORED_FULLY, FULL_DEGREE = SGA_MOST_FACTORED_DEGREE, SQUAREFREE_TERMS = 300, SQUAREFREE_DEGREE = 60 };

/* What ranks of quadrics are told modulo. */
enum { QUADRIC_PRIME = 2147483647 };

static bool factors_sane(const struct poly_factors *f)
{
    bool sane = f->sign >= -1 && f->sign <= 1;
    for (int i = 0; i < f->factors && sane; i++)
        sane = f->factor[i].expr && f->factor[i].multiplicity > 0 && f->factor[i].radicals >= 0;
    return sane;
}

void poly_factors_clear(struct poly_factors *f)
{
    for (int i = 0; i < f->factors; i++)
        free(f->factor[i].radical);
    free(f->factor);
    *f = (struct poly_factors){ 0 };
}

/* The product of the generators of a term that may vanish, each once. */
static expr_id radical_of(struct poly_bridge *b, const ulong *exp)
{
    expr_id e = expr_int(b->st, 1);
    for (int g = 0; g < b->gens; g++)
        if (exp[g] && b->gen[g].sign != POLY_POSITIVE)
            e = expr_mul(b->st, e, b->gen[g].node);
    return e;
}

static void radicals(struct poly_bridge *b, const fmpz_mpoly_t f, struct poly_factor *out)
{
    SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    out->radical = sga_malloc((size_t)f->length * sizeof *out->radical);
    for (slong i = 0; i < f->length; i++) {
        poly_exponents(b, f, i, exp);
        expr_id e = radical_of(b, exp);
        bool again = false;
        for (int k = 0; k < out->radicals; k++)
            again = again || out->radical[k] == e;
        if (!again)
            out->radical[out->radicals++] = e;
    }
}

/* sign * f as a sum of squares. */
static void squares(struct poly_bridge *b, const fmpz_mpoly_t f, int sign, struct poly_factor *out)
{
    bool never = false;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_scalar_mul_si(t, f, sign, b->ctx);
    bool found = poly_squares(b, t, &out->radical, &out->radicals, &never);
    out->never_zero = found && never;
    out->sum_of_even_powers = found && !never;
}

static bool shows_never(struct poly_bridge *b, const fmpz_mpoly_t f, int depth);

/* f = a + c g with g^2 = p/q: where f is 0, a^2 q - c^2 p is. sqrt(x^2 + 1) - x, times its conjugate, is 1. */
static bool norm_never(struct poly_bridge *b, const fmpz_mpoly_t f, int g, int depth)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *a = mpoly_take(&mem, b->ctx), *c = mpoly_take(&mem, b->ctx);
    slong var = g;
    ulong power = 1;
    fmpz_mpoly_get_coeff_vars_ui(c, f, &var, &power, 1, b->ctx);
    power = 0;
    fmpz_mpoly_get_coeff_vars_ui(a, f, &var, &power, 1, b->ctx);
    bool ok = poly_mul(b, a, a, a) && poly_mul(b, c, c, c) && poly_mul(b, a, a, b->gen[g].q) && poly_mul(b, c, c, b->gen[g].p);
    fmpz_mpoly_sub(a, a, c, b->ctx);
    bool never = ok && poly_fits(b, a) && !fmpz_mpoly_is_zero(a, b->ctx)
                 && (fmpz_mpoly_is_fmpz(a, b->ctx) || shows_never(b, a, depth + 1));
    return never;
}

/* Roots and absolute values taken out one after the other. */
static bool by_norms(struct poly_bridge *b, const fmpz_mpoly_t f, int depth)
{
    enum { DEPTH = 3, LENGTH = 60 };
    bool never = false;
    for (int g = 0; g < b->gens && !never && depth < DEPTH && f->length <= LENGTH; g++)
        never = b->gen[g].degree == 2 && b->gen[g].partner < 0 && fmpz_mpoly_degree_si(f, g, b->ctx) == 1 && norm_never(b, f, g, depth);
    return never;
}

static bool shows_never(struct poly_bridge *b, const fmpz_mpoly_t f, int depth)
{
    struct poly_factor x = { 0 };
    bool negative;
    int met;
    if (poly_sign_of(b, f, &negative) == POLY_POSITIVE || by_norms(b, f, depth))
        return true;
    if (gram_changes_sign(b, f, &met) || !met)
        return false;
    if (poly_keeps_sign(b, f))
        return true;
    squares(b, f, met, &x);
    free(x.radical);
    return x.never_zero;
}

static unsigned depends_of(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    SGA_FREED int *used = sga_calloc((size_t)b->max_gens, sizeof *used);
    unsigned d = 0;
    fmpz_mpoly_used_vars(used, f, b->ctx);
    for (int g = 0; g < b->gens; g++)
        if (used[g])
            d |= b->gen[g].depends;
    return d;
}

static void add_factor(struct poly_bridge *b, struct poly_factors *out, const fmpz_mpoly_t f, long n, bool irreducible)
{
    out->factor = sga_realloc(out->factor, ((size_t)out->factors + 1) * sizeof *out->factor);
    struct poly_factor *x = out->factor + out->factors++;
    bool negative;
    enum poly_sign sign = poly_sign_of(b, f, &negative);
    int met = 0;
    bool changes = sign == POLY_ANY && gram_changes_sign(b, f, &met);
    *x = (struct poly_factor){
        .expr = poly_show_poly(b, f), .multiplicity = n, .irreducible = irreducible,
        .depends = depends_of(b, f), .never_zero = sign == POLY_POSITIVE || (!changes && poly_keeps_sign(b, f)) };
    if (sign == POLY_NONNEGATIVE && f->length > 1) {
        x->sum_of_even_powers = true;
        radicals(b, f, x);
    } else if (sign == POLY_ANY && !changes && met && !x->never_zero) {
        squares(b, f, met, x);
        x->never_zero = x->never_zero || (!x->sum_of_even_powers && by_norms(b, f, 0));
    }
}

/* f = a g + b is irreducible if a and b have nothing in common; true: it was found so.
 * Many pivots and constraints are linear in something, and one gcd costs a tenth of a
 * factorisation. */
static bool linear_prime(struct poly_bridge *b, const fmpz_mpoly_t f)
{
    SGA_FREED slong *degree = sga_malloc((size_t)b->max_gens * sizeof *degree);
    SGA_ARENA(mem);
    fmpz_mpoly_struct *slope = mpoly_take(&mem, b->ctx), *rest = mpoly_take(&mem, b->ctx), *common = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_degrees_si(degree, f, b->ctx);
    bool prime = false;
    for (int g = 0; g < b->gens; g++) {
        if (degree[g] != 1)
            continue;
        slong var = g;
        ulong power = 1;
        fmpz_mpoly_get_coeff_vars_ui(slope, f, &var, &power, 1, b->ctx);
        power = 0;
        fmpz_mpoly_get_coeff_vars_ui(rest, f, &var, &power, 1, b->ctx);
        prime = poly_gcd(b, common, slope, rest) && fmpz_mpoly_is_one(common, b->ctx);
        break;
    }
    return prime;
}

/* Two squares of one sign, a constant being one of them: irreducible over the reals. */
static bool two_squares(const fmpz_mpoly_t f, const ulong *first, const ulong *second, int gens)
{
    bool squares = fmpz_sgn(f->coeffs) == fmpz_sgn(f->coeffs + 1);
    for (int g = 0; g < gens; g++)
        squares = squares && first[g] != 1 && second[g] != 1;
    return squares;
}

/* A polynomial of degree 2 with one more variable, which makes all of its terms of degree 2: a symmetric matrix, modulo a prime. */
struct quadric { int size; mp_limb_t *entry; };

static void put_term(struct quadric *q, int a, int b, mp_limb_t c)
{
    mp_limb_t *e = q->entry;
    e[a * q->size + b] = n_addmod(e[a * q->size + b], c, QUADRIC_PRIME);
    e[b * q->size + a] = n_addmod(e[b * q->size + a], c, QUADRIC_PRIME);      /* twice on the diagonal */
}

/* Whether its rank is 3 or more. */
static bool rank_of_three(struct quadric *q)
{
    mp_limb_t *e = q->entry;
    int n = q->size, rank = 0;
    for (int k = 0; k < n && rank < 3; k++) {
        int row = rank;
        while (row < n && !e[row * n + k])
            row++;
        if (row == n)
            continue;
        for (int c = 0; c < n; c++)
            MP_LIMB_SWAP(e[row * n + c], e[rank * n + c]);
        mp_limb_t by = n_invmod(e[rank * n + k], QUADRIC_PRIME);
        for (int r = rank + 1; r < n; r++) {
            mp_limb_t factor = e[r * n + k] * by % QUADRIC_PRIME;
            for (int c = k; c < n && factor; c++)
                e[r * n + c] = n_submod(e[r * n + c], factor * e[rank * n + c] % QUADRIC_PRIME, QUADRIC_PRIME);
        }
        rank++;
    }
    return rank == 3;
}

/* f of degree 2: the product of two linear polynomials has a matrix of rank 2 at the most, over every field; that modulo a prime is no
 * larger. Lengths of rods, normals and their rates are such polynomials, and a factorisation costs much more. True: f was found to be irreducible. */
static bool quadric_prime(struct poly_bridge *b, const fmpz_mpoly_t f)
{
    enum { TERMS = 100, SIZE = 40 };
    if (f->length < 2 || f->length > TERMS || poly_degree(b, f) != 2)
        return false;
    SGA_ARENA(mem);
    ulong *exp = sga_take(&mem, 2 * (size_t)b->max_gens * sizeof *exp), *second = exp + b->max_gens;
    int *used = sga_zeros(&mem, (size_t)b->max_gens, sizeof *used), *place = sga_take(&mem, (size_t)b->max_gens * sizeof *place);
    struct quadric q = { .size = 1 };
    fmpz_mpoly_used_vars(used, f, b->ctx);
    for (int g = 0; g < b->gens; g++)
        place[g] = used[g] ? q.size++ : 0;
    if (f->length == 2) {
        poly_exponents(b, f, 0, exp);
        poly_exponents(b, f, 1, second);
        if (two_squares(f, exp, second, b->gens))
            return true;
    }
    if (q.size > SIZE || q.size < 3)
        return false;
    q.entry = sga_zeros(&mem, (size_t)q.size * (size_t)q.size, sizeof *q.entry);
    for (slong i = 0; i < f->length; i++) {
        int at[2] = { 0, 0 }, n = 0;
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens; g++)
            for (ulong k = 0; k < exp[g]; k++)
                at[n++] = place[g];
        put_term(&q, at[0], at[1], fmpz_fdiv_ui(f->coeffs + i, QUADRIC_PRIME));
    }
    return rank_of_three(&q);
}

/* f over what its coefficients have in common. */
static void make_primitive(struct poly_bridge *b, fmpz_mpoly_t p, const fmpz_mpoly_t f)
{
    SGA_ENDS(fmpz_end) fmpz_t common = { 0 };
    for (slong i = 0; i < f->length && !fmpz_is_one(common); i++)
        fmpz_gcd(common, common, f->coeffs + i);
    if (fmpz_cmp_ui(common, 1) > 0)
        fmpz_mpoly_scalar_divexact_fmpz(p, f, common, b->ctx);
    else
        fmpz_mpoly_set(p, f, b->ctx);
}

static bool factor_into(struct poly_bridge *b, struct poly_factors *out, const fmpz_mpoly_t of, long n)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *f = mpoly_take(&mem, b->ctx);
    make_primitive(b, f, of);
    long degree = poly_degree(b, f);
    out->longest = f->length > out->longest ? f->length : out->longest;
    bool full = f->length <= FULL_TERMS && degree <= FULL_DEGREE;
    if (!full && (f->length > SQUAREFREE_TERMS || degree > SQUAREFREE_DEGREE))
        return false;
    if (f->length > 1 && (quadric_prime(b, f) || linear_prime(b, f))) {
        if (fmpz_sgn(f->coeffs) < 0) {
            fmpz_mpoly_neg(f, f, b->ctx);
            out->sign = n % 2 ? -out->sign : out->sign;
        }
        add_factor(b, out, f, n, true);
        return true;
    }
    fmpz_mpoly_factor_t fac;
    fmpz_mpoly_factor_init(fac, b->ctx);
    bool ok = full ? fmpz_mpoly_factor(fac, f, b->ctx) : fmpz_mpoly_factor_squarefree(fac, f, b->ctx);
    if (ok && fmpz_sgn(fac->constant) < 0 && n % 2)
        out->sign = -out->sign;
    for (slong i = 0; ok && i < fac->num; i++) {
        if (fmpz_sgn(fac->poly[i].coeffs) < 0) {
            fmpz_mpoly_neg(fac->poly + i, fac->poly + i, b->ctx);
            if (fmpz_is_odd(fac->exp + i) && n % 2)
                out->sign = -out->sign;
        }
        add_factor(b, out, fac->poly + i, n * fmpz_get_si(fac->exp + i), full);
    }
    fmpz_mpoly_factor_clear(fac, b->ctx);
    return ok;
}

static bool finish(struct poly_bridge *b, struct poly_factors *out, bool ok, struct sga_error before)
{
    ok = ok && expr_store_ok(b->st);
    *b->st->error = before;
    if (!ok)
        poly_factors_clear(out);
    assert(!ok || factors_sane(out));
    return ok;
}

bool poly_bridge_numerator_factors(struct poly_bridge *b, expr_id e, struct poly_factors *out)
{
    const struct poly_ratio *r = poly_value(b, e);
    struct poly_fraction f;
    struct sga_error before = *b->st->error;
    *out = (struct poly_factors){ 0 };
    if (!r || !poly_fraction_of(b, r, &f))
        return false;
    bool ok = true;
    if (f.num->length > 0) {
        out->sign = 1;
        ok = factor_into(b, out, f.num, 1);
    }
    poly_fraction_clear(b, &f);
    return finish(b, out, ok, before);
}

bool poly_bridge_denominator_factors(struct poly_bridge *b, expr_id e, struct poly_factors *out)
{
    const struct poly_ratio *r = poly_value(b, e);
    struct poly_fraction f;
    struct sga_error before = *b->st->error;
    *out = (struct poly_factors){ .sign = 1 };
    if (!r || !poly_fraction_of(b, r, &f))
        return false;
    bool ok = true;
    for (int i = 0; ok && i < f.dens; i++)
        ok = factor_into(b, out, f.den[i].f, f.den[i].n);
    poly_fraction_clear(b, &f);
    return finish(b, out, ok, before);
}

bool poly_numerator_factors(struct expr_store *st, expr_id e, const struct poly_limits *limits, struct poly_factors *out)
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, &e, 1, limits);
    return b && poly_bridge_numerator_factors(b, e, out);
}

bool poly_denominator_factors(struct expr_store *st, expr_id e, const struct poly_limits *limits, struct poly_factors *out)
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, &e, 1, limits);
    return b && poly_bridge_denominator_factors(b, e, out);
}
