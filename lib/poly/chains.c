/* Zeros of several polynomials, split by factors and by what elimination divides by. */
#include "bridge.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>
#include <flint/fmpz_mpoly_factor.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "facts.h"
#include "mem.h"
#include "mpoly_take.h"

/* Larger ones are not split: starts are drawn anywhere, too, so that nothing is cut by these. */
enum { MOST_GIVEN = 12, MOST_CASES = 160, MOST_CHAINS = 24, SPLIT_TERMS = 60, SPLIT_DEGREE = 12 };

struct polys { fmpz_mpoly_struct *f; int count; size_t cap; };

/* A case: `open` is yet to be solved, `solved` is for main[i] each, `apart` is not 0. */
struct chain_case { struct polys open, solved, apart; int *main; size_t main_cap; };

struct splitting {
    struct poly_bridge *b;
    bool *unknown;             /* by generator: a symbol to solve for, in no other generator */
    int most;                  /* polynomials of a chain: those that were given */
    int cases;
    struct poly_chains *out;
};

static void push(const struct poly_bridge *b, struct polys *p, const fmpz_mpoly_t f)
{
    SGA_RESERVE(p->f, p->cap, p->count + 1);
    fmpz_mpoly_init(p->f + p->count, b->ctx);
    fmpz_mpoly_set(p->f + p->count++, f, b->ctx);
}

static void drop(const struct poly_bridge *b, struct polys *p, int i)
{
    assert(i >= 0 && i < p->count);
    fmpz_mpoly_swap(p->f + i, p->f + p->count - 1, b->ctx);
    fmpz_mpoly_clear(p->f + --p->count, b->ctx);
}

static void clear_polys(const struct poly_bridge *b, struct polys *p)
{
    while (p->count)
        drop(b, p, p->count - 1);
    free(p->f);
}

static void copy_polys(const struct poly_bridge *b, struct polys *to, const struct polys *from)
{
    for (int i = 0; i < from->count; i++)
        push(b, to, from->f + i);
}

static struct chain_case copy_case(const struct poly_bridge *b, const struct chain_case *c)
{
    struct chain_case to = { 0 };
    copy_polys(b, &to.open, &c->open);
    copy_polys(b, &to.solved, &c->solved);
    copy_polys(b, &to.apart, &c->apart);
    SGA_RESERVE(to.main, to.main_cap, c->solved.count + 1);
    if (c->solved.count)
        memcpy(to.main, c->main, (size_t)c->solved.count * sizeof *to.main);
    return to;
}

static void clear_case(const struct poly_bridge *b, struct chain_case *c)
{
    clear_polys(b, &c->open);
    clear_polys(b, &c->solved);
    clear_polys(b, &c->apart);
    free(c->main);
}

static bool is_apart(const struct splitting *s, const struct chain_case *c, const fmpz_mpoly_t f)
{
    for (int i = 0; i < c->apart.count; i++)
        if (fmpz_mpoly_equal(c->apart.f + i, f, s->b->ctx))
            return true;
    return false;
}

static bool has_variable(const struct splitting *s, const fmpz_mpoly_t f)
{
    for (int g = 0; g < s->b->gens; g++)
        if (s->b->gen[g].depends & EXPR_HAS_VARIABLE && fmpz_mpoly_degree_si(f, g, s->b->ctx) > 0)
            return true;
    return false;
}

static bool small(const struct splitting *s, const fmpz_mpoly_t f)
{
    return f->length <= SPLIT_TERMS && poly_degree(s->b, f) <= SPLIT_DEGREE;
}

/* The irreducible factors of f that may vanish in the case, for whatever parameters, each once, with a positive leading
 * coefficient. False: f is too large. */
