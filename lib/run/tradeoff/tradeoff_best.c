/* The best solution that there is time for, and the rows' errors against it.
 *
 * It is computed like an answer, with other solutions beside it for an estimate of its own
 * error. What that estimate is not well below of is not called a true error: such rows have
 * a bound instead. */
#include "tradeoff.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "run_job.h"
#include "mem.h"
#include "request.h"
#include "tolerance.h"

/* A solution with its estimate takes about so many times one alone; of the time left, what one attempt may have beyond. */
static const double SOLUTIONS = 4, ATTEMPT_PART = 0.6;
enum { ATTEMPTS = 4 };
/* A true error is at least so many times what the best solution may be wrong by. */
static const double WELL_ABOVE = 4;
/* Of the difference to the row that is one solution less tight: see global.c of the integrator. */
static const double ALLOWANCE = 1.5;
/* Likewise, where nothing else tells what a solution is wrong by; it is preferred to one that is so many times less sure. */
static const double ALONE = 3, MUCH_SURER = 10;
/* About as tight. */
static const double SIMILAR = 1.001;

/* Less than this times its value cannot be told of a number. */
static double rounding(const char *arithmetic)
{
    return strcmp(arithmetic, "double") == 0 ? 2 * DBL_EPSILON : 0x1p-100;
}

static double distance(num_dd a, num_dd b)
{
    double size = fabs(num_dd_sub(a, b).hi);
    return isnan(size) ? INFINITY : size;
}

/* The better candidate: tighter, then of the longer arithmetic, then cheaper. */
static bool better(const struct tradeoff_row *a, const struct tradeoff_row *b)
{
    if (a->rtol != b->rtol)
        return a->rtol < b->rtol;
    return a->arithmetic != b->arithmetic ? a->arithmetic > b->arithmetic : a->seconds < b->seconds;
}

bool tradeoff_ends_well(bool ended, const char *reason)
{
    return !ended || (strcmp(reason, "step_limit") != 0 && strcmp(reason, "not_smooth") != 0);
}

static bool usable(const struct tradeoff_row *row)
{
    return row->finished && tradeoff_ends_well(row->ended, row->ended_reason) && row->values.rows > 0;
}

/* The last row of its series that came to an end, if it can be compared with: where tighter ones ran out of steps, a
 * loose one says nothing. */
static bool is_tightest(const struct tradeoff *t, int place)
{
    bool last = usable(t->row + place);
    for (int k = place + 1; k < t->rows && last; k++)
        last = t->row[k].series != t->row[place].series || !t->row[k].finished;
    return last;
}

static bool alike(const struct tradeoff_row *a, const struct tradeoff_row *b)
{
    return a->ended == b->ended && (!a->ended || strcmp(a->ended_reason, b->ended_reason) == 0);
}

/* A row that ends as most do where each method is tightest: one alone may stop at a kink of the field, or where
 * its enclosures grow, or step over a pole. -1: there is none. */
static int usual_end(const struct tradeoff *t)
{
    int best = -1, most = 0;
    for (int i = 0; i < t->rows; i++) {
        int same = 0;
        for (int k = 0; k < t->rows && is_tightest(t, i); k++)
            same += is_tightest(t, k) && alike(t->row + i, t->row + k);
        if (same > most || (same == most && same && !t->row[i].ended)) {
            most = same;
            best = i;
        }
    }
    return best;
}

/* The best row not tried yet that the time left allows, or -1. */
static int candidate(const struct tradeoff_run *u, const unsigned char *tried)
{
    const struct tradeoff *t = u->t;
    double left = tradeoff_left(u->end);
    int best = -1, usual = usual_end(t);
    for (int i = 0; i < t->rows; i++) {
        const struct tradeoff_row *row = t->row + i;
        if (tried[i] || !usable(row) || !alike(row, t->row + usual) || SOLUTIONS * row->seconds > left)
            continue;
        if (best < 0 || better(row, t->row + best))
            best = i;
    }
    return best;
}

static double largest(const struct tradeoff_values *v, int column)
{
    double most = 0;
    for (int i = 0; i < v->rows; i++)
        most = fmax(most, fabs(v->value[(size_t)i * (size_t)v->columns + (size_t)column].hi));
    return most;
}

/* Largest difference of a column over the samples that both have. */
static double difference(const struct tradeoff_values *a, const struct tradeoff_values *b, int column)
{
    assert(column >= 0 && column < a->columns && column < b->columns);
    double most = 0;
    for (int i = 0; i < a->rows && i < b->rows; i++) {
        size_t at = (size_t)i * (size_t)a->columns + (size_t)column;
        most = fmax(most, distance(a->value[at], b->value[at]));
    }
    return most;
}

static double largest_radius(const struct traj_result *r, int column)
{
    double most = 0;
    for (int i = 0; i < r->rows; i++)
        most = fmax(most, r->radius[(size_t)i * (size_t)r->columns + (size_t)column]);
    return most;
}

