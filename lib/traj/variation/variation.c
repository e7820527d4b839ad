/* The system of a motion and its derivatives: see variation.h. */
#include "variation.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "defined.h"
#include "derive.h"
#include "error.h"
#include "gauge_choice.h"
#include "mem.h"
#include "signal.h"
#include "switches.h"
#include "variation_along.h"

/* Symbols for the derivatives, and variables of v->system for all. */
static expr_id *add_variables(struct variation *v, const struct sys_system *sys, const struct variation_by *by)
{
    struct expr_store *st = sys->store;
    expr_id *slope = along_symbols(sys, by, v->directions);
    for (int j = 0; j < v->n; j++)
        sys_add_variable(&v->system, sys->variable[j].symbol, sys->variable[j].role);
    for (int k = 0; k < v->directions * v->n; k++)
        if (slope[k])
            sys_add_variable(&v->system, st->node[slope[k]].a, sys->variable[k % v->n].role);
    return slope;
}

/* The rows, and their derivatives: A S' + (A_x S + A_k) x' = alpha_x S + alpha_k. */
static void add_rows(struct variation *v, const struct sys_system *sys, struct variation_along *a)
{
    int q = v->directions, n = v->n;
    expr_id *to = sga_malloc(((size_t)q + 1) * sizeof *to);
    for (int i = 0; i < sys->rows && expr_store_ok(sys->store); i++) {
        const struct sys_row *r = sys->row + i;
        int base = sys_add_row(&v->system, r->alpha, r->source), first = v->system.rows;
        for (int k = 0; k < r->entries; k++)
            sys_add_entry(&v->system, base, r->entry[k].col, r->entry[k].value);
        along_of(a, r->alpha, to);
        for (int d = 0; d < q; d++)
            sys_add_row(&v->system, to[d], r->source);
        for (int k = 0; k < r->entries; k++) {
            along_of(a, r->entry[k].value, to);
            for (int d = 0; d < q; d++)
                sys_add_entry(&v->system, first + d, r->entry[k].col, to[d]);
        }
        for (int k = 0; k < r->entries; k++)
            for (int d = 0; d < q; d++)
                sys_add_entry(&v->system, first + d, n * (1 + d) + r->entry[k].col, r->entry[k].value);
    }
    free(to);
    assert(!expr_store_ok(sys->store) || v->system.rows == sys->rows * (1 + q));
}

/* Where the gauge is chosen the rows are the chosen field's. */
static void add_chosen_rows(struct variation *v, const struct sys_system *sys)
{
    for (int j = 0; j < v->n * (1 + v->directions); j++)
        sys_add_entry(&v->system, sys_add_row(&v->system, v->field[j], "the chosen field"), j, expr_int(sys->store, 1));
}

static void add_field(struct variation *v, const expr_id *root, struct variation_along *a)
{
    size_t n = (size_t)v->n, q = (size_t)v->directions;
    expr_id *to = sga_malloc((q + 1) * sizeof *to);
    v->field = sga_malloc((n * (1 + q) + 1) * sizeof *v->field);
    for (size_t j = 0; j < n; j++) {
        v->field[j] = root[j];
        along_of(a, root[j], to);
        for (size_t d = 0; d < q; d++)
            v->field[n * (1 + d) + j] = to[d];
    }
    free(to);
}

/* The constraints, each followed by its derivatives; what else of the solution a motion looks at. */
static void add_solution(struct variation *v, const struct sga_solution *sol, struct variation_along *a)
{
    struct sga_solution *to = &v->solution;
    int q = v->directions;
    *to = (struct sga_solution){ .verdict = SGA_UNIQUE, .generations = sol->generations, .dimension = sol->dimension, .field = v->field,
                                 .pivot = sol->pivot, .pivots = sol->pivots, .side = sol->side, .sides = sol->sides,
                                 .determinant = sol->determinant, .dense_blocks = sol->dense_blocks, .depends_on_time = sol->depends_on_time,
                                 .time_unit = sol->time_unit, .constraints = sol->constraints * (1 + q) };
    to->constraint = sga_calloc((size_t)to->constraints + 1, sizeof *to->constraint);
    expr_id *slope = sga_malloc(((size_t)q + 1) * sizeof *slope);
    for (int i = 0; i < sol->constraints; i++) {
        struct sga_constraint *c = to->constraint + (size_t)i * (size_t)(1 + q);
        along_of(a, sol->constraint[i].expr, slope);
        for (int d = 0; d <= q; d++)
            c[d] = (struct sga_constraint){ .expr = d ? slope[d - 1] : sol->constraint[i].expr, .generation = sol->constraint[i].generation,
                                            .origin = SGA_FROM_RESTRICTION, .restriction = -1, .source = -1 };
    }
    free(slope);
}

