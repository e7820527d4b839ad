/* The Kalman state form, read off the Popov form (section 5 of the source).
 *
 * Row j of the Popov form ends in y_j^(d_j), all other terms being y_k^(l) with l < d_k: so the
 * y_k^(l), l < d_k, span [y]/[e]. Derivatives of e in the dynamics are taken away one order
 * after the other, x = x_new + G_a e^(a-1). */
#include "operator.h"

#include <stdlib.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "popov.h"

struct raw {                       /* before the derivatives of e leave the dynamics */
    struct ratio_matrix *G, *J;    /* top + 1 of each */
    int top;
    int *base;                     /* by unknown: its first component of x */
};

void op_system_clear(struct op_system *s)
{
    for (int i = 0; i <= s->order && s->A; i++)
        ratio_matrix_clear(s->A + i);
    free(s->A);
    ratio_matrix_clear(&s->B);
    *s = (struct op_system){ 0 };
}

void op_system_matrix(const struct op_system *s, struct ore_matrix *m)
{
    ore_matrix_init(m, s->unknowns, s->unknowns);
    for (int k = 0; k <= s->order; k++)
        for (int q = 0; q < s->unknowns * s->unknowns; q++)
            if (!fmpz_poly_q_is_zero(s->A[k].e + q))
                ore_add_term(m->e + q, s->A[k].e + q, k);
}

void op_right_side(struct ore_matrix *W, const struct op_system *s, const struct op_popov *p)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix B;
    ore_matrix_init(&B, s->unknowns, s->sources);
    for (int k = 0; k < s->unknowns * s->sources; k++)
        if (!fmpz_poly_q_is_zero(s->B.e + k))
            ore_add_term(B.e + k, s->B.e + k, 0);
    ore_matrix_mul(W, &p->U, &B);
}

/* row of m = - (terms of row j of R below the pivots), in the components of x */
static void lower_terms(struct ratio_matrix *m, int row, const struct op_popov *p, int j, const int *base)
{
    for (int k = 0; k < p->R.cols; k++) {
        const struct ore *x = ore_at(&p->R, j, k);
        for (int l = 0; l < x->len && l < p->order[k]; l++)
            fmpz_poly_q_neg(ratio_at(m, row, base[k] + l), x->a + l);
    }
}

static void read_off(struct op_state *x, struct raw *r, const struct op_popov *p, const struct ore_matrix *W)
{
    for (int j = 0; j < p->rank; j++) {        /* full rank: the pivot of row j is in column j */
        int d = p->order[j], last = r->base[j] + d - 1;
        struct ratio_matrix *to = d ? r->G : r->J;
        for (int l = 0; l < d; l++) {
            x->unknown[r->base[j] + l] = j;
            x->derivative[r->base[j] + l] = l;
            if (l + 1 < d)
                fmpz_poly_q_one(ratio_at(&x->F, r->base[j] + l, r->base[j] + l + 1));
        }
        lower_terms(d ? &x->F : &x->H, d ? last : j, p, j, r->base);
        if (d)
            fmpz_poly_q_one(ratio_at(&x->H, j, r->base[j]));
        for (int q = 0; q < W->cols; q++)
            for (int v = 0; v < ore_at(W, j, q)->len; v++)
                fmpz_poly_q_set(ratio_at(to + v, d ? last : j, q), ore_at(W, j, q)->a + v);
    }
}

/* x + G_a e^(a-1) in place of x, a = top, .., 1 */
static void lower_sources(struct op_state *x, struct raw *r)
{
    SGA_ENDS(ratio_matrix_clear) struct ratio_matrix d = { 0 };
    for (int a = r->top; a > 0; a--) {
        ratio_matrix_addmul(r->G + a - 1, &x->F, r->G + a);
        ratio_matrix_derive(&d, r->G + a);
        ratio_matrix_sub(r->G + a - 1, &d);
        ratio_matrix_addmul(r->J + a - 1, &x->H, r->G + a);
    }
}

