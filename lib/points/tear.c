/* Blocks that are neither affine nor of one unknown, modulo a power of a small prime.
 *
 * A plan lists guesses, equations that are solved for one unknown each, and equations that are left over as checks: as
 * many as guesses. Each guess takes the p residues in turn, in steps of a random length so that no component is met first; what fails goes back to the last guess that it follows from,
 * and a guess that has had them all to the last one before that any of its failures follow from (conflict-directed
 * backjumping; P. Prosser, Comput. Intell. 9 (1993) 268). The p-adic point is the limit of x - J^-1 f(x) with J modulo p. */
#include "modblock.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "modp.h"
#include "points_random.h"
#include "points_space.h"
#include "shape.h"

enum kind { GUESS, SOLVE, CHECK };

struct step {
    enum kind kind;
    int unknown, equation;         /* by member; those that the kind needs */
    enum points_shape shape;       /* of the unknown in the equation */
    uint64_t follows;              /* guesses that it depends on, by number */
    int number;                    /* of a guess */
};

struct plan {
    struct modblock *b;
    unsigned char *shape;          /* n by n: of unknown j in equation i */
    expr_id **moving; int *moves;  /* by equation: its nodes that any unknown changes */
    struct step *step; int steps, guesses;
    int at[TEAR_MOST];         /* by guess: its step */
    mp_limb_t first[TEAR_MOST], stride[TEAR_MOST], tried[TEAR_MOST];
    uint64_t failures[TEAR_MOST];      /* by guess: what its failures follow from, itself left out */
};

static void clear_plan(struct plan *p)
{
    for (int i = 0; i < p->b->n; i++)
        free(p->moving[i]);
    free(p->moving);
    free(p->moves);
    free(p->shape);
    free(p->step);
}

/* False where an unknown lies under a function that is not algebraic. */
static bool look(struct plan *p, struct modblock *b)
{
    size_t n = (size_t)b->n;
    *p = (struct plan){ .b = b, .shape = sga_calloc(n * n, 1), .moving = sga_calloc(n, sizeof *p->moving), .moves = sga_calloc(n, sizeof *p->moves),
                        .step = sga_calloc(2 * n, sizeof *p->step) };
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED unsigned char *here = NULL, *any = NULL;
    size_t here_cap = 0, any_cap = 0;
    bool seen = true;
    expr_cone_init(&cone);
    for (size_t i = 0; i < n; i++) {
        expr_cone_of(b->s->st, &cone, b->s->constraint + b->member[i], 1);
        expr_cone_index(&cone);
        SGA_RESERVE(here, here_cap, cone.count);
        SGA_RESERVE(any, any_cap, cone.count);
        memset(any, 0, (size_t)cone.count);
        for (size_t j = 0; j < n; j++) {
            p->shape[i * n + j] = (unsigned char)points_shape_in(b->s->st, &cone, b->s->variable[b->solved[b->member[j]]], here);
            seen &= p->shape[i * n + j] != POINTS_HIDDEN;
            for (int k = 0; k < cone.count; k++)
                any[k] |= here[k];
        }
        p->moving[i] = sga_malloc(((size_t)cone.count + 1) * sizeof **p->moving);
        for (int k = 0; k < cone.count; k++)
            if (any[k])
                p->moving[i][p->moves[i]++] = cone.list[k];
    }
    return seen;
}

/* Unknowns of equation i that are not known yet, and the one to solve for: affine if there is one, then the one that the
 * fewest equations left contain. */
static int left_in(const struct plan *p, int i, const unsigned char *known, const int *uses, int *best)
{
    int n = p->b->n, left = 0;
    *best = -1;
    for (int j = 0; j < n; j++) {
        enum points_shape s = p->shape[i * n + j], t = *best < 0 ? POINTS_HIDDEN : p->shape[i * n + *best];
        if (s == POINTS_FREE || known[j])
            continue;
        left++;
        if (s < t || (s == t && uses[j] < uses[*best]))
            *best = j;
    }
    return left;
}

static void guess(struct plan *p, int j, uint64_t *follows)
{
    p->at[p->guesses] = p->steps;
    follows[j] = UINT64_C(1) << p->guesses;
    p->step[p->steps++] = (struct step){ .kind = GUESS, .unknown = j, .number = p->guesses++ };
}

