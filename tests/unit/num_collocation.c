/* Radau IIA formulas: what defines them, in double-double, for every number of stages. */
#include "check.h"
#include "collocation.h"
#include "dd_lu.h"

#include <math.h>

static double off(num_dd a, num_dd b) { return fabs(num_dd_sub(a, b).hi); }

static num_dd power(num_dd x, int k)
{
    num_dd v = num_dd_of(1);
    while (k-- > 0)
        v = num_dd_mul(v, x);
    return v;
}

/* sum_j a_ij c_j^(k-1) = c_i^k / k up to k = s in every row, up to 2 s - 1 in the last one: Radau's order. */
static double moments(const struct num_radau *r, int i, int most)
{
    double worst = 0;
    for (int k = 1; k <= most; k++) {
        num_dd sum = num_dd_of(0);
        for (int j = 0; j < r->s; j++)
            sum = num_dd_add(sum, num_dd_mul(r->A[i * r->s + j], power(r->c[j], k - 1)));
        worst = fmax(worst, off(sum, num_dd_div(power(r->c[i], k), num_dd_of(k))));
    }
    return worst;
}

static double inverse_off(const struct num_radau *r)
{
    double worst = 0;
    for (int i = 0; i < r->s; i++)
        for (int j = 0; j < r->s; j++) {
            num_dd sum = num_dd_of(i == j ? -1 : 0);
            for (int k = 0; k < r->s; k++)
                sum = num_dd_add(sum, num_dd_mul_d(r->A[i * r->s + k], r->inverse[k * r->s + j]));
            worst = fmax(worst, fabs(sum.hi));
        }
    return worst;
}

/* Values of t^k between the nodes, k = 1 .. s. */
static double interpolation_off(const struct num_radau *r)
{
    num_dd weight[NUM_RADAU_MOST];
    double rough[NUM_RADAU_MOST], worst = 0;
    for (int q = 0; q < 7; q++) {
        num_dd theta = num_dd_div(num_dd_of(q), num_dd_of(6)), sum;
        num_radau_weights(r, theta, weight);
        num_radau_weights_double(r, theta.hi, rough);
        for (int k = 1; k <= r->s; k++) {
            sum = num_dd_of(0);
            for (int i = 0; i < r->s; i++)
                sum = num_dd_add(sum, num_dd_mul(weight[i], power(r->c[i], k)));
            worst = fmax(worst, off(sum, power(theta, k)));
        }
        for (int i = 0; i < r->s; i++)
            CHECK(fabs(rough[i] - weight[i].hi) <= 1e-12);
    }
    return worst;
}

/* The last coefficients of P_s + 2 P_(s-1) - 3 P_(s-2) (less its value at 0) are these. */
static double coefficients_off(const struct num_radau *r)
{
    int s = r->s;
    double worst = 0, should[NUM_RADAU_TAIL] = { 1, 2, -3 };
    num_dd z[NUM_RADAU_MOST];
    for (int i = 0; i < s; i++) {
        num_dd x = num_dd_sub(num_dd_scale(r->c[i], 2), num_dd_of(1)), p = num_dd_of(1), q = x, before = num_dd_of(0);
        for (int k = 1; k < s; k++) {
            num_dd next = num_dd_div(num_dd_sub(num_dd_mul_d(num_dd_mul(x, q), 2 * k + 1), num_dd_mul_d(p, k)), num_dd_of(k + 1));
            before = p;
            p = q;
            q = next;
        }
        z[i] = num_dd_add(num_dd_add(q, num_dd_scale(p, 2)), num_dd_mul_d(before, -3));
        z[i] = num_dd_sub(z[i], num_dd_of(s % 2 ? -1 + 2 + 3 : 1 - 2 - 3));
    }
    for (int k = 0; k < NUM_RADAU_TAIL; k++) {
        num_dd sum = num_dd_of(0);
        for (int i = 0; i < s; i++)
            sum = num_dd_add(sum, num_dd_mul(r->tail[k * s + i], z[i]));
        worst = fmax(worst, fabs(num_dd_sub(sum, num_dd_of(should[k])).hi));
    }
    return worst;
}

