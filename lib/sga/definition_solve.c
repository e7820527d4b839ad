/* A run of the reduction with variables that equations define put in: where they have switches, and where a run fails that may have
 * failed by what names hide. */
#include "definition.h"

#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "mem.h"
#include "oracle.h"
#include "product_routes.h"
#include "reduction.h"
#include "state.h"
#include "system.h"

/* The system without what is defined, and that put back. *lifted: whether points were found for the whole. */
static bool solve_left(const struct definitions *d, const struct sys_system *system, const struct reduction_options *options,
                       struct points_oracle *oracle, struct route *route, struct sga_solution *solution, bool *lifted, struct sga_error *err)
{
    SGA_ENDS(sys_clear) struct sys_system left;
    struct reduction_options own = *options;
    SGA_ARENA(mem);
    double *near = sga_zeros(&mem, (size_t)system->variables + 1, sizeof *near);
    unsigned char *given = sga_zeros(&mem, (size_t)system->variables + 1, 1);
    definitions_put_in(d, system, &left);
    for (int j = 0; j < left.variables && options->near; j++) {
        near[j] = options->near[d->variable[j]];
        given[j] = options->near_given && options->near_given[d->variable[j]];
    }
    own.near = options->near ? near : NULL;
    own.near_given = options->near_given ? given : NULL;
    bool ok = state_solve_as_is(&left, &own, oracle, route, solution, err);
    *lifted = ok && definitions_lift(d, system, options, oracle, solution);
    return ok;
}

/* One way to run: what it leads to. */
struct attempt {
    const struct sys_system *system;
    const struct reduction_options *options;
    struct points_oracle *oracle;
    struct route *route;
    struct sga_solution *solution;
    struct sga_error *err;
};

/* With variables that equations define put in, where these are more than `fewer`: how many, *ok telling whether the run came to its
 * end. 0: there are not so many, or points were not found for the whole, and nothing is said. */
static int solve_through(const struct attempt *a, enum definitions_asked asked, int fewer, bool *ok)
{
    SGA_ENDS(definitions_clear) struct definitions d;
    uint64_t seed = a->oracle->random;
    bool lifted = false;
    definitions_find(&d, a->system, asked, a->options->budget);
    bool more = d.count > fewer;
    *ok = more && solve_left(&d, a->system, a->options, a->oracle, a->route, a->solution, &lifted, a->err);
    if (lifted) {         /* the definitions come first: zeros were asked for on the rest */
        a->solution->one_piece += d.count;
        for (int i = 0; i < a->oracle->zeros; i++)
            a->oracle->zero[i].constraints += d.count;
    }
    int count = more && (lifted || !*ok) ? d.count : 0;
    if (more && !count)
        routes_restart(a->oracle, seed, a->solution);
    return count;
}

/* The decisions that a route begins with, as one of its own. */
static struct route begun(const struct route *route, int decisions)
{
    struct route r = { 0 };
    SGA_RESERVE(r.at, r.cap, decisions + 1);
    if (decisions)
        memcpy(r.at, route->at, (size_t)decisions * sizeof *r.at);
    r.count = decisions;
    return r;
}

/* A run failed: what could not be seen may be hidden by names. One with everything put in that is given a name takes its place where it comes
 * to its end; otherwise all stays as it is. */
static bool see_through(const struct attempt *a, uint64_t seed, int decisions, int fewer)
{
    SGA_ENDS(points_oracle_clear) struct points_oracle oracle;
    SGA_ENDS(sga_solution_clear) struct sga_solution solution = { 0 };
    struct sga_error err = { 0 };
    struct route route = begun(a->route, decisions);
    struct attempt b = { a->system, a->options, &oracle, a->route ? &route : NULL, &solution, &err };
    bool ok;
    points_oracle_init(&oracle, seed);
    if (solve_through(&b, DEFINITIONS_ALL, fewer, &ok) && ok) {
        struct points_oracle was = *a->oracle;
        sga_solution_clear(a->solution);
        *a->oracle = oracle;
        *a->solution = solution;
        *a->err = (struct sga_error){ 0 };
        oracle = was;
        solution = (struct sga_solution){ 0 };
        if (a->route) {
            struct route first = *a->route;
            *a->route = route;
            route = first;
        }
    } else {
        ok = false;
    }
    free(route.at);
    return ok;
}

bool state_solve(const struct sys_system *system, const struct reduction_options *options, struct points_oracle *oracle,
                 struct route *route, struct sga_solution *solution, struct sga_error *err)
{
    struct attempt a = { system, options, oracle, route, solution, err };
    uint64_t seed = oracle->random;
    int decisions = route ? route->count : 0;
    bool ok;
    int kinked = solve_through(&a, DEFINITIONS_KINKED, 0, &ok);
    if (!kinked)
        ok = state_solve_as_is(system, options, oracle, route, solution, err);
    bool goes_on = !ok && routes_local(err->code) && sga_budget_ok(options->budget, NULL) && expr_store_ok(system->store);
    return ok || (goes_on && see_through(&a, seed, decisions, kinked));
}
