/* One request, stage by stage: read, reduce, print, witness, integrate, write. */
#include "answer.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kronecker.h"
#include "lin.h"
#include "slice.h"
#include "guess.h"
#include "mem.h"
#include "seeds.h"
#include "tradeoff.h"
#include "watch.h"

void sga_init_guest(void)
{
    lin_init();
    sga_watch_init();
}

void sga_init(void)
{
    sga_init_guest();
    sga_watch_hook();
    request_init();
}

/* What checking may take; a request that needs more is judged where it runs. */
static const double CHECK_SECONDS = 1;
enum { CHECK_NODES = 2000000 };

bool sga_canonical(const char *request, size_t length, struct sga_buf *out, struct sga_error *err)
{
    struct request r;
    struct request_bounds bounds = { .seconds = CHECK_SECONDS, .nodes = CHECK_NODES };
    struct sga_error own = { 0 };
    err = err ? err : &own;
    if (request_read_within(&r, request, length, &bounds, err))
        request_clear(&r);
    else if (!bounds.met)
        return false;
    *err = (struct sga_error){ 0 };
    return request_canonical(request, length, out, err);
}

/* Gauge fields that only a motion needs may take so many nodes: solved for numerically, a large choice takes less. */
enum { MOTION_GAUGE_NODES = 100000 };

static const double MAX_MEMORY = 0x1p34, DEFAULT_MEGABYTES = 2048;

static void progress(struct job *j, const char *stage, double fraction)
{
    j->stage = stage;
    if (j->options && j->options->progress)
        j->options->progress(j->options->ctx, stage, fraction);
}

static void name_stage(struct sga_error *err, const char *stage)
{
    if (!err->stage[0])
        snprintf(err->stage, sizeof err->stage, "%s", stage);
}

static void wall(void *ctx, const struct sga_error *err)
{
    const struct job *j = ctx;
    struct sga_error located = *err;
    name_stage(&located, j->stage);
    j->options->wall(j->options->ctx, &located);
}

static void set_budget(struct job *j)
{
    double most = j->options && j->options->max_seconds > 0 ? j->options->max_seconds : 3600;
    double seconds = j->request.limits.seconds > 0 ? fmin(j->request.limits.seconds, most) : most;
    double memory = j->options && j->options->max_memory ? (double)j->options->max_memory : MAX_MEMORY;
    double megabytes = j->request.limits.megabytes > 0 ? j->request.limits.megabytes : DEFAULT_MEGABYTES;
    j->budget = (struct sga_budget){
        .deadline = sga_now() + seconds - j->spent, .seconds = seconds,
        .max_generations = j->request.limits.generations,
        .max_memory = (size_t)fmin(megabytes * 0x1p20, memory),
        .max_terms = j->request.limits.terms,
        .cancelled = j->options ? j->options->cancelled : NULL,
        .cancel_ctx = j->options ? j->options->ctx : NULL,
        .warnings = &j->warnings,
        .exec = j->options ? j->options->exec : NULL,
    };
    j->request.store.max_nodes = j->request.limits.nodes;
    j->request.store.deadline = j->budget.deadline;
    j->request.store.seconds = seconds;
}

/* What is wanted but cannot be had yet is refused before any work is done. */
static bool check_wants(struct job *j)
{
    if (j->request.want & REQUEST_TRADEOFF && j->request.sweeps)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/want", "a tradeoff is measured on one motion; leave out \"sweep\", or "
                           "send a request of its own");
    if (j->request.op.open_sources && j->request.want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL))
        return sga_fail_at(j->err, SGA_E_NO_MOTION, "/system/sources", "to follow a motion, give each source as a function of time");
    return true;
}

/* Samples that cannot fit are refused before any work is done. */
static bool check_samples(struct job *j)
{
    const struct request_trajectory *t = &j->request.trajectory;
    if (!(j->request.want & REQUEST_TRAJECTORY))
        return true;
    double columns = 1 + (double)(t->outputs ? t->outputs : j->request.system.variables);
    double numbers = columns * (double)t->samples * (j->request.sweeps ? j->request.sweeps : 1), most = (double)answer_limit(j);
    if (2 * numbers <= most && 8 * numbers <= (double)j->budget.max_memory)
        return true;
    bool text = 2 * numbers > most;
    return sga_fail_at(j->err, text ? SGA_E_LIMIT_RESULT : SGA_E_LIMIT_MEMORY, "/trajectory",
                       "%.0f samples of %.0f columns need %.0f MB at least; the limit of %s is %.0f MB; ask for fewer samples, "
                       "or for fewer columns in trajectory.outputs", numbers / columns, columns,
                       (text ? 2 : 8) * numbers * 0x1p-20, text ? "a result" : "memory",
                       (text ? most : (double)j->budget.max_memory) * 0x1p-20);
}

