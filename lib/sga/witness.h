/* The independent witness: an answer is checked at fresh random points of Pf before it is
 * given. It shares no decision with the algorithm: it finds its own points from the final
 * constraints, and evaluates the identities that define the answer there, in balls. */
#ifndef SGA_SGA_WITNESS_H
#define SGA_SGA_WITNESS_H

#include "expr.h"

struct points_oracle;
struct sga_budget;
struct sga_solution;
struct sys_system;

/* What is checked. The expressions may live in another store than the system (for
 * example parsed back from the printed answer), with equal symbol names. */
struct sga_claim {
    const struct expr_store *st;
    const int *variable; int variables;        /* symbols of st, in the system's order */
    const int *parameter; int parameters;
    int time;
    const expr_id *constraint; int constraints;
    const struct sga_solution *solution;       /* for the constraints' generations */
    const expr_id *field;                      /* by variable; NULL: not claimed */
    const expr_id *gauge; int gauges;          /* gauges x variables; NULL: not claimed */
};

struct sga_witness {
    int points;             /* fresh points at which everything held */
    int far;                /* of them, from starts far from all points that the reduction used */
    bool certified;         /* all of them proved to lie on Pf, with independent differentials of the constraints */
    int digits;             /* residuals vanish to at least so many digits, relative to their terms */
    double seconds;
};

/* A X = alpha, tangency of X, gauge fields in ker A and tangent, at `points` fresh points.
 * False with err (WITNESS: contradicted, or UNDECIDED: no fresh point or no value).
 * near as in struct reduction_options. Points come from starts of the witness's own: near the guess (without one, near the
 * oracle's points) and, every other, far from all points that were used. Such a point may lie on another component, where something that the reduction
 * took for 0 (oracle->zero; NULL: not known) is not: the answer does not speak of it, and it is passed over. */
bool sga_witness_check(const struct sys_system *system, const struct sga_claim *claim,
                       const struct points_oracle *oracle, const double *near, double near_time, uint64_t seed, int points,
                       const struct sga_budget *budget, struct sga_witness *result, struct sga_error *err);

#endif
