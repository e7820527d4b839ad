/* Derivatives of points that move as little as constraints let them: see jump_least.h. */
#include "jump_least.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "arena.h"
#include "dependent.h"
#include "jump_impulse.h"
#include "kinds.h"
#include "reduction.h"
#include "sizes.h"
#include "system.h"
#include "tiers.h"

/* What the conditions of a nearest point miss, by the sizes in them; a distance that is none, in units; and how well equations that depend on others
 * must agree, by those digits that dependent_solve asks for. */
static const double MISSED = 1e-6, NONE = 1e-11, AGREE = 1e3;

/* The constraints at a point: gradients, and what they change by. */
struct linear {
    struct jump_slope *s;
    double t;
    const double *x;
    int n, c, q;
    const double *tau;
    double *J;                    /* c x n */
    double *by;                   /* c x q: xi_k + xi_t tau */
    double *unit;                 /* n */
    unsigned char *use;           /* c */
    signed char *free;            /* n: 1 moves */
    double *lambda;               /* c */
    double *H, *bent;             /* n x n; n x q: H_k + H_t tau */
};

static int row_of(const struct linear *l, int i, int d) { return l->s->first + i * (1 + l->q) + d; }

static bool linear_at(struct linear *l, const struct jump_along *a, const double *x, struct sga_arena *mem)
{
    struct jump_slope *s = a->j->slope;
    size_t n = (size_t)s->n, c = (size_t)a->j->sol->constraints, q = (size_t)s->q;
    *l = (struct linear){ .s = s, .t = a->at->t, .x = x, .n = s->n, .c = a->j->sol->constraints, .q = s->q, .tau = a->tau };
    l->J = sga_zeros(mem, c * n + 1, sizeof *l->J);
    l->by = sga_zeros(mem, c * q + 1, sizeof *l->by);
    l->unit = sga_zeros(mem, n + 1, sizeof *l->unit);
    l->use = sga_zeros(mem, c + 1, 1);
    l->free = sga_zeros(mem, n + 1, 1);
    l->lambda = sga_zeros(mem, c + 1, sizeof *l->lambda);
    l->H = sga_zeros(mem, n * n + 1, sizeof *l->H);
    l->bent = sga_zeros(mem, n * q + 1, sizeof *l->bent);
    if (!jump_slope_at(s, l->t, x, NULL))
        return false;
    for (int i = 0; i < l->c; i++) {
        double by_time = jump_slope_gradient(s, row_of(l, i, 0), l->J + (size_t)i * n);
        for (int d = 0; d < l->q; d++)
            l->by[i * l->q + d] = s->out[row_of(l, i, 1 + d)] + by_time * a->tau[d];
        l->use[i] = 1;
    }
    return true;
}

/* The second derivatives in the direction lambda: the derivative of xi_x S + xi_k, by variables and time, at S = 0 and at unit vectors S. */
static bool bend(struct linear *l, struct sga_arena *mem)
{
    size_t n = (size_t)l->n, q = (size_t)l->q;
    double *S = sga_zeros(mem, n * q + 1, sizeof *S), *g = sga_zeros(mem, 3 * n + 1, sizeof *g), *still = g + n, *by_time = still + n, at_zero = 0;
    memset(l->H, 0, n * n * sizeof *l->H);
    memset(l->bent, 0, n * q * sizeof *l->bent);
    if (!jump_slope_at(l->s, l->t, l->x, NULL))
        return false;
    for (int i = 0; i < l->c; i++)
        for (int d = 0; d < l->q && l->lambda[i] != 0; d++) {
            double t = jump_slope_gradient(l->s, row_of(l, i, 1 + d), g);
            for (size_t k = 0; k < n; k++) {
                l->bent[k * q + (size_t)d] += l->lambda[i] * g[k];
                still[k] += d ? 0 : l->lambda[i] * g[k];
            }
            at_zero += d ? 0 : l->lambda[i] * t;
        }
    for (size_t m = 0; m < n; m++) {
        S[m] = 1;
        if (!jump_slope_at(l->s, l->t, l->x, S))
            return false;
        S[m] = 0;
        for (int i = 0; i < l->c; i++) {
            if (l->lambda[i] == 0)
                continue;
            by_time[m] += l->lambda[i] * jump_slope_gradient(l->s, row_of(l, i, 1), g);
            for (size_t k = 0; k < n; k++)
                l->H[k * n + m] += l->lambda[i] * g[k];
        }
        by_time[m] -= at_zero;
        for (size_t k = 0; k < n; k++)
            l->H[k * n + m] -= still[k];
    }
    for (size_t k = 0; k < n; k++)
        for (size_t d = 0; d < q; d++)
            l->bent[k * q + d] += by_time[k] * l->tau[d];
    return true;
}

