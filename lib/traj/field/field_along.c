/* What is watched of the field along a step: pivots, denominators, and the borders of the domains of functions. A step looks at few places, and the motion
 * may pass where a rank drops, a pole or the end of a domain and be back between two of them: nobody saw it. The functions' values and rates at both
 * ends say of most steps that nothing is near; where they do not, the functions are tabulated on the step's polynomial (guard.h), and a place where one of them has
 * another sign than at the begin is asked as any other point of the motion. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "domain_ends.h"
#include "facts.h"
#include "field.h"
#include "guard.h"
#include "larger.h"
#include "mem.h"
#include "ode.h"
#include "system.h"
#include "tape.h"
#include "told.h"

static const double PROBE = 1e-4;      /* of a step: for the rates at its ends */
/* Of a step: no simple fractions, for what comes again and again; one place, or where it is long all of them. */
enum { PLACES = 7 };
static const double INSIDE[PLACES] = { 0.38, 0.11, 0.23, 0.49, 0.62, 0.77, 0.89 };
static const double LONGER = 1.5;      /* than the step before: what varies in it need not show at its ends (a whole period). */
static const double CALM_STEPS = 3;    /* After one in which nothing was near so many need no look, */
static const double CALM_PART = 0.2;   /* and no more than this part of the way to a zero at the largest rate */

struct along {
    struct field *f;
    const struct ode_path *path;
    double *x, *start, *rate, *last, *last_rate;
    unsigned char *free;               /* by function: its zeros end nothing in this step */
};

/* Those whose sign is settled by their shape do not change it. */
static void add_poles(const struct field *f, struct field_list *l)
{
    struct expr_facts facts;
    expr_facts_init(&facts);
    for (int q = 0; q < f->poles; q++)
        if (!(expr_facts_of(&facts, f->sys->store, f->pole_expr[q]) & (EXPR_NONZERO | EXPR_NONNEGATIVE | EXPR_NONPOSITIVE)))
            field_list_add(l, f->pole_expr[q]);
    expr_facts_clear(&facts);
}

bool field_guards_init(struct field *f, struct sga_error *err)
{
    struct field_list l = { 0 };
    f->guard_pivots = f->whole ? 0 : f->chosen;      /* rows as they stand divide by none */
    for (int q = 0; q < f->guard_pivots; q++)
        field_list_add(&l, f->pivot_expr[q]);
    if (!f->whole)
        add_poles(f, &l);
    f->guard_ends = l.count;
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
        f->along = sga_calloc(7 * (size_t)f->guards + (size_t)f->n, sizeof *f->along);
        f->along_free = sga_calloc((size_t)f->guards, 1);
        ok = f->guard != NULL;
        free(inputs);
    }
    f->guard_expr = l.e;
    return ok;
}

void field_guards_forget(struct field *f)
{
    num_tape_free(f->guard);
    free(f->guard_expr);
    free(f->along);
    free(f->along_free);
    f->guard = NULL;
    f->guard_expr = NULL;
    f->along = NULL;
    f->along_free = NULL;
    f->guards = 0;
}

/* Function k is 0 at the end of a domain, and not negative inside. */
static bool ends_domain(const struct field *f, int k) { return k >= f->guard_ends; }

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

/* Of function k at s, by what is added up in it: x^2 - 2 x + 1 is not negative anywhere. */
static double rounding(struct along *a, int k, double s)
{
    static const double TIMES = 4;
    struct told_place told;
    load(a->f, &(struct field_way){ a, load }, s);
    told_begin(&told, a->f->sys, NULL, a->f->in);
    double most = TIMES * told_rounding(&told, a->f->guard_expr[k]);
    told_end(&told);
    return most;
}

/* Function k has another sign at s than at the begin: does that end the motion? */
static bool ends(struct along *a, const struct guard_way *way, int k, double s, double value, double *g)
{
    struct field *f = a->f;
    f->lost_pivot = f->lost_pole = -1;
    f->rank_lost = false;
    if (ends_domain(f, k)) {
        if (!(fabs(value) > doubt(a, k, s, g) && fabs(value) > rounding(a, k, s)))
            return false;
        f->border = k;
        f->border_t = a->path->t + (a->start[k] > 0 ? guard_root(way, k, 0, a->start[k], s, value, g) : 0) * a->path->h;
        return true;
    }
    if (k >= f->guard_pivots || k < f->sides || !field_rank_tells(f))
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
        if (a->free[k])
            continue;
        if (isfinite(most) && !(least > most))
            return 0;
        if (most > 0)
            part = sga_smaller(part, CALM_PART * least / most);
    }
    return part;
}

