/* A random point of the variety modulo a prime or a power of one: free variables at random, the others by blocks in the
 * order in which they determine each other. */
#include "modpoint.h"

#include <assert.h>
#include <flint/fmpq.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "flint_ends.h"
#include "graph.h"
#include "mem.h"
#include "modblock.h"
#include "modmatch.h"
#include "points_random.h"
#include "points_space.h"

enum { TRIES = 16, BLOCK_TRIES = 24, LARGE = 400 };

/* Small primes to lift from, by the guesses that a block takes: the more guesses, the smaller; several, since a number
 * that is algebraic is there modulo some primes only. */
enum { GUESSES_MOST = 4, SMALL_PRIMES = 5, ROUNDS = 3 };
static const unsigned short small_prime[GUESSES_MOST + 1][SMALL_PRIMES] = {
    { 503, 479, 467, 383, 359 }, { 107, 83, 167, 59, 179 }, { 47, 59, 83, 47, 23 }, { 23, 47, 23, 47, 23 }, { 11, 23, 11, 23, 11 }
};

/* Nodes that may be worked out for one point: so many, and so many times those of the store. */
enum { WORK_MOST = 4000000, WORK_TIMES = 8 };

/* The square system: constraint i is solved for variable solved[i]; blocks are its strong components, each after those that it uses. */
struct blocks {
    int *order, *start, count;    /* constraints by block: order[start[b] .. start[b + 1]) */
};

/* Which constraints each one uses the variable of. */
static struct graph uses_of(const struct points_space *s, const int *solved, int **start, int **to)
{
    int c = s->constraints, count = 0;
    size_t cap = 0;
    SGA_FREED int *by_symbol = sga_malloc(((size_t)s->st->symbols + 1) * sizeof *by_symbol);
    for (int i = 0; i < s->st->symbols; i++)
        by_symbol[i] = -1;
    for (int i = 0; i < c; i++)
        by_symbol[s->variable[solved[i]]] = i;
    *start = sga_calloc((size_t)c + 1, sizeof **start);
    *to = NULL;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < c; i++) {
        expr_cone_of(s->st, &cone, s->constraint + i, 1);
        for (int k = 0; k < cone.count; k++) {
            const struct expr_node *n = s->st->node + cone.list[k];
            if (n->op != EXPR_SYM || by_symbol[n->a] < 0 || by_symbol[n->a] == i)
                continue;
            SGA_RESERVE(*to, cap, count + 1);
            (*to)[count++] = by_symbol[n->a];
        }
        (*start)[i + 1] = count;
    }
    return (struct graph){ c, c, *start, *to };
}

static void find_blocks(struct blocks *b, const struct points_space *s, const int *solved)
{
    int c = s->constraints;
    SGA_FREED int *start = NULL, *to = NULL;
    struct graph g = uses_of(s, solved, &start, &to);
    SGA_FREED int *component = sga_calloc((size_t)c + 1, sizeof *component);
    b->count = graph_strong(&g, component);
    b->order = sga_calloc((size_t)c + 1, sizeof *b->order);
    b->start = sga_calloc((size_t)b->count + 2, sizeof *b->start);
    for (int i = 0; i < c; i++)
        b->start[component[i] + 2]++;
    for (int k = 2; k < b->count + 2; k++)
        b->start[k] += b->start[k - 1];
    for (int i = 0; i < c; i++)
        b->order[b->start[component[i] + 1]++] = i;
}

/* A point in the making. */
struct search {
    struct num_modp *m;
    const struct points_space *s;
    const int *solved;
    int most;                     /* guesses that a block may take at this prime ... */
    int needs;                    /* ... and what the last one would; negative: no number is enough */
    bool guided;                  /* points near the space's guess, which may lie on the set itself */
    long work;
};

/* Other values for the free symbols of a block that no earlier block has used. */
static bool redraw(const struct modblock *b, const unsigned char *settled, uint64_t *random)
{
    bool any = false;
    for (int k = 0; k < b->cone.count; k++) {
        const struct expr_node *n = b->s->st->node + b->cone.list[k];
        if (n->op == EXPR_SYM && !settled[n->a]) {
            num_modp_set(b->m, n->a, points_random(random) % b->m->mod.n);
            any = true;
        }
    }
    return any;
}

