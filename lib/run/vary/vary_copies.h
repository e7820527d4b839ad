/* Inside the vary folder: a motion that is differentiated, at values of its parameters. */
#ifndef SGA_RUN_VARY_COPIES_H
#define SGA_RUN_VARY_COPIES_H

#include "sweep_case.h"
#include "variation.h"

/* Copies of variables and derivatives; and, where events set something, of the variables alone, whose motion the others are carried by (they stay where they are). */
struct vary_copies {
    struct sweep_case c, own;
    struct traj_carried carried;
    bool has_own;
};

/* sys, sol and rq are what v was made of; parameter: values of the request's swept ones, in its store. False with err; vary_copies_clear is due in any case. */
struct vary_copied { const struct request *of; const struct sys_system *sys; const struct sga_solution *sol; const struct traj_request *rq; const expr_id *parameter; };
bool vary_copies_make(struct vary_copies *p, const struct variation *v, const struct vary_copied *from, struct sga_error *err);
void vary_copies_clear(struct vary_copies *p);

#endif
