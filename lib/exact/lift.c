/* Combinations of rows over the rationals, digit by digit in base p. Only what the row to be combined leads to is looked at: its columns,
 * their pivots, the columns of these, and so on. */
#include "exact_rank.h"

#include <stdlib.h>

#include <flint/fmpq.h>
#include <flint/ulong_extras.h>

#include "arena.h"
#include "budget.h"
#include "flint_ends.h"
#include "mem.h"

struct lift {
    struct sga_arena mem;
    struct exact_echelon *e;
    const struct exact_row *b;
    bool whole;
    int *col, cols;            /* what b leads to */
    int *pivot, pivots;        /* those of these columns, increasing; of the vectors by pivot nothing else is set */
    mp_limb_t *w, *z;          /* scratch: by column, by pivot */
    unsigned char *used;       /* by pivot: some digit was not 0 */
    fmpz *sum;                 /* by pivot: the digits so far */
    fmpz_t power;              /* of p: modulus of the sums */
};

void exact_combination_clear(struct exact_combination *c)
{
    for (int k = 0; k < c->count; k++)
        fmpz_clear(c->factor + k);
    free(c->pivot);
    free(c->factor);
    fmpz_clear(c->den);
    c->pivot = NULL;
    c->factor = NULL;
    c->count = 0;
}

/* One digit of each factor: z with (residue - z rows) = 0 modulo p in the pivots' columns. */
static void digit(struct lift *l)
{
    struct exact_echelon *e = l->e;
    mp_limb_t n = e->mod.n, inv = e->mod.ninv;
    for (int i = 0; i < l->cols; i++) {
        int j = l->col[i];
        l->w[j] = fmpz_is_zero(e->residue + j) ? 0 : fmpz_fdiv_ui(e->residue + j, n);
    }
    for (int i = 0; i < l->pivots; i++) {       /* w = z' U */
        int q = l->pivot[i];
        const struct exact_pivot *p = e->pivot + q;
        mp_limb_t f = l->w[p->col] ? n_mulmod2_preinv(l->w[p->col], p->inverse, n, inv) : 0;
        l->z[q] = f;
        if (!f)
            continue;
        mp_limb_t minus = nmod_neg(f, e->mod), quotient = n_mulmod_precomp_shoup(minus, n);
        for (int k = 0; k < p->entries; k++) {
            mp_limb_t *to = l->w + p->entry[k].col;
            *to = nmod_add(*to, n_mulmod_shoup(minus, p->entry[k].value, quotient, n), e->mod);
        }
    }
    for (int i = l->pivots - 1; i >= 0; i--) {  /* z' = z L */
        int q = l->pivot[i];
        const struct exact_pivot *p = e->pivot + q;
        if (!l->z[q])
            continue;
        mp_limb_t minus = nmod_neg(l->z[q], e->mod), quotient = n_mulmod_precomp_shoup(minus, n);
        for (int k = 0; k < p->ops; k++) {
            mp_limb_t *to = l->z + p->op[k].pivot;
            *to = nmod_add(*to, n_mulmod_shoup(minus, p->op[k].factor, quotient, n), e->mod);
        }
    }
}

/* The digit of pivot q between -p/2 and p/2, into its sum; its row is taken off the residue. */
static void take_off(struct lift *l, int q, fmpz_t s)
{
    struct exact_echelon *e = l->e;
    const struct exact_row *r = e->given[e->pivot[q].row];
    slong z = l->z[q] > e->mod.n / 2 ? -(slong)(e->mod.n - l->z[q]) : (slong)l->z[q];
    fmpz_set_si(s, z);
    l->used[q] = 1;
    fmpz_addmul(l->sum + q, s, l->power);
    if (e->is_short[e->pivot[q].row])
        for (int k = 0; k < r->entries; k++)
            e->small[r->col[k]] += (__int128)z * r->value[k];
    else
        for (int k = 0; k < r->entries; k++)
            fmpz_submul(e->residue + r->col[k], s, r->value + k);
}

