/* The stage `equilibria`: what is held, the search, and a spectrum for each point. */
#include "ask.h"

#include <stdio.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "request.h"
#include "rest_search.h"
#include "run_job.h"
#include "stage_clock.h"
#include "system.h"

static void add_input(struct rest *r, int variable)
{
    struct linear_input *to = (struct linear_input *)r->s.rq.input;
    if (r->input[variable])
        return;
    r->input[variable] = 1;
    to[r->s.rq.inputs++] = (struct linear_input){ answer_variable_name(r->j, variable), variable, -1 };
}

/* What the form calls inputs and what is freed; what is held too, as long as the motion leaves more to choose. */
static void set_inputs(struct rest *r)
{
    const struct sys_system *sys = &r->j->request->system;
    r->s.rq.input = sga_zeros(&r->s.mem, (size_t)sys->variables + 1, sizeof *r->s.rq.input);
    r->s.rq.inputs = 0;
    for (int k = 0; k < sys->variables; k++)
        if (strcmp(sys->variable[k].role, "input") == 0 && ask_is_free(r->j, k))
            add_input(r, k);
    for (int k = 0; k < r->ask->frees; k++)
        add_input(r, r->ask->free[k]);
    for (int k = 0; k < r->ask->holds && r->s.rq.inputs < r->j->solution->free_columns; k++)
        add_input(r, r->ask->hold[k].variable);
}

static void hold(struct rest *r, int variable, expr_id value)
{
    struct expr_store *st = r->s.rq.sys->store;
    r->held_zero[r->helds++] = expr_sub(st, st->symbol[r->s.rq.sys->variable[variable].symbol].node, value);
    r->held[variable] = 1;
}

static void hold_output(struct rest *r, const struct request_held *h)
{
    r->held_zero[r->helds++] = expr_sub(r->s.rq.sys->store, r->j->request->output[h->output], h->exact);
}

/* What is held by its value; inputs that are not freed at trajectory.initial. */
static bool set_held(struct rest *r)
{
    const struct request_trajectory *t = &r->j->request->trajectory;
    for (int k = 0; k < r->ask->holds; k++)
        hold(r, r->ask->hold[k].variable, r->ask->hold[k].exact);
    for (int k = 0; k < r->ask->outputs; k++)
        hold_output(r, r->ask->output + k);
    for (int k = 0; k < r->ask->frees; k++)
        r->held[r->ask->free[k]] = 1;
    for (int k = 0; k < t->initials; k++)
        if (r->input[t->initial[k].variable] && !r->held[t->initial[k].variable])
            hold(r, t->initial[k].variable, t->initial[k].exact);
    for (int k = 0; k < r->s.rq.inputs; k++)
        if (!r->held[r->s.rq.input[k].variable])
            return sga_fail_at(r->j->err, SGA_E_MISSING_MEMBER, "/equilibria", "nothing says where the input %.100s is held: give its value in equilibria.hold, or name "
                               "it in equilibria.free", r->s.rq.input[k].name);
    return true;
}

/* Rates in coordinates of some point, and what is held. */
static bool set_functions(struct rest *r)
{
    struct job *j = r->j;
    int n = j->request->system.variables;
    bool of_time = false;
    double *x = sga_zeros(&r->s.mem, (size_t)n + 1, sizeof *x);
    if (j->oracle->reals && j->oracle->real[0].variables == n)
        memcpy(x, j->oracle->real[0].x, (size_t)n * sizeof *x);
    struct linear_guess guess = { .x = x, .t = j->oracle->reals ? j->oracle->real[0].t : 0, .budget = j->budget };
    if (!linear_rates(&r->base, &r->s.rq, &guess, &of_time, j->err)) {
        if (strncmp(j->err->pointer, "/linearization", 14) == 0)
            snprintf(j->err->pointer, sizeof j->err->pointer, "/equilibria");
        return false;
    }
    if (of_time)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/want", "the motion depends on time or on tables, so that nothing stays at rest by itself; put values in the place of "
                           "the functions of time to look for equilibria");
    r->held_zero = sga_zeros(&r->s.mem, 2 * (size_t)n + (size_t)r->ask->outputs + 1, sizeof *r->held_zero);
    return set_held(r);
}

