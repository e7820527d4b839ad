/* Trajectories on the final constraint submanifold: consistent start, gauge choice,
 * integration of the reduced field with projection, samples. */
#ifndef SGA_TRAJ_TRAJECTORY_H
#define SGA_TRAJ_TRAJECTORY_H

#include "expr.h"

struct num_jet_programs;
struct points_oracle;
struct sga_budget;
struct sga_solution;
struct sys_system;

struct traj_rate {
    int variable;
    expr_id rate;             /* its derivative: of variables and time */
};

/* What holds at the start. */
struct traj_relation {
    expr_id value;            /* of variables, time, and the symbols that stand for derivatives: 0 at the start */
    const char *text;         /* as it was given */
    const char *place;        /* JSON Pointer to it */
};

/* What an event assigns. */
struct traj_set {
    int variable;             /* or -1 - a mode's place */
    expr_id value;            /* of variables and time, as they are before the event */
};

struct traj_event {
    expr_id expression;       /* of variables and time: its zeros are looked for */
    int direction;            /* +1: up, -1: down, 0: any, touches too */
    bool stop;
    const struct traj_set *set; int sets;   /* 0: none (jumps.h) */
    bool turns;               /* of a surface of struct traj_modes: the motion comes to it, or its slide ends */
    bool sided;               /* switches that are modes are in it: beyond a surface it may be another function */
    bool from_flat;           /* the same, and its rate is 0 there too */
    bool from_zero;           /* in balls: it is 0 where a piece begins, exactly */
    int most;                 /* it acts so many times, and is not looked for from then on; 0: always */
};

/* Masses of coordinates: what impulses are shared by. */
struct traj_mass {
    const int *position, *velocity; int coordinates;   /* variables */
    const int *row, *col; const expr_id *value; int entries;
    bool impulses;            /* reactions are along the gradients of the constraints; otherwise no impulse is known */
};

struct traj_request;
struct enclosed_found;
struct enclosed_piece;

/* A system at certain values of its modes, reduced: events, samples and columns of `rq` are those of all others. */
struct traj_mode {
    const struct sys_system *sys; const struct sga_solution *sol; const struct traj_request *rq;
    const int *choice;        /* by mode: the place of its value */
    int place;                /* among those reached, which is 0 for the start */
    /* Where switches are modes (slide.h): what changes its sign at each surface, with other switches as they are here; the variable that stands for the
     * switch on a surface that the motion slides along, or -1. sol NULL: nothing can move here, for this reason. */
    const expr_id *surface;
    const int *sliding;
    const char *why;
};

/* The value of a mode that is a switch: on which side of its surface the motion is, or along it. */
enum { TRAJ_ABOVE, TRAJ_BELOW, TRAJ_ALONG, TRAJ_AS_WRITTEN };

struct traj_modes {
    int modes;
    const char *const *name;
    const double *const *value; const int *values;      /* by mode */
    const struct traj_mode *start;
    /* The one with these values, reduced where it is reached first: near x (variables of `from`) at time t. It stays where it is. NULL: err. */
    const struct traj_mode *(*enter)(void *ctx, const int *choice, const struct traj_mode *from, double t, const double *x, struct sga_error *err);
    /* Whether it is right where the motion goes on in it, at x on its final set. NULL: it is. */
    bool (*landed)(void *ctx, const struct traj_mode *mode, double t, const double *x, struct sga_error *err);
    /* Of modes that are switches: points of `from` at which the function of the surface is 0 are points of `to` as well, as algebra shows. NULL: it was not asked. */
    bool (*meets)(void *ctx, const struct traj_mode *from, const struct traj_mode *to, int surface);
    void *ctx;
    int surfaces;             /* modes are switches, so many, and none of them is set; 0: they are not. Of all modes of the motion: */
    int own;                  /* events of the request, which come first; then two for each surface: its function, and nothing (0 nowhere), or how far the switch of a
                               * slide is from 1, and from -1 */
};

/* One slide along a surface. */
struct traj_slide {
    int surface, mode;        /* mode: place of the mode in which it began */
    double from, to, error;   /* to: where the motion ended, if it was in it; error of both */
    int left;                 /* +1, -1: to this side; 0: the motion ended before */
    double least, most;       /* values of the switch, at samples and ends */
};

/* Where a piece of a motion begins, after an event that sets something. */
struct traj_leg {
    double t;
    int mode;                 /* place of its mode */
    const char *how;          /* what moved besides what is set; static */
    double moved;             /* the furthest that a variable with a derivative moved that was not set, by its size */
    double *impulse; int coordinates;   /* of the masses: M (v+ - v-); or NULL */
};

/* Of a system with derivatives among its variables (variation.h): what they do where the motion turns a switch. */
struct traj_turns {
    int base, directions;     /* variables of the motion, which come first, and how many derivatives of each follow */
    const expr_id *surface; int surfaces;   /* arguments of the motion's switches */
    const expr_id *slope;     /* surfaces x directions: their derivatives along each direction */
    const expr_id *rate;      /* by surface: its derivative along the motion */
    bool jumps;               /* the motion's field may jump, or its constraints bend, at one */
};

