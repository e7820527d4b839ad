/* A random point of the variety modulo a prime or a power of one: free variables at random, the others by blocks in the
 * order in which they determine each other. */
#include "modpoint.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

#include "graph.h"
#include "mem.h"
#include "modblock.h"
#include "modmatch.h"

enum { TRIES = 4, BLOCK_TRIES = 24, MATCHED_MOST = 400 };

/* Nodes that may be worked out for one point modulo powers. */
enum { WORK_MOST = 4000000 };

/* The square system: constraint i is solved for variable solved[i]; blocks are its strong components, each after those that it uses. */
struct blocks {
    int *order, *start, count;    /* constraints by block: order[start[b] .. start[b + 1]) */
};

/* Which constraints each one uses the variable of. */
static struct graph uses_of(const struct points_space *s, const int *solved, int **start, int **to)
{
    int c = s->constraints, count = 0;
    size_t cap = 0;
    int *by_symbol = sga_malloc(((size_t)s->st->symbols + 1) * sizeof *by_symbol);
    for (int i = 0; i < s->st->symbols; i++)
        by_symbol[i] = -1;
    for (int i = 0; i < c; i++)
        by_symbol[s->variable[solved[i]]] = i;
    *start = sga_calloc((size_t)c + 1, sizeof **start);
    *to = NULL;
    struct expr_cone cone;
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
    expr_cone_clear(&cone);
    free(by_symbol);
    return (struct graph){ c, c, *start, *to };
}

static void find_blocks(struct blocks *b, const struct points_space *s, const int *solved)
{
    int c = s->constraints, *start, *to;
    struct graph g = uses_of(s, solved, &start, &to);
    int *component = sga_calloc((size_t)c + 1, sizeof *component);
    b->count = graph_strong(&g, component);
    b->order = sga_calloc((size_t)c + 1, sizeof *b->order);
    b->start = sga_calloc((size_t)b->count + 2, sizeof *b->start);
    for (int i = 0; i < c; i++)
        b->start[component[i] + 2]++;
    for (int k = 2; k < b->count + 2; k++)
        b->start[k] += b->start[k - 1];
    for (int i = 0; i < c; i++)
        b->order[b->start[component[i] + 1]++] = i;
    free(component);
    free(start);
    free(to);
}

/* A point in the making. */
struct search {
    struct num_modp *m;
    const struct points_space *s;
    const int *solved;
    int most;                     /* guesses that a block may take at this prime ... */
    int needs;                    /* ... and what the first one that failed would */
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

static bool solve_once(struct search *f, struct modblock *b, uint64_t *random)
{
    if (modblock_affine(b, random))
        return true;
    if (b->m->power == 1)
        return b->n == 1 && modblock_univariate(b, random);
    f->needs = modblock_guesses(b);
    return f->needs >= 0 && f->needs <= f->most && modblock_tear(b, random);
}

static bool solve_block(struct search *f, const int *member, int n, unsigned char *settled, uint64_t *random)
{
    if (n > MODBLOCK_MOST)
        return false;
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
    for (int i = 0; i < s->variables; i++)
        num_modp_set(m, s->variable[i], points_random(random) % m->mod.n);
    for (int i = 0; i < s->parameters; i++)
        num_modp_set(m, s->parameter[i], points_random(random) % m->mod.n);
    num_modp_set(m, s->time, points_random(random) % m->mod.n);
    num_modp_extend(m);
    unsigned char *settled = sga_calloc((size_t)s->st->symbols, 1);
    bool ok = true;
    for (int k = 0; k < b->count && ok; k++)
        ok = solve_block(f, b->order + b->start[k], b->start[k + 1] - b->start[k], settled, random);
    free(settled);
    return ok && on_the_set(m, s);
}

/* Modulo prime number `prime`; or, where that is negative, modulo a power of the small prime for `most` guesses. */
static bool find(struct points_modpoint *p, const struct points_space *s, const int *solved, int prime, int most, int *needs, uint64_t *random)
{
    struct blocks b;
    find_blocks(&b, s, solved);
    p->value = sga_malloc(sizeof *p->value);
    uint64_t seed = points_random(random);
    if (prime >= 0)
        num_modp_init(p->value, s->st, seed, prime);
    else
        num_modp_init_power(p->value, s->st, seed, most);
    struct search f = { .m = p->value, .s = s, .solved = solved, .most = most, .work = prime >= 0 ? LONG_MAX : WORK_MOST };
    bool ok = false;
    for (int k = 0; k < TRIES && !ok && f.work > 0 && f.needs >= 0 && f.needs <= most; k++)
        ok = try_point(&f, &b, random);
    if (!ok)
        points_modpoint_clear(p);
    *needs = f.needs;
    free(b.order);
    free(b.start);
    return ok;
}

/* Modulo powers: the prime is the smaller, the more guesses there are to make. */
static bool find_lifted(struct points_modpoint *p, const struct points_space *s, const int *solved, uint64_t *random)
{
    int needs = 0, most = 0;
    while (!find(p, s, solved, -1, most, &needs, random)) {
        if (needs <= most || needs >= NUM_MODP_POWERS)
            return false;
        most = needs;
    }
    return true;
}

bool points_modpoint_find(struct points_modpoint *p, const struct points_space *s, const int *solved, int prime, uint64_t *random)
{
    int needs;
    if (find(p, s, solved, prime, 0, &needs, random))
        return true;
    int *shaped = sga_calloc((size_t)s->constraints + 1, sizeof *shaped);
    bool other = s->constraints <= MATCHED_MOST && points_match_by_shape(s, shaped);
    bool ok = (other && (find(p, s, shaped, prime, 0, &needs, random) || find_lifted(p, s, shaped, random))) || find_lifted(p, s, solved, random);
    free(shaped);
    return ok;
}

bool points_modpoint_find_modulo(struct points_modpoint *p, const struct points_space *s, const int *solved, int prime, uint64_t *random)
{
    int needs;
    return find(p, s, solved, prime, 0, &needs, random);
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
    num_modp_extend(p->value);
    bool bad = num_modp_bad(p->value, e);
    *chance = !num_modp_kernel(p->value, e) && (num_modp_branch(p->value, e) || !bad);
    return bad ? -1 : num_modp_value(p->value, e) == 0;
}
