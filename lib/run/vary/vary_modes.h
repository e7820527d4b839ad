/* Inside the vary folder: the modes of a motion that is differentiated, each reduced, with the parameters as symbols, when the motion reaches it, and differentiated. */
#ifndef SGA_RUN_VARY_MODES_H
#define SGA_RUN_VARY_MODES_H

#include "vary_model.h"

struct job;
struct variation_by;
struct vary_at;
struct vary_copies;
struct vary_modes;

/* What all motions of these modes have in common. */
struct vary_modes_of {
    struct vary_model *model;          /* of the start; its rq, or that of an experiment: */
    const struct traj_request *rq;
    const struct request_open *open; int opens;      /* the parameters that are symbols */
    const struct variation_by *by; int directions;   /* by parameters of the model's store */
    int experiment;                    /* of the fit, whose columns are meant; -1: those of the trajectory */
};

/* NULL: events set no modes. `of` is copied; what it points to must outlive it. */
struct vary_modes *vary_modes_new(struct job *j, const struct vary_modes_of *of);
void vary_modes_free(struct vary_modes *m);
/* A motion begins, at `at`, whose start's copies are these: their request gets its modes. */
void vary_modes_start(struct vary_modes *m, const struct vary_at *at, struct vary_copies *start);

#endif
