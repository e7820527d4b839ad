/* Lists of the ways in which a constraint can vanish. */
#include "regular_options.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "mem.h"
#include "regular.h"
#include "state.h"
#include "system.h"

void regular_ball(struct state *s, const double *x, double t, struct num_ball *b)
{
    num_ball_init(b, s->st, 64);
    for (int i = 0; i < s->sys->parameters; i++)
        num_ball_set_d(b, s->parameter_symbol[i], 1.25);
    for (int j = 0; j < s->sys->variables; j++)
        num_ball_set_d(b, s->variable[j], x[j]);
    num_ball_set_d(b, s->sys->time, t);
}

double regular_value(struct state *s, expr_id f, const double *x, double t)
{
    SGA_ENDS(num_ball_clear) struct num_ball b;
    regular_ball(s, x, t, &b);
    expr_cone_of(s->st, &s->cone, &f, 1);
    num_ball_list(&b, s->cone.list, s->cone.count);
    return arf_get_d(arb_midref(num_ball_value(&b, f)), ARF_RND_NEAR);
}

/* What a move of 1 in variable j means near x: as for the nearest consistent start. */
double regular_unit_near(const struct state *s, int j, const double *x)
{
    double size = s->space.scale ? ldexp(1, s->space.scale[j]) : 1;
    return fmax(size, fabs(x[j]) / 100);
}

/* About how far x is from a zero of f: its value over what moves of 1 change it by. */
static double distance(struct state *s, expr_id f, const double *x, double t)
{
    static const double STEP = 0x1p-16;
    int n = s->sys->variables;
    double v = regular_value(s, f, x, t), slope = 0;
    SGA_FREED double *y = memcpy(sga_malloc((size_t)(n + 1) * sizeof *y), x, (size_t)n * sizeof *y);
    SGA_ENDS(expr_cone_clear) struct expr_cone of;
    expr_cone_init(&of);
    expr_cone_of(s->st, &of, &f, 1);
    for (int i = 0; i < of.count; i++)
        for (int j = 0; j < n && s->st->node[of.list[i]].op == EXPR_SYM; j++)
            if (s->variable[j] == s->st->node[of.list[i]].a) {
                y[j] = x[j] + STEP * regular_unit_near(s, j, x);
                double d = fabs(regular_value(s, f, y, t) - v) / STEP;
                slope = isfinite(d) ? fmax(slope, d) : slope;
                y[j] = x[j];
            }
    return slope > 0 ? fabs(v) / slope : fabs(v);
}

double regular_option_distance(struct state *s, const struct regular_option *o, const double *x, double t)
{
    double far = 0;
    for (int i = 0; i < o->count && isfinite(far); i++) {
        double v = distance(s, o->out[i], x, t);
        far = isfinite(v) ? fmax(far, v) : INFINITY;
    }
    return far;
}

static bool same_option(const struct regular_option *o, const expr_id *out, int count)
{
    bool same = o->count == count;
    for (int i = 0; i < count && same; i++) {
        bool in = false;
        for (int k = 0; k < count; k++)
            in |= o->out[k] == out[i];
        same = in;
    }
    return same;
}

void regular_add(struct regular *r, const expr_id *out, int count)
{
    for (int i = 0; i < r->options; i++)
        if (same_option(r->option + i, out, count))
            return;
    r->option = sga_realloc(r->option, (size_t)(r->options + 1) * sizeof *r->option);
    struct regular_option *o = r->option + r->options++;
    o->count = count;
    o->out = sga_malloc((size_t)(count + 1) * sizeof *out);
    if (count)
        memcpy(o->out, out, (size_t)count * sizeof *out);
}

void regular_add_joined(struct regular *r, const struct regular_option *a, const struct regular_option *b)
{
    int n = 0;
    SGA_FREED expr_id *out = sga_malloc((size_t)(a->count + b->count + 1) * sizeof *out);
    for (int i = 0; i < a->count + b->count; i++) {
        expr_id f = i < a->count ? a->out[i] : b->out[i - a->count];
        bool known = false;
        for (int k = 0; k < n; k++)
            known |= out[k] == f;
        if (!known)
            out[n++] = f;
    }
    regular_add(r, out, n);
}

void regular_move(struct regular *to, struct regular *from)
{
    for (int k = 0; k < from->options; k++)
        regular_add(to, from->option[k].out, from->option[k].count);
    to->seen |= from->seen;
    regular_clear(from);
}

/* Distances from the guess that differ by less, in units, do so by roundings. */
static const double ALIKE = 1e-9;

int regular_sort(struct state *s, expr_id e, struct regular *r)
{
    int alike = 0;
    SGA_FREED double *far = sga_malloc(((size_t)r->options + 1) * sizeof *far);
    for (int i = 0; i < r->options; i++)
        far[i] = s->options->near && r->options > 1 ? guess_distance(s, r->option + i, e) : INFINITY;
    for (int i = 1; i < r->options; i++)
        for (int k = i; k > 0 && far[k] < far[k - 1]; k--) {
            struct regular_option o = r->option[k];
            double d = far[k];
            r->option[k] = r->option[k - 1];
            r->option[k - 1] = o;
            far[k] = far[k - 1];
            far[k - 1] = d;
        }
    while (alike < r->options && isfinite(far[0]) && far[alike] - far[0] < ALIKE)
        alike++;
    return alike;
}

void regular_follow_route(struct state *s, expr_id product, struct regular *r, int alike)
{
    struct route *w = s->route;
    int i = 0, first;
    while (i < w->count && (w->at[i].side || w->at[i].product != product))
        i++;
    if (i == w->count) {
        SGA_RESERVE(w->at, w->cap, w->count + 1);
        w->at[w->count++] = (struct decision){ .product = product, .options = r->options };
    }
    w->at[i].alike = alike;
    if (w->at[i].options < r->options)       /* on a smaller set it falls into more */
        w->at[i].options = r->options;
    first = w->at[i].chosen < r->options ? w->at[i].chosen : 0;
    for (; first > 0; first--) {
        struct regular_option o = r->option[0];
        memmove(r->option, r->option + 1, (size_t)(r->options - 1) * sizeof o);
        r->option[r->options - 1] = o;
    }
}

bool regular_sane(const struct regular *r)
{
    bool sane = r->answer != REGULAR_NEVER || !r->options;
    for (int i = 0; i < r->options && sane; i++)
        sane = r->option[i].count > 0;
    return sane;
}

void regular_clear(struct regular *r)
{
    for (int i = 0; i < r->options; i++)
        free(r->option[i].out);
    free(r->option);
    *r = (struct regular){ 0 };
}
