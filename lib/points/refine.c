/* Refinement with a double preconditioner. */
#include "refine.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "budget.h"
#include "doubling.h"
#include "mem.h"
#include "points_space.h"
#include "square.h"
#include "triangular.h"

enum { MANY_BITS = 600, FEW_ROWS = 24 };     /* from where on, and up to where, steps that double the digits pay */

static bool factor(struct square *q)
{
    struct points_jacobian *j = q->j;
    points_jacobian_values(j, &q->p->ball);
    points_jacobian_entries(j, &q->p->ball);
    struct points_row *row = sga_calloc((size_t)q->c, sizeof *row);
    bool finite = true;
    for (int i = 0; i < q->c; i++) {
        int len = j->cols[i];
        row[i].len = row[i].cap = len;
        row[i].col = sga_malloc((size_t)len * sizeof(int));
        row[i].val = sga_malloc((size_t)len * sizeof(double));
        slong e = -(WORD_MAX / 4);
        bool some = false;        /* not only what is left of a cancellation */
        for (int k = 0; k < len; k++) {
            if (!arb_is_finite(j->entry[i] + k)) {
                finite = false;
                continue;
            }
            some |= !arb_contains_zero(j->entry[i] + k);
            if (!arf_is_zero(arb_midref(j->entry[i] + k))) {
                slong x = num_ball_log2(arb_midref(j->entry[i] + k)) + square_scale(q, j->col[i][k]);
                e = x > e ? x : e;
            }
        }
        finite &= some;
        q->exponent[i] = e;
        for (int k = 0; k < len; k++) {
            row[i].col[k] = j->col[i][k];
            row[i].val[k] = finite ? square_scaled(arb_midref(j->entry[i] + k), e - square_scale(q, j->col[i][k])) : 0;
        }
    }
    points_lu_factor(&q->lu, row, q->c, q->n, 1e-13);
    return finite && q->lu.rank == q->c;
}

/* Solve for a right-hand side given by the constraints' values at the present point;
 * the correction of variable x[...] is -2^shift times the returned numbers. */
static slong correction(struct square *q)
{
    slong shift = -(WORD_MAX / 4);
    for (int i = 0; i < q->c; i++) {
        arb_srcptr v = num_ball_value(&q->p->ball, q->j->space->constraint[i]);
        if (arf_is_zero(arb_midref(v)) || !arb_is_finite(v))
            continue;
        slong e = num_ball_log2(arb_midref(v)) - q->exponent[i];
        shift = e > shift ? e : shift;
    }
    for (int i = 0; i < q->c; i++)
        q->b[i] = square_scaled(arb_midref(num_ball_value(&q->p->ball, q->j->space->constraint[i])), q->exponent[i] + shift);
    memset(q->x, 0, (size_t)q->n * sizeof *q->x);
    points_lu_solve(&q->lu, q->b, q->x);
    return shift;
}

/* Newton with the fixed factorization: each step gains about 40 bits. */
static bool iterate(struct square *q, slong prec)
{
    const struct points_space *s = q->j->space;
    struct num_ball *ball = &q->p->ball;
    arf_t d;
    arf_init(d);
    slong last = WORD_MAX;
    bool ok = false;
    for (int k = 0; k < 12 + prec / 20; k++) {
        ball->prec = prec + 40;
        points_jacobian_values(q->j, ball);
        slong shift = correction(q), size = -(WORD_MAX / 4);
        for (int i = 0; i < q->c; i++) {
            int v = q->lu.pivot_col[i];
            if (!isfinite(q->x[v]))
                goto out;
            arf_set_d(d, q->x[v]);
            if (arf_is_zero(d))
                continue;
            arf_mul_2exp_si(d, d, shift);
            slong e = num_ball_log2(d);       /* of the scaled unknown */
            arf_mul_2exp_si(d, d, square_scale(q, v));
            size = e > size ? e : size;
            arb_ptr sym = ball->symbol + s->variable[v];
            arf_sub(arb_midref(sym), arb_midref(sym), d, prec + 40, ARF_RND_NEAR);
            mag_zero(arb_radref(sym));
        }
        if (size < -prec - 10 || (k > 3 && size >= last)) {
            ok = size < -prec / 2 || size < -prec + 60;
            break;
        }
        last = size;
    }
out:
    arf_clear(d);
    return ok;
}

/* Differentials that are dependent on the set itself look independent a little beside it: where nothing
 * is proved, the rank is asked once more at the refined point. */
static bool still_full(struct square *q)
{
    SGA_ARENA(mem);
    mag_ptr radius = mags_take(&mem, q->n);
    for (int v = 0; v < q->n; v++) {
        mag_ptr r = arb_radref(q->p->ball.symbol + q->j->space->variable[v]);
        mag_set(radius + v, r);
        mag_zero(r);
    }
    points_lu_clear(&q->lu);
    bool full = factor(q);
    for (int v = 0; v < q->n; v++)       /* what the point is known to, as far as it is known: no theorem, but residuals are to be seen so */
        mag_swap(radius + v, arb_radref(q->p->ball.symbol + q->j->space->variable[v]));
    return full;
}

bool points_refine_with(struct points_jacobian *j, struct points_point *p, slong prec)
{
    assert(prec > 1);
    const struct points_space *s = j->space;
    if (p->triangular)
        return points_triangular(s, p, prec, true);
    struct square q = { .scale = p->scaled ? s->scale : NULL, .j = j, .p = p, .c = s->constraints, .n = s->variables };
    q.exponent = sga_malloc((size_t)q.c * sizeof *q.exponent);
    q.b = sga_malloc((size_t)q.c * sizeof *q.b);
    q.x = sga_malloc((size_t)q.n * sizeof *q.x);
    for (int i = 0; i < s->variables; i++)
        mag_zero(arb_radref(p->ball.symbol + s->variable[i]));
    if (p->ball.prec < prec)
        p->ball.prec = prec;
    bool ok = factor(&q), many = prec > MANY_BITS && q.c <= FEW_ROWS;
    if (ok && many && (ok = iterate(&q, MANY_BITS)))
        points_double_digits(j, p, q.lu.pivot_col, prec);
    ok = ok && iterate(&q, prec);
    if (ok) {
        for (int i = 0; i < q.c; i++)
            p->solved[q.lu.pivot_row[i]] = q.lu.pivot_col[i];
        p->certified = points_prove(&q, prec);
        ok = p->certified || still_full(&q);
    }
    if (ok) {
        for (int i = 0; i < q.n; i++)
            p->x[i] = arf_get_d(arb_midref(p->ball.symbol + s->variable[i]), ARF_RND_NEAR);
    }
    p->ball.prec = prec;
    num_ball_forget(&p->ball);
    points_lu_clear(&q.lu);
    free(q.exponent);
    free(q.b);
    free(q.x);
    return ok;
}