/* The guess for a variable modulo p^k, if it has a residue there. */
static bool near_residue(const struct search *f, int variable, mp_limb_t *residue)
{
    SGA_ENDS(fmpq_end) fmpq_t q = { { 0, 1 } };
    SGA_ENDS(arf_end) arf_t near = { 0 };
    arf_set_d(near, f->s->near[variable]);
    bool ok = arf_is_finite(near);
    if (ok)
        arf_get_fmpq(q, near);
    ok = ok && num_modp_fmpq(f->m, q, residue);
    return ok;
}

static bool solve_once(struct search *f, struct modblock *b, uint64_t *random)
{
    bool affine;
    if (modblock_affine(b, &affine, random))
        return true;
    if (f->guided) {
        for (int i = 0; i < b->n; i++)
            near_residue(f, b->solved[b->member[i]], b->x + i);
        return modblock_lift(b);
    }
    if (b->m->power == 1) {
        f->needs = 0;
        if (b->n == 1)
            return modblock_univariate(b, random);
        bool torn = !affine && b->n <= TORN_MOST && f->s->constraints > LARGE;
        f->needs = !affine && !torn;
        return torn && modblock_torn_once(b, random);
    }
    f->needs = modblock_guesses(b);
    return f->needs >= 0 && f->needs <= f->most && modblock_tear(b, random);
}

static bool solve_block(struct search *f, const int *member, int n, unsigned char *settled, uint64_t *random)
{
    if (n > MODBLOCK_MOST) {
        f->needs = -1;
        return false;
    }
    struct modblock b = { .m = f->m, .s = f->s, .solved = f->solved, .member = member, .n = n, .work = &f->work };
    modblock_begin(&b);
    bool ok = false;
    for (int k = 0; k < BLOCK_TRIES && !ok; k++) {
        ok = solve_once(f, &b, random);
        if (!ok && (f->work < 0 || f->needs < 0 || f->needs > f->most || !redraw(&b, settled, random)))
            break;
    }
    for (int k = 0; k < b.cone.count; k++)
        if (expr_op_of(f->s->st, b.cone.list[k]) == EXPR_SYM)
            settled[f->s->st->node[b.cone.list[k]].a] = 1;
    modblock_end(&b);
    return ok;
}

static bool on_the_set(struct num_modp *m, const struct points_space *s)
{
    num_modp_forget(m);
    num_modp_extend(m);
    for (int i = 0; i < s->constraints; i++)
        if (num_modp_bad(m, s->constraint[i]) || num_modp_value(m, s->constraint[i]))
            return false;
    return true;
}

static bool try_point(struct search *f, const struct blocks *b, uint64_t *random)
{
    struct num_modp *m = f->m;
    const struct points_space *s = f->s;
    num_modp_forget(m);
    for (int i = 0; i < s->variables; i++) {
        mp_limb_t x = points_random(random) % m->mod.n, near;
        if (f->guided && near_residue(f, i, &near))      /* a general point of its p-adic neighbourhood */
            x = nmod_add(near, nmod_mul(x, m->p, m->mod), m->mod);
        num_modp_set(m, s->variable[i], x);
    }
    for (int i = 0; i < s->parameters; i++)
        num_modp_set(m, s->parameter[i], points_random(random) % m->mod.n);
    num_modp_set(m, s->time, points_random(random) % m->mod.n);
    num_modp_extend(m);
    f->work -= s->st->nodes;
    SGA_FREED unsigned char *settled = sga_calloc((size_t)s->st->symbols, 1);
    bool ok = true;
    for (int k = 0; k < b->count && ok; k++)
        ok = solve_block(f, b->order + b->start[k], b->start[k + 1] - b->start[k], settled, random);
    return ok && on_the_set(m, s);
}

/* What is looked for, with what it may cost. */
struct task {
    const struct points_space *s;
    const int *solved;
    int most, needs;              /* as in struct search */
    bool guided;
    long work;
    uint64_t *random;
};

