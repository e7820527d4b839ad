/* Modes of a state form. */
#include "linear_modes.h"

#include <assert.h>

#include "linearize.h"

/* m gets the entries of part at (row, col); its exactness is that of all parts. */
static void place(struct linear_matrix *m, int row, int col, const struct linear_matrix *part, bool minus)
{
    m->exact = m->exact && part->exact;
    for (int i = 0; i < linear_rows(part); i++)
        for (int k = 0; k < linear_cols(part); k++) {
            fmpq *q = fmpq_mat_entry(m->q, row + i, col + k);
            arb_ptr b = arb_mat_entry(m->b, row + i, col + k);
            fmpq_set(q, fmpq_mat_entry(part->q, i, k));
            arb_set(b, arb_mat_entry(part->b, i, k));
            if (minus) {
                fmpq_neg(q, q);
                arb_neg(b, b);
            }
        }
}

/* Elementary divisors of s [I, 0; 0, 0] - [A, B; C, D], with or without its last rows and columns. */
static bool pencil(struct spectrum_of *s, const struct linearization *l, bool inputs, bool outputs, const struct sga_budget *budget, struct sga_error *err)
{
    int n = linear_rows(&l->A), rows = n + (outputs ? linear_rows(&l->C) : 0), cols = n + (inputs ? linear_cols(&l->B) : 0);
    struct linear_matrix E, F;
    linear_matrix_init(&E, rows, cols);
    linear_matrix_init(&F, rows, cols);
    for (int i = 0; i < n; i++)
        fmpq_one(fmpq_mat_entry(E.q, i, i));
    place(&F, 0, 0, &l->A, false);
    if (inputs)
        place(&F, 0, n, &l->B, false);
    if (outputs)
        place(&F, n, 0, &l->C, false);
    if (inputs && outputs)
        place(&F, n, n, &l->D, false);
    bool ok = spectrum_of_pencil(s, &E, &F, budget, err);
    linear_matrix_clear(&E);
    linear_matrix_clear(&F);
    return ok;
}

static bool exact_reach(struct linear_reach *r, const struct linearization *l, bool inputs, const struct sga_budget *budget, struct sga_error *err)
{
    if (!pencil(&r->missed, l, inputs, !inputs, budget, err))
        return false;
    r->dimension = r->missed.missing ? -1 : linear_rows(&l->A) - r->missed.total;
    r->least = r->dimension < 0 ? 0 : r->dimension;
    return true;
}

static void transposed(struct linear_matrix *out, const struct linear_matrix *m)
{
    linear_matrix_init(out, linear_cols(m), linear_rows(m));
    out->exact = m->exact;
    fmpq_mat_transpose(out->q, m->q);
    arb_mat_transpose(out->b, m->b);
}

/* The rank of [B, A B, A^2 B, ...]. */
static void krylov(struct linear_reach *r, const struct linear_matrix *A, const struct linear_matrix *B)
{
    int n = linear_rows(A), m = linear_cols(B);
    struct linear_matrix all, part, next;
    linear_matrix_init(&all, n, n * m);
    linear_matrix_init(&part, n, m);
    place(&part, 0, 0, B, false);
    for (int k = 0; k < n; k++) {
        place(&all, 0, k * m, &part, false);
        linear_matrix_product(&next, A, &part);
        linear_matrix_clear(&part);
        part = next;
    }
    linear_matrix_clear(&part);
    all.exact = false;
    bool known = linear_matrix_rank(&all, &r->least);
    linear_matrix_clear(&all);
    known = known || r->least == n;
    r->dimension = known ? r->least : -1;
    if (!known)
        r->missed.missing = "the rank is proved to be at least `least`, and not to be more";
    else if (r->least < n)
        r->missed.missing = "which eigenvalues are missed is told where the matrices are exact";
}

static bool reach(struct linear_modes *m, const struct linearization *l, const struct sga_budget *budget, struct sga_error *err)
{
    if (l->A.exact && l->B.exact) {
        if (!exact_reach(&m->controllable, l, true, budget, err))
            return false;
    } else {
        krylov(&m->controllable, &l->A, &l->B);
    }
    if (l->A.exact && l->C.exact)
        return exact_reach(&m->observable, l, false, budget, err);
    struct linear_matrix A, C;
    transposed(&A, &l->A);
    transposed(&C, &l->C);
    krylov(&m->observable, &A, &C);
    linear_matrix_clear(&A);
    linear_matrix_clear(&C);
    return true;
}

