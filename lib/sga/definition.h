/* Variables that an equation defines: an equation without derivatives c v = f(others), c a number, or such a difference times
 * a factor that is nowhere 0, where v' occurs in no
 * equation and f has a switch or a root (abs, sign, min, max, sqrt, cbrt, real powers, asin, acos, acosh). As equations they would
 * make the answer depend on the side on which points happen to lie, and their differentials are nothing where f has none;
 * with f put in for v before the reduction, and v put back after it, a signal that has a name is one that has none. Where v is
 * in no other equation under such a function either, nothing is left of the switch.
 *
 * P_k of the whole is the graph of v = f over P_k of what is left, from the first generation on: the same dimensions, and a generation
 * where there would be none. v' = f'(X). */
#ifndef SGA_SGA_DEFINITION_H
#define SGA_SGA_DEFINITION_H

#include "arena.h"
#include "reduction.h"
struct points_oracle;
struct reduction_options;
struct sga_budget;
struct sga_solution;
struct sys_system;

struct definition {
    int variable;
    int row;                       /* of the system */
    expr_id value;                 /* f, free of all variables that are defined */
    expr_id slope;                 /* c as the row has it */
    expr_id factor, rest;          /* the row is factor * rest, and the factor has a value and is not 0 anywhere; UNDEF: it is the rest */
};

struct definitions {
    struct sga_arena mem;          /* of its vectors */
    struct definition *at; int count; size_t cap;
    int *variable, *row;           /* of the whole by those of what is left */
};

enum definitions_asked {
    DEFINITIONS_KINKED,            /* those whose f has a switch or a root */
    DEFINITIONS_ALL                /* every variable that an equation gives: what a name hides (that a function is irregular, a square, 0) is
                                    * seen with these put in */
};
/* Those of the system. Costs a walk through its equations, and where there are some, another one for each. */
void definitions_find(struct definitions *d, const struct sys_system *system, enum definitions_asked asked, const struct sga_budget *budget);
void definitions_clear(struct definitions *d);
/* e[0 .. count) through the names: with their values put in for the variables, equal to e wherever the definitions hold. Linear in the
 * size of the expressions as the store shares them. */
void definitions_through(const struct definitions *d, const struct sys_system *system, expr_id *e, int count);
/* The system without them; the caller clears it. */
void definitions_put_in(const struct definitions *d, const struct sys_system *system, struct sys_system *left);
/* The solution of what is left becomes that of the system, and the oracle gets points of its final set. False: none were found, or
 * the store is full. */
bool definitions_lift(const struct definitions *d, const struct sys_system *system, const struct reduction_options *options,
                      struct points_oracle *oracle, struct sga_solution *solution);

#endif
