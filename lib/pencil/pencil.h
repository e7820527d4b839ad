/* The Kronecker canonical structure of a matrix pencil s A - B with rational entries, of any
 * shape: what A x' = B x is made of, up to changes of basis of equations and unknowns.
 *
 *   P (s A - B) Q = diag( L_e1, L_e2, ..  |  L_h1^T, ..  |  s N - I  |  s I - J )
 *
 * L_e (e x (e+1)): right minimal index e, an unknown function stays free. L_h^T: left minimal
 * index h, equations that are consequences or constraints of others. N nilpotent: the infinite
 * part, whose largest block is the nilpotency. J: the finite part.
 * (Gantmacher, The Theory of Matrices, vol. 2, ch. XII.)
 *
 * How. Rows and columns are scaled to small integers; that is an equivalence. Modulo primes of
 * 62 bits the pencil is brought to system form and deflated exactly by the staircase of Van
 * Dooren (Linear Algebra Appl. 27 (1979) 103; its form for x' = T x + G u, 0 = S x + D u is
 * Emami-Naeini & Van Dooren, Automatica 18 (1982) 415). No tolerance is involved and no number grows,
 * whatever the index. A prime gives a wrong structure only where it divides one particular minor of
 * an expanded (Toeplitz) matrix; those are bounded by Hadamard's inequality, so a structure on which
 * primes agree whose product is above the bound is proved. The characteristic polynomial of the
 * finite part comes from the same primes by rational reconstruction above Mignotte's bound;
 * Jordan blocks from ranks of f(J)^k modulo primes, with a bound for these.
 *
 * Cost: with n = rows + cols and h = sum over rows of log2 |row|, about h (k + 2) / 61 primes, k the
 * largest index, each about n^3 multiplications (less where the pencil is sparse), and the roots. */
#ifndef SGA_PENCIL_PENCIL_H
#define SGA_PENCIL_PENCIL_H

#include <stdbool.h>
#include <stddef.h>
#include <flint/fmpq.h>
#include <flint/fmpz_poly.h>

struct sga_error;

struct pencil_entry {
    int row, col;
    fmpq value;
};

struct pencil_matrix {
    struct pencil_entry *entry; int entries; size_t cap;   /* any order; equal places add up */
};

/* s A - B. Rows and columns may be 0 in number. */
struct pencil {
    int rows, cols;
    struct pencil_matrix A, B;
};

void pencil_init(struct pencil *p, int rows, int cols);
void pencil_clear(struct pencil *p);
/* m is p->A or p->B; the value is copied. */
void pencil_add(struct pencil_matrix *m, int row, int col, const fmpq_t value);

/* Eigenvalues that share their multiplicity and Jordan blocks: the roots of f. */
struct pencil_factor {
    fmpz_poly_t f;             /* primitive, squarefree, leading coefficient > 0 */
    int multiplicity;          /* of each root in the characteristic polynomial */
    int *block; int blocks;    /* sizes of each root's Jordan blocks, decreasing */
};

enum pencil_basis {
    PENCIL_PROVED,             /* primes above the bound agree */
    PENCIL_MODULAR             /* fewer primes agree: a wrong rank has probability about rank / 2^61 for each */
};

struct pencil_structure {
    bool regular;              /* square, and det(s A - B) is not identically zero */
    int normal_rank;           /* over Q(s) */
    int finite;                /* dimension of the finite part */
    int *right; int rights;    /* minimal indices, increasing */
    int *left; int lefts;
    int *infinite; int infinites;   /* block sizes, decreasing */
    int nilpotency;            /* the largest of these, or 0 */
    /* Pairwise coprime; the product of f^multiplicity is the characteristic polynomial of the
     * finite part, up to a constant. Empty where spectrum was not asked for. */
    struct pencil_factor *factor; int factors;
    enum pencil_basis basis;   /* of everything above */
    int primes;                /* how many agree */
    bool no_spectrum;          /* it was asked for, and would take longer than the budget has: left out */
};

struct pencil_options {
    bool spectrum;             /* find the factors too */
    const struct sga_budget *budget;   /* deadline and cancelling; may be NULL */
    double max_work;           /* multiplications that a proof may cost; 0: 5e9. Past it fewer primes
                                * are taken and the basis is PENCIL_MODULAR. */
};

/* Fills out; the caller clears it. False: the budget ended (LIMIT_SECONDS, CANCELLED), or the pencil
 * is too large (LIMIT_VARIABLES: more than PENCIL_MAX rows or columns); then out is cleared. */
enum { PENCIL_MAX = 2000 };
bool pencil_structure(const struct pencil *p, const struct pencil_options *options,
                      struct pencil_structure *out, struct sga_error *err);
/* As many minimal indices as rows and columns have beside the rank, and all lists in their order. Linear. */
bool pencil_structure_sane(const struct pencil *p, const struct pencil_structure *s);
void pencil_structure_clear(struct pencil_structure *s);

/* Invariant factors over Q[s] that are not 1, in number and one by one: k = 0 is the last one (the
 * minimal polynomial of the finite part), each divides the one before. Primitive. */
int pencil_invariant_factors(const struct pencil_structure *s);
void pencil_invariant_factor(const struct pencil_structure *s, int k, fmpz_poly_t out);

/* One finite generalized eigenvalue, as decimal numbers: re + i im. */
struct pencil_eigenvalue {
    char *re, *im;             /* correctly rounded, but a tie may go either way; "0" only where it is 0 */
    int factor;                /* index into structure.factor */
};

/* All of them, each once, sorted by real and then imaginary part; *out has *count elements. Where
 * rtol is 1e-15 or more each number is the shortest decimal of the nearest double; otherwise it
 * has as many digits as rtol asks. More digits are given where two eigenvalues would look equal.
 * Realness and vanishing real parts are decided exactly. False: the budget ended. */
bool pencil_eigenvalues(const struct pencil_structure *s, double rtol, const struct sga_budget *budget,
                        struct pencil_eigenvalue **out, int *count, struct sga_error *err);
void pencil_eigenvalues_clear(struct pencil_eigenvalue *e, int count);

#endif
