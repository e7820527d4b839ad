/* The bare motion of a request: motion FILE [RUNS]
 *
 * Prints one line of JSON: the least CPU seconds, over RUNS (200), of what is left of a motion once its system is reduced and its formulas are
 * machine code: the start made consistent, the solution and the second one for its error estimate. Beside it the motion's set-up: flow and start
 * of a fresh motion with its code, without the reduction. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "budget.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "ode.h"
#include "oracle.h"
#include "exec.h"
#include "reduction.h"
#include "request.h"

static struct request request;
static struct sga_error err;

static int failed(void)
{
    fprintf(stderr, "motion: %s\n", err.detail);
    return 1;
}

static bool begin(struct flow *f, const struct sga_solution *s, const struct traj_request *motion, double *x)
{
    double moved;
    return flow_start(f, &request.system, s, motion, x, &moved, &err) && field_begin(f->field, motion->start, x, &err);
}

static bool solve(struct flow *f, const struct traj_request *motion, const struct ode_problem *problem, const double *x)
{
    struct ode_start start = { .t = motion->start, .x = x, .count = motion->samples, .times = motion->times };
    struct ode_options options = ode_options_default();
    struct ode_result r;
    options.method = NULL;
    options.rtol = motion->rtol;
    options.atol = motion->atol;
    options.estimate_global_error = options.refine = true;
    options.budget = motion->budget;
    if (!flow_solve(f, motion, problem, &start, &options, &r, &err))
        return false;
    ode_result_free(&r);
    return true;
}

int main(int argc, char **argv)
{
    FILE *file = argc > 1 ? fopen(argv[1], "rb") : NULL;
    int runs = argc > 2 ? atoi(argv[2]) : 200;
    char *text = malloc(1 << 20);
    size_t length = file ? fread(text, 1, 1 << 20, file) : 0;
    if (!length || runs < 1 || !request_read(&request, text, length, &err))
        return failed();
    const struct request_trajectory *t = &request.trajectory;
    size_t n = (size_t)request.system.variables;
    double *initial = calloc(n + 1, sizeof *initial), *x = calloc(n + 1, sizeof *x), least = INFINITY;
    unsigned char *given = calloc(n + 1, 1);
    struct sga_budget budget = { .exec = sga_exec_new(1 << 22) };
    for (int k = 0; k < t->initials; k++) {
        initial[t->initial[k].variable] = t->initial[k].value;
        given[t->initial[k].variable] = 1;
    }
    struct traj_request motion = { .start = t->start, .times = t->times, .samples = t->samples, .initial = initial, .given = given, .held = calloc(n + 1, 1),
                                   .outputs = t->outputs, .output = t->output, .rtol = request.accuracy.rtol, .atol = request.accuracy.atol, .budget = &budget };
    struct reduction_options options = { .near = initial, .near_time = t->start, .seed = 1, .gauge_fields = true };
    struct points_oracle oracle;
    struct sga_solution solution;
    struct flow flow;
    points_oracle_init(&oracle, 20250101);
    if (!sga_reduce(&request.system, &options, &oracle, &solution, &err))
        return failed();
    double since = sga_cpu();
    if (!flow_init(&flow, &request.system, &solution, &motion, &err) || !begin(&flow, &solution, &motion, x) || !field_slope_init(flow.field, &err))
        return failed();
    struct ode_problem problem = flow_problem(&flow, &motion);
    double made = sga_cpu() - since;
    for (int i = 0; i < runs; i++) {
        since = sga_cpu();
        if (!begin(&flow, &solution, &motion, x) || !solve(&flow, &motion, &problem, x))
            return failed();
        least = fmin(least, sga_cpu() - since);
    }
    printf("{\"best\": %.9f, \"set_up\": %.9f}\n", least, made);
    return 0;
}
