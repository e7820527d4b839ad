/* The form `mechanical`: the geometry of its constraints before the reduction, acceleration, reaction and
 * regularity after it. */
#include "run_job.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "buf.h"
#include "form.h"
#include "mech.h"
#include "mechanical_answer.h"
#include "mem.h"
#include "reduce.h"
#include "reduction.h"
#include "request.h"
#include "seeds.h"
#include "stage_clock.h"
#include "system.h"
#include "warnings.h"

static struct reduction_options options_of(const struct job *j)
{
    return (struct reduction_options){ .near = j->start.x, .near_time = j->start.time, .seed = SGA_SEED_FIBRE, .budget = j->budget };
}

/* More conditions than constraints: names for their multipliers, by the rule of the reader. */
static void add_multipliers(struct job *j, int more)
{
    struct expr_store *st = &j->request->store;
    struct sys_system *s = &j->request->system;
    int old = s->variables;
    struct sga_buf name = { 0 };
    for (int k = 0; k < more; k++) {
        sga_buf_clear(&name);
        sga_buf_printf(&name, "lambda%d", s->variables - 2 * j->request->mechanical->coordinates + 1);
        while (expr_symbol_find(st, name.data, name.len) >= 0)
            sga_buf_put(&name, "_", 1);
        expr_symbol_add(st, name.data, EXPR_VARIABLE);
        sys_add_variable(s, expr_symbol_find(st, name.data, name.len), "multiplier");
    }
    sga_buf_free(&name);
    if (j->start.x) {
        double *was = j->start.x;
        j->start.x = sga_zeros(&j->mem, (size_t)s->variables, sizeof *was);
        memcpy(j->start.x, was, (size_t)old * sizeof *was);
    }
    if (j->start.given) {
        unsigned char *was = j->start.given;
        j->start.given = sga_zeros(&j->mem, (size_t)s->variables, 1);
        memcpy(j->start.given, was, (size_t)old);
    }
}

/* Multipliers of no condition are 0: reactions and motion do not depend on them. */
static void fix_multipliers(struct job *j, const int *column, int conditions)
{
    struct sys_system *s = &j->request->system;
    for (int k = 2 * j->request->mechanical->coordinates; k < s->variables; k++) {
        bool used = false;
        for (int i = 0; i < conditions; i++)
            used = used || column[i] == k;
        if (used)
            continue;
        struct sga_buf source = { 0 };
        expr_id lambda = s->store->symbol[s->variable[k].symbol].node;
        sga_buf_printf(&source, "choice of %s", s->store->symbol[s->variable[k].symbol].name);
        sys_add_row(s, lambda, source.data);
        sga_buf_free(&source);
        s->square = false;
    }
}

static expr_id reaction(const struct job *j, const int *column, int i)
{
    const struct mech_fibre *f = &j->mechanical->fibre;
    const struct sys_system *s = &j->request->system;
    expr_id sum = expr_int(s->store, 0);
    for (int k = 0; k < f->conditions; k++)
        sum = expr_add(s->store, sum, expr_mul(s->store, f->H[(size_t)k * (size_t)j->request->mechanical->coordinates + (size_t)i],
                                               s->store->symbol[s->variable[column[k]].symbol].node));
    return sum;
}

/* reaction_x and reaction_power, where the trajectory's expressions use them. */
static void give_reactions(struct job *j, const int *column)
{
    struct request *r = j->request;
    struct request_trajectory *t = &r->trajectory;
    if (!r->forces.reaction)
        return;
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)r->store.symbols + 1, sizeof *map), power = expr_int(&r->store, 0);
    for (int i = 0; i < r->mechanical->coordinates; i++) {
        expr_id R = reaction(j, column, i);
        power = expr_add(&r->store, power, expr_mul(&r->store, R, r->store.symbol[r->mechanical->velocity[i]].node));
        if (r->forces.reaction[i])
            map[r->store.node[r->forces.reaction[i]].a] = R;
    }
    if (r->forces.power)
        map[r->store.node[r->forces.power].a] = power;
    expr_substitute(&r->store, t->output, t->outputs, map);
    expr_substitute(&r->store, t->condition, t->conditions, map);
    for (int k = 0; k < t->rates; k++)
        expr_substitute(&r->store, &t->rate[k].rate, 1, map);
}

