/* Sums of squares with an exact proof. */
#include "gram.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"
#include "mpoly_take.h"

enum { FACES = 4 };

static void clear_squares(struct gram_proof *p)
{
    for (int i = 0; i < p->squares; i++) {
        fmpq_clear(p->square[i].factor);
        fmpz_mpoly_clear(p->square[i].q, p->g.b->ctx);
    }
    free(p->square);
    for (int i = 0; i < p->g.multiples && p->multiplier; i++)
        fmpq_clear(p->multiplier + i);
    free(p->multiplier);
    p->square = NULL;
    p->multiplier = NULL;
    p->squares = 0;
}

void gram_proof_clear(struct gram_proof *p)
{
    clear_squares(p);
    gram_clear(&p->g);
}

/* The affine space in doubles. */
static void parts_of(const struct gram *g, struct gram_parts *p)
{
    assert(g->frees >= 0 && g->frees <= g->unknowns);
    int entries = 0;
    *p = (struct gram_parts){ .blocks = g->blocks, .parts = g->frees + 1 };
    p->size = sga_malloc(((size_t)g->blocks + 1) * sizeof *p->size);
    p->start = sga_malloc(((size_t)p->parts + 1) * sizeof *p->start);
    for (int b = 0; b < g->blocks; b++)
        p->size[b] = g->block[b].count;
    double den = fmpz_get_d(g->den);
    for (int k = 0; k < p->parts; k++) {
        p->start[k] = entries;
        int c = k ? g->free_column[k - 1] : g->unknowns;
        for (int b = 0; b < g->blocks; b++)
            for (int i = 0, u = g->block[b].first; i < g->block[b].count; i++)
                for (int j = i; j < g->block[b].count; j++, u++) {
                    double v = u == c ? 1 : g->row[u] < 0 ? 0 : fmpz_get_d(fmpz_mat_entry(g->R, g->row[u], c)) / den;
                    if (v == 0)
                        continue;
                    v = k == 0 ? v / g->unit[u] : u == c ? 1 : -v * g->unit[c] / g->unit[u];
                    SGA_RESERVE(p->entry, p->cap, entries + 1);
                    p->entry[entries++] = (struct gram_entry){ b, i, j, v };
                }
    }
    p->start[p->parts] = entries;
}

static void parts_clear(struct gram_parts *p)
{
    free(p->size);
    free(p->start);
    free(p->entry);
}

/* Q = L D L^T, D >= 0: row i of Q becomes D_i and L_ji (j > i). False: not semidefinite. */
static bool decompose(fmpq_mat_t Q, bool *definite)
{
    int n = (int)fmpq_mat_nrows(Q);
    SGA_ENDS(fmpq_end) fmpq_t t = { { 0, 1 } };
    bool ok = true;
    for (int k = 0; k < n && ok; k++) {
        int sign = fmpq_sgn(fmpq_mat_entry(Q, k, k));
        ok = sign >= 0;
        *definite &= sign > 0;
        for (int j = k + 1; j < n && ok; j++) {
            if (sign == 0) {
                ok = fmpq_is_zero(fmpq_mat_entry(Q, k, j));
                continue;
            }
            fmpq_div(t, fmpq_mat_entry(Q, k, j), fmpq_mat_entry(Q, k, k));
            for (int i = j; i < n; i++)
                fmpq_submul(fmpq_mat_entry(Q, j, i), t, fmpq_mat_entry(Q, k, i));
        }
        for (int j = k + 1; j < n && ok && sign; j++)
            fmpq_div(fmpq_mat_entry(Q, k, j), fmpq_mat_entry(Q, k, j), fmpq_mat_entry(Q, k, k));
    }
    return ok;
}

