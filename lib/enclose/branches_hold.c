/* Values over parts of a step. */
#include <assert.h>

#include "arb_ends.h"
#include "arena.h"
#include "branches_hold.h"

enum { BITS = 64, PARTS = 32 };

/* f on the part k of the way, into r. */
static void over(arb_t r, const struct enc_tail *t, int slot, double h, int k)
{
    SGA_ENDS(arb_end) arb_t s = { 0 };
    arb_set_d(s, h);
    arb_mul_si(s, s, 2 * k + 1, BITS);
    arb_div_ui(s, s, 2 * PARTS, BITS);
    SGA_ENDS(mag_end) mag_t half = { 0 };
    mag_set_d(half, h < 0 ? -h : h);
    mag_div_ui(half, half, 2 * PARTS);
    arb_add_error_mag(s, half);
    _arb_poly_evaluate(r, enc_series_of(t->s, slot), t->order + 1, s, BITS);
    arb_add_error_mag(r, t->tau + slot);
}

/* |f_0| > |f - f_0| of f, or of f - g (g < 0: none). */
static bool far_from_zero(const struct enc_tail *t, int f, int g)
{
    SGA_ENDS(arb_end) arb_t d = { 0 };
    SGA_ENDS(mag_end) mag_t move = { 0 }, low = { 0 };
    arb_set(d, enc_series_of(t->s, f));
    mag_add(move, enc_tail_rest(t, f) + 1, t->tau + f);
    if (g >= 0) {
        arb_sub(d, d, enc_series_of(t->s, g), BITS);
        mag_add(move, move, enc_tail_rest(t, g) + 1);
        mag_add(move, move, t->tau + g);
    }
    arb_get_mag_lower(low, d);
    return mag_cmp(low, move) > 0;
}

static bool never_zero(const struct enc_tail *t, double h, int f, int g)
{
    if (far_from_zero(t, f, g))
        return true;
    SGA_ENDS(arb_end) arb_t a = { 0 }, b = { 0 };
    bool ok = true;
    for (int k = 0; k < PARTS && ok; k++) {
        over(a, t, f, h, k);
        if (g >= 0) {
            over(b, t, g, h, k);
            arb_sub(a, a, b, BITS);
        }
        ok = arb_is_finite(a) && !arb_contains_zero(a);
    }
    return ok;
}

/* Off the cut of the argument of x + i y. */
static bool off_cut(const struct enc_tail *t, double h, int y, int x)
{
    SGA_ENDS(arb_end) arb_t a = { 0 };
    bool ok = true;
    for (int k = 0; k < PARTS && ok; k++) {
        over(a, t, x, h, k);
        ok = arb_is_finite(a) && arb_is_positive(a);
        if (!ok) {
            over(a, t, y, h, k);
            ok = arb_is_finite(a) && !arb_contains_zero(a);
        }
    }
    return ok;
}

bool enc_branches_hold(const struct enc_tail *t, double h, int fields, int *bad)
{
    assert(fields >= 0 && fields <= t->s->p->slots);
    const struct enc_program *p = t->s->p;
    *bad = -1;
    for (int i = 0; i < p->slots; i++) {
        const struct enc_code *c = p->code + i;
        if (!c->varies || (c->op != ENC_CHOICE && c->op != ENC_ATAN2))
            continue;
        bool two = c->fun == EXPR_MIN || c->fun == EXPR_MAX;
        if (c->op == ENC_ATAN2 ? !off_cut(t, h, c->a, c->b) : !never_zero(t, h, c->a, two ? c->b : -1))
            return false;
    }
    for (int k = fields; k < p->roots; k++)
        if (!never_zero(t, h, p->root[k], -1)) {
            *bad = k - fields;
            return false;
        }
    return true;
}
