/* Whether the 2-form of a request is closed. */
#include "run_job.h"

#include <stdlib.h>
#include <string.h>

#include "form.h"
#include "oracle.h"
#include "poly.h"
#include "reduce.h"
#include "request.h"
#include "system.h"

enum { MOST_CYCLES = 4000 };

/* Zero on the whole space: by algebra where that decides, by points of the space otherwise. */
static enum points_truth zero_everywhere(struct job *j, struct points_oracle *oracle, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, j->budget);
    enum poly_truth t = poly_is_zero(&j->request->store, e, &limits);
    if (t != POLY_UNKNOWN)
        return t == POLY_YES ? POINTS_ZERO : POINTS_NONZERO;
    const struct sys_system *sys = &j->request->system;
    const struct form_hamiltonian *h = j->request->hamiltonian;
    if (!oracle->reals) {
        struct points_space space = {
            .st = sys->store, .variable = h->variable, .variables = h->variables, .parameter = sys->parameter,
            .parameters = sys->parameters, .time = sys->time, .near = j->start.x, .near_time = j->start.time, .budget = j->budget,
        };
        if (points_oracle_sample(oracle, &space) != POINTS_OK)
            return POINTS_UNKNOWN;
    }
    return points_oracle_zero(oracle, e).truth;
}

bool answer_two_form(struct job *j)
{
    const struct form_hamiltonian *h = j->request->hamiltonian;
    struct form_cycle *cycle;
    struct points_oracle oracle;
    int cycles;
    if (!h || !h->omega)
        return true;
    points_oracle_init(&oracle, 3);
    j->two_form.checked = true;
    j->two_form.closed = form_cycles(&j->request->store, h->variable, h->variables, h->omega, MOST_CYCLES, &cycle, &cycles) ? 1 : -1;
    for (int k = 0; k < cycles && j->two_form.closed; k++) {
        enum points_truth t = zero_everywhere(j, &oracle, cycle[k].sum);
        if (t == POINTS_UNKNOWN)
            j->two_form.closed = -1;
        if (t != POINTS_NONZERO)
            continue;
        j->two_form.closed = 0;
        j->two_form.variable[0] = cycle[k].i;
        j->two_form.variable[1] = cycle[k].j;
        j->two_form.variable[2] = cycle[k].k;
        j->two_form.defect = cycle[k].sum;
    }
    points_oracle_clear(&oracle);
    free(cycle);
    return job_goes_on(j);
}
