/* The samples of a result as an image. */
#ifndef CLIENTS_MOTION_PLOT_H
#define CLIENTS_MOTION_PLOT_H

#include <stdbool.h>

#include "buf.h"
#include "json_scan.h"

/* Appends an SVG image of the columns (names separated by commas; NULL: all but x) over the column x (NULL: the first, time); of a sweep a
 * curve for each set. False, said on standard error: there are no samples, or no such column. Cost: linear in the samples. */
bool motion_plot(struct slice result, const char *columns, const char *x, struct sga_buf *out);

#endif
