/* Values of a polynomial at random places where its kernels have values, in doubles. */
#include "gram.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

#include "arena.h"
#include "seeds.h"

enum { PLACES = 64 };

static double uniform(uint64_t *state)      /* xorshift, in (-1, 1) */
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return (double)(int64_t)*state / 0x1p63;
}

/* f at x by generator, and the sum of the magnitudes of its terms. */
static double value(const struct poly_bridge *b, const fmpz_mpoly_t f, const double *x, ulong *exp, double *size)
{
    double sum = 0;
    *size = 0;
    for (slong i = 0; i < f->length; i++) {
        double v = fmpz_get_d(f->coeffs + i);
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens; g++)
            if (exp[g])
                v *= pow(x[g], (double)exp[g]);
        sum += v;
        *size += fabs(v);
    }
    return sum;
}

/* A generator without a relation, in its range. */
static double free_value(const struct poly_generator *q, double r, int k)
{
    double wide = r * ldexp(1, k % 9 - 4);
    if (q->op == EXPR_SIN || q->op == EXPR_COS || q->op == EXPR_TANH)
        return r;
    if (q->op == EXPR_PI)
        return 3.14159265358979323846;
    return q->op == EXPR_COSH ? 1 + fabs(wide) : q->sign != POLY_ANY ? fabs(wide) : wide;
}

/* A root, or a sine of its cosine, from what its relation speaks of; NAN: it has no value there. */
static double related_value(const struct poly_bridge *b, const struct poly_generator *q, const double *x, ulong *exp, double r)
{
    double size, p = value(b, q->p, x, exp, &size) / value(b, q->q, x, exp, &size);
    if (!isfinite(p) || (q->degree % 2 == 0 && p < 0))
        return NAN;
    double root = copysign(pow(fabs(p), 1.0 / q->degree), p);
    return q->partner >= 0 && r < 0 ? -root : root;
}

/* All generators' values: the free ones first, a relation speaks of these and of earlier ones. False: there is none here. */
static bool draw(const struct poly_bridge *b, double *x, ulong *exp, int k, uint64_t *random)
{
    bool ok = true;
    for (int g = 0; g < b->gens; g++)
        if (!b->gen[g].degree)
            x[g] = free_value(b->gen + g, uniform(random), k);
    for (int g = 0; g < b->gens && ok; g++)
        if (b->gen[g].degree) {
            x[g] = related_value(b, b->gen + g, x, exp, uniform(random));
            ok = isfinite(x[g]);
        }
    return ok;
}

bool gram_changes_sign(const struct poly_bridge *b, const fmpz_mpoly_t f, int *sign)
{
    static const double CLEAR = 1e-9;
    uint64_t random = SGA_SEED_GRAM_SAMPLES;
    SGA_ARENA(mem);
    double *x = sga_zeros(&mem, (size_t)b->max_gens, sizeof *x), size;
    ulong *exp = sga_take(&mem, (size_t)b->max_gens * sizeof *exp);
    bool changes = false;
    *sign = 0;
    for (int k = 0; k < PLACES && !changes; k++) {
        if (!draw(b, x, exp, k, &random))
            continue;
        double v = value(b, f, x, exp, &size);
        int here = !isfinite(v) || fabs(v) <= CLEAR * size ? 0 : v > 0 ? 1 : -1;
        changes = here && *sign && here != *sign;
        *sign = here && !*sign ? here : *sign;
    }
    return changes;
}