/* Every function that has one sign at both ends stays there, as far as these and values inside tell. g: work. */
static bool plain(struct along *a, int places, double *g)
{
    bool ok = true;
    for (int i = 0; i < places && ok; i++) {
        at(a, INSIDE[i], g);
        for (int k = 0; k < a->f->guards && ok; k++) {
            struct guard_ends e = { a->start[k], a->rate[k], a->last[k], a->last_rate[k] };
            ok = a->free[k] || !isfinite(speed(a, k)) || ((i > 0 || guard_stays(&e)) && guard_fits(&e, INSIDE[i], g[k]));
        }
    }
    return ok;
}

/* What roundings of the state change the functions by, at the step's end. g: work. */
static void find_noise(struct along *a, double *noise, double *g)
{
    struct field *f = a->f;
    at(a, 1, g);
    memset(noise, 0, (size_t)f->guards * sizeof *noise);
    for (int j = 0; j < f->n; j++) {
        double keep = f->in[j];
        f->in[j] += 2 * DBL_EPSILON * fabs(keep);
        num_tape_eval(f->guard, f->in, g);
        for (int k = 0; k < f->guards; k++)
            noise[k] += isfinite(g[k]) ? fabs(g[k] - a->last[k]) : 0;
        f->in[j] = keep;
    }
}

static bool tabulated(struct along *a, struct guard_way *way)
{
    struct guard_table t;
    bool ok = true;
    guard_table_init(&t, way->count);
    SGA_FREED double *noise = sga_malloc((size_t)way->count * sizeof *noise);
    find_noise(a, noise, t.g);
    way->noise = noise;
    guard_table_fill(&t, way);
    guard_table_monotone(&t, way);
    for (int i = 1; i < t.nodes && ok; i++)       /* in their order: of several zeros the first is asked */
        ok = look(a, way, t.theta[i], t.value + (size_t)i * (size_t)t.count, t.g);
    guard_table_clear(&t);
    return ok;
}

/* The end of the step was found well: what is known of it stays where nothing ends the motion before. */
static bool asked(struct along *a, struct guard_way *way)
{
    struct field *f = a->f;
    size_t n = (size_t)f->n, pivots = (size_t)f->pivots, poles = (size_t)f->poles;
    double t = f->here_t, *kept = sga_malloc((n + pivots + poles + 1) * sizeof *kept);
    memcpy(kept, f->here, n * sizeof *kept);
    sga_copy(kept + n, f->pivot_side, f->pivots);
    sga_copy(kept + n + pivots, f->pole_side, f->poles);
    bool ok = tabulated(a, way);
    if (ok) {
        memcpy(f->here, kept, n * sizeof *kept);
        f->here_t = t;
        sga_copy(f->pivot_side, kept + n, f->pivots);
        sga_copy(f->pole_side, kept + n + pivots, f->poles);
    }
    free(kept);
    return ok;
}

/* The velocity is another one at the step's end, by as much as is hardly an error of so short a step. */
static bool turns(const struct along *a)
{
    static const double TURNED = 0.2, HARDLY = 4;
    const struct ode_path *p = a->path;
    double change = 0, size = 0;
    for (int j = 0; j < a->f->n; j++) {
        double unit = p->error(p->march, j);
        change = sga_larger(change, fabs(p->f1[j] - p->f0[j]) / unit);
        size = sga_larger(size, sga_larger(fabs(p->f0[j]), fabs(p->f1[j])) / unit);
    }
    return change > TURNED * size && change * fabs(p->h) <= HARDLY;
}

/* A pivot falls towards 0 by its rate at the begin, and rises from there by that at the end, and the velocity turns meanwhile: a step that is shorter than the errors
 * allowed may have changed to another branch of the constraints, which meet where it is 0. Shorter ones tell. Such a pivot, or -1. */
static int bounces(const struct along *a)
{
    static const double NEAR = 0.5;    /* of the lesser value: where lines from both ends meet; errors are in them */
    int found = -1;
    if (!a->path->f0 || !a->path->f1 || a->path->stages)
        return -1;
    for (int k = 0; k < a->f->guard_pivots; k++) {
        double side = a->start[k] > 0 ? 1 : -1, begin = side * a->start[k], end = side * a->last[k], down = side * a->rate[k], up = side * a->last_rate[k];
        if (!a->free[k] && end > 0 && down < 0 && up > 0 && begin + down * ((up + begin - end) / (up - down)) <= NEAR * sga_smaller(begin, end))
            found = k;
    }
    return found >= 0 && turns(a) ? found : -1;
}

