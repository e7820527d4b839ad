/* The system restricted to a stratum, or with a condition on parameters used up. */
#include "strata_case.h"

#include <stdlib.h>
#include <string.h>

#include "derive.h"
#include "facts.h"
#include "mem.h"
#include "poly.h"

static void restricted(struct strata_case *part, const struct sys_system *system, const struct stratum *s)
{
    int r = system->restrictions;
    part->system = *system;
    part->system.square = system->square && !s->wheres;
    part->system.restriction = sga_malloc((size_t)(r + s->wheres + 1) * sizeof *part->system.restriction);
    for (int i = 0; i < r; i++)
        part->system.restriction[i] = system->restriction[i];
    for (int i = 0; i < s->wheres; i++)
        part->system.restriction[r + i] = s->where[i];
    part->system.restrictions = r + s->wheres;
}

/* The same with variables and rows of its own, to be changed. */
static void own_copy(struct strata_case *part)
{
    struct sys_system from = part->system, *to = &part->system;
    sys_init(to, from.store);
    to->time = from.time;
    to->square = from.square;
    for (int i = 0; i < from.variables; i++)
        sys_add_variable(to, from.variable[i].symbol, from.variable[i].role);
    for (int i = 0; i < from.parameters; i++)
        sys_add_parameter(to, from.parameter[i]);
    for (int i = 0; i < from.restrictions; i++)
        sys_add_restriction(to, from.restriction[i]);
    for (int i = 0; i < from.rows; i++) {
        int row = sys_add_row(to, from.row[i].alpha, from.row[i].source);
        for (int q = 0; q < from.row[i].entries; q++)
            sys_add_entry(to, row, from.row[i].entry[q].col, from.row[i].entry[q].value);
    }
    free(from.restriction);
    part->own_rows = true;
}

static expr_id *replaced(struct expr_store *st, const expr_id *from, int n, const expr_id *map)
{
    expr_id *to = sga_malloc(((size_t)n + 1) * sizeof *to);
    memcpy(to, from, (size_t)n * sizeof *to);
    expr_substitute(st, to, n, map);
    return to;
}

/* Masses, forces and constraints with the parameter replaced. */
static void substitute_mechanical(struct strata_case *part, const struct form_mechanical *from, struct expr_store *st, const expr_id *map)
{
    struct form_mechanical *to = &part->mechanical;
    *to = *from;
    to->mass = sga_malloc((from->masses + 1) * sizeof *to->mass);
    memcpy(to->mass, from->mass, from->masses * sizeof *to->mass);
    for (size_t k = 0; k < from->masses; k++)
        expr_substitute(st, &to->mass[k].value, 1, map);
    to->force = replaced(st, from->force, from->coordinates, map);
    to->constraint = replaced(st, from->constraint, from->constraints, map);
}

static bool is_put(const struct cases_part *values, int symbol)
{
    for (int i = 0; i < values->puts; i++)
        if (values->put[i].symbol == symbol)
            return true;
    return false;
}

/* Rows, restriction and parameters with some of the parameters replaced. */
static void substitute(struct strata_case *part, const struct sys_system *system, const struct form_mechanical *mechanical,
                       const struct cases_part *values)
{
    struct expr_store *st = system->store;
    struct sys_system *to = &part->system;
    expr_id *map = sga_calloc((size_t)st->symbols, sizeof *map);
    for (int i = 0; i < values->puts; i++)
        map[values->put[i].symbol] = values->put[i].value;
    sys_init(to, st);
    to->time = system->time;
    to->square = system->square;
    for (int i = 0; i < system->variables; i++)
        sys_add_variable(to, system->variable[i].symbol, system->variable[i].role);
    for (int i = 0; i < system->parameters; i++)
        if (!is_put(values, system->parameter[i]))
            sys_add_parameter(to, system->parameter[i]);
    for (int i = 0; i < system->signals; i++)
        sys_add_signal(to, system->signal[i]);
    for (int i = 0; i < system->restrictions; i++) {
        expr_id e = system->restriction[i];
        expr_substitute(st, &e, 1, map);
        sys_add_restriction(to, e);
    }
    for (int i = 0; i < system->rows; i++) {
        expr_id e = system->row[i].alpha;
        expr_substitute(st, &e, 1, map);
        int row = sys_add_row(to, e, system->row[i].source);
        for (int q = 0; q < system->row[i].entries; q++) {
            e = system->row[i].entry[q].value;
            expr_substitute(st, &e, 1, map);
            sys_add_entry(to, row, system->row[i].entry[q].col, e);
        }
    }
    part->own_rows = true;
    if (mechanical)
        substitute_mechanical(part, mechanical, st, map);
    free(map);
}

bool strata_solvable(const struct stratum *s)
{
    return s->wheres && strcmp(s->kind, "instant") != 0 && strcmp(s->kind, "domain") != 0;
}

bool strata_is_part(const struct stratum *s)
{
    return !s->wheres && s->point && strcmp(s->kind, "branch") == 0;
}

bool strata_case_make(struct strata_case *part, const struct sys_system *system, const struct form_mechanical *mechanical,
                      struct stratum *s, struct sga_error *err)
{
    *part = (struct strata_case){ .own_rows = false };
    if (strcmp(s->kind, "parameter") != 0) {
        restricted(part, system, s);
        if (mechanical)
            own_copy(part);
        return true;
    }
    if (!s->part.puts || s->part.open)
        return sga_fail(err, SGA_E_UNDECIDED, "this condition on the parameters has no solution in closed form that could be "
                        "substituted; give the parameters values that fulfil it");
    substitute(part, system, mechanical, &s->part);
    return true;
}

void strata_case_clear(struct strata_case *part)
{
    if (part->own_rows)
        sys_clear(&part->system);
    else
        free(part->system.restriction);
    if (part->mechanical.mass) {
        free(part->mechanical.mass);
        free(part->mechanical.force);
        free(part->mechanical.constraint);
    }
}
