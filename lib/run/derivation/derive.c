/* The reduction's record, told in the order in which things were found. */
#include "derivation.h"

#include <assert.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "ask.h"
#include "buf.h"
#include "given.h"
#include "job_texts.h"
#include "oracle.h"
#include "printed_parts.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "stage_clock.h"
#include "sums.h"
#include "warnings.h"

static expr_id zero(struct derivation *d)
{
    return expr_int(&d->sheet.m.store, 0);
}

static void tell_given(struct derivation *d)
{
    const struct sys_system *sys = &d->j->request->system;
    const struct sga_solution *sol = d->j->solution;
    struct expr_store *st = &d->sheet.m.store;
    for (int i = 0; i < sys->rows; i++) {
        SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
        const struct sys_row *r = sys->row + i;
        derivation_row_text(d->j, i, &text);
        struct step *p = steps_add(&d->steps, STEP_GIVEN, 0, "given", text.data);
        expr_id left = zero(d);
        for (int k = 0; k < r->entries; k++)
            left = expr_add(st, left, expr_mul(st, derivation_sheet_copy(&d->sheet, r->entry[k].value), derivation_sheet_velocity(&d->sheet, r->entry[k].col)));
        steps_line(&d->steps, p, left, derivation_sheet_copy(&d->sheet, r->alpha));
        d->given[i] = d->steps.count;
    }
    for (int i = 0; i < sys->restrictions; i++) {
        char text[80];
        snprintf(text, sizeof text, "given, restrict[%d]: it vanishes where the motion starts", i);
        struct step *p = steps_add(&d->steps, STEP_GIVEN, 0, "given", text);
        steps_line(&d->steps, p, derivation_sheet_copy(&d->sheet, sys->restriction[i]), zero(d));
        d->restricted[i] = d->steps.count;
    }
    for (int i = 0; i < sol->specials; i++) {
        struct step *p = steps_add(&d->steps, STEP_BRANCH, 0, "branch", "general points contradict the equations; there are solutions where this vanishes too, the largest such set that was found");
        steps_line(&d->steps, p, derivation_sheet_copy(&d->sheet, sol->special[i]), zero(d));
        d->special[i] = d->steps.count;
    }
}

/* A constraint of the same origin whose sum this one is too: a function that stands for several. */
static int same_sum(const struct derivation *d, int i)
{
    const struct sga_constraint *c = d->j->solution->constraint;
    for (int k = i - 1; k >= 0 && c[k].generation == c[i].generation; k--)
        if (d->insert[k] && c[k].replaced && c[k].replaced == c[i].replaced && c[k].source == c[i].source)
            return k;
    return -1;
}

/* Whether the sum is one equation without velocities times a number: then it needs no step of its own. */
static bool is_plain(const struct derivation *d, const struct derivation_terms *t)
{
    return t->terms == 1 && !t->uses && !t->open && t->term[0].factor && expr_is_const(&d->sheet.m.store, t->term[0].factor);
}

static struct step *add_constraint(struct derivation *d, int i, const char *basis, const char *what)
{
    const struct sga_constraint *c = d->j->solution->constraint + i;
    char text[400];
    assert(d->steps.dimension > 0 && !d->found[i]);       /* independent ones are no more than variables */
    snprintf(text, sizeof text, "%s; it is independent of the constraints before, so that the dimension falls from %d to %d", what, d->steps.dimension, d->steps.dimension - 1);
    struct step *p = steps_add(&d->steps, STEP_CONSTRAINT, c->generation, basis, text);
    p->after = --d->steps.dimension;
    steps_line(&d->steps, p, d->xi[i], zero(d));
    if (!d->j->texts->names.count)
        p->line->text = d->j->texts->names.root[i];
    d->found[i] = d->steps.count;
    return p;
}

