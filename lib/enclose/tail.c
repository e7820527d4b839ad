/* Tails of the values: sizes, sweeps of Phi until it asks for no more, and what must stand at the end. */
#include "tail.h"

#include <assert.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "mem.h"
#include "watch.h"

void enc_tail_init(struct enc_tail *t, const struct enc_program *p)
{
    *t = (struct enc_tail){ .room = -1, .loop = sga_calloc((size_t)p->slots + 1, sizeof *t->loop) };
    enc_inverses_init(&t->inverse, p);
    for (int i = 0; i < p->slots; i++) {
        const struct enc_code *c = p->code + i;
        t->loop[i] |= i < p->n || c->op == ENC_SOLVE || c->op == ENC_SQRT;
        if (c->op == ENC_FUN || c->op == ENC_ATAN2)
            t->loop[c->g] |= c->g >= i;
        if (c->op == ENC_ATAN2)
            t->loop[c->g2] |= c->g2 >= i;
    }
}

static void drop(struct enc_tail *t)
{
    slong slots = t->inverse.p->slots, all = slots * (t->room + 2);
    if (t->room < 0)
        return;
    _mag_vec_clear(t->power, t->room + 1);
    _mag_vec_clear(t->size, all);
    _mag_vec_clear(t->rest, all);
    _mag_vec_clear(t->fixed, slots);
    _mag_vec_clear(t->moment, slots);
    _mag_vec_clear(t->tau, slots);
    if (t->dsize) {
        _mag_vec_clear(t->dsize, all);
        _mag_vec_clear(t->drest, all);
        _mag_vec_clear(t->dfixed, slots);
        _mag_vec_clear(t->dtau, slots);
        t->dsize = NULL;
    }
}

void enc_tail_clear(struct enc_tail *t)
{
    if (!t->inverse.p)
        return;
    drop(t);
    enc_inverses_clear(&t->inverse);
    free(t->loop);
    *t = (struct enc_tail){ .room = -1 };
}

static void reserve(struct enc_tail *t, int order)
{
    if (order <= t->room)
        return;
    drop(t);
    t->room = order;
    slong slots = t->inverse.p->slots, all = slots * (order + 2);
    t->power = _mag_vec_init(order + 1);
    t->size = _mag_vec_init(all);
    t->rest = _mag_vec_init(all);
    t->fixed = _mag_vec_init(slots);
    t->moment = _mag_vec_init(slots);
    t->tau = _mag_vec_init(slots);
}

void enc_tail_begin(struct enc_tail *t, const struct enc_series *s)
{
    assert(s->order >= 0);
    t->s = s;
    t->order = s->order;
    reserve(t, s->order);
    enc_inverses_forget(&t->inverse);
}

void enc_tail_overlap(mag_t r, mag_srcptr size, mag_srcptr rest, int last)
{
    assert(last >= -1);
    mag_zero(r);
    for (int i = 0; i <= last; i++)
        mag_addmul(r, size + i, rest + (last + 1 - i));
}

void enc_tail_sizes(mag_ptr size, mag_ptr rest, arb_srcptr f, mag_srcptr power, int order)
{
    mag_zero(rest + order + 1);
    for (int k = order; k >= 0; k--) {
        arb_get_mag(size + k, f + k);
        mag_mul(size + k, size + k, power + k);
        mag_add(rest + k, rest + k + 1, size + k);
    }
}

bool enc_tail_grow(mag_t tau, const mag_t phi, bool more)
{
    if (mag_cmp(phi, tau) <= 0)
        return false;
    mag_set(tau, phi);
    if (more) {
        mag_mul_ui(tau, tau, 3);
        mag_mul_2exp_si(tau, tau, -1);
    }
    return true;
}

static void all_sizes(struct enc_tail *t)
{
    const struct enc_program *p = t->s->p;
    mag_set_d(t->power, 1);
    for (int k = 1; k <= t->order; k++) {
        mag_set_d(t->power + k, t->R);
        mag_mul(t->power + k, t->power + k, t->power + k - 1);
    }
    for (int i = 0; i < p->slots; i++) {
        enc_tail_sizes(enc_tail_size(t, i), enc_tail_rest(t, i), enc_series_of(t->s, i), t->power, t->order);
        mag_zero(t->moment + i);
        for (int k = 1; k <= t->order && p->code[i].scaled; k++) {
            SGA_ENDS(mag_end) mag_t a = { 0 };
            mag_mul_ui(a, enc_tail_size(t, i) + k, (ulong)k);
            mag_add(t->moment + i, t->moment + i, a);
        }
    }
}

/* One pass. 0: tau did what the theorem asks; 1: it has grown; -1: it is infinite. */
static int sweep(struct enc_tail *t, int which)
{
    const struct enc_program *p = t->s->p;
    int grown = 0;
    SGA_ENDS(mag_end) mag_t r = { 0 };
    for (int i = p->n + 1; i < p->slots + p->n && grown >= 0; i++) {
        int slot = i < p->slots ? i : i - p->slots;      /* variables last */
        if (slot >= p->n && !p->code[slot].varies)
            continue;
        enc_tail_phi(r, t, slot);
        grown = mag_is_inf(r) || (i % ENC_LOOK == 0 && !sga_watch_ok()) ? -1 : enc_tail_grow(t->tau + slot, r, which >= ENC_PLAIN && t->loop[slot]) ? 1 : grown;
    }
    return grown;
}

/* A root must not come to 0: |tau / v| < 1. Denominators do not, as they have inverses. Matrices must stay regular. */
static bool stands(const struct enc_tail *t)
{
    const struct enc_program *p = t->s->p;
    SGA_ENDS(mag_end) mag_t u = { 0 }, none = { 0 };
    bool ok = true;
    for (int i = 0; i < p->slots && ok; i++)
        if (p->code[i].op == ENC_SQRT && p->code[i].varies) {
            enc_inverse_bound(u, t->inverse.scalar + i, none);
            mag_mul(u, u, t->tau + i);
            ok = mag_cmp_2exp_si(u, 0) < 0;
        }
    for (int k = 0; k < p->systems && ok; k++)
        ok = enc_inverse_regular(t, k);
    return ok;
}

bool enc_tail_find(struct enc_tail *t, double R)
{
    assert(R > 0);
    const struct enc_program *p = t->s->p;
    t->R = R;
    all_sizes(t);
    for (int i = 0; i < p->slots; i++) {
        mag_zero(t->tau + i);
        if (p->code[i].varies && p->code[i].op != ENC_INPUT && !enc_tail_prepare(t, i))
            return false;
        if (i % ENC_LOOK == ENC_LOOK - 1 && !sga_watch_ok())
            return false;
    }
    int state = 1;
    for (int k = 0; k < ENC_SWEEPS && state > 0 && sga_watch_ok(); k++)
        state = sweep(t, k);
    return state == 0 && stands(t);
}

void enc_tail_shrink(mag_t r, const struct enc_tail *t, const arb_t s)
{
    SGA_ENDS(mag_end) mag_t R = { 0 };
    arb_get_mag(r, s);
    mag_set_d_lower(R, t->R);
    mag_div(r, r, R);
    if (mag_cmp_2exp_si(r, 0) > 0)
        mag_one(r);
    mag_pow_ui(r, r, (ulong)t->order + 1);
}
