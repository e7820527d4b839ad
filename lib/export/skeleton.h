/* What stands around the formulas in each language. */
#ifndef SGA_EXPORT_SKELETON_H
#define SGA_EXPORT_SKELETON_H

#include "model.h"

bool export_c(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_python(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_matlab(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_julia(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_casadi(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_modelica(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_latex(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_mathml(struct export_model *m, struct sga_buf *out, struct sga_error *err);

/* Appends the formulas of each function: c[i]; J[row*n + column], entries that are not the constant 0; G[row*n + column], likewise;
 * dx[i], of components and f[k] times gauge fields. */
bool export_constraint_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_jacobian_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_gauge_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err);
bool export_field_lines(struct export_model *m, struct sga_buf *out, struct sga_error *err);
/* By variable, the component and f[k] times gauge fields, where f[k] become symbols of the store: once for each model. */
bool export_field_values(struct export_model *m, expr_id *value, struct sga_error *err);
/* Appends each parameter that has a value: the pattern with its name, the value, what comes after. */
bool export_constants(struct export_model *m, const char *pattern, const char *after, struct sga_buf *out, struct sga_error *err);
/* Appends what the source is, each line after `mark`; `failing` says what comes where a formula has no value. */
void export_about(const struct export_model *m, const char *mark, const char *failing, struct sga_buf *out);
/* Appends what the arrays mean, each line after `mark`: variables, constraints with their generation, arguments. */
void export_legend(const struct export_model *m, const char *mark, struct sga_buf *out);

#endif
