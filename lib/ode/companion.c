/* See companion.h.
 *
 * The error is taken along each step by an explicit formula of four stages, at the places where the step itself has looked at the field:
 * at its start, two places inside, and its end. Quadrature is of order 4, and with a constant Jacobian J the error is multiplied by
 * R(h J), R(z) = 1 + z + z^2/2 + a z^3 + a^2 z^4, a = (1 - sqrt(1/2))/2: on the imaginary axis |R|^2 = 1 + a^4 |z|^8 is least above 1, so
 * that what oscillates neither dies out nor grows (1.003 at |z| = 1.5, 1.06 at 2), where formulas of order 4 damp it. */
#include "companion.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "larger.h"
#include "march.h"
#include "mem.h"

/* The formula; places as ode_method.place numbers them. */
static const double C2 = 0.33333333333333333, C3 = 0.65128205128205128;
static const double A31 = 0.1669515046035988, A32 = 0.4843305466784525;
static const double A41 = 0.03216217247853126, A42 = -0.05, A43 = 1.0178378275214688;
static const double B1 = 0.12795276, B2 = 0.35685484, B3 = 0.3846777, B4 = 0.13051471;

/* Parts of a step of series are no longer than this over the largest rate of late; where it turns out to be more, this is still followed,
 * from a few steps on, before which errors are roundings in few variables. */
#define REACH 1.7
#define FAR 3.6
#define FORGET 0.7
enum { MOST_PARTS = 12, UNSETTLED = 3 };
/* How far a step's end was moved onto the manifold is a part of its error, and usually a small one: where it is not, the error was estimated too low. */
#define MOVED 10.0
/* Of the sizes of variables: smaller errors are followed enlarged, so that differences of the field keep their digits; larger ones are
 * none that a linear equation follows. */
#define SMALL 1e-8
#define LARGE 0.1

struct ode_companion {
    int n;
    bool lost;
    const double *noise;
    double *e, *from, *g[4], *y, *at, *k, *end, *size;    /* n each */
    double *rows;              /* count x n */
    double moved;              /* the end of the step, onto the manifold, in units of the error allowed */
    double rate;               /* the largest of late, see rate_of */
    long steps, evaluations;
    double *memory;
};

bool ode_companion_fits(const struct ode_run *run)
{
    const struct ode_problem *p = run->p;
    struct ode_start late;
    if (p->n == 0 || p->implicit || p->events || p->switches || p->break_count || (p->project && !p->tangent))
        return false;
    if (!ode_late_start(run, &late))
        return true;
    free((double *)late.times);
    return false;
}

struct ode_companion *ode_companion_new(const struct ode_run *run, const double *noise)
{
    struct ode_companion *c = sga_calloc(1, sizeof *c);
    size_t n = (size_t)run->p->n;
    c->n = run->p->n;
    c->noise = noise;
    double *at = c->memory = sga_calloc((11 + (size_t)run->start->count) * n + 1, sizeof *c->memory);
    double **vectors[] = { &c->e, &c->from, c->g, c->g + 1, c->g + 2, c->g + 3, &c->y, &c->at, &c->k, &c->end, &c->size };
    for (size_t i = 0; i < sizeof vectors / sizeof *vectors; i++, at += n)
        *vectors[i] = at;
    c->rows = at;
    return c;
}

void ode_companion_free(struct ode_companion *c)
{
    free(c->memory);
    free(c);
}

const double *ode_companion_errors(const struct ode_companion *c) { return c->lost ? NULL : c->rows; }
long ode_companion_evaluations(const struct ode_companion *c) { return c->evaluations; }

void ode_companion_lose(struct ode_companion *c) { c->lost = true; }

/* Samples first .. through - 1 lie at the present point. */
static void keep_rows(struct ode_companion *c, int first, int through)
{
    for (int k = first; k < through; k++)
        memcpy(c->rows + (size_t)k * (size_t)c->n, c->e, (size_t)c->n * sizeof *c->e);
}

static double rounding(const struct ode_companion *c, int j) { return DBL_EPSILON * (c->noise ? c->noise[j] : 1); }

