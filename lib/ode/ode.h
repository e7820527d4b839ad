/* Integration of x' = X(t, x) on a constraint manifold xi(t, x) = 0, in double precision.
 *
 * ode_solve() takes a problem (callbacks), a start and a list of times, and delivers a
 * sample at each of the times, every one of them on the manifold to rounding level. A
 * solution that ends before the last time is not an error: `end` says where and why, and
 * only the samples before it are delivered.
 *
 * Layers, each in its own file: driver.c (the march), control.c (step sizes), a method
 * (method.h; a const struct of functions: tsit5.c, dop853.c, radau.c, taylor.c), switch.c (which of them),
 * sample.c (dense output and its projection), event.c (zeros of functions), kink.c (switches), band.c (pulses), ending.c (why a march stopped), global.c
 * (other solutions, for the error estimate, and tighter ones until it is small enough), companion.c (what stands in for the
 * looser one), solve.c (checks of the request). */
#ifndef SGA_ODE_H
#define SGA_ODE_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

struct sga_error;
struct sga_stage_code;
struct sga_stages;

/* Why a solution ended before the last time asked for. The text is what results show. */
#define ODE_REASON_TABLE(X) \
    X(NONE,            "",                "reached the last time") \
    X(BLOW_UP,         "blow_up",         "the solution or its derivative grows without bound") \
    X(LEFT_DOMAIN,     "left_domain",     "the vector field has no value beyond this point") \
    X(CONSTRAINT_LOST, "constraint_lost", "the constraints can no longer be met") \
    X(SINGULAR,        "singular",        "the field or the constraints become singular") \
    X(NOT_SMOOTH,      "not_smooth",      "no step is small enough for the tolerance") \
    X(EVENT,           "event",           "an event that stops the motion") \
    X(TOLERANCE,       "tolerance",       "errors end it: solutions of other tolerances end elsewhere") \
    X(STEP_LIMIT,      "step_limit",      "too many steps are needed") \
    X(TIME_LIMIT,      "time_limit",      "the time granted is used up") \
    X(CANCELLED,       "cancelled",       "the job was cancelled")

/* An estimate that is a difference of two solutions passes through 0 where the error does not: it is raised towards the largest beside it, by so much at
 * most, because those may be far away. */
#define ODE_NEIGHBOUR 30.0

enum ode_reason {
#define X(sym, text, what) ODE_##sym,
    ODE_REASON_TABLE(X)
#undef X
    ODE_REASON_COUNT
};

const char *ode_reason_text(enum ode_reason r);   /* "blow_up" */
/* Details of ODE_NOT_SMOOTH: both sides of a surface lead to it; no sides of several go together. Of ODE_TOLERANCE. */
extern const char ode_slides[], ode_no_sides[], ode_by_errors[];
const char *ode_reason_what(enum ode_reason r);
/* An end that the motion has at a time of its own, whatever the work it may take. */
bool ode_reason_placed(enum ode_reason r);
/* What t is known to where two solutions end so far apart, the tighter with this rtol, after so long a way. Places are met by steps that shrink, from one side in
 * both: their difference says less than that of samples, and may be small by chance. Measured against closed forms: tests/ends_check.py. */
double ode_end_error(double apart, double rtol, double way);
/* How long what is v may go on growing by this rate, as a pole does, of order two at the most. */
static inline double ode_left_to_grow(double v, double rate) { return rate != 0 ? 2 * (v < 0 ? -v : v) / (rate < 0 ? -rate : rate) : 0; }

/* A time that is known to `error` after so long a way is so uncertain that errors may be all that ends solutions there. */
static inline bool ode_time_is_lost(double error, double way)
{
    static const double LOST = 0.3;
    return way != 0 && error > LOST * fabs(way);
}

/* What counts as an event of a function. */
struct ode_event {
    int direction;             /* +1: it grows through 0 as time grows, -1: it falls, 0: both, and
                                * where it touches 0, as far as the tolerances can tell */
    bool stop;                 /* the motion ends at the first one */
};

