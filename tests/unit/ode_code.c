/* Stages by a field's plain code, one by one and all of a step at once: the same solution as by rhs, bit for bit, and
 * the way back to rhs where the code's values do not hold or are not finite. */
#include <math.h>
#include <string.h>

#include "check.h"
#include "ode.h"
#include "stages.h"

enum { N = 9, SAMPLES = 4 };

/* x_j' = cos(t) x_(j+1) - x_j / 2, round the ring; where x_0 <= hole, the code has no value. */
struct ring {
    int n;
    double slots[1], time, hole;
    double rest[ODE_CODE_CALLS];
    bool wrong;                 /* values from code are, below the hole, and only `rest` says so */
    long by_rhs, by_code, at_once, refused;
    const struct sga_stages *plan;
    double place[2], times[SGA_STAGES_MOST];
};

static struct ring ring;

static void value(double t, const double *x, double *dx)
{
    for (int j = 0; j < ring.n; j++)
        dx[j] = cos(t) * x[(j + 1) % ring.n] - x[j] / 2;
}

static bool rhs(void *ctx, double t, const double *x, double *dx)
{
    (void)ctx;
    ring.by_rhs++;
    value(t, x, dx);
    return true;
}

static void run(double *slots, double *dx, double *rest, const double *x)
{
    CHECK(slots == ring.slots);
    ring.by_code++;
    value(ring.time, x, dx);
    *rest = x[0] - ring.hole;
    if (*rest <= 0)
        dx[ring.n - 1] = ring.wrong ? 7 : NAN;
}

static bool code(void *ctx, struct ode_code *c)
{
    (void)ctx;
    *c = (struct ode_code){ run, ring.slots, &ring.time, ring.rest, 1 };
    return true;
}

/* All stages of a step, by base/stages.h. */
static void run_stages(double *slots, double *block, double *rest, double *place, double h)
{
    const struct sga_stages *p = ring.plan;
    double y[N];
    CHECK(place == ring.place && p->row[p->count - 1].stage[p->row[p->count - 1].count - 1] == p->count - 2);
    ring.at_once++;
    for (int s = 1; s < p->count; s++) {
        const struct sga_row *r = p->row + s;
        for (int j = 0; j < ring.n; j++) {
            double from = block[p->x + (size_t)j], sum = 0;
            for (int m = 0; m < r->count - 1; m++) {
                double term = r->a[m] * block[(size_t)r->stage[m] * p->stride + (size_t)j];
                sum = m ? sum + term : term;
            }
            from = r->count > 1 ? from + h * sum : from;
            y[j] = from + (h * r->a[r->count - 1]) * block[(size_t)r->stage[r->count - 1] * p->stride + (size_t)j];
            if (s >= p->keep)
                block[p->y + (size_t)(s - p->keep) * p->stride + (size_t)j] = y[j];
        }
        ring.time = ring.times[s];
        double *k = block + (size_t)s * p->stride;
        run(slots, k, rest + s - 1, y);
        for (int j = 0; p->aside && j < ring.n; j++)
            k[j] *= j % 2 ? 1 - 0x1p-52 : 1 + 0x1p-52;
    }
}

static bool stages(void *ctx, const struct sga_stages *plan, struct sga_stage_code *c)
{
    (void)ctx;
    ring.plan = plan;
    *c = (struct sga_stage_code){ run_stages, ring.slots, ring.rest, ring.place, ring.times, true };
    return true;
}

static bool holds(void *ctx, int calls)
{
    (void)ctx;
    bool ok = true;
    for (int i = 0; i < calls; i++)
        ok &= ring.rest[i] > 0;
    ring.refused += !ok;
    return ok;
}

static const char *method = "dop853";

static void solve(int n, double hole, bool wrong, int with_code, bool estimate, double *out, long *evaluations)
{
    static const double times[SAMPLES] = { 0.3, 1, 2.5, 6 };
    double x[N];
    ring = (struct ring){ .n = n, .hole = hole, .wrong = wrong };
    for (int j = 0; j < n; j++)
        x[j] = 1 + 0.25 * j;
    struct ode_problem p = { .n = n, .rhs = rhs, .code = with_code ? code : NULL, .code_holds = with_code ? holds : NULL,
                             .stages = with_code > 1 ? stages : NULL };
    struct ode_start start = { 0, x, SAMPLES, times };
    struct ode_options o = ode_options_default();
    struct ode_result r;
    o.method = method;
    o.estimate_global_error = estimate;
    CHECK(ode_solve(&p, &start, &o, &r, NULL) && r.count == SAMPLES);
    memcpy(out, r.samples, (size_t)(SAMPLES * n) * sizeof *out);
    *evaluations = r.stats.evaluations;
    CHECK(r.stats.evaluations + r.second.evaluations == ring.by_rhs + ring.by_code, "all are counted");
    ode_result_free(&r);
}

/* tsit5 has no way of single stages by code. */
static void other_method(void)
{
    double plain[SAMPLES * N], fast[SAMPLES * N];
    long e, e_fast;
    method = "tsit5";
    for (int n = 1; n <= N; n++) {
        solve(n, -1e9, false, 0, false, plain, &e);
        solve(n, -1e9, false, 2, false, fast, &e_fast);
        CHECK(memcmp(plain, fast, (size_t)(SAMPLES * n) * sizeof *plain) == 0 && e == e_fast && ring.at_once > 0, "n %d", n);
        for (int wrong = 0; wrong < 2; wrong++) {
            solve(n, 0.8, wrong, 2, false, fast, &e_fast);
            CHECK(memcmp(plain, fast, (size_t)(SAMPLES * n) * sizeof *plain) == 0 && e_fast > e && (!wrong || ring.refused > 0), "n %d", n);
        }
    }
}

int main(void)
{
    double plain[SAMPLES * N], fast[SAMPLES * N];
    long e, e_fast;
    for (int n = 1; n <= N; n++) {
        for (int estimate = 0; estimate < 2; estimate++) {
            solve(n, -1e9, false, 0, estimate, plain, &e);
            for (int way = 1; way <= 2; way++) {
                solve(n, -1e9, false, way, estimate, fast, &e_fast);
                CHECK(memcmp(plain, fast, (size_t)(SAMPLES * n) * sizeof *plain) == 0, "n %d, way %d", n, way);
                CHECK(e == e_fast && ring.by_code > 5 * ring.by_rhs && ring.refused == 0, "%ld, %ld", e, e_fast);
                CHECK((ring.at_once > 0) == (way == 2), "%ld steps at once", ring.at_once);
            }
            for (int wrong = 0; wrong < 4; wrong++) {
                solve(n, 0.8, wrong % 2, 1 + wrong / 2, estimate, fast, &e_fast);
                CHECK(memcmp(plain, fast, (size_t)(SAMPLES * n) * sizeof *plain) == 0, "n %d, wrong %d", n, wrong);
                CHECK(e_fast > e && ring.by_rhs > 0, "%ld, %ld", e, e_fast);
                CHECK(wrong % 2 == 0 || ring.refused > 0);
            }
        }
    }
    other_method();
    return CHECK_END();
}
