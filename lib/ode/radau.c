/* Radau IIA of order 5, 9 and 13: the method for stiff systems.
 *
 * L-stable and stiffly accurate collocation at the Radau points; the number of stages
 * follows the rate at which Newton's method converges. The error estimate e is the defect
 * of the collocation polynomial at the start of the step, filtered by (gamma/h I - J)^-1;
 * it falls as h^(s+1) where the step's end is of order 2 s - 1, so a step is accepted with
 * an e above the error allowed, by the power of it that brings both to one scale. That
 * credit is not due to stiff components, whose error is of the size of e: what they miss is
 * about s P^(s-1) e with P = I - gamma/h (gamma/h I - J)^-1. For linear systems it is the error
 * of the step's end to within a factor of s for every step size, and gets no credit; nor
 * does the polynomial inside the step. E. Hairer and G. Wanner, Solving
 * Ordinary Differential Equations II, IV.8, and Stiff differential equations solved by
 * Radau methods, J. Comput. Appl. Math. 111 (1999) 93. */
#include "radau.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "lin_shift.h"
#include "lin_sparse.h"
#include "mem.h"
#include "radau_tables.h"

/* Contraction below which the Jacobian is still good: where factorisations cost nothing beside the rest of a step, and for each time that they cost as much. */
#define KEEP_JACOBIAN 1e-3
#define KEEP_JACOBIAN_FOR 0.1
#define KEEP_JACOBIAN_MOST 0.3
/* That it was good for a step says nothing of one that is so much longer. */
#define KEEP_JACOBIAN_LONGER 30.0
/* Growth that is never worth a factorisation, and that always is. */
#define KEEP_STEP 1.2
#define KEEP_STEP_MOST 3.0
/* Matrices are kept until what that has lost costs this part of new ones: how long these would be of use is not known. */
#define KEEP_PART 0.5
/* The order rises after CHANGE_AFTER steps where Newton's method contracts below
 * RAISE_BELOW, and falls where it contracts by LOWER_ABOVE only. */
#define RAISE_BELOW 0.002
#define LOWER_ABOVE 0.8
#define CHANGE_AFTER 10
/* What a step may start off the slow motion by, in errors allowed: farther off, the motion itself is fast. */
#define OFF_START 10.0

/* Ready for steps on the equations eq, or on the field. */
static void set_up(struct radau *r, const struct ode_problem *p, const struct ode_implicit *eq)
{
    size_t n = (size_t)p->n, block = RADAU_STAGES * n;
    *r = (struct radau){ .n = p->n, .p = p, .eq = eq, .tab = radau_tables, .eta = 1, .field_cost = p->cost > 0 ? p->cost : fmax(20, 20.0 * p->n) };
    ode_partials_init(&r->partials, p, eq ? eq->pattern : p->pattern);
    r->lin = lin_shift_new(r->partials.pattern);
    size_t entries = (size_t)r->partials.pattern->ptr[p->n], more = eq ? block + entries : 0;
    r->memory = sga_calloc(5 * block + 4 * n + entries + more + 1, sizeof *r->memory);
    r->z = r->memory;
    r->w = r->z + block;
    r->f = r->w + block;
    r->r = r->f + block;
    r->old_z = r->r + block;
    r->pair = r->old_z + block;
    r->scale = r->pair + 2 * n;
    r->err = r->scale + n;
    r->jac = r->err + n;
    r->v = eq ? r->jac + entries : NULL;
    r->mass = eq ? r->v + block : NULL;
}

static void clear(struct radau *r)
{
    ode_partials_clear(&r->partials);
    lin_shift_free(r->lin);
    free(r->memory);
}

static void *radau_alloc(const struct ode_problem *p)
{
    struct radau *r = sga_malloc(sizeof *r);
    set_up(r, p, p->implicit || !p->equations ? p->implicit : p->equations(p->ctx));
    return r;
}

static void radau_free(void *state)
{
    clear(state);
    free(state);
}

