/* The sparse system of velocities, and the equations for implicit steps; see the header. */
#include "whole.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "field.h"
#include "jacobian.h"
#include "larger.h"
#include "lin_lu.h"
#include "lin_sparse.h"
#include "mem.h"
#include "ode.h"
#include "system.h"
#include "tape.h"

/* Below this reciprocal condition the start is left to the dense way, which tells ranks. */
static const double REGULAR = 1e-20;
enum { STEPS = 8 };
/* Of each variable or its unit: corrections that are rounding. */
static const double ROUNDING = 1e-14;

struct whole {
    struct field *f;
    int n, c, rows;                /* rows that have derivatives */
    int *row;
    struct lin_lu *lu;
    int sign;                      /* of its determinant where the motion is; 0: not known yet */
    struct lin_sparse *B;          /* [A; d xi] */
    struct num_tape *tape;         /* roots: by row the entries of A and alpha, then the constraints */
    struct num_jacobian *jac;      /* of it by variables and time */
    double *out, *slope, *at, *d;
    int *place;                    /* by row, then by constraint: its row in the pattern */
    struct lin_sparse *pattern;    /* of mass and slope */
    int *mass_place, *slope_place; /* by entry of A; by entry of jac (-1: time) */
    struct ode_implicit equations;
};

void whole_free(struct whole *w)
{
    if (!w)
        return;
    lin_lu_free(w->lu);
    lin_sparse_free(w->B);
    lin_sparse_free(w->pattern);
    num_jacobian_free(w->jac);
    num_tape_free(w->tape);
    free(w->row);
    free(w->place);
    free(w->out);
    free(w->mass_place);
    free(w);
}

/* [A; d xi], its entries in the order of field_rows.c where rows without derivatives have none. */
static void velocities_pattern(struct whole *w)
{
    const struct field *f = w->f;
    int most = f->jac->nnz, at = 0;
    for (int i = 0; i < w->rows; i++)
        most += f->sys->row[w->row[i]].entries;
    int *ptr = sga_calloc((size_t)w->n + 1, sizeof *ptr), *col = sga_malloc(((size_t)most + 1) * sizeof *col);
    for (int i = 0; i < w->rows; i++) {
        const struct sys_row *r = f->sys->row + w->row[i];
        for (int k = 0; k < r->entries; k++)
            col[at++] = r->entry[k].col;
        ptr[i + 1] = at;
    }
    for (int i = 0; i < w->c; i++) {
        for (int k = f->jac->start[i]; k < f->jac->start[i + 1]; k++)
            if (f->jac->col[k] < w->n)
                col[at++] = f->jac->col[k];
        ptr[w->rows + i + 1] = at;
    }
    w->B = lin_sparse_new(w->n, w->n, ptr, col);
    w->lu = lin_lu_new(w->B);
    free(ptr);
    free(col);
}

static bool make_tape(struct whole *w, const expr_id *constraint)
{
    const struct field *f = w->f;
    struct sga_error ignored = { 0 };
    int roots = w->c, at = 0;
    for (int i = 0; i < w->rows; i++)
        roots += f->sys->row[w->row[i]].entries + 1;
    expr_id *root = sga_malloc(((size_t)roots + 1) * sizeof *root);
    for (int i = 0; i < w->rows; i++) {
        const struct sys_row *r = f->sys->row + w->row[i];
        for (int k = 0; k < r->entries; k++)
            root[at++] = r->entry[k].value;
        root[at++] = r->alpha;
    }
    for (int i = 0; i < w->c; i++)
        root[at++] = constraint[i];
    int *inputs = field_inputs(f->sys);
    w->tape = num_tape_new(f->sys->store, root, roots, inputs, w->n + 1, &ignored);
    w->jac = w->tape ? num_jacobian_new(w->tape, NULL, 0) : NULL;
    free(inputs);
    free(root);
    return w->jac;
}

