/* Derivatives of a consistent start where it is a nearest point: by the conditions of such a point (variation_least.h), and where these do not tell, the start at values
 * nearby, in central differences that are carried to a step of 0.
 * (C. J. F. Ridders, Accurate computation of F'(x) and F'(x) F''(x), Advances in Engineering Software 4 (1982) 75.) */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "mem.h"
#include "sweep_case.h"
#include "system.h"
#include "variation_least.h"
#include "vary_motion.h"

/* The first step, beside the value; how much smaller the next ones are; how far differences may be off beside what they are; and how near the start
 * at the values themselves must come to the motion's. */
static const double FIRST = 0.02, SMALLER = 1.7, OFF = 1e-4, SAME = 1e-8;
/* In balls what was not given counts a little too (enclosed_nearest.c). */
static const double SAME_IN_BALLS = 1e-5;
/* Differences of starts that do not move are roundings up to this. */
static const double ROUNDINGS = 1e-9;
/* Beside its natural size a value is a rounding of 0. */
static const double ROUNDED = 1e-13;
/* Rounding of a start, relative. */
static const double DIGITS = 1e-15;
enum { STEPS = 9, FEWEST = 4 };
/* Starts nearby, that bear out derivatives: how far, how much nearer after each try, and how well; to how many digits a search finds them. */
static const double BESIDE = 1e-3, SHORTER = 30, BORNE = 1e-3, FOUND = 1e-10;
enum { TRIES = 3 };

struct starts {
    struct vary_model *m;
    const struct vary_at *at;
    const struct variation_by *by;
    int n;
    double value, size;        /* of what is differentiated by; what steps beside it are parts of */
    struct sga_error *err;
};

/* What the start is looked for from: rq's values at the parameters; those that rq does not write are at->initial's. */
static bool asked_of(const struct vary_at *at, const struct sweep_case *c, int n, double *initial)
{
    bool ok = true;
    for (int j = 0; j < n && ok; j++) {
        if (!at->rq->given[j])
            continue;
        if (!at->rq->exact_initial[j])
            initial[j] = at->initial ? at->initial[j] : at->rq->initial[j];
        else
            ok = variation_constants(&c->store, c->request.exact_initial + j, 1, initial + j);
    }
    return ok;
}

/* The start at these parameters, from their initial values, one of them moved by h (variable -1: none is). */
static bool find_start(struct vary_model *m, const struct vary_at *at, const expr_id *parameter, int variable, double h, double *x, double *given, struct sga_error *err)
{
    struct request *r = &m->request;
    int n = r->system.variables;
    struct sweep_case c;
    struct traj_initial found;
    SGA_ARENA(mem);
    double *initial = sga_zeros(&mem, (size_t)n + 1, sizeof *initial);
    bool ok = sweep_case_of(&c, r, &r->system, m->solution, at->rq, parameter, err) && c.solved;
    ok = ok && asked_of(at, &c, n, initial);
    if (given)
        memcpy(given, initial, (size_t)n * sizeof *given);
    if (variable >= 0)
        initial[variable] += h;
    c.request.initial = initial;
    c.request.exact_initial = NULL;
    c.request.samples = 0;
    c.request.events = 0;
    ok = ok && traj_consistent(&c.system, &c.solution, &c.request, &found, err);
    if (ok) {
        memcpy(x, found.x, (size_t)n * sizeof *x);
        traj_initial_clear(&found);
    }
    sweep_case_clear(&c);
    return ok;
}

bool vary_start_at(struct vary_model *m, const struct vary_at *at, double *x, double *given, struct sga_error *err)
{
    if (find_start(m, at, at->parameter, -1, 0, x, given, err))
        return true;
    return err->code != SGA_E_OK ? false : sga_fail(err, SGA_E_EXPR_UNDEFINED, "the reduction for general values of the parameters has no value at these");
}

