/* Radau IIA formulas of any number of stages, from Legendre polynomials in balls. */
#include "collocation.h"

#include <arb_mat.h>
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "mem.h"

enum { BITS = 768, NEWTON = 8, SCAN = 60 };

/* p (last + 1): P_0 .. P_last at x in [-1, 1]. */
static void legendre(arb_ptr p, int last, const arb_t x)
{
    arb_t v;
    arb_init(v);
    arb_one(p);
    arb_set(p + 1, x);
    for (int k = 1; k < last; k++) {
        arb_mul(v, x, p + k, BITS);
        arb_mul_si(v, v, 2 * k + 1, BITS);
        arb_submul_si(v, p + k - 1, k, BITS);
        arb_div_si(p + k + 1, v, k + 1, BITS);
    }
    arb_clear(v);
}

/* (P_s - P_(s-1)) / (x - 1): its zeros are the nodes but 1. */
static double radau_value(int s, double x)
{
    double a = 1, b = x;
    for (int k = 1; k < s; k++) {
        double next = ((2 * k + 1) * x * b - k * a) / (k + 1);
        a = b;
        b = next;
    }
    return (b - a) / (x - 1);
}

/* x becomes the zero of P_s - P_(s-1) near x0; s P_s: (x^2 - 1) P_s' = s (x P_s - P_(s-1)). */
static void polish(arb_t x, double x0, int s)
{
    arb_ptr p = _arb_vec_init(s + 1);
    arb_t f, d, e, square;
    arb_init(f);
    arb_init(d);
    arb_init(e);
    arb_init(square);
    arb_set_d(x, x0);
    for (int k = 0; k < NEWTON; k++) {
        legendre(p, s, x);
        arb_sub(f, p + s, p + s - 1, BITS);
        arb_mul(square, x, x, BITS);
        arb_sub_si(square, square, 1, BITS);
        arb_mul(d, x, p + s, BITS);
        arb_sub(d, d, p + s - 1, BITS);
        arb_mul_si(d, d, s, BITS);
        arb_mul(e, x, p + s - 1, BITS);
        arb_sub(e, e, p + s - 2, BITS);
        arb_submul_si(d, e, s - 1, BITS);
        arb_mul(f, f, square, BITS);
        arb_div(f, f, d, BITS);
        arb_sub(x, x, f, BITS);
        arb_get_mid_arb(x, x);
    }
    assert(fabs(arf_get_d(arb_midref(x), ARF_RND_NEAR) - x0) < 1e-9);
    assert(arf_cmpabs_2exp_si(arb_midref(f), -BITS / 2) < 0);     /* the last step: converged */
    _arb_vec_clear(p, s + 1);
    arb_clear(f);
    arb_clear(d);
    arb_clear(e);
    arb_clear(square);
}

/* x (s): the nodes on [-1, 1], ascending. */
static void find_nodes(arb_ptr x, int s)
{
    int found = 0;
    double before = -1, value = radau_value(s, -1);
    for (int k = 1; k < SCAN * s && found < s - 1; k++) {
        double here = -cos(M_PI * k / (SCAN * s)), v = radau_value(s, here);
        if (value * v < 0) {
            double low = before, high = here;
            for (int i = 0; i < 60; i++) {
                double middle = 0.5 * (low + high);
                *(radau_value(s, middle) * value > 0 ? &low : &high) = middle;
            }
            polish(x + found++, 0.5 * (low + high), s);
        }
        before = here;
        value = v;
    }
    assert(found == s - 1);
    arb_one(x + s - 1);
}

static num_dd rounded(const arb_t a)
{
    mpfr_t m;
    mpfr_init2(m, BITS);
    arf_get_mpfr(m, arb_midref(a), MPFR_RNDN);
    num_dd v = num_dd_set_mpfr(m);
    mpfr_clear(m);
    assert(arb_rel_accuracy_bits(a) > 120 || arb_is_zero(a));
    return v;
}

/* a_ij: integrals of the Legendre polynomials up to x_i, times the inverse of their values. */
static void make_formula(struct num_radau *r, arb_srcptr x)
{
    int s = r->s;
    arb_mat_t value, integral, a;
    arb_ptr p = _arb_vec_init(s + 1);
    arb_mat_init(value, s, s);
    arb_mat_init(integral, s, s);
    arb_mat_init(a, s, s);
    for (int i = 0; i < s; i++) {
        legendre(p, s, x + i);
        for (int k = 0; k < s; k++) {
            arb_set(arb_mat_entry(value, i, k), p + k);
            arb_ptr to = arb_mat_entry(integral, i, k);
            if (k == 0)
                arb_add_si(to, x + i, 1, BITS);
            else
                arb_sub(to, p + k + 1, p + k - 1, BITS);
            arb_div_si(to, to, 2 * (2 * k + 1), BITS);
        }
    }
    bool ok = arb_mat_inv(value, value, BITS);
    arb_mat_mul(a, integral, value, BITS);
    for (int i = 0; i < s * s; i++)
        r->A[i] = rounded(arb_mat_entry(a, i / s, i % s));
    ok &= arb_mat_inv(a, a, BITS);
    for (int i = 0; i < s * s; i++)
        r->inverse[i] = rounded(arb_mat_entry(a, i / s, i % s)).hi;
    assert(ok);
    _arb_vec_clear(p, s + 1);
    arb_mat_clear(value);
    arb_mat_clear(integral);
    arb_mat_clear(a);
}

