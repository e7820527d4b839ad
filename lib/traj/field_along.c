/* What is watched of the field along a step: pivots, denominators, and the borders of the domains of functions. A step looks at few places, and the motion
 * may pass where a rank drops, a pole or the end of a domain and be back between two of them: nobody saw it. The functions' values and rates at both
 * ends say of most steps that nothing is near; where they do not, the functions are tabulated on the step's polynomial (guard.h), and a place where one of them has
 * another sign than at the begin is asked as any other point of the motion. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "domain_ends.h"
#include "field.h"
#include "guard.h"
#include "larger.h"
#include "mem.h"
#include "ode.h"
#include "system.h"
#include "tape.h"

static const double PROBE = 1e-4;      /* of a step: for the rates at its ends */
static const double INSIDE = 0.38;     /* of a step: no simple fraction, for what comes again and again */
static const double DIP = 0.5;         /* of its least value: where a function comes to less between, it is looked at; */
static const double WILD = 0.25;       /* of the same: and where it is not the cubic of its values and rates by so much, whose error is nowhere more than 1.2 times that */
static const double LONGER = 1.5;      /* than the step before: what varies in it need not show at its ends (a whole period). */
static const double CALM_STEPS = 3;    /* After one in which nothing was near so many need no look, */
static const double CALM_PART = 0.2;   /* and no more than this part of the way to a zero at the largest rate */

struct along {
    struct field *f;
    const struct ode_path *path;
    double *x, *start, *rate, *last, *last_rate;
    unsigned char *free;               /* by function: its zeros end nothing in this step */
};

bool field_guards_init(struct field *f, struct sga_error *err)
{
    struct field_list l = { 0 };
    for (int q = 0; q < f->chosen; q++)
        field_list_add(&l, f->pivot_expr[q]);
    for (int q = 0; q < f->poles; q++)
        field_list_add(&l, f->pole_expr[q]);
    expr_id *root;
    int roots = sys_expressions(f->sys, &root);
    root = sga_realloc(root, (size_t)(roots + f->valueds + 1) * sizeof *root);
    for (int k = 0; k < f->valueds; k++)
        root[roots + k] = f->valued[k];
    domain_ends(f->sys->store, root, roots + f->valueds, &l);
    free(root);
    f->guards = l.count;
    f->border = -1;
    bool ok = true;
    if (f->guards) {
        int *inputs = field_inputs(f->sys);
        f->guard = num_tape_new_switched(f->sys->store, field_switches(f), l.e, l.count, inputs, f->n + 1, err);
        f->along = sga_calloc(2 * (size_t)f->guards, sizeof *f->along);
        ok = f->guard != NULL;
        free(inputs);
    }
    f->guard_expr = l.e;
    return ok;
}

/* Function k is 0 at the end of a domain, and not negative inside. */
static bool ends_domain(const struct field *f, int k) { return k >= f->chosen + f->poles; }

static void load(struct field *f, const struct field_way *way, double s)
{
    const struct along *a = way->of;
    a->path->at(a->path->march, s, a->x);
    field_load(f, a->path->t + s * a->path->h, a->x);
}

/* Of a guard_way. */
static void at(void *of, double s, double *g)
{
    const struct along *a = of;
    load(a->f, &(struct field_way){ a, load }, s);
    num_tape_eval(a->f->guard, a->f->in, g);
}

/* The field at s says that the motion may be there. */
static bool is_inside(struct along *a, double s)
{
    struct field *f = a->f;
    load(f, &(struct field_way){ a, load }, s);
    num_tape_eval(f->direct, f->in, f->direct_out);
    field_forget_trial(f);             /* as the motion is at the begin of the step */
    return field_inside(f, f->in[f->n], a->x);
}

/* By how much errors of the state, and roundings, change function k at s. */
static double doubt(struct along *a, int k, double s, double *g)
{
    struct field *f = a->f;
    at(a, s, g);
    double value = g[k], sum = 16 * DBL_EPSILON * fabs(value);
    for (int j = 0; j <= f->n; j++) {
        double keep = f->in[j];
        f->in[j] += j < f->n ? a->path->error(a->path->march, j) : 16 * DBL_EPSILON * fabs(keep);
        num_tape_eval(f->guard, f->in, g);
        sum += fabs(g[k] - value);
        f->in[j] = keep;
    }
    return sum;
}

