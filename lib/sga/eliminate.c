/* A function written on the present set with fewer variables: constraints that are solved
 * by one variable with a constant factor are used up. */
#include "regular.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "cases.h"
#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "modp.h"
#include "oracle.h"
#include "points.h"
#include "poly.h"
#include "regular_shape.h"
#include "system.h"
#include "warnings.h"

enum { GROWN = 4 };      /* nodes of a function on the set, by its own, beside SGA_MOST_GROWN_ON_SET */

/* Whether v has different values at the two points: then it is no constant. */
static bool varies(struct state *s, expr_id v)
{
    struct points_oracle *w = s->oracle;
    if (w->reals < 2)
        return false;
    num_ball_ask(&w->real[0].ball, v);
    num_ball_ask(&w->real[1].ball, v);
    return !arb_overlaps(num_ball_value(&w->real[0].ball, v), num_ball_value(&w->real[1].ball, v));
}

/* Two points anywhere, modulo a prime, with the same parameters. */
struct pair { struct num_modp at[2]; struct expr_cone cone; };

static void pair_init(struct pair *p, const struct state *s)
{
    expr_cone_init(&p->cone);
    for (int k = 0; k < 2; k++) {
        struct num_modp *m = p->at + k;
        num_modp_init(m, s->st, 29, 11);
        for (int i = 0; i < s->st->symbols; i++)
            num_modp_set(m, i, num_modp_random(m, (uint64_t)i + (s->st->symbol[i].kind == EXPR_PARAMETER ? 0 : (uint64_t)(k + 1) << 32)));
    }
}

static void pair_clear(struct pair *p)
{
    expr_cone_clear(&p->cone);
    for (int k = 0; k < 2; k++)
        num_modp_clear(p->at + k);
}

/* Whether v, an algebraic function, has different values at the two: then it does not depend on parameters only. */
static bool pair_varies(struct pair *p, const struct state *s, expr_id v)
{
    expr_cone_of(s->st, &p->cone, &v, 1);
    for (int k = 0; k < 2; k++)
        num_modp_list(p->at + k, p->cone.list, p->cone.count);
    for (int k = 0; k < 2; k++)
        if (num_modp_bad(p->at + k, v) || num_modp_kernel(p->at + k, v) || num_modp_branch(p->at + k, v))
            return false;
    return num_modp_value(p->at, v) != num_modp_value(p->at + 1, v);
}

/* A slope that is a constant or depends on parameters only, and is not 0: its normal form,
 * since it may only look as if it depended on something. */
static bool constant_slope(struct state *s, struct pair *pair, expr_id v, expr_id *slope)
{
    struct poly_limits limits = poly_limits_of(POLY_SMALL, s->options->budget);
    bool depends = state_facts(s, v) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME);
    if (depends && ((!s->sys->parameters && varies(s, v)) || pair_varies(pair, s, v)))
        return false;
    if (depends)
        poly_normal(s->st, v, &limits, &v);
    *slope = v;
    return !expr_is_zero(s->st, v) && !(state_facts(s, v) & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME));
}

static int search_symbol(struct state *s, expr_id e, expr_id *slope, bool *affine)
{
    state_activate(s);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    int n = expr_gradient(s->st, &s->cone, e, s->active, &term, &cap), found = -1;
    *affine = true;
    for (int k = 0; k < n; k++)
        *affine &= !(state_facts(s, term[k].value) & EXPR_HAS_VARIABLE);
    SGA_ENDS(pair_clear) struct pair pair;
    pair_init(&pair, s);
    for (int k = 0; k < n && found < 0; k++)
        if (constant_slope(s, &pair, term[k].value, slope))
            found = term[k].symbol;
    return found;
}

/* What e is solved for, and whether it is affine in the variables. The same constraints
 * are asked for again and again: answers are kept. */
static const struct solved_for *solved_for(struct state *s, expr_id e)
{
    for (int k = 0; k < s->solved_count; k++)
        if (s->solved[k].expr == e)
            return s->solved + k;
    struct solved_for f = { .expr = e };
    f.symbol = search_symbol(s, e, &f.slope, &f.affine);
    SGA_RESERVE_IN(&s->mem, s->solved, s->solved_cap, s->solved_count + 1);
    s->solved[s->solved_count] = f;
    return s->solved + s->solved_count++;
}

