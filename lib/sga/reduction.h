/* The stabilization general algorithm (SGA) on A(x, t) x' = alpha(x, t).
 *
 * Source: Munoz-Lecanda & Roman-Roy, Implicit quasilinear differential systems (EJDE
 * 1999/10), section 3, theorems 1 and 2. From P_0 = M (or the zero set of the
 * restriction)
 *     P_{k+1} = { m in P_k : some v in T_m P_k has A(m) v = alpha(m) }
 * until nothing changes. One echelon form of the stacked rows [A; d xi | alpha; -d_t xi]
 * carries it: a row that vanishes on P_k with a right side that does not is a new
 * constraint; columns without a pivot at the end are the gauge freedom. Every zero, rank
 * and pivot is decided by the oracle at certified points of P_k, and recorded. */
#ifndef SGA_SGA_REDUCTION_H
#define SGA_SGA_REDUCTION_H

#include <stdint.h>

#include "expr.h"

struct points_oracle;
struct points_side;
struct sga_budget;
struct sys_system;

enum sga_verdict { SGA_UNIQUE, SGA_UNDERDETERMINED, SGA_ISOLATED, SGA_INCONSISTENT };

enum sga_origin { SGA_FROM_RESTRICTION, SGA_FROM_ROWS };

/* One term of the combination that made a constraint: factor times (row of the system,
 * or tangency of an earlier constraint). */
struct sga_part {
    int row;               /* index of the system's row, or -1 */
    int tangency;          /* index of the constraint, or -1 */
    expr_id factor;
};

struct sga_constraint {
    expr_id expr;          /* vanishes on P_generation */
    int generation;        /* from 1 */
    bool chosen;           /* one of several branches of a product */
    enum sga_origin origin;
    int restriction;       /* which one it came from; -1: none */
    struct sga_part *part; int parts;
    expr_id replaced;      /* the function that arose, where a regular one took its place; or EXPR_UNDEF */
    bool near_point;       /* that holds near the points; what was replaced may have more zeros elsewhere */
    expr_id base; int order;  /* expr is order! times the order-th flow coefficient of base */
    int source;            /* row of the system, or rows + index of the constraint whose tangency it was; -1 */
    int epoch;             /* how often the elimination had begun anew when it was found */
};

/* A row of the last elimination that gave neither pivot nor constraint: the sum of its
 * parts has no velocities left, and its right side `rest` vanishes on P_generation (0: on
 * all of M). */
struct sga_vanished {
    int source;            /* as in struct sga_constraint */
    int generation, epoch; /* epoch as in struct sga_constraint */
    expr_id rest;
    struct sga_part *part; int parts;
};

/* A velocity that an elimination determined: the sum of parts is, with velocities that were determined before put in, a multiple of
 * x_variable' - value on the set of the generations before. What later constraints of the same epoch put in for it is `value`. */
struct sga_rate {
    int variable;
    int generation, epoch; /* of the elimination; epoch as in struct sga_constraint */
    expr_id value;
    struct sga_part *part; int parts;
};

struct sga_pivot {
    int col;               /* -1: a factor in parameters only, dropped from a constraint */
    expr_id value;         /* assumed not zero */
    int generation;        /* in which elimination it was chosen: 1 that of the rows of A, g that which leaves constraints of generation g, and one more for the field */
    int source;            /* as in struct sga_constraint; -1 where col is */
};

/* The zero set of a factor of a product, where another one was followed. */
struct sga_branch {
    expr_id expr;
    int before;            /* how many constraints stood when the product was met */
};

/* A variable that a row defines by a function with switches or roots (definition.h): the reduction and motions are those of the
 * system with the function in its place. Its row is the constraint of the same number. */
struct sga_definition {
    int variable, row;
    expr_id value;         /* of variables that are not defined, and time */
};

/* A dense block that was solved as a whole: r velocities from r rows with the matrix S. */
struct sga_determinant {
    int size;
    expr_id value;         /* a SOLVE node, 0 where det S = 0 (see ech_block_test) */
    int solve;             /* its system in the store; S is the first r rows and columns */
    int *col, *source;     /* by row of S: the velocity, and the row as in struct sga_constraint; owned */
};

/* A point of the final set on another component of the constraints than the one that was solved. */
struct sga_elsewhere {
    double *x, t;          /* by variable; owned */
    int final;             /* its dimension there */
};

/* Functions of the symbolic parameters: where all of them vanish the answer may be another one. */
struct sga_condition {
    expr_id *function; int functions;
};

struct sga_conditions {
    struct sga_condition *at; int count; size_t cap;
};

