/* Equilibria as zeros of polynomials: how many there are, and where. */
#include "equilibria.h"

#include <arb_poly.h>
#include <assert.h>

#include "arb_ends.h"
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
    int most = sys->rows + sys->restrictions + helds + rq->sol->constraints, n = 0;
    SGA_ARENA(mem);
    expr_id *e = sga_take(&mem, ((size_t)most + 1) * sizeof *e);
    int *symbol = sga_take(&mem, ((size_t)sys->variables + 1) * sizeof *symbol);
    for (int i = 0; i < sys->rows; i++)
        e[n++] = sys->row[i].alpha;
    for (int i = 0; i < sys->restrictions; i++)
        e[n++] = sys->restriction[i];
    for (int i = 0; i < helds; i++)
        e[n++] = held[i];
    for (int i = 0; i < rq->sol->constraints && part; i++)
        e[n++] = rq->sol->constraint[i].expr;
    assert(n <= most);
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

static bool place_at(const struct poly_real_zeros *z, const arb_t at, slong bits, double *x)
{
    SGA_ENDS(arb_end) arb_t below = { 0 };
    arb_poly_t p;
    bool ok = true;
    arb_poly_init(p);
    arb_poly_set_fmpz_poly(p, z->below, bits);
    arb_poly_evaluate(below, p, at, bits);
    arb_poly_clear(p);
    for (int k = 0; k < z->symbols && ok; k++)
        ok = quotient(z->over + k, below, at, bits, x + k);
    return ok;
}

/* All real zeros, with so many bits. */
static bool find_places(struct equilibria_algebra *a, const struct poly_real_zeros *z, slong bits)
{
    struct root_list l = { 0 };
    bool ok = true;
    root_list_of(&l, z->root, 0, bits);
    a->places = 0;
    for (int k = 0; k < l.count && ok; k++)
        if (acb_is_real(&l.root[k].value) && a->places < a->real)
            ok = place_at(z, acb_realref(&l.root[k].value), bits, a->place[a->places++]);
    root_list_clear(&l);
    return ok;
}

void equilibria_by_algebra(struct equilibria_algebra *a, const struct linear_request *rq, const expr_id *held, int helds, bool parts)
{
    struct poly_real_zeros z;
    *a = (struct equilibria_algebra){ .on_part = -1 };
    a->status = count(&z, rq, held, helds, false);
    a->real = z.real;
    if (a->status == POLY_COUNTED && z.over) {
        bool ok = false;
        a->place = sga_take(&a->mem, ((size_t)z.real + 1) * sizeof *a->place);
        for (long k = 0; k < z.real; k++)
            a->place[k] = sga_zeros(&a->mem, (size_t)z.symbols + 1, sizeof **a->place);
        for (slong bits = FIRST_BITS; bits <= MOST_BITS && !ok; bits *= 2)
            ok = find_places(a, &z, bits);
        a->places = ok ? a->places : 0;
    }
    poly_real_zeros_clear(&z);
    if (a->status != POLY_COUNTED || !parts)
        return;
    if (count(&z, rq, held, helds, true) == POLY_COUNTED)
        a->on_part = z.real;
    poly_real_zeros_clear(&z);
}

void equilibria_algebra_clear(struct equilibria_algebra *a)
{
    sga_arena_end(&a->mem);
}
