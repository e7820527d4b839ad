/* Velocities after an impulse to the digits of double-double: residuals in these numbers, steps in double. */
#include <math.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "jump_fine.h"
#include "jump_impulse.h"
#include "jump_impulse_parts.h"
#include "trajectory.h"

enum { LEAST_STEPS = 2, MOST_STEPS = 8 };        /* the first finds the multipliers, whatever velocities move by */
/* Of the largest velocity: what the last step may move by. */
static const double SETTLED = 1e-30;

/* v and mu at which the equations are looked at. */
struct striking {
    struct impulse p;
    const struct traj_mass *m;
    num_dd *out, *v0, *mu;        /* roots; velocities as they are set; by condition */
    unsigned char *set;
    double *kept, *off, *dv, *dmu, speed;
};

/* Residuals: J^T mu - M (v - v0), and -conditions. */
static void residuals(struct striking *s, const num_dd *x)
{
    const struct traj_mass *m = s->m;
    int n = s->p.coordinates;
    for (int i = 0; i < n; i++) {
        num_dd sum = num_dd_of(0);
        for (int k = 0; k < m->entries; k++)
            if (m->row[k] == i)
                sum = num_dd_sub(sum, num_dd_mul(s->out[k], num_dd_sub(x[m->velocity[m->col[k]]], s->v0[m->col[k]])));
        for (int k = 0; k < s->p.terms; k++)
            if (s->p.col[k] == i)
                sum = num_dd_add(sum, num_dd_mul(s->out[m->entries + s->p.conditions + k], s->mu[s->p.row[k]]));
        s->kept[i] = sum.hi;
    }
    for (int i = 0; i < s->p.conditions; i++)
        s->off[i] = -s->out[m->entries + i].hi;
}

/* One step; how far velocities moved, or NAN. */
static double step(struct striking *s, const struct jump *j, num_dd t, num_dd *x)
{
    int roots = s->m->entries + s->p.conditions + s->p.terms;
    double moved = 0;
    if (!jump_fine_evaluate(s->p.tape, j->n, t, x, NULL, 0, s->out, NULL, roots))
        return NAN;
    for (int k = 0; k < roots; k++)
        s->p.out[k] = s->out[k].hi;
    jump_impulse_matrices(&s->p, s->m);
    residuals(s, x);
    if (!jump_impulse_solve(&s->p, s->set, s->kept, s->off, s->speed, s->dv, s->dmu))
        return NAN;
    for (int i = 0; i < s->p.coordinates; i++) {
        int v = s->m->velocity[i];
        x[v] = num_dd_add_d(x[v], s->dv[i]);
        moved = fmax(moved, fabs(s->dv[i]));
    }
    for (int i = 0; i < s->p.conditions; i++)
        s->mu[i] = num_dd_add_d(s->mu[i], s->dmu[i]);
    return moved;
}

bool jump_impulse_fine(const struct jump *j, num_dd t, num_dd *x, const struct jump_to *landed, struct impulse_found *found, struct sga_arena *mem)
{
    struct sga_error ignored = { 0 };
    struct striking s = { .m = j->rq->mass };
    double moved = INFINITY;
    bool ok = jump_impulse_init(&s.p, j, &ignored);
    size_t n = (size_t)s.p.coordinates, c = (size_t)s.p.conditions;
    s.out = sga_zeros(mem, (size_t)s.m->entries + c + (size_t)s.p.terms + 1, sizeof *s.out);
    s.v0 = sga_zeros(mem, n + c + 1, sizeof *s.v0);
    s.mu = s.v0 + n;
    s.set = sga_zeros(mem, n + 1, 1);
    s.kept = sga_zeros(mem, 2 * (n + c) + 1, sizeof *s.kept);
    s.off = s.kept + n;
    s.dv = s.off + c;
    s.dmu = s.dv + n;
    for (size_t i = 0; i < n; i++) {
        int v = s.m->velocity[i];
        s.v0[i] = x[v];
        s.set[i] = landed->changed[v];
        s.speed = fmax(s.speed, fmax(fabs(x[v].hi), fabs(landed->x[v])));
        if (!s.set[i])
            x[v] = num_dd_of(landed->x[v]);
    }
    for (int k = 0; k < MOST_STEPS && ok && (k < LEAST_STEPS || moved > SETTLED * s.speed); k++) {
        double last = moved;
        moved = step(&s, j, t, x);
        ok = !isnan(moved) && (k < 2 || moved <= 0.5 * last || moved <= SETTLED * s.speed);
    }
    jump_impulse_clear(&s.p);
    *found = (struct impulse_found){ s.v0, s.mu };
    return ok && moved <= SETTLED * s.speed;
}
