/* The shortest writer against exact powers of ten and against printf's digits. */
#include "check.h"

#include <float.h>
#include <gmp.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "buf.h"
#include "number_powers.h"

static uint64_t state;

static uint64_t next(void)
{
    uint64_t z = (state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return z ^ (z >> 31);
}

static double from_bits(uint64_t b)
{
    double v;
    memcpy(&v, &b, sizeof v);
    return v;
}

/* Significant digits of a decimal text: without sign, point, exponent, and zeros at
 * both ends. Returns how many. */
static int significant(const char *s, char *d)
{
    int n = 0;
    for (; *s && *s != 'e'; s++)
        if (*s >= '0' && *s <= '9' && (n || *s != '0'))
            d[n++] = *s;
    while (n && d[n - 1] == '0')
        n--;
    d[n] = 0;
    return n;
}

/* The second route: the first %.{n}e that reads back, the nearest decimal of n digits.
 * The digits must agree. Only at a power of two, where the interval is lopsided, a
 * shorter decimal that is not the nearest of its length may read back. */
static void compare(double v)
{
    char out[32], ref[64], d[64], e[64];
    int len = sga_format_double(out, v), n = 0, x;
    CHECK(len == (int)strlen(out) && len < 32, "%s", out);
    double back = strtod(out, NULL);
    CHECK(memcmp(&back, &v, sizeof v) == 0, "%a written as %s", v, out);
    do
        sprintf(ref, "%.*e", n++, v);
    while (strtod(ref, NULL) != v);
    int mine = significant(out, d), theirs = significant(ref, e);
    if (fabs(frexp(v, &x)) == 0.5 && mine < theirs)
        return;
    CHECK(strcmp(d, e) == 0, "%s, but %s", out, ref);
}

static void table(void)
{
    mpz_t n, d, g, w;
    mpz_inits(n, d, g, w, NULL);
    int wrong = 0;
    for (int k = SGA_POWER_MIN; k <= SGA_POWER_MAX; k++) {
        mpz_ui_pow_ui(n, 10, k > 0 ? (unsigned long)k : 0);
        mpz_ui_pow_ui(d, 10, k < 0 ? (unsigned long)-k : 0);
        mpz_mul_2exp(n, n, 1400);
        mpz_cdiv_q(g, n, d);    /* ceil(10^k 2^1400); a second ceil below is still the ceil */
        mpz_cdiv_q_2exp(g, g, mpz_sizeinbase(g, 2) - 128);
        const uint64_t *e = sga_power_of_ten[k - SGA_POWER_MIN];
        mpz_set_ui(w, e[0]);
        mpz_mul_2exp(w, w, 64);
        mpz_add_ui(w, w, e[1]);
        wrong += mpz_cmp(w, g) != 0;
    }
    CHECK(wrong == 0, "%d entries", wrong);
    mpz_clears(n, d, g, w, NULL);
}

static void style(void)
{
    static const struct { double v; const char *text; } t[] = {
        { 0, "0" }, { -0.0, "-0" }, { 101, "101" }, { -3, "-3" }, { 0.1, "0.1" }, { 0.001, "0.001" },
        { 1e-5, "0.00001" }, { 1e-6, "1e-6" }, { 1e-9, "1e-9" }, { 1.5e300, "1.5e300" }, { -1.25e-10, "-1.25e-10" },
        { 999999999999999.0, "999999999999999" }, { 1e15, "1000000000000000" }, { 1e16, "10000000000000000" },
        { 1e17, "1e17" }, { 123456.789, "123456.789" }, { 9007199254740993.0, "9007199254740992" },
        { 5e-324, "5e-324" }, { DBL_MAX, "1.7976931348623157e308" }, { DBL_MIN, "2.2250738585072014e-308" },
        { 2.2250738585072011e-308, "2.225073858507201e-308" }, { 1e23, "1e23" }, { 9e22, "9e22" },
        { 0.3, "0.3" }, { 0.1 + 0.2, "0.30000000000000004" }, { 2e-44, "2e-44" }, { 1.0 / 3, "0.3333333333333333" },
        { NAN, "null" }, { INFINITY, "null" }, { -INFINITY, "null" }
    };
    for (size_t i = 0; i < sizeof t / sizeof *t; i++) {
        char out[32];
        sga_format_double(out, t[i].v);
        CHECK(strcmp(out, t[i].text) == 0, "%s for %s", out, t[i].text);
    }
}

static void hard(void)
{
    for (int e = -1074; e <= 1023; e++) {    /* the narrow interval, and its neighbours */
        double v = ldexp(1, e);
        compare(v);
        compare(nextafter(v, 0) > 0 ? nextafter(v, 0) : v);
        compare(nextafter(v, INFINITY));
    }
    for (int k = -323; k <= 308; k++) {      /* near decimals */
        char text[16];
        sprintf(text, "1e%d", k);
        double v = strtod(text, NULL);
        compare(v);
        compare(nextafter(v, 0) > 0 ? nextafter(v, 0) : v);
        compare(nextafter(v, INFINITY));
    }
    for (uint64_t i = 1; i < 3000; i++) {    /* integers around 2^53 and 2^54: ties */
        compare((double)((UINT64_C(1) << 53) + 2 * i));
        compare((double)((UINT64_C(1) << 54) + 4 * i));
        compare((double)(UINT64_C(9007199254740992) * 1024 + 2048 * i));
        compare(from_bits(i));               /* the least subnormals */
        compare((double)i / 1000);
        compare((double)i + 0.5);
    }
}

static void random_bits(void)
{
    int n = check_scale(200000);
    for (int i = 0; i < n; i++) {
        double v = from_bits(next());
        if (!isfinite(v))
            continue;
        compare(v);
    }
    for (int i = 0; i < n; i++) {            /* usual magnitudes, and few digits */
        compare(ldexp((double)(int64_t)next(), -60));
        compare((double)(int32_t)next() / 1000.0);
    }
    int wrong = 0;
    for (int i = 0; i < 10 * n; i++) {       /* reading back alone, many more */
        double v = from_bits(next()), back;
        char out[32];
        if (!isfinite(v))
            continue;
        sga_format_double(out, v);
        back = strtod(out, NULL);
        wrong += memcmp(&back, &v, sizeof v) != 0;
    }
    CHECK(wrong == 0, "%d do not read back", wrong);
}

int main(void)
{
    state = check_seed(20261121);
    table();
    style();
    hard();
    random_bits();
    return CHECK_END();
}
