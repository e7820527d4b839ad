/* Sizes estimated before work is done: FLINT neither stops nor fails, it aborts. */
#include "bridge.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "mpoly_take.h"
#include "watch.h"

/* Intermediate polynomials may be this much longer than results: things cancel. */
enum { SLACK = 4, WORK = 128 };

struct poly_limits poly_limits_of(enum poly_size size, const struct sga_budget *budget)
{
    static const struct poly_limits table[] = {
#define X(name, terms, bits, degree, generators, why) { terms, bits, degree, generators, NULL },
        POLY_SIZE_TABLE(X)
#undef X
    };
    struct poly_limits limits = table[size];
    limits.budget = budget;
    assert(limits.max_terms > 0 && limits.max_degree > 0);
    return limits;
}

/* Exponents as machine words, where they fit: FLINT's own total degree makes big integers of all of them. */
long poly_degree(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    enum { GENERATORS = 64 };
    ulong exp[GENERATORS];
    slong n = fmpz_mpoly_ctx_nvars(b->ctx);
    if (fmpz_mpoly_is_zero(f, b->ctx))
        return 0;
    if (n > GENERATORS || f->bits > FLINT_BITS / 4)
        return fmpz_mpoly_total_degree_fits_si(f, b->ctx) ? fmpz_mpoly_total_degree_si(f, b->ctx) : WORD_MAX;
    ulong most = 0;
    for (slong i = 0; i < f->length; i++) {
        ulong degree = 0;
        poly_exponents(b, f, i, exp);
        for (slong g = 0; g < n; g++)
            degree += exp[g];
        most = degree > most ? degree : most;
    }
    return (long)most;
}

bool poly_surely_prime(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    for (int g = 0; g < b->gens; g++) {
        int with = 0;
        ulong highest = 0;
        for (slong i = 0; i < f->length && highest < 2 && with < 2; i++) {
            ulong e = fmpz_mpoly_get_term_var_exp_ui(f, i, g, b->ctx);
            with += e > 0;
            highest = e > highest ? e : highest;
        }
        if (highest == 1 && with == 1)
            return true;
    }
    return false;
}

static double bits_of(const fmpz_mpoly_t f)
{
    return fabs((double)fmpz_mpoly_max_bits(f));
}

bool poly_fits(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    return f->length <= SLACK * b->limits.max_terms && bits_of(f) <= (double)b->limits.max_bits;
}

void poly_content(fmpz_t c, const fmpz_mpoly_t f)
{
    _fmpz_vec_content(c, f->coeffs, f->length);
}

void poly_exponents(const struct poly_bridge *b, const fmpz_mpoly_t f, slong i, ulong *exp)
{
    assert(i >= 0 && i < f->length);
    fmpz_mpoly_get_term_exp_ui(exp, f, i, b->ctx);
}

double poly_box(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    SGA_FREED slong *degree = sga_malloc((size_t)b->max_gens * sizeof *degree);
    double box = 1;
    if (fmpz_mpoly_degrees_fit_si(f, b->ctx)) {
        fmpz_mpoly_degrees_si(degree, f, b->ctx);
        for (int i = 0; i < b->gens; i++)
            box *= degree[i] > 0 ? (double)degree[i] + 1 : 1;
    } else {
        box = INFINITY;
    }
    return box;
}

/* Exponent fields of up to 8 bits cannot hold degrees that matter: the common case
 * does not look at its exponents at all. */
static bool degrees_fit(const struct poly_bridge *b, const fmpz_mpoly_t x, const fmpz_mpoly_t y)
{
    if (x->bits <= 8 && y->bits <= 8)
        return true;
    return (double)poly_degree(b, x) + (double)poly_degree(b, y) <= (double)b->limits.max_degree;
}

bool poly_mul(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, const fmpz_mpoly_t y)
{
    double products = (double)x->length * (double)y->length;
    if (products > (double)WORK * (double)b->limits.max_terms)
        return false;
    if (bits_of(x) + bits_of(y) > (double)b->limits.max_bits || !degrees_fit(b, x, y))
        return false;
    sga_watch_count(SGA_COUNT_TERMS, (long)products);
    fmpz_mpoly_mul(out, x, y, b->ctx);
    return out->length <= SLACK * b->limits.max_terms;
}

/* log of the binomial coefficient (n + k choose k) */
static double log_binomial(double n, double k)
{
    return lgamma(n + k + 1) - lgamma(n + 1) - lgamma(k + 1);
}

/* log of the number of monomials that x^n can have at most: of the multinomial, or of the
 * box of its degrees where monomials coincide, as in (1 + x + x^2)^n. */
static double log_power_terms(const struct poly_bridge *b, const fmpz_mpoly_t x, double n)
{
    double terms = log_binomial(n, (double)x->length - 1), box = 0;
    if (!fmpz_mpoly_degrees_fit_si(x, b->ctx))
        return terms;
    SGA_FREED slong *degree = sga_malloc((size_t)b->max_gens * sizeof *degree);
    fmpz_mpoly_degrees_si(degree, x, b->ctx);
    for (int i = 0; i < b->gens; i++)
        box += log((double)degree[i] * n + 1);
    return fmin(terms, box);
}

bool poly_pow(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, long n)
{
    assert(n >= 0);
    if (x->length > 1 && log_power_terms(b, x, (double)n) > log((double)(SLACK * b->limits.max_terms)))
        return false;
    if ((double)poly_degree(b, x) * (double)n > (double)b->limits.max_degree
        || (bits_of(x) - 1 + log2((double)x->length + 1)) * (double)n > (double)b->limits.max_bits)
        return false;
    return fmpz_mpoly_pow_ui(out, x, (ulong)n, b->ctx) && poly_fits(b, out);
}

bool poly_divides(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, const fmpz_mpoly_t y)
{
    assert(y->length > 0);
    if (y->length > 1) {
        /* a wrong guess may grow a long quotient before it is found out */
        if (y->length > 2 && (x->bits > 8 || poly_degree(b, x) > 60) && poly_box(b, x) > 1e5)
            return false;
        if (x->length < 2)
            return false;
    }
    SGA_ARENA(mem);
    fmpz_mpoly_struct *q = mpoly_take(&mem, b->ctx);
    bool exact = fmpz_mpoly_divides(q, x, y, b->ctx);
    if (exact)
        fmpz_mpoly_swap(out, q, b->ctx);
    return exact;
}

bool poly_gcd(struct poly_bridge *b, fmpz_mpoly_t out, const fmpz_mpoly_t x, const fmpz_mpoly_t y)
{
    double work = (double)x->length * (double)y->length;
    if (work > 2e5 || (poly_degree(b, x) > 60 && poly_box(b, x) > 1e6))
        return false;
    return fmpz_mpoly_gcd(out, x, y, b->ctx);
}
