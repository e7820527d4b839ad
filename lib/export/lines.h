/* Straight-line code: expressions as statements of a language. */
#ifndef SGA_EXPORT_LINES_H
#define SGA_EXPORT_LINES_H

#include "model.h"

struct export_place {
    const char *array;            /* "c"; in print the whole left side */
    int row, column;              /* column -1: the array is a list */
    expr_id value;
};

/* Appends a statement `array[row] = value` for each place, before them those for what several share (w1, w2, ...; m->parts says how
 * many). What is used once stands where it is used, unless the line would grow long. False, with err: a number lies outside of the
 * doubles. Cost: linear in the graph under the places. */
bool export_lines(struct export_model *m, const struct export_place *place, int places, struct sga_buf *out, struct sga_error *err);
/* Appends one constant expression (of parameters' values). */
bool export_value(struct export_model *m, expr_id value, struct sga_buf *out, struct sga_error *err);

#endif
