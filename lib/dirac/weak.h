/* Weak equality and linear algebra over functions on a constraint set: what is zero the oracle decides at certified points of the set. */
#ifndef SGA_DIRAC_WEAK_H
#define SGA_DIRAC_WEAK_H

#include <stdbool.h>

#include "arena.h"
#include "expr.h"

struct points_oracle;
struct sga_budget;
struct sga_error;

/* What an elimination divided by, in the order of the pivots. */
struct weak_pivots {
    struct sga_arena *mem;
    expr_id *e; int count; size_t cap;
};

struct weak {
    struct expr_store *st;
    struct points_oracle *oracle;     /* points of the set */
    const struct sga_budget *budget;
    struct sga_error *err;
    struct weak_pivots *pivots;       /* appended to, or NULL */
};

/* 1 zero on the set, 0 not, -1 undecided: err is filled. */
int weak_zero(const struct weak *w, expr_id e);
/* e in normal form where that is found. */
expr_id weak_normal(const struct weak *w, expr_id e);

/* Something shorter that is equal to e wherever the functions `by` vanish, or e. */
expr_id weak_on_set(const struct weak *w, expr_id e, const expr_id *by, int count);

/* Gauss and Jordan on the first `columns` of `width` columns, from left to right, in place: each pivot is 1 then and stands alone in its column. A column
 * is passed over where it depends on those to the left of it, on the set. pivot_of[column] is the row, or -1. What is decided to be zero is made
 * the constant 0. False: undecided, or out of budget. Cost: rows * columns * width operations. */
bool weak_eliminate(const struct weak *w, expr_id *m, int rows, int columns, int width, int *pivot_of);

#endif
