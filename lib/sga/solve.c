/* The main loop of the stabilization general algorithm. */
#include "affine.h"
#include "block.h"
#include "budget.h"
#include "conditions.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "alike.h"
#include "arena.h"
#include "derive.h"
#include "domain.h"
#include "error.h"
#include "facts.h"
#include "guess.h"
#include "mem.h"
#include "natural.h"
#include "oracle.h"
#include "reduction.h"
#include "regular_options.h"
#include "regular_shape.h"
#include "sides.h"
#include "state.h"
#include "system.h"
#include "warnings.h"

const char *sga_verdict_text(enum sga_verdict v)
{
    static const char *const text[] = { "unique", "underdetermined", "isolated", "inconsistent" };
    return text[v];
}

void sga_conditions_clear(struct sga_conditions *c)
{
    for (int i = 0; i < c->count; i++)
        free(c->at[i].function);
    free(c->at);
    *c = (struct sga_conditions){ 0 };
}

void sga_rates_drop(struct sga_solution *sol)
{
    while (sol->rates)
        free(sol->rate[--sol->rates].part);
}

void sga_solution_clear(struct sga_solution *sol)
{
    sga_rates_drop(sol);
    free(sol->rate);
    for (int i = 0; i < sol->constraints; i++)
        free(sol->constraint[i].part);
    for (int i = 0; i < sol->dense_blocks; i++) {
        free(sol->determinant[i].col);
        free(sol->determinant[i].source);
    }
    free(sol->determinant);
    free(sol->side);
    free(sol->scale);
    free(sol->definition);
    free(sol->constraint);
    free(sol->dimension);
    free(sol->pivot);
    free(sol->field);
    free(sol->free_column);
    free(sol->gauge);
    free(sol->branch);
    free(sol->dead);
    free(sol->special);
    free(sol->other);
    free(sol->contradiction_part);
    for (int i = 0; i < sol->vanished_rows; i++)
        free(sol->vanished[i].part);
    free(sol->vanished);
    for (int i = 0; i < sol->elsewheres; i++)
        free(sol->elsewhere[i].x);
    free(sol->elsewhere);
    sga_conditions_clear(&sol->conditions);
    *sol = (struct sga_solution){ 0 };
}

int sga_stages(const struct sga_solution *sol, int constraints, int *end)
{
    assert(constraints <= sol->constraints);
    int stages = 0;
    for (int i = 0; i < constraints; i++)
        if (i + 1 == constraints || sol->constraint[i + 1].generation != sol->constraint[i].generation)
            end[stages++] = i + 1;
    assert(stages <= constraints && (!stages || end[stages - 1] == constraints));
    return stages;
}

/* What was not given leaves the guess first; what follows from others, as names of signals do, before what moves by itself. */
static signed char *move_cheaply(struct sga_arena *mem, const struct sys_system *sys, const unsigned char *given)
{
    enum { MOVING = 5, FOLLOWING = 10 };
    signed char *cheap = sga_zeros(mem, (size_t)sys->variables + 1, 1);
    SGA_FREED unsigned char *moving = guess_moving(sys);
    for (int j = 0; j < sys->variables; j++)
        cheap[j] = given[j] ? 0 : moving[j] ? MOVING : FOLLOWING;
    return cheap;
}

static void state_init(struct state *s, const struct sys_system *sys, const struct reduction_options *options,
                       struct points_oracle *oracle, struct route *route, struct sga_solution *sol, struct sga_error *err)
{
    int n = sys->variables;
    struct expr_store *st = sys->store;
    *s = (struct state){ .sys = sys, .options = options, .st = st, .oracle = oracle, .sol = sol, .err = err,
                         .route = route };
    *sol = (struct sga_solution){ 0 };
    expr_flow_init(s->flow = sga_take(&s->mem, sizeof *s->flow), st);
    expr_facts_init(s->facts = sga_take(&s->mem, sizeof *s->facts));
    s->alike = poly_alike_new(st);
    expr_cone_init(&s->cone);
    s->domain = sga_take(&s->mem, sizeof *s->domain);
    *s->domain = (struct domain){ .system = sys, .facts = s->facts, .cone = &s->cone, .budget = options->budget };
    ech_init(&s->ech, n);
    s->parameter_symbol = sys->parameter;
    s->variable = sga_take(&s->mem, (size_t)n * sizeof *s->variable);
    s->column = sga_take(&s->mem, (size_t)st->symbols * sizeof *s->column);
    for (int i = 0; i < st->symbols; i++)
        s->column[i] = -1;
    for (int j = 0; j < n; j++) {
        s->variable[j] = sys->variable[j].symbol;
        s->column[s->variable[j]] = j;
    }
    s->determined = sga_zeros(&s->mem, (size_t)n, 1);
    s->space = (struct points_space){
        .st = st, .variable = s->variable, .variables = n, .parameter = sys->parameter,
        .parameters = sys->parameters, .parameter_near = options->parameter_near, .time = sys->time, .near = options->near, .near_spread = options->near_spread,
        .near_time = options->near_time, .budget = options->budget,
    };
    s->space.defineds = sys_expressions(sys, &s->defined);
    s->space.defined = sga_keep(&s->mem, s->defined);
    s->space.scale = sol->scale = natural_sizes(sys, &sol->time_unit);
    s->space.time_unit = sol->time_unit;
    if (options->near && options->near_given)
        s->space.cheap = s->cheap = move_cheaply(&s->mem, sys, options->near_given);
    s->ctx = (struct ech_context){ .st = st, .facts = s->facts, .oracle = oracle, .near = options->near, .near_given = options->near_given, .near_time = options->near_time,
                                   .near_pivots = options->near && options->near_pivots, .wait = options->near && options->near_pivots, .budget = options->budget, .record = true, .err = err };
}

