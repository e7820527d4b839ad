/* The answer for the system without the variables that equations define becomes that of the whole. */
#include "definition_flat.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "natural.h"
#include "oracle.h"
#include "reduction.h"
#include "set_points.h"
#include "system.h"

struct lift {
    struct sga_arena mem;          /* of value and plain */
    const struct definitions *d;
    const struct sys_system *sys;
    struct sga_solution *sol;
    int rows;                      /* of what is left */
    expr_id *value;                /* by definition: its function, or where that has no derivative one that is equal on the set */
    unsigned char *plain;          /* by definition: the row has no derivative there, and `v - value` is the constraint */
};

/* s = sqrt(x y) where x stays 0: the variable itself is the constraint. Only where the set is that of the first generation, on which
 * definitions are listed. */
static void find_values(struct lift *l, struct points_oracle *oracle)
{
    const struct definitions *d = l->d;
    bool ask = l->sol->generations <= 1 && oracle->reals && l->sol->verdict != SGA_INCONSISTENT;
    l->value = sga_zeros(&l->mem, (size_t)d->count + 1, sizeof *l->value);
    l->plain = sga_zeros(&l->mem, (size_t)d->count + 1, 1);
    for (int i = 0; i < d->count; i++) {
        const struct definition *f = d->at + i;
        l->value[i] = f->value;
        if (!ask)
            continue;
        if (!definition_smooth(d, l->sys, oracle, f->value))
            l->value[i] = definition_flattened(d, l->sys, oracle, f->value);
        l->plain[i] = l->value[i] != f->value || !definition_smooth(d, l->sys, oracle, l->sys->row[f->row].alpha);
    }
}

/* Of a row of what is left, or rows + a constraint. */
static int source_of(const struct lift *l, int source)
{
    if (source < 0)
        return source;
    return source < l->rows ? l->d->row[source] : l->sys->rows + l->d->count + source - l->rows;
}

static void lift_parts(const struct lift *l, struct sga_part *part, int parts)
{
    for (int k = 0; k < parts; k++) {
        part[k].row = part[k].row < 0 ? -1 : l->d->row[part[k].row];
        part[k].tangency = part[k].tangency < 0 ? -1 : part[k].tangency + l->d->count;
    }
}

static void lift_pivots(const struct lift *l, struct sga_pivot *p, int pivots)
{
    for (int q = 0; q < pivots; q++) {
        p[q].source = source_of(l, p[q].source);
        p[q].col = p[q].col < 0 ? -1 : l->d->variable[p[q].col];
    }
}

/* The definitions come first among the constraints. */
static void lift_constraints(const struct lift *l, bool combinations)
{
    assert(l->sol->constraints <= l->sys->variables - l->d->count + (l->sol->verdict == SGA_INCONSISTENT));
    struct sga_solution *s = l->sol;
    int k = l->d->count;
    struct sga_constraint *all = sga_calloc((size_t)(k + s->constraints) + 1, sizeof *all);
    for (int i = 0; i < k; i++) {
        const struct definition *f = l->d->at + i;
        expr_id e = l->sys->row[f->row].alpha;
        expr_id own = f->rest ? f->rest : e;
        all[i] = (struct sga_constraint){ .expr = own, .generation = 1, .origin = SGA_FROM_ROWS, .restriction = -1, .base = own, .source = f->row,
                                          .replaced = f->rest ? e : EXPR_UNDEF };
        if (l->plain[i]) {
            expr_id v = l->sys->store->symbol[l->sys->variable[f->variable].symbol].node;
            all[i].replaced = e;
            all[i].expr = all[i].base = expr_sub(l->sys->store, v, l->value[i]);
        }
        if (!combinations)
            continue;
        all[i].part = sga_malloc(sizeof *all[i].part);
        all[i].parts = 1;
        all[i].part[0] = (struct sga_part){ .row = f->row, .tangency = -1, .factor = expr_int(l->sys->store, 1) };     /* of what was replaced */
    }
    for (int i = 0; i < s->constraints; i++) {
        all[k + i] = s->constraint[i];
        all[k + i].source = source_of(l, s->constraint[i].source);
        lift_parts(l, all[k + i].part, all[k + i].parts);
    }
    free(s->constraint);
    s->constraint = all;
    s->constraints += k;
    lift_parts(l, s->contradiction_part, s->contradiction_parts);
    for (int i = 0; i < s->branches; i++)
        s->branch[i].before += k;
    for (int i = 0; i < s->vanished_rows; i++) {
        s->vanished[i].source = source_of(l, s->vanished[i].source);
        lift_parts(l, s->vanished[i].part, s->vanished[i].parts);
    }
    if (s->generations || s->verdict == SGA_INCONSISTENT)
        return;
    s->dimension = sga_realloc(s->dimension, sizeof *s->dimension);
    s->dimension[s->generations++] = l->sys->variables - k;
}

