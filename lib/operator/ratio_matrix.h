/* Matrices over Q(t). */
#ifndef SGA_OPERATOR_RATIO_MATRIX_H
#define SGA_OPERATOR_RATIO_MATRIX_H

#include <stdbool.h>

#include <flint/fmpz_poly_q.h>

struct ratio_matrix {
    int rows, cols;
    fmpz_poly_q_struct *e;     /* by rows */
};

void ratio_matrix_init(struct ratio_matrix *m, int rows, int cols);      /* zero */
void ratio_matrix_clear(struct ratio_matrix *m);
void ratio_matrix_set(struct ratio_matrix *m, const struct ratio_matrix *a);   /* m initialised */
void ratio_matrix_swap(struct ratio_matrix *m, struct ratio_matrix *a);
static inline fmpz_poly_q_struct *ratio_at(const struct ratio_matrix *m, int i, int j)
{
    return m->e + (size_t)i * (size_t)m->cols + j;
}
bool ratio_matrix_is_zero(const struct ratio_matrix *m);
bool ratio_matrix_equal(const struct ratio_matrix *a, const struct ratio_matrix *b);
void ratio_matrix_derive(struct ratio_matrix *m, const struct ratio_matrix *a);   /* may be the same */
void ratio_matrix_add(struct ratio_matrix *m, const struct ratio_matrix *a);      /* m += a */
void ratio_matrix_sub(struct ratio_matrix *m, const struct ratio_matrix *a);
void ratio_matrix_scale(struct ratio_matrix *m, long factor);
/* m += a b (sizes fit) */
void ratio_matrix_addmul(struct ratio_matrix *m, const struct ratio_matrix *a, const struct ratio_matrix *b);
/* x = a^{-1} b for square a; false where a is singular. x may be b. Fraction-free over Z[t]. */
bool ratio_matrix_solve(struct ratio_matrix *x, const struct ratio_matrix *a, const struct ratio_matrix *b);

#endif
