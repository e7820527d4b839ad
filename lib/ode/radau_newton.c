/* The stages of a Radau IIA step by a simplified Newton method.
 *
 * In z = X - x the stages satisfy (hA)^-1 z = X(x + z). With w = T^-1 z the Newton matrix
 * (hA)^-1 (x) I - I (x) J falls apart into one real system gamma/h I - J and (s - 1)/2
 * complex ones. Hairer, Wanner, Solving Ordinary Differential Equations II, IV.8.
 *
 * Where the problem gives its equations r(t, X, V) = 0, V is (hA)^-1 z at the stages, and with M = -dr/dV the same
 * falls apart into gamma/h M - J and its complex likes. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <string.h>

#include "lin_shift.h"
#include "radau.h"
#include "radau_tables.h"
#include "watch.h"

/* The iteration ends when its error is below this part of the error allowed, by the number of stages: the defect weighs stages the more the more there
 * are, and what is left of their errors must not set the size of steps. */
static double solved(const struct radau *r) { return r->tab->s == 3 ? 0.03 : r->tab->s == 5 ? 0.01 : 0.004; }

/* Increments that no longer fall, but are this small, are rounding. */
#define ROUNDING_MOST 0.3
#define FEW 30                 /* variables whose equations are solved in no time */
#define FARTHEST_START 4.0     /* a start is extrapolated over at most so many old steps */

void radau_polynomial(const struct radau_table *tab, int n, const double *z, double theta, bool minus_end, double *out)
{
    double weight[RADAU_STAGES], sum = tab->bary[0] / theta;
    int exact = -1;
    for (int i = 0; i < tab->s; i++) {
        double d = theta - tab->c[i];
        exact = d == 0 ? i : exact;
        weight[i] = d != 0 ? tab->bary[i + 1] / d : 0;
        sum += weight[i];
    }
    for (int i = 0; i < tab->s; i++) {
        weight[i] = exact >= 0 ? i == exact : theta != 0 ? weight[i] / sum : 0;
        weight[i] -= minus_end && i == tab->s - 1;
    }
    for (int j = 0; j < n; j++) {
        double v = 0;
        for (int i = 0; i < tab->s; i++)
            v += weight[i] * z[(size_t)i * (size_t)n + (size_t)j];
        out[j] = v;
    }
}

/* w = TI z, or z += T w. */
static void transform(const double M[RADAU_STAGES][RADAU_STAGES], int s, int n, const double *from, double *to, bool add)
{
    for (int i = 0; i < s; i++)
        for (int j = 0; j < n; j++) {
            double v = 0;
            for (int k = 0; k < s; k++)
                v += M[i][k] * from[(size_t)k * (size_t)n + (size_t)j];
            size_t at = (size_t)i * (size_t)n + (size_t)j;
            to[at] = add ? to[at] + v : v;
        }
}

static bool factor(struct radau *r, struct ode_field *field, struct ode_step *step)
{
    const struct radau_table *t = r->tab;
    if (r->factored_h == step->h && r->factored_tab == t)
        return true;
    field->stats->factorisations++;
    r->factored_h = r->kept = 0;
    lin_shift_sizes(r->lin, r->scale);
    bool ok = lin_shift_factor(r->lin, 0, t->gamma / step->h, 0, r->jac);
    for (int p = 0; ok && p < t->s / 2; p++)
        ok = lin_shift_factor(r->lin, p + 1, t->re[p] / step->h, t->im[p] / step->h, r->jac);
    step->cost += lin_shift_cost(r->lin) * (1 + 4 * (t->s / 2)) / r->field_cost;
    if (ok) {
        r->factored_h = step->h;
        r->factored_tab = t;
    }
    return ok;
}

static void begin_values(struct radau *r, const struct ode_step *step, bool extrapolate)
{
    const struct radau_table *t = r->tab;
    size_t n = (size_t)r->n;
    double ratio = r->old_h != 0 ? step->h / r->old_h : 0;
    if (!extrapolate || !(ratio > 0 && ratio < FARTHEST_START)) {
        memset(r->z, 0, (size_t)t->s * n * sizeof *r->z);
        memset(r->w, 0, (size_t)t->s * n * sizeof *r->w);
        return;
    }
    for (int i = 0; i < t->s; i++)
        radau_polynomial(r->old_tab, r->n, r->old_z, 1 + t->c[i] * ratio, true, r->z + (size_t)i * n);
    transform(t->TI, t->s, r->n, r->z, r->w, false);
}

