/* The rows of the table: for each method and arithmetic one solution after the other, ever
 * tighter; of all that could follow, the one that is expected to be the cheapest, so that nothing cheap is
 * left out for something dear. What was begun and took longer than expected is cut off, and begun again
 * with more time when its turn comes.
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
#include "error.h"
#include "run_job.h"
#include "mem.h"
#include "ode.h"
#include "request.h"

/* The next row takes this times the last one's time where nothing more is known, and at most. */
static const double GROWTH = 3, MOST_GROWTH = 12;
/* A row is cut off after this times what was expected of it, but not before this part of all time. */
static const double PATIENCE = 6, LEAST_PART = 0.03;
/* What a first row takes, times the cheapest in double. */
static const double FIRST[] = { [TRAJ_DOUBLE] = 1, [TRAJ_DOUBLE_DOUBLE] = 30, [TRAJ_BALL] = 200 };

static const double double_rtol[] = { 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13, 0 };
static const double longer_rtol[] = { 1e-12, 1e-15, 1e-18, 1e-21, 1e-24, 1e-28, 0 };
static const double ball_rtol[] = { 1e-8, 1e-12, 1e-16, 1e-20, 1e-24, 1e-28, 0 };
static const double *const rtols[] = { [TRAJ_DOUBLE] = double_rtol, [TRAJ_DOUBLE_DOUBLE] = longer_rtol, [TRAJ_BALL] = ball_rtol };
enum { ARITHMETICS = sizeof rtols / sizeof *rtols };

const char *tradeoff_arithmetic(enum traj_arithmetic a)
{
    static const char *const text[] = { "auto", "double", "double-double", "ball" };
    return text[a];
}

/* One method and arithmetic, and how far it has come. */
struct series {
    int number;
    const char *method;
    enum traj_arithmetic arithmetic;
    const double *rtol;           /* the next one; 0 past the last */
    int rows;
    double last, before;          /* seconds of its last two rows */
    double around;                /* seconds that the last one took beside: set-up */
    double cut;                   /* the next one was cut off after so many seconds; 0: not yet tried */
    bool over;
};

