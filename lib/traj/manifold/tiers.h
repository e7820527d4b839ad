/* Inside the traj folder: a start in tiers.
 *
 * Held values stay. Then, each tier as near to its guess as those before it leave it:
 *   given values: all as they are, if the others can adapt; otherwise those of coordinates and velocities as they are, if
 *     the algebraic ones can adapt; otherwise the nearest point to all of them but multipliers, then multipliers (where there is
 *     none, as it takes velocities without bound: to all but velocities, then velocities, then multipliers);
 *   other coordinates (near 0); other velocities (at rest); algebraic variables and multipliers, which cost nothing before.
 * (sys/kinds.h says what is what.) Where a tier has no nearest point, as it takes values of later ones without bound, those cost
 * something there. Of several points that are found the nearest is taken, tier by tier; of points as near as
 * each other the one with the largest coordinate, the first in the order of names that differs. Nothing depends on the
 * order of variables or constraints. */
#ifndef SGA_TRAJ_TIERS_H
#define SGA_TRAJ_TIERS_H

#include "trajectory.h"

struct manifold;
struct sizes;

/* What stays where it was given. */
enum tiers_stage { TIERS_KEEP_ALL, TIERS_KEEP_STATES, TIERS_MOVE_ALL, TIERS_KEEP_PLACES, TIERS_MOVE_PLACES, TIERS_STAGES };
enum { TIERS = 6, TIERS_PLACES = 3 /* of coordinates that were not given */ };

/* By variable: its tier (0 to TIERS - 1), or -1 where it stays. kind: of sys_kinds. */
void tiers_of(const struct traj_request *rq, const unsigned char *kind, int n, enum tiers_stage stage, signed char *tier);
/* Whether a stage moves what the one before it does not. */
bool tiers_differ(const struct traj_request *rq, const unsigned char *kind, int n, enum tiers_stage stage);
/* The stage that x, a start, was found in. */
enum tiers_stage tiers_stage_of(const struct traj_request *rq, const unsigned char *kind, int n, const double *x);

/* x becomes the start. elsewhere: some point of the set to begin at, or NULL: at the guess. False: none was found. */
bool tiers_start(struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq,
                 const double *elsewhere, double *x);
/* From x, a point of the set, to the nearest one that descent along the set leads to, in the tiers of the stage that x is found in. False: it leads
 * nowhere. *far: the squares of distances by tier. */
bool tiers_descend(struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq, double *x,
                   double far[TIERS]);
/* The same with sparse steps, from the guess: for systems of thousands of variables. Of a tier its variables stay where the tier left them. */
bool tiers_large_start(struct manifold *m, const struct sys_system *sys, const struct sizes *sizes, const struct traj_request *rq, double *x);

#endif