/* Of its row, where that is 0. */
static expr_id slope_of(const struct lift *l, const struct definition *f)
{
    return f->factor ? expr_mul(l->sys->store, f->slope, f->factor) : f->slope;
}

static void lift_elimination(const struct lift *l)
{
    struct sga_solution *s = l->sol;
    lift_pivots(l, s->pivot, s->pivots);
    lift_pivots(l, s->dead, s->deads);
    s->pivot = sga_realloc(s->pivot, (size_t)(s->pivots + l->d->count + 1) * sizeof *s->pivot);
    for (int i = 0; i < l->d->count; i++)
        s->pivot[s->pivots++] = (struct sga_pivot){ l->d->at[i].variable, slope_of(l, l->d->at + i), 2, l->sys->rows + i };
    for (int q = 0; q < s->dense_blocks; q++)
        for (int i = 0; i < s->determinant[q].size; i++) {
            s->determinant[q].col[i] = l->d->variable[s->determinant[q].col[i]];
            s->determinant[q].source[i] = source_of(l, s->determinant[q].source[i]);
        }
    for (int i = 0; i < s->free_columns; i++)
        s->free_column[i] = l->d->variable[s->free_column[i]];
}

/* Components by the whole's variables, those that are defined by `defined`; malloced. */
static void spread(const struct lift *l, const expr_id *left, const expr_id *defined, expr_id *whole)
{
    for (int j = 0; j < l->sys->variables - l->d->count; j++)
        whole[l->d->variable[j]] = left[j];
    for (int i = 0; i < l->d->count; i++)
        whole[l->d->at[i].variable] = defined[i];
}

/* v' = f'(X). */
static void lift_field(const struct lift *l)
{
    const struct sys_system *sys = l->sys;
    expr_id *whole = sga_malloc(((size_t)sys->variables + 1) * sizeof *whole);
    SGA_FREED expr_id *rate = sga_malloc(((size_t)l->d->count + 1) * sizeof *rate);
    SGA_ENDS(expr_flow_clear) struct expr_flow flow;
    expr_flow_init(&flow, sys->store);
    for (int j = 0; j < sys->variables - l->d->count; j++)
        expr_flow_determine(&flow, sys->variable[l->d->variable[j]].symbol, l->sol->field[j]);
    for (int i = 0; i < l->d->count; i++)
        rate[i] = expr_flow_coefficient(&flow, l->value[i], 1);
    spread(l, l->sol->field, rate, whole);
    free(l->sol->field);
    l->sol->field = whole;
}

static void lift_gauge(const struct lift *l)
{
    const struct sys_system *sys = l->sys;
    struct expr_store *st = sys->store;
    int n = sys->variables, left = n - l->d->count, fields = l->sol->free_columns;
    SGA_ARENA(mem);
    expr_id *whole = sga_malloc(((size_t)fields * (size_t)n + 1) * sizeof *whole);
    expr_id *along = sga_take(&mem, ((size_t)l->d->count + 1) * sizeof *along);
    int *place = sga_take(&mem, ((size_t)st->symbols + 1) * sizeof *place);
    unsigned char *active = sga_zeros(&mem, (size_t)st->symbols + 1, 1);
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    expr_cone_init(&cone);
    for (int j = 0; j < left; j++) {
        place[sys->variable[l->d->variable[j]].symbol] = j;
        active[sys->variable[l->d->variable[j]].symbol] = 1;
    }
    for (int f = 0; f < fields; f++) {
        const expr_id *Y = l->sol->gauge + (size_t)f * (size_t)left;
        for (int i = 0; i < l->d->count; i++) {
            int terms = expr_gradient(st, &cone, l->value[i], active, &term, &cap);
            along[i] = expr_int(st, 0);
            for (int k = 0; k < terms; k++)
                along[i] = expr_add(st, along[i], expr_mul(st, term[k].value, Y[place[term[k].symbol]]));
        }
        spread(l, Y, along, whole + (size_t)f * (size_t)n);
    }
    free(l->sol->gauge);
    l->sol->gauge = whole;
}

