/* The set { x + A r }: from a box, and from an affine image with a new, well-conditioned A. */
#include "lohner.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "mem.h"

enum { BITS = ENC_ROUGH_BITS };

void enc_set_init(struct enc_set *s, int n)
{
    assert(n > 0);
    *s = (struct enc_set){ .n = n, .x = _arb_vec_init(n), .radius = _mag_vec_init(n) };
    arb_mat_init(s->A, n, n);
}

void enc_set_clear(struct enc_set *s)
{
    if (!s->x)
        return;
    _arb_vec_clear(s->x, s->n);
    _mag_vec_clear(s->radius, s->n);
    arb_mat_clear(s->A);
    memset(s, 0, sizeof *s);
}

void enc_set_box(struct enc_set *s, arb_srcptr box)
{
    arb_mat_one(s->A);
    for (int j = 0; j < s->n; j++) {
        arb_get_mid_arb(s->x + j, box + j);
        mag_set(s->radius + j, arb_radref(box + j));
    }
}

void enc_set_width(const struct enc_set *s, mag_ptr width)
{
    SGA_ENDS(mag_end) mag_t a = { 0 };
    for (int j = 0; j < s->n; j++) {
        mag_zero(width + j);
        for (int k = 0; k < s->n; k++) {
            arb_get_mag(a, arb_mat_entry(s->A, j, k));
            mag_addmul(width + j, a, s->radius + k);
        }
    }
}

void enc_set_hull(const struct enc_set *s, arb_ptr box)
{
    SGA_ARENA(mem);
    mag_ptr width = mags_take(&mem, s->n);
    enc_set_width(s, width);
    for (int j = 0; j < s->n; j++) {
        arb_set(box + j, s->x + j);
        arb_add_error_mag(box + j, width + j);
    }
}

/* The columns of M (n x n by columns, scaled doubles) by modified Gram-Schmidt, twice for each: Q in place. A column that is
 * lost becomes a unit vector that is not. */
static void orthonormal(double *M, int n)
{
    for (int k = 0; k < n; k++) {
        double *q = M + (size_t)k * (size_t)n, length = 0;
        for (int attempt = -1; attempt < n; attempt++) {
            if (attempt >= 0)
                for (int i = 0; i < n; i++)
                    q[i] = i == attempt;
            double before = 0;
            for (int i = 0; i < n; i++)
                before = hypot(before, q[i]);
            for (int twice = 0; twice < 2; twice++)
                for (int l = 0; l < k; l++) {
                    const double *p = M + (size_t)l * (size_t)n;
                    double dot = 0;
                    for (int i = 0; i < n; i++)
                        dot += p[i] * q[i];
                    for (int i = 0; i < n; i++)
                        q[i] -= dot * p[i];
                }
            length = 0;
            for (int i = 0; i < n; i++)
                length = hypot(length, q[i]);
            if (isfinite(length) && length > 1e-10 * before && length > 0)
                break;
        }
        for (int i = 0; i < n; i++)
            q[i] /= length;
    }
}

struct column {
    int index;
    mag_t size;
};

static int longer_first(const void *a, const void *b)
{
    return mag_cmp(((const struct column *)b)->size, ((const struct column *)a)->size);
}

/* The columns of U^-1 B in the order of their length times radius, as doubles, each scaled to about 1. */
static void sorted_columns(const struct enc_set *s, const arb_mat_t B, const int *unit, double *M)
{
    int n = s->n;
    SGA_FREED struct column *c = sga_malloc((size_t)n * sizeof *c);
    SGA_ENDS(arf_end) arf_t v = { 0 };
    SGA_ENDS(mag_end) mag_t a = { 0 };
    for (int k = 0; k < n; k++) {
        c[k].index = k;
        mag_init(c[k].size);
        for (int i = 0; i < n; i++) {
            arb_get_mag(a, arb_mat_entry(B, i, k));
            mag_mul_2exp_si(a, a, -unit[i]);
            mag_max(c[k].size, c[k].size, a);
        }
        mag_mul(c[k].size, c[k].size, s->radius + k);
    }
    qsort(c, (size_t)n, sizeof *c, longer_first);
    for (int k = 0; k < n; k++) {
        slong big = WORD_MIN;
        for (int i = 0; i < n; i++) {
            arb_srcptr e = arb_mat_entry(B, i, c[k].index);
            slong bits = arf_is_zero(arb_midref(e)) ? WORD_MIN : arf_abs_bound_lt_2exp_si(arb_midref(e)) - unit[i];
            big = bits > big ? bits : big;
        }
        for (int i = 0; i < n; i++) {
            arf_mul_2exp_si(v, arb_midref(arb_mat_entry(B, i, c[k].index)), -unit[i] - (big == WORD_MIN ? 0 : big));
            M[(size_t)k * (size_t)n + (size_t)i] = arf_get_d(v, ARF_RND_NEAR);
        }
    }
    for (int k = 0; k < n; k++)
        mag_clear(c[k].size);
}

/* radius = |inverse B| radius + |inverse| |rest|. */
static void new_radius(struct enc_set *s, const arb_mat_t inverse, const arb_mat_t B, const arb_srcptr y)
{
    int n = s->n;
    SGA_ENDS(arb_mat_end) arb_mat_t G;
    arb_mat_init(G, n, n);
    arb_mat_mul(G, inverse, B, BITS);
    SGA_ARENA(mem);
    mag_ptr r = mags_take(&mem, n);
    SGA_ENDS(mag_end) mag_t a = { 0 };
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            arb_get_mag(a, arb_mat_entry(G, i, k));
            mag_addmul(r + i, a, s->radius + k);
            arb_get_mag(a, arb_mat_entry(inverse, i, k));
            mag_addmul(r + i, a, arb_radref(y + k));
        }
    for (int i = 0; i < n; i++)
        mag_swap(s->radius + i, r + i);
}

bool enc_set_move(struct enc_set *s, arb_srcptr y, const arb_mat_t B, const double *size)
{
    assert(arb_mat_nrows(B) == s->n && arb_mat_ncols(B) == s->n);
    int n = s->n;
    size_t nn = (size_t)n * (size_t)n;
    SGA_ARENA(mem);
    double *M = sga_take(&mem, (nn + 1) * sizeof *M);
    int *unit = sga_take(&mem, (size_t)(n + 1) * sizeof *unit);
    for (int i = 0; i < n; i++)
        unit[i] = size[i] > 0 ? ilogb(size[i]) : 0;
    sorted_columns(s, B, unit, M);
    orthonormal(M, n);
    SGA_ENDS(arb_mat_end) arb_mat_t A, inverse;
    arb_mat_init(A, n, n);
    arb_mat_init(inverse, n, n);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            arb_set_d(arb_mat_entry(A, i, k), M[(size_t)k * (size_t)n + (size_t)i]);
            arb_mul_2exp_si(arb_mat_entry(A, i, k), arb_mat_entry(A, i, k), unit[i]);
        }
    bool ok = arb_mat_inv(inverse, A, BITS);
    if (ok)
        new_radius(s, inverse, B, y);
    for (int i = 0; i < n && ok; i++)
        arb_get_mid_arb(s->x + i, y + i);
    arb_mat_swap(s->A, A);
    for (int i = 0; i < n; i++)
        ok = ok && !mag_is_inf(s->radius + i) && arb_is_finite(s->x + i);
    return ok;
}
