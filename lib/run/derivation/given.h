/* The equations as they were given, in words. */
#ifndef SGA_RUN_GIVEN_H
#define SGA_RUN_GIVEN_H

#include <stdbool.h>

struct job;
struct sga_buf;

/* What row i of the system says, and where it comes from; appended. */
void derivation_row_text(const struct job *j, int row, struct sga_buf *out);
/* Whether row i is x' = f with the factor 1, so that it needs no solving; *variable then. */
bool derivation_row_is_solved(const struct job *j, int row, int *variable);

#endif