static void state_clear(struct state *s)
{
    expr_flow_clear(s->flow);
    expr_facts_clear(s->facts);
    poly_alike_free(s->alike);
    expr_cone_clear(&s->cone);
    ech_clear(&s->ech);
    state_clear_waiting(s);
    sga_arena_end(&s->mem);
}

bool state_dimension(struct state *s)
{
    int limit = s->options->budget && s->options->budget->max_generations ? s->options->budget->max_generations : 1000;
    struct sga_solution *sol = s->sol;
    if (s->held.code != SGA_E_OK)         /* one of its constraints is not known */
        return true;
    sol->dimension = sga_realloc(sol->dimension, (size_t)(sol->generations + 1) * sizeof *sol->dimension);
    sol->dimension[sol->generations++] = s->sys->variables - sol->constraints;
    assert(sol->generations == 1 || sol->dimension[sol->generations - 1] < sol->dimension[sol->generations - 2]);
    return sol->generations < limit || sga_fail(s->err, SGA_E_LIMIT_GENERATIONS,
        "after %d generations new constraints still appear; the limit is limits.generations", limit);
}

void state_push(struct state *s, const struct sga_constraint *c)
{
    assert(c->expr && c->generation >= 1);
    struct sga_solution *sol = s->sol;
    SGA_RESERVE(sol->constraint, s->constraint_cap, sol->constraints + 1);
    SGA_RESERVE_IN(&s->mem, s->con, s->con_cap, sol->constraints + 1);
    s->con[sol->constraints] = c->expr;
    sol->constraint[sol->constraints] = *c;
    sol->constraint[sol->constraints++].epoch = s->epoch;
}

void state_forget(struct state *s)
{
    struct sga_solution *sol = s->sol;
    while (sol->constraints)
        free(sol->constraint[--sol->constraints].part);
    while (sol->vanished_rows)
        free(sol->vanished[--sol->vanished_rows].part);
    sga_rates_drop(sol);
    sol->generations = sol->redundant_rows = 0;
    s->inconsistent = false;
}

static bool depends_on_time(struct state *s)
{
    unsigned f = 0;
    for (int i = 0; i < s->sys->rows; i++) {
        f |= state_facts(s, s->sys->row[i].alpha);
        for (int k = 0; k < s->sys->row[i].entries; k++)
            f |= state_facts(s, s->sys->row[i].entry[k].value);
    }
    for (int i = 0; i < s->sol->constraints; i++)
        f |= state_facts(s, s->con[i]);
    return f & EXPR_HAS_TIME;
}

/* Whether everything in the system has a value at the present points. */
static bool in_domain(struct state *s)
{
    for (int k = 0; k < s->oracle->reals; k++) {
        struct num_ball *b = &s->oracle->real[k].ball;
        num_ball_extend(b);
        for (int i = 0; i < s->sys->rows; i++) {
            const struct sys_row *r = s->sys->row + i;
            bool ok = arb_is_finite(num_ball_value(b, r->alpha));
            for (int q = 0; q < r->entries && ok; q++)
                ok = arb_is_finite(num_ball_value(b, r->entry[q].value));
            if (!ok)
                return false;
        }
        for (int i = 0; i < s->sys->restrictions; i++)
            if (!arb_is_finite(num_ball_value(b, s->sys->restriction[i])))
                return false;
    }
    return true;
}

enum points_status state_sample_defined(struct state *s)
{
    enum points_status status = state_sample(s);
    for (int k = 0; k < SGA_MOST_DOMAIN_TRIES && status == POINTS_OK && !in_domain(s); k++) {
        points_oracle_forget(s->oracle);
        status = state_sample(s);
    }
    if (status == POINTS_OK && !in_domain(s))
        sga_limit_met(s->options->budget, SGA_LIMIT_DOMAIN_TRIES);
    return status;
}

