/* Sparse elimination over node handles, with pivots decided by the oracle. */
#include "echelon.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "at_start.h"
#include "ball.h"
#include "block.h"
#include "budget.h"
#include "facts.h"
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
        free(e->block[i].matrix);
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
            *c->err = c->st->error;
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

/* Rows by length, and which rows meet a column; both lists may hold stale members. */
struct agenda {
    struct sga_arena mem;
    struct ech_row *row;
    int rows;
    unsigned char *done;
    int **bucket; int *bucket_len; size_t *bucket_cap;    /* by number of entries */
    int **meet; int *meet_len; size_t *meet_cap;          /* by column */
    int cols;
    int lowest;
    expr_id *mixed; int mixes; size_t mix_cap;            /* entries that are 0 on some sides of the set and not on others */
    bool sided;                                           /* these are asked now, on the side where the points are */
    struct at_start start;
    unsigned char *idle; size_t idle_cap;                 /* by expression: 1 it is no zero where a motion is to start, 2 it is; 0 not asked */
};

static void file_row(struct agenda *a, int i)
{
    int len = a->row[i].entries;
    assert(len <= a->cols && !a->done[i]);
    SGA_RESERVE_IN(&a->mem, a->bucket[len], a->bucket_cap[len], a->bucket_len[len] + 1);
    a->bucket[len][a->bucket_len[len]++] = i;
    if (len < a->lowest)
        a->lowest = len;
}

static void file_column(struct agenda *a, int col, int i)
{
    assert(col < a->cols);
    SGA_RESERVE_IN(&a->mem, a->meet[col], a->meet_cap[col], a->meet_len[col] + 1);
    a->meet[col][a->meet_len[col]++] = i;
}

static void agenda_init(struct agenda *a, struct ech_row *row, int rows, int cols)
{
    size_t lens = (size_t)cols + 1;
    *a = (struct agenda){ .row = row, .rows = rows, .cols = cols, .lowest = cols };
    a->done = sga_zeros(&a->mem, (size_t)rows, 1);
    a->bucket = sga_zeros(&a->mem, lens, sizeof *a->bucket);
    a->bucket_len = sga_zeros(&a->mem, lens, sizeof *a->bucket_len);
    a->bucket_cap = sga_zeros(&a->mem, lens, sizeof *a->bucket_cap);
    a->meet = sga_zeros(&a->mem, lens, sizeof *a->meet);
    a->meet_len = sga_zeros(&a->mem, lens, sizeof *a->meet_len);
    a->meet_cap = sga_zeros(&a->mem, lens, sizeof *a->meet_cap);
    for (int i = rows - 1; i >= 0; i--)
        file_row(a, i);
    for (int i = 0; i < rows; i++)
        for (int k = 0; k < row[i].entries; k++)
            file_column(a, row[i].entry[k].col, i);
}

static void agenda_clear(struct agenda *a)
{
    sga_arena_end(&a->mem);
    at_start_clear(&a->start);
}

/* Whether e, which is no zero in general, is one where a motion is to start. */
static bool is_idle(struct agenda *a, const struct ech_context *c, expr_id e)
{
    size_t had = a->idle_cap, need = (size_t)e + 1;
    if (!a->start.known)
        return false;
    SGA_RESERVE_IN(&a->mem, a->idle, a->idle_cap, need);
    if (a->idle_cap > had)
        memset(a->idle + had, 0, a->idle_cap - had);
    if (!a->idle[e])
        a->idle[e] = at_start_vanishes(&a->start, c, e) ? 2 : 1;
    return a->idle[e] == 2;
}

static bool is_mixed(const struct agenda *a, expr_id e)
{
    for (int i = 0; i < a->mixes; i++)
        if (a->mixed[i] == e)
            return true;
    return false;
}

/* The last kind of pivots; and an entry that is 0 where a motion is to start comes after those of the same rows that are not. */
enum { ANY = 6, IDLE = 1 };

/* Where pivots are to be large at a place: bits by which they may be smaller there at no cost, what each one more costs, and from how many on they
 * come after all others, of longer rows too. */
enum { FAINT_FREE = 3, FAINT_BIT = 2, FAINT = 9, LAST = 1000000 };

