/* What rounding does to the values of the field: they are compared with those in double-double, whose constants have all their
 * digits too. Where large terms cancel, or a linear solve is ill-conditioned, a value is known to fewer digits than a double has;
 * solutions that are compared would have that in common. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "field.h"
#include "flow.h"
#include "dd.h"
#include "jet.h"
#include "mem.h"
#include "system.h"
#include "tape.h"

enum { PLACES = 6 };
static const double BESIDE = 1e-3;     /* of the variables: roundings differ from place to place */
/* Of the largest velocity, in natural units: one that is smaller here need not be elsewhere (a cosine begins with none), and what it is wrong by is no part of
 * it then. And what no field is wrong by on purpose, a part of it. */
static const double SMALL = 1e-3, A_PART = 1e-3;

/* Raises size and miss (n each) to |X_j| and to how far it is wrong, at x. */
static void look(struct flow *f, struct num_jet2 *exact, double t, const double *x, double *v, double *size, double *miss)
{
    struct field *q = f->field;
    for (int j = 0; j < f->n; j++)
        num_jet2_input(exact, j)[0] = num_dd_of(x[j]);
    num_jet2_input(exact, f->n)[0] = num_dd_of(t);
    field_load(q, t, x);
    if (!num_tape_eval(q->plain, q->in, v) || !num_jet2_next(exact, 0))
        return;
    double least = SMALL * field_size(q, v);
    for (int j = 0; j < f->n; j++) {
        num_dd d = num_dd_add_d(num_jet2_root(exact, j)[0], -v[j]);
        if (!num_dd_finite(d))
            continue;
        size[j] = fmax(size[j], fmax(fabs(v[j]), least * (q->unit ? q->unit[j] : 1)));
        miss[j] = fmax(miss[j], fabs(d.hi));
    }
}

static void measure(struct flow *f, double t, const double *x, double *noise)
{
    int n = f->n;
    struct num_jet2 *exact = num_jet2_new(f->field->plain, 0);
    double *place = sga_calloc(4 * (size_t)n + 1, sizeof *place), *v = place + n, *size = v + n, *miss = size + n;
    for (int k = 0; k < PLACES; k++) {
        for (int j = 0; j < n; j++)
            place[j] = x[j] * (1 + BESIDE * sin(1.7 * k + 2.9 * k * j));
        look(f, exact, t, place, v, size, miss);
    }
    for (int j = 0; j < n; j++)
        noise[j] = size[j] > 0 ? fmax(1, fmin(miss[j] / size[j], A_PART) / DBL_EPSILON) : 1;
    free(place);
    num_jet2_free(exact);
}

bool flow_noise(void *flow, double t, const double *x, double *noise)
{
    struct flow *f = flow;
    if (!f->field->fast || !f->field->plain || f->sys->signals)
        return false;
    if (!f->noise) {
        f->noise = sga_malloc(((size_t)f->n + 1) * sizeof *f->noise);
        measure(f, t, x, f->noise);
    }
    sga_copy(noise, f->noise, f->n);
    return true;
}
