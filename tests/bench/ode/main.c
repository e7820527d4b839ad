/* Work against accuracy of the integrators: ode FOLDER [ours] [NAME]
 *
 * FOLDER has cases.py's requests. Every peer solves every problem at a row of
 * tolerances, and so does ours with the method left to it (with SGA_BENCH_METHODS set: by each of them too); each line says
 *   problem, stiff, method, tolerance, seconds, error, evaluations, samples delivered in
 * with the least CPU seconds of repeated solutions and the true error, the largest over samples and columns, relative to
 * |value| + floor. Methods of ours: libsga's own flow of the request, projection and reduced field by its tapes as in
 * the program; "ours+" computes a second solution for the error estimate too. What is set up
 * once for a system is not counted on either side: reduction, tapes, machine code; gcc.
 * SGA_BENCH_MS: the milliseconds that repetitions take together, 50 unless set. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <gsl/gsl_errno.h>
#include "budget.h"
#include "error.h"
#include "exec.h"
#include "field.h"
#include "flow.h"
#include "ode.h"
#include "problem.h"
#include "reduction.h"
#include "request.h"
#include "oracle.h"

static double least_time = 0.05;      /* of repetitions together */
enum { SLOW = 1 };                    /* seconds of one solution beyond which tighter ones are left out */

double cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void take_sample(const struct problem *p, const double *x, int sample, struct outcome *o)
{
    for (int c = 0; c < p->columns; c++)
        o->out[sample * p->columns + c] = x[p->column[c]];
}

static double error_of(const struct problem *p, const struct outcome *o)
{
    double worst = 0;
    for (int i = 0; i < p->samples * p->columns; i++) {
        double e = fabs(o->out[i] - p->reference[i]) / (fabs(p->reference[i]) + p->floor);
        worst = !(e <= worst) ? e : worst;
    }
    return worst;
}

/* Ours: the system reduced once. */
struct own {
    struct request request;
    struct points_oracle oracle;
    struct sga_solution solution;
    struct flow flow;
    struct traj_request motion;
    double *x;
    struct ode_problem problem;
};

static void own_fail(const struct sga_error *err)
{
    fprintf(stderr, "ode: %s\n", err->detail);
    exit(1);
}

static void own_start(struct own *w)
{
    const struct request_trajectory *t = &w->request.trajectory;
    int n = w->request.system.variables;
    struct sga_error err = {0};
    double moved, *initial = calloc((size_t)n + 1, sizeof *initial);
    unsigned char *given = calloc((size_t)n + 1, 1);
    for (int k = 0; k < t->initials; k++) {
        initial[t->initial[k].variable] = t->initial[k].value;
        given[t->initial[k].variable] = 1;
    }
    w->motion = (struct traj_request){.start = t->start, .times = t->times, .samples = t->samples, .initial = initial,
                                      .given = given, .held = calloc((size_t)n + 1, 1), .outputs = t->outputs, .output = t->output};
    struct reduction_options options = {.near = initial, .near_time = t->start, .seed = 1, .gauge_fields = true};
    points_oracle_init(&w->oracle, 20250101);
    w->x = calloc((size_t)n + 1, sizeof *w->x);
    if (!sga_reduce(&w->request.system, &options, &w->oracle, &w->solution, &err) ||
        !flow_init(&w->flow, &w->request.system, &w->solution, &w->motion, &err) ||
        !flow_start(&w->flow, &w->request.system, &w->solution, &w->motion, w->x, &moved, &err) ||
        !field_begin(w->flow.field, t->start, w->x, &err) || !field_slope_init(w->flow.field, &err))
        own_fail(&err);
    static struct sga_budget budget;
    if (!budget.exec)
        budget.exec = sga_exec_new(1 << 26);
    w->motion.budget = &budget;
    w->problem = flow_problem(&w->flow, &w->motion);
}

