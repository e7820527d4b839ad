/* Singular times: real roots of the leading Laurent matrix's denominators and common numerator.
 *
 * Each irreducible factor's real roots are isolated between rationals by bisection with
 * Sturm counts and refined until the two ends round to neighbouring doubles. */
#include "operator.h"

#include <stdlib.h>

#include <mpfr.h>

#include <flint/fmpq.h>
#include <flint/fmpq_poly.h>
#include <flint/fmpz_poly_factor.h>

#include "arena.h"
#include "flint_ends.h"
#include "mem.h"

enum { FINE_BITS = 64 };

static int sign_at(const fmpz_poly_t p, const fmpq_t x)
{
    SGA_ENDS(fmpq_end) fmpq_t v = { { 0, 1 } };
    fmpz_poly_evaluate_fmpq(v, p, x);
    return fmpq_sgn(v);
}

/* Number of real roots in (a, b]: those of the polynomial moved to (0, b - a], by Sturm. */
static long roots_between(const fmpz_poly_t p, const fmpq_t a, const fmpq_t b)
{
    SGA_ENDS(fmpq_poly_end) fmpq_poly_t q, line;
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t moved = { 0 };
    SGA_ENDS(fmpq_end) fmpq_t width = { { 0, 1 } };
    long zero, positive, count;
    fmpq_poly_init(q);
    fmpq_poly_init(line);
    /* roots in (a, b] of p are positive roots of p(a + (b - a) / (1 + s)), s >= 0: s = 0 is b */
    fmpq_sub(width, b, a);
    fmpq_poly_set_fmpz_poly(q, p);
    fmpq_poly_set_coeff_fmpq(line, 0, a);
    fmpq_poly_set_coeff_fmpq(line, 1, width);
    fmpq_poly_compose(q, q, line);             /* now (0, 1] */
    fmpq_poly_get_numerator(moved, q);
    fmpz_poly_reverse(moved, moved, fmpz_poly_length(moved));     /* [1, oo); a root 0 of q is lost, as it must */
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t one = { 0 };
    fmpz_poly_set_coeff_si(one, 0, 1);
    fmpz_poly_set_coeff_si(one, 1, 1);
    fmpz_poly_compose(moved, moved, one);      /* [0, oo) */
    zero = fmpz_is_zero(fmpz_poly_get_coeff_ptr(moved, 0)) || fmpz_poly_is_zero(moved) ? 1 : 0;
    if (zero)
        fmpz_poly_shift_right(moved, moved, 1);
    long negative = 0;
    positive = 0;
    if (fmpz_poly_degree(moved) > 0)
        _fmpz_poly_num_real_roots_sturm(&negative, &positive, moved->coeffs, moved->length);
    count = zero + positive;
    return count;
}

/* A power of two beyond every real root. */
static void bound(fmpq_t b, const fmpz_poly_t p)
{
    SGA_ENDS(fmpz_end) fmpz_t r = { 0 };
    fmpz_poly_bound_roots(r, p);
    fmpz_add_ui(r, r, 1);
    fmpz_set(fmpq_numref(b), r);
    fmpz_one(fmpq_denref(b));
}

static void add_root(struct op_singular_times *s, const fmpz_poly_t p, const fmpq_t low, const fmpq_t high, enum op_lost lost,
                     int order)
{
    s->at = sga_realloc(s->at, (size_t)(s->count + 1) * sizeof *s->at);
    struct op_singular *r = s->at + s->count++;
    *r = (struct op_singular){ .lost = lost, .order = order };
    fmpz_poly_init(r->polynomial);
    fmpz_poly_set(r->polynomial, p);
    fmpq_init(r->low);
    fmpq_init(r->high);
    fmpq_set(r->low, low);
    fmpq_set(r->high, high);
    SGA_ENDS(fmpq_end) fmpq_t middle = { { 0, 1 } }, width = { { 0, 1 } }, size = { { 0, 1 } };
    for (;;) {                                 /* one simple root in (low, high]: signs differ, or it is high */
        fmpq_sub(width, r->high, r->low);
        fmpq_mul_2exp(width, width, FINE_BITS);
        fmpq_abs(size, r->high);
        if (fmpq_cmp(width, size) < 0 || fmpq_equal(r->low, r->high))
            break;
        fmpq_add(middle, r->low, r->high);
        fmpq_div_2exp(middle, middle, 1);
        int at_middle = sign_at(p, middle), at_high = sign_at(p, r->high);
        if (at_middle == 0 || at_high == 0) {
            fmpq_set(r->low, at_middle == 0 ? middle : r->high);
            fmpq_set(r->high, r->low);
        } else if (at_middle == at_high) {
            fmpq_set(r->high, middle);
        } else {
            fmpq_set(r->low, middle);
        }
    }
    mpfr_t nearest;
    mpfr_init2(nearest, 53);
    fmpq_get_mpfr(nearest, r->high, MPFR_RNDN);
    r->t = mpfr_get_d(nearest, MPFR_RNDN);
    mpfr_clear(nearest);
}

