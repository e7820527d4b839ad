/* Velocities of masses after an impulse of constraints: Newton steps of the conditions of a nearest point in the metric of the masses. */
#include "jump_impulse.h"
#include "jump_impulse_parts.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "dependent.h"
#include "derive.h"
#include "error.h"
#include "field.h"
#include "mem.h"
#include "reduction.h"
#include "system.h"
#include "tape.h"

/* Newton steps; what is missed, by its size. */
enum { MOST_STEPS = 50 };
static const double MET = 1e-9;

void jump_impulse_clear(struct impulse *p)
{
    num_tape_free(p->tape);
    free(p->row);
    free(p->in);
    free(p->root);
}

/* Whether e has a velocity and nothing but positions, velocities and what stays where it is. */
static bool of_velocities(const struct jump *j, struct expr_cone *cone, expr_id e, const unsigned char *velocity)
{
    const struct expr_store *st = j->sys->store;
    bool any = false, other = false;
    expr_cone_of(st, cone, &e, 1);
    for (int i = 0; i < cone->count; i++)
        if (expr_op_of(st, cone->list[i]) == EXPR_SYM) {
            int symbol = st->node[cone->list[i]].a, v = j->variable[symbol];
            any |= velocity[symbol];
            other |= v >= 0 && !j->moving[v];
        }
    return any && !other;
}

void jump_impulse_conditions(const struct jump *j, unsigned char *is)
{
    const struct traj_mass *m = j->rq->mass;
    struct expr_cone cone;
    SGA_FREED unsigned char *velocity = sga_calloc((size_t)j->sys->store->symbols + 1, 1);
    for (int k = 0; k < m->coordinates; k++)
        velocity[j->sys->variable[m->velocity[k]].symbol] = 1;
    expr_cone_init(&cone);
    for (int i = 0; i < j->sol->constraints; i++)
        is[i] = of_velocities(j, &cone, j->sol->constraint[i].expr, velocity);
    expr_cone_clear(&cone);
}

bool jump_impulse_init(struct impulse *p, const struct jump *j, struct sga_error *err)
{
    const struct traj_mass *m = j->rq->mass;
    struct expr_store *st = j->sys->store;
    size_t symbols = (size_t)st->symbols, room = 0, cap = 0, n = (size_t)m->coordinates;
    SGA_FREED unsigned char *velocity = sga_calloc(symbols + 1, 1);
    SGA_FREED int *place = sga_calloc(symbols + 1, sizeof *place);
    SGA_FREED struct expr_term *term = NULL;
    SGA_FREED expr_id *condition = sga_malloc(((size_t)j->sol->constraints + 1) * sizeof *condition), *slope = NULL;
    struct expr_cone cone;
    *p = (struct impulse){ .n = j->n, .coordinates = m->coordinates };
    for (int k = 0; k < m->coordinates; k++) {
        int symbol = j->sys->variable[m->velocity[k]].symbol;
        velocity[symbol] = 1;
        place[symbol] = k;
    }
    SGA_FREED unsigned char *is = sga_calloc((size_t)j->sol->constraints + 1, 1);
    jump_impulse_conditions(j, is);
    expr_cone_init(&cone);
    for (int i = 0; i < j->sol->constraints; i++)
        if (is[i])
            condition[p->conditions++] = j->sol->constraint[i].expr;
    SGA_FREED int *count = sga_calloc((size_t)p->conditions + 1, sizeof *count);
    SGA_FREED int *column = NULL;
    size_t column_cap = 0;
    for (int i = 0; i < p->conditions; i++) {
        count[i] = expr_gradient(st, &cone, condition[i], velocity, &term, &cap);
        SGA_RESERVE(slope, room, p->terms + count[i]);
        SGA_RESERVE(column, column_cap, p->terms + count[i]);
        for (int k = 0; k < count[i]; k++, p->terms++) {
            slope[p->terms] = term[k].value;
            column[p->terms] = place[term[k].symbol];
        }
    }
    expr_cone_clear(&cone);
    p->row = sga_calloc(2 * (size_t)p->terms + 2, sizeof *p->row);
    p->col = p->row + p->terms;
    for (int i = 0, k = 0; i < p->conditions; i++)
        for (int c = 0; c < count[i]; c++, k++) {
            p->row[k] = i;
            p->col[k] = column[k];
        }
    for (int k = 0; k < m->entries; k++)
        assert(m->row[k] >= 0 && m->row[k] < m->coordinates && m->col[k] >= 0 && m->col[k] < m->coordinates);
    int roots = 0;
    expr_id *root = p->root = sga_malloc((size_t)(m->entries + p->conditions + p->terms + 1) * sizeof *root);
    for (int k = 0; k < m->entries; k++)
        root[roots++] = m->value[k];
    for (int k = 0; k < p->conditions; k++)
        root[roots++] = condition[k];
    for (int k = 0; k < p->terms; k++)
        root[roots++] = slope[k];
    SGA_FREED int *inputs = field_inputs(j->sys);
    p->tape = num_tape_new(st, root, roots, inputs, j->n + 1, err);
    p->in = sga_calloc((size_t)j->n + 2 + (size_t)roots + n * n + (size_t)p->conditions * n, sizeof *p->in);
    p->out = p->in + j->n + 1;
    p->M = p->out + roots + 1;
    p->J = p->M + n * n;
    return p->tape != NULL;
}

