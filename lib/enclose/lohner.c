/* One step of the enclosure, and its value in between. */
#include "lohner.h"

#include <math.h>
#include <stdlib.h>

#include "mem.h"

/* The step is this part of the disc's radius: order^2 / step is least near e^-2 for many digits. */
static const double PART = 1.0 / 6;
/* Bits of everything that multiplies radii, and of the remainder of J, which makes the radii grow by about its size in each step. */
enum { ROUGH_BITS = 64, LINEAR_BITS = 26 };

void enc_step_init(struct enc_step *w, const struct enc_program *p, int fields)
{
    *w = (struct enc_step){ .p = p };
    enc_disc_init(&w->disc, p, fields);
    enc_series_init(&w->point, p);
    enc_series_init(&w->rough, p);
}

void enc_step_clear(struct enc_step *w)
{
    if (!w->p)
        return;
    if (w->jacobian)
        _arb_vec_clear(w->jacobian, w->jacobian_room);
    enc_disc_clear(&w->disc);
    enc_series_clear(&w->point);
    enc_series_clear(&w->rough);
    *w = (struct enc_step){ 0 };
}

static arb_ptr jacobian_of(const struct enc_step *w, int i, int j)
{
    return w->jacobian + ((size_t)i * (size_t)w->p->n + (size_t)j) * (size_t)(w->linear + 1);
}

/* min_j d_j / |(A r)_j|, rounded down; 2^900 at most. */
static double theta_of(const struct enc_step *w, const struct enc_set *set)
{
    int n = set->n;
    double theta = 0x1p900;
    mag_t sum, a;
    mag_init(sum);
    mag_init(a);
    for (int j = 0; j < n; j++) {
        mag_zero(sum);
        for (int k = 0; k < n; k++) {
            arb_get_mag(a, arb_mat_entry(set->A, j, k));
            mag_addmul(sum, a, set->radius + k);
        }
        mag_set_d_lower(a, w->disc.d[j]);
        mag_div_lower(a, a, sum);
        if (!mag_is_zero(sum) && mag_cmp_2exp_si(a, 900) < 0)
            theta = fmin(theta, mag_get_d(a) * (1 - 0x1p-40));
    }
    mag_clear(sum);
    mag_clear(a);
    return theta;
}

/* An order whose remainder (h / R)^(order + 1) is below 2^-bits. */
static int order_for(double part, slong bits)
{
    double per = -log2(part);
    return (int)fmax(2, ceil((double)bits / per));
}

static bool tangents(struct enc_step *w)
{
    int n = w->p->n;
    slong need = (slong)n * n * (w->linear + 1);
    if (need > w->jacobian_room) {
        if (w->jacobian)
            _arb_vec_clear(w->jacobian, w->jacobian_room);
        w->jacobian = _arb_vec_init(need);
        w->jacobian_room = need;
    }
    for (int j = 0; j < n; j++) {
        if (!enc_series_along(&w->rough, j))
            return false;
        for (int i = 0; i < n; i++)
            for (int k = 0; k <= w->linear; k++)
                arb_set(jacobian_of(w, i, j) + k, enc_series_tangent(&w->rough, i) + k);
    }
    return true;
}

/* A step with few bits, so that times stay short. */
static double short_number(double h)
{
    int e;
    double m = frexp(h, &e);
    return ldexp(floor(fabs(m) * 4096) / 4096, e);
}

bool enc_step_make(struct enc_step *w, const struct enc_set *set, const arb_t t, double most, double least, slong prec)
{
    double far = fabs(most);
    w->prec = prec;
    w->failure = ENC_STEP_DISC;
    if (!enc_disc_find(&w->disc, set->x, t, fmin(far / PART, 0x1p500), least / PART))
        return false;
    double h = short_number(PART * w->disc.R);
    if (h >= far)
        h = far;
    w->h = most < 0 ? -h : h;
    w->failure = ENC_STEP_WIDE;
    w->theta = theta_of(w, set);
    if (!(w->theta > 2))
        return false;
    w->failure = ENC_STEP_SERIES;
    double part = h / w->disc.R * (1 + 0x1p-40);
    w->order = order_for(part, prec);
    w->linear = order_for(part, LINEAR_BITS);
    if (!enc_series_run(&w->point, set->x, t, w->order, prec + 10)
        || !enc_series_run(&w->rough, set->x, t, w->linear, ROUGH_BITS) || !tangents(w))
        return false;
    w->failure = ENC_STEP_OK;
    return true;
}

/* (|s| / R)^(order + 1) / (1 - |s| / R), above. */
static void geometric(mag_t r, const struct enc_step *w, const arb_t s, int order)
{
    mag_t q, one;
    mag_init(q);
    mag_init(one);
    arb_get_mag(q, s);
    mag_set_d_lower(one, w->disc.R);
    mag_div(q, q, one);
    mag_pow_ui(r, q, (ulong)order + 1);
    mag_one(one);
    mag_sub_lower(one, one, q);
    mag_div(r, r, one);
    mag_clear(q);
    mag_clear(one);
}

/* y = phi_s(x) with its remainder and w, the second-order part of the set. */
static void centre(const struct enc_step *w, const arb_t s, arb_ptr y)
{
    mag_t tail, b, e;
    mag_init(tail);
    mag_init(b);
    mag_init(e);
    geometric(tail, w, s, w->order);
    mag_set_d_lower(e, w->theta);        /* T^-2 / (1 - 1/T) = 1 / (T (T - 1)) */
    mag_set_d_lower(b, w->theta - 1 - w->theta * 0x1p-50);
    mag_mul_lower(e, e, b);
    mag_one(b);
    mag_div(e, b, e);
    mag_add(tail, tail, e);
    for (int i = 0; i < w->p->n; i++) {
        _arb_poly_evaluate(y + i, enc_series_of(&w->point, i), w->order + 1, s, w->prec + 10);
        mag_set_d(b, w->disc.b[i]);
        mag_mul(e, b, tail);
        arb_add_error_mag(y + i, e);
    }
    mag_clear(tail);
    mag_clear(b);
    mag_clear(e);
}

/* B = J(s) A. */
static void linear_part(const struct enc_step *w, const struct enc_set *set, const arb_t s, arb_mat_t B)
{
    int n = set->n;
    mag_t tail, b, d;
    mag_init(tail);
    mag_init(b);
    mag_init(d);
    geometric(tail, w, s, w->linear);
    arb_mat_t J;
    arb_mat_init(J, n, n);
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            _arb_poly_evaluate(arb_mat_entry(J, i, j), jacobian_of(w, i, j), w->linear + 1, s, ROUGH_BITS);
            mag_set_d(b, w->disc.b[i]);
            mag_set_d_lower(d, w->disc.d[j]);
            mag_div(b, b, d);
            mag_mul(b, b, tail);
            arb_add_error_mag(arb_mat_entry(J, i, j), b);
        }
    arb_mat_mul(B, J, set->A, ROUGH_BITS);
    arb_mat_clear(J);
    mag_clear(tail);
    mag_clear(b);
    mag_clear(d);
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
    bool ok = enc_set_move(set, y, B, w->disc.b);
    arb_mat_clear(B);
    arb_clear(s);
    _arb_vec_clear(y, n);
    return ok;
}
