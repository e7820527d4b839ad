/* Left and right reduction of a matrix that is not of full rank. */
#include "split.h"

/* The r x r corner of a matrix */
static void corner(struct ore_matrix *to, const struct ore_matrix *m, int r)
{
    ore_matrix_init(to, r, r);
    for (int i = 0; i < r; i++)
        for (int j = 0; j < r; j++)
            ore_set(ore_at(to, i, j), ore_at(m, i, j));
}

void op_split_clear(struct op_split *s)
{
    ore_matrix_clear(&s->U);
    ore_matrix_clear(&s->U_inverse);
    ore_matrix_clear(&s->V);
    ore_matrix_clear(&s->V_inverse);
    ore_matrix_clear(&s->R);
}

bool op_split_off(struct op_split *s, const struct ore_matrix *P, const struct op_limits *limits, struct sga_error *err)
{
    struct op_popov rows, cols;
    struct ore_matrix star = { 0 };
    if (!op_popov_weak(&rows, P, true, limits, err))
        return false;
    s->rank = rows.rank;
    ore_matrix_swap(&s->U, &rows.U);
    ore_matrix_swap(&s->U_inverse, &rows.inverse);
    if (rows.rank == P->cols) {
        ore_matrix_identity(&s->V, P->cols);
        ore_matrix_identity(&s->V_inverse, P->cols);
        corner(&s->R, &rows.R, s->rank);
        op_popov_clear(&rows);
        return true;
    }
    ore_matrix_adjoint(&star, &rows.R);
    op_popov_clear(&rows);
    bool ok = op_popov_weak(&cols, &star, true, limits, err);
    ore_matrix_clear(&star);
    if (!ok)
        return false;
    ore_matrix_adjoint(&s->V, &cols.U);        /* R V0 = (U_c R*)* */
    ore_matrix_adjoint(&s->V_inverse, &cols.inverse);
    ore_matrix_adjoint(&star, &cols.R);
    corner(&s->R, &star, s->rank);
    ore_matrix_clear(&star);
    op_popov_clear(&cols);
    return true;
}
