/* Shortest decimals for doubles.
 *
 * Of the decimals that read back as v, the shortest, and of those the nearest to v.
 * The rounding interval of v is scaled by a power of ten so that it holds at least one
 * integer and less than ten; one 64 x 128 bit product for each end and the centre,
 * rounded to odd, decides exactly which integers lie inside.
 * R. Giulietti, The Schubfach way to render doubles, 2020 (sections 9.3 to 9.10). */
#include "buf.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#include "number_powers.h"

static const char pairs[] =
    "00010203040506070809101112131415161718192021222324"
    "25262728293031323334353637383940414243444546474849"
    "50515253545556575859606162636465666768697071727374"
    "75767778798081828384858687888990919293949596979899";

/* floor(log10(2^e)), floor(log10(3/4 2^e)) and floor(log2(10^e)) for |e| < 1500 */
static int log10_pow2(int e) { return (e * 1262611) >> 22; }
static int log10_pow2_less(int e) { return (e * 1262611 - 524031) >> 22; }
static int log2_pow10(int e) { return (e * 1741647) >> 19; }

/* x g / 2^128, rounded to odd: the last bit is set if anything was cut off. g exceeds
 * the true power by less than one unit, hence the comparison with 1, not 0. */
static uint64_t scale(const uint64_t g[2], uint64_t x)
{
    unsigned __int128 low = (unsigned __int128)g[1] * x;
    unsigned __int128 high = (unsigned __int128)g[0] * x + (uint64_t)(low >> 64);
    return (uint64_t)(high >> 64) | ((uint64_t)high > 1);
}

/* The shortest d and exponent with d 10^exponent inside the rounding interval of
 * c 2^q; `narrow`: c is a power of two, the interval below it is half as wide. */
static uint64_t shortest(uint64_t c, int q, bool narrow, int *exponent)
{
    int k = narrow ? log10_pow2_less(q) : log10_pow2(q);
    int h = q + log2_pow10(-k) + 1;
    assert(h >= 1 && h <= 4);        /* 4 c + 2 has 55 bits and takes no more */
    const uint64_t *g = sga_power_of_ten[-k - SGA_POWER_MIN];
    uint64_t odd = c & 1;    /* the ends belong to the interval of an even c */
    uint64_t low = scale(g, (4 * c - 2 + narrow) << h) + odd;
    uint64_t mid = scale(g, (4 * c) << h);
    uint64_t high = scale(g, (4 * c + 2) << h) - odd;
    uint64_t s = mid / 4, tens = s / 10;
    bool below = low <= 40 * tens, above = 40 * tens + 40 <= high;
    *exponent = k;
    if (s >= 10 && below != above) {
        *exponent = k + 1;
        return tens + above;
    }
    below = low <= 4 * s;
    above = 4 * s + 4 <= high;
    if (below != above)
        return s + above;
    uint64_t half = 4 * s + 2;
    return s + (mid > half || (mid == half && (s & 1)));
}

/* Exactly eight digits, in two halves that do not wait for each other. */
static char *eight_digits(char *end, uint32_t d)
{
    uint32_t high = d / 10000, low = d % 10000;
    memcpy(end - 2, pairs + 2 * (low % 100), 2);
    memcpy(end - 4, pairs + 2 * (low / 100), 2);
    memcpy(end - 6, pairs + 2 * (high % 100), 2);
    memcpy(end - 8, pairs + 2 * (high / 100), 2);
    return end - 8;
}

/* Decimal digits of d, to the left of end. */
static char *digits_before(char *end, uint64_t d)
{
    for (; d >= 100000000; d /= 100000000)
        end = eight_digits(end, (uint32_t)(d % 100000000));
    uint32_t r = (uint32_t)d;
    for (; r >= 100; r /= 100)
        memcpy(end -= 2, pairs + 2 * (r % 100), 2);
    if (r >= 10)
        return memcpy(end - 2, pairs + 2 * r, 2);
    *--end = (char)('0' + r);
    return end;
}

/* n digits with the point after the first `whole` of them (whole may be <= 0 or >= n). */
static char *put_decimal(char *p, const char *digit, int n, int whole)
{
    if (whole <= 0) {
        memcpy(p, "0.00000000", (size_t)(2 - whole));
        p += 2 - whole;
        memcpy(p, digit, (size_t)n);
        return p + n;
    }
    if (whole >= n) {
        memcpy(p, digit, (size_t)n);
        memset(p + n, '0', (size_t)(whole - n));
        return p + whole;
    }
    memcpy(p, digit, (size_t)whole);
    p[whole] = '.';
    memcpy(p + whole + 1, digit + whole, (size_t)(n - whole));
    return p + n + 1;
}

static char *put_scientific(char *p, const char *digit, int n, int exponent)
{
    *p++ = *digit;
    if (n > 1) {
        *p++ = '.';
        memcpy(p, digit + 1, (size_t)(n - 1));
        p += n - 1;
    }
    *p++ = 'e';
    if (exponent < 0)
        *p++ = '-';
    char text[8], *end = text + sizeof text;
    char *t = digits_before(end, (uint64_t)(exponent < 0 ? -exponent : exponent));
    memcpy(p, t, (size_t)(end - t));
    return p + (end - t);
}

/* A positive finite number that is not a small integer. */
static char *put_positive(char *p, uint64_t bits)
{
    uint64_t fraction = bits & 0xFFFFFFFFFFFFFu;
    int biased = (int)(bits >> 52), k;
    uint64_t c = biased ? fraction | 0x10000000000000u : fraction;
    uint64_t d = shortest(c, (biased ? biased : 1) - 1075, fraction == 0 && biased > 1, &k);
    char text[24], *end = text + sizeof text;
    char *digit = digits_before(end, d);
    while (end[-1] == '0') {
        end--;
        k++;
    }
    int n = (int)(end - digit), exponent = n - 1 + k;
    assert(n >= 1 && n <= 17 && digit[0] != '0');
    return exponent >= -5 && exponent <= 16 ? put_decimal(p, digit, n, exponent + 1)
                                            : put_scientific(p, digit, n, exponent);
}

int sga_format_double(char *out, double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    if (!isfinite(v))
        return (int)(stpcpy(out, "null") - out);
    char *p = out;
    if (bits >> 63)
        *p++ = '-';
    double a = fabs(v);
    if (a < 1e15 && a == (double)(uint64_t)a) {
        char text[24], *end = text + sizeof text;
        char *t = digits_before(end, (uint64_t)a);
        memcpy(p, t, (size_t)(end - t));
        p += end - t;
    } else {
        p = put_positive(p, bits & 0x7FFFFFFFFFFFFFFFu);
    }
    *p = 0;
    return (int)(p - out);
}
