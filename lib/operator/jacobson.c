/* The Jacobson form by a cyclic vector.
 *
 * Left and right reduction first split off what is not torsion: U1 P V0 = [R 0; 0 0], R square
 * of full rank r. The module M of R z = 0 is torsion and k[D] is simple, so some w = W z
 * generates it, with annihilator e; W can be taken with an entry 1 at some m. In the
 * coordinates z_m = w, others unchanged (V1, elementary), z_i = c_i(D) w in M; after z_i -=
 * c_i z_m (V2, elementary) all z_i but z_m vanish in M, so the rows of R V1 V2 generate the same
 * left module as those of diag(1, .., e, .., 1). U follows by division. */
#include "annihilator.h"

#include <stdlib.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "split.h"

/* V = V1 V2 and its inverse, with the columns (rows) ordered so that w comes last. */
static void right_transformation(struct ore_matrix *V, struct ore_matrix *inverse, const struct cyclic *c)
{
    int r = c->w.cols;
    struct ore w;
    SGA_ENDS(ore_clear) struct ore minus;
    ore_init(&w);
    ore_init(&minus);
    ore_matrix_identity(V, r);
    ore_matrix_identity(inverse, r);
    for (int i = 0; i < r; i++) {              /* V2: z_i = z_i' + c_i w;  V1: z_m = w - sum W_i z_i */
        if (i == c->m)
            continue;
        ore_zero(&w);
        if (!fmpz_poly_q_is_zero(ratio_at(&c->w, 0, i)))
            ore_add_term(&w, ratio_at(&c->w, 0, i), 0);
        ore_set(ore_at(V, i, c->m), c->c + i);
        ore_sub(ore_at(V, c->m, i), &minus, &w);
        ore_submul(ore_at(V, c->m, c->m), &w, c->c + i);
        ore_set(ore_at(inverse, c->m, i), &w);
    }
    for (int i = 0; i < r; i++)                /* z_i' = z_i - c_i W z */
        for (int j = 0; j < r && i != c->m; j++)
            ore_submul(ore_at(inverse, i, j), c->c + i, ore_at(inverse, c->m, j));
    for (int i = c->m; i + 1 < r; i++) {
        ore_matrix_swap_cols(V, i, i + 1);
        ore_matrix_swap_rows(inverse, i, i + 1);
    }
    ore_clear(&w);
}

/* U with U P V = diag(1, .., 1, e): rows of diag V^{-1} divided by the Popov form. */
static bool left_transformation(struct ore_matrix *U, const struct op_popov *p, const struct ore_matrix *inverse,
                                const struct ore *e, const struct op_limits *limits, struct sga_error *err)
{
    int r = inverse->rows;
    SGA_ENDS(ore_matrix_clear) struct ore_matrix Q, row = { 0 };
    bool ok = true;
    ore_matrix_init(&Q, r, r);
    ore_matrix_set(&row, inverse);
    for (int j = 0; j < r; j++)
        ore_mul(ore_at(&row, r - 1, j), e, ore_at(&row, r - 1, j));
    for (int i = 0; i < r && ok; i++) {
        op_popov_reduce(p, ore_at(&row, i, 0), ore_at(&Q, i, 0));
        for (int j = 0; j < r && ok; j++)
            ok = ore_is_zero(ore_at(&row, i, j)) || sga_fail(err, SGA_E_WITNESS, "a row does not lie in the module of P: this is a bug");
        ok = ok && op_within(limits, &Q, err);
    }
    if (ok)
        ore_matrix_mul(U, &Q, &p->U);
    return ok;
}

/* U^{-1} = P V diag^{-1}: the last column divided by e on the right. */
static bool left_inverse(struct ore_matrix *inverse, const struct ore_matrix *P, const struct ore_matrix *V, const struct ore *e)
{
    SGA_ENDS(ore_clear) struct ore rest;
    bool ok = true;
    ore_init(&rest);
    ore_matrix_mul(inverse, P, V);
    for (int i = 0; i < P->rows && ok; i++) {
        struct ore *x = ore_at(inverse, i, P->cols - 1);
        ore_divide_right(x, &rest, x, e);
        ok = ore_is_zero(&rest);
    }
    return ok;
}

/* The full case: P square of full rank, x and p from it. */
static bool full_form(struct op_jacobson *f, const struct op_popov *p, const struct ore_matrix *P, const struct op_state *x,
                      const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(op_annihilator_clear) struct cyclic c;
    bool ok = op_annihilator_find(&c, x, limits, err);
    f->rank = P->rows;
    ore_swap(&f->e, &c.e);
    f->transformations = ok && ore_size(&f->e) <= OP_MOST_FACTOR_BYTES;
    if (f->transformations) {
        right_transformation(&f->V, &f->V_inverse, &c);
        ok = left_transformation(&f->U, p, &f->V_inverse, &f->e, limits, err);
    }
    if (ok && f->transformations && !left_inverse(&f->U_inverse, P, &f->V, &f->e))
        ok = sga_fail(err, SGA_E_WITNESS, "the last invariant factor does not divide its column: this is a bug");
    return ok;
}