/* An equation and a variable that it may be placed at. */
struct pair { double weight; int row, col; };

static int heavier_first(const void *a, const void *b)
{
    const struct pair *p = a, *q = b;
    if (p->weight != q->weight)
        return p->weight > q->weight ? -1 : 1;
    return p->row != q->row ? p->row - q->row : p->col - q->col;
}

/* Entries of the tape's roots [from, to): the columns that are free, weighed by their part of the largest. */
static int add_pairs(const struct whole *w, const double *x, int row, int from, int to, const bool *taken, struct pair *pair)
{
    int count = 0;
    double most = 0;
    for (int k = w->jac->start[from]; k < w->jac->start[to]; k++) {
        int col = w->jac->col[k];
        if (col == w->n || taken[col])
            continue;
        double weight = fabs(w->slope[k]) * fmax(fabs(x[col]), w->f->unit ? w->f->unit[col] : 1);
        pair[count++] = (struct pair){ isfinite(weight) ? weight : 0, row, col };
        most = sga_larger(most, pair[count - 1].weight);
    }
    for (int k = 0; k < count && most > 0; k++)
        pair[k].weight /= most;
    return count;
}

/* Each equation is placed at a variable: one with derivatives at one of those, a constraint where its slope at the start is the
 * largest. So the pattern is about as symmetric as the couplings are and the diagonal is large, and orderings for symmetric patterns
 * fill least with no pivots beside it. What finds no place so gets any that is left. */
static void place_rows(struct whole *w, double t, const double *x)
{
    const struct field *f = w->f;
    bool *taken = sga_calloc((size_t)w->n + 1, sizeof *taken);
    int root = 0, count = 0, spare = 0;
    struct pair *pair = sga_malloc(((size_t)w->jac->nnz + 1) * sizeof *pair);
    w->place = sga_malloc(((size_t)w->n + 1) * sizeof *w->place);
    memcpy(w->at, x, (size_t)w->n * sizeof *x);
    w->at[w->n] = t;
    if (!num_jacobian_eval(w->jac, w->at, w->out, w->slope))
        memset(w->slope, 0, (size_t)w->jac->nnz * sizeof *w->slope);
    for (int i = 0; i < w->rows; i++) {
        const struct sys_row *r = f->sys->row + w->row[i];
        w->place[i] = -1;
        for (int k = 0; k < r->entries && w->place[i] < 0; k++)
            if (!taken[r->entry[k].col])
                taken[w->place[i] = r->entry[k].col] = true;
        root += r->entries + 1;
    }
    for (int i = 0; i < w->c; i++, root++) {
        w->place[w->rows + i] = -1;
        count += add_pairs(w, x, w->rows + i, root, root + 1, taken, pair + count);
    }
    qsort(pair, (size_t)count, sizeof *pair, heavier_first);
    for (int k = 0; k < count; k++)
        if (w->place[pair[k].row] < 0 && !taken[pair[k].col])
            taken[w->place[pair[k].row] = pair[k].col] = true;
    for (int i = 0; i < w->n; i++) {
        while (w->place[i] < 0 && taken[spare])
            spare++;
        if (w->place[i] < 0)
            taken[w->place[i] = spare] = true;
    }
    free(pair);
    free(taken);
}

