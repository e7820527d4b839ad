/* What a state form dz' = A dz + B du, dy = C dz + D du is like: eigenvalues, zeros, which of them inputs reach and outputs show.
 *
 * Exact matrices: finite elementary divisors of the pencils s I - A, [s I - A, -B], [s I - A; -C] and [s I - A, -B; -C, -D] (Rosenbrock's
 * system matrix: invariant zeros, decoupling zeros among them), so that ranks and multiplicities are proved. Otherwise eigenvalues are
 * enclosed, and a rank is said where balls prove it. */
#ifndef SGA_LINEAR_LINEAR_MODES_H
#define SGA_LINEAR_LINEAR_MODES_H

#include "spectrum_of.h"

struct linearization;

struct linear_reach {
    int dimension;             /* -1: not known */
    int least;                 /* proved */
    struct spectrum_of missed; /* eigenvalues that are not reached, or not shown; missing where they are not known */
};

enum linear_stability { LINEAR_ASYMPTOTIC, LINEAR_MARGINAL, LINEAR_UNSTABLE, LINEAR_UNDECIDED };

struct linear_modes {
    bool exact;                /* by rational arithmetic */
    struct spectrum_of eigenvalues, zeros;
    struct linear_reach controllable, observable;
    enum linear_stability stability;
    const char *why;           /* what it rests on; static */
};

/* Of l's A, B, C, D. False: the budget ended; linear_modes_clear is due in every case. Cost: four pencils, or the cube of the states. */
bool linear_modes_find(struct linear_modes *m, const struct linearization *l, const struct sga_budget *budget, struct sga_error *err);
void linear_modes_clear(struct linear_modes *m);

#endif
