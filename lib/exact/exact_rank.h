/* The rank profile of sparse integer rows, and what dependent rows are combinations of.
 *
 * Rows are eliminated modulo one prime of 62 bits, with sparse pivots (Markowitz, Management
 * Science 3 (1957) 255). A rank modulo a prime is never too large, so rows that got pivots are
 * independent over the rationals: a theorem. A row without a pivot is taken for a combination of
 * them; exact_combine finds that combination by p-adic lifting (Dixon, Numer. Math. 40 (1982)
 * 137) with the same factors, and multiplies it out: then it is a theorem too. Where the prime
 * divides a minor that is not 0, no combination is found, and the work is begun again with
 * another prime. No number but those of the answer grows. */
#ifndef SGA_EXACT_ECHELON_H
#define SGA_EXACT_ECHELON_H

#include <flint/nmod_vec.h>

#include "arena.h"
#include "exact_row.h"

struct sga_budget;
struct sga_error;

struct exact_entry {
    int col;
    mp_limb_t value;
    double size;               /* about the value over the rationals, relative to its row: for choosing only */
};

struct exact_op {
    int pivot;                 /* this pivot's row was subtracted ... */
    mp_limb_t factor;          /* ... times this */
};

struct exact_pivot {
    int col, row;              /* row: which of the given */
    mp_limb_t inverse;         /* of the pivot */
    struct exact_entry *entry; int entries;   /* the eliminated row, without the pivot */
    struct exact_op *op; int ops;             /* in the order in which they were done */
};

enum { EXACT_SHORT = 40 };     /* bits: sums of such entries times digits of 61 bits fit 128 bits, 2^25 of them */

struct exact_echelon {
    struct sga_arena mem;      /* of all vectors but those of pivot rows */
    int cols;
    nmod_t mod;
    const struct exact_row **given; int givens; size_t given_cap;   /* borrowed */
    bool *is_short; size_t is_short_cap;          /* by given row: its entries are below 2^EXACT_SHORT */
    struct exact_pivot *pivot; int pivots; size_t pivot_cap;
    int *pivot_of;             /* by column: index or -1 */
    int *pivot_of_row; size_t pivot_of_row_cap;   /* by given row: index or -1 */
    struct exact_sum sum;      /* scratch */
    fmpz *residue;             /* scratch, by column */
    __int128 *small;           /* scratch, by column: what short rows change it by */
    struct exact_entry *work;  /* scratch, by column */
    unsigned char *mark;
};

/* which: the number of the prime to take, from 0. */
void exact_echelon_init(struct exact_echelon *e, int cols, int which);
void exact_echelon_clear(struct exact_echelon *e);
/* Adds rows (borrowed: they must stay) that are numbered on. Pivots are chosen among them all together.
 * False: the budget ended. Cost: multiplications of a sparse elimination. */
bool exact_echelon_add(struct exact_echelon *e, const struct exact_row *const *row, int rows,
                       const struct sga_budget *budget, struct sga_error *err);

/* Takes back what was added since there were so many given rows. */
void exact_echelon_cut(struct exact_echelon *e, int givens);

enum exact_found { EXACT_YES, EXACT_NO, EXACT_STOPPED };

/* den * b = sum over the pivots of factor * row: in every column, or (whole is false) in the pivots' columns. */
struct exact_combination {
    fmpz_t den;                /* > 0 */
    int *pivot; fmpz *factor; int count;      /* increasing, no factor is 0 */
};

/* EXACT_NO: b is no combination of the rows (or, with probability some 2^-60, the prime is a bad one).
 * c is initialised here in every case, and cleared by the caller. */
enum exact_found exact_combine(struct exact_echelon *e, const struct exact_row *b, bool whole, struct exact_combination *c,
                               const struct sga_budget *budget, struct sga_error *err);
void exact_combination_clear(struct exact_combination *c);

#endif