/* The sum of a constraint that stands for another function, told once. */
static int insert(struct derivation *d, int i, const struct derivation_terms *t, expr_id leaves)
{
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    const struct sga_constraint *c = d->j->solution->constraint + i;
    bool identity = derivation_sum_is(d, t, leaves);
    derivation_terms_text(d, t, &text);
    if (!identity)
        sga_buf_puts(&text, ", on the constraints so far");
    struct step *p = steps_add(&d->steps, STEP_INSERT, c->generation, "identity", text.data);
    derivation_use_terms(d, p, t);
    steps_line(&d->steps, p, leaves, zero(d));
    if (!identity)
        derivation_on_constraints(d, p, i);
    return d->insert[i] = d->steps.count;
}

/* Of several factors one is followed. */
static int branch(struct derivation *d, int i, int from)
{
    const struct sga_solution *sol = d->j->solution;
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    sga_buf_printf(&text, "(%d) holds in several ways; this one is followed", from);
    for (int k = 0, others = 0; k < sol->branches && others < 4; k++) {
        SGA_ENDS(sga_buf_free) struct sga_buf other = { 0 };
        if (sol->branch[k].before != i || !derivation_sheet_text(&d->sheet, derivation_sheet_copy(&d->sheet, sol->branch[k].expr), &other))
            continue;
        sga_buf_printf(&text, "%s %s = 0", others++ ? "," : "; left to the strata:", other.data);
    }
    struct step *p = steps_add(&d->steps, STEP_BRANCH, sol->constraint[i].generation, "branch", text.data);
    steps_use(&d->steps, p, from);
    for (int k = 0; k < i; k++)
        steps_use(&d->steps, p, d->found[k]);
    steps_line(&d->steps, p, d->xi[i], zero(d));
    return d->steps.count;
}

static void tell_restriction(struct derivation *d, int i)
{
    const struct sga_constraint *c = d->j->solution->constraint + i;
    int restrictions = d->j->request->system.restrictions, specials = d->j->solution->specials;
    bool own = c->restriction >= 0 && c->restriction < restrictions, branch = !own && !specials;      /* of products among them: a restriction of its own in the second run (primary.c) */
    struct step *p = add_constraint(d, i, branch ? "branch" : c->replaced ? "same_zeros" : "given",
                                    branch ? "the restrictions hold in several ways, of which this one is followed" : "a restriction holds from the start");
    if (own)
        steps_use(&d->steps, p, d->restricted[c->restriction]);
    for (int k = 0; k < restrictions && branch; k++)
        steps_use(&d->steps, p, d->restricted[k]);
    for (int k = 0; k < i && (c->replaced || branch); k++)
        steps_use(&d->steps, p, d->found[k]);
    for (int k = 0; k < specials && !own; k++)
        steps_use(&d->steps, p, d->special[k]);
}

static void tell_constraint(struct derivation *d, int i)
{
    struct job *j = d->j;
    const struct sga_constraint *c = j->solution->constraint + i;
    if (c->origin == SGA_FROM_RESTRICTION) {
        tell_restriction(d, i);
        return;
    }
    int twin = same_sum(d, i), from = twin >= 0 ? d->insert[twin] : 0;
    struct printed_sum printed = printed_sum(j, i);
    struct derivation_terms t = { 0 };
    bool plain = false;
    if (!from) {
        struct derivation_sum sum = { c->part, c->parts, c->parts && c->part[0].row >= 0, printed.divisor, c->generation, c->epoch, INT_MAX };
        t = derivation_sum_terms(d, &sum);
        plain = is_plain(d, &t) && !printed.stands_for && derivation_sum_is(d, &t, d->xi[i]);
        if (!plain)
            from = insert(d, i, &t, printed.stands_for ? derivation_sheet_copy(&d->sheet, printed_normal(j, c->replaced)) : d->xi[i]);
    } else {
        d->insert[i] = from;
    }
    if (c->chosen && !plain)
        from = branch(d, i, from);
    char what[120];
    if (plain)
        snprintf(what, sizeof what, "(%d) holds no velocity: a new constraint", t.term[0].step);
    else
        snprintf(what, sizeof what, "by (%d): a new constraint%s", from, printed.stands_for && !c->chosen ? ", with the same zeros" : "");
    struct step *p = add_constraint(d, i, c->chosen ? "branch" : printed.stands_for ? c->near_point ? "same_zeros_near_point" : "same_zeros" : "identity", what);
    if (plain)
        derivation_use_terms(d, p, &t);
    else
        steps_use(&d->steps, p, from);
    for (int k = 0; k < i && printed.stands_for; k++)       /* where these hold the zeros are the same */
        steps_use(&d->steps, p, d->found[k]);
}