struct sga_solution {
    enum sga_verdict verdict;
    int generations;
    int *dimension;                    /* by generation: dim P_1 .. */
    bool exact;                        /* constant coefficients, reduced over the rationals: dimensions and ranks are proved */
    bool written_out;                  /* ... and constraints and fields are sums of numbers times variables, reduced by the constraints */
    struct sga_constraint *constraint; int constraints;
    struct sga_pivot *pivot; int pivots;
    expr_id *field;                    /* by variable: X with every free function 0; NULL: inconsistent, or left out (options.field_unasked) */
    int *free_column; int free_columns;
    expr_id *gauge;                    /* free_columns x variables, by rows */
    expr_id passed;            /* a way for a constraint to vanish that was passed over: no regular point of it was found, which proves nothing; or EXPR_UNDEF */
    struct sga_branch *branch; int branches;
    struct sga_pivot *dead; int deads; /* divided by on a larger set, zero on the smaller one */
    /* Where general points contradict the system, but points where these functions vanish do
     * not: the answer is that of the restriction to them, the largest such set. `other` lists
     * functions whose zero sets hold solutions too. */
    expr_id *special; int specials;
    expr_id *other; int others;
    int equilibrium;                   /* isolated: are the points constant solutions, 1, 0 or -1 (undecided) */
    bool empty_restriction;            /* inconsistent: the restriction has no zeros at all */
    bool depends_on_time;              /* some row, restriction or constraint depends on t */
    expr_id contradiction;             /* for inconsistent: what would have to vanish */
    struct sga_part *contradiction_part; int contradiction_parts;
    int contradiction_epoch;
    char contradiction_why[400];
    struct sga_determinant *determinant; int dense_blocks;   /* assumed not 0; owned */
    int *scale;                        /* by variable, for sampling (points_space), or NULL; owned */
    double time_unit;                  /* for sampling too */
    struct points_side *side; int sides;   /* of surfaces that zero decisions rest on: the answer holds there; owned */
    bool sides_not_searched;           /* some switches of the constraints were not looked beyond */
    bool not_factored;                 /* some constraint was too large to be searched for branches */
    expr_id stuck;                     /* of a run that failed: what could not be made a constraint, or EXPR_UNDEF */
    int one_piece;                     /* the first so many constraints have a set of one piece by their shape: graphs, or affine */
    struct sga_elsewhere *elsewhere; int elsewheres;   /* other components that hold solutions; owned */
    struct sga_definition *definition; int definitions;   /* owned */
    int redundant_rows;                /* rows of the system that follow from the others (at least) */
    struct sga_vanished *vanished; int vanished_rows;   /* only where options.rows asks for them */
    struct sga_rate *rate; int rates;  /* in the order in which they came; only where options.rates asks for them; owned */
    struct sga_conditions conditions;  /* of all branches that were looked at; owned */
};

struct reduction_options {
    const double *near; double near_time;   /* a guess for a point of Pf, or NULL */
    const unsigned char *near_given;        /* by variable: its value in the guess was given; others are free. NULL: all were */
    double near_spread;                     /* as in struct points_space */
    bool near_only;                         /* what is elsewhere is no matter: it is not looked for */
    bool near_pivots;                       /* pivots are those that are large at near (all of it was given): for a motion that is there */
    const double *parameter_near;           /* by parameter: one that comes with it, NAN where there is none; or NULL */
    uint64_t seed;
    const struct sga_budget *budget;
    bool combinations;                      /* work out the parts of each constraint */
    bool gauge_fields;
    bool field_unasked;                     /* nothing will ask for the field: it is left out (NULL) where its numbers grow long */
    int gauge_nodes;                        /* that they may add (and 100 components for each); beyond it they are left out. 0: no limit */
    bool rows;                              /* keep what became of rows that vanish; needs combinations */
    bool rates;                             /* keep which velocities each elimination determined; needs combinations */
    struct sga_conditions *conditions;      /* what each run takes for granted of the parameters is added; or NULL */
};

/* Runs the reduction. The oracle is initialised by the caller and holds points of Pf at
 * the end (unless inconsistent). False with err filled where the job fails; a verdict is
 * a result, not an error. Cost: near linear in the nonzeros where elimination does not
 * fill in. */
bool sga_reduce(const struct sys_system *system, const struct reduction_options *options,
               struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err);
void sga_solution_clear(struct sga_solution *solution);
/* Forgets which velocities were determined when. */
void sga_rates_drop(struct sga_solution *solution);
/* Whether a solution keeps its own rules: generations rise, dimensions fall, pivots, parts and free columns are of the system, fields are
 * complete. Asserted where a stage of a job ends. */
bool sga_solution_sane(const struct sys_system *system, const struct sga_solution *solution);
/* Whether two reductions of one system, with other pivots, say the same of the set and of how much moves on it. */
bool sga_solution_same_kind(const struct sga_solution *a, const struct sga_solution *b);
void sga_conditions_clear(struct sga_conditions *conditions);

/* The generations of the first `constraints` as stages for points_find_staged: end[k] (room for `generations`) is the
 * number of them of the first k + 1 generations. Returns how many stages. */
int sga_stages(const struct sga_solution *solution, int constraints, int *end);

const char *sga_verdict_text(enum sga_verdict verdict);

#endif