/* Whether the step goes on; *quiet: the part of it that the next ones need no look for. */
static bool goes_on(struct along *a, double *g, double *quiet)
{
    struct field *f = a->f;
    const struct ode_path *p = a->path;
    double end = fabs(p->t) + fabs(p->h);
    struct guard_way way = { .count = f->guards, .at = at, .from_end = true, .of = a, .budget = p->budget, .grain = 2 * DBL_EPSILON * end / fabs(p->h) };
    *quiet = 0;
    for (int k = 0; k < f->guards; k++)       /* seen; on it, or beyond the end of a domain by roundings */
        a->free[k] = (p->stages && k < f->guard_pivots) || (ends_domain(f, k) ? a->start[k] < 0 : a->start[k] == 0);
    int bounced = bounces(a);
    if (bounced >= 0) {
        f->lost_pivot = bounced;
        f->rank_lost = true;
        f->contradiction = false;
        return false;
    }
    *quiet = calm(a);
    bool longer = !p->stages && fabs(p->h) > LONGER * f->along_h;
    if (*quiet > 0 && !longer)
        return true;
    if (p->ready && !p->ready(p->march)) {
        f->rank_lost = f->contradiction = false;
        return false;
    }
    return plain(a, longer ? PLACES : 1, g) || asked(a, &way);
}

int field_border_ahead(struct field *f, double t, double near)
{
    static const double BACK = 1e-6;           /* of the way made: the rates are differences */
    size_t n = (size_t)f->n, c = (size_t)f->guards;
    double back = BACK * (f->home_t - f->begin_t), best = near;
    int found = -1;
    if (f->guard_ends == f->guards || back == 0)
        return -1;
    SGA_FREED double *v = sga_malloc((n + 2 * c + 1) * sizeof *v);
    double *g = v + n, *before = g + c;
    if (!field_eval(f, f->home_t, f->home, v))
        return -1;
    field_load(f, f->home_t, f->home);
    num_tape_eval(f->guard, f->in, g);
    for (size_t j = 0; j < n; j++)
        f->in[j] -= back * v[j];
    f->in[n] -= back;
    num_tape_eval(f->guard, f->in, before);
    for (int k = f->guard_ends; k < f->guards; k++) {
        double zero = f->home_t + back * g[k] / (before[k] - g[k]), apart = fabs(zero - t);
        if (before[k] > g[k] && apart <= best) {
            best = apart;
            found = k;
        }
    }
    return found;
}

void field_along_anew(struct field *f)
{
    f->along_t = NAN;
    f->along_h = f->along_calm = 0;
}

bool field_along(struct field *f, const struct ode_path *path)
{
    size_t c = (size_t)f->guards;
    if (!c || (path->stages && f->guards == f->guard_pivots))
        return true;
    assert(fabs(path->t - f->home_t) <= 8 * DBL_EPSILON * fabs(path->t));       /* what is known is of the begin of the step */
    double end = path->t + path->h, size = fabs(path->h), quiet, *room = f->along + 2 * c;
    if (fabs(end - f->along_t) <= f->along_calm && size <= LONGER * f->along_h && f->along_stages == path->stages)
        return true;
    struct along a = { .f = f, .path = path, .start = room, .rate = room + c, .last = room + 2 * c, .last_rate = room + 3 * c, .x = room + 5 * c, .free = f->along_free };
    if (f->home_t == f->along_t && f->along_h > 0) {
        sga_copy(a.start, f->along, f->guards);
        for (size_t k = 0; k < c; k++)
            a.rate[k] = f->along[c + k] * path->h;
    } else {
        at_end(&a, false, a.start, a.rate);
    }
    at_end(&a, true, a.last, a.last_rate);
    bool ok = goes_on(&a, room + 4 * c, &quiet);
    f->along_t = ok ? end : NAN;
    if (ok) {
        sga_copy(f->along, a.last, f->guards);
        for (size_t k = 0; k < c; k++)
            f->along[c + k] = a.last_rate[k] / path->h;
        f->along_h = size;
        f->along_stages = path->stages;
        f->along_calm = quiet * size;
    }
    return ok;
}
