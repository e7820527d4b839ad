/* From a candidate to constraints: regular, independent, and with points. */
#include "state.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "admit.h"
#include "arena.h"
#include "ball.h"
#include "budget.h"
#include "error.h"
#include "facts.h"
#include "irregular.h"
#include "mem.h"
#include "place_search.h"
#include "points.h"
#include "poly.h"
#include "print.h"
#include "reduction.h"
#include "oracle.h"
#include "warnings.h"

char *state_text(struct state *s, expr_id e)
{
    return expr_text(s->st, e, 300);
}

enum points_status state_sample(struct state *s)
{
    int c = s->sol->constraints;
    s->space.constraint = s->con;
    s->space.constraints = c;
    SGA_RESERVE_IN(&s->mem, s->end, s->end_cap, (c ? s->sol->constraint[c - 1].generation : 0) + 2);
    s->space.end = s->end;
    s->space.ends = sga_stages(s->sol, c, s->end);
    return points_oracle_sample(s->oracle, &s->space);
}

/* Whether what vanished on the set of the first so many constraints vanishes at the present points: otherwise they lie on another
 * component of it than the decisions so far. */
static bool on_component(struct state *s, int constraints)
{
    struct points_oracle *w = s->oracle;
    bool on = true;
    for (int k = 0; k < w->reals && on; k++) {
        struct num_ball *b = &w->real[k].ball;
        for (int i = 0; i < w->zeros && on; i++) {
            num_ball_ask(b, w->zero[i].expr);
            arb_srcptr v = num_ball_value(b, w->zero[i].expr);
            on = w->zero[i].constraints > constraints || !arb_is_finite(v) || arb_contains_zero(v);
        }
    }
    return on;
}

static void push(struct state *s, const struct candidate *c, expr_id regular, int g)
{
    assert(g >= 1 && (!s->sol->constraints || s->sol->constraint[s->sol->constraints - 1].generation <= g));
    struct sga_solution *sol = s->sol;
    SGA_RESERVE(sol->constraint, s->constraint_cap, sol->constraints + 1);
    SGA_RESERVE_IN(&s->mem, s->con, s->con_cap, sol->constraints + 1);
    struct sga_constraint *k = sol->constraint + sol->constraints;
    bool same = regular == c->expr && !c->arose;
    *k = (struct sga_constraint){ .expr = regular, .generation = g, .origin = c->origin, .source = c->source,
                                  .restriction = c->restriction,
                                  .replaced = same ? EXPR_UNDEF : c->arose ? c->arose : c->expr,
                                  .base = same ? c->base : regular, .order = same ? c->order : 0 };
    if (s->options->combinations)
        state_combine(s, c, &k->part, &k->parts);
    s->con[sol->constraints++] = regular;
}

static void push_option(struct state *s, const struct candidate *c, const struct regular_option *o, int g)
{
    for (int i = 0; i < o->count; i++)
        push(s, c, o->out[i], g);
}

/* The branches of a product that are not followed. */
static void note_branches(struct state *s, const struct regular *r, int followed, int before)
{
    assert(followed < r->options && before <= s->sol->constraints);
    for (int i = before; i < s->sol->constraints; i++)
        s->sol->constraint[i].chosen = r->options > 1;
    SGA_RESERVE(s->sol->branch, s->branch_cap, s->sol->branches + r->options + 1);
    for (int i = 0; i < r->options; i++) {
        const struct regular_option *o = r->option + i;
        expr_id e = o->out[0];
        if (o->count > 1)         /* what vanishes together, as one function */
            e = expr_powi(s->st, e, 2);
        for (int k = 1; k < o->count; k++)
            e = expr_add(s->st, e, expr_powi(s->st, o->out[k], 2));
        if (i != followed)
            s->sol->branch[s->sol->branches++] = (struct sga_branch){ e, before };
    }
}

void admit_pop(struct state *s, int to)
{
    assert(to >= 0 && to <= s->sol->constraints);
    while (s->sol->constraints > to)
        free(s->sol->constraint[--s->sol->constraints].part);
}

static int contradiction(struct state *s, const struct candidate *c, const char *why)
{
    assert(c->expr && why[0]);
    s->inconsistent = true;
    s->sol->contradiction = c->expr;
    snprintf(s->sol->contradiction_why, sizeof s->sol->contradiction_why, "%s", why);
    s->sol->contradiction_epoch = s->epoch;
    state_combine(s, c, &s->sol->contradiction_part, &s->sol->contradiction_parts);
    return 0;
}

