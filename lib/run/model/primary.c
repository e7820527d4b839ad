/* Restrictions of the form `hamiltonian` are primary constraints: the equation is pulled back to their
 * zero set M0 before anything else (Gotay, Nester & Hinds 1978). The vectors tangent to M0 come from
 * differentials, so functions that are regular and independent on M0 are found first, by the
 * algorithm itself with the restrictions and no equation. Those that follow from the others, and
 * what p^2 or a product stands for, are then known.
 *
 * A product is a union of branches with tangent vectors of their own: where the equations
 * contradict each other on the first branch, the others are tried in turn. */
#include "run_job.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "form.h"
#include "mem.h"
#include "oracle.h"
#include "reduce.h"
#include "reduction.h"
#include "request.h"
#include "seeds.h"
#include "system.h"

struct attempt {
    expr_id *given; int givens;      /* as the request has them */
    int originals;                   /* how many of `given` are the request's own */
    struct points_oracle oracle;     /* points of M0 */
    struct sga_solution solution;    /* M0: its constraints */
};

static bool vanishes(void *ctx, expr_id e)
{
    return points_oracle_zero(ctx, e).truth == POINTS_ZERO;
}

static void set_restrictions(struct sys_system *sys, const expr_id *e, int n)
{
    sys->restrictions = 0;
    free(sys->restriction);
    sys->restriction = NULL;
    for (int i = 0; i < n; i++)
        sys_add_restriction(sys, e[i]);
}

static void drop_rows(struct sys_system *sys)
{
    for (int i = 0; i < sys->rows; i++) {
        free(sys->row[i].entry);
        free((char *)sys->row[i].source);
    }
    free(sys->row);
    sys->row = NULL;
    sys->rows = 0;
}

/* M0 alone: every velocity is free. */
static bool find_m0(struct job *j, struct attempt *a)
{
    struct reduction_options options = { .near = j->start.x, .near_time = j->start.time, .seed = SGA_SEED_REDUCTION, .budget = j->budget };
    points_oracle_init(&a->oracle, 20250101);
    drop_rows(&j->request->system);
    set_restrictions(&j->request->system, a->given, a->givens);
    return sga_reduce(&j->request->system, &options, &a->oracle, &a->solution, j->err);
}

static void pull_back(struct job *j, struct attempt *a)
{
    struct form_zero zero = { vanishes, &a->oracle };
    struct form_hamiltonian h = *j->request->hamiltonian;
    int n = 0;
    expr_id *regular = sga_malloc(((size_t)a->solution.constraints + 1) * sizeof *regular);
    for (int i = 0; i < a->solution.constraints; i++)
        if (a->solution.constraint[i].origin == SGA_FROM_RESTRICTION)
            regular[n++] = a->solution.constraint[i].expr;
    assert(n <= a->solution.constraints);
    h.restriction = regular;
    h.restrictions = n;
    h.zero = &zero;
    *j->primary = (struct form_tangent){ 0 };
    form_hamiltonian_rows(&j->request->system, &h, j->primary);
    sga_keep(&j->mem, j->primary->vector);
    set_restrictions(&j->request->system, regular, n);
    free(regular);
}

/* What only the first step knows goes into the answer of the second: the functions that regular ones
 * replaced, branches not followed, and that more rows were made than are needed. */
static void carry_over(struct job *j, const struct attempt *a)
{
    struct sga_solution *sol = j->solution;
    const struct sga_solution *m0 = &a->solution;
    assert(a->originals <= a->givens);
    int spare = j->primary->count - (j->request->system.variables - m0->constraints);
    for (int i = 0; i < sol->constraints; i++) {
        struct sga_constraint *c = sol->constraint + i;
        int from = c->restriction, regular = 0;        /* one of the regular functions: it is the answer's as what that came from */
        for (int k = 0; k < m0->constraints && c->origin == SGA_FROM_RESTRICTION; k++) {
            const struct sga_constraint *own = m0->constraint + k;
            if (c->expr == own->expr)
                c->replaced = own->replaced;
            if (own->origin == SGA_FROM_RESTRICTION && regular++ == from)
                c->restriction = own->restriction < a->originals ? own->restriction : -1;
        }
    }
    sol->branch = sga_realloc(sol->branch, ((size_t)(sol->branches + m0->branches) + 1) * sizeof *sol->branch);
    for (int i = 0; i < m0->branches; i++)
        sol->branch[sol->branches++] = m0->branch[i];
    sol->redundant_rows = sol->redundant_rows > spare ? sol->redundant_rows - spare : 0;
}

static bool try_one(struct job *j, struct attempt *a, bool (*solve)(struct job *))
{
    if (!find_m0(j, a))
        return false;
    if (a->solution.verdict != SGA_INCONSISTENT)
        pull_back(j, a);
    bool ok = solve(j);
    if (ok && a->solution.verdict != SGA_INCONSISTENT) {
        carry_over(j, a);
        answer_restrictions_kept(j, &a->solution);
    }
    set_restrictions(&j->request->system, a->given, a->originals);
    return ok;
}

static void attempt_clear(struct attempt *a)
{
    points_oracle_clear(&a->oracle);
    sga_solution_clear(&a->solution);
}

bool answer_primary(struct job *j, bool (*solve)(struct job *))
{
    const struct form_hamiltonian *h = j->request->hamiltonian;
    if (!h || !h->restrictions)
        return solve(j);
    int n = h->restrictions, branches = 0;
    SGA_ARENA(mem);
    expr_id *given = sga_take(&mem, ((size_t)n + 1) * sizeof *given);
    expr_id *branch = NULL;
    memcpy(given, h->restriction, (size_t)n * sizeof *given);
    struct attempt a = { .given = given, .givens = n, .originals = n };
    j->primary = sga_zeros(&j->mem, 1, sizeof *j->primary);
    bool ok = try_one(j, &a, solve);
    if (ok && j->solution->verdict == SGA_INCONSISTENT) {
        branches = a.solution.branches;
        branch = sga_malloc(((size_t)branches + 1) * sizeof *branch);
        for (int k = 0; k < branches; k++)
            branch[k] = a.solution.branch[k].expr;
    }
    attempt_clear(&a);
    for (int k = 0; k < branches && ok && j->solution->verdict == SGA_INCONSISTENT; k++) {
        given[n] = branch[k];
        a = (struct attempt){ .given = given, .givens = n + 1, .originals = n };
        ok = try_one(j, &a, solve);
        attempt_clear(&a);
    }
    free(branch);
    return ok;
}

void answer_restrictions_kept(struct job *j, const struct sga_solution *sol)
{
    int n = j->request->hamiltonian ? j->request->hamiltonian->restrictions : j->request->system.restrictions;
    if (!n || sol->verdict == SGA_INCONSISTENT)
        return;
    j->restriction_kept = sga_zeros(&j->mem, (size_t)n, 1);
    for (int i = 0; i < sol->constraints; i++)
        if (sol->constraint[i].restriction >= 0 && sol->constraint[i].restriction < n)
            j->restriction_kept[sol->constraint[i].restriction] = 1;
}