/* The union of what mass and slope have, and where each entry goes. */
static void equations_pattern(struct whole *w)
{
    const struct field *f = w->f;
    int most = w->jac->nnz, at = 0, root = 0;
    for (int i = 0; i < w->rows; i++)
        most += f->sys->row[w->row[i]].entries;
    int masses = most - w->jac->nnz;
    int *row = sga_malloc(((size_t)most + 1) * sizeof *row), *col = sga_malloc(((size_t)most + 1) * sizeof *col);
    int *place = sga_malloc(((size_t)most + 1) * sizeof *place), *entry = sga_malloc(((size_t)w->jac->nnz + 1) * sizeof *entry);
    for (int i = 0; i < w->rows; i++)
        for (int k = 0; k < f->sys->row[w->row[i]].entries; k++, at++) {
            row[at] = w->place[i];
            col[at] = f->sys->row[w->row[i]].entry[k].col;
        }
    for (int i = 0; i < w->n; i++) {
        int of = i < w->rows ? f->sys->row[w->row[i]].entries + 1 : 1;
        for (int k = w->jac->start[root]; k < w->jac->start[root + of]; k++) {
            entry[k] = -1;
            if (w->jac->col[k] == w->n)
                continue;
            entry[k] = at;
            row[at] = w->place[i];
            col[at++] = w->jac->col[k];
        }
        root += of;
    }
    assert(root == num_tape_roots(w->tape));
    w->pattern = lin_sparse_from_entries(w->n, w->n, at, row, col, place);
    w->mass_place = sga_malloc(((size_t)most + 1) * sizeof *w->mass_place);
    w->slope_place = w->mass_place + masses;
    for (int k = 0; k < masses; k++)
        w->mass_place[k] = place[k];
    for (int k = 0; k < w->jac->nnz; k++)
        w->slope_place[k] = entry[k] < 0 ? -1 : place[entry[k]];
    free(row);
    free(col);
    free(place);
    free(entry);
}

struct whole *whole_new(struct field *f, double t, const double *x)
{
    struct whole *w = sga_calloc(1, sizeof *w);
    w->f = f;
    w->n = f->n;
    w->c = f->c;
    w->row = sga_malloc(((size_t)f->rows + 1) * sizeof *w->row);
    for (int i = 0; i < f->rows; i++)
        if (f->sys->row[i].entries)
            w->row[w->rows++] = i;
    if (w->rows + w->c != w->n || !make_tape(w, f->constraint)) {
        whole_free(w);
        return NULL;
    }
    velocities_pattern(w);
    size_t roots = (size_t)num_tape_roots(w->tape);
    w->out = sga_malloc((roots + (size_t)w->jac->nnz + 3 * (size_t)w->n + 2) * sizeof *w->out);
    w->slope = w->out + roots;
    w->at = w->slope + w->jac->nnz;
    w->d = w->at + w->n + 1;
    place_rows(w, t, x);
    equations_pattern(w);
    double *v = sga_malloc(((size_t)w->n + 1) * sizeof *v);
    struct whole *before = f->whole;
    int rank = 0;
    field_load(f, t, x);
    f->whole = w;
    bool ok = field_general(f, v, &rank) && rank == w->n && lin_lu_rcond(w->lu) > REGULAR;
    f->whole = before;
    free(v);
    if (ok)
        return w;
    whole_free(w);
    return NULL;
}

const struct ode_implicit *whole_equations(struct whole *w, const struct ode_implicit *by)
{
    w->equations = (struct ode_implicit){ w->pattern, by->residual, by->matrices };
    return &w->equations;
}

bool whole_velocities(struct whole *w, const double *entry, const double *right, double *v)
{
    int at = 0;
    memcpy(w->B->val, entry, (size_t)w->B->ptr[w->n] * sizeof *entry);
    for (int i = 0; i < w->rows; i++)
        v[at++] = -right[w->row[i]];
    for (int i = 0; i < w->c; i++)
        v[at++] = -right[w->f->rows + i];
    assert(at == w->n);
    double *b = memcpy(w->d, v, (size_t)w->n * sizeof *v), *rest = b + w->n;
    if (!lin_lu_factor(w->lu, w->B->val) || (w->sign && lin_lu_sign(w->lu) != w->sign))       /* beyond a zero of it the rank was lost */
        return false;
    w->sign = lin_lu_sign(w->lu);
    lin_lu_solve(w->lu, v);
    lin_sparse_times(w->B, v, rest);       /* once refined */
    for (int j = 0; j < w->n; j++)
        rest[j] = b[j] - rest[j];
    lin_lu_solve(w->lu, rest);
    for (int j = 0; j < w->n; j++)
        v[j] += rest[j];
    return lin_all_finite(w->n, v);
}

