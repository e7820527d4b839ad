/* Linear time-varying systems P y = B e, P = A_0 + A_1 D + ... + A_m D^m over k = Q(t).
 *
 * Source: M. Fliess, J. Levine & P. Rouchon, Index of an implicit time-varying linear
 * differential equation: a noncommutative linear algebraic approach, Linear Algebra Appl. 186
 * (1993) 59, sections 2 to 6: solvable is full rank over k[D] (2.6, definition 1); index = max(0, 1 - nu0) with nu0 the leading order of the
 * transfer matrix's Laurent series in s^{-1} (definition 2), = max(0, 1 + deg J) for the
 * Kalman state form (definition 3, proposition 1). Every result is multiplied out before it is
 * given; the two indices must agree. Exact throughout. */
#ifndef SGA_OPERATOR_OPERATOR_H
#define SGA_OPERATOR_OPERATOR_H

#include "ore_matrix.h"
#include "ratio_matrix.h"

struct op_limits;
struct op_popov;
struct sga_error;

struct op_system {
    int unknowns, sources, order;      /* P has order + 1 coefficient matrices */
    struct ratio_matrix *A;            /* unknowns x unknowns */
    struct ratio_matrix B;             /* unknowns x sources */
};
void op_system_clear(struct op_system *s);
/* P as a matrix over k[D]; m not initialised. */
void op_system_matrix(const struct op_system *s, struct ore_matrix *m);

/* W = U B, the right side after a reduction; W initialised, takes its size. */
void op_right_side(struct ore_matrix *W, const struct op_system *s, const struct op_popov *p);

/* x' = F x + G e,  y = H x + sum J_v e^(v); no derivative of e moves x. The components of x are
 * y_j^(l) of the homogeneous system (label), less terms in e. */
struct op_state {
    int n;                             /* dim_k [y]/[e] */
    struct ratio_matrix F, G, H, *J;
    int degree;                        /* of J: -1 where it is 0; J has degree + 1 matrices */
    int *unknown, *derivative;         /* by component of x */
};
/* From the full Popov form of P. Checked by substitution (SGA_E_WITNESS if it fails). */
bool op_state_form(struct op_state *x, const struct op_system *s, const struct op_popov *p,
                   const struct op_limits *limits, struct sga_error *err);
/* The leading order of H (s - F)^{-1} G + sum J_v s^v, and its coefficient (initialised here):
 * the first of J_deg, .., J_0, H_0 G, H_1 G, .. that is not 0, H_0 = H, H_k+1 = H_k' + H_k F.
 * False: all are 0, and nothing is initialised. */
bool op_state_leading(const struct op_state *x, int *order, struct ratio_matrix *leading);
void op_state_clear(struct op_state *x);

/* P^{-1} B = sum over v >= first of coefficient[v - first] s^{-v}. Checked by P times it. */
struct op_laurent {
    int first;                         /* nu0: coefficient[0] is not 0 */
    int terms;                         /* 0: B = 0 */
    struct ratio_matrix *coefficient;
};
/* bound: an order by which a nonzero coefficient must come; at least `terms` of them from the
 * first on. Worked out from P alone, beside the state form. */
bool op_laurent_series(struct op_laurent *g, const struct op_system *s, const struct op_popov *weak, int bound,
                       int terms, const struct op_limits *limits, struct sga_error *err);
void op_laurent_clear(struct op_laurent *g);

/* U P V = diag(1, .., 1, e, 0, .., 0), U and V unimodular, with their inverses. k[D] is simple, so
 * all invariant factors but the last are 1 (Cohn, Free rings and their relations, ch. 8). e
 * is monic, of order dim of the torsion, and unique up to similarity only. It is the
 * annihilator of a cyclic vector w = W y of the torsion module.
 *
 * Coefficients grow with the square of e's order. Where e alone is known to be too large
 * err says so; where e can be had but the transformations would take many times its size,
 * they are left empty (e has then been applied to w, which gives 0). */
struct op_jacobson {
    struct ore_matrix U, V, U_inverse, V_inverse;
    bool transformations;              /* the four are there, and were multiplied out */
    struct ore e;
    int rank;
};
enum { OP_MOST_FACTOR_BYTES = 30000 };   /* of e, for the transformations */
/* full: the full Popov form, and x the state form, of a system of full rank; otherwise NULL. */
bool op_jacobson_form(struct op_jacobson *f, const struct op_system *s, const struct op_popov *full, const struct op_state *x,
                      const struct op_limits *limits, struct sga_error *err);
void op_jacobson_clear(struct op_jacobson *f);

/* Real times where the leading Laurent matrix has a pole, or vanishes (remark 4.3); or where a coefficient has a pole. */
enum op_lost { OP_POLE, OP_ZERO, OP_COEFFICIENT };
struct op_singular {
    enum op_lost lost;
    int order;                         /* of the pole or zero */
    fmpz_poly_t polynomial;            /* irreducible over Q; t is its root in [low, high] */
    fmpq_t low, high;                  /* equal where t is rational */
    double t;                          /* nearest double, to an ulp */
};
struct op_singular_times { struct op_singular *at; int count; };
void op_singular_find(struct op_singular_times *s, const struct ratio_matrix *leading);
/* Real times where a coefficient of the system has a pole that the state form has too: motions end
 * there. Poles that the state form has alone belong to its basis, and poles that it has not can be scaled away. */
void op_singular_coefficients(struct op_singular_times *s, const struct op_system *system, const struct op_state *x);
void op_singular_clear(struct op_singular_times *s);

#endif
