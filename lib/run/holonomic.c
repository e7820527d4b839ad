/* A holonomic constraint acts through its differential: the reaction is lambda dg. Where dg vanishes on
 * the zeros of g (a square, say) no multiplier can act, and the equations as they stand are not those of
 * the mechanical system; that is refused, rather than answered with what they say. */
#include "answer.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "derive.h"
#include "mem.h"

static bool is_holonomic(const struct sys_row *r)
{
    return strncmp(r->source, "holonomic[", 10) == 0;
}

/* Whether the answer, or the failure, may come from an irregular constraint. */
static bool suspicious(const struct job *j, bool ok)
{
    if (!ok)
        return j->err->code == SGA_E_IRREGULAR || j->err->code == SGA_E_UNDECIDED || j->err->code == SGA_E_NO_REAL_POINT;
    for (int i = 0; i < j->solution.constraints; i++)
        if (j->solution.constraint[i].generation == 1 && j->solution.constraint[i].replaced)
            return true;
    return false;
}

static bool differential_vanishes(struct job *j, struct points_shadow *shadow, expr_id g)
{
    const struct sys_system *sys = &j->request.system;
    for (int i = 0; i < sys->variables; i++)
        if (points_shadow_zero(shadow, expr_diff(sys->store, g, sys->variable[i].symbol)).truth != POINTS_ZERO)
            return false;
    return true;
}

/* The index of the first constraint that is regular nowhere on the common zeros; -1: none. */
static int find_irregular(struct job *j, const struct sys_system *only)
{
    struct sga_options options = { .near = j->near, .near_time = j->near_time, .seed = 1, .budget = &j->budget };
    struct sga_error err = { 0 };
    struct points_shadow shadow;
    struct sga_solution sol;
    int found = -1;
    points_shadow_init(&shadow, 20250101);
    if (sga_solve(only, &options, &shadow, &sol, &err) && sol.verdict != SGA_INCONSISTENT)
        for (int i = 0; i < sol.constraints && found < 0; i++)
            if (sol.constraint[i].replaced && sol.constraint[i].restriction >= 0
                && differential_vanishes(j, &shadow, sol.constraint[i].replaced))
                found = sol.constraint[i].restriction;
    points_shadow_clear(&shadow);
    sga_solution_clear(&sol);
    return found;
}

bool answer_holonomic(struct job *j, bool ok)
{
    const struct sys_system *sys = &j->request.system;
    struct sys_system only = *sys;
    int found = -1;
    if (strcmp(j->request.form, "lagrangian") != 0 || !suspicious(j, ok))
        return ok;
    only.rows = only.restrictions = 0;
    only.restriction = NULL;
    for (int i = 0; i < sys->rows; i++)
        if (is_holonomic(sys->row + i))
            sys_add_restriction(&only, sys->row[i].alpha);
    if (only.restrictions)
        found = find_irregular(j, &only);
    free(only.restriction);
    if (found < 0)
        return ok;
    *j->err = (struct sga_error){ 0 };
    char pointer[48];
    snprintf(pointer, sizeof pointer, "/system/holonomic/%d", found);
    return sga_fail_at(j->err, SGA_E_IRREGULAR, pointer, "the differential of this constraint vanishes wherever the constraint "
                       "holds, so that no reaction can act; write a function with the same zeros whose gradient does not vanish "
                       "on them (x for x^2)");
}
