/* The form `lagrangian`: velocities q' are variables, multipliers are added for holonomic
 * constraints. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "form.h"
#include "mem.h"
#include "reader.h"

struct lagrangian {
    int *coordinate, *velocity, *multiplier;
    int n, forces, constraints;
    expr_id function, *force, *constraint;
    bool second_order;
};

/* For struct expr_grammar: q' of a coordinate q, and nothing higher. */
static expr_id velocity_of(void *ctx, int symbol, int order)
{
    const struct reader *rd = ctx;
    const struct expr_store *st = &rd->r->store;
    char name[REQUEST_MAX_NAME + 2];
    if (order != 1 || strchr(st->symbol[symbol].name, '\''))
        return EXPR_UNDEF;
    snprintf(name, sizeof name, "%s'", st->symbol[symbol].name);
    int s = expr_symbol_find(st, name, strlen(name));
    return s < 0 ? EXPR_UNDEF : st->symbol[s].node;
}

static bool make_velocities(struct reader *rd, struct lagrangian *l)
{
    struct expr_store *st = &rd->r->store;
    l->velocity = sga_calloc((size_t)l->n + 1, sizeof *l->velocity);
    for (int i = 0; i < l->n; i++) {
        char name[REQUEST_MAX_NAME + 2];
        snprintf(name, sizeof name, "%s'", st->symbol[l->coordinate[i]].name);
        expr_id e = expr_symbol_add(st, name, EXPR_VARIABLE);
        if (!e)
            return store_ok(rd);
        l->velocity[i] = st->node[e].a;
    }
    return true;
}

/* lambda1, lambda2, ...; a name that is taken gets underscores. */
static bool make_multipliers(struct reader *rd, struct lagrangian *l)
{
    struct expr_store *st = &rd->r->store;
    struct sga_buf name = { 0 };
    bool ok = true;
    l->multiplier = sga_calloc((size_t)l->constraints + 1, sizeof *l->multiplier);
    for (int i = 0; i < l->constraints && ok; i++) {
        sga_buf_clear(&name);
        sga_buf_printf(&name, "lambda%d", i + 1);
        while (expr_symbol_find(st, name.data, name.len) >= 0)
            sga_buf_put(&name, "_", 1);
        expr_id e = expr_symbol_add(st, name.data, EXPR_VARIABLE);
        ok = e != EXPR_UNDEF;
        l->multiplier[i] = ok ? st->node[e].a : -1;
    }
    sga_buf_free(&name);
    return ok || store_ok(rd);
}

static bool read_function(struct reader *rd, const json_t *system, struct lagrangian *l)
{
    const json_t *v = need_member(rd, system, "lagrangian");
    if (!v)
        return false;
    size_t mark = at_member(rd, "lagrangian");
    l->function = read_expression(rd, v, NULL);
    if (!l->function)
        return false;
    at_back(rd, mark);
    v = json_object_get(system, "second_order");
    l->second_order = true;
    if (!v)
        return true;
    at_member(rd, "second_order");
    if (!read_boolean(rd, v, &l->second_order))
        return false;
    at_back(rd, mark);
    return true;
}

static bool read_forces(struct reader *rd, const json_t *system, struct lagrangian *l)
{
    if (!read_expression_list(rd, system, "forces", &l->force, &l->forces))
        return false;
    if (l->forces < 0 || l->forces == l->n)
        return true;
    at_member(rd, "forces");
    return at_fail(rd, SGA_E_SHAPE, "there are %d forces, but %d of coordinates", l->forces, l->n);
}

/* L and the forces know q'; the constraints are functions of q and time. */
static bool read_functions(struct reader *rd, const json_t *system, struct lagrangian *l)
{
    rd->grammar.derivative = velocity_of;
    rd->grammar.ctx = rd;
    bool ok = read_function(rd, system, l) && read_forces(rd, system, l);
    rd->grammar.derivative = NULL;
    ok = ok && read_expression_list(rd, system, "holonomic", &l->constraint, &l->constraints);
    if (l->constraints < 0)
        l->constraints = 0;
    long count = 2L * l->n + l->constraints;
    if (ok && count > REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "the system of first order has %ld variables; the limit is %d", count,
                       REQUEST_MAX_VARIABLES);
    return ok;
}

bool read_lagrangian(struct reader *rd, const json_t *system)
{
    struct lagrangian l = { 0 };
    l.coordinate = read_variables(rd, system, "coordinates", &l.n);
    bool ok = l.coordinate && make_velocities(rd, &l) && read_functions(rd, system, &l) && make_multipliers(rd, &l);
    if (ok) {
        struct form_lagrangian f = {
            .coordinate = l.coordinate, .velocity = l.velocity, .coordinates = l.n, .lagrangian = l.function,
            .second_order = l.second_order, .force = l.forces > 0 ? l.force : NULL,
            .constraint = l.constraint, .constraints = l.constraints, .multiplier = l.multiplier,
        };
        form_lagrangian(&rd->r->system, &f);
        rd->r->lagrangian = f.force ? EXPR_UNDEF : l.function;
        rd->r->coordinates = l.n;
    }
    free(l.coordinate);
    free(l.velocity);
    free(l.multiplier);
    free(l.force);
    free(l.constraint);
    return ok;
}
