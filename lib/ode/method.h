/* Inside the ode folder: what an integration method is.
 *
 * A method makes one step from (t, x) with f = X(t, x) given, and, once the driver has
 * accepted and projected the step's end, fits a polynomial over the step. It knows
 * nothing of step control, samples, constraints or endings. To add one: a file with a
 * const struct ode_method, and a line in method.c's table. */
#ifndef SGA_ODE_METHOD_H
#define SGA_ODE_METHOD_H

#include "ode.h"

/* The field with its evaluations counted, and refusals remembered. */
struct ode_field {
    const struct ode_problem *p;
    struct ode_stats *stats;
    enum ode_reason why;       /* of the last refusal */
};
/* False: refused, or not finite. */
bool ode_eval(struct ode_field *field, double t, const double *x, double *dx);

/* One step: the driver fills the first part, the method's attempt() the second, the
 * driver the third. All vectors have n entries and are the driver's. */
struct ode_step {
    int n;
    double t, t_low;           /* start, as an unevaluated sum */
    double h;                  /* signed */
    const double *x, *f;       /* state and field at the start */
    double rtol, atol;
    const double *unit;        /* never NULL here */

    double *dx;                /* increment: the end is x + dx */
    double error;              /* weighted error, <= 1 is within tolerance */

    const double *x1, *f1;     /* state (projected) and field at the end */
};

struct ode_method {
    const char *name, *what;
    int order;                 /* of the solution delivered */
    int error_order;           /* the error estimate falls as h to this power */
    double rtol_least, rtol_most;  /* what "auto" would use it for */
    void *(*alloc)(int n);
    void (*free)(void *state);
    /* False: the field was refused at a stage. */
    bool (*attempt)(void *state, struct ode_field *field, struct ode_step *step);
    /* After attempt and with x1, f1 set: prepare dense output; may evaluate. */
    bool (*dense_begin)(void *state, struct ode_field *field, const struct ode_step *step);
    /* After attempt and with x1, f1 set: |h| times an estimate of the largest eigenvalue,
     * over the method's stability limit; > 1 is a sign of stiffness. May be NULL. */
    double (*stiffness)(const void *state, const struct ode_step *step);
    /* x (n) at t + theta h, 0 <= theta <= 1. */
    void (*dense_at)(const void *state, const struct ode_step *step, double theta, double *x);
};

extern const struct ode_method ode_dop853;

/* By name; "auto" and NULL choose by tolerance. NULL: there is no such method. */
const struct ode_method *ode_method_find(const char *name, double rtol);

/* The error allowed in variable j between values a and b: never 0. */
double ode_allowed(double rtol, double atol, double unit, double a, double b);

#endif
