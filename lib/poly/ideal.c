/* Buchberger's algorithm with both of his criteria; pairs of least degree first. */
#include "ideal.h"

#include <assert.h>
#include <flint/fmpz_vec.h>

#include "budget.h"
#include "mpoly_take.h"

/* What ideals of practice stay below by far; past it a basis may take minutes, and one step of FLINT cannot be interrupted. */
enum { MOST_PAIRS = 1500, MOST_TERMS = 600, MOST_BITS = 8000, MOST_DEGREE = 24 };

struct pair {
    int i, k;
    ulong degree;                  /* of the least common multiple of the leading monomials */
};

struct pairs {
    struct poly_ideal *I;
    struct sga_arena mem;
    struct pair *pair; int count; size_t cap;
    unsigned char *idle; size_t idle_cap;   /* by generator: another one's leading monomial divides its own */
    int treated;
};

void poly_ideal_init(struct poly_ideal *I, int variables, const struct sga_budget *budget)
{
    assert(variables > 0);
    *I = (struct poly_ideal){ .n = variables, .budget = budget };
    fmpz_mpoly_ctx_init(I->ctx, variables, ORD_DEGREVLEX);
}

void poly_ideal_clear(struct poly_ideal *I)
{
    sga_arena_end(&I->mem);
    fmpz_mpoly_ctx_clear(I->ctx);
}

static void lead(const struct poly_ideal *I, const fmpz_mpoly_t f, ulong *exp)
{
    assert(f->length > 0);
    fmpz_mpoly_get_term_exp_ui(exp, f, 0, I->ctx);
}

static bool divides(const ulong *a, const ulong *b, int n)
{
    for (int v = 0; v < n; v++)
        if (a[v] > b[v])
            return false;
    return true;
}

/* f over its content, the leading coefficient above 0. */
static void make_primitive(const struct poly_ideal *I, fmpz_mpoly_t out, const fmpz_mpoly_t f)
{
    fmpz_t c;
    fmpz_init(c);
    _fmpz_vec_content(c, f->coeffs, f->length);
    if (fmpz_sgn(f->coeffs) < 0)
        fmpz_neg(c, c);
    fmpz_mpoly_scalar_divexact_fmpz(out, f, c, I->ctx);
    fmpz_clear(c);
}

void poly_ideal_add(struct poly_ideal *I, const fmpz_mpoly_t f)
{
    if (!f->length)
        return;
    fmpz_mpoly_struct *own = mpoly_take(&I->mem, I->ctx);
    make_primitive(I, own, f);
    SGA_RESERVE_IN(&I->mem, I->g, I->cap, (size_t)I->count + 1);
    I->g[I->count++] = own;
}

bool poly_ideal_reduce(const struct poly_ideal *I, fmpz_mpoly_t r, fmpz_t scale, const fmpz_mpoly_t f)
{
    SGA_ARENA(mem);
    fmpz_mpoly_struct **q = sga_take(&mem, ((size_t)I->count + 1) * sizeof *q);
    for (int k = 0; k < I->count; k++)
        q[k] = mpoly_take(&mem, I->ctx);
    fmpz_mpoly_quasidivrem_ideal(scale, q, r, f, I->g, I->count, I->ctx);
    if (fmpz_sgn(scale) < 0) {
        fmpz_neg(scale, scale);
        fmpz_mpoly_neg(r, r, I->ctx);
    }
    return sga_budget_ok(I->budget, NULL);
}

static bool fits(const struct poly_ideal *I, const fmpz_mpoly_t f)
{
    return f->length <= MOST_TERMS && FLINT_ABS(fmpz_mpoly_max_bits(f)) <= MOST_BITS && fmpz_mpoly_total_degree_si(f, I->ctx) <= MOST_DEGREE;
}

static bool waits(const struct pairs *p, int a, int b)
{
    for (int k = 0; k < p->count; k++)
        if ((p->pair[k].i == a && p->pair[k].k == b) || (p->pair[k].i == b && p->pair[k].k == a))
            return true;
    return false;
}

/* No S-polynomial has to be looked at: the leading monomials have no variable in common, or another generator's divides their multiple, and its pairs
 * with both are no longer waiting. */
static bool needless(const struct pairs *p, const struct pair *at, const ulong *both, bool apart)
{
    const struct poly_ideal *I = p->I;
    SGA_ARENA(mem);
    ulong *exp = sga_take(&mem, (size_t)I->n * sizeof *exp);
    if (apart)
        return true;
    for (int k = 0; k < I->count; k++) {
        if (k == at->i || k == at->k)
            continue;
        lead(I, I->g[k], exp);
        if (divides(exp, both, I->n) && !waits(p, at->i, k) && !waits(p, at->k, k))
            return true;
    }
    return false;
}

/* The least common multiple of both leading monomials; its degree; apart: they have no variable in common. */
static ulong multiple(const struct poly_ideal *I, int i, int k, ulong *both, bool *apart)
{
    SGA_ARENA(mem);
    ulong *b = sga_take(&mem, (size_t)I->n * sizeof *b), degree = 0;
    lead(I, I->g[i], both);
    lead(I, I->g[k], b);
    *apart = true;
    for (int v = 0; v < I->n; v++) {
        *apart &= !both[v] || !b[v];
        both[v] = b[v] > both[v] ? b[v] : both[v];
        degree += both[v];
    }
    return degree;
}

