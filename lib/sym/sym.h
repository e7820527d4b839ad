/* Symmetries of a reduced system.
 *
 * Source: Munoz-Lecanda & Roman-Roy, Implicit quasilinear differential systems (EJDE
 * 1999/10), section 4. K is the span of the gauge fields on the final submanifold Pf,
 * solutions are X0 + K. A field D = D^i d/dx_i + theta d/dt is an infinitesimal symmetry if
 *     D is tangent to Pf, and  [D, Y] + Y(theta) X0 lies in K  for Y = X0 (with d/dt) and
 *     for every gauge field Y, on Pf,
 * that is, its flow maps graphs of solutions to graphs of solutions. With theta = 0 this is
 * [D, X0] in K and [D, K] in K. A map phi (with t -> tau) is a symmetry if it is a local
 * diffeomorphism that takes Pf into Pf, and D(phi) Y - Y(tau) X0(phi) lies in K(phi) for the
 * same Y. That T and alpha are preserved is sufficient only (theorem 3), and told apart.
 *
 * Works on a finished reduction and its oracle; the points of the oracle decide. */
#ifndef SGA_SYM_SYM_H
#define SGA_SYM_SYM_H

#include "expr.h"

struct points_oracle;
struct sga_budget;
struct sga_solution;
struct sys_system;

enum sym_truth { SYM_FALSE, SYM_TRUE, SYM_UNKNOWN };

/* The first place where a condition fails, or could not be decided. */
struct sym_defect {
    const char *condition;     /* "tangent", "solutions", "gauge_fields", "diffeomorphism", "T", "alpha"; static */
    expr_id expr;              /* should vanish on Pf; EXPR_UNDEF: could not be formed */
    bool nonzero;              /* proved or shown; otherwise undecided */
};

enum { SYM_DEFECTS = 6 };

struct sym_check {
    enum sym_truth symmetry, tangent, preserves_T, preserves_alpha, gauge;
    struct sym_defect defect[SYM_DEFECTS];   /* at most one for each condition */
    int defects;
};

struct sym_field {
    expr_id *component;        /* by variable, then time */
    bool gauge;                /* lies in K on Pf */
    enum sym_truth along_motion;   /* lies in the span of X0 (with d/dt) and K on Pf */
};

/* [field i, field j] = sum of factor[k] * field k on Pf. */
struct sym_commutator {
    int left, right;
    bool closed;               /* false: not a combination of the fields found */
    expr_id *factor;           /* by field, where closed */
};

/* A first integral F and a symmetry D with dF = i_D T on Pf, T a closed 2-form. */
struct sym_noether {
    expr_id *component;        /* of D: by variable, then time (0) */
    expr_id integral;
};

struct sym_search {
    int degree;                /* of the polynomial components */
    int integral_degree;
    bool time;                 /* components may depend on time, and time has one */
    const expr_id *function; int functions;   /* not owned; beside the polynomials */
};

/* What a search rests on. */
struct sym_evidence {
    int unknowns, points, primes;
    int reals;                 /* real points instead, where none modulo a prime were found */
    bool irrational;           /* and the equations there are not rational ones */
    int dropped;               /* candidates that the check did not confirm */
    bool kernels;              /* functions that are not algebraic took part */
    bool complete;             /* no other field of the ansatz is a symmetry */
    const char *why_not;       /* static; NULL where complete */
};

struct sym_request {
    bool tensor;               /* row i of A belongs to variable i: T is a tensor */
    bool has_search;
    struct sym_search search;
    const expr_id *form;       /* n x n: the closed 2-form for Noether's theorem; NULL: A, where it is one */
    const expr_id *vector; int vectors; /* by vectors, n each: those that it is pulled back along; NULL: all */
};

struct sym_result {
    enum sym_truth antisymmetric, closed, alpha_closed;   /* of T and alpha, on all of M */
    enum sym_truth gauge_closed;             /* [K, K] in K on Pf */
    struct sym_field *field; int fields;     /* a basis modulo fields that vanish on Pf; gauge fields first */
    struct sym_commutator *commutator; int commutators;   /* pairs left < right, in order */
    expr_id *integral; int integrals;        /* modulo functions that are constant on Pf */
    struct sym_noether *noether; int noethers;
    struct sym_evidence of_fields, of_integrals;
};

/* The verdict must not be inconsistent. False where the budget ends, the store is full, or the
 * search has too many unknowns (LIMIT_VARIABLES). The oracle must not be used after
 * sym_free. The work of a search is cubic in its unknowns. */
struct sym_work;
struct sym_work *sym_new(const struct sys_system *sys, const struct sga_solution *sol, struct points_oracle *oracle,
                         const struct sga_budget *budget, bool tensor);
void sym_free(struct sym_work *w);
/* component: by variable, then time. For a field 0 where nothing is said; for a map the
 * symbol itself. */
void sym_check_field(struct sym_work *w, const expr_id *component, struct sym_check *out);
void sym_check_map(struct sym_work *w, const expr_id *component, struct sym_check *out);
/* Presymplectic test, closure of K, and the search where one is asked. */
bool sym_find(struct sym_work *w, const struct sym_request *request, struct sym_result *out, struct sga_error *err);
void sym_clear(struct sym_result *r);

#endif
