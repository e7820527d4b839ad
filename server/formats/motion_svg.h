/* The samples of a result as an image. */
#ifndef SERVER_MOTION_SVG_H
#define SERVER_MOTION_SVG_H

#include <stdbool.h>

struct samples;
struct sga_buf;

/* Appends an SVG image of the columns (names separated by commas; NULL: all but x and time) over the column x (NULL: time); of a sweep a
 * curve for each set. False: there is no such column, and `why` says which there are. Cost: linear in the samples. */
bool motion_svg(const struct samples *s, const char *columns, const char *x, struct sga_buf *out, struct sga_buf *why);

#endif
