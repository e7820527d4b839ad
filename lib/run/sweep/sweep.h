/* Inside the run folder: many trajectories of one analysis. */
#ifndef SGA_RUN_SWEEP_H
#define SGA_RUN_SWEEP_H

#include <stdbool.h>

struct job;
struct modes;
struct request_sweep;
struct sga_error;
struct sga_json;
struct sga_solution;
struct sys_system;
struct traj_request;
struct traj_result;

/* What a set with modes (of events, or switches that slide) needs of the floor above: modes.h, slides.h. */
struct sweep_modes {
    void *of;
    /* A set begins, of this system: the request that is followed; NULL with err. */
    const struct traj_request *(*set)(void *of, int set, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err);
    /* Its motion is there: one that comes further may take its place. */
    void (*further)(void *of, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r);
    void (*tell)(void *of);      /* its motion is there, */
    void (*unset)(void *of);     /* and its system ends */
    bool keeps;                  /* the job keeps what it is told */
};

/* Runs the members of the request's sweep, everything but the start as in `request`, into
 * j->sweep; A member without a trajectory says why; false where the job cannot go on. */
bool answer_sweep(struct job *j, const struct sga_solution *solution, const struct traj_request *request, struct sweep_modes modes);

/* What a member begins with, where parameters are swept: their values, and from which analysis (NULL: not said). A member that has an error. */
void sweep_write_set(const struct job *j, const struct request_sweep *m, const char *analysis, struct sga_json *w);
void sweep_write_error(const struct job *j, const struct request_sweep *m, struct sga_json *w, const struct sga_error *e);
/* The time ended before any set had what is wanted: false, with j->err. */
bool sweep_too_short(struct job *j);

#endif