/* From the equations to the field, which has no value on the other side of what it divides by: where a solution is nearer to that than the tolerances, no step of
 * the equations' knows on which side it is. */
static bool radau_otherwise(void *state)
{
    struct radau *r = state;
    const struct ode_problem *p = r->p;
    if (!r->eq || p->implicit)
        return false;
    clear(r);
    set_up(r, p, NULL);
    return true;
}

static void radau_forget(void *state)
{
    struct radau *r = state;
    r->jac_known = r->jac_fresh = r->refused_before = r->trouble = false;
    r->old_h = r->factored_h = r->refused_off = 0;
    r->eta = 1;
    r->sign = 0;
    r->since_change = 0;
}

/* What the estimate may be, over the error allowed. */
static double credit(const struct radau *r, const struct ode_step *step)
{
    double s = r->tab->s, tol = fmin(0.1, step->rtol > 0 ? step->rtol : step->atol);
    return fmax(0.3, 0.1 * pow(tol, (s + 1) / (2 * s) - 1));
}

/* The weighted norm of v (n). */
static double norm(const struct radau *r, const struct ode_step *step, const double *v)
{
    double sum = 0;
    for (int j = 0; j < r->n; j++) {
        double e = v[j] / ode_allowed(step->rtol, step->atol, step->unit[j], step->x[j], step->x[j] + step->dx[j]);
        sum += e * e;
    }
    return r->n ? sqrt(sum / r->n) : 0;
}

/* r->err = (gamma/h I - J)^-1 (f + sign sum weight_i z_i / h), f the field at (t, x); its weighted norm, INFINITY where there is no value. f NULL: it is
 * evaluated here. On equations: what they miss at (t, x) with the derivative -sign sum weight_i z_i / h, in place of the right side. */
static double filtered(struct radau *r, struct ode_field *field, const struct ode_step *step, double t, const double *x, const double *f, const double *weight, double sign)
{
    const struct radau_table *tab = r->tab;
    const struct ode_implicit *eq = r->eq;
    assert(r->factored_h == step->h && r->factored_tab == tab);       /* the matrix is this step's */
    if (!eq && !f && !ode_eval(field, t, x, r->pair))
        return INFINITY;
    f = f ? f : r->pair;
    for (int j = 0; j < r->n; j++) {
        double v = 0;
        for (int i = 0; i < tab->s; i++)
            v += weight[i] * r->z[(size_t)i * (size_t)r->n + (size_t)j];
        r->err[j] = eq ? -sign * v / step->h : f[j] + sign * v / step->h;
    }
    if (eq) {
        memcpy(r->v, r->err, (size_t)r->n * sizeof *r->v);
        if (!eq->residual(field->p->ctx, t, x, r->v, r->err))
            return INFINITY;
    }
    lin_shift_solve(r->lin, 0, r->err);
    return norm(r, step, r->err);
}

void radau_mass_times(const struct radau *r, const double *v, double *out)
{
    const struct lin_sparse *a = r->partials.pattern;
    for (int i = 0; i < r->n; i++)
        for (int k = a->ptr[i]; k < a->ptr[i + 1]; k++)
            out[i] += r->mass[k] * v[a->col[k]];
}

/* The estimate once more, from x + e, which is in place of what stiff components start from; e itself where the field has no value there. */
static double once_more(struct radau *r, struct ode_field *field, struct ode_step *step, const double *from, double e)
{
    for (int j = 0; j < r->n; j++)
        r->scale[j] = step->x[j] + from[j];
    step->cost++;
    double again = filtered(r, field, step, step->t, r->scale, NULL, r->tab->defect, 1);
    return isfinite(again) ? again : e;
}

/* After a refusal, or with no step before, a large estimate is filtered once more. */
static double estimate(struct radau *r, struct ode_field *field, struct ode_step *step, double allowed)
{
    double e = filtered(r, field, step, step->t, step->x, step->f, r->tab->defect, 1);
    return e <= allowed || !(r->old_h == 0 || r->refused_before) ? e : once_more(r, field, step, r->err, e);
}

