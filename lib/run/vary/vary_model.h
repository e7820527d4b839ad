/* Inside the vary folder: the request's system reduced with some of its parameters as symbols, and its motion asked of it. */
#ifndef SGA_RUN_VARY_MODEL_H
#define SGA_RUN_VARY_MODEL_H

#include "oracle.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "trajectory.h"

struct vary_model {
    struct request request;          /* read anew, the parameters being swept ones of no set */
    struct job job;                  /* that reduces it */
    struct sga_solution conditioned; struct points_oracle oracle;   /* with gauge conditions among the rows */
    bool read, has_conditioned;
    const struct sga_solution *solution;   /* of the two */
    struct traj_request rq;          /* of the whole; its lists are in the job's arena. exact_initial: with the parameters as symbols */
    struct num_jet_programs *programs;     /* machine code of its motions, kept from one to the next */
};

/* Reads and reduces. m->rq has events and masses where events set something. j: the job that asks; what is not there is refused at `pointer`. False with j->err. vary_model_clear is due in any case. */
bool vary_model_make(struct vary_model *m, struct job *j, const struct request_open *open, int opens, const char *pointer);
/* The system with its modes at these values (by mode the place of one), reduced near the values x of the variables of `from` that have their names, at time t; with these
 * parameters as symbols. Its verdict may be any; texts are made as far as j wants them, where no parameter is open. m->rq has neither events nor masses. vary_model_clear is
 * due in any case. */
struct vary_mode { const int *choice; const struct sys_system *from; double t; const double *x; const struct request_open *open; int opens; };
bool vary_model_mode(struct vary_model *m, struct job *j, const struct vary_mode *mode);
/* Columns that were not named are the variables of the start's system. False with err: this one, with its modes at `text`, does not have them. */
bool vary_model_columns(struct vary_model *m, const struct sys_system *start, const char *text, struct sga_error *err);
void vary_model_clear(struct vary_model *m);
/* The derivative of each initial value that rq gives (variables; in the request's store) by a swept parameter (its symbol), or by itself (parameter -1). */
void vary_model_guess(struct vary_model *m, const struct traj_request *rq, int parameter, int variable, expr_id *to);

#endif
