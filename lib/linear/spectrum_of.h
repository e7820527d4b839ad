/* Eigenvalues with what is known of them. */
#ifndef SGA_LINEAR_SPECTRUM_OF_H
#define SGA_LINEAR_SPECTRUM_OF_H

#include "arena.h"
#include "linear_matrix.h"

struct sga_budget;
struct sga_error;

/* Where its real part is: right of the axis, on it, left of it, or not known. */
enum spectrum_side { SPECTRUM_RIGHT, SPECTRUM_AXIS, SPECTRUM_LEFT, SPECTRUM_UNKNOWN };

struct spectrum_value {
    char *re, *im;             /* decimal numbers: correctly rounded where exact; else see `error` */
    double size;               /* |value|, roughly */
    int multiplicity;          /* exact; otherwise so many in one disc, which need not be equal */
    int block;                 /* its largest Jordan block; 0: not known */
    enum spectrum_side side;
};

struct spectrum_of {
    struct sga_arena mem;
    struct spectrum_value *value; int count;
    int total;                 /* with multiplicities */
    bool exact;                /* by algebra, from rational matrices */
    double error;              /* not exact: a bound of |true - written| over all of them */
    const char *missing;       /* why there is none, static; NULL: there is */
};

/* The finite generalized eigenvalues of s E - F, of any shape: its elementary divisors (pencil.h). Both exact. False: the budget ended. */
bool spectrum_of_pencil(struct spectrum_of *s, const struct linear_matrix *E, const struct linear_matrix *F, const struct sga_budget *budget,
                        struct sga_error *err);
/* Eigenvalues of a square matrix: as above where it is exact, otherwise enclosed by Arb (Rump's discs around clusters), sorted by real
 * and then imaginary part. Cost: the cube, in balls. */
bool spectrum_of_matrix(struct spectrum_of *s, const struct linear_matrix *A, const struct sga_budget *budget, struct sga_error *err);
void spectrum_of_clear(struct spectrum_of *s);

#endif
