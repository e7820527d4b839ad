/* What a solution in double-double keeps of its way: see precise.h. */
#include <math.h>
#include <stdlib.h>

#include "flow.h"
#include "precise.h"
#include "sizes.h"
#include "tolerance.h"
#include "trajectory.h"

void precise_forget_events(struct precise_path *path, int events)
{
    while (path->events > events)
        free(path->event[--path->events].x);
}

void precise_path_clear(struct precise_path *path)
{
    precise_forget_events(path, 0);
    free(path->event);
    free(path->sample);
    free(path->held);
    path->event = NULL;
    path->sample = NULL;
    path->held = NULL;
}

void precise_drop_events(struct precise_path *path, double t, double direction)
{
    int kept = path->events;
    while (kept > 0 && direction * (path->event[kept - 1].t.hi - t) > 0)
        kept--;
    precise_forget_events(path, kept);
}

/* A difference may pass through 0, as those of samples do. */
#define NEIGHBOUR 30.0

double precise_event_errors(const struct precise *p, struct precise_path *a, const struct precise_path *b, double factor)
{
    double start = p->start.hi, worst = 0;
    bool alike = a->events == b->events;
    for (int i = 0; i < a->events && alike; i++)
        alike = a->event[i].event == b->event[i].event && a->event[i].direction == b->event[i].direction;
    for (int i = 0; i < a->events; i++) {
        double size = fmax(fabs(a->event[i].t.hi), fabs(a->event[i].t.hi - start)), near = 0, raw = 0;
        for (int k = i - 1; k <= i + 1 && alike; k++) {
            double d = k < 0 || k >= a->events ? 0 : fabs(num_dd_sub(a->event[k].t, b->event[k].t).hi);
            *(k == i ? &raw : &near) = k == i ? d : fmax(near, d);
        }
        a->event[i].error = alike ? factor * fmax(raw, fmin(near, NEIGHBOUR * raw)) + a->event[i].floor + 16 * NUM_DD_EPSILON * size : INFINITY;
        if (a->event[i].direction)
            worst = fmax(worst, sga_error_ratio(a->event[i].error, (struct sga_tolerance){ p->rq->rtol, p->rq->atol }, p->flow->sizes->time, size));
    }
    return worst;
}
