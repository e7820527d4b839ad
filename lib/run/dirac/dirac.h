/* The stage `dirac`: primary and secondary constraints, classes, brackets and gauge generator of a Lagrangian or Hamiltonian system.
 *
 * A system of either form becomes a Hamiltonian one with primary constraints (lib/dirac/legendre.h), which is reduced by itself; what the brackets
 * say of it (lib/dirac/classes.h) must agree with that reduction, and with the one of the request. */
#ifndef SGA_RUN_DIRAC_H
#define SGA_RUN_DIRAC_H

#include <stdbool.h>

struct job;
struct sga_buf;

/* j->ask->dirac. False: j->err. */
bool answer_dirac(struct job *j);

/* The Lagrangian or Hamiltonian of the request as a request of its own, of the form hamiltonian with the variables q..., p... and the primary constraints
 * as restrictions: appended. Of a Lagrangian the member `legendre` too (legendre: empty else). */
bool dirac_phase_space(struct job *j, struct sga_buf *request, struct sga_buf *legendre);

#endif
