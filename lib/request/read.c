/* The whole request, member by member. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "error.h"
#include "form.h"
#include "mem.h"
#include "reader.h"
#include "table.h"

/* Reading alone may make so many bits of exact numbers: seconds of work, 32 MB. */
static const double WORK_BITS = 268435456;

static void defaults(struct request *r)
{
    *r = (struct request){ 0 };
    expr_store_init(&r->store);
    sys_init(&r->system, &r->store);
    r->accuracy = (struct request_accuracy){ .rtol = 1e-8, .atol = 1e-8 * REQUEST_ATOL_OF_RTOL, .arithmetic = REQUEST_AUTO };
    r->limits = (struct request_limits){ .seconds = 30, .nodes = 20000000, .generations = 1000, .bits = REQUEST_MAX_BITS };
    r->store.max_work_bits = WORK_BITS;
}

static bool needs_value(struct reader *rd, const char *what)
{
    at_member(rd, "system");
    at_member(rd, "parameters");
    at_member(rd, rd->symbolic);
    return at_fail(rd, SGA_E_SCHEMA, "%s needs the value of the parameter \"%s\", which is null", what, rd->symbolic);
}

/* What is wanted against what is given. */
static bool check_wants(struct reader *rd, const json_t *trajectory, const json_t *symmetries, const json_t *fit, const json_t *linearization)
{
    struct request *r = rd->r;
    unsigned numbers = REQUEST_TRANSFER | REQUEST_EQUILIBRIA | (json_is_true(json_object_get(linearization, "symbolic")) ? 0 : REQUEST_LINEARIZATION);
    if (r->want & REQUEST_SYMMETRIES && !symmetries)
        return at_fail(rd, SGA_E_MISSING_MEMBER, "\"symmetries\" is wanted, but the member \"symmetries\" is missing; "
                       "it says what to check and what to search");
    if (r->want & REQUEST_FIT && !fit)
        return at_fail(rd, SGA_E_MISSING_MEMBER, "\"fit\" is wanted, but the member \"fit\" is missing; it says what is to be found, and from which data");
    if (r->want & numbers && rd->symbolic[0])
        return needs_value(rd, r->want & numbers & REQUEST_LINEARIZATION ? "a linearization that is not symbolic" : r->want & REQUEST_TRANSFER ? "a transfer matrix" : "a search for equilibria");
    unsigned needs = r->want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL);
    if (!needs)
        return true;
    if (!trajectory)
        return at_fail(rd, SGA_E_MISSING_MEMBER, "\"%s\" is wanted, but the member \"trajectory\" is missing",
                       r->want & REQUEST_TRAJECTORY ? "trajectory" : r->want & REQUEST_TRADEOFF ? "tradeoff"
                                                                                               : "consistent_initial");
    if (rd->symbolic[0])
        return needs_value(rd, needs & REQUEST_TRAJECTORY ? "a trajectory" : needs & REQUEST_TRADEOFF ? "a tradeoff"
                                                                                                  : "a consistent start");
    return true;
}

/* omega(d/dq_i, d/dp_i) = 1 and nothing else: what leaving it out says. */
static bool is_canonical(const struct expr_store *st, const struct form_matrix *omega)
{
    size_t said = 0;
    for (size_t k = 0; k < omega->entries; k++) {
        const struct form_entry *e = omega->entry + k;
        bool above = e->col == e->row + omega->rows / 2, below = e->row == e->col + omega->rows / 2;
        if (expr_is_zero(st, e->value))
            continue;
        if (!expr_is_const(st, e->value) || !(above || below) || !fmpz_is_one(fmpq_denref(expr_const_value(st, e->value))) || !fmpz_equal_si(fmpq_numref(expr_const_value(st, e->value)), above ? 1 : -1))
            return false;
        said++;
    }
    return said == (size_t)omega->rows;
}

