/* The drift of functions that should not change along the motion: what the integration itself
 * lets go of, beside the constraints, which every sample is put back on. */
#include "flow.h"

#include <math.h>
#include <stdlib.h>

#include "budget.h"
#include "field.h"
#include "mem.h"
#include "system.h"
#include "tape.h"

static void look(struct traj_drift *d, double t, double value)
{
    double far = fabs(value - d->start);
    d->end = value;
    if (isnan(far))
        far = INFINITY;
    if (far > d->largest) {
        d->largest = far;
        d->t = t;
    }
}

bool traj_drift(struct flow *f, const struct traj_request *rq, const double *x, int samples, struct traj_result *r,
                struct sga_error *err)
{
    if (!rq->integrals)
        return true;
    int n = f->n, *inputs = field_inputs(f->field->sys);
    struct num_tape *tape = num_tape_new(f->field->sys->store, rq->integral, rq->integrals, inputs, n + 1, err);
    free(inputs);
    if (!tape)
        return false;
    double *value = sga_malloc((size_t)rq->integrals * sizeof *value);
    num_tape_compile(tape, rq->budget ? rq->budget->exec : NULL);
    r->drift = sga_calloc((size_t)rq->integrals, sizeof *r->drift);
    num_tape_eval_field(tape, r->initial, rq->start, rq->integrals, value, NULL);
    for (int i = 0; i < rq->integrals; i++)
        r->drift[i] = (struct traj_drift){ .start = value[i], .end = value[i], .t = rq->start };
    for (int k = 0; k < samples; k++) {
        num_tape_eval_field(tape, x + (size_t)k * (size_t)n, rq->times[k], rq->integrals, value, NULL);
        for (int i = 0; i < rq->integrals; i++)
            look(r->drift + i, rq->times[k], value[i]);
    }
    free(value);
    num_tape_free(tape);
    return true;
}
