/* Gauss-Newton, in doubles where there are many constraints, else and beyond these in balls. */
#include "newton.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arb_ends.h"
#include "arena.h"
#include "budget.h"
#include "mem.h"
#include "normal.h"
#include "points.h"
#include "points_space.h"
#include "quick.h"
#include "search.h"

enum { STEPS = 60, LONG_STEPS = 240, BASIC_STEPS = 12, RETREATS = 20 };
/* A place so much farther than all before is one more on the way to infinity, where so many were, the last of them so far in units; nearer than this
 * part of them, it was none. */
static const double FARTHER = 1.5, FAR_OUT = 1e3, BACK = 0.25;
enum { FARTHER_PLACES = 5 };
/* In doubles a step goes on while it leaves less than this part of what was left, or more than their roundings may be. */
static const double SLOWEST = 0.1, QUICK_NOISE = 1e-6;

/* Blank the columns of variables that satisfied constraints contain; of many constraints those of the point before, though
 * others may be satisfied by chance. Returns how many constraints are not satisfied, or new. */
static int only_new(struct points_jacobian *j, struct normal *w, const double *r, unsigned char *old)
{
    int c = w->c, open = 0, first = j->space->before->constraints;
    for (int i = 0; i < c; i++) {
        bool met = c > POINTS_MANY ? i < first : fabs(r[i]) < 1e-9;
        open += !met;
        for (int k = 0; k < j->cols[i] && met && !old[w->n]; k++)
            old[j->col[i][k]] = 1;
    }
    old[w->n] = 1;
    for (int i = 0; i < c; i++)
        for (int k = 0; k < j->cols[i]; k++)
            if (old[j->col[i][k]])
                w->value[i][k] = 0;
    return open;
}

/* The largest variable of row i, 1 at the least: what its residual is compared with. A variable that
 * the row does not contain says nothing about it, however far it went. */
static double row_size(const struct points_jacobian *j, int i, const struct points_point *p, const int *scale)
{
    double size = 1;
    for (int k = 0; k < j->cols[i]; k++) {
        double x = fabs(p->x[j->col[i][k]]);
        size = fmax(size, scale ? ldexp(x, -scale[j->col[i][k]]) : x);
    }
    return size;
}

/* Row i and its residual where some variables move more easily, the row's largest entry as large as before. */
static void loosen_row(const struct points_jacobian *j, struct normal *w, int i, const signed char *cheap, double *r)
{
    double before = 0, after = 0;
    for (int k = 0; k < j->cols[i]; k++) {
        before = fmax(before, fabs(w->value[i][k]));
        w->value[i][k] = ldexp(w->value[i][k], cheap[j->col[i][k]]);
        after = fmax(after, fabs(w->value[i][k]));
    }
    for (int k = 0; k < j->cols[i] && after > 0; k++)
        w->value[i][k] *= before / after;
    r[i] *= after > 0 ? before / after : 1;
}

static void set_symbols(const struct points_space *s, struct points_point *p)
{
    for (int i = 0; i < s->variables; i++)
        num_ball_set_d(&p->ball, s->variable[i], p->x[i]);
}

/* The rows' entries and the constraints' values, in units of each row's largest entry: in balls. False: something has no value. */
static bool rows_in_balls(struct points_jacobian *j, struct points_point *p, struct normal *w, double *r)
{
    const struct points_space *s = j->space;
    const int *scale = p->scaled ? s->scale : NULL;
    points_jacobian_values(j, &p->ball);
    for (int i = 0; i < s->constraints; i++)
        if (!arb_is_finite(num_ball_value(&p->ball, s->constraint[i])))
            return false;
    points_jacobian_entries(j, &p->ball);
    for (int i = 0; i < s->constraints; i++) {
        slong e = points_row_exponent(j, i, scale);
        for (int k = 0; k < j->cols[i]; k++) {
            if (!arb_is_finite(j->entry[i] + k))
                return false;
            w->value[i][k] = points_scaled(j->entry[i] + k, e - (scale ? scale[j->col[i][k]] : 0));
        }
        r[i] = points_scaled(num_ball_value(&p->ball, s->constraint[i]), e);
        if (!isfinite(r[i]))
            return false;
    }
    return true;
}

/* The same in doubles; false where these are not enough. */
static bool rows_in_doubles(struct points_quick *q, const struct points_jacobian *j, const struct points_point *p, struct normal *w, double *r)
{
    const int *scale = p->scaled ? j->space->scale : NULL;
    if (!points_quick_at(q, j, p, w->value))
        return false;
    for (int i = 0; i < w->c; i++) {
        double most = 0;
        int e;
        for (int k = 0; k < j->cols[i]; k++) {
            w->value[i][k] = scale ? ldexp(w->value[i][k], scale[j->col[i][k]]) : w->value[i][k];
            most = fabs(w->value[i][k]) > most ? fabs(w->value[i][k]) : most;
        }
        frexp(most, &e);
        double unit = ldexp(1, -e);
        for (int k = 0; k < j->cols[i]; k++)
            w->value[i][k] *= unit;
        r[i] = q->value[i] * unit;
        if (!isfinite(most) || !(most > 0) || !isfinite(unit) || !(unit > 0) || !isfinite(r[i]))
            return false;
    }
    return true;
}

/* One Gauss-Newton step: of least norm, or (old not NULL) one that moves only variables
 * that no satisfied constraint contains; `old` (by variable) is worked out at the first
 * such step (old[n] = 0). Returns the largest scaled residual before it, or -1 where the
 * constraints have no value; *rank is the numerical rank of the differentials. In doubles where *quick, which becomes false where these are not enough. */
