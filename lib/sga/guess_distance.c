/* How far a guess is from a branch, in the values that were given. */
#include "regular.h"
#include "regular_options.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "guess.h"
#include "leastnorm.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "system.h"
#include "warnings.h"

/* A move of 1 counts for so much less where no value was given: of what moves by itself, of what follows from it. */
static const double MOVING = 0x1p-10, FOLLOWING = 0x1p-20;
static const double STEP = 0x1p-16;
/* Tangent planes from a guess to a point of the branch, how far that may be against the first of them, and how well its distance settles. */
enum { PLANES = 30 };
static const double FARTHER = 100, SETTLED = 1e-6;
enum { MOST = SGA_MOST_GUESS_DISTANCE };     /* functions, and variables: beyond, each option is measured alone */

/* Functions that are to vanish, with the variables in units of what a move counts for. */
struct measure {
    expr_id *f; int count;
    double *unit, *far;            /* by variable: what a move of 1 is, and what it counts for */
    double *value, *J;             /* by function; and by function and variable */
};

static void add_given(struct state *s, struct measure *m)
{
    const struct sys_system *sys = s->sys;
    for (int i = 0; i < sys->rows; i++)
        if (!sys->row[i].entries && m->count <= MOST)
            m->f[m->count++] = sys->row[i].alpha;
    for (int i = 0; i < sys->restrictions && m->count <= MOST; i++)
        m->f[m->count++] = sys->restriction[i];
}

/* The option's alone, or the given equations too: a union that is asked about is met by the option itself. */
static void functions(struct state *s, const struct regular_option *o, expr_id asked, bool all, struct measure *m)
{
    int n = 0;
    m->f = sga_malloc((size_t)(o->count + MOST + 2) * sizeof *m->f);
    if (all)
        add_given(s, m);
    for (int i = 0; i < m->count; i++)
        if (m->f[i] != asked)
            m->f[n++] = m->f[i];
    for (int i = 0; i < o->count; i++)
        m->f[n + i] = o->out[i];
    m->count = n + o->count;
}

static void units(struct state *s, struct measure *m)
{
    int n = s->sys->variables;
    const unsigned char *given = s->options->near_given;
    SGA_FREED unsigned char *moving = guess_moving(s->sys);
    m->unit = sga_malloc(2 * ((size_t)n + 1) * sizeof *m->unit);
    m->far = m->unit + n + 1;
    for (int j = 0; j < n; j++) {
        m->far[j] = !given || given[j] ? 1 : moving[j] ? MOVING : FOLLOWING;
        m->unit[j] = regular_unit_near(s, j, s->options->near);
    }
}

static bool values(struct state *s, const struct measure *m, struct num_ball *b, double *out)
{
    bool ok = true;
    num_ball_list(b, s->cone.list, s->cone.count);
    for (int i = 0; i < m->count; i++) {
        out[i] = arf_get_d(arb_midref(num_ball_value(b, m->f[i])), ARF_RND_NEAR);
        ok = ok && isfinite(out[i]);
    }
    return ok;
}

/* Values and differences where moves from the guess have come to. */
static bool differences(struct state *s, struct measure *m, const double *move)
{
    int n = s->sys->variables, c = m->count;
    SGA_FREED double *x = sga_malloc(((size_t)n + 1) * sizeof *x);
    for (int j = 0; j < n; j++)
        x[j] = s->options->near[j] + move[j] * m->unit[j] / m->far[j];
    SGA_ENDS(num_ball_clear) struct num_ball b;
    SGA_FREED double *moved = sga_malloc(((size_t)c + 1) * sizeof *moved);
    memset(m->J, 0, (size_t)n * (size_t)c * sizeof *m->J);
    regular_ball(s, x, s->options->near_time, &b);
    expr_cone_of(s->st, &s->cone, m->f, c);
    bool ok = values(s, m, &b, m->value);
    for (int j = 0; j < n && ok; j++) {
        num_ball_set_d(&b, s->variable[j], x[j] + STEP * m->unit[j]);
        bool here = values(s, m, &b, moved);
        num_ball_set_d(&b, s->variable[j], x[j]);
        for (int i = 0; i < c && here; i++)
            m->J[(size_t)i * (size_t)n + (size_t)j] = (moved[i] - m->value[i]) / STEP / m->far[j];
    }
    return ok;
}

