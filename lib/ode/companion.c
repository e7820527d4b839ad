/* See companion.h. */
#include "companion.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "larger.h"
#include "march.h"
#include "mem.h"

/* Of its size, by which a variable is another for a difference; and from which on a distance is no longer small. */
#define BY 1e-7
#define FAR 1e-3
/* What the last two terms of a distance's series may be, of itself and of what a step adds to it: of long motions it is the small part that is new which
 * grows later, beside a large one that does not. Where they are a part of that the next series is shorter. */
#define MISSED 0.02
#define MISSED_OF_NEW 0.1
#define AMPLE 5e-3
/* Where that takes more terms than there are the problem is stiff, and other methods take over soon: after so many steps distances are given up. */
enum { STRAINED = 16 };
enum { FIRST_ORDER = 4, LEAST_ORDER = 3, MORE = 3, LEFT_OUT = 2 };
/* What the terms do not tell: the field at the end of a step is missed by so many times what the next term makes. */
#define DEFECT 10.0

struct ode_companion {
    int n, order;                  /* of the series of distances */
    bool lost;
    int strained;                  /* steps of late whose distance had too few terms */
    double *e, *e1;                /* n: at the begin of a step, at its end */
    double near, by;               /* how far e is off, in sizes of variables; it is made larger by so many times, 0: it is 0 */
    double *y, *part, *rest, *left;      /* n: a point beside; 1 / sizes of variables; what is left out beside the last terms; all that is left out */
    double *series;                /* of the point beside */
    double *apart;                 /* count x n */
};

bool ode_companion_goes_with(const struct ode_problem *p)
{
    return p->taylor && p->n > 0 && !p->switches && !p->events && !p->turned && !p->implicit;
}

bool ode_companion_may(const struct ode_run *run)
{
    bool series = run->series || (run->o.method && strcmp(run->o.method, ode_taylor.name) == 0);
    return series && ode_companion_goes_with(run->p) && !ode_is_late(run);
}

struct ode_companion *ode_companion_begin(const struct ode_march *m)
{
    size_t n = (size_t)m->p->n, count = (size_t)m->start->count;
    struct ode_companion *c = sga_calloc(1, sizeof *c);
    c->n = m->p->n;
    c->order = FIRST_ORDER;
    c->e = sga_calloc((6 + (size_t)ode_taylor.order + 1) * n + 1, sizeof *c->e);
    c->e1 = c->e + n;
    c->y = c->e1 + n;
    c->part = c->y + n;
    c->rest = c->part + n;
    c->left = c->rest + n;
    c->series = c->left + n;
    c->apart = sga_calloc(count * n + 1, sizeof *c->apart);
    for (size_t j = 0; j < n; j++)
        c->e[j] = (j * 5 % 3 == 1 ? -DBL_EPSILON : DBL_EPSILON) * m->x[j];
    for (int k = 0; k < m->next; k++)
        memcpy(c->apart + (size_t)k * n, c->e, n * sizeof *c->e);
    return c;
}

/* y = x less e, made larger so that roundings do not matter; by how many times, 0 where e is 0, -1 where e is large. */
static double beside(struct ode_companion *c, const double *unit, const double *x, const double *e)
{
    double near = 0;
    for (int j = 0; j < c->n; j++) {
        c->part[j] = 1 / sga_larger(fabs(x[j]), unit[j]);
        near = sga_larger(near, fabs(e[j]) * c->part[j]);
    }
    c->near = near;
    if (!(near <= FAR))
        return -1;
    double by = !(near > 0) ? 0 : near < BY ? BY / near : 1;
    for (int j = 0; j < c->n; j++)
        c->y[j] = x[j] - by * e[j];
    return by;
}

static double power_of(double s, int k)
{
    double power = 1;
    for (; k; k >>= 1, s *= s)
        power *= k & 1 ? s : 1;
    return power;
}

/* The term of order k of the distance, made larger, in units of its size at the begin. */
static double term(const struct ode_companion *c, const struct ode_series *of, int k, double s)
{
    const double *a = of->row + (size_t)k * (size_t)c->n, *b = c->series + (size_t)k * (size_t)c->n;
    double most = 0;
    for (int j = 0; j < c->n; j++)
        most = sga_larger(most, fabs(a[j] - b[j]) * c->part[j]);
    return most * power_of(s, k) / (c->near * c->by);
}

/* What the last terms do not tell of a step: that the field is wrong by a rounding, and is missed at the end. */
static void set_rest(struct ode_companion *c, const struct ode_march *m, const struct ode_series *of)
{
    double h = fabs(m->step.h);
    const double *noise = m->field.noise;
    for (int j = 0; j < c->n; j++) {
        double size = fabs(of->field[j]), miss = fabs(of->slope[j] - of->field[j]) - ODE_FIELD_ROUNDING * DBL_EPSILON * size;
        c->rest[j] = h * ((miss > 0 ? DEFECT * miss / (of->order + 1) : 0) + DBL_EPSILON * (noise ? noise[j] : 1) * size);
    }
}

