/* Inverses of series, with as few coefficients as serve. */
#include "inverse.h"

#include <assert.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "mem.h"
#include "tail.h"
#include "watch.h"

enum { BITS = 64, REGULAR = 60 };

void enc_inverses_init(struct enc_inverses *v, const struct enc_program *p)
{
    *v = (struct enc_inverses){ .p = p, .scalar = sga_calloc((size_t)p->slots + 1, sizeof *v->scalar),
                                .matrix = sga_calloc((size_t)p->systems + 1, sizeof *v->matrix) };
    for (int i = 0; i < p->slots; i++) {
        mag_init(v->scalar[i].norm);
        mag_init(v->scalar[i].error);
    }
    for (int k = 0; k < p->systems; k++) {
        slong m = p->system[k].m;
        struct enc_matrix_inverse *w = v->matrix + k;
        w->Q = sga_calloc(ENC_INVERSE_MATRIX + 1, sizeof *w->Q);
        for (int l = 0; l <= ENC_INVERSE_MATRIX; l++)
            arb_mat_init(w->Q + l, m, m);
        w->norm = _mag_vec_init(m * m);
        w->error = _mag_vec_init(m * m);
    }
}

void enc_inverses_clear(struct enc_inverses *v)
{
    if (!v->p)
        return;
    for (int i = 0; i < v->p->slots; i++) {
        if (v->scalar[i].q)
            _arb_vec_clear(v->scalar[i].q, ENC_INVERSE_SCALAR + 1);
        mag_clear(v->scalar[i].norm);
        mag_clear(v->scalar[i].error);
    }
    for (int k = 0; k < v->p->systems; k++) {
        slong m = v->p->system[k].m;
        struct enc_matrix_inverse *w = v->matrix + k;
        for (int l = 0; l <= ENC_INVERSE_MATRIX; l++)
            arb_mat_clear(w->Q + l);
        free(w->Q);
        _mag_vec_clear(w->norm, m * m);
        _mag_vec_clear(w->error, m * m);
    }
    free(v->scalar);
    free(v->matrix);
    *v = (struct enc_inverses){ 0 };
}

void enc_inverses_forget(struct enc_inverses *v)
{
    for (int i = 0; i < v->p->slots; i++)
        v->scalar[i].known = 0;
    for (int k = 0; k < v->p->systems; k++)
        v->matrix[k].known = 0;
}

/* q_k = -q_0 sum_{i >= 1} f_i q_{k - i}. */
static void extend(struct enc_inverse *v, arb_srcptr f, int M)
{
    if (!v->q)
        v->q = _arb_vec_init(ENC_INVERSE_SCALAR + 1);
    for (int k = v->known; k <= M; k++) {
        if (k == 0) {
            arb_inv(v->q, f, BITS);
        } else {
            enc_convolve(v->q + k, NULL, true, f + 1, v->q, k - 1, k, BITS);
            arb_mul(v->q + k, v->q + k, v->q, BITS);
        }
    }
    v->known = M + 1 > v->known ? M + 1 : v->known;
}

static void measure(struct enc_inverse *v, const struct enc_tail *t, int slot, int M)
{
    mag_srcptr rest = enc_tail_rest(t, slot);
    SGA_ENDS(mag_end) mag_t a = { 0 };
    mag_zero(v->norm);
    mag_zero(v->error);
    for (int i = 0; i <= M; i++) {
        arb_get_mag(a, v->q + i);
        mag_mul(a, a, t->power + i);
        mag_add(v->norm, v->norm, a);
        mag_addmul(v->error, a, rest + (M + 1 - i));
    }
}

bool enc_inverse_find(struct enc_tail *t, int slot)
{
    assert(slot >= 0 && slot < t->s->p->slots);
    struct enc_inverse *v = t->inverse.scalar + slot;
    for (int M = 0;; M = M ? 2 * M : 3) {
        extend(v, enc_series_of(t->s, slot), M);
        measure(v, t, slot, M);
        if (mag_cmp_2exp_si(v->error, -2) <= 0)
            return true;
        if (2 * M > ENC_INVERSE_SCALAR || 2 * M > t->order || t->order < 3)
            return mag_cmp_2exp_si(v->error, 0) < 0;
    }
}

void enc_inverse_bound(mag_t r, const struct enc_inverse *v, const mag_t tau)
{
    SGA_ENDS(mag_end) mag_t e = { 0 }, one = { 0 };
    mag_set(e, v->error);
    mag_addmul(e, v->norm, tau);
    mag_one(one);
    mag_sub_lower(one, one, e);
    mag_div(r, v->norm, one);       /* infinite where one is 0 */
}