/* Where a step starts off the slow motion by some of what is allowed, as the step before left it, stiff components go back in no time, and e tells of that: no shorter
 * step has less of it, unless as short as they are fast. */
static bool starts_off(const struct radau *r, const struct ode_step *step, double stiff, double off)
{
    double h = fabs(step->h);
    return stiff > 1 && off <= OFF_START && r->refused_off > 0 && h < r->refused_h && off * r->refused_h > r->refused_off * h;
}

/* About |s P^(s-1) e|, and by which power of h it falls; r->err is e, and is used up. A
 * component of eigenvalue -l has P = u = h l / (gamma + h l); the factor goes from 0.6
 * where u is 0 to s where u is 1. *off: |P^(s-1) e|. */
static double stiff_part(struct radau *r, const struct ode_step *step, double e, double *power, double *off)
{
    double shift = r->tab->gamma / step->h, s = r->tab->s;
    for (int k = 1; k < r->tab->s; k++) {
        memcpy(r->scale, r->err, (size_t)r->n * sizeof *r->err);
        if (r->mass) {
            memset(r->scale, 0, (size_t)r->n * sizeof *r->scale);
            radau_mass_times(r, r->err, r->scale);
        }
        lin_shift_solve(r->lin, 0, r->scale);
        for (int j = 0; j < r->n; j++)
            r->err[j] -= shift * r->scale[j];
    }
    double left = norm(r, step, r->err), u = e > 0 ? fmin(1, pow(left / e, 1 / (s - 1))) : 0;
    *power = fmax(s, (s + 1 - u) + (s - 1) * (1 - u));
    *off = left;
    return (0.6 + (s - 0.6) * u * u) * left;
}

static enum ode_outcome radau_attempt(void *state, struct ode_field *field, struct ode_step *step)
{
    struct radau *r = state;
    step->cost = 0;
    if (r->old_h == 0 && !r->refused_before)
        r->tab = radau_tables + (step->rtol < 1e-7) + (step->rtol < 1e-10);
    step->error_order = r->tab->s + 1;
    enum radau_outcome o = radau_stages(r, field, step);
    if (o != RADAU_SOLVED) {
        r->trouble = r->refused_before = true;
        return o == RADAU_REFUSED ? ODE_FIELD_REFUSED : ODE_NOT_SOLVED;
    }
    memcpy(step->dx, r->z + (size_t)(r->tab->s - 1) * (size_t)r->n, (size_t)r->n * sizeof *step->dx);
    double allowed = credit(r, step), e = estimate(r, field, step, allowed);
    double power, off, *was = r->pair + r->n;
    memcpy(was, r->err, (size_t)r->n * sizeof *was);
    double stiff = stiff_part(r, step, e, &power, &off);
    if (starts_off(r, step, stiff, off)) {
        double gone, again = once_more(r, field, step, was, e);
        stiff = isfinite(again) ? stiff_part(r, step, again, &power, &gone) : stiff;
    }
    r->refused_off = off;
    r->refused_h = fabs(step->h);
    step->error = fmax(e / allowed, stiff);
    step->error_order = stiff > e / allowed ? power : r->tab->s + 1;
    step->dense_error = e * r->tab->dense;
    step->doubt = e;
    r->refused_before = true;      /* until it is accepted */
    return ODE_STEPPED;
}

/* True: the number of stages has changed. */
static bool choose_order(struct radau *r, double factor)
{
    int now = (int)(r->tab - radau_tables), next = now;
    r->since_change++;
    if (r->trouble && r->since_change > 1)
        next = now - 1;
    else if (r->iterations > 1 && r->theta >= LOWER_ABOVE && r->since_change > CHANGE_AFTER)
        next = now - 1;
    else if (r->since_change > CHANGE_AFTER && (r->iterations == 1 || r->theta <= RAISE_BELOW) && factor < 1.5 && factor > 0.7)
        next = now + 1;
    next = next < 0 ? 0 : next >= RADAU_TABLES ? RADAU_TABLES - 1 : next;
    r->trouble = false;
    assert(now >= 0 && now < RADAU_TABLES);
    r->tab = radau_tables + next;
    if (next != now)
        r->since_change = 0;
    return next != now;
}