static void write_values(struct rest *r, const double *x)
{
    sga_json_object(&r->s.json);
    for (int k = 0; k < r->j->request->system.variables; k++)
        sga_json_member_double(&r->s.json, answer_variable_name(r->j, k), x[k]);
    sga_json_end_object(&r->s.json);
}

static void write_stable(struct sga_json *w, const struct linear_modes *m)
{
    static const char *const word[] = { "asymptotic", "marginal", "unstable" };
    sga_json_key(w, "stable");
    if (m->stability == LINEAR_UNDECIDED)
        sga_json_null(w);
    else
        sga_json_bool(w, m->stability != LINEAR_UNSTABLE);
    sga_json_key(w, "stability");
    if (m->stability == LINEAR_UNDECIDED)
        sga_json_null(w);
    else
        sga_json_string(w, word[m->stability]);
}

static void write_modes(struct sga_json *w, const struct linearization *l, const struct linear_modes *m)
{
    static const char *const basis[] = { "exact", "proved", "numeric" };
    linear_write_spectrum(w, "eigenvalues", &m->eigenvalues);
    write_stable(w, m);
    sga_json_key(w, "evidence");
    sga_json_object(w);
    sga_json_member_string(w, "point", basis[l->place.basis]);
    sga_json_member_string(w, "eigenvalues", m->eigenvalues.missing ? m->eigenvalues.missing : m->eigenvalues.exact ? "exact" : "enclosed");
    if (!m->eigenvalues.missing && !m->eigenvalues.exact)
        sga_json_member_double(w, "eigenvalue_error", m->eigenvalues.error);
    sga_json_member_string(w, "stability", m->why);
    sga_json_end_object(w);
}

/* A point that the linearization cannot be had at has no spectrum, and says why. */
static void write_no_modes(struct sga_json *w, const struct sga_error *why, bool exact)
{
    static const char *const member[] = { "eigenvalues", "stable", "stability" };
    for (int k = 0; k < 3; k++) {
        sga_json_key(w, member[k]);
        sga_json_null(w);
    }
    sga_json_key(w, "evidence");
    sga_json_object(w);
    sga_json_member_string(w, "point", exact ? "exact" : "numeric");
    sga_json_member_string(w, "eigenvalues", why->detail);
    sga_json_member_string(w, "stability", why->detail);
    sga_json_end_object(w);
}

/* What equilibria are about the point, where Newton's method tells (regular) or algebra. */
static void write_shape(struct rest *r, const struct equilibrium *p, const struct equilibrium_shape *shape, bool certified, int family)
{
    struct sga_json *w = &r->s.json;
    bool regular = certified && !p->degenerate, told = certified && p->degenerate && (shape->dimension >= 0 || r->finite);
    int dimension = !told ? family : r->finite ? 0 : shape->dimension;
    sga_json_key(w, "isolated");
    if (regular || told || (certified && (p->shifted || shape->crossing)))
        sga_json_bool(w, (regular || told) && dimension == 0);
    else
        sga_json_null(w);
    sga_json_key(w, "family_dimension");
    if (regular || told)
        sga_json_int(w, dimension);
    else
        sga_json_null(w);
}

static void write_head(struct rest *r, const struct equilibrium *p, const struct equilibrium_shape *shape, const double *x, bool certified, int family)
{
    struct sga_json *w = &r->s.json;
    sga_json_key(w, "values");
    write_values(r, x);
    sga_json_member_bool(w, "certified", certified);
    write_shape(r, p, shape, certified, family);
}

