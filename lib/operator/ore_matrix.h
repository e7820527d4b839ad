/* Matrices over k[D]. */
#ifndef SGA_OPERATOR_ORE_MATRIX_H
#define SGA_OPERATOR_ORE_MATRIX_H

#include "ore.h"

struct ore_matrix {
    int rows, cols;
    struct ore *e;             /* by rows */
};

void ore_matrix_init(struct ore_matrix *m, int rows, int cols);      /* zero */
void ore_matrix_clear(struct ore_matrix *m);
void ore_matrix_set(struct ore_matrix *m, const struct ore_matrix *a);   /* m initialised; takes a's size */
void ore_matrix_swap(struct ore_matrix *m, struct ore_matrix *a);
void ore_matrix_identity(struct ore_matrix *m, int n);               /* m initialised */
static inline struct ore *ore_at(const struct ore_matrix *m, int i, int j)
{
    return m->e + (size_t)i * (size_t)m->cols + j;
}
bool ore_matrix_equal(const struct ore_matrix *a, const struct ore_matrix *b);
bool ore_matrix_is_identity(const struct ore_matrix *a);
/* m = a b; m may not be one of them. Cost: rows x cols x inner products in k[D]. */
void ore_matrix_mul(struct ore_matrix *m, const struct ore_matrix *a, const struct ore_matrix *b);
/* Transposed, each entry replaced by its adjoint: turns left into right. */
void ore_matrix_adjoint(struct ore_matrix *m, const struct ore_matrix *a);
/* row i += q row j; col j -= col i q (what it takes to keep the product) */
void ore_matrix_add_row(struct ore_matrix *m, int i, const struct ore *q, int j);
void ore_matrix_sub_col(struct ore_matrix *m, int j, const struct ore *q, int i);
void ore_matrix_swap_rows(struct ore_matrix *m, int i, int j);
void ore_matrix_swap_cols(struct ore_matrix *m, int i, int j);
/* row i = c row i; col i = col i c */
void ore_matrix_scale_row(struct ore_matrix *m, int i, const fmpz_poly_q_t c);
void ore_matrix_scale_col(struct ore_matrix *m, int i, const fmpz_poly_q_t c);
int ore_matrix_order(const struct ore_matrix *m);                    /* -1 for 0 */
size_t ore_matrix_size(const struct ore_matrix *m);                  /* bytes, roughly */

#endif