static bool factors(const struct splitting *s, const struct chain_case *c, const fmpz_mpoly_t f, struct polys *out)
{
    struct poly_bridge *b = s->b;
    fmpz_mpoly_factor_t fac;
    if (!small(s, f))
        return false;
    fmpz_mpoly_factor_init(fac, b->ctx);
    bool ok = fmpz_mpoly_factor(fac, f, b->ctx);
    for (slong i = 0; ok && i < fac->num; i++) {
        if (fmpz_sgn(fac->poly[i].coeffs) < 0)
            fmpz_mpoly_neg(fac->poly + i, fac->poly + i, b->ctx);
        if (has_variable(s, fac->poly + i) && !is_apart(s, c, fac->poly + i))
            push(b, out, fac->poly + i);
    }
    fmpz_mpoly_factor_clear(fac, b->ctx);
    return ok;
}

static void keep_chain(struct splitting *s, const struct chain_case *c)
{
    assert(c->open.count == 0);
    struct poly_chains *out = s->out;
    if (out->chains >= MOST_CHAINS || c->solved.count > s->most)
        return;
    struct poly_chain chain = { .count = c->solved.count };
    chain.poly = sga_malloc(((size_t)chain.count + 1) * sizeof *chain.poly);
    for (int i = 0; i < chain.count; i++)
        chain.poly[i] = poly_show_poly(s->b, c->solved.f + i);
    SGA_RESERVE(out->chain, out->cap, out->chains + 1);
    out->chain[out->chains++] = chain;
}

static void split(struct splitting *s, struct chain_case *c);

/* The case where polynomial i of a list (its `open`, or its `solved`) is one of these: each in turn, those before it not 0. */
static void one_of(struct splitting *s, const struct chain_case *c, bool open, int i, const struct polys *which)
{
    for (int k = 0; k < which->count; k++) {
        struct chain_case own = copy_case(s->b, c);
        assert(i < (open ? own.open.count : own.solved.count));
        fmpz_mpoly_set((open ? own.open.f : own.solved.f) + i, which->f + k, s->b->ctx);
        for (int h = 0; h < k; h++)
            push(s->b, &own.apart, which->f + h);
        split(s, &own);
        clear_case(s->b, &own);
    }
}

/* Each open polynomial becomes one that is irreducible. 1: they are; 0: the case is done. */
static int to_factors(struct splitting *s, struct chain_case *c)
{
    struct poly_bridge *b = s->b;
    int go_on = 1;
    for (int i = 0; i < c->open.count && go_on; i++) {
        struct polys which = { 0 };
        if (fmpz_mpoly_is_zero(c->open.f + i, b->ctx))
            drop(b, &c->open, i--);
        else if (!factors(s, c, c->open.f + i, &which) || !which.count)
            go_on = 0;           /* too large; or never 0 */
        else if (which.count == 1)
            fmpz_mpoly_set(c->open.f + i, which.f, b->ctx);
        else {
            one_of(s, c, true, i, &which);
            go_on = 0;
        }
        for (int k = 0; k < i && go_on; k++)
            if (i < c->open.count && fmpz_mpoly_equal(c->open.f + k, c->open.f + i, b->ctx)) {
                drop(b, &c->open, i--);
                break;
            }
        clear_polys(b, &which);
    }
    return go_on;
}

/* What is to be solved next, and for what: of least degree, in what few others have. False: nothing can be solved for. */
static bool choose(const struct splitting *s, const struct chain_case *c, int *at, int *main)
{
    double least = 1e300;
    for (int g = 0; g < s->b->gens; g++) {
        int with = 0;
        for (int i = 0; i < c->open.count && s->unknown[g]; i++)
            with += fmpz_mpoly_degree_si(c->open.f + i, g, s->b->ctx) > 0;
        for (int i = 0; i < c->open.count && with; i++) {
            slong d = fmpz_mpoly_degree_si(c->open.f + i, g, s->b->ctx);
            double cost = 1e6 * (double)d + 1e3 * with + (double)c->open.f[i].length;
            if (d > 0 && cost < least) {
                least = cost;
                *at = i;
                *main = g;
            }
        }
    }
    return least < 1e300;
}

