/* One solution by Taylor series in double-double. As lib/ode/taylor.c, and simpler: steps end
 * where the series wants them to, samples are values of the polynomial. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "precise.h"

#define LEAST_ORDER 8
#define MOST_ORDER 40
#define LAST_TERMS 3
#define EXPECTED_FALL 0.2
#define SAFETY 0.95
/* Steps this small against the time passed end a march that shrinks them. */
#define SMALLEST 1e-25
/* Places of ranks and domains are found in double. */
#define SMALLEST_REFUSED 4e-16
#define HUGE_STATE 1e280        /* products of halves overflow not far beyond */
#define LOOK_EVERY 500
#define LOOKS 4
#define BEYOND_HOPE 2.0
#define SCALES 4               /* tries of a scale on which the series is finite */

struct place {
    num_dd t, *x, *series, reach;     /* series: (order + 1) x n */
    double scale;
};

struct march {
    struct precise *p;
    struct precise_path *path;
    int n, order, next;
    double rtol, atol, direction, first_size;
    bool beside;
    struct place here, there;
    long look_at; num_dd look_t; int hopeless;     /* see out_of_reach */
    double *scale;             /* n: the error allowed */
    num_dd *slope;             /* n */
    enum ode_reason why;
    double *xd, *fd;           /* n: in double */
};

static void set_scale(struct march *m, const num_dd *x)
{
    for (int j = 0; j < m->n; j++)
        m->scale[j] = fmax(m->atol + m->rtol * fabs(x[j].hi), 1e-300);
}

/* Root mean square in units of the error allowed; v may be so large that squares overflow. */
static double weighted(const struct march *m, const num_dd *v)
{
    double most = 0, sum = 0;
    for (int j = 0; j < m->n; j++)
        most = fmax(most, fabs(v[j].hi) / m->scale[j]);
    if (!(most > 0) || isinf(most))
        return most;
    for (int j = 0; j < m->n; j++)
        sum += pow(fabs(v[j].hi) / m->scale[j] / most, 2);
    return most * sqrt(sum / m->n);
}

static bool series_at(struct march *m, struct place *q)
{
    struct num_jet2 *jet = m->p->series;
    int n = m->n;
    num_dd *time = num_jet2_input(jet, n);
    memset(time, 0, (size_t)(m->order + 1) * sizeof *time);
    time[0] = q->t;
    time[1] = num_dd_of(q->scale);
    for (int j = 0; j < n; j++)
        q->series[j] = num_jet2_input(jet, j)[0] = q->x[j];
    for (int k = 0; k < m->order; k++) {
        if (!num_jet2_next(jet, k))
            return false;
        for (int j = 0; j < n; j++) {
            num_dd c = num_dd_div(num_dd_scale(num_jet2_root(jet, j)[k], q->scale), num_dd_of(k + 1));
            if (m->beside)
                c = num_dd_mul(c, (num_dd){ 1, j % 2 ? -NUM_DD_EPSILON : NUM_DD_EPSILON });
            num_jet2_input(jet, j)[k + 1] = q->series[(size_t)(k + 1) * (size_t)n + (size_t)j] = c;
        }
    }
    q->reach = num_jet2_reach(jet, m->order - 1);
    return true;
}

/* The series at q on a scale near the size, or below where it overflows there. */
static bool expand(struct march *m, struct place *q, double size)
{
    int e;
    frexp(size, &e);
    q->scale = ldexp(m->direction, e);
    for (int turn = 0; turn < SCALES; turn++, q->scale *= 1.0 / 256) {
        m->path->evaluations += m->order;
        if (series_at(m, q))
            return true;
    }
    return false;
}

/* The field has a value at q that the rank and the pivots' signs allow. */
static bool allowed(struct march *m, const struct place *q)
{
    struct flow *f = m->p->flow;
    for (int j = 0; j < m->n; j++)
        m->xd[j] = q->x[j].hi;
    if (field_eval(&f->field, q->t.hi, m->xd, m->fd))
        return true;
    m->why = f->field.rank_lost || f->field.contradiction ? ODE_SINGULAR : ODE_LEFT_DOMAIN;
    return false;
}