void jump_impulse_matrices(struct impulse *p, const struct traj_mass *m)
{
    size_t n = (size_t)p->coordinates;
    memset(p->M, 0, n * n * sizeof *p->M);
    memset(p->J, 0, (size_t)p->conditions * n * sizeof *p->J);
    for (int k = 0; k < m->entries; k++)
        p->M[(size_t)m->row[k] * n + (size_t)m->col[k]] += p->out[k];
    for (int k = 0; k < p->terms; k++)
        p->J[(size_t)p->row[k] * n + (size_t)p->col[k]] += p->out[m->entries + p->conditions + k];
}

bool jump_impulse_look(struct impulse *p)
{
    return num_tape_eval(p->tape, p->in, p->out);
}

/* Masses, conditions and gradients at x; false: one has no value. */
static bool look(struct impulse *p, const struct traj_mass *m, double t, const double *x)
{
    memcpy(p->in, x, (size_t)p->n * sizeof *p->in);
    p->in[p->n] = t;
    if (!jump_impulse_look(p))
        return false;
    jump_impulse_matrices(p, m);
    return true;
}

/* The largest of so many, by its size; 1 where all are 0. */
static double largest(const double *v, size_t n)
{
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(v[i]));
    return most > 0 ? most : 1;
}

bool jump_impulse_solve(const struct impulse *p, const unsigned char *set, const double *kept, const double *off, double speed, double *dv, double *dmu)
{
    size_t n = (size_t)p->coordinates, c = (size_t)p->conditions, size = n + c;
    SGA_FREED double *K = sga_calloc(size * size + 2 * size + 1, sizeof *K);
    double *b = K + size * size, *z = b + size, mass = largest(p->M, n * n);
    for (size_t i = 0; i < n; i++) {
        if (set[i]) {
            K[i * size + i] = 1;
            continue;
        }
        for (size_t k = 0; k < n; k++)
            K[i * size + k] = p->M[i * n + k] / mass;
        b[i] = kept[i] / mass;
    }
    for (size_t i = 0; i < c; i++) {
        double unit = largest(p->J + i * n, n);
        for (size_t k = 0; k < n; k++) {
            K[(n + i) * size + k] = p->J[i * n + k] / unit;
            K[k * size + n + i] = set[k] ? 0 : -p->J[i * n + k] / unit;
        }
        b[n + i] = off[i] / unit;
    }
    if (!dependent_solve(K, b, z, (int)size, speed))
        return false;
    memcpy(dv, z, n * sizeof *dv);
    for (size_t i = 0; i < c && dmu; i++)
        dmu[i] = z[n + i] * mass / largest(p->J + i * n, n);
    return true;
}