/* All of them. */
struct table {
    struct series *all;
    int count;
    double cheapest;              /* first row in double; 0: not known */
    double least;                 /* seconds that each row may have */
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

static struct tradeoff_row *last_row(struct tradeoff *t, int series)
{
    struct tradeoff_row *found = NULL;
    for (int i = 0; i < t->rows; i++)
        if (t->row[i].series == series)
            found = t->row + i;
    return found;
}

/* A new one, or that which was cut off. */
static struct tradeoff_row *add_row(struct tradeoff *t, const struct series *s, double atol_to_rtol)
{
    assert(*s->rtol > 0 && t->rows <= t->cap);
    if (s->cut > 0)
        return last_row(t, s->number);
    if (t->rows == t->cap) {
        t->cap = 2 * t->cap + 16;
        t->row = sga_realloc(t->row, (size_t)t->cap * sizeof *t->row);
    }
    struct tradeoff_row *row = t->row + t->rows++;
    *row = (struct tradeoff_row){ .series = s->number, .method = s->method, .arithmetic = s->arithmetic, .evaluations = -1, .rtol = *s->rtol,
                                  .atol = *s->rtol * atol_to_rtol, .residual = NAN, .error = NAN, .error_at_most = NAN, .digits = NAN, .digits_most = NAN };
    return row;
}

static void drop_row(struct tradeoff *t, struct tradeoff_row *row)
{
    size_t after = (size_t)(t->row + --t->rows - row);
    memmove(row, row + 1, after * sizeof *row);
}

static struct tradeoff_left_out left_out(const struct series *s, double from)
{
    return (struct tradeoff_left_out){ .method = s->method, .arithmetic = tradeoff_arithmetic(s->arithmetic), .from = from };
}

/* Cut off, refused, or the job cannot go on. */
static bool not_solved(struct tradeoff_run *u, struct series *s, struct tradeoff_row *row, const struct sga_error *err, double granted)
{
    struct tradeoff *t = u->t;
    if (!job_goes_on(u->j))
        return false;
    if (err->code == SGA_E_LIMIT_SECONDS) {
        s->cut = granted;
        snprintf(row->note, sizeof row->note, "cut off: not solved in %.2g s", granted);
        return true;
    }
    s->over = true;
    drop_row(t, row);
    if (err->code != SGA_E_NOT_SUPPORTED && t->rows == 0 && s->arithmetic == TRAJ_DOUBLE) {     /* nothing can be integrated */
        *u->j->err = *err;
        return false;
    }
    if (s->rows == 0) {
        struct tradeoff_left_out l = left_out(s, 0);
        snprintf(l.reason, sizeof l.reason, "%.*s", (int)sizeof l.reason - 1, err->detail);
        tradeoff_leave_out(t, &l);
    }
    return true;
}

static void go_on(struct series *s, struct table *all, double seconds, double around)
{
    s->around = around;
    s->before = s->last;
    s->last = seconds;
    s->cut = 0;
    if (s->rows++ == 0 && s->arithmetic == TRAJ_DOUBLE)
        all->cheapest = all->cheapest > 0 ? fmin(all->cheapest, seconds + around) : seconds + around;
    s->over = *++s->rtol == 0;
}

/* The next row of a series, cut off after so many seconds. False: the job cannot go on. */
static bool one(struct tradeoff_run *u, struct series *s, struct table *all, double granted)
{
    const struct request_accuracy *asked = &u->j->request->accuracy;
    struct tradeoff *t = u->t;
    struct tradeoff_row *row = add_row(t, s, asked->atol / asked->rtol);
    struct traj_result r;
    struct sga_error err = { 0 };
    double begin = sga_cpu();
    if (!tradeoff_solve(u, row, true, granted, &r, &err)) {
        row->seconds = sga_cpu() - begin;
        return not_solved(u, s, row, &err, granted);
    }
    if (s->rows == 0 && known(t, r.method, s->arithmetic)) {
        drop_row(t, row);
        s->over = true;
    } else {
        double around = fmax(sga_cpu() - begin - r.seconds, 0);
        t->moved = r.moved;
        tradeoff_take(u, row, &r, tradeoff_left(u->rows_end));
        go_on(s, all, row->seconds, around);
    }
    traj_result_clear(&r);
    return true;
}

/* How long its next row will take, as the last ones grew. */
static double predicted(const struct series *s, const struct table *all)
{
    if (s->cut > 0)
        return GROWTH * s->cut;
    if (s->rows == 0)
        return s->arithmetic == TRAJ_DOUBLE ? 0 : FIRST[s->arithmetic] * all->cheapest;
    double growth = s->rows < 2 ? GROWTH : fmin(fmax(1.2, s->last / fmax(s->before, 1e-9)), MOST_GROWTH);
    return growth * s->last + s->around;
}

/* The series whose next row is the cheapest; NULL: all are over. */
static struct series *next(const struct table *all)
{
    struct series *best = NULL;
    for (int i = 0; i < all->count; i++)
        if (!all->all[i].over && (!best || predicted(all->all + i, all) < predicted(best, all)))
            best = all->all + i;
    return best;
}

/* Time does not allow its next row: what is there says so. */
static void out_of_time(struct tradeoff *t, struct series *s, double expected, double left)
{
    struct tradeoff_left_out l = left_out(s, *s->rtol);
    struct tradeoff_row *row = s->rows && !(s->cut > 0) ? last_row(t, s->number) : NULL;
    s->over = true;
    l.not_begun = !s->rows && !(s->cut > 0);
    if (s->cut > 0)
        snprintf(l.reason, sizeof l.reason, "time: not solved in %.2g s of CPU", s->cut);
    else if (expected > 0)
        snprintf(l.reason, sizeof l.reason, "time: expected to take more than the %.2g s of CPU left", left);
    else
        snprintf(l.reason, sizeof l.reason, "time: none was left");
    if (row && !row->note[0])
        snprintf(row->note, sizeof row->note, "tighter ones were left out, expected to take more than the %.2g s of CPU left", left);
    tradeoff_leave_out(t, &l);
}

/* Cheap rows first, until the time is used up or nothing more is expected to fit. */
static bool run_all(struct tradeoff_run *u, struct table *all)
{
    struct series *s;
    while ((s = next(all))) {
        double left = tradeoff_left(u->rows_end), expected = predicted(s, all);
        if (u->t->rows && (expected > left || left <= 0))
            out_of_time(u->t, s, expected, left);
        else if (!one(u, s, all, fmin(left, fmax(expected, fmin(left / 2, fmax(PATIENCE * expected, all->least))))))
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

bool tradeoff_rows(struct tradeoff_run *u)
{
    const struct request_accuracy *accuracy = &u->j->request->accuracy;
    struct tradeoff *t = u->t;
    int methods = 0;
    while (method_name(accuracy, methods))
        methods++;
    SGA_ARENA(mem);
    struct table all = { .all = sga_zeros(&mem, (size_t)(methods * ARITHMETICS), sizeof *all.all), .least = LEAST_PART * tradeoff_left(u->rows_end) };
    for (int a = TRAJ_DOUBLE; a < ARITHMETICS; a++)
        for (int k = 0; k < methods && (accuracy->arithmetic == REQUEST_AUTO || (int)accuracy->arithmetic == a); k++, all.count++)
            all.all[all.count] = (struct series){ .number = all.count, .method = method_name(accuracy, k), .arithmetic = (enum traj_arithmetic)a, .rtol = rtols[a] };
    bool ok = run_all(u, &all);
    t->busy = u->rows_end.wall - sga_now() < u->rows_end.cpu - sga_cpu();
    qsort(t->row, (size_t)t->rows, sizeof *t->row, by_series);
    if (ok && t->rows == 0)
        sga_fail_at(u->j->err, SGA_E_NOT_SUPPORTED, "/accuracy", "nothing to compare: %.600s",
                    t->left_outs ? t->left_out[0].reason : "no method was tried");
    return ok && t->rows;
}
