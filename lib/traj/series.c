/* Taylor coefficients along the flow, from the expressions of the reduced field. */
#include "series.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"

bool series_along(struct series *s, struct field *f, double t, const double *x, int order, double scale, double *out, double *reach)
{
    int n = f->n;
    if (!field_expressions_hold(f, t, x))
        return false;
    if (!s->jet || s->order < order) {
        num_jet_free(s->jet);
        s->jet = num_jet_new(f->plain, order);
        s->order = order;
        num_jet_compile(s->jet, s->memory);
    }
    double *time = num_jet_input(s->jet, n);
    memset(time, 0, (size_t)(order + 1) * sizeof *time);
    time[0] = t;
    if (order > 0)
        time[1] = scale;
    sga_copy(out, x, n);
    if (!num_jet_along(s->jet, n, order, scale, out))
        return false;
    *reach = num_jet_reach(s->jet, order - 1);
    return true;
}

void series_clear(struct series *s)
{
    num_jet_free(s->jet);
    *s = (struct series){ 0 };
}
