/* Is a field, is a map a symmetry? Definitions 4 and 5 of the source, with the bracket in
 * K (proposition 4) instead of the printed L(D)X - X, which would exclude D = 0. */
#include <arb_mat.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "sym_work.h"
#include "system.h"
#include "warnings.h"

/* The field in K, itself or after X0 times its time component was taken away. */
static enum sym_truth in_gauge(struct sym_work *w, const expr_id *D)
{
    size_t n = (size_t)w->n;
    expr_id defect;
    SGA_FREED expr_id *v = sga_malloc((n + 1) * sizeof *v);
    memcpy(v, D, (n + 1) * sizeof *v);
    sym_modulo_gauge(w, w->gauge, v);
    return sym_all_zero(w, v, w->n + 1, &defect);
}

static enum sym_truth tangent(struct sym_work *w, const expr_id *D, expr_id *defect)
{
    enum sym_truth all = SYM_TRUE;
    for (int i = 0; i < w->sol->constraints && all != SYM_FALSE; i++) {
        expr_id e = sym_derive(w, D, w->constraint[i]), bad = EXPR_UNDEF;
        enum sym_truth here = sym_all_zero(w, &e, 1, &bad);
        if (here != SYM_TRUE && (all == SYM_TRUE || here == SYM_FALSE))
            *defect = bad;
        all = sym_and(all, here);
    }
    return all;
}

/* [D, Y] + Y(theta) X0 in K. */
static enum sym_truth keeps(struct sym_work *w, const expr_id *D, const expr_id *Y, expr_id *defect)
{
    SGA_FREED expr_id *v = sga_malloc(((size_t)w->n + 1) * sizeof *v);
    sym_bracket(w, D, Y, v);
    sym_modulo_gauge(w, w->gauge, v);
    return sym_all_zero(w, v, w->n, defect);
}

static void unknown(struct sym_check *out)
{
    *out = (struct sym_check){ SYM_UNKNOWN, SYM_UNKNOWN, SYM_UNKNOWN, SYM_UNKNOWN, SYM_UNKNOWN, .defects = 0 };
}

void sym_check_field(struct sym_work *w, const expr_id *D, struct sym_check *out)
{
    expr_id defect = EXPR_UNDEF;
    unknown(out);
    out->tangent = tangent(w, D, &defect);
    sym_note(w, out, "tangent", defect, out->tangent);
    out->gauge = in_gauge(w, D);
    if (w->sol->field) {
        enum sym_truth solutions = keeps(w, D, w->field, &defect), fields = SYM_TRUE;
        sym_note(w, out, "solutions", defect, solutions);
        for (int k = 0; k < w->gauges && fields != SYM_FALSE; k++) {
            expr_id bad = EXPR_UNDEF;
            enum sym_truth here = keeps(w, D, w->gauge + (size_t)k * (size_t)(w->n + 1), &bad);
            if (here != SYM_TRUE && (fields == SYM_TRUE || here == SYM_FALSE))
                defect = bad;
            fields = sym_and(fields, here);
        }
        sym_note(w, out, "gauge_fields", defect, fields);
        /* brackets of a field that leaves Pf depend on how X0 goes on outside */
        out->symmetry = out->tangent == SYM_TRUE ? sym_and(solutions, fields) : out->tangent;
    }
    sym_field_preserves(w, D, out);
}

/* Is the Jacobian regular on Pf? Proved in balls at the points, by elimination. */
static enum sym_truth regular(struct sym_work *w, const expr_id *jacobian, int m)
{
    int yes = 0;
    for (int p = 0; p < w->oracle->reals; p++) {
        struct num_ball *b = &w->oracle->real[p].ball;
        num_ball_extend(b);
        SGA_ENDS(arb_mat_end) arb_mat_t a;
        SGA_ENDS(arb_end) arb_t det = { 0 };
        arb_mat_init(a, m, m);
        for (int i = 0; i < m; i++)
            for (int j = 0; j < m; j++)
                arb_set(arb_mat_entry(a, i, j), num_ball_value(b, jacobian[i * m + j]));
        arb_mat_det(det, a, b->prec);
        yes += arb_is_finite(det) && !arb_contains_zero(det);
    }
    return yes && yes == w->oracle->reals ? SYM_TRUE : SYM_UNKNOWN;
}

/* A row at or below k whose entry in column k is not zero on Pf: a number where there is one. *all: every other one is zero; -1: none. */
static int pivot_row(struct sym_work *w, const expr_id *a, int m, int k, bool *all)
{
    *all = true;
    for (int i = k; i < m; i++)
        if (expr_is_const(w->st, a[i * m + k]) && !expr_is_zero(w->st, a[i * m + k]))
            return i;
    for (int i = k; i < m; i++) {
        enum sym_truth zero = sym_zero(w, a[i * m + k]);
        if (zero == SYM_FALSE)
            return i;
        *all = *all && zero == SYM_TRUE;
    }
    return -1;
}

/* Is the determinant zero on Pf? By elimination with decided pivots, a overwritten; *defect: a pivot
 * that could not be decided. Column by column, so that a singular matrix ends at the first that depends on those before. */