/* Dirac's theory is one of Lagrangians, and of Hamiltonians with the canonical form. */
static bool check_dirac(struct reader *rd)
{
    const struct request *r = rd->r;
    bool lagrangian = strcmp(r->form, "lagrangian") == 0;
    if (!(r->want & REQUEST_DIRAC))
        return true;
    if (!lagrangian && !r->hamiltonian) {
        at_member(rd, "want");
        return at_fail(rd, SGA_E_NOT_SUPPORTED, "\"dirac\" is for the forms \"lagrangian\" and \"hamiltonian\": equations of the form \"%s\" need not come from a Lagrangian", r->form);
    }
    at_member(rd, "system");
    if (lagrangian && !r->lagrangian) {
        at_member(rd, "forces");
        return at_fail(rd, SGA_E_NOT_SUPPORTED, "forces beside the Lagrangian are not variational: there is no Hamiltonian for them; put what has a potential into the Lagrangian, "
                       "or leave out \"dirac\"");
    }
    if (r->hamiltonian && r->hamiltonian->omega && !is_canonical(&r->store, r->hamiltonian->omega)) {
        at_member(rd, "omega");
        return at_fail(rd, SGA_E_NOT_SUPPORTED, "Dirac's classes are worked out for the canonical form; leave out omega, and name the variables q1..qk, p1..pk");
    }
    at_back(rd, 0);
    return true;
}

static bool read_strata(struct reader *rd, const json_t *v)
{
    size_t mark = at_member(rd, "strata");
    if (json_is_string(v)) {
        const char *word = json_string_value(v);
        rd->r->strata = strcmp(word, "solve") == 0;
        if (!rd->r->strata && strcmp(word, "list") != 0)
            return at_fail(rd, SGA_E_SCHEMA, "strata must be \"list\" or \"solve\"");
    } else if (!read_boolean(rd, v, &rd->r->strata)) {
        return false;
    }
    at_back(rd, mark);
    return true;
}

/* The request's own limits, or the narrower bounds of who asks. */
static void set_bounds(struct reader *rd)
{
    struct expr_store *st = &rd->r->store;
    st->seconds = rd->r->limits.seconds;
    st->max_nodes = rd->r->limits.nodes;
    if (rd->bounds && rd->bounds->seconds < st->seconds)
        st->seconds = rd->bounds->seconds;
    if (rd->bounds && rd->bounds->nodes < st->max_nodes)
        st->max_nodes = rd->bounds->nodes;
    st->deadline = sga_now() + st->seconds;
}

/* Did the bounds end the reading, and not the request's own limits? */
static bool bounds_met(const struct request *r, const struct request_bounds *b, enum sga_code code)
{
    return (code == SGA_E_LIMIT_NODES && r->store.max_nodes == b->nodes && b->nodes < r->limits.nodes)
        || (code == SGA_E_LIMIT_SECONDS && r->store.seconds < r->limits.seconds);
}

/* A part of the request that was read, or whose fault is listed. */
static bool part(struct reader *rd, bool ok)
{
    return ok || at_pass(rd, 0);
}

/* The members; limits have been read. */
static bool read_parts(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "system", "want", "symmetries", "trajectory", "accuracy", "limits", "strata", "sweep",
                                           "linearization", "transfer", "equilibria", "fit", "families", NULL };
    if (!only_members(rd, v, members))
        return false;
    const json_t *accuracy = json_object_get(v, "accuracy");
    const json_t *trajectory = json_object_get(v, "trajectory"), *symmetries = json_object_get(v, "symmetries");
    const json_t *want = json_object_get(v, "want"), *strata = json_object_get(v, "strata"), *sweep = json_object_get(v, "sweep");
    const json_t *linearization = json_object_get(v, "linearization"), *transfer = json_object_get(v, "transfer");
    const json_t *equilibria = json_object_get(v, "equilibria"), *fit = json_object_get(v, "fit");
    const json_t *families = json_object_get(v, "families");
    const json_t *system = need_member(rd, v, "system");
    if (!system)
        return false;
    if (rd->by_name)
        return read_system(rd, system) && store_ok(rd);
    bool stands = read_fit_names(rd, fit, system) && read_sweep_names(rd, sweep) && read_system(rd, system);
    if (!part(rd, stands) || !part(rd, read_want(rd, want)))
        return false;
    bool sets = stands && read_sweep_parameters(rd, sweep);       /* what starts from values of parameters that cannot be read is not read */
    if (stands && !part(rd, sets))
        return false;
    if (!want && fit)
        rd->r->want |= REQUEST_FIT;
    if (!want && trajectory && !fit)
        rd->r->want |= REQUEST_TRAJECTORY;
    if (!want && linearization)
        rd->r->want |= REQUEST_LINEARIZATION;
    if (!want && transfer)
        rd->r->want |= REQUEST_TRANSFER;
    if (!want && equilibria)
        rd->r->want |= REQUEST_EQUILIBRIA;
    if (stands && rd->r->mechanical && trajectory)
        read_mechanical_outputs(rd);
    return part(rd, check_wants(rd, trajectory, symmetries, fit, linearization)) && (!stands || part(rd, check_dirac(rd)))
        && (!trajectory || !sets || part(rd, read_trajectory(rd, trajectory))) && (!sweep || !sets || part(rd, read_sweep(rd, sweep)))
        && (!accuracy || part(rd, read_accuracy(rd, accuracy))) && (!symmetries || !stands || part(rd, read_symmetries(rd, symmetries)))
        && (!linearization || !stands || part(rd, read_linearization(rd, linearization)))
        && (!transfer || !stands || part(rd, read_transfer(rd, transfer)))
        && ((!equilibria && !(rd->r->want & REQUEST_EQUILIBRIA)) || !stands || part(rd, read_equilibria(rd, equilibria)))
        && (!fit || !stands || part(rd, read_fit(rd, fit)))
        && (!families || part(rd, read_families(rd, families)))
        && (!strata || part(rd, read_strata(rd, strata))) && (!stands || read_tables_end(rd)) && store_ok(rd);
}

