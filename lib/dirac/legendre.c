/* Velocities are eliminated by linear algebra, or through the one root. */
#include "legendre.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "derive.h"
#include "error.h"


static bool has_velocity(const struct legendre_request *rq, expr_id e)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    for (int i = 0; i < rq->n; i++)
        if (expr_depends(rq->weak->st, &cone, e, rq->v[i]))
            return true;
    return false;
}

/* e with all velocities 0. */
static expr_id at_rest(const struct legendre_request *rq, expr_id e)
{
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)rq->weak->st->symbols + 1, sizeof *map);
    for (int i = 0; i < rq->n; i++)
        map[rq->v[i]] = expr_int(rq->weak->st, 0);
    expr_substitute(rq->weak->st, &e, 1, map);
    return e;
}

/* e = v^T (G/2) v + g v + k: G by rows, in normal form. False: it is not of that shape, as far as normal forms see. */
struct quadratic {
    expr_id *G, *g, k;
};

static bool take_quadratic(const struct legendre_request *rq, expr_id e, struct quadratic *out)
{
    const struct weak *w = rq->weak;
    int n = rq->n;
    out->G = sga_zeros(rq->mem, (size_t)(n * n) + 1, sizeof *out->G);
    out->g = sga_zeros(rq->mem, (size_t)n + 1, sizeof *out->g);
    for (int i = 0; i < n; i++) {
        expr_id d = expr_diff(w->st, e, rq->v[i]);
        out->g[i] = weak_normal(w, at_rest(rq, d));
        for (int k = 0; k < n; k++) {
            out->G[i * n + k] = weak_normal(w, expr_diff(w->st, d, rq->v[k]));
            if (!out->G[i * n + k] || has_velocity(rq, out->G[i * n + k]))
                return false;
        }
        if (!out->g[i])
            return false;
    }
    out->k = weak_normal(w, at_rest(rq, e));
    return out->k != EXPR_UNDEF;
}

static bool is_quadratic(const struct legendre_request *rq, expr_id e, struct quadratic *out)
{
    struct sga_error before = *rq->weak->st->error;      /* a root may have no derivative at rest */
    bool ok = take_quadratic(rq, e, out);
    if (!ok)
        *rq->weak->st->error = before;
    return ok;
}

/* p_i = G v + g: the rows [G | p - g | 1] by elimination: velocities of the rows with pivots, constraints of the others. */
static bool solve_quadratic(struct legendre *out, const struct legendre_request *rq, const struct quadratic *l)
{
    const struct weak *w = rq->weak;
    struct expr_store *st = w->st;
    int n = rq->n, width = n + 1;
    SGA_ARENA(mem);
    expr_id *m = sga_zeros(&mem, (size_t)(n * width) + 1, sizeof *m), *v = sga_zeros(&mem, (size_t)n + 1, sizeof *v);
    int *pivot = sga_zeros(&mem, (size_t)n + 1, sizeof *pivot);
    for (int i = 0; i < n; i++) {
        memcpy(m + i * width, l->G + i * n, (size_t)n * sizeof *m);
        m[i * width + n] = expr_sub(st, rq->p[i], l->g[i]);
    }
    if (!weak_eliminate(w, m, n, n, width, pivot))
        return false;
    for (int i = 0; i < n; i++) {
        out->rank += pivot[i] >= 0;
        v[i] = pivot[i] >= 0 ? m[pivot[i] * width + n] : expr_int(st, 0);     /* the others are free: H does not depend on them on the primary set */
    }
    for (int i = out->rank; i < n; i++)
        out->primary[out->primaries++] = weak_normal(w, m[i * width + n]);
    assert(out->rank + out->primaries == n);
    /* H = p v - L = (p - g) v - v G v / 2 - k */
    expr_id h = expr_neg(st, l->k), half = expr_rational(st, 1, 2);
    for (int i = 0; i < n; i++) {
        expr_id row = expr_sub(st, rq->p[i], l->g[i]);
        for (int k = 0; k < n; k++)
            row = expr_sub(st, row, expr_mul(st, half, expr_mul(st, l->G[i * n + k], v[k])));
        h = expr_add(st, h, expr_mul(st, v[i], row));
    }
    out->hamiltonian = weak_normal(w, h);
    return true;
}

/* The one root whose argument has velocities; EXPR_UNDEF: none, or several. */
static expr_id only_root(const struct legendre_request *rq, expr_id e)
{
    const struct expr_store *st = rq->weak->st;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_id found = EXPR_UNDEF;
    int count = 0;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, &e, 1);
    for (int i = 0; i < cone.count; i++)
        if (expr_op_of(st, cone.list[i]) == EXPR_SQRT && has_velocity(rq, cone.list[i])) {
            found = cone.list[i];
            count++;
        }
    return count == 1 ? found : EXPR_UNDEF;
}

/* x^T G^-1 y; inverse by rows. */
static expr_id paired(const struct legendre_request *rq, const expr_id *inverse, const expr_id *x, const expr_id *y)
{
    struct expr_store *st = rq->weak->st;
    expr_id sum = expr_int(st, 0);
    for (int i = 0; i < rq->n; i++)
        for (int k = 0; k < rq->n; k++)
            sum = expr_add(st, sum, expr_mul(st, x[i], expr_mul(st, inverse[i * rq->n + k], y[k])));
    return weak_normal(rq->weak, sum);
}

