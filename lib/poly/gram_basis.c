/* Which squares can occur: weights by the ranges of kernels, monomials by the Newton polytope
 * (2 m lies in that of f where f is a plain sum of squares), and blocks by the sign symmetries
 * of f (x y stands beside x^2 only if some term says so). Reznick 1978; Loefberg 2009. */
#include "gram.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "mpoly_take.h"
#include "seeds.h"

enum { CANDIDATES = SGA_MOST_GRAM_CANDIDATES, DIRECTIONS = 40 };

/* Monomials as exponents by generator. */
struct list { int gens, count; ulong *exp; };

static const ulong *at(const struct list *l, int i) { return l->exp + (size_t)i * (size_t)l->gens; }

static struct list support(const struct poly_bridge *b, const fmpz_mpoly_t f)
{
    struct list l = { b->max_gens, (int)f->length, sga_malloc((size_t)(f->length * b->max_gens + 1) * sizeof(ulong)) };
    for (slong i = 0; i < f->length; i++)
        poly_exponents(b, f, i, l.exp + i * l.gens);
    return l;
}

static slong along(const ulong *exp, const int *direction, int gens)
{
    slong s = 0;
    for (int g = 0; g < gens; g++)
        s += direction[g] * (slong)exp[g];
    return s;
}

/* Drops the candidates m with 2 m outside of the support's hull along some directions: sums and differences of two
 * axes, and others that are fixed at random. Too few leave too many candidates in, which costs time only. */
static void inside_hull(struct list *l, const struct list *f)
{
    SGA_FREED int *direction = sga_calloc((size_t)l->gens, sizeof *direction);
    int gens = l->gens;
    unsigned random = SGA_SEED_GRAM_DIRECTIONS;
    for (int k = 0; k < gens * gens + DIRECTIONS; k++) {
        for (int g = 0; g < gens; g++) {
            random = random * 1103515245u + 12345u;
            direction[g] = k < gens * gens ? (g == k / gens) - (k / gens != k % gens && g == k % gens) : (int)(random >> 16) % 7 - 3;
        }
        slong lo = WORD_MAX, hi = WORD_MIN;
        for (int i = 0; i < f->count; i++) {
            slong s = along(at(f, i), direction, gens);
            lo = s < lo ? s : lo;
            hi = s > hi ? s : hi;
        }
        int n = 0;
        for (int i = 0; i < l->count; i++) {
            slong s = 2 * along(at(l, i), direction, gens);
            if (s >= lo && s <= hi)
                memmove(l->exp + (size_t)n++ * (size_t)gens, at(l, i), (size_t)gens * sizeof(ulong));
        }
        l->count = n;
    }
}

/* All monomials within most[] (by generator), of total degree lo .. hi, in descending order. False: too many. */
static bool box(struct list *l, const int *most, int lo, int hi)
{
    int gens = l->gens, total = 0;
    SGA_FREED ulong *e = sga_calloc((size_t)gens, sizeof *e);
    double all = 1;
    for (int g = 0; g < gens; g++) {
        all *= most[g] + 1;
        e[g] = (ulong)most[g];
        total += most[g];
    }
    bool ok = all <= CANDIDATES;
    l->exp = sga_malloc(((size_t)(ok ? all : 0) * (size_t)gens + 1) * sizeof *l->exp);
    l->count = 0;
    while (ok) {
        if (total >= lo && total <= hi)
            memcpy(l->exp + (size_t)l->count++ * (size_t)gens, e, (size_t)gens * sizeof *e);
        int g = gens - 1;
        while (g >= 0 && e[g] == 0) {
            e[g] = (ulong)most[g];
            total += most[g--];
        }
        if (g < 0)
            break;
        e[g]--;
        total--;
    }
    return ok;
}

static bool is_sum(const ulong *x, const ulong *y, const ulong *s, int gens)
{
    for (int g = 0; g < gens; g++)
        if (x[g] + y[g] != s[g])
            return false;
    return true;
}

/* m's square can neither occur in f nor be cancelled: then it is not part of any square. */
static bool alone(const struct list *l, int m, const struct list *f)
{
    int gens = l->gens;
    for (int i = 0; i < f->count; i++)
        if (is_sum(at(l, m), at(l, m), at(f, i), gens))
            return false;
    SGA_FREED ulong *twice = sga_malloc((size_t)gens * sizeof *twice);
    bool cancelled = false;
    for (int g = 0; g < gens; g++)
        twice[g] = 2 * at(l, m)[g];
    for (int i = 0; i < l->count && !cancelled; i++)
        for (int j = i + 1; j < l->count && !cancelled; j++)
            cancelled = is_sum(at(l, i), at(l, j), twice, gens);
    return !cancelled;
}