static void make_plan(struct plan *p)
{
    int n = p->b->n, uses[TEAR_MOST] = { 0 };
    unsigned char known[TEAR_MOST] = { 0 }, done[TEAR_MOST] = { 0 };
    uint64_t follows[TEAR_MOST] = { 0 };
    for (int i = 0; i < n * n; i++)
        uses[i % n] += p->shape[i] != POINTS_FREE;
    for (int round = 0; round < n; round++) {
        int next = -1, least = 0, solve = -1, best = -1;
        bool affine = false;
        for (int i = 0; i < n; i++) {
            int left = done[i] ? -1 : left_in(p, i, known, uses, &best);
            bool flat = best >= 0 && p->shape[i * n + best] == POINTS_AFFINE;
            if (left < 0 || (next >= 0 && (left > least || (left == least && affine >= flat))))
                continue;
            next = i;
            least = left;
            solve = best;
            affine = flat;
        }
        done[next] = 1;
        uint64_t all = 0;
        for (int j = 0; j < n; j++) {
            if (p->shape[next * n + j] == POINTS_FREE)
                continue;
            uses[j]--;
            if (!known[j] && j != solve)
                guess(p, j, follows);
            known[j] = 1;
            all |= follows[j];
        }
        if (solve >= 0)
            follows[solve] = all;
        p->step[p->steps++] = (struct step){ .kind = solve < 0 ? CHECK : SOLVE, .unknown = solve, .equation = next, .follows = all,
                                             .shape = solve < 0 ? POINTS_FREE : p->shape[next * n + solve] };
    }
}

/* The residue of an equation with unknown j at v; false where it has none. */
static bool residue(struct plan *p, int i, int j, mp_limb_t v, mp_limb_t *r)
{
    struct modblock *b = p->b;
    expr_id e = b->s->constraint[b->member[i]];
    *b->work -= p->moves[i];
    if (j >= 0) {
        b->x[j] = v;
        num_modp_set(b->m, b->s->variable[b->solved[b->member[j]]], v);
    }
    num_modp_list(b->m, p->moving[i], p->moves[i]);
    *r = num_modp_value(b->m, e) % b->m->p;
    return !num_modp_bad(b->m, e);
}

/* The zeros of a polynomial of low degree from its first values, by its differences (C. Babbage's engine). -1: not of that kind, or
 * without a value there; 0: it has none; 1: the unknown is set to one. */
static int by_differences(struct plan *p, const struct step *t, mp_limb_t first, mp_limb_t stride)
{
    enum { VALUES = 8 };          /* degrees below 7, and one value to see it by */
    mp_limb_t prime = p->b->m->p, d[VALUES], r;
    for (int k = 0; k < VALUES; k++)
        if (!residue(p, t->equation, t->unknown, (first + (mp_limb_t)k * stride) % prime, d + k))
            return -1;
    for (int order = 1; order < VALUES; order++)
        for (int k = VALUES - 1; k >= order; k--)
            d[k] = n_submod(d[k], d[k - 1], prime);
    if (d[VALUES - 1])
        return -1;
    for (mp_limb_t k = 0; k < prime; k++) {
        if (d[0] == 0 && residue(p, t->equation, t->unknown, (first + k * stride) % prime, &r) && r == 0)
            return 1;
        for (int order = 0; order + 1 < VALUES; order++)
            d[order] = n_addmod(d[order], d[order + 1], prime);
    }
    return 0;
}

static bool solve_step(struct plan *p, const struct step *t, uint64_t *random)
{
    mp_limb_t prime = p->b->m->p, r, slope;
    if (t->shape == POINTS_AFFINE) {
        if (!residue(p, t->equation, t->unknown, 0, &r) || !residue(p, t->equation, t->unknown, 1, &slope))
            return false;
        slope = n_submod(slope, r, prime);
        return slope && residue(p, t->equation, t->unknown, n_mulmod2(n_negmod(r, prime), n_invmod(slope, prime), prime), &r) && r == 0;
    }
    mp_limb_t first = points_random(random) % prime, stride = 1 + points_random(random) % (prime - 1);
    int known = by_differences(p, t, first, stride);
    for (mp_limb_t k = 0; k < prime && known < 0; k++)
        if (residue(p, t->equation, t->unknown, (first + k * stride) % prime, &r) && r == 0)
            return true;
    return known > 0;
}

