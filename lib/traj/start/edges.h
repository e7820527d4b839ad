/* Inside the traj folder: starts at the ends of roots. y = sqrt(u) has values from u = 0 on, and is one of them there: where the guess lies
 * beyond, the nearest start has u = 0 as a rule, which no search along the set comes to, since slopes grow without bound. */
#ifndef SGA_TRAJ_EDGES_H
#define SGA_TRAJ_EDGES_H

#include "defined.h"

/* Candidates with the argument of each root in d's definitions at 0, and with all of them; where one is as near to what is given as
 * `moved`, the distance of the start known so far (infinite: none), d begins there. Whether it does. */
bool edges_start(struct defined *d, double moved);

#endif
