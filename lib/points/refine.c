/* Refinement with a double preconditioner. */
#include "refine.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "budget.h"
#include "doubling.h"
#include "lin_sparse.h"
#include "mem.h"
#include "points_space.h"
#include "search.h"
#include "square.h"
#include "triangular.h"

enum { MANY_BITS = 600, FEW_ROWS = 24 };     /* from where on, and up to where, steps that double the digits pay */
/* From so many rows on all variables move. */
enum { MANY_ROWS = 500 };
/* What differentials that become doubles are taken to first; and values at a point that is itself one of doubles. */
enum { SLOPE_BITS = 64, FIRST_BITS = 128 };
/* Of a row's length, what must be left once the rows before it are taken out: its square is a relative error of corrections of some 1e-4. */
static const double LEAST_LEFT = 1e-6;

/* Values at the present point to so many bits, and the rows' exponents. False: a value is not finite, or all of a row is what a cancellation left. */
static bool take_values(struct square *q, slong bits)
{
    struct points_jacobian *j = q->j;
    q->p->ball.prec = bits;
    points_jacobian_values(j, &q->p->ball);
    points_jacobian_entries(j, &q->p->ball);
    bool sound = true;
    for (int i = 0; i < q->c; i++) {
        slong e = -(WORD_MAX / 4);
        bool some = false;
        for (int k = 0; k < j->cols[i]; k++) {
            if (!arb_is_finite(j->entry[i] + k)) {
                sound = false;
                continue;
            }
            some |= !arb_contains_zero(j->entry[i] + k);
            if (!arf_is_zero(arb_midref(j->entry[i] + k))) {
                slong x = num_ball_log2(arb_midref(j->entry[i] + k)) + square_scale(q, j->col[i][k]);
                e = x > e ? x : e;
            }
        }
        sound &= some;
        q->exponent[i] = e;
    }
    return sound;
}

/* As many unknowns as rows. */
static bool factor(struct square *q)
{
    struct points_jacobian *j = q->j;
    bool sound = take_values(q, q->p->ball.prec);
    struct points_row *row = sga_calloc((size_t)q->c, sizeof *row);
    for (int i = 0; i < q->c; i++) {
        int len = j->cols[i];
        row[i] = (struct points_row){ sga_malloc((size_t)len * sizeof(int)), sga_malloc((size_t)len * sizeof(double)), len, len };
        for (int k = 0; k < len; k++) {
            row[i].col[k] = j->col[i][k];
            row[i].val[k] = sound ? square_scaled(arb_midref(j->entry[i] + k), q->exponent[i] - square_scale(q, j->col[i][k])) : 0;
        }
    }
    points_lu_factor(&q->lu, row, q->c, q->n, 1e-13);
    q->unknowns = q->lu.rank;
    memcpy(q->unknown, q->lu.pivot_col, (size_t)q->lu.rank * sizeof *q->unknown);
    return sound && q->lu.rank == q->c;
}

/* The values into the whole's J, which is made the first time. False: they are not finite, or it makes no stairs. */
static bool take_whole(struct square *q)
{
    struct points_whole *w = q->whole;
    if (w->none)
        return false;
    if (w->J) {
        bool finite = square_values(q, w->J);
        lin_stairs_take(&w->stairs);
        return finite;
    }
    w->J = square_sparse(q);
    w->none = w->J && !square_stairs(q, w->J, &w->stairs);
    return w->J && !w->none;
}

/* All variables that constraints contain are unknowns. */
static bool factor_whole(struct square *q)
{
    SGA_ARENA(mem);
    slong bits = q->p->ball.prec;
    unsigned char *in = sga_zeros(&mem, (size_t)q->n + 1, 1);
    for (int i = 0; i < q->c; i++)
        for (int k = 0; k < q->j->cols[i]; k++)
            in[q->j->col[i][k]] = 1;
    q->unknowns = 0;
    for (int v = 0; v < q->n; v++)
        if (in[v])
            q->unknown[q->unknowns++] = v;
    return (take_values(q, SLOPE_BITS) || take_values(q, bits)) && take_whole(q) && lin_stairs_factor(&q->whole->stairs, LEAST_LEFT);
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
    if (q->whole) {
        for (int i = 0; i < q->c; i++)
            q->b[i] = -q->b[i];
        bool finite = lin_stairs_solve(&q->whole->stairs, q->b, q->x);
        for (int i = q->unknowns - 1; i >= 0; i--) {       /* from a column each unknown has to its variable */
            double d = finite ? q->x[i] : NAN;
            q->x[i] = 0;
            q->x[q->unknown[i]] = d;
        }
    } else {
        points_lu_solve(&q->lu, q->b, q->x);
    }
    return shift;
}

