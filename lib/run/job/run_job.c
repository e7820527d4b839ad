/* What is asked of a job everywhere; the list of stages as it runs. */
#include "run_job.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "buf.h"
#include "error.h"
#include "reduction.h"
#include "request.h"
#include "system.h"
#include "team.h"
#include "tolerance.h"
#include "warnings.h"

void job_progress_at(struct job *j, const char *stage, double fraction, double t)
{
    j->stage = stage;
    if (j->host.progress)
        j->host.progress(j->host.ctx, stage, fraction, t);
}

void job_progress(struct job *j, const char *stage, double fraction)
{
    job_progress_at(j, stage, fraction, NAN);
}

/* What every stage keeps: the store, the system, and the solution where there is one. */
static bool job_sane(const struct job *j, int nodes)
{
    return expr_store_sane(&j->request->store, nodes) && sys_sane(&j->request->system)
           && (!j->solution || sga_solution_sane(&j->request->system, j->solution));
}

bool job_run(struct job *j, bool follows)
{
    bool ok = true;
    for (const struct job_stage *s = j->stages; s->name && ok; s++) {
        if (s->follows != follows || (s->wanted && !s->wanted(j)))
            continue;
        if (s->at >= 0)
            job_progress(j, s->name, s->at);
        else
            j->stage = s->name;
        int nodes = j->request->store.nodes;
        ok = s->run(j);
        assert(!ok || job_sane(j, nodes));
    }
    return ok;
}

void job_clear(struct job *j)
{
    assert(j->stages && j->place.depth >= j->place.inside);
    const struct job_stage *s = j->stages;
    while (s->name)
        s++;
    while (s-- != j->stages)
        if (s->clear)
            s->clear(j);
    sga_warnings_clear(j->warnings);
    sga_arena_end(&j->mem);
}

const char *answer_variable_name(const struct job *j, int variable)
{
    assert(variable >= 0 && variable < j->request->system.variables);
    return j->request->store.symbol[j->request->system.variable[variable].symbol].name;
}

bool job_goes_on(const struct job *j)
{
    return sga_budget_ok(j->budget, j->err);
}

bool job_has_left(const struct job *j)
{
    return sga_budget_ok(j->budget, NULL);
}

/* Of the time granted: what writing an answer takes without a part that there was no time for. */
static const double WRITING_PART = 0.025;

double job_shorten(struct job *j)
{
    double deadline = j->budget->deadline;
    if (deadline > 0)
        j->budget->deadline = deadline - WRITING_PART * j->budget->seconds;
    return deadline;
}

bool job_leaves_out(struct job *j, double deadline, const char *pointer, const char *what)
{
    j->budget->deadline = deadline;
    if ((j->err->code && j->err->code != SGA_E_LIMIT_SECONDS) || !job_has_left(j))
        return false;
    *j->err = (struct sga_error){ 0 };
    sga_warn(j->budget, SGA_W_WORK_CUT, pointer, "the limit of %g seconds was reached: the motion is kept, without %s; raise limits.seconds", j->budget->seconds, what);
    return true;
}

/* From the motion's end. The service waits for five past the time granted. */
static const double ENDING_SECONDS = 1;

void job_ends(struct job *j)
{
    assert(j->budget->deadline > 0);
    if (j->one_of_many)
        return;
    j->budget->deadline = fmax(j->budget->deadline, sga_now() + ENDING_SECONDS);
    j->request->store.deadline = j->budget->deadline;
}

bool job_helps(const struct job *j)
{
    return j->host.team && j->host.team->member;
}

size_t answer_limit(const struct job *j)
{
    return j->host.most_result ? j->host.most_result : (size_t)1 << 30;
}

bool answer_fits(struct job *j, const struct sga_buf *out)
{
    const struct answer_flow *flow = j->host.flow;
    size_t limit = answer_limit(j), length = out->len + (flow && flow->out == out ? flow->given : 0);
    if (length <= limit)
        return true;
    return sga_fail(j->err, SGA_E_LIMIT_RESULT, "the result has more than %.1f MB (%.1f MB were written); ask for fewer samples, "
                    "or for less in want", (double)limit * 0x1p-20, (double)length * 0x1p-20);
}

/* Bytes of a result that go at a time. */
static const size_t PIECE = 256 << 10;

bool answer_goes(struct job *j, struct sga_buf *out)
{
    struct answer_flow *flow = j->host.flow;
    if (!answer_fits(j, out))
        return false;
    if (!flow || flow->out != out || out->len < PIECE)
        return true;
    flow->give(flow->ctx, out->data, out->len);
    flow->given += out->len;
    sga_buf_clear(out);
    return true;
}

void answer_raw(struct job *j, struct sga_json *w, const char *text)
{
    size_t left = strlen(text), n = left < PIECE ? left : PIECE;
    sga_json_raw(w, text, n);
    while (left -= n) {
        text += n;
        n = left < PIECE ? left : PIECE;
        answer_goes(j, w->out);
        sga_buf_put(w->out, text, n);
    }
}

bool answer_value_moved(const struct job *j, const struct request_initial *given, const double *x)
{
    struct sga_tolerance asked = { j->request->accuracy.rtol, j->request->accuracy.atol };
    return fabs(x[given->variable] - given->value) > sga_allowed(asked, 1, given->value);
}

bool answer_start_moved(const struct job *j, const double *x)
{
    const struct request_trajectory *t = &j->request->trajectory;
    for (int k = 0; k < t->initials; k++)
        if (answer_value_moved(j, t->initial + k, x))
            return true;
    return false;
}

/* Gauge fields that only a motion needs may take so many nodes: solved for numerically, a large choice takes less. */
enum { MOTION_GAUGE_NODES = 100000 };

int answer_gauge_nodes(const struct job *j)
{
    const struct expr_store *st = &j->request->store;
    int left = st->max_nodes ? (st->max_nodes - st->nodes) / 4 : MOTION_GAUGE_NODES;
    if (j->request->accuracy.arithmetic == REQUEST_BALL)
        return 0;
    return left < 1 ? 1 : left < MOTION_GAUGE_NODES ? left : MOTION_GAUGE_NODES;
}

void answer_free_name(const struct job *j, int k, char *out, size_t size)
{
    assert(k >= 0 && k < j->solution->free_columns);
    const struct expr_store *st = &j->request->store;
    snprintf(out, size, "f%d", k + 1);
    while (expr_symbol_find(st, out, strlen(out)) >= 0) {
        size_t n = strlen(out);
        if (n + 2 > size)
            return;
        out[n] = '_';
        out[n + 1] = 0;
    }
}
