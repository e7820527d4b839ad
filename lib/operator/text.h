/* Elements of Q(t) as texts of the grammar. */
#ifndef SGA_OPERATOR_TEXT_H
#define SGA_OPERATOR_TEXT_H

#include <flint/fmpz_poly_q.h>

struct sga_buf;

/* Appends p, highest power first: "3*t^2 - t + 1". */
void op_text_polynomial(struct sga_buf *out, const fmpz_poly_t p, const char *time);
/* Appends a: "(t + 1)/(2*t)". */
void op_text_ratio(struct sga_buf *out, const fmpz_poly_q_t a, const char *time);

#endif