static void lift_verdict(const struct lift *l)
{
    struct sga_solution *s = l->sol;
    SGA_ENDS(expr_facts_clear) struct expr_facts facts;
    expr_facts_init(&facts);
    for (int i = 0; i < l->d->count; i++)
        s->depends_on_time |= (expr_facts_of(&facts, l->sys->store, l->d->at[i].value) & EXPR_HAS_TIME) != 0;
    if (s->verdict == SGA_ISOLATED && s->depends_on_time) {
        s->verdict = SGA_UNIQUE;
        s->equilibrium = 0;
    }
}

static void keep_definitions(const struct lift *l)
{
    struct sga_solution *s = l->sol;
    s->definition = sga_malloc(((size_t)l->d->count + 1) * sizeof *s->definition);
    for (int i = 0; i < l->d->count; i++)
        s->definition[s->definitions++] = (struct sga_definition){ l->d->at[i].variable, l->d->at[i].row, l->d->at[i].value };
}

/* The first point that the oracle has, with the values of what is defined there. False: it has none. */
static bool known_point(const struct lift *l, struct points_oracle *oracle, double *x, double *t)
{
    if (!oracle->reals)
        return false;
    struct points_point *p = oracle->real;
    num_ball_extend(&p->ball);
    for (int j = 0; j < l->sys->variables - l->d->count; j++)
        x[l->d->variable[j]] = p->x[j];
    for (int i = 0; i < l->d->count; i++)
        x[l->d->at[i].variable] = arf_get_d(arb_midref(num_ball_value(&p->ball, l->d->at[i].value)), ARF_RND_NEAR);
    *t = p->t;
    return true;
}

/* New points on the whole's final set, near those of what is left. */
static bool sample(const struct lift *l, const struct reduction_options *options, struct points_oracle *oracle)
{
    const struct sys_system *sys = l->sys;
    SGA_FREED double *x = sga_calloc((size_t)sys->variables + 1, sizeof *x);
    double t = options->near_time;
    SGA_FREED expr_id *defined = NULL;
    SGA_ENDS(set_points_clear) struct set_points on;
    set_points_init(&on, sys, l->sol, l->sol->constraints, 0, 0);
    on.space.near = known_point(l, oracle, x, &t) ? x : options->near;
    on.space.near_time = t;
    on.space.parameter_near = options->parameter_near;
    on.space.scale = l->sol->scale;
    on.space.time_unit = l->sol->time_unit;
    on.space.budget = options->budget;
    on.space.defineds = sys_expressions(sys, &defined);
    on.space.defined = defined;
    points_oracle_forget(oracle);
    bool ok = points_oracle_sample(oracle, &on.space) == POINTS_OK || l->sol->verdict == SGA_INCONSISTENT;
    if (!ok && on.space.near) {           /* what is defined has no value there */
        on.space.near = NULL;
        points_oracle_forget(oracle);
        ok = points_oracle_sample(oracle, &on.space) == POINTS_OK;
    }
    oracle->space.near = NULL;         /* these end here */
    return ok;
}

bool definitions_lift(const struct definitions *d, const struct sys_system *system, const struct reduction_options *options,
                      struct points_oracle *oracle, struct sga_solution *solution)
{
    assert(d->count > 0 && d->count <= system->rows && d->count <= system->variables);
    struct lift l = { .d = d, .sys = system, .sol = solution, .rows = system->rows - d->count };
    find_values(&l, oracle);
    sga_rates_drop(solution);          /* of the smaller system */
    lift_constraints(&l, options->combinations);
    lift_elimination(&l);
    lift_verdict(&l);
    if (solution->field)
        lift_field(&l);
    if (solution->gauge)
        lift_gauge(&l);
    keep_definitions(&l);
    sga_arena_end(&l.mem);
    free(solution->scale);
    solution->scale = natural_sizes(system, &solution->time_unit);
    return expr_store_ok(system->store) && sample(&l, options, oracle) && expr_store_ok(system->store);
}
