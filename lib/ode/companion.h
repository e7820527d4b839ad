/* Inside the ode folder: the error of a solution, followed along its own steps.
 *
 * Beside the solution u goes the error e that it is thought to have: after each step it is what the flow near u makes of the error
 * before the step, e' = X(t, u + e) - X(t, u), and the error that the step itself made (ode_method.missed; roundings). This is linear as
 * long as e is small, and known well enough by a few evaluations of the field a step, whose other half, X(t, u), the steps have computed
 * (R. D. Skeel, Thirteen ways to estimate global error, Numerische Mathematik 48, 1986: solving for the error, with the local error for
 * the defect). A second solution costs as much as the first one; this costs a third of it, and a tenth beside series.
 *
 * Only explicit steps on a smooth field are followed: after anything else the companion is lost, and says nothing. */
#ifndef SGA_ODE_COMPANION_H
#define SGA_ODE_COMPANION_H

#include <stdbool.h>

struct ode_march;
struct ode_run;
struct ode_companion;

/* Whether the steps of this problem can be followed, as far as can be told before. */
bool ode_companion_fits(const struct ode_run *run);
/* For one solution of the run. noise: n, as in ode_run, or NULL; borrowed. */
struct ode_companion *ode_companion_new(const struct ode_run *run, const double *noise);
void ode_companion_free(struct ode_companion *c);

/* driver.c: the start is known; after a step, before it becomes the present point: samples up to, not including, `through` are complete. */
void ode_companion_start(struct ode_march *m);
void ode_companion_step(struct ode_march *m, int through);

/* The field or the manifold is another one from here on: the error is not followed any further. */
void ode_companion_lose(struct ode_companion *c);

/* The errors at the samples (count x n), those that were complete; NULL: the companion was lost. */
const double *ode_companion_errors(const struct ode_companion *c);
/* Evaluations of the field that it took. */
long ode_companion_evaluations(const struct ode_companion *c);

#endif
