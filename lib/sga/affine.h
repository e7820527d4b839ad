/* Inside the sga folder: systems A x' = B x + c(t) with rational A and B, restrictions likewise affine.
 *
 * Such a system is a list of integer rows. Its reduction needs no points: every P_k is an affine
 * subspace, every rank one of rational numbers (exact/exact_rank.h), and only functions of time and
 * parameters alone are asked of the oracle whether they are zero. Right sides are rows over the
 * variables and over atoms: 1, and functions that are no sums (sin(t), a table's value, a symbol). */
#ifndef SGA_SGA_AFFINE_H
#define SGA_SGA_AFFINE_H

#include <flint/fmpq.h>

#include "exact_basis.h"
#include "exact_rank.h"
#include "state.h"

/* The time derivative of an atom: over den, columns are atoms. */
struct affine_rate {
    struct exact_row row;
    fmpz den;
    bool known;
};

struct affine_atom {
    expr_id expr;
    expr_id base; int order;       /* it is the order-th derivative of base, where order > 0 */
    struct affine_rate rate;
};

/* scale * (A_i x' - alpha_i) = a x' - b. Column j < n of b is x_j, column n + k the k-th atom. */
struct affine_row {
    struct exact_row a, b;
    fmpq scale;
};

struct affine {
    const struct sys_system *sys;
    struct expr_store *st;
    int n;
    const int *column;             /* by symbol: variable or -1; borrowed */
    struct affine_row *row;        /* of the system */
    struct exact_row *restriction; /* over the variables and atoms, primitive */
    struct affine_atom *atom; int atoms; size_t atom_cap;   /* the first is 1 */
    int *atom_of; size_t atom_of_cap;                       /* by node: index + 1 */
    struct expr_cone cone;
    struct expr_facts *facts;      /* borrowed */
    struct expr_flow *flow;        /* borrowed: no velocity is ever determined in it */
};

/* Whether s->sys is such a system, in rows. False costs little where some coefficient is no number. */
bool affine_read(struct affine *a, struct state *s);
void affine_clear(struct affine *a);

/* out/den = e. False: e is not found to be affine with rational coefficients. */
bool affine_function(struct affine *a, expr_id e, struct exact_row *out, fmpz_t den);
/* The derivative in time of the atoms in r, over den; out has atoms only. */
void affine_rate(struct affine *a, const struct exact_row *r, struct exact_row *out, fmpz_t den);
/* The row as an expression: variables in their order, then functions of time, then the number. */
expr_id affine_expression(struct affine *a, const struct exact_row *r);
/* The same for the part from column `from` on, every coefficient over den. */
expr_id affine_expression_from(struct affine *a, const struct exact_row *r, int from, const fmpz_t den);

/* One constraint: the function, its tangency a x' = b times scale (1 / scale is the printed one's). */
struct affine_constraint {
    struct exact_row function;     /* primitive */
    struct affine_row tangency;
};

struct affine_run {
    struct state *s;
    struct affine *a;
    struct exact_echelon velocities;   /* of the rows of A, then of the tangencies: given row = source */
    struct exact_basis basis;          /* of the constraints, while they are few ... */
    struct exact_echelon set;          /* ... and of their linear parts, once they are many: given row = constraint */
    bool many;
    struct affine_constraint **constraint; int constraints; size_t constraint_cap;
    bool bad_prime;
    bool sampled;                      /* the oracle has points */
};

/* A function that is to vanish: sum of weight * (A x' - alpha, or a tangency) = function. */
struct affine_candidate {
    struct exact_row function;
    int *source; fmpq *weight; int parts;
    int from;                      /* the row that ended without velocities, or -1 */
    int restriction;               /* or -1 */
};

void affine_candidate_clear(struct affine_candidate *c);
/* Makes constraints of generation g from candidates: independent of each other and of the earlier ones, which they are
 * written without where that is shorter. What comes to a function of time is decided: it vanishes, or contradicts (s->inconsistent).
 * Candidates are moved from. Returns how many were added, or -1 with err or a bad prime. */
int affine_admit(struct affine_run *r, struct affine_candidate *c, int count, int g);
/* Of a row of the system, or of rows + a constraint: its row of integers. */
const struct affine_row *affine_source(const struct affine_run *r, int source);

/* Of the rows that vanished: those that are combinations of others, as they stand, get that combination. False: stopped. */
bool affine_explain(struct affine_run *r);

/* The reduction: fills what `run` in solve.c fills for other systems, and pivots. */
bool affine_reduce(struct state *s, struct affine *a);

/* The vector field and the gauge fields. */
bool affine_fields(struct affine_run *r);
/* Points for the oracle on the constraints so far, where the system has values. */
bool affine_sample(struct state *s, int constraints);
/* The same on all of them; where none are found in the usual way (numbers of all sizes), they are solved for one by one. */
bool affine_final_points(struct affine_run *r);

#endif
