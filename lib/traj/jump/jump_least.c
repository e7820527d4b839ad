/* Derivatives of points that move as little as constraints let them, at an event: see jump_least.h. */
#include "jump_least.h"

#include <math.h>
#include <string.h>

#include "arena.h"
#include "jump_impulse.h"
#include "least_move.h"
#include "least_tiers.h"
#include "sizes.h"

/* The masses at what was evaluated last into M (n x n), and what they change by along each direction times v (n): push (n x q) loses it. */
static bool masses(struct least_move *l, const struct jump_along *a, const double *y, const double *v, double *M, double *push)
{
    struct jump_slope *s = a->j->slope;
    const struct traj_mass *m = a->j->rq->mass;
    int root = s->rows.first - s->masses;
    size_t n = (size_t)l->n, q = (size_t)l->q;
    SGA_ARENA(mem);
    double *g = sga_zeros(&mem, n + 1, sizeof *g);
    if (!least_rows_at(&s->rows, l->t, l->x, y) || !jump_slope_directions(s))
        return false;
    for (int k = 0; k < m->entries; k++) {
        size_t i = (size_t)m->velocity[m->row[k]], j = (size_t)m->velocity[m->col[k]];
        double by_time = least_rows_gradient(&s->rows, root + k, g);
        M[i * n + j] += s->rows.out[root + k];
        for (size_t d = 0; d < q; d++)
            push[i * q + d] -= (s->along[(size_t)(root + k) * q + d] + by_time * l->tau[d]) * v[j];
    }
    return true;
}

/* pull (n): M v; and what it is made of at the most, in units. */
static double pull_of(const struct least_move *l, const double *M, const double *v, double *pull)
{
    double most = 0;
    for (int i = 0; i < l->n; i++) {
        pull[i] = 0;
        for (int k = 0; k < l->n; k++) {
            pull[i] += M[i * l->n + k] * v[k];
            most = fmax(most, fabs(M[i * l->n + k]) * l->unit[i] * l->unit[k]);
        }
    }
    return most;
}

bool jump_least_impulse(const struct jump_along *a, const double *asked, double *y)
{
    const struct traj_mass *m = a->j->rq->mass;
    struct least_move l;
    SGA_ARENA(mem);
    if (!least_move_at(&l, &a->j->slope->rows, a->at->t, a->to->x, a->tau, &mem))
        return false;
    size_t n = (size_t)l.n, q = (size_t)l.q;
    double *M = sga_zeros(&mem, n * n + 1, sizeof *M), *push = sga_zeros(&mem, n * q + 1, sizeof *push), *v = sga_zeros(&mem, 3 * n + 1, sizeof *v), *pull = v + n, *to = pull + n;
    double speed = 0;
    for (int k = 0; k < m->coordinates; k++)
        speed = fmax(speed, fmax(fabs(a->to->x[m->velocity[k]]), fabs(asked[m->velocity[k]])));
    if (speed == 0)
        speed = 1;
    for (size_t k = 0; k < n; k++)
        l.unit[k] = 1;
    for (int k = 0; k < m->coordinates; k++) {
        l.unit[m->velocity[k]] = speed;
        l.free[m->velocity[k]] = !a->to->changed[m->velocity[k]];
        v[m->velocity[k]] = a->to->x[m->velocity[k]] - asked[m->velocity[k]];
    }
    jump_impulse_conditions(a->j, l.use);
    if (!masses(&l, a, y, v, M, push))
        return false;
    double most = pull_of(&l, M, v, pull);
    if (!least_multipliers(&l, pull, LEAST_NONE * most, &mem) || !least_bend(&l, &mem))
        return false;
    for (size_t d = 0; d < q; d++) {
        memset(pull, 0, n * sizeof *pull);
        for (size_t i = 0; i < n; i++) {
            pull[i] = push[i * q + d] - l.bent[i * q + d];
            for (size_t k = 0; k < n; k++)
                pull[i] += l.free[k] ? M[i * n + k] * y[d * n + k] : 0;
        }
        memcpy(to, y + d * n, n * sizeof *to);
        if (!least_solve(&l, M, pull, l.by + d, (int)q, to, &mem))
            return false;
        memcpy(y + d * n, to, n * sizeof *to);
    }
    return true;
}

bool jump_least_start(const struct jump_along *a, const double *x, int way, double *y)
{
    int n = a->j->n, q = a->j->slope->rows.q, left = q;
    SGA_ARENA(mem);
    unsigned char *done = sga_zeros(&mem, (size_t)q + 1, 1), *place = sga_zeros(&mem, 2 * (size_t)n + 1, 1);
    for (; way < JUMP_WAYS && left; way++) {
        struct traj_request rq;
        struct sizes sizes;
        memset(place, 0, 2 * (size_t)n);
        jump_request(a->j, a->at, a->to, way, place, &rq);
        sizes_init(&sizes, a->j->sys, &rq);
        left -= least_tiers_move(&(struct least_tiers){ &a->j->slope->rows, a->j->sys, &sizes, &rq, a->at->t, a->tau, a->to->x, x }, y, done);
        sizes_clear(&sizes);
    }
    return !left;
}
