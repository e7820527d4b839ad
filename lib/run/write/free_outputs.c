/* L_Y L_X^k out, for gauge fields Y and the reduced field X: where it is not 0, the derivative of order k + 1 of the output has a free function in it. */
#include "free_outputs.h"

#include <assert.h>
#include <stdio.h>

#include "derive.h"
#include "error.h"
#include "oracle.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "signal.h"
#include "system.h"
#include "warnings.h"

/* Of larger systems the derivatives along the field are long; that some unknowns are free is said all the same (fewer_equations). */
enum { MOST_VARIABLES = 60, DERIVATIVES = 4, MOST_NODES = 200000 };

static expr_id along(struct expr_store *st, const struct sys_system *sys, expr_id e, const expr_id *field)
{
    expr_id sum = expr_int(st, 0);
    for (int k = 0; k < sys->variables; k++)
        if (!expr_is_zero(st, field[k]))
            sum = expr_add(st, sum, expr_mul(st, expr_diff(st, e, sys->variable[k].symbol), field[k]));
    return sum;
}

static bool moves(struct job *j, expr_id e)
{
    const struct sga_solution *sol = j->solution;
    const struct sys_system *sys = &j->request->system;
    for (int k = 0; k < sol->free_columns; k++) {
        expr_id d = along(sys->store, sys, e, sol->gauge + (size_t)k * (size_t)sys->variables);
        if (!expr_is_zero(sys->store, d) && points_oracle_zero(j->oracle, d).truth == POINTS_NONZERO)
            return true;
    }
    return false;
}

/* As long as derivatives stay short. */
static bool is_free(struct job *j, expr_id e)
{
    const struct sys_system *sys = &j->request->system;
    struct expr_store *st = sys->store;
    int most = st->nodes + MOST_NODES;
    for (int k = 0; k < DERIVATIVES && expr_store_ok(st) && st->nodes < most; k++) {
        if (moves(j, e))
            return true;
        e = expr_add(st, along(st, sys, e, j->solution->field), expr_time_partial(st, e, sys->time));
    }
    return false;
}

void answer_warn_free_outputs(struct job *j)
{
    const struct request_trajectory *t = &j->request->trajectory;
    const struct sga_solution *sol = j->solution;
    struct sga_error before = *j->request->store.error;
    if (!(j->request->want & REQUEST_TRAJECTORY) || t->rates || t->conditions || !sol->gauge || !sol->free_columns || j->request->system.variables > MOST_VARIABLES || j->request->op.has)
        return;
    assert(sol->field);
    for (int k = 0; k < t->outputs; k++) {
        char pointer[64];
        snprintf(pointer, sizeof pointer, "/trajectory/outputs/%d", k);
        if (t->output[k] && is_free(j, t->output[k]))
            sga_warn(j->budget, SGA_W_FREE_OUTPUT, pointer, "%.100s is not determined by the equations: what is told of it follows from the choice of least norm; say what is free by trajectory.gauge, or "
                     "add the equations that are missing", t->output_text[k]);
    }
    *j->request->store.error = before;      /* an output without a derivative is not this one's matter */
}
