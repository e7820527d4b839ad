/* Acceleration and reaction by the formulas of the source, (4.3) and (4.13).
 *
 * With masses on the diagonal that are not 0 the multipliers come from H M^{-1} H^T lambda = -(rate + H M^{-1} F), as many equations
 * as conditions; otherwise accelerations and multipliers are solved for together. */
#include "mech.h"

#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "form.h"
#include "mem.h"

struct motion {
    struct expr_store *st;
    const struct mech_fibre *f;
    const struct form_mechanical *in;
    int n, r;
};

static expr_id h(const struct motion *m, int i, int j)
{
    return m->f->H[(size_t)i * (size_t)m->n + (size_t)j];
}

static expr_id add_product(struct expr_store *st, expr_id sum, expr_id a, expr_id b)
{
    return expr_add(st, sum, expr_mul(st, a, b));
}

/* S y = b (S is size x size): one and two unknowns by Cramer's rule. */
static void solve(struct expr_store *st, int size, const expr_id *S, const expr_id *b, expr_id *y)
{
    if (size == 1) {
        y[0] = expr_div(st, b[0], S[0]);
    } else if (size == 2) {
        expr_id det = expr_sub(st, expr_mul(st, S[0], S[3]), expr_mul(st, S[1], S[2]));
        y[0] = expr_div(st, expr_sub(st, expr_mul(st, b[0], S[3]), expr_mul(st, S[1], b[1])), det);
        y[1] = expr_div(st, expr_sub(st, expr_mul(st, S[0], b[1]), expr_mul(st, b[0], S[2])), det);
    } else if (size > 2) {
        int solution = expr_solve_add(st, size, S, b);
        for (int i = 0; i < size; i++)
            y[i] = expr_solution(st, solution, i);
    }
}

/* H W H^T for a diagonal W, or H H^T. */
static expr_id *gram(const struct motion *m, const expr_id *weight)
{
    expr_id *G = sga_malloc(((size_t)m->r * (size_t)m->r + 1) * sizeof *G);
    for (int i = 0; i < m->r; i++)
        for (int k = 0; k < m->r; k++) {
            expr_id sum = expr_int(m->st, 0);
            for (int j = 0; j < m->n; j++) {
                expr_id p = expr_mul(m->st, h(m, i, j), h(m, k, j));
                sum = expr_add(m->st, sum, weight ? expr_mul(m->st, p, weight[j]) : p);
            }
            G[(size_t)i * (size_t)m->r + (size_t)k] = sum;
        }
    return G;
}

/* 1 / mass by coordinate where M is diagonal without zeros; otherwise NULL. */
static expr_id *inverse_masses(const struct motion *m)
{
    expr_id *w = sga_malloc((size_t)(m->n + 1) * sizeof *w);
    bool ok = true;
    for (int j = 0; j < m->n; j++)
        w[j] = expr_int(m->st, 0);
    for (size_t k = 0; k < m->in->masses && ok; k++) {
        const struct form_entry *e = m->in->mass + k;
        ok = e->row == e->col || expr_is_zero(m->st, e->value);
        if (e->row == e->col)
            w[e->row] = expr_add(m->st, w[e->row], e->value);
    }
    for (int j = 0; j < m->n && ok; j++) {
        ok = !expr_is_zero(m->st, w[j]);
        w[j] = ok ? expr_div(m->st, expr_int(m->st, 1), w[j]) : w[j];
    }
    if (ok)
        return w;
    free(w);
    return NULL;
}

/* reaction = H^T lambda */
static void react(const struct motion *m, const expr_id *lambda, expr_id *reaction)
{
    for (int j = 0; j < m->n; j++) {
        reaction[j] = expr_int(m->st, 0);
        for (int i = 0; i < m->r; i++)
            reaction[j] = add_product(m->st, reaction[j], h(m, i, j), lambda[i]);
    }
}

static void by_multipliers(const struct motion *m, const expr_id *w, struct mech_motion *out)
{
    struct expr_store *st = m->st;
    SGA_ARENA(mem);
    SGA_FREED expr_id *S = gram(m, w);
    expr_id *b = sga_take(&mem, (size_t)(m->r + 1) * sizeof *b), *lambda = sga_zeros(&mem, (size_t)m->r + 1, sizeof *lambda);
    for (int i = 0; i < m->r; i++) {
        b[i] = m->f->rate[i];
        for (int j = 0; j < m->n; j++)
            b[i] = add_product(st, b[i], h(m, i, j), expr_mul(st, w[j], m->in->force[j]));
        b[i] = expr_neg(st, b[i]);
    }
    solve(st, m->r, S, b, lambda);
    react(m, lambda, out->reaction);
    for (int j = 0; j < m->n; j++)
        out->total[j] = expr_mul(st, w[j], expr_add(st, m->in->force[j], out->reaction[j]));
}