static bool read_all(struct reader *rd, json_t *v)
{
    const json_t *limits = json_object_get(v, "limits");
    if (limits && !part(rd, read_limits(rd, limits)))
        return false;
    set_bounds(rd);
    rd->r->store.max_bits = rd->r->limits.bits;
    json_t *plain = write_out(rd, v);
    bool ok = plain && read_parts(rd, plain);
    json_decref(plain);
    return ok;
}

bool request_read(struct request *r, const char *text, size_t length, struct sga_error *err)
{
    return request_read_within(r, text, length, NULL, err);
}

bool request_sane(const struct request *r)
{
    const struct request_trajectory *t = &r->trajectory;
    bool sane = sys_sane(&r->system) && (!r->sweeps || r->want & REQUEST_OF_SETS) && r->accuracy.rtol > 0 && r->accuracy.atol > 0;
    for (int i = 0; i < t->initials && sane; i++)
        sane = t->initial[i].variable > (i ? t->initial[i - 1].variable : -1) && t->initial[i].variable < r->system.variables;
    for (int i = 0; i < t->rates && sane; i++)
        sane = t->rate[i].variable > (i ? t->rate[i - 1].variable : -1) && t->rate[i].variable < r->system.variables;
    for (int k = 1; k < t->samples && sane && t->times; k++)
        sane = (t->times[k] > t->times[k - 1]) == (t->times[1] > t->times[0]) && t->times[k] != t->times[k - 1];
    return sane;
}

/* What ended the reading is the last fault, unless it is one of the bounds. */
static bool close_faults(struct reader *rd, bool ok)
{
    bool bounds = !ok && rd->bounds && bounds_met(rd->r, rd->bounds, rd->err->code);
    if (!ok && !bounds && rd->err->code != SGA_E_OK)
        faults_add(rd);
    rd->faults->cut |= bounds && rd->faults->count > 0;
    return ok && !rd->faults->count;
}

/* Of the passes of a loop that are wrong in one way at one place the first is told. */
static void same_places(struct request_faults *f)
{
    int kept = 0;
    for (int i = 0; i < f->count; i++) {
        const struct sga_error *e = f->list + i;
        bool told = false;
        for (int k = 0; k < kept && !told && e->pointer[0]; k++) {
            const struct sga_error *o = f->list + k;
            told = o->code == e->code && o->line == e->line && o->column == e->column && strcmp(o->pointer, e->pointer) == 0;
        }
        if (!told)
            f->list[kept++] = *e;
    }
    f->count = kept;
}

static bool read_text(struct reader *rd, const char *text, size_t length)
{
    rd->grammar.max_length = REQUEST_MAX_EXPRESSION;
    struct request *r = rd->r;
    struct sga_error *err = rd->err;
    defaults(r);
    json_t *v = load_json(text, length, err);
    bool ok = v && read_all(rd, v);
    if (rd->faults)
        ok = close_faults(rd, ok);
    if (rd->written) {
        written_place(rd->written, v, err);
        for (int i = 0; rd->faults && i < rd->faults->count; i++)
            written_place(rd->written, v, rd->faults->list + i);
        if (rd->faults)
            same_places(rd->faults);
        if (ok)
            start_equations_written(rd, v);
        written_end(rd->written);
    }
    json_decref(v);
    sga_buf_free(&rd->at);
    free(rd->value);
    json_decref(rd->swept);
    sga_arena_end(&rd->mem);
    r->store.max_work_bits = 0;
    if (rd->bounds)
        rd->bounds->met = !ok && bounds_met(r, rd->bounds, err->code);
    assert(!ok || request_sane(r));
    if (!ok) {
        if (err->code != SGA_E_OK && !err->stage[0])
            strcpy(err->stage, "request");
        make_utf8(err->detail);
        make_utf8(err->pointer);
        request_clear(r);
    }
    return ok;
}