static void add_outputs(struct variation *v, const struct sys_system *sys, const struct traj_request *rq, struct variation_along *a)
{
    int outputs = v->outputs, q = v->directions;
    v->output = sga_malloc(((size_t)outputs * (size_t)(1 + q) + 1) * sizeof *v->output);
    for (int k = 0; k < outputs; k++) {
        expr_id e = rq->outputs ? rq->output[k] : sys->store->symbol[sys->variable[k].symbol].node;
        along_of(a, e, v->output + (size_t)k * (size_t)q);
        v->output[outputs * q + k] = e;
    }
}

/* Along the motion: e_x X + e_t. */
static expr_id rate_of(struct variation_along *a, const expr_id *field, expr_id e)
{
    struct expr_store *st = a->st;
    int terms = expr_gradient(st, &a->cone, e, a->active, &a->term, &a->cap);
    expr_id sum = expr_int(st, 0);
    for (int k = 0; k < terms; k++) {
        int j = a->variable_of[a->term[k].symbol];
        if (j >= 0)
            sum = expr_add(st, sum, expr_mul(st, a->term[k].value, field[j]));
    }
    return expr_add(st, sum, expr_time_partial(st, e, a->sys->time));       /* through tables too */
}

/* The switches of the motion, and whether it may jump at one: at sign anywhere in it, and at any switch of its constraints. */
static void add_turns(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, const expr_id *field, struct variation_along *a)
{
    struct expr_store *st = sys->store;
    int q = v->directions, all = 0;
    expr_id *root;
    int rows = sys_expressions(sys, &root);
    root = sga_realloc(root, (size_t)(rows + v->n + sol->constraints + 1) * sizeof *root);
    all = rows;
    for (int i = 0; i < sol->constraints; i++)
        root[all++] = sol->constraint[i].expr;
    struct num_switches w;
    num_switches_find(&w, st, root, all);
    v->may_jump = w.count > 0 && sol->constraints > 0;
    num_switches_clear(&w);
    for (int j = 0; j < v->n; j++)
        root[all++] = field[j];
    num_switches_find(&w, st, root, all);
    expr_cone_of(st, &a->cone, root, all);
    for (int k = 0; k < a->cone.count; k++)
        v->may_jump |= w.count > 0 && expr_op_of(st, a->cone.list[k]) == EXPR_SIGN;
    v->surface = sga_malloc(((size_t)w.count + 1) * sizeof *v->surface);
    v->slope = sga_malloc(((size_t)w.count * (size_t)q + 1) * sizeof *v->slope);
    v->rate = sga_malloc(((size_t)w.count + 1) * sizeof *v->rate);
    for (int e = 0; e < w.count; e++) {
        v->surface[e] = w.argument[e];
        along_of(a, w.argument[e], v->slope + (size_t)e * (size_t)q);
        v->rate[e] = rate_of(a, field, w.argument[e]);
    }
    v->turns = (struct traj_turns){ .base = v->n, .directions = q, .surface = v->surface, .surfaces = w.count, .slope = v->slope, .rate = v->rate, .jumps = v->may_jump };
    num_switches_clear(&w);
    free(root);
}

/* Events, what they set, and masses, along the directions. */
static void add_jumps(struct variation *v, const struct traj_request *rq, struct variation_along *a)
{
    size_t q = (size_t)v->directions, sets = 0, entries = rq->mass ? (size_t)rq->mass->entries : 0;
    for (int e = 0; e < rq->events; e++)
        sets += (size_t)rq->event[e].sets;
    v->event_slope = sga_malloc(((size_t)rq->events * q + 1) * sizeof *v->event_slope);
    v->set_slope = sga_malloc((sets * q + 1) * sizeof *v->set_slope);
    v->mass_slope = sga_malloc((entries * q + 1) * sizeof *v->mass_slope);
    sets = 0;
    for (int e = 0; e < rq->events; e++) {
        along_of(a, rq->event[e].expression, v->event_slope + (size_t)e * q);
        for (int k = 0; k < rq->event[e].sets; k++)
            along_of(a, rq->event[e].set[k].value, v->set_slope + sets++ * q);
    }
    for (size_t k = 0; k < entries; k++)
        along_of(a, rq->mass->value[k], v->mass_slope + k * q);
    v->slopes = (struct traj_slopes){ .base = v->n, .directions = v->directions, .event = v->event_slope, .set = v->set_slope, .mass = v->mass_slope };
}

