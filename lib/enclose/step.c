/* How far one step goes: the choice of its length, and the proof that it holds. */
#include "lohner.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "branches_hold.h"
#include "mem.h"
#include "scale.h"
#include "watch.h"

/* Steps are about this part of the radius of convergence. order^2 / step is least near e^-2 for many digits; what else a step costs asks for longer ones. */
static const double PART = 1.0 / 4;
/* Bits of the remainder of J, which makes the radii grow by about its size in each step; how much of a radius a step may add at most;
 * what the length is guessed below (estimates of tails are longer than the first term left out). */
enum { LINEAR_BITS = 20, GROWTH_BITS = 12, SLACK_BITS = 12, GUESS_BITS = 8, ACCURATE = 3, LEAST_ORDER = 6, FLAT_BITS = 44 };
/* After this much of a step only the set is in the way. */
static const double NARROW = 0x1p-10;

void enc_step_init(struct enc_step *w, const struct enc_program *p, int fields)
{
    int n = p->n;
    *w = (struct enc_step){ .p = p, .fields = fields, .box = _arb_vec_init(n), .width = _mag_vec_init(n),
                            .jacobian_tail = _mag_vec_init((slong)n * n), .bits = ENC_ROUGH_BITS, .size = sga_calloc((size_t)n + 1, sizeof(double)) };
    enc_series_init(&w->point, p);
    enc_series_init(&w->rough, p);
    enc_tail_init(&w->point_tail, p);
    enc_tail_init(&w->rough_tail, p);
}

void enc_step_clear(struct enc_step *w)
{
    if (!w->p)
        return;
    int n = w->p->n;
    if (w->jacobian)
        _arb_vec_clear(w->jacobian, w->jacobian_room);
    enc_series_clear(&w->point);
    enc_series_clear(&w->rough);
    enc_tail_clear(&w->point_tail);
    enc_tail_clear(&w->rough_tail);
    _arb_vec_clear(w->box, n);
    _mag_vec_clear(w->width, n);
    _mag_vec_clear(w->jacobian_tail, (slong)n * n);
    free(w->size);
    *w = (struct enc_step){ 0 };
}

static int order_for(slong bits)
{
    return (int)fmax(LEAST_ORDER, ceil((double)bits / -log2(PART)));
}

/* A step with few bits, so that times stay short. */
static double short_number(double h)
{
    int e;
    double m = frexp(h, &e);
    return ldexp(floor(m * 4096) / 4096, e);
}

/* By how many bits the tail is longer than it should be, at most. */
static double excess(const struct enc_step *w)
{
    int n = w->p->n;
    double most = -HUGE_VAL;
    SGA_FREED double *scale = sga_malloc((size_t)(n + 1) * sizeof *scale);
    SGA_ARENA(mem);
    mag_ptr scratch = mags_take(&mem, w->p->slots);
    enc_scale_of(&w->point_tail, scratch, scale);
    for (int j = 0; j < n; j++)
        if (!mag_is_zero(w->point_tail.tau + j)) {
            double allowed = fmax(scale[j] - (double)w->prec, mag_get_d_log2_approx(w->width + j) - SLACK_BITS);
            most = fmax(most, mag_get_d_log2_approx(w->point_tail.tau + j) - allowed);
        }
    return most;
}

/* The longest step that the point's series is good for. */
static bool from_point(struct enc_step *w, double far, double least)
{
    double guess = exp2(fmin(1000, enc_scale_step(&w->point, w->width, (double)w->prec + GUESS_BITS, SLACK_BITS)));
    double h = guess < far ? short_number(guess) : far;
    int accurate = 0;
    for (; h >= least && sga_watch_ok(); h = short_number(h)) {
        double over = 0;
        if (!enc_tail_find(&w->point_tail, h))
            h *= 0.7;
        else if (accurate++ < ACCURATE && (over = excess(w)) > 0)
            h *= exp2(-fmin(1, (over + 2) / w->point.order));
        else
            break;
    }
    w->h = h;
    return h >= least && sga_watch_ok();
}

/* The order from which on the point's series is below 2^-LINEAR_BITS of itself. */
static int linear_order(const struct enc_step *w)
{
    int order = LEAST_ORDER;
    for (int j = 0; j < w->p->n; j++) {
        mag_srcptr rest = enc_tail_rest(&w->point_tail, j);
        double whole = mag_get_d_log2_approx(rest);
        while (order < w->point.order && mag_get_d_log2_approx(rest + order + 1) > whole - LINEAR_BITS)
            order++;
    }
    order += w->more;
    return order < w->point.order ? order : w->point.order;
}

static void keep_jacobian(struct enc_step *w, int j)
{
    int n = w->p->n, order = w->rough.order;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k <= order; k++)
            arb_set(enc_step_jacobian(w, i, j) + k, enc_series_tangent(&w->rough, i) + k);
        mag_set(w->jacobian_tail + i * n + j, w->rough_tail.dtau + i);
    }
}

