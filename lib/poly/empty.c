/* Sets without real points: Stengle's Positivstellensatz with squares of low degree. */
#include "gram.h"

#include <stdlib.h>

#include "arena.h"
#include "mem.h"
#include "mpoly_take.h"

enum { HIGHEST = 2 /* half the degree of the squares, beyond what the functions ask for */ };

/* Drops zeros; true: one is a number, which has none. */
static bool settle(struct poly_bridge *b, fmpz_mpoly_struct *f, int *n)
{
    bool never = false;
    int kept = 0;
    for (int i = 0; i < *n; i++) {
        if (fmpz_mpoly_is_zero(f + i, b->ctx))
            continue;
        never |= fmpz_mpoly_is_fmpz(f + i, b->ctx) != 0;
        fmpz_mpoly_swap(f + kept++, f + i, b->ctx);
    }
    *n = kept;
    return never;
}

/* -1 = squares + multiples of f[0 .. n) */
static bool by_squares(struct poly_bridge *b, const fmpz_mpoly_struct *f, int n)
{
    struct gram_proof p;
    SGA_ARENA(mem);
    bool found = false;
    if (!n || !gram_within(b, n <= GRAM_GIVEN, SGA_LIMIT_GRAM_GIVEN))
        return false;
    fmpz_mpoly_struct *minus_one = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_set_si(minus_one, -1, b->ctx);
    for (int least = 1; least <= HIGHEST && !found; least++) {
        found = gram_prove_with(b, minus_one, f, n, least, &p);
        if (found)
            gram_proof_clear(&p);
    }
    return found;
}

bool poly_never_together(struct expr_store *st, const expr_id *e, int n, const struct poly_limits *limits)
{
    if (n > SGA_MOST_GIVEN_TOGETHER)
        sga_limit_open(limits ? limits->budget : NULL, SGA_LIMIT_GIVEN_TOGETHER);
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = n > SGA_MOST_GIVEN_TOGETHER ? NULL : poly_bridge_new(st, e, n, limits);
    if (!b)
        return false;
    SGA_FREED fmpz_mpoly_struct *f = sga_malloc(((size_t)n + 1) * sizeof *f);
    int used = 0, left;
    for (int i = 0; i < n; i++)
        fmpz_mpoly_init(f + i, b->ctx);
    for (int i = 0; i < n; i++)      /* one that is too large is left out */
        used += poly_numerator(b, e[i], f + used);
    left = used;
    bool never = poly_use_up(b, NULL, f, used) && (settle(b, f, &left) || by_squares(b, f, left));
    for (int i = 0; i < n; i++)
        fmpz_mpoly_clear(f + i, b->ctx);
    return never;
}
