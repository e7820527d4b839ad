/* Magnitudes. */
#include "scale.h"

#include <assert.h>
#include <math.h>

#include "arb_ends.h"
#include "arena.h"

static double log2_of_mag(mag_srcptr m)
{
    return mag_is_zero(m) ? -HUGE_VAL : mag_get_d_log2_approx(m);
}

static double log2_of(const arb_t x)
{
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_get_mag(m, x);
    return log2_of_mag(m);
}

/* Of variable j by coefficient k. One whose series only begins in its second half (y_k' = y_1 y_(k-1) from 0) says nothing. */
static double step_by(arb_srcptr c, int k, double bits, double least)
{
    double last = log2_of(c + k), best = -HUGE_VAL;
    if (last == -HUGE_VAL)
        return HUGE_VAL;
    for (int i = 0; 2 * i <= k; i++)
        best = fmax(best, (log2_of(c + i) - bits - last) / (k - i));
    return best == -HUGE_VAL && least == -HUGE_VAL ? HUGE_VAL : fmax(best, (least - last) / k);
}

double enc_scale_step(const struct enc_series *s, mag_srcptr width, double bits, double slack)
{
    assert(bits > 0 && s->order >= 0);
    double best = HUGE_VAL;
    for (int j = 0; j < s->p->n; j++)
        for (int k = s->order > 1 ? s->order - 1 : 1; k <= s->order; k++)
            best = fmin(best, step_by(enc_series_of(s, j), k, bits, log2_of_mag(width + j) - slack));
    return best;
}

static void scale_slot(const struct enc_tail *t, mag_ptr m, int i)
{
    const struct enc_code *c = t->s->p->code + i;
    SGA_ENDS(mag_end) mag_t u = { 0 };
    switch (c->op) {
    case ENC_ADD: case ENC_SUB: mag_add(m + i, m + c->a, m + c->b); break;
    case ENC_NEG: mag_set(m + i, m + c->a); break;
    case ENC_MUL: mag_mul(m + i, m + c->a, m + c->b); break;
    case ENC_DIV:
        if (c->varies) {
            enc_inverse_bound(u, t->inverse.scalar + c->b, t->tau + c->b);
            mag_mul(m + i, m + c->a, u);
            break;
        }
        /* fall through */
    default: mag_set(m + i, enc_tail_rest(t, i)); break;
    }
}

void enc_scale_of(const struct enc_tail *t, mag_ptr m, double *log2_scale)
{
    const struct enc_program *p = t->s->p;
    for (int i = 0; i < p->slots; i++)
        scale_slot(t, m, i);
    for (int j = 0; j < p->n; j++)
        log2_scale[j] = fmax(mag_get_d_log2_approx(enc_tail_rest(t, j)), mag_get_d_log2_approx(m + p->root[j]) + log2(t->R));
}
