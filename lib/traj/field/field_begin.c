/* The field where a motion starts: by which way it goes, the rank, and what contradicts. */
#include "field.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "gauge_choice.h"
#include "kinds.h"
#include "mem.h"
#include "points.h"
#include "points_space.h"
#include "print.h"
#include "switches.h"
#include "system.h"
#include "tape.h"
#include "warnings.h"
#include "whole.h"

/* Of a pivot beside the start: below this it is 0 there but for roundings, and what it is beside tells its size. And how far beside, of the variables. */
static const double NONE = 1e-10, BESIDE = 0.1;

/* The sizes of pivots that are 0 at the start: what is divided by them as they grow from a rounding is nothing but roundings too. f->direct_out is for a place
 * beside then. */
static void sizes_beside(struct field *f, double t, const double *x)
{
    SGA_FREED int *by_name = sga_malloc(((size_t)f->n + 1) * sizeof *by_name);
    sys_by_name(f->sys, by_name);
    for (int i = 0; i < f->n; i++) {
        int j = by_name[i];
        f->in[j] = x[j] + BESIDE * (fabs(x[j]) + (f->unit ? f->unit[j] : 1)) * sin(1.3 + 2.1 * i);
    }
    num_tape_eval(f->direct, f->in, f->direct_out);
    for (int q = 0; q < f->pivots; q++) {
        double p = fabs(f->direct_out[f->n + q]);
        if (isfinite(p) && f->pivot_start[q] < NONE * p)
            f->pivot_start[q] = p;
    }
    field_load(f, t, x);
}

/* Remember how large the pivots are where the motion starts. */
static bool try_direct(struct field *f, double t, const double *x, double *v)
{
    bool well = num_tape_eval(f->direct, f->in, f->direct_out);
    memcpy(v, f->direct_out, (size_t)f->n * sizeof *v);
    field_take_sides(f, t, x);
    for (int q = 0; q < f->pivots; q++) {
        double p = f->direct_out[f->n + q];
        f->pivot_start[q] = isfinite(p) ? fabs(p) : 0;
        well &= f->pivot_start[q] > 0;
    }
    if (f->pivots)
        sizes_beside(f, t, x);
    return well && f->fast;
}

/* The start lies where the answer says nothing. */
static bool start_beyond(struct field *f, int q, struct sga_error *err)
{
    char *text = expr_text(f->sys->store, f->solution_side[q].function, 200);
    sga_fail(err, SGA_E_NO_MOTION, "the constraints hold where %s %s 0 only, and the consistent start is not there; "
             "give trajectory.initial on that side", text, f->solution_side[q].sign > 0 ? ">" : "<");
    free(text);
    return false;
}

/* The rates do not fit; the one that is missed most is named, where it is a rate. */
static void refuse_rates(const struct field *f, int row, double miss, struct sga_error *err)
{
    int k = row - f->rows - f->c;
    char pointer[224] = "/trajectory/gauge/rates";
    if (k >= 0)
        snprintf(pointer, sizeof pointer, "/trajectory/gauge/rates/%.190s", f->sys->store->symbol[f->sys->variable[f->rate[k].variable].symbol].name);
    sga_fail_at(err, SGA_E_GAUGE, pointer, "the rates asked for contradict the motion: at the start the equations miss by %.3g; fix at "
                "most as many rates as there are gauge fields, and only free ones", miss);
}

/* Up to so many variables (field_init says where there are more) the rows are asked at the start, whatever the choice divides by; and how far they may differ. */
enum { ROWS_ASKED = SGA_MOST_ROWS_ASKED };
static const double SAME_FIELD = 1e-9;

/* At the start v, with the gauge choice by expressions, is what the rows say, and so is its rank: a pivot of the
 * rates may be 0 on all of Pf, or only here, where they ask less than elsewhere. */
