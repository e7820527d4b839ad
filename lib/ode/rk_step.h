/* Inside the ode folder: what steps of explicit Runge-Kutta methods have in common. */
#ifndef SGA_ODE_RK_STEP_H
#define SGA_ODE_RK_STEP_H

#include "method.h"
#include "rk_sum.h"

RK_INLINE double rk_time(const struct ode_step *step, double c) { return step->t + (step->t_low + c * step->h); }

/* All stages by one piece of code, to be judged by rk_holds. False: there is none. */
static inline bool rk_as_one(struct sga_stages *plan, const struct ode_field *field, const struct ode_step *step, double *k)
{
    struct sga_stage_code all;
    plan->aside = field->beside;
    if (!field->p->stages || field->noise || !field->p->stages(field->p->ctx, plan, &all))
        return false;
    for (int s = 1; all.needs_time && s < plan->count; s++)
        all.time[s] = rk_time(step, plan->c[s]);
    all.run(all.slots, k, all.rest, all.place, step->h);
    return true;
}

/* After the stages 1 .. stages - 1 by the field's plain code: are they finite, and the field's values? They are counted. */
RK_INLINE bool rk_holds(struct ode_field *field, const double *k, int stages, size_t even, size_t stride)
{
    rk_two sum = {0, 0};
    for (size_t j = 0; j < even; j += 2) {
        rk_two a = {0, 0}, b = {0, 0};       /* not finite if any of them is not */
#pragma GCC unroll 6
        for (size_t s = 1; s + 1 < (size_t)stages; s += 2) {
            a += *(const rk_two *)(k + s * stride + j);
            b += *(const rk_two *)(k + (s + 1) * stride + j);
        }
        if (stages % 2 == 0)
            a += *(const rk_two *)(k + (size_t)(stages - 1) * stride + j);
        sum += 0.0 * (a + b);
    }
    field->stats->evaluations += stages - 1;
    return sum[0] + sum[1] == 0 && field->p->code_holds(field->p->ctx, stages - 1);
}

/* Do fields f and k at states x and y of one time differ by more than limit / |h| times what these differ by? An
 * eigenvalue is so large then. */
RK_INLINE bool rk_stiff(int n, const double *unit, double h, const double *f, const double *k, const double *x, const double *y, double limit)
{
    rk_two up = {0, 0}, down = {0, 0};
    for (int j = 0; j < n; j += 2) {
        rk_two part = 1 / rk_of(unit, n, j, 1);
        rk_two df = (rk_of(f, n, j, 0) - rk_of(k, n, j, 0)) * part, dx = (rk_of(x, n, j, 0) - rk_of(y, n, j, 0)) * part;
        up += df * df;
        down += dx * dx;
    }
    return h * h * (up[0] + up[1]) > limit * limit * (down[0] + down[1]);
}

#endif
