/* Inside the ode folder: the state of one solution in progress. */
#ifndef SGA_ODE_MARCH_H
#define SGA_ODE_MARCH_H

#include "control.h"
#include "guard.h"
#include "method.h"

/* Why a step was not taken. */
enum ode_refusal { STEP_TAKEN, ERROR_TOO_LARGE, NOT_SOLVED, FIELD_REFUSED, MANIFOLD_REFUSED,
                   STEP_CUT /* to be made shorter, by kink.c */, ENDED /* res->end is set */ };

/* Explicit or implicit? Kept by switch.c. */
struct ode_choice {
    bool free;                      /* the method may change */
    const struct ode_method *explicit;   /* the one of Runge-Kutta for these tolerances */
    void *explicit_state, *implicit_state, *series_state;
    long series_at;                 /* steps at which Taylor series are (again) tried; -1: never */
    long series_wait;               /* steps between tries */
    long series_steps;              /* made with them */
    double h;                       /* average size of explicit steps lately */
    double cost;                    /* of an implicit step lately, in evaluations */
    int stiff;                      /* explicit steps of late that stability has set the size of */
    int enough;                     /* such steps before the implicit method is tried */
    long try_at;                    /* steps at which it is tried anyway */
    long since;                     /* steps at which explicit ones took over again: it may be stiff soon once more; 0: never */
    long back_at;                   /* steps at which the explicit one is thought of */
};

/* One solution to be computed. */
struct ode_run {
    const struct ode_problem *p;
    const struct ode_start *start;
    struct ode_options o;           /* with the tolerances of this solution */
    const double *unit;             /* never NULL */
    bool series;                    /* auto takes Taylor series: by the tolerance asked for, so that the
                                     * solutions that are compared come by the same methods */
    int level;                      /* of several: later ones take more steps to a sample */
    bool beside;                    /* start and field are wrong by a rounding, on purpose, */
    const double *noise;            /* the field by so many; NULL: one */
    bool accompanied;               /* the solution less a looser one is wanted with it (companion.h) */
};

/* Corrections that do not shrink with the steps. */
struct ode_grain {
    double moved; int still, same;  /* by the last refused one; how many were as large as the one before, and of these how many no larger than is put up with */
    double allowed;
};

struct ode_companion;

struct ode_march {
    const struct ode_problem *p;
    const struct ode_start *start;
    const struct ode_options *o;    /* with the tolerances of this solution */
    const double *unit;             /* never NULL */
    int level;
    bool beside, series;
    struct ode_result *res;
    const struct ode_method *method;
    void *state;                    /* the method's */
    struct ode_choice choice;       /* between methods, for "auto" */
    struct ode_field field;
    struct ode_control control;
    struct ode_step step;
    double direction, stop;
    int next_break;                 /* of p->breaks: the first that lies ahead */
    int next_piece;                 /* of p->piece: the one where the motion is */
    double piece;                   /* distance from break to break, where there are any; else INFINITY */
    double error;                   /* of the last step, against what it had to meet */
    double errors;                  /* of all steps before, each in units of what it was allowed, */
    double erred;                   /* and with what iterations leave at the most, not what they are allowed */
    bool dense_checked;             /* in this step */
    double dense_ratio;             /* by what steps are shorter that samples may lie inside of */
    /* The present point: time as an unevaluated sum, state with what rounding dropped. */
    double t, t_low;
    double *x, *carry, *f;
    /* The point that the present step leads to. */
    double t1, t1_low;
    double *x1, *carry1, *f1;
    double *dx, *scale, *work;      /* work: 2 n */
    double *last;                   /* the state at last_times[1], where a step was made */
    double *memory;
    int next;                       /* the first sample not yet delivered */
    struct ode_watch *watch;        /* event.c's; NULL: no events */
    struct ode_kinks *kinks;        /* kink.c's; NULL: no switches */
    struct ode_bands *bands;        /* band.c's; NULL: none */
    struct ode_companion *companion;    /* NULL: none */
    bool stopped;                   /* by an event in the present step */
    struct ode_grain grain;         /* settle.c */
    double pending_residual;        /* of samples in the present step */
    double moved;                   /* by the last projection */
    enum ode_reason manifold_why;   /* of the last refusal by `project` */
    bool field_refused;             /* ever, and from which time last */
    double field_refused_t;
    bool late;                      /* errors are those of rounded times (late.c) */
    double start_size, start_rate;  /* largest |x_j|/unit_j and |x'_j|/unit_j at the start */
    long manifold_refused;          /* steps */
    double last_times[2];           /* of the two accepted points before the present one */
    /* Attempts at which the clock is looked at next; when that was done last. */
    long budget_at;
    double budget_looked, begun;
    /* Is there hope to arrive? Looked at every so many attempts (reach.c), last at look_at. */
    long look_at;
    double look_t, look_progress;
    int hopeless;                   /* looks in a row that saw none, */
    double slow_since;              /* from this time on */
    long pile_at;                   /* the last look at whether steps pile up, and where it was */
    double pile_t;
};