/* What the companion leaves out up to s, of which end is the end of the step. */
static void leave_out(struct ode_companion *c, const struct ode_series *of, double s, double end)
{
    size_t n = (size_t)c->n;
    const double *last = of->row + (size_t)of->order * n;
    double power = power_of(s, of->order - LEFT_OUT + 1), along = s / end;
    for (size_t j = 0; j < n; j++) {
        double a = (last[j - n] + last[j] * s) * power;
        c->left[j] = a + copysign(c->rest[j] * along, a);
    }
}

static double largest(const struct ode_companion *c, const double *v)
{
    double most = 0;
    for (int j = 0; j < c->n; j++)
        most = sga_larger(most, fabs(v[j]) * c->part[j]);
    return most;
}

/* The series of the point beside, on the scale of the solution's; s: the end of the step on it, up to which c->left is. False: there is none. */
static bool expand(struct ode_companion *c, struct ode_march *m, const struct ode_series *of, double s)
{
    const struct ode_problem *p = m->p;
    double reach, last = INFINITY, most = c->by > 0 ? fmin(MISSED, MISSED_OF_NEW * largest(c, c->left) / c->near) : 0;
    c->order = c->order < of->order ? c->order : of->order;
    while (c->by > 0) {
        m->res->stats.evaluations += c->order;
        if (!p->taylor(p->ctx, m->t + m->t_low, c->y, c->order, of->scale, c->series, &reach))
            return false;
        last = sga_larger(term(c, of, c->order, s), term(c, of, c->order - 1, s));
        if (last <= most || c->order == of->order)
            break;
        c->order = c->order + MORE < of->order ? c->order + MORE : of->order;
    }
    c->strained = last > MISSED && c->by > 0 ? c->strained + 1 : c->strained > 0 ? c->strained - 1 : 0;
    c->order -= last < AMPLE * most && c->order > LEAST_ORDER;          /* the last term is small enough to be missed now, too */
    return c->by >= 0 && c->strained <= STRAINED;
}

/* The distance at s, up to which c->left is. */
static void distance_at(const struct ode_companion *c, const struct ode_series *of, double s, double *e)
{
    size_t n = (size_t)c->n;
    double part = c->by > 0 ? 1 / c->by : 0;
    for (size_t j = 0; j < n; j++) {
        double v = 0;
        for (size_t k = (size_t)c->order + 1, at = (size_t)c->order * n + j; k-- > 0 && part > 0; at -= n)
            v = v * s + (of->row[at] - c->series[at]);
        e[j] = v * part + c->left[j];
    }
}

/* e1 for the point that x1 - e1 is moved to on the manifold. */
static bool settle(struct ode_companion *c, struct ode_march *m)
{
    const struct ode_problem *p = m->p;
    double moved, residual, by = p->project ? beside(c, m->unit, m->x1, c->e1) : 0;
    if (by <= 0)
        return by == 0;
    for (int j = 0; j < c->n; j++)
        m->scale[j] = ode_allowed(m->o->rtol, m->o->atol, m->unit[j], c->y[j], c->y[j]);
    m->res->stats.projections++;
    double part = 1 / by;
    if (!p->project(p->ctx, m->t1, c->y, m->scale, &moved, &residual))
        return false;
    for (int j = 0; j < c->n; j++)
        c->e1[j] = (m->x1[j] - c->y[j]) * part;
    return true;
}

static bool follow(struct ode_companion *c, struct ode_march *m, int through)
{
    if (!m->method->series)
        return false;
    struct ode_series of = ode_taylor_series(m->state);
    double end = m->step.h / of.scale;
    assert(end > 0 && of.order >= LEFT_OUT);
    c->by = beside(c, m->unit, m->x, c->e);
    set_rest(c, m, &of);
    leave_out(c, &of, end, end);
    if (!expand(c, m, &of, end))
        return false;
    distance_at(c, &of, end, c->e1);
    int k = m->next;
    for (double at; k < through && (at = ((m->start->times[k] - m->t) - m->t_low) / of.scale) < end; k++) {
        leave_out(c, &of, at, end);
        distance_at(c, &of, at, c->apart + (size_t)k * (size_t)c->n);
    }
    if (!settle(c, m))
        return false;
    for (; k < through; k++)
        memcpy(c->apart + (size_t)k * (size_t)c->n, c->e1, (size_t)c->n * sizeof *c->e1);
    double *before = c->e;
    c->e = c->e1;
    c->e1 = before;
    return true;
}

void ode_companion_step(struct ode_companion *c, struct ode_march *m, int through)
{
    if (c && !c->lost)
        c->lost = !follow(c, m, through);
}

void ode_companion_lose(struct ode_companion *c)
{
    if (c)
        c->lost = true;
}

bool ode_companion_lost(const struct ode_companion *c)
{
    return c && c->lost;
}

double *ode_companion_end(struct ode_companion *c)
{
    if (!c)
        return NULL;
    double *apart = c->apart, *memory = c->e < c->e1 ? c->e : c->e1;
    if (c->lost) {
        free(apart);
        apart = NULL;
    }
    free(memory);
    free(c);
    return apart;
}
