/* Inside the poly folder: polynomials written as weighted sums of squares,
 *     f = sum over blocks of w q^T Q q  (+ multiples of what is zero),
 * w >= 0 by the ranges of kernels (1, sqrt u, 1 - sin^2 u, cosh u - 1, ...), q polynomials, Q
 * symmetric. All Q that fit f form an affine space; a point of it with Q positive definite is
 * looked for in doubles, rounded to rationals inside that space, and proved by exact L D L^T.
 * Where only semidefinite Q fit (f has zeros), the kernel is guessed from the doubles, q is
 * made shorter by it, and the search starts again (facial reduction).
 * Parrilo 2003; Peyrl and Parrilo 2008; Permenter and Parrilo 2018. */
#ifndef SGA_POLY_GRAM_H
#define SGA_POLY_GRAM_H

#include <flint/fmpq_mat.h>
#include <flint/fmpz_mat.h>

#include "bridge.h"
#include "warnings.h"

/* Past these nothing is found: a solve stays below about a second. */
enum {
    GRAM_SIZE = SGA_MOST_GRAM_SIZE, GRAM_BLOCKS = SGA_MOST_GRAM_BLOCKS, GRAM_UNKNOWNS = SGA_MOST_GRAM_UNKNOWNS,
    GRAM_EQUATIONS = SGA_MOST_GRAM_EQUATIONS, GRAM_FREE = SGA_MOST_GRAM_FREE, GRAM_TERMS = SGA_MOST_GRAM_TERMS,
    GRAM_DEGREE = SGA_MOST_GRAM_DEGREE, GRAM_GIVEN = SGA_MOST_GRAM_GIVEN
};

/* ok; where it is not, the limit is one that the job has met. */
static inline bool gram_within(const struct poly_bridge *b, bool ok, enum sga_limit limit)
{
    if (!ok)
        sga_limit_open(b->limits.budget, limit);
    return ok;
}

struct gram_block {
    fmpz_mpoly_t weight;
    bool positive;                     /* weight > 0, not only >= 0 */
    fmpz_mpoly_struct *q; int count;
    int first;                         /* unknown of entry (0, 0); entries (i, j), i <= j, follow by rows */
};

struct gram {
    struct poly_bridge *b;
    struct gram_block *block; int blocks;
    fmpz_mpoly_struct *multiple; int multiples;    /* vanish wherever the kernels have values; unknowns after the blocks' */
    int unknowns;
    /* the affine space: unknown u = (R[row][unknowns] - sum over free columns of R[row][c] y_c) / den in its pivot row */
    fmpz_mat_t R; fmpz_t den;
    int *row;                          /* by unknown: its pivot row, or -1 - (its place among the free ones) */
    int *free_column; int frees;
    double scale;                      /* of f's coefficients, a power of two */
    int *size;                         /* by generator: of which power of two values make f's terms alike */
    double *unit;                      /* by unknown: what 1 is in doubles */
};

/* gram_basis.c: blocks for f where given[0 .. n), n <= GRAM_GIVEN, are zero, too, with squares of at least the degree
 * 2 least. False: too large, or nothing could fit. */
bool gram_init(struct gram *g, struct poly_bridge *b, const fmpz_mpoly_t f, const fmpz_mpoly_struct *given, int n, int least);
void gram_clear(struct gram *g);
/* Values of f of both signs where the kernels have values: it is not definite. `sign`: the one sign met, or 0. */
bool gram_changes_sign(const struct poly_bridge *b, const fmpz_mpoly_t f, int *sign);

/* gram_sizes.c: g->scale and g->size from f and what is zero beside it. */
void gram_sizes(struct gram *g, const fmpz_mpoly_t f, const fmpz_mpoly_struct *given, int count);

/* gram_space.c: all Q that fit f. False: none, or too many unknowns. */
bool gram_space(struct gram *g, const fmpz_mpoly_t f);
/* The power of two that q's leading monomial has where each generator has its size. */
int gram_size_of(const struct gram *g, const fmpz_mpoly_t q);
/* Unknown u at y (by free unknown). */
void gram_value(const struct gram *g, const fmpq *y, int u, fmpq_t out);

/* gram_centre.c: sum of part k times y_k, in symmetric blocks: part 0 (y_0 = 1) the constant one. */
struct gram_entry { int block, i, j; double v; };      /* i <= j */
struct gram_parts {
    int blocks; int *size;
    int parts; int *start;             /* entries of part k: start[k] .. start[k + 1] */
    struct gram_entry *entry; size_t cap;
};
/* The y for which the least eigenvalue of all blocks, at most 1, is greatest, well inside where that is
 * possible; returns that eigenvalue, about, or NAN where the budget ended. Interior point method: at
 * most some 150 Newton steps of O(parts^3 + entries size^2). */
double gram_centre(const struct gram_parts *p, const struct sga_budget *budget, double *y);
/* Whether all blocks at y plus t I are positive definite. */
bool gram_inside(const struct gram_parts *p, const double *y, double t);
/* Eigenvectors of a symmetric matrix (n x n, spent) by Jacobi: columns of V, values ascending. */
void gram_eigen(double *A, int n, double *value, double *V);

/* gram_face.c: shortens q by the kernels of Q at y, as far as these look rational within the tolerance, with
 * denominators up to `most`. Returns how many of q were lost in all. */
int gram_face(struct gram *g, const struct gram_parts *p, const double *y, double tolerance, int most);
/* The matrix of one block at y, row by row. */
void gram_matrix(const struct gram_parts *p, const double *y, int block, double *Q);

/* gram.c: the sum of squares. */
struct gram_square { fmpq_t factor; int block; fmpz_mpoly_t q; };      /* factor * weight * q^2, factor > 0 */
struct gram_proof {
    struct gram g;
    struct gram_square *square; int squares;
    fmpq *multiplier;                  /* by multiple */
    bool definite;                     /* every Q is: f = 0 just where all weight * q of the blocks are */
    bool never;                        /* f > 0 */
};
/* f = the sum of squares, exactly. False: not found. The caller clears *out after true. */
bool gram_prove(struct poly_bridge *b, const fmpz_mpoly_t f, struct gram_proof *out);
void gram_proof_clear(struct gram_proof *p);
/* The same of f, or of f times 1 + the squares of its generators, which is written to multiplier (1 or that): positive
 * polynomials that are no sums of squares may be one then (Reznick 1995; Motzkin's and a little). With that only f > 0 is
 * shown. */
bool gram_prove_times(struct poly_bridge *b, const fmpz_mpoly_t f, fmpz_mpoly_t multiplier, struct gram_proof *out);
/* The same where given[0 .. n) are zero, too: f = the sum of squares plus multiples of them. With f = -1 it shows that
 * they have no common real zero (Positivstellensatz). */
bool gram_prove_with(struct poly_bridge *b, const fmpz_mpoly_t f, const fmpz_mpoly_struct *given, int n, int least, struct gram_proof *out);

#endif