static bool of_doubles(const struct square *q)
{
    for (int i = 0; i < q->unknowns; i++)
        if (arf_bits(arb_midref(q->p->ball.symbol + q->j->space->variable[q->unknown[i]])) > DBL_MANT_DIG)
            return false;
    return true;
}

/* Newton with the fixed factorization: each step gains about 40 bits (13 at least where all variables move). */
static bool iterate(struct square *q, slong prec)
{
    const struct points_space *s = q->j->space;
    struct num_ball *ball = &q->p->ball;
    arf_t d;
    arf_init(d);
    slong last = WORD_MAX;
    bool ok = false;
    for (int k = 0; k < 12 + prec / 20; k++) {
        ball->prec = k == 0 && prec + 40 > FIRST_BITS && of_doubles(q) ? FIRST_BITS : prec + 40;
        points_jacobian_values(q->j, ball);
        slong shift = correction(q), size = -(WORD_MAX / 4);
        for (int i = 0; i < q->unknowns; i++) {
            int v = q->unknown[i];
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

/* With corrections that move all variables. False: nothing is proved, and the point is what it was. */
static bool refine_whole(struct square *q, struct points_whole *whole, slong prec)
{
    const struct points_space *s = q->j->space;
    struct num_ball *ball = &q->p->ball;
    SGA_ARENA(mem);
    arb_ptr before = arbs_take(&mem, q->n);
    for (int v = 0; v < q->n; v++)
        arb_set(before + v, ball->symbol + s->variable[v]);
    q->whole = whole;
    bool ok = factor_whole(q) && iterate(q, prec) && points_prove(q, prec);
    q->whole = NULL;
    for (int v = 0; v < q->n && !ok; v++)
        arb_swap(ball->symbol + s->variable[v], before + v);
    return ok;
}

static bool refine_square(struct square *q, slong prec)
{
    bool ok = factor(q), many = prec > MANY_BITS && q->c <= FEW_ROWS;
    if (ok && many && (ok = iterate(q, MANY_BITS)))
        points_double_digits(q->j, q->p, q->lu.pivot_col, prec);
    ok = ok && iterate(q, prec);
    if (ok) {
        for (int i = 0; i < q->c; i++)
            q->p->solved[q->lu.pivot_row[i]] = q->lu.pivot_col[i];
        q->p->certified = points_prove(q, prec);
        ok = q->p->certified || still_full(q);
    }
    points_lu_clear(&q->lu);
    return ok;
}

bool points_refine_with(struct points_search *w, struct points_point *p, slong prec)
{
    struct points_jacobian *j = &w->j;
    assert(prec > 1);
    const struct points_space *s = j->space;
    p->unsolved = false;
    if (p->triangular)
        return points_triangular(s, p, prec, true);
    SGA_ARENA(mem);
    struct square q = { .scale = p->scaled ? s->scale : NULL, .j = j, .p = p, .c = s->constraints, .n = s->variables };
    q.exponent = sga_take(&mem, ((size_t)q.c + 1) * sizeof *q.exponent);
    q.b = sga_take(&mem, ((size_t)q.c + 1) * sizeof *q.b);
    q.x = sga_take(&mem, ((size_t)q.n + 1) * sizeof *q.x);
    q.unknown = sga_take(&mem, ((size_t)q.n + 1) * sizeof *q.unknown);
    for (int i = 0; i < s->variables; i++)
        mag_zero(arb_radref(p->ball.symbol + s->variable[i]));
    if (p->ball.prec < prec)
        p->ball.prec = prec;
    bool ok = q.c > MANY_ROWS && refine_whole(&q, &w->whole, prec);
    p->unsolved = ok;
    if (ok)
        p->certified = true;
    else
        ok = refine_square(&q, prec);
    for (int i = 0; i < q.n && ok; i++)
        p->x[i] = arf_get_d(arb_midref(p->ball.symbol + s->variable[i]), ARF_RND_NEAR);
    p->ball.prec = prec;
    num_ball_forget(&p->ball);
    return ok;
}
