/* The vector field and the gauge fields of an affine system.
 *
 * Where elimination keeps rows sparse and numbers short the field is the back substitution, in which equal
 * parts are shared. Dense systems have long numbers in it; there the field is written out in coordinates of the
 * final set, whose coefficients are as short as that set allows. */
#include "affine.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include <flint/fmpq_mat.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "flint_ends.h"
#include "mem.h"
#include "reduction.h"
#include "system.h"

/* One pivot row over the rationals: entries behind the pivot, operations as in the modular one. */
struct exact_lu_row {
    int *col; fmpq *value; int entries;
    fmpq pivot;
    fmpq *factor;              /* by operation */
};

struct lu {
    struct affine_run *r;
    struct exact_lu_row *row; int rows;
    fmpq *work; unsigned char *met; int *list; int count;
    double bits, numbers;
};

enum { WRITTEN_OUT = 100 };        /* rows: of so many a field is written out, long as its numbers may be */
/* Numbers of so many bits on average are short; below so many in all the field is short in any case. */
static const double SHORT_BITS = 40, FEW_BITS = 20000, MOST_BITS = 1e9;

static void met(struct lu *l, int col)
{
    if (l->met[col])
        return;
    l->met[col] = 1;
    l->list[l->count++] = col;
}

static double bits_of(const fmpq *q)
{
    return (double)fmpz_bits(fmpq_numref(q)) + (double)fmpz_bits(fmpq_denref(q));
}

static void load(struct lu *l, const struct affine_row *from)
{
    l->count = 0;
    for (int k = 0; k < from->a.entries; k++) {
        met(l, from->a.col[k]);
        fmpq *v = l->work + from->a.col[k];
        fmpq_set_fmpz(v, from->a.value + k);
        fmpq_div(v, v, &from->scale);
    }
}

/* The pivot rows are worked off in the order that the modular elimination found. */
static void lu_row(struct lu *l, int q)
{
    const struct exact_pivot *p = l->r->velocities.pivot + q;
    struct exact_lu_row *to = l->row + q;
    load(l, affine_source(l->r, p->row));
    to->factor = sga_malloc(((size_t)p->ops + 1) * sizeof *to->factor);
    for (int k = 0; k < p->ops; k++) {
        const struct exact_lu_row *by = l->row + p->op[k].pivot;
        int col = l->r->velocities.pivot[p->op[k].pivot].col;
        fmpq_init(to->factor + k);
        fmpq_div(to->factor + k, l->work + col, &by->pivot);
        fmpq_zero(l->work + col);
        for (int m = 0; m < by->entries; m++) {
            met(l, by->col[m]);
            fmpq_submul(l->work + by->col[m], to->factor + k, by->value + m);
        }
        l->bits += bits_of(to->factor + k);
    }
    to->col = sga_malloc(((size_t)l->count + 1) * sizeof *to->col);
    to->value = sga_malloc(((size_t)l->count + 1) * sizeof *to->value);
    fmpq_init(&to->pivot);
    for (int k = 0; k < l->count; k++) {
        int col = l->list[k];
        fmpq *v = l->work + col;
        l->met[col] = 0;
        l->bits += bits_of(v);
        if (col == p->col) {
            fmpq_set(&to->pivot, v);
        } else if (!fmpq_is_zero(v)) {
            to->col[to->entries] = col;
            fmpq_init(to->value + to->entries);
            fmpq_set(to->value + to->entries++, v);
        }
        fmpq_zero(v);
    }
    l->rows = q + 1;
    l->numbers += p->ops + to->entries + 1;
}

/* A field of long numbers that nobody asks for, and that takes long to write out. */
static bool unasked(const struct affine_run *r)
{
    return (r->many || r->velocities.pivots > WRITTEN_OUT) && r->s->options->field_unasked && r->constraints < r->a->n;
}

/* Every pivot row. False: the numbers grow long (or the budget ended). */
static bool lu_make(struct lu *l, struct affine_run *r)
{
    const double most = r->many && !unasked(r) ? MOST_BITS : 0;
    int n = r->a->n, pivots = r->velocities.pivots;
    *l = (struct lu){ .r = r };
    l->row = sga_calloc((size_t)pivots + 1, sizeof *l->row);
    l->work = sga_malloc(((size_t)n + 1) * sizeof *l->work);
    l->met = sga_calloc((size_t)n + 1, 1);
    l->list = sga_malloc(((size_t)n + 1) * sizeof *l->list);
    for (int j = 0; j < n; j++)
        fmpq_init(l->work + j);
    bool ok = true;
    for (int q = 0; q < pivots && ok; q++) {
        lu_row(l, q);
        ok = sga_budget_ok(r->s->options->budget, NULL) && !fmpq_is_zero(&l->row[q].pivot)
             && l->bits < fmax(most, FEW_BITS + SHORT_BITS * l->numbers);
    }
    return ok;
}

