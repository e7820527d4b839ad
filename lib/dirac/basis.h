/* Bases of the constraints of the first class in which the primary ones do not mix them.
 *
 * A generator whose parameters are functions of time alone asks that {gamma_A, phi} is a combination of primary constraints for each primary phi. In bent
 * coordinates constraints come with factors and in combinations for which it is not, though others span the same: solved for momenta they commute
 * (M. Henneaux & C. Teitelboim, Quantization of Gauge Systems (1992), section 5.2.1); and where {gamma, phi} = C gamma a factor f with {f, phi} = -f C makes up
 * for C, which is looked for among products of powers of the factors that occur (Darboux's method of integration by invariant curves, 1878). */
#ifndef SGA_DIRAC_BASIS_H
#define SGA_DIRAC_BASIS_H

#include "classes.h"

struct dirac_basis {
    int firsts, primary;          /* the primary ones come first, and stay as they are */
    expr_id *first;
    expr_id *inverse;             /* (firsts - primary)^2: the old ones by these, but for primary ones */
};

/* Those of the classes. In mem of the system's space, as all below. */
void dirac_basis_begin(struct dirac_basis *b, const struct dirac_system *d, const struct dirac_classes *c);
/* Solved for momenta, or coordinates, by elimination. False: undecided. */
bool dirac_basis_resolve(struct dirac_basis *b, const struct dirac_system *d);
/* Times factors. mix: primary x (firsts - primary)^2: {gamma_A, phi_a} = mix[a][A][B] gamma_B + primary ones. *found: there are such factors. False: undecided. */
bool dirac_basis_scale(struct dirac_basis *b, const struct dirac_system *d, const expr_id *mix, bool *found);

#endif
