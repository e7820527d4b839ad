/* Functions of time and operators as JSON: an element of Q(t) as text, an operator as the list of its coefficients a0, a1, .., matrices by rows. */
#ifndef SGA_OPERATOR_OPERATOR_JSON_H
#define SGA_OPERATOR_OPERATOR_JSON_H

#include "ore_matrix.h"
#include "ratio_matrix.h"

struct sga_json;

void op_json_ratio(struct sga_json *w, const fmpz_poly_q_t a, const char *time);
void op_json_ratios(struct sga_json *w, const struct ratio_matrix *m, const char *time);
void op_json_ore(struct sga_json *w, const struct ore *x, const char *time);
void op_json_ores(struct sga_json *w, const struct ore_matrix *m, const char *time);

#endif