enum { ODE_SIDE_TOLD = 0, ODE_SIDE_FRESH = 2 };
/* How many events a motion of n variables may have: the states there are kept. */
static inline int ode_most_events(int n)
{
    enum { MOST_FOUND = 100000, MOST_NUMBERS = 10000000 };
    return MOST_NUMBERS / (n + 1) < MOST_FOUND ? MOST_NUMBERS / (n + 1) : MOST_FOUND;
}

/* One event found. */
struct ode_happening {
    int event;
    int crossing;              /* +1, -1 as above; 0: touched */
    double t;
    double error;              /* estimated, of t; INFINITY where not known */
    double slope;              /* of the function along the motion where it passes 0; 0: not known */
};

/* The problem. Callbacks must be deterministic and may be asked outside the region of
 * interest (stages look ahead); they are called from one thread. */
/* A field that is plain code: run(slots, dx, rest, x) after *time = t gives dx, which must not
 * overlap x, and `rests` numbers that code_holds judges. */
struct ode_code {
    void (*run)(double *slots, double *dx, double *rest, const double *x);
    double *slots, *time;
    double *rest;              /* room for ODE_CODE_CALLS calls, rests each */
    size_t rests;
};
enum { ODE_CODE_CALLS = 12 };

/* The motion as equations for x and its derivative v, for implicit steps on these themselves: r(t, x, v) = 0, n of them, linear in v, some of them
 * the constraints. */
struct ode_implicit {
    const struct lin_sparse *pattern;      /* n x n: of both matrices below */
    bool (*residual)(void *ctx, double t, const double *x, const double *v, double *r);
    /* mass = -dr/dv and slope = dr/dx at (t, x, v), in the order of the pattern's entries. */
    bool (*matrices)(void *ctx, double t, const double *x, const double *v, double *mass, double *slope);
};

/* A part of the time span, from the end of the one before (or the start) to `end`. */
struct ode_piece { double end, step; };
/* |h| so that a step from t in this direction (+1, -1) reaches into no piece further than that one's `step`. *at: the first
 * piece that is not past, 0 at first. */
double ode_within(const struct ode_piece *piece, int pieces, int *at, double t, double direction, double h);

/* A step that was tried: x(n) at the part s (0 to 1) of the way from t to t + h. */
struct ode_path {
    void *march;
    double t, h;
    void (*at)(const void *march, double s, double *x);
    bool (*ready)(void *march);            /* asked once before `at` inside the step; false: it cannot be had, and the step is refused. NULL: it can */
    double (*error)(const void *march, int j);         /* what x_j may be wrong by */
    const double *f0, *f1;                 /* the field at both ends; NULL: not known */
    const struct sga_budget *budget;       /* told where a limit is met */
    bool stages;                           /* the field was asked at many places between, and had a value */
};