static void drop_alone(struct list *l, const struct list *f)
{
    enum { LARGEST = 90 };
    for (bool again = l->count <= LARGEST; again;) {
        again = false;
        for (int i = 0; i < l->count; i++)
            if (alone(l, i, f)) {
                memmove(l->exp + (size_t)i * (size_t)l->gens, at(l, i + 1), (size_t)(--l->count - i) * (size_t)l->gens * sizeof(ulong));
                again = true;
                break;
            }
    }
}

/* Parities of exponents as a space over F_2: bits by generator, in echelon form. */
struct parities { uint64_t row[64]; int rows; };

static uint64_t reduced(const struct parities *p, uint64_t v)
{
    for (int i = 0; i < p->rows; i++)
        if ((v ^ p->row[i]) < v)
            v ^= p->row[i];
    return v;
}

static uint64_t parity(const ulong *exp, int gens)
{
    uint64_t v = 0;
    for (int g = 0; g < gens && g < 64; g++)
        v |= (uint64_t)(exp[g] & 1) << g;
    return v;
}

/* Rows stay sorted and each leading bit in one row only, so that reduced() is a normal form. */
static void span(struct parities *p, const struct list *l)
{
    for (int k = 0; k < l->count; k++) {
        uint64_t v = reduced(p, parity(at(l, k), l->gens));
        if (!v)
            continue;
        for (int i = 0; i < p->rows; i++)
            if ((p->row[i] ^ v) < p->row[i])
                p->row[i] ^= v;
        int i = p->rows++;
        for (; i > 0 && p->row[i - 1] < v; i--)
            p->row[i] = p->row[i - 1];
        p->row[i] = v;
    }
}

/* What is known to be >= 0, or 0. */
struct known {
    fmpz_mpoly_struct weight[16]; bool positive[16]; int weights;
    fmpz_mpoly_struct zero[GRAM_GIVEN + 16]; int zeros;
};

static void know_weight(struct poly_bridge *b, struct known *k, int g, slong constant, slong slope, slong power, bool positive)
{
    fmpz_mpoly_struct *w = k->weight + k->weights;
    fmpz_mpoly_init(w, b->ctx);
    fmpz_mpoly_gen(w, g, b->ctx);
    fmpz_mpoly_pow_ui(w, w, (ulong)power, b->ctx);
    fmpz_mpoly_scalar_mul_si(w, w, slope, b->ctx);
    fmpz_mpoly_add_si(w, w, constant, b->ctx);
    k->positive[k->weights++] = positive;
}

/* What the kind of a generator says of its values. */
static void know_range(struct poly_bridge *b, struct known *k, int g)
{
    const struct poly_generator *q = b->gen + g;
    switch (q->op) {
    case EXPR_SIN: case EXPR_COS: case EXPR_TANH:
        know_weight(b, k, g, 1, -1, 2, q->op == EXPR_TANH);
        break;
    case EXPR_COSH:
        know_weight(b, k, g, -1, 1, 1, false);
        break;
    case EXPR_PI:       /* between two of its convergents */
        know_weight(b, k, g, -333, 106, 1, true);
        know_weight(b, k, g, 355, -113, 1, true);
        break;
    default:
        if (q->sign != POLY_ANY)
            know_weight(b, k, g, 0, 1, 1, q->sign == POLY_POSITIVE);
    }
}

static void use(const struct poly_bridge *b, const fmpz_mpoly_t f, int *used)
{
    SGA_FREED int *more = sga_calloc((size_t)b->max_gens, sizeof *more);
    fmpz_mpoly_used_vars(more, f, b->ctx);
    for (int i = 0; i < b->gens; i++)
        used[i] |= more[i];
}

/* Of the generators that f and what is given as zero are made of, and those that their relations speak of; used[] is
 * filled. */
