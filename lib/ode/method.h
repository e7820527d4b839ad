/* Inside the ode folder: what an integration method is.
 *
 * A method makes one step from (t, x) with f = X(t, x) given, and, once the driver has
 * accepted and projected the step's end, fits a polynomial over the step. It knows
 * nothing of step control, samples, constraints or endings. To add one: a file with a
 * const struct ode_method, and a line in method.c's table. */
#ifndef SGA_ODE_METHOD_H
#define SGA_ODE_METHOD_H

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "ode.h"
#include "tolerance.h"

/* The field with its evaluations counted, and refusals remembered. */
struct ode_field {
    const struct ode_problem *p;
    struct ode_stats *stats;
    enum ode_reason why;       /* of the last refusal */
    bool beside;               /* wrong by a rounding, on purpose: see ode_solve */
    const double *noise;       /* n: by how many, where this is more than a few; else NULL */
};
/* False always: notes why the field refused. */
bool ode_eval_refused(struct ode_field *field);
/* False: refused, or not finite. */
bool ode_eval(struct ode_field *field, double t, const double *x, double *dx);
/* The factor of variable j's rate there. */
static inline double ode_aside(const struct ode_field *field, int j)
{
    double by = field->noise ? DBL_EPSILON * field->noise[j] : DBL_EPSILON;
    return j % 2 ? 1 - by : 1 + by;
}
/* The field where the solution is to be wrong by a rounding, on purpose. */
static inline void ode_step_aside(const struct ode_field *field, double *dx)
{
    for (int j = 0; field->beside && j < field->p->n; j++)
        dx[j] *= ode_aside(field, j);
}
/* The same inside a step, where a value that is not finite makes the error estimate so too,
 * and is found there. */
static inline bool ode_eval_stage(struct ode_field *field, double t, const double *x, double *dx)
{
    if (field->beside)
        return ode_eval(field, t, x, dx);
    field->stats->evaluations++;
    return field->p->rhs(field->p->ctx, t, x, dx) || ode_eval_refused(field);
}

/* One step: the driver fills the first part, the method's attempt() the second, the
 * driver the third. All vectors have n entries and are the driver's. */
struct ode_step {
    int n;
    double t, t_low;           /* start, as an unevaluated sum */
    double h;                  /* signed; attempt() may take a shorter step, and says so here */
    const double *x, *f;       /* state and field at the start */
    double rtol, atol;
    const double *unit;        /* never NULL here */

    double *dx;                /* increment: the end is x + dx */
    double error;              /* weighted error, <= 1 is within tolerance; falls as h to */
    double error_order;        /* this power */
    double log_error;          /* ode_rough_log of it where the method has that sooner; else NaN */
    /* The same for points inside the step, and how far the end may have to be moved onto
     * the manifold, in units of the error allowed. */
    double dense_error, doubt;
    double cost;               /* what the attempt took, in evaluations of the field */
    const double *f_end;       /* the field at x + dx, where the attempt needed it; else NULL */
    double retry;              /* where it was not solved: try this times h, < 1 */

    const double *x1, *f1;     /* state (projected) and field at the end */
};

enum ode_outcome { ODE_STEPPED, ODE_FIELD_REFUSED, ODE_NOT_SOLVED };

struct ode_method {
    const char *name, *what;
    bool implicit;
    bool series;               /* needs ode_problem.taylor */
    int order;                 /* of the solution delivered */
    double error_order;        /* the error estimate falls as h to this power at first */
    /* Of explicit ones: evaluations of a step; where the stability region ends on the negative
     * real axis; what a solution is called that radau made steps of too. */
    double cost, stable;
    const char *and_radau;
    void *(*alloc)(const struct ode_problem *p);
    void (*free)(void *state);
    enum ode_outcome (*attempt)(void *state, struct ode_field *field, struct ode_step *step);
    /* The step was accepted; x1, f1 are set. The driver would multiply the step size by
     * `factor`; returns what it is to be multiplied by. May be NULL. */
    double (*accepted)(void *state, const struct ode_step *step, double factor);
    /* The last attempt led nowhere, or other methods made steps since. May be NULL. */
    void (*forget)(void *state);
    /* Steps are as short as can be. True: from now on they are made in another way, from which no step was made yet. May be NULL. */
    bool (*otherwise)(void *state);
    /* After attempt and with x1, f1 set: prepare dense output; may evaluate, and may find
     * that step->dense_error is larger. */
    bool (*dense_begin)(void *state, struct ode_field *field, struct ode_step *step);
    /* After attempt and with x1, f1 set: |h| times an estimate of the largest eigenvalue
     * exceeds the method's stability limit, a sign of stiffness. May be NULL. */
    bool (*stiff)(const void *state, const struct ode_step *step);
    /* x (n) at t + theta h, 0 <= theta <= 1. */
    void (*dense_at)(const void *state, const struct ode_step *step, double theta, double *x);
};

extern const struct ode_method ode_tsit5, ode_dop853, ode_radau, ode_taylor;

/* The field's own rounding, in units of its last place: where a series misses it by less that is no defect. */
#define ODE_FIELD_ROUNDING 500.0

/* Of the last step that was attempted by Taylor series: its coefficients (order + 1 rows of n, with s = 1 at t + scale), and at its end the derivative that
 * they say, and the field. Its own, until the next attempt. */
struct ode_series {
    int order;
    double scale;
    const double *row, *slope, *field;
};
struct ode_series ode_taylor_series(const void *state);

/* By name; "auto" and NULL give the explicit one for this tolerance. NULL: there is no such
 * method. */
const struct ode_method *ode_method_find(const char *name, double rtol);
bool ode_method_is_auto(const char *name);

/* The logarithm to base 2 of a positive number to three digits after the point: more than step sizes need, and the next
 * step waits for it. Exponent and mantissa together are the logarithm but for a bump, which a cubic gives; INFINITY is a
 * large number, 0 a small one. */
static inline double ode_rough_log(double x)
{
    uint64_t bits, mantissa;
    double m;
    memcpy(&bits, &x, sizeof bits);
    mantissa = (bits & 0x000FFFFFFFFFFFFFu) | 0x3FF0000000000000u;
    memcpy(&m, &mantissa, sizeof m);
    return (double)(int64_t)bits * 0x1p-52 - 1023 + ((m - 1) * (2 - m)) * (0.58209 - 0.15922 * m);
}

/* The error allowed in variable j between values a and b: never 0. Comparisons rather than
 * fmax, which is a call. */
static inline double ode_allowed(double rtol, double atol, double unit, double a, double b)
{
    double p = fabs(a), q = fabs(b), size = p > q ? p : q;
    /* 7e-15: less than some 30 roundings cannot be asked for; 1e-200: never 0 */
    double asked = sga_allowed((struct sga_tolerance){ rtol, atol }, unit, size), least = 7e-15 * size;
    asked = asked > least ? asked : least;
    return asked > 1e-200 ? asked : 1e-200;
}

#endif
