/* Pivots inside a step. A step of series or of an implicit method looks at few places, and where the motion is a smooth one it may be so long
 * that a pivot changes its sign twice inside of it: the rank dropped there, and nobody saw it. Here each pivot is looked at between the
 * ends, at more places where it bends so much that it may come to 0 between those that are known. */
#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "field.h"
#include "larger.h"
#include "mem.h"
#include "ode.h"
#include "tape.h"

static const double INSIDE = 0.38;     /* of a part: no simple fraction, for what comes again and again */
static const double DIP = 0.5;         /* of its least value: where a pivot is thought to come to less between, it is looked at again; */
static const double WILD = 0.25;       /* of its largest one: and where it is so far from a straight line */
static const double LONGER = 1.5;      /* than the step before: what varies in it may not be seen at three places, */
static const int PARTS = 3;            /* and it is halved so often first */
static const int CALM_STEPS = 3;       /* no longer ones are let pass after one in which no pivot bends */
static const int DEPTH = 6, PLACES = 40;

struct along {
    struct field *f;
    const struct ode_path *path;
    double *x, *start;
    unsigned char *free;               /* by pivot: its zeros end nothing in this step */
    bool bent;                         /* somewhere */
    int parts;                         /* halvings that are made whatever is seen */
    int left;                          /* places that may still be looked at */
};

static void load(struct field *f, const struct field_way *way, double s)
{
    const struct along *a = way->of;
    a->path->at(a->path->march, s, a->x);
    field_load(f, a->path->t + s * a->path->h, a->x);
}

static double pivot_at(struct along *a, int q, double s)
{
    load(a->f, &(struct field_way){ a, load }, s);
    num_tape_eval(a->f->direct, a->f->in, a->f->direct_out);
    return a->f->direct_out[a->f->n + q];
}

/* The field at s says that the motion may be there. */
static bool is_inside(struct along *a, int q, double s)
{
    pivot_at(a, q, s);
    field_forget_trial(a->f);          /* as the motion is at the begin of the step */
    return field_inside(a->f, a->f->in[a->f->n], a->x);
}

/* Pivot q has another sign at the part s than at the begin: does that end the motion? */
static bool ends(struct along *a, int q, double s)
{
    struct field *f = a->f;
    double low = 0, high = s;
    if (q < f->sides || !field_rank_tells(f))
        return !is_inside(a, q, s);
    for (int turn = 0; turn < 50; turn++) {
        double middle = 0.5 * (low + high);
        if (pivot_at(a, q, middle) * a->start[q] > 0)
            low = middle;
        else
            high = middle;
    }
    if (!field_falls_along(f, q, &(struct field_way){ a, load }, high))
        return f->rates && !is_inside(a, q, s);       /* it may be one of the rates, which ask less there */
    f->lost_pivot = f->fell = q;
    f->lost_pole = -1;
    f->fell_t = a->path->t + high * a->path->h;
    return true;
}

/* The pivots at the part s of the way. False: the motion is not continued as far as that. */
static bool look(struct along *a, double s, double *p)
{
    struct field *f = a->f;
    a->left--;
    pivot_at(a, 0, s);
    memcpy(p, f->direct_out + f->n, (size_t)f->chosen * sizeof *p);
    for (int q = 0; q < f->chosen; q++) {
        if (a->free[q] || !(p[q] * a->start[q] < 0))
            continue;
        if (ends(a, q, s)) {
            f->rank_lost = f->lost_pole < 0;
            f->contradiction = false;
            return false;
        }
        a->free[q] = 1;
    }
    return true;
}

/* A function with these values at 0, INSIDE and 1 may come to 0 between. */
static bool bends(double p0, double p, double p1)
{
    double slope = (p - p0) / INSIDE, curve = (p1 - p) / (1 - INSIDE) - slope;      /* p0 + s slope + s (s - INSIDE) curve */
    double off = INSIDE * (1 - INSIDE) * fabs(curve), lowest = curve > 0 ? 0.5 * (INSIDE - slope / curve) : 0;
    if (off > WILD * sga_larger(p0, sga_larger(p, p1)))
        return true;
    return lowest > 0 && lowest < 1 && p0 + lowest * (slope + (lowest - INSIDE) * curve) < DIP * sga_smaller(p0, sga_smaller(p, p1));
}

