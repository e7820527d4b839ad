/* Paths on which all constraints grow smaller together. */
#include "davidenko.h"

#include <math.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "differentials.h"
#include "normal.h"
#include "points_space.h"

enum { FEW = 40, STEPS = 300, STEPS_LARGE = 100, CORRECTIONS = 4, RANGE = 1000 };
/* The first piece of the path, and the shortest; how much shorter each step must become; what is near enough, in units. */
static const double FIRST = 0.25, SHORTEST = 1e-4, SHORTER = 0.25, NEAR = 1e-3;
/* A path that leads so much farther out than it began leads to where the constraints are 0 at infinity only. */
static const double FAR_OUT = 1e3;

struct path {
    struct points_jacobian *j;
    struct points_point *p;
    const int *scale;          /* of the variables: powers of 2, or NULL */
    struct normal w;
    double *value;             /* of the constraints at the start */
    double *r, *d, *here;      /* by constraint; by variable */
    int left;                  /* steps */
};

/* The point's largest variable in units, 1 at the least. */
static double size_of(const struct path *a)
{
    double size = 1;
    for (int i = 0; i < a->p->variables; i++)
        size = fmax(size, fabs(a->p->x[i]) * (a->scale ? ldexp(1, -a->scale[i]) : 1));
    return size;
}

/* Largest entry of the step d in units, beside the point's. */
static double length(const struct path *a)
{
    double len = 0;
    for (int i = 0; i < a->p->variables; i++)
        len = fmax(len, fabs(a->d[i]));
    return len / size_of(a);
}

static void place(struct path *a, const double *x)
{
    const struct points_space *s = a->j->space;
    if (x != a->p->x)
        memcpy(a->p->x, x, (size_t)s->variables * sizeof *x);
    for (int i = 0; i < s->variables; i++)
        num_ball_set_d(&a->p->ball, s->variable[i], x[i]);
}

/* The step to where the constraints have this part of their first values; false where they have no value, or are dependent. */
static bool solve(struct path *a, double part)
{
    const struct points_space *s = a->j->space;
    points_jacobian_values(a->j, &a->p->ball);
    for (int i = 0; i < s->constraints; i++)
        if (!arb_is_finite(num_ball_value(&a->p->ball, s->constraint[i])))
            return false;
    points_jacobian_entries(a->j, &a->p->ball);
    for (int i = 0; i < s->constraints; i++) {
        slong e = points_row_exponent(a->j, i, a->scale);
        if (e < -RANGE || e > RANGE)
            return false;
        for (int k = 0; k < a->j->cols[i]; k++) {
            if (!arb_is_finite(a->j->entry[i] + k))
                return false;
            a->w.value[i][k] = points_scaled(a->j->entry[i] + k, e - (a->scale ? a->scale[a->j->col[i][k]] : 0));
        }
        double value = arf_get_d(arb_midref(num_ball_value(&a->p->ball, s->constraint[i])), ARF_RND_NEAR);
        a->r[i] = ldexp(value - part * a->value[i], (int)-e);
        if (!isfinite(a->r[i]))
            return false;
    }
    return normal_step(&a->w, a->r, a->d) == s->constraints;
}

/* To the place with this part of the first values, near the present one. */
static bool meet(struct path *a, double part)
{
    double before = INFINITY;
    long *all = a->j->space->steps;          /* of the whole search */
    for (int k = 0; k < CORRECTIONS && a->left-- > 0 && (!all || (*all)-- > 0); k++) {
        if (!solve(a, part))
            return false;
        double len = length(a);
        if (!(len <= 1) || len > SHORTER * before)
            return false;
        for (int i = 0; i < a->p->variables; i++)
            a->p->x[i] += a->scale ? ldexp(a->d[i], a->scale[i]) : a->d[i];
        place(a, a->p->x);
        if (len < NEAR)
            return true;
        before = len;
    }
    return false;
}

static bool values_at_start(struct path *a)
{
    const struct points_space *s = a->j->space;
    points_jacobian_values(a->j, &a->p->ball);
    bool finite = true;
    for (int i = 0; i < s->constraints && finite; i++) {
        arb_srcptr v = num_ball_value(&a->p->ball, s->constraint[i]);
        finite = arb_is_finite(v);
        a->value[i] = finite ? arf_get_d(arb_midref(v), ARF_RND_NEAR) : 0;
        finite = finite && isfinite(a->value[i]);
    }
    return finite;
}

void points_follow(struct points_jacobian *j, struct points_point *p)
{
    const struct points_space *s = j->space;
    SGA_ARENA(mem);
    struct path a = { .j = j, .p = p, .scale = p->scaled ? s->scale : NULL, .left = s->constraints > FEW ? STEPS_LARGE : STEPS };
    size_t c = (size_t)s->constraints, n = (size_t)s->variables;
    a.value = sga_take(&mem, (c + 1) * sizeof *a.value);
    a.r = sga_take(&mem, (c + 1) * sizeof *a.r);
    a.d = sga_take(&mem, (n + 1) * sizeof *a.d);
    a.here = sga_take(&mem, 2 * (n + 1) * sizeof *a.here);
    normal_init(&a.w, s->constraints, s->variables, j->col, j->cols);
    double part = 1, piece = FIRST, far = FAR_OUT * size_of(&a), *start = memcpy(a.here + n + 1, p->x, n * sizeof *start);
    bool on = values_at_start(&a);
    while (on && part > 0 && piece >= SHORTEST && a.left > 0 && size_of(&a) < far && sga_budget_ok(s->budget, NULL)) {
        memcpy(a.here, p->x, n * sizeof *a.here);
        double next = fmax(0, part - piece);
        if (meet(&a, next)) {
            part = next;
            piece *= 2;
        } else {
            place(&a, a.here);
            piece /= 2;
        }
    }
    if (part > 0 || size_of(&a) >= far)
        place(&a, start);
    normal_clear(&a.w);
}
