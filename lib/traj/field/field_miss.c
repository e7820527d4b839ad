/* By how much velocities miss the rows that define the field, and whether that is what roundings make of them. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "field.h"
#include "jacobian.h"
#include "larger.h"
#include "mem.h"
#include "switches.h"
#include "system.h"
#include "tape.h"

/* |entry| where it multiplies v_j in natural units. */
static double entry_size(const struct field *f, double entry, int j)
{
    return fabs(entry) * (f->unit ? f->unit[j] : 1);
}

/* A row without derivatives, missed by more than this in units of 1, is held against what its terms are: the largest change of its value as one variable
 * changes by its size. (x^2 + y^2 = L^2 with L = 1e6 is met no better than 1e-4.) */
static const double MISSED = 1e-10;

/* Slopes of right sides at in, by row (of alpha_slope). False: there are none (sides of switches are held). Cost: two tapes where it is asked for first. */
static bool slopes(struct field *f)
{
    if (f->switches->count)
        return false;
    if (!f->alpha_value) {
        struct sga_error ignored = { 0 };
        SGA_FREED int *inputs = field_inputs(f->sys);
        SGA_FREED expr_id *root = sga_malloc(((size_t)f->rows + 1) * sizeof *root);
        for (int i = 0; i < f->rows; i++)
            root[i] = f->sys->row[i].alpha;
        f->alpha = num_tape_new(f->sys->store, root, f->rows, inputs, f->n + 1, &ignored);
        f->alpha_slope = f->alpha ? num_jacobian_new(f->alpha, NULL, 0) : NULL;
        f->alpha_value = sga_malloc(((size_t)(f->alpha_slope ? f->alpha_slope->nnz : 0) + 1) * sizeof *f->alpha_value);
    }
    if (f->alpha_slope)
        num_jacobian_eval(f->alpha_slope, f->in, NULL, f->alpha_value);
    return f->alpha_slope;
}

/* The largest change of row i's right side by one variable, by a difference quotient; general_out stays. Cost: two evaluations. */
static double change_by(struct field *f, int alpha, int j)
{
    const double part = 1e-6;
    double value = f->general_out[alpha], x = f->in[j], change = 0;
    f->in[j] = x + part * (fabs(x) + (f->unit ? f->unit[j] : 1));
    if (field_general_values(f) && isfinite(f->general_out[alpha]))
        change = fabs(f->general_out[alpha] - value) / part;
    f->in[j] = x;
    field_general_values(f);
    return change;
}

/* That change by all of them, from slopes where these have values. */
static double terms_size(struct field *f, int row, int alpha, bool sloped)
{
    double big = 0;
    for (int k = sloped ? f->alpha_slope->start[row] : 0; sloped && k < f->alpha_slope->start[row + 1]; k++) {
        int j = f->alpha_slope->col[k];
        double change = j < f->n ? fabs(f->alpha_value[k]) * (fabs(f->in[j]) + (f->unit ? f->unit[j] : 1)) : 0;
        big = sga_larger(big, isfinite(change) ? change : change_by(f, alpha, j));
    }
    if (sloped)
        return big;
    struct expr_cone cone;
    expr_cone_init(&cone);
    for (int j = 0; j < f->n; j++)
        if (expr_depends(f->sys->store, &cone, f->sys->row[row].alpha, f->sys->variable[j].symbol))
            big = sga_larger(big, change_by(f, alpha, j));
    expr_cone_clear(&cone);
    return big;
}

double field_rows_miss(struct field *f, const double *v, int *worst_row)
{
    double worst = 0;
    int at = 0, sloped = -1;       /* not looked */
    if (!field_general_values(f) || !num_jacobian_eval(f->jac, f->in, NULL, f->jac_value))
        return INFINITY;
    for (int i = 0; i < f->rows + f->c + f->rates; i++) {
        double sum = 0, big = 0;
        if (i < f->rows) {
            const struct sys_row *r = f->sys->row + i;
            for (int k = 0; k < r->entries; k++, at++) {
                sum += f->general_out[at] * v[r->entry[k].col];
                big = sga_larger(big, entry_size(f, f->general_out[at], r->entry[k].col));
            }
            sum -= f->general_out[at];
            if (!r->entries && fabs(sum) > MISSED) {
                sloped = sloped < 0 ? slopes(f) : sloped;
                big = sga_larger(1, terms_size(f, i, at, sloped));
            }
            at++;
        } else if (i < f->rows + f->c) {
            int c = i - f->rows;
            for (int k = f->jac->start[c]; k < f->jac->start[c + 1]; k++) {
                bool time = f->jac->col[k] == f->n;
                sum += f->jac_value[k] * (time ? 1 : v[f->jac->col[k]]);
                big = time ? big : sga_larger(big, entry_size(f, f->jac_value[k], f->jac->col[k]));
            }
        } else {
            int j = f->rate[i - f->rows - f->c].variable;
            sum = v[j] - f->general_out[at++];
            big = entry_size(f, 1, j);
        }
        sum = fabs(sum) / (big > 0 ? big : 1);
        if (sum > worst) {
            worst = sum;
            *worst_row = i;
        }
    }
    return worst;
}