/* What moves, and the constraints in use, by the sizes of their gradients. */
struct places { int *moves, *constraint; int count, constraints; double *size; };

static void find_places(const struct linear *l, struct places *p, struct sga_arena *mem)
{
    *p = (struct places){ .moves = sga_zeros(mem, (size_t)l->n + 1, sizeof(int)), .constraint = sga_zeros(mem, (size_t)l->c + 1, sizeof(int)),
                          .size = sga_zeros(mem, (size_t)l->c + 1, sizeof(double)) };
    for (int k = 0; k < l->n; k++)
        if (l->free[k])
            p->moves[p->count++] = k;
    for (int i = 0; i < l->c; i++) {
        double most = 0;
        for (int k = 0; k < l->n; k++)
            most = fmax(most, fabs(l->J[i * l->n + k]) * l->unit[k]);
        if (l->use[i] && most > 0) {
            p->size[p->constraints] = most;
            p->constraint[p->constraints++] = i;
        }
    }
}

/* lambda, with pull (n: W (x - y)) + J^T lambda = 0 where x moves. False: no constraints hold it there. floor: pulls, times units, that are none. */
static bool multipliers(struct linear *l, const double *pull, double floor, struct sga_arena *mem)
{
    struct places p;
    find_places(l, &p, mem);
    size_t f = (size_t)p.count, size = f + (size_t)p.constraints;
    double *K = sga_zeros(mem, size * size + 1, sizeof *K), *b = sga_zeros(mem, size + 1, sizeof *b), *z = sga_zeros(mem, size + 1, sizeof *z), most = 0;
    memset(l->lambda, 0, (size_t)l->c * sizeof *l->lambda);
    for (size_t a = 0; a < f; a++) {
        int k = p.moves[a];
        K[a * size + a] = 1;
        b[a] = -pull[k] * l->unit[k];
        most = fmax(most, fabs(b[a]));
        for (size_t i = f; i < size; i++)
            K[a * size + i] = K[i * size + a] = l->J[p.constraint[i - f] * l->n + k] * l->unit[k] / p.size[i - f];
    }
    if (most <= floor)
        return true;
    if (!dependent_solve(K, b, z, (int)size, AGREE * most))
        return false;
    for (size_t a = 0; a < f; a++)
        if (fabs(z[a]) > MISSED * most + floor)
            return false;
    for (size_t i = f; i < size; i++)
        l->lambda[p.constraint[i - f]] = z[i] / p.size[i - f];
    return true;
}