/* How far the nearest solution by another method, in the same arithmetic and about as tight, is away
 * in a column: estimates by one method alone can be too small by chance. 0 where there is none. */
static double second_opinion(const struct tradeoff *t, const struct tradeoff_row *row, int column)
{
    double least = INFINITY;
    for (int i = 0; i < t->rows; i++) {
        const struct tradeoff_row *other = t->row + i;
        if (other->finished && other->series != row->series && other->arithmetic == row->arithmetic && other->rtol <= SIMILAR * row->rtol
            && other->values.rows >= t->best.values.rows)
            least = fmin(least, difference(&t->best.values, &other->values, column));
    }
    return isfinite(least) ? least : 0;
}

/* What digits of each column are relative to. */
static void set_sizes(struct tradeoff_best *b, const double *unit, double floor_size)
{
    int n = b->values.columns;
    b->doubt = sga_calloc((size_t)n + 1, sizeof *b->doubt);
    b->size = sga_calloc((size_t)n + 1, sizeof *b->size);
    b->unit = sga_calloc((size_t)n + 1, sizeof *b->unit);
    for (int j = 0; j < n; j++) {
        b->unit[j] = unit ? unit[j] : 1;
        b->size[j] = fmax(largest(&b->values, j), floor_size * b->unit[j]);
    }
}

/* What each column of the best solution may be wrong by: the radius of enclosures; otherwise the
 * estimate of the column (or that of all, shared out by their sizes), and at least
 * what the solution less tight and the one by another method differ by. */
static void set_doubt(struct tradeoff *t, const struct traj_result *r, const struct tradeoff_row *row)
{
    struct tradeoff_best *b = &t->best;
    double most = 0;
    for (int j = 0; j < b->values.columns; j++)
        most = fmax(most, largest(&b->values, j));
    for (int j = 0; j < b->values.columns; j++) {
        double size = largest(&b->values, j), apart = fmax(ALLOWANCE * difference(&b->values, &row->values, j), second_opinion(t, row, j));
        b->doubt[j] = r->radius ? largest_radius(r, j)
                                : fmax(apart, r->column_error ? r->column_error[j] : most > 0 ? b->error_estimate * (size / most) : b->error_estimate);
        b->doubt[j] += rounding(b->arithmetic) * size;
    }
}

/* Is it fit to be compared with? Then it is kept. */
static bool keep(struct tradeoff *t, const struct traj_result *r, int place, double floor_size)
{
    const struct tradeoff_row *row = t->row + place;
    if (!isfinite(r->error_estimate) || r->rows == 0 || !tradeoff_ends_well(r->ended, r->ended_reason))
        return false;
    t->best = (struct tradeoff_best){ .has = true, .method = r->method, .arithmetic = r->arithmetic, .rtol = row->rtol,
                                 .error_estimate = r->error_estimate, .row = place, .ended = r->ended,
                                 .ended_reason = r->ended_reason };
    tradeoff_keep(r, &t->best.values);
    set_sizes(&t->best, r->unit, floor_size);
    set_doubt(t, r, row);
    return true;
}

/* The largest doubt, relative to what digits are relative to. */
static double relative_doubt(const struct tradeoff_best *b)
{
    double most = 0;
    for (int j = 0; j < b->values.columns; j++)
        most = fmax(most, b->size[j] > 0 ? b->doubt[j] / b->size[j] : b->doubt[j] > 0 ? INFINITY : 0);
    return most;
}

/* The row of its series before it, if they can be compared; -1: there is none. */
static int before(const struct tradeoff *t, int place)
{
    const struct tradeoff_row *row = t->row + place, *last = row - 1;
    bool fits = place > 0 && last->series == row->series && usable(last) && alike(last, row) && last->values.rows == row->values.rows;
    return fits ? place - 1 : -1;
}

/* The tightest row with another to compare it with, or -1. */
static int best_row(const struct tradeoff *t)
{
    int best = -1, usual = usual_end(t);
    for (int i = 0; i < t->rows; i++)
        if (usable(t->row + i) && alike(t->row + i, t->row + usual) && before(t, i) >= 0 && (best < 0 || better(t->row + i, t->row + best)))
            best = i;
    return best;
}

static void end_best(struct tradeoff_best *b)
{
    free(b->values.value);
    free(b->doubt);
    free(b->size);
    free(b->unit);
    *b = (struct tradeoff_best){ 0 };
}

/* Where no solution with an estimate of its own was found, or only one that is much less sure: a row serves, by what it
 * and the one less tight differ by. */
