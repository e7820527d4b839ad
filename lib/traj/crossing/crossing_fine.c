/* See crossing_fine.h. */
#include "crossing_fine.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "collocation.h"
#include "error.h"
#include "field.h"
#include "flow.h"
#include "jump_exact.h"
#include "knots.h"
#include "manifold.h"
#include "mem.h"
#include "sizes.h"
#include "system.h"
#include "table_balls.h"
#include "tape.h"

/* Stages of the two steps that are compared; iterations; lengths. */
enum { STAGES = 24, FEWER = 19, TURNS = 150, LENGTHS = 6 };
/* By the sizes of variables: iterations have come to an end; what agrees with double, which errs by the tolerances too; roundings that are left, which the nearness of the place makes larger. */
static const double SETTLED = 1e-30, DOUBLE = 1e-8, GRAIN = 1e-29;
static const double STILL = 1e-3;                     /* of what the tolerances allow: iterations may leave it, where roundings keep them from settling */
static const double SHRINK = 0.5, MIDDLE = 0.02;      /* MIDDLE: of half a step, nearer to the place points are not moved onto the constraints */

/* One step: points (stages x n) of this formula. */
struct attempt { const struct num_radau *formula; num_dd *x; };

/* The size of variable j, whose value is x. */
static double size_of(const struct crossing_fine *f, int j, double x) { return fmax(f->p.flow->sizes->unit[j], fabs(x)); }

static double apart(const struct crossing_fine *f, const num_dd *a, const num_dd *b)
{
    double most = 0;
    for (int j = 0; j < f->p.n; j++) {
        double d = fabs(num_dd_sub(a[j], b[j]).hi) / size_of(f, j, a[j].hi);
        most = isnan(d) ? INFINITY : fmax(most, d);
    }
    return most;
}

static bool field_at(struct precise *p, num_dd t, const num_dd *x, num_dd *v)
{
    for (int j = 0; j <= p->n; j++)
        num_jet2_input(p->values, j)[0] = j < p->n ? x[j] : t;
    bool ok = num_jet2_next(p->values, 0);
    for (int j = 0; j < p->n; j++)
        v[j] = num_jet2_root(p->values, j)[0];
    return ok;
}

static num_dd time_of(const struct crossing_fine *f, num_dd part)
{
    return num_dd_add_d(num_dd_mul(part, num_dd_sub(num_dd_of(f->to), num_dd_of(f->from))), f->from);
}

/* What the tolerances allow of the variable that is smallest against its unit. */
static double allowed(const struct traj_request *rq)
{
    return fmax(0.1 * (rq->rtol + rq->atol), 16 * GRAIN);
}

/* The points by iteration, from those in double. */
static bool collocate(struct crossing_fine *f, const struct crossing *c, struct attempt *a)
{
    size_t n = (size_t)f->p.n;
    int s = a->formula->s;
    num_dd h = num_dd_sub(num_dd_of(f->to), num_dd_of(f->from));
    double moved = INFINITY, still = fmax(16 * GRAIN, STILL * allowed(f->p.rq)), ignored[2];
    num_dd *v = sga_malloc(((size_t)s + 1) * (n + 1) * sizeof *v), *y = v + (size_t)s * n;
    double *start = sga_malloc((n + 1) * sizeof *start);
    bool ok = true;
    for (int i = 0; i < s; i++) {
        crossing_at(c, time_of(f, a->formula->c[i]).hi, start, NULL);
        for (size_t j = 0; j < n; j++)
            a->x[(size_t)i * n + j] = num_dd_of(start[j]);
    }
    for (int turn = 0; turn < TURNS && ok && moved > SETTLED; turn++) {
        double before = moved;
        moved = 0;
        for (int i = 0; i < s && ok; i++)
            ok = field_at(&f->p, time_of(f, a->formula->c[i]), a->x + (size_t)i * n, v + (size_t)i * n);
        for (int i = 0; i < s && ok; i++) {
            for (size_t j = 0; j < n; j++) {
                num_dd sum = num_dd_of(0);
                for (int k = 0; k < s; k++)
                    sum = num_dd_add(sum, num_dd_mul(a->formula->A[i * s + k], v[(size_t)k * n + j]));
                y[j] = num_dd_add(f->x0[j], num_dd_mul(sum, h));
            }
            ok = precise_project(&f->p, time_of(f, a->formula->c[i]), y, NULL, NULL, ignored, ignored + 1);
            moved = fmax(moved, apart(f, y, a->x + (size_t)i * n));
            memcpy(a->x + (size_t)i * n, y, n * sizeof *y);
        }
        ok = ok && isfinite(moved) && !(turn > 8 && moved > 2 * before && moved > still);
        if (moved <= still && moved > 0.5 * before)
            break;            /* roundings */
    }
    ok = ok && moved <= still;
    free(v);
    free(start);
    return ok;
}