/* s (n; what does not move is known) along direction d: W (n x n) s = push there, and on the constraints. False: they cannot hold. */
static bool move(const struct linear *l, const double *W, const double *push, int d, double *s, struct sga_arena *mem)
{
    struct places p;
    find_places(l, &p, mem);
    size_t f = (size_t)p.count, size = f + (size_t)p.constraints, n = (size_t)l->n, q = (size_t)l->q;
    double *K = sga_zeros(mem, size * size + 1, sizeof *K), *b = sga_zeros(mem, size + 1, sizeof *b), *z = sga_zeros(mem, size + 1, sizeof *z), most = DBL_MIN;
    for (size_t a = 0; a < f; a++) {
        size_t k = (size_t)p.moves[a];
        b[a] = push[k] - l->bent[k * q + (size_t)d];
        for (size_t m = 0; m < n; m++)
            b[a] -= l->free[m] ? 0 : l->H[k * n + m] * s[m];
        for (size_t c = 0; c < f; c++)
            K[a * size + c] = (W[k * n + (size_t)p.moves[c]] + l->H[k * n + (size_t)p.moves[c]]) * l->unit[k] * l->unit[p.moves[c]];
        b[a] *= l->unit[k];
        most = fmax(most, fabs(b[a]));
    }
    for (size_t i = f; i < size; i++) {
        size_t row = (size_t)p.constraint[i - f];
        double sum = -l->by[row * q + (size_t)d], terms = fabs(sum);
        for (size_t a = 0; a < f; a++)
            K[a * size + i] = K[i * size + a] = l->J[row * n + (size_t)p.moves[a]] * l->unit[p.moves[a]] / p.size[i - f];
        for (size_t m = 0; m < n; m++) {
            sum -= l->free[m] ? 0 : l->J[row * n + m] * s[m];
            terms += l->free[m] ? 0 : fabs(l->J[row * n + m] * s[m]);
        }
        b[i] = sum / p.size[i - f];
        most = fmax(most, terms / p.size[i - f]);
    }
    if (!dependent_solve(K, b, z, (int)size, AGREE * most))
        return false;
    for (size_t a = 0; a < f; a++)
        s[p.moves[a]] = z[a] * l->unit[p.moves[a]];
    return true;
}

/* The masses at what was evaluated last into M (n x n), and what they change by along each direction times v (n): push (n x q) loses it. */
static bool masses(struct linear *l, const struct jump_along *a, const double *y, const double *v, double *M, double *push)
{
    struct jump_slope *s = l->s;
    const struct traj_mass *m = a->j->rq->mass;
    int root = s->first - s->masses;
    size_t n = (size_t)l->n, q = (size_t)l->q;
    SGA_ARENA(mem);
    double *g = sga_zeros(&mem, n + 1, sizeof *g);
    if (!jump_slope_at(s, l->t, l->x, y) || !jump_slope_directions(s))
        return false;
    for (int k = 0; k < m->entries; k++) {
        size_t i = (size_t)m->velocity[m->row[k]], j = (size_t)m->velocity[m->col[k]];
        double by_time = jump_slope_gradient(s, root + k, g);
        M[i * n + j] += s->out[root + k];
        for (size_t d = 0; d < q; d++)
            push[i * q + d] -= (s->along[(size_t)(root + k) * q + d] + by_time * l->tau[d]) * v[j];
    }
    return true;
}

/* pull (n): M v; and what it is made of at the most, in units. */
static double pull_of(const struct linear *l, const double *M, const double *v, double *pull)
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
    struct linear l;
    SGA_ARENA(mem);
    if (!linear_at(&l, a, a->to->x, &mem))
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
    if (!multipliers(&l, pull, NONE * most, &mem) || !bend(&l, &mem))
        return false;
    for (size_t d = 0; d < q; d++) {
        memset(pull, 0, n * sizeof *pull);
        for (size_t i = 0; i < n; i++) {
            pull[i] = push[i * q + d];
            for (size_t k = 0; k < n; k++)
                pull[i] += l.free[k] ? M[i * n + k] * y[d * n + k] : 0;
        }
        memcpy(to, y + d * n, n * sizeof *to);
        if (!move(&l, M, pull, (int)d, to, &mem))
            return false;
        memcpy(y + d * n, to, n * sizeof *to);
    }
    return true;
}

/* A start in tiers. */
struct search {
    struct linear l;
    const struct jump_along *a;
    const double *x;
    signed char *tier;
    double *W, *pull, *push, *rate;    /* n x n; n each: W (x - y), what pushes, and by what the units grow */
};

/* The tier's own metric, and what it is pulled by. */
static void weigh(struct search *s, int tier, const double *y)
{
    struct linear *l = &s->l;
    const double *asked = s->a->to->x;
    memset(s->W, 0, (size_t)l->n * (size_t)l->n * sizeof *s->W);
    for (int k = 0; k < l->n; k++) {
        bool own = l->free[k] && s->tier[k] == tier;
        double w = own ? 1 / (l->unit[k] * l->unit[k]) : 0, off = s->x[k] - asked[k];
        s->W[k * l->n + k] = w;
        s->pull[k] = w * off;
        s->push[k] = own ? w * y[k] + 2 * w * off / l->unit[k] * s->rate[k] : 0;
    }
}