static void lu_clear(struct lu *l)
{
    for (int q = 0; q < l->rows; q++) {
        for (int k = 0; k < l->row[q].entries; k++)
            fmpq_clear(l->row[q].value + k);
        for (int k = 0; k < l->r->velocities.pivot[q].ops; k++)
            fmpq_clear(l->row[q].factor + k);
        fmpq_clear(&l->row[q].pivot);
        free(l->row[q].col);
        free(l->row[q].value);
        free(l->row[q].factor);
    }
    for (int j = 0; j < l->r->a->n; j++)
        fmpq_clear(l->work + j);
    free(l->row);
    free(l->work);
    free(l->met);
    free(l->list);
}

/* The right side of a row as it was given; of a tangency -d_t xi. */
static expr_id right_side(struct affine_run *r, int source)
{
    assert(source >= 0 && source < r->s->sys->rows + r->constraints);
    int rows = r->s->sys->rows;
    if (source < rows)
        return r->s->sys->row[source].alpha;
    const struct affine_row *t = &r->constraint[source - rows]->tangency;
    return affine_expression_from(r->a, &t->b, 0, fmpq_numref(&t->scale));
}

static expr_id times(struct expr_store *st, const fmpq *q, expr_id e)
{
    return expr_mul(st, expr_fmpq(st, q), e);
}

static void field_by_substitution(struct lu *l, expr_id *v)
{
    struct expr_store *st = l->r->s->st;
    struct exact_echelon *e = &l->r->velocities;
    SGA_FREED expr_id *rhs = sga_malloc(((size_t)e->pivots + 1) * sizeof *rhs);
    for (int q = 0; q < e->pivots; q++) {
        rhs[q] = right_side(l->r, e->pivot[q].row);
        for (int k = 0; k < e->pivot[q].ops; k++)
            rhs[q] = expr_sub(st, rhs[q], times(st, l->row[q].factor + k, rhs[e->pivot[q].op[k].pivot]));
    }
    for (int q = e->pivots - 1; q >= 0; q--) {
        expr_id x = rhs[q];
        for (int k = 0; k < l->row[q].entries; k++)
            x = expr_sub(st, x, times(st, l->row[q].value + k, v[l->row[q].col[k]]));
        v[e->pivot[q].col] = expr_div(st, x, expr_fmpq(st, &l->row[q].pivot));
    }
}

/* A x' = 0 with x'_free = 1 and the other free ones 0. */
static void gauge_by_substitution(struct lu *l, fmpq *v)
{
    struct exact_echelon *e = &l->r->velocities;
    for (int q = e->pivots - 1; q >= 0; q--) {
        fmpq *x = v + e->pivot[q].col;
        fmpq_zero(x);
        for (int k = 0; k < l->row[q].entries; k++)
            fmpq_submul(x, l->row[q].value + k, v + l->row[q].col[k]);
        fmpq_div(x, x, &l->row[q].pivot);
    }
}

/* Dense: the pivot rows restricted to the pivot columns, S. */
static void pivot_block(const struct affine_run *r, fmpz_mat_t S)
{
    const struct exact_echelon *e = &r->velocities;
    for (int q = 0; q < e->pivots; q++) {
        const struct exact_row *a = &affine_source(r, e->pivot[q].row)->a;
        for (int k = 0; k < a->entries; k++)
            if (e->pivot_of[a->col[k]] >= 0)
                fmpz_set(fmpz_mat_entry(S, q, e->pivot_of[a->col[k]]), a->value + k);
    }
}

/* Coordinates of the final set: the variables that are not pivots of the basis, then the atoms.
 * place: by variable, which coordinate; or -1 - i for the pivot of the i-th row. */
struct coordinates {
    int *place, count, atoms;
    const struct exact_basis *basis;
    fmpz_t den;                /* a common multiple of the pivots */
};

static const fmpz *pivot_of(const struct exact_basis *b, int i)
{
    return b->row[i].value + exact_row_before(b->row + i, b->pivot[i]);
}

