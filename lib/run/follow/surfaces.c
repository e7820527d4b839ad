/* Surfaces of switches, told apart by the values of their functions. */
#include "surfaces.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "error.h"
#include "mem.h"
#include "poly.h"
#include "reduction.h"
#include "system.h"
#include "tape.h"

/* Points at which functions are compared; ratios that are one. */
enum { POINTS = 5 };
static const double ALIKE = 1e-11;

/* 1 by switch that may jump: sign, and abs under a line of division. */
static void find_jumping(const struct surfaces *s, const expr_id *root, int roots, unsigned char *jumps)
{
    const struct expr_store *st = s->sys->store;
    struct expr_cone all, below;
    expr_cone_init(&all);
    expr_cone_init(&below);
    expr_cone_of(st, &all, root, roots);
    for (int i = 0; i < all.count; i++) {
        expr_id e = all.list[i], divisor = expr_divisor(st, e);
        if (expr_op_of(st, e) == EXPR_SIGN && e < s->w.nodes && s->w.of[e] >= 0)
            jumps[s->w.of[e]] = 1;
        if (!divisor)
            continue;
        expr_cone_of(st, &below, &divisor, 1);
        for (int k = 0; k < below.count; k++)
            if (expr_op_of(st, below.list[k]) == EXPR_ABS && below.list[k] < s->w.nodes && s->w.of[below.list[k]] >= 0)
                jumps[s->w.of[below.list[k]]] = 1;
    }
    expr_cone_clear(&all);
    expr_cone_clear(&below);
}

/* Values of all arguments at POINTS points, and then at one on the constraints, if there is one (argument by argument), malloced; NULL: not all symbols have values. */
static double *values_of(const struct surfaces *s, const struct surfaces_every *every)
{
    const struct sys_system *sys = s->sys;
    struct sga_error ignored = { 0 };
    int n = sys->variables, count = s->w.count;
    SGA_FREED int *inputs = sga_malloc(((size_t)n + 1) * sizeof *inputs);
    for (int k = 0; k < n; k++)
        inputs[k] = sys->variable[k].symbol;
    inputs[n] = sys->time;
    struct num_tape *tape = num_tape_new(sys->store, s->w.argument, count, inputs, n + 1, &ignored);
    if (!tape)
        return NULL;
    SGA_FREED double *in = sga_malloc(((size_t)n + 1) * sizeof *in), *out = sga_malloc(((size_t)count + 1) * sizeof *out);
    double *value = sga_malloc(((size_t)count * (POINTS + 1) + 1) * sizeof *value);
    for (int p = 0; p <= POINTS; p++) {
        bool on = p == POINTS && every && every->x;
        for (int k = 0; k <= n; k++)
            in[k] = on ? k < n ? every->x[k] : every->t : fmod(0.6180339887498949 * (k + 1) + 0.3819660112501051 * (p + 1) * (k + 2), 1) + 0.2 * p - 0.4;
        num_tape_eval(tape, in, out);
        for (int k = 0; k < count; k++)
            value[k * (POINTS + 1) + p] = out[k];
    }
    num_tape_free(tape);
    return value;
}

/* +1, -1: a is that times a positive number times b; 0: it is not. */
static int multiple(const double *value, int a, int b)
{
    double ratio = NAN;
    for (int p = 0; p < POINTS; p++) {
        double q = value[a * (POINTS + 1) + p] / value[b * (POINTS + 1) + p];
        if (!isfinite(q) || q == 0 || (p && fabs(q - ratio) > ALIKE * fabs(ratio)))
            return 0;
        ratio = p ? ratio : q;
    }
    return ratio > 0 ? 1 : -1;
}

/* The same, where the constraints hold. */
static int multiple_on(const struct surfaces *s, const struct surfaces_every *every, const double *value, int a, int b)
{
    if (!every || !every->x || !value)
        return 0;
    SGA_ARENA(mem);
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, every->budget);
    expr_id *given = sga_take(&mem, ((size_t)every->sol->constraints + 1) * sizeof *given);
    for (int i = 0; i < every->sol->constraints; i++)
        given[i] = every->sol->constraint[i].expr;
    double ratio = value[a * (POINTS + 1) + POINTS] / value[b * (POINTS + 1) + POINTS];
    return poly_is_multiple(s->sys->store, s->w.argument[a], s->w.argument[b], ratio, given, every->sol->constraints, &limits);
}

/* The switch's surface among those there are; false: none. */
static bool join(struct surfaces *s, const struct surfaces_every *every, const double *value, const int *first, int k)
{
    for (int i = 0; i < s->count; i++) {
        int sign = s->w.argument[k] == s->function[i] ? 1 : value ? multiple(value, k, first[i]) : 0;
        sign = sign ? sign : multiple_on(s, every, value, k, first[i]);
        if (!sign)
            continue;
        s->of[k] = i;
        s->sign[k] = (signed char)sign;
        return true;
    }
    return false;
}