/* Of the polynomials with the node 0 too. */
static void make_polynomial(struct num_radau *r, arb_srcptr x)
{
    int s = r->s;
    arb_mat_t value;
    arb_ptr p = _arb_vec_init(s + 1), node = _arb_vec_init(s + 1);
    arb_t w, d;
    arb_init(w);
    arb_init(d);
    arb_mat_init(value, s + 1, s + 1);
    arb_set_si(node, -1);
    for (int i = 0; i < s; i++)
        arb_set(node + 1 + i, x + i);
    for (int i = 0; i <= s; i++) {
        legendre(p, s, node + i);
        for (int k = 0; k <= s; k++)
            arb_set(arb_mat_entry(value, i, k), p + k);
        arb_one(w);
        for (int k = 0; k <= s; k++)
            if (k != i) {
                arb_sub(d, node + i, node + k, BITS);
                arb_mul(w, w, d, BITS);
            }
        arb_inv(w, w, BITS);
        r->bary[i] = rounded(w);
    }
    bool ok = arb_mat_inv(value, value, BITS);
    assert(ok);
    for (int k = 0; k < NUM_RADAU_TAIL; k++)
        for (int i = 0; i < s; i++)
            r->tail[k * s + i] = k <= s ? rounded(arb_mat_entry(value, s - k, i + 1)) : num_dd_of(0);
    _arb_vec_clear(p, s + 1);
    _arb_vec_clear(node, s + 1);
    arb_clear(w);
    arb_clear(d);
    arb_mat_clear(value);
}

struct num_radau *num_radau_new(int s)
{
    assert(s >= NUM_RADAU_LEAST && s <= NUM_RADAU_MOST);
    struct num_radau *r = sga_calloc(1, sizeof *r);
    size_t n = (size_t)s;
    r->s = s;
    r->c = sga_calloc(n, sizeof *r->c);
    r->A = sga_calloc(n * n, sizeof *r->A);
    r->inverse = sga_calloc(n * n, sizeof *r->inverse);
    r->bary = sga_calloc(n + 1, sizeof *r->bary);
    r->tail = sga_calloc(NUM_RADAU_TAIL * n, sizeof *r->tail);
    arb_ptr x = _arb_vec_init(s);
    arb_t c;
    arb_init(c);
    find_nodes(x, s);
    for (int i = 0; i < s; i++) {
        arb_add_si(c, x + i, 1, BITS);
        arb_mul_2exp_si(c, c, -1);
        r->c[i] = rounded(c);
    }
    make_formula(r, x);
    make_polynomial(r, x);
    arb_clear(c);
    _arb_vec_clear(x, s);
    return r;
}

void num_radau_free(struct num_radau *r)
{
    if (!r)
        return;
    free(r->c);
    free(r->A);
    free(r->inverse);
    free(r->bary);
    free(r->tail);
    free(r);
}

void num_radau_weights(const struct num_radau *r, num_dd theta, num_dd *weight)
{
    num_dd sum = num_dd_of(0);
    int exact = -1;
    for (int i = -1; i < r->s; i++) {
        num_dd d = i < 0 ? theta : num_dd_sub(theta, r->c[i]);
        if (d.hi == 0)
            exact = i + 1;
        num_dd v = d.hi == 0 ? num_dd_of(0) : num_dd_div(r->bary[i + 1], d);
        sum = num_dd_add(sum, v);
        if (i >= 0)
            weight[i] = v;
    }
    for (int i = 0; i < r->s; i++)
        weight[i] = exact >= 0 ? num_dd_of(i + 1 == exact) : num_dd_div(weight[i], sum);
}

void num_radau_weights_double(const struct num_radau *r, double theta, double *weight)
{
    double sum = theta != 0 ? r->bary[0].hi / theta : 0;
    int exact = theta != 0 ? -1 : 0;
    for (int i = 0; i < r->s; i++) {
        double d = theta - r->c[i].hi;
        exact = d == 0 ? i + 1 : exact;
        weight[i] = d != 0 ? r->bary[i + 1].hi / d : 0;
        sum += weight[i];
    }
    for (int i = 0; i < r->s; i++)
        weight[i] = exact >= 0 ? i + 1 == exact : weight[i] / sum;
}