/* reach.c: before an attempt; after a failure, which may be the budget's. False: ended. */
bool ode_may_go_on(struct ode_march *m);
bool ode_within_budget(struct ode_march *m);

/* inside.c: by how much sample k of r may be off for lying inside a step, by column of y (its outputs), into e. */
void ode_inside(const struct ode_run *run, const struct ode_result *r, int k, const double *y, double *e);

/* switch.c: see ode_run.series. */
bool ode_takes_series(const struct ode_problem *p, const struct ode_options *o);
/* driver.c: one solution. Fills *res, whatever it held; error, max_error, worst say that
 * nothing is known. */
void ode_march(const struct ode_run *run, struct ode_result *res);
/* global.c: several solutions, the last one with estimates of its error. */
void ode_global(const struct ode_run *run, struct ode_result *res);

/* driver.c: of all steps with the present one; what iterations of implicit steps leave is not in their estimates: as much as a step is allowed to leave, or as much as they do. */
double ode_errors(const struct ode_march *m);
double ode_erred(const struct ode_march *m);

/* settle.c: x, meant for time t, is projected. False: refused, or moved by more than
 * `most` units of its error (and some roundings); manifold_why is set. */
bool ode_settle(struct ode_march *m, double t, double *x, double most, double *residual);
/* How far a step's end may be moved, its error estimate being this. */
double ode_settle_most(const struct ode_march *m, double error);

/* switch.c: after an accepted step, whose successor would have size h. Changes the method
 * where another makes more way for its work, and then returns another size. */
void ode_choice_begin(struct ode_march *m);
double ode_choose(struct ode_march *m, double h);
/* The present method is the Taylor one, which has no series here, and another may take over. */
bool ode_without_series(struct ode_march *m);
void ode_choice_end(struct ode_march *m);
/* The step's fields set for a step of signed size h from the present point. */
void ode_prepare_step(struct ode_march *m, double h);

/* driver.c: where the present step has to end at the latest. */
double ode_goal(const struct ode_march *m);
/* sane.c: invariants between steps (constant cost); of the sides, of a result for these times (linear cost). */
bool ode_march_sane(const struct ode_march *m);
bool ode_kinks_sane(const struct ode_kinks *k);
bool ode_result_sane(const struct ode_start *start, const struct ode_result *r);

/* settle.c: after a step that was refused because its end was moved too far. */
void ode_settle_refused(struct ode_march *m);
/* Corrections of refused steps do not shrink with these. */
bool ode_settle_trembles(const struct ode_march *m);
/* sample.c: a sample lies inside the present step. */
bool ode_sample_inside(const struct ode_march *m);
/* sample.c: samples inside the present step and at its end are put into the result,
 * each projected; *through: how many are complete then. */
enum ode_refusal ode_sample(struct ode_march *m, int *through);

/* kink.c: around the march; the sides at the start (x, f and a first step h are known; f may change), false: ended;
 * after an attempt, x1 and f1 being known: does the step pass a kink? STEP_TAKEN, or STEP_CUT, FIELD_REFUSED, ENDED; after
 * a commit, h being the size of the next step: switches are turned, false: ended; h, cut to end at a kink. */
