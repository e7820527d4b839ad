/* The system restricted to a stratum, or with a condition on parameters used up. */
#include "strata_case.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "cases.h"
#include "error.h"
#include "mem.h"
#include "stratum.h"

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

/* The system with some of its parameters replaced. */
static void substitute(struct strata_case *part, const struct sys_system *system, const struct form_mechanical *mechanical,
                       const struct cases_part *values)
{
    struct expr_store *st = system->store;
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)st->symbols, sizeof *map);
    for (int i = 0; i < values->puts; i++)
        map[values->put[i].symbol] = values->put[i].value;
    sys_copy_part(&part->system, system, NULL, map);
    if (mechanical)
        substitute_mechanical(part, mechanical, st, map);
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
    *part = (struct strata_case){ .mechanical = { .mass = NULL } };
    if (strcmp(s->kind, "parameter") != 0) {
        sys_copy(&part->system, system);
        part->system.square = system->square && !s->wheres;
        for (int i = 0; i < s->wheres; i++)
            sys_add_restriction(&part->system, s->where[i]);
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
    sys_clear(&part->system);
    if (part->mechanical.mass) {
        free(part->mechanical.mass);
        free(part->mechanical.force);
        free(part->mechanical.constraint);
    }
}
