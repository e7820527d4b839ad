/* Ways on from many surfaces at once, by complementarity. */
#include "slide_trial.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reduction.h"

enum { MOST = 10 };              /* surfaces: their minors are 2 to this */
/* Of products of the entries of a minor's rows, what is not told from 0; of a switch, what is not told from its ends; of rates, what is not told from affine. */
static const double SINGULAR = 1e-9, AT_END = 1e-6, BENT = 1e-7;

static const char nonlinear[] = "the motion comes to more than three surfaces at once, and what their switches do there is not the sum of what each does: so many ways on are not told apart";
static const char not_unique[] = "the motion comes to more than three surfaces at once, and how their switches act on them does not leave one way on, whatever else acts: so many are not told apart";
static const char close_call[] = "the motion comes to more than three surfaces at once, and first derivatives do not tell which of them it leaves";
static const char too_many[] = "the motion comes to more than ten surfaces at once where switches jump: so many ways on are not told apart";

/* rate = base + sum of by (row: surface, column: switch) times (switch + 1) / 2, along the motion. */
struct rates {
    int n, open[MOST];
    double base[MOST], by[MOST][MOST], doubt[MOST];
};

/* The derivatives of the open surfaces' functions with all switches at ends. *known: they have values here. */
static bool at_corner(const struct decision *d, const struct rates *r, const int *choice, double *rate, double *doubt, bool *known, struct sga_error *err)
{
    struct trial trial;
    struct told v = { 0 };
    bool ok = slide_try(d, choice, &trial, err);
    *known = ok && trial.has_start && trial.stays && !trial.mode->sol->free_columns;
    if (*known)
        ok = slide_tell(slide_ways(d->s, trial.mode), 0, d->at->t, trial.start.x, trial.start.derivative, &v, err);
    for (int i = 0; i < r->n && *known && ok; i++) {
        size_t at = (size_t)r->open[i] * (size_t)(v.order + 1) + 1;
        rate[i] = d->along * v.value[at];
        doubt[i] = fmax(doubt[i], v.doubt[at]);
        *known = isfinite(rate[i]) && d->open[r->open[i]] == AT_IT;
    }
    free(v.value);
    slide_trial_clear(&trial);
    return ok;
}

/* *why: they are not affine, or not known. */
static bool find_rates(const struct decision *d, const int *choice, struct rates *r, const char **why, struct sga_error *err)
{
    SGA_FREED int *mine = sga_malloc(((size_t)d->surfaces + 1) * sizeof *mine);
    double rate[MOST];
    bool known = true;
    for (int corner = 0; corner <= r->n + 1; corner++) {
        memcpy(mine, choice, (size_t)d->surfaces * sizeof *mine);
        for (int i = 0; i < r->n; i++)
            mine[r->open[i]] = corner == i + 1 || corner > r->n ? TRAJ_ABOVE : TRAJ_BELOW;
        if (!at_corner(d, r, mine, rate, r->doubt, &known, err))
            return false;
        if (!known)
            break;
        for (int i = 0; i < r->n; i++) {
            if (corner == 0)
                r->base[i] = rate[i];
            else if (corner <= r->n)
                r->by[i][corner - 1] = rate[i] - r->base[i];
        }
    }
    for (int i = 0; i < r->n && known; i++) {       /* rate: all switches up */
        double sum = r->base[i], size = fabs(r->base[i]);
        for (int k = 0; k < r->n; k++) {
            sum += r->by[i][k];
            size += fabs(r->by[i][k]);
        }
        known = fabs(rate[i] - sum) <= BENT * size + r->doubt[i];
    }
    *why = known ? NULL : nonlinear;
    return true;
}

