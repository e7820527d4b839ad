/* Derivatives of velocities after an impulse to the digits of double-double. With y what changes by along the event (jump_slope.h), the impulse's equations
 *     M (v - v0) - J^T mu = 0 where velocities are free,   conditions(v) = 0
 * are differentiated: linear equations for dv and dmu, with residuals in these numbers and steps in double. Directions of masses are those of the request, of conditions the
 * constraints that follow each of them, and of gradients the gradients of these. */
#include <math.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "error.h"
#include "field.h"
#include "jump_fine.h"
#include "jump_impulse.h"
#include "jump_impulse_parts.h"
#include "mem.h"
#include "reduction.h"
#include "signal.h"
#include "system.h"
#include "tape.h"

enum { MOST_STEPS = 8 };
/* Of the largest derivative: what the last step may move by. */
static const double SETTLED = 1e-29;

struct sloping {
    struct impulse p;
    const struct traj_mass *m;
    const struct traj_mode *own;  /* variables and derivatives */
    int q, n, roots;              /* directions; variables; of p */
    struct num_tape *along;       /* of own: roots of p along each direction, then by time */
    num_dd *out, *rate, *in, *mu, *dmu;
    const num_dd *x, *v0;
    const unsigned char *set;
    double size;                  /* of the largest derivative, as set */
    struct sga_arena mem;
};

/* Roots along direction d, and by time. */
static bool make_tape(struct sloping *s, const struct jump *j, struct sga_error *err)
{
    const struct sys_system *sys = s->own->sys;
    const struct sga_solution *sol = s->own->sol;
    struct expr_store *st = sys->store;
    int each = 1 + s->q, c = 0, place = 0;
    size_t roots = (size_t)s->roots;
    unsigned char *is = sga_zeros(&s->mem, (size_t)j->sol->constraints + 1, 1);
    int *row = sga_zeros(&s->mem, (size_t)s->p.conditions + 1, sizeof *row);
    expr_id *root = sga_zeros(&s->mem, roots * (size_t)each + 1, sizeof *root);
    jump_impulse_conditions(j, is);
    for (int i = 0; i < j->sol->constraints; i++)
        if (is[i])
            row[c++] = i * each;
    for (int d = 0; d <= s->q; d++) {        /* d = q: by time */
        for (int k = 0; k < s->m->entries; k++)
            root[place++] = d < s->q ? s->own->rq->slopes->mass[k * s->q + d] : expr_time_partial(st, s->own->rq->mass->value[k], sys->time);
        for (int i = 0; i < s->p.conditions; i++)
            root[place++] = d < s->q ? sol->constraint[row[i] + 1 + d].expr : expr_time_partial(st, sol->constraint[row[i]].expr, sys->time);
        for (int k = 0; k < s->p.terms; k++) {
            expr_id of = root[place - k - s->p.conditions + s->p.row[k]];
            root[place++] = expr_diff(st, of, sys->variable[s->m->velocity[s->p.col[k]]].symbol);
        }
    }
    SGA_FREED int *inputs = field_inputs(sys);
    s->along = expr_store_ok(st) ? num_tape_new(st, root, (int)roots * each, inputs, sys->variables + 1, err) : NULL;
    return s->along != NULL;
}

/* Residuals of direction d at y (n), of which the velocities are guessed: into kept and off. */
static void residuals(const struct sloping *s, int d, num_dd tau, const num_dd *y, const num_dd *v0_rate, double *kept, double *off)
{
    const struct traj_mass *m = s->m;
    const num_dd *rate = s->rate + d * s->roots, *by_time = s->rate + s->q * s->roots;
    for (int i = 0; i < s->p.coordinates; i++) {
        num_dd sum = num_dd_of(0);
        for (int k = 0; k < m->entries; k++) {
            if (m->row[k] != i)
                continue;
            int c = m->col[k];
            num_dd dM = num_dd_add(rate[k], num_dd_mul(by_time[k], tau));
            sum = num_dd_sub(sum, num_dd_mul(dM, num_dd_sub(s->x[m->velocity[c]], s->v0[c])));
            sum = num_dd_sub(sum, num_dd_mul(s->out[k], num_dd_sub(y[m->velocity[c]], v0_rate[c])));
        }
        for (int k = 0; k < s->p.terms; k++) {
            if (s->p.col[k] != i)
                continue;
            int root = m->entries + s->p.conditions + k;
            num_dd dJ = num_dd_add(rate[root], num_dd_mul(by_time[root], tau));
            sum = num_dd_add(sum, num_dd_mul(dJ, s->mu[s->p.row[k]]));
            sum = num_dd_add(sum, num_dd_mul(s->out[root], s->dmu[s->p.row[k]]));
        }
        kept[i] = sum.hi;
    }
    for (int i = 0; i < s->p.conditions; i++)
        off[i] = -num_dd_add(rate[m->entries + i], num_dd_mul(by_time[m->entries + i], tau)).hi;
}

