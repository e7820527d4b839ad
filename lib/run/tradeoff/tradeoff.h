/* Inside the run folder: speed against accuracy, measured on the request's own system. */
#ifndef SGA_RUN_TRADEOFF_H
#define SGA_RUN_TRADEOFF_H

#include <assert.h>

#include "buf.h"
#include "dd.h"
#include "trajectory.h"

struct job;

/* Columns at the samples of one solution, with the digits that tell those of longer arithmetics apart. */
struct tradeoff_values {
    int rows, columns;
    num_dd *value;                /* rows x columns; malloced */
};

/* One method, arithmetic and tolerance. */
struct tradeoff_row {
    int series;                   /* rows of one method and arithmetic */
    const char *method;           /* static, or the request's */
    enum traj_arithmetic arithmetic;
    double rtol, atol;
    double seconds;               /* CPU of one solution, the least of several where it is short; or what was spent */
    long evaluations;             /* -1: not known */
    double residual;              /* NAN: it has no samples */
    bool finished;                /* it ended by itself: at the last time, or where the motion ends */
    bool ended;                   /* before the last time, and why; static text */
    double ended_t;
    const char *ended_reason;
    struct tradeoff_values values;
    bool compared;                /* with the best solution: the next four are known */
    double error;                 /* largest |value - best| over samples and columns; NAN where the best
                                   * solution's own error is not well below it */
    double error_at_most;         /* with what the best one's error may add */
    double digits;                /* that hold in every column, relative to the larger of its largest value and atol / rtol */
    double digits_most;           /* that can hold, as the best solution may be wrong */
    bool within;                  /* the request's own tolerances */
    bool beyond;                  /* surely not within them; neither: the best solution is not known well enough */
    char note[200];               /* why something is missing; "" */
};

/* The solution that errors are measured against. */
struct tradeoff_best {
    bool has;
    const char *method, *arithmetic;
    double rtol;                  /* that was asked of it; what is delivered is tighter */
    double error_estimate;        /* of its own */
    double *doubt;                /* by column: of it */
    double *size;                 /* by column: what digits are relative to */
    double *unit;                 /* by column: what atol is times */
    int row;                      /* of the table: the one solution less tight by the same means */
    bool ended;
    const char *ended_reason;
    struct tradeoff_values values;
};

enum { TRADEOFF_CHOICES = 6 };
/* The cheapest row for so many digits, 0: for the request's own tolerances. */
struct tradeoff_choice {
    int digits, row;              /* row -1: none is known to have reached it */
    bool none;                    /* and all are known not to have */
};

/* A method and arithmetic that refused, or was not gone on with for want of time. */
struct tradeoff_left_out {
    const char *method, *arithmetic;
    double from;                  /* the tolerance from which on time did not allow it; 0: it refused */
    bool not_begun;               /* and no row of it was tried */
    char reason[256];
};

struct tradeoff {
    struct tradeoff_row *row;
    int rows, cap;
    double moved;                 /* the start, to be consistent */
    double *unit;                 /* by column: what atol is times, as the first row had it; NULL: 1 */
    struct tradeoff_best best;
    struct tradeoff_left_out *left_out;
    int left_outs;
    bool busy;                    /* time on the clock ended the rows, before the CPU granted did */
    struct tradeoff_choice choice[TRADEOFF_CHOICES];
    struct sga_buf advice;
};

/* Runs the table into j->tradeoff (owned by the job): within CPU seconds that are a small part of the time that is
 * left, so that other load on the machine changes nothing until most of that time is over on the clock.
 * `request` as for a trajectory. False: there is no motion, or the job ended. */
bool answer_tradeoff(struct job *j, const struct sga_solution *solution, const struct traj_request *request);
void answer_tradeoff_clear(struct tradeoff *t);

/* Whether it keeps its rules: rows that choices and the best solution name are there, and an error is not above its own bound. */
bool tradeoff_sane(const struct tradeoff *t);

const char *tradeoff_arithmetic(enum traj_arithmetic a);

/* When a part shall be over, whichever comes first: CPU seconds of this thread, as sga_cpu() counts, and sga_now(). */
struct tradeoff_end {
    double cpu, wall;
};

/* The parts, in order. */
struct tradeoff_run {
    struct job *j;
    const struct sga_solution *solution;
    struct traj_request request;  /* with the samples thinned out */
    struct tradeoff *t;
    struct tradeoff_end rows_end, end;    /* of the rows, and of all */
};
/* Seconds that are left. */
double tradeoff_left(struct tradeoff_end end);
/* tradeoff_rows.c: the rows. */
bool tradeoff_rows(struct tradeoff_run *u);
/* tradeoff_solve.c: one solution, cut off after so many seconds of CPU; *err has the reason where false. */
bool tradeoff_solve(struct tradeoff_run *u, const struct tradeoff_row *row, bool single, double seconds,
                    struct traj_result *r, struct sga_error *err);
void tradeoff_keep(const struct traj_result *r, struct tradeoff_values *v);
/* What a solution gave; short ones are timed again, within so many seconds. */
void tradeoff_take(struct tradeoff_run *u, struct tradeoff_row *row, const struct traj_result *r, double seconds);
/* An entry of left_out. */
void tradeoff_leave_out(struct tradeoff *t, const struct tradeoff_left_out *l);
/* tradeoff_best.c: the best solution that the time allows, and each row's error against it. */
bool tradeoff_ends_well(bool ended, const char *reason);   /* where steps or time ended a motion, it is none to compare with */
bool tradeoff_best(struct tradeoff_run *u);
void tradeoff_errors(struct tradeoff *t, double rtol, double atol);
/* tradeoff_advice.c: choices and their text. */
void tradeoff_advice(struct tradeoff *t, double rtol, double atol);

#endif