static void coordinates_make(struct coordinates *c, const struct affine_run *r)
{
    assert(r->basis.rows <= r->a->n);
    *c = (struct coordinates){ .place = sga_malloc(((size_t)r->a->n + 1) * sizeof *c->place), .atoms = r->a->atoms, .basis = &r->basis };
    fmpz_init_set_ui(c->den, 1);
    for (int j = 0; j < r->a->n; j++)
        c->place[j] = r->basis.row_of[j] >= 0 ? -1 - r->basis.row_of[j] : c->count++;
    assert(c->count == r->a->n - r->basis.rows);
    for (int i = 0; i < r->basis.rows; i++)
        fmpz_lcm(c->den, c->den, pivot_of(&r->basis, i));
}

static void coordinates_clear(struct coordinates *c)
{
    free(c->place);
    fmpz_clear(c->den);
}

/* factor * row into row q of out, where the pivot variables of the basis do not count. */
static void add_coordinates(const struct coordinates *c, int n, const struct exact_row *row, const fmpz_t factor, fmpz_mat_t out, int q)
{
    for (int k = 0; k < row->entries; k++) {
        int at = row->col[k] < n ? c->place[row->col[k]] : c->count + row->col[k] - n;
        if (at >= 0)
            fmpz_addmul(fmpz_mat_entry(out, q, at), row->value + k, factor);
    }
}

/* b in coordinates, times c->den, into row q of out. */
static void in_coordinates(const struct coordinates *c, int n, const struct exact_row *b, fmpz_mat_t out, int q)
{
    SGA_ENDS(fmpz_end) fmpz_t f = { 0 };
    add_coordinates(c, n, b, c->den, out, q);
    for (int k = 0; k < b->entries && b->col[k] < n; k++) {
        int i = -1 - c->place[b->col[k]];
        if (i < 0)
            continue;
        fmpz_divexact(f, c->den, pivot_of(c->basis, i));
        fmpz_mul(f, f, b->value + k);
        fmpz_neg(f, f);
        add_coordinates(c, n, c->basis->row + i, f, out, q);
    }
}

/* Row q of m over den as an expression. */
static expr_id written(const struct affine_run *r, const struct coordinates *c, const fmpz_mat_t m, int q, const fmpz_t den)
{
    SGA_ENDS(exact_row_clear) struct exact_row row = { 0 };
    SGA_ENDS(fmpz_end) fmpz_t g, d = { 0 };
    fmpz_init_set(g, den);
    for (int j = 0; j < r->a->n; j++)
        if (c->place[j] >= 0)
            exact_row_push(&row, j, fmpz_mat_entry(m, q, c->place[j]));
    for (int k = 0; k < c->atoms; k++)
        exact_row_push(&row, r->a->n + k, fmpz_mat_entry(m, q, c->count + k));
    exact_row_content(g, &row);
    if (fmpz_sgn(den) < 0)
        fmpz_neg(g, g);
    exact_row_divide(&row, g);
    fmpz_divexact(d, den, g);
    expr_id e = affine_expression(r->a, &row);
    struct expr_store *st = r->s->st;
    SGA_ENDS(fmpq_end) fmpq_t q_ = { { 0, 1 } };
    fmpq_set_fmpz(q_, d);
    e = fmpz_is_one(d) ? e : expr_div(st, e, expr_fmpq(st, q_));
    return e;
}

/* Field and, where they are wanted, gauge fields: S v = right sides, solved for all at once. */
static bool fields_written_out(struct affine_run *r, bool gauge)
{
    const struct exact_echelon *e = &r->velocities;
    struct sga_solution *sol = r->s->sol;
    SGA_ENDS(coordinates_clear) struct coordinates c;
    bool ok = true;
    coordinates_make(&c, r);
    int n = r->a->n, width = c.count + c.atoms, all = width + (gauge ? sol->free_columns : 0);
    SGA_ENDS(fmpz_mat_end) fmpz_mat_t S, right, X;
    SGA_ENDS(fmpz_end) fmpz_t den;
    fmpz_mat_init(S, e->pivots, e->pivots);
    fmpz_mat_init(right, e->pivots, all);
    fmpz_mat_init(X, e->pivots, all);
    fmpz_init_set_ui(den, 1);
    pivot_block(r, S);
    for (int q = 0; q < e->pivots && ok; q++) {
        const struct affine_row *row = affine_source(r, e->pivot[q].row);
        in_coordinates(&c, n, &row->b, right, q);
        for (int f = 0; width + f < all; f++)
            for (int k = 0; k < row->a.entries; k++)
                if (row->a.col[k] == sol->free_column[f])
                    fmpz_neg(fmpz_mat_entry(right, q, width + f), row->a.value + k);
    }
    ok = ok && (!e->pivots || fmpz_mat_solve(X, den, S, right));
    SGA_ENDS(fmpq_end) fmpq_t v = { { 0, 1 } };
    for (int q = 0; q < e->pivots && ok; q++)
        for (int f = 0; width + f < all; f++) {
            fmpq_set_fmpz_frac(v, fmpz_mat_entry(X, q, width + f), den);
            sol->gauge[(size_t)f * (size_t)n + (size_t)e->pivot[q].col] = expr_fmpq(r->s->st, v);
        }
    fmpz_mul(den, den, c.den);
    for (int q = 0; q < e->pivots && ok; q++)
        sol->field[e->pivot[q].col] = written(r, &c, X, q, den);
    return ok || sga_fail(r->s->err, SGA_E_INTERNAL, "a matrix of full rank modulo a prime was found singular");
}

