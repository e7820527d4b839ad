/* The structure over the rationals: primes until they are enough.
 *
 * A rank modulo a prime is never above the true one, and is below it only for primes that divide
 * one nonzero minor. Each index is read off ranks of expanded matrices of at most
 * (largest index + 2) block rows, so primes that agree on a structure, with a product above the bound
 * on these minors, prove it: for every such rank one of them at least is right, and they all say the
 * same. A prime that sees a more special structure than another is dropped.
 *
 * The characteristic polynomial, primitive, divides a nonzero minor of s A - B in Z[s]: its
 * coefficients are below 2^(degree + joint) (Mignotte), and the primes that agree on the structure all
 * see its residue, because they see all of the minors' common divisor, infinite part included. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <flint/fmpq_poly.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "spectrum.h"

bool search_next(struct search *s, struct structure_mod *m)
{
    s->prime = n_nextprime(s->prime, 1);
    bool ok = structure_mod(&s->p, s->prime, m, s->budget, s->err);
    if (ok)
        s->work += m->work;
    return ok;
}

static int largest(const struct structure_mod *m)
{
    return m->right.steps > m->left.steps ? m->right.steps : m->left.steps;
}

static double bits_of_structure(const struct search *s)
{
    return (largest(&s->reference) + 2) * s->p.apart;
}

static double bits_of_polynomial(const struct search *s)
{
    return (double)s->reference.finite->r + s->p.joint;
}

/* Takes a prime's structure in: agreeing, more generic, or dropped. Owns m. */
static void take(struct search *s, struct structure_mod *m)
{
    int c = s->agree ? structure_mod_compare(m, &s->reference) : -1;
    if (c > 0) {
        structure_mod_clear(m);
        return;
    }
    if (c < 0) {
        if (s->agree)
            structure_mod_clear(&s->reference);
        s->agree = 0;
        fmpz_one(s->modulus);
        fmpz_poly_zero(s->residue);
    }
    if (s->spectrum) {
        double q = m->finite->r;
        SGA_ENDS(nmod_poly_end) nmod_poly_t chi;
        nmod_poly_init(chi, s->prime);
        nmod_mat_charpoly_danilevsky(chi, m->finite);
        fmpz_poly_CRT_ui(s->residue, s->residue, s->modulus, chi, 0);
        fmpz_mul_ui(s->modulus, s->modulus, s->prime);
        s->work += 2 * q * q * q;
    }
    if (s->agree++)
        structure_mod_clear(m);
    else
        s->reference = *m;
}

bool spectrum_lift(const struct search *s, double bits, fmpz_poly_t out)
{
    SGA_ENDS(fmpz_end) fmpz_t bound = { 0 }, twice = { 0 };
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t q;
    SGA_ENDS(fmpq_end) fmpq_t c = { { 0, 1 } };
    bool ok = true;
    fmpq_poly_init(q);
    if (bits < 0) {                             /* as large as the primes allow */
        fmpz_fdiv_q_2exp(twice, s->modulus, 1);
        fmpz_sqrt(bound, twice);
    } else {
        fmpz_one_2exp(bound, (ulong)ceil(bits) + 1);
    }
    fmpz_mul(twice, bound, bound);
    fmpz_mul_2exp(twice, twice, 1);
    ok = fmpz_cmp(twice, s->modulus) <= 0;
    for (slong i = 0; ok && i < fmpz_poly_length(s->residue); i++) {
        ok = fmpq_reconstruct_fmpz_2(c, s->residue->coeffs + i, s->modulus, bound, bound);
        if (ok)
            fmpq_poly_set_coeff_fmpq(q, i, c);
    }
    if (ok) {
        fmpq_poly_get_numerator(out, q);
        fmpz_poly_primitive_part(out, out);
    }
    return ok;
}

static int descending(const void *x, const void *y)
{
    return *(const int *)y - *(const int *)x;
}

/* nullity_j - rank_j indices j - 1, for all j, increasing. */
static int *indices(const struct staircase *s, int *count)
{
    int n = 0, *out;
    for (int j = 0; j < s->steps; j++)
        n += s->nullity[j] - s->rank[j];
    out = sga_calloc((size_t)n + 1, sizeof *out);
    n = 0;
    for (int j = 0; j < s->steps; j++)
        for (int k = s->nullity[j] - s->rank[j]; k > 0; k--)
            out[n++] = j;
    *count = n;
    return out;
}

static int sum(const int *v, int n)
{
    int t = 0;
    for (int i = 0; i < n; i++)
        t += v[i];
    return t;
}

/* What the staircases say. */
static void read_off(const struct search *s, struct pencil_structure *out)
{
    const struct staircase *r = &s->reference.right;
    out->right = indices(r, &out->rights);
    out->left = indices(&s->reference.left, &out->lefts);
    out->infinite = sga_calloc((size_t)s->p.rows + 1, sizeof *out->infinite);
    for (int j = 0; j < r->steps; j++)
        for (int k = r->rank[j] - (j + 1 < r->steps ? r->nullity[j + 1] : 0); k > 0; k--)
            out->infinite[out->infinites++] = j + 1;
    if (out->infinites)
        qsort(out->infinite, (size_t)out->infinites, sizeof *out->infinite, descending);
    out->nilpotency = out->infinites ? out->infinite[0] : 0;
    out->finite = (int)s->reference.finite->r;
    out->normal_rank = sum(out->right, out->rights) + sum(out->left, out->lefts)
                     + sum(out->infinite, out->infinites) + out->finite;
    out->regular = !out->rights && !out->lefts;
    out->primes = s->agree;
    out->no_spectrum = s->gave_up;
}