/* Pairs of the last generator, and which ones it makes idle. */
static void meet(struct pairs *p, int last)
{
    const struct poly_ideal *I = p->I;
    SGA_ARENA(mem);
    ulong *own = sga_take(&mem, (size_t)I->n * sizeof *own), *both = sga_take(&mem, (size_t)I->n * sizeof *both);
    bool apart;
    SGA_RESERVE_IN(&p->mem, p->idle, p->idle_cap, (size_t)last + 1);
    p->idle[last] = 0;
    for (int k = 0; k < last; k++) {
        ulong degree = multiple(I, k, last, both, &apart);
        SGA_RESERVE_IN(&p->mem, p->pair, p->cap, (size_t)p->count + 1);
        p->pair[p->count++] = (struct pair){ k, last, degree };
        lead(I, I->g[last], own);
        lead(I, I->g[k], both);
        p->idle[k] |= divides(own, both, I->n);
    }
}

/* out = S-polynomial of two generators. */
static void s_polynomial(const struct poly_ideal *I, const struct pair *at, const ulong *both, fmpz_mpoly_t out)
{
    SGA_ARENA(mem);
    ulong *exp = sga_take(&mem, (size_t)I->n * sizeof *exp);
    fmpz_mpoly_struct *part[2];
    for (int s = 0; s < 2; s++) {
        const fmpz_mpoly_struct *f = I->g[s ? at->k : at->i], *other = I->g[s ? at->i : at->k];
        fmpz_mpoly_struct *factor = mpoly_take(&mem, I->ctx);
        part[s] = mpoly_take(&mem, I->ctx);
        lead(I, f, exp);
        for (int v = 0; v < I->n; v++)
            exp[v] = both[v] - exp[v];
        fmpz_mpoly_set_coeff_fmpz_ui(factor, other->coeffs, exp, I->ctx);
        fmpz_mpoly_mul(part[s], f, factor, I->ctx);
    }
    fmpz_mpoly_sub(out, part[0], part[1], I->ctx);
}

/* The ideal with the generators that are not idle alone: a view. */
static struct poly_ideal working(const struct pairs *p, struct sga_arena *mem)
{
    struct poly_ideal view = *p->I;
    view.g = sga_take(mem, ((size_t)p->I->count + 1) * sizeof *view.g);
    view.count = 0;
    for (int k = 0; k < p->I->count; k++)
        if (!p->idle[k])
            view.g[view.count++] = p->I->g[k];
    return view;
}

static bool treat(struct pairs *p, const struct pair *at)
{
    struct poly_ideal *I = p->I;
    SGA_ARENA(mem);
    ulong *both = sga_take(&mem, (size_t)I->n * sizeof *both);
    bool apart;
    fmpz_t scale;
    multiple(I, at->i, at->k, both, &apart);
    if (needless(p, at, both, apart))
        return true;
    fmpz_mpoly_struct *s = mpoly_take(&mem, I->ctx), *r = mpoly_take(&mem, I->ctx);
    s_polynomial(I, at, both, s);
    struct poly_ideal view = working(p, &mem);
    fmpz_init(scale);
    bool ok = poly_ideal_reduce(&view, r, scale, s) && fits(I, r);
    fmpz_clear(scale);
    if (ok && r->length) {
        poly_ideal_add(I, r);
        meet(p, I->count - 1);
    }
    return ok;
}

static struct pair least(struct pairs *p)
{
    int best = 0;
    for (int k = 1; k < p->count; k++)
        if (p->pair[k].degree < p->pair[best].degree)
            best = k;
    struct pair at = p->pair[best];
    p->pair[best] = p->pair[--p->count];
    return at;
}

/* Generators whose leading monomial another one's divides are not needed. */
static void drop_idle(struct pairs *p)
{
    struct poly_ideal *I = p->I;
    int kept = 0;
    for (int k = 0; k < I->count; k++)
        if (!p->idle[k])
            I->g[kept++] = I->g[k];
    I->count = kept;
}

bool poly_ideal_basis(struct poly_ideal *I)
{
    struct pairs p = { .I = I };
    int given = I->count;
    bool ok = true;
    I->count = 0;
    for (int k = 0; k < given && ok; k++) {      /* the same leading monomial twice would make both idle */
        fmpz_t scale;
        SGA_ARENA(mem);
        fmpz_mpoly_struct *r = mpoly_take(&mem, I->ctx), *f = I->g[k];
        struct poly_ideal view = working(&p, &mem);
        fmpz_init(scale);
        ok = fits(I, f) && poly_ideal_reduce(&view, r, scale, f) && fits(I, r);
        fmpz_clear(scale);
        if (ok && r->length) {
            make_primitive(I, f, r);
            I->g[I->count++] = f;
            meet(&p, I->count - 1);
        }
    }
    while (ok && p.count && p.treated++ < MOST_PAIRS) {
        struct pair at = least(&p);
        ok = at.degree <= MOST_DEGREE && treat(&p, &at);
    }
    ok = ok && !p.count;
    if (ok)
        drop_idle(&p);
    sga_arena_end(&p.mem);
    return ok;
}
