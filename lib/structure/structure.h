/* What the reduction says about the system's structure: which initial values are free,
 * what each equation is good for, which equations are consequences of which, and the
 * blocks in which the motion can be solved.
 *
 * Works on a finished reduction (sga_options.rows was set) and its oracle. Ranks and
 * zeros are decided by values at certified points; only `predicted` rests on the pattern
 * of the request's equations alone. */
#ifndef SGA_STRUCTURE_STRUCTURE_H
#define SGA_STRUCTURE_STRUCTURE_H

#include "arena.h"
#include "reduction.h"
struct points_oracle;
struct sga_budget;
struct sga_part;
struct sga_solution;
struct sys_system;

enum structure_role {
    STRUCTURE_DERIVATIVE,     /* gives the derivative of `variable` */
    STRUCTURE_CONSTRAINT,     /* becomes the constraint `constraint` */
    STRUCTURE_CONSEQUENCE,    /* may be left out, together with all others of this role */
    STRUCTURE_USED            /* took part in a constraint only */
};

/* An equation A x' - alpha = 0 (source < rows), or the derivative of a constraint along
 * the motion (rows + its index). */
struct structure_equation {
    int source;
    enum structure_role role;
    int variable, constraint;      /* -1: none */
    int vanished;                  /* for a consequence: which of the solution's vanished rows; or -1 */
    /* For a consequence among equations: sum of factor * (equation) = 0 identically, this
     * one with the factor 1. NULL: no such combination was found. */
    struct sga_part *part; int parts;
    bool everywhere;               /* the combination holds on all of the space, not only on ... */
    int holds_on;                  /* ... P_k of this k (0: everywhere) */
    int derivative_of;             /* a constraint whose derivative implies this equation too; -1 */
};

struct structure_group {           /* variables first[k] .. first[k + 1] - 1 of `member` */
    int groups;
    int *first, *member;
};

/* An equation of the request, or a function of its restriction, and how often it is differentiated. */
struct structure_origin {
    int equation, restriction;     /* one of them is -1 */
    int differentiated;
};

struct structure {
    struct sga_arena mem;          /* all of what follows */
    bool has_initial;
    int *free_initial; int frees;  /* variables: local coordinates of Pf near its certified points */
    int *solved_for;               /* by constraint: the variable that follows from it (with the others) */
    struct structure_equation *equation; int equations;   /* the rows, then the constraints' derivatives */
    /* The independent equations and derivatives of constraints that give the velocities,
     * as blocks in solution order: by variable its block (-1: a free function) and the
     * equation (index as above) that it is matched with. */
    int blocks, *block, *matched;
    /* By block b: what it rests on, origin[origin_first[b]] ..; constraints are traced back along
     * their combinations. Equations whose velocities were inserted on the way are not counted
     * again. origin NULL: too large; origin_unknown[b]: a combination is not known. */
    struct structure_origin *origin; int *origin_first; unsigned char *origin_unknown;
    /* By constraint i: the free variables that solved_for[i] follows from, follow[follow_first[i]] ..;
     * NULL: too large. */
    int *follow, *follow_first;
    /* Variables by what their motion needs, itself and earlier groups only. */
    struct structure_group motion;
    int *motion_group;             /* by variable */
    int *need_first, *need;        /* by group: earlier groups that it needs directly */
    /* From the pattern of the request's equations alone (variable j is in equation i). */
    int structural_rank;
    enum graph_part *row_part, *col_part;
};

/* False only where the budget ends or the store is full; what cannot be decided is left
 * unknown in its member. The oracle must not be used after structure_clear. Near linear in the nonzeros of the equations as a rule. */
bool structure_find(const struct sys_system *sys, const struct sga_solution *sol, struct points_oracle *oracle,
                    const struct sga_budget *budget, struct structure *out, struct sga_error *err);
/* Blocks, matched equations and solved variables are of the system, and each constraint has a variable of its own. Linear. */
bool structure_sane(const struct sys_system *sys, const struct sga_solution *sol, const struct structure *s);
void structure_clear(struct structure *s);

/* The differentiation index of a system whose solution is unique, with any number of equations and with restrictions: the least k
 * for which F = 0, ..., F^(k) = 0 determine x' as a function of (x, t) at general points of Pf, F the rows and restrictions, constraints
 * being taken as sets (z^2 = 0 is z = 0). -1: not known. Cost: an elimination of the rows and of the constraints' differentials. */
int structure_index(const struct sys_system *sys, const struct sga_solution *sol, struct points_oracle *oracle,
                    const struct sga_budget *budget);

#endif