/* The step that a row of the elimination comes from; 0: none is told. */
static int source_step(struct derivation *d, int source)
{
    int rows = d->j->request->system.rows;
    return source < 0 ? 0 : source < rows ? d->given[source] : source - rows < d->j->solution->constraints ? derivation_differentiate(d, source - rows) : 0;
}

static void tell_pivots(struct derivation *d, int generation, int *listed)
{
    struct job *j = d->j;
    const struct sga_solution *sol = j->solution;
    for (int q = 0; q < sol->pivots; q++) {
        const struct sga_pivot *v = sol->pivot + q;
        if (v->generation != generation || expr_is_const(&j->request->store, v->value))
            continue;
        if (++*listed > SGA_MOST_PIVOTS_LISTED) {
            sga_limit_met(j->budget, SGA_LIMIT_PIVOTS_LISTED);
            return;
        }
        SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
        int from = source_step(d, v->source);
        if (v->col < 0)
            sga_buf_puts(&text, "a factor of parameters that was dropped from a constraint is not zero");
        else
            sga_buf_printf(&text, "solving for the velocity of %s divides by this, which is not zero at general points", answer_variable_name(j, v->col));
        struct step *p = steps_add(&d->steps, STEP_PIVOT, generation, points_basis_text(points_oracle_zero(j->oracle, v->value).basis), text.data);
        p->relation = "!=";
        steps_line(&d->steps, p, derivation_sheet_copy(&d->sheet, printed_normal(j, v->value)), zero(d));
        if (from)
            steps_use(&d->steps, p, from);
    }
}

/* What an answer for a part of the constraints' zeros rests on. */
static const char *on_part(const struct sga_solution *sol)
{
    return sol->elsewheres ? ", on the part of the constraints' common zeros that is solved" : sol->sides ? ", on the side of a switch that is solved (evidence.sides)" : "";
}

static const char *basis_of_zero(const struct job *j, expr_id e)
{
    if (expr_is_zero(&j->request->store, e))
        return "identity";
    for (int k = 0; k < j->oracle->zeros; k++)
        if (j->oracle->zero[k].expr == e)
            return points_basis_text(j->oracle->zero[k].decision.basis);
    return points_basis_text(points_oracle_zero(j->oracle, e).basis);
}

/* Rows and tangencies that left nothing new in the elimination of this generation (0: with the first). */
static void tell_redundant(struct derivation *d, int generation, bool last)
{
    struct job *j = d->j;
    const struct sga_solution *sol = j->solution;
    for (int k = 0; k < sol->vanished_rows; k++) {
        const struct sga_vanished *v = sol->vanished + k;
        int at = v->generation + (v->generation < 1), top = sol->generations > 1 ? sol->generations : 1;
        assert(v->source < j->request->system.rows + sol->constraints);
        if (v->source >= j->request->system.rows)       /* a tangency: not before its constraint */
            at = at > sol->constraint[v->source - j->request->system.rows].generation ? at : sol->constraint[v->source - j->request->system.rows].generation;
        for (int q = 0; q < v->parts; q++)
            if (v->part[q].tangency >= 0 && sol->constraint[v->part[q].tangency].generation > at)
                at = sol->constraint[v->part[q].tangency].generation;
        if (at != generation && !(last && at > top))
            continue;
        if (sol->verdict == SGA_INCONSISTENT && points_oracle_zero(j->oracle, v->rest).truth != POINTS_ZERO)
            continue;             /* was set aside, as it could not be made a constraint; the others contradict without it */
        struct derivation_sum sum = { v->part, v->parts, false, EXPR_UNDEF, INT_MAX, v->epoch, INT_MAX };
        struct derivation_terms t = derivation_sum_terms(d, &sum);
        SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
        derivation_terms_text(d, &t, &text);
        bool identity = expr_is_zero(&j->request->store, v->rest);
        sga_buf_puts(&text, identity ? " leaves nothing" : " leaves what vanishes on the constraints already: nothing new");
        sga_buf_puts(&text, identity ? "" : on_part(sol));
        struct step *p = steps_add(&d->steps, STEP_REDUNDANT, generation, basis_of_zero(j, v->rest), text.data);
        derivation_use_terms(d, p, &t);
        steps_line(&d->steps, p, zero(d), zero(d));
        for (int i = 0; i < sol->constraints && !identity; i++)
            if (d->found[i])
                steps_use(&d->steps, p, d->found[i]);
    }
}