struct ode_problem {
    int n;                     /* may be 0 */
    void *ctx;
    /* dx (n) = X(t, x). False: outside the domain, or singular, or not finite. Values
     * that are not finite are taken as false too. */
    bool (*rhs)(void *ctx, double t, const double *x, double *dx);
    /* The same without ceremony, for the stages of a step: false (or NULL): there is no such
     * code at present. The calls 0 .. calls - 1 were made, results finite: are they the
     * field's values? If not, rhs is asked for each. */
    bool (*code)(void *ctx, struct ode_code *code);
    bool (*code_holds)(void *ctx, int calls);
    /* The same for all stages of an explicit step at once; its stages 1, 2, ... are the calls
     * 0, 1, ... that code_holds judges. May be NULL, or false for long. */
    bool (*stages)(void *ctx, const struct sga_stages *plan, struct sga_stage_code *code);
    /* How far rounding takes the field near (t, x): in units of an epsilon of the size that it has there, at least 1, by
     * variable. NULL, or false: not known. Errors are estimated with it. */
    bool (*noise)(void *ctx, double t, const double *x, double *noise);
    /* Moves x to the manifold at time t, to the point nearest in the norm of d_j/scale_j,
     * scale_j > 0 being the error allowed in variable j. NULL: no constraints. Sets
     *   *moved:    root mean square of d_j/scale_j over the n variables,
     *   *residual: the largest |xi_i| left.
     * False: it cannot (x may then hold anything). */
    bool (*project)(void *ctx, double t, double *x, const double *scale, double *moved,
                    double *residual);
    /* Switches were turned, and the constraints jumped: what may jump too (variables that no equation differentiates) is solved for
     * anew, the rest stays. False: it cannot, and x is as it was. NULL: nothing may jump. */
    bool (*jump)(void *ctx, double t, double *x);
    /* The largest |xi_i(t, x)|, for problems without `project` that have constraints to be
     * watched. May be NULL. */
    double (*residual)(void *ctx, double t, const double *x);
    /* Asked right after rhs or project returned false: what the reason is, if the march
     * cannot get past it. NULL: LEFT_DOMAIN for rhs, CONSTRAINT_LOST for project. */
    enum ode_reason (*why)(void *ctx);
    /* For implicit methods: the pattern of dX/dx (NULL: full) and its values in the order
     * of the pattern's entries (by rows where it is full). Where jacobian is NULL or
     * returns false, central differences are taken, one pair of evaluations for each
     * group of columns that share no row; without a pattern and with constraints, they are
     * taken along the manifold. */
    const struct lin_sparse *pattern;
    bool (*jacobian)(void *ctx, double t, const double *x, double *value);
    /* NULL: there are none such. Otherwise implicit steps are made on them (pattern and jacobian are not asked for), and auto makes no others:
     * an evaluation of rhs, which must solve the same equations, costs as much as a factorisation for a step. */
    const struct ode_implicit *implicit;
    /* Where implicit is NULL: such equations for implicit steps, beside which auto makes others too; asked for where the first of them is made. They are better where
     * rhs divides by what tends to 0: the stages are solved in a few turns as long as the equations themselves bend little. NULL, or it returns NULL: none. */
    const struct ode_implicit *(*equations)(void *ctx);
    /* For the Taylor method: coefficients along the solution from (t, x), those of
     * s -> x(t + s scale), order by order: series[k * n + j] for k = 0 .. order. *reach: the least s in (0, 1] at which the field switches (abs and
     * the like), beyond which they do not hold; INFINITY. False: they are not finite, or
     * not known here. NULL: there is no such method for this problem. */
    bool (*taylor)(void *ctx, double t, const double *x, int order, double scale, double *series, double *reach);
    double taylor_rtol;        /* from here on auto takes it; 0: at fine tolerances, as if the series were slow */
    /* Times between start and stop, in the order of the motion, at which the field or its derivatives
     * may jump: steps end there. */
    const double *breaks;
    int break_count;
    /* In the order of the motion: no step may reach further into a piece than its `step`. NULL: no such bounds. */
    const struct ode_piece *piece;
    int pieces;
    /* With breaks: the motion is now between these two times, at which the callbacks may
     * change their nature: they are to give values as inside, also at and beyond the ends. NaN:
     * no motion is followed. May be NULL. */
    void (*enter)(void *ctx, double from, double to);
    /* A solution begins at this time: that of the request, or some roundings beside it. May be NULL. */
    void (*begins)(void *ctx, double t);
    /* After each step: it was taken, the motion is at t, x; or it was not, and what its trial points have told of the way is
     * void: the motion is where it was. Both or none; NULL: nothing is told. True: from now on
     * the same field and manifold are computed in another way, which has more digits here, and x was moved to the manifold as that has it. */
    bool (*taken)(void *ctx, double t, double *x);
    void (*refused)(void *ctx);
    /* Implicit steps on `equations` came to where none is short enough, and are made on rhs from the last point on: what trials beyond it have told of the end is
     * forgotten. May be NULL. */
    void (*otherwise)(void *ctx);
    /* Before a step is taken: whether the field goes on along all of it. False: as when rhs is. May be NULL. */
    bool (*along)(void *ctx, const struct ode_path *path);
    /* After a step that the field refused, before `refused`: it is sure to end at *t, which is so near that the way there is not worth its
     * steps (points there lose their digits). May be NULL. */
    bool (*over)(void *ctx, double *t);
    /* Switches: functions g of t and x on each side of whose zeros the field is smooth (those in abs, sign, min, max).
     * hold(side): from now on the callbacks give values as where g_k has the sign of side[k], wherever they are
     * asked; 0: as g_k says. NULL: all 0, as at first. switching gives all g. */
    int switches;
    void (*switching)(void *ctx, double t, const double *x, double *g);
    void (*hold)(void *ctx, const signed char *side);
    /* Where some variables are derivatives of others: switches were turned at t (the motion led to the surfaces of those with turned[k]), where x and its derivative were `from` and
     * `before`; x is there now, on the constraints of the sides beyond, and becomes what it is with the jumps of the derivatives. False: they have no value there.
     * NULL: none are. */
    bool (*turned)(void *ctx, double t, const double *from, const double *before, const unsigned char *turned, double *x);
    /* Bands: arguments of what is a pulse or a step of the field where they are near 0 and nothing far from it (exp,
     * tanh): steps do not pass over a place where one is (band.c). band gives all. */
    int bands;
    void (*band)(void *ctx, double t, const double *x, double *a);
    double cost;               /* of one rhs, in multiplications; 0: taken as 20 n */
    /* What errors are estimated of: y (outputs) at t, x. NULL: the variables. */
    int outputs;
    void (*output)(void *ctx, double t, const double *x, double *y);
    /* Functions whose zeros are looked for, all of them at t, x into g (events); a value
     * that is not finite is no zero. */
    int events;
    const struct ode_event *event_spec;
    /* Where the motion is one that goes on from an event: by event the side of its zero that it starts on, +1 or -1, though the value may be
     * 0 there; ODE_SIDE_TOLD: the value tells, to its rounding; ODE_SIDE_FRESH: to the error allowed, as where this is NULL. With it, what
     * happens at the time of an event that stops (to its rounding) is found beside it. */
    const signed char *event_side;
    void (*event)(void *ctx, double t, const double *x, double *g);
};