/* m = diag(m, identity) with n rows */
static void border(struct ore_matrix *m, int n)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix big;
    ore_matrix_init(&big, n, n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            if (i < m->rows && j < m->cols)
                ore_set(ore_at(&big, i, j), ore_at(m, i, j));
            else if (i == j)
                ore_one(ore_at(&big, i, j));
        }
    ore_matrix_swap(m, &big);
}

static void multiply_into(struct ore_matrix *to, const struct ore_matrix *a, const struct ore_matrix *b)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix r = { 0 };
    ore_matrix_mul(&r, a, b);
    ore_matrix_swap(to, &r);
}

/* m diag(1, .., 1, e, 0, .., 0) */
static void times_diagonal(struct ore_matrix *m, const struct op_jacobson *f)
{
    for (int i = 0; i < m->rows; i++)
        for (int j = 0; j < m->cols; j++) {
            if (j >= f->rank)
                ore_zero(ore_at(m, i, j));
            else if (j == f->rank - 1)
                ore_mul(ore_at(m, i, j), ore_at(m, i, j), &f->e);
        }
}

/* P V = U^{-1} diag, U U^{-1} = 1, V V^{-1} = 1: together U P V = diag. */
static bool multiplies_out(const struct op_jacobson *f, const struct ore_matrix *P)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix a = { 0 }, b = { 0 };
    ore_matrix_mul(&a, P, &f->V);
    ore_matrix_set(&b, &f->U_inverse);
    times_diagonal(&b, f);
    bool ok = ore_matrix_equal(&a, &b);
    ore_matrix_mul(&a, &f->U, &f->U_inverse);
    ore_matrix_mul(&b, &f->V, &f->V_inverse);
    ok = ok && ore_matrix_is_identity(&a) && ore_matrix_is_identity(&b);
    return ok;
}

/* The coefficient matrices of R, as a system without sources. */
static void as_system(struct op_system *s, const struct ore_matrix *R)
{
    int order = ore_matrix_order(R);
    *s = (struct op_system){ .unknowns = R->rows, .order = order < 0 ? 0 : order };
    s->A = sga_calloc((size_t)s->order + 1, sizeof *s->A);
    ratio_matrix_init(&s->B, R->rows, 0);
    for (int k = 0; k <= s->order; k++) {
        ratio_matrix_init(s->A + k, R->rows, R->cols);
        for (int q = 0; q < R->rows * R->cols; q++)
            if (k < R->e[q].len)
                fmpz_poly_q_set(s->A[k].e + q, R->e[q].a + k);
    }
}

/* What is not torsion is split off first. */
static bool split_form(struct op_jacobson *f, const struct ore_matrix *P, const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(op_split_clear) struct op_split split = { 0 };
    SGA_ENDS(op_system_clear) struct op_system part = { 0 };
    SGA_ENDS(op_popov_clear) struct op_popov popov = { 0 };
    SGA_ENDS(op_state_clear) struct op_state state = { 0 };
    bool ok = op_split_off(&split, P, limits, err);
    f->transformations = true;
    if (ok && split.rank) {
        as_system(&part, &split.R);
        ok = op_popov_weak(&popov, &split.R, false, limits, err) && op_popov_finish(&popov, limits, err)
          && op_state_form(&state, &part, &popov, limits, err)
          && full_form(f, &popov, &split.R, &state, limits, err);
    }
    if (ok && f->transformations) {
        border(&f->U, P->rows);
        border(&f->U_inverse, P->rows);
        border(&f->V, P->cols);
        border(&f->V_inverse, P->cols);
        multiply_into(&f->U, &f->U, &split.U);
        multiply_into(&f->U_inverse, &split.U_inverse, &f->U_inverse);
        multiply_into(&f->V, &split.V, &f->V);
        multiply_into(&f->V_inverse, &f->V_inverse, &split.V_inverse);
        ok = op_within(limits, &f->U, err);
    }
    return ok;
}

bool op_jacobson_form(struct op_jacobson *f, const struct op_system *s, const struct op_popov *full, const struct op_state *x,
                      const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix P;
    *f = (struct op_jacobson){ 0 };
    op_system_matrix(s, &P);
    bool ok = full ? full_form(f, full, &P, x, limits, err) : split_form(f, &P, limits, err);
    if (ok && f->transformations && !multiplies_out(f, &P))
        ok = sga_fail(err, SGA_E_WITNESS, "the Jacobson form does not multiply out: this is a bug");
    if (!ok)
        op_jacobson_clear(f);
    return ok;
}

void op_jacobson_clear(struct op_jacobson *f)
{
    ore_matrix_clear(&f->U);
    ore_matrix_clear(&f->V);
    ore_matrix_clear(&f->U_inverse);
    ore_matrix_clear(&f->V_inverse);
    ore_clear(&f->e);
    *f = (struct op_jacobson){ 0 };
}
