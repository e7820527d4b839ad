/* See the header. */
#include "ball_solve.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball_matrix.h"
#include "least_singular.h"
#include "lin_lu.h"
#include "lin_sparse.h"
#include "mem.h"

enum { GUARD_BITS = 30 };          /* of the corrections, beyond those asked for */

struct system {
    struct num_ball_matrix a;
    struct lin_lu *lu;
    double least;                  /* a lower bound of the least singular value of every matrix in the balls; 0: not looked for yet */
    slong prec;
    int m;
    arb_ptr right;                 /* the right side in units of rows */
    arf_struct *y;                 /* the approximation in those of columns, exact numbers */
};

/* r = right - B y in balls, with the entries as they are; size: a bound of its norm, radius: of that of its radii. */
static void what_is_left(const struct system *w, arb_ptr r, mag_t size, mag_t radius)
{
    SGA_ENDS(arb_end) arb_t y = { 0 };
    SGA_ENDS(mag_end) mag_t one = { 0 };
    mag_zero(size);
    mag_zero(radius);
    for (int i = 0; i < w->m; i++) {
        arb_zero(r + i);
        for (int k = w->a.B->ptr[i]; k < w->a.B->ptr[i + 1]; k++) {
            int j = w->a.B->col[k];
            arf_mul_2exp_si(arb_midref(y), w->y + j, w->a.column[j]);
            arb_submul(r + i, w->a.entry[k], y, w->prec);
        }
        arb_mul_2exp_si(r + i, r + i, w->a.row[i]);
        arb_add(r + i, r + i, w->right + i, w->prec);
        arb_get_mag(one, r + i);
        mag_addmul(size, one, one);
        mag_addmul(radius, arb_radref(r + i), arb_radref(r + i));
    }
    mag_sqrt(size, size);
    mag_sqrt(radius, radius);
}

/* y += B^-1 r, in doubles. False: out of their range. */
static bool correct(struct system *w, arb_srcptr r, const mag_t size, double *d)
{
    slong unit = -MAG_EXP(size);       /* brings it to about 1 */
    if (mag_is_special(size) || COEFF_IS_MPZ(MAG_EXP(size)))
        return false;
    SGA_ENDS(arf_end) arf_t v = { 0 };
    for (int i = 0; i < w->m; i++) {
        arf_mul_2exp_si(v, arb_midref(r + i), unit);
        d[i] = arf_get_d(v, ARF_RND_NEAR);
    }
    lin_lu_solve(w->lu, d);
    if (!lin_all_finite(w->m, d))
        return false;
    for (int i = 0; i < w->m; i++) {
        arf_set_d(v, d[i]);
        arf_mul_2exp_si(v, v, -unit);
        arf_add(w->y + i, w->y + i, v, w->prec, ARF_RND_NEAR);
    }
    return true;
}

/* Corrections until what is left falls no more; size: a bound of its norm. False: it does not fall to roundings. */
static bool approximate(struct system *w, mag_t size)
{
    SGA_ARENA(mem);
    SGA_ENDS(mag_end) mag_t radius = { 0 }, before = { 0 };
    double *d = sga_take(&mem, (size_t)w->m * sizeof *d);
    bool ok = true;
    int most = 4 + (int)(w->prec / 8);
    arb_ptr r = _arb_vec_init(w->m);
    mag_inf(before);
    bool more = true;
    for (int turn = 0; more; turn++) {
        what_is_left(w, r, size, radius);
        mag_mul_2exp_si(radius, radius, 2);
        bool rounding = mag_cmp(size, radius) <= 0;
        mag_mul_2exp_si(radius, size, 1);
        bool falls = mag_cmp(radius, before) < 0;
        mag_set(before, size);
        ok = mag_is_finite(size) && (rounding || (falls && turn < most));
        more = ok && !rounding && correct(w, r, size, d);
        ok = ok && (rounding || more);
    }
    _arb_vec_clear(r, w->m);
    return ok;
}