/* a x = b in place, n x n of a row length MOST; pivots by size. The determinant; 0: it is not told from 0. */
static double solve(double a[MOST][MOST], double *b, int n)
{
    double det = 1, size = 1;
    for (int i = 0; i < n; i++) {
        double row = 0;
        for (int k = 0; k < n; k++)
            row = fmax(row, fabs(a[i][k]));
        size *= row;
    }
    for (int k = 0; k < n; k++) {
        int p = k;
        for (int i = k + 1; i < n; i++)
            p = fabs(a[i][k]) > fabs(a[p][k]) ? i : p;
        if (a[p][k] == 0)
            return 0;
        for (int c = 0; c < n && p != k; c++) {
            double keep = a[p][c];
            a[p][c] = a[k][c];
            a[k][c] = keep;
        }
        double keep = b[p];
        b[p] = b[k];
        b[k] = keep;
        det *= p == k ? a[k][k] : -a[k][k];
        for (int i = k + 1; i < n; i++) {
            double part = a[i][k] / a[k][k];
            for (int c = k; c < n; c++)
                a[i][c] -= part * a[k][c];
            b[i] -= part * b[k];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        for (int c = k + 1; c < n; c++)
            b[k] -= a[k][c] * b[c];
        b[k] /= a[k][k];
    }
    return fabs(det) > SINGULAR * size ? det : 0;
}

/* The block of -by with these surfaces; its size. */
static int block(const struct rates *r, const bool *in, double a[MOST][MOST], int *of)
{
    int n = 0;
    for (int i = 0; i < r->n; i++)
        if (in[i])
            of[n++] = i;
    for (int i = 0; i < n; i++)
        for (int k = 0; k < n; k++)
            a[i][k] = -r->by[of[i]][of[k]];
    return n;
}

/* All principal minors of -by are positive. */
static bool leaves_one(const struct rates *r)
{
    double a[MOST][MOST], b[MOST] = { 0 };
    bool in[MOST], ok = true;
    int of[MOST];
    for (unsigned set = 1; set < 1u << r->n && ok; set++) {
        for (int i = 0; i < r->n; i++)
            in[i] = set >> i & 1;
        ok = solve(a, b, block(r, in, a, of)) > 0;
    }
    return ok;
}

/* Switches (part: 0 at -1, 1 at 1) with those in `free` such that their surfaces are stayed on; rates of the others. */
static void balance(const struct rates *r, const bool *free_, double *part, double *rate)
{
    double a[MOST][MOST], b[MOST];
    int of[MOST], n = block(r, free_, a, of);
    for (int i = 0; i < n; i++) {
        b[i] = r->base[of[i]];
        for (int k = 0; k < r->n; k++)
            b[i] += free_[k] ? 0 : r->by[of[i]][k] * part[k];
    }
    solve(a, b, n);
    for (int i = 0; i < n; i++)
        part[of[i]] = b[i];
    for (int i = 0; i < r->n; i++) {
        rate[i] = free_[i] ? 0 : r->base[i];
        for (int k = 0; k < r->n && !free_[i]; k++)
            rate[i] += r->by[i][k] * part[k];
    }
}

/* The one choice that the rates leave, by pivots on the least index that is wrong. False: it is too close to another to be told. */
static bool complementary(const struct rates *r, int *choice)
{
    double part[MOST] = { 0 }, rate[MOST];
    bool free_[MOST];
    int wrong = 0;
    for (int i = 0; i < r->n; i++)
        free_[i] = true;
    for (long turn = 0; turn < 1L << 2 * MOST && wrong < r->n; turn++) {
        balance(r, free_, part, rate);
        for (wrong = 0; wrong < r->n; wrong++) {
            if (free_[wrong] && (part[wrong] < 0 || part[wrong] > 1)) {
                free_[wrong] = false;
                part[wrong] = part[wrong] < 0 ? 0 : 1;
                break;
            }
            if (!free_[wrong] && (part[wrong] == 0 ? rate[wrong] > 0 : rate[wrong] < 0)) {
                free_[wrong] = true;
                break;
            }
        }
    }
    bool clear = wrong == r->n;
    for (int i = 0; i < r->n && clear; i++) {
        clear = free_[i] ? part[i] > AT_END && part[i] < 1 - AT_END : fabs(rate[i]) > r->doubt[i];
        choice[r->open[i]] = free_[i] ? TRAJ_ALONG : part[i] == 0 ? TRAJ_BELOW : TRAJ_ABOVE;
    }
    return clear;
}

bool slide_many(const struct decision *d, int *choice, int *ways, const char **why, struct sga_error *err)
{
    struct rates r = { 0 };
    struct trial trial;
    *ways = 0;
    *why = NULL;
    for (int k = 0; k < d->surfaces; k++)
        if (d->open[k]) {
            if (r.n == MOST) {
                *why = too_many;
                return true;
            }
            r.open[r.n++] = k;
        }
    if (!find_rates(d, choice, &r, why, err) || *why)
        return err->code == SGA_E_OK;
    if (!leaves_one(&r) || !complementary(&r, choice)) {
        *why = leaves_one(&r) ? close_call : not_unique;
        return true;
    }
    memset(d->other, 0, (size_t)d->surfaces);
    bool ok = slide_try(d, choice, &trial, err);
    assert(!ok || trial.mode);
    *ways = ok && trial.way == IS_WAY;
    if (ok && trial.way == NOT_TOLD)
        *why = trial.what ? trial.what : close_call;
    slide_trial_clear(&trial);
    return ok;
}
