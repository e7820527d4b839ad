/* A holonomic constraint acts through its differential: the reaction is lambda dg. Where dg vanishes on
 * the zeros of g (a square, say) no multiplier can act, and the equations as they stand are not those of
 * the mechanical system; that is refused, rather than answered with what they say. */
#include "run_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "echelon.h"
#include "error.h"
#include "facts.h"
#include "oracle.h"
#include "reduce.h"
#include "reduction.h"
#include "request.h"
#include "seeds.h"
#include "system.h"

static bool is_holonomic(const struct sys_row *r)
{
    return strncmp(r->source, "holonomic[", 10) == 0;
}

/* Whether the answer, or the failure, may come from an irregular constraint. */
static bool suspicious(const struct job *j, bool ok)
{
    if (!ok)
        return j->err->code == SGA_E_IRREGULAR || j->err->code == SGA_E_UNDECIDED || j->err->code == SGA_E_NO_REAL_POINT;
    for (int i = 0; i < j->solution->constraints; i++)
        if (j->solution->constraint[i].generation == 1 && j->solution->constraint[i].replaced)
            return true;
    return false;
}

static bool differential_vanishes(struct job *j, struct points_oracle *oracle, expr_id g)
{
    const struct sys_system *sys = &j->request->system;
    for (int i = 0; i < sys->variables; i++)
        if (points_oracle_zero(oracle, expr_diff(sys->store, g, sys->variable[i].symbol)).truth != POINTS_ZERO)
            return false;
    return true;
}

/* The holonomic constraints alone, as restrictions; the caller frees them. row[i]: which row restriction i is. */
static struct sys_system constraints_alone(const struct job *j, int *row)
{
    const struct sys_system *sys = &j->request->system;
    struct sys_system only = *sys;
    only.rows = only.restrictions = 0;
    only.restriction = NULL;
    for (int i = 0; i < sys->rows; i++)
        if (is_holonomic(sys->row + i)) {
            row[only.restrictions] = i;
            sys_add_restriction(&only, sys->row[i].alpha);
        }
    return only;
}

/* The index of the first constraint that is regular nowhere on the common zeros; -1: none. */
static int find_irregular(struct job *j, const struct sys_system *only)
{
    struct reduction_options options = { .near = j->start.x, .near_time = j->start.time, .seed = SGA_SEED_REDUCTION, .budget = j->budget };
    struct sga_error err = { 0 };
    struct points_oracle oracle;
    struct sga_solution sol;
    int found = -1;
    points_oracle_init(&oracle, 20250101);
    if (sga_reduce(only, &options, &oracle, &sol, &err) && sol.verdict != SGA_INCONSISTENT)
        for (int i = 0; i < sol.constraints && found < 0; i++)
            if (sol.constraint[i].replaced && sol.constraint[i].restriction >= 0
                && differential_vanishes(j, &oracle, sol.constraint[i].replaced))
                found = sol.constraint[i].restriction;
    points_oracle_clear(&oracle);
    sga_solution_clear(&sol);
    return found;
}

bool answer_holonomic(struct job *j, bool ok)
{
    int found = -1;
    if (strcmp(j->request->form, "lagrangian") != 0 || !suspicious(j, ok))
        return ok;
    SGA_ARENA(mem);
    int *row = sga_take(&mem, ((size_t)j->request->system.rows + 1) * sizeof *row);
    struct sys_system only = constraints_alone(j, row);
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

/* d e as a row over the variables. */
static void differential(const struct sys_system *sys, expr_id e, struct ech_row *row)
{
    *row = (struct ech_row){ .rhs = expr_int(sys->store, 0) };
    for (int k = 0; k < sys->variables; k++) {
        expr_id d = expr_diff(sys->store, e, sys->variable[k].symbol);
        if (!expr_is_zero(sys->store, d))
            ech_row_push(row, k, d);
    }
}

/* Which differentials depend on those before them on the set of the solution. Returns how many do, 0 where the others
 * do not span what the set leaves out (an irregular set), or where that is not known. */
static int dependent(struct job *j, const struct sys_system *only, const struct sga_solution *sol, struct points_oracle *oracle, unsigned char *is)
{
    struct echelon ech;
    struct expr_facts facts;
    struct sga_error err = { 0 };
    struct ech_context ctx = { .st = only->store, .facts = &facts, .oracle = oracle, .budget = j->budget, .err = &err };
    int count = 0;
    bool ok = oracle->reals > 0;
    ech_init(&ech, only->variables);
    expr_facts_init(&facts);
    for (int i = 0; i < only->restrictions && ok; i++) {
        struct ech_row row;
        int before = ech.pivots;
        differential(only, only->restriction[i], &row);
        ok = ech_eliminate(&ech, &ctx, &row, 1, 0);
        is[i] = ech.pivots == before;
        count += is[i];
        ech_row_clear(&row);
    }
    ok = ok && ech.pivots == sol->constraints;
    ech_clear(&ech);
    expr_facts_clear(&facts);
    return ok ? count : 0;
}

/* The number in "holonomic[3]". */
static int number_of(const struct sys_row *r)
{
    return atoi(r->source + 10);
}

/* The multiplier of constraint a is chosen to be 0: reactions and motion do not depend on it. */
static bool fix_multiplier(struct job *j, int a)
{
    struct sys_system *sys = &j->request->system;
    struct sga_buf source = { 0 };
    bool there = false;
    for (int k = 0; k < sys->variables; k++)
        there |= sys->variable[k].symbol == j->request->multiplier + a;
    if (!there)          /* cut off: nothing depends on it */
        return false;
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)sys->store->symbols + 1, sizeof *map);
    map[j->request->multiplier + a] = expr_int(sys->store, 0);
    for (int i = 0; i < sys->rows; i++)
        expr_substitute(sys->store, &sys->row[i].alpha, 1, map);
    sga_buf_printf(&source, "choice of %s", sys->store->symbol[j->request->multiplier + a].name);
    sys_add_row(sys, sys->store->symbol[j->request->multiplier + a].node, source.data);
    sga_buf_free(&source);
    sys->square = false;
    return true;
}

bool answer_holonomic_redundant(struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    struct reduction_options options = { .near = j->start.x, .near_time = j->start.time, .seed = SGA_SEED_REDUCTION, .budget = j->budget };
    struct sga_error err = { 0 };
    struct points_oracle oracle;
    struct sga_solution sol;
    if (strcmp(j->request->form, "lagrangian") != 0)
        return false;
    SGA_ARENA(mem);
    int *row = sga_take(&mem, ((size_t)sys->rows + 1) * sizeof *row), rows = sys->rows;
    struct sys_system only = constraints_alone(j, row);
    unsigned char *is = sga_zeros(&mem, (size_t)only.restrictions + 1, 1);
    bool fixed = false;
    points_oracle_init(&oracle, 20250103);
    if (only.restrictions && sga_reduce(&only, &options, &oracle, &sol, &err)) {
        if (sol.verdict != SGA_INCONSISTENT && dependent(j, &only, &sol, &oracle, is)) {
            j->redundant = sga_take(&j->mem, ((size_t)rows + 1) * sizeof *j->redundant);
            for (int i = 0; i < only.restrictions; i++)
                if (is[i] && fix_multiplier(j, number_of(sys->row + row[i])))
                    j->redundant[j->redundants++] = number_of(sys->row + row[i]);
            fixed = j->redundants > 0;
        }
        sga_solution_clear(&sol);
    }
    points_oracle_clear(&oracle);
    free(only.restriction);
    return fixed;
}
