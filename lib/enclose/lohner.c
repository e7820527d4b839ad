/* The set after a step, and boxes in between. */
#include "lohner.h"

/* y = phi_s(x). */
static void centre(const struct enc_step *w, const arb_t s, arb_ptr y)
{
    mag_t tail, e;
    mag_init(tail);
    mag_init(e);
    enc_tail_shrink(tail, &w->point_tail, s);
    for (int i = 0; i < w->p->n; i++) {
        _arb_poly_evaluate(y + i, enc_series_of(&w->point, i), w->point.order + 1, s, w->prec + 10);
        mag_mul(e, w->point_tail.tau + i, tail);
        arb_add_error_mag(y + i, e);
    }
    mag_clear(tail);
    mag_clear(e);
}

/* B = J(s) A. */
static void linear_part(const struct enc_step *w, const struct enc_set *set, const arb_t s, arb_mat_t B)
{
    int n = set->n;
    mag_t tail, e;
    mag_init(tail);
    mag_init(e);
    enc_tail_shrink(tail, &w->rough_tail, s);
    arb_mat_t J;
    arb_mat_init(J, n, n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            arb_ptr v = arb_mat_entry(J, i, j);
            _arb_poly_evaluate(v, enc_step_jacobian(w, i, j), w->rough.order + 1, s, ENC_ROUGH_BITS);
            mag_mul(e, w->jacobian_tail + i * n + j, tail);
            arb_add_error_mag(v, e);
        }
    arb_mat_mul(B, J, set->A, ENC_ROUGH_BITS);
    arb_mat_clear(J);
    mag_clear(tail);
    mag_clear(e);
}

void enc_step_at(const struct enc_step *w, const struct enc_set *set, const arb_t s, arb_ptr box)
{
    int n = set->n;
    arb_mat_t B;
    arb_mat_init(B, n, n);
    mag_t a;
    mag_init(a);
    centre(w, s, box);
    linear_part(w, set, s, B);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            arb_get_mag(a, arb_mat_entry(B, i, k));
            mag_mul(a, a, set->radius + k);
            arb_add_error_mag(box + i, a);
        }
    arb_mat_clear(B);
    mag_clear(a);
}

bool enc_step_take(const struct enc_step *w, struct enc_set *set)
{
    int n = set->n;
    arb_ptr y = _arb_vec_init(n);
    arb_mat_t B;
    arb_t s;
    arb_init(s);
    arb_mat_init(B, n, n);
    arb_set_d(s, w->h);
    centre(w, s, y);
    linear_part(w, set, s, B);
    bool ok = enc_set_move(set, y, B, w->size);
    arb_mat_clear(B);
    arb_clear(s);
    _arb_vec_clear(y, n);
    return ok;
}
