/* See companion.h.
 *
 * The error is taken along each step by a Runge-Kutta formula of four stages and order 4, at the places where the step itself has looked at the
 * field: at its start, two places inside, and its end. Steps are long for such a formula, which would damp what oscillates, and shift it.
 * Where a second application of the Jacobian J gives back a multiple of the error, J^2 e = s e, as with one frequency or one rate, the whole
 * flow is known: exp(h J) e = C(h^2 s) e + S(h^2 s) h J e with the series of cosh and sinh. Their terms beyond those of the formula are added, s
 * being the least-squares fit. */
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
static const double A31 = -0.28055226824457735, A32 = 0.9318343195266287;
static const double A41 = 0.8958633691915259, A42 = -0.9236710586097189, A43 = 1.0278076894181931;
static const double B1 = 0.12795275590551164, B2 = 0.3568548387096781, B3 = 0.38467769950245723, B4 = 0.13051470588235309;

/* Parts of a step of series are no longer than this over the largest rate of late; where it turns out to be more, this is still followed,
 * from a few steps on, before which errors are roundings in few variables. */
#define REACH 1.4
#define FAR 3.6
#define FORGET 0.7
/* How errors are forgotten, from step to step. */
#define LATELY 0.9
/* So many parts of the whole motion may be as long as that: more are to be shorter, by the eighth root. */
#define MANY 200.0
enum { MOST_PARTS = 12, UNSETTLED = 3, FIRST_PARTS = 4 };
/* How far a step's end was moved onto the manifold is a part of its error, and usually a small one: where it is not, the error was estimated too low. */
#define MOVED 10.0
/* Of the size that a Runge-Kutta step's error is estimated to have, what it is to be taken for: measured. */
#define RUNGE_KUTTA 0.6
/* Of the sizes of variables: smaller errors are followed enlarged, so that differences of the field keep their digits; larger ones are
 * none that a linear equation follows. */
#define SMALL 1e-8
#define LARGE 0.1

