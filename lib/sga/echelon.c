/* Sparse elimination over node handles, with pivots decided by the oracle. */
#include "echelon.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "agenda.h"
#include "arena.h"
#include "ball.h"
#include "block.h"
#include "budget.h"
#include "error.h"
#include "expr_rows.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "print.h"
#include "system.h"

void ech_init(struct echelon *e, int cols)
{
    *e = (struct echelon){ .cols = cols };
    e->pivot_of = sga_malloc((size_t)cols * sizeof *e->pivot_of);
    for (int i = 0; i < cols; i++)
        e->pivot_of[i] = -1;
    e->work = sga_calloc((size_t)cols, sizeof *e->work);
    e->mark = sga_calloc((size_t)cols, 1);
    e->touched = sga_malloc((size_t)cols * sizeof *e->touched);
}

void ech_row_clear(struct ech_row *r)
{
    free(r->entry);
    free(r->op);
    *r = (struct ech_row){ 0 };
}

void ech_clear(struct echelon *e)
{
    for (int i = 0; i < e->pivots; i++)
        ech_row_clear(&e->pivot[i].row);
    for (int i = 0; i < e->blocks; i++)
        expr_rows_clear(&e->block[i].matrix);
    free(e->block);
    free(e->pivot);
    free(e->pivot_of);
    free(e->work);
    free(e->mark);
    free(e->touched);
    *e = (struct echelon){ 0 };
}

void ech_row_push(struct ech_row *r, int col, expr_id value)
{
    assert(col >= 0);
    SGA_RESERVE(r->entry, r->cap, r->entries + 1);
    r->entry[r->entries++] = (struct sys_entry){ col, value };
}

static bool may_ask(const struct ech_context *c, expr_id e)
{
    if (!e || !expr_store_ok(c->st)) {
        if (c->err->code == SGA_E_OK)
            *c->err = *c->st->error;
        return false;
    }
    return sga_budget_ok(c->budget, c->err);
}

/* The first part of e that has no value at a point that was found; or EXPR_UNDEF. */
static expr_id without_value(const struct ech_context *c, expr_id e)
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    expr_id first = EXPR_UNDEF;
    expr_cone_init(&cone);
    expr_cone_of(c->st, &cone, &e, 1);
    for (int k = 0; k < c->oracle->reals && !first; k++) {
        struct num_ball *b = &c->oracle->real[k].ball;
        num_ball_list(b, cone.list, cone.count);
        for (int i = 0; i < cone.count && !first; i++)
            first = arb_is_finite(num_ball_value(b, cone.list[i])) ? EXPR_UNDEF : cone.list[i];
        num_ball_forget(b);
    }
    return first;
}

static void undecided(const struct ech_context *c, expr_id e, const char *text)
{
    expr_id part = without_value(c, e);
    SGA_FREED char *why = part ? expr_text(c->st, part, 300) : NULL;
    if (why)
        sga_fail(c->err, SGA_E_UNDECIDED, "could not decide whether %s is zero on the constraint set: %s has no value at a point that was "
                 "found there; give trajectory.initial where all equations have values, if they have anywhere", text, why);
    else
        sga_fail(c->err, SGA_E_UNDECIDED, "could not decide whether %s is zero on the constraint set", text);
}

static int told(const struct ech_context *c, expr_id e, struct points_decision d)
{
    if (d.truth != POINTS_UNKNOWN)
        return d.truth == POINTS_ZERO;
    SGA_FREED char *text = expr_text(c->st, e, 300);
    if (d.basis == POINTS_IS_SPLIT)
        sga_fail(c->err, SGA_E_SPLIT, "the constraint set has several branches: %s vanishes on some and not on others; "
                 "give trajectory.initial on the branch that is meant", text);
    else
        undecided(c, e, text);
    return -1;
}

int ech_zero(const struct ech_context *c, expr_id e)
{
    return may_ask(c, e) ? told(c, e, points_oracle_zero(c->oracle, e)) : -1;
}