/* factor * (q_i + sum over j > i of L_ji q_j)^2 */
static void add_square(struct gram_proof *p, int block, const fmpq_mat_t Q, int i)
{
    const struct gram_block *k = p->g.block + block;
    struct poly_bridge *b = p->g.b;
    struct gram_square *s = p->square + p->squares++;
    SGA_ENDS(fmpz_end) fmpz_t all, c = { 0 };
    SGA_ARENA(mem);
    fmpz_init_set_ui(all, 1);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    fmpq_init(s->factor);
    fmpz_mpoly_init(s->q, b->ctx);
    s->block = block;
    for (int j = i + 1; j < k->count; j++)
        fmpz_lcm(all, all, fmpq_mat_entry_den(Q, i, j));
    fmpz_mpoly_scalar_mul_fmpz(s->q, k->q + i, all, b->ctx);
    for (int j = i + 1; j < k->count; j++) {
        fmpz_divexact(c, all, fmpq_mat_entry_den(Q, i, j));
        fmpz_mul(c, c, fmpq_mat_entry_num(Q, i, j));
        fmpz_mpoly_scalar_mul_fmpz(t, k->q + j, c, b->ctx);
        fmpz_mpoly_add(s->q, s->q, t, b->ctx);
    }
    fmpz_mul(all, all, all);
    fmpq_div_fmpz(s->factor, fmpq_mat_entry(Q, i, i), all);
}

/* Whether f is what the proof says, multiplied out. */
static bool holds(struct gram_proof *p, const fmpz_mpoly_t f)
{
    struct poly_bridge *b = p->g.b;
    SGA_ENDS(fmpz_end) fmpz_t all, c = { 0 };
    SGA_ARENA(mem);
    fmpz_init_set_ui(all, 1);
    fmpz_mpoly_struct *sum = mpoly_take(&mem, b->ctx), *t = mpoly_take(&mem, b->ctx);
    bool ok = true;
    for (int i = 0; i < p->squares; i++)
        fmpz_lcm(all, all, fmpq_denref(p->square[i].factor));
    for (int i = 0; i < p->g.multiples; i++)
        fmpz_lcm(all, all, fmpq_denref(p->multiplier + i));
    for (int i = 0; i < p->squares && ok; i++) {
        struct gram_square *s = p->square + i;
        ok = poly_mul(b, t, s->q, s->q) && poly_mul(b, t, t, p->g.block[s->block].weight);
        fmpz_divexact(c, all, fmpq_denref(s->factor));
        fmpz_mul(c, c, fmpq_numref(s->factor));
        fmpz_mpoly_scalar_mul_fmpz(t, t, c, b->ctx);
        fmpz_mpoly_add(sum, sum, t, b->ctx);
    }
    for (int i = 0; i < p->g.multiples; i++) {
        fmpz_divexact(c, all, fmpq_denref(p->multiplier + i));
        fmpz_mul(c, c, fmpq_numref(p->multiplier + i));
        fmpz_mpoly_scalar_mul_fmpz(t, p->g.multiple + i, c, b->ctx);
        fmpz_mpoly_add(sum, sum, t, b->ctx);
    }
    fmpz_mpoly_scalar_mul_fmpz(t, f, all, b->ctx);
    ok = ok && fmpz_mpoly_equal(sum, t, b->ctx);
    return ok;
}

static bool keeps_off(const struct gram_proof *p, int block, const fmpz_mpoly_t q)
{
    bool negative;
    return p->g.block[block].positive && poly_sign_of(p->g.b, q, &negative) == POLY_POSITIVE;
}

/* Whether something that never vanishes is among what vanishes where f does. */
static bool keeps_positive(const struct gram_proof *p)
{
    bool found = false;
    for (int i = 0; i < p->squares && !found; i++)
        found = keeps_off(p, p->square[i].block, p->square[i].q);
    for (int b = 0; b < p->g.blocks && p->definite; b++)
        for (int i = 0; i < p->g.block[b].count && !found; i++)
            found = keeps_off(p, b, p->g.block[b].q + i);
    return found;
}

