/* See start_parts.h. Of a part: the search of consistent.c, all other variables held, on a manifold of its own. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "consistent.h"
#include "error.h"
#include "flow.h"
#include "manifold.h"
#include "mem.h"
#include "reduction.h"
#include "sizes.h"
#include "start_parts.h"
#include "system.h"

/* Variables of systems that are taken apart. */
enum { MOST = 100 };

struct parts {
    struct flow *f;
    const struct sys_system *sys; const struct sga_solution *sol; const struct traj_request *rq;
    int *of;                      /* by variable: the least variable of its part */
    struct sga_arena mem;
};

static int root(const int *of, int j)
{
    while (of[j] != j)
        j = of[j];
    return j;
}

/* Parts by the constraints' variables, without held ones. Returns how many have constraints. */
static int divide(struct parts *p)
{
    const struct manifold *m = p->f->manifold;
    const unsigned char *held = p->rq->held;
    int parts = 0;
    p->of = sga_zeros(&p->mem, (size_t)m->n + 1, sizeof *p->of);
    unsigned char *seen = sga_zeros(&p->mem, (size_t)m->n + 1, 1);
    for (int j = 0; j < m->n; j++)
        p->of[j] = j;
    for (int i = 0; i < m->c; i++) {
        int first = -1;
        for (int k = 0; k < m->cols[i]; k++) {
            int j = root(p->of, m->col[i][k]);
            if (held && held[m->col[i][k]])
                continue;
            if (first >= 0 && j != first)
                p->of[j > first ? j : first] = j < first ? j : first;
            first = first < 0 || j < first ? j : first;
        }
        if (first < 0)
            return 0;            /* of held values alone */
    }
    for (int j = 0; j < m->n; j++)
        p->of[j] = root(p->of, j);
    for (int i = 0; i < m->c; i++)
        for (int k = 0; k < m->cols[i]; k++) {
            int j = m->col[i][k];
            parts += !(held && held[j]) && !seen[p->of[j]];
            seen[p->of[j]] |= !(held && held[j]);
        }
    return parts;
}

static int part_of(const struct parts *p, int i)
{
    const struct manifold *m = p->f->manifold;
    for (int k = 0; k < m->cols[i]; k++)
        if (!(p->rq->held && p->rq->held[m->col[i][k]]))
            return p->of[m->col[i][k]];
    return -1;
}

/* The start of one part, into x. */
static bool start(struct parts *p, int part, double *x)
{
    size_t n = (size_t)p->f->n;
    struct sga_solution sol = *p->sol;
    struct traj_request rq = *p->rq;
    struct manifold m;
    struct sga_error ignored = { 0 };
    unsigned char *held = sga_zeros(&p->mem, n + 1, 1);
    double *own = sga_zeros(&p->mem, n + 1, sizeof *own), moved;
    struct sga_constraint *constraint = sga_zeros(&p->mem, (size_t)sol.constraints + 1, sizeof *constraint);
    sol.constraint = constraint;
    sol.constraints = 0;
    for (int i = 0; i < p->sol->constraints; i++)
        if (part_of(p, i) == part)
            constraint[sol.constraints++] = p->sol->constraint[i];
    for (size_t j = 0; j < n; j++)
        held[j] = p->of[j] != part || (p->rq->held && p->rq->held[j]);
    rq.held = held;
    bool ok = manifold_init(&m, p->sys, &sol, NULL, &ignored);
    m.unit = p->f->manifold->unit;
    ok = ok && consistent_start(&m, p->sys, &sol, p->f->sizes, &rq, NULL, own, &moved, NULL);
    for (size_t j = 0; j < n && ok; j++)
        if (!held[j])
            x[j] = own[j];
    manifold_clear(&m);
    return ok;
}

bool start_parts(struct flow *f, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, double *x, double *moved)
{
    struct parts p = { f, sys, sol, rq, NULL, { 0 } };
    size_t n = (size_t)f->n;
    double residual, *scale = sga_zeros(&p.mem, n + 1, sizeof *scale);
    memcpy(x, rq->initial, n * sizeof *x);
    bool there = manifold_project(f->manifold, rq->start, x, NULL, rq->held, 0, NULL, &residual, NULL);
    bool ok = !there && f->manifold->c > 1 && f->n <= MOST && divide(&p) > 1;
    unsigned char *done = sga_zeros(&p.mem, n + 1, 1);
    for (int i = 0; i < f->manifold->c && ok; i++) {
        int part = part_of(&p, i);
        if (!done[part])
            ok = start(&p, part, x);
        done[part] = 1;
    }
    for (size_t j = 0; j < n; j++)
        scale[j] = sizes_move(f->sizes, (int)j, rq->initial[j]);
    ok = ok && manifold_project(f->manifold, rq->start, x, NULL, rq->held, 0, NULL, &residual, NULL);
    if (ok)
        *moved = consistent_moved(f->manifold, rq, scale, x);
    sga_arena_end(&p.mem);
    return ok;
}
