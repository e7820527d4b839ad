/* Inside the traj folder: the reduced field as numbers. */
#ifndef SGA_TRAJ_FIELD_H
#define SGA_TRAJ_FIELD_H

#include "trajectory.h"

struct gauge_choice;
struct num_switches;
struct ode_code;
struct ode_path;
struct sga_stage_code;
struct sga_stages;
struct whole;

/* Two ways to the same vector. The fast one evaluates the expressions of the reduced
 * field, with the gauge choice in them (gauge_choice.h); it is used where there are such expressions and no
 * pivot has come near 0. The general one solves the rows that define the field,
 *     A v = alpha, d xi v = -d_t xi, v_j = rate_j,
 * with pivots chosen at the point, for the solution of least norm: so a pivot that only
 * happens to vanish stops nothing, and what is left of the gauge freedom is least norm over
 * all of X among the solutions tangent to Pf. */
struct field_sum { int entry, size; };     /* roots of `general` */

struct field {
    int n, rows, c, rates, pivots;
    struct num_switches *switches;    /* owned, as choice: of the field, the constraints, the rows and the events, however they are written */
    const struct sys_system *sys;
    const struct traj_rate *rate;
    struct gauge_choice *choice;
    const expr_id *root;              /* n: the field as expressions, of choice or of the solution; borrowed */
    int chosen;                       /* pivots from this one on are those of the choice: their zeros end nothing */
    bool fast;                        /* the expressions may be used */
    struct num_tape *direct;          /* roots: field, pivots, poles */
    const struct points_side *solution_side;   /* borrowed */
    int sides;                        /* the first so many "pivots" are sides that the answer rests on */
    int deep;                         /* those from `sides` to here are pivots that constraints may carry: where they are small, so are the digits of these */
    int beyond;                       /* the side of which nothing was known beyond, and where the motion is; -1: none. See field_follows */
    double *direct_out, *pivot_start;
    double *stages;                   /* pivots and poles by call of the code: see field_code */
    expr_id *pivot_expr;
    /* A pivot that changes sign has passed 0. The rank at the place tells whether it only
     * happened to vanish (the chart changes) or a stratum begins there, beyond which the
     * field is not continued. */
    double *pivot_side;               /* by pivot: sign on the side where the motion is */
    double *here, here_t;             /* the last point that was found to be well inside */
    double *home, home_t;             /* n: the last point that the motion has taken; then pivots' and poles' sides there */
    /* field_along.c: roots of the tape are the pivots up to `chosen` (guard_pivots; with `whole` none), poles, and from guard_ends on what is negative beyond the ends of domains. */
    struct num_tape *guard; int guards, guard_pivots, guard_ends;
    expr_id *guard_expr;
    int border; double border_t;      /* the last end of a domain that was refused inside a step: its root, or -1, and when */
    const expr_id *valued; int valueds;       /* what the motion's variables define has values too (traj_request); borrowed */
    struct num_tape *values;                  /* the same, with nothing held; NULL: none */
    struct pole_named *named; bool named_asked;       /* pole.c: made where they are asked for first; NULL: none */
    double *along; unsigned char *along_free;      /* their values at the end of the last step looked at, and rates (then work), */
    double along_t, along_h;          /* when that is, and how long that step was; not a number: of none */
    double along_calm;                /* for so long no step needs a look, */
    bool along_stages;                /* of these methods (ode_path) */
    double begin_t;                   /* the motion begins here */
    double start_t;                   /* each solution (there may be two) begins here */
    struct manifold *manifold;        /* to look for the place of a change of sign; borrowed */
    int lost_pivot;                   /* the pivot whose zero ended it, or -1 */
    int fell;                         /* the pivot with which the rank goes, as points on the way to its zero tell (field_drop.c), and when that is; or -1 */
    double fell_t;
    bool over;                        /* and it is so near that the motion may be ended (field_watch.c) */
    /* Denominators of the equations as given; their values follow those of the pivots (pole.c). */
    int poles;
    expr_id *pole_expr;
    double *pole_side, *pole_from;    /* signs where the motion is; n: where it began */
    int lost_pole;                    /* the denominator whose zero ended it, or -1 */
    struct num_tape *plain;           /* roots: field; for its derivatives, where fast */
    struct num_jacobian *slope;       /* of plain, by variables */
    struct lin_sparse *pattern;       /* of slope */
    const expr_id *constraint;        /* c; owned */
    int dense;                        /* the largest block of velocities that the reduction solved as a whole */
    bool reduced;                     /* whole is not wanted */
    struct whole *whole;              /* the rows as one sparse system, in place of all else; or NULL. whole.h */
    struct num_tape *general;         /* roots: entries of A, alpha, rates */
    double *general_out;
    struct num_tape *alpha;           /* field_miss.c's, made where asked for; roots: right sides by row */
    struct num_jacobian *alpha_slope;
    double *alpha_value;              /* its entries; not NULL: asked for */
    struct field_sum *sum; int sums;  /* field_sums.c's: entries of A that are sums */
    struct num_tape *con;             /* roots: constraints */
    struct num_jacobian *jac;         /* by variables and time */
    double *jac_value;
    double *in;                       /* variables, time */
    const double *guess; const unsigned char *given;   /* by variable: the request's; borrowed */
    const double *unit;               /* by variable: natural sizes (sizes.h), borrowed; NULL: all 1 */
    double *M, *rhs, *qr;             /* qr: for points_least_norm, with */
    double *kept, *row_size;          /* field_rows.c's: M's entries, what its rows were divided by; */
    int kept_rank;                    /* the rank of the rows, -1: no factors are kept; */
    const double *kept_unit;          /* these are for v in these units */
    int *perm;
    int generic_rank;                 /* of the system at general points of Pf */
    int rank;                         /* what it must be; a loss of it is a stratum */
    bool rank_lost;                   /* set by the last evaluation */
    bool contradiction;               /* of the last evaluation that was refused: the rates do not fit any more */
    long evaluations;
};

