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
#include "mem.h"
#include "print.h"
#include "sparse.h"
#include "system.h"
#include "trajectory.h"

/* Of the size at the start, or the natural one. */
static const double GROWN = 1e3;
/* Of a row, what elimination leaves of one that is independent. */
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
    struct points_row *row = sga_calloc((size_t)m->c + 1, sizeof *row);
    int rows = 0;
    for (int i = 0; i < m->c; i++) {
        int start = m->jac->start[i], len = m->jac->start[i + 1] - start;
        bool other = true;
        for (int k = 0; k < len; k++)
            other &= !far[m->jac->col[start + k]];
        if (!other)
            continue;
        struct points_row *r = row + rows++;
        *r = (struct points_row){ sga_malloc(((size_t)len + 1) * sizeof *r->col), sga_malloc(((size_t)len + 1) * sizeof *r->val), len, len };
        for (int k = 0; k < len; k++) {
            r->col[k] = m->jac->col[start + k];
            r->val[k] = m->value[start + k] * m->unit[r->col[k]];
        }
    }
    SGA_ENDS(points_lu_clear) struct points_lu lu;
    points_lu_factor(&lu, row, rows, f->n, INDEPENDENT);
    return lu.rank == rows;
}

bool endings_far(struct flow *f, const struct traj_request *rq, struct traj_result *r)
{
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
