/* The field of least norm and its derivatives by the inputs' rates: the choice depends on the rates affinely, so it is made with all of them 0 and
 * with one of them 1. */
#include "linear_least.h"

#include <string.h>

#include "ask_work.h"
#include "error.h"
#include "gauge_choice.h"
#include "reduction.h"
#include "run_job.h"
#include "system.h"
#include "trajectory.h"

/* Inputs that are variables, as rates; NULL and an error where one has none of its own to be chosen. */
static struct traj_rate *rates_of(struct ask_work *s, int *count)
{
    struct traj_rate *rate = sga_zeros(&s->mem, (size_t)s->rq.inputs + 1, sizeof *rate);
    *count = 0;
    for (int i = 0; i < s->rq.inputs; i++) {
        int u = s->rq.input[i].variable;
        if (u < 0)
            continue;
        if (!ask_is_free(s->j, u)) {
            sga_fail_at(s->j->err, SGA_E_INPUTS, "/linearization/inputs", "%.100s cannot be chosen as a function of time: its derivative is determined on the final set; name what is left free "
                        "(gauge says what moves)", s->rq.input[i].name);
            return NULL;
        }
        rate[(*count)++] = (struct traj_rate){ u, expr_int(s->rq.sys->store, 0) };
    }
    return rate;
}

/* The field at these rates, into out (by variable). */
static bool choice(struct ask_work *s, const struct traj_rate *rate, int rates, expr_id *out)
{
    struct traj_request r = { .rate = rate, .rates = rates, .arithmetic = TRAJ_DOUBLE, .budget = s->j->budget };
    struct gauge_choice c;
    gauge_choice_make(&c, s->rq.sys, s->j->solution, &r);
    bool ok = c.field && c.fixed == rates;
    if (ok)
        memcpy(out, c.field, (size_t)s->rq.sys->variables * sizeof *out);
    else if (c.fixed < rates)
        sga_fail_at(s->j->err, SGA_E_INPUTS, "/linearization/inputs", "the inputs cannot be chosen independently of each other: %d of %d can%s%s", c.fixed, rates, c.why ? "; " : "", c.why ? c.why : "");
    else
        sga_fail_at(s->j->err, SGA_E_GAUGE, "/linearization/gauge", "there is no motion of least norm beside these inputs: %s", c.why ? c.why : "the gauge fields are not known");
    gauge_choice_clear(&c);
    return ok;
}

bool linear_least_norm(struct ask_work *s)
{
    const struct sga_solution *sol = s->j->solution;
    struct expr_store *st = s->rq.sys->store;
    int n = s->rq.sys->variables, m;
    struct traj_rate *rate = sol->free_columns ? rates_of(s, &m) : NULL;
    if (!rate)
        return !sol->free_columns;
    struct sga_solution *own = sga_take(&s->mem, sizeof *own);
    *own = *sol;
    own->free_columns = m;
    own->field = sga_take(&s->mem, ((size_t)n + 1) * sizeof *own->field);
    own->gauge = sga_take(&s->mem, ((size_t)m * (size_t)n + 1) * sizeof *own->gauge);
    if (!choice(s, rate, m, own->field))
        return false;
    for (int i = 0; i < m; i++) {
        expr_id *y = own->gauge + (size_t)i * (size_t)n;
        rate[i].rate = expr_int(st, 1);
        if (!choice(s, rate, m, y))
            return false;
        rate[i].rate = expr_int(st, 0);
        for (int j = 0; j < n; j++)
            y[j] = expr_sub(st, y[j], own->field[j]);
    }
    s->rq.sol = own;
    s->ports.gauge = m < sol->free_columns ? "least norm" : NULL;
    return true;
}