/* Between s0 and s1, where the pivots are p0 and p1; below p1 there is room for DEPTH more. */
static bool between(struct along *a, double s0, const double *p0, double s1, double *p1, int depth)
{
    double s = s0 + INSIDE * (s1 - s0), *p = p1 + a->f->chosen;
    assert(0 <= s0 && s0 < s && s < s1 && s1 <= 1);
    bool bent = false;
    if (!look(a, s, p))
        return false;
    for (int q = 0; q < a->f->chosen && !bent; q++)
        bent = !a->free[q] && bends(fabs(p0[q]), fabs(p[q]), fabs(p1[q]));
    a->bent |= bent;
    if ((!bent && DEPTH - depth >= a->parts) || depth == 0 || a->left <= 0)
        return true;
    double *mine = p + a->f->chosen;    /* the second half needs p1 at its place, and p before it */
    memcpy(mine, p, (size_t)a->f->chosen * sizeof *mine);
    if (!between(a, s0, p0, s, mine, depth - 1))
        return false;
    memcpy(mine, p1, (size_t)a->f->chosen * sizeof *mine);
    return between(a, s, p, s1, mine, depth - 1);
}

bool field_along(struct field *f, const struct ode_path *path)
{
    size_t n = (size_t)f->n, c = (size_t)f->chosen, watched = (size_t)(f->pivots + f->poles);
    if (!c)
        return true;
    assert(fabs(path->t - f->home_t) <= 8 * DBL_EPSILON * fabs(path->t));       /* the pivots that are known are those of the begin of the step */
    bool longer = fabs(path->h) > LONGER * f->along_h;
    if (!longer && f->along_calm > 0) {
        f->along_calm--;
        return true;
    }
    double *work = sga_malloc((n + n + 1 + watched + (2 * (size_t)DEPTH + 6) * c) * sizeof *work);
    double *kept = work + n, *p0 = kept + n + 1 + watched, *p1 = p0 + c;
    struct along a = { .f = f, .path = path, .x = work, .start = p0, .free = sga_calloc(c, 1), .left = PLACES,
                       .parts = longer ? PARTS : 0 };
    memcpy(kept, f->here, n * sizeof *kept);       /* the end of the step was found well: what is known of it stays */
    kept[n] = f->here_t;
    memcpy(kept + n + 1, f->pivot_side, (size_t)f->pivots * sizeof *kept);
    memcpy(kept + n + 1 + f->pivots, f->pole_side, (size_t)f->poles * sizeof *kept);
    if (f->home_t == f->along_t) {
        memcpy(p0, f->along, c * sizeof *p0);
    } else {
        field_load(f, f->home_t, f->home);
        num_tape_eval(f->direct, f->in, f->direct_out);
        memcpy(p0, f->direct_out + n, c * sizeof *p0);
    }
    bool ok = look(&a, 1, p1);
    memcpy(f->along, p1, c * sizeof *p1);
    f->along_t = ok ? path->t + path->h : NAN;
    ok = ok && between(&a, 0, p0, 1, p1, DEPTH);
    if (ok) {
        f->along_h = fabs(path->h);
        f->along_calm = a.bent || longer ? 0 : CALM_STEPS;
        memcpy(f->here, kept, n * sizeof *kept);
        f->here_t = kept[n];
        memcpy(f->pivot_side, kept + n + 1, (size_t)f->pivots * sizeof *kept);
        memcpy(f->pole_side, kept + n + 1 + f->pivots, (size_t)f->poles * sizeof *kept);
    }
    free(a.free);
    free(work);
    return ok;
}