/* Function k has another sign at s than at the begin: does that end the motion? */
static bool ends(struct along *a, const struct guard_way *way, int k, double s, double value, double *g)
{
    struct field *f = a->f;
    f->lost_pivot = f->lost_pole = -1;
    f->rank_lost = false;
    if (ends_domain(f, k)) {
        if (!(fabs(value) > doubt(a, k, s, g)))
            return false;
        f->border = k;
        f->border_t = a->path->t + (a->start[k] > 0 ? guard_root(way, k, 0, a->start[k], s, value, g) : 0) * a->path->h;
        return true;
    }
    if (k >= f->chosen || k < f->sides || !field_rank_tells(f))
        return !is_inside(a, s);
    double zero = guard_root(way, k, 0, a->start[k], s, value, g);
    if (!field_falls_along(f, k, &(struct field_way){ a, load }, zero))
        return f->rates && !is_inside(a, s);          /* it may be one of the rates, which ask less there */
    f->lost_pivot = f->fell = k;
    f->fell_t = a->path->t + zero * a->path->h;
    return true;
}

/* False: one of the functions ends the motion at s, where they have these values. */
static bool look(struct along *a, const struct guard_way *way, double s, const double *value, double *g)
{
    struct field *f = a->f;
    bool goes_on = true;
    for (int k = 0; k < f->guards && goes_on; k++) {
        bool border = ends_domain(f, k), beyond = border ? value[k] < 0 && s < 1 /* where the field has told */ : value[k] * a->start[k] < 0;
        if (a->free[k] || !beyond)
            continue;
        a->free[k] = 1;
        goes_on = !ends(a, way, k, s, value[k], g);
    }
    if (goes_on)
        return true;
    f->rank_lost = f->lost_pivot >= 0 && f->lost_pole < 0;
    f->contradiction = false;
    return false;
}

/* Values and rates (by the part of the step) at an end. */
static void at_end(struct along *a, bool last, double *value, double *rate)
{
    struct field *f = a->f;
    const struct ode_path *p = a->path;
    const double *slope = last ? p->f1 : p->f0;
    double step = last ? -PROBE : PROBE;
    at(a, last, value);
    if (slope) {
        for (int j = 0; j < f->n; j++)
            f->in[j] += step * p->h * slope[j];
        f->in[f->n] += step * p->h;
        num_tape_eval(f->guard, f->in, rate);
    } else {
        at(a, last + step, rate);
    }
    for (int k = 0; k < f->guards; k++)
        rate[k] = (rate[k] - value[k]) / step;
}

/* The largest rate on the way, as far as the ends tell. */
static double speed(const struct along *a, int k)
{
    return fabs(a->last[k] - a->start[k]) + 0.5 * (fabs(a->rate[k]) + fabs(a->last_rate[k]));
}

static double nearest(const struct along *a, int k)
{
    return a->start[k] * a->last[k] > 0 ? sga_smaller(fabs(a->start[k]), fabs(a->last[k])) : 0;
}

/* Part of the step that may pass with this motion before anything is near; 0: something may be near in this one, or changes its sign. */
static double calm(const struct along *a)
{
    double part = CALM_STEPS;
    for (int k = 0; k < a->f->guards; k++) {
        double least = nearest(a, k), most = speed(a, k);
        if (!a->free[k] && isfinite(most) && !(least > most))
            return 0;
        if (most > 0)
            part = sga_smaller(part, CALM_PART * least / most);
    }
    return part;
}

/* The cubic through the values and rates at both ends is start + rate s + bend s^2 + twist s^3. */
struct cubic { double start, rate, bend, twist; };

static double cubic_at(const struct cubic *c, double s) { return c->start + s * (c->rate + s * (c->bend + s * c->twist)); }

static struct cubic cubic_of(const struct along *a, int k)
{
    double way = a->last[k] - a->start[k], r0 = a->rate[k], r1 = a->last_rate[k];
    return (struct cubic){ a->start[k], r0, 3 * way - 2 * r0 - r1, r0 + r1 - 2 * way };
}

/* The least of side times the cubic between 0 and 1. */
static double cubic_least(const struct cubic *c, double side)
{
    double least = sga_smaller(side * c->start, side * cubic_at(c, 1)), root = c->bend * c->bend - 3 * c->twist * c->rate;
    if (root < 0)
        return least;
    double q = -c->bend - copysign(sqrt(root), c->bend), place[2] = { q / (3 * c->twist), c->rate / q };
    for (int i = 0; i < 2; i++)
        if (place[i] > 0 && place[i] < 1)
            least = sga_smaller(least, side * cubic_at(c, place[i]));
    return least;
}

