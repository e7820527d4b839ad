/* Regular forms on the present set: a function may be a product there, or irregular, that is neither by itself. */
#include "regular.h"

#include <stdlib.h>

#include "facts.h"
#include "regular_options.h"
#include "regular_shape.h"
#include "warnings.h"

/* From so many nodes on what is left with the constraints used up takes a function's place where it is smaller by this much: else its derivatives swell. */
enum { LARGE = 40, SMALLER = 2 };

static bool much_smaller(struct state *s, expr_id a, expr_id e)
{
    int size = state_size(s, e);
    return size >= LARGE && SMALLER * state_size(s, a) <= size;
}

/* The form of e with the constraints used up, where that says more, or the same in much shorter; KEEP where it does not. */
static struct regular form_on_set(struct state *s, expr_id e)
{
    struct regular keep = { .answer = REGULAR_KEEP };
    if (regular_fresh_graph(s, e))
        return keep;
    expr_id reduced = regular_reduced(s, e);
    if (reduced == e || expr_is_zero(s->st, reduced))
        return keep;
    struct regular q = regular_alone(s, reduced);
    bool one = q.options == 1 && q.option[0].count == 1, poles = regular_has_poles(s, e);
    if (one && !poles && regular_same_zeros(s, reduced, q.option[0].out[0]))        /* it says no more than e, and may be far longer */
        q.answer = much_smaller(s, q.option[0].out[0], e) ? REGULAR_REPLACED : REGULAR_KEEP;
    if (q.answer == REGULAR_KEEP && poles && !regular_has_poles(s, reduced))
        q.answer = REGULAR_REPLACED;
    q.reduced = q.answer != REGULAR_KEEP;
    return q;
}

/* A way in which e vanishes may be irregular on the present set, or a union of its own: v = 0 where v = u^2. */
static void look_at_ways(struct state *s, struct regular *r)
{
    struct regular all = { .answer = REGULAR_REPLACED };
    for (int i = 0; i < r->options; i++) {
        const struct regular_option *o = r->option + i;
        struct regular own = { .answer = REGULAR_KEEP };
        if (o->count == 1)
            own = form_on_set(s, o->out[0]);
        all.reduced |= own.answer != REGULAR_KEEP;
        all.seen |= own.seen;
        if (own.answer == REGULAR_KEEP) {
            regular_clear(&own);
            regular_add(&own, o->out, o->count);
        }
        regular_move(&all, &own);
    }
    all.seen |= r->seen;
    all.outside = r->outside;
    if (all.reduced) {
        regular_clear(r);
        *r = all;
        r->answer = r->options ? REGULAR_REPLACED : REGULAR_NEVER;
    } else {
        regular_clear(&all);
    }
}

/* Whether time is in e or in a constraint: affine functions have products of it with others then. */
static bool timed(struct state *s, expr_id e)
{
    unsigned facts = state_facts(s, e);
    for (int i = 0; i < s->sol->constraints; i++)
        facts |= state_facts(s, s->con[i]);
    for (int i = 0; i < s->pendings; i++)
        facts |= state_facts(s, s->pending[i]);
    return facts & EXPR_HAS_TIME;
}

static struct regular form(struct state *s, expr_id e)
{
    struct regular r = regular_alone(s, e);
    int c = s->sol->constraints + s->pendings;
    if (c > SGA_MOST_REDUCED_BY) {
        s->sol->not_factored = true;
        sga_limit_met(s->options->budget, SGA_LIMIT_REDUCED_BY);
    }
    if (r.answer == REGULAR_NEVER || c == 0 || c > SGA_MOST_REDUCED_BY || (regular_all_affine(s, e) && !timed(s, e)))
        return r;
    if (r.answer == REGULAR_REPLACED) {
        look_at_ways(s, &r);
        return r;
    }
    struct regular q = form_on_set(s, e);
    struct regular *drop = q.answer == REGULAR_KEEP ? &q : &r;
    struct regular take = q.answer == REGULAR_KEEP ? r : q;
    regular_clear(drop);
    return take;
}

struct regular regular_form(struct state *s, expr_id e)
{
    struct regular r = form(s, e);
    int alike = regular_sort(s, e, &r);
    if (r.options > 1 && s->route)
        regular_follow_route(s, e, &r, alike);
    return r;
}
