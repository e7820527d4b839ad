/* Inside the sga folder: one run of the algorithm. */
#ifndef SGA_SGA_STATE_H
#define SGA_SGA_STATE_H

#include "arena.h"
#include "echelon.h"
#include "error.h"
#include "points_space.h"
#include "reduction.h"

struct domain;
struct expr_facts;
struct poly_alike;
struct expr_flow;

/* A function that may become a constraint: where it came from, and how. */
struct candidate {
    expr_id expr;
    expr_id base; int order;      /* see struct sga_constraint */
    expr_id arose;                /* what it is a part of, where that was split up; or EXPR_UNDEF */
    expr_id times;                /* what its combination is multiplied by (primitive.h); EXPR_UNDEF: 1 */
    enum sga_origin origin;
    int source;                   /* of the row it is the right side of; -1 for a restriction */
    int restriction;              /* which one; -1: none */
    struct ech_op *op; int ops;   /* borrowed from that row */
};

/* Which branch of each product is followed first. A product is a union of sets: where one
 * of them turns out empty in the end another may not be, so other routes are run. */
struct decision {
    expr_id product;
    int options, chosen;
    int alike;                    /* so many of the options, the first of them, are as far from the guess as the first: it lies where branches meet */
    signed char side;             /* not 0: `product` changes its sign at a surface, and the answer rests on a side of it: this one,
                                   * or the other */
};

struct route {
    struct decision *at; int count; size_t cap;
    double far;                   /* of the set that it led to from the guess (guess_distance_of_set); negative: not known */
    bool off;                     /* no branch keeps the values that were given (guess_is_off) */
};

/* The variable that a function can be solved for with a constant factor; -1: none. */
struct solved_for {
    expr_id expr, slope;
    int symbol;
    bool affine;                  /* in all variables */
};

/* A constraint as it is on the set of those before it, solved for a variable where it can be: kept, as each question uses up the same ones. */
struct used_up {
    expr_id constraint;           /* as it stands */
    int symbol;                   /* solved for; -1: none */
    expr_id value;
};

struct state {
    struct sga_arena mem;                 /* of all vectors below that are not borrowed */
    const struct sys_system *sys;
    const struct reduction_options *options;
    struct expr_store *st;
    struct points_oracle *oracle;
    struct points_space space;
    int *variable;                        /* symbols, for the space */
    signed char *cheap;                   /* by variable, for the space; NULL: all alike */
    const int *parameter_symbol;          /* borrowed from the system */
    expr_id *defined;                     /* the system's expressions, for the space */
    expr_id *con; size_t con_cap;         /* the constraints' expressions, for the space, */
    int *end; size_t end_cap;             /* and their generations */
    struct expr_flow *flow;               /* in mem */
    struct expr_facts *facts;             /* in mem */
    struct poly_alike *alike;             /* owned: factors of functions that were asked for, within `factoring` */
    struct expr_cone cone;
    struct echelon ech;
    struct ech_row *waiting; int waitings;      /* rows that the next elimination takes: pivots that are large where a motion is may come with its tangencies (near_pivots) */
    struct ech_context ctx;
    unsigned char *determined;            /* by variable */
    unsigned char *active; size_t active_cap;   /* by symbol: derivatives by it are asked for */
    int activated;                        /* the number of symbols where these are all variables; 0: they are others */
    unsigned char *open; size_t open_cap; /* by symbol: undetermined variable (state_open_columns) */
    int *column;                          /* by symbol: variable or -1 */
    struct sga_solution *sol;
    size_t constraint_cap, branch_cap;
    struct route *route;                  /* borrowed */
    expr_id *assumed; int assumptions; size_t assumed_cap;   /* factors in parameters only that were dropped */
    struct sga_error *err;
    const expr_id *pending; int pendings; /* candidates that are to hold together with the present constraints; borrowed */
    struct solved_for *solved;            /* what constraints are solved for (eliminate.c) */
    size_t solved_cap;
    int solved_count;
    struct used_up *used; size_t used_cap; int useds;   /* of the constraints when last asked (eliminate.c) */
    bool affine;                          /* the system was reduced as rational matrices (affine.h) */
    struct domain *domain;                /* in mem: what must not vanish for the system to have a value */
    bool inconsistent;
    struct sga_error held;                /* a constraint could not be admitted for this reason: the run goes on without it, as a
                                           * contradiction of the others stands whatever it says, and fails with it otherwise */
    bool started;                         /* the system's rows are in the echelon form */
    bool restarted;                       /* a pivot died on a smaller set, and they were put in anew */
    bool blocks_lost;                     /* ... and dense blocks with them, whose combinations are not known */
    size_t vanished_cap, rate_cap;
    int epoch;                            /* how often the elimination began anew */
};