/* The polynomial at s; slope (or NULL): its derivative by s. */
static void polynomial(const struct march *m, const struct place *q, num_dd s, num_dd *x, num_dd *slope)
{
    for (int j = 0; j < m->n; j++) {
        num_dd v = num_dd_of(0), d = num_dd_of(0);
        for (int k = m->order; k > 0; k--) {
            num_dd c = q->series[(size_t)k * (size_t)m->n + (size_t)j];
            v = num_dd_mul(num_dd_add(v, c), s);
            if (slope)
                d = num_dd_add(num_dd_mul(d, s), num_dd_mul_d(c, k));
        }
        x[j] = num_dd_add(q->series[j], v);
        if (slope)
            slope[j] = d;
    }
}

/* Up to which s the last terms are within tolerance. */
static double last_terms(struct march *m)
{
    double fall = EXPECTED_FALL, s = INFINITY;
    set_scale(m, m->here.x);
    for (int i = 0; i < LAST_TERMS; i++, fall *= EXPECTED_FALL) {
        double e = fall * weighted(m, m->here.series + (size_t)(m->order - i) * (size_t)m->n);
        if (!(e <= 0))
            s = fmin(s, pow(e, -1.0 / (m->order - i)));
    }
    return s;
}

/* The polynomial's derivative at the end against the field there, in units of what a step may do. */
static double defect(struct march *m, num_dd s)
{
    double h = fabs(m->here.scale) * s.hi, sum = 0, size = 0;
    for (int j = 0; j < m->n; j++) {
        num_dd f = num_dd_div(m->there.series[m->n + j], num_dd_of(m->there.scale));
        double miss = num_dd_sub(num_dd_div(m->slope[j], num_dd_of(m->here.scale)), f).hi * h / m->scale[j];
        sum += miss * miss;
        size += (f.hi * h / m->scale[j]) * (f.hi * h / m->scale[j]);
    }
    return fmax(0, sqrt(sum / m->n) - 500 * NUM_DD_EPSILON * sqrt(size / m->n)) / (m->order + 1);
}

/* How far the projection may move a point without spoiling it. */
static double most_moved(const struct march *m)
{
    double sum = 0;
    for (int j = 0; j < m->n; j++)
        sum += pow(NUM_DD_EPSILON * m->there.x[j].hi / m->scale[j], 2);
    return 10 + 1000 * sqrt(sum / m->n);
}

enum outcome { TAKEN, TOO_LARGE, REFUSED };

static enum outcome attempt(struct march *m, num_dd s, double *miss)
{
    double moved, residual;
    polynomial(m, &m->here, s, m->there.x, m->slope);
    m->there.t = num_dd_add(m->here.t, num_dd_scale(s, m->here.scale));
    m->why = ODE_LEFT_DOMAIN;
    if (!precise_project(m->p, m->there.t, m->there.x, m->scale, NULL, &moved, &residual))
        return REFUSED;
    m->why = ODE_CONSTRAINT_LOST;
    if (!(moved <= most_moved(m)))
        return REFUSED;
    if (!allowed(m, &m->there))
        return REFUSED;
    m->why = ODE_LEFT_DOMAIN;
    if (!expand(m, &m->there, 2 * fabs(m->here.scale) * s.hi))
        return REFUSED;
    *miss = defect(m, s);
    return *miss <= 1 ? TAKEN : TOO_LARGE;
}

/* Samples up to s. False: one of them cannot be projected. */
static bool deliver(struct march *m, num_dd s)
{
    const struct precise *p = m->p;
    for (; m->next < p->rq->samples; m->next++) {
        num_dd at = num_dd_div(num_dd_sub(p->time[m->next], m->here.t), num_dd_of(m->here.scale));
        double moved, residual;
        if (num_dd_less(s, at))
            return true;
        num_dd *x = m->path->sample + (size_t)m->next * (size_t)m->n;
        polynomial(m, &m->here, at, x, NULL);
        if (!precise_project(m->p, p->time[m->next], x, m->scale, NULL, &moved, &residual) || !(moved <= most_moved(m)))
            return false;
        m->path->residual = fmax(m->path->residual, residual);
    }
    return true;
}

static void end_at(struct march *m, enum ode_reason reason, const char *detail)
{
    m->path->reason = reason;
    m->path->t = m->here.t.hi;
    snprintf(m->path->detail, sizeof m->path->detail, "%.255s", detail);
}

