/* Interval Newton for the consistent start. */
#include "enclose.h"

#include <assert.h>
#include <stdlib.h>

#include "arb_ends.h"
#include "arena.h"
#include "budget.h"
#include "mem.h"
#include "series.h"

enum { NEWTON_STEPS = 60, WIDENINGS = 8 };

struct newton {
    struct enc_series s;
    int c, *column;              /* unknowns: their variables */
    arb_ptr f;                   /* c */
    arb_mat_t J, C;              /* c x c; C: about J^-1, exact numbers */
    slong prec;
};

/* f and J in the unknowns at x. */
static bool values(struct newton *w, arb_srcptr x, const arb_t t)
{
    const struct enc_program *p = w->s.p;
    bool ok = true;
    enc_series_values(&w->s, x, t, w->prec);
    for (int i = 0; i < w->c; i++) {
        arb_set(w->f + i, enc_series_of(&w->s, p->root[i]));
        ok &= arb_is_finite(w->f + i);
    }
    for (int j = 0; j < w->c && ok; j++) {
        ok = enc_series_slope(&w->s, w->column[j]);
        for (int i = 0; i < w->c; i++)
            arb_set(arb_mat_entry(w->J, i, j), enc_series_tangent(&w->s, p->root[i]));
    }
    return ok;
}

/* d = C f at exact x; the midpoints move by it. Returns log2 of the largest |d_j|, WORD_MAX where it fails. */
static slong newton_step(struct newton *w, arb_ptr x, const arb_t t)
{
    slong size = WORD_MIN;
    if (!values(w, x, t) || !arb_mat_approx_inv(w->C, w->J, w->prec))
        return WORD_MAX;
    SGA_ENDS(arb_end) arb_t d = { 0 };
    for (int i = 0; i < w->c; i++) {
        arb_ptr u = x + w->column[i];
        arb_dot(d, NULL, 0, w->C->rows[i], 1, w->f, 1, w->c, w->prec);
        if (!arb_is_finite(d))
            size = WORD_MAX;
        else if (!arf_is_zero(arb_midref(d)) && size < arf_abs_bound_lt_2exp_si(arb_midref(d)))
            size = arf_abs_bound_lt_2exp_si(arb_midref(d));
        arb_sub(u, u, d, w->prec);
        mag_zero(arb_radref(u));
    }
    return size;
}

/* |K - x| of K = x - C f(x) + (I - C J(X)) (X - x), X: x with radii, shift = C f(x): into reach. False: no value. */
static bool reaches(struct newton *w, arb_ptr x, const arb_t t, arb_srcptr radius, arb_srcptr shift, arb_mat_t E, mag_ptr reach)
{
    int c = w->c;
    for (int i = 0; i < c; i++)
        mag_set(arb_radref(x + w->column[i]), arb_radref(radius + i));
    if (!values(w, x, t))
        return false;
    arb_mat_mul(E, w->C, w->J, w->prec);
    SGA_ENDS(arb_end) arb_t k = { 0 };
    for (int i = 0; i < c; i++) {
        arb_sub_ui(arb_mat_entry(E, i, i), arb_mat_entry(E, i, i), 1, w->prec);
        arb_dot(k, NULL, 0, E->rows[i], 1, radius, 1, c, w->prec);
        arb_sub(k, k, shift + i, w->prec);
        arb_get_mag(reach + i, k);
    }
    return true;
}

/* K inside X proves one zero in X for each choice of the others. Where X is too flat for it (an unknown that is 0 beside others
 * that are not), it is widened to twice K: epsilon-inflation (Rump, Verification methods, Acta Numerica 2010). */
static bool proves(struct newton *w, arb_ptr x, const arb_t t)
{
    int c = w->c;
    arb_ptr radius = _arb_vec_init(c), shift = _arb_vec_init(c);
    SGA_ARENA(mem);
    mag_ptr reach = mags_take(&mem, c);
    SGA_ENDS(arb_mat_end) arb_mat_t E;
    arb_mat_init(E, c, c);
    bool ok = values(w, x, t) && arb_mat_approx_inv(w->C, w->J, w->prec), inside = false;
    for (int i = 0; i < c && ok; i++) {
        arb_dot(shift + i, NULL, 0, w->C->rows[i], 1, w->f, 1, c, w->prec);
        arb_get_mag(arb_radref(radius + i), shift + i);
        mag_mul_2exp_si(arb_radref(radius + i), arb_radref(radius + i), 1);
        SGA_ENDS(mag_end) mag_t least = { 0 };            /* not flat */
        arb_get_mag(least, x + w->column[i]);
        mag_mul_2exp_si(least, least, 8 - w->prec);
        mag_add(arb_radref(radius + i), arb_radref(radius + i), least);
        mag_add_ui_2exp_si(arb_radref(radius + i), arb_radref(radius + i), 1, -2 * w->prec);
    }
    for (int turn = 0; turn < WIDENINGS && ok && !inside; turn++) {
        ok = reaches(w, x, t, radius, shift, E, reach);
        inside = ok;
        for (int i = 0; i < c && ok; i++) {
            inside &= mag_cmp(reach + i, arb_radref(radius + i)) < 0;
            mag_mul_2exp_si(reach + i, reach + i, 1);
            ok = mag_is_finite(reach + i);
        }
        for (int i = 0; i < c && ok && !inside; i++)
            mag_max(arb_radref(radius + i), arb_radref(radius + i), reach + i);
    }
    _arb_vec_clear(radius, c);
    _arb_vec_clear(shift, c);
    return ok && inside;
}

bool enclose_zero(const struct enclose_problem *q, const expr_id *function, int functions, const arb_t t,
                  const unsigned char *solved, slong prec, arb_ptr x, struct sga_error *err)
{
    assert(functions <= q->n && prec > 1);
    SGA_ENDS(enc_program_clear) struct enc_program p;
    struct newton w = { .prec = prec + 20 };
    bool ok = enc_program_init(&p, &(struct enc_of){ q->st, q->variable, q->n, q->time, q->tables }, function, functions, err);
    if (ok) {
        w.column = sga_malloc((size_t)(q->n + 1) * sizeof *w.column);
        for (int j = 0; j < q->n; j++)
            if (solved[j])
                w.column[w.c++] = j;
        ok = w.c == functions;
        enc_series_init(&w.s, &p);
        w.f = _arb_vec_init(w.c);
        arb_mat_init(w.J, w.c, w.c);
        arb_mat_init(w.C, w.c, w.c);
        for (int i = 0; i < w.c; i++)
            mag_zero(arb_radref(x + w.column[i]));
        slong last = WORD_MAX, size = 0;
        for (int k = 0; k < NEWTON_STEPS && ok; k++) {
            size = newton_step(&w, x, t);
            ok = size != WORD_MAX && sga_budget_ok(q->budget, err);
            if (size < -prec / 2 && size >= last)
                break;           /* at rounding level */
            last = size;
        }
        ok = ok && proves(&w, x, t);
        ok = sga_budget_ok(q->budget, err) && ok;        /* what failed may have been stopped */
        arb_mat_clear(w.J);
        arb_mat_clear(w.C);
        _arb_vec_clear(w.f, w.c);
        enc_series_clear(&w.s);
        free(w.column);
    }
    return ok;
}