/* The polynomial at a part of the step. */
static void through(const struct crossing_fine *f, const struct attempt *a, num_dd part, num_dd *x)
{
    size_t n = (size_t)f->p.n;
    num_dd weight[NUM_RADAU_MOST];
    num_radau_weights(a->formula, part, weight);
    for (size_t j = 0; j < n; j++) {
        x[j] = f->x0[j];
        for (int k = 0; k < a->formula->s; k++)
            x[j] = num_dd_add(x[j], num_dd_mul(weight[k], num_dd_sub(a->x[(size_t)k * n + j], f->x0[j])));
    }
}

/* Largest differences of the two steps, and of the first from the curve in double. */
static double compare(const struct crossing_fine *f, const struct crossing *c, const struct attempt *fine, const struct attempt *coarse, double *from_double)
{
    size_t n = (size_t)f->p.n;
    num_dd *x = sga_malloc((n + 1) * sizeof *x);
    double *d = sga_malloc((n + 1) * sizeof *d), most = apart(f, fine->x + (size_t)(STAGES - 1) * n, coarse->x + (size_t)(FEWER - 1) * n);
    *from_double = 0;
    for (int i = 0; i < FEWER; i++) {
        through(f, fine, coarse->formula->c[i], x);
        most = fmax(most, apart(f, x, coarse->x + (size_t)i * n));
        crossing_at(c, time_of(f, coarse->formula->c[i]).hi, d, NULL);
        for (size_t j = 0; j < n; j++)
            *from_double = fmax(*from_double, fabs(x[j].hi - d[j]) / fmax(c->unit[j], size_of(f, (int)j, d[j])));
    }
    free(x);
    free(d);
    return most;
}

/* The motion in double-double at the begins of all lengths: x (LENGTHS x n). How many it came to. */
static int begins(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, const struct crossing *c, num_dd *x)
{
    double from[LENGTHS], way = c->at - c->from;
    expr_id exact[LENGTHS];
    struct traj_request q = *rq;
    struct traj_result r;
    struct sga_error ignored = { 0 };
    for (int k = 0; k < LENGTHS; k++, way *= SHRINK) {
        from[k] = c->at - way;
        exact[k] = jump_exact_constant(sys->store, NULL, from[k]);
    }
    q.times = from;
    q.exact_time = exact;
    q.samples = LENGTHS;
    q.outputs = q.events = q.integrals = q.valueds = 0;
    q.beside = NULL;
    q.event_side = NULL;
    q.single = q.ends_there = true;
    if (!traj_run(sys, sol, &q, &r, &ignored))
        return 0;
    int rows = r.rows;
    for (int i = 0; i < rows * c->n; i++)
        x[i] = r.digits && r.digits[i] ? num_dd_parse(r.digits[i]) : num_dd_of(NAN);
    traj_result_clear(&r);
    return rows;
}

/* Tables are their polynomials around the place, where no knot lies (crossing.h). */
static void enter_tables(struct crossing_fine *f)
{
    double direction = f->at < f->p.rq->start ? -1 : 1;
    int piece = 0;
    for (int k = 0; k < f->p.knots->tables; k++)
        num_table_fine(f->p.knots->table[k]);
    while (piece < f->p.knots->count && direction * (fmpq_get_d(f->p.knots->knot + piece) - f->at) < 0)
        piece++;
    if (f->p.knots->tables)
        knots_enter(f->p.knots, piece);
}

