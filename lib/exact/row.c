/* Sparse rows of integers. */
#include "exact_row.h"

#include <assert.h>
#include <stdlib.h>

#include "mem.h"

void exact_row_clear(struct exact_row *r)
{
    for (int k = 0; k < r->entries; k++)
        fmpz_clear(r->value + k);
    free(r->col);
    free(r->value);
    *r = (struct exact_row){ 0 };
}

void exact_row_push(struct exact_row *r, int col, const fmpz_t value)
{
    assert(!r->entries || r->col[r->entries - 1] < col);
    if (fmpz_is_zero(value))
        return;
    SGA_RESERVE(r->col, r->col_cap, r->entries + 1);
    SGA_RESERVE(r->value, r->value_cap, r->entries + 1);
    r->col[r->entries] = col;
    fmpz_init_set(r->value + r->entries, value);
    r->entries++;
}

void exact_row_content(fmpz_t g, const struct exact_row *r)
{
    for (int k = 0; k < r->entries && !fmpz_is_one(g); k++)
        fmpz_gcd(g, g, r->value + k);
}

void exact_row_divide(struct exact_row *r, const fmpz_t d)
{
    if (fmpz_is_one(d))
        return;
    for (int k = 0; k < r->entries; k++)
        fmpz_divexact(r->value + k, r->value + k, d);
}

int exact_row_before(const struct exact_row *r, int col)
{
    int low = 0, high = r->entries;
    while (low < high) {
        int mid = (low + high) / 2;
        if (r->col[mid] < col)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

void exact_row_copy(const struct exact_row *from, int col, struct exact_row *to)
{
    int n = exact_row_before(from, col);
    for (int k = 0; k < n; k++)
        exact_row_push(to, from->col[k], from->value + k);
}

enum { ENTRY_BITS = 8 };       /* what an entry takes beside its number */

double exact_row_bits(const struct exact_row *r)
{
    double bits = 0;
    for (int k = 0; k < r->entries; k++)
        bits += ENTRY_BITS + (double)fmpz_bits(r->value + k);
    return bits;
}

void exact_sum_init(struct exact_sum *s, int cols)
{
    *s = (struct exact_sum){ .cols = cols };
    s->value = sga_calloc((size_t)cols + 1, sizeof *s->value);
    s->met = sga_calloc((size_t)cols + 1, 1);
    s->list = sga_malloc(((size_t)cols + 1) * sizeof *s->list);
}

void exact_sum_clear(struct exact_sum *s)
{
    exact_sum_reset(s);
    free(s->value);
    free(s->met);
    free(s->list);
    *s = (struct exact_sum){ 0 };
}

static void meet(struct exact_sum *s, int col)
{
    assert(col < s->cols);
    if (s->met[col])
        return;
    s->met[col] = 1;
    s->list[s->count++] = col;
}

void exact_sum_add(struct exact_sum *s, const struct exact_row *r, const fmpz_t f)
{
    for (int k = 0; k < r->entries; k++) {
        meet(s, r->col[k]);
        fmpz_addmul(s->value + r->col[k], r->value + k, f);
    }
}

void exact_sum_subtract(struct exact_sum *s, const struct exact_row *r, const fmpz_t f)
{
    for (int k = 0; k < r->entries; k++) {
        meet(s, r->col[k]);
        fmpz_submul(s->value + r->col[k], r->value + k, f);
    }
}

bool exact_sum_is_zero(const struct exact_sum *s)
{
    for (int k = 0; k < s->count; k++)
        if (!fmpz_is_zero(s->value + s->list[k]))
            return false;
    return true;
}

void exact_sum_reset(struct exact_sum *s)
{
    for (int k = 0; k < s->count; k++) {
        fmpz_clear(s->value + s->list[k]);
        fmpz_init(s->value + s->list[k]);
        s->met[s->list[k]] = 0;
    }
    s->count = 0;
}

static int by_column(const void *a, const void *b)
{
    int x = *(const int *)a, y = *(const int *)b;
    return (x > y) - (x < y);
}

void exact_sum_take(struct exact_sum *s, struct exact_row *out)
{
    qsort(s->list, (size_t)s->count, sizeof *s->list, by_column);
    for (int k = 0; k < s->count; k++)
        exact_row_push(out, s->list[k], s->value + s->list[k]);
    exact_sum_reset(s);
}