/* r->v = (hA)^-1 z, by way of w. */
static void derivatives(struct radau *r, double h)
{
    const struct radau_table *t = r->tab;
    size_t n = (size_t)r->n;
    for (size_t j = 0; j < n; j++)
        r->r[j] = t->gamma / h * r->w[j];
    for (int p = 0; p < t->s / 2; p++) {
        const double *u = r->w + (size_t)(1 + 2 * p) * n, *v = u + n;
        double *a = r->r + (size_t)(1 + 2 * p) * n, re = t->re[p] / h, im = t->im[p] / h;
        for (size_t j = 0; j < n; j++) {
            a[j] = re * u[j] - im * v[j];
            a[n + j] = im * u[j] + re * v[j];
        }
    }
    transform(t->T, t->s, r->n, r->r, r->v, false);
}

static bool evaluate(struct radau *r, struct ode_field *field, const struct ode_step *step)
{
    const struct radau_table *t = r->tab;
    const struct ode_implicit *eq = r->eq;
    if (eq)
        derivatives(r, step->h);
    for (int i = 0; i < t->s; i++) {
        size_t at = (size_t)i * (size_t)r->n;
        for (int j = 0; j < r->n; j++)
            r->err[j] = step->x[j] + r->z[at + (size_t)j];
        if (eq && !(eq->residual(field->p->ctx, step->t + (step->t_low + t->c[i] * step->h), r->err, r->v + at, r->f + at) || ode_eval_refused(field)))
            return false;
        if (!eq && !ode_eval(field, step->t + (step->t_low + t->c[i] * step->h), r->err, r->f + at))
            return false;
    }
    return true;
}

/* One Newton correction, left in r->f (transformed back); returns its norm. */
static double correction(struct radau *r, const struct ode_step *step)
{
    const struct radau_table *t = r->tab;
    size_t n = (size_t)r->n;
    assert(r->factored_h == step->h && r->factored_tab == t);
    double h = r->mass ? INFINITY : step->h;       /* what the equations miss has V in it */
    transform(t->TI, t->s, r->n, r->f, r->r, false);
    for (size_t j = 0; j < n; j++)
        r->r[j] -= t->gamma / h * r->w[j];
    lin_shift_solve(r->lin, 0, r->r);
    for (int p = 0; p < t->s / 2; p++) {
        double *a = r->r + (size_t)(1 + 2 * p) * n, *b = a + n, re = t->re[p] / h, im = t->im[p] / h;
        const double *u = r->w + (size_t)(1 + 2 * p) * n, *v = u + n;
        for (size_t j = 0; j < n; j++) {
            r->pair[2 * j] = a[j] - (re * u[j] - im * v[j]);
            r->pair[2 * j + 1] = b[j] - (im * u[j] + re * v[j]);
        }
        lin_shift_solve(r->lin, p + 1, r->pair);
        for (size_t j = 0; j < n; j++) {
            a[j] = r->pair[2 * j];
            b[j] = r->pair[2 * j + 1];
        }
    }
    transform(t->T, t->s, r->n, r->r, r->f, false);
    double sum = 0;
    for (int i = 0; i < t->s; i++)
        for (size_t j = 0; j < n; j++) {
            double d = r->f[(size_t)i * n + j] / r->scale[j];
            sum += d * d;
        }
    return sqrt(sum / fmax(1, (double)t->s * (double)n));
}

static void apply(struct radau *r)
{
    size_t count = (size_t)r->tab->s * (size_t)r->n;
    for (size_t k = 0; k < count; k++) {
        r->z[k] += r->f[k];
        r->w[k] += r->r[k];
    }
}

/* From the present z and w. step->retry is set where it diverges. */
static enum radau_outcome iterate(struct radau *r, struct ode_field *field, struct ode_step *step)
{
    int most = 7 + (r->tab->s - 3) * 5 / 2;
    double before = 0, rate_before = 0, best = INFINITY, s = r->tab->s, enough = solved(r);
    double eta = pow(fmax(r->eta, DBL_EPSILON), 0.8);
    step->retry = 0.5;
    for (int k = 1; k <= most; k++) {
        step->cost += r->tab->s + (2 * s * s * r->n + s * lin_shift_solve_cost(r->lin)) / r->field_cost;
        if (!evaluate(r, field, step) || (r->n > FEW && !sga_watch_ok()))
            return RADAU_REFUSED;
        double size = correction(r, step);
        r->iterations = k;
        if (!isfinite(size))
            return RADAU_DIVERGED;
        if (k > 1) {
            double rate = size / before;
            r->theta = k == 2 ? rate : sqrt(rate * rate_before);
            rate_before = rate;
            if (size < ROUNDING_MOST && (rate > 0.5 || k == most) && best < 1) {
                apply(r);
                r->theta = fmin(r->theta, 0.9);
                return RADAU_SOLVED;
            }
            if (r->theta >= 0.99)
                return RADAU_DIVERGED;
            eta = r->theta / (1 - r->theta);
            double expected = eta * size * pow(r->theta, most - k - 1) / enough;
            if (k < most && expected >= 1) {
                step->retry = fmax(0.1, fmin(0.5, 0.8 * pow(fmin(20, fmax(1e-4, expected)), -1.0 / (4 + most - 1 - k))));
                return RADAU_DIVERGED;
            }
        }
        best = fmin(best, size);
        before = fmax(size, 1e-300);
        apply(r);
        /* that the first increment was the last one in earlier steps says nothing of pulses, which it may not have met */
        if (eta * size <= enough && (k > 1 || !field->p->bands)) {
            r->eta = eta;
            return RADAU_SOLVED;
        }
    }
    return RADAU_DIVERGED;
}