/* The inverse of half of u's matrix: u = v^T (G/2) v + ...; false with *regular false: it has none. */
static bool invert(const struct legendre_request *rq, const expr_id *G, expr_id *inverse, bool *regular)
{
    struct expr_store *st = rq->weak->st;
    int n = rq->n, width = 2 * n;
    SGA_ARENA(mem);
    expr_id *m = sga_zeros(&mem, (size_t)(n * width) + 1, sizeof *m);
    int *pivot = sga_zeros(&mem, (size_t)n + 1, sizeof *pivot);
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++) {
            m[i * width + k] = expr_mul(st, expr_rational(st, 1, 2), G[i * n + k]);
            m[i * width + n + k] = expr_int(st, i == k);
        }
    if (!weak_eliminate(rq->weak, m, n, n, width, pivot))
        return false;
    *regular = true;
    for (int i = 0; i < n; i++) {
        *regular &= pivot[i] >= 0;
        for (int k = 0; k < n && pivot[i] >= 0; k++)
            inverse[i * n + k] = m[pivot[i] * width + n + k];
    }
    return true;
}

/* L = c s + b v + d, s = sqrt(u), u = v G v + 2 g v + k. With pi = p - b: pi = c (G v + g)/s, so that s^2 (1 - pi G^-1 pi/c^2) = k - g G^-1 g. */
static bool solve_root(struct legendre *out, const struct legendre_request *rq, bool *solved)
{
    const struct weak *w = rq->weak;
    struct expr_store *st = w->st;
    int n = rq->n;
    SGA_ARENA(mem);
    expr_id root = only_root(rq, rq->lagrangian);
    *solved = false;
    if (!root)
        return true;
    /* the root as a symbol: L must be affine in it, without velocities in its coefficient */
    int symbol = rq->root;
    expr_id s = st->symbol[symbol].node;
    expr_id *by = sga_zeros(&mem, (size_t)st->nodes + 1, sizeof *by);
    by[root] = s;
    expr_id plain = expr_replace(st, rq->lagrangian, by);
    expr_id c = weak_normal(w, expr_diff(st, plain, symbol));
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_cone_init(&cone);
    if (!c || has_velocity(rq, c) || expr_depends(st, &cone, c, symbol))
        return true;
    expr_id rest = weak_normal(w, expr_sub(st, plain, expr_mul(st, c, s)));
    struct quadratic b, u;
    if (!rest || expr_depends(st, &cone, rest, symbol) || !is_quadratic(rq, rest, &b) || !is_quadratic(rq, expr_child(st, root, 0), &u))
        return true;
    for (int i = 0; i < n * n; i++)
        if (!expr_is_zero(st, b.G[i]))
            return true;
    expr_id *inverse = sga_zeros(&mem, (size_t)(n * n) + 1, sizeof *inverse), *pi = sga_zeros(&mem, (size_t)n + 1, sizeof *pi), *g = sga_zeros(&mem, (size_t)n + 1, sizeof *g);
    bool regular;
    if (!invert(rq, u.G, inverse, &regular))
        return false;
    if (!regular)
        return true;
    for (int i = 0; i < n; i++) {
        pi[i] = expr_sub(st, rq->p[i], b.g[i]);
        g[i] = expr_mul(st, expr_rational(st, 1, 2), u.g[i]);
    }
    expr_id square = paired(rq, inverse, pi, pi), kappa = weak_normal(w, expr_sub(st, u.k, paired(rq, inverse, g, g)));
    expr_id mass = expr_mul(st, c, c), h = expr_sub(st, expr_neg(st, paired(rq, inverse, pi, g)), b.k);
    int homogeneous = weak_zero(w, kappa);
    if (homogeneous < 0)
        return false;
    if (homogeneous) {
        out->primary[out->primaries++] = weak_normal(w, expr_sub(st, square, mass));
        out->rank = n - 1;
    } else {                      /* -c kappa / s, 1/s = sqrt((c^2 - pi^2)/kappa)/|c|: the sign of c is that of its branch */
        expr_id inside = weak_normal(w, expr_div(st, expr_sub(st, mass, square), kappa));
        expr_id sign = expr_is_const(st, c) ? expr_int(st, fmpq_sgn(expr_const_value(st, c))) : expr_fun(st, EXPR_SIGN, c);
        h = expr_sub(st, h, expr_mul(st, expr_mul(st, sign, kappa), expr_fun(st, EXPR_SQRT, inside)));
        out->rank = n;
    }
    out->hamiltonian = weak_normal(w, h);
    *solved = true;
    return true;
}

bool legendre_map(struct legendre *out, const struct legendre_request *rq)
{
    const struct weak *w = rq->weak;
    struct quadratic l;
    bool solved = false;
    *out = (struct legendre){ .n = rq->n };
    out->momentum = sga_zeros(rq->mem, (size_t)rq->n + 1, sizeof *out->momentum);
    out->primary = sga_zeros(rq->mem, (size_t)rq->n + 1, sizeof *out->primary);
    for (int i = 0; i < rq->n; i++)
        out->momentum[i] = weak_normal(w, expr_diff(w->st, rq->lagrangian, rq->v[i]));
    if (is_quadratic(rq, rq->lagrangian, &l))
        return solve_quadratic(out, rq, &l);
    if (!solve_root(out, rq, &solved))
        return false;
    if (solved)
        return true;
    return sga_fail_at(w->err, SGA_E_NOT_SUPPORTED, "/system/lagrangian", "the velocities cannot be eliminated exactly: the Lagrangian is neither quadratic in the velocities nor a root of "
                       "a regular quadratic form with terms linear in them beside it; send its Hamiltonian with the primary constraints in form \"hamiltonian\"");
}