/* The proof at y, exactly. */
static bool at(struct gram_proof *p, const fmpz_mpoly_t f, const fmpq *y)
{
    struct gram *g = &p->g;
    bool ok = true;
    int all = 0;
    for (int b = 0; b < g->blocks; b++)
        all += g->block[b].count;
    p->square = sga_calloc((size_t)all + 1, sizeof *p->square);
    p->squares = 0;
    p->definite = true;
    for (int b = 0; b < g->blocks && ok; b++) {
        int n = g->block[b].count;
        SGA_ENDS(fmpq_mat_end) fmpq_mat_t Q;
        fmpq_mat_init(Q, n, n);
        for (int i = 0, u = g->block[b].first; i < n; i++)
            for (int j = i; j < n; j++, u++)
                gram_value(g, y, u, fmpq_mat_entry(Q, i, j));
        ok = decompose(Q, &p->definite);
        for (int i = 0; i < n && ok; i++)
            if (!fmpq_is_zero(fmpq_mat_entry(Q, i, i)))
                add_square(p, b, Q, i);
    }
    p->multiplier = sga_calloc((size_t)g->multiples + 1, sizeof *p->multiplier);
    for (int i = 0; i < g->multiples; i++) {
        fmpq_init(p->multiplier + i);
        gram_value(g, y, g->unknowns - g->multiples + i, p->multiplier + i);
    }
    ok = ok && holds(p, f);
    p->never = ok && keeps_positive(p);
    if (!ok)
        clear_squares(p);
    return ok;
}

static double unit_of(const struct gram *g, int free) { return g->unit[g->free_column[free]]; }

/* numerator / denominator * 2^power */
static void exactly(fmpq_t out, double numerator, double denominator, int power)
{
    fmpz_set_d(fmpq_numref(out), numerator);
    fmpz_set_d(fmpq_denref(out), denominator);
    fmpq_canonicalise(out);
    if (power < 0)
        fmpq_div_2exp(out, out, (ulong)-power);
    else
        fmpq_mul_2exp(out, out, (ulong)power);
}

/* The point near y with these denominators, of the values themselves or (alike) of values in their units, which are powers of 2: near is what
 * it is in doubles. False: out of range. */
static bool round_to(const struct gram_proof *p, const double *y, double den, bool alike, double *near, fmpq *exact)
{
    for (int k = 0; k < p->g.frees; k++) {
        double unit = unit_of(&p->g, k), own = alike ? 1 : unit, n = nearbyint(y[k] * own * den);
        near[k] = n / den / own;
        if (!isfinite(near[k]) || !isfinite(n))
            return false;
        exactly(exact + k, n, den, alike ? ilogb(unit) : 0);
    }
    return true;
}

/* The point at y with the shortest denominators that stays inside, where the least eigenvalue is `least`: well inside
 * if there is room, otherwise what is exact decides. */
static bool rounded(struct gram_proof *p, const fmpz_mpoly_t f, const struct gram_parts *parts, const double *y, double least)
{
    static const double den[] = { 1, 2, 3, 4, 6, 12, 24, 60, 120, 0x1p10, 0x1p16, 0x1p24, 0x1p34, 0x1p46 };
    enum { DENS = sizeof den / sizeof *den };
    int n = p->g.frees;
    bool ok = false, uneven = false;
    SGA_ARENA(mem);
    double *near = sga_take(&mem, ((size_t)n + 1) * sizeof *near);
    fmpq *exact = sga_zeros(&mem, (size_t)n + 1, sizeof *exact);
    for (int k = 0; k < n; k++) {
        fmpq_init(exact + k);
        uneven |= unit_of(&p->g, k) != 1;
    }
    for (size_t d = 0; d < (uneven ? 2 : 1) * DENS && !ok; d++)
        ok = round_to(p, y, den[d % DENS], d >= DENS, near, exact)
             && gram_inside(parts, near, least > 1e-6 ? -least / 8 : 1e-9) && at(p, f, exact);
    for (int k = 0; k < n; k++)
        fmpq_clear(exact + k);
    return ok;
}

/* One face: 1 proved, 0 no proof can be had, -1 on a smaller face perhaps. */
static int on_face(struct gram_proof *p, const fmpz_mpoly_t f)
{
    static const struct { double tolerance; int most; } GUESS[] = { { 1e-6, 100 }, { 1e-4, 12 }, { 3e-3, 4 } };
    static const double OUTSIDE = 1e-5;
    SGA_ENDS(parts_clear) struct gram_parts parts = { 0 };
    int result = 0;
    if (!gram_space(&p->g, f))
        return 0;
    parts_of(&p->g, &parts);
    SGA_FREED double *y = sga_calloc((size_t)parts.parts, sizeof *y);
    double least = gram_centre(&parts, p->g.b->limits.budget, y);
    if (least > -OUTSIDE && rounded(p, f, &parts, y, least))
        result = 1;
    else if (least > -OUTSIDE)
        for (int k = 0; k < 3 && !result; k++)
            result = gram_face(&p->g, &parts, y, GUESS[k].tolerance, GUESS[k].most) ? -1 : 0;
    return result;
}

