/* The linearization of the reduced motion about a point of the final set.
 *
 * Near the point the final set Pf is a graph over free coordinates: states z and the inputs u that are variables; the others, y, follow
 * from them and from the inputs w that are tables: xi(z, y, u, w, t) = 0. With X the reduced field,
 *     dz' = A dz + B du,   [A B] = dX_z/dx Phi,   d(out) = C dz + D du,   [C D] = d(out)/dx Phi,
 * where Phi = d(z, y, u, w)/d(z, u, w) spans the tangent space, from d xi Phi = 0, and du stands for the inputs of both kinds in the order
 * given. Deviations are at equal times. Free functions of the motion (the gauge) are the derivatives of inputs: they must be as many, and X is
 * the field that holds the inputs. Where states move with these derivatives all the same, z' = X_z + b u', the state is z - b u (with b at the
 * point: so about equilibria, and for constant coefficients, only). About an equilibrium A has the finite eigenvalues of the pencil of the given equations,
 *     E x' + F u' = A x + B u,   E = A(x, t),   A = d(alpha - A v)/dx,   v = X,
 * linearized too; elsewhere A is that of the deviation from the motion in these coordinates, and depends on their choice.
 * (Compare Campbell, Linearization of DAEs along trajectories, ZAMP 46 (1995) 70.) */
#ifndef SGA_LINEAR_LINEARIZE_H
#define SGA_LINEAR_LINEARIZE_H

#include "linear_place.h"
#include "spectrum_of.h"

struct points_oracle;
struct sga_budget;
struct sga_error;
struct sga_solution;
struct sys_system;

struct linear_input {
    const char *name;
    int variable, signal;      /* index of a variable, or symbol of a table; -1: the other one */
};

struct linear_request {
    const struct sys_system *sys;
    const struct sga_solution *sol;
    struct points_oracle *oracle;
    const struct linear_input *input; int inputs;
    const char *said_in;       /* the member of the request that names inputs, for refusals: "linearization.inputs" */
    const expr_id *output; int outputs;
    const struct sga_budget *budget;
};

/* d/d(coordinates): rows of functions by columns of variables, and then of signals. */
struct linearization {
    struct sga_arena mem;
    struct linear_place place;
    bool motion_constant;      /* A and B are the same at all points and times: the reduced motion is linear with constant coefficients */
    bool constant;             /* ... C and D too ... */
    bool everywhere;           /* ... and those of the given equations */
    int equilibrium;           /* with the inputs held: 1 proved, 0 it is none, -1 not known, or the system depends on time */
    int *state; int states;    /* variables: coordinates of Pf, beside the inputs */
    int *variable; int variables;   /* columns of E and DA: all but the inputs */
    int rows;                  /* of the given equations, restrictions last */
    struct linear_matrix A, B, C, D;
    bool shifted;
    struct linear_matrix shift;   /* b, states x inputs */
    struct linear_matrix E, F, DA, DB, DC, DD;   /* of the given equations; F is 0 as a rule */
    bool rates;                /* F is not 0 */
    expr_id *rate;             /* by state: X with the inputs held, of the store */
};

enum { LINEAR_MOST = 300 };    /* variables: matrices are dense, and their entries balls of 192 bits */

/* About the point of Pf at guess (zero: functions that vanish at an equilibrium alone: the point proved is one then, and is not moved to one). False with err: INPUTS (freedom that no input names, an input that
 * cannot be chosen), IMPROPER (a state moves with an input's derivative), UNDECIDED, a limit. linearization_clear is due in every case. Cost: gradients of the
 * constraints, the field and the rows; the cube of the variables. */
bool linearize(struct linearization *l, const struct linear_request *rq, const struct linear_guess *guess, struct sga_error *err);
/* The given equations alone, where all of their entries are rational numbers: E, F, DA, DB, DC, DD and their names, no point, nothing of the reduction.
 * *constant tells; nothing is refused but by limits. */
bool linear_given(struct linearization *l, const struct linear_request *rq, bool *constant, struct sga_error *err);
/* The states and their rates with the inputs held, as functions, nothing of the matrices but whether they are constant. *of_time: the
 * constraints or rates depend on time, or on tables. Errors and ownership as for linearize. */
bool linear_rates(struct linearization *l, const struct linear_request *rq, const struct linear_guess *guess, bool *of_time, struct sga_error *err);
void linearization_clear(struct linearization *l);

#endif