static void gauge_fields(struct lu *l)
{
    struct sga_solution *sol = l->r->s->sol;
    int n = l->r->a->n;
    SGA_FREED fmpq *v = sga_malloc(((size_t)n + 1) * sizeof *v);
    for (int j = 0; j < n; j++)
        fmpq_init(v + j);
    for (int f = 0; f < sol->free_columns; f++) {
        for (int k = 0; k < sol->free_columns; k++)
            fmpq_set_si(v + sol->free_column[k], k == f, 1);
        gauge_by_substitution(l, v);
        for (int j = 0; j < n; j++)
            sol->gauge[(size_t)f * (size_t)n + (size_t)j] = expr_fmpq(l->r->s->st, v + j);
    }
    for (int j = 0; j < n; j++)
        fmpq_clear(v + j);
}

/* Components of gauge fields for each node that they may add, as in fields.c. */
enum { COMPONENTS = 100 };

static bool wants_gauge(const struct affine_run *r)
{
    const struct reduction_options *o = r->s->options;
    double components = (double)r->s->sol->free_columns * r->a->n;
    return o->gauge_fields && components > 0 && (!o->gauge_nodes || components <= (double)COMPONENTS * o->gauge_nodes);
}

/* A single point that does not move. */
static bool at_rest(const struct affine_run *r)
{
    bool rest = r->constraints == r->a->n;
    for (int i = 0; i < r->constraints && rest; i++)
        rest = !r->constraint[i]->tangency.b.entries;
    return rest;
}

bool affine_fields(struct affine_run *r)
{
    assert(!r->s->inconsistent && r->velocities.pivots <= r->a->n);
    struct sga_solution *sol = r->s->sol;
    int n = r->a->n;
    sol->free_column = sga_malloc(((size_t)n + 1) * sizeof *sol->free_column);
    for (int j = 0; j < n; j++)
        if (r->velocities.pivot_of[j] < 0)
            sol->free_column[sol->free_columns++] = j;
    assert(sol->free_columns == n - r->velocities.pivots);
    sol->field = sga_malloc(((size_t)n + 1) * sizeof *sol->field);
    for (int j = 0; j < n; j++)
        sol->field[j] = expr_int(r->s->st, 0);
    bool gauge = wants_gauge(r), ok = true;
    if (gauge) {
        sol->gauge = sga_malloc((size_t)sol->free_columns * (size_t)n * sizeof *sol->gauge);
        for (int f = 0; f < sol->free_columns; f++)
            for (int j = 0; j < n; j++)
                sol->gauge[(size_t)f * (size_t)n + (size_t)j] = expr_int(r->s->st, j == sol->free_column[f]);
    }
    if (at_rest(r))
        return true;
    SGA_ENDS(lu_clear) struct lu l;
    if (lu_make(&l, r)) {
        field_by_substitution(&l, sol->field);
        if (gauge)
            gauge_fields(&l);
    } else if (unasked(r)) {
        ok = sga_budget_ok(r->s->options->budget, r->s->err);
        free(sol->field);
        free(sol->gauge);
        sol->field = sol->gauge = NULL;
    } else if ((ok = sga_budget_ok(r->s->options->budget, r->s->err))) {
        ok = r->many ? sga_fail(r->s->err, SGA_E_LIMIT_GROWTH, "the numbers of the vector field grow too long") : fields_written_out(r, gauge);
        sol->written_out = ok;
    }
    return ok;
}