static bool zeros(struct linear_modes *m, const struct linearization *l, const struct sga_budget *budget, struct sga_error *err)
{
    int inputs = linear_cols(&l->B), outputs = linear_rows(&l->C);
    struct linear_matrix M, t;
    if (l->A.exact && l->B.exact && l->C.exact && l->D.exact)
        return pencil(&m->zeros, l, true, true, budget, err);
    m->zeros.missing = "zeros are told where the matrices are exact, or D is regular";
    if (inputs != outputs || !linear_matrix_solve(&t, &l->D, &l->C)) {
        if (inputs == outputs)
            linear_matrix_clear(&t);
        return true;
    }
    linear_matrix_product(&M, &l->B, &t);        /* A - B D^-1 C */
    linear_matrix_clear(&t);
    linear_matrix_add(&M, &l->A, true);
    for (int i = 0; i < linear_rows(&M); i++)
        for (int k = 0; k < linear_cols(&M); k++) {
            fmpq_neg(fmpq_mat_entry(M.q, i, k), fmpq_mat_entry(M.q, i, k));
            arb_neg(arb_mat_entry(M.b, i, k), arb_mat_entry(M.b, i, k));
        }
    bool ok = spectrum_of_matrix(&m->zeros, &M, budget, err);
    linear_matrix_clear(&M);
    return ok;
}

static enum linear_stability told(struct linear_modes *m, enum linear_stability is, const char *why)
{
    m->why = why;
    return is;
}

/* Lyapunov's first method; for constant coefficients the linear system is the system. */
static enum linear_stability stability(struct linear_modes *m, const struct linearization *l)
{
    const struct spectrum_of *s = &m->eigenvalues;
    bool left = true, axis = false, chain = false;
    if (s->missing)
        return told(m, LINEAR_UNDECIDED, "the eigenvalues are not known");
    if (!l->motion_constant && l->equilibrium != 1)
        return told(m, LINEAR_UNDECIDED, l->equilibrium == 0 ? "the point is no equilibrium: eigenvalues at one moment do not decide about a motion"
                                                             : "the point is not known to be an equilibrium");
    for (int i = 0; i < s->count; i++) {
        if (s->value[i].side == SPECTRUM_RIGHT)
            return told(m, LINEAR_UNSTABLE, "an eigenvalue has a positive real part");
        left = left && s->value[i].side == SPECTRUM_LEFT;
        axis |= s->value[i].side == SPECTRUM_AXIS;
        chain |= s->value[i].side == SPECTRUM_AXIS && s->value[i].block > 1;
        if (s->value[i].side == SPECTRUM_UNKNOWN)
            return told(m, LINEAR_UNDECIDED, "the real part of an eigenvalue could not be told from 0");
    }
    if (left)
        return told(m, LINEAR_ASYMPTOTIC, "all eigenvalues have negative real parts");
    assert(axis);
    if (!l->motion_constant || !s->exact)
        return told(m, LINEAR_UNDECIDED, "an eigenvalue lies on the imaginary axis: what is not linear decides");
    return chain ? told(m, LINEAR_UNSTABLE, "an eigenvalue on the imaginary axis has a Jordan block of more than 1")
                 : told(m, LINEAR_MARGINAL, "no eigenvalue lies right of the imaginary axis, and those on it have Jordan blocks of 1");
}

bool linear_modes_find(struct linear_modes *m, const struct linearization *l, const struct sga_budget *budget, struct sga_error *err)
{
    *m = (struct linear_modes){ .exact = l->A.exact };
    if (!spectrum_of_matrix(&m->eigenvalues, &l->A, budget, err) || !reach(m, l, budget, err) || !zeros(m, l, budget, err))
        return false;
    m->stability = stability(m, l);
    return true;
}

void linear_modes_clear(struct linear_modes *m)
{
    spectrum_of_clear(&m->eigenvalues);
    spectrum_of_clear(&m->zeros);
    spectrum_of_clear(&m->controllable.missed);
    spectrum_of_clear(&m->observable.missed);
}