struct ode_companion {
    int n;
    bool lost;
    const double *noise;
    double *e, *from, *g[4], *y, *at, *k, *end, *size, *late;    /* n each */
    double *rows;              /* count x n */
    double moved;              /* the end of the step, onto the manifold, in units of the error allowed */
    double rate;               /* the largest of late, see rate_of */
    long steps, parts, evaluations;
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
    double *at = c->memory = sga_calloc((12 + (size_t)run->start->count) * n + 1, sizeof *c->memory);
    double **vectors[] = { &c->e, &c->from, c->g, c->g + 1, c->g + 2, c->g + 3, &c->y, &c->at, &c->k, &c->end, &c->size, &c->late };
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

/* Samples first .. through - 1: errors come to 0 in passing, here and in truth at other times, so that what they were of late counts too. */
static void raise_rows(struct ode_companion *c, int first, int through)
{
    for (int k = first; k < through; k++)
        for (int j = 0; j < c->n; j++) {
            double *e = c->rows + (size_t)k * (size_t)c->n + (size_t)j;
            *e = copysign(sga_larger(fabs(*e), c->late[j]), *e);
        }
}

/* They lie at the present point. */
static void keep_rows(struct ode_companion *c, int first, int through)
{
    for (int k = first; k < through; k++)
        memcpy(c->rows + (size_t)k * (size_t)c->n, c->e, (size_t)c->n * sizeof *c->e);
    raise_rows(c, first, through);
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

/* How fast the error changes: sqrt(|J J e| / |e|), in which the sizes of variables and their rates cancel; *square: h^2 s. After the second slope. */
static double rate_of(const struct ode_companion *c, double h, double *square)
{
    double up = 0, down = 0, both = 0;
    for (int j = 0; j < c->n; j++) {
        double part = c->size[j] > 0 ? 1 / c->size[j] : 0, a = (c->g[1][j] - c->g[0][j]) * part, b = c->from[j] * part;
        up += a * a;
        down += b * b;
        both += a * b;
    }
    *square = down > 0 ? both / down * (h / C2) : 0;
    return down > 0 ? sqrt(sqrt(up / down) / (C2 * fabs(h))) : 0;
}

/* How long parts of the present step are to be, of the inverse of the rate. */
static double reach(const struct ode_companion *c, const struct ode_march *m)
{
    double way = fabs(m->t - m->start->t), all = way > 0 ? (double)c->parts * (fabs(m->stop - m->start->t) / way) : 0;
    return all > MANY ? REACH * sqrt(sqrt(sqrt(MANY / all))) : REACH;
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
    double s, rate = rate_of(c, h, &s);
    if (c->steps > UNSETTLED && !(rate * fabs(h) < FAR))
        return false;
    s = fabs(s) < FAR * FAR ? s : 0;
    double cosine = s * s * s / 720 * (1 + s / 56 * (1 + s / 90 * (1 + s / 132))), sine = h * s * s / 120 * (1 + s / 42 * (1 + s / 72 * (1 + s / 110)));
    for (int j = 0; j < c->n; j++)
        c->e[j] += h * (B1 * g[0][j] + B2 * g[1][j] + B3 * g[2][j] + B4 * g[3][j]) + (cosine * c->e[j] + sine * g[0][j]);
    c->rate = sga_larger(FORGET * c->rate, rate);
    c->parts++;
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
    int parts = m->method->series ? (c->parts ? 1 : FIRST_PARTS) + (int)sga_smaller(c->rate * fabs(m->step.h) / reach(c, m), MOST_PARTS) : 1, next = m->next;
    q.share = 1.0 / parts;
    q.h = m->step.h * q.share;
    q.coded = m->p->code && m->p->code(m->p->ctx, &q.code);
    for (int i = 0; i < parts; i++) {
        if (!slope(&q, 0, q.theta, i ? c->at : m->x, i ? c->k : m->f, c->e, c->g[0]))
            return false;
        sga_copy(c->from, c->e, c->n);
        if (!follow(&q))
            return false;
        next = inside(&q, next, through);
        q.theta += q.share;
    }
    return true;
}

/* Of a Runge-Kutta step's error (c->end) the size is estimated, and a line that another formula's error has. Its senses are such that it adds to
 * the error, along the field (where errors are shifts in phase, which hide the others) and across it, so that nothing cancels by accident. */
static void turn(struct ode_companion *c, const struct ode_march *m)
{
    double ff = 0, lf = 0, ef = 0, le = 0;
    for (int j = 0; j < c->n; j++) {
        double part = c->size[j] > 0 ? 1 / c->size[j] : 0, f = m->f1[j] * part, l = c->end[j] * part, e = c->e[j] * part;
        ff += f * f;
        lf += l * f;
        ef += e * f;
        le += l * e;
    }
    double along = ff > 0 ? lf / ff : 0, across = le - along * ef, size = RUNGE_KUTTA;
    if (m->p->project && MOVED * c->moved > m->step.error && m->step.error > 0)      /* it is no smaller than the projection says */
        size *= MOVED * c->moved / m->step.error;
    double forth = along * ef < 0 ? -size : size, aside = across < 0 ? -size : size;
    for (int j = 0; j < c->n; j++)
        c->end[j] = aside * c->end[j] + (forth - aside) * along * m->f1[j];
}

/* What the step itself adds: the error that its method tells; what a field wrong by a rounding adds, on purpose, as where two solutions are compared;
 * and the roundings of the step, which go here and there, to the side where the error is already. */
static void add_own(struct ode_march *m)
{
    struct ode_companion *c = m->companion;
    double walk = 1 / sqrt((double)c->steps), moved = m->p->project ? DBL_EPSILON : 0;
    m->method->missed(m->state, &m->step, c->end);
    if (!m->method->series)
        turn(c, m);
    for (int j = 0; j < c->n; j++) {
        double wrong = rounding(c, j) * m->dx[j], e = c->e[j] + c->end[j] + (j % 2 ? -wrong : wrong);
        c->e[j] = e + copysign(walk * (fabs(wrong) + moved * fabs(m->x1[j])), e);
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
    for (int j = 0; j < c->n; j++)
        c->late[j] = sga_larger(fabs(c->e[j]), LATELY * c->late[j]);
    raise_rows(c, m->next, inner);
    keep_rows(c, inner, through);
}
