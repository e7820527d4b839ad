/* See endings_far.h. */
#include "endings_far.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arena.h"
#include "field.h"
#include "flow.h"
#include "jacobian.h"
#include "kinds.h"
#include "manifold.h"
#include "mem.h"
#include "ode.h"
#include "print.h"
#include "sparse.h"
#include "system.h"
#include "trajectory.h"
#include "warnings.h"

/* Of the size at the start, or the natural one. */
static const double GROWN = 1e3;
/* Of a row, what elimination leaves of one that is independent; and of what was left at the start. */
static const double INDEPENDENT = 1e-3, STAYS = 1e-2;

/* far[j]: variable j has grown so, and equations themselves determine it. Returns the one that has grown most, or -1. */
static int grown(const struct flow *f, const double *initial, const unsigned char *kind, unsigned char *far)
{
    double most = GROWN;
    int which = -1;
    for (int j = 0; j < f->n; j++) {
        double by = fabs(f->field->home[j]) / fmax(fabs(initial[j]), f->manifold->unit[j]);
        far[j] = kind[j] == SYS_ALGEBRAIC && by > GROWN;
        if (far[j] && by > most) {
            most = by;
            which = j;
        }
    }
    return which;
}

/* A row of so many entries; those with values are added by entry. */
static struct points_row row_of(int entries)
{
    size_t room = (size_t)entries + 1;
    return (struct points_row){ .col = sga_malloc(room * sizeof(int)), .val = sga_malloc(room * sizeof(double)), .cap = entries };
}

static void entry(struct points_row *r, int col, double value)
{
    r->col[r->len] = col;
    r->val[r->len++] = value;
}

/* The rank at the end of the motion of what is said of the velocities of variables that are not far: by the equations, and by the constraints on these
 * alone. -1: they have no values there. */
static int rank_of_others(struct flow *f, const unsigned char *far)
{
    struct field *field = f->field;
    struct manifold *m = f->manifold;
    memcpy(field->in, field->home, (size_t)f->n * sizeof *field->in);
    field->in[f->n] = field->home_t;
    if (manifold_residual(m, field->home_t, field->home, NULL, NULL) < 0 || !field_general_values(field))
        return -1;
    struct points_row *row = sga_calloc((size_t)(field->rows + m->c) + 1, sizeof *row);
    int rows = 0;
    for (int i = 0, at = 0; i < field->rows; i++, at++) {     /* a right side after each */
        const struct sys_row *from = f->sys->row + i;
        row[rows] = row_of(from->entries);
        for (int k = 0; k < from->entries; k++, at++)
            if (!far[from->entry[k].col])
                entry(row + rows, from->entry[k].col, field->general_out[at] * m->unit[from->entry[k].col]);
        rows++;
    }
    for (int i = 0; i < m->c; i++) {
        bool other = true;
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++)
            other &= !far[m->jac->col[k]];
        if (!other)
            continue;
        row[rows] = row_of(m->jac->start[i + 1] - m->jac->start[i]);
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1]; k++)
            entry(row + rows, m->jac->col[k], m->value[k] * m->unit[m->jac->col[k]]);
        rows++;
    }
    SGA_ENDS(points_lu_clear) struct points_lu lu;
    points_lu_factor(&lu, row, rows, f->n, INDEPENDENT);
    return lu.rank;
}

void endings_at_zero(struct flow *f, const struct traj_request *rq, int pivot, double near, struct traj_result *r)
{
    double zero = field_zero_ahead(f->field, pivot), back = rq->times[rq->samples - 1] < rq->start ? -1 : 1;
    if (fabs(zero - r->ended_t) <= near * fabs(r->ended_t - rq->start) && (!r->rows || back * (zero - r->t[r->rows - 1]) >= 0))
        r->ended_t = zero;
}

