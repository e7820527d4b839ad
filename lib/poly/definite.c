/* Polynomials that keep one sign though their terms do not: quadratic ones by completing
 * squares, univariate ones by counting real roots. */
#include "bridge.h"

#include <assert.h>
#include <flint/fmpq_mat.h>
#include <flint/fmpz_poly.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"

/* f as (1, x)^T M (1, x), M symmetric, index 0 for the constant. */
static void quadratic_matrix(struct poly_bridge *b, const fmpz_mpoly_t f, const int *place, fmpq_mat_t M)
{
    SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    for (slong i = 0; i < f->length; i++) {
        int at[2] = { 0, 0 }, n = 0;
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens; g++)
            for (ulong k = 0; k < exp[g]; k++)
                at[n++] = place[g];
        assert(n <= 2);            /* a quadratic polynomial */
        fmpz_mpoly_get_term_coeff_fmpz(c, f, i, b->ctx);
        if (at[0] == at[1]) {
            fmpq_set_fmpz(fmpq_mat_entry(M, at[0], at[0]), c);
        } else {
            fmpq_set_fmpz(fmpq_mat_entry(M, at[0], at[1]), c);
            fmpq_div_2exp(fmpq_mat_entry(M, at[0], at[1]), fmpq_mat_entry(M, at[0], at[1]), 1);
            fmpq_set(fmpq_mat_entry(M, at[1], at[0]), fmpq_mat_entry(M, at[0], at[1]));
        }
    }
}

/* Complete squares in the variables; what is left is the least value, if it exists. Every
 * square must have the sign `sign`, and the rest too, strictly. */
static bool completes(fmpq_mat_t M, int n, int sign)
{
    SGA_FREED bool *used = sga_calloc((size_t)n, sizeof *used);
    bool ok = true;
    SGA_ENDS(fmpq_end) fmpq_t t = { { 0, 1 } };
    for (;;) {
        int p = 0;
        for (int i = 1; i < n && !p; i++)
            if (!used[i] && !fmpq_is_zero(fmpq_mat_entry(M, i, i)))
                p = i;
        if (!p)
            break;
        ok = fmpq_sgn(fmpq_mat_entry(M, p, p)) == sign;
        used[p] = true;
        for (int i = 0; i < n && ok; i++)
            for (int j = 0; j < n; j++) {
                if (used[i] || used[j])
                    continue;
                fmpq_mul(t, fmpq_mat_entry(M, i, p), fmpq_mat_entry(M, p, j));
                fmpq_div(t, t, fmpq_mat_entry(M, p, p));
                fmpq_sub(fmpq_mat_entry(M, i, j), fmpq_mat_entry(M, i, j), t);
            }
        if (!ok)
            break;
    }
    /* no squares are left: any other entry with a variable is indefinite or linear */
    for (int i = 1; i < n && ok; i++)
        for (int j = 0; j < n && ok && !used[i]; j++)
            ok = used[j] || fmpq_is_zero(fmpq_mat_entry(M, i, j));
    ok = ok && fmpq_sgn(fmpq_mat_entry(M, 0, 0)) == sign;
    return ok;
}

static bool quadratic_definite(struct poly_bridge *b, const fmpz_mpoly_t f, const int *place, int gens)
{
    bool definite = false;
    for (int sign = -1; sign <= 1 && !definite; sign += 2) {
        SGA_ENDS(fmpq_mat_end) fmpq_mat_t M;
        fmpq_mat_init(M, gens + 1, gens + 1);
        quadratic_matrix(b, f, place, M);
        definite = completes(M, gens + 1, sign);
    }
    return definite;
}

static bool rootless(struct poly_bridge *b, const fmpz_mpoly_t f, int gen)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t p = { 0 };
    bool none = fmpz_mpoly_get_fmpz_poly(p, f, gen, b->ctx) && fmpz_poly_is_squarefree(p)
                && fmpz_poly_num_real_roots(p) == 0;
    return none;
}

bool poly_keeps_sign(struct poly_bridge *b, const fmpz_mpoly_t f)
{
    long degree = poly_degree(b, f);
    if (degree < 2 || degree % 2 || degree > 40 || f->length > 200)
        return false;
    SGA_ARENA(mem);
    int *used = sga_zeros(&mem, (size_t)b->max_gens, sizeof *used), *place = sga_zeros(&mem, (size_t)b->max_gens, sizeof *place);
    int gens = 0, last = -1;
    fmpz_mpoly_used_vars(used, f, b->ctx);
    for (int g = 0; g < b->gens; g++)
        if (used[g]) {
            place[g] = ++gens;
            last = g;
        }
    assert(gens >= 1 && last >= 0);
    return gens == 1 ? rootless(b, f, last) : degree == 2 && quadratic_definite(b, f, place, gens);
}