/* A constraint without variables holds for no x, or for all. */
const char *state_hopeless(struct state *s, expr_id e)
{
    unsigned f = state_facts(s, e);
    if (!(f & EXPR_HAS_VARIABLE)) {
        if (f & EXPR_HAS_TIME)
            return "it depends on time only, so it can hold at some instants only";
        return f & EXPR_HAS_PARAMETER ? "it depends on parameters only, and is not zero for general values of them"
                                      : "it is a constant that is not zero";
    }
    return f & EXPR_NONZERO ? "it has no real zero" : NULL;
}

static int fail_sample(struct state *s, const struct candidate *c, enum points_status status)
{
    SGA_FREED char *text = state_text(s, c->expr);
    if (status == POINTS_STOPPED)
        sga_budget_ok(s->options->budget, s->err);
    else if (status == POINTS_IRREGULAR)
        sga_fail(s->err, SGA_E_IRREGULAR, "the differential of the constraint %s depends on those of the earlier ones "
                 "where it vanishes, and no regular function with the same zeros was found; "
                 "write the constraint in a form whose gradient does not vanish on it", text);
    else
        sga_fail(s->err, SGA_E_NO_REAL_POINT, "no real point was found on which the constraint %s holds with the earlier "
                 "ones (this is not a proof that there is none); give trajectory.initial near such a point", text);
    return -1;
}

/* e's first derivatives on the present set: below some order they vanish, that one does
 * not. */
static bool order_holds(struct state *s, const struct proposal *p)
{
    for (int k = 0; k < p->derivatives; k++) {
        enum points_truth z = points_oracle_zero(s->oracle, p->derivative[k]).truth;
        if (z != POINTS_ZERO)
            return z == POINTS_NONZERO && k > 0;
    }
    return false;
}

/* The constraint c turned out irregular near x: try what may take its place there. */
static int admit_irregular(struct state *s, const struct candidate *c, const double *x, double t, int g)
{
    SGA_FREED struct proposal *p = NULL;
    int count = irregular_proposals(s, c->expr, x, t, &p), before = s->sol->constraints, added = -1;
    bool taken = false;
    int sides = s->oracle->sides;
    for (int i = 0; i < count; i++) {
        for (int k = 0; k < p[i].count && added < 0; k++)
            push(s, c, p[i].out[k], g);
        if (added < 0 && place_sample_near(s, x, t) == POINTS_OK && on_component(s, before)
            && points_oracle_zero(s->oracle, c->expr).truth == POINTS_ZERO
            && (!p[i].derivatives || order_holds(s, p + i)) && (p[i].exact || place_vanishes_far(s, c->expr)))
            added = p[i].count;
        for (int k = before; k < s->sol->constraints; k++)
            s->sol->constraint[k].near_point = true;
        if (added < 0) {
            admit_pop(s, before);
            s->oracle->sides = sides;
        } else if (p[i].whole && s->sol->constraints == before + added && !taken) {
            SGA_RESERVE(s->sol->branch, s->branch_cap, s->sol->branches + 1);
            s->sol->branch[s->sol->branches++] = (struct sga_branch){ p[i].whole, before };
        }
        taken = added >= 0;
        irregular_clear(p + i);
    }
    return added >= 0 ? added : fail_sample(s, c, POINTS_IRREGULAR);
}


/* Where a regular function took the place of what arose, the latter must vanish on the
 * new set: a check of the factorisation by the points. */
static bool replacements_hold(struct state *s, int from)
{
    for (int i = from; i < s->sol->constraints; i++) {
        expr_id old = s->sol->constraint[i].replaced;
        if (!old)
            continue;
        struct points_oracle *w = s->oracle;
        int sides = w->sides, z = ech_zero(&s->ctx, old);
        while (w->sides > sides && w->side[w->sides - 1].unseen)      /* a factor's zeros are zeros of the product, seen or not */
            w->sides--;
        if (z < 0)
            return false;
        if (z == 0)
            return sga_fail(s->err, SGA_E_INTERNAL, "a constraint and the regular function that took its place have different zeros");
    }
    return true;
}

