/* A ball as a decimal number and a bound of its error. */
#include "enclose.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "buf.h"
#include "flint_ends.h"
#include "mem.h"

double enclose_above(const mag_t m)
{
    if (mag_is_zero(m))
        return 0;
    double d = mag_is_inf(m) ? INFINITY : mag_get_d(m) * (1 + 0x1p-40);
    return fmax(d, DBL_MIN);
}

/* 10^e as the unit of the last digit: a tenth of the radius, but no finer than prec bits of the midpoint. */
static long unit_of(const arb_t x, slong prec)
{
    double finest = -HUGE_VAL, log10_2 = 0.30103;
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arf_get_mag(m, arb_midref(x));
    if (!mag_is_zero(m))
        finest = floor((mag_get_d_log2_approx(m) - (double)prec) * log10_2);
    if (!mag_is_zero(arb_radref(x)))
        finest = fmax(finest, floor(mag_get_d_log2_approx(arb_radref(x)) * log10_2) - 1);
    return (long)finest;
}

static void set_power(arb_t r, long e, slong prec)
{
    arb_set_ui(r, 10);
    arb_pow_ui(r, r, (ulong)labs(e), prec);
    if (e < 0)
        arb_inv(r, r, prec);
}

/* N 10^e in plain digits where that is short, otherwise as d.dddE+x. */
static char *text_of(const fmpz_t N, long e)
{
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    char *digits = fmpz_get_str(NULL, 10, N), *d = digits + (*digits == '-');
    long count = (long)strlen(d), point = count + e;      /* the decimal point stands after so many digits */
    if (*digits == '-')
        sga_buf_puts(&out, "-");
    if (e <= 0 && point > 0) {
        sga_buf_put(&out, d, (size_t)point);
        if (e < 0) {
            sga_buf_puts(&out, ".");
            sga_buf_puts(&out, d + point);
        }
    } else if (e <= 0 && point > -5) {
        sga_buf_puts(&out, "0.");
        for (long k = point; k < 0; k++)
            sga_buf_puts(&out, "0");
        sga_buf_puts(&out, d);
    } else {
        char exponent[32];
        snprintf(exponent, sizeof exponent, "e%+ld", point - 1);
        sga_buf_put(&out, d, 1);
        if (count > 1) {
            sga_buf_puts(&out, ".");
            sga_buf_puts(&out, d + 1);
        }
        sga_buf_puts(&out, exponent);
    }
    flint_free(digits);
    return sga_strdup(out.data);
}

char *enclose_decimal(const arb_t x, slong prec, double *radius)
{
    *radius = INFINITY;
    if (!arb_is_finite(x))
        return NULL;
    if (arb_is_zero(x)) {
        *radius = 0;
        return sga_strdup("0");
    }
    long e = unit_of(x, prec);
    slong bits = 2 * prec + 128 + (slong)labs(e);
    SGA_ENDS(arb_end) arb_t u = { 0 }, d = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t N = { 0 };
    SGA_ENDS(mag_end) mag_t far = { 0 };
    set_power(u, e, bits);
    arb_get_mid_arb(d, x);
    arb_div(d, d, u, bits);
    arf_get_fmpz(N, arb_midref(d), ARF_RND_NEAR);
    arb_mul_fmpz(d, u, N, bits);        /* what is written, and how far it is from all of x */
    arb_sub(d, d, x, bits);
    arb_get_mag(far, d);
    *radius = enclose_above(far);
    return fmpz_is_zero(N) ? sga_strdup("0") : text_of(N, e);
}
