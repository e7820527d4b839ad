/* Equilibria as zeros of polynomials: how many there are, and where. */
#include "equilibria.h"

#include <arb_poly.h>

#include "arb_ends.h"
#include "equilibria_shape.h"
#include "linearize.h"
#include "reduction.h"
#include "roots.h"
#include "system.h"

/* Bits of roots: doubled until the places are told to DIGITS. */
enum { FIRST_BITS = 128, MOST_BITS = 8192, TOLD_BITS = 40 };

/* Functions that vanish at rest: alpha, as the velocities are 0 there, restrictions, what is held; `part`: the constraints too. */
static enum poly_count count(struct poly_real_zeros *z, const struct linear_request *rq, const expr_id *held, int helds, bool part)
{
    const struct sys_system *sys = rq->sys;
    SGA_ARENA(mem);
    expr_id *e = sga_take(&mem, ((size_t)equilibria_functions_most(rq, helds) + 1) * sizeof *e);
    int *symbol = sga_take(&mem, ((size_t)sys->variables + 1) * sizeof *symbol), n = equilibria_functions(rq, held, helds, part, e);
    for (int k = 0; k < sys->variables; k++)
        symbol[k] = sys->variable[k].symbol;
    return poly_real_zeros(sys->store, e, n, symbol, sys->variables, rq->budget, z);
}

/* over/below at the root; false: more bits are needed. */
static bool quotient(const fmpz_poly_struct *over, const arb_t below, const arb_t at, slong bits, double *out)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    arb_poly_t p;
    arb_poly_init(p);
    arb_poly_set_fmpz_poly(p, over, bits);
    arb_poly_evaluate(v, p, at, bits);
    arb_poly_clear(p);
    arb_div(v, v, below, bits);
    *out = arf_get_d(arb_midref(v), ARF_RND_NEAR);
    return arb_is_finite(v) && (arb_rel_accuracy_bits(v) >= TOLD_BITS || mag_cmp_2exp_si(arb_radref(v), -2 * TOLD_BITS) < 0);
}

static void value_at(arb_t out, const fmpz_poly_struct *p, const arb_t at, slong bits)
{
    arb_poly_t q;
    arb_poly_init(q);
    arb_poly_set_fmpz_poly(q, p, bits);
    arb_poly_evaluate(out, q, at, bits);
    arb_poly_clear(q);
}

/* Whether p vanishes at the root of z, in whose ball it may: they have a factor in common that does. */
static bool vanishes(const struct poly_real_zeros *z, const fmpz_poly_struct *p, const arb_t at, slong bits)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    fmpz_poly_t common;
    fmpz_poly_init(common);
    fmpz_poly_gcd(common, z->root, p);
    value_at(v, common, at, bits);
    bool is = fmpz_poly_degree(common) > 0 && arb_contains_zero(v);
    fmpz_poly_clear(common);
    return is;
}

/* Whether roots of expressions have the signs that they have: 1, or 0; -1: more bits are needed. */
static int signs_hold(const struct poly_real_zeros *z, const arb_t below, const arb_t at, slong bits)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    int hold = 1;
    for (int k = 0; k < z->roots && hold == 1; k++) {
        if (!z->nonnegative[k])
            continue;
        const fmpz_poly_struct *over = z->over + z->symbols + k;
        value_at(v, over, at, bits);
        if (arb_contains_zero(v) && vanishes(z, over, at, bits))
            continue;
        arb_div(v, v, below, bits);
        hold = arb_is_positive(v) ? 1 : arb_is_negative(v) ? 0 : -1;
    }
    return hold;
}

static bool place_at(const struct poly_real_zeros *z, const arb_t below, const arb_t at, slong bits, double *x)
{
    bool ok = true;
    for (int k = 0; k < z->symbols && ok; k++)
        ok = quotient(z->over + k, below, at, bits, x + k);
    return ok;
}

/* All real zeros, with so many bits; *real: those where roots of expressions have their signs. */
static bool find_places(struct equilibria_algebra *a, const struct poly_real_zeros *z, slong bits, long *real)
{
    SGA_ENDS(arb_end) arb_t below = { 0 };
    struct root_list l = { 0 };
    bool ok = true;
    root_list_of(&l, z->root, 0, bits);
    a->places = 0;
    *real = 0;
    for (int k = 0; k < l.count && ok; k++) {
        arb_srcptr at = acb_realref(&l.root[k].value);
        if (!acb_is_real(&l.root[k].value) || a->places >= z->real)
            continue;
        value_at(below, z->below, at, bits);
        int hold = signs_hold(z, below, at, bits);
        ok = hold >= 0;
        if (hold == 1 && (ok = place_at(z, below, at, bits, a->place[a->places]))) {
            a->places++;
            ++*real;
        }
    }
    root_list_clear(&l);
    return ok;
}

static bool has_signs(const struct poly_real_zeros *z)
{
    bool has = false;
    for (int k = 0; k < z->roots; k++)
        has |= z->nonnegative[k];
    return has;
}

void equilibria_by_algebra(struct equilibria_algebra *a, const struct linear_request *rq, const expr_id *held, int helds, bool parts)
{
    struct poly_real_zeros z;
    bool ok = false;
    *a = (struct equilibria_algebra){ .on_part = -1 };
    a->status = count(&z, rq, held, helds, false);
    a->real = z.real;
    if (a->status == POLY_COUNTED && z.over) {
        long real = 0;
        a->place = sga_take(&a->mem, ((size_t)z.real + 1) * sizeof *a->place);
        for (long k = 0; k < z.real; k++)
            a->place[k] = sga_zeros(&a->mem, (size_t)z.symbols + 1, sizeof **a->place);
        for (slong bits = FIRST_BITS; bits <= MOST_BITS && !ok; bits *= 2)
            ok = find_places(a, &z, bits, &real);
        a->places = ok ? a->places : 0;
        a->real = ok ? real : z.real;
    }
    if (a->status == POLY_COUNTED && z.real && !ok && has_signs(&z))
        a->status = POLY_NOT_COUNTED;        /* some may be none */
    poly_real_zeros_clear(&z);
    if (a->status != POLY_COUNTED || !parts)
        return;
    if (count(&z, rq, held, helds, true) == POLY_COUNTED && !has_signs(&z))
        a->on_part = z.real;
    poly_real_zeros_clear(&z);
}

void equilibria_algebra_clear(struct equilibria_algebra *a)
{
    sga_arena_end(&a->mem);
}