/* How long the variable may go on growing as it does at the last point. */
static double left_to_grow(struct flow *f, int which)
{
    struct field *field = f->field;
    SGA_FREED double *v = sga_malloc(2 * ((size_t)f->n + 1) * sizeof *v);
    double *home = v + f->n + 1;
    sga_copy(home, field->home, f->n);
    bool ok = field_eval(field, field->home_t, home, v);
    field_forget_trial(field);
    return ok ? ode_left_to_grow(home[which], v[which]) : 0;
}

/* The reason is that the variable grows, and the pivot (-1: none) tends to 0 with it. */
static void say_grows(struct flow *f, const struct traj_request *rq, int which, double last, int pivot, struct traj_result *r)
{
    r->ended_reason = "blow_up";
    r->stratum = false;
    snprintf(r->ended_detail, sizeof r->ended_detail, "%s grows without bound (%.3g at the last point)",
             f->sys->store->symbol[f->sys->variable[which].symbol].name, last);
    size_t before = strlen(r->ended_detail);
    if (pivot < 0) {
        r->ended_error += r->ended_error > 0 ? left_to_grow(f, which) : 0;
        return;
    }
    SGA_FREED char *zero = expr_text(f->sys->store, f->field->pivot_expr[pivot], 120);
    endings_at_zero(f, rq, pivot, ENDINGS_NEAR, r);
    snprintf(r->ended_detail + before, sizeof r->ended_detail - before, ", while %s tends to 0", zero);
}

bool endings_grows_with(struct flow *f, const struct traj_request *rq, int pivot, struct traj_result *r)
{
    int which = field_grows_with(f->field, pivot, r->initial);
    if (which >= 0)
        say_grows(f, rq, which, f->field->here[which], pivot, r);
    return which >= 0;
}

bool endings_far(struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    SGA_ARENA(mem);
    unsigned char *far = sga_zeros(&mem, 2 * (size_t)f->n + 1, 1), *kind = far + f->n;
    sys_kinds(f->sys, kind);
    int which = grown(f, r->initial, kind, far), others = f->field->generic_rank;
    for (int j = 0; j < f->n; j++)
        others -= far[j];
    if (which < 0)
        return false;
    bool stays = f->n <= SGA_MOST_ROWS_ASKED ? field_left_of_others(f->field, rq->start, r->initial, far, others) > STAYS : rank_of_others(f, far) >= others;
    if (!stays)
        return false;
    say_grows(f, rq, which, f->field->home[which], field_approaches(f->field, r->initial, rq->start, r->ended_t, FIELD_SOON, false, NULL), r);
    return true;
}

/* Of what it was at the start: pivots above this are away from 0. */
static const double AWAY = 1e-2;
/* The velocity at the end, times the way made, beside the size. */
static const double STEEP = 1e3;

/* No pivot that can be 0 has come near it. */
static bool pivots_away(const struct field *f)
{
    bool away = true;
    for (int q = f->sides; q < f->chosen && away; q++)
        away = fabs(f->direct_out[f->n + q]) > AWAY * f->pivot_start[q];
    return away;
}

bool endings_steep(struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    struct field *field = f->field;
    SGA_ARENA(mem);
    double *v = sga_zeros(&mem, 2 * (size_t)f->n + 1, sizeof *v), *home = v + f->n, way = fabs(r->ended_t - rq->start), most = STEEP;
    int which = -1;
    sga_copy(home, field->home, f->n);
    if (field->contradiction || !field->fast || !field_eval(field, field->home_t, home, v) || !pivots_away(field))
        return false;
    for (int j = 0; j < f->n; j++) {
        double by = fabs(v[j]) * way / fmax(fmax(fabs(home[j]), fabs(r->initial[j])), f->manifold->unit[j]);
        if (by > most) {
            most = by;
            which = j;
        }
    }
    if (which < 0)
        return false;
    r->ended_reason = "blow_up";
    snprintf(r->ended_detail, sizeof r->ended_detail, "the derivative of %s grows without bound (%.3g at the last point)",
             f->sys->store->symbol[f->sys->variable[which].symbol].name, v[which]);
    return true;
}
