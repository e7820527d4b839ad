/* What a run of the reduction took for granted of the symbolic parameters.
 *
 * The constraints are brought to triangular shape, one after the other: each is written with the variables that the earlier ones
 * leave, and solved for one of them where it is affine in one. A function g of variables and parameters is written in the same
 * way; as a polynomial in the variables that are left it vanishes on the whole set just where all its coefficients do. By a
 * constraint that is affine in nothing a variable is eliminated by the resultant: its zeros hold all those of g. */
#include "conditions.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "sort.h"
#include "poly.h"
#include "reduction.h"
#include "state.h"
#include "system.h"
#include "warnings.h"

struct step {
    int symbol;               /* the variable that goes; -1: none could be eliminated */
    expr_id value;            /* what it equals; EXPR_UNDEF: it goes by the resultant with ... */
    expr_id function;         /* ... the constraint, in the variables that were left */
    expr_id slope;            /* that was divided by */
    bool ready, used;         /* whether the variable has been chosen, and its going matters to another function */
};

struct chain {
    struct state *s;
    struct sga_conditions *to;
    struct step *step; int steps;
    struct poly_limits limits;
};

static bool same(const struct sga_condition *c, const expr_id *f, int n)
{
    return c->functions == n && memcmp(c->function, f, (size_t)n * sizeof *f) == 0;
}

void conditions_add(struct sga_conditions *to, struct expr_store *st, struct expr_facts *facts, const expr_id *function, int functions)
{
    expr_id *f = sga_malloc(((size_t)functions + 1) * sizeof *f);
    int n = 0;
    bool holds = false;
    for (int i = 0; i < functions && !holds; i++) {
        holds = expr_facts_of(facts, st, function[i]) & EXPR_NONZERO || (expr_is_const(st, function[i]) && !expr_is_zero(st, function[i]));
        if (!expr_is_zero(st, function[i]))
            f[n++] = function[i];
    }
    sga_sort(f, (size_t)n);
    for (int i = 0; i < to->count && !holds; i++)
        holds = same(to->at + i, f, n);
    if (holds || !n) {
        free(f);
        return;
    }
    SGA_RESERVE(to->at, to->cap, to->count + 1);
    to->at[to->count++] = (struct sga_condition){ .function = f, .functions = n };
}

static void too_large(const struct chain *c)
{
    sga_warn(c->s->options->budget, SGA_W_STRATA_NOT_SEARCHED, "", "what the reduction takes for granted of the symbolic parameters is in "
             "part too large for its coefficients to be looked at: there may be more cases of them");
}

/* The coefficients of those terms of a numerator that depend on `of` (0: of all) do not all vanish. */
static void note_by(struct chain *c, struct poly_numerator *g, unsigned of)
{
    struct poly_coefficients k;
    struct expr_store *st = c->s->st;
    if (!g || !poly_coefficients_of(g, &k)) {
        too_large(c);
        return;
    }
    int n = 0;
    for (int i = 0; i < k.count; i++)
        if (!of || k.of[i] & of)
            k.coefficient[n++] = k.coefficient[i];
    conditions_add(c->to, st, c->s->facts, k.coefficient, n);
    poly_coefficients_clear(&k);
}

/* The same of a function, which cannot hold any where it has no parameters. */
static void note(struct chain *c, expr_id g, unsigned of)
{
    if (g && !(state_facts(c->s, g) & EXPR_HAS_PARAMETER))
        return;
    struct poly_numerator *n = poly_numerator_new(c->s->st, g, &c->limits);
    note_by(c, n, of);
    poly_numerator_free(n);
    if (g && n)
        conditions_kernels(c->s, c->to, g, of);
}

static bool contains(struct chain *c, expr_id e, int symbol)
{
    struct state *s = c->s;
    expr_cone_of(s->st, &s->cone, &e, 1);
    for (int k = 0; k < s->cone.count; k++)
        if (s->cone.list[k] == s->st->symbol[symbol].node)
            return true;
    return false;
}