static double largest(const num_dd *x, int n)
{
    double most = 0;
    for (int j = 0; j < n; j++)
        most = fmax(most, fabs(x[j].hi));
    return most;
}

/* The derivative is far larger than the state over the time passed: a scale of its own that goes to 0. */
static bool grows_now(const struct march *m, double size, double *rate)
{
    double passed = fabs(num_dd_sub(m->here.t, m->p->start).hi);
    *rate = m->path->steps ? largest(m->here.series + m->n, m->n) / fabs(m->here.scale) : 0;
    return *rate * passed > 1e3 * fmax(fmax(size, m->first_size), 1e-300);
}

static void end_refused(struct march *m, bool refused)
{
    double size = largest(m->here.x, m->n), rate;
    char text[200];
    bool grows = grows_now(m, size, &rate) && !(refused && m->why != ODE_LEFT_DOMAIN);
    if (size > HUGE_STATE) {
        snprintf(text, sizeof text, "the solution grows beyond the range of numbers (size %.3g at the end)", size);
        end_at(m, ODE_BLOW_UP, text);
    } else if (size > 1e3 * (m->first_size + 1) && !(refused && m->why == ODE_SINGULAR)) {
        snprintf(text, sizeof text, "the solution grows without bound (size %.3g at the end)", size);
        end_at(m, ODE_BLOW_UP, text);
    } else if (grows) {
        snprintf(text, sizeof text, "the derivative grows without bound (size %.3g) while the solution stays at size %.3g", rate, size);
        end_at(m, ODE_BLOW_UP, text);
    } else if (!refused) {
        end_at(m, ODE_NOT_SMOOTH, "no step is small enough for the tolerance here: the field is not smooth, or the tolerance is too tight");
    } else {
        end_at(m, m->why, m->why == ODE_SINGULAR ? "a rank drops here: the field or the constraints are singular"
                          : m->why == ODE_LEFT_DOMAIN ? "the vector field has no series beyond this time"
                          : "no point near the solution satisfies the constraints beyond this time");
    }
}

/* At this pace the stop would take far more steps than are allowed, look after look? */
static bool out_of_reach(struct march *m)
{
    double progress = fabs(num_dd_sub(m->here.t, m->look_t).hi);
    double rest = fabs(num_dd_sub(m->p->time[m->p->rq->samples - 1], m->here.t).hi);
    m->hopeless = rest / fmax(progress, 1e-300) * LOOK_EVERY > BEYOND_HOPE * (double)m->p->max_steps ? m->hopeless + 1 : 0;
    m->look_t = m->here.t;
    m->look_at += LOOK_EVERY;
    return m->hopeless >= LOOKS;
}

static bool may_go_on(struct march *m)
{
    struct precise_path *q = m->path;
    struct sga_error err = { 0 };
    if (!sga_budget_ok(m->p->rq->budget, &err)) {
        end_at(m, err.code == SGA_E_CANCELLED ? ODE_CANCELLED : ODE_TIME_LIMIT, err.detail);
        return false;
    }
    if (q->steps + q->refused >= m->p->max_steps) {
        end_at(m, ODE_STEP_LIMIT, "the limit of steps was reached; ask for an earlier stop or larger tolerances");
        return false;
    }
    if (q->steps >= m->look_at && out_of_reach(m)) {
        end_at(m, ODE_STEP_LIMIT, "the last time is out of reach: if the system is stiff, ask for arithmetic \"double\", which has an "
               "implicit method; otherwise for an earlier stop");
        return false;
    }
    return true;
}