void surfaces_find(struct surfaces *s, const struct sys_system *sys, const expr_id *beside, int besides, const struct surfaces_every *every, struct sga_arena *mem)
{
    expr_id *root;
    int roots = sys_expressions(sys, &root);
    root = sga_realloc(root, ((size_t)roots + (size_t)sys->restrictions + (size_t)besides + 1) * sizeof *root);
    for (int i = 0; i < sys->restrictions; i++)
        root[roots++] = sys->restriction[i];
    for (int i = 0; i < besides; i++)
        root[roots + i] = beside[i];
    *s = (struct surfaces){ .sys = sys };
    num_switches_find(&s->w, sys->store, root, roots + besides);
    size_t count = (size_t)s->w.count;
    s->function = sga_zeros(mem, count + 1, sizeof *s->function);
    s->of = sga_zeros(mem, count + 1, sizeof *s->of);
    s->sign = sga_zeros(mem, count + 1, sizeof *s->sign);
    SGA_FREED unsigned char *jumps = sga_calloc(count + 1, 1);
    SGA_FREED int *first = sga_calloc(count + 1, sizeof *first);
    SGA_FREED double *value = count ? values_of(s, every) : NULL;
    if (every)
        memset(jumps, 1, count);
    else
        find_jumping(s, root, roots, jumps);
    for (int k = 0; k < s->w.count; k++) {
        s->of[k] = -1;
        if (!jumps[k] || join(s, every, value, first, k))
            continue;
        first[s->count] = k;
        s->function[s->count] = s->w.argument[k];
        s->of[k] = s->count++;
        s->sign[k] = 1;
    }
    for (int k = 0; k < s->w.count; k++)
        if (s->of[k] < 0)
            join(s, every, value, first, k);
    for (int k = 0; k < s->w.count; k++)
        assert(s->of[k] < s->count && (s->of[k] < 0 || s->sign[k]));
    free(root);
}

void surfaces_clear(struct surfaces *s)
{
    num_switches_clear(&s->w);
}

/* A switch's node where the switch has this value. */
static expr_id node_at(struct expr_store *st, expr_id e, expr_id argument, expr_id value, bool swapped)
{
    expr_id a = st->node[e].a, b = st->node[e].b;
    bool up = expr_is_one(st, value), down = expr_is_int(st, value, -1);
    switch (expr_op_of(st, e)) {
    case EXPR_SIGN:
        return value;
    case EXPR_ABS:
        return expr_mul(st, value, a);
    case EXPR_MIN: case EXPR_MAX: {
        bool larger = expr_op_of(st, e) == EXPR_MAX;
        if (up || down)
            return (up != swapped) == larger ? a : b;
        expr_id part = expr_mul(st, value, argument), sum = expr_add(st, a, b);
        return expr_div(st, larger ? expr_add(st, sum, part) : expr_sub(st, sum, part), expr_int(st, 2));
    }
    default:
        return e;
    }
}

/* Whether some switch that has a value is left. */
static bool any_left(const struct surfaces *s, const expr_id *value, const expr_id *e, int count)
{
    struct expr_cone cone;
    bool any = false;
    expr_cone_init(&cone);
    expr_cone_of(s->sys->store, &cone, e, count);
    for (int i = 0; i < cone.count && !any; i++) {
        expr_id node = cone.list[i];
        int k = node < s->w.nodes ? s->w.of[node] : -1;
        any = k >= 0 && s->of[k] >= 0 && value[s->of[k]];
    }
    expr_cone_clear(&cone);
    return any;
}

void surfaces_put(const struct surfaces *s, const expr_id *value, expr_id *e, int count)
{
    struct expr_store *st = s->sys->store;
    SGA_FREED expr_id *at = sga_calloc((size_t)s->w.nodes + 1, sizeof *at);
    for (int node = 0; node < s->w.nodes; node++) {
        int k = s->w.of[node];
        if (k >= 0 && s->of[k] >= 0 && value[s->of[k]])
            at[node] = node_at(st, node, s->w.argument[k], s->sign[k] < 0 ? expr_neg(st, value[s->of[k]]) : value[s->of[k]], s->w.swapped[node]);
    }
    /* what takes their place may hold others in turn */
    while (expr_store_ok(st) && any_left(s, value, e, count)) {
        SGA_FREED expr_id *by = sga_calloc((size_t)st->nodes + 1, sizeof *by);
        memcpy(by, at, (size_t)s->w.nodes * sizeof *by);
        for (int i = 0; i < count; i++)
            if (any_left(s, value, e + i, 1))
                e[i] = expr_replace(st, e[i], by);
    }
}

expr_id surfaces_chord(struct expr_store *st, expr_id e, int symbol)
{
    struct expr_cone cone;
    expr_cone_init(&cone);
    bool bent = expr_depends(st, &cone, expr_diff(st, e, symbol), symbol);
    expr_cone_clear(&cone);
    if (!bent)
        return e;
    SGA_FREED expr_id *map = sga_calloc((size_t)st->symbols + 1, sizeof *map);
    expr_id end[2] = { e, e };
    for (int i = 0; i < 2; i++) {
        map[symbol] = expr_int(st, i ? -1 : 1);
        expr_substitute(st, end + i, 1, map);
    }
    expr_id half = expr_rational(st, 1, 2), sum = expr_add(st, end[0], end[1]), difference = expr_sub(st, end[0], end[1]);
    return expr_mul(st, half, expr_add(st, sum, expr_mul(st, st->symbol[symbol].node, difference)));
}