/* Functions that vanish together, of which one is irregular: one after the other. */
static int admit_parts(struct state *s, const struct candidate *c, const struct regular_option *o, int g)
{
    int before = s->sol->constraints, result = 0;
    for (int i = 0; i < o->count && result >= 0 && !s->inconsistent; i++) {
        struct candidate part = *c;
        part.expr = o->out[i];
        part.arose = c->arose ? c->arose : c->expr;
        result = admit_one(s, &part, g);
    }
    if (result >= 0 && !s->inconsistent && !replacements_hold(s, before))
        result = -1;
    return result < 0 ? -1 : s->sol->constraints - before;
}

static bool never_on_set(struct state *s, expr_id e)
{
    if (s->sol->constraints > SGA_MOST_USED_UP) {
        sga_limit_met(s->options->budget, SGA_LIMIT_USED_UP);
        return false;
    }
    expr_id reduced = regular_reduced(s, e);
    if (state_hopeless(s, reduced))
        return true;
    SGA_ENDS(regular_clear) struct regular r = regular_form(s, reduced);
    return r.answer == REGULAR_NEVER;
}

/* The same by squares: -1 as a sum of them, with multiples of e and of the constraints. */
static bool never_by_squares(struct state *s, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, s->options->budget);
    int c = s->sol->constraints;
    if (c >= SGA_MOST_REDUCED_BY)
        return false;
    SGA_FREED expr_id *f = sga_malloc(((size_t)c + 1) * sizeof *f);
    if (c)
        memcpy(f, s->con, (size_t)c * sizeof *f);
    f[c] = e;
    return poly_never_together(s->st, f, c + 1, &limits);
}

/* Whether e is made with functions that change their branch: what holds near the points
 * then says nothing about the rest. */
static bool has_branches(struct state *s, expr_id e)
{
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++) {
        enum expr_op op = expr_op_of(s->st, s->cone.list[k]);
        if (op == EXPR_ABS || op == EXPR_SIGN || op == EXPR_MIN || op == EXPR_MAX)
            return true;
    }
    return false;
}

/* c keeps one value, not zero, along the branch of the present set that the points lie on. */
static int constant_there(struct state *s, const struct candidate *c, const char *why)
{
    SGA_FREED char *text = NULL;
    if (has_branches(s, c->expr))
        return fail_sample(s, c, POINTS_NONE);
    if (!place_holds_elsewhere(s, c->expr))
        return contradiction(s, c, why);
    text = state_text(s, c->expr);
    sga_fail(s->err, SGA_E_SPLIT, "the constraint set has several branches, and %s = 0 holds on some of them only; "
             "write the constraints so that they cut out those alone", text);
    return -1;
}

/* No option led to points: say what can be said. `status` is that of the last one. */
static int refuse(struct state *s, const struct candidate *c, const struct regular *r, enum points_status status, int g)
{
    SGA_FREED double *x = NULL;
    double t = 0;
    int result = -1;
    if (status == POINTS_IRREGULAR) {     /* the place that was approached */
        SGA_ENDS(points_point_clear) struct points_point p;
        place_with(s, r->option[0].out[0], &p);
        x = memcpy(sga_malloc((size_t)p.variables * sizeof *x), p.x, (size_t)p.variables * sizeof *x);
        t = p.t;
    }
    if (status == POINTS_STOPPED)
        result = fail_sample(s, c, status);
    else if (place_holds_on_side(s, c->expr))
        result = 0;
    else if (s->sol->constraints && never_by_squares(s, c->expr))
        result = contradiction(s, c, "it has no real zero on the earlier constraints: -1 is a sum of squares plus multiples of these and of it");
    else if (state_sample(s) != POINTS_OK)
        result = fail_sample(s, c, POINTS_NONE);
    else if (state_locally_constant(s, c->expr))
        result = constant_there(s, c, "it is locally constant on the earlier constraints and not zero there");
    else if (never_on_set(s, c->expr))
        result = contradiction(s, c, "with the earlier constraints used up, it has no real zero");
    else if (status == POINTS_IRREGULAR)
        result = admit_irregular(s, c, x, t, g);
    else
        result = fail_sample(s, c, status);
    return result;
}

/* Algebra shows that it has no zero. */
static int never(struct state *s, const struct candidate *c, const struct regular *r)
{
    char why[sizeof s->sol->contradiction_why];
    regular_never_text(s, c->expr, r, why, sizeof why);
    return contradiction(s, c, why);
}

/* The last constraint, pushed as it arose, led to no points: in normal form on the set before it, the same function there, sums that cancel
 * and what it is solved for are seen. POINTS_NONE where that says no more. */