static bool begin(struct march *m)
{
    const struct precise *p = m->p;
    double moved, residual, span = fabs(num_dd_sub(p->time[p->rq->samples - 1], p->start).hi);
    memcpy(m->here.x, p->x, (size_t)m->n * sizeof *p->x);
    m->here.t = m->look_t = p->start;
    m->look_at = LOOK_EVERY;
    m->path->t = p->start.hi;
    m->first_size = largest(p->x, m->n);
    set_scale(m, p->x);
    for (int j = 0; j < m->n && m->beside; j++)
        m->here.x[j] = num_dd_mul(m->here.x[j], (num_dd){ 1, j * 5 % 3 == 1 ? -NUM_DD_EPSILON : NUM_DD_EPSILON });
    m->why = ODE_CONSTRAINT_LOST;
    if (!precise_project(m->p, m->here.t, m->here.x, m->scale, NULL, &moved, &residual) || !allowed(m, &m->here)) {
        end_refused(m, true);
        return false;
    }
    m->path->residual = residual;
    m->why = ODE_LEFT_DOMAIN;
    for (; m->next < p->rq->samples && num_dd_sub(p->time[m->next], p->start).hi == 0; m->next++)
        memcpy(m->path->sample + (size_t)m->next * (size_t)m->n, m->here.x, (size_t)m->n * sizeof *p->x);
    if (m->next == p->rq->samples)
        return false;
    for (double size = span; size > 1e-30 * span; size *= 1e-3)
        if (expand(m, &m->here, size))
            return true;
    end_refused(m, true);
    return false;
}

static void go(struct march *m)
{
    double cut = 1, miss;
    if (!begin(m))
        return;
    while (may_go_on(m)) {
        double far = cut * fmin(1, SAFETY * last_terms(m)), h;
        num_dd s = num_dd_of(far);
        if (m->here.reach.hi < far)
            s = num_dd_add(m->here.reach, num_dd_of(1e-30));
        h = s.hi * fabs(m->here.scale);
        double passed = fmax(fabs(m->here.t.hi), fabs(num_dd_sub(m->here.t, m->p->start).hi));
        bool refused = cut < 1 && m->why != ODE_NONE;
        if (h < (refused ? SMALLEST_REFUSED : SMALLEST) * fmax(passed, 1e-300) || largest(m->here.x, m->n) > HUGE_STATE) {
            end_refused(m, refused);
            return;
        }
        enum outcome o = attempt(m, s, &miss);
        if (o == TAKEN && !deliver(m, s))
            o = REFUSED;
        if (o != TAKEN) {
            m->path->refused++;
            if (o == TOO_LARGE)
                m->why = ODE_NONE;
            cut *= o == REFUSED ? 0.5 : fmax(0.1, 0.9 * pow(miss, -1.0 / m->order));
            continue;
        }
        m->path->steps++;
        if (m->next == m->p->rq->samples)
            return;
        struct place before = m->here;
        m->here = m->there;
        m->there = before;
        cut = 1;
    }
}

static void place_alloc(struct march *m, struct place *q)
{
    q->x = sga_calloc((size_t)m->n, sizeof *q->x);
    q->series = sga_calloc((size_t)(m->order + 1) * (size_t)m->n, sizeof *q->series);
}

void precise_march(struct precise *p, double rtol, double atol, bool beside, struct precise_path *path)
{
    struct march m = { .p = p, .path = path, .n = p->n, .rtol = rtol, .atol = atol, .beside = beside };
    double tol = rtol > 0 ? rtol : fmin(1e-3, atol);
    *path = (struct precise_path){ .t = p->time[p->rq->samples - 1].hi };
    m.order = (int)fmin(MOST_ORDER, fmax(LEAST_ORDER, ceil(-log(tol) / 2 + 2)));
    if (!p->series || p->order != m.order) {
        num_jet2_free(p->series);
        p->series = num_jet2_new(p->flow->field.plain, m.order);
        p->order = m.order;
    }
    m.direction = num_dd_less(p->time[p->rq->samples - 1], p->start) ? -1 : 1;
    path->sample = sga_calloc((size_t)p->rq->samples * (size_t)m.n + 1, sizeof *path->sample);
    place_alloc(&m, &m.here);
    place_alloc(&m, &m.there);
    m.scale = sga_calloc(3 * (size_t)m.n, sizeof *m.scale);
    m.xd = m.scale + m.n;
    m.fd = m.xd + m.n;
    m.slope = sga_calloc((size_t)m.n, sizeof *m.slope);
    path->t = p->start.hi;
    go(&m);
    path->count = m.next;
    if (path->reason == ODE_NONE)
        path->t = p->time[p->rq->samples - 1].hi;
    free(m.here.x);
    free(m.here.series);
    free(m.there.x);
    free(m.there.series);
    free(m.scale);
    free(m.slope);
}

void precise_path_clear(struct precise_path *path)
{
    free(path->sample);
    path->sample = NULL;
}