static void subtract_wide(fmpz_t v, __int128 d)
{
    unsigned __int128 size = d < 0 ? -(unsigned __int128)d : (unsigned __int128)d;
    SGA_ENDS(fmpz_end) fmpz_t t = { 0 };
    fmpz_set_uiui(t, (mp_limb_t)(size >> 64), (mp_limb_t)size);
    if (d < 0)
        fmpz_add(v, v, t);
    else
        fmpz_sub(v, v, t);
}

/* residue = (residue - z rows) / p. 1: it is 0, 0: not, -1: p does not divide it. */
static int next_residue(struct lift *l)
{
    struct exact_echelon *e = l->e;
    SGA_ENDS(fmpz_end) fmpz_t s = { 0 };
    bool zero = true;
    int result = 0;
    for (int i = 0; i < l->pivots; i++)
        if (l->z[l->pivot[i]])
            take_off(l, l->pivot[i], s);
    fmpz_set_ui(s, e->mod.n);
    fmpz_mul(l->power, l->power, s);
    for (int i = 0; i < l->cols; i++) {
        int j = l->col[i];
        fmpz *v = e->residue + j;
        if (e->small[j])
            subtract_wide(v, e->small[j]);
        e->small[j] = 0;
        if (fmpz_is_zero(v) || result < 0)
            continue;
        if (!l->whole && e->pivot_of[j] < 0)
            fmpz_zero(v);
        else if (fmpz_divisible(v, s))
            fmpz_divexact(v, v, s);
        else
            result = -1;
        zero = zero && fmpz_is_zero(v);
    }
    return result < 0 ? -1 : zero;
}

/* y mod m, the one nearest to 0. */
static void nearest(fmpz_t y, const fmpz_t m)
{
    SGA_ENDS(fmpz_end) fmpz_t twice = { 0 };
    fmpz_mod(y, y, m);
    fmpz_mul_2exp(twice, y, 1);
    if (fmpz_cmp(twice, m) > 0)
        fmpz_sub(y, y, m);
}

enum { SLACK_BITS = 24 };      /* by which a number must be shorter than chance would have it */

/* A common denominator of the sums modulo power. False: they have none that is short enough. */
static bool denominator(struct lift *l, fmpz_t den)
{
    mp_bitcnt_t half = (fmpz_bits(l->power) - SLACK_BITS) / 2;
    SGA_ENDS(fmpz_end) fmpz_t y = { 0 }, bound = { 0 };
    SGA_ENDS(fmpq_end) fmpq_t r = { { 0, 1 } };
    bool ok = true;
    fmpz_setbit(bound, half);
    fmpz_one(den);
    for (int i = 0; i < l->pivots && ok; i++) {
        int q = l->pivot[i];
        if (!l->used[q])
            continue;
        fmpz_mul(y, l->sum + q, den);
        nearest(y, l->power);
        if (fmpz_bits(y) <= half)
            continue;
        fmpz_mod(y, y, l->power);
        ok = fmpq_reconstruct_fmpz_2(r, y, l->power, bound, bound);
        if (ok)
            fmpz_mul(den, den, fmpq_denref(r));
        ok = ok && fmpz_bits(den) <= half;
    }
    return ok;
}

/* The combination with this denominator, multiplied out. */
static bool holds(struct lift *l, struct exact_combination *c)
{
    struct exact_echelon *e = l->e;
    SGA_ENDS(fmpz_end) fmpz_t y = { 0 };
    bool zero = true;
    for (int k = 0; k < c->count; k++)
        fmpz_clear(c->factor + k);
    c->count = 0;
    exact_sum_add(&e->sum, l->b, c->den);
    for (int i = 0; i < l->pivots; i++) {
        int q = l->pivot[i];
        if (!l->used[q])
            continue;
        fmpz_mul(y, l->sum + q, c->den);
        nearest(y, l->power);
        if (fmpz_is_zero(y))
            continue;
        exact_sum_subtract(&e->sum, e->given[e->pivot[q].row], y);
        c->pivot[c->count] = q;
        fmpz_init_set(c->factor + c->count++, y);
    }
    for (int k = 0; k < e->sum.count && zero; k++) {
        int j = e->sum.list[k];
        zero = fmpz_is_zero(e->sum.value + j) || (!l->whole && e->pivot_of[j] < 0);
    }
    exact_sum_reset(&e->sum);
    return zero;
}

