/* What a field or a map does to T and alpha themselves, where T is a tensor: rows and columns
 * of A belong to the variables. Sufficient for a symmetry, not necessary (theorem 3).
 *     (L_D T)_ij = D(A_ij) + A_kj d_i D^k + A_ik d_j D^k
 *     (L_D alpha)_i = D(alpha_i) + alpha_k d_i D^k */
#include "sym_work.h"

#include <stdlib.h>

#include "arena.h"
#include "derive.h"
#include "mem.h"
#include "oracle.h"
#include "system.h"
#include "warnings.h"

/* d[i * n + k] = d phi^k / d x_i */
static expr_id *partials(struct sym_work *w, const expr_id *phi)
{
    size_t n = (size_t)w->n;
    expr_id *d = sga_malloc((n * n + 1) * sizeof *d);
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < n; i++)
            d[i * n + k] = expr_diff(w->st, phi[k], w->variable[i]);
    return d;
}

static bool usable(const struct sym_work *w)
{
    if (w->tensor && w->n > SGA_MOST_TENSOR)
        sga_limit_met(w->budget, SGA_LIMIT_TENSOR);
    return w->tensor && w->n <= SGA_MOST_TENSOR;
}

static void add_product(struct expr_store *st, expr_id *sum, expr_id a, expr_id b)
{
    if (!expr_is_zero(st, a) && !expr_is_zero(st, b))
        *sum = expr_add(st, *sum, expr_mul(st, a, b));
}

/* T (n x n) and alpha (n) hold what ought to vanish on Pf. */
static void report(struct sym_work *w, struct sym_check *c, const expr_id *T, const expr_id *alpha)
{
    expr_id defect = EXPR_UNDEF;
    c->preserves_T = sym_all_zero(w, T, w->n * w->n, &defect);
    sym_note(w, c, "T", defect, c->preserves_T);
    c->preserves_alpha = sym_all_zero(w, alpha, w->n, &defect);
    sym_note(w, c, "alpha", defect, c->preserves_alpha);
}

void sym_field_preserves(struct sym_work *w, const expr_id *D, struct sym_check *c)
{
    struct expr_store *st = w->st;
    int n = w->n;
    if (!usable(w) || !expr_is_const(st, D[n]))
        return;
    SGA_FREED expr_id *d = partials(w, D), *T = sga_malloc((size_t)(n * n + n + 1) * sizeof *T);
    expr_id *alpha = T + n * n;
    for (int i = 0; i < n * n; i++)
        T[i] = expr_int(st, 0);
    for (int k = 0; k < n; k++) {
        const struct sys_row *r = w->sys->row + k;
        for (int q = 0; q < r->entries; q++) {
            int l = r->entry[q].col;
            T[k * n + l] = expr_add(st, T[k * n + l], sym_derive(w, D, r->entry[q].value));
            for (int i = 0; i < n; i++) {
                add_product(st, T + i * n + l, r->entry[q].value, d[i * n + k]);
                add_product(st, T + k * n + i, r->entry[q].value, d[i * n + l]);
            }
        }
    }
    for (int i = 0; i < n; i++) {
        alpha[i] = sym_derive(w, D, w->sys->row[i].alpha);
        for (int k = 0; k < n; k++)
            add_product(st, alpha + i, w->sys->row[k].alpha, d[i * n + k]);
    }
    report(w, c, T, alpha);
}

void sym_map_preserves(struct sym_work *w, const expr_id *phi, const expr_id *subst, struct sym_check *c)
{
    struct expr_store *st = w->st;
    int n = w->n;
    if (!usable(w) || phi[n] != st->symbol[w->sys->time].node)
        return;
    SGA_FREED expr_id *d = partials(w, phi), *T = sga_malloc((size_t)(n * n + n + 1) * sizeof *T);
    expr_id *alpha = T + n * n;
    for (int i = 0; i < n * n; i++)
        T[i] = expr_neg(st, sym_entry(w, i / n, i % n));
    for (int i = 0; i < n; i++)
        alpha[i] = expr_neg(st, w->sys->row[i].alpha);
    for (int k = 0; k < n; k++) {
        const struct sys_row *r = w->sys->row + k;
        expr_id there = r->alpha;
        expr_substitute(st, &there, 1, subst);
        for (int i = 0; i < n; i++)
            add_product(st, alpha + i, there, d[i * n + k]);
        for (int q = 0; q < r->entries; q++) {
            int l = r->entry[q].col;
            expr_id value = r->entry[q].value;
            expr_substitute(st, &value, 1, subst);
            for (int i = 0; i < n; i++)
                for (int j = 0; j < n && !expr_is_zero(st, d[i * n + k]); j++)
                    add_product(st, T + i * n + j, expr_mul(st, value, d[i * n + k]), d[j * n + l]);
        }
    }
    report(w, c, T, alpha);
}

/* Zero on all of M, at points of a oracle of its own. */
static enum sym_truth vanish(struct points_oracle *space, struct expr_store *st, expr_id e)
{
    if (expr_is_zero(st, e))
        return SYM_TRUE;
    if (!space->reals)
        return SYM_UNKNOWN;
    struct points_decision d = points_oracle_zero(space, e);
    return d.truth == POINTS_ZERO ? SYM_TRUE : d.truth == POINTS_NONZERO ? SYM_FALSE : SYM_UNKNOWN;
}

static enum sym_truth closed_form(struct sym_work *w, struct points_oracle *space)
{
    struct expr_store *st = w->st;
    int n = w->n;
    enum sym_truth all = SYM_TRUE;
    for (int i = 0; i < n; i++)
        for (int j = i + 1; j < n; j++)
            for (int k = j + 1; k < n && all != SYM_FALSE; k++) {
                expr_id e = expr_diff(st, sym_entry(w, j, k), w->variable[i]);
                e = expr_add(st, e, expr_diff(st, sym_entry(w, k, i), w->variable[j]));
                e = expr_add(st, e, expr_diff(st, sym_entry(w, i, j), w->variable[k]));
                all = sym_and(all, vanish(space, st, e));
            }
    return all;
}

void sym_presymplectic(struct sym_work *w, struct sym_result *out)
{
    struct expr_store *st = w->st;
    int n = w->n;
    out->antisymmetric = out->closed = out->alpha_closed = SYM_UNKNOWN;
    if (w->tensor && n > SGA_MOST_CLOSED)
        sga_limit_met(w->budget, SGA_LIMIT_CLOSED);
    if (!usable(w) || n > SGA_MOST_CLOSED)
        return;
    SGA_ENDS(points_oracle_clear) struct points_oracle space;
    struct points_space all = w->oracle->space;
    all.constraint = NULL;
    all.constraints = 0;
    points_oracle_init(&space, 20250815);
    points_oracle_sample(&space, &all);
    out->antisymmetric = out->alpha_closed = SYM_TRUE;
    for (int i = 0; i < n; i++)
        for (int j = i; j < n; j++) {
            expr_id sum = expr_add(st, sym_entry(w, i, j), sym_entry(w, j, i));
            expr_id curl = expr_sub(st, expr_diff(st, w->sys->row[i].alpha, w->variable[j]),
                                    expr_diff(st, w->sys->row[j].alpha, w->variable[i]));
            if (out->antisymmetric != SYM_FALSE)
                out->antisymmetric = sym_and(out->antisymmetric, vanish(&space, st, sum));
            if (out->alpha_closed != SYM_FALSE)
                out->alpha_closed = sym_and(out->alpha_closed, vanish(&space, st, curl));
        }
    out->closed = out->antisymmetric == SYM_TRUE ? closed_form(w, &space) : SYM_UNKNOWN;
}
