/* What stands around the formulas in each language. */
#ifndef SGA_EXPORT_SKELETON_H
#define SGA_EXPORT_SKELETON_H

#include "model.h"

bool export_c(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_python(struct export_model *m, struct sga_buf *out, struct sga_error *err);

/* Appends the formulas of each function: c[i]; J[row*n + column], entries that are not the constant 0; G[row*n + column], likewise;
 * dx[i], of components and f[k] times gauge fields. */
bool export_constraint_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err);
bool export_jacobian_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err);
bool export_gauge_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err);
bool export_field_lines(struct export_model *m, enum export_language l, struct sga_buf *out, struct sga_error *err);
/* Appends what the arrays mean, each line after `mark`: variables, constraints with their generation, arguments. */
void export_legend(const struct export_model *m, const char *mark, struct sga_buf *out);

#endif
