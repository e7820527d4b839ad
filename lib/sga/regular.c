/* Regular forms of constraints, by shape and by factors. */
#include "regular.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alike.h"
#include "arena.h"
#include "at_start.h"
#include "domain.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"
#include "regular_options.h"
#include "regular_shape.h"
#include "take_apart.h"
#include "warnings.h"

enum { DEPTH = SGA_MOST_REGULAR_DEPTH };

static struct regular form_at(struct state *s, expr_id e, int depth);

/* Functions that vanish together, each in its regular form: the ways in which they can. No
 * option comes out where one of them never vanishes. */
static struct regular together(struct state *s, const expr_id *f, int count, int depth)
{
    struct regular all = { .answer = REGULAR_REPLACED };
    regular_add(&all, NULL, 0);
    for (int i = 0; i < count && all.options; i++) {
        struct regular own = form_at(s, f[i], depth + 1), next = { .answer = REGULAR_REPLACED };
        if (own.options * all.options > SGA_MOST_REGULAR_WAYS) {     /* too many: left as it is */
            sga_limit_met(s->options->budget, SGA_LIMIT_REGULAR_WAYS);
            regular_clear(&own);
            regular_add(&own, f + i, 1);
        }
        for (int k = 0; k < all.options; k++)
            for (int m = 0; m < own.options; m++)
                regular_add_joined(&next, all.option + k, own.option + m);
        next.seen = all.seen || own.seen;
        regular_clear(&all);
        regular_clear(&own);
        all = next;
    }
    return all;
}

/* A factor in parameters only is taken as not zero, and that is remembered. */
static void assume(struct state *s, expr_id factor)
{
    for (int i = 0; i < s->assumptions; i++)
        if (s->assumed[i] == factor)
            return;
    SGA_RESERVE_IN(&s->mem, s->assumed, s->assumed_cap, s->assumptions + 1);
    s->assumed[s->assumptions++] = factor;
}

/* Whether the factor, a sum of squares, asks for a relation between parameters: it is taken as not there. */
static bool asks_parameters(struct state *s, const struct poly_factor *q)
{
    expr_id sum = expr_int(s->st, 0);
    int asked = 0, last = -1;
    for (int k = 0; k < q->radicals; k++)
        if (!(state_facts(s, q->radical[k]) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME))) {
            sum = expr_add(s->st, sum, expr_powi(s->st, q->radical[k], 2));
            last = k;
            asked++;
        }
    if (asked)
        assume(s, asked == 1 ? q->radical[last] : sum);
    return asked > 0;
}

/* A factor matters if it depends on variables or time, may vanish, and does not keep one
 * value, not zero, all over the present set (then *seen is set). */
static bool matters(struct state *s, const struct poly_factor *q, int factors, bool *seen)
{
    if (q->never_zero || !(q->depends & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)))
        return false;
    if (asks_parameters(s, q))
        return false;
    if (factors == 1 || !s->sol->constraints || !(q->depends & EXPR_HAS_VARIABLE))      /* at instants only, whatever stands */
        return true;
    bool dropped = ech_zero(&s->ctx, q->expr) == 0 && state_locally_constant(s, q->expr);
    *seen |= dropped;
    return !dropped;
}

/* What f = 0 says of its parts, where that is more than f itself: true, with the options. */
static bool by_ends(struct state *s, expr_id f, int depth, struct regular *r)
{
    SGA_ENDS(take_apart_clear) struct take_apart e = take_apart_of(s, f);
    bool changed = e.changed;
    for (int i = 0; i < e.options; i++)
        changed = changed && e.option[i].count > 0;
    for (int i = 0; i < e.options && changed; i++) {
        struct regular sub = together(s, e.option[i].out, e.option[i].count, depth);
        regular_move(r, &sub);
    }
    return changed;
}

/* Whether e divides by what is 0 where a motion is to start, so that it has no value there. */
static bool divides_at_start(struct state *s, expr_id e)
{
    if (!s->ctx.near || !regular_has_poles(s, e))
        return false;
    SGA_ENDS(at_start_clear) struct at_start start;
    bool any = false;
    at_start_init(&start, &s->ctx);
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count && !any; k++) {
        expr_id below = expr_divisor(s->st, s->cone.list[k]);
        any = below && !expr_is_const(s->st, below) && at_start_vanishes(&start, &s->ctx, below);
    }
    return any;
}