bool request_read_named(struct request *r, const char *text, size_t length, int nodes)
{
    struct sga_error ignored = { 0 };
    struct request_bounds bounds = { .seconds = 1, .nodes = nodes };
    return read_text(&(struct reader){ .r = r, .err = &ignored, .bounds = &bounds, .by_name = true }, text, length);
}

bool request_read_open(struct request *r, const char *text, size_t length, const struct request_open *open, int opens, struct sga_error *err)
{
    return read_text(&(struct reader){ .r = r, .err = err, .open = open, .opens = opens }, text, length);
}

bool request_read_modes(struct request *r, const char *text, size_t length, const struct request_choice *mode, struct sga_error *err)
{
    return read_text(&(struct reader){ .r = r, .err = err, .choice = mode->choice, .open = mode->open, .opens = mode->opens }, text, length);
}

bool request_read_within(struct request *r, const char *text, size_t length, struct request_bounds *bounds, struct sga_error *err)
{
    struct sga_error own = { 0 };
    return read_text(&(struct reader){ .r = r, .err = err ? err : &own, .bounds = bounds }, text, length);
}

bool request_read_all(struct request *r, const char *text, size_t length, struct request_bounds *bounds, struct request_faults *faults)
{
    struct sga_error err = { 0 };
    *faults = (struct request_faults){ 0 };
    const char *form = NULL;
    struct reader rd = { .r = r, .err = &err, .bounds = bounds, .faults = faults, .form = &form };
    bool ok = read_text(&rd, text, length);
    r->form = form;
    return ok || (bounds->met && !faults->count);
}

/* The text, and the same with ranges and loops written out (the same object where there are none; NULL: err). Both are the caller's. */
static json_t *plain_of(const char *text, size_t length, json_t **as_it_stands, struct sga_error *err)
{
    struct request r;
    struct sga_error own = { 0 };
    struct reader rd = { .r = &r, .err = err ? err : &own };
    defaults(&r);
    r.store.seconds = r.limits.seconds;
    r.store.deadline = sga_now() + r.limits.seconds;
    json_t *v = load_json(text, length, rd.err), *plain = v ? write_out(&rd, v) : NULL;
    if (rd.written)
        written_end(rd.written);
    sga_buf_free(&rd.at);
    sga_arena_end(&rd.mem);
    request_clear(&r);
    *as_it_stands = v;
    return plain;
}

bool request_plain(const char *text, size_t length, struct sga_buf *out, struct sga_error *err)
{
    json_t *v, *plain = plain_of(text, length, &v, err);
    if (plain == v && v)
        sga_buf_put(out, text, length);
    else if (plain)
        write_json(out, plain);
    json_decref(plain);
    json_decref(v);
    return plain != NULL;
}

/* A request without its sweep, and that. */
struct request_sets { json_t *alone, *set; };

struct request_sets *request_sets_new(const char *text, size_t length, struct sga_error *err)
{
    json_t *v, *plain = plain_of(text, length, &v, err);
    struct request_sets *s = plain ? sga_calloc(1, sizeof *s) : NULL;
    if (s) {
        s->alone = json_copy(plain);
        s->set = json_incref(json_object_get(plain, "sweep"));
        json_object_del(s->alone, "sweep");
    }
    json_decref(plain);
    json_decref(v);
    return s;
}

void request_sets_text(const struct request_sets *s, int k, struct sga_buf *out)
{
    assert(k >= 0 && (size_t)k < json_array_size(s->set));
    json_t *one = sweep_set_alone(s->alone, json_array_get(s->set, (size_t)k));
    write_json(out, one);
    json_decref(one);
}

void request_sets_free(struct request_sets *s)
{
    if (!s)
        return;
    json_decref(s->alone);
    json_decref(s->set);
    free(s);
}

void request_clear(struct request *r)
{
    for (int k = 0; k < r->tables; k++)
        expr_table_free(r->table[k].values);
    free(r->known);
    sys_clear(&r->system);
    expr_store_clear(&r->store);
    sga_arena_end(&r->mem);
    *r = (struct request){ 0 };
}
