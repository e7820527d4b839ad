/* Multiplicities and Jordan blocks of the finite part.
 *
 * The squarefree decomposition of the characteristic polynomial gives multiplicities exactly. A
 * factor f of multiplicity m > 1 has one Jordan block at each root if f(J) has nullity deg f modulo
 * one prime: the nullity is never too small there. Otherwise f is split into irreducible factors, whose roots
 * are conjugate and share their blocks, and the nullities of f(J)^k, k = 1, 2, ..., count those of size k
 * or more. For f^K of degree d these are dimensions of
 *     { (x_0, .., x_(d-1)) : A x_(i+1) = B x_i,  sum c_i A x_i + c_d B x_(d-1) = 0 },
 * f^K = sum c_i s^i, a matrix whose minors are below 2^(d apart) |c|^rows: primes past that prove it.
 * (A singular part adds a dimension that does not depend on f; an infinite one adds none.) */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include <flint/fmpz_poly_factor.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "spectrum.h"

struct check {
    int factor;                    /* index into out->factor */
    int *nullity, steps;           /* of f(J)^k, k = 1, 2, ... until deg f * multiplicity; NULL: not known yet */
};

struct checks {
    struct check *check;
    int count;
    size_t cap;
};

static int add_factor(struct pencil_structure *out, const fmpz_poly_t f, int multiplicity)
{
    out->factor = sga_realloc(out->factor, (size_t)(out->factors + 1) * sizeof *out->factor);
    struct pencil_factor *p = out->factor + out->factors;
    *p = (struct pencil_factor){ .multiplicity = multiplicity, .block = sga_calloc((size_t)multiplicity, sizeof *p->block) };
    fmpz_poly_init(p->f);
    fmpz_poly_set(p->f, f);
    p->block[0] = multiplicity;
    p->blocks = 1;
    return out->factors++;
}

/* f(J); f is taken modulo J's prime. False: its leading coefficient vanishes there. */
static bool evaluate(nmod_mat_t out, const fmpz_poly_t f, const nmod_mat_t J, double *work)
{
    slong d = fmpz_poly_degree(f), n = J->r;
    mp_limb_t p = J->mod.n;
    SGA_ENDS(nmod_mat_end) nmod_mat_t t;
    nmod_mat_init(t, n, n, p);
    nmod_mat_zero(out);
    for (slong k = d; k >= 0; k--) {
        mp_limb_t c = fmpz_fdiv_ui(f->coeffs + k, p);
        if (k == d && !c)
            return false;
        if (k < d - 1) {
            nmod_mat_mul(t, out, J);
            nmod_mat_swap(t, out);
            *work += (double)n * (double)n * (double)n;
        } else if (k == d - 1) {
            mp_limb_t lead = fmpz_fdiv_ui(f->coeffs + d, p);
            nmod_mat_scalar_mul(out, J, lead);
        }
        if (k < d)
            for (slong i = 0; i < n; i++)
                out->rows[i][i] = n_addmod(out->rows[i][i], c, p);
    }
    return true;
}

/* Nullities of f(J)^k until they reach deg f * multiplicity, at most `most` of them. Returns how
 * many; 0: this prime does not tell (a nullity that no rational matrix has). */
static int nullities(const struct pencil_factor *f, const nmod_mat_t J, int *out, int most, double *work)
{
    slong n = J->r, d = fmpz_poly_degree(f->f), full = d * f->multiplicity;
    int steps = 0;
    double cube = (double)n * (double)n * (double)n;
    SGA_ENDS(nmod_mat_end) nmod_mat_t g, power, t;
    nmod_mat_init(g, n, n, J->mod.n);
    nmod_mat_init(power, n, n, J->mod.n);
    nmod_mat_init(t, n, n, J->mod.n);
    if (evaluate(g, f->f, J, work)) {
        nmod_mat_set(power, g);
        while (steps < most) {
            slong nullity = n - nmod_mat_rank(power);
            *work += cube / 3;
            if (nullity % d || nullity > full || (steps && nullity <= out[steps - 1])) {
                steps = 0;
                break;
            }
            out[steps++] = (int)nullity;
            if (nullity == full)
                break;
            nmod_mat_mul(t, power, g);
            nmod_mat_swap(t, power);
            *work += cube;
        }
    }
    return steps;
}

/* Is f(J) of nullity deg f, one block at each root? True is proved. */
static bool one_block(struct search *s, const fmpz_poly_t f)
{
    SGA_ENDS(nmod_mat_end) nmod_mat_t g;
    const nmod_mat_struct *J = s->reference.finite;
    nmod_mat_init(g, J->r, J->r, J->mod.n);
    return evaluate(g, f, J, &s->work) && J->r - nmod_mat_rank(g) == fmpz_poly_degree(f);
}

static void add_check(struct checks *c, int factor)
{
    SGA_RESERVE(c->check, c->cap, (size_t)c->count + 1);
    c->check[c->count++] = (struct check){ .factor = factor };
}

