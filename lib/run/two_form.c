/* Whether the 2-form of a request is closed, and what the answer says about restrictions. */
#include "answer.h"

#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "poly.h"

enum { MOST_CYCLES = 4000, TEXT_BYTES = 400 };

/* Zero on the whole space: by algebra where that decides, by points of the space otherwise. */
static enum points_truth zero_everywhere(struct job *j, struct points_shadow *shadow, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, &j->budget);
    enum poly_truth t = poly_is_zero(&j->request.store, e, &limits);
    if (t != POLY_UNKNOWN)
        return t == POLY_YES ? POINTS_ZERO : POINTS_NONZERO;
    const struct sys_system *sys = &j->request.system;
    const struct form_hamiltonian *h = j->request.hamiltonian;
    if (!shadow->reals) {
        struct points_space space = {
            .st = sys->store, .variable = h->variable, .variables = h->variables, .parameter = sys->parameter,
            .parameters = sys->parameters, .time = sys->time, .near = j->start.x, .near_time = j->start.time, .budget = &j->budget,
        };
        if (points_shadow_sample(shadow, &space) != POINTS_OK)
            return POINTS_UNKNOWN;
    }
    return points_shadow_zero(shadow, e).truth;
}

bool answer_two_form(struct job *j)
{
    const struct form_hamiltonian *h = j->request.hamiltonian;
    struct form_cycle *cycle;
    struct points_shadow shadow;
    int cycles;
    if (!h || !h->omega)
        return true;
    points_shadow_init(&shadow, 3);
    j->two_form.checked = true;
    j->two_form.closed = form_cycles(&j->request.store, h->variable, h->variables, h->omega, MOST_CYCLES, &cycle, &cycles) ? 1 : -1;
    for (int k = 0; k < cycles && j->two_form.closed; k++) {
        enum points_truth t = zero_everywhere(j, &shadow, cycle[k].sum);
        if (t == POINTS_UNKNOWN)
            j->two_form.closed = -1;
        if (t != POINTS_NONZERO)
            continue;
        j->two_form.closed = 0;
        j->two_form.variable[0] = cycle[k].i;
        j->two_form.variable[1] = cycle[k].j;
        j->two_form.variable[2] = cycle[k].k;
        j->two_form.defect = cycle[k].sum;
    }
    points_shadow_clear(&shadow);
    free(cycle);
    return sga_budget_ok(&j->budget, j->err);
}

static void write_text(struct job *j, struct sga_json *w, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, &j->budget);
    expr_id normal;
    if (poly_normal(&j->request.store, e, &limits, &normal))
        e = normal;
    expr_json(&j->request.store, e, TEXT_BYTES, w);
}

static void write_two_form(struct job *j, struct sga_json *w)
{
    sga_json_key(w, "two_form");
    sga_json_object(w);
    sga_json_key(w, "closed");
    if (j->two_form.closed < 0)
        sga_json_null(w);
    else
        sga_json_bool(w, j->two_form.closed);
    if (j->two_form.closed == 0) {
        sga_json_key(w, "component");
        sga_json_array(w);
        for (int k = 0; k < 3; k++)
            sga_json_string(w, answer_variable_name(j, j->two_form.variable[k]));
        sga_json_end_array(w);
        sga_json_key(w, "defect");
        write_text(j, w, j->two_form.defect);
    }
    sga_json_end_object(w);
}

/* The vectors along which the equation was pulled back: row i is "pull-back i". */
static void write_tangent(struct job *j, struct sga_json *w)
{
    int n = j->request.system.variables;
    if (j->primary.tangent.count > SGA_MOST_TANGENT_LISTED)
        sga_limit_met(&j->budget, SGA_LIMIT_TANGENT_LISTED);
    sga_json_key(w, "pull_back");
    sga_json_array(w);
    for (int i = 0; i < j->primary.tangent.count && i < SGA_MOST_TANGENT_LISTED; i++) {
        const expr_id *v = j->primary.tangent.vector + (size_t)i * (size_t)n;
        sga_json_object(w);
        for (int k = 0; k < n; k++) {
            if (expr_is_zero(&j->request.store, v[k]))
                continue;
            sga_json_key(w, answer_variable_name(j, k));
            write_text(j, w, v[k]);
        }
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

void answer_write_restrictions(struct job *j, struct sga_json *w)
{
    int n = j->request.system.restrictions;
    if (j->two_form.checked)
        write_two_form(j, w);
    if (j->primary.has && j->request.want & REQUEST_CONSTRAINTS)
        write_tangent(j, w);
    if (!j->restriction_kept)
        return;
    sga_json_key(w, "redundant_restrictions");
    sga_json_array(w);
    for (int i = 0; i < n; i++)
        if (!j->restriction_kept[i])
            sga_json_int(w, i);
    sga_json_end_array(w);
}
