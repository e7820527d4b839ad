/* Radau IIA formulas of any number of stages, from Legendre polynomials in balls. */
#include "collocation.h"

#include <arb.h>
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "lu.h"
#include "mem.h"

enum { BITS = 256, NEWTON = 3, SCAN = 60 };

/* p (last + 1): P_0 .. P_last at x in [-1, 1]. */
static void legendre(arb_ptr p, int last, const arb_t x)
{
    SGA_ENDS(arb_end) arb_t v = { 0 };
    arb_one(p);
    arb_set(p + 1, x);
    for (int k = 1; k < last; k++) {
        arb_mul(v, x, p + k, BITS);
        arb_mul_si(v, v, 2 * k + 1, BITS);
        arb_submul_si(v, p + k - 1, k, BITS);
        arb_div_si(p + k + 1, v, k + 1, BITS);
    }
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
    SGA_ARENA(mem);
    arb_ptr p = arbs_take(&mem, s + 1);
    SGA_ENDS(arb_end) arb_t f = { 0 }, d = { 0 }, e = { 0 }, square = { 0 };
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
    assert(arb_rel_accuracy_bits(a) > 110 || mag_cmp_2exp_si(arb_radref(a), -190) < 0);
    return v;
}

/* a_ij = sum_k (integral of P_k up to c_i) (2 k + 1) b_j P_k(c_j), b the weights of Radau's quadrature, which is
 * exact for products of the P_k with k < s: 1/b_j = sum_k (2 k + 1) P_k(c_j)^2. */
static void make_formula(struct num_radau *r, arb_srcptr x)
{
    int s = r->s, perm[NUM_RADAU_MOST];
    SGA_ARENA(mem);
    arb_ptr value = arbs_take(&mem, (slong)s * (s + 1)), integral = arbs_take(&mem, (slong)s * s);
    SGA_ENDS(arb_end) arb_t sum = { 0 }, b = { 0 };
    for (int i = 0; i < s; i++) {
        arb_ptr p = value + (slong)i * (s + 1), to = integral + (slong)i * s;
        legendre(p, s, x + i);
        for (int k = 0; k < s; k++, to++) {       /* times 2 k + 1 */
            if (k == 0)
                arb_add_si(to, x + i, 1, BITS);
            else
                arb_sub(to, p + k + 1, p + k - 1, BITS);
            arb_mul_2exp_si(to, to, -1);
        }
    }
    for (int j = 0; j < s; j++) {
        arb_srcptr p = value + (slong)j * (s + 1);
        arb_zero(b);
        for (int k = 0; k < s; k++) {
            arb_mul(sum, p + k, p + k, BITS);
            arb_addmul_si(b, sum, 2 * k + 1, BITS);
        }
        for (int i = 0; i < s; i++) {
            arb_dot(sum, NULL, 0, integral + (slong)i * s, 1, p, 1, s, BITS);
            arb_div(sum, sum, b, BITS);
            r->A[i * s + j] = rounded(sum);
        }
    }
    SGA_FREED double *lu = sga_malloc((size_t)s * (size_t)s * sizeof *lu);
    double unit[NUM_RADAU_MOST], column[NUM_RADAU_MOST];
    for (int k = 0; k < s * s; k++)
        lu[k] = r->A[k].hi;
    bool ok = num_lu_factor(lu, perm, s);
    assert(ok);
    for (int j = 0; j < s; j++) {
        for (int i = 0; i < s; i++)
            unit[i] = i == j;
        num_lu_solve(lu, perm, s, unit, column);
        for (int i = 0; i < s; i++)
            r->inverse[i * s + j] = column[i];
    }
}

/* The leading coefficient of P_k on [-1, 1]. */
static void leading(arb_t a, int k)
{
    arb_one(a);
    for (int i = 2; i <= k; i++) {
        arb_mul_si(a, a, 2 * i - 1, BITS);
        arb_div_si(a, a, i, BITS);
    }
}

/* Of the polynomial through the nodes and 0 (here -1, x_1, ..., x_s): it is sum_j w_j z_j prod_(k != j) (x - x_k), w the
 * barycentric weights, so that its coefficients of x^s, x^(s-1), x^(s-2) are sums of w_j z_j times 1, -e_1, e_2 of the other
 * nodes. P_s has those of L (x^s - s (s-1) / (2 (2 s - 1)) x^(s-2) + ...). */
static void make_polynomial(struct num_radau *r, arb_srcptr x)
{
    int s = r->s;
    SGA_ARENA(mem);
    arb_ptr node = arbs_take(&mem, s + 1);
    arb_t w, d, first, second, one, two, lead[NUM_RADAU_TAIL];
    arb_t *const own[] = { &w, &d, &first, &second, &one, &two, lead, lead + 1, lead + 2 };
    for (size_t k = 0; k < sizeof own / sizeof *own; k++)
        arb_init(*own[k]);
    arb_set_si(node, -1);
    for (int i = 0; i < s; i++)
        arb_set(node + 1 + i, x + i);
    for (int i = 0; i <= s; i++) {
        arb_addmul(second, first, node + i, BITS);
        arb_add(first, first, node + i, BITS);
    }
    for (int k = 0; k < NUM_RADAU_TAIL; k++)
        leading(lead[k], s - k);
    for (int i = 0; i <= s; i++) {
        arb_one(w);
        for (int k = 0; k <= s; k++)
            if (k != i) {
                arb_sub(d, node + i, node + k, BITS);
                arb_mul(w, w, d, BITS);
            }
        arb_inv(w, w, BITS);
        r->bary[i] = rounded(w);
        if (i == 0)
            continue;
        arb_sub(one, first, node + i, BITS);              /* e_1, e_2 without node i */
        arb_set(two, second);
        arb_submul(two, one, node + i, BITS);
        arb_div(d, w, lead[0], BITS);
        r->tail[i - 1] = rounded(d);
        arb_mul(d, w, one, BITS);
        arb_div(d, d, lead[1], BITS);
        arb_neg(d, d);
        r->tail[s + i - 1] = rounded(d);
        arb_set_si(d, (slong)s * (s - 1));
        arb_div_si(d, d, 2 * (2 * s - 1), BITS);
        arb_add(d, d, two, BITS);
        arb_mul(d, d, w, BITS);
        arb_div(d, d, lead[2], BITS);
        r->tail[2 * s + i - 1] = rounded(d);
    }
    for (size_t k = 0; k < sizeof own / sizeof *own; k++)
        arb_clear(*own[k]);
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
    SGA_ARENA(mem);
    arb_ptr x = arbs_take(&mem, s);
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
    assert(r->c[s - 1].hi == 1 && r->c[0].hi > 0);
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
    assert(r->s >= NUM_RADAU_LEAST && r->s <= NUM_RADAU_MOST);
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