/* Intervals that hold one root each, by bisection with a list of those still open. */
static void isolate(struct op_singular_times *s, const fmpz_poly_t p, enum op_lost lost, int order)
{
    struct { fmpq_t low, high; } *open = NULL;
    size_t cap = 0;
    int count = 0;
    fmpq_t low, high;
    fmpq_init(low);
    fmpq_init(high);
    if (fmpz_poly_degree(p) == 1) {            /* rational */
        fmpz_neg(fmpq_numref(low), p->coeffs);
        fmpz_set(fmpq_denref(low), p->coeffs + 1);
        fmpq_canonicalise(low);
        add_root(s, p, low, low, lost, order);
        fmpq_clear(low);
        fmpq_clear(high);
        return;
    }
    bound(high, p);
    fmpq_neg(low, high);
    for (;;) {
        long n = roots_between(p, low, high);
        if (n == 1)
            add_root(s, p, low, high, lost, order);
        if (n > 1) {
            SGA_RESERVE(open, cap, count + 1);
            fmpq_init(open[count].low);
            fmpq_init(open[count].high);
            fmpq_set(open[count].high, high);
            fmpq_add(open[count].low, low, high);
            fmpq_div_2exp(open[count].low, open[count].low, 1);
            fmpq_set(high, open[count++].low);
            continue;
        }
        if (!count)
            break;
        fmpq_swap(low, open[--count].low);
        fmpq_swap(high, open[count].high);
        fmpq_clear(open[count].low);
        fmpq_clear(open[count].high);
    }
    free(open);
    fmpq_clear(low);
    fmpq_clear(high);
}

static int by_time(const void *a, const void *b)
{
    const struct op_singular *x = a, *y = b;
    return x->t < y->t ? -1 : x->t > y->t;
}

/* The real roots of p join those known, by time. */
static void roots_of(struct op_singular_times *s, const fmpz_poly_t p, enum op_lost lost)
{
    fmpz_poly_factor_t f;
    if (fmpz_poly_degree(p) < 1)
        return;
    fmpz_poly_factor_init(f);
    fmpz_poly_factor(f, p);
    for (long k = 0; k < f->num; k++)
        isolate(s, f->p + k, lost, (int)f->exp[k]);
    fmpz_poly_factor_clear(f);
    if (s->count)
        qsort(s->at, (size_t)s->count, sizeof *s->at, by_time);
}

/* den = its least common multiple with the denominators of m */
static void denominators(fmpz_poly_t den, const struct ratio_matrix *m)
{
    for (int k = 0; k < m->rows * m->cols; k++)
        fmpz_poly_lcm(den, den, fmpz_poly_q_denref(m->e + k));
}

void op_singular_find(struct op_singular_times *s, const struct ratio_matrix *leading)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t den = { 0 }, num = { 0 };
    *s = (struct op_singular_times){ 0 };
    fmpz_poly_one(den);
    denominators(den, leading);
    for (int k = 0; k < leading->rows * leading->cols; k++)
        fmpz_poly_gcd(num, num, fmpz_poly_q_numref(leading->e + k));
    roots_of(s, den, OP_POLE);
    roots_of(s, num, OP_ZERO);
}

void op_singular_coefficients(struct op_singular_times *s, const struct op_system *system, const struct op_state *x)
{
    SGA_ENDS(fmpz_poly_end) fmpz_poly_t own = { 0 }, state = { 0 };
    *s = (struct op_singular_times){ 0 };
    fmpz_poly_one(own);
    fmpz_poly_one(state);
    for (int k = 0; k <= system->order; k++)
        denominators(own, system->A + k);
    denominators(own, &system->B);
    denominators(state, &x->F);
    denominators(state, &x->G);
    denominators(state, &x->H);
    for (int v = 0; v <= x->degree; v++)
        denominators(state, x->J + v);
    fmpz_poly_gcd(own, own, state);
    roots_of(s, own, OP_COEFFICIENT);
}

void op_singular_clear(struct op_singular_times *s)
{
    for (int k = 0; k < s->count; k++) {
        fmpz_poly_clear(s->at[k].polynomial);
        fmpq_clear(s->at[k].low);
        fmpq_clear(s->at[k].high);
    }
    free(s->at);
    *s = (struct op_singular_times){ 0 };
}
