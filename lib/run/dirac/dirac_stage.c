/* The classes of the system in phase space, and their text. */
#include "dirac.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ask.h"
#include "buf.h"
#include "classes.h"
#include "error.h"
#include "form.h"
#include "oracle.h"
#include "print.h"
#include "reduce.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "stage_clock.h"
#include "system.h"
#include "table.h"

enum { SHOWN_BYTES = 4000 };

struct answer {
    struct job *j;
    struct job *inner;             /* of the system in phase space */
    struct sga_arena mem;
    struct weak weak;
    struct dirac_space space;
    struct dirac_system system;
    struct dirac_classes classes;
    struct dirac_generator generator;
    int *generation;               /* by constraint: 1 primary, 2 secondary, ... */
    struct sga_json *w;
};

static void put(const struct answer *a, expr_id e)
{
    expr_json(a->weak.st, weak_normal(&a->weak, e), SHOWN_BYTES, a->w);
}

static const char *name_of(const struct answer *a, int k)
{
    return a->weak.st->symbol[a->space.symbol[k]].name;
}

/* The constraints of the reduction, those of the restrictions first. */
static void take_constraints(struct answer *a)
{
    const struct sga_solution *sol = a->inner->solution;
    expr_id *chi = sga_zeros(&a->mem, (size_t)sol->constraints + 1, sizeof *chi);
    int *symbol = sga_zeros(&a->mem, (size_t)a->inner->request->system.variables + 1, sizeof *symbol), m = 0;
    int first = 2;                 /* in which generation of the reduction the secondary ones come */
    a->generation = sga_zeros(&a->mem, (size_t)sol->constraints + 1, sizeof *a->generation);
    for (int i = 0; i < sol->constraints; i++)
        if (sol->constraint[i].origin != SGA_FROM_RESTRICTION && sol->constraint[i].generation < first)
            first = sol->constraint[i].generation;
    for (int primary = 1; primary >= 0; primary--)
        for (int i = 0; i < sol->constraints; i++)
            if ((sol->constraint[i].origin == SGA_FROM_RESTRICTION) == primary) {
                a->generation[m] = primary ? 1 : sol->constraint[i].generation + 2 - first;
                chi[m++] = weak_normal(&a->weak, sol->constraint[i].expr);
                a->system.primaries += primary;
            }
    assert(m == sol->constraints && a->system.primaries <= m);       /* each once, primary or not */
    for (int k = 0; k < a->inner->request->system.variables; k++)
        symbol[k] = a->inner->request->system.variable[k].symbol;
    a->space = (struct dirac_space){ &a->weak, &a->mem, symbol, a->inner->request->system.variables / 2, a->inner->request->system.time };
    a->system.space = &a->space;
    a->system.hamiltonian = a->inner->request->hamiltonian->hamiltonian;
    a->system.chi = chi;
    a->system.constraints = m;
}

/* The reduction in phase space, the brackets, and the request's own reduction are three ways to the same numbers. */
static bool agree(struct answer *a)
{
    const struct sga_solution *own = a->j->solution, *phase = a->inner->solution;
    const struct request *r = a->j->request;
    int ambient = a->inner->request->system.variables, final = ambient - phase->constraints, free = a->classes.primary_firsts, fixed = 0;
    for (int k = 0; k < a->system.primaries; k++)
        fixed += a->classes.fixed[k];
    assert(a->classes.firsts + a->classes.seconds == a->system.constraints && a->classes.primary_firsts <= a->system.primaries);
    if (phase->free_columns != free || a->system.primaries - fixed != free)
        return sga_fail(a->j->err, SGA_E_WITNESS, "the brackets leave %d multipliers free, the reduction of the Hamiltonian system %d", free, phase->free_columns);
    if (r->hamiltonian)
        return true;
    bool second = r->system.rows > 0 && strncmp(r->system.row[r->coordinates].source, "definition", 10) == 0;
    bool plain = r->system.variables == 2 * r->coordinates;
    int fibre = second ? free : a->system.primaries;      /* velocities that the momenta do not tell ... */
    int own_free = second ? free : free + fibre;          /* ... and that are free without the condition of second order */
    int own_final = r->system.variables - own->constraints;
    if (own->verdict == SGA_INCONSISTENT || (plain && own_final != final + fibre) || own->free_columns != own_free)
        return sga_fail_at(a->j->err, SGA_E_UNDECIDED, "/want", "the Lagrangian's own reduction has a final set of dimension %d with %d free functions, which does not fit the %d and %d of the Hamiltonian side: "
                           "they were led to other branches; give trajectory.initial, or send the system in form \"hamiltonian\"", own_final, own->free_columns, final, free);
    return true;
}

static void write_list(const struct answer *a, const char *key, bool primary)
{
    sga_json_key(a->w, key);
    sga_json_array(a->w);
    for (int k = 0; k < a->system.constraints; k++) {
        if ((k < a->system.primaries) != primary)
            continue;
        if (primary) {
            put(a, a->system.chi[k]);
            continue;
        }
        sga_json_object(a->w);
        sga_json_member_int(a->w, "generation", a->generation[k]);
        sga_json_key(a->w, "expression");
        put(a, a->system.chi[k]);
        sga_json_end_object(a->w);
    }
    sga_json_end_array(a->w);
}