/* y (m) of the right side of these nodes' values; EXPR_NONE: 0. */
static bool solve(struct system *w, const struct num_ball *b, const expr_id *right, arb_ptr y)
{
    SGA_ENDS(mag_end) mag_t size = { 0 }, least = { 0 };
    for (int i = 0; i < w->m; i++) {
        if (right[i] == EXPR_NONE)
            arb_zero(w->right + i);
        else
            arb_mul_2exp_si(w->right + i, b->value + right[i], w->a.row[i]);
        arf_zero(w->y + i);
    }
    if (!approximate(w, size))
        return false;
    if (w->least == 0)
        w->least = num_least_singular(w->a.B, NULL) - w->a.error;
    if (!(w->least > 0))
        return false;
    mag_set_d_lower(least, w->least * (1 - 1e-9));
    mag_div(size, size, least);
    for (int j = 0; j < w->m; j++) {
        arf_set(arb_midref(y + j), w->y + j);
        mag_set(arb_radref(y + j), size);
        arb_mul_2exp_si(y + j, y + j, w->a.column[j]);
        arb_set_round(y + j, y + j, b->prec);
    }
    return true;
}

/* [S u; v d] y = [r; e] with z = S^-1 u and q = S^-1 r: the last unknown is (e - v q) / (d - v z), the others are q less that times z. */
static bool solve_bordered(struct system *w, const struct num_ball *b, const struct expr_solve *s, arb_ptr y)
{
    int n = w->m;
    SGA_FREED expr_id *last = sga_malloc((size_t)(n + 1) * sizeof *last);       /* column */
    for (int i = 0; i <= n; i++) {
        int end = s->matrix.start[i + 1] - 1;
        last[i] = end >= s->matrix.start[i] && s->matrix.column[end] == n ? s->matrix.entry[end] : EXPR_NONE;
    }
    SGA_ENDS(arb_end) arb_t over = { 0 }, under = { 0 };
    arb_ptr z = _arb_vec_init(n);
    bool ok = solve(w, b, last, z) && solve(w, b, s->rhs, y);
    if (ok) {
        arb_set(over, b->value + s->rhs[n]);
        if (last[n] != EXPR_NONE)
            arb_set(under, b->value + last[n]);
        for (int k = s->matrix.start[n]; k < s->matrix.start[n + 1] && s->matrix.column[k] < n; k++) {
            arb_submul(over, b->value + s->matrix.entry[k], y + s->matrix.column[k], w->prec);
            arb_submul(under, b->value + s->matrix.entry[k], z + s->matrix.column[k], w->prec);
        }
        ok = !arb_contains_zero(under);
    }
    if (ok) {
        arb_div(y + n, over, under, b->prec);
        for (int k = 0; k < n; k++)
            arb_submul(y + k, y + n, z + k, b->prec);
    }
    _arb_vec_clear(z, n);
    return ok;
}

/* A last row and a last column that are filled, of a matrix that is not: the product of the matrix with its transpose would be full. */
static bool is_bordered(const struct num_ball *b, const struct expr_solve *s)
{
    const struct expr_rows *a = &s->matrix;
    int row = 0, column = 0;
    for (int i = 0; i < s->m; i++)
        for (int k = a->start[i]; k < a->start[i + 1]; k++) {
            bool last_row = i == s->m - 1, last_column = a->column[k] == s->m - 1;
            if (last_row == last_column || arb_is_zero(b->value + a->entry[k]))
                continue;
            row += last_row;
            column += last_column;
        }
    return 2 * row > s->m && 2 * column > s->m;
}

bool num_ball_solve_sparse(const struct num_ball *b, const struct expr_solve *s, arb_ptr y)
{
    if (s->m <= NUM_BALL_MATRIX_ROWS)
        return false;
    bool bordered = is_bordered(b, s), ok;
    struct system w = { .prec = b->prec + GUARD_BITS, .m = s->m - bordered };
    ok = num_ball_matrix_init(&w.a, b, w.m, w.m, &s->matrix);
    if (ok) {
        SGA_ARENA(mem);
        w.right = _arb_vec_init(w.m);
        w.y = sga_zeros(&mem, (size_t)w.m, sizeof *w.y);
        w.lu = lin_lu_new(w.a.B);
        ok = lin_lu_factor(w.lu, w.a.B->val) && (bordered ? solve_bordered(&w, b, s, y) : solve(&w, b, s->rhs, y));
        for (int j = 0; j < w.m; j++)
            arf_clear(w.y + j);
        _arb_vec_clear(w.right, w.m);
        lin_lu_free(w.lu);
    }
    num_ball_matrix_clear(&w.a);
    return ok;
}