bool whole_project(struct whole *w, double t, double *x, const double *scale, double *moved, double *raw)
{
    struct field *f = w->f;
    int n = w->n, rank;
    double *old = memcpy(sga_malloc(3 * ((size_t)n + 1) * sizeof *old), x, (size_t)n * sizeof *x), *d = old + n + 1, *v = d + n + 1, last = INFINITY;
    bool ok = true, done = false;
    for (int k = 0; k < STEPS && ok && !done; k++) {
        field_load(f, t, x);
        ok = k || (field_general(f, v, &rank) && rank == n);       /* which leaves the factors here */
        field_load(f, t, x);
        ok = ok && num_tape_eval(f->con, f->in, d + w->rows);
        *raw = 0;
        for (int i = 0; i < n; i++) {
            d[i] = i < w->rows ? 0 : -d[i];
            *raw = sga_larger(*raw, fabs(d[i]));
        }
        if (!ok)
            break;
        lin_lu_solve(w->lu, d);
        double size = 0;
        for (int j = 0; j < n; j++)
            size = sga_larger(size, fabs(d[j]) / (fabs(x[j]) + (f->unit ? f->unit[j] : 1)));
        done = size <= ROUNDING || (size < 1e-11 && size > 0.1 * last);
        ok = isfinite(size) && (done || size < 0.5 * last);
        last = size;
        for (int j = 0; j < n && ok && size > 1e-16; j++)
            x[j] += d[j];
    }
    double sum = 0;
    for (int j = 0; j < n; j++)
        sum += (x[j] - old[j]) / scale[j] * ((x[j] - old[j]) / scale[j]);
    *moved = sqrt(sum);
    if (!ok || !done)
        memcpy(x, old, (size_t)n * sizeof *x);
    free(old);
    return ok && done;
}

bool whole_residual(struct whole *w, double t, const double *x, const double *v, double *r)
{
    int at = 0;
    memcpy(w->at, x, (size_t)w->n * sizeof *x);
    w->at[w->n] = t;
    if (!num_tape_eval(w->tape, w->at, w->out))
        return false;
    for (int i = 0; i < w->rows; i++) {
        const struct sys_row *row = w->f->sys->row + w->row[i];
        double sum = 0;
        for (int k = 0; k < row->entries; k++)
            sum += w->out[at++] * v[row->entry[k].col];
        r[w->place[i]] = w->out[at++] - sum;
    }
    for (int i = 0; i < w->c; i++)
        r[w->place[w->rows + i]] = -w->out[at++];
    return true;
}

bool whole_matrices(struct whole *w, double t, const double *x, const double *v, double *mass, double *slope)
{
    int root = 0, a = 0, entries = w->pattern->ptr[w->n];
    memcpy(w->at, x, (size_t)w->n * sizeof *x);
    w->at[w->n] = t;
    if (!num_jacobian_eval(w->jac, w->at, w->out, w->slope))
        return false;
    memset(mass, 0, (size_t)entries * sizeof *mass);
    memset(slope, 0, (size_t)entries * sizeof *slope);
    for (int i = 0; i < w->n; i++) {
        const struct sys_row *row = i < w->rows ? w->f->sys->row + w->row[i] : NULL;
        for (int q = 0; q <= (row ? row->entries : 0); q++, root++) {
            bool last = !row || q == row->entries;
            double factor = !row ? -1 : last ? 1 : -v[row->entry[q].col];
            if (!last)
                mass[w->mass_place[a++]] += w->out[root];
            for (int k = w->jac->start[root]; k < w->jac->start[root + 1]; k++)
                if (w->slope_place[k] >= 0)
                    slope[w->slope_place[k]] += factor * w->slope[k];
        }
    }
    assert(root == num_tape_roots(w->tape));
    return true;
}