static double step(struct points_jacobian *j, struct points_point *p, struct points_parts *parts, struct normal *w, struct points_quick *q, bool *quick,
                   unsigned char *old, double *r, double *d, int *rank)
{
    const struct points_space *s = j->space;
    const int *scale = p->scaled ? s->scale : NULL;
    const signed char *cheap = p->cheaply ? s->cheap : NULL;
    int c = s->constraints, n = s->variables;
    bool was = *quick;
    *quick = was && rows_in_doubles(q, j, p, w, r);
    if (was && !*quick)
        set_symbols(s, p);
    if (!*quick && !rows_in_balls(j, p, w, r))
        return -1;
    double worst = 0;
    for (int k = 0; k < parts->count; k++)
        parts->residual[k] = 0;
    for (int i = 0; i < c; i++) {
        double residual = fabs(r[i]) / row_size(j, i, p, scale);
        worst = fmax(worst, residual);
        if (parts->count)
            parts->residual[parts->of_constraint[i]] = fmax(parts->residual[parts->of_constraint[i]], residual);
        if (cheap)
            loosen_row(j, w, i, cheap, r);
    }
    if (old) {
        int open = only_new(j, w, r, old);
        *rank = normal_basic_step(w, r, d) < open ? 0 : c;
    } else {
        *rank = normal_is_sparse(w) ? normal_quick_step(w, r, d) : normal_step(w, r, d);
    }
    for (int i = 0; i < n && cheap; i++)
        d[i] = ldexp(d[i], cheap[i]);
    double len = 0, size = 1;
    for (int i = 0; i < n; i++) {
        len = fmax(len, fabs(d[i]));
        size = fmax(size, scale ? ldexp(fabs(p->x[i]), -scale[i]) : fabs(p->x[i]));
    }
    double whole = len > 4 * size ? 4 * size / len : 1;
    if (parts->count)
        points_parts_damp(parts, s, p, scale, d);
    for (int i = 0; i < n; i++) {
        double damp = parts->count && parts->of_variable[i] >= 0 ? parts->length[parts->of_variable[i]] : whole;
        p->x[i] += damp * (scale ? ldexp(d[i], scale[i]) : d[i]);
        if (!isfinite(p->x[i]))
            return -1;
    }
    if (!*quick)
        set_symbols(s, p);
    return worst;
}

/* Back to a quarter of the last step, which led out of the domain. */
static void retreat(struct points_point *p, const struct points_space *s, const double *from)
{
    for (int i = 0; i < s->variables; i++)
        p->x[i] = isfinite(p->x[i]) ? from[i] + (p->x[i] - from[i]) / 4 : from[i];
    set_symbols(s, p);
}

/* How far a search has gone, in units, and over how many places, each farther than those before. */
struct way {
    double far;
    int places;
};

static void way_on(struct way *way, const struct points_space *s, const struct points_point *p)
{
    const int *scale = p->scaled ? s->scale : NULL;
    double far = 1;
    for (int i = 0; i < s->variables; i++)
        far = fmax(far, scale ? ldexp(fabs(p->x[i]), -scale[i]) : fabs(p->x[i]));
    if (far > FARTHER * way->far)
        *way = (struct way){ far, way->places + 1 };
    else if (far < BACK * way->far)
        *way = (struct way){ far, 0 };
}

int points_newton(struct points_search *w, struct points_point *p, struct points_parts *parts, bool basic)
{
    struct points_jacobian *j = &w->j;
    const struct points_space *s = j->space;
    int c = s->constraints, n = s->variables, rank = c, result = 0;
    SGA_ARENA(mem);
    double *r = sga_take(&mem, (size_t)c * sizeof *r), *d = sga_take(&mem, (size_t)n * sizeof *d);
    double *from = sga_take(&mem, 2 * ((size_t)n + 1) * sizeof *from), *here = from + n + 1, last = INFINITY;
    bool quick = c > POINTS_QUICK;
    struct points_quick *q = quick ? points_search_quick(w) : NULL;
    int retreats = 0;
    struct way way = { 1, 0 };
    SGA_FREED unsigned char *old = basic ? sga_calloc((size_t)n + 1, 1) : NULL;
    for (int k = 0; k < (basic ? BASIC_STEPS : c > POINTS_FEW ? LONG_STEPS : STEPS) && (!s->steps || (*s->steps)-- > 0); k++) {
        memcpy(here, p->x, (size_t)n * sizeof *here);
        double res = step(j, p, parts, &w->normal, q, &quick, old, r, d, &rank);
        if (!sga_budget_ok(s->budget, NULL))
            break;
        if (res < 0) {
            if (!k || retreats++ >= RETREATS)
                break;
            retreat(p, s, from);
            continue;
        }
        memcpy(from, here, (size_t)n * sizeof *from);
        way_on(&way, s, p);
        if (old && rank == 0 && res >= 1e-12)
            break;          /* the new variables alone cannot do it */
        if (quick && res <= QUICK_NOISE && !(res < SLOWEST * last)) {      /* roundings of doubles are what is left */
            quick = false;
            set_symbols(s, p);
        }
        last = res;
        if (last < 1e-12) {
            result = 1;      /* whether it is regular there, the refinement tells */
            break;
        }
    }
    if (quick)
        set_symbols(s, p);
    p->away = way.places >= FARTHER_PLACES && way.far > FAR_OUT;
    if (result == 0 && !basic && last < 1e-4)
        result = -1;
    if (result != 1)
        points_parts_keep(parts, s, p);
    return result;
}
