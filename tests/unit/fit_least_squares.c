/* Least squares: a linear problem, a nonlinear one of NIST's with certified values, bounds, directions that nothing is told of. */
#include <math.h>
#include <string.h>

#include "least_squares.h"
#include "check.h"

/* Misra1a (NIST StRD): y = b1 (1 - exp(-b2 x)). */
static const double Y[] = { 10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78 };
static const double X[] = { 77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0 };

static bool misra(void *ctx, const double *b, double *r, double *J)
{
    (void)ctx;
    for (int i = 0; i < 14; i++) {
        double e = exp(-b[1] * X[i]);
        r[i] = b[0] * (1 - e) - Y[i];
        J[2 * i] = 1 - e;
        J[2 * i + 1] = b[0] * X[i] * e;
    }
    return true;
}

static void nist(const double *guess)
{
    double low[] = { -INFINITY, -INFINITY }, high[] = { INFINITY, INFINITY };
    struct fit_problem q = { .m = 14, .p = 2, .low = low, .high = high, .value = misra, .unsure = 1e-15, .most = 200 };
    struct fit_result r;
    struct fit_spread s;
    fit_least_squares(&q, guess, &r);
    CHECK(r.status == FIT_CONVERGED);
    CHECK(fabs(r.x[0] / 2.3894212918e+02 - 1) < 1e-9);
    CHECK(fabs(r.x[1] / 5.5015643181e-04 - 1) < 1e-9);
    CHECK(fabs(r.sum / 1.2455138894e-01 - 1) < 1e-9);
    fit_spread_of(&(struct fit_at){ .size = r.size, .J = r.J, .bound = r.bound, .unsure = 1e-15 }, 14, 2, &s);
    CHECK(s.rank == 2 && s.told[0] && s.told[1]);
    CHECK(fabs(sqrt(s.covariance[0] * r.sum / 12) / 2.7070075241 - 1) < 1e-8);
    CHECK(fabs(sqrt(s.covariance[3] * r.sum / 12) / 7.2668688436e-06 - 1) < 1e-8);
    fit_spread_clear(&s);
    fit_result_clear(&r);
}

static void bounds(void)
{
    double low[] = { 0, 6e-4 }, high[] = { INFINITY, 1 }, guess[] = { 200, 1e-3 };
    struct fit_problem q = { .m = 14, .p = 2, .low = low, .high = high, .value = misra, .unsure = 1e-15, .most = 200 };
    struct fit_result r;
    fit_least_squares(&q, guess, &r);
    CHECK(r.status == FIT_CONVERGED && r.x[1] == 6e-4 && r.bound[1] && !r.bound[0]);
    double num = 0, den = 0;        /* the other one is a linear fit */
    for (int i = 0; i < 14; i++) {
        num += Y[i] * (1 - exp(-6e-4 * X[i]));
        den += pow(1 - exp(-6e-4 * X[i]), 2);
    }
    CHECK(fabs(r.x[0] / (num / den) - 1) < 1e-8);
    fit_result_clear(&r);
}

/* a b and c: only the product is told, and nothing of d. */
static bool product(void *ctx, const double *b, double *r, double *J)
{
    (void)ctx;
    memset(J, 0, 3 * 4 * sizeof *J);
    for (int i = 0; i < 3; i++) {
        r[i] = b[0] * b[1] * i + b[2] - (6 * i + 1);
        J[4 * i] = b[1] * i;
        J[4 * i + 1] = b[0] * i;
        J[4 * i + 2] = 1;
    }
    return true;
}

static void not_told(void)
{
    double low[] = { -INFINITY, -INFINITY, -INFINITY, -INFINITY }, high[] = { INFINITY, INFINITY, INFINITY, INFINITY }, guess[] = { 1, 2, 0, 5 };
    struct fit_problem q = { .m = 3, .p = 4, .low = low, .high = high, .value = product, .unsure = 1e-15, .noise = 1e-12, .most = 200 };
    struct fit_result r;
    struct fit_spread s;
    fit_least_squares(&q, guess, &r);
    CHECK(r.status == FIT_CONVERGED);
    CHECK(fabs(r.x[0] * r.x[1] - 6) < 1e-9 && fabs(r.x[2] - 1) < 1e-9 && r.x[3] == 5);
    fit_spread_of(&(struct fit_at){ .size = r.size, .J = r.J, .bound = r.bound, .unsure = 1e-15 }, 3, 4, &s);
    CHECK(s.rank == 2 && !s.told[0] && !s.told[1] && s.told[2] && !s.told[3]);
    fit_spread_clear(&s);
    fit_result_clear(&r);
}