bool crossing_fine_find(const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, const struct crossing *c, struct crossing_fine *f)
{
    size_t n = (size_t)c->n;
    const char *why;
    struct sga_error ignored = { 0 };
    double half = c->at - c->from, from_double = INFINITY;
    *f = (struct crossing_fine){ .p = { .flow = c->flow, .sys = sys, .sol = sol, .rq = rq, .n = c->n }, .at = c->at, .error = INFINITY };
    f->p.knots = sga_calloc(1, sizeof *f->p.knots);
    if (!knots_init(f->p.knots, sys, rq, &ignored) || !field_slope_init(c->flow->field, &ignored) || !precise_possible(c->flow, rq, &why) || !(f->p.field = precise_field(&f->p))) {
        crossing_fine_clear(f);
        return false;
    }
    f->p.constraint = num_jet2_new(c->flow->manifold->tape, 1);
    f->p.values = num_jet2_new(f->p.field, 0);
    f->p.output = c->flow->output ? num_jet2_new(c->flow->output, 0) : NULL;
    f->x0 = sga_calloc(n + 1, sizeof *f->x0);
    f->z = sga_calloc(STAGES * n + 1, sizeof *f->z);
    f->p.formula = num_radau_new(STAGES);
    struct num_radau *fewer = num_radau_new(FEWER);
    num_dd *x = sga_calloc((LENGTHS + FEWER) * n + 1, sizeof *x);
    struct attempt fine = { f->p.formula, f->z }, coarse = { fewer, x + LENGTHS * n };
    int rows = begins(sys, sol, rq, c, x);
    enter_tables(f);
    for (int k = 0; k < rows && !(f->error <= allowed(rq)); k++, half *= SHRINK) {
        f->from = c->at - half;
        f->to = c->at + half;
        memcpy(f->x0, x + (size_t)k * n, n * sizeof *x);
        f->error = collocate(f, c, &fine) && collocate(f, c, &coarse) ? compare(f, c, &fine, &coarse, &from_double) + GRAIN : INFINITY;
        f->error = from_double <= fmax(DOUBLE, rq->rtol + rq->atol) ? f->error : INFINITY;
    }
    num_radau_free(fewer);
    free(x);
    bool found = f->error <= allowed(rq);
    if (!found)
        crossing_fine_clear(f);
    return found;
}

void crossing_fine_at(struct crossing_fine *f, num_dd t, num_dd *x, num_dd *y)
{
    const struct attempt fine = { f->p.formula, f->z };
    size_t n = (size_t)f->p.n;
    double ignored[2];
    assert((t.hi - f->from) * (f->to - t.hi) >= 0);
    through(f, &fine, num_dd_div(num_dd_sub(t, num_dd_of(f->from)), num_dd_sub(num_dd_of(f->to), num_dd_of(f->from))), x);
    if (fabs(t.hi - f->at) > MIDDLE * fabs(f->to - f->at)) {
        num_dd *z = memcpy(sga_malloc((n + 1) * sizeof *z), x, n * sizeof *z);
        if (precise_project(&f->p, t, z, NULL, NULL, ignored, ignored + 1))
            memcpy(x, z, n * sizeof *z);
        free(z);
    }
    for (size_t j = 0; y && f->p.output && j <= n; j++)
        num_jet2_input(f->p.output, (int)j)[0] = j < n ? x[j] : t;
    if (y && f->p.output)
        num_jet2_next(f->p.output, 0);
    for (int k = 0; y && k < (f->p.output ? f->p.rq->outputs : f->p.n); k++)
        y[k] = f->p.output ? num_jet2_root(f->p.output, k)[0] : x[k];
}

void crossing_fine_clear(struct crossing_fine *f)
{
    if (f->p.knots) {
        knots_leave(f->p.knots);
        knots_clear(f->p.knots);
    }
    free(f->p.knots);
    f->p.knots = NULL;
    if (f->p.field != f->p.flow->field->plain)
        num_tape_free(f->p.field);
    num_jet2_free(f->p.constraint);
    num_jet2_free(f->p.values);
    num_jet2_free(f->p.output);
    num_radau_free(f->p.formula);
    free(f->x0);
    free(f->z);
    *f = (struct crossing_fine){ 0 };
}