/* The least move, to first order around the one before, that meets all of them: to the point of the tangent plane there that is nearest to the guess. */
static double least_move(const struct measure *m, int n, double *move)
{
    SGA_ARENA(mem);
    int c = m->count, *perm = sga_take(&mem, ((size_t)c + 1) * sizeof *perm);
    double *work = sga_take(&mem, (size_t)(c + c * c + n + 1) * sizeof *work), *d = work + c + c * c, sum = 0;
    for (int i = 0; i < c; i++) {
        double size = 0, *row = m->J + (size_t)i * (size_t)n;
        for (int j = 0; j < n; j++) {
            size = fmax(size, fabs(row[j]));
            m->value[i] -= row[j] * move[j];
        }
        for (int j = 0; j < n && size > 0; j++)
            row[j] /= size;
        m->value[i] = size > 0 ? m->value[i] / size : 0;
    }
    points_least_norm(c, n, m->J, m->value, d, perm, work);
    for (int j = 0; j < n; j++) {
        move[j] = d[j];
        sum += d[j] * d[j];
    }
    return sqrt(sum);
}

/* A factor times one that has no zero is as far: planes are followed to where they touch. Where that leads nowhere the first one says it. */
static double nearest(struct state *s, struct measure *m, double *move)
{
    int n = s->sys->variables;
    m->value = sga_calloc(((size_t)n + 1) * ((size_t)m->count + 1), sizeof *m->value);
    m->J = m->value + m->count;
    double first = INFINITY, last = INFINITY;
    for (int k = 0; k < PLANES; k++) {
        if (!differences(s, m, move))
            return first;
        double far = least_move(m, n, move);
        if (k == 0)
            first = far;
        if (!(far < FARTHER * first))
            return first;
        if (fabs(far - last) <= SETTLED * far)
            return far;
        last = far;
    }
    return first;
}

/* NaN: there are too many functions. */
static double measured(struct state *s, const struct regular_option *o, expr_id asked, bool all)
{
    struct measure m = { 0 };
    functions(s, o, asked, all, &m);
    double far = NAN;
    if (m.count <= MOST) {
        SGA_FREED double *move = sga_calloc((size_t)s->sys->variables + 1, sizeof *move);
        units(s, &m);
        far = nearest(s, &m, move);
    }
    free(m.f);
    free(m.unit);
    free(m.value);
    return far;
}

/* Equations may contradict the option to first order, and are left out then: it is as far as alone at the least. */
double guess_distance(struct state *s, const struct regular_option *o, expr_id asked)
{
    if (s->sys->variables > MOST) {
        sga_limit_met(s->options->budget, SGA_LIMIT_GUESS_DISTANCE);
        return regular_option_distance(s, o, s->options->near, s->options->near_time);
    }
    double alone = measured(s, o, asked, false), all = measured(s, o, asked, true);
    if (isnan(alone) || isnan(all))
        sga_limit_met(s->options->budget, SGA_LIMIT_GUESS_DISTANCE);
    if (isnan(alone))
        return regular_option_distance(s, o, s->options->near, s->options->near_time);
    return isnan(all) ? alone : fmax(alone, all);
}

/* In the values that were given. */
static double length(const struct state *s, const double *move)
{
    double sum = 0;
    for (int j = 0; j < s->sys->variables; j++)
        if (!s->options->near_given || s->options->near_given[j])
            sum += move[j] * move[j];
    return sqrt(sum);
}

double guess_distance_of_set(struct state *s)
{
    int n = s->sys->variables;
    if (n > MOST || !s->oracle->reals || s->sol->constraints > MOST)
        return -1;
    struct measure m = { .f = s->con, .count = s->sol->constraints };
    SGA_FREED double *move = sga_calloc((size_t)n + 1, sizeof *move);
    units(s, &m);
    for (int j = 0; j < n; j++)
        move[j] = (s->oracle->real[0].x[j] - s->options->near[j]) / m.unit[j] * m.far[j];
    double far = length(s, move);
    if (m.count && isfinite(nearest(s, &m, move)))
        far = fmin(far, length(s, move));
    free(m.unit);
    free(m.value);
    return far;
}

/* Of the values that were given, and of no others. */
static bool of_given(struct state *s, expr_id f)
{
    bool given = true;
    expr_cone_of(s->st, &s->cone, &f, 1);
    for (int k = 0; k < s->cone.count && given; k++) {
        const struct expr_node *n = s->st->node + s->cone.list[k];
        int j = n->op == EXPR_SYM ? s->column[n->a] : -1;
        given = j < 0 || !s->options->near_given || s->options->near_given[j];
    }
    return given;
}

bool guess_is_off(struct state *s)
{
    static const double OFF = 1e-6;
    for (int i = 0; i < s->sol->constraints && !s->sol->constraint[i].chosen; i++) {
        struct regular_option o = { .out = s->con + i, .count = 1 };
        if (of_given(s, s->con[i]) && regular_option_distance(s, &o, s->options->near, s->options->near_time) > OFF)
            return true;
    }
    return false;
}
