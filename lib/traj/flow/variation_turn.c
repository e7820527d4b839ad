/* Jumps of derivatives of a motion where it turns a switch at a time that depends on what it is differentiated by. */
#include "variation_turn.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"
#include "flow.h"
#include "jacobian.h"
#include "manifold.h"
#include "mem.h"
#include "switches.h"
#include "system.h"
#include "tape.h"

/* Beside its size before and after, the field does not jump; beside what is added up in it, the surface's argument does not move; times
 * of several surfaces are the same. */
static const double SAME = 1e-10, AT_REST = 1e-9, TOGETHER = 1e-7;

bool variation_turn_init(struct variation_turn *v, const struct flow *f, const struct traj_request *rq, struct sga_error *err)
{
    const struct traj_turns *q = rq->turns;
    const struct num_switches *w = field_switches(f->field);
    int n = f->n, *inputs = field_inputs(f->sys), switches = w ? w->count : 0;
    assert(q->base * (1 + q->directions) == n);
    *v = (struct variation_turn){ .base = q->base, .directions = q->directions, .surfaces = q->surfaces };
    v->surface_of = sga_malloc(((size_t)switches + 1) * sizeof *v->surface_of);
    for (int e = 0; e < switches; e++) {
        v->surface_of[e] = -1;
        for (int i = 0; i < q->surfaces; i++)
            if (q->surface[i] == w->argument[e] || expr_neg(f->sys->store, q->surface[i]) == w->argument[e])      /* of max(x, 1/2): 1/2 - x */
                v->surface_of[e] = i;
    }
    v->surface = num_tape_new_switched(f->sys->store, w, q->surface, q->surfaces, inputs, n + 1, err);
    v->slope = num_tape_new_switched(f->sys->store, w, q->slope, q->surfaces * q->directions, inputs, n + 1, err);
    v->jac = v->surface ? num_jacobian_new(v->surface, NULL, 0) : NULL;
    free(inputs);
    if (!v->jac || !v->slope)
        return false;
    v->value = sga_calloc((size_t)v->jac->nnz + 1, sizeof *v->value);
    v->along = sga_calloc((size_t)(q->surfaces * q->directions) + 1, sizeof *v->along);
    v->before = sga_calloc((size_t)(q->directions) + 1, sizeof *v->before);
    v->after = sga_calloc((size_t)n + 1, sizeof *v->after);
    return true;
}

void variation_turn_clear(struct variation_turn *v)
{
    num_jacobian_free(v->jac);
    num_tape_free(v->surface);
    num_tape_free(v->slope);
    free(v->surface_of);
    free(v->value);
    free(v->along);
    free(v->before);
    free(v->after);
    *v = (struct variation_turn){ 0 };
}

/* v->before[d] = dt/dk_d of the surface i, which the motion comes to at in. False: it does not pass it there. */
static bool times_of(struct variation_turn *v, int n, int i, const double *before)
{
    double rate = 0, terms = 0;
    bool moves = false;
    for (int d = 0; d < v->directions; d++) {
        v->before[d] = 0;
        moves |= v->along[i * v->directions + d] != 0;
    }
    if (!moves)
        return true;
    for (int k = v->jac->start[i]; k < v->jac->start[i + 1]; k++) {
        double part = v->value[k] * (v->jac->col[k] == n ? 1 : before[v->jac->col[k]]);
        rate += part;
        terms += fabs(part);
    }
    if (!(fabs(rate) > AT_REST * terms))
        return false;
    for (int d = 0; d < v->directions; d++)
        v->before[d] = -v->along[i * v->directions + d] / rate;
    return true;
}

/* The times of all surfaces that were turned, which must be one; no surface: a time that does not move. */
static bool find_times(struct variation_turn *v, int switches, int n, const double *before, const unsigned char *turned)
{
    double *first = NULL;
    bool ok = true;
    for (int d = 0; d < v->directions; d++)
        v->before[d] = 0;
    for (int e = 0; e < switches && ok; e++) {
        if (!turned[e])
            continue;
        ok = v->surface_of[e] >= 0 && times_of(v, n, v->surface_of[e], before);
        for (int d = 0; d < v->directions && ok && first; d++)
            ok = fabs(v->before[d] - first[d]) <= TOGETHER * (fabs(v->before[d]) + fabs(first[d]));
        if (!first && ok)
            first = memcpy(sga_malloc(((size_t)v->directions + 1) * sizeof *first), v->before, (size_t)v->directions * sizeof *first);
    }
    free(first);
    return ok;
}

bool variation_turned(void *ctx, double t, const double *from, const double *before, const unsigned char *turned, double *x)
{
    struct flow *f = ctx;
    struct variation_turn *v = f->turn;
    size_t n = (size_t)f->n, base = (size_t)v->base;
    bool jumps = false;
    if (!field_eval(f->field, t, x, v->after))
        return false;
    for (size_t j = 0; j < base; j++)
        jumps |= f->moving[j] && fabs(before[j] - v->after[j]) > SAME * (fabs(before[j]) + fabs(v->after[j]));
    double *at = memcpy(sga_malloc((2 * n + 2) * sizeof *at), from, n * sizeof *at), *to = at + n + 1;
    at[n] = t;
    bool ok = true;
    sga_copy(to, x, f->n);
    /* what is differentiated is continuous, unless the motion's own derivative is not; what follows from it by the constraints is solved for */
    for (size_t i = base; i < n; i++)
        to[i] = f->moving[i] ? from[i] : x[i];
    if (jumps)
        ok = num_jacobian_eval(v->jac, at, NULL, v->value) && num_tape_eval(v->slope, at, v->along)
             && find_times(v, f->field->switches->count, f->n, before, turned);
    for (size_t d = 0; d < (size_t)v->directions && jumps && ok; d++)
        for (size_t j = 0; j < base; j++)
            if (f->moving[base * (d + 1) + j])
                to[base * (d + 1) + j] += (before[j] - v->after[j]) * v->before[d];
    ok = ok && (!f->manifold->c || manifold_jump(f->manifold, t, to, f->moving));
    if (ok)
        sga_copy(x, to, f->n);
    free(at);
    return ok;
}