/* t^s has the leading coefficient s!^2 / (2 s)! of P_s on [0, 1]; t^(s-1) has none. */
static double tail_off(const struct num_radau *r)
{
    num_dd lead = num_dd_of(1), first = num_dd_of(0), none = num_dd_of(0);
    for (int k = 1; k <= r->s; k++)
        lead = num_dd_div(num_dd_mul_d(lead, k), num_dd_of(r->s + k));
    for (int i = 0; i < r->s; i++) {
        first = num_dd_add(first, num_dd_mul(r->tail[i], power(r->c[i], r->s)));
        none = num_dd_add(none, num_dd_mul(r->tail[i], power(r->c[i], r->s - 1)));
    }
    return fmax(off(first, lead), r->s > 1 ? fabs(none.hi) : 0);
}

/* One step of x' = (q/h) x from 1: solves X = 1 + q A X, and returns X_s. */
static num_dd step(const struct num_radau *r, num_dd q)
{
    int s = r->s, perm[NUM_RADAU_MOST];
    static num_dd M[NUM_RADAU_MOST * NUM_RADAU_MOST], one[NUM_RADAU_MOST], X[NUM_RADAU_MOST];
    for (int i = 0; i < s; i++) {
        one[i] = num_dd_of(1);
        for (int j = 0; j < s; j++)
            M[i * s + j] = num_dd_sub(num_dd_of(i == j), num_dd_mul(q, r->A[i * s + j]));
    }
    CHECK(num_dd_lu_factor(M, perm, s));
    num_dd_lu_solve(M, perm, s, one, X);
    return X[s - 1];
}

/* Errors of one step fall as h^(2 s); steps of fast rates damp, whatever their number of stages. */
static void order_and_damping(const struct num_radau *r)
{
    int s = r->s;
    double e[2];
    for (int k = 0; k < 2 && s <= 6; k++) {
        num_dd q = num_dd_of(k ? -0.0625 : -0.125);
        e[k] = off(step(r, q), num_dd_function(EXPR_EXP, q));
    }
    CHECK(s > 6 || fabs(log2(e[0] / e[1]) - 2 * s) < 0.2, "order %g for %d stages", log2(e[0] / e[1]) - 1, s);
    for (double q = 1e2; q < 1e16; q *= 10) {
        num_dd left = step(r, num_dd_of(-q));
        CHECK(fabs(left.hi) <= (q >= 1e6 ? 2.0 * s * s / q : 1), "%g left by %d stages at %g", left.hi, s, q);
    }
}

int main(void)
{
    for (int s = NUM_RADAU_LEAST; s <= NUM_RADAU_MOST; s++) {
        struct num_radau *r = num_radau_new(s);
        CHECK(r->c[s - 1].hi == 1 && r->c[s - 1].lo == 0 && r->c[0].hi > 0);
        for (int i = 1; i < s; i++)
            CHECK(num_dd_less(r->c[i - 1], r->c[i]));
        for (int i = 0; i < s; i++)
            CHECK(moments(r, i, i == s - 1 ? 2 * s - 1 : s) < 2e-31);
        CHECK(s > 8 || moments(r, s - 1, 2 * s) > 1e-12);     /* and no more */
        CHECK(inverse_off(r) < 1e-12);
        CHECK(interpolation_off(r) < 1e-30);
        CHECK(tail_off(r) < 1e-30);
        CHECK(s < 3 || coefficients_off(r) < 1e-28);
        order_and_damping(r);
        num_radau_free(r);
    }
    /* Radau IIA of order 3: c = 1/3, 1; A = (5/12, -1/12; 3/4, 1/4). */
    struct num_radau *r = num_radau_new(2);
    num_dd third = num_dd_div(num_dd_of(1), num_dd_of(3)), five = num_dd_div(num_dd_of(5), num_dd_of(12));
    CHECK(off(r->c[0], third) < 1e-32);
    CHECK(off(r->A[0], five) < 1e-32);
    CHECK(off(r->A[1], num_dd_div(num_dd_of(-1), num_dd_of(12))) < 1e-32);
    num_radau_free(r);
    flint_cleanup();
    return CHECK_END();
}
