/* The reduction of a job's system, with what its form asks for before and after it. */
#ifndef SGA_RUN_REDUCE_H
#define SGA_RUN_REDUCE_H

#include <stdbool.h>

struct job;
struct sga_solution;

/* Fills j->solution and j->oracle. A stratum's rows are those of the whole, brought to form already. */
bool answer_reduce(struct job *j);
void answer_reduce_clear(struct job *j);

/* Of the form `operator`: the analysis over Q(t)[D], before the reduction. Whether it is one of order 1 at the most, and its index, -1:
 * not solvable. */
bool answer_operator(struct job *j);
void answer_operator_clear(struct job *j);
bool answer_operator_is_pencil(const struct job *j);
int answer_operator_index(const struct job *j);
/* Of the form `mechanical`: the geometry of the constraints, before the reduction; the system gets multipliers for independent
 * conditions only. Then, after it, acceleration and regularity as far as they are wanted. */
bool answer_mechanical(struct job *j);
bool answer_mechanical_motion(struct job *j);
void answer_mechanical_clear(struct job *j);

/* Runs the reduction, `solve`, after the equations of the form hamiltonian have been pulled back to the zero
 * set of its restrictions; on other branches too where the first one ends in a contradiction. */
bool answer_primary(struct job *j, bool (*solve)(struct job *));
/* Takes and returns whether the reduction succeeded; refuses holonomic constraints that are irregular. */
bool answer_holonomic(struct job *j, bool ok);
/* After a reduction that left freedom: holonomic constraints whose differentials depend on those before them on the common
 * zeros ask nothing more; rows are added that set their multipliers to 0 (j->redundant). True: the system has to be reduced again. */
bool answer_holonomic_redundant(struct job *j);
/* Which restrictions a solution's constraints came from. */
void answer_restrictions_kept(struct job *j, const struct sga_solution *sol);
/* Is a given 2-form closed? */
bool answer_two_form(struct job *j);

#endif
