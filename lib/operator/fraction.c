/* Elimination of unknowns, the common left factor, and the Popov form of what is left. */
#include "fraction.h"

#include <assert.h>

#include "arena.h"
#include "error.h"
#include "popov.h"

/* m (not initialised) = a above b. */
static void stack(struct ore_matrix *m, const struct ore_matrix *a, const struct ore_matrix *b)
{
    assert(a->cols == b->cols);
    ore_matrix_init(m, a->rows + b->rows, a->cols);
    for (int i = 0; i < m->rows; i++)
        for (int k = 0; k < m->cols; k++)
            ore_set(ore_at(m, i, k), i < a->rows ? ore_at(a, i, k) : ore_at(b, i - a->rows, k));
}

/* m (not initialised) = a beside b. */
static void beside(struct ore_matrix *m, const struct ore_matrix *a, const struct ore_matrix *b)
{
    assert(a->rows == b->rows);
    ore_matrix_init(m, a->rows, a->cols + b->cols);
    for (int i = 0; i < m->rows; i++)
        for (int k = 0; k < m->cols; k++)
            ore_set(ore_at(m, i, k), k < a->cols ? ore_at(a, i, k) : ore_at(b, i, k - a->cols));
}

/* out (not initialised) = m[row.., col..] of so many rows and columns. */
static void part(struct ore_matrix *out, const struct ore_matrix *m, int row, int rows, int col, int cols)
{
    ore_matrix_init(out, rows, cols);
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < cols; k++)
            ore_set(ore_at(out, i, k), ore_at(m, row + i, col + k));
}

/* Relations Q y = N u, perhaps too many: the rows of U below the rank of [P; C], U [B; 0] = -N + U_y E. */
static bool relations(struct ore_matrix *Q, struct ore_matrix *N, const struct ore_matrix *P, const struct ore_matrix *B, const struct ore_matrix *C, const struct ore_matrix *E,
                      const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix M = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix Up = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix known = { 0 };
    SGA_ENDS(op_popov_clear) struct op_popov rows = { 0 };
    stack(&M, P, C);
    if (!op_popov_weak(&rows, &M, false, limits, err))
        return false;
    int count = M.rows - rows.rank;
    part(&Up, &rows.U, rows.rank, count, 0, P->rows);
    ore_matrix_clear(Q);
    part(Q, &rows.U, rows.rank, count, P->rows, C->rows);
    ore_matrix_mul(N, Q, E);
    ore_matrix_mul(&known, &Up, B);
    for (int i = 0; i < count; i++)
        for (int k = 0; k < B->cols; k++)
            ore_sub(ore_at(N, i, k), ore_at(N, i, k), ore_at(&known, i, k));
    return true;
}

/* The first column without a pivot. */
static int open_column(const struct op_popov *p, int cols)
{
    for (int k = 0; k < cols; k++) {
        bool has = false;
        for (int i = 0; i < p->rank; i++)
            has |= p->pivot[i] == k;
        if (!has)
            return k;
    }
    return -1;
}

static bool zero_rows(const struct ore_matrix *m, int from)
{
    for (int i = from; i < m->rows; i++)
        for (int k = 0; k < m->cols; k++)
            if (!ore_is_zero(ore_at(m, i, k)))
                return false;
    return true;
}

/* As many relations as outputs. */
static enum op_fraction_status independent(struct op_fraction *f, struct ore_matrix *Q, struct ore_matrix *N, const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(op_popov_clear) struct op_popov rows = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix all = { 0 };
    int outputs = Q->cols, inputs = N->cols;
    if (!op_popov_weak(&rows, Q, false, limits, err))
        return OP_FRACTION_FAILED;
    f->which = open_column(&rows, outputs);
    if (f->which >= 0)
        return OP_FRACTION_OUTPUT_OPEN;
    ore_matrix_mul(&all, &rows.U, N);
    if (!zero_rows(&all, rows.rank))
        return OP_FRACTION_INPUTS_BOUND;
    ore_matrix_clear(Q);
    part(Q, &rows.R, 0, outputs, 0, outputs);
    ore_matrix_clear(N);
    part(N, &all, 0, outputs, 0, inputs);
    return OP_FRACTION_FOUND;
}

/* [Q N] = L [Q1 N1], Q1 and N1 without a common left factor: of the adjoint, (U^-1 R)* with R on top. */
static bool coprime(struct ore_matrix *Q, struct ore_matrix *N, const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix W = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix star = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix top = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix L = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix left = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix product = { 0 };
    SGA_ENDS(op_popov_clear) struct op_popov rows = { 0 };
    int outputs = Q->rows, inputs = N->cols;
    beside(&W, Q, N);
    ore_matrix_adjoint(&star, &W);
    if (!op_popov_weak(&rows, &star, true, limits, err))
        return false;
    assert(rows.rank == outputs);             /* Q is regular */
    part(&top, &rows.R, 0, outputs, 0, outputs);
    ore_matrix_adjoint(&L, &top);
    ore_matrix_clear(&top);
    part(&top, &rows.inverse, 0, outputs + inputs, 0, outputs);
    ore_matrix_adjoint(&left, &top);          /* [Q1 N1] */
    ore_matrix_mul(&product, &L, &left);
    if (!ore_matrix_equal(&product, &W))
        return sga_fail(err, SGA_E_WITNESS, "a common factor of a fraction of operators does not multiply out: this is a bug");
    ore_matrix_clear(Q);
    part(Q, &left, 0, outputs, 0, outputs);
    ore_matrix_clear(N);
    part(N, &left, 0, outputs, outputs, inputs);
    return true;
}

/* Q in Popov form. */
static bool normal(struct op_fraction *f, const struct ore_matrix *Q, const struct ore_matrix *N, const struct op_limits *limits, struct sga_error *err)
{
    struct op_popov rows = { 0 };
    if (!op_popov_weak(&rows, Q, false, limits, err) || !op_popov_finish(&rows, limits, err))
        return false;
    ore_matrix_set(&f->left, &rows.R);
    ore_matrix_mul(&f->right, &rows.U, N);
    op_popov_clear(&rows);
    return true;
}

enum op_fraction_status op_fraction_find(struct op_fraction *f, const struct ore_matrix *P, const struct ore_matrix *B, const struct ore_matrix *C,
                                         const struct ore_matrix *E, const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix Q = { 0 };
    SGA_ENDS(ore_matrix_clear) struct ore_matrix N = { 0 };
    *f = (struct op_fraction){ .which = -1 };
    assert(P->rows == B->rows && C->rows == E->rows && P->cols == C->cols && B->cols == E->cols);
    if (!relations(&Q, &N, P, B, C, E, limits, err))
        return OP_FRACTION_FAILED;
    enum op_fraction_status status = independent(f, &Q, &N, limits, err);
    if (status != OP_FRACTION_FOUND)
        return status;
    return coprime(&Q, &N, limits, err) && normal(f, &Q, &N, limits, err) ? OP_FRACTION_FOUND : OP_FRACTION_FAILED;
}

bool op_fraction_proper(const struct op_fraction *f, bool strictly)
{
    for (int i = 0; i < f->left.rows; i++) {
        int order = -1;
        for (int k = 0; k < f->left.cols; k++)
            order = ore_order(ore_at(&f->left, i, k)) > order ? ore_order(ore_at(&f->left, i, k)) : order;
        for (int k = 0; k < f->right.cols; k++)
            if (ore_order(ore_at(&f->right, i, k)) > order - strictly)
                return false;
    }
    return true;
}

void op_fraction_clear(struct op_fraction *f)
{
    ore_matrix_clear(&f->left);
    ore_matrix_clear(&f->right);
}