/* Q_k = -(sum_{i >= 1} Q_{k - i} S_i) Q_0. False: the time is over. */
static bool extend_matrix(struct enc_matrix_inverse *w, const struct enc_series *s, int system, int M)
{
    const struct enc_system *q = s->p->system + system;
    int m = q->m;
    bool ok = true;
    SGA_ENDS(arb_mat_end) arb_mat_t sum;
    arb_mat_init(sum, m, m);
    for (int k = w->known; k <= M && ok; k++) {
        if (k == 0) {
            arb_mat_set(w->Q, s->inverse + system);
            continue;
        }
        arb_mat_zero(sum);
        for (int j = 0; j < m && (ok = sga_watch_ok()); j++)
            for (int c = 0; c < m; c++) {
                int e = q->matrix[j * m + c];
                arb_srcptr f = enc_series_of(s, e);
                if (!s->p->code[e].varies)
                    continue;
                for (int r = 0; r < m; r++)
                    for (int i = 1; i <= k; i++)
                        arb_submul(arb_mat_entry(sum, r, c), arb_mat_entry(w->Q + (k - i), r, j), f + i, BITS);
            }
        arb_mat_mul(w->Q + k, sum, w->Q, BITS);
    }
    w->known = !ok ? 0 : M + 1 > w->known ? M + 1 : w->known;
    return ok;
}

static void measure_matrix(struct enc_matrix_inverse *w, const struct enc_tail *t, int system, int M)
{
    const struct enc_system *q = t->s->p->system + system;
    int m = q->m;
    SGA_ENDS(mag_end) mag_t a = { 0 };
    for (int k = 0; k < m * m; k++) {
        mag_zero(w->norm + k);
        mag_zero(w->error + k);
    }
    for (int r = 0; r < m; r++)
        for (int j = 0; j < m; j++)
            for (int i = 0; i <= M; i++) {
                arb_get_mag(a, arb_mat_entry(w->Q + i, r, j));
                mag_mul(a, a, t->power + i);
                mag_add(w->norm + r * m + j, w->norm + r * m + j, a);
                for (int c = 0; c < m; c++)
                    mag_addmul(w->error + r * m + c, a, enc_tail_rest(t, q->matrix[j * m + c]) + (M + 1 - i));
            }
}

/* Whether E is small: the trace of E^2 does not depend on units. A guess only. */
static bool small(const struct enc_matrix_inverse *w, int m)
{
    SGA_ENDS(mag_end) mag_t trace = { 0 };
    for (int i = 0; i < m; i++)
        for (int j = 0; j < m; j++)
            mag_addmul(trace, w->error + i * m + j, w->error + j * m + i);
    return mag_cmp_2exp_si(trace, -4) <= 0;
}

bool enc_inverse_matrix(struct enc_tail *t, int system)
{
    assert(system >= 0 && system < t->s->p->systems);
    struct enc_matrix_inverse *w = t->inverse.matrix + system;
    int m = t->s->p->system[system].m;
    for (int M = 0;; M = M ? 2 * M : 3) {
        if (!extend_matrix(w, t->s, system, M))
            return false;
        measure_matrix(w, t, system, M);
        if (small(w, m) || 2 * M > ENC_INVERSE_MATRIX || 2 * M > t->order || t->order < 3)
            break;
    }
    bool finite = true;
    for (int k = 0; k < m * m; k++)
        finite = finite && !mag_is_inf(w->norm + k) && !mag_is_inf(w->error + k);
    return finite;
}

/* e = |E| v with tails: (P + |Q| tau(S)) v. */
static void apply(mag_ptr e, const struct enc_tail *t, int system, mag_srcptr v)
{
    const struct enc_system *q = t->s->p->system + system;
    const struct enc_matrix_inverse *w = t->inverse.matrix + system;
    int m = q->m;
    SGA_ENDS(mag_end) mag_t a = { 0 };
    for (int i = 0; i < m; i++)
        mag_zero(e + i);
    for (int j = 0; j < m; j++) {
        mag_zero(a);
        for (int c = 0; c < m; c++)
            mag_addmul(a, t->tau + q->matrix[j * m + c], v + c);
        for (int i = 0; i < m; i++) {
            mag_addmul(e + i, w->norm + i * m + j, a);
            mag_addmul(e + i, w->error + i * m + j, v + j);
        }
    }
}

/* v = 1 + |E| v, from 1 on, comes to |E| v < v where it converges. */
bool enc_inverse_regular(const struct enc_tail *t, int system)
{
    int m = t->s->p->system[system].m;
    SGA_ARENA(mem);
    mag_ptr v = mags_take(&mem, m), e = mags_take(&mem, m);
    bool below = false;
    for (int i = 0; i < m; i++)
        mag_one(v + i);
    for (int k = 0; k < REGULAR && !below; k++) {
        apply(e, t, system, v);
        below = true;
        for (int i = 0; i < m; i++) {
            below = below && mag_cmp(e + i, v + i) < 0;
            mag_add_ui(e + i, e + i, 1);
        }
        if (!below) {
            mag_ptr other = v;
            v = e;
            e = other;
        }
    }
    return below;
}