/* [M, -H^T; H, 0] (xi, lambda) = (F, -rate) */
static void together(const struct motion *m, struct mech_motion *out)
{
    struct expr_store *st = m->st;
    int n = m->n, size = n + m->r;
    SGA_ARENA(mem);
    expr_id *K = sga_take(&mem, ((size_t)size * (size_t)size + 1) * sizeof *K);
    expr_id *b = sga_take(&mem, (size_t)(size + 1) * sizeof *b), *y = sga_zeros(&mem, (size_t)size + 1, sizeof *y);
    for (int i = 0; i < size * size; i++)
        K[i] = expr_int(st, 0);
    for (size_t k = 0; k < m->in->masses; k++) {
        expr_id *at = K + (size_t)m->in->mass[k].row * (size_t)size + (size_t)m->in->mass[k].col;
        *at = expr_add(st, *at, m->in->mass[k].value);
    }
    for (int j = 0; j < n; j++)
        b[j] = m->in->force[j];
    for (int i = 0; i < m->r; i++) {
        b[n + i] = expr_neg(st, m->f->rate[i]);
        for (int j = 0; j < n; j++) {
            K[(size_t)(n + i) * (size_t)size + (size_t)j] = h(m, i, j);
            K[(size_t)j * (size_t)size + (size_t)(n + i)] = expr_neg(st, h(m, i, j));
        }
    }
    solve(st, size, K, b, y);
    for (int j = 0; j < n; j++)
        out->total[j] = y[j];
    react(m, y + n, out->reaction);
}

static void split(const struct motion *m, struct mech_motion *out)
{
    struct expr_store *st = m->st;
    SGA_FREED expr_id *G = gram(m, NULL), *y = sga_calloc((size_t)m->r + 1, sizeof *y);
    solve(st, m->r, G, m->f->rate, y);
    react(m, y, out->orthogonal);
    for (int j = 0; j < m->n; j++) {
        out->orthogonal[j] = expr_neg(st, out->orthogonal[j]);
        out->tangent[j] = expr_sub(st, out->total[j], out->orthogonal[j]);
    }
}

static struct motion begin(struct mech_motion *out, const struct mech_fibre *f, const struct form_mechanical *in)
{
    size_t size = (size_t)in->coordinates + 1;
    *out = (struct mech_motion){ sga_calloc(size, sizeof(expr_id)), sga_calloc(size, sizeof(expr_id)),
                                 sga_calloc(size, sizeof(expr_id)), sga_calloc(size, sizeof(expr_id)) };
    return (struct motion){ .st = f->kinematics.store, .f = f, .in = in, .n = in->coordinates, .r = f->conditions };
}

void mech_motion_find(struct mech_motion *out, const struct mech_fibre *f, const struct form_mechanical *in)
{
    assert(f->W && f->oracle);
    struct motion m = begin(out, f, in);
    SGA_FREED expr_id *w = inverse_masses(&m);
    if (w)
        by_multipliers(&m, w, out);
    else
        together(&m, out);
    split(&m, out);
}

void mech_motion_of(struct mech_motion *out, const struct mech_fibre *f, const struct form_mechanical *in, const expr_id *total)
{
    assert(f->W && f->oracle);
    struct motion m = begin(out, f, in);
    for (int j = 0; j < m.n; j++) {
        out->total[j] = total[j];
        out->reaction[j] = expr_neg(m.st, in->force[j]);
    }
    for (size_t k = 0; k < in->masses; k++)
        out->reaction[in->mass[k].row] = add_product(m.st, out->reaction[in->mass[k].row], in->mass[k].value,
                                                     total[in->mass[k].col]);
    split(&m, out);
}

void mech_motion_clear(struct mech_motion *m)
{
    free(m->total);
    free(m->tangent);
    free(m->orthogonal);
    free(m->reaction);
    *m = (struct mech_motion){ 0 };
}