/* The derivatives of direction d in y (n): from as they are set. */
static bool solve(struct sloping *s, num_dd t, int d, num_dd tau, num_dd *y)
{
    size_t n = (size_t)s->p.coordinates, c = (size_t)s->p.conditions;
    int all = s->n * (1 + s->q);
    num_dd *v0_rate = sga_zeros(&s->mem, n + 1, sizeof *v0_rate);
    double *kept = sga_zeros(&s->mem, 2 * (n + c) + 1, sizeof *kept), *off = kept + n, *dv = off + c, *dmu = dv + n, moved = INFINITY, size = s->size;
    for (size_t i = 0; i < n; i++)
        v0_rate[i] = y[s->m->velocity[i]];
    memset(s->dmu, 0, c * sizeof *s->dmu);
    for (int k = 0; k < MOST_STEPS && (k < 2 || moved > SETTLED * size); k++) {
        memcpy(s->in + s->n + d * s->n, y, (size_t)s->n * sizeof *y);
        if (!jump_fine_evaluate(s->along, all, t, s->in, NULL, 0, s->rate, NULL, s->roots * (1 + s->q)))
            return false;
        residuals(s, d, tau, y, v0_rate, kept, off);
        if (!jump_impulse_solve(&s->p, s->set, kept, off, fmax(size, 1e-300), dv, dmu))
            return false;
        moved = 0;
        for (size_t i = 0; i < n; i++) {
            num_dd *v = y + s->m->velocity[i];
            *v = num_dd_add_d(*v, dv[i]);
            moved = fmax(moved, fabs(dv[i]));
            size = fmax(size, fabs(v->hi));
        }
        for (size_t i = 0; i < c; i++)
            s->dmu[i] = num_dd_add_d(s->dmu[i], dmu[i]);
    }
    return moved <= SETTLED * size;
}

bool jump_impulse_slope(const struct jump *j, const struct traj_mode *own, num_dd t, const num_dd *x, const struct impulse_found *found, const struct jump_to *landed, const num_dd *tau, int q,
                        num_dd *y)
{
    struct sloping s = { .m = j->rq->mass, .own = own, .q = q, .n = j->n, .x = x, .v0 = found->v0, .mu = found->mu };
    struct sga_error ignored = { 0 };
    bool ok = jump_impulse_init(&s.p, j, &ignored);
    if (ok && s.p.conditions) {
        size_t all = (size_t)j->n * (size_t)(1 + q);
        s.roots = s.m->entries + s.p.conditions + s.p.terms;
        s.out = sga_zeros(&s.mem, (size_t)s.roots * (size_t)(2 + q) + 1, sizeof *s.out);
        s.rate = s.out + s.roots;
        s.in = sga_zeros(&s.mem, all + 1, sizeof *s.in);
        s.dmu = sga_zeros(&s.mem, (size_t)s.p.conditions + 1, sizeof *s.dmu);
        unsigned char *set = sga_zeros(&s.mem, (size_t)s.p.coordinates + 1, 1);
        for (int i = 0; i < s.p.coordinates; i++)
            set[i] = landed->changed[s.m->velocity[i]];
        s.set = set;
        memcpy(s.in, x, (size_t)j->n * sizeof *s.in);
        memcpy(s.in + j->n, y, (all - (size_t)j->n) * sizeof *s.in);
        for (int i = 0; i < q * j->n; i++)
            s.size = fmax(s.size, fabs(y[i].hi));
        ok = jump_fine_evaluate(s.p.tape, j->n, t, x, NULL, 0, s.out, NULL, s.roots) && make_tape(&s, j, &ignored);
        for (int k = 0; k < s.roots && ok; k++)
            s.p.out[k] = s.out[k].hi;
        if (ok)
            jump_impulse_matrices(&s.p, s.m);
        for (int d = 0; d < q && ok; d++)
            ok = solve(&s, t, d, tau[d], y + d * j->n);
        num_tape_free(s.along);
    }
    jump_impulse_clear(&s.p);
    sga_arena_end(&s.mem);
    return ok;
}
