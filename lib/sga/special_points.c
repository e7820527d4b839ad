/* Systems that contradict themselves at general points may have solutions at special ones. */
#include "product_routes.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "ball.h"
#include "error.h"
#include "mem.h"
#include "oracle.h"
#include "print.h"
#include "reduction.h"
#include "square.h"
#include "system.h"
#include "warnings.h"

/* One set of special points: the functions that vanish there. */
struct place {
    expr_id at[SGA_MOST_SPECIAL_DEPTH];
    int count;
};

struct search {
    const struct sys_system *system;
    const struct reduction_options *options;
    struct place best;
    struct route route;
    int final;                  /* dimension of the best place's final set; -1: none yet */
    bool near;                  /* the guess lies on the best place */
    expr_id *other; int others; size_t other_cap;
    struct sga_error unknown;   /* of the first place that could not be decided */
};

static bool near_place(const struct search *s, const struct place *p)
{
    const struct sys_system *sys = s->system;
    if (!s->options->near)
        return false;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_ENDS(num_ball_clear) struct num_ball b;
    bool on = true;
    expr_cone_init(&cone);
    num_ball_init(&b, sys->store, 64);
    for (int i = 0; i < sys->parameters; i++)
        num_ball_set_d(&b, sys->parameter[i], 1.25);
    for (int j = 0; j < sys->variables; j++)
        num_ball_set_d(&b, sys->variable[j].symbol, s->options->near[j]);
    num_ball_set_d(&b, sys->time, s->options->near_time);
    expr_cone_of(sys->store, &cone, p->at, p->count);
    num_ball_list(&b, cone.list, cone.count);
    for (int i = 0; i < p->count; i++)
        on = on && fabs(arf_get_d(arb_midref(num_ball_value(&b, p->at[i])), ARF_RND_NEAR)) < 1e-9;
    return on;
}

/* The system restricted to a place; the caller frees part->restriction. */
static void restrict_to(struct sys_system *part, const struct sys_system *system, const expr_id *at, int count)
{
    *part = *system;
    part->restriction = sga_malloc((size_t)(system->restrictions + count + 1) * sizeof *part->restriction);
    for (int k = 0; k < system->restrictions; k++)
        part->restriction[k] = system->restriction[k];
    for (int k = 0; k < count; k++)
        part->restriction[part->restrictions++] = at[k];
}

static void keep_other(struct search *s, expr_id e)
{
    for (int i = 0; i < s->others; i++)
        if (s->other[i] == e)
            return;
    SGA_RESERVE(s->other, s->other_cap, s->others + 1);
    s->other[s->others++] = e;
}

static void unknown(struct search *s, expr_id e, const char *why)
{
    SGA_FREED char *text = expr_text(s->system->store, e, 300);
    if (s->unknown.code == SGA_E_OK)
        sga_fail(&s->unknown, SGA_E_UNDECIDED, "at general points the equations contradict each other; what holds where "
                 "%s vanishes could not be found: %.200s", text, why);
    keep_other(s, e);
}

static void found(struct search *s, const struct place *p, const struct routes *r)
{
    bool near = near_place(s, p);
    keep_other(s, p->at[0]);
    if (s->final >= 0 && (near != s->near ? s->near : r->final <= s->final))
        return;
    s->best = *p;
    s->final = r->final;
    s->near = near;
    SGA_RESERVE(s->route.at, s->route.cap, r->best.count + 1);
    if (r->best.count)
        memcpy(s->route.at, r->best.at, (size_t)r->best.count * sizeof *s->route.at);
    s->route.count = r->best.count;
}

/* Looks at the zero set of each pivot of runs that ended empty at `place`; depth-first, at
 * most SGA_MOST_SPECIAL_DEPTH deep. False: a failure that ends the job. */
static bool look(struct search *s, const struct routes *above, const struct place *place, struct sga_error *err)
{
    bool ok = true;
    bool deep = above->pivots && place->count == SGA_MOST_SPECIAL_DEPTH, many = above->pivots > SGA_MOST_SPECIAL_PIVOTS;
    if (deep || many) {
        sga_limit_met(s->options->budget, deep ? SGA_LIMIT_SPECIAL_DEPTH : SGA_LIMIT_SPECIAL_PIVOTS);
        unknown(s, above->pivot[0], "there are too many special points to look at; restrict the system to those that are meant");
        return true;
    }
    for (int i = 0; i < above->pivots && ok; i++) {
        assert(place->count < SGA_MOST_SPECIAL_DEPTH);
        struct place here = *place;
        struct sys_system part;
        SGA_ENDS(sga_solution_clear) struct sga_solution solution = { 0 };
        SGA_ENDS(points_oracle_clear) struct points_oracle oracle;
        SGA_ENDS(routes_clear) struct routes r = { .final = -1, .seed = above->seed, .best_at = -1, .now_at = -1 };
        here.at[here.count++] = above->pivot[i];
        restrict_to(&part, s->system, here.at, here.count);
        points_oracle_init(&oracle, above->seed);
        ok = routes_explore(&r, &part, s->options, &oracle, &solution, err);
        if (ok && r.final >= 0)
            found(s, &here, &r);
        else if (ok && ((r.failed && r.error.code != SGA_E_NO_REAL_POINT) || r.left))
            unknown(s, here.at[0], r.error.detail);
        else if (ok)
            ok = look(s, &r, &here, err);
        free(part.restriction);
    }
    return ok;
}

/* Run the best place once more, for its solution. */
static bool take(struct search *s, uint64_t seed, struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err)
{
    struct sys_system part;
    assert(s->best.count > 0 && s->final >= 0);
    SGA_ENDS(sga_solution_clear) struct sga_solution general = *solution;      /* its contradiction is kept */
    *solution = (struct sga_solution){ 0 };
    restrict_to(&part, s->system, s->best.at, s->best.count);
    routes_restart(oracle, seed, solution);
    bool ok = state_solve(&part, s->options, oracle, &s->route, solution, err);
    free(part.restriction);
    if (ok) {
        solution->contradiction = general.contradiction;
        memcpy(solution->contradiction_why, general.contradiction_why, sizeof solution->contradiction_why);
        solution->contradiction_part = general.contradiction_part;
        solution->contradiction_parts = general.contradiction_parts;
        general.contradiction_part = NULL;
        solution->special = memcpy(sga_malloc(sizeof s->best.at), s->best.at, sizeof s->best.at);
        solution->specials = s->best.count;
        solution->other = s->other;
        solution->others = s->others;
        s->other = NULL;
    }
    return ok;
}

bool special_points_solve(const struct routes *above, const struct sys_system *system, const struct reduction_options *options,
                          struct points_oracle *oracle, struct sga_solution *solution, struct sga_error *err)
{
    struct search s = { .system = system, .options = options, .final = -1 };
    struct place everywhere = { .count = 0 };
    bool ok = look(&s, above, &everywhere, err);
    if (ok && s.final >= 0) {
        ok = take(&s, above->seed, oracle, solution, err);
    } else if (ok && s.unknown.code != SGA_E_OK) {
        *err = s.unknown;
        ok = false;
    }
    free(s.other);
    free(s.route.at);
    return ok;
}
