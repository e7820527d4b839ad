/* ode_solve: checks of the request, and its result's release. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "error.h"
#include "march.h"
#include "mem.h"

struct ode_options ode_options_default(void)
{
    return (struct ode_options){.rtol = 1e-9, .atol = 1e-9, .max_steps = 1000000};
}

static bool check_start(const struct ode_problem *p, const struct ode_start *s,
                        struct sga_error *err)
{
    if (s->count < 1)
        return sga_fail(err, SGA_E_SHAPE, "a trajectory needs at least one time");
    if (!isfinite(s->t))
        return sga_fail(err, SGA_E_SHAPE, "the start time is not finite");
    for (int j = 0; j < p->n; j++)
        if (!isfinite(s->x[j]))
            return sga_fail(err, SGA_E_INITIAL, "initial value %d is not finite", j);
    double before = s->t, direction = s->times[s->count - 1] < s->t ? -1 : 1;
    for (int k = 0; k < s->count; before = s->times[k++])
        if (!isfinite(s->times[k]) || (s->times[k] - before) * direction < 0)
            return sga_fail(err, SGA_E_SHAPE,
                            "times must be finite and go in one direction from the start; time %d does not",
                            k);
    return true;
}

static bool check_options(const struct ode_problem *p, const struct ode_options *o,
                          struct sga_error *err)
{
    if (!(o->rtol >= 0) || !(o->atol >= 0) || !(o->rtol + o->atol > 0) ||
        !isfinite(o->rtol + o->atol))
        return sga_fail(err, SGA_E_SCHEMA, "rtol and atol must be finite, not negative and not both 0");
    for (int j = 0; o->unit && j < p->n; j++)
        if (!(o->unit[j] > 0) || !isfinite(o->unit[j]))
            return sga_fail(err, SGA_E_SCHEMA, "the scale of variable %d is not positive", j);
    const struct ode_method *method = ode_method_find(o->method, o->rtol);
    if (!method)
        return sga_fail(err, SGA_E_NOT_SUPPORTED, "there is no integration method \"%s\"", o->method);
    if (method->series && !p->taylor)
        return sga_fail(err, SGA_E_NOT_SUPPORTED, "the field is solved from the equations at every evaluation, so it has no Taylor series here; use \"auto\", \"tsit5\", \"dop853\" or \"radau\"");
    return true;
}

bool ode_solve(const struct ode_problem *p, const struct ode_start *start,
               const struct ode_options *opt, struct ode_result *res, struct sga_error *err)
{
    if (!check_start(p, start, err) || !check_options(p, opt, err))
        return false;
    double *ones = sga_malloc(((size_t)p->n + 1) * sizeof *ones);
    for (int j = 0; j < p->n; j++)
        ones[j] = 1;
    struct ode_run run = {.p = p, .start = start, .o = *opt, .unit = opt->unit ? opt->unit : ones,
                          .series = ode_takes_series(p, opt)};
    if (opt->estimate_global_error)
        ode_global(&run, res);
    else
        ode_march(&run, res);
    free(ones);
    assert(ode_result_sane(start, res));
    return true;
}

void ode_result_free(struct ode_result *res)
{
    free(res->samples);
    free(res->inside);
    free(res->apart);
    free(res->error);
    free(res->column_error);
    free(res->happening);
    free(res->happened_x);
    free(res->held);
    res->held = NULL;
    res->samples = res->inside = res->apart = res->error = res->happened_x = NULL;
    res->happening = NULL;
    res->happened = 0;
}