static void know(struct poly_bridge *b, const fmpz_mpoly_t f, const fmpz_mpoly_struct *given, int n, struct known *k, int *used)
{
    k->weights = k->zeros = 0;
    use(b, f, used);
    for (int i = 0; i < n; i++) {
        use(b, given + i, used);
        fmpz_mpoly_init(k->zero + k->zeros, b->ctx);
        fmpz_mpoly_set(k->zero + k->zeros++, given + i, b->ctx);
    }
    for (int g = b->gens - 1; g >= 0; g--) {
        const struct poly_generator *q = b->gen + g;
        if (!used[g] || k->weights > 12 || k->zeros > GRAM_GIVEN + 12)
            continue;
        know_range(b, k, g);
        if (!q->degree || (q->partner >= 0 && !used[q->partner]))
            continue;
        fmpz_mpoly_struct *z = k->zero + k->zeros++;
        fmpz_mpoly_init(z, b->ctx);
        fmpz_mpoly_gen(z, g, b->ctx);
        fmpz_mpoly_pow_ui(z, z, (ulong)q->degree, b->ctx);
        fmpz_mpoly_mul(z, z, q->q, b->ctx);
        fmpz_mpoly_sub(z, z, q->p, b->ctx);
        use(b, z, used);
    }
}

static void forget(struct poly_bridge *b, struct known *k)
{
    for (int i = 0; i < k->weights; i++)
        fmpz_mpoly_clear(k->weight + i, b->ctx);
    for (int i = 0; i < k->zeros; i++)
        fmpz_mpoly_clear(k->zero + i, b->ctx);
}

static void monomial(struct poly_bridge *b, fmpz_mpoly_t out, const ulong *exp)
{
    fmpz_mpoly_zero(out, b->ctx);
    fmpz_mpoly_set_coeff_ui_ui(out, 1, exp, b->ctx);
}

/* The monomials of l in blocks by parity, with a weight. False: too large. */
static bool add_blocks(struct gram *g, const struct list *l, const struct parities *p, const fmpz_mpoly_t weight, bool positive)
{
    SGA_FREED unsigned char *done = sga_calloc((size_t)l->count + 1, 1);
    bool ok = true;
    for (int i = 0; i < l->count && ok; i++) {
        if (done[i])
            continue;
        ok = gram_within(g->b, g->blocks < GRAM_BLOCKS, SGA_LIMIT_GRAM_BLOCKS);
        if (!ok)
            break;
        struct gram_block *k = g->block + g->blocks++;
        *k = (struct gram_block){ .positive = positive };
        fmpz_mpoly_init(k->weight, g->b->ctx);
        fmpz_mpoly_set(k->weight, weight, g->b->ctx);
        k->q = sga_malloc((size_t)(l->count + 1) * sizeof *k->q);
        uint64_t class = reduced(p, parity(at(l, i), l->gens));
        for (int j = i; j < l->count; j++) {
            if (done[j] || reduced(p, parity(at(l, j), l->gens)) != class)
                continue;
            done[j] = 1;
            fmpz_mpoly_init(k->q + k->count, g->b->ctx);
            monomial(g->b, k->q + k->count++, at(l, j));
        }
        ok = gram_within(g->b, k->count <= GRAM_SIZE, SGA_LIMIT_GRAM_SIZE);
    }
    return ok;
}

/* Half of f's degree in each generator, and where f's kernels bring weights or relations at least 1. */
static bool bounds(struct poly_bridge *b, const fmpz_mpoly_t f, const struct known *k, const int *used, int least, int *most, int *half)
{
    bool plain = !k->weights && !k->zeros;
    long degree = poly_degree(b, f);
    degree = 2 * least > degree ? 2 * least : degree;
    for (int i = 0; i < k->zeros; i++) {
        long d = poly_degree(b, k->zero + i);
        degree = d > degree ? d : degree;
    }
    for (int g = 0; g < b->max_gens; g++) {
        slong d = g < b->gens ? fmpz_mpoly_degree_si(f, g, b->ctx) : 0;
        for (int i = 0; i < k->zeros && g < b->gens; i++) {
            slong other = fmpz_mpoly_degree_si(k->zero + i, g, b->ctx);
            d = other > d ? other : d;
        }
        most[g] = (int)(plain ? d / 2 : (d + 1) / 2);
        most[g] = most[g] < least ? least : most[g];
        if (g < b->gens && (!used[g] || (b->gen[g].op == EXPR_PI && d < 2)))
            most[g] = 0;
    }
    *half = (int)(plain ? degree / 2 : (degree + 1) / 2);
    return degree >= 1 && (!plain || degree % 2 == 0) && gram_within(b, degree <= GRAM_DEGREE, SGA_LIMIT_GRAM_DEGREE);
}