/* f without its terms of degree d in g, which become *lead times g^d. */
static void leading(const struct splitting *s, const fmpz_mpoly_t f, int g, slong d, fmpz_mpoly_t lead, fmpz_mpoly_t rest)
{
    slong var = g;
    ulong power = (ulong)d;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *top = mpoly_take(&mem, s->b->ctx);
    fmpz_mpoly_get_coeff_vars_ui(lead, f, &var, &power, 1, s->b->ctx);
    fmpz_mpoly_gen(top, g, s->b->ctx);
    if (fmpz_mpoly_pow_ui(top, top, power, s->b->ctx))
        fmpz_mpoly_mul(top, top, lead, s->b->ctx);
    fmpz_mpoly_sub(rest, f, top, s->b->ctx);
}

/* The case where p's leading coefficient in g vanishes, and from now on it does not. */
static void by_leading(struct splitting *s, struct chain_case *c, int at, int g)
{
    struct polys which = { 0 };
    SGA_ARENA(mem);
    fmpz_mpoly_struct *lead = mpoly_take(&mem, s->b->ctx), *rest = mpoly_take(&mem, s->b->ctx);
    leading(s, c->open.f + at, g, fmpz_mpoly_degree_si(c->open.f + at, g, s->b->ctx), lead, rest);
    if (factors(s, c, lead, &which) && which.count) {
        struct chain_case own = copy_case(s->b, c);
        fmpz_mpoly_set(own.open.f + at, rest, s->b->ctx);
        push(s->b, &own.open, lead);
        split(s, &own);
        clear_case(s->b, &own);
        for (int k = 0; k < which.count; k++)
            push(s->b, &c->apart, which.f + k);
    }
    clear_polys(s->b, &which);
}

/* Without g: the resultant with p. False: too large. */
static bool eliminate(struct splitting *s, fmpz_mpoly_t f, const fmpz_mpoly_t p, int g)
{
    if (fmpz_mpoly_degree_si(f, g, s->b->ctx) <= 0)
        return true;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *r = mpoly_take(&mem, s->b->ctx);
    bool ok = small(s, f) && small(s, p) && fmpz_mpoly_resultant(r, f, p, g, s->b->ctx) && poly_fits(s->b, r);
    if (ok)
        fmpz_mpoly_swap(f, r, s->b->ctx);
    return ok;
}

/* What was solved before may fall into factors where the later ones hold: true, the case is done by these. */
static bool falls_apart(struct splitting *s, struct chain_case *c)
{
    bool done = false;
    for (int i = 0; i < c->solved.count && !done; i++)
        for (int k = i + 1; k < c->solved.count && !done; k++) {
            struct polys which = { 0 };
            fmpz_mpoly_t f;
            if (c->main[k] < 0 || fmpz_mpoly_degree_si(c->solved.f + k, c->main[k], s->b->ctx) != 1
                || fmpz_mpoly_degree_si(c->solved.f + i, c->main[k], s->b->ctx) <= 0)
                continue;
            fmpz_mpoly_init(f, s->b->ctx);
            fmpz_mpoly_set(f, c->solved.f + i, s->b->ctx);
            if (eliminate(s, f, c->solved.f + k, c->main[k]) && f->length <= c->solved.f[i].length && factors(s, c, f, &which)) {
                if (which.count == 1)
                    fmpz_mpoly_set(c->solved.f + i, which.f, s->b->ctx);
                else
                    one_of(s, c, false, i, &which);
                done = which.count != 1;
            }
            clear_polys(s->b, &which);
            fmpz_mpoly_clear(f, s->b->ctx);
        }
    return done;
}

/* The case where f vanishes too, begun anew. */
static void with(struct splitting *s, const struct chain_case *c, const fmpz_mpoly_t f)
{
    struct chain_case own = { 0 };
    copy_polys(s->b, &own.open, &c->solved);
    copy_polys(s->b, &own.apart, &c->apart);
    push(s->b, &own.open, f);
    split(s, &own);
    clear_case(s->b, &own);
}

