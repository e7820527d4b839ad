/* Inside the vary folder: a fit as a problem of least squares. */
#ifndef SGA_RUN_FIT_WORK_H
#define SGA_RUN_FIT_WORK_H

#include "arena.h"
#include "error.h"
#include "least_squares.h"
#include "vary_motion.h"

/* One experiment: its motion and where its data stand. */
struct fit_experiment {
    const struct request_experiment *data;
    struct traj_request rq;
    struct variation variation;
    struct vary_modes *modes;      /* or NULL, */
    struct vary_slides *slides;    /* like these */
    bool varied;
    double *time; int times;       /* each once, in the order of the motion */
    int *place;                    /* by time of the data: which of these */
    int first;                     /* unknown: the first initial value of this experiment */
    double *initial, *x;           /* by variable: what the start is looked for from, and the start */
};

struct fit_work {
    struct job *j;
    const struct request_open *open;   /* the parameters */
    struct vary_model model;
    const struct request_fit *fit; /* of the model's request */
    struct fit_experiment *experiment;
    int unknowns, data, measured;  /* data: functions; measured: those that are */
    double *low, *high, *guess;    /* by unknown: parameters, then initial values by experiment */
    double noise;                  /* what the last values cannot be told from: estimated where that was asked for */
    bool estimate;                 /* errors are estimated */
    double *sample;                /* by data: the motion's value, where it is kept; or NULL */
    int lost;                      /* the experiment whose motion could not be had last, */
    struct sga_error why;          /* and why */
    struct sga_arena mem;
};

/* False with j->err. fit_work_end is due in any case. */
bool fit_work_begin(struct fit_work *w, struct job *j);
void fit_work_end(struct fit_work *w);
/* As fit_problem.value. */
bool fit_work_value(void *work, const double *x, double *r, double *J);
bool fit_work_goes_on(void *work);
/* The same once more at x, with estimates of errors: w->noise. */
bool fit_work_estimate(struct fit_work *w, const double *x, double *r, double *J);

#endif