/* Multiples of what is zero, up to the degree of the rest. */
static bool add_multiples(struct gram *g, const struct known *k, const int *most, int half)
{
    struct poly_bridge *b = g->b;
    SGA_FREED int *room = sga_malloc((size_t)b->max_gens * sizeof *room);
    bool ok = true;
    for (int i = 0; i < k->zeros && ok; i++) {
        for (int v = 0; v < b->max_gens; v++) {
            slong d = v < b->gens ? fmpz_mpoly_degree_si(k->zero + i, v, b->ctx) : 0;
            room[v] = 2 * most[v] > d ? (int)(2 * most[v] - d) : 0;
        }
        struct list l = { .gens = b->max_gens };
        ok = box(&l, room, 0, 2 * half - (int)poly_degree(b, k->zero + i)) 
             && gram_within(b, g->multiples + l.count <= GRAM_UNKNOWNS, SGA_LIMIT_GRAM_UNKNOWNS);
        for (int m = 0; m < l.count && ok; m++) {
            g->multiple = sga_realloc(g->multiple, (size_t)(g->multiples + 1) * sizeof *g->multiple);
            fmpz_mpoly_struct *f = g->multiple + g->multiples++;
            fmpz_mpoly_init(f, b->ctx);
            monomial(b, f, at(&l, m));
            ok = poly_mul(b, f, f, k->zero + i);
        }
        free(l.exp);
    }
    return ok;
}

static void span_poly(struct poly_bridge *b, struct parities *p, const fmpz_mpoly_t f)
{
    struct list l = support(b, f);
    span(p, &l);
    free(l.exp);
}

static bool blocks_of(struct gram *g, const fmpz_mpoly_t f, const struct known *k, const int *used, int least)
{
    struct poly_bridge *b = g->b;
    struct list s = support(b, f), l = { .gens = b->max_gens };
    struct parities p = { .rows = 0 };
    SGA_FREED int *most = sga_malloc((size_t)b->max_gens * sizeof *most);
    int half;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *one = mpoly_take(&mem, b->ctx);
    fmpz_mpoly_one(one, b->ctx);
    span(&p, &s);
    for (int i = 0; i < k->weights; i++)
        span_poly(b, &p, k->weight + i);
    for (int i = 0; i < k->zeros; i++)
        span_poly(b, &p, k->zero + i);
    bool ok = b->max_gens <= 64 && bounds(b, f, k, used, least, most, &half) && gram_within(b, box(&l, most, 0, half), SGA_LIMIT_GRAM_CANDIDATES);
    if (ok && !k->weights && !k->zeros) {
        inside_hull(&l, &s);
        drop_alone(&l, &s);
    }
    ok = ok && l.count && add_blocks(g, &l, &p, one, true);
    for (int i = 0; i < k->weights && ok; i++) {
        struct list w = { .gens = b->max_gens };
        ok = box(&w, most, 0, half - (int)(poly_degree(b, k->weight + i) + 1) / 2) && add_blocks(g, &w, &p, k->weight + i, k->positive[i]);
        free(w.exp);
    }
    ok = ok && add_multiples(g, k, most, half);
    free(s.exp);
    free(l.exp);
    return ok;
}

bool gram_init(struct gram *g, struct poly_bridge *b, const fmpz_mpoly_t f, const fmpz_mpoly_struct *given, int n, int least)
{
    *g = (struct gram){ .b = b, .block = sga_calloc(GRAM_BLOCKS, sizeof *g->block) };
    fmpz_mat_init(g->R, 0, 0);
    fmpz_init(g->den);
    struct known k;
    SGA_FREED int *used = sga_calloc((size_t)b->max_gens, sizeof *used);
    know(b, f, given, n, &k, used);
    bool ok = gram_within(b, f->length <= GRAM_TERMS, SGA_LIMIT_GRAM_TERMS) && blocks_of(g, f, &k, used, least);
    if (ok)
        gram_sizes(g, f, given, n);
    forget(b, &k);
    return ok;
}

static void block_clear(struct poly_bridge *b, struct gram_block *k)
{
    for (int i = 0; i < k->count; i++)
        fmpz_mpoly_clear(k->q + i, b->ctx);
    free(k->q);
    fmpz_mpoly_clear(k->weight, b->ctx);
}

void gram_clear(struct gram *g)
{
    for (int i = 0; i < g->blocks; i++)
        block_clear(g->b, g->block + i);
    for (int i = 0; i < g->multiples; i++)
        fmpz_mpoly_clear(g->multiple + i, g->b->ctx);
    free(g->block);
    free(g->multiple);
    free(g->row);
    free(g->free_column);
    free(g->size);
    free(g->unit);
    fmpz_mat_clear(g->R);
    fmpz_clear(g->den);
    *g = (struct gram){ 0 };
}
