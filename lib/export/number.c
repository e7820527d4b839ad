#include "number.h"

#include "buf.h"
#include "operators.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Decimals with more digits than these are no numbers that somebody wrote. */
enum { DECIMALS = 25, DIGITS = 40 };

/* |q| = number / 10^places with fewest places. */
static bool decimal(const fmpq_t q, fmpz_t number, int *places)
{
    fmpz_t scale;
    bool fits = false;
    fmpz_init_set_ui(scale, 1);
    for (*places = 0; *places <= DECIMALS && !fits; ++*places) {
        fits = fmpz_divisible(scale, fmpq_denref(q));
        if (fits)
            break;
        fmpz_mul_ui(scale, scale, 10);
    }
    if (fits) {
        fmpz_divexact(number, scale, fmpq_denref(q));
        fmpz_mul(number, number, fmpq_numref(q));
        fmpz_abs(number, number);
        fits = fmpz_sizeinbase(number, 10) <= DIGITS;
    }
    fmpz_clear(scale);
    return fits;
}

static void put_decimal(const fmpz_t number, int places, struct sga_buf *out)
{
    char digits[DIGITS + DECIMALS + 8];
    memset(digits, '0', DECIMALS + 1);
    fmpz_get_str(digits + DECIMALS + 1, 10, number);
    int n = (int)strlen(digits + DECIMALS + 1);
    assert(places >= 0 && places <= DECIMALS && n <= DIGITS);
    int zeros = places >= n ? places - n + 1 : 0;         /* so that a digit stands before the point */
    const char *from = digits + DECIMALS + 1 - zeros;
    n += zeros;
    sga_buf_put(out, from, (size_t)(n - places));
    sga_buf_printf(out, ".%s", places ? from + n - places : "0");
}

bool export_number(const fmpq_t q, struct sga_buf *out, int *binds)
{
    bool negative = fmpq_sgn(q) < 0, ok = true;
    int places;
    fmpz_t number;
    fmpz_init(number);
    *binds = negative ? BINDS_SIGN : BINDS_ALL;
    if (decimal(q, number, &places)) {
        sga_buf_puts(out, negative ? "-" : "");
        put_decimal(number, places, out);
    } else if (fmpz_bits(fmpq_numref(q)) <= 53 && fmpz_bits(fmpq_denref(q)) <= 53) {
        sga_buf_printf(out, "%ld.0/%ld.0", (long)fmpz_get_si(fmpq_numref(q)), (long)fmpz_get_si(fmpq_denref(q)));
        *binds = BINDS_PRODUCT;
    } else {
        mpfr_t nearest;
        mpfr_init2(nearest, 53);
        fmpq_get_mpfr(nearest, q, MPFR_RNDN);
        double d = mpfr_get_d(nearest, MPFR_RNDN);
        mpfr_clear(nearest);
        if ((ok = isfinite(d) && fabs(d) >= 2.2250738585072014e-308))
            sga_buf_printf(out, "%.16e", d);
    }
    fmpz_clear(number);
    return ok;
}

/* Fractions with denominators below this one stay fractions though decimals of few places. */
enum { PLAIN_FRACTION = 10 };

static void put_fraction(const fmpq_t q, enum export_language l, struct sga_buf *out)
{
    fmpz_t top;
    fmpz_init(top);
    fmpz_abs(top, fmpq_numref(q));
    char *above = fmpz_get_str(NULL, 10, top), *below = fmpz_get_str(NULL, 10, fmpq_denref(q));
    sga_buf_printf(out, l == EXPORT_LATEX ? "\\frac{%s}{%s}" : "<mfrac><mn>%s</mn><mn>%s</mn></mfrac>", above, below);
    flint_free(above);
    flint_free(below);
    fmpz_clear(top);
}

void export_print_number(const fmpq_t q, enum export_language l, struct sga_buf *out, int *binds)
{
    const char *before = l == EXPORT_MATHML ? "<mn>" : "", *after = l == EXPORT_MATHML ? "</mn>" : "";
    bool whole = fmpz_is_one(fmpq_denref(q));
    int places;
    fmpz_t number;
    fmpz_init(number);
    if (fmpq_sgn(q) < 0)
        sga_buf_puts(out, l == EXPORT_MATHML ? "<mo>-</mo>" : "-");
    *binds = fmpq_sgn(q) < 0 ? BINDS_SUM : whole ? BINDS_ALL : BINDS_POWER;
    if (whole || (fmpz_cmp_ui(fmpq_denref(q), PLAIN_FRACTION) >= 0 && decimal(q, number, &places))) {
        sga_buf_puts(out, before);
        if (whole) {
            fmpz_abs(number, fmpq_numref(q));
            char *digits = fmpz_get_str(NULL, 10, number);
            sga_buf_puts(out, digits);
            flint_free(digits);
        } else {
            put_decimal(number, places, out);
        }
        sga_buf_puts(out, after);
    } else {
        put_fraction(q, l, out);
    }
    fmpz_clear(number);
}
