/* Inside the vary folder: a model's motion and its derivatives at values of the parameters. */
#ifndef SGA_RUN_VARY_MOTION_H
#define SGA_RUN_VARY_MOTION_H

#include "variation.h"
#include "vary_model.h"

struct sga_arena;
struct vary_modes;
struct vary_slides;

struct vary_motion {
    struct traj_result result;       /* columns: derivatives by output and direction, then the outputs */
    double *slope_error;             /* rows x columns: what the start's own error makes of them; NULL: the start is known to all digits */
    bool exact_start;                /* the derivatives of the start are solved for; otherwise they are differences */
};

/* rq: what the variation was made of; parameter: values of the swept ones, in the request's store; initial: by variable of the whole, NULL: rq's; x: the start of
 * the motion there; modes, slides: NULL where there are none. False with err. The result is cleared by vary_motion_clear. */
struct vary_at { const struct traj_request *rq; const expr_id *parameter; const double *initial; const double *x; struct vary_modes *modes; struct vary_slides *slides; };
bool vary_motion_run(struct vary_motion *to, struct vary_model *m, struct variation *v, const struct vary_at *at, struct sga_error *err);
void vary_motion_clear(struct vary_motion *v);

/* vary_start.c. The start at these values, by variable of the whole: initial values are rq's at the parameters; at->initial has those that rq gives and has no expression
 * for. given (NULL, or by variable): gets the values that it was looked for from. */
bool vary_start_at(struct vary_model *m, const struct vary_at *at, double *x, double *given, struct sga_error *err);
/* unit, by variable: as variation_units. False: as there. */
bool vary_start_units(struct vary_model *m, const struct vary_at *at, double *unit, struct sga_error *err);
/* unit, directions x variables of the whole: natural sizes of derivatives, those of variables over those of what they are taken by. False: as there. */
bool vary_slope_units(struct vary_model *m, const struct variation_by *by, int directions, const struct vary_at *at, double *unit, struct sga_error *err);
/* The derivatives (directions x variables) of the start x at these values, and how far they may be off; *exact: by the conditions of a nearest point, otherwise by differences of
 * starts. False: INITIAL with err: it has none. */
bool vary_start_slopes(struct vary_model *m, const struct variation_by *by, int directions, const struct vary_at *at, double *slope, double *off, bool *exact, struct sga_error *err);

#endif
