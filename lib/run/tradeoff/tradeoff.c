/* Speed against accuracy: one system, one motion, every method and arithmetic at ever tighter
 * tolerances, each measured and compared with the best solution of all. */
#include "tradeoff.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>

#include "budget.h"
#include "run_job.h"
#include "mem.h"
#include "request.h"
#include "stage_clock.h"

/* The table may take this part of the time that is left (of 30 seconds, four) as CPU, and on a machine that is shared
 * this part on the clock; the rows this part of either, and the rest is for the best solution. */
static const double PART = 0.125, WALL_PART = 0.75, ROWS_PART = 0.55;
/* Samples times columns that are compared; more samples are thinned out. */
static const double MOST_VALUES = 1e5;

/* At most so many samples, evenly, the last one among them. */
static double *thin(struct traj_request *r, int columns)
{
    int most = (int)fmax(2, fmin(r->samples, MOST_VALUES / (columns + 1)));
    double *times = sga_malloc((size_t)(most + 1) * sizeof *times);
    expr_id *exact = r->exact_time ? sga_malloc((size_t)(most + 1) * sizeof *exact) : NULL;
    if (most > r->samples)
        most = r->samples;
    for (int k = 0; k < most; k++) {
        int from = most == 1 ? 0 : (int)((double)k * (r->samples - 1) / (most - 1));
        times[k] = r->times[from];
        if (exact)
            exact[k] = r->exact_time[from];
    }
    assert(times[most - 1] == r->times[r->samples - 1]);
    r->samples = most;
    r->times = times;
    r->exact_time = exact;
    return times;
}

double tradeoff_left(struct tradeoff_end end)
{
    return fmax(fmin(end.cpu - sga_cpu(), end.wall - sga_now()), 0);
}

static struct tradeoff_end end_after(double left, double part)
{
    return (struct tradeoff_end){ sga_cpu() + part * PART * left, sga_now() + part * WALL_PART * left };
}

bool answer_tradeoff(struct job *j, const struct sga_solution *solution, const struct traj_request *request)
{
    const struct request_accuracy *a = &j->request->accuracy;
    double left = j->budget->deadline ? j->budget->deadline - sga_now() : 30;
    stage_begin(j->clock, STAGE_TRADEOFF);
    struct tradeoff *t = sga_calloc(1, sizeof *t);
    struct tradeoff_run u = { .j = j, .solution = solution, .request = *request, .t = t,
                              .rows_end = end_after(left, ROWS_PART), .end = end_after(left, 1) };
    j->tradeoff = t;
    double *times = thin(&u.request, request->outputs ? request->outputs : j->request->system.variables);
    bool ok = tradeoff_rows(&u) && tradeoff_best(&u);
    if (ok) {
        tradeoff_errors(t, a->rtol, a->atol);
        tradeoff_advice(t, a->rtol, a->atol);
        assert(tradeoff_sane(t));
    }
    free(times);
    free((expr_id *)u.request.exact_time);
    return ok;
}

bool tradeoff_sane(const struct tradeoff *t)
{
    for (int k = 0; k < TRADEOFF_CHOICES; k++)
        if (t->choice[k].row >= t->rows || (t->choice[k].none && t->choice[k].row >= 0))
            return false;
    for (int i = 0; i < t->rows; i++) {
        const struct tradeoff_row *row = t->row + i;
        if (!row->method || row->seconds < 0 || (row->compared && (row->error > row->error_at_most || row->digits > row->digits_most || (row->within && row->beyond))))
            return false;
        if (row->ended && !row->ended_reason)
            return false;
    }
    return !t->best.has || (t->best.row < t->rows && t->best.values.columns > 0);
}

void answer_tradeoff_clear(struct tradeoff *t)
{
    if (!t)
        return;
    for (int i = 0; i < t->rows; i++)
        free(t->row[i].values.value);
    free(t->row);
    free(t->unit);
    free(t->best.values.value);
    free(t->best.doubt);
    free(t->best.size);
    free(t->best.unit);
    free(t->left_out);
    sga_buf_free(&t->advice);
    free(t);
}