/* field_sums.c: behind `at` roots, the sizes of what is added up in those of them that are entries of A and sums (log(x y) - log(x) - log(y));
 * returns how many roots there are then. */
int field_sums_add(struct field *f, expr_id **root, int at);
/* f->general at f->in: an entry that is rounding beside what is added up in it is 0. False: no value. */
bool field_general_values(struct field *f);

bool field_init(struct field *f, const struct sys_system *sys, const struct sga_solution *sol,
                const struct traj_request *rq, struct manifold *manifold, struct sga_error *err);
/* For tapes; NULL: there are none. */
const struct num_switches *field_switches(const struct field *f);
/* The sides that its switches were held on (side: by switch; NULL: on none), into r. */
void field_keep_held(const struct field *f, const signed char *side, struct traj_result *r);
/* As num_tape_hold, for all ways to the field. */
void field_hold(struct field *f, const signed char *side);
void field_clear(struct field *f);
/* Invariants of what is watched, and of ranks. */
bool field_sane(const struct field *f);
/* field_begin.c. Fix the expected rank, and check that the rates agree with the motion. False: GAUGE or
 * NO_MOTION with err. */
bool field_begin(struct field *f, double t, const double *x, struct sga_error *err);
/* The same without the rows as one sparse system, whatever the size. */
bool field_as_reduced(struct field *f, double t, const double *x, struct sga_error *err);
/* v = X(t, x). False outside the domain or where the rank is lost. */
bool field_eval(struct field *f, double t, const double *x, double *v);
/* ode_problem's code, stages and code_holds: the machine code of the expressions; every pivot was on its
 * side and well away from 0 in these calls. */
bool field_code(struct field *f, struct ode_code *code);
bool field_stages(struct field *f, const struct sga_stages *plan, struct sga_stage_code *code);
bool field_code_holds(const struct field *f, int calls);
/* stratum.c. After a motion from start that came to no further than end_t: the pivot, of the reduction or (choice) of the gauge choice, that tends to 0
 * there while what it depends on stays finite, or -1. apart: of the way made, by which the place where a zero of higher order lies may be another.
 * A denominator of the field may come to 0 sooner: *pole (or NULL), else -1; what moves fast only because of it is not told. */
