/* Blocks that are affine, and blocks of one unknown. */
#include "modblock.h"

#include <assert.h>
#include <flint/nmod_poly.h>
#include <flint/nmod_poly_factor.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "modp.h"
#include "points_random.h"
#include "points_space.h"

enum { DEGREE_MOST = 10 };

void modblock_begin(struct modblock *b)
{
    assert(b->n > 0);
    SGA_FREED expr_id *root = sga_malloc((size_t)b->n * sizeof *root);
    for (int i = 0; i < b->n; i++)
        root[i] = b->s->constraint[b->member[i]];
    expr_cone_init(&b->cone);
    expr_cone_of(b->s->st, &b->cone, root, b->n);
    b->x = sga_calloc((size_t)b->n, sizeof *b->x);
    b->value = sga_calloc((size_t)b->n, sizeof *b->value);
}

void modblock_end(struct modblock *b)
{
    expr_cone_clear(&b->cone);
    free(b->x);
    free(b->value);
}

bool modblock_evaluate(struct modblock *b)
{
    *b->work -= b->cone.count;
    for (int i = 0; i < b->n; i++) {
        assert(b->x[i] < b->m->mod.n);
        num_modp_set(b->m, b->s->variable[b->solved[b->member[i]]], b->x[i]);
    }
    num_modp_list(b->m, b->cone.list, b->cone.count);
    bool ok = true;
    for (int i = 0; i < b->n; i++) {
        expr_id e = b->s->constraint[b->member[i]];
        ok &= !num_modp_bad(b->m, e);
        b->value[i] = num_modp_value(b->m, e);
    }
    return ok;
}

bool modblock_vanishes(struct modblock *b)
{
    bool ok = modblock_evaluate(b);
    for (int i = 0; i < b->n; i++)
        ok &= b->value[i] == 0;
    return ok;
}

/* The columns of a linear system by differences from a base point. False: no value somewhere. */
static bool slopes(struct modblock *b, mp_limb_t *slope, mp_limb_t *rest, const mp_limb_t *base)
{
    bool ok = modblock_evaluate(b);
    for (int i = 0; i < b->n; i++)
        rest[i] = b->value[i];
    for (int j = 0; j < b->n && ok; j++) {
        b->x[j] = nmod_add(base[j], 1, b->m->mod);
        ok = modblock_evaluate(b);
        for (int i = 0; i < b->n; i++)
            slope[i * b->n + j] = nmod_sub(b->value[i], rest[i], b->m->mod);
        b->x[j] = base[j];
    }
    return ok;
}

/* Exact where the block is affine in its unknowns; otherwise the check fails. The base point is random, since 0 is often a
 * place without values. */
bool modblock_affine(struct modblock *b, bool *affine, uint64_t *random)
{
    size_t n = (size_t)b->n;
    *affine = false;
    if (*b->work < (long)(b->n + 2) * b->cone.count) {      /* not begun where it cannot come to an end */
        *b->work = -1;
        return false;
    }
    SGA_ARENA(mem);
    mp_limb_t *slope = sga_zeros(&mem, n * n, sizeof *slope), *rest = sga_zeros(&mem, n, sizeof *rest);
    mp_limb_t *base = sga_zeros(&mem, n, sizeof *base);
    for (size_t i = 0; i < n; i++)
        base[i] = b->x[i] = points_random(random) % b->m->mod.n;
    bool ok = slopes(b, slope, rest, base) && num_modp_solve(b->m, slope, rest, b->n);
    for (size_t i = 0; i < n && ok; i++)
        b->x[i] = nmod_sub(base[i], rest[i], b->m->mod);
    bool vanishes = ok && modblock_vanishes(b);
    *affine = vanishes || !ok;
    return vanishes;
}

/* The n - 1 equations other than `equation`, affine in the unknowns other than `torn` once that is given, solved for these. */
static bool solve_others(struct modblock *b, int torn, int equation)
{
    int n = b->n, m = n - 1;
    SGA_ARENA(mem);
    mp_limb_t *slope = sga_zeros(&mem, (size_t)m * (size_t)m + 1, sizeof *slope), *rest = sga_zeros(&mem, (size_t)m + 1, sizeof *rest);
    bool ok = modblock_evaluate(b);
    for (int i = 0; i < m; i++)
        rest[i] = b->value[i + (i >= equation)];
    for (int j = 0; j < m && ok; j++) {
        mp_limb_t *x = b->x + j + (j >= torn), here = *x;
        *x = nmod_add(here, 1, b->m->mod);
        ok = modblock_evaluate(b);
        for (int i = 0; i < m; i++)
            slope[i * m + j] = nmod_sub(b->value[i + (i >= equation)], rest[i], b->m->mod);
        *x = here;
    }
    ok = ok && num_modp_solve(b->m, slope, rest, m);
    for (int j = 0; j < m && ok; j++)
        b->x[j + (j >= torn)] = nmod_sub(b->x[j + (j >= torn)], rest[j], b->m->mod);
    ok = ok && modblock_evaluate(b);
    for (int i = 0; i < m && ok; i++)
        ok = b->value[i + (i >= equation)] == 0;
    return ok;
}

/* The equation as a polynomial in one unknown, the others (equation < 0: none) solved for: through as many points as its degree needs, and a
 * root modulo the prime. */
static bool by_root(struct modblock *b, int unknown, int equation, uint64_t *random)
{
    nmod_t p = b->m->mod;
    mp_limb_t xs[DEGREE_MOST + 1], ys[DEGREE_MOST + 1];
    for (int k = 0; k <= DEGREE_MOST; k++) {
        xs[k] = b->x[unknown] = points_random(random) % p.n;
        if (equation < 0 ? !modblock_evaluate(b) : !solve_others(b, unknown, equation))
            return false;
        ys[k] = b->value[equation < 0 ? 0 : equation];
    }
    SGA_ENDS(nmod_poly_end) nmod_poly_t f;
    nmod_poly_init(f, p.n);
    nmod_poly_interpolate_nmod_vec(f, xs, ys, DEGREE_MOST + 1);
    bool ok = false;
    if (nmod_poly_degree(f) >= 1 && nmod_poly_degree(f) < DEGREE_MOST) {
        nmod_poly_factor_t fac;
        nmod_poly_factor_init(fac);
        nmod_poly_factor(fac, f);
        slong first = (slong)(points_random(random) % (uint64_t)fac->num);    /* any of the components */
        for (slong r = 0; r < fac->num && !ok; r++) {
            slong k = (first + r) % fac->num;
            if (nmod_poly_degree(fac->p + k) != 1)
                continue;
            b->x[unknown] = nmod_div(nmod_neg(nmod_poly_get_coeff_ui(fac->p + k, 0), p),
                                     nmod_poly_get_coeff_ui(fac->p + k, 1), p);
            ok = (equation < 0 || solve_others(b, unknown, equation)) && modblock_vanishes(b);
        }
        nmod_poly_factor_clear(fac);
    }
    return ok;
}

bool modblock_univariate(struct modblock *b, uint64_t *random)
{
    assert(b->n == 1);
    return by_root(b, 0, -1, random);
}

bool modblock_torn_once(struct modblock *b, uint64_t *random)
{
    assert(b->m->power == 1 && b->n <= TORN_MOST);
    bool ok = false;
    for (int e = 0; e < b->n && !ok; e++)
        for (int u = 0; u < b->n && !ok && *b->work > 0; u++)
            ok = by_root(b, u, e, random);
    return ok;
}