/* Modulo prime number `prime`; or, where that is negative, modulo a power of the small prime. */
static bool find(struct points_modpoint *p, struct task *t, int prime, mp_limb_t small)
{
    struct blocks b;
    find_blocks(&b, t->s, t->solved);
    for (int k = 0; k < b.count; k++)
        if (b.start[k + 1] - b.start[k] > MODBLOCK_MOST) {      /* the blocks before it would be solved for nothing */
            t->needs = -1;
            free(b.order);
            free(b.start);
            return false;
        }
    p->value = sga_malloc(sizeof *p->value);
    uint64_t seed = points_random(t->random);
    if (prime >= 0)
        num_modp_init(p->value, t->s->st, seed, prime);
    else
        num_modp_init_power(p->value, t->s->st, seed, small);
    struct search f = { .m = p->value, .s = t->s, .solved = t->solved, .most = t->most, .guided = t->guided, .work = t->work };
    bool ok = false;
    for (int k = 0; k < TRIES && !ok && f.work > 0 && f.needs >= 0 && f.needs <= f.most; k++)
        ok = try_point(&f, &b, t->random);
    if (!ok)
        points_modpoint_clear(p);
    t->needs = f.needs;
    t->work = f.work;
    free(b.order);
    free(b.start);
    return ok;
}

static struct task task_of(const struct points_space *s, const int *solved, uint64_t *random)
{
    return (struct task){ .s = s, .solved = solved, .work = WORK_MOST + (long)WORK_TIMES * s->st->nodes, .random = random };
}

static bool find_lifted(struct points_modpoint *p, const struct points_space *s, const int *solved, int first, uint64_t *random)
{
    struct task t = task_of(s, solved, random);
    for (int k = 0; k < ROUNDS * SMALL_PRIMES && t.work > 0; k++) {
        if (find(p, &t, -1, small_prime[t.most][(first + k) % SMALL_PRIMES]))
            return true;
        if (t.needs < 0 || t.needs > GUESSES_MOST)
            return false;
        t.most = t.needs > t.most ? t.needs : t.most;
    }
    return false;
}

/* From the guess, where it is a point of the set. */
static bool find_near(struct points_modpoint *p, const struct points_space *s, const int *solved, int first, uint64_t *random)
{
    struct task t = task_of(s, solved, random);
    t.guided = true;
    bool ok = false;
    for (int k = 0; k < SMALL_PRIMES && s->near && !ok && t.work > 0; k++)
        ok = find(p, &t, -1, small_prime[0][(first + k) % SMALL_PRIMES]);
    return ok;
}

bool points_modpoint_find(struct points_modpoint *p, const struct points_space *s, const int *solved, int prime, uint64_t *random)
{
    struct task t = task_of(s, solved, random);
    if (solved && find(p, &t, prime, 0))
        return true;
    SGA_FREED int *shaped = sga_calloc((size_t)s->constraints + 1, sizeof *shaped);
    bool ok = false;
    if (points_match_by_shape(s, shaped)) {
        t = task_of(s, shaped, random);
        ok = find(p, &t, prime, 0) || find_lifted(p, s, shaped, prime, random);
    }
    if (solved)
        ok = ok || find_lifted(p, s, solved, prime, random) || find_near(p, s, solved, prime, random);
    return ok;
}

bool points_modpoint_find_modulo(struct points_modpoint *p, const struct points_space *s, const int *solved, int prime, uint64_t *random)
{
    struct task t = task_of(s, solved, random);
    return find(p, &t, prime, 0);
}

void points_modpoint_clear(struct points_modpoint *p)
{
    if (p->value)
        num_modp_clear(p->value);
    free(p->value);
    p->value = NULL;
}

int points_modpoint_zero(struct points_modpoint *p, expr_id e, bool *chance)
{
    assert(e < p->value->st->nodes);
    num_modp_extend(p->value);
    bool bad = num_modp_bad(p->value, e);
    *chance = !num_modp_kernel(p->value, e) && (num_modp_branch(p->value, e) || !bad);
    return bad ? -1 : num_modp_value(p->value, e) == 0;
}