static void own_read(struct own *w, const char *folder, int which)
{
    char path[4096], *text = malloc(1 << 20);
    struct sga_error err = {0};
    snprintf(path, sizeof path, "%s/ode%d.json", folder, which);
    FILE *f = fopen(path, "rb");
    size_t length = f ? fread(text, 1, 1 << 20, f) : 0;
    memset(w, 0, sizeof *w);
    if (!f || !request_read(&w->request, text, length, &err))
        own_fail(&err);
    fclose(f);
    free(text);
    own_start(w);
}

static bool own_solve(struct own *w, const struct problem *p, const char *method, bool estimate, double rtol, struct outcome *o, const char **used)
{
    struct ode_start start = {.t = w->motion.start, .x = w->x, .count = w->motion.samples, .times = w->motion.times};
    struct ode_options options = ode_options_default();
    struct ode_result r;
    options.method = method;
    options.rtol = rtol;
    options.atol = rtol * p->floor;
    options.estimate_global_error = estimate;
    double begin = cpu_seconds();
    if (!ode_solve(&w->problem, &start, &options, &r, NULL))
        return false;
    o->seconds = cpu_seconds() - begin;
    o->evaluations = r.stats.evaluations + r.second.evaluations;
    *used = r.method;
    for (int k = 0; k < r.count; k++)
        flow_output(&w->flow, w->motion.times[k], r.samples + (size_t)k * (size_t)r.n, o->out + k * p->columns);
    bool ok = r.count == p->samples;
    ode_result_free(&r);
    return ok;
}

struct way { const char *name, *method; bool estimate; const struct peer *peer; bool gsl; };

static void sweep(const struct problem *p, const struct way *w, struct own *own)
{
    for (double e = 2; e < 14.4; e += 0.5) {
        struct outcome o = {0};
        double tol = pow(10, -e), least = INFINITY, spent = 0;
        const char *used = w->name;
        bool ok = true;
        for (int turn = 0; ok && turn < 10000 && (turn < 2 || spent < least_time) && (turn < 1 || spent < SLOW); turn++) {
            ok = !w->peer ? own_solve(own, p, w->method, w->estimate, tol, &o, &used)
                 : w->gsl ? gsl_solve(p, w->peer, tol, &o) : sundials_solve(p, w->peer, tol, &o);
            if (o.seconds > 0)           /* clocks may stand still for a moment */
                least = fmin(least, o.seconds);
            spent += o.seconds;
        }
        if (ok)
            printf("%s;%d;%s;%g;%.9g;%.4g;%ld;%s\n", p->name, p->stiff, w->name, tol, least, error_of(p, &o), o.evaluations, used);
        if (least > SLOW)
            break;
    }
    fflush(stdout);
}

int main(int argc, char **argv)
{
    gsl_set_error_handler_off();
    if (argc < 2)
        return 2;
    bool ours_alone = argc > 2 && !strcmp(argv[2], "ours");
    const char *name = argc > 2 + ours_alone ? argv[2 + ours_alone] : NULL;
    if (getenv("SGA_BENCH_MS"))
        least_time = 1e-3 * atof(getenv("SGA_BENCH_MS"));
    for (int k = 0; k < problem_count; k++) {
        const struct problem *p = problems + k;
        static struct own own;
        if (name && !strstr(p->name, name))
            continue;
        own_read(&own, argv[1], k);
        sweep(p, &(struct way){.name = "ours"}, &own);
        sweep(p, &(struct way){.name = "ours+", .estimate = true}, &own);
        for (int m = 0; ode_method_name(m); m++)
            if (getenv("SGA_BENCH_METHODS"))
                sweep(p, &(struct way){.name = ode_method_name(m), .method = ode_method_name(m)}, &own);
        for (const struct peer *q = sundials_peers; q->name && !ours_alone; q++)
            if (q->implicit == p->stiff)
                sweep(p, &(struct way){.name = q->name, .peer = q}, NULL);
        for (const struct peer *q = gsl_peers; q->name && !ours_alone; q++)
            if (q->implicit == p->stiff)
                sweep(p, &(struct way){.name = q->name, .peer = q, .gsl = true}, NULL);
    }
    return 0;
}
