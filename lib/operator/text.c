/* Printing polynomials and fractions of time. */
#include "text.h"

#include <flint/flint.h>

#include "arena.h"
#include "buf.h"
#include "flint_ends.h"

static void put_integer(struct sga_buf *out, const fmpz_t v)
{
    char *s = fmpz_get_str(NULL, 10, v);
    sga_buf_puts(out, s);
    flint_free(s);
}

static void put_power(struct sga_buf *out, const char *time, long k)
{
    sga_buf_puts(out, time);
    if (k > 1)
        sga_buf_printf(out, "^%ld", k);
}

void op_text_polynomial(struct sga_buf *out, const fmpz_poly_t p, const char *time)
{
    SGA_ENDS(fmpz_end) fmpz_t c = { 0 };
    bool first = true;
    for (long k = fmpz_poly_degree(p); k >= 0; k--) {
        fmpz_poly_get_coeff_fmpz(c, p, k);
        if (fmpz_is_zero(c))
            continue;
        bool minus = fmpz_sgn(c) < 0;
        sga_buf_puts(out, first ? (minus ? "-" : "") : minus ? " - " : " + ");
        fmpz_abs(c, c);
        if (k == 0 || !fmpz_is_one(c))
            put_integer(out, c);
        if (k > 0 && !fmpz_is_one(c))
            sga_buf_puts(out, "*");
        if (k > 0)
            put_power(out, time, k);
        first = false;
    }
    if (first)
        sga_buf_puts(out, "0");
}

static long terms(const fmpz_poly_t p)
{
    long n = 0;
    for (long k = 0; k < fmpz_poly_length(p); k++)
        n += !fmpz_is_zero(fmpz_poly_get_coeff_ptr(p, k));
    return n;
}

void op_text_ratio(struct sga_buf *out, const fmpz_poly_q_t a, const char *time)
{
    const fmpz_poly_struct *num = fmpz_poly_q_numref(a), *den = fmpz_poly_q_denref(a);
    if (fmpz_poly_is_one(den)) {
        op_text_polynomial(out, num, time);
        return;
    }
    bool above = terms(num) > 1;
    bool below = terms(den) > 1 || (fmpz_poly_degree(den) > 0 && !fmpz_is_one(fmpz_poly_lead(den)));
    sga_buf_puts(out, above ? "(" : "");
    op_text_polynomial(out, num, time);
    sga_buf_puts(out, above ? ")/" : "/");
    sga_buf_puts(out, below ? "(" : "");
    op_text_polynomial(out, den, time);
    sga_buf_puts(out, below ? ")" : "");
}