/* A rounding beside the start, as where two solutions are compared. */
void ode_companion_start(struct ode_march *m)
{
    struct ode_companion *c = m->companion;
    for (int j = 0; j < c->n; j++) {
        c->e[j] = m->x[j] * (j * 5 % 3 == 1 ? -DBL_EPSILON : DBL_EPSILON);
        c->size[j] = fabs(m->x[j]);
    }
    keep_rows(c, 0, m->next);
}

/* How much larger than the variables' sizes (which the step may raise) the error is. */
static double part_of_size(struct ode_companion *c, const struct ode_march *m)
{
    double most = 0;
    for (int j = 0; j < c->n; j++) {
        c->size[j] = sga_larger(c->size[j], sga_larger(fabs(m->x1[j]), fabs(m->step.h * m->f[j])));
        double a = fabs(c->e[j]);
        if (a > most * c->size[j])
            most = c->size[j] > 0 ? a / c->size[j] : most;
    }
    return most;
}

/* How fast the error changed in the last part: sqrt(|J J e| / |e|), in which the sizes of variables and their rates cancel. */
static double rate_of(const struct ode_companion *c, double h)
{
    double up = 0, down = 0;
    for (int j = 0; j < c->n; j++) {
        double part = c->size[j] > 0 ? 1 / c->size[j] : 0, a = (c->g[1][j] - c->g[0][j]) * part, b = c->from[j] * part;
        up += a * a;
        down += b * b;
    }
    return down > 0 ? sqrt(sqrt(up / down) / (C2 * fabs(h))) : 0;
}

/* One part of a step. */
struct part {
    struct ode_march *m;
    double theta, share;       /* where it begins, and how long it is, of the step */
    double h, large;           /* signed; e is followed times `large` */
    struct ode_code code;
    bool coded;
};

/* g = (X(t, y + large v) - k) / large. False: refused. */
static bool slope(const struct part *q, int stage, double theta, const double *y, const double *k, const double *v, double *g)
{
    struct ode_march *m = q->m;
    struct ode_companion *c = m->companion;
    double t = m->t + (m->t_low + theta * m->step.h), part = 1 / q->large;
    for (int j = 0; j < c->n; j++)
        c->y[j] = y[j] + q->large * v[j];
    c->evaluations++;
    if (q->coded) {
        *q->code.time = t;
        q->code.run(q->code.slots, g, q->code.rest + (size_t)stage * q->code.rests, c->y);
    } else if (!m->p->rhs(m->p->ctx, t, c->y, g)) {
        return false;
    }
    for (int j = 0; j < c->n; j++)
        g[j] = (g[j] - k[j]) * part;
    return true;
}

/* The state and the field at one of the formula's places inside the step. */
static void place(const struct part *q, int which, double part)
{
    const struct ode_march *m = q->m;
    m->method->place(m->state, &m->step, which, q->theta + part * q->share, m->companion->at, m->companion->k);
}

/* After the first slope: c->e becomes the error at the end of the part. False: refused. */
static bool follow(const struct part *q)
{
    struct ode_companion *c = q->m->companion;
    double h = q->h, *const *g = c->g, *v = c->end;
    place(q, 1, C2);
    for (int j = 0; j < c->n; j++)
        v[j] = c->e[j] + h * C2 * g[0][j];
    if (!slope(q, 1, q->theta + C2 * q->share, c->at, c->k, v, g[1]))
        return false;
    place(q, 2, C3);
    for (int j = 0; j < c->n; j++)
        v[j] = c->e[j] + h * (A31 * g[0][j] + A32 * g[1][j]);
    if (!slope(q, 2, q->theta + C3 * q->share, c->at, c->k, v, g[2]))
        return false;
    place(q, 3, 1);
    for (int j = 0; j < c->n; j++)
        v[j] = c->e[j] + h * (A41 * g[0][j] + A42 * g[1][j] + A43 * g[2][j]);
    if (!slope(q, 3, q->theta + q->share, c->at, c->k, v, g[3]) || (q->coded && !q->m->p->code_holds(q->m->p->ctx, 4)))
        return false;
    for (int j = 0; j < c->n; j++)
        c->e[j] += h * (B1 * g[0][j] + B2 * g[1][j] + B3 * g[2][j] + B4 * g[3][j]);
    return true;
}