/* s->open, for state_tangency: to be asked for anew where variables were determined. */
void state_open_columns(struct state *s);
/* Tangency of constraint i as a row over the undetermined columns:
 * sum of d xi/d x_j x_j' = -(D_0 xi), D_0 the derivative along what is determined. Costs what the constraint is long. */
void state_tangency(struct state *s, int i, struct ech_row *row);
/* Columns whose rows have no free functions left get their velocity, and the flow. */
void state_determine(struct state *s, int generation);

/* New points for the present constraints. */
enum points_status state_sample(struct state *s);

/* Make constraints of generation g from candidates: regular, independent of each other
 * and of the earlier ones, the present points on all of them. Sets s->inconsistent.
 * Returns how many were added, or -1 with err. */
int state_admit(struct state *s, struct candidate *cand, int count, int g);

/* Why e, not being zero on the present set, has no zeros there that last; NULL where its shape does not say. */
const char *state_hopeless(struct state *s, expr_id e);

/* A finished constraint, which goes behind the others. */
void state_push(struct state *s, const struct sga_constraint *c);
/* All constraints, dimensions and rows that vanished are dropped: the reduction begins anew. */
void state_forget(struct state *s);
/* The generation is complete: notes its dimension. False with err: more generations than are allowed. */
bool state_dimension(struct state *s);
/* Points of the present set where the whole system has values, if some are found in a number of tries. */
enum points_status state_sample_defined(struct state *s);

/* Whether e is locally constant in x on the present set: then, not being zero there, it
 * has no zero that lasts. The oracle must hold points of the present set. */
bool state_locally_constant(struct state *s, expr_id e);
/* P_g from the rows of the system and the tangency to the first `to` constraints (those
 * before `from` are in the echelon form already). On the smaller set a pivot may vanish:
 * then the same rows say more there, and that belongs to the same P_g. */
int state_generation(struct state *s, int from, int to, int g);
void state_clear_waiting(struct state *s);
/* s->active: by symbol, 1 for the variables; whoever makes others active says so (activated = 0). */
void state_activate(struct state *s);
/* What holds of e by its shape: expr_facts_of. */
unsigned state_facts(struct state *s, expr_id e);
/* How many nodes of the store it is made of. Costs as many. */
int state_size(struct state *s, expr_id e);

/* The combination of rows and tangencies behind a row: its own source once, and what its
 * operations brought in. */
void state_combine(struct state *s, const struct candidate *c, struct sga_part **part, int *parts);
/* The same of a pivot row. */
void state_combine_pivot(struct state *s, int pivot, struct sga_part **part, int *parts);

/* One run of the reduction along a route, which grows by the decisions that it meets. */
bool state_solve(const struct sys_system *system, const struct reduction_options *options, struct points_oracle *oracle,
                 struct route *route, struct sga_solution *solution, struct sga_error *err);
/* The same, with all variables among the reduction's, those too that equations define (definition.h). */
bool state_solve_as_is(const struct sys_system *system, const struct reduction_options *options, struct points_oracle *oracle,
                 struct route *route, struct sga_solution *solution, struct sga_error *err);

/* X with free functions 0, and the gauge fields. */
void state_fields(struct state *s);

/* "expression" shortened for messages; the caller frees it. */
char *state_text(struct state *s, expr_id e);

#endif
