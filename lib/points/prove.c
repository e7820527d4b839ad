/* Proofs that a point of the set lies near an approximate one. */
#include "differentials.h"
#include "points_space.h"
#include "search.h"
#include "square.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "larger.h"
#include "least_singular.h"
#include "lin_sparse.h"
#include "mem.h"
#include "points.h"
#include "warnings.h"

enum { DENSE_ROWS = 200 };     /* up to here the inverse costs less than a millisecond, and its radii are narrower */
enum { MOST_GROUPS = 8 };      /* of generations: where there are more, several make one */
enum { SPREAD_BITS = 64 };     /* for how far differentials are from numbers that are rounded to 53 */
enum { MOST_WITHIN = 32 };     /* log2 of the radius, in units of the precision, of the ball that differentials are taken in first: little beside 2^-53 */

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
                entry[total++] = (struct entry){ at, square_scaled(arb_midref(q->j->entry[k] + l), q->exponent[k] - square_scale(q, q->j->col[k][l])),
                                                 radius(q->j->entry[k] + l, q->exponent[k] - square_scale(q, q->j->col[k][l])) };
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

/* By variable: which unknown it is, or -1. */
static int *places(const struct square *q, struct sga_arena *mem)
{
    int *place = sga_take(mem, ((size_t)q->n + 1) * sizeof *place);
    memset(place, -1, ((size_t)q->n + 1) * sizeof *place);
    for (int i = 0; i < q->unknowns; i++)
        place[q->unknown[i]] = i;
    return place;
}

/* Krawczyk: with C about J^-1, m = |C xi(x)| and E = |I - C J(X)|, the box x +- rho holds
 * exactly one zero if m + E rho < rho. Sums in double are widened by factors that cover
 * their rounding (at most a few thousand terms each). */
static bool by_inverse(struct square *q, slong prec)
{
    const struct points_space *s = q->j->space;
    struct num_ball *ball = &q->p->ball;
    int c = q->c;
    size_t cc = (size_t)c * (size_t)c;
    SGA_ARENA(mem);
    SGA_FREED double *C = sga_calloc(cc, sizeof *C);
    double *m = sga_zeros(&mem, (size_t)c, sizeof *m), *rho = sga_zeros(&mem, (size_t)c, sizeof *rho);
    bool ok = true;
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
        mag_mul_2exp_si(arb_radref(sym), arb_radref(sym), unit + square_scale(q, q->lu.pivot_col[i]));
    }
    if (ok) {
        points_jacobian_values(q->j, ball);
        points_jacobian_entries(q->j, ball);
    }
    ok = ok && contracts(q, C, m, rho, places(q, &mem));
    return ok;
}

bool square_values(const struct square *q, struct lin_sparse *B)
{
    SGA_ARENA(mem);
    const int *place = places(q, &mem);
    int e = 0;
    for (int k = 0; k < q->c; k++)
        for (int l = 0; l < q->j->cols[k]; l++)
            if (place[q->j->col[k][l]] >= 0)
                B->val[e++] = num_ball_double(arb_midref(q->j->entry[k] + l), q->exponent[k] - square_scale(q, q->j->col[k][l]));
    assert(e == B->ptr[q->c]);
    return lin_all_finite(e, B->val);
}

struct lin_sparse *square_sparse(const struct square *q)
{
    int c = q->c, total = 0;
    SGA_ARENA(mem);
    const int *place = places(q, &mem);
    for (int k = 0; k < c; k++)
        total += q->j->cols[k];
    int *ptr = sga_zeros(&mem, (size_t)c + 1, sizeof *ptr), *col = sga_take(&mem, ((size_t)total + 1) * sizeof *col);
    total = 0;
    for (int k = 0; k < c; k++) {
        for (int l = 0; l < q->j->cols[k]; l++) {
            if (place[q->j->col[k][l]] < 0)
                continue;
            col[total++] = place[q->j->col[k][l]];
        }
        ptr[k + 1] = total;
    }
    struct lin_sparse *B = lin_sparse_new(c, q->unknowns, ptr, col);
    if (square_values(q, B))
        return B;
    lin_sparse_free(B);
    return NULL;
}

/* From the largest sums of rows and columns. */
double square_spread(const struct square *q, const struct lin_sparse *B)
{
    SGA_ARENA(mem);
    const int *place = places(q, &mem);
    double *column = sga_zeros(&mem, (size_t)q->unknowns + 1, sizeof *column), rows = 0, columns = 0;
    for (int k = 0, e = 0; k < q->c; k++) {
        double row = 0;
        for (int l = 0; l < q->j->cols[k]; l++) {
            int at = place[q->j->col[k][l]];
            if (at < 0)
                continue;
            arb_srcptr v = q->j->entry[k] + l;
            slong exponent = q->exponent[k] - square_scale(q, q->j->col[k][l]);
            long double mid = num_ball_long(arb_midref(v), exponent), off = fabsl(mid - B->val[e++]) + LDBL_EPSILON * fabsl(mid);
            double size = (double)off + radius(v, exponent) + DBL_MIN;
            if (!isfinite(size))
                return INFINITY;
            row += size;
            column[at] += size;
        }
        rows = sga_larger(rows, row);
    }
    for (int i = 0; i < q->unknowns; i++)
        columns = sga_larger(columns, column[i]);
    return sqrt(rows * columns) * (1 + 1e-9);
}

static void set_radii(struct square *q, double rho, slong prec)
{
    for (int i = 0; i < q->unknowns; i++) {
        mag_ptr radius = arb_radref(q->p->ball.symbol + q->j->space->variable[q->unknown[i]]);
        mag_set_d(radius, rho);
        mag_mul_2exp_si(radius, radius, square_scale(q, q->unknown[i]) - prec);
    }
}