bool answer_mechanical(struct job *j)
{
    struct request *r = j->request;
    const struct form_mechanical *in = r->mechanical;
    struct reduction_options options = options_of(j);
    j->mechanical = sga_calloc(1, sizeof *j->mechanical);
    struct mech_fibre *f = &j->mechanical->fibre;
    stage_begin(j->clock, STAGE_MECHANICAL);
    if (!mech_fibre_find(f, &r->system, in, &options, j->err))
        return false;
    if (f->W->verdict == SGA_INCONSISTENT)
        return true;
    int multipliers = r->system.variables - 2 * in->coordinates;
    if (f->conditions > multipliers)
        add_multipliers(j, f->conditions - multipliers);
    SGA_ARENA(mem);
    int *column = sga_zeros(&mem, (size_t)f->conditions + 1, sizeof *column);
    for (int i = 0; i < f->conditions; i++)
        column[i] = 2 * in->coordinates + f->constraint[i];
    if (!f->own || f->redundants) {
        sys_clear_rows(&r->system);
        form_mechanical_rows(&r->system, in, f->condition, column, f->conditions);
        fix_multipliers(j, column, f->conditions);
        r->system.square = false;
    }
    give_reactions(j, column);
    return true;
}

/* The motion lives on all of W (near its general points), and is determined there. */
static bool is_determined(const struct job *j)
{
    const struct sga_solution *sol = j->solution;
    int W = 2 * j->request->mechanical->coordinates - j->mechanical->fibre.W->constraints;
    return sol->verdict != SGA_INCONSISTENT && sol->free_columns == 0 && j->request->system.variables - sol->constraints == W;
}

bool answer_mechanical_motion(struct job *j)
{
    struct mechanical_answer *m = j->mechanical;
    unsigned want = j->request->want;
    stage_begin(j->clock, STAGE_MECHANICAL);
    if (m->fibre.W->verdict == SGA_INCONSISTENT)
        return true;
    m->determined = is_determined(j);
    bool unique = j->solution->verdict == SGA_UNIQUE || j->solution->verdict == SGA_ISOLATED;
    m->has_motion = want & REQUEST_VECTOR_FIELD && unique && (m->determined || j->solution->field);
    /* On a subset of W what determines the acceleration may be the subset instead of the masses. */
    if (m->has_motion && m->determined && !(j->request->system.restrictions && j->solution->field))
        mech_motion_find(&m->motion, &m->fibre, j->request->mechanical);
    else if (m->has_motion)
        mech_motion_of(&m->motion, &m->fibre, j->request->mechanical, j->solution->field + j->request->mechanical->coordinates);
    if (want & (REQUEST_VECTOR_FIELD | REQUEST_CONSTRAINTS | REQUEST_INDEX | REQUEST_STRUCTURE)) {
        struct reduction_options options = options_of(j);
        struct sga_budget part = *j->budget;      /* the search must not take the whole job's time */
        double soon = sga_now() + (j->place.depth ? SGA_MOST_STRATUM_RANK_SECONDS : SGA_MOST_RANK_SECONDS);
        if (!part.deadline || part.deadline > soon)
            part.deadline = soon;
        options.budget = &part;
        mech_regularity_find(&m->regularity, &m->fibre, j->request->mechanical, &options);
        m->has_regularity = true;
        if (!sga_budget_ok(&part, NULL) && job_has_left(j))
            sga_limit_met(j->budget, j->place.depth ? SGA_LIMIT_STRATUM_RANK_SECONDS : SGA_LIMIT_RANK_SECONDS);
    }
    return job_goes_on(j);
}

void answer_mechanical_clear(struct job *j)
{
    if (!j->mechanical)
        return;
    mech_regularity_clear(&j->mechanical->regularity);
    mech_motion_clear(&j->mechanical->motion);
    mech_fibre_clear(&j->mechanical->fibre);
    free(j->mechanical);
    j->mechanical = NULL;
}
