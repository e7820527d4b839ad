/* Tails of the values: the theorem of tail.h, sweep by sweep. */
#include "tail.h"

#include <stdlib.h>

#include "mem.h"

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
    _mag_vec_clear(t->dsize, all);
    _mag_vec_clear(t->drest, all);
    _mag_vec_clear(t->dfixed, slots);
    _mag_vec_clear(t->dtau, slots);
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
    t->dsize = _mag_vec_init(all);
    t->drest = _mag_vec_init(all);
    t->dfixed = _mag_vec_init(slots);
    t->dtau = _mag_vec_init(slots);
}

void enc_tail_begin(struct enc_tail *t, const struct enc_series *s)
{
    t->s = s;
    t->order = s->order;
    reserve(t, s->order);
    enc_inverses_forget(&t->inverse);
}

void enc_tail_overlap(mag_t r, mag_srcptr size, mag_srcptr rest, int last)
{
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
            mag_t a;
            mag_init(a);
            mag_mul_ui(a, enc_tail_size(t, i) + k, (ulong)k);
            mag_add(t->moment + i, t->moment + i, a);
            mag_clear(a);
        }
    }
}

/* sum_{1 <= i <= N} i |x_i| R^i sum_{N - i < l <= N} |g_l| R^l */
static void weighted(mag_t r, const struct enc_tail *t, int x, int g)
{
    mag_srcptr size = enc_tail_size(t, x), rest = enc_tail_rest(t, g);
    mag_t a;
    mag_init(a);
    for (int i = 1; i <= t->order; i++) {
        mag_mul_ui(a, size + i, (ulong)i);
        mag_addmul(r, a, rest + (t->order + 1 - i));
    }
    mag_clear(a);
}

/* What does not depend on tau, and inverses. */
static bool prepare(struct enc_tail *t, int i)
{
    const struct enc_code *c = t->s->p->code + i;
    mag_ptr r = t->fixed + i;
    mag_zero(r);
    switch (c->op) {
    case ENC_MUL: enc_tail_overlap(r, enc_tail_size(t, c->a), enc_tail_rest(t, c->b), t->order); break;
    case ENC_DIV:
        enc_tail_overlap(r, enc_tail_size(t, c->b), enc_tail_rest(t, i), t->order);
        return enc_inverse_find(t, c->b);
    case ENC_SQRT:
        enc_tail_overlap(r, enc_tail_size(t, i), enc_tail_rest(t, i), t->order);
        return enc_inverse_find(t, i);
    case ENC_FUN: weighted(r, t, c->a, c->g); break;
    case ENC_ATAN2:
        weighted(r, t, c->a, c->g);
        weighted(r, t, c->b, c->g2);
        break;
    case ENC_SOLVE: {
        const struct enc_system *q = t->s->p->system + c->a;
        mag_t a;
        mag_init(a);
        for (int j = 0; j < q->m; j++) {
            enc_tail_overlap(a, enc_tail_size(t, q->matrix[c->b * q->m + j]), enc_tail_rest(t, q->first + j), t->order);
            mag_add(r, r, a);
        }
        mag_clear(a);
        return c->b > 0 || enc_inverse_matrix(t, c->a);
    }
    default: break;
    }
    return true;
}

/* What depends on tau for u' = g x': tau(x) ([g] + tau(g)) + moment(x) tau(g) / (N + 1), and its fixed part, not yet divided, from the caller. */
static void integral(mag_t r, const struct enc_tail *t, int x, int g)
{
    mag_t a;
    mag_init(a);
    mag_mul(a, t->moment + x, t->tau + g);
    mag_div_ui(a, a, (ulong)t->order + 1);
    mag_add(r, r, a);
    mag_add(a, enc_tail_rest(t, g), t->tau + g);
    mag_addmul(r, a, t->tau + x);
    mag_clear(a);
}

/* e_i of row i, then component c = sum |Q_ci| e_i + E_ci tau(y_i). */
static void solve(mag_t r, const struct enc_tail *t, int system, int component)
{
    const struct enc_system *q = t->s->p->system + system;
    const struct enc_matrix_inverse *w = t->inverse.matrix + system;
    int m = q->m;
    mag_t e, E;
    mag_init(e);
    mag_init(E);
    mag_zero(r);
    for (int i = 0; i < m; i++) {
        mag_add(e, t->fixed + q->first + i, t->tau + q->rhs[i]);
        for (int j = 0; j < m; j++) {
            mag_srcptr tau = t->tau + q->matrix[i * m + j];
            mag_addmul(e, tau, enc_tail_rest(t, q->first + j));
            mag_mul(E, tau, t->tau + q->first + j);     /* the tail of S in E = 1 - Q S */
            mag_add(e, e, E);
        }
        mag_addmul(r, w->norm + component * m + i, e);
        mag_addmul(r, w->error + component * m + i, t->tau + q->first + i);
    }
    mag_clear(e);
    mag_clear(E);
}

