/* The kernel of m independent rows by cofactors: for m + 1 columns S the vector with entries
 * (-1)^k det(rows, S without its k-th column) is annihilated by every row (Cramer; the rows of the
 * m + 1 square matrix with one row doubled). Where the rows are independent some minor does
 * not vanish, and the vectors that contain it span the kernel. */
#include "cofactors.h"

#include <stdint.h>
#include <stdlib.h>

#include "arena.h"
#include "mem.h"

enum { MOST_COLUMNS = 16 };

static int bits(uint32_t mask)
{
    return __builtin_popcount(mask);
}

static long choose(int n, int k)
{
    long c = 1;
    for (int i = 0; i < k; i++)
        c = c * (n - i) / (i + 1);
    return c;
}

/* minor[S]: the determinant of the first |S| rows and the columns S, by its last row. */
static expr_id *all_minors(struct expr_store *st, expr_id *const *row, int rows, const int *col, int n)
{
    expr_id *minor = sga_calloc((size_t)1 << n, sizeof *minor);
    minor[0] = expr_int(st, 1);
    for (uint32_t s = 1; s < (uint32_t)1 << n; s++) {
        int m = bits(s);
        if (m > rows)
            continue;
        expr_id sum = expr_int(st, 0);
        for (int j = 0, k = 0; j < n; j++) {
            if (!(s >> j & 1))
                continue;
            expr_id t = expr_mul(st, row[m - 1][col[j]], minor[s & ~((uint32_t)1 << j)]);
            sum = (m - 1 - k++) % 2 ? expr_sub(st, sum, t) : expr_add(st, sum, t);
        }
        minor[s] = sum;
    }
    return minor;
}

bool form_cofactors(struct expr_store *st, expr_id *const *row, int rows, const int *col, int n, int cols,
                    expr_id **out, int *count)
{
    if (n > MOST_COLUMNS || choose(n, rows + 1) > FORM_COFACTORS)
        return false;
    SGA_FREED expr_id *minor = all_minors(st, row, rows, col, n);
    long most = *count + choose(n, rows + 1);
    *out = sga_realloc(*out, ((size_t)most * (size_t)cols + 1) * sizeof **out);
    for (uint32_t s = 0; s < (uint32_t)1 << n; s++) {
        if (bits(s) != rows + 1)
            continue;
        expr_id *v = *out + (size_t)*count * (size_t)cols;
        bool some = false;
        for (int j = 0; j < cols; j++)
            v[j] = expr_int(st, 0);
        for (int j = 0, k = 0; j < n; j++) {
            if (!(s >> j & 1))
                continue;
            expr_id d = minor[s & ~((uint32_t)1 << j)];
            v[col[j]] = k++ % 2 ? expr_neg(st, d) : d;
            some = some || !expr_is_zero(st, d);
        }
        *count += some;
    }
    return true;
}
