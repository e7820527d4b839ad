/* Far from time 0 (seconds since 1970) the field is only known at rounded times: t + c h loses what is below a rounding of t.
 *
 * An error that this alone could make is no reason for shorter steps, which it would follow slowly: ode_late_error. And
 * steps that follow roundings make them alike in all solutions, so that of two that are compared one runs by two roundings
 * of time later: ode_late_start. */
#include <float.h>
#include <math.h>

#include "larger.h"
#include "march.h"
#include "mem.h"

bool ode_late_error(struct ode_march *m)
{
    static const double FAR = 1e3, LATE = 1e-10, SHARE = 6;        /* time 0 over the span; a rounding of time over a step; the sizes of the weights in an error estimate */
    double late = 2 * DBL_EPSILON * fabs(m->t), h = fabs(m->step.h), most = 0;
    if (!(fabs(m->t) > FAR * fabs(m->stop - m->start->t)))       /* near a singularity steps are short too */
        return false;
    for (int side = -1; side <= 1 && late > LATE * h; side += 2) {
        double sum = 0;
        if (!ode_eval(&m->field, m->t + side * late, m->x, m->f1))
            return false;
        for (int j = 0; j < m->p->n; j++) {
            double e = 0.5 * h * (m->f1[j] - m->f[j]) / ode_allowed(m->o->rtol, m->o->atol, m->unit[j], m->x[j], m->x[j]);
            sum += e * e;
        }
        most = sga_larger(most, sqrt(sum / fmax(1, m->p->n)));
    }
    return m->error <= SHARE * most;
}

/* Two roundings of time, where they are more than nothing of the way; else 0. */
static double shift_of(const struct ode_run *run)
{
    static const double FAR = 1e-13;
    const struct ode_start *s = run->start;
    double last = s->times[s->count - 1], shift = 2 * DBL_EPSILON * fmax(fabs(s->t), fabs(last));
    return !run->p->break_count && !run->p->enter && shift > FAR * fabs(last - s->t) ? shift : 0;
}

bool ode_is_late(const struct ode_run *run)
{
    return shift_of(run) > 0;
}

bool ode_late_start(const struct ode_run *run, struct ode_start *late)
{
    const struct ode_start *s = run->start;
    double shift = shift_of(run);
    if (!(shift > 0))
        return false;
    double *times = sga_malloc((size_t)s->count * sizeof *times);
    for (int k = 0; k < s->count; k++)
        times[k] = s->times[k] + shift;
    *late = (struct ode_start){ .t = s->t + shift, .x = s->x, .count = s->count, .times = times };
    return true;
}
