/* Taylor coefficients along the flow, from the expressions of the reduced field. */
#include "flow_series.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"
#include "mem.h"
#include "tape.h"

enum { HEADROOM = 4 };         /* for the tighter solution that errors are estimated by */
enum { SHORT = 50 };           /* operations: with more, those of an order take longer than the rest of a step */

bool series_fast(const struct field *f)
{
    return f->fast && f->plain && num_tape_length(f->plain) <= SHORT && num_jet_straight(f->plain);
}

bool series_along(struct series *s, struct field *f, double t, const double *x, int order, double scale, double *out, double *reach)
{
    int n = f->n;
    if (!field_expressions_hold(f, t, x))
        return false;
    if (!s->jet || s->order < order) {
        num_jet_free(s->jet);
        s->order = order + HEADROOM;
        s->jet = num_jet_new(f->plain, s->order);
        num_jet_compile(s->jet, s->memory, s->programs);
    }
    sga_copy(out, x, n);
    if (!num_jet_along(s->jet, n, order, t, scale, out))
        return false;
    *reach = num_jet_reach(s->jet, order - 1);
    assert(order <= s->order && *reach > 0);       /* else no step is short enough */
    return true;
}

void series_clear(struct series *s)
{
    num_jet_free(s->jet);
    *s = (struct series){ 0 };
}