static void write_classes(const struct answer *a)
{
    sga_json_key(a->w, "first_class");
    sga_json_array(a->w);
    for (int k = 0; k < a->classes.firsts; k++) {
        sga_json_object(a->w);
        sga_json_key(a->w, "expression");
        put(a, a->classes.first[k]);
        sga_json_member_bool(a->w, "primary", k < a->classes.primary_firsts);
        sga_json_key(a->w, "generates");
        if (a->generator.why_not)
            sga_json_null(a->w);
        else
            sga_json_bool(a->w, !a->generator.idle[k]);
        sga_json_end_object(a->w);
    }
    sga_json_end_array(a->w);
    sga_json_key(a->w, "second_class");
    sga_json_array(a->w);
    for (int k = 0; k < a->classes.seconds; k++)
        put(a, a->system.chi[a->classes.second[k]]);
    sga_json_end_array(a->w);
}

static void write_bracket(const struct answer *a)
{
    int n2 = 2 * a->space.n;
    sga_json_key(a->w, "variables");
    sga_json_array(a->w);
    for (int k = 0; k < n2; k++)
        sga_json_string(a->w, name_of(a, k));
    sga_json_end_array(a->w);
    sga_json_key(a->w, "bracket");
    sga_json_array(a->w);
    for (int i = 0; i < n2; i++) {
        sga_json_array(a->w);
        for (int k = 0; k < n2; k++)
            put(a, a->classes.bracket[i * n2 + k]);
        sga_json_end_array(a->w);
    }
    sga_json_end_array(a->w);
}

/* u1, u2, ...: a name of the request is never used again. */
static void multiplier_name(const struct answer *a, int k, char *out, size_t size)
{
    snprintf(out, size, "u%d", k + 1);
    while (expr_symbol_find(a->weak.st, out, strlen(out)) >= 0 && strlen(out) + 2 < size)
        strcat(out, "_");
}

/* A multiplier's value: the factors times the free ones are put behind it. */
static void write_multiplier(const struct answer *a, int k)
{
    SGA_ENDS(sga_buf_free) struct sga_buf b = { 0 };
    bool ok = expr_print(a->weak.st, a->classes.multiplier[k], SHOWN_BYTES, &b);
    for (int f = 0; f < a->system.primaries && ok; f++) {
        expr_id e = a->classes.factor[k * a->system.primaries + f];
        char name[40];
        if (expr_is_zero(a->weak.st, e))
            continue;
        multiplier_name(a, f, name, sizeof name);
        sga_buf_puts(&b, " + (");
        ok = expr_print(a->weak.st, e, SHOWN_BYTES, &b);
        sga_buf_printf(&b, ")*%s", name);
    }
    if (ok)
        sga_json_string(a->w, b.data);
    else
        sga_json_null(a->w);
}

static void write_multipliers(const struct answer *a)
{
    char name[40];
    sga_json_key(a->w, "multipliers");
    sga_json_object(a->w);
    sga_json_key(a->w, "names");
    sga_json_array(a->w);
    for (int k = 0; k < a->system.primaries; k++) {
        multiplier_name(a, k, name, sizeof name);
        sga_json_string(a->w, name);
    }
    sga_json_end_array(a->w);
    sga_json_key(a->w, "fixed");
    sga_json_object(a->w);
    for (int k = 0; k < a->system.primaries; k++) {
        if (!a->classes.fixed[k])
            continue;
        multiplier_name(a, k, name, sizeof name);
        sga_json_key(a->w, name);
        write_multiplier(a, k);
    }
    sga_json_end_object(a->w);
    sga_json_key(a->w, "free");
    sga_json_array(a->w);
    for (int k = 0; k < a->system.primaries; k++) {
        if (a->classes.fixed[k])
            continue;
        multiplier_name(a, k, name, sizeof name);
        sga_json_string(a->w, name);
    }
    sga_json_end_array(a->w);
    sga_json_end_object(a->w);
}

/* The change of each variable by one term, those that do not move left out. */
static void write_moves(const struct answer *a, expr_id term)
{
    sga_json_key(a->w, "moves");
    sga_json_object(a->w);
    for (int k = 0; k < 2 * a->space.n; k++) {
        expr_id e = dirac_poisson(&a->space, a->weak.st->symbol[a->space.symbol[k]].node, term);
        if (expr_is_zero(a->weak.st, e))
            continue;
        sga_json_key(a->w, name_of(a, k));
        put(a, e);
    }
    sga_json_end_object(a->w);
}

