/* Inside the traj folder: whether it is the motion that blows up, or what its errors have become.
 *
 * Where a motion is stable and what it approaches lies beside states from which it runs away (concentrations near 0, which errors make negative), solutions at tolerances that do
 * not see the difference run away at about the same time, and agree on an end that is none. A solution that is far tighter does so much later, or not at all; at a
 * true one it ends there too. */
#ifndef SGA_TRAJ_BLOW_UP_H
#define SGA_TRAJ_BLOW_UP_H

struct ode_options;
struct ode_problem;
struct ode_start;
struct traj_result;

/* r ended with a blow-up that is not confirmed so: then it is said to end by errors. options: of its solutions. What the flow knows of its end is void afterwards.
 * Cost: a solution at a thousandth of the tolerances. */
void blow_up_confirm(const struct ode_problem *p, const struct ode_start *start, const struct ode_options *options, struct traj_result *r);

#endif
