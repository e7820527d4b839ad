/* The consistent start as a result of its own. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "coordinates.h"
#include "defined.h"
#include "field.h"
#include "flow.h"
#include "given_rows.h"
#include "manifold.h"
#include "mem.h"
#include "normal.h"
#include "sparse.h"
#include "start_relations.h"
#include "tape.h"

/* The elimination of the differentials decides. */
int flow_solved(struct flow *f, const struct traj_request *rq, const double *x, unsigned char *solved)
{
    int n = f->n, c = f->manifold->c;
    struct points_row *row = sga_calloc((size_t)c + 1, sizeof *row);
    manifold_residual(f->manifold, rq->start, x, NULL, NULL);
    for (int i = 0; i < c; i++) {
        int len = f->manifold->cols[i];
        row[i].len = row[i].cap = len;
        row[i].col = sga_malloc((size_t)(len + 1) * sizeof(int));
        row[i].val = sga_malloc((size_t)(len + 1) * sizeof(double));
        for (int k = 0; k < len; k++) {
            row[i].col[k] = f->manifold->col[i][k];
            row[i].val[k] = f->manifold->step->value[i][k] * (rq->given[row[i].col[k]] ? 1 : 1e3);
        }
    }
    struct points_lu lu;
    points_lu_factor(&lu, row, c, n, 1e-10);
    int rank = lu.rank;
    for (int k = 0; k < rank; k++)
        solved[lu.pivot_col[k]] = 1;
    assert(rank <= c && rank <= n);
    points_lu_clear(&lu);
    return rank;
}

/* Coordinates of Pf near x: those that the constraints can be solved for are taken out, what follows from the others first. */
static void free_coordinates(struct flow *f, const struct traj_request *rq, struct traj_initial *r)
{
    int n = f->n;
    unsigned char *solved = sga_calloc((size_t)n + 1, 1);
    if (!coordinates_solved(f->manifold, f->sys, rq, r->x, solved))
        flow_solved(f, rq, r->x, solved);
    r->free = sga_malloc((size_t)(n + 1) * sizeof *r->free);
    for (int j = 0; j < n; j++)
        if (!solved[j])
            r->free[r->frees++] = j;
    assert(r->frees >= n - f->manifold->c);
    free(solved);
}

static bool consistent_as_is(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                             struct traj_initial *r, struct sga_error *err)
{
    struct flow f;
    *r = (struct traj_initial){ 0 };
    bool ok = flow_init(&f, sys, sol, rq, err);
    if (ok) {
        int n = f.n, c = f.manifold->c;
        r->x = sga_calloc((size_t)n + 1, sizeof *r->x);
        r->derivative = sga_calloc((size_t)n + 1, sizeof *r->derivative);
        r->residual = sga_calloc((size_t)c + 1, sizeof *r->residual);
        ok = flow_start(&f, sys, sol, rq, r->x, &r->moved, err) && flow_given(&f, rq, r->x, err)
             && field_begin(f.field, rq->start, r->x, err) && field_eval(f.field, rq->start, r->x, r->derivative);
        if (ok) {
            memcpy(f.in, r->x, (size_t)n * sizeof *f.in);
            f.in[n] = rq->start;
            num_tape_eval(f.manifold->tape, f.in, r->residual);
            free_coordinates(&f, rq, r);
            r->gauge = flow_gauge(&f, rq);
        }
    }
    flow_clear(&f);
    if (!ok)
        traj_initial_clear(r);
    return ok;
}

static bool consistent(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                       struct traj_initial *r, struct sga_error *err)
{
    struct defined d;
    if (!defined_any(sol, rq))
        return consistent_as_is(sys, sol, rq, r, err);
    *r = (struct traj_initial){ 0 };
    defined_init(&d, sys, sol, rq);
    bool ok = defined_start(&d, err) && consistent_as_is(&d.system, &d.solution, &d.request, r, err);
    if (ok && !defined_initial(&d, r, err)) {
        traj_initial_clear(r);
        ok = false;
    }
    defined_clear(&d);
    return ok;
}

bool traj_consistent(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                     struct traj_initial *r, struct sga_error *err)
{
    if (start_relations_any(rq))
        return start_relations_consistent(sys, sol, rq, r, err);
    bool ok = consistent(sys, sol, rq, r, err);
    if (ok && !given_rows_hold(sys, rq, r->x, err)) {
        traj_initial_clear(r);
        ok = false;
    }
    return ok;
}

void traj_initial_clear(struct traj_initial *r)
{
    free(r->x);
    free(r->derivative);
    free(r->residual);
    free(r->free);
    free(r->relation);
    *r = (struct traj_initial){ 0 };
}