/* A squarefree factor with several blocks at some root: by its irreducible factors. */
static void split(struct search *s, struct pencil_structure *out, struct checks *c, const fmpz_poly_t f, int multiplicity)
{
    fmpz_poly_factor_t irreducible;
    fmpz_poly_factor_init(irreducible);
    fmpz_poly_factor(irreducible, f);
    for (slong i = 0; i < irreducible->num; i++) {
        int k = add_factor(out, irreducible->p + i, multiplicity);
        if (irreducible->num == 1 || !one_block(s, irreducible->p + i))
            add_check(c, k);
    }
    fmpz_poly_factor_clear(irreducible);
}

/* Bits of the minors whose vanishing the nullities rest on. */
static double bits_of(const struct search *s, const struct pencil_factor *f, int steps)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t power = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t norm = { 0 };
    slong e;
    fmpz_poly_pow(power, f->f, (ulong)steps);
    for (slong i = 0; i < fmpz_poly_length(power); i++)
        fmpz_addmul(norm, power->coeffs + i, power->coeffs + i);
    double lead = fmpz_get_d_2exp(&e, norm);
    return (double)fmpz_poly_degree(power) * s->p.apart + s->p.rows * 0.5 * (log2(lead) + (double)e + 1e-9);
}

/* One prime's word on a check: -1 more generic than before (taken over), 0 the same, 1 to be
 * dropped. J is a sum of blocks modulo a prime too, and nullities there are never too small. */
static int hear(struct check *c, const struct pencil_factor *f, const nmod_mat_t J, double *work)
{
    int *now = sga_calloc((size_t)f->multiplicity + 1, sizeof *now);
    int steps = nullities(f, J, now, f->multiplicity, work), verdict = steps ? (c->nullity ? 0 : -1) : 1;
    for (int k = 0; verdict == 0 && k < steps && k < c->steps; k++)
        verdict = (now[k] > c->nullity[k]) - (now[k] < c->nullity[k]);
    if (verdict < 0) {
        free(c->nullity);
        c->nullity = now;
        c->steps = steps;
    } else {
        free(now);
    }
    return verdict;
}

static bool decide(struct search *s, struct pencil_structure *out, struct checks *c)
{
    int agree = 0;
    double before = s->work;
    struct structure_mod m;
    for (;;) {
        double need = 1;
        if (!search_next(s, &m))
            return false;
        bool fits = structure_mod_compare(&m, &s->reference) == 0;
        for (int i = 0; fits && i < c->count; i++) {
            int word = hear(c->check + i, out->factor + c->check[i].factor, m.finite, &s->work);
            fits = word <= 0;
            if (word < 0)
                agree = 0;
        }
        agree += fits;
        structure_mod_clear(&m);
        if (!agree)
            continue;
        for (int i = 0; i < c->count; i++)
            need = fmax(need, bits_of(s, out->factor + c->check[i].factor, c->check[i].steps));
        if ((double)agree * PRIME_BITS > need)
            return true;
        if (agree >= 3 && (s->work - before) / agree * (need / PRIME_BITS) > s->max_work) {
            out->basis = PENCIL_MODULAR;
            return true;
        }
    }
}

/* nullity_k - nullity_(k-1) = deg f times the number of blocks of size k or more */
static void blocks(const struct check *c, struct pencil_factor *f)
{
    int d = (int)fmpz_poly_degree(f->f), *size = f->block;
    f->blocks = c->nullity[0] / d;
    assert(c->nullity[0] % d == 0 && f->blocks > 0);
    for (int i = 0; i < f->blocks; i++)
        size[i] = 0;
    for (int k = 0; k < c->steps; k++)
        for (int i = 0; i < (c->nullity[k] - (k ? c->nullity[k - 1] : 0)) / d; i++)
            size[i]++;
}

bool spectrum_factors(struct search *s, const fmpz_poly_t chi, struct pencil_structure *out)
{
    fmpz_poly_factor_t squarefree;
    struct checks c = { .count = 0 };
    fmpz_poly_factor_init(squarefree);
    if (fmpz_poly_degree(chi) > 0)
        fmpz_poly_factor_squarefree(squarefree, chi);
    for (slong i = 0; i < squarefree->num; i++) {
        fmpz_poly_struct *f = squarefree->p + i;
        int multiplicity = (int)squarefree->exp[i];
        if (fmpz_sgn(fmpz_poly_lead(f)) < 0)
            fmpz_poly_neg(f, f);
        if (multiplicity == 1 || one_block(s, f))
            add_factor(out, f, multiplicity);
        else
            split(s, out, &c, f, multiplicity);
    }
    fmpz_poly_factor_clear(squarefree);
    bool ok = !c.count || decide(s, out, &c);
    for (int i = 0; i < c.count; i++) {
        if (ok)
            blocks(c.check + i, out->factor + c.check[i].factor);
        free(c.check[i].nullity);
    }
    free(c.check);
    return ok;
}

int pencil_invariant_factors(const struct pencil_structure *s)
{
    int n = 0;
    for (int i = 0; i < s->factors; i++)
        n = s->factor[i].blocks > n ? s->factor[i].blocks : n;
    return n;
}

void pencil_invariant_factor(const struct pencil_structure *s, int k, fmpz_poly_t out)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t t = { 0 };
    fmpz_poly_one(out);
    for (int i = 0; i < s->factors; i++) {
        if (k >= s->factor[i].blocks)
            continue;
        fmpz_poly_pow(t, s->factor[i].f, (ulong)s->factor[i].block[k]);
        fmpz_poly_mul(out, out, t);
    }
}