/* Direction d (y: n, of what was asked for; becomes that of the start), if the start was found in this stage. */
static bool descend(struct search *s, int d, double *y, struct sga_arena *mem)
{
    struct linear *l = &s->l;
    SGA_ARENA(own);
    double *to = sga_zeros(&own, (size_t)l->n + 1, sizeof *to);
    bool any = false;
    memcpy(to, y, (size_t)l->n * sizeof *to);
    for (int tier = 0; tier < TIERS; tier++) {
        bool has = false;
        for (int k = 0; k < l->n; k++)
            has |= l->free[k] && s->tier[k] == tier;
        if (!has)
            continue;
        weigh(s, tier, y);
        if (!multipliers(l, s->pull, NONE, mem) || !bend(l, mem) || !move(l, s->W, s->push, d, to, mem))
            return false;
        for (int k = 0; k < l->n; k++)
            l->free[k] = l->free[k] && s->tier[k] != tier;
        any = true;
    }
    memset(s->push, 0, (size_t)l->n * sizeof *s->push);
    if (!any && !move(l, s->W, s->push, d, to, mem))
        return false;
    memcpy(y, to, (size_t)l->n * sizeof *y);
    return true;
}

/* Direction d, in the way and stage. */
static bool in_stage(struct search *s, const struct traj_request *rq, const struct sizes *sizes, const unsigned char *kind, enum tiers_stage stage, int d, double *y)
{
    struct linear *l = &s->l;
    const double *asked = s->a->to->x;
    SGA_ARENA(mem);
    s->W = sga_zeros(&mem, (size_t)l->n * (size_t)l->n + 1, sizeof *s->W);
    s->pull = sga_zeros(&mem, 3 * (size_t)l->n + 1, sizeof *s->pull);
    s->push = s->pull + l->n;
    s->rate = s->push + l->n;
    s->tier = sga_zeros(&mem, (size_t)l->n + 1, 1);
    tiers_of(rq, kind, l->n, stage, s->tier);
    for (int k = 0; k < l->n; k++) {
        l->unit[k] = sizes_move(sizes, k, asked[k]);
        s->rate[k] = fabs(asked[k]) / 100 >= l->unit[k] ? (asked[k] < 0 ? -y[k] : y[k]) / 100 : 0;
        l->free[k] = s->tier[k] >= 0;
        if (!l->free[k] && fabs(s->x[k] - asked[k]) > MISSED * l->unit[k])
            return false;
    }
    return descend(s, d, y, &mem);
}

bool jump_least_start(const struct jump_along *a, const double *x, int way, double *y)
{
    struct search s = { .a = a, .x = x };
    int n = a->j->n, q = a->j->slope->q, found = 0;
    SGA_ARENA(mem);
    if (!linear_at(&s.l, a, x, &mem))
        return false;
    unsigned char *kind = sga_zeros(&mem, (size_t)n + 1, 1), *done = sga_zeros(&mem, (size_t)q + 1, 1), *place = sga_zeros(&mem, 2 * (size_t)n + 1, 1);
    sys_kinds(a->j->sys, kind);
    for (; way < JUMP_WAYS && found < q; way++) {
        struct traj_request rq;
        struct sizes sizes;
        memset(place, 0, 2 * (size_t)n);
        jump_request(a->j, a->at, a->to, way, place, &rq);
        sizes_init(&sizes, a->j->sys, &rq);
        int first = tiers_stage_of(&rq, kind, n, x);
        for (int stage = first; stage <= TIERS_MOVE_ALL; stage++)
            for (int d = 0; d < q; d++)
                if (!done[d] && in_stage(&s, &rq, &sizes, kind, (enum tiers_stage)stage, d, y + (size_t)d * (size_t)n)) {
                    done[d] = 1;
                    found++;
                }
        sizes_clear(&sizes);
    }
    return found == q;
}
