/* From expressions to an ideal, and what its algebra tells. */
#include "real_zeros.h"

#include <assert.h>
#include <string.h>

#include "bridge.h"
#include "budget.h"
#include "hermite.h"
#include "mpoly_take.h"

/* Of processor time, for what is a proof beside a search. */
static const double SECONDS = 3;
/* Equations and variables that are looked at. */
enum { MOST_SYMBOLS = 40, MOST_EQUATIONS = 120 };

/* The generators of the bridge as variables: symbols that are asked for, then roots, which have a relation; -1: another one. False: no symbol is asked for. */
static bool variables_of(const struct poly_bridge *b, const int *symbol, int symbols, int *place, int *roots)
{
    bool any = false;
    *roots = 0;
    for (int g = 0; g < b->gens; g++) {
        place[g] = -1;
        for (int k = 0; k < symbols; k++)
            if (b->gen[g].node == b->st->symbol[symbol[k]].node)
                place[g] = k;
        any |= place[g] >= 0;
    }
    for (int g = 0; g < b->gens; g++)
        if (place[g] < 0 && b->gen[g].degree > 1 && b->gen[g].op != EXPR_SIN && b->gen[g].op != EXPR_COS && b->gen[g].op != EXPR_SINH && b->gen[g].op != EXPR_COSH)
            place[g] = symbols + (*roots)++;
    return any;
}

/* f in the variables of the ideal. False: it has other generators. */
static bool in_variables(const struct poly_ideal *I, const struct poly_bridge *b, const fmpz_mpoly_struct *f, const int *place, fmpz_mpoly_struct *own)
{
    SGA_ARENA(mem);
    ulong *exp = sga_take(&mem, (size_t)b->max_gens * sizeof *exp), *to = sga_take(&mem, (size_t)I->n * sizeof *to);
    for (slong i = 0; i < f->length; i++) {
        memset(to, 0, (size_t)I->n * sizeof *to);
        poly_exponents(b, f, i, exp);
        for (int g = 0; g < b->gens; g++) {
            if (exp[g] && place[g] < 0)
                return false;
            if (exp[g])
                to[place[g]] = exp[g];
        }
        fmpz_mpoly_push_term_fmpz_ui(own, f->coeffs + i, to, I->ctx);
    }
    fmpz_mpoly_sort_terms(own, I->ctx);
    return true;
}

/* The numerator of e, or nothing where it has other generators. False: over the limits. */
static bool add_numerator(struct poly_ideal *I, struct poly_bridge *b, expr_id e, const int *place)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *f = mpoly_take(&mem, b->ctx), *own = mpoly_take(&mem, I->ctx);
    if (!poly_numerator(b, e, f))
        return false;
    if (in_variables(I, b, f, place, own))
        poly_ideal_add(I, own);
    return true;
}

/* q g^degree = p. False: of other generators. */
static bool add_relation(struct poly_ideal *I, const struct poly_bridge *b, int g, const int *place)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *f = mpoly_take(&mem, b->ctx), *own = mpoly_take(&mem, I->ctx);
    fmpz_mpoly_gen(f, g, b->ctx);
    bool ok = fmpz_mpoly_pow_ui(f, f, (ulong)b->gen[g].degree, b->ctx);
    if (!ok)
        return false;
    fmpz_mpoly_mul(f, f, b->gen[g].q, b->ctx);
    fmpz_mpoly_sub(f, f, b->gen[g].p, b->ctx);
    ok = in_variables(I, b, f, place, own);
    if (ok)
        poly_ideal_add(I, own);
    return ok;
}

static enum poly_count count(struct poly_ideal *I, struct poly_real_zeros *out)
{
    struct hermite h;
    long complex_zeros = 0;
    if (!poly_ideal_basis(I))
        return POLY_NOT_COUNTED;
    if (I->count == 1 && fmpz_mpoly_is_fmpz(I->g[0], I->ctx))      /* everything is in the ideal: no zero at all */
        return POLY_COUNTED;
    if (!hermite_finite(I))
        return POLY_MANY;
    bool ok = hermite_find(&h, I) && hermite_signature(&h, &out->real, &complex_zeros);
    if (ok && out->real && sga_budget_ok(I->budget, NULL))
        hermite_by_roots(&h, complex_zeros, out);
    hermite_clear(&h);
    return ok ? POLY_COUNTED : POLY_NOT_COUNTED;
}

void poly_real_zeros_clear(struct poly_real_zeros *z)
{
    sga_arena_end(&z->mem);
    fmpz_poly_clear(z->root);
    fmpz_poly_clear(z->below);
}

enum poly_count poly_real_zeros(struct expr_store *st, const expr_id *e, int n, const int *symbol, int symbols, const struct sga_budget *budget, struct poly_real_zeros *out)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, budget);
    struct poly_ideal I;
    struct sga_budget own = { 0 };
    SGA_ARENA(mem);
    if (budget)
        own = *budget;
    own.warnings = NULL;
    if (!(own.cpu_deadline > 0 && own.cpu_deadline < sga_cpu() + SECONDS))
        own.cpu_deadline = sga_cpu() + SECONDS;
    if (own.deadline > 0)                    /* and a third of the time that is left */
        own.deadline = sga_now() + (own.deadline - sga_now()) / 3;
    int roots = 0;
    *out = (struct poly_real_zeros){ .symbols = symbols };
    fmpz_poly_init(out->root);
    fmpz_poly_init(out->below);
    limits.max_generators = 2 * MOST_SYMBOLS;
    if (symbols < 1 || symbols > MOST_SYMBOLS || n > MOST_EQUATIONS)
        return POLY_NOT_COUNTED;
    struct poly_bridge *b = poly_bridge_new(st, e, n, &limits);
    if (!b)
        return POLY_NOT_COUNTED;
    int *place = sga_take(&mem, ((size_t)b->gens + 1) * sizeof *place);
    enum poly_count status = POLY_MANY;
    bool any = variables_of(b, symbol, symbols, place, &roots);
    poly_ideal_init(&I, symbols + roots, &own);
    out->roots = roots;
    out->nonnegative = sga_zeros(&out->mem, (size_t)roots + 1, 1);
    if (any) {
        bool all = true;
        for (int g = 0; g < b->gens; g++)
            if (place[g] >= symbols) {
                out->nonnegative[place[g] - symbols] = b->gen[g].sign != POLY_ANY;
                all &= add_relation(&I, b, g, place);
            }
        for (int k = 0; k < n; k++)
            all &= add_numerator(&I, b, e[k], place);
        status = count(&I, out);
        status = status == POLY_MANY && !all ? POLY_NOT_COUNTED : status;
    }
    poly_ideal_clear(&I);
    poly_bridge_free(b);
    return status;
}
