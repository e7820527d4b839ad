/* Finite eigenvalues as decimal numbers.
 *
 * Roots are isolated in balls by Arb, which tells real roots of integer polynomials from others
 * exactly. Roots on the imaginary axis are told by algebra: they are roots of
 * g = gcd(f(s), f(-s)) = h(s^2) or s h(s^2), and are the square roots of h's negative real roots. All
 * others have a real part that is not 0, so that a ball excludes 0 after finitely many bits.
 * A decimal is printed when both ends of its ball round to it. */
#include "roots.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <arb_fmpz_poly.h>

#include "arb_ends.h"
#include "arena.h"
#include "buf.h"
#include "flint_ends.h"
#include "mem.h"

enum { TIE_BITS = 256 };

void root_list_clear(struct root_list *l)
{
    for (int i = 0; i < l->count; i++)
        acb_clear(&l->root[i].value);
    free(l->root);
    *l = (struct root_list){ .count = 0 };
}

static void add(struct root_list *l, const acb_t value, int factor)
{
    SGA_RESERVE(l->root, l->cap, (size_t)l->count + 1);
    struct root *r = l->root + l->count++;
    acb_init(&r->value);
    acb_set(&r->value, value);
    r->factor = factor;
}

/* The roots of a squarefree polynomial, each in its own ball, real ones exactly real. */
static acb_ptr isolate(const fmpz_poly_t f, slong precision)
{
    slong d = fmpz_poly_degree(f);
    acb_ptr roots = _acb_vec_init(d > 0 ? d : 1);
    if (d > 0)
        arb_fmpz_poly_complex_roots(roots, f, 0, precision);
    return roots;
}

/* f = g * rest, where g has the roots z of f for which -z is a root too. */
static void symmetric_part(const fmpz_poly_t f, fmpz_poly_t g, fmpz_poly_t rest)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t mirrored = { 0 };
    fmpz_poly_set(mirrored, f);
    for (slong i = 1; i < fmpz_poly_length(f); i += 2)
        fmpz_neg(mirrored->coeffs + i, mirrored->coeffs + i);
    fmpz_poly_gcd(g, f, mirrored);
    fmpz_poly_div(rest, f, g);
}

/* The roots of g = h(s^2) or s h(s^2): square roots, along the axes exactly. */
static void symmetric_roots(struct root_list *l, const fmpz_poly_t g, int factor, slong precision)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t h = { 0 };
    acb_t z;
    slong d = fmpz_poly_degree(g), odd = d & 1;
    acb_init(z);
    for (slong i = odd; i <= d; i += 2)
        fmpz_poly_set_coeff_fmpz(h, i / 2, g->coeffs + i);
    if (odd)
        add(l, z, factor);
    acb_ptr y = isolate(h, precision);
    for (slong i = 0; i < d / 2; i++) {
        if (!acb_is_real(y + i)) {
            acb_sqrt(z, y + i, precision);
        } else if (arb_is_negative(acb_realref(y + i))) {
            arb_neg(acb_imagref(z), acb_realref(y + i));
            arb_sqrt(acb_imagref(z), acb_imagref(z), precision);
            arb_zero(acb_realref(z));
        } else {
            arb_sqrt(acb_realref(z), acb_realref(y + i), precision);
            arb_zero(acb_imagref(z));
        }
        add(l, z, factor);
        acb_neg(z, z);
        add(l, z, factor);
    }
    _acb_vec_clear(y, d / 2 > 0 ? d / 2 : 1);
    acb_clear(z);
}

void root_list_of(struct root_list *l, const fmpz_poly_t f, int factor, slong precision)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t g = { 0 }, rest = { 0 };
    symmetric_part(f, g, rest);
    if (fmpz_poly_degree(g) > 0)
        symmetric_roots(l, g, factor, precision);
    slong d = fmpz_poly_degree(rest);
    acb_ptr roots = isolate(rest, precision);
    for (slong i = 0; i < d; i++)
        add(l, roots + i, factor);
    _acb_vec_clear(roots, d > 0 ? d : 1);
}

/* Decimal digits of an exact binary number, rounded to nearest; 0 < digits. */
static char *decimal(const arf_t x, slong digits)
{
    SGA_ENDS(arb_end) arb_t ball = { 0 };
    arb_set_arf(ball, x);
    char *s = arb_get_str(ball, digits, ARB_STR_NO_RADIUS), *copy = sga_strdup(s);
    flint_free(s);
    return copy;
}

static bool as_double(const arf_t x, char *out)
{
    double v = arf_get_d(x, ARF_RND_NEAR);
    if (!isfinite(v) || fabs(v) < 2.3e-308)
        return false;
    sga_format_double(out, v);
    return true;
}

static char *text(const arf_t x, slong digits)
{
    char out[32];
    if (arf_is_zero(x))
        return sga_strdup("0");
    if (digits == 0 && as_double(x, out))
        return sga_strdup(out);
    return decimal(x, digits ? digits : 17);
}

/* NULL: the ball is too wide for so many digits (0: a double). */
char *root_text(const arb_t x, slong digits, slong precision)
{
    SGA_ENDS(arf_end) arf_t lower = { 0 }, upper = { 0 };
    char *a = NULL;
    SGA_FREED char *b = NULL;
    slong goal = digits ? (slong)((double)digits * 3.33) + 8 : 64;
    if (arb_is_zero(x))
        return sga_strdup("0");
    if (arb_contains_zero(x))
        return NULL;
    arb_get_lbound_arf(lower, x, precision + 64);
    arb_get_ubound_arf(upper, x, precision + 64);
    a = text(lower, digits);
    b = text(upper, digits);
    /* equal, or so narrow that the value must be a tie to all appearance */
    if (strcmp(a, b) != 0 && arb_rel_accuracy_bits(x) < goal + TIE_BITS) {
        free(a);
        a = NULL;
    }
    return a;
}
