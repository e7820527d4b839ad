/* Tails of the derivatives along one direction. Their rules are linear: with d for the derivative,
 *   d(a b) = a db + b da,  b dv = da - v db,  2 v dv = da,  du = g dx,  S dy = dr - dS y,
 * so that Phi is, with K(f, dg) = P(f, dg) + ([f] + tau(f)) tau(dg) + tau(f) [dg] for the tail of f dg,
 *   K(a, db) + K(b, da);   i (tau(da) + K(v, db) + P(b, dv) + tau(b) [dv]);   i / 2 (tau(da) + 2 (P(v, dv) + tau(v) [dv]));   K(g, dx);
 *   |Q| e + E tau(dy),  e_i = tau(dr_i) + sum_j (K(y_j, dS_ij) + P(S_ij, dy_j) + tau(S_ij) [dy_j]),
 * all i of series with their tails, and of variables as for values. */
#include "arb_ends.h"
#include "arena.h"
#include "tail.h"
#include "watch.h"

/* The part of K that does not depend on tails of derivatives; and the other one, added. */
static void begin_product(mag_t r, const struct enc_tail *t, int f, int dg)
{
    SGA_ENDS(mag_end) mag_t a = { 0 };
    enc_tail_overlap(a, enc_tail_dsize(t, dg), enc_tail_rest(t, f), t->order);
    mag_add(r, r, a);
    mag_addmul(r, t->tau + f, enc_tail_drest(t, dg));
}

static void end_product(mag_t r, const struct enc_tail *t, int f, int dg)
{
    mag_addmul(r, enc_tail_rest(t, f), t->dtau + dg);
    mag_addmul(r, t->tau + f, t->dtau + dg);
}

/* P(f, dg) + tau(f) [dg] twice where f dg is what is solved for. */
static void begin(struct enc_tail *t, int i)
{
    const struct enc_code *c = t->s->p->code + i;
    mag_ptr r = t->dfixed + i;
    mag_zero(r);
    switch (c->op) {
    case ENC_MUL:
        begin_product(r, t, c->a, c->b);
        begin_product(r, t, c->b, c->a);
        break;
    case ENC_DIV:
        begin_product(r, t, i, c->b);
        begin_product(r, t, c->b, i);
        break;
    case ENC_SQRT:
        begin_product(r, t, i, i);
        mag_mul_2exp_si(r, r, 1);
        break;
    case ENC_FUN: begin_product(r, t, c->g, c->a); break;
    case ENC_ATAN2:
        begin_product(r, t, c->g, c->a);
        begin_product(r, t, c->g2, c->b);
        break;
    case ENC_SOLVE: {
        const struct enc_system *q = t->s->p->system + c->a;
        for (int j = 0; j < q->m; j++) {
            begin_product(r, t, q->first + j, q->matrix[c->b * q->m + j]);
            begin_product(r, t, q->matrix[c->b * q->m + j], q->first + j);
        }
        break;
    }
    default: break;
    }
}

static void solve(mag_t r, const struct enc_tail *t, int system, int component)
{
    const struct enc_system *q = t->s->p->system + system;
    const struct enc_matrix_inverse *w = t->inverse.matrix + system;
    int m = q->m;
    SGA_ENDS(mag_end) mag_t e = { 0 };
    mag_zero(r);
    for (int i = 0; i < m; i++) {
        mag_add(e, t->dfixed + q->first + i, t->dtau + q->rhs[i]);
        for (int j = 0; j < m; j++) {
            int S = q->matrix[i * m + j];
            end_product(e, t, q->first + j, S);
            mag_addmul(e, t->tau + S, t->dtau + q->first + j);      /* the tail of S in E */
        }
        mag_addmul(r, w->norm + component * m + i, e);
        mag_addmul(r, w->error + component * m + i, t->dtau + q->first + i);
    }
}

static void phi(mag_t r, const struct enc_tail *t, int i)
{
    const struct enc_code *c = t->s->p->code + i;
    mag_srcptr a = t->dtau + c->a, b = t->dtau + c->b;
    SGA_ENDS(mag_end) mag_t u = { 0 };
    mag_set(r, t->dfixed + i);
    switch (c->op) {
    case ENC_ADD: case ENC_SUB: mag_add(r, a, b); break;
    case ENC_NEG: mag_set(r, a); break;
    case ENC_MUL:
        end_product(r, t, c->a, c->b);
        end_product(r, t, c->b, c->a);
        break;
    case ENC_DIV:
        mag_add(r, r, a);
        end_product(r, t, i, c->b);
        enc_inverse_bound(u, t->inverse.scalar + c->b, t->tau + c->b);
        enc_tail_times(r, u);
        break;
    case ENC_SQRT:
        mag_add(r, r, a);
        enc_inverse_bound(u, t->inverse.scalar + i, t->tau + i);
        enc_tail_times(r, u);
        mag_mul_2exp_si(r, r, -1);
        break;
    case ENC_FUN: end_product(r, t, c->g, c->a); break;
    case ENC_ATAN2:
        end_product(r, t, c->g, c->a);
        end_product(r, t, c->g2, c->b);
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

static void integrate(mag_t r, const struct enc_tail *t, int j)
{
    int X = t->s->p->root[j];
    SGA_ENDS(mag_end) mag_t R = { 0 };
    mag_set_d(R, t->R);
    mag_add(r, enc_tail_dsize(t, X) + t->order, t->dtau + X);
    mag_mul(r, r, R);
    mag_div_ui(r, r, (ulong)t->order + 1);
}

static bool wanted(const struct enc_code *c)
{
    return c->state && !c->aux;
}

static int sweep(struct enc_tail *t, int which)
{
    const struct enc_program *p = t->s->p;
    int grown = 0;
    SGA_ENDS(mag_end) mag_t r = { 0 };
    for (int i = p->n + 1; i < p->slots + p->n && grown >= 0; i++) {
        int slot = i < p->slots ? i : i - p->slots;
        if (!wanted(p->code + slot))
            continue;
        if (slot < p->n)
            integrate(r, t, slot);
        else
            phi(r, t, slot);
        grown = mag_is_inf(r) || (i % ENC_LOOK == 0 && !sga_watch_ok()) ? -1 : enc_tail_grow(t->dtau + slot, r, which >= ENC_PLAIN && t->loop[slot]) ? 1 : grown;
    }
    return grown;
}

bool enc_tail_along(struct enc_tail *t)
{
    const struct enc_program *p = t->s->p;
    if (!t->dsize) {
        t->dsize = _mag_vec_init((slong)p->slots * (t->room + 2));
        t->drest = _mag_vec_init((slong)p->slots * (t->room + 2));
        t->dfixed = _mag_vec_init(p->slots);
        t->dtau = _mag_vec_init(p->slots);
    }
    for (int i = 0; i < p->slots; i++)
        if (wanted(p->code + i))
            enc_tail_sizes(enc_tail_dsize(t, i), enc_tail_drest(t, i), enc_series_tangent(t->s, i), t->power, t->order);
    for (int i = 0; i < p->slots; i++)
        if (wanted(p->code + i)) {
            mag_zero(t->dtau + i);
            begin(t, i);
        }
    int state = 1;
    for (int k = 0; k < ENC_SWEEPS && state > 0 && sga_watch_ok(); k++)
        state = sweep(t, k);
    return state == 0;
}