/* What roundings make of a row's terms, relative to these; and entries of a constraint that are not small beside its largest, in natural units. */
static const double ROUNDINGS = 1e-12, LARGE_ENTRY = 1e-3;
enum { TURNS = 2 };            /* a constraint, and another that shares a rate with it */

/* Rates that a constraint ties together take part in each other's roundings: as they are before, whatever the order of constraints. */
static void tie(const struct field *f, double *terms)
{
    SGA_FREED double *before = sga_malloc(((size_t)f->n + 1) * sizeof *before);
    memcpy(before, terms, (size_t)f->n * sizeof *before);
    for (int c = 0; c < f->c; c++) {
        double size = 0, off = 0;
        for (int k = f->jac->start[c]; k < f->jac->start[c + 1]; k++) {
            int j = f->jac->col[k];
            size = j < f->n ? sga_larger(size, entry_size(f, f->jac_value[k], j)) : size;
            off = j < f->n ? sga_larger(off, fabs(f->jac_value[k]) * before[j]) : off;
        }
        for (int k = f->jac->start[c]; k < f->jac->start[c + 1]; k++) {
            int j = f->jac->col[k];
            if (j < f->n && entry_size(f, f->jac_value[k], j) > LARGE_ENTRY * size)
                terms[j] = sga_larger(terms[j], off / fabs(f->jac_value[k]));
        }
    }
}

/* By variable: the largest term of a row for its derivative, over the entry there. */
static double *rate_terms(struct field *f, double *of_row)
{
    double *terms = sga_calloc((size_t)f->n + 1, sizeof *terms);
    bool sloped = slopes(f);
    for (int i = 0, at = 0; i < f->rows; i++, at++) {
        const struct sys_row *r = f->sys->row + i;
        int alpha = at + r->entries;
        of_row[i] = terms_size(f, i, alpha, sloped);
        for (int k = 0; k < r->entries; k++, at++)
            if (f->general_out[at] != 0)
                terms[r->entry[k].col] = sga_larger(terms[r->entry[k].col], of_row[i] / fabs(f->general_out[at]));
    }
    for (int turn = 0; turn < TURNS; turn++)
        tie(f, terms);
    return terms;
}

bool field_rows_rounded(struct field *f, const double *v, double miss)
{
    if (!field_general_values(f) || !num_jacobian_eval(f->jac, f->in, NULL, f->jac_value))
        return false;
    SGA_FREED double *of_row = sga_calloc((size_t)f->rows + 1, sizeof *of_row);
    SGA_FREED double *rate = rate_terms(f, of_row);
    bool ok = true;
    for (int i = 0, at = 0; i < f->rows && ok; i++, at++) {
        const struct sys_row *r = f->sys->row + i;
        double sum = 0, big = 0, terms = of_row[i];
        for (int k = 0; k < r->entries; k++, at++) {
            sum += f->general_out[at] * v[r->entry[k].col];
            terms += fabs(f->general_out[at]) * (fabs(v[r->entry[k].col]) + rate[r->entry[k].col]);
            big = sga_larger(big, entry_size(f, f->general_out[at], r->entry[k].col));
        }
        sum = fabs(sum - f->general_out[at]);
        ok = sum <= miss * (r->entries ? big : 1) || sum <= ROUNDINGS * terms;
    }
    for (int c = 0; c < f->c && ok; c++) {
        double sum = 0, big = 0, terms = 0;
        for (int k = f->jac->start[c]; k < f->jac->start[c + 1]; k++) {
            int j = f->jac->col[k];
            bool time = j == f->n;
            sum += f->jac_value[k] * (time ? 1 : v[j]);
            terms += fabs(f->jac_value[k]) * (time ? 1 : fabs(v[j]) + rate[j]);
            big = time ? big : sga_larger(big, entry_size(f, f->jac_value[k], j));
        }
        ok = fabs(sum) <= miss * big || fabs(sum) <= ROUNDINGS * terms;
    }
    return ok;
}
