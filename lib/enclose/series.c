/* The recurrences, coefficient by coefficient. */
#include "series.h"

#include <assert.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "mem.h"
#include "watch.h"

void enc_series_init(struct enc_series *s, const struct enc_program *p)
{
    *s = (struct enc_series){ .p = p, .room = -1, .choice = sga_calloc((size_t)p->slots + 1, 1),
                              .from = sga_calloc((size_t)p->slots + 1, sizeof(int)) };
    s->inverse = sga_calloc((size_t)p->systems + 1, sizeof *s->inverse);
    for (int k = 0; k < p->systems; k++)
        arb_mat_init(s->inverse + k, p->system[k].m, p->system[k].m);
}

static void drop(struct enc_series *s)
{
    slong total = (slong)s->p->slots * (s->room + 1);
    if (s->value)
        _arb_vec_clear(s->value, total);
    if (s->scaled)
        _arb_vec_clear(s->scaled, total);
    if (s->tangent)
        _arb_vec_clear(s->tangent, total);
    s->value = s->scaled = s->tangent = NULL;
}

void enc_series_clear(struct enc_series *s)
{
    if (!s->p)
        return;
    drop(s);
    for (int k = 0; k < s->p->systems; k++)
        arb_mat_clear(s->inverse + k);
    free(s->inverse);
    free(s->choice);
    free(s->from);
    *s = (struct enc_series){ 0 };
}

static void reserve(struct enc_series *s, int order)
{
    if (order <= s->room)
        return;
    drop(s);
    s->room = order;
    s->value = _arb_vec_init((slong)s->p->slots * (order + 1));
    s->scaled = _arb_vec_init((slong)s->p->slots * (order + 1));
}

static arb_ptr scaled_of(const struct enc_series *s, int slot)
{
    return s->scaled + (size_t)slot * (size_t)(s->room + 1);
}

void enc_convolve(arb_t r, const arb_t r0, bool minus, arb_srcptr x, arb_srcptr y, slong top, slong len, slong prec)
{
    assert(top >= len - 1);
    arb_dot(r, r0, minus, x, 1, len > 0 ? y + top : y, -1, len > 0 ? len : 0, prec);
}

static void sum_fun(struct enc_series *s, int i, slong k)
{
    const struct enc_code *c = s->p->code + i;
    arb_ptr r = enc_series_of(s, i) + k;
    if (c->op == ENC_ATAN2) {
        enc_convolve(r, NULL, false, scaled_of(s, c->a) + 1, enc_series_of(s, c->g), k - 1, k, s->prec);
        enc_convolve(r, r, true, scaled_of(s, c->b) + 1, enc_series_of(s, c->g2), k - 1, k, s->prec);
    } else {
        enc_convolve(r, NULL, c->sign < 0, scaled_of(s, c->a) + 1, enc_series_of(s, c->g), k - 1, k, s->prec);
    }
    arb_div_ui(r, r, (ulong)k, s->prec);
}

static void choose(struct enc_series *s, int i)
{
    const struct enc_code *c = s->p->code + i;
    SGA_ENDS(arb_end) arb_t d = { 0 };
    if (c->fun == EXPR_MIN || c->fun == EXPR_MAX)
        arb_sub(d, enc_series_of(s, c->a), enc_series_of(s, c->b), s->prec);
    else
        arb_set(d, enc_series_of(s, c->a));
    int sign = arb_is_positive(d) ? 1 : arb_is_negative(d) ? -1 : 0;
    switch (c->fun) {
    case EXPR_ABS:  s->choice[i] = (signed char)sign; break;
    case EXPR_SIGN: s->choice[i] = (signed char)(3 * sign); break;
    case EXPR_MIN:  s->choice[i] = (signed char)(sign < 0 ? 1 : sign > 0 ? 2 : 0); break;
    default:        s->choice[i] = (signed char)(sign > 0 ? 1 : sign < 0 ? 2 : 0); break;
    }
}

void enc_follow(arb_t r, int choice, const arb_t a, const arb_t b, bool constant)
{
    switch (choice) {
    case 1:  arb_set(r, a); break;
    case -1: arb_neg(r, a); break;
    case 2:  arb_set(r, b); break;
    case 3:  constant ? arb_one(r) : arb_zero(r); break;
    case -3: constant ? arb_set_si(r, -1) : arb_zero(r); break;
    default: arb_indeterminate(r); break;
    }
}

/* y_k = S_0^-1 (r_k - sum_{i>=1} S_i y_{k-i}) for all components. */
static void solve(struct enc_series *s, const struct enc_system *q, arb_mat_struct *inverse, slong k)
{
    int m = q->m;
    SGA_ARENA(mem);
    arb_ptr r = arbs_take(&mem, m);
    for (int i = 0; i < m; i++) {
        arb_set(r + i, enc_series_of(s, q->rhs[i]) + k);
        for (int j = 0; j < m; j++) {
            int e = q->matrix[i * m + j];
            if (k == 0)
                arb_set(arb_mat_entry(inverse, i, j), enc_series_of(s, e));
            else if (s->p->code[e].varies)
                enc_convolve(r + i, r + i, true, enc_series_of(s, e) + 1, enc_series_of(s, q->first + j), k - 1, k, s->prec);
        }
    }
    if (k == 0 && !arb_mat_inv(inverse, inverse, s->prec))
        arb_mat_indeterminate(inverse);
    for (int i = 0; i < m; i++)
        arb_dot(enc_series_of(s, q->first + i) + k, NULL, 0, inverse->rows[i], 1, r, 1, m, s->prec);
}

