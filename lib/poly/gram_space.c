/* The affine space of all Gram matrices of a polynomial, by exact elimination. */
#include "gram.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

/* Monomials that occur, as exponents, in descending order. */
struct monomials { int gens; slong count; ulong *exp; };

static int compare(const ulong *x, const ulong *y, int gens)
{
    for (int g = 0; g < gens; g++)
        if (x[g] != y[g])
            return x[g] > y[g] ? -1 : 1;
    return 0;
}

static slong place(const struct monomials *m, const ulong *exp)
{
    slong lo = 0, hi = m->count - 1;
    while (lo <= hi) {
        slong mid = (lo + hi) / 2;
        int c = compare(exp, m->exp + mid * m->gens, m->gens);
        if (c == 0)
            return mid;
        if (c < 0)
            hi = mid - 1;
        else
            lo = mid + 1;
    }
    return -1;
}

/* What unknown u multiplies. */
static bool products(struct gram *g, fmpz_mpoly_struct *product)
{
    struct poly_bridge *b = g->b;
    bool ok = true;
    for (int k = 0; k < g->blocks && ok; k++) {
        struct gram_block *c = g->block + k;
        int u = c->first;
        for (int i = 0; i < c->count && ok; i++)
            for (int j = i; j < c->count && ok; j++, u++) {
                ok = poly_mul(b, product + u, c->q + i, c->q + j) && poly_mul(b, product + u, product + u, c->weight);
                if (i != j)
                    fmpz_mpoly_scalar_mul_si(product + u, product + u, 2, b->ctx);
            }
    }
    for (int k = 0; k < g->multiples; k++)
        fmpz_mpoly_set(product + g->unknowns - g->multiples + k, g->multiple + k, b->ctx);
    return ok;
}

static bool monomials_of(const struct gram *g, const fmpz_mpoly_struct *product, const fmpz_mpoly_t f, struct monomials *m)
{
    struct poly_bridge *b = g->b;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *all = mpoly_take(&mem, b->ctx), *t = mpoly_take(&mem, b->ctx);
    for (int u = 0; u <= g->unknowns; u++) {
        fmpz_mpoly_set(t, u < g->unknowns ? product + u : f, b->ctx);
        for (slong i = 0; i < t->length; i++)
            fmpz_one(t->coeffs + i);
        fmpz_mpoly_add(all, all, t, b->ctx);
    }
    *m = (struct monomials){ .gens = b->max_gens, .count = all->length };
    bool ok = gram_within(b, m->count <= GRAM_EQUATIONS, SGA_LIMIT_GRAM_EQUATIONS);
    if (ok) {
        m->exp = sga_malloc((size_t)(m->count * m->gens + 1) * sizeof *m->exp);
        for (slong i = 0; i < m->count; i++)
            poly_exponents(b, all, i, m->exp + i * m->gens);
    }
    return ok;
}

static void column(const struct gram *g, const struct monomials *m, const fmpz_mpoly_t f, int u, fmpz_mat_t A, ulong *exp)
{
    for (slong i = 0; i < f->length; i++) {
        poly_exponents(g->b, f, i, exp);
        fmpz_set(fmpz_mat_entry(A, place(m, exp), u), f->coeffs + i);
    }
}

/* The pivots of R, and the free columns; false: a pivot on the right side. */
static bool pivots(struct gram *g, slong rank)
{
    for (int u = 0; u < g->unknowns; u++)
        g->row[u] = -1;
    int u = 0;
    for (slong r = 0; r < rank; r++) {
        while (u <= g->unknowns && fmpz_is_zero(fmpz_mat_entry(g->R, r, u)))
            u++;
        if (u >= g->unknowns)
            return false;
        g->row[u] = (int)r;
    }
    g->frees = 0;
    for (u = 0; u < g->unknowns; u++)
        if (g->row[u] < 0) {
            g->row[u] = -1 - g->frees;
            g->free_column[g->frees++] = u;
        }
    return gram_within(g->b, g->frees <= GRAM_FREE, SGA_LIMIT_GRAM_FREE);
}