/* Of such a system, where events set something: derivatives along each direction (events and what they set are those of its request). */
struct traj_slopes {
    int base, directions;     /* as above */
    const expr_id *event;     /* events x directions */
    const expr_id *set;       /* what is set, event by event, x directions */
    const expr_id *mass;      /* entries of the masses x directions */
};

/* Of such a system, in balls: what its start is. Either given values are what they are, exactly, and the rest follows (held ones determine it); or the motion's start is
 * the point nearest to values of its own, which come first in exact_initial, before their derivatives. */
struct traj_asked {
    bool nearest;
    bool known;               /* constraints of held values alone are known to hold: they are not asked for a proof */
    int base, directions;     /* as above */
    const double *initial, *unit; const unsigned char *given, *held;   /* nearest; base each: as of struct traj_request; by variable what a distance of 1 is */
};

/* Of a motion with events that set something, which is differentiated (jump_slope.h): its pieces are those of this system of variables and derivatives, whose
 * columns are the answer's. */
struct traj_carried { const struct sys_system *sys; const struct sga_solution *sol; const struct traj_request *rq; };

/* An event that happened. */
struct traj_happening {
    int event;
    int direction;            /* as above; 0: touched */
    double t, error;          /* error: estimated; INFINITY where not known */
    bool undecided;           /* ball: it is not shown whether there is one, within the error of t */
};

/* Where a motion went on with another reduction, whose pivots are large there. */
struct traj_chart {
    double t;
    char *pivot;              /* that had become small in the reduction before; malloced */
};

/* A singular position that the motion passed (crossing.h). */
struct traj_passed {
    double t;
    char *detail;             /* a sentence; malloced */
};

/* How far a function went from its value at the start, over the samples. */
struct traj_drift {
    double start, end;        /* values there */
    double largest, t;        /* the largest distance, and where; INFINITY where the function has no value */
};

/* What a solution is computed in. AUTO: the cheapest that reaches the tolerances. */
enum traj_arithmetic { TRAJ_AUTO, TRAJ_DOUBLE, TRAJ_DOUBLE_DOUBLE, TRAJ_BALL };

struct traj_request {
    double start;
    const double *times; int samples;      /* ascending from start, or descending */
    const double *initial;                 /* by variable: the guess; 0 where not given */
    const unsigned char *given;            /* by variable: 1 where the request gave it */
    const unsigned char *held;             /* by variable: the projection must not move it */
    const struct traj_relation *relation; int relations;
    const int *rate_symbol;                /* by variable: the symbol that is its derivative in the relations, or -1; NULL where there are none */
    const double *low, *high;              /* by variable: where the start must lie; NULL: anywhere */
    const double *on;                      /* by variable: a point of the component that the answer is about, or NULL */
    const struct traj_rate *rate; int rates;
    bool conditions;                       /* gauge conditions are among the system's rows (for the name of the choice) */
    const expr_id *output; int outputs;    /* 0: all variables */
    const expr_id *valued; int valueds;    /* functions without a value the motion has none either: it ends where one loses it */
    const unsigned char *beside;           /* by output: a root, whose value near 0 is not known as well as its argument: no reason for a tighter solution; or NULL */
    const struct traj_event *event; int events;
    const struct traj_modes *modes;        /* NULL: there are none */
    const struct traj_mass *mass;          /* NULL: there is none */
    const signed char *event_side;         /* as ode_problem's: the motion goes on from an event; or NULL */
    const expr_id *integral; int integrals;   /* functions that should stay what they are at the start */
    double rtol, atol;
    bool own_atol;                         /* atol was asked for: it is meant as it is; otherwise in units of natural sizes (sizes.h) */
    const char *method;                    /* NULL or "auto": chosen */
    double rows_until;                     /* sga_now() value at which a motion ends with the rows it has, if these are more than its start; 0: time that ends is a
                                            * failure */
    enum traj_arithmetic arithmetic;
    /* Where the arithmetic carries more than a double: constants of the store, by variable
     * (EXPR_UNDEF: not given) and by sample. NULL: the doubles are meant exactly. */
    expr_id exact_start;
    const expr_id *exact_initial, *exact_time;
    const struct traj_turns *turns;        /* NULL: none of the variables is a derivative */
    const struct traj_slopes *slopes;      /* the same, of events that set something */
    const struct traj_asked *asked;        /* NULL: none of the variables is a derivative, or it is not asked for in balls */
    const struct enclosed_found *found;    /* in balls: what a start that was searched for is (enclosed.h); or NULL */
    struct enclosed_piece *piece;          /* in balls: it is a piece of a motion (enclosed.h); or NULL */
    const struct traj_carried *carried;    /* NULL: pieces are the motion's own */
    const struct traj_request *sized_by;   /* of a later piece of a motion: the request that natural sizes are those of; NULL: its own */
    bool ends_there;                       /* singular positions are not passed */
    bool no_motion;                        /* only a start is looked for: what would jump later is no matter */
    bool single;                           /* one solution at the tolerances as they are: no estimate of its error */
    const struct sga_budget *budget;
    struct num_jet_programs *programs;     /* machine code of the motions of one system, kept from one to the next (jet.h); or NULL */
};

