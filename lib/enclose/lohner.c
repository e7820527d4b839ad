/* The set after a step, and boxes in between. */
#include <assert.h>

#include "arb_ends.h"
#include "arena.h"
#include "lohner.h"

/* Many polynomials at one place: its powers once, for dot products. */
static arb_ptr powers(const arb_t s, int order, slong prec)
{
    arb_ptr p = _arb_vec_init(order + 1);
    _arb_vec_set_powers(p, s, order + 1, prec);
    return p;
}

/* y = phi_s(x). */
static void centre(const struct enc_step *w, const arb_t s, arb_ptr y)
{
    SGA_ENDS(mag_end) mag_t tail = { 0 }, e = { 0 };
    enc_tail_shrink(tail, &w->point_tail, s);
    int terms = w->point.order + 1;
    arb_ptr power = powers(s, w->point.order, w->prec + 10);
    for (int i = 0; i < w->p->n; i++) {
        arb_dot(y + i, NULL, 0, enc_series_of(&w->point, i), 1, power, 1, terms, w->prec + 10);
        mag_mul(e, w->point_tail.tau + i, tail);
        arb_add_error_mag(y + i, e);
    }
    _arb_vec_clear(power, terms);
}

/* B = J(s) A. */
static void linear_part(const struct enc_step *w, const struct enc_set *set, const arb_t s, arb_mat_t B)
{
    int n = set->n;
    SGA_ENDS(mag_end) mag_t tail = { 0 }, e = { 0 };
    enc_tail_shrink(tail, &w->rough_tail, s);
    SGA_ENDS(arb_mat_end) arb_mat_t J;
    arb_mat_init(J, n, n);
    int terms = w->rough.order + 1;
    arb_ptr power = powers(s, w->rough.order, ENC_ROUGH_BITS);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            arb_ptr v = arb_mat_entry(J, i, j);
            arb_dot(v, NULL, 0, enc_step_jacobian(w, i, j), 1, power, 1, terms, ENC_ROUGH_BITS);
            mag_mul(e, w->jacobian_tail + i * n + j, tail);
            arb_add_error_mag(v, e);
        }
    _arb_vec_clear(power, terms);
    arb_mat_mul(B, J, set->A, ENC_ROUGH_BITS);
}

void enc_step_at(const struct enc_step *w, const struct enc_set *set, const arb_t s, arb_ptr box)
{
    assert(set->n == w->p->n);
    int n = set->n;
    SGA_ENDS(arb_mat_end) arb_mat_t B;
    arb_mat_init(B, n, n);
    SGA_ENDS(mag_end) mag_t a = { 0 };
    centre(w, s, box);
    linear_part(w, set, s, B);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            arb_get_mag(a, arb_mat_entry(B, i, k));
            mag_mul(a, a, set->radius + k);
            arb_add_error_mag(box + i, a);
        }
}

bool enc_step_take(const struct enc_step *w, struct enc_set *set, const arb_t s)
{
    assert(set->n == w->p->n);
    int n = set->n;
    SGA_ARENA(mem);
    arb_ptr y = arbs_take(&mem, n);
    SGA_ENDS(arb_mat_end) arb_mat_t B;
    arb_mat_init(B, n, n);
    centre(w, s, y);
    linear_part(w, set, s, B);
    return enc_set_move(set, y, B, w->size);
}
