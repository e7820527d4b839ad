/* The rows of the table: for each method and arithmetic one solution after the other, ever
 * tighter; of all that could follow, the one that is expected to be the cheapest.
 *
 * The methods are those of the integrator's own table; what refuses a system or an arithmetic
 * is left out with its reason. */
#include "tradeoff.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "integrate.h"
#include "run_job.h"
#include "mem.h"
#include "ode.h"
#include "request.h"

/* A solution shorter than this is measured again, as often as this. */
static const double SHORT_SECONDS = 4e-3;
enum { REPEATS = 4 };
/* Where each one takes much more to be set up, not for longer than this. */
static const double REPEAT_SECONDS = 0.02;
/* The next row takes this times the last one's time where nothing more is known, and at most. */
static const double GROWTH = 3, MOST_GROWTH = 12;
/* A row is cut off after this times what was expected of it, but not before so many seconds. */
static const double PATIENCE = 6, LEAST_SECONDS = 0.2;

static const double double_rtol[] = { 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 0 };
static const double longer_rtol[] = { 1e-12, 1e-15, 1e-18, 1e-21, 1e-24, 1e-28, 0 };
static const double ball_rtol[] = { 1e-8, 1e-12, 1e-16, 1e-20, 1e-24, 1e-28, 0 };
/* Of the time left, for all rows in one arithmetic: the cheaper ones come first. */
static const double parts[] = { [TRAJ_DOUBLE] = 0.5, [TRAJ_DOUBLE_DOUBLE] = 0.6, [TRAJ_BALL] = 1 };
static const double *const rtols[] = { [TRAJ_DOUBLE] = double_rtol, [TRAJ_DOUBLE_DOUBLE] = longer_rtol, [TRAJ_BALL] = ball_rtol };
enum { ARITHMETICS = sizeof rtols / sizeof *rtols };

const char *tradeoff_arithmetic(enum traj_arithmetic a)
{
    static const char *const text[] = { "auto", "double", "double-double", "ball" };
    return text[a];
}

bool tradeoff_solve(struct tradeoff_run *u, const struct tradeoff_row *row, bool single, double until,
                    struct traj_result *r, struct sga_error *err)
{
    struct sga_budget budget = *u->j->budget;
    double now = sga_now();
    if (!budget.deadline || budget.deadline > until) {
        budget.deadline = until;
        budget.seconds = until - now;
    }
    struct traj_request request = u->request;
    request.method = row->method;
    request.arithmetic = row->arithmetic;
    request.rtol = row->rtol;
    request.atol = row->atol;
    request.single = single;
    request.budget = &budget;
    double begin = sga_cpu();
    bool ok = answer_integrate(u->j, u->solution, &request, r, err);
    if (ok && !(r->seconds > 0))     /* not measured there */
        r->seconds = sga_cpu() - begin;
    return ok;
}

void tradeoff_keep(const struct traj_result *r, struct tradeoff_values *v)
{
    size_t count = (size_t)r->rows * (size_t)r->columns;
    v->rows = r->rows;
    v->columns = r->columns;
    v->value = sga_malloc((count + 1) * sizeof *v->value);
    for (size_t i = 0; i < count; i++)
        v->value[i] = r->digits && r->digits[i] ? num_dd_parse(r->digits[i]) : num_dd_of(r->value[i]);
}

/* One method and arithmetic, and how far it has come. */
struct series {
    int number;
    const char *method;
    enum traj_arithmetic arithmetic;
    const double *rtol;           /* the next one; 0 past the last */
    int rows;
    double last, before;          /* seconds of its last two rows */
    double around;                /* seconds on the clock that the last one took beside: set-up, other processes */
    bool over;
};

static bool same_text(const char *a, const char *b)
{
    return strcmp(a, b) == 0;
}

/* Some arithmetics know one method only, whatever is asked for: it is shown once. */
static bool known(const struct tradeoff *t, const char *method, enum traj_arithmetic a)
{
    for (int i = 0; i < t->rows; i++)
        if (t->row[i].finished && t->row[i].arithmetic == a && same_text(t->row[i].method, method))
            return true;
    return false;
}