static void first(struct enc_series *s, int i)
{
    const struct enc_code *c = s->p->code + i;
    arb_ptr r = enc_series_of(s, i);
    if (c->op == ENC_SOLVE) {
        if (c->b == 0)
            solve(s, s->p->system + c->a, s->inverse + c->a, 0);
    } else if (c->op == ENC_CHOICE && c->varies) {
        choose(s, i);
        enc_follow(r, s->choice[i], enc_series_of(s, c->a), enc_series_of(s, c->b), true);
    } else {
        bool leaf = c->op == ENC_INTEGER || c->op == ENC_CONSTANT || c->op == ENC_PIECE;
        enc_value(r, s->p, c, leaf ? r : enc_series_of(s, c->a), enc_series_of(s, c->b), s->prec);
    }
}

static void next(struct enc_series *s, int i, slong k)
{
    const struct enc_code *c = s->p->code + i;
    arb_ptr v = enc_series_of(s, i), r = v + k, a = enc_series_of(s, c->a), b = enc_series_of(s, c->b);
    slong prec = s->prec;
    switch (c->op) {
    case ENC_ADD: arb_add(r, a + k, b + k, prec); break;
    case ENC_SUB: arb_sub(r, a + k, b + k, prec); break;
    case ENC_NEG: arb_neg(r, a + k); break;
    case ENC_MUL:
        if (!s->p->code[c->a].varies)
            arb_mul(r, a, b + k, prec);
        else if (!s->p->code[c->b].varies)
            arb_mul(r, a + k, b, prec);
        else
            enc_convolve(r, NULL, false, a, b, k, k + 1, prec);
        break;
    case ENC_DIV:
        if (s->p->code[c->b].varies) {
            enc_convolve(r, a + k, true, b + 1, v, k - 1, k, prec);
            arb_div(r, r, b, prec);
        } else {
            arb_div(r, a + k, b, prec);
        }
        break;
    case ENC_SQRT:
        enc_convolve(r, a + k, true, v + 1, v, k - 1, k - 1, prec);
        arb_div(r, r, v, prec);
        arb_mul_2exp_si(r, r, -1);
        break;
    case ENC_FUN: case ENC_ATAN2: sum_fun(s, i, k); break;
    case ENC_CHOICE: enc_follow(r, s->choice[i], a + k, b + k, false); break;
    case ENC_SOLVE:
        if (c->b == 0)
            solve(s, s->p->system + c->a, s->inverse + c->a, k);
        break;
    default: break;
    }
}

/* After coefficient k is there. */
static bool finish(struct enc_series *s, int i, slong k)
{
    arb_ptr r = enc_series_of(s, i) + k;
    if (s->p->code[i].scaled)
        arb_mul_ui(scaled_of(s, i) + k, r, (ulong)k, s->prec);
    return arb_is_finite(r) || (s->p->code[i].aux && !s->p->code[i].varies);     /* nobody asks for that one */
}

static void begin(struct enc_series *s, arb_srcptr x, const arb_t t)
{
    int n = s->p->n;
    for (int j = 0; j < n; j++)
        arb_set_round(enc_series_of(s, j), x + j, s->prec);
    arb_set_round(enc_series_of(s, n), t, s->prec);
    for (int k = 1; k <= s->order; k++)
        arb_set_si(enc_series_of(s, n) + k, k == 1);
    for (int i = 0; i < s->p->slots; i++)
        for (int k = 1; k <= s->order && !s->p->code[i].varies; k++) {
            arb_zero(enc_series_of(s, i) + k);
            arb_zero(scaled_of(s, i) + k);
        }
}

bool enc_series_run(struct enc_series *s, arb_srcptr x, const arb_t t, int order, slong prec)
{
    assert(order >= 0 && prec > 1);
    const struct enc_program *p = s->p;
    bool ok = true;
    reserve(s, order);
    s->order = order;
    s->prec = prec;
    begin(s, x, t);
    for (int k = 0; k <= order && ok; k++) {
        ok = sga_watch_ok();
        for (int i = 0; i < p->slots && ok; i++) {
            if (k > 0 && !p->code[i].varies)
                continue;
            if (p->code[i].op != ENC_INPUT && k == 0)
                first(s, i);
            else if (p->code[i].op != ENC_INPUT)
                next(s, i, k);
            ok = finish(s, i, k);
        }
        for (int j = 0; j < p->n && k < order; j++)
            arb_div_ui(enc_series_of(s, j) + k + 1, enc_series_of(s, p->root[j]) + k, (ulong)k + 1, prec);
    }
    return ok;
}

void enc_series_values(struct enc_series *s, arb_srcptr x, const arb_t t, slong prec)
{
    assert(prec > 1);
    reserve(s, 0);
    s->order = 0;
    s->prec = prec;
    begin(s, x, t);
    for (int i = 0; i < s->p->slots; i++) {
        const struct enc_code *c = s->p->code + i;
        if (c->op == ENC_CHOICE && c->varies)
            choose(s, i);
        if (c->op == ENC_CHOICE)
            enc_value(enc_series_of(s, i), s->p, c, enc_series_of(s, c->a), enc_series_of(s, c->b), prec);
        else if (c->op != ENC_INPUT)
            first(s, i);
    }
}
