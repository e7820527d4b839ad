/* Zeros of higher order: exact roots of functions of one quantity, and derivatives. */
#include "irregular.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"
#include "system.h"
#include "warnings.h"

enum { LARGEST_CONE = SGA_MOST_IRREGULAR_CONE, MOST_PARTS = 3 };
static const double NEAR_ROOT = 5e-3;

static struct proposal *add(struct proposal **list, int *count, const expr_id *out, int n)
{
    *list = sga_realloc(*list, (size_t)(*count + 1) * sizeof **list);
    struct proposal *p = *list + (*count)++;
    *p = (struct proposal){ .count = n };
    p->out = memcpy(sga_malloc((size_t)(n + 1) * sizeof *out), out, (size_t)n * sizeof *out);
    return p;
}

void irregular_clear(struct proposal *p)
{
    free(p->out);
    free(p->derivative);
    *p = (struct proposal){ 0 };
}

/* e, de/dx, d2e/dx2, ... as far as they stay small; returns how many. */
static int derivatives(struct state *s, expr_id e, int symbol, expr_id d[IRREGULAR_ORDER])
{
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    int n = 0;
    struct poly_limits limits = poly_limits_of(POLY_MODEST, s->options->budget);
    SGA_RESERVE_IN(&s->mem, s->active, s->active_cap, s->st->symbols);
    memset(s->active, 0, (size_t)s->st->symbols);
    s->active[symbol] = 1;
    s->activated = 0;
    d[n++] = e;
    while (n < IRREGULAR_ORDER) {
        if (expr_gradient(s->st, &s->cone, d[n - 1], s->active, &term, &cap) != 1)
            break;
        d[n] = term[0].value;
        poly_normal(s->st, d[n], &limits, d + n);
        expr_cone_of(s->st, &s->cone, d + n, 1);
        if (s->cone.count > LARGEST_CONE) {
            sga_limit_open(s->options->budget, SGA_LIMIT_IRREGULAR_CONE);
            break;
        }
        n++;
    }
    assert(n >= 1 && n <= IRREGULAR_ORDER);
    return n;
}

static void keep_derivatives(struct proposal *p, const expr_id *d, int n)
{
    p->derivatives = n;
    p->derivative = memcpy(sga_malloc((size_t)n * sizeof *d), d, (size_t)n * sizeof *d);
}

/* Whether e depends on symbols through u alone; list is e's cone. */
static bool passes(struct state *s, const struct expr_cone *cone, expr_id e, expr_id u, unsigned char *reached)
{
    memset(reached, 0, (size_t)cone->count);
    reached[cone->place[e]] = 1;
    for (int k = cone->count - 1; k >= 0; k--) {
        expr_id n = cone->list[k];
        if (!reached[k] || n == u)
            continue;
        if (expr_op_of(s->st, n) == EXPR_SYM)
            return false;
        for (int c = 0; c < expr_children(s->st, n); c++)
            reached[cone->place[expr_child(s->st, n, c)]] = 1;
    }
    return true;
}

/* The parts through each of which alone e depends on anything, the largest first: 10 x and x in sin(10 x) - 10 x; e itself if there
 * is none. Returns how many. */
static int quantities(struct state *s, expr_id e, expr_id part[MOST_PARTS])
{
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    int found = 0;
    expr_cone_init(&cone);
    expr_cone_of(s->st, &cone, &e, 1);
    if (cone.count <= LARGEST_CONE) {
        expr_cone_index(&cone);
        SGA_FREED unsigned char *reached = sga_calloc((size_t)cone.count, 1);
        for (int k = cone.count - 1; k >= 0; k--)
            if (cone.list[k] != e && state_facts(s, cone.list[k]) & EXPR_HAS_VARIABLE && passes(s, &cone, e, cone.list[k], reached)) {
                if (found == MOST_PARTS)
                    memmove(part, part + 1, (MOST_PARTS - 1) * sizeof *part);
                part[found < MOST_PARTS ? found++ : MOST_PARTS - 1] = cone.list[k];
            }
    }
    if (!found)
        part[found++] = e;
    return found;
}

/* The smallest of them. */
static expr_id quantity(struct state *s, expr_id e)
{
    expr_id part[MOST_PARTS];
    return part[quantities(s, e, part) - 1];
}

/* The largest of what u's variables add to it near x: what a difference of large terms is small beside. */
static double terms_of(struct state *s, expr_id u, double v, const double *x, double t)
{
    static const double STEP = 0x1p-16;
    int n = s->sys->variables;
    double most = 0;
    SGA_FREED double *y = memcpy(sga_malloc((size_t)(n + 1) * sizeof *y), x, (size_t)n * sizeof *y);
    for (int j = 0; j < n; j++) {
        y[j] = x[j] * (1 + STEP);
        double d = x[j] != 0 ? fabs(regular_value(s, u, y, t) - v) / STEP : 0;
        most = isfinite(d) ? fmax(most, d) : most;
        y[j] = x[j];
    }
    return most;
}