static struct tradeoff_row *add_row(struct tradeoff *t, const struct series *s, double rtol, double atol)
{
    assert(rtol > 0 && t->rows <= t->cap);
    if (t->rows == t->cap) {
        t->cap = 2 * t->cap + 16;
        t->row = sga_realloc(t->row, (size_t)t->cap * sizeof *t->row);
    }
    struct tradeoff_row *row = t->row + t->rows++;
    *row = (struct tradeoff_row){ .series = s->number, .method = s->method, .arithmetic = s->arithmetic, .evaluations = -1, .rtol = rtol, .atol = atol, .residual = NAN,
                                  .error = NAN, .error_at_most = NAN, .digits = NAN };
    return row;
}

static void leave_out(struct tradeoff *t, const char *method, enum traj_arithmetic a, const char *reason)
{
    t->left_out = sga_realloc(t->left_out, (size_t)(t->left_outs + 1) * sizeof *t->left_out);
    struct tradeoff_left_out *l = t->left_out + t->left_outs++;
    l->method = method;
    l->arithmetic = tradeoff_arithmetic(a);
    snprintf(l->reason, sizeof l->reason, "%.*s", (int)sizeof l->reason - 1, reason);
}

static void take(struct tradeoff_row *row, const struct traj_result *r)
{
    row->method = r->method;
    row->seconds = r->seconds;
    row->evaluations = r->evaluations;
    row->residual = r->rows ? r->residual : NAN;
    row->finished = true;
    row->ended = r->ended;
    row->ended_t = r->ended_t;
    row->ended_reason = r->ended_reason;
    tradeoff_keep(r, &row->values);
}

/* Short solutions are timed again: the least of several is the one that nothing disturbed. */
static void measure_again(struct tradeoff_run *u, struct tradeoff_row *row, double until)
{
    double end = fmin(until, sga_now() + REPEAT_SECONDS);
    for (int k = 1; k < REPEATS && row->seconds < SHORT_SECONDS && sga_now() < end; k++) {
        struct traj_result r;
        struct sga_error err = { 0 };
        if (!tradeoff_solve(u, row, true, until, &r, &err))
            return;
        row->seconds = fmin(row->seconds, r.seconds);
        traj_result_clear(&r);
    }
}

/* Cut off, refused, or the job cannot go on. */
static bool not_solved(struct tradeoff_run *u, struct series *s, struct tradeoff_row *row, const struct sga_error *err, double granted)
{
    struct tradeoff *t = u->t;
    s->over = true;
    if (!job_goes_on(u->j))
        return false;
    if (err->code == SGA_E_LIMIT_SECONDS) {
        snprintf(row->note, sizeof row->note, "cut off: not solved in %.2g s", granted);
        return true;
    }
    t->rows--;
    if (err->code != SGA_E_NOT_SUPPORTED && t->rows == 0 && s->arithmetic == TRAJ_DOUBLE) {     /* nothing can be integrated */
        *u->j->err = *err;
        return false;
    }
    if (s->rows == 0)
        leave_out(t, s->method, s->arithmetic, err->detail);
    return true;
}

/* The next row of a series, cut off at `until`. False: the job cannot go on. */
static bool one(struct tradeoff_run *u, struct series *s, double until)
{
    const struct request_accuracy *asked = &u->j->request->accuracy;
    struct tradeoff *t = u->t;
    struct tradeoff_row *row = add_row(t, s, *s->rtol, *s->rtol * asked->atol / asked->rtol);
    struct traj_result r;
    struct sga_error err = { 0 };
    double begin = sga_cpu(), now = sga_now(), granted = until - now;
    if (!tradeoff_solve(u, row, true, until, &r, &err)) {
        row->seconds = sga_cpu() - begin;
        return not_solved(u, s, row, &err, granted);
    }
    if (s->rows == 0 && known(t, r.method, s->arithmetic)) {
        t->rows--;
        s->over = true;
    } else {
        s->around = fmax(sga_now() - now - r.seconds, 0);
        take(row, &r);
        t->moved = r.moved;
        measure_again(u, row, until);
        s->before = s->last;
        s->last = row->seconds;
        s->rows++;
        s->over = *++s->rtol == 0;
    }
    traj_result_clear(&r);
    return true;
}

