/* Inside the run folder: while the list of the strata is made. */
#ifndef SGA_RUN_STRATA_LISTING_H
#define SGA_RUN_STRATA_LISTING_H

#include "points_space.h"

struct cases;
struct cases_part;
struct definitions;
struct domain;
struct expr_facts;
struct job;
struct poly_alike;
struct strata_constraints;
struct stratum;

struct listing {
    struct job *j;
    struct expr_facts *facts;
    struct expr_cone cone;
    struct domain *domain;    /* where the equations have values */
    int off, moved;           /* how many factors were looked at off the final set, and for special parameters */
    struct cases *cases;      /* of the parameters, so far */
    struct definitions *names; bool names_known;
    struct poly_alike *alike; /* factors of pivots */
    int before, rank;         /* generic rank with the first `before` constraints; -1: not known */
};

/* What is looked for beside the values of the variables. */
enum strata_moving { STRATA_FIXED, STRATA_PARAMETERS, STRATA_TIME };

/* Adds the zero set of factor, on the branches chosen among the first `before` constraints;
 * EXPR_UNDEF: what as->description says. Takes over what `as` holds. */
void strata_add(struct job *j, expr_id factor, int before, struct stratum as);

/* What is looked for: a point of the set of the first c constraints where factor vanishes, too
 * (EXPR_UNDEF: of the set alone), from so many random starts (0: as many as usual). */
struct strata_look {
    int c;
    expr_id factor;
    const expr_id *squared; int squares;   /* the factor is a sum of their squares: they vanish together; or NULL */
    enum strata_moving moving;
    int starts;
    uint64_t seed;            /* of the random starts */
    bool far;                 /* anywhere, also where the request says where it starts */
    const struct points_point *from;   /* begin there; or NULL */
    bool point_only;          /* the rank is not asked for: it takes a dense decomposition */
    bool *solvable;           /* gets whether some velocity solves the equations and is tangent to those constraints there; or NULL */
};

/* The point, and the rank there; *rank is -1 where an irregular place was approached, or it was not asked for. With
 * STRATA_TIME the point's x has the time after the variables. The caller clears p in every case. */
enum points_status strata_look_at(struct job *j, struct strata_look look, struct points_point *p, int *rank);

/* Whether e is, up to its sign, a constraint of the first generation, as the squared length of a rod less what that is. Cost: the constraints that
 * have its rarest variable, until all that were compared have cost a walk of the store: for some functions only a point modulo a prime tells, and one serves all. */
bool strata_is_constraint(struct job *j, expr_id e);
void strata_constraints_free(struct strata_constraints *k);       /* NULL: nothing */

/* The rank at general points of the set of the first `before` constraints; asked once for a set. */
int strata_general_rank(struct listing *l, int before);

/* Whether a real point of Pf with factor = 0 can be found at which the rank is lower than
 * on Pf in general: otherwise the pivot only happened to vanish there. as gets the point. */
bool strata_drops(struct job *j, expr_id factor, int starts, struct stratum *as);

/* Lists each factor of value, a pivot chosen on the set of the first `before` constraints, that can vanish. */
void strata_factors(struct listing *l, expr_id value, int before);

struct poly_factor;
struct poly_factors;
struct poly_limits;
/* The factors of a pivot: through the names of its parts where these hide some. False: they are not known. */
bool strata_through(struct listing *l, expr_id value, const struct poly_limits *limits, struct poly_factors *f);

/* A factor that is a sum of squares: the set where all of them vanish is listed where the rank drops there. False: it is none, and
 * may vanish as any other function does. */
bool strata_squares(struct listing *l, const struct poly_factor *factor, int before);

/* The cases in which functions of the parameters all vanish join the list; parts of others do not. */
void strata_condition(struct listing *l, const expr_id *function, int functions);
/* One part more, taken over, unless it lies in one that is listed. */
void strata_join(struct listing *l, struct cases_part *part);
/* Where strata are solved: parts where the general answer holds leave the list; what is special inside them joins it. Cost: a
 * reduction for each. */
void strata_alike(struct listing *l);
/* One of them, taken over, as a stratum. False: its functions are too long to be written, for which there is a warning. */
bool strata_add_case(struct job *j, struct cases_part *part);
/* e must not vanish. */
void strata_assume(struct job *j, expr_id e);
/* The list becomes strata and assumptions. */
void strata_cases(struct listing *l);

/* Parts of the constraint set on which the answer does not hold, each by a point that satisfies all given equations. To be called before the oracle is asked
 * about anything but the reduction. */
void strata_components(struct listing *l);

/* Parts of the set of a generation that went by because of the pivot that its constraints were divided by. */
void strata_lost(struct listing *l);

/* Zeros of the determinants of dense blocks, and zeros of denominators of the equations. */
void strata_determinants(struct listing *l);
void strata_domain(struct listing *l);

#endif
