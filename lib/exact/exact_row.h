/* Sparse rows of integers, and sums of them. */
#ifndef SGA_EXACT_ROW_H
#define SGA_EXACT_ROW_H

#include <stdbool.h>
#include <stddef.h>
#include <flint/fmpz.h>

/* Increasing columns, no entry is 0. An all-zero struct is an empty row. */
struct exact_row {
    int *col;
    fmpz *value;
    int entries;
    size_t col_cap, value_cap;
};

void exact_row_clear(struct exact_row *r);
/* Adds an entry at the end: col is beyond the last one. A value of 0 is left out. */
void exact_row_push(struct exact_row *r, int col, const fmpz_t value);
/* The entries in columns before col, as a row (to is empty). */
void exact_row_copy(const struct exact_row *from, int col, struct exact_row *to);
/* The greatest common divisor of the entries, and of g before. */
void exact_row_content(fmpz_t g, const struct exact_row *r);
/* Every entry divided by d, which divides them. */
void exact_row_divide(struct exact_row *r, const fmpz_t d);
/* How many entries lie in columns before col. */
int exact_row_before(const struct exact_row *r, int col);
/* About how many bits writing the row takes. */
double exact_row_bits(const struct exact_row *r);

/* A sum of rows on its way: dense, with the columns that were met. */
struct exact_sum {
    fmpz *value;
    unsigned char *met;
    int *list;
    int cols, count;
};

void exact_sum_init(struct exact_sum *s, int cols);
void exact_sum_clear(struct exact_sum *s);
/* s += f r, or s -= f r. */
void exact_sum_add(struct exact_sum *s, const struct exact_row *r, const fmpz_t f);
void exact_sum_subtract(struct exact_sum *s, const struct exact_row *r, const fmpz_t f);
bool exact_sum_is_zero(const struct exact_sum *s);
/* Begins anew at 0. Cost: the columns that were met. */
void exact_sum_reset(struct exact_sum *s);
/* The sum as a row (appended to an empty one), and begins anew. Cost: n log n. */
void exact_sum_take(struct exact_sum *s, struct exact_row *out);

#endif
