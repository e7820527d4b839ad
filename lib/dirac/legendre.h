/* From a Lagrangian to a Hamiltonian with primary constraints.
 *
 * Source: P. A. M. Dirac, Lectures on Quantum Mechanics (1964), lecture 1; M. Henneaux & C. Teitelboim, Quantization of Gauge Systems (1992),
 * section 1.1. Two classes of L(q, v, t) are solved exactly: quadratic in v (by elimination, the rank may drop), and c sqrt(u) + b v + d with
 * u quadratic in v with a regular matrix, and b, c, d without v (relativistic particles, with the constraint pi^2 = c^2 where u is homogeneous). */
#ifndef SGA_DIRAC_LEGENDRE_H
#define SGA_DIRAC_LEGENDRE_H

#include "arena.h"
#include "weak.h"

struct legendre {
    int n, rank;                  /* of the Hessian */
    expr_id *momentum;            /* dL/dv by coordinate, in (q, v) */
    expr_id hamiltonian;          /* in (q, p) */
    expr_id *primary; int primaries;
};

struct legendre_request {
    expr_id lagrangian;
    const int *q, *v;             /* symbols */
    const expr_id *p;             /* nodes */
    int root;                     /* a symbol that nothing uses; all were there before the oracle's points */
    int n;
    const struct weak *weak;      /* its oracle decides at points of the whole space of all these */
    struct sga_arena *mem;
};

/* False: err says why it cannot be done; pointer is /system/lagrangian then. */
bool legendre_map(struct legendre *out, const struct legendre_request *rq);

#endif