static void row_serves(struct tradeoff *t, const double *unit, double floor_size)
{
    int place = best_row(t);
    if (place < 0)
        return;
    const struct tradeoff_row *row = t->row + place, *last = t->row + before(t, place);
    struct tradeoff_best found = t->best;
    size_t count = (size_t)row->values.rows * (size_t)row->values.columns;
    t->best = (struct tradeoff_best){ .has = true, .method = row->method, .arithmetic = tradeoff_arithmetic(row->arithmetic), .rtol = row->rtol,
                                 .row = place, .ended = row->ended, .ended_reason = row->ended_reason, .values = row->values };
    struct tradeoff_best *b = &t->best;
    b->values.value = memcpy(sga_malloc((count + 1) * sizeof *b->values.value), row->values.value, count * sizeof *b->values.value);
    set_sizes(b, unit, floor_size);
    for (int j = 0; j < b->values.columns; j++) {
        b->doubt[j] = fmax(ALONE * difference(&b->values, &last->values, j), second_opinion(t, row, j)) + rounding(b->arithmetic) * largest(&b->values, j);
        b->error_estimate = fmax(b->error_estimate, b->doubt[j]);
    }
    bool surer = !found.has || relative_doubt(b) * MUCH_SURER < relative_doubt(&found);
    struct tradeoff_best *worse = surer ? &found : b, kept = surer ? *b : found;
    end_best(worse);
    t->best = kept;
}

bool tradeoff_best(struct tradeoff_run *u)
{
    struct tradeoff *t = u->t;
    const struct request_accuracy *asked = &u->j->request->accuracy;
    double floor_size = asked->atol / asked->rtol;
    SGA_ARENA(mem);
    unsigned char *tried = sga_zeros(&mem, (size_t)t->rows + 1, 1);
    bool ok = true;
    int place;
    for (int k = 0; k < ATTEMPTS && ok && !t->best.has && (place = candidate(u, tried)) >= 0; k++) {
        struct traj_result r;
        struct sga_error err = { 0 };
        double seconds = fmax(SOLUTIONS * t->row[place].seconds, ATTEMPT_PART * tradeoff_left(u->end));
        tried[place] = 1;
        if (tradeoff_solve(u, t->row + place, false, seconds, &r, &err)) {
            keep(t, &r, place, floor_size);
            traj_result_clear(&r);
        } else {
            ok = job_goes_on(u->j);
        }
    }
    if (ok)
        row_serves(t, t->unit, floor_size);
    return ok;
}

/* The same end as the best solution's. */
static bool same_end(const struct tradeoff_row *row, const struct tradeoff_best *b)
{
    return row->ended == b->ended && (!row->ended || strcmp(row->ended_reason, b->ended_reason) == 0);
}

/* Each sample within rtol |value| + atol, whatever the best solution is wrong by; or one surely not. */
static void set_within(struct tradeoff_row *row, const struct tradeoff_best *b, double rtol, double atol)
{
    const struct sga_tolerance asked = { rtol, atol };
    row->within = true;
    row->beyond = false;
    for (int i = 0; i < row->values.rows && i < b->values.rows; i++)
        for (int j = 0; j < b->values.columns; j++) {
            size_t at = (size_t)i * (size_t)b->values.columns + (size_t)j;
            double apart = distance(row->values.value[at], b->values.value[at]), allowed = sga_allowed(asked, b->unit[j], b->values.value[at].hi);
            row->within = row->within && apart + b->doubt[j] <= allowed;
            row->beyond = row->beyond || apart - b->doubt[j] > allowed;
        }
}

static void compare(struct tradeoff_row *row, const struct tradeoff_best *b, double rtol, double atol)
{
    assert(b->has && row->values.columns == b->values.columns);
    double error = 0, doubt = 0, most = rounding(b->arithmetic), least = most;
    row->error_at_most = 0;
    for (int j = 0; j < b->values.columns; j++) {
        double e = difference(&row->values, &b->values, j);
        error = fmax(error, e);
        doubt = fmax(doubt, b->doubt[j]);
        row->error_at_most = fmax(row->error_at_most, e + b->doubt[j]);
        if (b->size[j] > 0 || e + b->doubt[j] > 0) {
            most = fmax(most, (e + b->doubt[j]) / b->size[j]);
            least = fmax(least, (e - b->doubt[j]) / b->size[j]);
        }
    }
    row->compared = true;
    row->error = error >= WELL_ABOVE * doubt ? error : NAN;
    row->digits = fmax(-log10(most), 0);
    row->digits_most = fmax(-log10(least), 0);
    set_within(row, b, rtol, atol);
}

void tradeoff_errors(struct tradeoff *t, double rtol, double atol)
{
    for (int i = 0; i < t->rows; i++) {
        struct tradeoff_row *row = t->row + i;
        if (!row->finished)
            continue;
        if (!t->best.has)
            snprintf(row->note, sizeof row->note, "no better solution could be found in the time, so that the error is not known");
        else if (!same_end(row, &t->best) && row->ended)
            snprintf(row->note, sizeof row->note, "ended at %.9g (%s), unlike the best solution", row->ended_t, row->ended_reason);
        else if (!same_end(row, &t->best))
            snprintf(row->note, sizeof row->note, "did not end before the last time, unlike the best solution");
        else
            compare(row, &t->best, rtol, atol);
        if (row->compared && isnan(row->error) && !row->note[0])
            snprintf(row->note, sizeof row->note, "the best solution is not known well enough to tell the error");
    }
}