/* Without the means for a proof: the smallest fraction that the residues give, taken when two
 * more primes confirm it. */
static bool confirm(struct search *s, fmpz_poly_t chi)
{
    struct structure_mod m;
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t again = { 0 };
    bool same = false, ok = true;
    int wait = 4;
    while (ok && !same) {
        while (ok && s->agree < wait) {
            ok = search_next(s, &m);
            if (ok)
                take(s, &m);
        }
        if (!ok || !spectrum_lift(s, -1, chi)) {
            wait += 1 + wait / 4;
            continue;
        }
        for (int more = s->agree + 2; ok && s->agree < more; ) {
            ok = search_next(s, &m);
            if (ok)
                take(s, &m);
        }
        same = ok && spectrum_lift(s, -1, again) && fmpz_poly_equal(chi, again);
        wait = s->agree + 1 + s->agree / 4;
    }
    return ok;
}

/* Seconds of a multiplication in a characteristic polynomial modulo a prime; what its coefficients need may be so much less
 * than their bound. */
static const double SECONDS = 2e-9, LUCK = 8;

/* Whether the characteristic polynomial would take longer than the budget has, by its first prime: a structure without it is
 * an answer, a search that is stopped is none. */
static bool too_long(const struct search *s, const struct structure_mod *m, double took)
{
    double q = m->finite->r, primes = (2 * (q + s->p.joint) + 4) / PRIME_BITS;
    return s->budget && s->budget->deadline > 0
           && primes * (2 * q * q * q * SECONDS + took) / LUCK > s->budget->deadline - sga_now();
}

static bool gather(struct search *s, struct pencil_structure *out)
{
    struct structure_mod m;
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t chi = { 0 };
    bool proved = false, ok = true;
    do {
        double begun = sga_now();
        if (!search_next(s, &m))
            return false;
        if (s->spectrum && !s->agree && too_long(s, &m, sga_now() - begun)) {
            s->spectrum = false;
            s->gave_up = true;
        }
        take(s, &m);
        double need = fmax(bits_of_structure(s), s->spectrum ? 2 * bits_of_polynomial(s) + 4 : 0) + 1;
        proved = (double)s->agree * PRIME_BITS >= need;
        if (!proved && s->agree >= 2 && s->work / s->agree * (need / PRIME_BITS) > s->max_work)
            break;
    } while (!proved);
    out->basis = proved ? PENCIL_PROVED : PENCIL_MODULAR;
    if (s->spectrum) {
        if (!proved || !spectrum_lift(s, bits_of_polynomial(s), chi)) {
            out->basis = PENCIL_MODULAR;
            ok = confirm(s, chi);
        }
        ok = ok && spectrum_factors(s, chi, out);
    }
    if (ok)
        read_off(s, out);
    return ok;
}

bool pencil_structure_sane(const struct pencil *p, const struct pencil_structure *s)
{
    bool sane = s->normal_rank >= 0 && s->normal_rank <= p->rows && s->normal_rank <= p->cols && s->finite <= s->normal_rank
                && s->rights == p->cols - s->normal_rank && s->lefts == p->rows - s->normal_rank;
    for (int i = 1; i < s->rights && sane; i++)
        sane = s->right[i - 1] <= s->right[i];
    for (int i = 1; i < s->lefts && sane; i++)
        sane = s->left[i - 1] <= s->left[i];
    for (int i = 1; i < s->infinites && sane; i++)
        sane = s->infinite[i - 1] >= s->infinite[i];
    return sane && s->nilpotency == (s->infinites ? s->infinite[0] : 0);
}

bool pencil_structure(const struct pencil *p, const struct pencil_options *options,
                      struct pencil_structure *out, struct sga_error *err)
{
    struct search s = {
        .prime = 1UL << PRIME_BITS, .spectrum = options->spectrum, .budget = options->budget, .err = err,
        .max_work = options->max_work > 0 ? options->max_work : 5e9,
    };
    *out = (struct pencil_structure){ .basis = PENCIL_MODULAR };
    if (p->rows > PENCIL_MAX || p->cols > PENCIL_MAX)
        return sga_fail(err, SGA_E_LIMIT_VARIABLES, "the matrix pencil has %d rows and %d columns; its structure is computed "
                        "for at most %d of each", p->rows, p->cols, PENCIL_MAX);
    integral_init(&s.p, p);
    fmpz_init_set_ui(s.modulus, 1);
    fmpz_poly_init(s.residue);
    bool ok = gather(&s, out);
    assert(!ok || pencil_structure_sane(p, out));
    assert(!ok || out->primes > 0);
    if (s.agree)
        structure_mod_clear(&s.reference);
    fmpz_poly_clear(s.residue);
    fmpz_clear(s.modulus);
    integral_clear(&s.p);
    if (!ok)
        pencil_structure_clear(out);
    return ok;
}

void pencil_structure_clear(struct pencil_structure *s)
{
    for (int i = 0; i < s->factors; i++) {
        fmpz_poly_clear(s->factor[i].f);
        free(s->factor[i].block);
    }
    free(s->factor);
    free(s->right);
    free(s->left);
    free(s->infinite);
    *s = (struct pencil_structure){ .basis = PENCIL_MODULAR };
}