struct ode_start {
    double t;
    const double *x;           /* n; consistent: it is projected, and moves no further */
    int count;                 /* samples; at least 1 */
    const double *times;       /* ascending from t, or descending from t; repeats allowed.
                                * The last one is where the integration stops. */
};

struct ode_options {
    const char *method;        /* NULL or "auto": chosen, and changed where the problem turns
                                * stiff or no longer is; else a name in method.c's table */
    double rtol, atol;         /* local error allowed: atol * unit_j + rtol * |x_j| */
    const double *unit;        /* n; typical sizes, > 0; NULL: all 1 */
    const double *output_unit; /* the same of the outputs, where there are some */
    const unsigned char *output_beside;   /* by output: its errors are told, but no tighter solution is looked for because of them; NULL: none */
    double time_unit;          /* the same of times of events; 0: 1 */
    double first_step;         /* 0: chosen */
    double max_step;           /* 0: none */
    long max_steps;            /* accepted and refused, of one solution */
    bool estimate_global_error;
    bool refine;               /* with estimates: solve again until they are within tolerance */
    bool keep_rows;            /* with estimates: where the budget's time ends first, what two solutions have reached by then is the result */
    const struct sga_budget *budget;   /* NULL: none */
};
/* method auto, rtol = atol = 1e-9, 1,000,000 steps, no error estimate, no budget. */
struct ode_options ode_options_default(void);

