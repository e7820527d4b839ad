/* One solution of the table, and what is kept of it. */
#include "tradeoff.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "integrate.h"
#include "run_job.h"
#include "mem.h"
#include "request.h"

/* A solution shorter than this is measured again, as often as this. */
static const double SHORT_SECONDS = 4e-3;
enum { REPEATS = 4 };
/* Where each one takes much more to be set up, not for longer than this. */
static const double REPEAT_SECONDS = 0.02;

bool tradeoff_solve(struct tradeoff_run *u, const struct tradeoff_row *row, bool single, double seconds,
                    struct traj_result *r, struct sga_error *err)
{
    struct sga_budget budget = *u->j->budget;
    if (!budget.deadline || budget.deadline > u->end.wall)
        budget.deadline = u->end.wall;
    double begin = sga_cpu();
    budget.cpu_deadline = begin + seconds;
    budget.seconds = seconds;
    struct traj_request request = u->request;
    request.method = row->method;
    request.arithmetic = row->arithmetic;
    request.rtol = row->rtol;
    request.atol = row->atol;
    request.single = single;
    request.rows_until = 0;          /* of rows that are cut off nothing is measured */
    request.budget = &budget;
    bool ok = answer_integrate(u->j, u->solution, &request, r, err);
    if (ok && !(r->seconds > 0))     /* not measured there */
        r->seconds = sga_cpu() - begin;
    return ok;
}

void tradeoff_keep(const struct traj_result *r, struct tradeoff_values *v)
{
    size_t count = (size_t)r->rows * (size_t)r->columns;
    v->rows = r->rows;
    v->columns = r->columns;
    v->value = sga_malloc((count + 1) * sizeof *v->value);
    for (size_t i = 0; i < count; i++)
        v->value[i] = r->digits && r->digits[i] ? num_dd_parse(r->digits[i]) : num_dd_of(r->value[i]);
}

/* Short solutions are timed again: the least of several is the one that nothing disturbed. */
static void measure_again(struct tradeoff_run *u, struct tradeoff_row *row, double seconds)
{
    double end = sga_cpu() + fmin(seconds, REPEAT_SECONDS);
    for (int k = 1; k < REPEATS && row->seconds < SHORT_SECONDS && sga_cpu() < end; k++) {
        struct traj_result r;
        struct sga_error err = { 0 };
        if (!tradeoff_solve(u, row, true, end - sga_cpu(), &r, &err))
            return;
        row->seconds = fmin(row->seconds, r.seconds);
        traj_result_clear(&r);
    }
}

void tradeoff_take(struct tradeoff_run *u, struct tradeoff_row *row, const struct traj_result *r, double seconds)
{
    assert(!row->finished);
    row->method = r->method;
    row->seconds = r->seconds;
    row->evaluations = r->evaluations;
    row->residual = r->rows ? r->residual : NAN;
    row->finished = true;
    row->note[0] = 0;
    row->ended = r->ended;
    row->ended_t = r->ended_t;
    row->ended_reason = r->ended_reason;
    tradeoff_keep(r, &row->values);
    if (r->unit && !u->t->unit)
        u->t->unit = memcpy(sga_malloc((size_t)(r->columns + 1) * sizeof *u->t->unit), r->unit, (size_t)r->columns * sizeof *u->t->unit);
    measure_again(u, row, seconds);
}

void tradeoff_leave_out(struct tradeoff *t, const struct tradeoff_left_out *l)
{
    assert(l->method && l->from >= 0);
    t->left_out = sga_realloc(t->left_out, (size_t)(t->left_outs + 1) * sizeof *t->left_out);
    t->left_out[t->left_outs++] = *l;
}