/* Constants first, then what never vanishes, then parameters, then the rest. */
static int kind_of(const struct ech_context *c, expr_id e)
{
    unsigned f = expr_facts_of(c->facts, c->st, e);
    if (expr_is_const(c->st, e))
        return expr_is_one(c->st, e) || expr_is_int(c->st, e, -1) ? 0 : 1;
    if (!(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
        return 2;
    return f & EXPR_NONZERO ? 3 : ANY;
}

/* Numbers much smaller than others of a long row are no pivots: marching through a discrete Laplacian by its
 * neighbours (1 beside -4) multiplies errors by 5.8 in each row of the grid. Below which magnitude. */
enum { LONG_ROW = 4 };
#define MUCH_SMALLER 1.5       /* bits */

static double least_pivot(const struct ech_context *c, const struct ech_row *r)
{
    double most = -INFINITY;
    for (int k = 0; k < r->entries && r->entries >= LONG_ROW; k++)
        if (expr_is_const(c->st, r->entry[k].value))
            most = fmax(most, points_oracle_magnitude(c->oracle, r->entry[k].value));
    return most - MUCH_SMALLER;
}

/* What an entry that is no constant costs where a motion is to start, or is. */
static double faint_cost(struct agenda *a, const struct ech_context *c, expr_id e)
{
    if (!c->near_pivots)
        return is_idle(a, c, e) ? IDLE : 0;
    double bits = at_start_faintness(&a->start, c, e);
    return bits >= FAINT ? LAST + bits : FAINT_BIT * fmax(0, bits - FAINT_FREE);
}

/* The best pivot among a few of the shortest rows. False: no rows are left. */
static bool choose(struct agenda *a, const struct ech_context *c, int *out_row, int *out_at)
{
    int len = a->lowest, seen = 0, shortest = a->cols + 1;
    double best = INFINITY;
    for (; len <= a->cols && best >= LAST; len++) {
        int kept = 0;
        for (int q = 0; q < a->bucket_len[len]; q++) {     /* drop stale members */
            int i = a->bucket[len][q];
            if (!a->done[i] && a->row[i].entries == len)
                a->bucket[len][kept++] = i;
        }
        a->bucket_len[len] = kept;
        shortest = kept && shortest > a->cols ? len : shortest;
        a->lowest = !c->near_pivots ? kept ? len : len + 1 : shortest < len ? shortest : kept ? len : len + 1;
        for (int q = kept - 1; q >= 0 && (seen < 6 || best >= LAST); q--, seen++) {
            int i = a->bucket[len][q];
            if (len == 0) {
                *out_row = i;
                *out_at = -1;
                return true;
            }
            double least = least_pivot(c, a->row + i);
            for (int k = 0; k < len; k++) {
                if (!a->sided && is_mixed(a, a->row[i].entry[k].value))
                    continue;
                double fill = 4.0 * (len - 1) * (a->meet_len[a->row[i].entry[k].col] - 1);
                double size = points_oracle_magnitude(c->oracle, a->row[i].entry[k].value);
                int kind = kind_of(c, a->row[i].entry[k].value);
                double score = fill + 2 * kind - 1e-3 * fmin(200, fmax(-200, size));
                if (kind == ANY)
                    score += faint_cost(a, c, a->row[i].entry[k].value);
                if (score < best && !(size < least && expr_is_const(c->st, a->row[i].entry[k].value))) {
                    best = score;
                    *out_row = i;
                    *out_at = k;
                }
            }
        }
    }
    return best < INFINITY;
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
    a->done[i] = 1;
    for (int q = 0; q < a->meet_len[col]; q++) {
        int r = a->meet[col][q], filled = 0;
        if (a->done[r] || find(a->row + r, col) < 0)
            continue;
        if (!subtract(e, c, a->row + r, index, &filled))
            return false;
        for (int k = 0; k < filled; k++)
            file_column(a, e->touched[k], r);
        file_row(a, r);
    }
    return true;
}

/* Where every row that is left is long, the rest is a dense block. Blocks of numbers are
 * better eliminated: their entries stay numbers. */
enum { BLOCK_LENGTH = 8, BLOCK_ROWS = 8 };

static bool is_block(const struct agenda *a, const struct ech_context *c, int i)
{
    if (a->row[i].entries < BLOCK_LENGTH)
        return false;
    int left = 0;
    long entries = 0, functions = 0;
    for (int r = 0; r < a->rows; r++)
        if (!a->done[r] && a->row[r].entries) {
            left++;
            entries += a->row[r].entries;
            for (int k = 0; k < a->row[r].entries; k++)
                functions += !expr_is_const(c->st, a->row[r].entry[k].value);
        }
    return left >= BLOCK_ROWS && entries >= (long)left * BLOCK_LENGTH && 4 * functions >= entries;
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
            a->done[index[k]] = 1;      /* it became a pivot row */
        else
            file_row(a, index[k]);
        for (int q = 0; q < r->entries; q++)
            file_column(a, r->entry[q].col, index[k]);
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
    agenda_init(&a, row, rows, e->cols);
    at_start_init(&a.start, c);
    bool ok = true, blocks = true;
    int i = 0, at = -1;
    while (ok) {
        if (!choose(&a, c, &i, &at)) {
            if (a.sided || !a.mixes)
                break;
            a.sided = true;           /* nothing else is left: what holds on this side, which is said */
            a.lowest = 0;
            continue;
        }
        if (at >= 0 && blocks && is_block(&a, c, i)) {
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
                file_row(&a, i);
            }
        } else {
            int z = drops(c, row[i].rhs);      /* 0 on one side only: whether it is on the set of the others, its admission tells */
            ok = z >= 0;
            if (z == 1) {
                row[i].rest = row[i].rhs;
                row[i].rhs = expr_int(c->st, 0);
            }
            a.done[i] = 1;
        }
    }
    assert(!ok || ech_sane(e));
    return ok;
}
