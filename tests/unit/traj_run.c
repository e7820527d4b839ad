/* Motions whose closed forms are known, in each arithmetic: values within their estimates, starts nearest to the guess, endings with their
 * true reasons and times. */
#include "model.h"

#include <math.h>

#include "error.h"
#include "oracle.h"
#include "points.h"
#include "system.h"
#include "trajectory.h"

static const struct model_text oscillator = { "x y", "", { { "x:1", "y" }, { "y:1", "-x" } }, { 0 } };
static const struct model_text pole = { "x", "", { { "x:1", "x^2" } }, { 0 } };
static const struct model_text ring = { "x y z", "", { { "x:1", "-y" }, { "y:1", "x" }, { "", "x^2 + y^2 - 1" }, { "", "z - x*y" } }, { 0 } };
static const struct model_text stiff = { "x y", "", { { "x:1", "-1000*(x - cos(t)) - sin(t)" }, { "", "y - x^2" } }, { 0 } };
static const struct model_text root = { "x", "", { { "x:1", "-1/(2*x)" } }, { 0 } };          /* x = sqrt(1 - t) */
static const struct model_text surface = { "x y", "", { { "x:y", "1" }, { "", "y - 1 + x" } }, { 0 } };

struct run {
    struct model m;
    struct traj_result r;
    struct sga_error err;
    bool ok;
};

/* The first variables are given, as many as are to follow from others left out. */
static void go(struct run *run, const struct model_text *t, int follow, const double *start, double stop, int samples, enum traj_arithmetic arithmetic, double rtol)
{
    double times[8] = { 0 };
    unsigned char given[MODEL_VARIABLES] = { 0 };
    *run = (struct run){ .ok = false };
    model_begin(&run->m, t, NULL, NULL);
    CHECK(model_reduce(&run->m, start), "%s", run->m.err.detail);
    memset(given, 1, (size_t)(run->m.sys.variables - follow));
    for (int k = 0; k < samples; k++)
        times[k] = stop * (k + 1) / samples;
    struct traj_request rq = { .times = times, .samples = samples, .initial = start, .given = given, .rtol = rtol, .atol = rtol, .arithmetic = arithmetic,
                               .budget = &run->m.budget };
    run->ok = traj_run(&run->m.sys, &run->m.sol, &rq, &run->r, &run->err);
}

static void end(struct run *run)
{
    if (run->ok)
        traj_result_clear(&run->r);
    model_end(&run->m);
}

static void values(void)
{
    for (int a = TRAJ_DOUBLE; a <= TRAJ_BALL; a++)
        for (int digits = 4; digits <= (a == TRAJ_DOUBLE ? 12 : 20); digits += 4) {
            struct run run;
            double start[2] = { 1, 0 };
            go(&run, &oscillator, 0, start, 5, 5, (enum traj_arithmetic)a, pow(10, -digits));
            CHECK(run.ok && run.r.rows == 5 && !run.r.ended, "%s", run.err.detail);
            for (int k = 0; k < run.r.rows; k++) {
                double off = fabs(run.r.value[2 * k] - cos(run.r.t[k]));
                CHECK(off <= run.r.error_estimate + 1e-15 && run.r.error_estimate <= 4 * pow(10, -digits), "arithmetic %d, %d digits: %g, said %g",
                      a, digits, off, run.r.error_estimate);
            }
            end(&run);
        }
}

static void starts(void)
{
    struct run run;
    double start[3] = { 1.2, 1.6, 0 };
    go(&run, &ring, 1, start, 1, 1, TRAJ_DOUBLE, 1e-9);
    CHECK(run.ok && fabs(run.r.initial[0] - 0.6) < 1e-12 && fabs(run.r.initial[1] - 0.8) < 1e-12 && fabs(run.r.initial[2] - 0.48) < 1e-12, "%s", run.err.detail);
    CHECK(run.ok && run.r.moved > 0.1 && run.r.residual < 1e-12, "moved %g, residual %g", run.r.moved, run.r.residual);
    CHECK(run.ok && fabs(run.r.value[0] - cos(atan2(0.8, 0.6) + 1)) < 1e-8, "on the circle");
    end(&run);
}

static void endings(void)
{
    struct run run;
    double one[2] = { 1, 0 };
    go(&run, &pole, 0, one, 2, 1, TRAJ_DOUBLE, 1e-9);         /* 1/(1 - t) */
    CHECK(run.ok && run.r.ended && fabs(run.r.ended_t - 1) < 1e-6 && strcmp(run.r.ended_reason, "blow_up") == 0, "%s at %g", run.r.ended_reason, run.r.ended_t);
    end(&run);
    go(&run, &root, 0, one, 2, 1, TRAJ_DOUBLE, 1e-9);
    CHECK(run.ok && run.r.ended && fabs(run.r.ended_t - 1) < 1e-6, "%s at %g", run.r.ended_reason, run.r.ended_t);
    end(&run);
    go(&run, &surface, 0, (double[]){ 0, 1 }, 2, 1, TRAJ_DOUBLE, 1e-9);      /* (1 - x) x' = 1: at x = 1, t = 1/2 */
    CHECK(run.ok && run.r.ended && fabs(run.r.ended_t - 0.5) < 1e-6 && strcmp(run.r.ended_reason, "stratum") == 0, "%s at %g", run.r.ended_reason, run.r.ended_t);
    end(&run);
}

static void stiffness(void)
{
    struct run run;
    double start[2] = { 1, 1 };
    go(&run, &stiff, 0, start, 4, 4, TRAJ_AUTO, 1e-8);
    CHECK(run.ok && run.r.rows == 4 && run.r.steps < 4000, "%ld steps", run.r.steps);
    for (int k = 0; k < run.r.rows; k++)
        CHECK(fabs(run.r.value[2 * k] - cos(run.r.t[k])) <= run.r.error_estimate + 1e-14, "%g", run.r.value[2 * k] - cos(run.r.t[k]));
    end(&run);
}

static void refused(void)
{
    struct model m;
    struct traj_initial x;
    struct sga_error err = { 0 };
    double start[3] = { 1, 0, 0 };
    unsigned char held[3] = { 1, 0, 1 }, given[3] = { 1, 0, 1 };
    start[0] = 2;
    struct traj_request rq = { .initial = start, .given = given, .held = held, .rtol = 1e-9, .atol = 1e-9 };
    model_begin(&m, &ring, NULL, NULL);
    rq.budget = &m.budget;
    CHECK(model_reduce(&m, NULL), "%s", m.err.detail);
    CHECK(!traj_consistent(&m.sys, &m.sol, &rq, &x, &err) && err.code == SGA_E_INITIAL, "x = 2 is on no circle of radius 1: %s", err.detail);
    model_end(&m);
}

int main(void)
{
    values();
    starts();
    endings();
    stiffness();
    refused();
    flint_cleanup();
    return CHECK_END();
}
