/* Inside the ask folder: linearizations at the places of a request, for who needs them. */
#ifndef SGA_RUN_ASK_WORK_H
#define SGA_RUN_ASK_WORK_H

#include "arena.h"
#include "buf.h"
#include "linear_write.h"

struct job;
struct sga_error;
struct request_initial;
struct request_ports;

struct ask_work {
    struct job *j;
    struct linear_request rq;
    struct linear_ports ports;
    struct sga_json json;      /* what is written */
    struct sga_arena mem;      /* ended by the owner */
    char why[160];             /* a way that was tried first does not go; "" */
    /* With each linearization. anywhere: the request does not say where. */
    bool (*take)(struct ask_work *s, const struct linearization *l, bool anywhere);
};

/* Inputs as they were named, or the variables that the form calls inputs; outputs as they were given, or the form's. */
void ask_begin(struct ask_work *s, struct job *j, const struct request_ports *p, struct sga_buf *out);
/* Whether the equations leave variable k to be chosen as a function of time, perhaps in part. */
bool ask_is_free(const struct job *j, int k);
/* Of inputs that the request did not name, those that the equations determine are none (constraints of form control). */
void ask_drop_determined(struct ask_work *s);
/* False where nothing can be linearized: NO_MOTION. */
bool ask_possible(struct job *j);
/* As linearize, with pivots that are large at the point where the solution's vanish there. */
bool ask_linearize(struct ask_work *s, struct linearization *l, const struct linear_guess *guess, struct sga_error *err);
/* At the consistent start from these values; at the start of the trajectory (or anywhere, where there is none); along it. */
bool ask_at_values(struct ask_work *s, double time, const struct request_initial *initial, int count, bool anywhere);
bool ask_at_start(struct ask_work *s);
bool ask_at_samples(struct ask_work *s);

#endif