/* u - r for simple numbers r near u's value at x: what is approached is known roughly,
 * since zeros of high order attract slowly. d: the derivatives that are to tell. */
static void simple_roots(struct state *s, expr_id u, const expr_id *d, int n, bool exact, const double *x, double t,
                         struct proposal **list, int *count)
{
    enum { ROOTS = 4 };
    double v = regular_value(s, u, x, t);
    if (isfinite(v) && fabs(v) < NEAR_ROOT * terms_of(s, u, v, x, t))
        v = 0;
    for (int turn = 0; turn < 2 && isfinite(v) && fabs(v) < 1e6; turn++) {
        double unit = turn ? M_PI : 1;
        int tried = 0;
        for (long q = 1; q <= 12 && tried < ROOTS; q++) {
            double p = round(v / unit * (double)q);
            if (fabs(v - p / (double)q * unit) > NEAR_ROOT * (1 + fabs(v)) || (turn && p == 0))
                continue;
            expr_id r = expr_rational(s->st, (long)p, q);
            if (turn)
                r = expr_mul(s->st, r, expr_pi(s->st));
            expr_id f = expr_sub(s->st, u, r);
            struct regular_option o = regular_nearest(s, f, x, t);
            bool known = !o.count;
            for (int k = 0; k < *count && !known; k++)
                known = (*list)[k].out[0] == o.out[0] && (*list)[k].count == o.count && n > 1
                        && (*list)[k].derivatives > 1 && (*list)[k].derivative[1] == d[1];
            if (!known) {
                struct proposal *pr = add(list, count, o.out, o.count);
                keep_derivatives(pr, d, n);
                pr->exact = exact;
                pr->whole = o.count == 1 && o.out[0] == f ? EXPR_UNDEF : f;
                tried++;
            }
            free(o.out);
        }
    }
}

/* Where e is a function of one quantity u: e = 0 where u is a root of it. */
static void exact_roots(struct state *s, expr_id e, const double *x, double t, struct proposal **list, int *count)
{
    enum { VARIABLES = 3 };
    expr_id part[MOST_PARTS], d[IRREGULAR_ORDER];
    int parts = quantities(s, e, part), tried = 0;
    for (int j = 0; j < s->sys->variables && part[0] != e && tried < VARIABLES; j++) {
        int n = derivatives(s, e, s->variable[j], d);
        tried += n > 1;
        for (int k = 0; k < parts && n > 1; k++)
            simple_roots(s, part[k], d, n, true, x, t, list, count);
    }
}

/* The gradient's components that show a definite second derivative, each by the part of it
 * that vanishes at x. */
static void gradient(struct state *s, expr_id e, const double *x, double t, struct proposal **list, int *count)
{
    SGA_FREED expr_id *part = NULL, *out = NULL;
    int parts = regular_by_gradient(s, e, x, t, &part), n = 0;
    size_t cap = 0;
    for (int i = 0; i < parts; i++) {
        struct regular_option o = regular_nearest(s, part[i], x, t);
        for (int k = 0; k < o.count; k++) {
            bool known = false;
            for (int m = 0; m < n; m++)
                known |= out[m] == o.out[k];
            if (known)
                continue;
            SGA_RESERVE(out, cap, n + 1);
            out[n++] = o.out[k];
        }
        free(o.out);
    }
    if (n)
        add(list, count, out, n);
    if (parts)
        add(list, count, part, parts);
}

/* A derivative of e of order m - 1 along one variable, for zeros of order m. */
static void orders(struct state *s, expr_id e, const double *x, double t, struct proposal **list, int *count)
{
    enum { VARIABLES = 6 };
    int tried = 0;
    for (int j = 0; j < s->sys->variables && tried < VARIABLES; j++) {
        expr_id d[IRREGULAR_ORDER];
        int n = derivatives(s, e, s->variable[j], d);
        tried += n > 1;
        for (int m = 2; m < n; m++) {
            struct regular_option o = regular_nearest(s, d[m - 1], x, t);
            if (o.count == 1) {       /* sin(x + y) = 0 near 0 is x + y = 0 there */
                simple_roots(s, quantity(s, o.out[0]), d, n, false, x, t, list, count);
                keep_derivatives(add(list, count, o.out, 1), d, n);
            }
            free(o.out);
        }
    }
}

int irregular_proposals(struct state *s, expr_id e, const double *x, double t, struct proposal **list)
{
    int count = 0;
    *list = NULL;
    exact_roots(s, e, x, t, list, &count);
    gradient(s, e, x, t, list, &count);
    orders(s, e, x, t, list, &count);
    return count;
}