static enum sym_truth singular(struct sym_work *w, expr_id *a, int m, expr_id *defect)
{
    struct expr_store *st = w->st;
    for (int k = 0; k < m; k++) {
        bool all;
        int p = pivot_row(w, a, m, k, &all);
        *defect = a[k * m + k];
        if (p < 0)
            return all ? SYM_TRUE : SYM_UNKNOWN;
        for (int j = 0; j < m && p != k; j++) {
            expr_id t = a[p * m + j];
            a[p * m + j] = a[k * m + j];
            a[k * m + j] = t;
        }
        for (int i = k + 1; i < m; i++) {
            if (expr_is_zero(st, a[i * m + k]))
                continue;
            if (!sga_budget_ok(w->budget, NULL))
                return SYM_UNKNOWN;
            expr_id f = expr_div(st, a[i * m + k], a[k * m + k]);
            for (int j = k + 1; j < m; j++)
                a[i * m + j] = expr_sub(st, a[i * m + j], expr_mul(st, f, a[k * m + j]));
        }
    }
    return SYM_FALSE;
}

static enum sym_truth diffeomorphism(struct sym_work *w, const expr_id *phi, expr_id *defect)
{
    int m = w->n + 1;
    if (m > SGA_MOST_MAP_VARIABLES) {
        sga_limit_met(w->budget, SGA_LIMIT_MAP_VARIABLES);
        return SYM_UNKNOWN;
    }
    SGA_ARENA(mem);
    expr_id *j = sga_take(&mem, (size_t)(m * m) * sizeof *j), *unit = sga_take(&mem, (size_t)m * sizeof *unit);
    for (int b = 0; b < m; b++) {
        for (int c = 0; c < m; c++)
            unit[c] = expr_int(w->st, b == c);
        for (int a = 0; a < m; a++)
            j[a * m + b] = sym_derive(w, unit, phi[a]);
    }
    enum sym_truth truth = regular(w, j, m);
    if (truth == SYM_UNKNOWN) {
        /* time alone seldom takes part: then its row is a unit */
        bool plain = expr_is_one(w->st, j[m * m - 1]);
        for (int b = 0; b < w->n; b++)
            plain = plain && expr_is_zero(w->st, j[w->n * m + b]);
        int small = plain ? w->n : m;
        for (int a = 0; a < small; a++)
            memmove(j + a * small, j + a * m, (size_t)small * sizeof *j);
        enum sym_truth zero = singular(w, j, small, defect);
        truth = zero == SYM_TRUE ? SYM_FALSE : zero == SYM_FALSE ? SYM_TRUE : SYM_UNKNOWN;
    }
    return truth;
}

/* D(phi) Y - Y(tau) X0(phi) in K(phi). */
static enum sym_truth maps(struct sym_work *w, const expr_id *phi, const expr_id *Y, const expr_id *field,
                           const expr_id *gauge, expr_id *defect)
{
    struct expr_store *st = w->st;
    SGA_FREED expr_id *v = sga_malloc(((size_t)w->n + 1) * sizeof *v);
    expr_id slow = sym_derive(w, Y, phi[w->n]);
    for (int a = 0; a < w->n; a++)
        v[a] = expr_sub(st, sym_derive(w, Y, phi[a]), expr_mul(st, slow, field[a]));
    sym_modulo_gauge(w, gauge, v);
    return sym_all_zero(w, v, w->n, defect);
}

void sym_check_map(struct sym_work *w, const expr_id *phi, struct sym_check *out)
{
    size_t n = (size_t)w->n, g = (size_t)w->gauges, c = (size_t)w->sol->constraints;
    SGA_ARENA(mem);
    expr_id defect = EXPR_UNDEF, *subst = sga_zeros(&mem, (size_t)w->st->symbols + 1, sizeof *subst);
    expr_id *there = sga_take(&mem, ((n + 1) * (g + 1) + c + 1) * sizeof *there);
    unknown(out);
    for (size_t j = 0; j < n; j++)
        subst[w->variable[j]] = phi[j];
    subst[w->sys->time] = phi[n];
    memcpy(there, w->constraint, c * sizeof *there);
    memcpy(there + c, w->field, (n + 1) * sizeof *there);
    memcpy(there + c + n + 1, w->gauge, (n + 1) * g * sizeof *there);
    expr_substitute(w->st, there, (int)(c + (n + 1) * (g + 1)), subst);
    out->tangent = sym_all_zero(w, there, (int)c, &defect);
    sym_note(w, out, "tangent", defect, out->tangent);
    defect = EXPR_UNDEF;
    enum sym_truth diffeo = diffeomorphism(w, phi, &defect);
    sym_note(w, out, "diffeomorphism", defect, diffeo);
    if (w->sol->field) {
        enum sym_truth solutions = maps(w, phi, w->field, there + c, there + c + n + 1, &defect), fields = SYM_TRUE;
        sym_note(w, out, "solutions", defect, solutions);
        for (size_t k = 0; k < g && fields != SYM_FALSE; k++) {
            expr_id bad = EXPR_UNDEF;
            enum sym_truth here = maps(w, phi, w->gauge + k * (n + 1), there + c, there + c + n + 1, &bad);
            if (here != SYM_TRUE && (fields == SYM_TRUE || here == SYM_FALSE))
                defect = bad;
            fields = sym_and(fields, here);
        }
        sym_note(w, out, "gauge_fields", defect, fields);
        out->symmetry = sym_and(out->tangent, diffeo);
        /* what the map makes of solutions off Pf depends on how X0 goes on there */
        if (out->tangent == SYM_TRUE)
            out->symmetry = sym_and(diffeo, sym_and(solutions, fields));
    }
    sym_map_preserves(w, phi, subst, out);
}