static bool as_rows(struct field *f, const double *v)
{
    if (!f->choice->field || (f->n > ROWS_ASKED && !f->choice->pivots))
        return true;
    double *w = sga_calloc((size_t)f->n + 1, sizeof *w);
    int rank = 0;
    bool same = field_general(f, w, &rank) && rank == f->generic_rank + f->choice->fixed;
    double size = field_size(f, w);
    for (int j = 0; j < f->n && same; j++)
        same = fabs(v[j] - w[j]) <= SAME_FIELD * size * (f->unit ? f->unit[j] : 1);
    free(w);
    return same;
}

/* The field at the start, and the rank there. */
static bool first_value(struct field *f, double t, const double *x, double *v, int *rank)
{
    bool direct = !f->whole && try_direct(f, t, x, v), rows = direct && as_rows(f, v);
    *rank = f->generic_rank + f->choice->fixed;
    if (rows)
        return true;
    if (f->choice->field && (direct || f->choice->pivots)) {
        f->fast = false;
        f->choice->why = "at the start the rates ask less than elsewhere, or the expressions lose digits";
    }
    return field_general(f, v, rank);
}

/* Variables are changed by so much of their sizes; and how much farther the velocities of the expressions may go then than those of the rows. */
static const double CHANGE = 1e-7, FARTHER = 1e4;

static double apart(const struct field *f, const double *a, const double *b)
{
    double most = 0;
    for (int j = 0; j < f->n; j++) {
        double d = fabs(a[j] - b[j]) / (f->unit ? f->unit[j] : 1);
        most = isfinite(d) ? fmax(most, d) : INFINITY;
    }
    return most;
}

/* Velocities here (a) and beside (b), by the expressions or by f->whole. */
static bool here_and_beside(struct field *f, double t, const double *x, double *a, double *b)
{
    bool ok = true;
    SGA_FREED int *by_name = sga_malloc(((size_t)f->n + 1) * sizeof *by_name);
    sys_by_name(f->sys, by_name);
    for (int beside = 0; beside < 2 && ok; beside++) {
        int rank;
        field_load(f, t, x);
        for (int i = 0; i < f->n && beside; i++) {
            int j = by_name[i];
            f->in[j] += CHANGE * (fabs(x[j]) + (f->unit ? f->unit[j] : 1)) * sin(1.3 + 2.1 * i);
        }
        if (f->whole)
            ok = field_general(f, beside ? b : a, &rank) && rank == f->n;
        else if ((ok = num_tape_eval(f->direct, f->in, f->direct_out)))
            memcpy(beside ? b : a, f->direct_out, (size_t)f->n * sizeof *a);
    }
    field_load(f, t, x);
    return ok;
}

/* An elimination in an order that no values have chosen (a grid solved row by row) makes of a rounding what a march makes of it: velocities change far more
 * beside this place than those of the rows do. f->whole are these. */
static bool loses_digits(struct field *f, double t, const double *x)
{
    struct whole *whole = f->whole;
    SGA_ARENA(mem);
    size_t bytes = ((size_t)f->n + 1) * sizeof(double);
    double *a = sga_take(&mem, bytes), *b = sga_take(&mem, bytes);
    bool known = here_and_beside(f, t, x, a, b);
    double rows = apart(f, a, b) + CHANGE * field_size(f, a);
    f->whole = NULL;
    bool far = known && (!here_and_beside(f, t, x, a, b) || apart(f, a, b) > FARTHER * rows);
    f->whole = whole;
    return far;
}