static void renew(struct gram *g, slong rows)
{
    fmpz_mat_clear(g->R);
    fmpz_mat_init(g->R, rows, g->unknowns + 1);
    g->row = sga_realloc(g->row, ((size_t)g->unknowns + 1) * sizeof *g->row);
    g->free_column = sga_realloc(g->free_column, ((size_t)g->unknowns + 1) * sizeof *g->free_column);
}

int gram_size_of(const struct gram *g, const fmpz_mpoly_t q)
{
    SGA_FREED ulong *exp = sga_malloc((size_t)g->b->max_gens * sizeof *exp);
    slong size = 0;
    poly_exponents(g->b, q, 0, exp);
    for (int i = 0; i < g->b->gens; i++)
        size += (slong)exp[i] * g->size[i];
    return (int)size;
}

/* log2 of the first coefficient, about. */
static int leading_bits(const fmpz_mpoly_struct *q)
{
    slong exp = 0;
    fmpz_get_d_2exp(&exp, q->coeffs);
    return (int)exp - 1;
}

/* What 1 is in doubles, by unknown: so that all terms of f are of one size. */
static void units(struct gram *g)
{
    g->unit = sga_realloc(g->unit, ((size_t)g->unknowns + 1) * sizeof *g->unit);
    for (int u = 0; u <= g->unknowns; u++)
        g->unit[u] = g->scale;
    for (int k = 0; k < g->multiples; k++)
        g->unit[g->unknowns - g->multiples + k] = ldexp(g->scale, -gram_size_of(g, g->multiple + k) - leading_bits(g->multiple + k));
    for (int k = 0, u = 0; k < g->blocks; k++)
        for (int i = 0; i < g->block[k].count; i++)
            for (int j = i; j < g->block[k].count; j++, u++)
                g->unit[u] = ldexp(g->scale, -gram_size_of(g, g->block[k].q + i) - gram_size_of(g, g->block[k].q + j));
}

bool gram_space(struct gram *g, const fmpz_mpoly_t f)
{
    struct poly_bridge *b = g->b;
    int u = 0;
    for (int k = 0; k < g->blocks; k++) {
        g->block[k].first = u;
        u += g->block[k].count * (g->block[k].count + 1) / 2;
    }
    g->unknowns = u + g->multiples;
    if (!gram_within(b, g->unknowns <= GRAM_UNKNOWNS, SGA_LIMIT_GRAM_UNKNOWNS))
        return false;
    SGA_FREED fmpz_mpoly_struct *product = sga_malloc(((size_t)g->unknowns + 1) * sizeof *product);
    for (u = 0; u < g->unknowns; u++)
        fmpz_mpoly_init(product + u, b->ctx);
    struct monomials m = { 0 };
    bool ok = products(g, product) && monomials_of(g, product, f, &m);
    if (ok) {
        SGA_FREED ulong *exp = sga_malloc((size_t)b->max_gens * sizeof *exp);
        renew(g, m.count);
        for (u = 0; u < g->unknowns; u++)
            column(g, &m, product + u, u, g->R, exp);
        column(g, &m, f, g->unknowns, g->R, exp);
        ok = pivots(g, fmpz_mat_rref(g->R, g->den, g->R));
        units(g);
    }
    for (u = 0; u < g->unknowns; u++)
        fmpz_mpoly_clear(product + u, b->ctx);
    free(m.exp);
    return ok;
}

void gram_value(const struct gram *g, const fmpq *y, int u, fmpq_t out)
{
    assert(u >= 0 && u < g->unknowns);
    if (g->row[u] < 0) {
        fmpq_set(out, y + (-1 - g->row[u]));
        return;
    }
    SGA_ENDS(fmpq_end) fmpq_t t = { { 0, 1 } };
    fmpq_set_fmpz(out, fmpz_mat_entry(g->R, g->row[u], g->unknowns));
    for (int k = 0; k < g->frees; k++) {
        const fmpz *c = fmpz_mat_entry(g->R, g->row[u], g->free_column[k]);
        if (fmpz_is_zero(c))
            continue;
        fmpq_mul_fmpz(t, y + k, c);
        fmpq_sub(out, out, t);
    }
    fmpq_div_fmpz(out, out, g->den);
}