/* sum A_i y^(i) = B e, with y^(i) = H_i x + sum J_iv e^(v) */
static bool substitute(const struct op_state *x, const struct op_system *s)
{
    int top = x->degree + s->order + 2;
    SGA_ARENA(mem);
    SGA_ENDS(ratio_matrix_clear) struct ratio_matrix H = { 0 }, d = { 0 }, left;
    struct ratio_matrix *J = sga_zeros(&mem, (size_t)top, sizeof *J), *sum = sga_zeros(&mem, (size_t)top, sizeof *sum);
    ratio_matrix_init(&left, s->unknowns, x->n);
    ratio_matrix_set(&H, &x->H);
    for (int v = 0; v < top; v++) {
        ratio_matrix_init(J + v, s->unknowns, s->sources);
        ratio_matrix_init(sum + v, s->unknowns, s->sources);
        if (v <= x->degree)
            ratio_matrix_set(J + v, x->J + v);
    }
    for (int i = 0; i <= s->order; i++) {
        ratio_matrix_addmul(&left, s->A + i, &H);
        for (int v = 0; v < top; v++)
            ratio_matrix_addmul(sum + v, s->A + i, J + v);
        for (int v = top - 1; v >= 0; v--) {       /* the derivative of H x + sum J_v e^(v) */
            ratio_matrix_derive(&d, J + v);
            ratio_matrix_set(J + v, &d);
            if (v)
                ratio_matrix_add(J + v, J + v - 1);
            else
                ratio_matrix_addmul(J, &H, &x->G);
        }
        ratio_matrix_derive(&d, &H);
        ratio_matrix_addmul(&d, &H, &x->F);
        ratio_matrix_swap(&H, &d);
    }
    bool ok = ratio_matrix_is_zero(&left) && ratio_matrix_equal(sum, &s->B);
    for (int v = 1; v < top; v++)
        ok = ok && ratio_matrix_is_zero(sum + v);
    for (int v = 0; v < top; v++) {
        ratio_matrix_clear(J + v);
        ratio_matrix_clear(sum + v);
    }
    return ok;
}

bool op_state_form(struct op_state *x, const struct op_system *s, const struct op_popov *p,
                   const struct op_limits *limits, struct sga_error *err)
{
    SGA_ENDS(ore_matrix_clear) struct ore_matrix W = { 0 };
    struct raw r = { .base = sga_calloc((size_t)s->unknowns + 1, sizeof *r.base) };
    *x = (struct op_state){ 0 };
    for (int j = 0; j < s->unknowns; j++) {
        r.base[j] = x->n;
        x->n += p->order[j];
    }
    op_right_side(&W, s, p);
    r.top = ore_matrix_order(&W) > 0 ? ore_matrix_order(&W) : 0;
    r.G = sga_calloc((size_t)r.top + 1, sizeof *r.G);
    r.J = sga_calloc((size_t)r.top + 1, sizeof *r.J);
    for (int v = 0; v <= r.top; v++) {
        ratio_matrix_init(r.G + v, x->n, s->sources);
        ratio_matrix_init(r.J + v, s->unknowns, s->sources);
    }
    x->unknown = sga_calloc((size_t)x->n + 1, sizeof *x->unknown);
    x->derivative = sga_calloc((size_t)x->n + 1, sizeof *x->derivative);
    ratio_matrix_init(&x->F, x->n, x->n);
    ratio_matrix_init(&x->H, s->unknowns, x->n);
    read_off(x, &r, p, &W);
    lower_sources(x, &r);
    x->G = r.G[0];
    x->J = r.J;
    x->degree = r.top;
    while (x->degree >= 0 && ratio_matrix_is_zero(x->J + x->degree))
        ratio_matrix_clear(x->J + x->degree--);
    for (int v = 1; v <= r.top; v++)
        ratio_matrix_clear(r.G + v);
    free(r.G);
    free(r.base);
    bool ok = op_within(limits, NULL, err);
    if (ok && !substitute(x, s))
        ok = sga_fail(err, SGA_E_WITNESS, "the state form does not satisfy the system: this is a bug");
    if (!ok)
        op_state_clear(x);
    return ok;
}

bool op_state_leading(const struct op_state *x, int *order, struct ratio_matrix *leading)
{
    *leading = (struct ratio_matrix){ 0 };
    if (x->degree >= 0) {
        *order = -x->degree;
        ratio_matrix_set(leading, x->J + x->degree);
        return true;
    }
    SGA_ENDS(ratio_matrix_clear) struct ratio_matrix H = { 0 }, d = { 0 };
    bool found = false;
    ratio_matrix_set(&H, &x->H);
    for (int k = 1; k <= x->n && !found; k++) {
        ratio_matrix_clear(leading);
        ratio_matrix_init(leading, H.rows, x->G.cols);
        ratio_matrix_addmul(leading, &H, &x->G);
        found = !ratio_matrix_is_zero(leading);
        *order = k;
        ratio_matrix_derive(&d, &H);
        ratio_matrix_addmul(&d, &H, &x->F);
        ratio_matrix_swap(&H, &d);
    }
    if (!found)
        ratio_matrix_clear(leading);
    return found;
}

void op_state_clear(struct op_state *x)
{
    ratio_matrix_clear(&x->F);
    ratio_matrix_clear(&x->G);
    ratio_matrix_clear(&x->H);
    for (int v = 0; v <= x->degree && x->J; v++)
        ratio_matrix_clear(x->J + v);
    free(x->J);
    free(x->unknown);
    free(x->derivative);
    *x = (struct op_state){ 0 };
}