/* Of an entry, or a right side: 1 it is 0 and may be dropped. One that is 0 here, and not beyond a surface that the set reaches, stays. */
static int drops(const struct ech_context *c, expr_id e)
{
    bool mixed = false;
    if (!may_ask(c, e))
        return -1;
    int z = told(c, e, points_oracle_cells(c->oracle, e, false, false, &mixed));
    return mixed ? 0 : z;
}

static void record(const struct ech_context *c, struct ech_row *r, int pivot, expr_id factor)
{
    if (!c->record)
        return;
    SGA_RESERVE(r->op, r->op_cap, r->ops + 1);
    r->op[r->ops++] = (struct ech_op){ pivot, factor };
}

static int find(const struct ech_row *r, int col)
{
    for (int k = 0; k < r->entries; k++)
        if (r->entry[k].col == col)
            return k;
    return -1;
}

/* row -= factor * pivot row, the pivot column leaving the row. *filled counts columns
 * that are new in the row; they are listed in e->touched. -1: undecided. */
static bool subtract(struct echelon *e, const struct ech_context *c, struct ech_row *r, int pivot, int *filled)
{
    const struct ech_pivot *p = e->pivot + pivot;
    int at = find(r, p->col), fresh = 0;
    assert(at >= 0);
    expr_id f = expr_div(c->st, r->entry[at].value, p->value);
    bool ok = true;
    r->entry[at] = r->entry[--r->entries];
    for (int k = 0; k < r->entries; k++) {
        e->work[r->entry[k].col] = r->entry[k].value;
        e->mark[r->entry[k].col] = 1;
    }
    for (int k = 0; k < p->row.entries && ok; k++) {
        int col = p->row.entry[k].col;
        if (col == p->col)
            continue;
        expr_id t = expr_mul(c->st, f, p->row.entry[k].value);
        if (e->mark[col]) {
            e->work[col] = expr_sub(c->st, e->work[col], t);
            int z = drops(c, e->work[col]);
            ok = z >= 0;
            if (z == 1)
                e->work[col] = EXPR_UNDEF;
        } else {
            e->work[col] = expr_neg(c->st, t);
            e->mark[col] = 1;
            ech_row_push(r, col, e->work[col]);
            e->touched[fresh++] = col;
        }
    }
    int n = 0;
    for (int k = 0; k < r->entries; k++) {
        int col = r->entry[k].col;
        if (e->work[col])
            r->entry[n++] = (struct sys_entry){ col, e->work[col] };
        e->work[col] = EXPR_UNDEF;
        e->mark[col] = 0;
    }
    r->entries = n;
    assert(r->entries >= 0 && find(r, p->col) < 0);
    r->rhs = expr_sub(c->st, r->rhs, expr_mul(c->st, f, p->row.rhs));
    record(c, r, pivot, f);
    *filled = fresh;
    return ok && expr_store_ok(c->st);
}

/* Drop entries that are zero on the present set, then use up the pivots so far. */
static bool reduce(struct echelon *e, const struct ech_context *c, struct ech_row *r)
{
    int n = 0;
    for (int k = 0; k < r->entries; k++) {
        int z = drops(c, r->entry[k].value);
        if (z < 0)
            return false;
        if (z == 0)
            r->entry[n++] = r->entry[k];
    }
    r->entries = n;
    for (;;) {
        int first = -1, filled;
        for (int k = 0; k < r->entries; k++) {
            int p = e->pivot_of[r->entry[k].col];
            if (p >= 0 && (first < 0 || p < first))
                first = p;
        }
        if (first < 0)
            return true;
        if (!subtract(e, c, r, first, &filled))
            return false;
    }
}

/* Give row i the pivot at entry `at`, and clear its column from the other rows. */
static bool take(struct echelon *e, const struct ech_context *c, struct agenda *a, int i, int at, int generation)
{
    int col = a->row[i].entry[at].col, index = e->pivots;
    assert(e->pivot_of[col] < 0);
    SGA_RESERVE(e->pivot, e->pivot_cap, e->pivots + 1);
    e->pivot[e->pivots++] = (struct ech_pivot){ col, a->row[i].entry[at].value, generation, a->row[i] };
    e->pivot_of[col] = index;
    a->row[i] = (struct ech_row){ 0 };
    agenda_done(a, i);
    for (int q = 0; q < a->meet_len[col]; q++) {
        int r = a->meet[col][q], filled = 0;
        if (a->done[r] || find(a->row + r, col) < 0)
            continue;
        if (!subtract(e, c, a->row + r, index, &filled))
            return false;
        for (int k = 0; k < filled; k++)
            agenda_file_column(a, e->touched[k], r);
        agenda_file_row(a, r);
    }
    return true;
}

