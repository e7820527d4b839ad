/* Inside the formats folder: an FMU of an answer. */
#ifndef SERVER_FMU_VIEW_H
#define SERVER_FMU_VIEW_H

#include "code_source.h"

/* Appends the archive. The start is that of the answer's motion, or of its consistent_initial; of a sweep that of the first set that has one,
 * with its parameters. False: err says why. */
bool fmu_view(struct code_source *r, struct sga_buf *out, struct sga_error *err);

#endif