/* The factors that matter are the branches. */
static void from_factors(struct state *s, expr_id e, struct regular *r, const struct poly_factors *f, int depth)
{
    bool plain = true;       /* one simple factor, nothing else dropped */
    for (int i = 0; i < f->factors; i++) {
        const struct poly_factor *q = f->factor + i;
        bool in = matters(s, q, f->factors, &r->seen);
        if (in && !q->irreducible)
            sga_limit_met(s->options->budget, f->longest > SGA_MOST_FACTORED_FULLY ? SGA_LIMIT_FACTORED_FULLY : SGA_LIMIT_FACTORED_DEGREE);
        plain &= in && q->multiplicity == 1;
        if (!q->never_zero && q->depends == EXPR_HAS_PARAMETER)
            assume(s, q->expr);
        if (!in)
            continue;
        if (q->sum_of_even_powers && q->radicals > 0) {
            plain = false;
            struct regular sub = together(s, q->radical, q->radicals, depth);
            regular_move(r, &sub);
        } else if (depth < DEPTH && by_ends(s, q->expr, depth, r)) {
            plain = false;
        } else {
            regular_add(r, &q->expr, 1);
        }
    }
    r->answer = !r->options ? REGULAR_NEVER : REGULAR_REPLACED;
    if (r->options == 1 && plain && !divides_at_start(s, e)) {
        r->answer = REGULAR_KEEP;
        r->option[0].out[0] = e;
    }
}

static struct poly_limits factoring(const struct state *s)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, s->options->budget);
    limits.max_terms = SGA_MOST_FACTORED_TERMS;
    return limits;
}

/* Part by part: what is too large to factor as a whole. */
static struct regular from_shape(struct state *s, expr_id e)
{
    enum { PARTS = 24 };
    struct regular r = { .answer = REGULAR_REPLACED };
    expr_id part[PARTS];
    int parts = regular_shape_factors(s, e, part, PARTS);
    for (int i = 0; i < parts; i++) {
        struct poly_limits limits = factoring(s);
        struct poly_factors f;
        if (parts > 1 && poly_numerator_factors(s->st, part[i], &limits, &f)) {
            struct regular q = { .answer = REGULAR_KEEP };
            from_factors(s, part[i], &q, &f, DEPTH);
            poly_factors_clear(&f);
            regular_move(&r, &q);
        } else {
            regular_add(&r, part + i, 1);
        }
    }
    if (!r.options)
        r.answer = REGULAR_NEVER;
    else if (r.options == 1 && r.option[0].count == 1 && r.option[0].out[0] == e)
        r.answer = REGULAR_KEEP;
    return r;
}

static struct regular form_at(struct state *s, expr_id e, int depth)
{
    struct regular r = { .answer = REGULAR_KEEP };
    if (state_facts(s, e) & EXPR_NONZERO) {
        r.answer = REGULAR_NEVER;
        return r;
    }
    enum graph graph = regular_graph(s, e);
    if (graph != PLAIN_GRAPH && depth > DEPTH)
        sga_limit_met(s->options->budget, SGA_LIMIT_REGULAR_DEPTH);
    if (graph == PLAIN_GRAPH || depth > DEPTH) {
        regular_add(&r, &e, 1);
        return r;
    }
    if (by_ends(s, e, depth, &r)) {
        r.answer = r.options ? REGULAR_REPLACED : REGULAR_NEVER;
        return r;
    }
    struct poly_limits limits = factoring(s);
    struct poly_factors f;
    if (poly_alike_factors(s->alike, e, &limits, &f)) {
        from_factors(s, e, &r, &f, depth);
        poly_factors_clear(&f);
    } else if (graph == GRAPH) {
        regular_add(&r, &e, 1);
    } else {
        r = from_shape(s, e);
        s->sol->not_factored = true;
        sga_limit_met(s->options->budget, SGA_LIMIT_FACTORED_TERMS);
    }
    return r;
}

/* f without its factors in parameters only; these are assumed not to vanish, if `keep`. */
static expr_id general(struct state *s, expr_id f, bool keep)
{
    struct poly_limits limits = factoring(s);
    SGA_ENDS(poly_factors_clear) struct poly_factors q = { 0 };
    if (!(state_facts(s, f) & EXPR_HAS_PARAMETER) || !poly_numerator_factors(s->st, f, &limits, &q))
        return f;
    expr_id out = expr_int(s->st, 1);
    for (int i = 0; i < q.factors; i++)
        if (q.factor[i].depends != EXPR_HAS_PARAMETER)
            out = expr_mul(s->st, out, q.factor[i].expr);
        else if (keep && !q.factor[i].never_zero)
            assume(s, q.factor[i].expr);
    return out;
}

