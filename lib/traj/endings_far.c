/* See endings_far.h. */
#include "endings_far.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "flow.h"
#include "jacobian.h"
#include "kinds.h"
#include "lin_dense.h"
#include "print.h"
#include "system.h"
#include "trajectory.h"

enum { MOST = 200 };                        /* variables */
/* Of the size at the start, or the natural one. */
static const double GROWN = 1e3;
/* Of the largest singular value: constraints are independent. */
static const double INDEPENDENT = 1e-3;

/* far[j]: variable j has grown so, and equations themselves determine it. Returns the one that has grown most, or -1. */
static int grown(const struct flow *f, const double *initial, const unsigned char *kind, unsigned char *far)
{
    double most = GROWN;
    int which = -1;
    for (int j = 0; j < f->n; j++) {
        double by = fabs(f->field.home[j]) / fmax(fabs(initial[j]), f->manifold.unit[j]);
        far[j] = kind[j] == SYS_ALGEBRAIC && by > GROWN;
        if (far[j] && by > most) {
            most = by;
            which = j;
        }
    }
    return which;
}

/* The constraints on variables that are not far are independent at the end of the motion. */
static bool others_regular(struct flow *f, const unsigned char *far)
{
    struct manifold *m = &f->manifold;
    if (manifold_residual(m, f->field.home_t, f->field.home, NULL, NULL) < 0)
        return false;
    SGA_ARENA(mem);
    double *a = sga_zeros(&mem, (size_t)(m->c + 1) * (size_t)f->n, sizeof *a);
    int rows = 0;
    for (int i = 0; i < m->c; i++) {
        bool other = true;
        double big = 0, *row = a + (size_t)rows * (size_t)f->n;
        for (int k = m->jac->start[i]; k < m->jac->start[i + 1] && other; k++) {
            int j = m->jac->col[k];
            other = !far[j];
            row[j] = m->value[k] * m->unit[j];
            big = fmax(big, fabs(row[j]));
        }
        for (int j = 0; j < f->n; j++)
            row[j] = other && big > 0 ? row[j] / big : 0;
        rows += other;
    }
    double *value = sga_take(&mem, ((size_t)rows + 1) * sizeof *value);
    struct lin_dense dense = { .rows = rows, .cols = f->n, .a = a };
    return !rows || (rows <= f->n && lin_singular_values(&dense, value) && value[rows - 1] > INDEPENDENT * value[0]);
}

bool endings_far(struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
    if (f->n > MOST)
        return false;
    SGA_ARENA(mem);
    unsigned char *far = sga_zeros(&mem, 2 * (size_t)f->n + 1, 1), *kind = far + f->n;
    sys_kinds(f->sys, kind);
    int which = grown(f, r->initial, kind, far);
    if (which < 0 || !others_regular(f, far))
        return false;
    r->ended_reason = "blow_up";
    r->stratum = false;
    snprintf(r->ended_detail, sizeof r->ended_detail, "%s grows without bound (%.3g at the last point)",
             f->sys->store->symbol[f->sys->variable[which].symbol].name, f->field.home[which]);
    struct sga_buf zero = { 0 };
    int pivot = field_approaches(&f->field, r->initial, rq->start, r->ended_t, false);
    size_t before = strlen(r->ended_detail);
    if (pivot >= 0 && expr_print(f->sys->store, f->field.pivot_expr[pivot], 120, &zero))
        snprintf(r->ended_detail + before, sizeof r->ended_detail - before, ", while %s tends to 0", zero.data);
    sga_buf_free(&zero);
    return true;
}