static enum points_status sample_reduced(struct state *s, const struct candidate *c, int g)
{
    int before = s->sol->constraints - 1;
    expr_id e = s->con[before];
    if (before >= SGA_MOST_REDUCED_BY)
        return POINTS_NONE;
    admit_pop(s, before);
    expr_id reduced = regular_reduced(s, e);
    bool says = reduced != e && state_facts(s, reduced) & EXPR_HAS_VARIABLE;
    push(s, c, says ? reduced : e, g);
    return says ? state_sample(s) : POINTS_NONE;
}

int admit_one(struct state *s, const struct candidate *c, int g)
{
    int z = ech_zero(&s->ctx, c->expr);
    if (z < 0)
        return -1;
    if (z == 1)
        return 0;          /* it follows from those admitted before it */
    const char *why = state_hopeless(s, c->expr);
    if (why)
        return contradiction(s, c, why);
    SGA_ENDS(regular_clear) struct regular r = regular_form(s, c->expr);
    assert(regular_sane(&r));
    int before = s->sol->constraints, result = -1;
    enum points_status status = POINTS_NONE;
    expr_id passed = EXPR_UNDEF;
    bool found = false;
    for (int i = 0; i < r.options && !found; i++) {      /* the branches of a product in turn */
        push_option(s, c, r.option + i, g);
        status = state_sample(s);
        if (status == POINTS_NONE && r.option[i].count == 1)
            status = sample_reduced(s, c, g);
        if (status == POINTS_OK && !on_component(s, before))
            status = POINTS_NONE;
        found = status == POINTS_OK;
        if (found)
            note_branches(s, &r, i, before);
        else
            admit_pop(s, before);
        bool more = i + 1 < r.options;       /* that may be found in its place */
        if (!found && more && status != POINTS_STOPPED && !s->sol->passed && !(r.option[i].count == 1 && never_by_squares(s, r.option[i].out[0])))
            passed = r.option[i].out[0];
        if (status == POINTS_STOPPED)
            break;
    }
    if (found && passed)
        s->sol->passed = passed;
    if (found)      /* what a part arose from vanishes with the other parts: admit_parts looks at it */
        result = c->arose || replacements_hold(s, before) ? s->sol->constraints - before : -1;
    else if (status == POINTS_IRREGULAR && r.options == 1 && r.option[0].count > 1 && !c->arose && state_sample(s) == POINTS_OK)
        result = admit_parts(s, c, r.option, g);
    else if (r.answer == REGULAR_NEVER && !r.seen)
        result = never(s, c, &r);
    else if (r.answer == REGULAR_NEVER)
        result = constant_there(s, c, "it has no real zero on the earlier constraints");
    else
        result = refuse(s, c, &r, status, g);
    return result;
}

int admit_together(struct state *s, const struct candidate *cand, int count, int g)
{
    assert(count > 0);
    int before = s->sol->constraints;
    bool plain = true, going = true;
    SGA_ARENA(mem);
    struct regular *form = sga_zeros(&mem, (size_t)count, sizeof *form);
    expr_id *pending = sga_take(&mem, (size_t)count * sizeof *pending);
    s->pending = pending;
    for (int i = 0; i < count && plain && (going = sga_budget_ok(s->options->budget, s->err)); i++) {
        plain = !state_hopeless(s, cand[i].expr);
        if (plain)
            form[i] = regular_form(s, cand[i].expr);
        plain = plain && form[i].options == 1;
        pending[s->pendings++] = plain ? form[i].option[0].out[0] : cand[i].expr;
    }
    for (int i = 0; i < count; i++) {
        if (plain && going)
            push_option(s, cand + i, form[i].option, g);
        regular_clear(form + i);
    }
    s->pending = NULL;
    s->pendings = 0;
    if (!going)
        return -2;
    if (!plain)
        return -1;
    enum points_status status = state_sample(s);
    if (status == POINTS_OK && !on_component(s, before))
        status = POINTS_NONE;
    if (status == POINTS_OK && (count == 1 || s->sol->constraints > SGA_MOST_PROOF_ROWS || points_oracle_certified(s->oracle)))
        return replacements_hold(s, before) ? s->sol->constraints - before : -2;
    admit_pop(s, before);
    if (status == POINTS_STOPPED || state_sample(s) != POINTS_OK) {
        fail_sample(s, cand, status);
        return -2;
    }
    return -1;
}