/* Whether the functions of o vanish together, on the present set, only where something has no value. */
static bool leads_out(struct state *s, expr_id e, const struct regular_option *o)
{
    int c = s->sol->constraints, count = 0;
    SGA_FREED expr_id *f = sga_malloc((size_t)(o->count + c + s->pendings + 1) * sizeof *f);
    for (int i = 0; i < o->count; i++)
        f[count++] = general(s, o->out[i], false);
    for (int i = 0; i < c + s->pendings && count <= DOMAIN_GIVEN; i++)
        f[count++] = i < c ? s->con[i] : s->pending[i - c];
    bool out = domain_leaves_out(s->domain, e, f, o->count, count);
    for (int i = 0; i < o->count && out; i++)
        general(s, o->out[i], true);
    return out;
}

/* Ways that lead out of where the equations have values are none. */
static void keep_inside(struct state *s, expr_id e, struct regular *r)
{
    int n = 0;
    for (int i = 0; i < r->options; i++)
        if (leads_out(s, e, r->option + i))
            free(r->option[i].out);
        else
            r->option[n++] = r->option[i];
    if (n > 1 && s->domain->cut)
        sga_limit_met(s->options->budget, SGA_LIMIT_DOMAIN_DIVISORS);
    if (n > 1 && s->sol->constraints + s->pendings >= SGA_MOST_DOMAIN_GIVEN)
        sga_limit_met(s->options->budget, SGA_LIMIT_DOMAIN_GIVEN);
    if (n == r->options)
        return;
    r->options = n;
    r->outside = true;
    r->answer = n ? REGULAR_REPLACED : REGULAR_NEVER;
}

/* Whether all that vanishes with a vanishes with b: a is a part of it. */
static bool part_of(struct state *s, const struct regular_option *a, const struct regular_option *b)
{
    struct poly_limits limits = poly_limits_of(POLY_SMALL, s->options->budget);
    bool all = a->count > 1;
    for (int i = 0; i < b->count && all; i++)
        all = poly_vanishes_with(s->st, b->out[i], a->out, a->count, &limits);
    return all;
}

/* Functions that vanish with the others of their way say nothing. */
static void keep_needed(struct state *s, struct regular_option *o)
{
    struct poly_limits limits = poly_limits_of(POLY_SMALL, s->options->budget);
    for (int i = o->count - 1; i >= 0 && o->count > 1; i--) {
        expr_id last = o->out[o->count - 1], e = o->out[i];
        o->out[i] = last;
        if (poly_vanishes_with(s->st, e, o->out, o->count - 1, &limits))
            o->count--;
        else
            o->out[i] = e;
    }
}

/* Ways that others contain are none of their own. */
static void keep_largest(struct state *s, struct regular *r)
{
    for (int i = 0; i < r->options; i++)
        keep_needed(s, r->option + i);
    for (int i = r->options - 1; i >= 0; i--) {
        bool inside = false;
        for (int k = 0; k < r->options && !inside; k++)
            inside = k != i && part_of(s, r->option + i, r->option + k);
        if (!inside)
            continue;
        free(r->option[i].out);
        memmove(r->option + i, r->option + i + 1, (size_t)(--r->options - i) * sizeof *r->option);
    }
}

struct regular regular_alone(struct state *s, expr_id e)
{
    struct regular r = form_at(s, e, 0);
    keep_inside(s, e, &r);
    keep_largest(s, &r);
    return r;
}

struct regular_option regular_nearest(struct state *s, expr_id e, const double *x, double t)
{
    SGA_ENDS(regular_clear) struct regular r = form_at(s, e, 0);
    keep_inside(s, e, &r);
    struct regular_option best = { 0 };
    int at = -1;
    double least = INFINITY;
    for (int k = 0; k < r.options; k++) {
        double v = regular_option_distance(s, r.option + k, x, t);
        if (v < least) {
            least = v;
            at = k;
        }
    }
    if (at >= 0) {
        best = r.option[at];
        r.option[at].out = NULL;
    }
    return best;
}