int field_approaches(struct field *f, const double *start, double start_t, double end_t, double apart, bool choice, int *pole);
#define FIELD_SOON 1e-3        /* apart, where the motion itself grows without bound */
/* When that pivot is 0, from the last point inside, to the third power of the way there; not a number: not known. */
double field_zero_ahead(struct field *f, int pivot);
/* The variable that grows most as a pole at the zero of this pivot does, ahead of the last point inside, where the pivot depends on such a one; -1: it depends on
 * none. start: of the motion. */
int field_grows_with(struct field *f, int pivot, const double *start);

/* Inside this module.
 *
 * field.c. Symbols of the variables and time (malloced). */
int *field_inputs(const struct sys_system *sys);
/* f->in is the place (t, x). */
void field_load(struct field *f, double t, const double *x);
/* field_rows.c. v at in from the rows that define the field, of least norm, and their rank. False: they have no value there.
 * Costs the cube of the variables, their square where the rows' matrix is as it was. */
bool field_general(struct field *f, double *v, int *rank);
/* field_rows.c. The rank at the place in f->in, a row of the equations that has all but vanished since (t, x) counting as 0 (x1 x3' = x1^2 beside x1 = 0), which by
 * itself has an entry as large as any other. -1: no value at one of them. Costs two evaluations of the rows and one elimination. */
int field_rank_since(struct field *f, double t, const double *x);
/* What field_general has made room for and kept; it is made anew where it is asked for next. */
void field_rows_forget(struct field *f);
/* The same rank at the start where entries are 0 that roundings, of values and of what of the start was not given, do not tell from it; -1: no value.
 * Some evaluations, and a factorisation. */
int field_rank_told(struct field *f);
/* field.c. The largest |v_j| in natural units, 1 at the least. */
double field_size(const struct field *f, const double *v);
/* field_miss.c. The largest |row v - right side|, each row divided by its largest entry; *row: which. */
double field_rows_miss(struct field *f, const double *v, int *row);
/* Each row that misses by more than that much is within roundings of its terms, and of those that rates are sums of: natural units may be far smaller
 * than what doubles tell of these (a velocity of 1e-100 at a place of 100). Costs the slopes of all rows, and where switches are held an evaluation for each variable of each row. */
bool field_rows_rounded(struct field *f, const double *v, double miss);
/* The field at in, by whichever way it goes; direct_out is that of the same place. */
bool field_value(struct field *f, double *v);

/* field_watch.c. A list of expressions to be watched, of any length. */
struct field_list { expr_id *e; int count; size_t cap; };
void field_list_add(struct field_list *l, expr_id e);
/* Adds expressions whose zeros are those of a pivot. */
void field_watch_pivot(struct field *f, expr_id pivot, struct field_list *l);
/* The sides of pivots' and poles' zeros on which a solution begins; direct_out is that of (t, x). */
void field_take_sides(struct field *f, double t, const double *x);
/* The motion has come to (t, x): sides are kept as they are there. And: trial points are forgotten, sides are those of the
 * last point that was kept; lost_pivot and lost_pole still say what a trial met. */
void field_keep_sides(struct field *f, double t, const double *x);
void field_forget_trial(struct field *f);
/* On which side of each pivot's and denominator's zeros is (t, x)? direct_out is known. False: beyond a stratum
 * (lost_pivot) or a pole (lost_pole). */
bool field_inside(struct field *f, double t, const double *x);
/* field_along.c. The guards, at a start that holds them in no switch; false: err is set. Whether none of them ends the motion inside the step from the last point that
 * the motion has taken along path; false: as after field_eval. Cost: two evaluations of the guards where nothing was near lately, some fifty where something is. */