static void values_at(struct square *q, slong prec)
{
    q->p->ball.prec = prec;
    points_jacobian_values(q->j, &q->p->ball);
}

/* The differentials in the ball of radius rho about the present point, to SPREAD_BITS. */
static void differentials_within(struct square *q, double rho, slong prec)
{
    set_radii(q, rho, prec);
    values_at(q, SPREAD_BITS);
    points_jacobian_entries(q->j, &q->p->ball);
}

bool square_stairs(const struct square *q, const struct lin_sparse *B, struct lin_stairs *stairs)
{
    const struct points_space *s = q->j->space;
    SGA_ARENA(mem);
    int *group = sga_zeros(&mem, (size_t)q->c + 1, sizeof *group), g = 0;
    for (int i = 0; i < q->c; i++) {
        while (g + 1 < s->ends && i >= s->end[g])
            g++;
        group[i] = s->ends > MOST_GROUPS ? (int)((long)g * MOST_GROUPS / s->ends) : g;
    }
    return lin_stairs_init(stairs, B, group, q->c ? group[q->c - 1] + 1 : 1);
}

/* A bound of |xi(x)|, in units of 2^-prec. */
static double residual(const struct square *q, slong prec)
{
    double sum = 0;
    for (int k = 0; k < q->c; k++) {
        double r = bound(num_ball_value(&q->p->ball, q->j->space->constraint[k]), q->exponent[k] - prec);
        sum += r * r;
    }
    return sqrt(sum) * (1 + 1e-9);
}

/* A matrix near J(X), |J(X) - B| = eta over the ball X of radius `within`. */
struct near {
    const struct lin_sparse *B;
    double eta, within;
};

/* With sigma > 0 no more than the least singular value of B, |xi(x~)| / sigma = beta and |J(X) - B| = eta over the ball X of radius rho about
 * x~: x -> x - B^+ xi(x) with B^+ = B^T (B B^T)^-1, |B^+| <= 1 / sigma, maps what the ball has of the plane x~ + B^T y into itself and contracts there
 * if beta + eta / sigma rho < rho, as I - B^+ J is B^+ (B - J) on differences B^T y; where it rests xi is 0. That eta is of a larger ball, as a rule. */
static bool contracts_by(struct square *q, const struct near *near, double sigma, double residual, slong prec)
{
    double beta = residual / sigma, rho = 2 * beta * (1 + 1e-9) + 1e-3, eta = near->eta;
    if (!(sigma > 0) || !isfinite(rho))
        return false;
    bool ok = rho <= near->within && (beta + eta / sigma * rho) * (1 + 1e-9) < rho;
    if (!ok) {
        differentials_within(q, rho, prec);
        ok = (beta + square_spread(q, near->B) / sigma * rho) * (1 + 1e-9) < rho;
    }
    set_radii(q, ok ? rho : 0, prec);
    return ok;
}

/* The bounds are of the values that J has. */
static void know(struct points_whole *w)
{
    size_t bytes = (size_t)w->J->ptr[w->J->rows] * sizeof *w->J->val;
    if (w->of && !memcmp(w->of, w->J->val, bytes))
        return;
    if (!w->of)
        w->of = sga_malloc(bytes);
    memcpy(w->of, w->J->val, bytes);
    w->least[0] = w->least[1] = -1;
}

/* By its generations first, whose factors are smaller, then as a whole. */
static bool contracts_whole(struct square *q, const struct near *near, double residual, slong prec)
{
    const struct sga_budget *budget = q->j->space->budget;
    struct points_whole *w = q->whole;
    know(w);
    for (int way = !w->none && w->stairs.groups > 1 ? 0 : 1; way < 2; way++) {
        if (w->least[way] < 0)
            w->least[way] = way ? num_least_singular(w->J, budget) : num_least_singular_stairs(&w->stairs, budget);
        if (contracts_by(q, near, w->least[way], residual, prec))
            return true;
    }
    return false;
}

/* Radii are counted in units of 2^-prec. */
static bool by_singular_value(struct square *q, slong prec)
{
    struct points_whole own = { .J = NULL };
    values_at(q, prec + 40);
    double r = residual(q, prec), within = ldexp(1, (int)(prec > 4 * MOST_WITHIN ? MOST_WITHIN : prec / 4));
    if (!isfinite(r))
        return false;
    differentials_within(q, within, prec);
    bool mine = !q->whole, ok = mine ? (own.J = square_sparse(q)) != NULL : square_values(q, q->whole->J);
    double eta = ok ? square_spread(q, mine ? own.J : q->whole->J) : INFINITY;
    set_radii(q, 0, prec);
    if (mine && ok) {
        q->whole = &own;
        own.none = !square_stairs(q, own.J, &own.stairs);
    } else if (ok) {
        lin_stairs_take(&q->whole->stairs);
    }
    ok = ok && contracts_whole(q, &(struct near){ q->whole->J, eta, within }, r, prec);
    if (mine) {
        q->whole = NULL;
        points_whole_clear(&own);
    }
    return ok;
}

bool points_prove(struct square *q, slong prec)
{
    if (q->c > DENSE_ROWS && by_singular_value(q, prec))
        return true;
    if (q->unknowns > q->c)
        return false;
    if (q->c > SGA_MOST_PROOF_ROWS) {
        sga_limit_met(q->j->space->budget, SGA_LIMIT_PROOF_ROWS);
        return false;
    }
    return by_inverse(q, prec);
}