/* The variable that e is solved for, and its constant factor; -1 if there is none. */
static int solved_symbol(struct state *s, expr_id e, expr_id *slope)
{
    const struct solved_for *f = solved_for(s, e);
    *slope = f->slope;
    return f->symbol;
}

bool regular_all_affine(struct state *s, expr_id e)
{
    bool affine = solved_for(s, e)->affine;
    for (int i = 0; i < s->sol->constraints && affine; i++)
        affine = solved_for(s, s->con[i])->affine;
    for (int i = 0; i < s->pendings && affine; i++)
        affine = solved_for(s, s->pending[i])->affine;
    return affine;
}

bool regular_is_solved(struct state *s, expr_id e)
{
    expr_id slope;
    struct route *route = s->route;
    s->route = NULL;             /* a question, no decision */
    SGA_ENDS(regular_clear) struct regular r = regular_form(s, e);
    s->route = route;
    return r.options == 1 && r.option[0].count == 1 && solved_symbol(s, r.option[0].out[0], &slope) >= 0;
}

/* What x is where f = 0, which is slope x + rest. The rest is f at x = 0: without x, also where its normal form is too large. It may have
 * no value as it is written there, (x^2 + x y)/x: then x is left to the normal form. */
static expr_id value_of(struct state *s, int x, expr_id f, expr_id slope)
{
    struct cases_put zero = { x, expr_int(s->st, 0) };
    expr_id rest = cases_at(s->st, f, &zero, 1);
    return rest ? expr_neg(s->st, expr_div(s->st, rest, slope)) : expr_sub(s->st, s->st->symbol[x].node, expr_div(s->st, f, slope));
}

/* Whether the shape of e says nothing of its zeros but that it is 0 there. */
static bool is_one_part(struct state *s, expr_id e)
{
    expr_id part[2];
    return regular_shape_factors(s, e, part, 2) == 1 && regular_same_zeros(s, e, part[0]);
}

static long size_of(struct state *s, expr_id e)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    return s->cone.count;
}

/* Without a normal form each constraint that is put in may double the function: past this it says nothing more. */
static bool outgrows(struct state *s, expr_id e, long first)
{
    return size_of(s, e) > GROWN * first + SGA_MOST_GROWN_ON_SET;
}

/* e with the first `count` of those in s->used put in, one after the other, and brought to normal form each time. What has one and would lose
 * it to a sum that says nothing stays as it is: equal on the set as well, and within bounds, however many are put into each other.
 * map: by symbol, UNDEF. */
static expr_id with_used(struct state *s, expr_id e, int count, expr_id *map, const struct poly_limits *limits)
{
    bool begun = false, has = false;
    long first = size_of(s, e);
    for (int i = 0; i < count; i++) {
        const struct used_up *u = s->used + i;
        if (u->symbol < 0)
            continue;
        has = begun ? has : poly_normal(s->st, e, limits, &e);
        begun = true;
        expr_id put = e;
        map[u->symbol] = u->value;
        expr_substitute(s->st, &put, 1, map);
        map[u->symbol] = EXPR_UNDEF;
        if (put == e)
            continue;
        bool found = poly_normal(s->st, put, limits, &put);
        if (!found && outgrows(s, put, first)) {
            s->sol->not_factored = true;
            sga_limit_met(s->options->budget, SGA_LIMIT_GROWN_ON_SET);
            continue;
        }
        e = found || !has || !is_one_part(s, put) ? put : e;
        has |= found;
    }
    return e;
}

expr_id regular_reduced(struct state *s, expr_id e)
{
    int own = s->sol->constraints, c = own + s->pendings;
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)s->st->symbols, sizeof *map);
    /* no product of more than can be factored is written out */
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, s->options->budget);
    for (int i = 0; i < c; i++) {
        expr_id f = i < own ? s->con[i] : s->pending[i - own], slope;
        if (i < s->useds && s->used[i].constraint == f)
            continue;
        struct used_up u = { .constraint = f };
        f = with_used(s, f, i, map, &limits);
        u.symbol = solved_symbol(s, f, &slope);
        if (u.symbol >= 0) {
            u.value = value_of(s, u.symbol, f, slope);
            poly_normal(s->st, u.value, &limits, &u.value);
        }
        SGA_RESERVE_IN(&s->mem, s->used, s->used_cap, i + 1);
        s->used[i] = u;
        s->useds = i + 1;
    }
    return with_used(s, e, c, map, &limits);
}