/* The start where what is differentiated by is moved by h. */
static bool start_at(struct starts *s, double h, double *x)
{
    struct request *r = &s->m->request;
    SGA_ARENA(mem);
    expr_id *parameter = sga_take(&mem, ((size_t)r->swept_count + 1) * sizeof *parameter);
    memcpy(parameter, s->at->parameter, (size_t)r->swept_count * sizeof *parameter);
    for (int i = 0; i < r->swept_count && h != 0; i++)
        if (r->swept[i].symbol == s->by->parameter)
            parameter[i] = expr_double(&r->store, s->value + h);
    return find_start(s->m, s->at, parameter, s->by->parameter < 0 ? s->by->variable : -1, h, x, NULL, s->err);
}

/* Where the value is a rounding of 0; most: the largest number of the start, beside which it is one where units are plain. */
static bool step_in_units(struct starts *s, double most)
{
    SGA_ARENA(mem);
    double *unit = sga_zeros(&mem, (size_t)s->n + 1, sizeof *unit);
    vary_start_units(s->m, s->at, unit, s->err);
    double own = unit[s->by->variable];
    s->size = fabs(s->value) < ROUNDED * own || (own == 1 && fabs(s->value) < ROUNDED * most) ? own : s->size;
    return s->err->code == SGA_E_OK;
}

static bool value_of(struct starts *s)
{
    const struct request *r = &s->m->request;
    bool found = s->by->parameter < 0;
    if (found)
        s->value = s->at->initial ? s->at->initial[s->by->variable] : s->at->rq->initial[s->by->variable];
    for (int i = 0; i < r->swept_count && !found; i++)
        if (r->swept[i].symbol == s->by->parameter && !(found = variation_constants(&r->store, s->at->parameter + i, 1, &s->value)))
            return false;
    s->size = s->value != 0 ? fabs(s->value) : 1;
    double most = 0;
    for (int j = 0; j < s->n; j++)
        most = fmax(most, fabs(s->at->x[j]));
    if (found && s->by->parameter < 0 && fabs(s->value) <= ROUNDED * most)      /* it may be a rounding of 0 */
        return step_in_units(s, most);
    return found;
}

/* Differences with steps h, h/SMALLER, ...: central ones in table, and how the two sides differ in bend (steps x n each). Returns how many: those before the
 * first start that is not found are left out. */
static int differences(struct starts *s, const double *here, double *table, double *bend, double *step)
{
    SGA_ARENA(mem);
    double *up = sga_take(&mem, (2 * (size_t)s->n + 1) * sizeof *up), *down = up + s->n;
    double h = FIRST * s->size;
    int steps = 0;
    for (int k = 0; k < STEPS; k++, h /= SMALLER) {
        double a = s->value + h, b = s->value - h, wide = (a - b) / 2;
        if (!start_at(s, wide, up) || !start_at(s, -wide, down)) {
            *s->err = (struct sga_error){ 0 };
            steps = 0;
            continue;
        }
        for (int j = 0; j < s->n; j++) {
            table[(size_t)steps * (size_t)s->n + (size_t)j] = (up[j] - down[j]) / (2 * wide);
            bend[(size_t)steps * (size_t)s->n + (size_t)j] = (up[j] - 2 * here[j] + down[j]) / wide;
        }
        step[steps++] = wide;
    }
    return steps;
}

/* Neville's table in the squares of the steps; the entry with the least change. */
static double extrapolate(const double *table, const double *step, int steps, int n, int j, double *off)
{
    double a[STEPS][STEPS], best = table[j];
    *off = INFINITY;
    for (int k = 0; k < steps; k++) {
        a[k][0] = table[(size_t)k * (size_t)n + (size_t)j];
        for (int i = 1; i <= k; i++) {
            double ratio = step[k - i] / step[k];
            a[k][i] = a[k][i - 1] + (a[k][i - 1] - a[k - 1][i - 1]) / (ratio * ratio - 1);
            double change = fmax(fabs(a[k][i] - a[k][i - 1]), fabs(a[k][i] - a[k - 1][i - 1]));
            if (change < *off) {
                *off = change;
                best = a[k][i];
            }
        }
    }
    return best;
}

