/* Inside the ode folder: step-size control. */
#ifndef SGA_ODE_CONTROL_H
#define SGA_ODE_CONTROL_H

#include <stdbool.h>

struct ode_field;
struct ode_step;

/* A proportional-integral controller, and a predictive one that follows the trend of the
 * last two steps (Gustafsson; Hairer, Wanner, IV.2 and IV.8); the smaller step is taken,
 * so that sizes do not swing and few steps are refused where the solution gets harder. */
struct ode_control {
    double error_order;
    double log_before;      /* of the error of the last accepted step, */
    double step_before;     /* and its size; 0: none yet */
    bool refused_before;    /* after a refusal the step does not grow at once */
};

void ode_control_begin(struct ode_control *c, double error_order);
/* By what a step is to be multiplied after it was accepted, 1/3 .. 6, and after one
 * whose error was above 1, 1/3 .. 0.9. */
double ode_control_accepted(struct ode_control *c, double error, double step);
double ode_control_refused(struct ode_control *c, double error);

/* As ode_control_accepted, but for the last digits, from ode_rough_log of the error: for methods whose steps cost little. */
double ode_control_quick(struct ode_control *c, double log_error, double step);

/* A power of 2 to three digits, for exponents to some hundreds. */
double ode_rough_power(double x);

/* A first step size (unsigned) from the sizes of x, x' and an estimate of x'' got by an
 * explicit Euler step (Hairer, Norsett, Wanner, II.4). `step` has t, x, f and the
 * tolerances set, h = the whole signed span. One evaluation, or a few where the field is
 * refused; work has 2 n entries. level: what is bounded by no error is 2^-level as long, so that solutions that are compared do not begin with one step. */
double ode_first_step(struct ode_field *field, const struct ode_step *step, double error_order, int level, double *work);

#endif