struct traj_result {
    double *initial;          /* by variable: the consistent start */
    double moved;             /* scaled distance from the guess */
    double *relation; int relations;   /* residuals of the request's relations at the start */
    int rows, columns;        /* columns without time */
    double *t, *value;        /* rows; rows x columns */
    double *error;            /* by row: estimated global error, largest over the columns; or NULL */
    double error_estimate;    /* largest of all */
    double *column_error;     /* by column: the largest of its errors; or NULL */
    double *unit;             /* by column: what atol was times; NULL: all 1 */
    struct traj_happening *happening; int happened;   /* in the order of the motion */
    double *happened_value;   /* happened x columns */
    expr_id *held_argument; signed char *held; int helds;      /* by switch of the equations: what it is the sign of, and the side that it was held on at the end; 0: it was not */
    char **happened_digits;   /* as digits below: happened x (1 + columns), time first; or NULL */
    struct traj_drift *drift; /* by integral of the request; NULL: not computed */
    int ended_event;          /* that stopped it, or -1 */
    bool rounded;             /* it ended where roundings of double had grown, for them perhaps: longer numbers tell */
    bool out_of_time;         /* rows_until has come, or the motion ended for it */
    const char *shortfall;    /* why estimates exceed rtol |value| + atol somewhere, static; NULL where none does */
    bool beside;              /* only columns that the request calls so do: longer numbers are not tried */
    double residual;          /* largest |constraint| over the samples, each scaled by its gradient */
    /* Where the arithmetic carries more than a double: the rows again, rows x columns decimal
     * texts with all digits that `error` leaves (malloced, each its own; NULL: not a number). */
    char **digits;
    double *radius;           /* ball: rows x columns, |true - value written| is at most this; or NULL */
    const char *arithmetic;   /* "double", "double-double", "ball"; static */
    const char *method;
    bool inputs_examined;     /* functions of time were searched for narrow features everywhere (inputs.h), or there are none */
    bool ended;               /* before the last time */
    double ended_t, ended_error;   /* the error is estimated; 0: not known */
    const char *ended_reason;
    char ended_detail[256];
    const char *gauge;        /* how the motion was chosen, see traj_gauge_text; static */
    const char *gauge_numeric; /* why that is solved from the equations at each evaluation, not by expressions; static; NULL: it is not */
    struct traj_leg *leg; int legs;        /* of motions with events that set something */
    struct traj_slide *slide; int slides;  /* in the order of the motion */
    struct traj_chart *chart; int charts;   /* in the order of the motion; of the last of the solutions that were compared */
    bool stratum;             /* ended where the rank of the equations drops */
    struct traj_passed *passed; int passes;   /* in the order of the motion */
    long steps, rejected, evaluations;
    double seconds;           /* CPU of the integration alone, without what is set up before it */
};

/* A consistent start as a result of its own. */
struct traj_initial {
    double *x;                /* by variable: on Pf, nearest to the guess */
    double *derivative;       /* by variable: X there (with the gauge choice asked for) */
    double *residual;         /* by constraint: its value at x */
    int *free; int frees;     /* variables whose start can be chosen: coordinates of Pf near x */
    double moved;             /* scaled distance over which given values moved */
    double *relation; int relations;   /* residuals of the request's relations */
    const char *gauge;        /* as in struct traj_result: of the derivative */
};

/* The name of a gauge choice: "none", "rates", "conditions", "conditions and rates", each with ", then least norm"
 * where freedom is left to it, or "least norm" alone. */
const char *traj_gauge_text(bool conditions, bool rates, bool least_norm);

/* False with err INITIAL: which constraint stays unsatisfied, and by how much. */
bool traj_consistent(const struct sys_system *system, const struct sga_solution *solution,
                     const struct traj_request *request, struct traj_initial *result, struct sga_error *err);
void traj_initial_clear(struct traj_initial *result);

/* Whether some event sets something, or is a turn: the motion is made of pieces between events. */
bool traj_in_pieces(const struct traj_request *request);
/* Tolerances that double does not reach, of values that are known beyond it. */
bool traj_beyond_double(const struct traj_request *request);

/* The whole trajectory. False with err where there is none; blow-up and the like are
 * results (`ended`). */
bool traj_run(const struct sys_system *system, const struct sga_solution *solution,
              const struct traj_request *request, struct traj_result *result, struct sga_error *err);
void traj_result_clear(struct traj_result *result);
/* Whether and where it ends, and why, becomes what it is for another; not its event. */
void traj_take_end(struct traj_result *result, const struct traj_result *from);
/* It is what errors have grown to that ends it: reason "tolerance", at a time that is not known. */
void traj_end_by_errors(struct traj_result *result);
/* Invariants of a result for this request (linear cost). */
bool traj_result_sane(const struct traj_request *request, const struct traj_result *result);

#endif
