/* Where a problem lies, under the line that has it. */
#ifndef CLIENTS_CARET_H
#define CLIENTS_CARET_H

#include "buf.h"
#include "json_scan.h"

/* Appends the line of the request's text that the problem (an object with pointer, line, column) points into, and a line with ^ under the
 * column: of the expression at the pointer, or of the whole text where there is no pointer. Nothing where it says no column. */
void caret_put(struct sga_buf *out, struct slice problem, struct slice request);

#endif