struct ode_stats {
    long steps, refused;       /* accepted; refused for any cause */
    long evaluations;          /* of rhs */
    long projections;
    long jacobians, factorisations;    /* of implicit steps; a factorisation is of all shifts */
    long implicit_steps;       /* accepted */
    long kinks;                /* switches passed */
    long stiff_steps;          /* accepted where stability, not accuracy, set the size */
    double smallest_step, largest_step;
};

struct ode_end {
    enum ode_reason reason;    /* ODE_NONE: the last time was reached */
    double t;                  /* where; the last time if it was reached */
    double error;              /* estimated, of t: how far apart the solutions that were compared end; 0: not known, or no place of the motion's own */
    double left;               /* where steps were given up before it: how long the motion may have had to it */
    bool alone;                /* a blow-up of this solution; another one goes on to the last time */
    int variable;              /* of the one that grows most, for BLOW_UP; else -1 */
    char detail[256];          /* a sentence, "" for ODE_NONE */
};

struct ode_result {
    int n, count;              /* count: samples delivered */
    double *samples;           /* count x n by rows */
    double *inside;            /* count: by how much the polynomial of its step may miss the sample, in units of what rtol and atol below allow; 0 at steps' ends */
    double *apart;             /* count x n: the solution less a looser one beside it, to first order (companion.h); NULL: not known */
    struct ode_end end;
    double max_residual;       /* over the samples; 0 without project and residual */
    double start_moved;        /* how far the start was moved, in units of its error */
    double start_residual;     /* the largest |xi_i| at the projected start */
    /* With estimate_global_error: error[k] estimates max_j |y_j - true y_j| at sample k, y
     * the outputs, or the variables; INFINITY where it is not known (the
     * comparison ended before). max_error is the largest of them, column_error (count x
     * columns) those of each y_j; worst is the largest
     * error_j / (atol unit_j + rtol |y_j|) with the tolerances asked for. Otherwise error is NULL
     * and max_error and worst are -1. */
    double *error, *column_error;
    double max_error, worst;
    /* Events in the order of the motion, none past the end; those of the start itself are not
     * counted. The states there, on the manifold: happened x n. */
    int happened;
    struct ode_happening *happening;
    double *happened_x;
    signed char *held; int helds;      /* by switch: the side that it was held on at the end; 0: it was not */
    const char *shortfall;     /* why worst is above 1, static; NULL where it is not */
    int solutions;             /* computed in all */
    double rtol, atol;         /* used for the solution that was delivered */
    const char *method;        /* names of the methods that made steps; static */
    struct ode_stats stats;    /* of the solution delivered */
    struct ode_stats second;   /* of all other solutions together, all 0 without one */
};

/* Integrates. False only for requests without meaning (times not monotone, not finite,
 * tolerances not positive, unknown method): err (may be NULL) says what, and there is
 * nothing to free. Otherwise fills *res (whatever it held), to be released with
 * ode_result_free; also where the budget ended, with reason TIME_LIMIT or CANCELLED.
 *
 * With estimate_global_error two solutions are computed, at the tolerances and at a
 * tenth of them. The tighter one is delivered; their difference, which is the error of
 * the looser one, gives the estimate: it is some 15 times too large in the median, and
 * holds. The looser one starts a rounding beside the start and follows a field that is
 * wrong by a rounding, so that the effect of rounded data shows too. Cost: about 1.9
 * times one solution. Where all steps are Taylor series and no events, switches or jumps are on the way,
 * the looser one is followed to first order only (companion.h), down to tolerances of 1e-11: about 1.45 times.
 * With `refine` a tighter one follows while the estimate exceeds the
 * tolerances, each against the one before; `shortfall` says why that was given up.
 *
 * Tolerances below 1e-14 (relative) cannot be met in double precision and are raised. */
bool ode_solve(const struct ode_problem *p, const struct ode_start *start,
               const struct ode_options *opt, struct ode_result *res, struct sga_error *err);
void ode_result_free(struct ode_result *res);

/* The methods there are: name and one line, NULL past the last. For schemas and menus. */
const char *ode_method_name(int i);
const char *ode_method_what(int i);

#endif