/* Large systems whose reduced field is dense, or loses digits (lossy: known), are taken as they stand, where nothing is watched and nothing is left to choose. */
static void begin_whole(struct field *f, double t, const double *x, bool lossy)
{
    bool dense = f->dense >= WHOLE_BLOCK || lossy, divides = f->fast && f->c && f->pivots;
    bool may = f->n >= WHOLE_VARIABLES && (dense || divides) && f->generic_rank == f->n && !f->rates && !f->choice->field;
    if (!may || f->sides || f->poles || f->switches->count || f->whole || f->reduced)
        return;
    f->whole = whole_new(f, t, x);
    if (f->whole && !dense && !loses_digits(f, t, x)) {
        whole_free(f->whole);
        f->whole = NULL;
    }
    f->fast = f->fast && !f->whole;
    f->beyond = f->whole ? -1 : f->beyond;
    if (!f->whole)
        field_rows_forget(f);
    field_load(f, t, x);
}

bool field_begin(struct field *f, double t, const double *x, struct sga_error *err)
{
    double *v = sga_calloc((size_t)f->n + 1, sizeof *v);
    int rank, bad = 0;
    f->begin_t = t;
    field_load(f, t, x);
    begin_whole(f, t, x, false);
    bool ok = first_value(f, t, x, v, &rank);
    /* with rates the rank is higher than that of the system: what it is at the start */
    f->rank = f->rates && rank > f->generic_rank ? rank : f->generic_rank;
    for (int q = 0; q < f->sides && ok; q++)
        if (f->pivot_side[q] != f->solution_side[q].sign && !f->solution_side[q].unseen)
            ok = start_beyond(f, q, err);
    if (ok && rank == f->rank && f->n <= ROWS_ASKED && !f->rates && !f->whole) {
        int told = field_rank_told(f);
        rank = told >= 0 && told < rank ? told : rank;
    }
    if (!ok && err->code != SGA_E_OK) {
        ;               /* said already */
    } else if (!ok) {
        sga_fail(err, SGA_E_NO_MOTION, "the equations have no value at the consistent start; start inside their domain");
    } else if (rank < f->rank) {
        ok = sga_fail(err, SGA_E_NO_MOTION, "at the consistent start the rank is %d as far as numbers in double tell, and %d elsewhere: it lies on a "
                      "stratum, where the motion is not determined, or too near to one; start elsewhere", rank, f->rank);
    } else {
        double size = field_size(f, v), worst = field_rows_miss(f, v, &bad);
        bool asked = !f->rates && f->n <= ROWS_ASKED;
        /* a row of nothing but roundings (x E2 added to E1, at x = 0) says nothing against the expressions, and much that is wrong where it is solved */
        bool rounded = worst > 1e-9 * size && f->fast && asked && field_rows_rounded(f, v, 1e-9 * size);
        if (f->fast && worst > 1e-9 * size && !rounded)
            begin_whole(f, t, x, true);
        if ((f->fast || f->whole) && worst > 1e-9 * size && !rounded && field_general(f, v, &rank) && rank == f->rank) {
            f->fast = false;      /* the expressions lose digits here: solve the rows instead */
            if (f->choice->field)
                f->choice->why = "the expressions lose digits at the start";
            worst = field_rows_miss(f, v, &bad);
        }
        ok = rounded || worst <= 1e-7 * size || (asked && field_rows_rounded(f, v, 1e-7 * size));
        if (!ok && f->rates)
            refuse_rates(f, bad, worst, err);
        else if (!ok)
            sga_fail(err, SGA_E_NO_MOTION, "at the consistent start the equations have no solution (row %d misses by %.3g): "
                     "the start lies on a stratum where the rank drops; start elsewhere", bad + 1, worst);
    }
    free(v);
    assert(field_sane(f));
    ok = ok && (f->guard || field_guards_init(f, err));
    f->start_t = f->whole ? t : f->start_t;
    if (!ok && !err->stage[0])
        memcpy(err->stage, "trajectory", 11);
    return ok;
}

bool field_as_reduced(struct field *f, double t, const double *x, struct sga_error *err)
{
    whole_free(f->whole);
    f->whole = NULL;
    f->reduced = true;
    f->fast = !f->choice->why;
    field_rows_forget(f);
    field_guards_forget(f);
    return field_begin(f, t, x, err);
}