/* Every function that has one sign at both ends is the cubic of its values and rates there, more or less, and that does not come near 0. value: at INSIDE. */
static bool plain(const struct along *a, const double *value)
{
    bool ok = true;
    for (int k = 0; k < a->f->guards && ok; k++) {
        if (a->free[k] || !isfinite(speed(a, k)))
            continue;
        struct cubic c = cubic_of(a, k);
        double least = nearest(a, k);
        ok = cubic_least(&c, a->start[k] < 0 ? -1 : 1) > DIP * least && fabs(value[k] - cubic_at(&c, INSIDE)) < WILD * least;
    }
    return ok;
}

static bool tabulated(struct along *a, const struct guard_way *way)
{
    struct guard_table t;
    bool ok = true;
    guard_table_init(&t, way->count);
    guard_table_fill(&t, way);
    guard_table_monotone(&t, way);
    for (int i = 1; i < t.nodes && ok; i++)       /* in their order: of several zeros the first is asked */
        ok = look(a, way, t.theta[i], t.value + (size_t)i * (size_t)t.count, t.g);
    guard_table_clear(&t);
    return ok;
}

/* Whether the step goes on; *quiet: the part of it that the next ones need no look for. */
static bool goes_on(struct along *a, double *g, double *quiet)
{
    struct field *f = a->f;
    const struct ode_path *p = a->path;
    double end = fabs(p->t) + fabs(p->h);
    struct guard_way way = { .count = f->guards, .at = at, .of = a, .grain = 2 * DBL_EPSILON * end / fabs(p->h) };
    *quiet = 0;
    for (int k = 0; k < f->guards; k++)       /* on it, or beyond the end of a domain by roundings */
        a->free[k] = ends_domain(f, k) ? a->start[k] < 0 : a->start[k] == 0;
    *quiet = calm(a);
    bool longer = fabs(p->h) > LONGER * f->along_h;
    if (*quiet > 0 && !longer)
        return true;
    if (p->ready && !p->ready(p->march)) {
        f->rank_lost = f->contradiction = false;
        return false;
    }
    at(a, INSIDE, g);
    return (!longer && plain(a, g)) || tabulated(a, &way);
}

bool field_along(struct field *f, const struct ode_path *path)
{
    size_t n = (size_t)f->n, c = (size_t)f->guards, watched = (size_t)(f->pivots + f->poles);
    if (!c)
        return true;
    assert(fabs(path->t - f->home_t) <= 8 * DBL_EPSILON * fabs(path->t));       /* what is known is of the begin of the step */
    double end = path->t + path->h, size = fabs(path->h);
    if (fabs(end - f->along_t) <= f->along_calm && size <= LONGER * f->along_h)
        return true;
    double *work = sga_malloc((n + n + 1 + watched + 5 * c) * sizeof *work), *kept = work + n, *start = kept + n + 1 + watched, quiet;
    struct along a = { .f = f, .path = path, .x = work, .start = start, .rate = start + c, .last = start + 2 * c, .last_rate = start + 3 * c,
                       .free = sga_calloc(c, 1) };
    memcpy(kept, f->here, n * sizeof *kept);       /* the end of the step was found well: what is known of it stays */
    kept[n] = f->here_t;
    memcpy(kept + n + 1, f->pivot_side, (size_t)f->pivots * sizeof *kept);
    memcpy(kept + n + 1 + f->pivots, f->pole_side, (size_t)f->poles * sizeof *kept);
    if (f->home_t == f->along_t && f->along_h > 0) {
        memcpy(a.start, f->along, c * sizeof *a.start);
        for (size_t k = 0; k < c; k++)
            a.rate[k] = f->along[c + k] * path->h;
    } else {
        at_end(&a, false, a.start, a.rate);
    }
    at_end(&a, true, a.last, a.last_rate);
    bool ok = goes_on(&a, start + 4 * c, &quiet);
    f->along_t = ok ? end : NAN;
    if (ok) {
        memcpy(f->along, a.last, c * sizeof *a.last);
        for (size_t k = 0; k < c; k++)
            f->along[c + k] = a.last_rate[k] / path->h;
        f->along_h = size;
        f->along_calm = quiet * size;
        memcpy(f->here, kept, n * sizeof *kept);
        f->here_t = kept[n];
        memcpy(f->pivot_side, kept + n + 1, (size_t)f->pivots * sizeof *kept);
        memcpy(f->pole_side, kept + n + 1 + f->pivots, (size_t)f->poles * sizeof *kept);
    }
    free(a.free);
    free(work);
    return ok;
}
