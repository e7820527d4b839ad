/* Refinement with a double preconditioner, and the proof. */
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
#include "mem.h"
#include "sparse.h"
#include "triangular.h"
#include "warnings.h"

enum { MANY_BITS = 600, FEW_ROWS = 24 };     /* from where on, and up to where, steps that double the digits pay */

/* Everything about one square subsystem: rows scaled by 2^-exponent. */
struct square {
    struct points_jacobian *j;
    struct points_point *p;
    slong *exponent;           /* by constraint */
    const int *scale;          /* by variable, or NULL: unknowns are x / 2^scale */
    struct points_lu lu;
    int c, n;
    double *b, *x;             /* work: rows, columns */
};

static slong scale_of(const struct square *q, int variable)
{
    return q->scale ? q->scale[variable] : 0;
}

static double scaled(const arf_t v, slong exponent)
{
    SGA_ENDS(arf_end) arf_t t = { 0 };
    arf_mul_2exp_si(t, v, -exponent);
    return arf_get_d(t, ARF_RND_NEAR);
}

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
                slong x = num_ball_log2(arb_midref(j->entry[i] + k)) + scale_of(q, j->col[i][k]);
                e = x > e ? x : e;
            }
        }
        finite &= some;
        q->exponent[i] = e;
        for (int k = 0; k < len; k++) {
            row[i].col[k] = j->col[i][k];
            row[i].val[k] = finite ? scaled(arb_midref(j->entry[i] + k), e - scale_of(q, j->col[i][k])) : 0;
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
        q->b[i] = scaled(arb_midref(num_ball_value(&q->p->ball, q->j->space->constraint[i])), q->exponent[i] + shift);
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
            arf_mul_2exp_si(d, d, scale_of(q, v));
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

/* Upper bound of |v| * 2^-exponent as a double. */
static double bound(const arb_t v, slong exponent)
{
    SGA_ENDS(mag_end) mag_t m = { 0 };
    arb_get_mag(m, v);
    mag_mul_2exp_si(m, m, -exponent);
    return mag_get_d(m);
}

static double radius(const arb_t v, slong exponent)
{
    SGA_ENDS(mag_end) mag_t m = { 0 };
    mag_mul_2exp_si(m, arb_radref(v), -exponent);
    return mag_get_d(m);
}

/* The entries of J(X) in the solved columns, as doubles with bounds. */
struct entry {
    int at;
    double mid, radius;
};

/* What a sum of so many products in double may be off by, relative to the sum of their sizes and 1. */
static double rounding(int terms)
{
    return (terms + 3) * DBL_EPSILON;
}

/* m + |I - C J(X)| rho < rho, row by row. */
static bool contracts(struct square *q, const double *C, const double *m, const double *rho, const int *place)
{
    int c = q->c, total = 0;
    for (int k = 0; k < c; k++)
        total += q->j->cols[k];
    SGA_ARENA(mem);
    struct entry *entry = sga_take(&mem, (size_t)(total + 1) * sizeof *entry);
    int *start = sga_take(&mem, (size_t)(c + 1) * sizeof *start), *terms = sga_zeros(&mem, (size_t)c + 1, sizeof *terms);
    total = 0;
    for (int k = 0; k < c; k++) {
        start[k] = total;
        for (int l = 0; l < q->j->cols[k]; l++) {
            int at = place[q->j->col[k][l]];
            if (at >= 0)
                terms[at]++;
            if (at >= 0)
                entry[total++] = (struct entry){ at, scaled(arb_midref(q->j->entry[k] + l), q->exponent[k] - scale_of(q, q->j->col[k][l])),
                                                 radius(q->j->entry[k] + l, q->exponent[k] - scale_of(q, q->j->col[k][l])) };
        }
    }
    start[c] = total;
    double *E = sga_take(&mem, (size_t)(c + 1) * sizeof *E), *slack = sga_take(&mem, (size_t)(c + 1) * sizeof *slack);
    bool ok = true;
    for (int i = 0; i < c && ok; i++) {
        memset(E, 0, (size_t)c * sizeof *E);
        memset(slack, 0, (size_t)c * sizeof *slack);
        E[i] = 1;
        for (int k = 0; k < c; k++) {
            double f = C[(size_t)i * (size_t)c + (size_t)k];
            if (f == 0)
                continue;
            for (int l = start[k]; l < start[k + 1]; l++) {
                E[entry[l].at] -= f * entry[l].mid;
                slack[entry[l].at] += fabs(f) * (entry[l].radius + rounding(terms[entry[l].at]) * fabs(entry[l].mid));
            }
        }
        double sum = m[i];
        for (int k = 0; k < c; k++)
            sum += (fabs(E[k]) + slack[k] + rounding(terms[k])) * rho[k];
        ok = sum * (1 + 1e-9) < rho[i] && (i % 16 || sga_budget_ok(q->j->space->budget, NULL));
    }
    return ok;
}

/* Krawczyk: with C about J^-1, m = |C xi(x)| and E = |I - C J(X)|, the box x +- rho holds
 * exactly one zero if m + E rho < rho. Sums in double are widened by factors that cover
 * their rounding (at most a few thousand terms each). */
static bool krawczyk(struct square *q, slong prec)
{
    const struct points_space *s = q->j->space;
    struct num_ball *ball = &q->p->ball;
    int c = q->c;
    if (c > SGA_MOST_PROOF_ROWS) {
        sga_limit_met(q->j->space->budget, SGA_LIMIT_PROOF_ROWS);
        return false;
    }
    size_t cc = (size_t)c * (size_t)c;
    SGA_ARENA(mem);
    SGA_FREED double *C = sga_calloc(cc, sizeof *C);
    double *m = sga_zeros(&mem, (size_t)c, sizeof *m), *rho = sga_zeros(&mem, (size_t)c, sizeof *rho);
    int *place = sga_take(&mem, (size_t)q->n * sizeof *place);
    bool ok = true;
    for (int v = 0; v < q->n; v++)
        place[v] = -1;
    for (int i = 0; i < c; i++)
        place[q->lu.pivot_col[i]] = i;
    for (int k = 0; k < c && ok; k++) {       /* column k of C = J_B^-1, rows in pivot order */
        memset(q->b, 0, (size_t)c * sizeof *q->b);
        memset(q->x, 0, (size_t)q->n * sizeof *q->x);
        q->b[k] = 1;
        points_lu_solve(&q->lu, q->b, q->x);
        for (int i = 0; i < c; i++)
            C[(size_t)i * (size_t)c + (size_t)k] = q->x[q->lu.pivot_col[i]];
        ok = k % 16 || sga_budget_ok(s->budget, NULL);
    }
    ball->prec = prec + 40;
    points_jacobian_values(q->j, ball);
    slong unit = -prec;      /* radii are counted in units of 2^unit */
    for (int k = 0; k < c; k++) {
        double r = bound(num_ball_value(ball, s->constraint[k]), q->exponent[k] + unit);
        for (int i = 0; i < c; i++)
            m[i] += fabs(C[(size_t)i * (size_t)c + (size_t)k]) * r;
    }
    for (int i = 0; i < c; i++) {
        rho[i] = 2 * m[i] * (1 + 1e-9) + 1e-3;
        ok &= isfinite(rho[i]) != 0;
    }
    for (int i = 0; i < c && ok; i++) {
        arb_ptr sym = ball->symbol + s->variable[q->lu.pivot_col[i]];
        mag_set_d(arb_radref(sym), rho[i]);
        mag_mul_2exp_si(arb_radref(sym), arb_radref(sym), unit + scale_of(q, q->lu.pivot_col[i]));
    }
    if (ok) {
        points_jacobian_values(q->j, ball);
        points_jacobian_entries(q->j, ball);
    }
    ok = ok && contracts(q, C, m, rho, place);
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
        return points_triangular(s, p, prec);
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
        p->certified = krawczyk(&q, prec);
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
