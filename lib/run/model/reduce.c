/* The reduction of a job. */
#include "reduce.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>

#include "operator_answer.h"
#include "oracle.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "seeds.h"
#include "stage_clock.h"

/* Sources that are only named were left out: what depends on them is not told, and the verdict is
 * the one for general sources. */
static void open_sources(struct job *j)
{
    assert(j->op->rank <= j->request->op.unknowns && !(j->op->solvable && j->op->asks_sources));
    if (j->op->solvable)
        j->solution->verdict = SGA_UNIQUE;
    else if (j->op->asks_sources)
        j->solution->verdict = SGA_INCONSISTENT;
    j->request->want &= ~(unsigned)(REQUEST_CONSTRAINTS | REQUEST_VECTOR_FIELD | REQUEST_GAUGE | REQUEST_DERIVATION);
    if (j->solution->verdict == SGA_INCONSISTENT)
        snprintf(j->solution->contradiction_why, sizeof j->solution->contradiction_why,
                 "the operator has rank %d of %d, and the equations left over ask something of the sources", j->op->rank,
                 j->request->op.unknowns);
}

static void drop_solution(struct job *j)
{
    if (j->solution) {
        points_oracle_clear(j->oracle);
        sga_solution_clear(j->solution);
    }
    j->oracle = NULL;
    j->solution = NULL;
}

static bool solve(struct job *j)
{
    /* motions choose the gauge by expressions, those of other rows where there are conditions */
    unsigned moves = REQUEST_TRAJECTORY | REQUEST_TRADEOFF | (j->request->trajectory.relations ? REQUEST_CONSISTENT_INITIAL : 0);
    bool motion = j->request->want & moves && !j->request->trajectory.conditions;
    bool fields = j->request->want & (REQUEST_GAUGE | REQUEST_SYMMETRIES | REQUEST_LINEARIZATION | REQUEST_TRANSFER | REQUEST_EQUILIBRIA | REQUEST_DERIVATION);
    const unsigned told = REQUEST_CONSTRAINTS | REQUEST_INDEX;
    struct reduction_options options = {
        .near = j->start.x, .near_given = j->start.given, .near_time = j->start.time, .parameter_near = j->start.parameter, .seed = SGA_SEED_REDUCTION, .budget = j->budget,
        .combinations = j->request->want & (REQUEST_CONSTRAINTS | REQUEST_STRUCTURE | REQUEST_DERIVATION),
        .gauge_fields = fields || motion,
        .gauge_nodes = fields ? 0 : answer_gauge_nodes(j),
        .field_unasked = !(j->request->want & ~told) && !j->request->mechanical && !j->request->op.has,
        .rows = j->request->want & (REQUEST_STRUCTURE | REQUEST_DERIVATION),
        .rates = j->request->want & REQUEST_DERIVATION,
    };
    drop_solution(j);
    j->solution = sga_zeros(&j->mem, 1, sizeof *j->solution);
    j->oracle = sga_zeros(&j->mem, 1, sizeof *j->oracle);
    points_oracle_init(j->oracle, 20250101);
    j->stage = "sga";            /* as the solver names it in its own errors */
    bool ok = sga_reduce(&j->request->system, &options, j->oracle, j->solution, j->err);
    j->clock->sampling += j->oracle->seconds_sampling;
    return ok;
}

bool answer_reduce(struct job *j)
{
    if (j->place.depth)                /* a stratum: its rows are those of the whole, brought to form already */
        return solve(j);
    stage_begin(j->clock, STAGE_REDUCTION);
    bool ok = answer_holonomic(j, answer_primary(j, solve));
    if (ok && j->solution->verdict == SGA_UNDERDETERMINED && answer_holonomic_redundant(j))
        ok = solve(j);
    if (ok && !j->primary)
        answer_restrictions_kept(j, j->solution);
    if (ok && j->op && j->request->op.open_sources)
        open_sources(j);
    return ok && answer_two_form(j);
}

void answer_reduce_clear(struct job *j)
{
    drop_solution(j);
}

