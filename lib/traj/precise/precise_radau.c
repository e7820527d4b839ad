/* Implicit steps in double-double: Radau IIA of as many stages as the tolerance asks for.
 *
 * L-stable and stiffly accurate, of order 2 s - 1 at the ends of steps. Steps are chosen by the
 * polynomial inside of them (order s): its last coefficients over Legendre polynomials fall by a
 * ratio that the distance of the solution's singularities sets, in stiff components as in others,
 * so that samples anywhere are as good as the tolerance and no order is lost where stiffness
 * takes that of the ends (Hairer, Wanner, Solving Ordinary Differential Equations II, IV.15). */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "collocation.h"
#include "field.h"
#include "flow.h"
#include "mem.h"
#include "precise.h"
#include "precise_march.h"
#include "precise_stage_sides.h"
#include "trajectory.h"

#define LEAST_STAGES 5
#define MOST_STAGES 24
/* Stages for a digit of the tolerance: for up to FEW variables; at the least, for many, where the matrix costs more. Measured. */
#define STAGES_PER_DIGIT 0.6
#define STAGES_PER_DIGIT_MANY 0.4
#define FEW 4
#define EXPECTED_FALL 0.2      /* of coefficients */
#define SAFETY 0.9
#define GROWTH 4.0
#define GROWTH_BESIDE 3.3
#define NOISE 50               /* roundings of the stages, in coefficients */
#define STAGE_NOISE 4          /* what else rounding leaves of them */
#define FARTHEST_GUESS 2.5     /* over so many old steps a guess is extrapolated */

struct radau {
    struct precise_stages *stages;
    struct stage_sides *sides; /* NULL: there are no switches */
    int n, s;
    num_dd *old_z, *tail;      /* s x n: of the last step, if old_h is not 0; n */
    double h, old_h, factor;
    num_dd step;               /* attempted */
    bool refused;              /* since the last step */
    double work;               /* of the last step with its tries */
};

bool precise_radau_possible(const struct field *f)
{
    return f->slope && stage_matrix_most(f->pattern) >= LEAST_STAGES;
}

static void *radau_alloc(struct precise_march *m)
{
    struct radau *r = sga_calloc(1, sizeof *r);
    double tol = m->rtol > 0 ? m->rtol : fmin(1e-3, m->atol);
    int most = (int)fmin(MOST_STAGES, stage_matrix_most(m->p->flow->field->pattern));
    double per_digit = fmax(STAGES_PER_DIGIT_MANY, STAGES_PER_DIGIT * fmin(1, pow((double)FEW / m->n, 0.2)));
    int s = (int)ceil(-log10(tol) * per_digit) + 2;
    r->stages = precise_stages_new(m, s < LEAST_STAGES ? LEAST_STAGES : s > most ? most : s);
    r->n = m->n;
    r->s = r->stages->s;
    r->sides = stage_sides_new(m, r->s);
    assert(r->s >= LEAST_STAGES && r->s <= NUM_RADAU_MOST);       /* weights have room for so many */
    r->old_z = sga_calloc((size_t)r->s * (size_t)r->n + 1, sizeof *r->old_z);
    r->tail = sga_calloc((size_t)r->n + 1, sizeof *r->tail);
    return r;
}

static void radau_free(void *state)
{
    struct radau *r = state;
    precise_stages_free(r->stages);
    stage_sides_free(r->sides);
    free(r->old_z);
    free(r->tail);
    free(r);
}

/* At the start of a motion a part of the time in which the state changes by its own size. */
static double first_size(const struct precise_march *m, double span)
{
    double x = 0, f = 0;
    for (int j = 0; j < m->n; j++) {
        x += pow(m->here.x[j].hi / m->scale[j] / 1e10, 2);
        f += pow(m->fd[j] / m->scale[j] / 1e10, 2);
    }
    double h = x > 0 && f > 0 && isfinite(x) && isfinite(f) ? 0.1 * sqrt(x / f) : 1e-6 * span;
    return fmin(span, fmax(h, 1e-20 * span));
}

static bool radau_begin(void *state, struct precise_march *m, double size)
{
    struct radau *r = state;
    precise_set_scale(m, m->here.x);
    r->h = m->path->steps ? size : first_size(m, size);
    r->old_h = 0;
    r->refused = false;
    r->stages->work = 0;
    return !r->sides || stage_sides_begin(r->sides, m, size);
}

static num_dd smooth_size(const struct radau *r, struct precise_march *m, double cut)
{
    num_dd rest = precise_goal_rest(m);
    double h = cut * r->h, left = fabs(rest.hi);
    precise_set_scale(m, m->here.x);
    if (h >= 0.99 * left)
        return cut < 1 ? num_dd_of(0.7 * rest.hi * fmin(1, cut)) : rest;
    return num_dd_of(m->direction * (2 * h > left ? 0.5 * left : h));
}

static num_dd radau_size(void *state, struct precise_march *m, double cut)
{
    const struct radau *r = state;
    num_dd h = smooth_size(r, m, cut);
    return r->sides ? stage_sides_size(r->sides, m, h) : h;
}

/* The polynomial of the last step, continued. */
static void guess(struct radau *r, num_dd h)
{
    int n = r->n, s = r->s;
    double ratio = r->old_h != 0 ? h.hi / r->old_h : 0, weight[NUM_RADAU_MOST];
    const struct num_radau *t = r->stages->formula;
    memset(r->stages->z, 0, (size_t)s * (size_t)n * sizeof *r->stages->z);
    if (!(ratio > 0 && ratio < FARTHEST_GUESS))
        return;
    for (int i = 0; i < s; i++) {
        num_radau_weights_double(t, 1 + t->c[i].hi * ratio, weight);
        for (int j = 0; j < n; j++) {
            double v = -r->old_z[(s - 1) * n + j].hi;
            for (int k = 0; k < s; k++)
                v += weight[k] * r->old_z[k * n + j].hi;
            r->stages->z[i * n + j] = num_dd_of(v);
        }
    }
}