/* Where the request starts is a hint for which component of the constraint set is meant. */
static void set_near(struct job *j)
{
    const struct request_trajectory *t = &j->request.trajectory;
    j->start.time = t->start;
    if (!t->initials)
        return;
    j->start.x = sga_calloc((size_t)j->request.system.variables, sizeof *j->start.x);
    for (int k = 0; k < t->initials; k++)
        j->start.x[t->initial[k].variable] = t->initial[k].value;
    const struct sys_system *s = &j->request.system;
    if (j->request.tables) {
        j->start.parameter = sga_calloc((size_t)s->parameters + 1, sizeof *j->start.parameter);
        for (int k = 0; k < s->parameters; k++) {
            const struct expr_symbol *p = s->store->symbol + s->parameter[k];
            j->start.parameter[k] = p->table ? expr_table_value(p->table, p->order, t->start) : NAN;
        }
    }
    j->start.given = sga_calloc((size_t)s->variables + 1, 1);
    for (int k = 0; k < t->initials; k++)
        j->start.given[t->initial[k].variable] = 1;
    guess_complete(s, j->start.given, j->start.time, j->start.parameter, j->start.x);
}

/* Sources that are only named were left out: what depends on them is not told, and the verdict is
 * the one for general sources. */
static void open_sources(struct job *j)
{
    if (j->op->solvable)
        j->solution.verdict = SGA_UNIQUE;
    else if (j->op->asks_sources)
        j->solution.verdict = SGA_INCONSISTENT;
    j->request.want &= ~(unsigned)(REQUEST_CONSTRAINTS | REQUEST_VECTOR_FIELD | REQUEST_GAUGE);
    if (j->solution.verdict == SGA_INCONSISTENT)
        snprintf(j->solution.contradiction_why, sizeof j->solution.contradiction_why,
                 "the operator has rank %d of %d, and the equations left over ask something of the sources", j->op->rank,
                 j->request.op.unknowns);
}

int answer_gauge_nodes(const struct job *j)
{
    const struct expr_store *st = &j->request.store;
    int left = st->max_nodes ? (st->max_nodes - st->nodes) / 4 : MOTION_GAUGE_NODES;
    if (j->request.accuracy.arithmetic == REQUEST_BALL)
        return 0;
    return left < 1 ? 1 : left < MOTION_GAUGE_NODES ? left : MOTION_GAUGE_NODES;
}

static bool solve(struct job *j)
{
    /* motions choose the gauge by expressions, those of other rows where there are conditions */
    bool motion = j->request.want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF) && !j->request.trajectory.conditions;
    struct reduction_options options = {
        .near = j->start.x, .near_given = j->start.given, .near_time = j->start.time, .parameter_near = j->start.parameter, .seed = SGA_SEED_REDUCTION, .budget = &j->budget,
        .combinations = j->request.want & (REQUEST_CONSTRAINTS | REQUEST_STRUCTURE),
        .gauge_fields = j->request.want & (REQUEST_GAUGE | REQUEST_SYMMETRIES) || motion,
        .gauge_nodes = j->request.want & (REQUEST_GAUGE | REQUEST_SYMMETRIES) ? 0 : answer_gauge_nodes(j),
        .rows = j->request.want & REQUEST_STRUCTURE,
    };
    if (j->solved) {
        points_shadow_clear(&j->shadow);
        sga_solution_clear(&j->solution);
    }
    points_shadow_init(&j->shadow, 20250101);
    j->stage = "sga";            /* as the solver names it in its own errors */
    j->solved = true;
    bool ok = sga_reduce(&j->request.system, &options, &j->shadow, &j->solution, j->err);
    j->clock.sampling += j->shadow.seconds_sampling;
    return ok;
}

