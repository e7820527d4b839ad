/* Inside the traj folder: what a motion leaves whose time ends before it does. Its rows are kept as far as two solutions, or a proof, have come. */
#ifndef SGA_TRAJ_ROWS_KEPT_H
#define SGA_TRAJ_ROWS_KEPT_H

#include <stdbool.h>

struct sga_budget;
struct sga_error;
struct traj_request;

/* Whether rows are to be kept: traj_request's rows_until. */
bool rows_are_kept(const struct traj_request *rq);
/* The request with a budget that ends at `until`, an sga_now() value; *own and *budget are the caller's. */
const struct traj_request *rows_request(const struct traj_request *rq, double until, struct traj_request *own, struct sga_budget *budget);
/* When the first of two solutions has to be there; the second, which is tighter, has the rest. */
double rows_first_until(double until);
/* Whether the time of rq's own budget ended; no other limit, and no cancellation. */
bool rows_time_ended(const struct traj_request *rq);
/* The budget without its time, where rows are kept: what has rows ends with them, however slow the machine was since rows_until. */
bool rows_may_end(const struct traj_request *rq, struct sga_error *err);
/* Whether the last of so many rows lies beyond the start; otherwise err (which may be NULL): the limit is too short. */
bool rows_beyond_start(const struct traj_request *rq, int rows, struct sga_error *err);
/* Why errors are larger than what was asked for, static. */
extern const char rows_shortfall[];

#endif
