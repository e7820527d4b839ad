/* Inside the ode folder: sums over the stages of explicit Runge-Kutta methods.
 *
 * The tables are constants that the compiler sees, so that each sum becomes straight code.
 * Vectors are kept in pairs of doubles, the last one filled up with zeros, and the sums run
 * on both at once. Up to RK_NEAR variables the stages lie a fixed distance apart: then every
 * address in them is a constant too. */
#ifndef SGA_ODE_RK_SUM_H
#define SGA_ODE_RK_SUM_H

#include <stddef.h>

#include "stages.h"
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#define RK_INLINE static inline __attribute__((always_inline))

typedef double rk_two __attribute__((vector_size(16)));
enum { RK_NEAR = 8, RK_FRESH = 2 };

/* n made even; the distance of vectors. */
static inline size_t rk_even(int n) { return ((size_t)n + 1) / 2 * 2; }
static inline size_t rk_stride(size_t even) { return even <= RK_NEAR ? RK_NEAR : even; }

/* Two doubles that were written a moment ago, one at a time: they are read likewise, because the processor cannot
 * forward two writes to one read. */
RK_INLINE rk_two rk_apart(const double *at)
{
#ifdef __SSE2__
    return (rk_two)_mm_loadh_pd(_mm_load_sd(at), at + 1);
#else
    return (rk_two){at[0], at[1]};
#endif
}

/* Variables j and j + 1 of a vector that has no even length. */
RK_INLINE rk_two rk_of(const double *v, int n, int j, double beyond)
{
    return j + 1 < n ? rk_apart(v + j) : (rk_two){v[j], beyond};
}

/* a > b ? a : b */
RK_INLINE rk_two rk_larger(rk_two a, rk_two b)
{
#ifdef __SSE2__
    return (rk_two)_mm_max_pd((__m128d)a, (__m128d)b);
#else
    return (rk_two){a[0] > b[0] ? a[0] : b[0], a[1] > b[1] ? a[1] : b[1]};
#endif
}

RK_INLINE rk_two rk_size(rk_two a) { return rk_larger(a, -a); }

/* ode_allowed of method.h for two variables. */
RK_INLINE rk_two rk_allowed(double rtol, double atol, rk_two unit, rk_two a, rk_two b)
{
    rk_two size = rk_larger(rk_size(a), rk_size(b));
    return rk_larger(rk_larger(atol * unit + rtol * size, 7e-15 * size), (rk_two){1e-200, 1e-200});
}

/* sum_s a_s k_s at variables j and j + 1, in two halves that do not wait for each other. */
RK_INLINE rk_two rk_pair(const struct sga_row *r, const double *k, size_t stride, size_t j)
{
    rk_two even = {0, 0}, odd = {0, 0};
#pragma GCC unroll 12
    for (int m = 0; m < r->count; m++) {
        const double *at = k + (size_t)r->stage[m] * stride + j;
        rk_two v = m == r->count - 1 ? rk_apart(at) : *(const rk_two *)at;
        if (m % 2)
            odd += r->a[m] * v;
        else
            even += r->a[m] * v;
    }
    return even + odd;
}

/* x + h sum_s a_s k_s at variables j and j + 1, as base/stages.h says: all but the last stage are summed first, so that
 * little follows on the field's last value, which everything waits for. */
RK_INLINE rk_two rk_stage(const struct sga_row *r, double h, const double *x, const double *k, size_t stride, size_t j)
{
    rk_two sum = {0, 0}, from = *(const rk_two *)(x + j);
    const double *last = k + (size_t)r->stage[r->count - 1] * stride + j;
#pragma GCC unroll 12
    for (int m = 0; m < r->count - 1; m++) {
        const double *at = k + (size_t)r->stage[m] * stride + j;
        rk_two v = m >= r->count - RK_FRESH ? rk_apart(at) : *(const rk_two *)at;
        sum = m ? sum + r->a[m] * v : r->a[m] * v;
    }
    if (r->count > 1)
        from += h * sum;
    return from + (h * r->a[r->count - 1]) * rk_apart(last);
}

/* out = sum_s a_s k_s */
RK_INLINE void rk_sum(const struct sga_row *r, const double *k, size_t even, size_t stride, double *out)
{
    for (size_t j = 0; j < even; j += 2)
        *(rk_two *)(out + j) = rk_pair(r, k, stride, j);
}

#endif