static bool start(struct state *s, int *added)
{
    enum points_status status = state_sample_defined(s);
    if (status == POINTS_STOPPED)
        return sga_budget_ok(s->options->budget, s->err);
    if (status != POINTS_OK && s->oracle->sides)
        return sga_fail(s->err, SGA_E_NO_REAL_POINT, "no point was found on a side of the equations' switches; give trajectory.initial there");
    if (status != POINTS_OK)
        return sga_fail(s->err, SGA_E_INTERNAL, "no point of the whole space could be made");
    int n = s->sys->restrictions;
    SGA_FREED struct candidate *cand = sga_calloc((size_t)n + 1, sizeof *cand);
    for (int i = 0; i < n; i++)
        cand[i] = (struct candidate){ .expr = s->sys->restriction[i], .base = s->sys->restriction[i],
                                      .origin = SGA_FROM_RESTRICTION, .source = -1, .restriction = i };
    *added = n ? state_admit(s, cand, n, 1) : 0;
    return *added >= 0;
}

/* Whether nothing was divided by that may vanish: then a contradiction holds wherever the equations do, and not only at
 * general points of constraints of which one was held back. */
static bool divided_safely(struct state *s)
{
    bool safe = !s->sol->deads && !s->ech.blocks;
    for (int q = 0; q < s->ech.pivots && safe; q++)
        safe = state_facts(s, s->ech.pivot[q].value) & EXPR_NONZERO;
    for (int i = 0; i < s->sol->constraints && safe; i++)
        safe = !s->sol->constraint[i].chosen && !s->sol->constraint[i].near_point;
    return safe;
}

static bool run(struct state *s)
{
    int added = 0, more, done = 0;
    if (!start(s, &added))
        return false;
    if (s->inconsistent) {
        s->sol->empty_restriction = true;
        return true;
    }
    more = state_generation(s, 0, 0, 1);      /* compatibility on the zero set of the restriction */
    if (more < 0)
        return false;
    for (added += more; added && !s->inconsistent; ) {
        if (!state_dimension(s))
            return false;
        int from = done;
        done = s->sol->constraints;
        added = state_generation(s, from, done, s->sol->generations + 1);
        if (added < 0)
            return false;
    }
    if (s->held.code != SGA_E_OK && !(s->inconsistent && divided_safely(s))) {
        *s->err = s->held;
        return false;
    }
    if (!s->inconsistent)
        state_fields(s);
    return true;
}

/* A contradiction that rests on one side of a surface says nothing of the other, where points of the constraints are known to
 * lie. */
static bool contradiction_on_side(struct state *s)
{
    const struct points_side *side = s->oracle->side;
    int k = 0;
    while (k < s->oracle->sides && side[k].unseen)
        k++;
    if (k == s->oracle->sides)
        return true;
    side += k;
    SGA_FREED char *text = state_text(s, side->function);
    sga_fail(s->err, SGA_E_SPLIT, "where %s %s 0 the equations contradict each other; what holds on the other side was not "
             "looked at; give trajectory.initial there, or write the system for the side that is meant", text, side->sign > 0 ? ">" : "<");
    return false;
}

/* T_m Pf = 0, so the reduction asked alpha(m) = 0, and the velocities are 0: asked again of the field. */
static int at_rest(struct state *s)
{
    int rest = 1;
    for (int i = 0; i < s->sys->variables && rest == 1; i++) {
        struct points_decision d = points_oracle_zero(s->oracle, s->sol->field[i]);
        rest = d.truth == POINTS_ZERO ? 1 : d.truth == POINTS_NONZERO ? 0 : -1;
    }
    return rest;
}

static void keep_determinants(struct state *s)
{
    assert(ech_sane(&s->ech));
    struct sga_solution *sol = s->sol;
    sol->dense_blocks = s->ech.blocks;
    sol->determinant = sga_calloc((size_t)s->ech.blocks + 1, sizeof *sol->determinant);
    for (int q = 0; q < s->ech.blocks; q++) {
        const struct ech_dense *b = s->ech.block + q;
        struct sga_determinant *d = sol->determinant + q;
        d->size = b->size;
        d->value = ech_block_test(s->st, b, &d->solve);
        d->col = sga_malloc((size_t)b->size * sizeof *d->col);
        d->source = sga_malloc((size_t)b->size * sizeof *d->source);
        for (int k = 0; k < b->size; k++) {
            d->col[k] = s->ech.pivot[b->first + k].col;
            d->source[k] = s->ech.pivot[b->first + k].row.source;
        }
    }
}

/* How many of the first constraints cut out a set of one piece: each is affine like all before it, or has exactly one
 * zero over each point of the set before it (regular_fresh_graph). */