/* The last guess among those of the set, or -1. */
static int last_of(uint64_t set)
{
    int g = -1;
    for (; set; set >>= 1)
        g++;
    return g;
}

/* The step to go on with after a failure that follows from these guesses; -1: there is none. */
static int back(struct plan *p, uint64_t set)
{
    int g = last_of(set);
    while (g >= 0) {
        p->failures[g] |= set & ~(UINT64_C(1) << g);
        for (int k = g + 1; k < p->guesses; k++)
            p->tried[k] = 0;
        if (p->tried[g] < p->b->m->p)
            return p->at[g];
        set = p->failures[g];
        p->tried[g] = 0;
        g = last_of(set);
    }
    return -1;
}

static bool search(struct plan *p, uint64_t *random)
{
    mp_limb_t prime = p->b->m->p, r;
    memset(p->tried, 0, sizeof p->tried);
    for (int k = 0; k >= 0 && k < p->steps;) {
        const struct step *t = p->step + k;
        bool ok = true;
        if (*p->b->work < 0)
            return false;
        if (t->kind == GUESS) {
            int g = t->number;
            if (p->tried[g] == 0) {
                p->first[g] = points_random(random) % prime;
                p->stride[g] = 1 + points_random(random) % (prime - 1);
                p->failures[g] = 0;
            }
            struct modblock *b = p->b;
            b->x[t->unknown] = (p->first[g] + p->tried[g]++ * p->stride[g]) % prime;
            num_modp_set(b->m, b->s->variable[b->solved[b->member[t->unknown]]], b->x[t->unknown]);
        } else if (t->kind == SOLVE) {
            ok = solve_step(p, t, random);
        } else {
            ok = residue(p, t->equation, -1, 0, &r) && r == 0;
        }
        k = ok ? k + 1 : back(p, t->follows);
        if (k < 0)
            return false;
    }
    return true;
}

/* False where it is none, or the Jacobian is singular modulo p. */
bool modblock_lift(struct modblock *b)
{
    size_t n = (size_t)b->n;
    mp_limb_t top = b->m->mod.n / b->m->p;
    assert(b->m->power > 1 || top == 1);
    SGA_ARENA(mem);
    mp_limb_t *slope = sga_zeros(&mem, n * n, sizeof *slope), *work = sga_zeros(&mem, n * n, sizeof *work);
    mp_limb_t *r = sga_zeros(&mem, n, sizeof *r);
    bool ok = modblock_evaluate(b);
    memcpy(r, b->value, n * sizeof *r);
    for (size_t i = 0; i < n; i++)
        ok = ok && r[i] % b->m->p == 0;
    for (size_t j = 0; j < n && ok; j++) {
        mp_limb_t here = b->x[j];
        b->x[j] = nmod_add(here, top, b->m->mod);
        ok = modblock_evaluate(b);
        for (size_t i = 0; i < n; i++)
            slope[i * n + j] = nmod_sub(b->value[i], r[i], b->m->mod) / top;
        b->x[j] = here;
    }
    ok = ok && modblock_evaluate(b);
    for (int k = 1; k < b->m->power && ok; k++) {
        memcpy(work, slope, n * n * sizeof *work);
        memcpy(r, b->value, n * sizeof *r);
        ok = num_modp_solve(b->m, work, r, b->n);
        for (size_t j = 0; j < n && ok; j++)
            b->x[j] = nmod_sub(b->x[j], r[j], b->m->mod);
        ok = ok && modblock_evaluate(b);
    }
    for (size_t i = 0; i < n; i++)
        ok = ok && b->value[i] == 0;
    return ok;
}

bool modblock_tear(struct modblock *b, uint64_t *random)
{
    SGA_ENDS(clear_plan) struct plan p;
    bool ok = look(&p, b);
    if (ok) {
        make_plan(&p);
        modblock_evaluate(b);      /* what the unknowns do not change */
        ok = search(&p, random) && modblock_lift(b);
    }
    return ok;
}

int modblock_guesses(struct modblock *b)
{
    if (b->n > TEAR_MOST)
        return -1;
    SGA_ENDS(clear_plan) struct plan p;
    bool ok = look(&p, b);
    if (ok)
        make_plan(&p);
    return ok ? p.guesses : -1;
}
