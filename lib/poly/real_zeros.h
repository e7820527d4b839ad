/* How many real points a system of polynomial equations has: a proof that a list of them is complete.
 *
 * Source: P. Pedersen, M.-F. Roy & A. Szpirglas, Counting real zeros in the multivariate case, Computational Algebraic Geometry (1993) 203; Hermite (1853)
 * for one variable: in the algebra of polynomials modulo the ideal the quadratic form h -> trace of multiplication by h^2 has the rank of
 * all and the signature of the real zeros, each counted once. Everything is rational, so the count is exact. */
#ifndef SGA_POLY_REAL_ZEROS_H
#define SGA_POLY_REAL_ZEROS_H

#include <flint/fmpz_poly.h>

#include "arena.h"
#include "expr.h"

struct sga_budget;

/* Their number, and the zeros by the roots of one polynomial: each zero, real or not, is x_k = over_k(t)/below(t) at one root t of `root`, which is squarefree;
 * real zeros are at real roots. */
struct poly_real_zeros {
    struct sga_arena mem;
    long real;                     /* each once */
    int symbols, roots;            /* roots of expressions (sqrt, cbrt, abs, ...) are variables too, behind the symbols, with their relations */
    unsigned char *nonnegative;    /* by root of an expression: it is, so that zeros where it is negative are none; they are among `real` */
    fmpz_poly_t root, below;
    fmpz_poly_struct *over;        /* by variable; NULL: not known */
};

enum poly_count { POLY_COUNTED, POLY_MANY, POLY_NOT_COUNTED };

/* Real common zeros of the numerators of e[0 .. n), in all of these symbols, each once: a bound from above of the zeros of e, and their number where nothing is
 * divided by. Functions with others than polynomials and roots of them are left out of account, which may only leave more. POLY_MANY: the zeros that numbers over the complex
 * field make are no finite set; POLY_NOT_COUNTED: too large (ideal.c, hermite.h, and the constants of real_zeros.c), or the budget ended. Cost: a Groebner basis, and
 * the fourth power of its dimension. poly_real_zeros_clear is due in every case. */
enum poly_count poly_real_zeros(struct expr_store *st, const expr_id *e, int n, const int *symbol, int symbols, const struct sga_budget *budget, struct poly_real_zeros *out);
void poly_real_zeros_clear(struct poly_real_zeros *z);

#endif