static expr_id replaced(struct chain *c, expr_id e, int symbol, expr_id value)
{
    struct expr_store *st = c->s->st;
    SGA_FREED expr_id *map = sga_calloc((size_t)st->symbols, sizeof *map);
    map[symbol] = value;
    expr_substitute(st, &e, 1, map);
    return e;
}

static int kind_of(struct chain *c, expr_id slope)
{
    unsigned f = state_facts(c->s, slope);
    return expr_is_const(c->s->st, slope) ? 0 : !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME)) ? 1 : f & EXPR_NONZERO ? 2 : 3;
}

/* Chooses the variable that the step's function is solved for: affine and with the plainest slope, otherwise of least degree. */
static void choose(struct chain *c, struct step *p)
{
    struct state *s = c->s;
    struct poly_numerator *n = poly_numerator_new(s->st, p->function, &c->limits);
    int least = 1000;
    for (int j = 0; j < s->sys->variables && least && n; j++) {
        expr_id *k;
        int degree;
        if (!poly_powers_of(n, s->st->symbol[s->variable[j]].node, &k, &degree))
            continue;
        int cost = degree == 1 ? kind_of(c, k[1]) : 10 * degree;
        if (degree >= 1 && cost < least) {
            least = cost;
            p->symbol = s->variable[j];
            p->slope = k[degree];
            p->value = degree == 1 ? expr_neg(s->st, expr_div(s->st, k[0], k[1])) : EXPR_UNDEF;
        }
        free(k);
    }
    poly_numerator_free(n);
    p->ready = true;
}

/* Where a x + b falls into factors, a and b have one in common: then x is free on a part of the set. */
static void note_common(struct chain *c, const struct step *p)
{
    struct state *s = c->s;
    if (!(state_facts(s, p->slope) & EXPR_HAS_VARIABLE) || state_facts(s, p->slope) & EXPR_NONZERO)
        return;
    expr_id rest = replaced(c, p->function, p->symbol, expr_int(s->st, 0)), r;
    for (int j = 0; j < s->sys->variables && rest; j++)
        if (contains(c, p->slope, s->variable[j]) && poly_resultant(s->st, p->slope, rest, s->variable[j], &c->limits, &r)
            && !expr_is_zero(s->st, r))
            note(c, r, 0);
}

/* One square more, or one branch less: where f has a factor twice. */
static void note_double(struct chain *c, const struct step *p)
{
    expr_id r, d = expr_diff(c->s->st, p->function, p->symbol);
    if (poly_resultant(c->s->st, p->function, d, p->symbol, &c->limits, &r) && !expr_is_zero(c->s->st, r))
        note(c, r, 0);
}

/* g with what the first `to` constraints determine eliminated; EXPR_UNDEF: it could not be. */
static expr_id eliminated(struct chain *c, expr_id g, int to)
{
    for (int i = 0; i < to && i < c->steps && g; i++) {
        struct step *p = c->step + i;
        if (!p->ready)
            choose(c, p);
        if (p->symbol < 0 || !contains(c, g, p->symbol))
            continue;
        p->used = true;
        if (p->value)
            g = replaced(c, g, p->symbol, p->value);
        else if (!poly_resultant(c->s->st, g, p->function, p->symbol, &c->limits, &g))
            g = EXPR_UNDEF;
    }
    return g;
}

static bool share_variables(struct chain *c, expr_id f, expr_id g)
{
    for (int j = 0; j < c->s->sys->variables; j++)
        if (contains(c, f, c->s->variable[j]) && contains(c, g, c->s->variable[j]))
            return true;
    return false;
}

/* Where the slope of an earlier constraint vanishes, the variables that are left in it are bound: together with f, which has some of
 * them, they may be bound twice. */
static void meet_earlier(struct chain *c, expr_id f)
{
    for (int i = 0; i < c->steps; i++) {
        struct step *p = c->step + i;
        if (p->used || !p->function || !(state_facts(c->s, p->function) & EXPR_HAS_PARAMETER) || !share_variables(c, f, p->function))
            continue;
        if (!p->ready)
            choose(c, p);
        p->used = p->symbol >= 0;
    }
}

