/* Inside the traj folder: trajectories in double-double arithmetic (about 30 digits).
 *
 * Taylor series of the reduced field in double-double, or implicit steps where it is stiff
 * (precise_march.h), each step and each sample projected onto the final set by Newton steps
 * whose residuals are double-double (so that factors in double suffice), from a start in exact
 * values; solved twice and more, for the estimate of the error, as lib/ode does. Ranks, pivots
 * and domains are watched in double on the way. */
#ifndef SGA_TRAJ_PRECISE_H
#define SGA_TRAJ_PRECISE_H

#include "jet.h"
#include "ode.h"

struct field;
struct flow;
struct knots;
struct traj_request;
struct traj_result;
struct precise_turn;

/* What each solution may take. */
struct precise_limits {
    long steps;
    double work;               /* in multiplications in double-double, some nanoseconds each; INFINITY: no limit */
};

struct precise {
    struct flow *flow;
    const struct sys_system *sys;
    const struct sga_solution *sol;
    const struct traj_request *rq;
    int n;
    struct num_jet2 *constraint, *output;     /* values only; output NULL: the variables */
    struct num_jet2 *series; int order;       /* of the field, from */
    struct num_tape *field;                   /* with the arguments of the switches after it */
    struct num_jet2 *values;                  /* of the field: its values alone, for implicit steps; NULL at first */
    struct num_jet2 *event, *velocity;        /* of the events, to order 1; of the field; NULL: no events */
    struct precise_chart *chart; int charts, at;      /* by chart: what is not in use of the members above; the one in use */
    struct precise_turn *turn;                /* NULL: no derivatives that jump with switches */
    struct num_radau *formula;                /* of the last implicit steps; NULL at first */
    num_dd start, *time, *x;                  /* the samples' times; the consistent start */
    struct knots *knots; num_dd *knot;        /* of the tables, and their times */
    int solution;                             /* which is made, from 0 */
    struct precise_limits limits;
};

/* Of another chart of the flow (charts.h): the members of the same names. */
struct precise_chart {
    struct num_jet2 *constraint, *series, *values, *velocity;
    int order;
    struct num_tape *field;
};

/* An event that happened. */
struct precise_event {
    int event, direction;      /* as struct traj_happening has them */
    num_dd t, *x;              /* the state there */
    double error, floor;       /* floor: what rounding leaves of it */
};

/* One solution. */
struct precise_path {
    int count;                 /* samples there are */
    num_dd *sample;            /* count x n */
    enum ode_reason reason;
    double t, left;            /* of the end; as in struct ode_end */
    char detail[256];
    double residual;           /* the largest |xi_i| at a sample */
    long steps, refused, evaluations;
    const char *method;        /* that made the steps; static */
    struct precise_event *event; int events; size_t event_cap;
    signed char *held;         /* by switch of the field: the side that it was held on at the end; or NULL */
    int kept;                  /* events of the steps that were taken */
};

/* precise_point.c. The values of the request's exact constants: p->start, p->time, and x set to
 * the consistent start in double-double. False: err says why it is not known to more digits
 * than a double's. */
bool precise_start(struct precise *p, const double *x, struct sga_error *err);
/* x is moved onto the set at t, by the least correction in units of scale (n; NULL: 1) that leaves held
 * variables; *moved: root mean square of it; *residual: the largest |xi_i|. */
bool precise_project(struct precise *p, num_dd t, num_dd *x, const double *scale, const unsigned char *held,
                     double *moved, double *residual);
/* Constraint values at x, to this order of their jets (p->constraint); false where they are not finite. Coefficient 1 of the inputs is as it was. */
bool precise_residuals(struct precise *p, num_dd t, const num_dd *x, int order);
/* J (c x n) in units of scale, held columns (NULL: none) 0, by a directional derivative for each column. */
bool precise_jacobian(struct precise *p, num_dd t, const num_dd *x, const double *scale, const unsigned char *held, num_dd *J);

/* precise_charts.c. The tape of the flow's field with the arguments of its switches; the field's own where there are none, or NULL. */
struct num_tape *precise_field(struct precise *p);
/* The flow may have gone over to another chart: the members follow. True: they did. */
bool precise_follow_chart(struct precise *p);
void precise_charts_clear(struct precise *p);

/* precise_march.c. beside: start and field are wrong by a rounding, on purpose. */
void precise_march(struct precise *p, double rtol, double atol, bool beside, struct precise_path *path);
/* precise_path.c. Events from this one on are not told. */
void precise_forget_events(struct precise_path *path, int events);
/* Frees the path's lists; the errors of a's events by those of b, which was solved less tightly: the largest
 * over what is allowed, touches left out, which have no time as sharp as the tolerances. */
void precise_path_clear(struct precise_path *path);
/* Events beyond t, in the direction of the motion, are not told. */
void precise_drop_events(struct precise_path *path, double t, double direction);
double precise_event_errors(const struct precise *p, struct precise_path *a, const struct precise_path *b, double factor);

/* precise_radau.c. Implicit steps can be made: not where Jacobians are too large to be factored for all stages. */
bool precise_radau_possible(const struct field *f);

/* precise.c. The consistent start of a request in double-double (x: n). False: err, as precise_start. */
bool precise_place(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, num_dd *x, struct sga_error *err);
/* All digits that the error leaves; malloced. */
char *precise_digits(num_dd v, double error);
/* precise.c. May it be tried? (A field given by expressions.) *why: if not. */
bool precise_possible(const struct flow *f, const struct traj_request *rq, const char **why);
/* Fills the samples, events, errors and endings of r (r->initial, r->moved are known). False: err. *reason: of its end. */
bool precise_run(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                 struct precise_limits limits, enum ode_reason *reason, struct traj_result *r, struct sga_error *err);

#endif
