/* Is w = W y a cyclic vector of the torsion module? Asked modulo a prime along power series. */
#include "cyclic.h"

#include <stdlib.h>

#include <flint/nmod_poly.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"

enum { PLACES = 8 };
static const ulong prime = 1152921504606846883UL;      /* the largest below 2^60 */

/* The series of a in t - place modulo t^length; false where the denominator vanishes there. */
static bool expand(nmod_poly_t out, const fmpz_poly_q_struct *a, ulong place, long length)
{
    SGA_ENDS(nmod_poly_end) nmod_poly_t num, den;
    nmod_poly_init(num, prime);
    nmod_poly_init(den, prime);
    fmpz_poly_get_nmod_poly(num, fmpz_poly_q_numref(a));
    fmpz_poly_get_nmod_poly(den, fmpz_poly_q_denref(a));
    nmod_poly_taylor_shift(num, num, place);
    nmod_poly_taylor_shift(den, den, place);
    bool ok = nmod_poly_get_coeff_ui(den, 0) != 0;
    if (ok)
        nmod_poly_div_series(out, num, den, length);
    return ok;
}

static nmod_poly_struct *new_series(long count)
{
    nmod_poly_struct *p = sga_malloc((size_t)(count + 1) * sizeof *p);
    for (long k = 0; k < count; k++)
        nmod_poly_init(p + k, prime);
    return p;
}

static void free_series(nmod_poly_struct *p, long count)
{
    for (long k = 0; k < count; k++)
        nmod_poly_clear(p + k);
    free(p);
}

static bool expand_all(nmod_poly_struct *out, const struct ratio_matrix *m, ulong place, long length)
{
    bool ok = true;
    for (int k = 0; k < m->rows * m->cols && ok; k++)
        ok = expand(out + k, m->e + k, place, length);
    return ok;
}

/* Are w, w' + w F, ... independent at the place? Rows of constant terms of n Krylov vectors. */
static bool full_at(const struct ratio_matrix *F, const struct ratio_matrix *w, ulong place, bool *full)
{
    int n = F->rows;
    nmod_poly_struct *f = new_series((long)n * n), *v = new_series(n), *next = new_series(n);
    SGA_ENDS(nmod_mat_end) nmod_mat_t K;
    SGA_ENDS(nmod_poly_end) nmod_poly_t p;
    nmod_mat_init(K, n, n, prime);
    nmod_poly_init(p, prime);
    bool ok = expand_all(f, F, place, n) && expand_all(v, w, place, n);
    for (int k = 0; k < n && ok; k++) {
        long length = n - k;
        for (int j = 0; j < n; j++) {
            nmod_mat_entry(K, k, j) = nmod_poly_get_coeff_ui(v + j, 0);
            nmod_poly_derivative(next + j, v + j);
            for (int i = 0; i < n; i++) {
                nmod_poly_mullow(p, v + i, f + (long)i * n + j, length);
                nmod_poly_add(next + j, next + j, p);
            }
            nmod_poly_truncate(next + j, length);
        }
        nmod_poly_struct *keep = v;
        v = next;
        next = keep;
    }
    *full = ok && nmod_mat_rank(K) == n;
    free_series(f, (long)n * n);
    free_series(v, n);
    free_series(next, n);
    return ok;
}

bool op_is_cyclic(const struct ratio_matrix *F, const struct ratio_matrix *w)
{
    for (int k = 0; k < PLACES; k++) {
        bool full;
        if (full_at(F, w, 912345678901UL + 7919UL * (ulong)k, &full))
            return full;
    }
    return false;
}
