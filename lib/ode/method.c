/* The table of methods, and what they share. */
#include "method.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const struct ode_method *const methods[] = {
    &ode_tsit5,
    &ode_dop853,
    &ode_radau,
    &ode_taylor,
};
enum { METHODS = sizeof methods / sizeof *methods };

const char *ode_method_name(int i)
{
    return i >= 0 && i < METHODS ? methods[i]->name : NULL;
}

const char *ode_method_what(int i)
{
    return i >= 0 && i < METHODS ? methods[i]->what : NULL;
}

bool ode_method_is_auto(const char *name)
{
    return !name || strcmp(name, "auto") == 0;
}

/* From here on the low-order method is cheaper: measured over the references (tests/bench). */
#define LOW_ORDER_RTOL 1e-3

const struct ode_method *ode_method_find(const char *name, double rtol)
{
    if (ode_method_is_auto(name))
        return rtol >= LOW_ORDER_RTOL ? &ode_tsit5 : &ode_dop853;
    for (int i = 0; i < METHODS; i++)
        if (strcmp(name, methods[i]->name) == 0)
            return methods[i];
    return NULL;
}

bool ode_eval_refused(struct ode_field *field)
{
    field->why = field->p->why ? field->p->why(field->p->ctx) : ODE_LEFT_DOMAIN;
    return false;
}

bool ode_eval(struct ode_field *field, double t, const double *x, double *dx)
{
    const struct ode_problem *p = field->p;
    field->stats->evaluations++;
    if (!p->rhs(p->ctx, t, x, dx))
        return ode_eval_refused(field);
    ode_step_aside(field, dx);
    double s = 0;
    for (int j = 0; j < p->n; j++)
        s += dx[j] * 0.0;
    if (s == 0)
        return true;
    field->why = ODE_LEFT_DOMAIN;
    return false;
}