/* A bend that stays as steps become small is a kink: one side's derivative is not the other's. */
static bool kinked(const double *bend, int steps, int n, int j, double size)
{
    double first = fabs(bend[j]), last = fabs(bend[(size_t)(steps - 1) * (size_t)n + (size_t)j]);
    return last > OFF * size && last > ROUNDINGS && last > 0.5 * first;
}

/* Whether starts on both sides, nearby, are where these derivatives lead: to one branch, without a bend. */
static bool borne_out(struct starts *s, const double *here, const double *slope)
{
    size_t n = (size_t)s->n;
    SGA_ARENA(mem);
    double *up = sga_take(&mem, (2 * n + 1) * sizeof *up), *down = up + n, h = BESIDE * s->size, size = 0;
    for (size_t j = 0; j < n; j++)
        size = fmax(size, fabs(slope[j]));
    for (int k = 0; k < TRIES; k++, h /= SHORTER) {
        double a = s->value + h, b = s->value - h, wide = (a - b) / 2;
        bool ok = start_at(s, wide, up) && start_at(s, -wide, down);
        for (size_t j = 0; j < n && ok; j++) {
            double told = BORNE * fabs(slope[j]) + OFF / 10 * size + ROUNDINGS + FOUND * fabs(here[j]) / wide;
            ok = fabs((up[j] - down[j]) / (2 * wide) - slope[j]) <= told && fabs(up[j] - 2 * here[j] + down[j]) / wide <= 4 * told;
        }
        if (ok)
            return true;
        if (!sga_budget_ok(s->at->rq->budget, s->err))
            return false;
        *s->err = (struct sga_error){ 0 };
    }
    return false;
}

static bool one_direction(struct starts *s, const double *here, double *slope, double *off)
{
    size_t n = (size_t)s->n;
    SGA_ARENA(mem);
    double *table = sga_zeros(&mem, 2 * STEPS * n + 1, sizeof *table), *bend = table + STEPS * n, step[STEPS], size = 0;
    int steps = value_of(s) ? differences(s, here, table, bend, step) : 0;
    if (steps < FEWEST)
        return sga_fail_at(s->err, SGA_E_INITIAL, "/trajectory/initial", "the consistent start cannot be followed as what it is differentiated by changes: none is found nearby");
    for (int j = 0; j < s->n; j++) {
        slope[j] = extrapolate(table, step, steps, s->n, j, off + j);
        size = fmax(size, fabs(slope[j]));
    }
    for (int j = 0; j < s->n; j++)
        if (!(off[j] <= OFF * size || off[j] <= ROUNDINGS) || kinked(bend, steps, s->n, j, size))
            return sga_fail_at(s->err, SGA_E_INITIAL, "/trajectory/initial", "the consistent start has no derivative by what is asked for, as far as differences tell: it jumps or bends "
                               "there; give initial values that satisfy the constraints");
    for (int j = 0; j < s->n; j++)       /* starts are known to their digits */
        off[j] = fmax(off[j], DIGITS * fabs(here[j]) / step[steps - 1]);
    return true;
}

