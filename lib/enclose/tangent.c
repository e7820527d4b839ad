/* Derivatives of the coefficients with respect to the start. They are linear: that of a product is two convolutions,
 * that of f(x) one with f'(x). */
#include <assert.h>

#include "arb_ends.h"
#include "arena.h"
#include "series.h"
#include "watch.h"

/* r = r0 -or+ sum over i of (tangent of slot)_i v_{k-i}: from its first coefficient that is not 0, to the last one of v. */
static void convolve_along(struct enc_series *s, arb_t r, const arb_t r0, bool minus, int slot, int v, slong k)
{
    slong from = s->p->code[v].varies ? s->from[slot] : k;
    if (from <= k && s->from[slot] <= k)
        enc_convolve(r, r0, minus, enc_series_tangent(s, slot) + from, enc_series_of(s, v), k - from, k - from + 1, s->prec);
    else if (r0 && r0 != r)
        arb_set(r, r0);
    else if (!r0)
        arb_zero(r);
}

/* S y' = r' - S' y, orders as above. */
static void solve_along(struct enc_series *s, int index, slong k)
{
    const struct enc_system *q = s->p->system + index;
    int m = q->m;
    SGA_ARENA(mem);
    arb_ptr r = arbs_take(&mem, m);
    for (int i = 0; i < m; i++) {
        arb_set(r + i, enc_series_tangent(s, q->rhs[i]) + k);
        for (int j = 0; j < m; j++) {
            int e = q->matrix[i * m + j];
            convolve_along(s, r + i, r + i, true, e, q->first + j, k);
            if (s->p->code[e].varies)
                enc_convolve(r + i, r + i, true, enc_series_of(s, e) + 1, enc_series_tangent(s, q->first + j), k - 1, k, s->prec);
        }
    }
    for (int i = 0; i < m; i++)
        arb_dot(enc_series_tangent(s, q->first + i) + k, NULL, 0, (s->inverse + index)->rows[i], 1, r, 1, m, s->prec);
}

/* Of a choice that is undecided: all of whose ends are derivatives of the branches (Clarke's). */
static void between(const struct enc_code *c, arb_t r, const arb_t da, const arb_t db, slong prec)
{
    SGA_ENDS(arb_end) arb_t other = { 0 };
    arb_neg(other, da);
    if (c->fun == EXPR_SIGN)
        arb_indeterminate(r);
    else
        arb_union(r, da, c->fun == EXPR_ABS ? other : db, prec);
}

/* Derivatives are linear: those of a product are two convolutions, of f(x) one with f'(x). */
static void along(struct enc_series *s, int i, slong k)
{
    const struct enc_code *c = s->p->code + i;
    arb_ptr r = enc_series_tangent(s, i) + k, da = enc_series_tangent(s, c->a), db = enc_series_tangent(s, c->b);
    arb_ptr v = enc_series_of(s, i), b = enc_series_of(s, c->b);
    slong prec = s->prec;
    switch (c->op) {
    case ENC_ADD: arb_add(r, da + k, db + k, prec); break;
    case ENC_SUB: arb_sub(r, da + k, db + k, prec); break;
    case ENC_NEG: arb_neg(r, da + k); break;
    case ENC_MUL:
        convolve_along(s, r, NULL, false, c->a, c->b, k);
        convolve_along(s, r, r, false, c->b, c->a, k);
        break;
    case ENC_DIV:        /* b v' = a' - v b' */
        convolve_along(s, r, da + k, true, c->b, i, k);
        enc_convolve(r, r, true, b + 1, enc_series_tangent(s, i), k - 1, k, prec);
        arb_div(r, r, b, prec);
        break;
    case ENC_SQRT:       /* 2 v v' = a' */
        arb_mul_2exp_si(r, da + k, -1);
        enc_convolve(r, r, true, v + 1, enc_series_tangent(s, i), k - 1, k, prec);
        arb_div(r, r, v, prec);
        break;
    case ENC_FUN: convolve_along(s, r, NULL, c->sign < 0, c->a, c->g, k); break;
    case ENC_ATAN2:
        convolve_along(s, r, NULL, false, c->a, c->g, k);
        convolve_along(s, r, r, true, c->b, c->g2, k);
        break;
    case ENC_CHOICE:
        if (s->choice[i] || k)
            enc_follow(r, s->choice[i], da + k, db + k, false);
        else
            between(c, r, da, db, prec);
        break;
    case ENC_SOLVE:
        if (c->b == 0)
            solve_along(s, c->a, k);
        break;
    default: break;
    }
}

static void begin_along(struct enc_series *s, int direction)
{
    if (!s->tangent)
        s->tangent = _arb_vec_init((slong)s->p->slots * (s->room + 1));
    for (int i = 0; i < s->p->slots; i++) {
        _arb_vec_zero(enc_series_tangent(s, i), s->order + 1);
        s->from[i] = s->p->code[i].state ? 0 : s->order + 1;
    }
    arb_one(enc_series_tangent(s, direction));
    for (int j = 0; j < s->p->n; j++)
        s->from[j] = j != direction;
}

/* Slots whose operands have not been reached yet stay 0. */
static bool reached(const struct enc_series *s, const struct enc_code *c, slong k)
{
    if (c->op == ENC_SOLVE) {
        const struct enc_system *q = s->p->system + c->a;
        for (int i = 0; i < q->m * q->m; i++)
            if (s->from[q->matrix[i]] <= k)
                return true;
        for (int i = 0; i < q->m; i++)
            if (s->from[q->rhs[i]] <= k)
                return true;
        return false;
    }
    bool one = c->op == ENC_NEG || c->op == ENC_SQRT || c->op == ENC_FUN;
    return s->from[c->a] <= k || (!one && s->from[c->b] <= k);
}

static bool all_along(struct enc_series *s, slong k)
{
    const struct enc_program *p = s->p;
    bool ok = true;
    for (int i = p->n + 1; i < p->slots && ok; i++) {
        if (p->code[i].aux)      /* only values of those are used */
            continue;
        if (!p->code[i].state || (s->from[i] == k && !reached(s, p->code + i, k))) {
            s->from[i] += p->code[i].state;
            continue;
        }
        along(s, i, k);
        ok = arb_is_finite(enc_series_tangent(s, i) + k);
    }
    return ok;
}

bool enc_series_slope(struct enc_series *s, int direction)
{
    begin_along(s, direction);
    return all_along(s, 0);
}

bool enc_series_along(struct enc_series *s, int direction)
{
    assert(direction >= 0 && direction < s->p->n);
    const struct enc_program *p = s->p;
    begin_along(s, direction);
    bool ok = true;
    for (int k = 0; k <= s->order && ok; k++) {
        ok = all_along(s, k) && sga_watch_ok();
        for (int j = 0; j < p->n && k < s->order; j++) {
            if (s->from[j] == k + 1 && s->from[p->root[j]] > k)
                s->from[j]++;
            else
                arb_div_ui(enc_series_tangent(s, j) + k + 1, enc_series_tangent(s, p->root[j]) + k, (ulong)k + 1, s->prec);
        }
    }
    return ok;
}