/* What the factorisations of a step cost, over all else in the last one. */
static double factorisations_part(const struct radau *r)
{
    double s = r->tab->s, systems = 1 + 4 * floor(s / 2), solves = r->iterations + 2;
    return lin_shift_cost(r->lin) * systems / (solves * (lin_shift_solve_cost(r->lin) * systems + s * (r->field_cost + 2 * s * r->n)));
}

/* What the next step is to be multiplied by; whether the Jacobian is kept. */
static double next_size(struct radau *r, const struct ode_step *step, double factor)
{
    int most = 7 + (r->tab->s - 3) * 5 / 2;
    memcpy(r->old_z, r->z, (size_t)r->tab->s * (size_t)r->n * sizeof *r->z);
    r->old_h = step->h;
    r->old_tab = r->tab;
    r->jac_known = r->iterations == 1 || r->theta < KEEP_JACOBIAN;
    r->fresh_iterations = r->jac_fresh ? r->iterations : r->fresh_iterations;
    r->refused_before = r->jac_fresh = false;
    r->refused_off = 0;
    bool as_long = factor >= 1;
    factor *= (1.0 + 2 * most) / (r->iterations + 2 * most);
    if (choose_order(r, factor))
        return fmin(factor, 1);
    if (!as_long || factor > KEEP_STEP_MOST)
        return factor;
    double part = factorisations_part(r);
    r->kept += fmax(0, 1 - 1 / factor) + fmax(0, r->iterations - r->fresh_iterations) / (r->iterations + 2.0);
    if (r->kept <= KEEP_PART * part)
        r->jac_known |= r->theta < fmin(KEEP_JACOBIAN_MOST, KEEP_JACOBIAN_FOR * part);
    else if (factor > KEEP_STEP)
        return factor;
    return r->jac_known && (factor >= 1 || r->kept <= KEEP_PART * part) ? 1 : factor;
}

static double radau_accepted(void *state, const struct ode_step *step, double factor)
{
    struct radau *r = state;
    factor = next_size(r, step, factor);
    r->jac_known = r->jac_known && fabs(step->h) * factor <= KEEP_JACOBIAN_LONGER * fabs(r->jac_h);
    return factor;
}

/* Inside a step the polynomial misses stiff components by the full interpolation error,
 * which the estimate at the step's start does not see. The filtered defect at two points
 * far from the nodes does: in stiff components it is the error itself. */
static bool radau_dense_begin(void *state, struct ode_field *field, struct ode_step *step)
{
    struct radau *r = state;
    const struct radau_table *t = r->tab;
    for (int k = 0; k < 2; k++) {
        radau_polynomial(t, r->n, r->z, t->middle[k], false, r->scale);
        for (int j = 0; j < r->n; j++)
            r->scale[j] += step->x[j];
        double defect = filtered(r, field, step, step->t + (step->t_low + t->middle[k] * step->h), r->scale, NULL, t->slope[k], -1);
        if (!isfinite(defect))
            return false;
        step->dense_error = fmax(step->dense_error, defect);
    }
    return true;
}

static void radau_dense_at(const void *state, const struct ode_step *step, double theta, double *x)
{
    const struct radau *r = state;
    radau_polynomial(r->tab, r->n, r->z, theta, false, x);
    for (int j = 0; j < r->n; j++)
        x[j] += step->x[j];
}

const struct ode_method ode_radau = {
    .name = "radau",
    .what = "implicit Runge-Kutta of order 5, 9 and 13 (Radau IIA), for stiff systems",
    .implicit = true,
    .order = 5,
    .error_order = 4,
    .alloc = radau_alloc,
    .free = radau_free,
    .attempt = radau_attempt,
    .accepted = radau_accepted,
    .forget = radau_forget,
    .otherwise = radau_otherwise,
    .dense_begin = radau_dense_begin,
    .dense_at = radau_dense_at,
};