/* Two that are not linear in what they have in common may fall into factors together: x^2 + y^2 - 1 and z^2 + y^2 - 1 where x = z, and
 * where x = -z. */
static bool fall_apart_together(struct splitting *s, struct chain_case *c)
{
    bool done = false;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *r = mpoly_take(&mem, s->b->ctx);
    for (int i = 0; i < c->solved.count && !done; i++)
        for (int k = i + 1; k < c->solved.count && !done; k++)
            for (int g = 0; g < s->b->gens && !done; g++) {
                struct polys which = { 0 };
                if (!s->unknown[g] || fmpz_mpoly_degree_si(c->solved.f + i, g, s->b->ctx) < 2 || fmpz_mpoly_degree_si(c->solved.f + k, g, s->b->ctx) < 2)
                    continue;
                fmpz_mpoly_set(r, c->solved.f + i, s->b->ctx);
                done = eliminate(s, r, c->solved.f + k, g) && factors(s, c, r, &which) && which.count > 1;
                for (int h = 0; h < which.count && done; h++)
                    with(s, c, which.f + h);
                clear_polys(s->b, &which);
            }
    return done;
}

static void split(struct splitting *s, struct chain_case *c)
{
    struct poly_bridge *b = s->b;
    int at = 0, g = -1;
    if (++s->cases > MOST_CASES || c->solved.count > s->most || !sga_budget_ok(b->limits.budget, NULL) || !to_factors(s, c))
        return;
    if (!c->open.count) {
        if (!falls_apart(s, c) && !fall_apart_together(s, c))
            keep_chain(s, c);
        return;
    }
    bool ok = true;
    if (choose(s, c, &at, &g))
        by_leading(s, c, at, g);
    SGA_RESERVE(c->main, c->main_cap, c->solved.count + 1);
    c->main[c->solved.count] = g;
    push(b, &c->solved, c->open.f + at);
    drop(b, &c->open, at);
    for (int i = 0; i < c->open.count && ok && g >= 0; i++)
        ok = eliminate(s, c->open.f + i, c->solved.f + c->solved.count - 1, g);
    if (ok)
        split(s, c);
}

bool poly_chains_of(struct expr_store *st, const expr_id *e, int count, const struct poly_limits *limits, struct poly_chains *out)
{
    struct sga_error before = *st->error;
    *out = (struct poly_chains){ 0 };
    SGA_ENDS(poly_bridge_end) struct poly_bridge *b = count <= MOST_GIVEN ? poly_bridge_new(st, e, count, limits) : NULL;
    if (!b)
        return false;
    struct splitting s = { .b = b, .most = count, .out = out };
    struct chain_case all = { 0 };
    s.unknown = sga_calloc((size_t)b->max_gens + 1, sizeof *s.unknown);
    for (int g = 0; g < b->gens; g++)
        s.unknown[g] = b->gen[g].op == EXPR_SYM && b->gen[g].depends & EXPR_HAS_VARIABLE && poly_generator_of(b, b->gen[g].node) == g;
    bool ok = true;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *f = mpoly_take(&mem, b->ctx);
    for (int i = 0; i < count && ok; i++) {
        ok = poly_numerator(b, e[i], f) && small(&s, f);
        if (ok)
            push(b, &all.open, f);
    }
    if (ok)
        split(&s, &all);
    clear_case(b, &all);
    free(s.unknown);
    ok = ok && expr_store_ok(st);
    *st->error = before;
    if (!ok)
        poly_chains_clear(out);
    return ok;
}

void poly_chains_clear(struct poly_chains *c)
{
    for (int i = 0; i < c->chains; i++)
        free(c->chain[i].poly);
    free(c->chain);
    *c = (struct poly_chains){ 0 };
}
