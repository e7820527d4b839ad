/* A random point of the variety modulo a prime: free variables at random, the others by
 * blocks in the order in which they determine each other. */
#include "modpoint.h"

#include <flint/nmod_poly.h>
#include <flint/nmod_poly_factor.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"

enum { BLOCK_MAX = 48, DEGREE_MAX = 10, TRIES = 4, BLOCK_TRIES = 24 };

/* The square system: constraint i solves variable solved[i]; blocks are its strongly
 * connected components, each after the ones that it uses. */
struct blocks {
    int c;
    int *order, *start, count;    /* constraints by block: order[start[b] .. start[b+1]) */
};

struct uses {
    int **to, *len;               /* by constraint: constraints whose variable it uses */
};

static void find_uses(struct uses *u, const struct points_space *s, const int *solved)
{
    int c = s->constraints;
    int *by_symbol = sga_malloc((size_t)s->st->symbols * sizeof *by_symbol);
    for (int i = 0; i < s->st->symbols; i++)
        by_symbol[i] = -1;
    for (int i = 0; i < c; i++)
        by_symbol[s->variable[solved[i]]] = i;
    u->to = sga_calloc((size_t)c, sizeof *u->to);
    u->len = sga_calloc((size_t)c, sizeof *u->len);
    struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < c; i++) {
        expr_cone_of(s->st, &cone, s->constraint + i, 1);
        u->to[i] = sga_malloc((size_t)cone.count * sizeof(int));
        for (int k = 0; k < cone.count; k++) {
            const struct expr_node *n = s->st->node + cone.list[k];
            if (n->op == EXPR_SYM && by_symbol[n->a] >= 0 && by_symbol[n->a] != i)
                u->to[i][u->len[i]++] = by_symbol[n->a];
        }
    }
    expr_cone_clear(&cone);
    free(by_symbol);
}

/* Tarjan's algorithm with its own stack. */
static void find_blocks(struct blocks *b, const struct uses *u, int c)
{
    size_t size = (size_t)c + 1;
    int *low = sga_calloc(size, sizeof *low), *num = sga_calloc(size, sizeof *num), *at = sga_calloc(size, sizeof *at);
    int *stack = sga_malloc(size * sizeof *stack), *path = sga_malloc(size * sizeof *path);
    unsigned char *on = sga_calloc(size, 1);
    int sp = 0, pp, clock = 0, placed = 0;
    *b = (struct blocks){ .c = c, .order = sga_malloc(size * sizeof(int)), .start = sga_malloc((size + 1) * sizeof(int)) };
    for (int root = 0; root < c; root++) {
        if (num[root])
            continue;
        pp = 0;
        path[pp++] = root;
        while (pp) {
            int v = path[pp - 1];
            if (!num[v]) {
                num[v] = low[v] = ++clock;
                stack[sp++] = v;
                on[v] = 1;
            }
            bool descended = false;
            while (at[v] < u->len[v] && !descended) {
                int w = u->to[v][at[v]];
                if (!num[w]) {
                    path[pp++] = w;
                    descended = true;
                } else {
                    if (on[w] && low[w] < low[v])
                        low[v] = low[w];
                    at[v]++;
                }
            }
            if (descended)
                continue;
            if (low[v] == num[v]) {
                b->start[b->count++] = placed;
                int w;
                do {
                    w = stack[--sp];
                    on[w] = 0;
                    b->order[placed++] = w;
                } while (w != v);
            }
            pp--;
        }
    }
    b->start[b->count] = placed;
    free(low);
    free(num);
    free(at);
    free(stack);
    free(path);
    free(on);
}

/* One block at work. */
struct block {
    struct num_modp *m;
    const struct points_space *s;
    const int *solved, *member;
    int n;
    struct expr_cone cone;
    mp_limb_t *x, *value;
};

static bool evaluate(struct block *b)
{
    for (int i = 0; i < b->n; i++)
        num_modp_set(b->m, b->s->variable[b->solved[b->member[i]]], b->x[i]);
    num_modp_list(b->m, b->cone.list, b->cone.count);
    bool ok = true;
    for (int i = 0; i < b->n; i++) {
        expr_id e = b->s->constraint[b->member[i]];
        ok &= !num_modp_bad(b->m, e);
        b->value[i] = num_modp_value(b->m, e);
    }
    return ok;
}

static bool vanishes(struct block *b)
{
    bool ok = evaluate(b);
    for (int i = 0; i < b->n; i++)
        ok &= b->value[i] == 0;
    return ok;
}

/* Exact where the block is affine in its variables; otherwise the check fails. The base
 * point is random, since 0 is often a place without values. */
static bool solve_affine(struct block *b, uint64_t *random)
{
    int n = b->n, w = n + 1;
    nmod_t p = b->m->mod;
    mp_limb_t *J = sga_calloc((size_t)n * (size_t)w, sizeof *J), *base = sga_malloc((size_t)n * sizeof *base);
    for (int i = 0; i < n; i++)
        base[i] = b->x[i] = points_random(random) % p.n;
    bool ok = evaluate(b);
    for (int i = 0; i < n; i++)
        J[i * w + n] = b->value[i];
    for (int j = 0; j < n && ok; j++) {
        b->x[j] = nmod_add(base[j], 1, p);
        ok = evaluate(b);
        for (int i = 0; i < n; i++)
            J[i * w + j] = nmod_sub(b->value[i], J[i * w + n], p);
        b->x[j] = base[j];
    }
    for (int j = 0; j < n && ok; j++) {
        int r = j;
        while (r < n && !J[r * w + j])
            r++;
        ok = r < n;
        for (int k = j; k <= n && ok && r != j; k++) {
            mp_limb_t t = J[r * w + k];
            J[r * w + k] = J[j * w + k];
            J[j * w + k] = t;
        }
        mp_limb_t inverse = ok ? nmod_inv(J[j * w + j], p) : 0;
        for (int k = j; k <= n && ok; k++)
            J[j * w + k] = nmod_mul(J[j * w + k], inverse, p);
        for (int i = 0; i < n && ok; i++) {
            mp_limb_t f = i == j ? 0 : J[i * w + j];
            for (int k = j; k <= n && f; k++)
                J[i * w + k] = nmod_sub(J[i * w + k], nmod_mul(f, J[j * w + k], p), p);
        }
    }
    for (int i = 0; i < n && ok; i++)
        b->x[i] = nmod_sub(base[i], J[i * w + n], p);
    free(J);
    free(base);
    return ok && vanishes(b);
}