bool field_guards_init(struct field *f, struct sga_error *err);
void field_guards_forget(struct field *f);
bool field_along(struct field *f, const struct ode_path *path);
/* The end of a domain that the motion has ended at, at the time t: by its value and rate at the last point taken it comes to 0 within `near` of t. A root
 * of the guard; -1: there is none. Cost: one evaluation of the field, two of the guard. */
int field_border_ahead(struct field *f, double t, double near);
void field_along_anew(struct field *f);       /* a solution begins: nothing is known of the steps before */
/* fell_t as it is seen from the last point that the motion has taken. */
void field_fall_refine(struct field *f);
/* Beyond a side of which nothing was known (points_side.unseen) the rows say whether the field is still theirs: at (t, x), a point on the
 * constraints. False: it is not, rank_lost and lost_pivot say why. Cost: nothing on the side of the start. */
bool field_follows(struct field *f, double t, const double *x);
/* Nothing is near: every pivot is on its side and well away from 0, every denominator on its side. p: their values. */
bool field_well_inside(const struct field *f, const double *p);
/* No pivot of the last evaluation of f->direct has come near 0. */
bool field_pivots_well(const struct field *f);
/* Between the last point inside and (t, x) root k of the direct tape after the field changed its sign from
 * side: y (n) and the time that is returned are where, on the constraints, within `near` of the way between;
 * f->in and direct_out are for that place. */
double field_place_of_change(struct field *f, int k, double side, double t, const double *x, double near, double *y);

/* field_drop.c. Between the last point that the motion has taken and (t, x) a pivot came to 0: whether the rank of the rows goes with it, as far as
 * points on the way tell. Cost: some projections, two eliminations. */
bool field_rank_falls(struct field *f, int pivot, double t, const double *x);
/* The same along a way of points on the constraints (as far as tolerances go) from where the pivot is large to its zero at the part `end`. */
struct field_way {
    const void *of;
    void (*load)(struct field *f, const struct field_way *way, double s);     /* f->in is the place at the part s */
};
bool field_falls_along(struct field *f, int pivot, const struct field_way *way, double end);
/* Sizes of the columns of a (rows x n) in which, each row by its largest entry, their largest entries are of one size: units of the variables are nobody's concern.
 * 0: of one that no row has to more than roundings. Cost: some passes over a. */
void field_balance(const double *a, int rows, int n, double *column);
/* What is left for the last of `rank` of the rows (a: rows x n), by complete pivoting; they are used up. Cost: rank rows n. */
double field_left_for(double *a, int rows, int n, int rank);
/* The same where the motion is, over what it was at the start, of the rows without the columns of variables that are far, and without the constraints that have these: no matter
 * in which units. Not a number where they have no values, or nothing is left at the start. Cost: rows times n, twice. */
double field_left_of_others(struct field *f, double start, const double *initial, const unsigned char *far, int rank);
/* Whether these can tell: there are constraints, no rates, and not too many rows. */
bool field_rank_tells(const struct field *f);

/* pole.c. Adds the denominators of the equations that are not among the list, by factors. Cost: the nodes of the equations. */
void field_find_poles(struct field *f, struct field_list *l);
/* Denominator q changed its sign between the last point inside and (t, x): does the field grow like its
 * inverse (or nearly) towards its zeros near there, or what variables are defined as beyond all bounds? Then the solution is not
 * continued. Unknown: no points could be found from so far away. */
enum field_pole { FIELD_NO_POLE, FIELD_POLE, FIELD_POLE_UNKNOWN };
enum field_pole field_pole_at_change(struct field *f, int q, double t, const double *x);

/* field_slope.c: f->slope and f->pattern, where the field is given by expressions; called
 * once, when an implicit method may be needed. */
bool field_slope_init(struct field *f, struct sga_error *err);
/* The field's expressions may be used at this point: no pivot has come near 0. */
bool field_expressions_hold(struct field *f, double t, const double *x);
/* dX/dx in the order of f->pattern's entries. False where the expressions are not used at
 * this point, or have no derivative. */
bool field_slope(struct field *f, double t, const double *x, double *value);

#endif
