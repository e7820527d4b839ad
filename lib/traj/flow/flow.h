/* Inside the traj folder: a solved system made ready for numbers. */
#ifndef SGA_TRAJ_FLOW_H
#define SGA_TRAJ_FLOW_H

#include "trajectory.h"

struct charts;
struct field;
struct given;
struct inputs;
struct manifold;
struct ode_options;
struct ode_problem;
struct ode_result;
struct ode_start;
struct series;
struct sizes;
struct variation_turn;

struct flow {
    struct manifold *manifold;    /* owned, as field, series, given, inputs, sizes */
    struct field *field;
    struct series *series;
    struct given *given;
    struct num_tape *surface;     /* arguments of the field's switches; inputs: variables, time; NULL: none */
    struct num_tape *band;        /* see bands.h; the same; NULL: none */
    struct num_tape *output;      /* inputs: variables, time */
    struct num_tape *event;       /* the same */
    struct num_tape *valued;      /* the same; functions that must have values; NULL: none */
    double *value;                /* theirs */
    bool no_value;                /* the last point that was asked for had none, */
    int lost_value;               /* and which it was that had none last of all, and when; -1: none */
    double lost_value_t;
    struct ode_event *spec;
    double *in;
    int n, bands;
    const struct sys_system *sys;
    struct inputs *inputs;
    struct sizes *sizes;
    unsigned char *moving;        /* n: variables that some equation differentiates: they do not jump */
    struct leap *leap;            /* see leap.h; or NULL */
    double thrown_t;              /* where constraints jumped last, had values, and nothing could follow, or NAN */
    bool thrown;                  /* the last projection failed, there */
    bool off;                     /* the last projection failed where the constraints have values */
    double *noise;                /* n: see flow_noise; NULL until it is asked for */
    struct variation_turn *turn;  /* of motions with derivatives that come to switches; or NULL */
    struct charts *charts;        /* owned; NULL: the motion has one (charts.h) */
    struct whole *beside; bool beside_asked;  /* owned: the equations, for implicit steps beside others (flow_problem); or NULL */
    double *knot; int knots;      /* of the tables, inside the motion's times, in its order */
};

/* Everything but the derivatives of the field. False: err says why; flow_clear is due all the same. */
bool flow_init(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol,
               const struct traj_request *rq, struct sga_error *err);
void flow_clear(struct flow *f);
/* The consistent start x (n); where the guess leads nowhere, from a point that a search finds.
 * *moved: see consistent_start. */
bool flow_start(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol,
                const struct traj_request *rq, double *x, double *moved, struct sga_error *err);
/* solved[j] (n, zero on entry) becomes 1 for variables that the constraints can be solved for near x, values that were not given
 * first; the others are coordinates of Pf. Returns how many. */
int flow_solved(struct flow *f, const struct traj_request *rq, const double *x, unsigned char *solved);
/* Whether the given equations hold at the consistent start x: NO_MOTION with err where one does not. */
bool flow_given(struct flow *f, const struct traj_request *rq, const double *x, struct sga_error *err);
/* Whether the functions that must have values have them at a point. */
bool flow_valued(struct flow *f, double t, const double *x);
/* The constraints have jumped: what may jump with them is solved for anew (manifold_jump, or leap_over). False: nothing can, and x is as it was. */
bool flow_jump(struct flow *f, double t, double *x);
/* After field_begin: how the motion is chosen. */
const char *flow_gauge(const struct flow *f, const struct traj_request *rq);
/* As ode_problem.noise, looked at where it is asked for first. After field_slope_init. */
bool flow_noise(void *flow, double t, const double *x, double *noise);
/* The columns y of a sample. */
void flow_output(void *flow, double t, const double *x, double *y);
/* sized.c. ode_solve in units of natural sizes; where that goes wrong, once more in those of the motion so far, if it comes as far. */
bool flow_solve(struct flow *f, const struct traj_request *rq, const struct ode_problem *problem, const struct ode_start *start,
                struct ode_options *options, struct ode_result *o, struct sga_error *err);
/* The largest of each column of rows x columns errors; malloced. */
double *traj_column_errors(const double *error, int rows, int columns);
/* As num_tape_hold, for everything of the flow that has switches. */
void flow_hold(void *flow, const signed char *side);
/* drift.c: r->drift from samples x n states at the request's times. False with err: an integral has
 * no value anywhere, or uses names that have none. */
bool traj_drift(struct flow *f, const struct traj_request *rq, const double *x, int samples, struct traj_result *r,
                struct sga_error *err);
/* From now on what is evaluated often may become machine code. */
void flow_code(struct flow *f, const struct traj_request *rq);
/* The problem as the integrator sees it; field_slope_init has been called. From now on what is
 * evaluated often may become machine code. */
struct ode_problem flow_problem(struct flow *f, const struct traj_request *rq);

#endif