/* A line through 0, whose constant is 0 but for the last digits: its value says nothing about whether it is told. */
static bool line(void *ctx, const double *b, double *r, double *J)
{
    (void)ctx;
    for (int i = 0; i < 4; i++) {
        r[i] = b[0] + b[1] * i - 3 * i - 1e-13;
        J[2 * i] = 1;
        J[2 * i + 1] = i;
    }
    return true;
}

static void value_near_0(void)
{
    double low[] = { -INFINITY, -INFINITY }, high[] = { INFINITY, INFINITY };
    double guess[][2] = { { 0, 0 }, { 1, 1 }, { 1e-13, 3 }, { 0, 3 } };
    for (int k = 0; k < 4; k++) {
        struct fit_problem q = { .m = 4, .p = 2, .low = low, .high = high, .value = line, .unsure = 1e-15, .noise = 1e-11, .most = 200 };
        struct fit_result r;
        struct fit_spread s;
        fit_least_squares(&q, guess[k], &r);
        CHECK(r.status == FIT_CONVERGED && fabs(r.x[0]) < 1e-8 && fabs(r.x[1] - 3) < 1e-8);
        fit_spread_of(&(struct fit_at){ .size = r.size, .J = r.J, .bound = r.bound, .unsure = 1e-15, .noise = 1e-11 }, 4, 2, &s);
        CHECK(k == 2 || (s.rank == 2 && s.told[0] && s.told[1]));       /* a guess of 1e-13 says that this is its size */
        fit_spread_clear(&s);
        fit_result_clear(&r);
    }
}

/* The second column is rounding errors: what is left of the data must not be explained by it. */
static bool errors(void *ctx, const double *b, double *r, double *J)
{
    static const double rest[] = { 0.1, -0.3, 0.2, 0.1 }, off[] = { 3e-15, -7e-15, 2e-15, 5e-15 };
    (void)ctx;
    for (int i = 0; i < 4; i++) {
        r[i] = exp(b[0] * i) - exp(0.5 * i) - rest[i];
        J[2 * i] = i * exp(b[0] * i);
        J[2 * i + 1] = off[i];
    }
    return true;
}

static void column_of_errors(void)
{
    double low[] = { -INFINITY, -INFINITY }, high[] = { INFINITY, INFINITY }, guess[] = { 0.4, 2 }, other[] = { 0.4, 0 };
    struct fit_problem q = { .m = 4, .p = 2, .low = low, .high = high, .value = errors, .unsure = 1e-9, .noise = 1e-10, .most = 200 };
    for (int k = 0; k < 2; k++) {
        const double *x = k ? other : guess;
        struct fit_result r;
        struct fit_spread s;
        fit_least_squares(&q, x, &r);
        CHECK(r.status == FIT_CONVERGED && r.x[1] == x[1] && fabs(r.x[0] - 0.5) < 0.02);
        fit_spread_of(&(struct fit_at){ .size = r.size, .J = r.J, .bound = r.bound, .unsure = 1e-9, .noise = 1e-10 }, 4, 2, &s);
        CHECK(s.rank == 1 && s.told[0] && !s.told[1]);
        fit_spread_clear(&s);
        fit_result_clear(&r);
    }
}

static bool nowhere(void *ctx, const double *b, double *r, double *J)
{
    (void)ctx;
    r[0] = sqrt(-1 - b[0] * b[0]);
    J[0] = 1;
    return true;
}

static void no_value(void)
{
    double low[] = { -INFINITY }, high[] = { INFINITY }, guess[] = { 1 };
    struct fit_problem q = { .m = 1, .p = 1, .low = low, .high = high, .value = nowhere, .most = 20 };
    struct fit_result r;
    fit_least_squares(&q, guess, &r);
    CHECK(r.status == FIT_NO_VALUE);
    fit_result_clear(&r);
}

int main(void)
{
    double far[] = { 500, 1e-4 }, near[] = { 250, 5e-4 };
    nist(far);
    nist(near);
    bounds();
    not_told();
    value_near_0();
    column_of_errors();
    no_value();
    return CHECK_END();
}