static void reach(struct lift *l, int col)
{
    if (!l->e->mark[col])
        l->col[l->cols++] = col;
    l->e->mark[col] = 1;
}

static int rising(const void *a, const void *b)
{
    const int *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* The columns and pivots that digits of b can be found at. Linear in their entries, and sorting. */
static void reach_all(struct lift *l)
{
    struct exact_echelon *e = l->e;
    for (int k = 0; k < l->b->entries; k++)
        reach(l, l->b->col[k]);
    for (int i = 0; i < l->cols; i++) {
        int q = e->pivot_of[l->col[i]];
        if (q < 0)
            continue;
        const struct exact_pivot *p = e->pivot + q;
        l->pivot[l->pivots++] = q;
        for (int k = 0; k < p->entries; k++)
            reach(l, p->entry[k].col);
        for (int k = 0; k < p->ops; k++)
            reach(l, e->pivot[p->op[k].pivot].col);
        for (int k = 0; k < e->given[p->row]->entries; k++)
            reach(l, e->given[p->row]->col[k]);
    }
    for (int i = 0; i < l->cols; i++)
        e->mark[l->col[i]] = 0;
    qsort(l->pivot, (size_t)l->pivots, sizeof *l->pivot, rising);
}

static void lift_init(struct lift *l, struct exact_echelon *e)
{
    size_t n = (size_t)e->pivots + 1;
    l->col = sga_take(&l->mem, ((size_t)e->cols + 1) * sizeof *l->col);
    l->pivot = sga_take(&l->mem, n * sizeof *l->pivot);
    reach_all(l);
    l->w = sga_take(&l->mem, ((size_t)e->cols + 1) * sizeof *l->w);
    l->z = sga_take(&l->mem, n * sizeof *l->z);
    l->used = sga_take(&l->mem, n);
    l->sum = sga_take(&l->mem, n * sizeof *l->sum);
    fmpz_init_set_ui(l->power, 1);
    for (int i = 0; i < l->pivots; i++) {
        l->used[l->pivot[i]] = 0;
        fmpz_init(l->sum + l->pivot[i]);
    }
    for (int i = 0; i < l->cols; i++)
        fmpz_zero(e->residue + l->col[i]);
    for (int k = 0; k < l->b->entries; k++)
        if (l->whole || e->pivot_of[l->b->col[k]] >= 0)
            fmpz_set(e->residue + l->b->col[k], l->b->value + k);
}

static void lift_clear(struct lift *l)
{
    for (int i = 0; i < l->pivots; i++)
        fmpz_clear(l->sum + l->pivot[i]);
    sga_arena_end(&l->mem);
    fmpz_clear(l->power);
}

enum exact_found exact_combine(struct exact_echelon *e, const struct exact_row *b, bool whole, struct exact_combination *c,
                               const struct sga_budget *budget, struct sga_error *err)
{
    SGA_ENDS(lift_clear) struct lift l = { .e = e, .b = b, .whole = whole };
    enum exact_found found = EXACT_NO;
    *c = (struct exact_combination){ .count = 0 };
    fmpz_init_set_ui(c->den, 1);
    lift_init(&l, e);
    c->pivot = sga_malloc(((size_t)l.pivots + 1) * sizeof *c->pivot);
    c->factor = sga_calloc((size_t)l.pivots + 1, sizeof *c->factor);
    for (int k = 1, look = 1;; k++) {
        if (!sga_budget_ok(budget, err)) {
            found = EXACT_STOPPED;
            break;
        }
        digit(&l);
        int zero = next_residue(&l);
        if (zero < 0)
            break;
        if (zero)
            fmpz_one(c->den);
        if ((zero || (k == look && denominator(&l, c->den))) && holds(&l, c)) {
            found = EXACT_YES;
            break;
        }
        look += k == look ? 1 + k / 3 : 0;
    }
    return found;
}