static void phi(mag_t r, const struct enc_tail *t, int i)
{
    const struct enc_code *c = t->s->p->code + i;
    mag_srcptr a = t->tau + c->a, b = t->tau + c->b;
    mag_t u;
    mag_init(u);
    mag_zero(r);
    switch (c->op) {
    case ENC_ADD: case ENC_SUB: mag_add(r, a, b); break;
    case ENC_NEG: mag_set(r, a); break;
    case ENC_MUL:
        mag_set(r, t->fixed + i);
        mag_addmul(r, a, enc_tail_rest(t, c->b));
        mag_addmul(r, b, enc_tail_rest(t, c->a));
        mag_addmul(r, a, b);
        break;
    case ENC_DIV:
        mag_add(r, t->fixed + i, a);
        mag_addmul(r, b, enc_tail_rest(t, i));
        enc_inverse_bound(u, t->inverse.scalar + c->b, b);
        mag_mul(r, r, u);
        break;
    case ENC_SQRT:
        mag_add(r, t->fixed + i, a);
        mag_addmul(r, t->tau + i, t->tau + i);
        enc_inverse_bound(u, t->inverse.scalar + i, u);     /* u: 0 */
        mag_mul(r, r, u);
        mag_mul_2exp_si(r, r, -1);
        break;
    case ENC_FUN: case ENC_ATAN2:
        mag_div_ui(r, t->fixed + i, (ulong)t->order + 1);
        integral(r, t, c->a, c->g);
        if (c->op == ENC_ATAN2)
            integral(r, t, c->b, c->g2);
        break;
    case ENC_CHOICE: {
        int took = t->s->choice[i];
        if (took == 2)
            mag_set(r, b);
        else if (took == 1 || took == -1)
            mag_set(r, a);
        break;
    }
    case ENC_SOLVE: solve(r, t, c->a, c->b); break;
    default: break;
    }
    mag_clear(u);
}

/* R / (N + 1) (|X_N| R^N + tau(X)) */
static void integrate(mag_t r, const struct enc_tail *t, int j)
{
    int X = t->s->p->root[j];
    mag_t R;
    mag_init(R);
    mag_set_d(R, t->R);
    mag_add(r, enc_tail_size(t, X) + t->order, t->tau + X);
    mag_mul(r, r, R);
    mag_div_ui(r, r, (ulong)t->order + 1);
    mag_clear(R);
}

/* One pass. 0: tau did what the theorem asks; 1: it has grown; -1: it is infinite. */
static int sweep(struct enc_tail *t, int which)
{
    const struct enc_program *p = t->s->p;
    int grown = 0;
    mag_t r;
    mag_init(r);
    for (int i = p->n + 1; i < p->slots + p->n && grown >= 0; i++) {
        int slot = i < p->slots ? i : i - p->slots;      /* variables last */
        if (slot >= p->n && !p->code[slot].varies)
            continue;
        if (slot < p->n)
            integrate(r, t, slot);
        else
            phi(r, t, slot);
        grown = mag_is_inf(r) ? -1 : enc_tail_grow(t->tau + slot, r, which >= ENC_PLAIN && t->loop[slot]) ? 1 : grown;
    }
    mag_clear(r);
    return grown;
}

/* A root must not come to 0: |tau / v| < 1. Denominators do not, as they have inverses. Matrices must stay regular. */
static bool stands(const struct enc_tail *t)
{
    const struct enc_program *p = t->s->p;
    mag_t u, none;
    mag_init(u);
    mag_init(none);
    bool ok = true;
    for (int i = 0; i < p->slots && ok; i++)
        if (p->code[i].op == ENC_SQRT && p->code[i].varies) {
            enc_inverse_bound(u, t->inverse.scalar + i, none);
            mag_mul(u, u, t->tau + i);
            ok = mag_cmp_2exp_si(u, 0) < 0;
        }
    for (int k = 0; k < p->systems && ok; k++)
        ok = enc_inverse_regular(t, k);
    mag_clear(u);
    mag_clear(none);
    return ok;
}

bool enc_tail_find(struct enc_tail *t, double R)
{
    const struct enc_program *p = t->s->p;
    t->R = R;
    all_sizes(t);
    for (int i = 0; i < p->slots; i++) {
        mag_zero(t->tau + i);
        if (p->code[i].varies && p->code[i].op != ENC_INPUT && !prepare(t, i))
            return false;
    }
    int state = 1;
    for (int k = 0; k < ENC_SWEEPS && state > 0; k++)
        state = sweep(t, k);
    return state == 0 && stands(t);
}

void enc_tail_shrink(mag_t r, const struct enc_tail *t, const arb_t s)
{
    mag_t R;
    mag_init(R);
    arb_get_mag(r, s);
    mag_set_d_lower(R, t->R);
    mag_div(r, r, R);
    if (mag_cmp_2exp_si(r, 0) > 0)
        mag_one(r);
    mag_pow_ui(r, r, (ulong)t->order + 1);
    mag_clear(R);
}
