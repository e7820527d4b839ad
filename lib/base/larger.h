/* The larger and the smaller of two numbers where speed counts: fmax is a call into libm. NaN only comes out
 * where a is NaN, so it must not be relied on. */
#ifndef SGA_BASE_LARGER_H
#define SGA_BASE_LARGER_H

static inline double sga_larger(double a, double b)
{
    return b > a ? b : a;
}

static inline double sga_smaller(double a, double b)
{
    return b < a ? b : a;
}

#endif