/* Derivatives by the conditions of the start, which starts nearby bear out. False: they are not told so, or (err) time or the store ends. */
static bool solved(struct starts *s, const struct variation_by *by, int directions, const double *here, double *slope, double *off)
{
    struct request *r = &s->m->request;
    const struct vary_at *at = s->at;
    size_t n = (size_t)s->n, values = (size_t)r->swept_count;
    struct sweep_case c;
    SGA_ARENA(mem);
    double *initial = sga_zeros(&mem, n + 1, sizeof *initial), *value = sga_zeros(&mem, values + 1, sizeof *value);
    expr_id *guess = sga_zeros(&mem, n * (size_t)directions + 1, sizeof *guess);
    int *symbol = sga_zeros(&mem, values + 1, sizeof *symbol);
    for (size_t i = 0; i < values; i++)
        symbol[i] = r->swept[i].symbol;
    for (int d = 0; d < directions; d++)
        vary_model_guess(s->m, at->rq, by[d].parameter, by[d].variable, guess + (size_t)d * n);
    bool ok = sweep_case_of(&c, r, &r->system, s->m->solution, at->rq, at->parameter, s->err) && c.solved && asked_of(at, &c, s->n, initial)
              && variation_constants(&r->store, at->parameter, (int)values, value);
    c.request.initial = initial;
    c.request.exact_initial = NULL;
    ok = ok && variation_least(&(struct variation_start){ &r->system, s->m->solution, at->rq, by, directions, guess, symbol, value, (int)values, &c.system, &c.request, here }, slope, off, s->err);
    sweep_case_clear(&c);
    for (int d = 0; d < directions && ok; d++) {
        s->by = by + d;
        ok = value_of(s) && borne_out(s, here, slope + (size_t)d * n);
    }
    return ok;
}

bool vary_start_units(struct vary_model *m, const struct vary_at *at, double *unit, struct sga_error *err)
{
    struct request *r = &m->request;
    struct sweep_case c;
    SGA_ARENA(mem);
    double *initial = sga_zeros(&mem, (size_t)r->system.variables + 1, sizeof *initial);
    bool ok = sweep_case_of(&c, r, &r->system, m->solution, at->rq, at->parameter, err) && asked_of(at, &c, r->system.variables, initial);
    c.request.initial = initial;
    ok = ok && variation_units(&c.system, &c.request, at->x, unit);
    sweep_case_clear(&c);
    return ok;
}

bool vary_slope_units(struct vary_model *m, const struct variation_by *by, int directions, const struct vary_at *at, double *unit, struct sga_error *err)
{
    size_t n = (size_t)m->request.system.variables;
    struct starts s = { .m = m, .at = at, .n = (int)n, .err = err };
    SGA_ARENA(mem);
    double *own = sga_zeros(&mem, n + 1, sizeof *own);
    vary_start_units(m, at, own, err);
    bool ok = err->code == SGA_E_OK;
    for (int d = 0; d < directions && ok; d++) {
        s.by = by + d;
        ok = value_of(&s);
        double size = s.by->parameter < 0 ? own[s.by->variable] : s.value != 0 ? fabs(s.value) : 1;
        for (size_t j = 0; j < n; j++)
            unit[(size_t)d * n + j] = own[j] / size;
    }
    return ok;
}

bool vary_start_slopes(struct vary_model *m, const struct variation_by *by, int directions, const struct vary_at *at, double *slope, double *off, bool *exact, struct sga_error *err)
{
    size_t n = (size_t)m->request.system.variables;
    struct starts s = { .m = m, .at = at, .n = (int)n, .err = err };
    SGA_ARENA(mem);
    double *here = sga_take(&mem, (n + 1) * sizeof *here);
    s.by = by;
    if (!value_of(&s) || !start_at(&s, 0, here))
        return err->code != SGA_E_OK ? false : sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial", "the start is not found for general values of the parameters");
    double same = at->rq->arithmetic == TRAJ_BALL ? SAME_IN_BALLS : SAME;
    for (size_t j = 0; j < n; j++)
        if (fabs(here[j] - at->x[j]) > same * (1 + fabs(here[j])))
            return sga_fail_at(err, SGA_E_INITIAL, "/trajectory/initial", "the start that is found for general values of the parameters is another one: give initial values that satisfy the "
                               "constraints");
    *exact = solved(&s, by, directions, here, slope, off);
    if (err->code != SGA_E_OK)
        return false;
    for (int d = 0; d < directions && !*exact; d++) {
        s.by = by + d;
        if (!one_direction(&s, here, slope + (size_t)d * n, off + (size_t)d * n))
            return false;
    }
    for (size_t i = 0; i < n * (size_t)directions; i++)       /* roundings of 0 would be taken for the sizes that derivatives have */
        slope[i] = fabs(slope[i]) <= off[i] ? 0 : slope[i];
    return true;
}
