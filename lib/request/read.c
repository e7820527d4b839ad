/* The whole request, member by member. */
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "mem.h"
#include "reader.h"

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

/* What is wanted against what is given. */
static bool check_wants(struct reader *rd, const json_t *trajectory, const json_t *symmetries)
{
    struct request *r = rd->r;
    if (r->want & REQUEST_SYMMETRIES && !symmetries)
        return at_fail(rd, SGA_E_MISSING_MEMBER, "\"symmetries\" is wanted, but the member \"symmetries\" is missing; "
                       "it says what to check and what to search");
    unsigned needs = r->want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL);
    if (!needs)
        return true;
    if (!trajectory)
        return at_fail(rd, SGA_E_MISSING_MEMBER, "\"%s\" is wanted, but the member \"trajectory\" is missing",
                       r->want & REQUEST_TRAJECTORY ? "trajectory" : r->want & REQUEST_TRADEOFF ? "tradeoff"
                                                                                               : "consistent_initial");
    if (rd->symbolic[0]) {
        at_member(rd, "system");
        at_member(rd, "parameters");
        at_member(rd, rd->symbolic);
        return at_fail(rd, SGA_E_SCHEMA, "%s needs the value of the parameter \"%s\", which is null",
                       needs & REQUEST_TRAJECTORY ? "a trajectory" : needs & REQUEST_TRADEOFF ? "a tradeoff"
                                                                                            : "a consistent start",
                       rd->symbolic);
    }
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

static bool read_all(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "system", "want", "symmetries", "trajectory", "accuracy", "limits", "strata", "sweep",
                                           NULL };
    if (!only_members(rd, v, members))
        return false;
    const json_t *limits = json_object_get(v, "limits"), *accuracy = json_object_get(v, "accuracy");
    const json_t *trajectory = json_object_get(v, "trajectory"), *symmetries = json_object_get(v, "symmetries");
    const json_t *want = json_object_get(v, "want"), *strata = json_object_get(v, "strata"), *sweep = json_object_get(v, "sweep");
    const json_t *system = need_member(rd, v, "system");
    if (!system || (limits && !read_limits(rd, limits)))
        return false;
    set_bounds(rd);
    rd->r->store.max_bits = rd->r->limits.bits;
    if (rd->by_name)
        return read_system(rd, system) && store_ok(rd);
    if (!read_sweep_names(rd, sweep) || !read_system(rd, system) || !read_want(rd, want) || !read_sweep_parameters(rd, sweep))
        return false;
    if (!want && trajectory)
        rd->r->want |= REQUEST_TRAJECTORY;
    if (rd->r->has_mechanical && trajectory)
        read_mechanical_outputs(rd);
    return check_wants(rd, trajectory, symmetries)
        && (!trajectory || read_trajectory(rd, trajectory)) && (!sweep || read_sweep(rd, sweep)) && (!accuracy || read_accuracy(rd, accuracy))
        && (!symmetries || read_symmetries(rd, symmetries)) && (!strata || read_strata(rd, strata)) && read_tables_end(rd) && store_ok(rd);
}

bool request_read(struct request *r, const char *text, size_t length, struct sga_error *err)
{
    return request_read_within(r, text, length, NULL, err);
}

static bool read_text(struct reader *rd, const char *text, size_t length)
{
    struct request *r = rd->r;
    struct sga_error *err = rd->err;
    defaults(r);
    json_t *v = load_json(text, length, err);
    bool ok = v && read_all(rd, v);
    json_decref(v);
    sga_buf_free(&rd->at);
    free(rd->value);
    json_decref(rd->swept);
    free(rd->column);
    r->store.max_work_bits = 0;
    if (rd->bounds)
        rd->bounds->met = !ok && bounds_met(r, rd->bounds, err->code);
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

bool request_read_within(struct request *r, const char *text, size_t length, struct request_bounds *bounds, struct sga_error *err)
{
    struct sga_error own = { 0 };
    return read_text(&(struct reader){ .r = r, .err = err ? err : &own, .bounds = bounds }, text, length);
}

static void clear_trajectory(struct request_trajectory *t)
{
    for (int i = 0; i < t->initials; i++)
        free(t->initial[i].text);
    for (int i = 0; i < t->outputs; i++)
        free(t->output_text[i]);
    for (int i = 0; i < t->rates; i++)
        free(t->rate[i].text);
    for (int i = 0; i < t->conditions; i++)
        free(t->condition_text[i]);
    for (int i = 0; i < t->integrals; i++)
        free(t->integral_text[i]);
    for (int i = 0; i < t->events; i++) {
        free(t->event[i].name);
        free(t->event[i].text);
    }
    free(t->event);
    free(t->times);
    free(t->exact_times);
    free(t->initial);
    free(t->hold);
    free(t->output);
    free(t->output_text);
    free(t->rate);
    free(t->condition);
    free(t->condition_text);
    free(t->integral);
    free(t->integral_text);
}

static void clear_symmetries(struct request_symmetries *s)
{
    for (int k = 0; k < s->checks; k++) {
        free(s->check[k].name);
        free(s->check[k].component);
    }
    free(s->check);
    free(s->function);
}

static void clear_operator(struct request_operator *op)
{
    for (int k = 0; k < op->sources && op->source_name; k++)
        free(op->source_name[k]);
    free(op->source_name);
    free(op->unknown);
    free(op->source);
    free(op->A);
    free(op->B);
}

static void clear_hamiltonian(struct form_hamiltonian *h)
{
    if (!h)
        return;
    if (h->omega)
        free((void *)h->omega->entry);
    free((void *)h->omega);
    free((void *)h->variable);
    free((void *)h->restriction);
    free(h);
}

static void clear_mechanical(struct form_mechanical *m)
{
    free(m->coordinate);
    free(m->velocity);
    free(m->multiplier);
    free(m->mass);
    free(m->force);
    free(m->constraint);
}

void request_clear(struct request *r)
{
    clear_mechanical(&r->mechanical);
    free(r->forces.reaction);
    free(r->known);
    clear_operator(&r->op);
    clear_trajectory(&r->trajectory);
    clear_symmetries(&r->symmetries);
    for (int k = 0; k < r->sweeps; k++) {
        for (int i = 0; i < r->sweep[k].initials; i++)
            free(r->sweep[k].initial[i].text);
        free(r->sweep[k].initial);
        free(r->sweep[k].parameter);
        free(r->sweep[k].parameter_value);
    }
    free(r->sweep);
    free(r->swept);
    for (int k = 0; k < r->tables; k++) {
        free(r->table[k].name);
        expr_table_free(r->table[k].values);
    }
    free(r->table);
    sys_clear(&r->system);
    expr_store_clear(&r->store);
    free(r->name);
    free(r->accuracy.method);
    clear_hamiltonian(r->hamiltonian);
    *r = (struct request){ 0 };
}