static void add_request(struct variation *v, const struct traj_request *rq, const expr_id *guess, int whole)
{
    size_t n = (size_t)v->n, all = n * (size_t)(1 + v->directions);
    v->guess = sga_calloc(n + 1, sizeof *v->guess);
    v->guessed = sga_calloc(n + 1, 1);
    v->kept = sga_calloc(n + 1, 1);
    v->initial = sga_calloc(all + 1, sizeof *v->initial);
    v->given = sga_calloc(all + 1, 1);
    v->held = sga_calloc(all + 1, 1);
    v->exact = sga_calloc(all + 1, sizeof *v->exact);
    for (size_t j = 0; j < n; j++) {
        int from = v->of_defined ? v->defined->variable[j] : (int)j;
        v->guess[j] = rq->initial[j];
        v->guessed[j] = rq->given[j];
        v->kept[j] = rq->held ? rq->held[j] : 0;
        v->exact[j] = rq->exact_initial ? rq->exact_initial[j] : EXPR_UNDEF;
        for (int d = 0; d < v->directions; d++)
            v->exact[n * (size_t)(1 + d) + j] = guess[(size_t)d * (size_t)whole + (size_t)from];
    }
    v->request = *rq;
    v->request.initial = v->initial;
    v->request.given = v->given;
    v->request.held = v->held;
    v->request.on = NULL;
    v->request.rates = 0;
    v->request.conditions = false;
    v->request.output = v->output;
    v->request.outputs = v->outputs * (1 + v->directions);
    v->request.beside = NULL;
    v->request.events = v->jumps ? rq->events : 0;
    v->request.mass = v->jumps ? rq->mass : NULL;
    v->request.modes = NULL;
    v->request.slopes = v->jumps ? &v->slopes : NULL;
    v->request.integrals = 0;
    v->request.rows_until = 0;
    v->request.exact_initial = v->exact;
    v->request.turns = v->turns.surfaces ? &v->turns : NULL;
}

bool variation_make(struct variation *v, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq,
                    const struct variation_by *by, int directions, const expr_id *guess, struct sga_error *err)
{
    int whole = sys->variables;
    *v = (struct variation){ .jumps = traj_in_pieces(rq), .by = by, .directions = directions };
    v->of_defined = !v->jumps && defined_any(sol, rq);      /* what events set may be defined */
    sys_init(&v->system, sys->store);
    if (v->of_defined) {
        v->defined = sga_calloc(1, sizeof *v->defined);
        defined_init(v->defined, sys, sol, rq);
        sys = &v->defined->system;
        sol = &v->defined->solution;
        rq = &v->defined->request;
    }
    v->n = sys->variables;
    v->outputs = rq->outputs ? rq->outputs : v->n;
    v->system.time = sys->time;
    for (int i = 0; i < sys->parameters; i++)
        sys_add_parameter(&v->system, sys->parameter[i]);
    for (int i = 0; i < sys->signals; i++)
        sys_add_signal(&v->system, sys->signal[i]);
    struct gauge_choice choice;
    gauge_choice_make(&choice, sys, sol, rq);
    bool ok = !choice.why;
    if (!ok)
        sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/sensitivities", "the motion is chosen by solving equations at each step (%s), so that there are no expressions to differentiate; fix "
                    "what is free by trajectory.gauge", choice.why);
    expr_id *slope = add_variables(v, sys, by);
    struct variation_along a;
    along_begin(&a, sys, by, directions, slope);
    if (ok && expr_store_ok(sys->store)) {
        const expr_id *root = choice.field ? choice.field : sol->field;
        add_field(v, root, &a);
        if (choice.field)
            add_chosen_rows(v, sys);
        else
            add_rows(v, sys, &a);
        add_solution(v, sol, &a);
        add_outputs(v, sys, rq, &a);
        add_turns(v, sys, sol, root, &a);
        if (v->jumps)
            add_jumps(v, rq, &a);
        add_request(v, rq, guess, whole);
        if (rq->relations && rq->arithmetic == TRAJ_BALL && !v->of_defined)
            ok = variation_relations(v, sys, sol, rq, &a, err);
    }
    along_end(&a);
    gauge_choice_clear(&choice);
    free(slope);
    if (ok && !expr_store_ok(sys->store)) {
        *err = *sys->store->error;
        ok = false;
    }
    assert(!ok || sys_sane(&v->system));
    assert(!ok || (v->system.variables == v->n * (1 + directions) && v->solution.constraints % (1 + directions) == 0));
    return ok;
}

void variation_clear(struct variation *v)
{
    if (v->of_defined)
        defined_clear(v->defined);
    free(v->defined);
    sys_clear(&v->system);
    free(v->solution.constraint);
    free(v->relation);
    free(v->field);
    free(v->guess);
    free(v->guessed);
    free(v->kept);
    free(v->initial);
    free(v->given);
    free(v->held);
    free(v->exact);
    free(v->output);
    free(v->surface);
    free(v->slope);
    free(v->rate);
    free(v->event_slope);
    free(v->set_slope);
    free(v->mass_slope);
}
