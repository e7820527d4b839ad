/* The reduced echelon form of a growing set of rows. */
#include "exact_basis.h"

#include <assert.h>
#include <limits.h>
#include <stdlib.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"

void exact_basis_init(struct exact_basis *b, int linear)
{
    *b = (struct exact_basis){ .linear = linear };
    b->row_of = sga_malloc(((size_t)linear + 1) * sizeof *b->row_of);
    for (int j = 0; j < linear; j++)
        b->row_of[j] = -1;
}

void exact_basis_clear(struct exact_basis *b)
{
    for (int i = 0; i < b->rows; i++)
        exact_row_clear(b->row + i);
    free(b->row);
    free(b->pivot);
    free(b->row_of);
    *b = (struct exact_basis){ 0 };
}

void exact_primitive(struct exact_row *r, fmpq_t factor)
{
    SGA_ENDS(fmpz_end) fmpz_t g = { 0 };
    exact_row_content(g, r);
    if (r->entries && fmpz_sgn(r->value) < 0)
        fmpz_neg(g, g);
    if (!fmpz_is_zero(g)) {
        exact_row_divide(r, g);
        fmpq_div_fmpz(factor, factor, g);
    }
}

static const fmpz *entry_at(const struct exact_row *r, int col)
{
    int k = exact_row_before(r, col);
    return k < r->entries && r->col[k] == col ? r->value + k : NULL;
}

/* What r must be multiplied by so that pivots divide its entries in their columns. */
static bool common(const struct exact_basis *b, const struct exact_row *r, fmpz_t d)
{
    bool met = false;
    SGA_ENDS(fmpz_end) fmpz_t g = { 0 };
    fmpz_one(d);
    for (int k = 0; k < r->entries && r->col[k] < b->linear; k++) {
        int i = b->row_of[r->col[k]];
        if (i < 0)
            continue;
        const fmpz *p = entry_at(b->row + i, r->col[k]);
        fmpz_gcd(g, p, r->value + k);
        fmpz_divexact(g, p, g);
        fmpz_lcm(d, d, g);
        met = true;
    }
    return met;
}

void exact_basis_reduce(const struct exact_basis *b, const struct exact_row *r, int columns, struct exact_row *out, fmpq_t factor, bool *met)
{
    SGA_ENDS(exact_sum_clear) struct exact_sum sum;
    SGA_ENDS(fmpz_end) fmpz_t d = { 0 }, f = { 0 };
    exact_sum_init(&sum, columns);
    *met = common(b, r, d);
    exact_sum_add(&sum, r, d);
    for (int k = 0; k < r->entries && r->col[k] < b->linear; k++) {
        int i = b->row_of[r->col[k]];
        if (i < 0)
            continue;
        fmpz_mul(f, d, r->value + k);
        fmpz_divexact(f, f, entry_at(b->row + i, r->col[k]));
        exact_sum_subtract(&sum, b->row + i, f);
    }
    exact_sum_take(&sum, out);
    fmpq_set_fmpz(factor, d);
    exact_primitive(out, factor);
}

/* row i without column col, by the row that has its pivot there. */
static void clear_column(struct exact_basis *b, int i, const struct exact_row *by, int col, int columns)
{
    const fmpz *mine = entry_at(b->row + i, col), *theirs = entry_at(by, col);
    if (!mine)
        return;
    SGA_ENDS(exact_sum_clear) struct exact_sum sum;
    struct exact_row out = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t x = { 0 }, y = { 0 }, g = { 0 };
    SGA_ENDS(fmpq_end) fmpq_t unused = { { 0, 1 } };
    fmpz_gcd(g, mine, theirs);
    fmpz_divexact(x, theirs, g);
    fmpz_divexact(y, mine, g);
    exact_sum_init(&sum, columns);
    exact_sum_add(&sum, b->row + i, x);
    exact_sum_subtract(&sum, by, y);
    exact_sum_take(&sum, &out);
    exact_primitive(&out, unused);
    exact_row_clear(b->row + i);
    b->row[i] = out;
}

void exact_basis_add(struct exact_basis *b, const struct exact_row *reduced, int columns)
{
    int best = -1;
    struct exact_row copy = { 0 };
    for (int k = 0; k < reduced->entries && reduced->col[k] < b->linear; k++)
        if (best < 0 || fmpz_cmpabs(reduced->value + k, reduced->value + best) > 0)
            best = k;
    assert(best >= 0);
    int col = reduced->col[best];
    assert(b->row_of[col] < 0 && b->rows < b->linear);
    exact_row_copy(reduced, INT_MAX, &copy);
    for (int i = 0; i < b->rows; i++)
        clear_column(b, i, &copy, col, columns);
    SGA_RESERVE(b->row, b->row_cap, b->rows + 1);
    SGA_RESERVE(b->pivot, b->pivot_cap, b->rows + 1);
    b->row[b->rows] = copy;
    b->pivot[b->rows] = col;
    b->row_of[col] = b->rows++;
}
