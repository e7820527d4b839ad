/* Before the first stage. */
#include "guess.h"
#include "budget.h"
#include "request.h"
#include "stage_list.h"
#include "system.h"
#include "table.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "error.h"

/* What neither slides nor events that set variables go with; NULL: nothing of it is asked for. */
static const char *beyond_plain(const struct request *r)
{
    const struct request_trajectory *t = &r->trajectory;
    return t->integrals ? "the drift of integrals"
        : !strcmp(r->form, "operator") ? "the form operator"
        : NULL;
}

/* Events that set variables: not every motion can carry them. */
static bool check_sets(struct job *j)
{
    const struct request *r = j->request;
    const struct request_trajectory *t = &r->trajectory;
    const char *what = NULL;
    char place[64];
    int e = 0;
    while (e < t->events && !t->event[e].sets)
        e++;
    if (e == t->events)
        return true;
    if (r->want & (REQUEST_TRADEOFF | REQUEST_LINEARIZATION | REQUEST_TRANSFER))
        what = "tradeoff, linearization or transfer";
    else if (r->modes && t->conditions)
        what = "modes and gauge conditions";
    else if (r->modes && r->strata)
        what = "modes and solved strata";
    else
        what = beyond_plain(r);
    snprintf(place, sizeof place, "/trajectory/events/%d/set", e);
    return !what || sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, place, "events that set variables do not go with %s; leave one of them out", what);
}

/* Slides: not every motion can have them. */
static bool check_sliding(struct job *j)
{
    const struct request *r = j->request;
    const struct request_trajectory *t = &r->trajectory;
    const char *what = NULL;
    bool sets = false;
    if (!t->sliding)
        return true;
    for (int e = 0; e < t->events; e++)
        sets |= t->event[e].sets > 0;
    if (r->want & REQUEST_TRADEOFF)
        what = "tradeoff";
    else if (sets || r->modes)
        what = "modes and events that set variables";
    else if (t->conditions || t->rates)
        what = "a choice of gauge";
    else if (r->strata)
        what = "solved strata";
    else
        what = beyond_plain(r);
    return !what || sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/trajectory/sliding", "slides do not go with %s; leave one of them out", what);
}

/* What is wanted but cannot be had yet is refused before any work is done. */
static bool check_wants(struct job *j)
{
    if (j->request->want & REQUEST_TRADEOFF && j->request->sweeps)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/want", "a tradeoff is measured on one motion; leave out \"sweep\", or "
                           "send a request of its own");
    if (!check_sets(j) || !check_sliding(j))
        return false;
    const struct request_trajectory *t = &j->request->trajectory;
    if (j->request->want & REQUEST_FIT && (t->relations || t->low))
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, t->relations ? "/trajectory/start_equations" : "/trajectory/bounds", "a fit finds initial values itself, from its own guesses; leave "
                           "start_equations and bounds out, or write what holds at the start with parameters in trajectory.initial");
    if (j->request->op.open_sources && j->request->want & REQUEST_DERIVATION)
        return sga_fail_at(j->err, SGA_E_NO_MOTION, "/system/sources", "for a derivation, give each source as a function of time");
    if (j->request->op.open_sources && j->request->want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL))
        return sga_fail_at(j->err, SGA_E_NO_MOTION, "/system/sources", "to follow a motion, give each source as a function of time");
    return true;
}

/* Samples that cannot fit are refused before any work is done. */
static bool check_samples(struct job *j)
{
    const struct request_trajectory *t = &j->request->trajectory;
    if (!(j->request->want & REQUEST_TRAJECTORY))
        return true;
    double columns = 1 + (double)(t->outputs ? t->outputs : j->request->system.variables) * (1 + t->sensitivities.parameters + t->sensitivities.initials);
    double numbers = columns * (double)t->samples * (j->request->sweeps ? j->request->sweeps : 1), most = (double)answer_limit(j);
    if (2 * numbers <= most && 8 * numbers <= (double)j->budget->max_memory)
        return true;
    bool text = 2 * numbers > most;
    return sga_fail_at(j->err, text ? SGA_E_LIMIT_RESULT : SGA_E_LIMIT_MEMORY, "/trajectory",
                       "%.0f samples of %.0f columns need %.0f MB at least; the limit of %s is %.0f MB; ask for fewer samples, "
                       "or for fewer columns in trajectory.outputs", numbers / columns, columns,
                       (text ? 2 : 8) * numbers * 0x1p-20, text ? "a result" : "memory",
                       (text ? most : (double)j->budget->max_memory) * 0x1p-20);
}

/* Where the request starts is a hint for which component of the constraint set is meant. */
static void set_near(struct job *j)
{
    const struct request_trajectory *t = &j->request->trajectory;
    j->start.time = t->start;
    if (!t->initials)
        return;
    j->start.x = sga_zeros(&j->mem, (size_t)j->request->system.variables, sizeof *j->start.x);
    for (int k = 0; k < t->initials; k++)
        j->start.x[t->initial[k].variable] = t->initial[k].value;
    const struct sys_system *s = &j->request->system;
    if (j->request->tables) {
        j->start.parameter = sga_zeros(&j->mem, (size_t)s->parameters + 1, sizeof *j->start.parameter);
        for (int k = 0; k < s->parameters; k++) {
            const struct expr_symbol *p = s->store->symbol + s->parameter[k];
            j->start.parameter[k] = p->table ? expr_table_value(p->table, p->order, t->start) : NAN;
        }
    }
    j->start.given = sga_zeros(&j->mem, (size_t)s->variables + 1, 1);
    for (int k = 0; k < t->initials; k++)
        j->start.given[t->initial[k].variable] = 1;
    guess_complete(s, j->start.given, j->start.time, j->start.parameter, j->start.x);
}

bool job_prepare(struct job *j)
{
    set_near(j);
    return check_wants(j) && check_samples(j);
}