static void write_generator(const struct answer *a)
{
    const struct dirac_generator *g = &a->generator;
    sga_json_key(a->w, "gauge_generator");
    if (g->why_not) {
        sga_json_null(a->w);
        sga_json_member_string(a->w, "no_generator", g->why_not);
        return;
    }
    sga_json_array(a->w);
    for (int p = 0; p < g->parameters; p++) {
        char name[40];
        snprintf(name, sizeof name, "epsilon%d", p + 1);
        sga_json_object(a->w);
        sga_json_member_string(a->w, "parameter", name);
        sga_json_key(a->w, "terms");
        sga_json_array(a->w);
        for (int k = 0; k < g->orders; k++) {
            expr_id e = g->term[p * g->orders + k];
            if (expr_is_zero(a->weak.st, e))
                continue;
            sga_json_object(a->w);
            sga_json_member_int(a->w, "derivative", k);
            sga_json_key(a->w, "expression");
            put(a, e);
            write_moves(a, e);
            sga_json_end_object(a->w);
        }
        sga_json_end_array(a->w);
        sga_json_end_object(a->w);
    }
    sga_json_end_array(a->w);
}

static void write_all(struct answer *a, const struct sga_buf *legendre)
{
    struct sga_json w;
    a->w = &w;
    sga_json_begin(&w, &a->j->ask->dirac);
    sga_json_object(&w);
    sga_json_key(&w, "legendre");
    if (legendre->len)
        sga_json_raw(&w, legendre->data, legendre->len);
    else
        sga_json_null(&w);
    sga_json_key(&w, "hamiltonian");
    put(a, a->system.hamiltonian);
    write_list(a, "primary", true);
    write_list(a, "secondary", false);
    write_classes(a);
    write_bracket(a);
    write_multipliers(a);
    write_generator(a);
    sga_json_member_int(&w, "degrees_of_freedom", (2 * a->space.n - 2 * a->classes.firsts - a->classes.seconds) / 2);
    sga_json_key(&w, "evidence");
    sga_json_object(&w);
    sga_json_member_int(&w, "final_dimension", 2 * a->space.n - a->system.constraints);
    sga_json_member_int(&w, "free_functions", a->classes.primary_firsts);
    sga_json_member_int(&w, "zeros_algebraic", a->inner->oracle->count[POINTS_ZERO_ALGEBRAIC]);
    sga_json_member_int(&w, "zeros_numeric", a->inner->oracle->count[POINTS_ZERO_NUMERIC]);
    sga_json_member_string(&w, "agrees_with", a->j->request->hamiltonian ? "the reduction of the Hamiltonian system" : "the reductions of the Lagrangian and of the Hamiltonian system");
    sga_json_end_object(&w);
    sga_json_end_object(&w);
}

/* The inner request's own limits are those of the job. */
static void share_limits(const struct job *j, struct request *r)
{
    r->limits = j->request->limits;
    r->store.max_nodes = j->request->store.max_nodes;
    r->store.deadline = j->request->store.deadline;
    r->store.seconds = j->request->store.seconds;
}

/* Values of tables, by parameter of the inner system. */
static void give_start(struct job *inner, const struct job *j)
{
    const struct sys_system *s = &inner->request->system;
    inner->start = j->start;
    if (!j->start.parameter)
        return;
    inner->start.parameter = sga_zeros(&inner->mem, (size_t)s->parameters + 1, sizeof *inner->start.parameter);
    for (int k = 0; k < s->parameters; k++) {
        const struct expr_symbol *p = s->store->symbol + s->parameter[k];
        inner->start.parameter[k] = p->table ? expr_table_value(p->table, p->order, j->start.time) : NAN;
    }
}

static bool in_phase_space(struct job *j, struct request *r, const struct sga_buf *legendre)
{
    struct job inner = { .request = r, .budget = j->budget, .warnings = j->warnings, .clock = j->clock, .err = j->err, .host = j->host, .stage = j->stage };
    struct answer a = { .j = j, .inner = &inner };
    share_limits(j, r);
    if (j->request->hamiltonian)                /* the same variables */
        give_start(&inner, j);
    bool ok = answer_reduce(&inner);
    stage_begin(j->clock, STAGE_DIRAC);
    if (ok && inner.solution->verdict == SGA_INCONSISTENT)
        ok = sga_fail_at(j->err, SGA_E_NO_MOTION, "/want", "the constraints contradict each other: there is nothing to put into classes");
    if (ok) {
        a.weak = (struct weak){ &r->store, inner.oracle, j->budget, j->err, NULL };
        take_constraints(&a);
        ok = dirac_classes_find(&a.classes, &a.system) && agree(&a) && dirac_generator_find(&a.generator, &a.system, &a.classes);
    }
    if (ok)
        write_all(&a, legendre);
    answer_reduce_clear(&inner);
    sga_arena_end(&inner.mem);
    sga_arena_end(&a.mem);
    return ok && job_goes_on(j) && answer_fits(j, &j->ask->dirac);
}

bool answer_dirac(struct job *j)
{
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 }, legendre = { 0 };
    struct request r;
    stage_begin(j->clock, STAGE_DIRAC);
    j->ask = j->ask ? j->ask : sga_zeros(&j->mem, 1, sizeof *j->ask);
    if (!dirac_phase_space(j, &text, &legendre))
        return false;
    if (!request_read(&r, text.data, text.len, j->err)) {
        snprintf(j->err->pointer, sizeof j->err->pointer, "/want");
        return false;
    }
    bool ok = in_phase_space(j, &r, &legendre);
    request_clear(&r);
    return ok;
}