void ode_kinks_begin(struct ode_march *m);
bool ode_kinks_start(struct ode_march *m, double h);
enum ode_refusal ode_kinks_step(struct ode_march *m);
bool ode_kinks_pass(struct ode_march *m, double h);
/* The motion passed a break, and is at it: switches whose arguments jump there are turned, at a time that nothing moves, and the field is evaluated on
 * the new sides. False: ended. And then, the field being known: what the next step begins with. */
bool ode_kinks_enter(struct ode_march *m);
void ode_kinks_look(struct ode_march *m);
double ode_kinks_cut(const struct ode_march *m, double h);
void ode_kinks_end(struct ode_march *m);
/* Switches were turned at the present point. */
bool ode_kinks_turned(const struct ode_march *m);
/* Whether a switch is to turn at the present step's end. */
bool ode_kinks_turn_ahead(const struct ode_march *m);
/* After a refusal of a step of size h: true, it may be tried with nothing held. And then: all is held again. */
bool ode_kinks_natural(struct ode_march *m, enum ode_refusal cause, double h);
void ode_kinks_held(struct ode_march *m);

/* band.c: around the march; after an attempt, x1 and f1 being known: does the step pass a pulse? STEP_TAKEN, STEP_CUT or
 * FIELD_REFUSED; after a commit; h, cut to end in one. */
void ode_bands_begin(struct ode_march *m);
enum ode_refusal ode_bands_step(struct ode_march *m);
void ode_bands_pass(struct ode_march *m);
double ode_bands_cut(const struct ode_march *m, double h);
void ode_bands_end(struct ode_march *m);

/* late.c: the error of the step just attempted is what rounded times make. */
bool ode_late_error(struct ode_march *m);
/* *late: the start and the samples by two roundings of time later, where time is far from 0 and its ends are not the ends of
 * something; its times are the caller's to free. Else false. */
bool ode_late_start(const struct ode_run *run, struct ode_start *late);
bool ode_is_late(const struct ode_run *run);       /* the same, and no more */

/* way.c: the present step as a way of functions of time and state (guard.h). Begun once, made ready for each step after dense_begin. */
struct ode_way {
    struct guard_way way;
    struct ode_march *m;
    void (*function)(void *ctx, double t, const double *x, double *g);
    double *x;                 /* n: the state where they were asked for last */
};
void ode_way_begin(struct ode_way *w, struct ode_march *m, int count, void (*function)(void *, double, const double *, double *));
const struct guard_way *ode_way_ready(struct ode_way *w);
void ode_way_end(struct ode_way *w);
/* Whether the problem goes on along the present step (ode_problem.along). */
bool ode_goes_on_along(struct ode_march *m);
/* Of a value's size: what does not tell from 0 where a motion goes on. Where steps have erred by less than is allowed (straight motions), so may what depends on
 * them: times the sum of their errors. */
#define ODE_TOLD (16 * DBL_EPSILON)
#define ODE_ERRORS 4.0

/* event.c: around the march; the start (x is set); after ode_sample: the events in the present
 * step are put into the result, and samples past one that stops are taken back. */
void ode_watch_begin(struct ode_march *m);
void ode_watch_start(struct ode_march *m);
void ode_watch_end(struct ode_march *m);
enum ode_refusal ode_watch_step(struct ode_march *m, int *through);
void ode_end_event(struct ode_march *m);

/* ending.c: fills res->end. */
void ode_end_at(struct ode_march *m, enum ode_reason reason, const char *detail);
void ode_end_refused(struct ode_march *m, enum ode_refusal cause);
/* It is what errors have grown to that ends solutions. */
void ode_end_by_errors(struct ode_end *end);
/* After a step that the field refused: whether it ends for good just beyond the present point, and no sample lies between. Where the motion has been it does not
 * end. True: the end is set. */
bool ode_is_over(struct ode_march *m);
/* The derivative, over the time passed, is far beyond the size, and beyond what it was at the start. */
bool ode_grows(const struct ode_march *m);
void ode_end_steps(struct ode_march *m, bool foreseen);
double ode_largest(const struct ode_march *m, const double *v, int *which);

#endif
