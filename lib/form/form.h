/* Forms: what a user wrote, brought to A(x, t) x' = alpha(x, t).
 *
 * Input is expression handles and symbols, no JSON; sizes have been checked by the
 * caller (asserted here). Output goes to a struct sys_system that has its store and
 * its time symbol and is otherwise empty. Nothing is assumed about squareness. */
#ifndef SGA_FORM_FORM_H
#define SGA_FORM_FORM_H

#include "system.h"

/* A(x, t) x' = alpha(x, t), or its right-hand problem. */
struct form_entry {
    int row, col;                            /* of A as given, from 0 */
    expr_id value;
};

struct form_quasilinear {
    const int *variable; int variables;      /* symbols of x */
    int rows, cols;                          /* of A as given */
    const struct form_entry *entry; size_t entries;   /* any order; equal places add up */
    const expr_id *alpha;                    /* rows of them, cols if transposed */
    const expr_id *restriction; int restrictions;
    bool transpose;                          /* A^T x' = alpha: variables = rows */
};

/* Rows are named "row i". Cost: the number of entries. */
void form_quasilinear(struct sys_system *s, const struct form_quasilinear *in);

struct form_matrix {
    int rows, cols;
    const struct form_entry *entry; size_t entries;     /* any order; equal places add up */
};

/* A x' = B x + C u with constant matrices; with feedback u = D x', that is
 * (A - C D) x' = B x. */
struct form_linear {
    const int *variable; int variables;
    struct form_matrix A, B, C, D;       /* C, D: 0 x 0 where they are absent */
    const expr_id *u;                    /* C.cols of them where there is no D */
    const int *input; int inputs;        /* those of u that are variables themselves */
};

/* Rows are named "row i", inputs have the role "input". Cost: the number of entries, and
 * for each entry of C the entries of one row of D. */
void form_linear(struct sys_system *s, const struct form_linear *in);

/* x' = F + sum u_j G_j on the zero set of the constraints. */
struct form_control {
    const int *variable; int variables;
    const int *input; int inputs;
    const expr_id *F;                    /* one for each variable */
    struct form_matrix G;                /* inputs x variables */
    const expr_id *constraint; int constraints;
};

/* Variables are x and then u (role "input"). Rows are named "equation of x" and
 * "constraints[i]". Cost: the number of entries. */
void form_control(struct sys_system *s, const struct form_control *in);

/* i_X omega = dH, that is Omega^T x' = grad H with omega_ij = omega(d_i, d_j), on the zero
 * set of the restrictions; there it is pulled back: e^T (Omega^T x' - grad H) = 0 for vectors e
 * that span the kernel of the restrictions' differentials. So the result does not depend on how
 * H goes on outside (Gotay, Nester & Hinds, J. Math. Phys. 19 (1978) 2388).
 *
 * The vectors are made without division, except by constants; they may be more than a basis, so
 * that they span the kernel at every point where the differentials are independent (cofactors.c).
 * For that the restrictions must be regular and independent on their zeros: p^2, or p said
 * twice in other words, has differentials that vanish there. */
struct form_zero {
    bool (*vanishes)(void *ctx, expr_id e);   /* what counts as zero on the set */
    void *ctx;
};

struct form_hamiltonian {
    const int *variable; int variables;
    expr_id hamiltonian;
    const struct form_matrix *omega;     /* NULL: canonical, q1..qk, p1..pk (variables even) */
    const expr_id *restriction; int restrictions;
    const struct form_zero *zero;        /* NULL: zero at a random point of all symbols */
};

/* The vectors of the pull-back, `variables` entries each, one for each row; empty where there is
 * no restriction. */
struct form_tangent {
    expr_id *vector;                     /* owned */
    int count;
};

/* Vectors of `cols` entries that span the kernel of a dense rows x cols matrix of expressions (by
 * rows, overwritten), one after the other in a new array; *count is how many.
 *
 * Constant pivots are eliminated first. What is left falls into blocks that share no column,
 * and a small block of m independent rows gives all its cofactor vectors, one for each choice of
 * m + 1 columns: more than a basis, but they span the kernel wherever the rows are independent, so
 * that no point is singular only because of an unlucky pivot. A block that is too large for
 * that is eliminated crosswise; the vectors are then a basis where the pivots do not vanish.
 *
 * vanishes(ctx, e) says what counts as zero (on the set that the vectors shall be tangent to);
 * NULL: what is zero at a random point of all symbols. Cost: rows^2 cols operations, and at
 * most 200 vectors for each block. */
