/* Inside the traj folder: starts that meet relations, within bounds.
 *
 * Derivatives in a relation are the field's components there; then a start is a point of the final set that is cut down by the relations, the nearest
 * to the guess of those that a search finds within the bounds. What depends on the choice of the gauge says nothing of the start: refused, but for
 * derivatives that the request itself fixes. */
#ifndef SGA_TRAJ_START_RELATIONS_H
#define SGA_TRAJ_START_RELATIONS_H

#include "trajectory.h"

bool start_relations_any(const struct traj_request *rq);
/* traj_run and traj_consistent from such a start, which is the result's `initial`; `moved` is the distance from the guess, r->relation what the
 * relations miss there. False with err: INITIAL at the relation or bound that is not met, GAUGE at a relation that the gauge enters. In
 * double-double the relations hold to its digits, in balls the start is proved to be there (struct enclosed_found). Expressions go to the store of sys. */
bool start_relations_run(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_result *r, struct sga_error *err);
bool start_relations_consistent(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct traj_initial *r, struct sga_error *err);

#endif