/* One constraint, one variable: interpolate, and take a root modulo p. */
static bool solve_univariate(struct block *b, uint64_t *random)
{
    nmod_t p = b->m->mod;
    mp_limb_t xs[DEGREE_MAX + 1], ys[DEGREE_MAX + 1];
    for (int k = 0; k <= DEGREE_MAX; k++) {
        xs[k] = b->x[0] = points_random(random) % p.n;
        if (!evaluate(b))
            return false;
        ys[k] = b->value[0];
    }
    nmod_poly_t f;
    nmod_poly_init(f, p.n);
    nmod_poly_interpolate_nmod_vec(f, xs, ys, DEGREE_MAX + 1);
    bool ok = false;
    if (nmod_poly_degree(f) >= 1 && nmod_poly_degree(f) < DEGREE_MAX) {
        nmod_poly_factor_t fac;
        nmod_poly_factor_init(fac);
        nmod_poly_factor(fac, f);
        for (slong k = 0; k < fac->num && !ok; k++) {
            if (nmod_poly_degree(fac->p + k) != 1)
                continue;
            b->x[0] = nmod_div(nmod_neg(nmod_poly_get_coeff_ui(fac->p + k, 0), p),
                               nmod_poly_get_coeff_ui(fac->p + k, 1), p);
            ok = vanishes(b);
        }
        nmod_poly_factor_clear(fac);
    }
    nmod_poly_clear(f);
    return ok;
}

/* Other values for the free symbols of a block that no earlier block has used. */
static bool redraw(struct block *b, const unsigned char *settled, uint64_t *random)
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

static bool solve_block(struct num_modp *m, const struct points_space *s, const int *solved,
                        const int *member, int n, unsigned char *settled, uint64_t *random)
{
    if (n > BLOCK_MAX)
        return false;
    struct block b = { .m = m, .s = s, .solved = solved, .member = member, .n = n };
    expr_id *root = sga_malloc((size_t)n * sizeof *root);
    for (int i = 0; i < n; i++)
        root[i] = s->constraint[member[i]];
    expr_cone_init(&b.cone);
    expr_cone_of(s->st, &b.cone, root, n);
    b.x = sga_calloc((size_t)n, sizeof *b.x);
    b.value = sga_calloc((size_t)n, sizeof *b.value);
    bool ok = false;
    for (int k = 0; k < BLOCK_TRIES && !ok; k++) {
        ok = solve_affine(&b, random) || (n == 1 && solve_univariate(&b, random));
        if (!ok && !redraw(&b, settled, random))
            break;
    }
    for (int k = 0; k < b.cone.count; k++)
        if (expr_op_of(s->st, b.cone.list[k]) == EXPR_SYM)
            settled[s->st->node[b.cone.list[k]].a] = 1;
    expr_cone_clear(&b.cone);
    free(root);
    free(b.x);
    free(b.value);
    return ok;
}

static bool try_point(struct num_modp *m, const struct points_space *s, const struct blocks *b,
                      const int *solved, uint64_t *random)
{
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
        ok = solve_block(m, s, solved, b->order + b->start[k], b->start[k + 1] - b->start[k], settled, random);
    free(settled);
    if (!ok)
        return false;
    num_modp_forget(m);
    num_modp_extend(m);
    for (int i = 0; i < s->constraints; i++)
        if (num_modp_bad(m, s->constraint[i]) || num_modp_value(m, s->constraint[i]))
            return false;
    return true;
}

bool points_modpoint_find(struct points_modpoint *p, const struct points_space *s, const int *solved, uint64_t *random)
{
    return points_modpoint_find_modulo(p, s, solved, -1, random);
}

bool points_modpoint_find_modulo(struct points_modpoint *p, const struct points_space *s, const int *solved, int prime,
                                 uint64_t *random)
{
    struct uses u;
    struct blocks b;
    find_uses(&u, s, solved);
    find_blocks(&b, &u, s->constraints);
    p->value = sga_malloc(sizeof *p->value);
    bool ok = false;
    if (prime < 0)
        prime = (int)(points_random(random) % NUM_MODP_PRIMES);
    uint64_t seed = points_random(random);
    num_modp_init(p->value, s->st, seed, prime);
    for (int k = 0; k < TRIES && !ok; k++)
        ok = try_point(p->value, s, &b, solved, random);
    if (!ok)
        points_modpoint_clear(p);
    for (int i = 0; i < s->constraints; i++)
        free(u.to[i]);
    free(u.to);
    free(u.len);
    free(b.order);
    free(b.start);
    return ok;
}

void points_modpoint_clear(struct points_modpoint *p)
{
    if (p->value)
        num_modp_clear(p->value);
    free(p->value);
    p->value = NULL;
}

int points_modpoint_zero(struct points_modpoint *p, expr_id e)
{
    num_modp_extend(p->value);
    if (num_modp_bad(p->value, e))
        return -1;
    return num_modp_value(p->value, e) == 0;
}
