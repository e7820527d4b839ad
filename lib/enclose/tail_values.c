/* Phi of the values, slot by slot: the rules of tail.h. */
#include <assert.h>

#include "arb_ends.h"
#include "arena.h"
#include "tail.h"

/* sum_{1 <= i <= N} i |x_i| R^i sum_{N - i < l <= N} |g_l| R^l */
static void weighted(mag_t r, const struct enc_tail *t, int x, int g)
{
    mag_srcptr size = enc_tail_size(t, x), rest = enc_tail_rest(t, g);
    SGA_ENDS(mag_end) mag_t a = { 0 };
    for (int i = 1; i <= t->order; i++) {
        mag_mul_ui(a, size + i, (ulong)i);
        mag_addmul(r, a, rest + (t->order + 1 - i));
    }
}

/* What does not depend on tau, and inverses. */
bool enc_tail_prepare(struct enc_tail *t, int i)
{
    assert(i >= 0 && i < t->s->p->slots);
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
    SGA_ENDS(mag_end) mag_t a = { 0 };
    mag_mul(a, t->moment + x, t->tau + g);
    mag_div_ui(a, a, (ulong)t->order + 1);
    mag_add(r, r, a);
    mag_add(a, enc_tail_rest(t, g), t->tau + g);
    mag_addmul(r, a, t->tau + x);
}

/* e_i of row i, then component c = sum |Q_ci| e_i + E_ci tau(y_i). */
static void solve(mag_t r, const struct enc_tail *t, int system, int component)
{
    const struct enc_system *q = t->s->p->system + system;
    const struct enc_matrix_inverse *w = t->inverse.matrix + system;
    int m = q->m;
    SGA_ENDS(mag_end) mag_t e = { 0 }, E = { 0 };
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
}

/* R / (N + 1) (|X_N| R^N + tau(X)) */
static void integrate(mag_t r, const struct enc_tail *t, int j)
{
    int X = t->s->p->root[j];
    SGA_ENDS(mag_end) mag_t R = { 0 };
    mag_set_d(R, t->R);
    mag_add(r, enc_tail_size(t, X) + t->order, t->tau + X);
    mag_mul(r, r, R);
    mag_div_ui(r, r, (ulong)t->order + 1);
}

void enc_tail_phi(mag_t r, const struct enc_tail *t, int i)
{
    if (i < t->s->p->n) {
        integrate(r, t, i);
        return;
    }
    const struct enc_code *c = t->s->p->code + i;
    mag_srcptr a = t->tau + c->a, b = t->tau + c->b;
    SGA_ENDS(mag_end) mag_t u = { 0 };
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
        enc_tail_times(r, u);
        break;
    case ENC_SQRT:
        mag_add(r, t->fixed + i, a);
        mag_addmul(r, t->tau + i, t->tau + i);
        enc_inverse_bound(u, t->inverse.scalar + i, u);     /* u: 0 */
        enc_tail_times(r, u);
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
}