/* One Newton step from v: M (v + dv - v0) - J^T mu = 0 where velocities are free, J dv = -conditions. */
static bool step(const struct impulse *p, const struct traj_mass *m, const double *v, const double *v0, const unsigned char *set, double speed, double *dv)
{
    size_t n = (size_t)p->coordinates, c = (size_t)p->conditions;
    SGA_FREED double *kept = sga_calloc(n + c + 1, sizeof *kept);
    double *off = kept + n;
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < n; k++)
            kept[i] -= p->M[i * n + k] * (v[k] - v0[k]);
    for (size_t i = 0; i < c; i++)
        off[i] = -p->out[m->entries + (int)i];
    return jump_impulse_solve(p, set, kept, off, speed, dv, NULL);
}

/* How far the conditions are missed, by what their gradients make of the velocities. */
static double missed(const struct impulse *p, const struct traj_mass *m, const double *v, double speed)
{
    double most = 0;
    for (int i = 0; i < p->conditions; i++) {
        double size = 0;
        for (int k = 0; k < p->coordinates; k++)
            size += fabs(p->J[(size_t)i * (size_t)p->coordinates + (size_t)k]) * fmax(fabs(v[k]), speed);
        most = fmax(most, size > 0 ? fabs(p->out[m->entries + i]) / size : 0);
    }
    return most;
}

/* v+ from v0, by coordinate. */
static bool strike(struct impulse *p, const struct traj_mass *m, double t, double *x, const double *v0, const unsigned char *set, double speed)
{
    size_t n = (size_t)p->coordinates;
    SGA_FREED double *v = sga_calloc(2 * n + 1, sizeof *v);
    double *dv = v + n, least = INFINITY;
    memcpy(v, v0, n * sizeof *v);
    for (int k = 0; k < MOST_STEPS; k++) {
        if (!look(p, m, t, x) || !step(p, m, v, v0, set, speed, dv))
            return false;
        double moved = 0;
        for (size_t i = 0; i < n; i++) {
            v[i] += dv[i];
            x[m->velocity[i]] = v[i];
            moved = fmax(moved, fabs(dv[i]));
        }
        if (moved <= 4 * DBL_EPSILON * speed || (moved <= MET * speed && moved >= 0.5 * least))
            break;
        least = moved;
    }
    return look(p, m, t, x) && missed(p, m, v, speed) <= MET;
}

bool jump_impulse(struct jump *j, const struct jump_at *at, struct jump_to *to, const char *place, struct sga_error *err)
{
    const struct traj_mass *m = j->rq->mass;
    size_t n = (size_t)m->coordinates;
    struct impulse p;
    bool ok = jump_impulse_init(&p, j, err);
    SGA_FREED double *v0 = sga_calloc(2 * n + 1, sizeof *v0);
    SGA_FREED unsigned char *set = sga_calloc(n + 1, 1);
    double *sum = v0 + n, speed = 0, size = 0;
    for (int k = 0; k < m->coordinates; k++) {
        v0[k] = to->x[m->velocity[k]];
        set[k] = to->changed[m->velocity[k]];
        speed = fmax(speed, fmax(fabs(v0[k]), fabs(at->x[m->velocity[k]])));
    }
    if (ok && p.conditions && !m->impulses)
        ok = sga_fail_at(err, SGA_E_NOT_SUPPORTED, place, "at %.10g velocities may jump, and how is not known: the reactions do not alone hold the system on what `restrict` or the "
                         "constraints leave of it; let constraints alone hold it, or use the form \"equations\", in which velocities move to the nearest point", at->t);
    if (ok && !strike(&p, m, at->t, to->x, v0, set, speed))
        ok = sga_fail_at(err, SGA_E_EVENT_SET, place, "at %.10g no impulse of the constraints brings the velocities onto them; set fewer velocities, or such as the constraints allow", at->t);
    to->impulse = sga_calloc(n + 1, sizeof *to->impulse);
    for (int k = 0; ok && k < m->coordinates; k++)
        size = fmax(size, fabs(to->x[m->velocity[k]] - v0[k]));
    to->struck = ok && size > MET * speed;
    for (size_t i = 0; ok && i < n; i++)
        for (size_t k = 0; k < n; k++)
            sum[i] += p.M[i * n + k] * (to->x[m->velocity[k]] - at->x[m->velocity[k]]);
    memcpy(to->impulse, sum, n * sizeof *sum);
    jump_impulse_clear(&p);
    return ok;
}