static expr_id component(struct derivation *d, int i)
{
    struct job *j = d->j;
    const struct sga_solution *sol = j->solution;
    struct expr_store *st = &d->sheet.m.store;
    int n = j->request->system.variables;
    expr_id x = derivation_sheet_read(&d->sheet, j->texts->names.root[j->texts->first_field + i]);
    for (int k = 0; k < sol->free_columns && x; k++) {
        expr_id z = sol->gauge ? derivation_sheet_read(&d->sheet, j->texts->names.root[j->texts->first_gauge + k * n + i]) : EXPR_UNDEF;
        x = z ? expr_add(st, x, expr_mul(st, z, st->symbol[d->sheet.free + k].node)) : EXPR_UNDEF;
    }
    return x;
}

/* All velocities, from all equations and tangencies that hold any. */
static int tell_field(struct derivation *d)
{
    const struct sys_system *sys = &d->j->request->system;
    const struct sga_solution *sol = d->j->solution;
    char text[160];
    for (int i = 0; i < sol->constraints; i++)
        derivation_differentiate(d, i);
    snprintf(text, sizeof text, "solve all equations together for the velocities; %d of them %s free", sol->free_columns, sol->free_columns == 1 ? "is" : "are");
    struct step *p = steps_add(&d->steps, STEP_SOLVE, sol->generations + 1, "identity", text);
    for (int i = 0; i < sys->rows; i++)
        if (sys->row[i].entries)
            steps_use(&d->steps, p, d->given[i]);
    for (int i = 0; i < sol->constraints; i++)
        steps_use(&d->steps, p, d->differentiated[i]);
    for (int i = 0; i < sys->variables; i++)
        steps_line(&d->steps, p, derivation_sheet_velocity(&d->sheet, i), component(d, i));
    return d->steps.count;
}

static void tell_contradiction(struct derivation *d)
{
    struct job *j = d->j;
    const struct sga_solution *sol = j->solution;
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 }, why = { 0 };
    int from = 0;
    if (sol->contradiction_parts) {
        struct derivation_sum sum = { sol->contradiction_part, sol->contradiction_parts, sol->contradiction_part[0].row >= 0, EXPR_UNDEF, INT_MAX,
                                      sol->contradiction_epoch, INT_MAX };
        struct derivation_terms t = derivation_sum_terms(d, &sum);
        derivation_terms_text(d, &t, &text);
        struct step *p = steps_add(&d->steps, STEP_INSERT, sol->generations + 1, "identity", text.data);
        derivation_use_terms(d, p, &t);
        expr_id left = derivation_sheet_copy(&d->sheet, sol->contradiction);
        steps_line(&d->steps, p, left, zero(d));
        if (!derivation_sum_is(d, &t, left))
            derivation_on_constraints(d, p, sol->constraints);
        from = d->steps.count;
    }
    sga_buf_printf(&why, "a contradiction: %s", sol->contradiction_why[0] ? sol->contradiction_why : "this has no zero on the constraints so far");
    struct step *p = steps_add(&d->steps, STEP_STOP, sol->generations + 1, "inconsistent", why.data);
    if (from)
        steps_use(&d->steps, p, from);
    for (int i = 0; !from && i < j->request->system.restrictions; i++)
        steps_use(&d->steps, p, d->restricted[i]);
    if (sol->contradiction) {
        p->relation = "!=";
        steps_line(&d->steps, p, derivation_sheet_copy(&d->sheet, sol->contradiction), zero(d));
    }
}

