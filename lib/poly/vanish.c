/* Whether one function is zero wherever others are: generators that one of these is solved for are used up. */
#include "bridge.h"

#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "mpoly_take.h"
#include "warnings.h"

enum { POWER = 3 };

bool poly_numerator(struct poly_bridge *b, expr_id e, fmpz_mpoly_t out)
{
    const struct poly_ratio *r = poly_value(b, e);
    struct poly_fraction f;
    if (!r || !poly_fraction_of(b, r, &f))
        return false;
    fmpz_mpoly_set(out, f.num, b->ctx);
    poly_fraction_clear(b, &f);
    return true;
}

/* f = c g + rest with a number c: the generator g, or -1. */
static int solved_for(struct poly_bridge *b, const fmpz_mpoly_t f, fmpz_mpoly_t c, fmpz_mpoly_t rest)
{
    for (int g = 0; g < b->gens; g++) {
        slong var = g;
        ulong power = 1;
        if (fmpz_mpoly_degree_si(f, g, b->ctx) != 1)
            continue;
        fmpz_mpoly_get_coeff_vars_ui(c, f, &var, &power, 1, b->ctx);
        if (!fmpz_mpoly_is_fmpz(c, b->ctx))
            continue;
        power = 0;
        fmpz_mpoly_get_coeff_vars_ui(rest, f, &var, &power, 1, b->ctx);
        fmpz_mpoly_neg(rest, rest, b->ctx);
        return g;
    }
    return -1;
}

bool poly_use_up(struct poly_bridge *b, fmpz_mpoly_struct *target, fmpz_mpoly_struct *given, int n)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *c = mpoly_take(&mem, b->ctx), *rest = mpoly_take(&mem, b->ctx);
    bool ok = true;
    for (int i = 0; i < n && ok; i++) {
        int g = -1;
        for (int k = i; k < n && g < 0; k++) {
            g = solved_for(b, given + k, c, rest);
            if (g >= 0)
                fmpz_mpoly_swap(given + k, given + i, b->ctx);
        }
        if (g < 0)
            break;
        for (int k = i + 1; k < n && ok; k++)
            ok = poly_reduce_by(b, given + k, g, 1, rest, c) >= 0;
        ok = ok && (!target || poly_reduce_by(b, target, g, 1, rest, c) >= 0);
        fmpz_mpoly_zero(given + i, b->ctx);
    }
    return ok;
}

/* A power of the target is a multiple of one of those left. */
static bool multiple(struct poly_bridge *b, const fmpz_mpoly_t target, const fmpz_mpoly_struct *given, int n)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct *power = mpoly_take(&mem, b->ctx), *quotient = mpoly_take(&mem, b->ctx);
    bool found = false, ok = poly_pow(b, power, target, POWER);
    for (int i = 0; i < n && ok && !found; i++)
        found = !fmpz_mpoly_is_zero(given + i, b->ctx) && poly_divides(b, quotient, power, given + i);
    return found;
}

bool poly_vanish(struct poly_bridge *b, const fmpz_mpoly_t target, const fmpz_mpoly_struct *const *given, int n)
{
    SGA_FREED fmpz_mpoly_struct *f = sga_malloc(((size_t)n + 1) * sizeof *f);
    for (int i = 0; i <= n; i++) {
        fmpz_mpoly_init(f + i, b->ctx);
        fmpz_mpoly_set(f + i, i < n ? given[i] : target, b->ctx);
    }
    bool yes = n <= SGA_MOST_GIVEN_TOGETHER && poly_use_up(b, f + n, f, n) && (fmpz_mpoly_is_zero(f + n, b->ctx) || multiple(b, f + n, f, n));
    for (int i = 0; i <= n; i++)
        fmpz_mpoly_clear(f + i, b->ctx);
    return yes;
}

bool poly_bridge_vanishes_with(struct poly_bridge *b, expr_id target, const expr_id *given, int n)
{
    if (n > SGA_MOST_GIVEN_TOGETHER) {
        sga_limit_open(b->limits.budget, SGA_LIMIT_GIVEN_TOGETHER);
        return false;
    }
    SGA_FREED fmpz_mpoly_struct *f = sga_malloc(((size_t)n + 1) * sizeof *f);
    const fmpz_mpoly_struct *known[SGA_MOST_GIVEN_TOGETHER] = { 0 };
    for (int i = 0; i <= n; i++)
        fmpz_mpoly_init(f + i, b->ctx);
    bool ok = poly_numerator(b, target, f + n);
    int used = 0;
    for (int i = 0; i < n && ok; i++)      /* one that is too large is left out */
        if (poly_numerator(b, given[i], f + used)) {
            known[used] = f + used;
            used++;
        }
    ok = ok && poly_vanish(b, f + n, known, used);
    for (int i = 0; i <= n; i++)
        fmpz_mpoly_clear(f + i, b->ctx);
    return ok;
}

/* Whether some target does, asked in one bridge: what is given is converted once. */
static bool vanishes_some(struct expr_store *st, const expr_id *target, int targets, const expr_id *given, int n, const struct poly_limits *limits,
                          bool *asked)
{
    SGA_FREED expr_id *root = sga_malloc((size_t)(n + targets) * sizeof *root);
    for (int i = 0; i < n + targets; i++)
        root[i] = i < n ? given[i] : target[i - n];
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = poly_bridge_new(st, root, n + targets, limits);
    bool yes = false;
    for (int i = 0; i < targets && b && !yes; i++)
        yes = poly_bridge_vanishes_with(b, target[i], given, n);
    *asked = b && b->bases < POLY_MAX_BASE;
    return yes;
}

bool poly_vanishes_with(struct expr_store *st, expr_id target, const expr_id *given, int n, const struct poly_limits *limits)
{
    bool asked;
    return vanishes_some(st, &target, 1, given, n, limits, &asked);
}

bool poly_any_vanishes_with(struct expr_store *st, const expr_id *target, int targets, const expr_id *given, int n,
                            const struct poly_limits *limits)
{
    bool asked, yes = targets > 0 && vanishes_some(st, target, targets, given, n, limits, &asked);
    for (int i = 0; i < targets && targets > 1 && !yes && !asked; i++)     /* together they are too many for one */
        yes = poly_vanishes_with(st, target[i], given, n, limits);
    return yes;
}
