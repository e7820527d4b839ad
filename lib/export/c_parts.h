/* Pieces of C that the language c and the FMU share. */
#ifndef SGA_EXPORT_C_PARTS_H
#define SGA_EXPORT_C_PARTS_H

#include "model.h"

/* Inline functions that formulas use: sga_sign, sga_power, sga_least, sga_greatest. */
extern const char export_c_helpers[];
/* The definition of sga_project, for the macros SGA_VARIABLES and SGA_CONSTRAINTS. */
extern const char export_c_projection[];
/* Appends a function: its head, places of the array that are to be 0 (`size` of them; NULL: none are), the lines. */
bool export_c_function(struct export_model *m, const char *head, const char *size, const char *array,
                       bool (*lines)(struct export_model *, struct sga_buf *, struct sga_error *), struct sga_buf *out, struct sga_error *err);

#endif