static void tell_stop(struct derivation *d, int field)
{
    const struct sga_solution *sol = d->j->solution;
    int dimension = d->steps.dimension;
    char text[300];
    if (sol->verdict == SGA_ISOLATED)
        snprintf(text, sizeof text, "the final set has dimension 0: it is made of points%s", sol->equilibrium == 1 ? ", at which the velocities vanish: constant solutions" : "");
    else if (sol->verdict == SGA_UNDERDETERMINED)
        snprintf(text, sizeof text, "the field is tangent to all constraints: nothing new appears, and the final set has dimension %d; the free velocities (%d) are functions to be chosen", dimension, sol->free_columns);
    else
        snprintf(text, sizeof text, "the field is tangent to all constraints: nothing new appears, and the final set has dimension %d; one solution runs through each of its points", dimension);
    SGA_ENDS(sga_buf_free) struct sga_buf all = { 0 };
    sga_buf_printf(&all, "%s%s", text, on_part(sol));
    struct step *p = steps_add(&d->steps, STEP_STOP, sol->generations + 1, sga_verdict_text(sol->verdict), all.data);
    steps_use(&d->steps, p, field);
}

static bool tell(struct derivation *d)
{
    const struct sga_solution *sol = d->j->solution;
    int listed = 0, top = sol->generations > 1 ? sol->generations : 1;
    tell_given(d);
    for (int g = 0; g <= top; g++) {
        for (int i = 0; i < sol->constraints; i++)
            if (sol->constraint[i].generation == g)
                tell_constraint(d, i);
        if (g)
            tell_redundant(d, g, g == top);
        tell_pivots(d, g, &listed);
        if (!job_goes_on(d->j))
            return false;
    }
    if (sol->verdict == SGA_INCONSISTENT) {
        tell_contradiction(d);
        return true;
    }
    tell_pivots(d, top + 1, &listed);
    tell_stop(d, tell_field(d));
    assert(d->steps.dimension == d->j->request->system.variables - sol->constraints);
    return true;
}

static void open_derivation(struct derivation *d, struct job *j)
{
    const struct sga_solution *sol = j->solution;
    const struct sys_system *sys = &j->request->system;
    size_t constraints = (size_t)sol->constraints + 1;
    *d = (struct derivation){ .j = j };
    derivation_sheet_open(&d->sheet, j);
    d->steps = (struct steps){ .sheet = &d->sheet, .mem = &d->mem, .dimension = sys->variables };
    d->given = sga_zeros(&d->mem, (size_t)sys->rows + 1, sizeof *d->given);
    d->restricted = sga_zeros(&d->mem, (size_t)sys->restrictions + 1, sizeof *d->restricted);
    d->special = sga_zeros(&d->mem, (size_t)sol->specials + 1, sizeof *d->special);
    d->found = sga_zeros(&d->mem, constraints, sizeof *d->found);
    d->insert = sga_zeros(&d->mem, constraints, sizeof *d->insert);
    d->differentiated = sga_zeros(&d->mem, constraints, sizeof *d->differentiated);
    d->solved = sga_zeros(&d->mem, (size_t)sol->rates + 1, sizeof *d->solved);
    d->xi = sga_zeros(&d->mem, constraints, sizeof *d->xi);
    for (int i = 0; i < sol->constraints; i++)
        d->xi[i] = derivation_sheet_read(&d->sheet, j->texts->names.root[i]);
}

bool answer_derivation(struct job *j)
{
    struct derivation d;
    struct sga_json w;
    stage_begin(j->clock, STAGE_DERIVATION);
    j->ask = j->ask ? j->ask : sga_zeros(&j->mem, 1, sizeof *j->ask);
    open_derivation(&d, j);
    bool ok = tell(&d) && job_goes_on(j);
    if (ok) {
        sga_json_begin(&w, &j->ask->derivation);
        steps_write(&d.steps, &w);
        ok = answer_fits(j, &j->ask->derivation);
    }
    derivation_sheet_close(&d.sheet);
    sga_arena_end(&d.mem);
    return ok;
}