bool answer_reduce(struct job *j)
{
    if (j->place.depth)                /* a stratum: its rows are those of the whole, brought to form already */
        return solve(j);
    stage_begin(&j->clock, STAGE_REDUCTION);
    bool ok = answer_holonomic(j, answer_primary(j, solve));
    if (ok && j->solution.verdict == SGA_UNDERDETERMINED && answer_holonomic_redundant(j))
        ok = solve(j);
    if (ok && !j->primary.has)
        answer_restrictions_kept(j, &j->solution);
    if (ok && j->op && j->request.op.open_sources)
        open_sources(j);
    return ok && answer_two_form(j);
}

static bool structure(struct job *j)
{
    stage_begin(&j->clock, STAGE_STRUCTURE);
    j->structure.has = true;
    return structure_find(&j->request.system, &j->solution, &j->shadow, &j->budget, &j->structure.found, j->err);
}

static void structure_free(struct job *j)
{
    if (j->structure.has)
        structure_clear(&j->structure.found);
    sga_buf_free(&j->structure.kronecker);
}

static bool kronecker(struct job *j)
{
    return kronecker_text(j, &j->structure.kronecker, &j->structure.is_linear);
}

static void reduction_clear(struct job *j)
{
    free(j->redundant);
    answer_primary_clear(j);
    if (j->solved) {
        points_shadow_clear(&j->shadow);
        sga_solution_clear(&j->solution);
    }
}

static void texts_clear(struct job *j)
{
    if (j->texts.has)
        expr_names_clear(&j->texts.names);
    free(j->texts.scale);
    free(j->texts.reduced);
}

static bool strata(struct job *j)
{
    answer_strata(j);
    return true;
}

static bool signs(struct job *j)
{
    answer_signs(j);
    return sga_budget_ok(&j->budget, j->err);
}

static void signs_clear(struct job *j)
{
    sga_buf_free(&j->signs);
}

static bool motion(struct job *j)
{
    bool ok = answer_motion(j);
    if (!ok && j->err->code == SGA_E_NO_MOTION && j->solution.verdict != SGA_INCONSISTENT)
        ok = answer_motion_on_stratum(j);
    return ok;
}

static void motion_clear(struct job *j)
{
    if (j->trajectory.has)
        traj_result_clear(&j->trajectory.result);
    sga_buf_free(&j->trajectory.sweep);
    answer_integrals_clear(j);
    if (j->initial.has)
        traj_initial_clear(&j->initial.result);
    answer_tradeoff_clear(j->tradeoff);
}

static bool has_operator(const struct job *j)
{
    return j->request.op.has;
}

static bool has_mechanical(const struct job *j)
{
    return j->request.has_mechanical;
}

static bool wants_structure(const struct job *j)
{
    return j->request.want & REQUEST_STRUCTURE && !j->request.op.open_sources;
}

static bool wants_symmetries(const struct job *j)
{
    return j->request.want & REQUEST_SYMMETRIES;
}

static bool wants_kronecker(const struct job *j)
{
    return j->request.want & REQUEST_STRUCTURE || (j->op && j->op->system.order <= 1);
}

/* What a job goes through, in this order: what is said of the system, and then what follows it along a motion. */
static const struct job_stage {
    const char *name;                      /* of progress and of errors */
    double at;                             /* of the whole, where it begins; negative: it is not shown */
    bool follows;                          /* runs once all that is said is known not to rest on what was left out (slice.h) */
    bool (*wanted)(const struct job *j);   /* NULL: always */
    bool (*run)(struct job *j);            /* false: the job ends with j->err */
    void (*clear)(struct job *j);          /* what it has in the job, whether it ran or not; NULL: nothing of its own */
} stages[] = {
    { "operator",   -1,   false, has_operator,     answer_operator,          answer_operator_clear },
    { "mechanical", 0.04, false, has_mechanical,   answer_mechanical,        answer_mechanical_clear },
    { "reduction",  0.05, false, NULL,             answer_reduce,            reduction_clear },
    { "sga",        -1,   false, has_mechanical,   answer_mechanical_motion, NULL },
    { "texts",      0.4,  false, NULL,             answer_texts,             texts_clear },
    { "texts",      -1,   false, NULL,             strata,                   answer_strata_clear },
    { "texts",      -1,   false, NULL,             signs,                    signs_clear },
    { "witness",    0.45, false, NULL,             answer_witness,           NULL },
    { "structure",  0.45, false, wants_structure,  structure,                structure_free },
    { "symmetries", 0.48, false, wants_symmetries, answer_symmetries,        answer_symmetries_clear },
    { "structure",  -1,   false, wants_kronecker,  kronecker,                NULL },
    { "trajectory", 0.5,  true,  NULL,             motion,                   motion_clear },
    { "trajectory", -1,   true,  NULL,             answer_strata_solve,      NULL },
};
enum { ALL_STAGES = sizeof stages / sizeof *stages };