/* Along the field at here, from where the Jacobian has no value (sqrt(x) at 0). */
static void guess_straight(struct radau *r, const struct precise_march *m, num_dd h)
{
    for (int k = 0; k < r->s * r->n; k++)
        r->stages->z[k] = num_dd_of(r->stages->formula->c[k / r->n].hi * h.hi * m->fd[k % r->n]);
}

/* Of the polynomial inside the step, in units of the error allowed. */
static double error_of(struct radau *r, const struct precise_march *m)
{
    const struct num_radau *t = r->stages->formula;
    double worst = 0, fall = EXPECTED_FALL;
    for (int k = 0; k < NUM_RADAU_TAIL; k++, fall *= EXPECTED_FALL) {
        for (int j = 0; j < r->n; j++) {
            num_dd v = num_dd_of(0);
            double most = fabs(m->here.x[j].hi);
            for (int i = 0; i < r->s; i++) {
                num_dd z = r->stages->z[i * r->n + j];
                v = num_dd_add(v, num_dd_mul(t->tail[k * r->s + i], z));
                most = fmax(most, fabs(z.hi));
            }
            r->tail[j] = num_dd_of(fmax(0, fabs(v.hi) - NOISE * NUM_DD_EPSILON * most - STAGE_NOISE * r->stages->noise[j]));
        }
        worst = fmax(worst, fall * precise_weighted(m, r->tail));
    }
    return worst;
}

static enum precise_outcome radau_attempt(void *state, struct precise_march *m, num_dd h, double *cut)
{
    struct radau *r = state;
    r->step = h;
    guess(r, h);
    m->why = ODE_LEFT_DOMAIN;
    enum precise_solved solved = precise_stages_solve(r->stages, m, h);
    if (solved == STAGES_REFUSED && r->old_h == 0) {
        guess_straight(r, m, h);
        solved = precise_stages_solve(r->stages, m, h);
    }
    bool again = r->refused;
    r->refused = true;
    if (solved != STAGES_SOLVED) {
        *cut *= solved == STAGES_REFUSED ? 0.5 : 0.3;
        return solved == STAGES_REFUSED ? PRECISE_REFUSED : PRECISE_TOO_LARGE;
    }
    double e = error_of(r, m);
    r->factor = SAFETY * pow(fmax(e, 1e-300), -1.0 / (r->s + 1));
    if (e > 1) {
        *cut *= fmax(0.1, r->factor);
        return PRECISE_TOO_LARGE;
    }
    m->there.t = precise_after(m, h);
    for (int j = 0; j < r->n; j++)
        m->there.x[j] = num_dd_add(m->here.x[j], r->stages->z[(r->s - 1) * r->n + j]);
    if (!precise_arrive(m)) {
        *cut *= 0.5;
        return PRECISE_REFUSED;
    }
    if (r->sides && !stage_sides_agree(r->sides, m, r->stages, h, cut))
        return PRECISE_TOO_LARGE;
    r->factor = fmin(r->factor, again ? 1 : m->beside ? GROWTH_BESIDE : GROWTH);
    return PRECISE_TAKEN;
}

static void radau_value(const void *state, const struct precise_march *m, num_dd t, num_dd *x)
{
    const struct radau *r = state;
    num_dd weight[NUM_RADAU_MOST];
    num_radau_weights(r->stages->formula, num_dd_div(num_dd_sub(t, m->here.t), r->step), weight);
    for (int j = 0; j < r->n; j++) {
        num_dd v = num_dd_of(0);
        for (int i = 0; i < r->s; i++)
            v = num_dd_add(v, num_dd_mul(weight[i], r->stages->z[i * r->n + j]));
        x[j] = num_dd_add(m->here.x[j], v);
    }
}

static bool radau_accepted(void *state, struct precise_march *m)
{
    struct radau *r = state;
    memcpy(r->old_z, r->stages->z, (size_t)r->s * (size_t)r->n * sizeof *r->old_z);
    r->old_h = r->step.hi;
    /* one that ended at a change says nothing of the step after it */
    r->h = m->sides.heading ? fmax(r->h, fabs(r->old_h) * r->factor) : fabs(r->old_h) * r->factor;
    r->refused = false;
    r->work = r->stages->work;
    r->stages->work = 0;
    if (!r->sides)
        return true;
    const struct precise_sides *q = &m->sides;
    num_dd turned = q->turned_t;
    bool ok = stage_sides_pass(r->sides, m, fabs(r->old_h));
    if (q->turned_t.hi != turned.hi || q->turned_t.lo != turned.lo) {
        r->old_h = 0;          /* no polynomial goes on there */
        r->h /= precise_parts(m->p);      /* a fast part that is smaller than the tolerance is stepped over */
    }
    return ok;
}

static double radau_cost(const void *state, const struct precise_march *m)
{
    (void)m;
    return ((const struct radau *)state)->work;
}

const struct precise_method precise_radau = {
    .name = "radau",
    .alloc = radau_alloc,
    .free = radau_free,
    .begin = radau_begin,
    .size = radau_size,
    .attempt = radau_attempt,
    .value = radau_value,
    .accepted = radau_accepted,
    .cost = radau_cost,
};