static bool write_point(struct rest *r, const struct equilibrium *p, const struct equilibrium_shape *shape, int family)
{
    struct job *j = r->j;
    struct linearization l;
    struct linear_modes m = { .exact = false };
    struct sga_error why = { .code = SGA_E_OK };
    struct linear_guess guess = { .x = p->x, .zero = p->zero, .zeros = p->zeros, .budget = j->budget };
    sga_json_object(&r->s.json);
    if (ask_linearize(&r->s, &l, &guess, &why) && linear_modes_find(&m, &l, j->budget, &why)) {
        bool certified = rest_certified(p, &l);
        r->certified += certified;
        write_head(r, p, shape, l.place.x, certified, family);
        write_modes(&r->s.json, &l, &m);
    } else {
        r->certified += p->kink || p->by_factors;
        write_head(r, p, shape, p->x, p->kink || p->by_factors, family);
        write_no_modes(&r->s.json, &why, p->kink);
    }
    linear_modes_clear(&m);
    linearization_clear(&l);
    sga_json_end_object(&r->s.json);
    return job_goes_on(j) && answer_fits(j, r->s.json.out);
}

static void write_searched(struct rest *r, const struct equilibria *e)
{
    struct sga_json *w = &r->s.json;
    sga_json_key(w, "searched");
    sga_json_object(w);
    sga_json_member_int(w, "starts", e->tried);
    sga_json_member_int(w, "reached", e->reached);
    sga_json_member_int(w, "outside", e->outside);
    sga_json_member_int(w, "irregular", e->beside);
    sga_json_key(w, "irregular_places");
    sga_json_array(w);
    for (int k = 0; k < e->irregulars; k++)
        write_values(r, e->irregular[k]);
    sga_json_end_array(w);
    sga_json_end_object(w);
}

static bool write_all(struct rest *r, const struct equilibria *e, const struct equilibria_algebra *a)
{
    struct sga_json *w = &r->s.json;
    bool ok = true;
    sga_json_object(w);
    sga_json_key(w, "points");
    sga_json_array(w);
    rest_families(r, e);
    for (int k = 0; k < e->points && ok; k++)
        ok = r->point[k].left_out || write_point(r, e->point + k, &r->point[k].shape, e->family);
    sga_json_end_array(w);
    SGA_ENDS(sga_buf_free) struct sga_buf why = { 0 };
    sga_json_member_bool(w, "complete", ok && rest_complete(r, e, a, &why));
    sga_json_member_string(w, "reason", why.len ? why.data : "");
    write_searched(r, e);
    sga_json_end_object(w);
    rest_families_clear(r);
    return ok;
}

static bool find(struct rest *r)
{
    const struct request_trajectory *t = &r->j->request->trajectory;
    struct equilibria e = { .points = 0 };
    for (int k = 0; k < t->initials; k++)
        r->near[t->initial[k].variable] = t->initial[k].value;
    for (int k = 0; k < r->ask->holds; k++)
        r->near[r->ask->hold[k].variable] = r->ask->hold[k].value;
    struct equilibria_algebra a;
    equilibria_by_algebra(&a, &r->s.rq, r->held_zero, r->helds, rest_has_parts(r->j->solution));
    struct equilibria_request q = rest_request(r, &a);
    r->finite = a.status == POLY_COUNTED;
    bool ok = equilibria_search(&e, &q, r->j->err) && write_all(r, &e, &a);
    equilibria_clear(&e);
    equilibria_algebra_clear(&a);
    return ok;
}

bool answer_equilibria(struct job *j)
{
    static const struct request_ports none = { .says_inputs = true };
    struct rest r = { .j = j, .ask = &j->request->equilibria };
    size_t n = (size_t)j->request->system.variables;
    stage_begin(j->clock, STAGE_EQUILIBRIA);
    j->ask = j->ask ? j->ask : sga_zeros(&j->mem, 1, sizeof *j->ask);
    if (!ask_possible(j))
        return false;
    ask_begin(&r.s, j, &none, &j->ask->equilibria);
    r.s.rq.outputs = 0;
    r.s.rq.said_in = "equilibria.free";
    r.input = sga_zeros(&r.s.mem, n + 1, 1);
    r.held = sga_zeros(&r.s.mem, n + 1, 1);
    r.near = sga_zeros(&r.s.mem, n + 1, sizeof *r.near);
    set_inputs(&r);
    bool ok = set_functions(&r) && find(&r);
    linearization_clear(&r.base);
    sga_arena_end(&r.s.mem);
    return ok;
}