static int one_piece(struct state *s)
{
    SGA_FREED unsigned char *met = sga_calloc((size_t)s->st->symbols, 1);
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    bool affine = true, fresh = true;
    int i = 0;
    state_activate(s);
    for (; i < s->sol->constraints && (affine || fresh); i++) {
        int n = expr_gradient(s->st, &s->cone, s->con[i], s->active, &term, &cap);
        fresh = false;
        for (int k = 0; k < n; k++) {
            unsigned f = state_facts(s, term[k].value);
            bool plain = !(f & (EXPR_HAS_VARIABLE | EXPR_HAS_TIME));
            affine = affine && !(f & EXPR_HAS_VARIABLE);
            fresh = fresh || (!met[term[k].symbol] && (plain || (f & EXPR_NONZERO && !regular_depends(s, term[k].value, term[k].symbol))));
        }
        expr_cone_of(s->st, &s->cone, s->con + i, 1);
        for (int k = 0; k < s->cone.count; k++) {
            if (expr_op_of(s->st, s->cone.list[k]) == EXPR_SYM)
                met[s->st->node[s->cone.list[k]].a] = 1;
            if (points_switches(expr_op_of(s->st, s->cone.list[k])))
                affine = fresh = false;         /* one piece, but not one analytic function */
        }
    }
    return affine || fresh ? i : i - 1;
}

static void conclude(struct state *s)
{
    struct sga_solution *sol = s->sol;
    sol->one_piece = one_piece(s);
    if (s->inconsistent) {
        sol->verdict = SGA_INCONSISTENT;
    } else {
        sol->depends_on_time = depends_on_time(s);
        bool point = sol->constraints == s->sys->variables;
        sol->verdict = sol->free_columns ? SGA_UNDERDETERMINED
                       : point && !sol->depends_on_time ? SGA_ISOLATED : SGA_UNIQUE;
        if (sol->verdict == SGA_ISOLATED)
            sol->equilibrium = at_rest(s);
    }
    keep_determinants(s);
    sol->exact = s->affine;
    sol->sides = s->oracle->sides;
    sol->sides_not_searched = points_oracle_cut_short(s->oracle);
    if (sol->sides)
        sol->side = memcpy(sga_malloc((size_t)sol->sides * sizeof *sol->side), s->oracle->side, (size_t)sol->sides * sizeof *sol->side);
    if (s->affine)           /* it has listed its pivots */
        return;
    sol->pivot = sga_malloc((size_t)(s->ech.pivots + s->assumptions + 1) * sizeof *sol->pivot);
    for (int q = 0; q < s->ech.pivots; q++)
        sol->pivot[sol->pivots++] = (struct sga_pivot){ s->ech.pivot[q].col, s->ech.pivot[q].value,
                                                        s->ech.pivot[q].generation, s->ech.pivot[q].row.source };
    for (int q = 0; q < s->assumptions; q++)
        sol->pivot[sol->pivots++] = (struct sga_pivot){ -1, s->assumed[q], 0, -1 };
}

/* The sides that the route takes. */
static void take_sides(struct state *s)
{
    struct points_oracle *w = s->oracle;
    w->sides = 0;
    for (int i = 0; i < s->route->count; i++) {
        const struct decision *d = s->route->at + i;
        if (!d->side)
            continue;
        SGA_RESERVE(w->side, w->side_cap, w->sides + 1);
        w->side[w->sides++] = (struct points_side){ d->product, d->chosen ? -d->side : d->side, false };
    }
}

static bool has_branches(const struct route *r)
{
    bool has = false;
    for (int i = 0; i < r->count; i++)
        has |= !r->at[i].side && r->at[i].options > 1;
    return has;
}

bool state_solve_as_is(const struct sys_system *system, const struct reduction_options *options, struct points_oracle *oracle,
                 struct route *route, struct sga_solution *solution, struct sga_error *err)
{
    SGA_ENDS(state_clear) struct state s;
    state_init(&s, system, options, oracle, route, solution, err);
    oracle->zeros = 0;
    take_sides(&s);
    points_oracle_forget_cut(oracle);
    struct affine affine;
    s.affine = affine_read(&affine, &s);
    bool ok = s.affine ? affine_reduce(&s, &affine) : run(&s);
    if (s.affine)
        affine_clear(&affine);
    if (ok && !expr_store_ok(s.st)) {
        *err = *s.st->error;
        ok = false;
    }
    if (ok && s.inconsistent && oracle->sides)
        ok = contradiction_on_side(&s);
    if (ok && options->conditions)
        conditions_note(&s, options->conditions);
    bool measured = ok && options->near && !s.inconsistent && has_branches(route);
    route->far = measured ? guess_distance_of_set(&s) : -1;
    route->off = measured && route->far > 0 && guess_is_off(&s);
    if (ok)
        conclude(&s);
    else if (!err->stage[0])
        memcpy(err->stage, "sga", 4);
    assert(!ok || sga_solution_sane(system, solution));
    return ok;
}