/* Samples inside the part: between the errors at its ends, with the slope at its start. */
static int inside(const struct part *q, int k, int through)
{
    const struct ode_march *m = q->m;
    const struct ode_companion *c = m->companion;
    for (; k < through; k++) {
        double theta = ((m->start->times[k] - m->t) - m->t_low) / m->step.h, s = (theta - q->theta) / q->share;
        if (s > 1 - 1e-12)
            break;
        double *row = c->rows + (size_t)k * (size_t)c->n;
        for (int j = 0; j < c->n; j++) {
            double rise = q->h * c->g[0][j];
            row[j] = c->from[j] + s * (rise + s * (c->e[j] - c->from[j] - rise));
        }
    }
    return k;
}

/* The whole step in parts. False: refused, or the error changes too fast to be followed. */
static bool follow_step(struct ode_march *m, double large, int through)
{
    struct ode_companion *c = m->companion;
    struct part q = { .m = m, .large = large };
    int parts = m->method->series ? 1 + (int)sga_smaller(c->rate * fabs(m->step.h) / REACH, MOST_PARTS) : 1, next = m->next;
    q.share = 1.0 / parts;
    q.h = m->step.h * q.share;
    q.coded = m->p->code && m->p->code(m->p->ctx, &q.code);
    for (int i = 0; i < parts; i++) {
        if (!slope(&q, 0, q.theta, i ? c->at : m->x, i ? c->k : m->f, c->e, c->g[0]))
            return false;
        sga_copy(c->from, c->e, c->n);
        if (!follow(&q))
            return false;
        double rate = rate_of(c, q.h);
        c->rate = sga_larger(FORGET * c->rate, rate);
        if (c->steps > UNSETTLED && !(rate * fabs(q.h) < FAR))
            return false;
        next = inside(&q, next, through);
        q.theta += q.share;
    }
    return true;
}

/* What the step itself adds: the error that its method tells, and roundings, to the side where the error is already. */
static void add_own(struct ode_march *m)
{
    struct ode_companion *c = m->companion;
    double walk = m->p->project ? DBL_EPSILON / sqrt((double)c->steps) : 0, more = 1;
    m->method->missed(m->state, &m->step, c->end);
    if (m->p->project && !m->method->series && MOVED * c->moved > m->step.error)
        more = m->step.error > 0 ? MOVED * c->moved / m->step.error : 1;
    for (int j = 0; j < c->n; j++) {
        c->end[j] *= more;
        double e = c->e[j] + c->end[j];
        c->e[j] = e + copysign(rounding(c, j) * fabs(m->dx[j]) + walk * fabs(m->x1[j]), e);
    }
}

static bool all_finite(const struct ode_companion *c)
{
    double s = 0;
    for (int j = 0; j < c->n; j++)
        s += 0 * c->e[j];
    return s == 0;
}

void ode_companion_step(struct ode_march *m, int through)
{
    struct ode_companion *c = m->companion;
    if (c->lost)
        return;
    double part = part_of_size(c, m);
    c->lost = true;
    c->moved = m->end_moved;
    c->steps++;
    if (!m->method->missed || m->late || !(part < LARGE) || (part > 0 && !follow_step(m, part < SMALL ? SMALL / part : 1, through)))
        return;
    int inner = through;
    while (inner > m->next && m->start->times[inner - 1] == m->t1)
        inner--;
    add_own(m);
    for (int k = m->next; k < inner; k++) {      /* a series errs by its next term; other polynomials by as much as the step does */
        double theta = ((m->start->times[k] - m->t) - m->t_low) / m->step.h, share = m->method->series ? pow(theta, m->step.error_order + 1) : 1;
        for (int j = 0; j < c->n; j++)
            c->rows[(size_t)k * (size_t)c->n + (size_t)j] += share * c->end[j];
    }
    if (!all_finite(c) || (m->p->project && !m->p->tangent(m->p->ctx, m->t1, m->x1, m->scale, c->e)))
        return;
    c->lost = false;
    keep_rows(c, inner, through);
}