/* Positive factors of squares, each of a block. */
static bool proof_sane(const struct gram_proof *p)
{
    bool sane = true;
    for (int i = 0; i < p->squares && sane; i++)
        sane = fmpq_sgn(p->square[i].factor) > 0 && p->square[i].block >= 0 && p->square[i].block < p->g.blocks;
    return sane;
}

bool gram_prove_with(struct poly_bridge *b, const fmpz_mpoly_t f, const fmpz_mpoly_struct *given, int n, int least, struct gram_proof *out)
{
    enum { BITS = 400 };
    *out = (struct gram_proof){ 0 };
    slong bits = fmpz_mpoly_max_bits(f);
    bool ok = gram_within(b, poly_degree(b, f) <= GRAM_DEGREE, SGA_LIMIT_GRAM_DEGREE) && gram_within(b, n <= GRAM_GIVEN, SGA_LIMIT_GRAM_GIVEN);
    if (f->length < 1 || !ok || bits > BITS || -bits > BITS)
        return false;
    int result = 0;
    /* in natural sizes, and where these are no simple numbers, which a face asks for, in those of the coefficients */
    for (int plain = 0; plain < 2 && result != 1; plain++) {
        result = gram_init(&out->g, b, f, given, n, least) ? -1 : 0;
        if (plain && (result == 0 || !gram_sizes_forget(&out->g, f)))
            result = 0;
        for (int k = 0; k < FACES && result < 0; k++)
            result = on_face(out, f);
        if (result != 1)
            gram_proof_clear(out);
    }
    assert(result != 1 || proof_sane(out));
    return result == 1;
}

bool gram_prove(struct poly_bridge *b, const fmpz_mpoly_t f, struct gram_proof *out)
{
    return poly_degree(b, f) >= 1 && gram_prove_with(b, f, NULL, 0, 0, out);
}

/* 1 + the squares of the generators of f, in natural sizes, times a number */
static void reznick(struct poly_bridge *b, const fmpz_mpoly_t f, fmpz_mpoly_t out)
{
    struct gram g = { .b = b };
    int largest = 0;
    SGA_ARENA(mem);
    SGA_ENDS(fmpz_end) fmpz_t c;
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    fmpz_init_set_ui(c, 1);
    gram_sizes(&g, f, NULL, 0);
    for (int k = 0; k < b->gens; k++)
        largest = g.size[k] > largest ? g.size[k] : largest;
    fmpz_mul_2exp(c, c, (ulong)(2 * largest));
    fmpz_mpoly_set_fmpz(out, c, b->ctx);
    for (int k = 0; k < b->gens; k++)
        if (fmpz_mpoly_degree_si(f, k, b->ctx) > 0) {
            fmpz_one(c);
            fmpz_mul_2exp(c, c, (ulong)(2 * (largest - g.size[k])));
            fmpz_mpoly_gen(t, k, b->ctx);
            fmpz_mpoly_mul(t, t, t, b->ctx);
            fmpz_mpoly_scalar_mul_fmpz(t, t, c, b->ctx);
            fmpz_mpoly_add(out, out, t, b->ctx);
        }
    free(g.size);
}

bool gram_prove_times(struct poly_bridge *b, const fmpz_mpoly_t f, fmpz_mpoly_t multiplier, struct gram_proof *out)
{
    enum { LENGTH = 40 };      /* the product is longer */
    fmpz_mpoly_one(multiplier, b->ctx);
    if (gram_prove(b, f, out))
        return true;
    if (f->length > LENGTH)
        return false;
    SGA_ARENA(mem);
    fmpz_mpoly_struct *t = mpoly_take(&mem, b->ctx);
    reznick(b, f, multiplier);
    bool found = poly_mul(b, t, f, multiplier) && gram_prove(b, t, out), never = found && out->never;
    if (found && !never)
        gram_proof_clear(out);
    return never;
}