/* How long its next row will take, as the last ones grew. */
static double predicted(const struct series *s)
{
    double growth = s->rows < 2 ? GROWTH : fmin(fmax(1.2, s->last / fmax(s->before, 1e-9)), MOST_GROWTH);
    return growth * s->last + s->around;
}

/* The series whose next row is the cheapest, the ones not begun first; NULL: all are over. */
static struct series *next(struct series *all, int count)
{
    struct series *best = NULL;
    for (int i = 0; i < count; i++)
        if (!all[i].over && (!best || (best->rows && predicted(all + i) < predicted(best))))
            best = all + i;
    return best;
}

static struct tradeoff_row *last_row(struct tradeoff *t, int series)
{
    struct tradeoff_row *found = NULL;
    for (int i = 0; i < t->rows; i++)
        if (t->row[i].series == series)
            found = t->row + i;
    return found;
}

/* Cheap rows first, until the time is used up or nothing more is expected to fit. */
static bool run_all(struct tradeoff_run *u, struct series *all, int count, double until)
{
    struct series *s;
    int begun = 0;
    while ((s = next(all, count))) {
        double now = sga_now(), left = fmax(until - now, 0), granted = fmin(left, fmax(PATIENCE * predicted(s), LEAST_SECONDS));
        if (s->rows == 0) {
            assert(begun < count);       /* each begins once */
            granted = left / (count - begun++);
        } else if (predicted(s) > left) {
            snprintf(last_row(u->t, s->number)->note, sizeof u->t->row->note, "tighter ones were left out, expected to take more than the %.2g s left", left);
            s->over = true;
            continue;
        }
        if (!one(u, s, now + granted))
            return false;
    }
    return true;
}

/* By series, as they were begun; within one in the order of the tolerances. */
static int by_series(const void *a, const void *b)
{
    const struct tradeoff_row *p = a, *q = b;
    if (p->series != q->series)
        return p->series < q->series ? -1 : 1;
    return p->rtol > q->rtol ? -1 : p->rtol < q->rtol;
}

/* Names of methods: the table's, or the one that was asked for, whatever it is. */
static const char *method_name(const struct request_accuracy *a, int k)
{
    if (!a->method || same_text(a->method, "auto"))
        return ode_method_name(k);
    return k == 0 ? a->method : NULL;
}

bool tradeoff_rows(struct tradeoff_run *u, double until)
{
    const struct request_accuracy *accuracy = &u->j->request->accuracy;
    struct tradeoff *t = u->t;
    int methods = 0, count = 0;
    while (method_name(accuracy, methods))
        methods++;
    SGA_ARENA(mem);
    struct series *all = sga_zeros(&mem, (size_t)(methods * ARITHMETICS), sizeof *all);
    bool ok = true;
    for (int a = TRAJ_DOUBLE; a < ARITHMETICS && ok; a++) {
        if (accuracy->arithmetic != REQUEST_AUTO && (int)accuracy->arithmetic != a)
            continue;
        int first = count;
        for (int k = 0; k < methods; k++, count++)
            all[count] = (struct series){ .number = count, .method = method_name(accuracy, k), .arithmetic = (enum traj_arithmetic)a, .rtol = rtols[a] };
        double now = sga_now(), left = fmax(until - now, 0);
        ok = run_all(u, all + first, methods, now + (accuracy->arithmetic == REQUEST_AUTO ? parts[a] : 1) * left);
    }
    qsort(t->row, (size_t)t->rows, sizeof *t->row, by_series);
    if (ok && t->rows == 0)
        sga_fail_at(u->j->err, SGA_E_NOT_SUPPORTED, "/accuracy", "nothing to compare: %.600s",
                    t->left_outs ? t->left_out[0].reason : "no method was tried");
    return ok && t->rows;
}
