/* ode_solve: checks of the request, and the global error by a second solution. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "march.h"
#include "mem.h"

/* The comparison solution is this much looser than the one delivered. Errors follow
 * tolerances only roughly (over a few steps they scatter by several times), and the
 * difference must be the looser one's error; hence not less. */
#define LOOSER 10.0
/* For the scatter that is left. */
#define ALLOWANCE 1.5
#define TIGHTEST_RTOL 1e-14

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
    if (!ode_method_find(o->method))
        return sga_fail(err, SGA_E_NOT_SUPPORTED, "there is no integration method \"%s\"", o->method);
    return true;
}

static void solve_once(const struct ode_problem *p, const struct ode_start *start,
                       const struct ode_options *o, const double *unit,
                       struct ode_result *res)
{
    const struct ode_method *method = ode_method_find(o->method);
    *res = (struct ode_result){.n = p->n, .max_error = -1, .rtol = o->rtol, .method = method->name};
    res->samples = sga_malloc(((size_t)start->count * (size_t)p->n + 1) * sizeof(double));
    ode_march(p, start, o, unit, method, res);
}

/* Largest difference of sample k, and the rounding that cannot be seen in a difference:
 * each solution carries at least a few roundings of its own size. */
static double difference(const struct ode_result *a, const struct ode_result *b, int k,
                         const double *unit)
{
    double most = 0;
    for (int j = 0; j < a->n; j++) {
        size_t at = (size_t)k * (size_t)a->n + (size_t)j;
        double d = ALLOWANCE * fabs(a->samples[at] - b->samples[at]) + 4 * DBL_EPSILON * fabs(a->samples[at]);
        most = fmax(most, d / unit[j]);
    }
    return most;
}

/* A difference can pass through 0 where the error does not: each estimate is the largest
 * of its neighbours' too. */
static void set_errors(struct ode_result *res, const struct ode_result *other,
                       const double *unit)
{
    int known = other->count < res->count ? other->count : res->count;
    double *raw = sga_malloc(((size_t)res->count + 1) * sizeof *raw);
    res->error = sga_malloc(((size_t)res->count + 1) * sizeof *res->error);
    res->max_error = 0;
    for (int k = 0; k < res->count; k++)
        raw[k] = k < known ? difference(res, other, k, unit) : INFINITY;
    for (int k = 0; k < res->count; k++) {
        double e = raw[k];
        if (k > 0)
            e = fmax(e, raw[k - 1]);
        if (k + 1 < known)
            e = fmax(e, raw[k + 1]);
        res->error[k] = e;
        res->max_error = fmax(res->max_error, e);
    }
    free(raw);
}

/* The tolerance asked for the looser of two solutions; where the tighter one could not
 * be had in double precision, a looser one still. */
static double loose_rtol(double rtol, double atol)
{
    return atol <= rtol && rtol < LOOSER * TIGHTEST_RTOL ? LOOSER * TIGHTEST_RTOL : rtol;
}

bool ode_solve(const struct ode_problem *p, const struct ode_start *start,
               const struct ode_options *opt, struct ode_result *res, struct sga_error *err)
{
    if (!check_start(p, start, err) || !check_options(p, opt, err))
        return false;
    struct ode_options o = *opt;
    double *ones = sga_malloc(((size_t)p->n + 1) * sizeof *ones);
    for (int j = 0; j < p->n; j++)
        ones[j] = 1;
    const double *unit = o.unit ? o.unit : ones;
    if (!o.estimate_global_error) {
        solve_once(p, start, &o, unit, res);
    } else {
        struct ode_result loose;
        o.rtol = loose_rtol(o.rtol, o.atol);
        solve_once(p, start, &o, unit, &loose);
        o.rtol /= LOOSER;
        o.atol /= LOOSER;
        solve_once(p, start, &o, unit, res);
        set_errors(res, &loose, unit);
        res->second = loose.stats;
        ode_result_free(&loose);
    }
    free(ones);
    return true;
}

void ode_result_free(struct ode_result *res)
{
    free(res->samples);
    free(res->error);
    res->samples = res->error = NULL;
}
