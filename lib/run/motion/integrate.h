/* From a reduction to numbers. */
#ifndef SGA_RUN_INTEGRATE_H
#define SGA_RUN_INTEGRATE_H

#include <stdbool.h>

struct job;
struct points_oracle;
struct sga_error;
struct sga_solution;
struct traj_request;
struct traj_result;

/* traj_run of the answer's system; in the form operator it ends at singular times. */
bool answer_integrate(const struct job *j, const struct sga_solution *solution, const struct traj_request *request,
                      struct traj_result *result, struct sga_error *err);
/* The first integrals whose drift the trajectory shall report, of a solution and its oracle. */
void answer_integrals(struct job *j, const struct sga_solution *s, struct points_oracle *oracle, struct traj_request *r);

#endif