expr_id *form_kernel(struct expr_store *st, expr_id *matrix, int rows, int cols, const struct form_zero *zero, int *count);

/* Is entry (i, j) + entry (j, i) zero by rational identities? Decided at a random point. Returns
 * the first entry whose sum is not, or the number of entries. Cost: entries log entries, and the cones of the sums. */
size_t form_not_antisymmetric(struct expr_store *st, const struct form_matrix *m);

/* The variables and the restrictions alone. */
void form_hamiltonian_space(struct sys_system *s, const struct form_hamiltonian *in);
/* The rows: "row i", or "pull-back i" along the vector i. out may be NULL. Cost: cubic in the number of
 * restrictions and variables that they depend on, in the worst case. */
void form_hamiltonian_rows(struct sys_system *s, const struct form_hamiltonian *in, struct form_tangent *out);

/* d omega = 0: the sum over i, j, k in cyclic order of d_i omega_jk. One sum for each three
 * variables i < j < k for which some term is not the constant 0, in increasing order; caller frees. A
 * canonical form has none. False where there are more than `most`. */
struct form_cycle {
    int i, j, k;                         /* variables */
    expr_id sum;
};
bool form_cycles(struct expr_store *st, const int *variable, int variables, const struct form_matrix *omega, int most,
                 struct form_cycle **cycle, int *cycles);

/* The Euler-Lagrange equations of L(q, v, t), W the Hessian of L in v:
 *   second order:  q' = v,  W v' = dL/dq - (d2L/dv dq) v - d2L/dv dt + F + (dg/dq)^T lambda
 *   otherwise i_X omega_L = dE_L alone (E_L = v dL/dv - L, omega_L = sum dq ^ d(dL/dv)):
 *     W v' + (P - P^T) q' = dL/dq - P^T v - d2L/dv dt + F + (dg/dq)^T lambda,  W q' = W v
 *   with P = d2L/dv dq;  and 0 = g.
 * The velocities stand in the store as EXPR_VARIABLE. */
struct form_lagrangian {
    const int *coordinate, *velocity; int coordinates;
    expr_id lagrangian;
    bool second_order;
    const expr_id *force;                    /* one for each coordinate, or NULL */
    const expr_id *constraint; int constraints;   /* g(q, t) */
    const int *multiplier;                   /* one for each constraint */
};

/* Variables are q, v (role "velocity"), lambda (role "multiplier"). Cost: one gradient for
 * L, each momentum and each constraint. */
void form_lagrangian(struct sys_system *s, const struct form_lagrangian *in);

/* Particles and bodies with masses, forces and constraints in q and q' (the third source,
 * section 2): q' = v, M v' - H^T lambda = F, 0 = h, where row i of H is the derivative along v of
 * condition[i], a function that vanishes on W and whose differential along the fibre belongs to it
 * (d'Alembert-Chetaev). The system's own conditions are h, and dh/dt where h depends on q (and
 * time) alone. M is as the user means it: q'' stands on the left alone, so what
 * a mass matrix that depends on q adds to Newton's law belongs to F. */
struct form_mechanical {
    int *coordinate, *velocity; int coordinates;       /* symbols */
    struct form_entry *mass; size_t masses;            /* entries of M, any order; equal places add up */
    expr_id *force;                                    /* one for each coordinate */
    expr_id *constraint; int constraints;
    int *multiplier;                                   /* one for each constraint */
};

/* The condition that h puts on the fibre: h, or dh/dt where no velocity occurs in it. */
expr_id form_fibre_condition(const struct sys_system *s, const struct form_mechanical *in, expr_id h);
/* Variables are q, v (role "velocity"), lambda (role "multiplier"). Rows are "definition of",
 * "equation of" and "constraints[i]". Cost: one gradient for each constraint. */
void form_mechanical(struct sys_system *s, const struct form_mechanical *in);
/* The rows alone, for a system that has the variables: condition[i] belongs to the variable
 * column[i]. */
void form_mechanical_rows(struct sys_system *s, const struct form_mechanical *in, const expr_id *condition,
                          const int *column, int conditions);
/* What is possible, whatever the forces: q' = v, 0 = h, with v' left open. s has store, time and
 * parameters. */
void form_kinematics(struct sys_system *s, const struct form_mechanical *in);

#endif
