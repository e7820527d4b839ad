/* The form `lagrangian`: velocities q' are variables, multipliers are added for holonomic
 * constraints. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "form.h"
#include "reader.h"

struct lagrangian {
    int *coordinate, *velocity, *multiplier;
    int n, forces, constraints;
    expr_id function, *force, *constraint;
    bool second_order;
};

static bool read_function(struct reader *rd, const json_t *system, struct lagrangian *l)
{
    const json_t *v = need_member(rd, system, "lagrangian");
    if (!v)
        return false;
    size_t mark = at_member(rd, "lagrangian");
    l->function = read_listed(rd, v, NULL);
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
    rd->grammar.derivative = read_velocity_of;
    rd->grammar.ctx = rd;
    bool ok = read_function(rd, system, l) && read_forces(rd, system, l);
    rd->grammar.derivative = NULL;
    ok = ok && read_expression_list(rd, system, "holonomic", &l->constraint, &l->constraints);
    if (l->constraints < 0)
        l->constraints = 0;
    return ok && read_motion_fits(rd, l->n, l->constraints);
}

bool read_lagrangian(struct reader *rd, const json_t *system)
{
    struct lagrangian l = { 0 };
    l.coordinate = read_variables(rd, system, "coordinates", &l.n);
    bool ok = l.coordinate && (l.velocity = read_make_velocities(rd, l.coordinate, l.n))
        && read_functions(rd, system, &l) && (l.multiplier = read_make_multipliers(rd, l.constraints));
    if (ok) {
        struct form_lagrangian f = {
            .coordinate = l.coordinate, .velocity = l.velocity, .coordinates = l.n, .lagrangian = l.function,
            .second_order = l.second_order, .force = l.forces > 0 ? l.force : NULL,
            .constraint = l.constraint, .constraints = l.constraints, .multiplier = l.multiplier,
        };
        form_lagrangian(&rd->r->system, &f);
        rd->r->lagrangian = f.force ? EXPR_UNDEF : l.function;
        rd->r->coordinates = l.n;
        rd->r->multiplier = l.constraints ? l.multiplier[0] : 0;
    }
    return ok;
}