/* Hand the rest over, and file what is left of it anew. */
static bool solve_block(struct echelon *e, const struct ech_context *c, struct agenda *a, int generation)
{
    SGA_FREED int *index = sga_malloc((size_t)a->rows * sizeof *index);
    int m = 0;
    for (int r = 0; r < a->rows; r++)
        if (!a->done[r] && a->row[r].entries)
            index[m++] = r;
    bool ok = ech_block(e, c, a->row, index, m, generation);
    for (int k = 0; k < m; k++) {
        struct ech_row *r = a->row + index[k];
        if (!r->rhs)
            agenda_done(a, index[k]);   /* it became a pivot row */
        else
            agenda_file_row(a, index[k]);
        for (int q = 0; q < r->entries; q++)
            agenda_file_column(a, r->entry[q].col, index[k]);
    }
    return ok;
}

/* The entry that was chosen for a pivot: 0 it is none where the points are not, 1 it is 0, 2 it depends on the side and is
 * left until nothing else is. */
static int judge(struct agenda *a, const struct ech_context *c, expr_id e)
{
    bool mixed = false;
    if (!may_ask(c, e))
        return -1;
    int z = told(c, e, points_oracle_cells(c->oracle, e, true, a->sided, &mixed));
    if (z < 0 || !mixed || a->sided)
        return z;
    SGA_RESERVE_IN(&a->mem, a->mixed, a->mix_cap, a->mixes + 1);
    a->mixed[a->mixes++] = e;
    return 2;
}

bool ech_sane(const struct echelon *e)
{
    bool sane = e->pivots <= e->cols;
    for (int q = 0; q < e->pivots && sane; q++)
        sane = e->pivot_of[e->pivot[q].col] == q && e->pivot[q].row.entries > 0 && e->pivot[q].value;
    for (int b = 0; b < e->blocks && sane; b++)
        sane = e->block[b].first >= 0 && e->block[b].first + e->block[b].size <= e->pivots;
    return sane;
}

bool ech_eliminate(struct echelon *e, const struct ech_context *c, struct ech_row *row, int rows, int generation)
{
    assert(ech_sane(e));
    for (int i = 0; i < rows; i++)
        if (!reduce(e, c, row + i) || !sga_budget_ok(c->budget, c->err))
            return false;
    SGA_ENDS(agenda_clear) struct agenda a;
    agenda_init(&a, c, row, rows, e->cols);
    bool ok = true, blocks = true;
    int i = 0, at = -1;
    while (ok) {
        if (!agenda_choose(&a, &i, &at)) {
            if (a.sided || !a.mixes)
                break;
            a.sided = true;           /* nothing else is left: what holds on this side, which is said */
            a.lowest = 0;
            continue;
        }
        if (at >= 0 && blocks && agenda_is_block(&a, i, at)) {
            int before = e->pivots;
            ok = solve_block(e, c, &a, generation) && sga_budget_ok(c->budget, c->err);
            blocks = e->pivots > before;
            continue;
        }
        if (at >= 0) {
            int z = judge(&a, c, row[i].entry[at].value);
            ok = z >= 0;
            if (z == 0) {
                ok = take(e, c, &a, i, at, generation) && sga_budget_ok(c->budget, c->err);
            } else if (z == 1) {
                row[i].entry[at] = row[i].entry[--row[i].entries];
                agenda_file_row(&a, i);
            }
        } else {
            int z = drops(c, row[i].rhs);      /* 0 on one side only: whether it is on the set of the others, its admission tells */
            ok = z >= 0;
            if (z == 1) {
                row[i].rest = row[i].rhs;
                row[i].rhs = expr_int(c->st, 0);
            }
            agenda_done(&a, i);
        }
    }
    assert(!ok || ech_sane(e));
    return ok;
}