static bool jacobian(struct enc_step *w)
{
    int n = w->p->n;
    slong need = (slong)n * n * (w->rough.order + 1);
    if (need > w->jacobian_room) {
        if (w->jacobian)
            _arb_vec_clear(w->jacobian, w->jacobian_room);
        w->jacobian = _arb_vec_init(need);
        w->jacobian_room = need;
    }
    for (int j = 0; j < n; j++) {
        if (!enc_series_along(&w->rough, j) || !enc_tail_along(&w->rough_tail))
            return false;
        keep_jacobian(w, j);
    }
    return true;
}

/* Whether tails of J add little to the radii. */
static bool sharp(const struct enc_step *w)
{
    int n = w->p->n;
    bool ok = true;
    SGA_ENDS(mag_end) mag_t added = { 0 }, whole = { 0 }, a = { 0 };
    int terms = w->rough.order + 1;
    SGA_ARENA(mem);
    arb_ptr power = arbs_take(&mem, terms);
    SGA_ENDS(arb_end) arb_t v = { 0 };
    arb_set_d(v, w->h);
    _arb_vec_set_powers(power, v, terms, ENC_ROUGH_BITS);
    for (int i = 0; i < n && ok; i++) {
        mag_zero(added);
        mag_set(whole, w->width + i);
        for (int j = 0; j < n; j++) {
            mag_addmul(added, w->jacobian_tail + i * n + j, w->width + j);
            arb_dot(v, NULL, 0, enc_step_jacobian(w, i, j), 1, power, 1, terms, ENC_ROUGH_BITS);
            arb_get_mag(a, v);
            mag_addmul(whole, a, w->width + j);
        }
        mag_mul_2exp_si(whole, whole, -GROWTH_BITS);
        ok = mag_cmp(added, whole) <= 0;
    }
    return ok;
}

/* Everything about the set for the step |h|, of order `order`. */
enum outcome { GOOD, SERIES, TAILS, BRANCHES, NONE };

static enum outcome over_set(struct enc_step *w, const arb_t t, int order, double h)
{
    if (w->rough_tail.s == NULL || w->rough.order != order || w->rough.prec != w->bits) {
        w->runs++;
        w->rough_tail.s = NULL;
        if (!enc_series_run(&w->rough, w->box, t, order, w->bits))
            return SERIES;
        enc_tail_begin(&w->rough_tail, &w->rough);
    }
    if (!enc_tail_find(&w->rough_tail, fabs(h)))
        return TAILS;
    if (!enc_branches_hold(&w->rough_tail, h, w->fields, &w->bad))
        return BRANCHES;
    w->h = h;
    return jacobian(w) && sharp(w) ? GOOD : TAILS;
}

/* Units: what the variables move by, but not nothing. */
static void sizes(struct enc_step *w)
{
    int n = w->p->n;
    double big = 0;
    for (int j = 0; j < n; j++)
        big = fmax(big, mag_get_d(enc_tail_rest(&w->point_tail, j)));
    big = big > 0 && isfinite(big) ? big : 1;
    for (int j = 0; j < n; j++) {
        double all = mag_get_d(enc_tail_rest(&w->point_tail, j)), moves = mag_get_d(enc_tail_rest(&w->point_tail, j) + 1);
        w->size[j] = fmax(moves, fmax(ldexp(fmax(all, 0x1p-10 * big), -FLAT_BITS), 0x1p-900));
    }
}

/* The step |h| of the point, or a shorter one, for all of the set. */
static bool from_set(struct enc_step *w, const arb_t t, double sign, double least)
{
    double h = w->h, whole = h;
    int order = linear_order(w);
    enum outcome got = NONE;
    w->rough_tail.s = NULL;
    while (h >= least && sga_watch_ok() && (got = over_set(w, t, order, sign * h)) != GOOD) {
        w->failure = got == BRANCHES ? ENC_STEP_SHORT : ENC_STEP_WIDE;
        if (got == SERIES || (got == TAILS && h < NARROW * whole)) {
            if (w->bits >= w->prec)
                return false;
            w->bits *= 2;        /* cancellation, not the set */
            h = whole;
        } else if (got == TAILS && order < w->point.order) {
            w->more += 4;
            order = order + 4 < w->point.order ? order + 4 : w->point.order;
        } else {
            h = short_number(got == BRANCHES ? 0.5 * h : 0.7 * h);
        }
    }
    return h >= least && got == GOOD && (h == whole || enc_tail_find(&w->point_tail, h));
}

bool enc_step_make(struct enc_step *w, const struct enc_set *set, const arb_t t, double most, double least, slong prec)
{
    assert(set->n == w->p->n && prec > 1);
    w->prec = prec;
    w->bad = -1;
    w->failure = ENC_STEP_SHORT;
    enc_set_width(set, w->width);
    for (int j = 0; j < w->p->n; j++) {
        arb_set(w->box + j, set->x + j);
        arb_add_error_mag(w->box + j, w->width + j);
    }
    w->runs++;
    if (!enc_series_run(&w->point, set->x, t, order_for(prec), prec + 10))
        return false;
    enc_tail_begin(&w->point_tail, &w->point);
    if (!from_point(w, fabs(most), least) || !from_set(w, t, most < 0 ? -1 : 1, least))
        return false;
    sizes(w);
    if (++w->calm % 4 == 0) {
        w->more -= w->more > 0;
        w->bits = w->calm % 16 ? w->bits : ENC_ROUGH_BITS;
    }
    w->failure = ENC_STEP_OK;
    return true;
}