static void add_step(struct chain *c, int i)
{
    struct state *s = c->s;
    expr_id f = eliminated(c, s->con[i], i), from = s->sol->constraint[i].replaced;
    if (f)
        meet_earlier(c, f);
    c->step[c->steps++] = (struct step){ .symbol = -1, .function = f, .ready = !f };
    if (!f)
        too_large(c);
    note(c, f, EXPR_HAS_VARIABLE);      /* its differential */
    if (from)
        note(c, eliminated(c, from, i), EXPR_HAS_VARIABLE);
}

/* f is affine in all variables, or a graph for all values of the parameters: there it is of one piece and regular. */
static bool plain(struct chain *c, expr_id f)
{
    struct state *s = c->s;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    bool affine = true, graph = false;
    state_activate(s);
    int n = expr_gradient(s->st, &s->cone, f, s->active, &term, &cap);
    for (int k = 0; k < n; k++) {
        unsigned d = state_facts(s, term[k].value);
        bool fixed = !(d & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME));
        affine = affine && fixed;
        graph = graph || (fixed && (d & EXPR_NONZERO || !(d & EXPR_HAS_PARAMETER)));
    }
    return affine || graph;
}

/* What holds of the constraints that are no graphs: whether anything is eliminated by them or not. */
static void note_shape(struct chain *c, struct step *p)
{
    if (!p->function || !(state_facts(c->s, p->function) & EXPR_HAS_PARAMETER) || plain(c, p->function))
        return;
    if (!p->ready)
        choose(c, p);
    if (p->symbol >= 0 && p->value && !(state_facts(c->s, p->slope) & EXPR_HAS_VARIABLE))
        note(c, p->slope, 0);
    else if (p->symbol >= 0 && p->value)
        note_common(c, p);
    else if (p->symbol >= 0)
        note_double(c, p);
}

/* A pivot, which stands on the set of the first `to` constraints. */
static void note_pivot(struct chain *c, expr_id value, int to)
{
    unsigned f = state_facts(c->s, value);
    if (expr_is_const(c->s->st, value) || f & EXPR_NONZERO || !expr_store_ok(c->s->st))
        return;
    note(c, eliminated(c, value, to), 0);
}

/* How many constraints stood when the elimination of a generation began. */
static int stood(const struct sga_solution *sol, int generation)
{
    int k = 0;
    while (k < sol->constraints && (sol->constraint[k].generation < generation || sol->constraint[k].origin == SGA_FROM_RESTRICTION))
        k++;
    return k;
}

static bool has_parameter(const struct state *s)
{
    for (int i = 0; i < s->sys->parameters; i++)
        if (s->st->symbol[s->sys->parameter[i]].kind == EXPR_PARAMETER)
            return true;
    return false;
}

void conditions_note(struct state *s, struct sga_conditions *to)
{
    struct sga_solution *sol = s->sol;
    struct chain c = { .s = s, .to = to };
    if (!has_parameter(s))
        return;
    if (sol->constraints > SGA_MOST_CONDITIONED) {
        sga_limit_met(s->options->budget, SGA_LIMIT_CONDITIONED);
        return;
    }
    c.limits = poly_limits_of(POLY_AMPLE, s->options->budget);
    c.step = sga_calloc((size_t)sol->constraints + 1, sizeof *c.step);
    for (int i = 0; i < sol->constraints; i++)
        add_step(&c, i);
    if (s->inconsistent)
        note_pivot(&c, sol->contradiction, c.steps);
    for (int q = 0; q < s->assumptions; q++)
        note(&c, s->assumed[q], 0);
    for (int q = 0; q < s->ech.pivots; q++)
        note_pivot(&c, s->ech.pivot[q].value, c.steps);
    for (int q = 0; q < sol->deads; q++)
        note_pivot(&c, sol->dead[q].value, stood(sol, sol->dead[q].generation));
    for (int i = 0; i < c.steps; i++) {
        note_shape(&c, c.step + i);
        if (c.step[i].used)
            note(&c, c.step[i].slope, 0);
    }
    free(c.step);
}
