/* Dirac's theory on the final set of a Hamiltonian system with primary constraints.
 *
 * Source: Dirac (1964), lectures 1 and 2; Henneaux & Teitelboim (1992), chapters 1 and 3; L. Castellani, Symmetries in constrained Hamiltonian systems,
 * Annals of Physics 143 (1982) 357. The constraints are those of the reduction (Gotay, Nester & Hinds find the same set as Dirac), which are regular
 * and independent there; brackets, multipliers and classes are worked out anew from them, so that a bracket which does not vanish where it
 * should is seen. */
#ifndef SGA_DIRAC_CLASSES_H
#define SGA_DIRAC_CLASSES_H

#include "arena.h"
#include "weak.h"

/* The phase space: symbols q1..qn, p1..pn; {f, g} = sum of df/dq dg/dp - df/dp dg/dq. */
struct dirac_space {
    const struct weak *weak;
    struct sga_arena *mem;
    const int *symbol; int n;     /* 2n symbols */
    int time;
};

struct dirac_system {
    const struct dirac_space *space;
    expr_id hamiltonian;
    const expr_id *chi; int constraints;      /* the primary ones first */
    int primaries;
};

struct dirac_classes {
    expr_id *pair;                /* constraints x constraints: {chi_j, chi_k}, zeros of the set made 0 */
    int firsts, primary_firsts;
    expr_id *kernel;              /* firsts x constraints: combinations that are first class; those of primary ones alone come first */
    int *lead;                    /* by first-class combination: the constraint that it has the factor 1 of, and no other one has */
    expr_id *first;               /* the combinations */
    int *second; int seconds;     /* which constraints stand for the second class */
    expr_id *bracket;             /* 2n x 2n: Dirac's, of the coordinates */
    unsigned char *fixed;         /* by primary constraint: its multiplier is determined ... */
    expr_id *multiplier;          /* ... as this and the sum of ... */
    expr_id *factor;              /* ... primaries x primaries: factors times the free ones */
    expr_id first_class_hamiltonian;   /* H and the fixed multipliers times their constraints, the free ones 0 */
};

/* {f, g}, in normal form. */
expr_id dirac_poisson(const struct dirac_space *s, expr_id f, expr_id g);
/* df/dt of what depends on time by itself. */
expr_id dirac_by_time(const struct dirac_space *s, expr_id f);

/* Fills all. False: undecided, or (witness_failed) a constraint is not preserved for any multipliers: the set is not final. */
bool dirac_classes_find(struct dirac_classes *c, const struct dirac_system *d);

/* The generator: G = sum over parameters and orders of epsilon^(order) * term. */
struct dirac_generator {
    int parameters, orders;       /* orders: one more than the highest derivative */
    expr_id *term;                /* parameters x orders */
    unsigned char *idle; int idles;   /* by first-class combination: it generates nothing (Dirac's conjecture does not hold) */
    const char *why_not;          /* there is none; static text; then no terms */
};
/* c->first: those that are not primary may become other combinations, of which there is a generator (basis.h). */
bool dirac_generator_find(struct dirac_generator *g, const struct dirac_system *d, struct dirac_classes *c);

#endif
