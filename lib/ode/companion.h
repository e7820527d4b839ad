/* Inside the ode folder: the error of a solution while it is made.
 *
 * A companion takes the steps of the solution by the same series less their last two terms, so that it errs by more, and follows a field that is wrong by a
 * rounding from a start that is. How far the solution is from it is known without computing it: a distance e as small as errors are goes over a step by
 *   e -> (P(x) - P(x - by e)) / by + the terms left out,
 * where the polynomials P need no more terms than make this sharp beside what the step adds. It is put on the manifold by projecting x - by e. Cost: one short series and
 * one projection a step: less than half of the solution's own.
 *
 * This is the difference of two solutions of which one is looser (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4), to first order. */
#ifndef SGA_ODE_COMPANION_H
#define SGA_ODE_COMPANION_H

#include <stdbool.h>

struct ode_march;
struct ode_problem;
struct ode_run;

struct ode_companion;

/* Whether nothing is on the way of this problem's solutions at which distances jump, and they have series. */
bool ode_companion_goes_with(const struct ode_problem *p);
/* Whether solutions of this run can be accompanied: by series from the start. */
bool ode_companion_may(const struct ode_run *run);
/* The march's x is its start. Memory: some 40 n numbers, and n for each sample. */
struct ode_companion *ode_companion_begin(const struct ode_march *m);
/* The march's step was taken, the samples before `through` lie in it; x and x1 are its ends. Nothing where c is NULL. */
void ode_companion_step(struct ode_companion *c, struct ode_march *m, int through);
/* The solution jumps, and distances in another way. */
void ode_companion_lose(struct ode_companion *c);
/* Its distance is no longer known. False where c is NULL. */
bool ode_companion_lost(const struct ode_companion *c);
/* By sample the solution less its companion, count x n, the caller's to free; NULL: other methods made steps, or the distance has grown too large. Frees c. */
double *ode_companion_end(struct ode_companion *c);

#endif