/* What every stage keeps: the store, the system, and the solution where there is one. */
static bool job_sane(const struct job *j, int nodes)
{
    return expr_store_sane(&j->request.store, nodes) && sys_sane(&j->request.system)
           && (!j->solved || sga_solution_sane(&j->request.system, &j->solution));
}

static bool run_stages(struct job *j, bool follows)
{
    bool ok = true;
    for (int k = 0; k < ALL_STAGES && ok; k++) {
        const struct job_stage *s = stages + k;
        if (s->follows != follows || (s->wanted && !s->wanted(j)))
            continue;
        if (s->at >= 0)
            progress(j, s->name, s->at);
        else
            j->stage = s->name;
        int nodes = j->request.store.nodes;
        ok = s->run(j);
        assert(!ok || job_sane(j, nodes));
    }
    return ok;
}

void answer_clear(struct job *j)
{
    for (int k = ALL_STAGES - 1; k >= 0; k--)
        if (stages[k].clear)
            stages[k].clear(j);
    answer_slice_clear(j);
    free(j->start.x);
    free(j->start.given);
    free(j->start.parameter);
    sga_warnings_clear(&j->warnings);
}

/* Past a limit nothing is an answer any more; nor is a refusal, for what failed may have been stopped (watch.h). */
static bool within_limits(struct job *j)
{
    enum sga_code code = j->err->code;
    bool said = code == SGA_E_LIMIT_SECONDS || code == SGA_E_LIMIT_MEMORY || code == SGA_E_CANCELLED;
    if (!said && !sga_budget_ok(&j->budget, NULL))
        *j->err = (struct sga_error){ 0 };
    return sga_budget_ok(&j->budget, j->err);
}

/* A request that was read, from its system to its result. *again: what was left out of the system has to
 * be looked at after all. */
static bool run_request(struct job *j, bool tied, struct sga_buf *out, bool *again)
{
    answer_warn_unused(j);
    answer_slice(j, tied);
    set_near(j);
    bool ok = check_wants(j) && check_samples(j) && run_stages(j, false);
    *again = ok && !answer_slice_holds(j);
    ok = ok && !*again && run_stages(j, true);
    *again |= ok && !answer_slice_holds(j);
    if (*again)
        return false;
    if (ok) {
        progress(j, "writing", 0.98);
        ok = answer_write(j, out);
    }
    return within_limits(j) && ok;
}

/* What was not found may be beyond a limit. */
static void explain_limits(struct job *j)
{
    enum sga_code code = j->err->code;
    if (code == SGA_E_NO_REAL_POINT || code == SGA_E_UNDECIDED || code == SGA_E_IRREGULAR || code == SGA_E_SPLIT)
        sga_limits_explain(&j->warnings, j->err);
}

/* One way through, from the text. */
static bool run_text(struct job *j, const char *request, size_t length, bool tied, struct sga_buf *out, bool *again)
{
    stage_begin(&j->clock, STAGE_READ);
    j->request_text = request;
    j->request_length = length;
    set_budget(j);                 /* the service's; the request's own once it is read */
    sga_watch_begin(&j->budget, j->options && j->options->wall ? wall : NULL, j);
    if (!request_read(&j->request, request, length, j->err)) {
        sga_watch_end();
        return false;
    }
    set_budget(j);
    bool ok = run_request(j, tied, out, again);
    if (!ok && !*again) {
        name_stage(j->err, j->stage);
        explain_limits(j);
    }
    sga_watch_end();
    answer_clear(j);
    request_clear(&j->request);
    return ok;
}

bool sga_run(const char *request, size_t length, const struct sga_run_options *options,
             struct sga_buf *out, struct sga_error *err)
{
    struct sga_error own = { 0 };
    struct job j = { .options = options, .err = err ? err : &own, .stage = "request" };
    double begin = sga_now();
    bool again = false, ok = run_text(&j, request, length, true, out, &again);
    if (!again)
        return ok;
    j = (struct job){ .options = options, .err = err ? err : &own, .stage = "request", .spent = sga_now() - begin };
    return run_text(&j, request, length, false, out, &again);
}
