/* Sums of squares for a reader. */
#include "gram.h"

#include <stdlib.h>
#include <flint/fmpz_mpoly_factor.h>

#include "arena.h"
#include "error.h"
#include "flint_ends.h"
#include "mpoly_take.h"

/* factor * weight * q^2 / scale */
static expr_id term(struct poly_bridge *b, const struct gram_proof *p, int i, const fmpz_t scale)
{
    const struct gram_square *s = p->square + i;
    struct expr_store *st = b->st;
    SGA_ENDS(fmpq_end) fmpq_t c = { { 0, 1 } };
    fmpq_div_fmpz(c, s->factor, scale);
    expr_id q = expr_powi(st, poly_show_poly(b, s->q), 2), w = poly_show_poly(b, p->g.block[s->block].weight);
    return expr_mul(st, expr_fmpq(st, c), expr_mul(st, w, q));
}

/* The sum, what is no number first. */
static expr_id sum_of(struct poly_bridge *b, const struct gram_proof *p, const fmpz_t scale)
{
    expr_id sum = expr_int(b->st, 0);
    for (int last = 0; last < 2; last++)
        for (int i = 0; i < p->squares; i++)
            if (last == (fmpz_mpoly_is_fmpz(p->square[i].q, b->ctx) != 0))
                sum = expr_add(b->st, sum, term(b, p, i, scale));
    return sum;
}

/* f or -f as a sum of squares that is never zero. */
static bool show(struct poly_bridge *b, const fmpz_mpoly_t f, const fmpz_t scale, struct poly_certificate *out)
{
    SGA_ARENA(mem);
    struct gram_proof p;
    if (gram_changes_sign(b, f, &out->sign) || !out->sign)
        return false;
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx), *multiplier = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_scalar_mul_si(t, f, out->sign, b->ctx);
    bool ok = gram_prove_times(b, t, multiplier, &p);
    if (ok) {
        out->sum = sum_of(b, &p, scale);
        out->multiplier = fmpz_mpoly_is_one(multiplier, b->ctx) ? EXPR_UNDEF : poly_show_poly(b, multiplier);
        ok = p.never && out->sum;
        gram_proof_clear(&p);
    }
    return ok;
}

/* A factor of f that is no such sum by its terms. */
static bool show_factor(struct poly_bridge *b, const fmpz_mpoly_t f, struct poly_certificate *out)
{
    enum { TERMS = 100, DEGREE = 24 };
    fmpz_mpoly_factor_t fac;
    SGA_ENDS(fmpz_end) fmpz_t one = { 0 };
    bool found = false, negative;
    if (f->length > TERMS || poly_degree(b, f) > DEGREE)
        return false;
    fmpz_init_set_ui(one, 1);
    fmpz_mpoly_factor_init(fac, b->ctx);
    bool ok = fmpz_mpoly_factor(fac, f, b->ctx);
    for (slong i = 0; ok && i < fac->num && !found; i++) {
        found = poly_sign_of(b, fac->poly + i, &negative) != POLY_POSITIVE && show(b, fac->poly + i, one, out);
        if (found)
            out->factor = poly_show_poly(b, fac->poly + i);
    }
    fmpz_mpoly_factor_clear(fac, b->ctx);
    return found;
}

bool poly_certificate(struct expr_store *st, expr_id e, const struct poly_limits *limits, struct poly_certificate *out)
{
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, &e, 1, limits);
    struct sga_error before = *st->error;
    struct poly_fraction f;
    *out = (struct poly_certificate){ 0 };
    const struct poly_ratio *r = b ? poly_value(b, e) : NULL;
    bool ok = r && poly_fraction_of(b, r, &f);
    if (ok) {
        ok = f.num->length > 1 && ((!f.dens && show(b, f.num, f.scale, out)) || show_factor(b, f.num, out));
        poly_fraction_clear(b, &f);
    }
    ok = ok && expr_store_ok(st);
    *st->error = before;
    return ok;
}
