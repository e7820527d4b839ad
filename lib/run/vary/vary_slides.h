/* Inside the vary folder: the switches of a motion that slides and is differentiated, as modes: each reduced, with the parameters as symbols, when the motion may come to it, and
 * differentiated. */
#ifndef SGA_RUN_VARY_SLIDES_H
#define SGA_RUN_VARY_SLIDES_H

#include "vary_model.h"

struct vary_at;
struct vary_copies;
struct variation_by;
struct vary_slides;
struct traj_request;

/* rq: the motion's request, of the model's system; it gets the surfaces among its events, and must stay where it is. *out NULL: the job j did not ask for slides, or nothing
 * jumps. by: of the model's store, borrowed, like the rest; vary_slides_free is due before vary_model_clear. False with j->err. */
bool vary_slides_new(struct job *j, struct vary_model *model, struct traj_request *rq, const struct variation_by *by, int directions, struct vary_slides **out);
/* A motion at other values may begin: what was made for the last one ends; reductions stay. NULL is allowed. */
void vary_slides_again(struct vary_slides *s);
void vary_slides_free(struct vary_slides *s);
/* The motion begins, at `at`, whose start's copies are these: their request gets its modes. */
void vary_slides_start(struct vary_slides *s, const struct vary_at *at, struct vary_copies *start);

#endif