/* So much shorter than the step: as short as can be. */
static const double SHORTEST = 1e-9;

/* The sign of the real determinant for the shortest steps, of this Jacobian. False: it is singular for these. */
static bool find_sign(struct radau *r, const struct ode_step *step)
{
    bool ok = lin_shift_factor(r->lin, 0, r->tab->gamma / (SHORTEST * step->h), 0, r->jac);
    r->sign = ok ? lin_shift_sign(r->lin) : 0;
    r->sign_fresh = true;
    return ok;
}

/* A real eigenvalue beyond gamma / h (beyond on the side where h points): the solution
 * grows in this step by more than the method follows, and a singularity could be stepped
 * over unseen. Pairs of them escape. Of equations the sign for short steps changes at their singular points alone: it is looked at again
 * where the one of this step is another. */
static bool grows_too_fast(struct radau *r, struct ode_field *field, struct ode_step *step)
{
    int expected = r->mass ? r->sign : step->h < 0 && r->n % 2 ? -1 : 1;
    if (lin_shift_sign(r->lin) == expected)
        return false;
    if (!r->mass || r->sign_fresh)
        return true;
    int here = lin_shift_sign(r->lin);
    if (!find_sign(r, step) || r->sign != here)
        return true;
    r->factored_h = 0;
    return !factor(r, field, step);
}

static bool matrices(struct radau *r, struct ode_field *field, struct ode_step *step)
{
    const struct ode_implicit *eq = r->eq;
    field->stats->jacobians++;
    r->factored_h = 0;
    step->cost += 2;
    r->jac_known = r->jac_fresh = r->sign_fresh = false;
    if (!eq->matrices(field->p->ctx, step->t, step->x, step->f, r->mass, r->jac))
        return false;
    lin_shift_mass(r->lin, r->mass);
    lin_shift_sizes(r->lin, r->scale);
    r->jac_known = r->jac_fresh = r->sign || find_sign(r, step);
    return r->jac_known;
}

static bool jacobian(struct radau *r, struct ode_field *field, struct ode_step *step)
{
    double cost = 0;
    r->jac_h = step->h;
    if (r->mass)
        return matrices(r, field, step);
    r->jac_known = r->jac_fresh = ode_partials_eval(&r->partials, field, step, r->jac, &cost);
    r->factored_h = 0;
    step->cost += cost;
    return r->jac_known;
}

enum radau_outcome radau_stages(struct radau *r, struct ode_field *field, struct ode_step *step)
{
    /* what one rounding of x does cannot be iterated away */
    for (int j = 0; j < r->n; j++)
        r->scale[j] = fmax(ode_allowed(step->rtol, step->atol, step->unit[j], step->x[j], step->x[j]),
                           1e-13 * fabs(step->x[j]));
    enum radau_outcome last = RADAU_DIVERGED;
    for (int turn = 0; turn < 4; turn++) {
        bool fresh_start = turn % 2;
        if ((turn == 2 && r->jac_fresh) || (fresh_start && r->old_h == 0))
            continue;
        if (!r->jac_known || turn == 2 || (r->refused_before && !r->jac_fresh)) {     /* what was refused may have been an old Jacobian's fault */
            step->retry = 0.5;
            if (!jacobian(r, field, step))
                return RADAU_REFUSED;
        }
        if (!factor(r, field, step)) {
            step->retry = 0.5;
            last = RADAU_DIVERGED;
            continue;
        }
        if (grows_too_fast(r, field, step)) {
            step->retry = 0.5;
            return RADAU_DIVERGED;
        }
        begin_values(r, step, !fresh_start);
        r->theta = 0;
        last = iterate(r, field, step);
        assert(last != RADAU_SOLVED || (r->theta >= 0 && r->theta < 1));      /* it contracts */
        if (last == RADAU_SOLVED)
            return last;
        if (last == RADAU_DIVERGED && turn == 0 && r->jac_fresh)
            break;
        if (last == RADAU_DIVERGED && turn == 0)
            turn = 1;      /* a new Jacobian helps more than another start */
    }
    return last;
}
