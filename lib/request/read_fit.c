/* The member `fit`: what is to be found, and from which data. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reader.h"
#include "suggest.h"

enum { MOST_DATA = 1000000 };

bool read_fit_names(struct reader *rd, const json_t *fit, const json_t *system)
{
    const json_t *parameters = json_object_get(fit, "parameters"), *values = json_object_get(system, "parameters");
    const char *key;
    json_t *item;
    if (rd->opens || !json_is_object(parameters))
        return true;
    struct request_open *open = sga_zeros(&rd->mem, json_object_size(parameters) + 1, sizeof *open);
    json_object_foreach((json_t *)parameters, key, item) {
        const json_t *guess = json_is_object(item) ? json_object_get(item, "guess") : item;
        if (!json_is_null(json_object_get(values, key)))
            continue;
        double near = json_is_number(guess) ? json_number_value(guess) : json_is_string(guess) ? strtod(json_string_value(guess), NULL) : 1;
        open[rd->opens++] = (struct request_open){ .name = key, .near = isfinite(near) ? near : 1 };
    }
    rd->open = open;
    rd->fitted = rd->opens ? parameters : NULL;
    return true;
}

/* {"guess", "bounds"}, or a guess alone. */
static bool read_unknown(struct reader *rd, const json_t *v, struct request_unknown *u)
{
    static const char *const members[] = { "guess", "bounds", NULL };
    u->low = -INFINITY;
    u->high = INFINITY;
    if (!json_is_object(v)) {
        u->has_guess = true;
        return read_value(rd, v, &u->guess, NULL);
    }
    const json_t *guess = json_object_get(v, "guess"), *bounds = json_object_get(v, "bounds");
    size_t mark = rd->at.len;
    if (!only_members(rd, v, members))
        return false;
    if (guess) {
        at_member(rd, "guess");
        if (!read_value(rd, guess, &u->guess, NULL))
            return false;
        u->has_guess = true;
        at_back(rd, mark);
    }
    if (!bounds)
        return true;
    at_member(rd, "bounds");
    if (!json_is_array(bounds) || json_array_size(bounds) != 2)
        return expected(rd, "two bounds, null for none", bounds);
    if (!read_bound_end(rd, bounds, 0, &u->low) || !read_bound_end(rd, bounds, 1, &u->high))
        return false;
    if (!(u->low < u->high))
        return at_fail(rd, SGA_E_SCHEMA, "the lower bound %g is not below the upper bound %g", u->low, u->high);
    at_back(rd, mark);
    return true;
}

static bool within(struct reader *rd, const struct request_unknown *u)
{
    return (u->guess >= u->low && u->guess <= u->high)
           || at_fail(rd, SGA_E_SCHEMA, "the guess %g of \"%.100s\" lies outside of its bounds; give one inside", u->guess, u->name);
}

/* The value of a parameter in system.parameters, for a guess. */
static bool known_value(const struct reader *rd, int symbol, double *value)
{
    const struct request *r = rd->r;
    for (int i = 0; i < r->knowns; i++)
        if (r->known[i].symbol == symbol)
            return constant_value(&r->store, r->known[i].value, value);
    for (int i = 0; i < r->swept_count; i++)
        if (r->swept[i].symbol == symbol && r->swept[i].value)
            return constant_value(&r->store, r->swept[i].value, value);
    return false;
}

/* It has no value in system.parameters. */
static bool is_open(const struct reader *rd, const char *name)
{
    for (int i = 0; i < rd->opens && rd->fitted; i++)
        if (!strcmp(rd->open[i].name, name))
            return true;
    return false;
}

static bool read_parameters(struct reader *rd, const json_t *v)
{
    struct request_fit *f = &rd->r->fit;
    const struct expr_store *st = &rd->r->store;
    const char *key;
    json_t *item;
    if (!json_is_object(v))
        return expected(rd, "an object of parameters and their guesses", v);
    if (json_object_size(v) > REQUEST_MAX_UNKNOWNS_FIT)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu parameters; the limit is %d", json_object_size(v), REQUEST_MAX_UNKNOWNS_FIT);
    f->parameter = sga_zeros(&rd->r->mem, json_object_size(v) + 1, sizeof *f->parameter);
    json_object_foreach((json_t *)v, key, item) {
        size_t mark = at_member(rd, key);
        struct request_unknown *u = f->parameter + f->parameters;
        int symbol = expr_symbol_find(st, key, strlen(key));
        if (symbol < 0 || st->symbol[symbol].kind != EXPR_PARAMETER || st->symbol[symbol].table) {
            struct suggest s;
            suggest_begin(&s, key, strlen(key));
            for (int i = 0; i < st->symbols; i++)
                if (st->symbol[i].kind == EXPR_PARAMETER)
                    suggest_offer(&s, st->symbol[i].name);
            return at_fail(rd, SGA_E_EXPR_NAME, "\"%.100s\" is not a parameter of the system; give it in system.parameters, with a value or null%s%s%s", key,
                           s.best ? "; did you mean \"" : "", s.best ? s.best : "", s.best ? "\"?" : "");
        }
        *u = (struct request_unknown){ .name = sga_take_text(&rd->r->mem, key), .variable = -1 };
        rd->r->store.symbol[symbol].mentioned = true;
        if (!read_unknown(rd, item, u))
            return false;
        if (!u->has_guess && (is_open(rd, key) || !known_value(rd, symbol, &u->guess)))
            return at_fail(rd, SGA_E_MISSING_MEMBER, "the parameter \"%.100s\" has neither a guess here nor a value in system.parameters", key);
        if (!within(rd, u))
            return false;
        f->parameters++;
        at_back(rd, mark);
    }
    return true;
}

static bool add_initial(struct reader *rd, const char *name, const json_t *v)
{
    struct request_fit *f = &rd->r->fit;
    struct request_unknown *u = f->initial + f->initials;
    int k = name ? state_variable(rd, name) : -1;
    if (k < 0)
        return false;
    for (int i = 0; i < f->initials; i++)
        if (f->initial[i].variable == k)
            return at_fail(rd, SGA_E_DUPLICATE_NAME, "the variable \"%.100s\" is given twice", name);
    *u = (struct request_unknown){ .low = -INFINITY, .high = INFINITY };
    if (v && !read_unknown(rd, v, u))
        return false;
    u->name = sga_take_text(&rd->r->mem, name);
    u->variable = k;
    f->initials++;
    return !u->has_guess || within(rd, u);
}

/* A list of names, or an object of names and {"guess", "bounds"}. */
static bool read_initials(struct reader *rd, const json_t *v)
{
    struct request_fit *f = &rd->r->fit;
    size_t n = json_is_object(v) ? json_object_size(v) : list_size(v);
    if (n > REQUEST_MAX_UNKNOWNS_FIT)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu initial values; the limit is %d", n, REQUEST_MAX_UNKNOWNS_FIT);
    f->initial = sga_zeros(&rd->r->mem, n + 1, sizeof *f->initial);
    const char *key;
    json_t *item;
    if (json_is_object(v)) {
        json_object_foreach((json_t *)v, key, item) {
            size_t mark = at_member(rd, key);
            if (!add_initial(rd, key, item))
                return false;
            at_back(rd, mark);
        }
        return true;
    }
    for (size_t i = 0; i < n; i++) {
        size_t mark = at_item(rd, v, i);
        const char *name = read_string(rd, list_item(v, i));
        if (!name || !add_initial(rd, name, NULL))
            return false;
        at_back(rd, mark);
    }
    return true;
}

static bool read_times(struct reader *rd, const json_t *v, struct request_experiment *e)
{
    double start = rd->r->trajectory.start, way = 0;
    size_t n = list_size(v);
    if (n < 1 || n > MOST_DATA)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu times; there must be 1 to %d", n, MOST_DATA);
    e->time = sga_zeros(&rd->r->mem, n, sizeof *e->time);
    for (size_t i = 0; i < n; i++) {
        size_t mark = at_item(rd, v, i);
        if (!read_value(rd, list_item(v, i), e->time + i, NULL))
            return false;
        double far = e->time[i] - start;
        if (far * way < 0)
            return at_fail(rd, SGA_E_SCHEMA, "%.17g lies on the other side of the start %.17g than the times before: the motion goes one way from trajectory.start; give an earlier one, or "
                           "an experiment of its own", e->time[i], start);
        way = far != 0 ? far : way;
        at_back(rd, mark);
    }
    e->times = (int)n;
    return true;
}

/* Numbers by time; null: none. */
static bool read_series(struct reader *rd, const json_t *v, int times, bool gaps, double *out)
{
    if (!json_is_array(v) || (int)json_array_size(v) != times)
        return json_is_array(v) ? at_fail(rd, SGA_E_SCHEMA, "there are %zu values for %d times", json_array_size(v), times) : expected(rd, "a list of numbers", v);
    for (int i = 0; i < times; i++) {
        const json_t *one = json_array_get(v, (size_t)i);
        size_t mark = at_index(rd, (size_t)i);
        out[i] = NAN;
        if (!(gaps && json_is_null(one)) && !read_value(rd, one, out + i, NULL))
            return false;
        at_back(rd, mark);
    }
    return true;
}

static bool read_weight(struct reader *rd, const json_t *weights, struct request_experiment *e)
{
    const char *key;
    json_t *item;
    size_t mark = at_member(rd, "weights");
    if (!json_is_object(weights))
        return expected(rd, "an object of outputs and weights", weights);
    json_object_foreach((json_t *)weights, key, item) {
        size_t here = at_member(rd, key);
        int c = 0;
        while (c < e->columns && strcmp(e->column[c].text, key) != 0)
            c++;
        if (c == e->columns)
            return at_fail(rd, SGA_E_EXPR_NAME, "there are no data of \"%.100s\", written like this, in data.columns", key);
        double all = 0, *w = e->column[c].weight;
        if (json_is_array(item) ? !read_series(rd, item, e->times, false, w) : !read_value(rd, item, &all, NULL))
            return false;
        for (int i = 0; i < e->times; i++) {
            w[i] = json_is_array(item) ? w[i] : all;
            if (!(w[i] >= 0))
                return at_fail(rd, SGA_E_SCHEMA, "a weight is negative; it multiplies the square of a difference, like 1/sigma^2");
        }
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool read_columns(struct reader *rd, const json_t *v, struct request_experiment *e)
{
    const char *key;
    json_t *item;
    if (!json_is_object(v) || !json_object_size(v))
        return expected(rd, "an object of outputs and their values", v);
    e->column = sga_zeros(&rd->r->mem, json_object_size(v), sizeof *e->column);
    json_object_foreach((json_t *)v, key, item) {
        size_t mark = at_member(rd, key);
        struct request_column *c = e->column + e->columns;
        json_t *text = json_string(key);
        c->output = text ? read_expression(rd, text, NULL) : EXPR_UNDEF;
        json_decref(text);
        if (!c->output)
            return false;
        c->text = sga_take_text(&rd->r->mem, key);
        c->value = sga_zeros(&rd->r->mem, (size_t)e->times, sizeof *c->value);
        c->weight = sga_zeros(&rd->r->mem, (size_t)e->times, sizeof *c->weight);
        for (int i = 0; i < e->times; i++)
            c->weight[i] = 1;
        if (!read_series(rd, item, e->times, true, c->value))
            return false;
        e->columns++;
        at_back(rd, mark);
    }
    return true;
}

static int by_variable(const void *a, const void *b)
{
    return ((const struct request_initial *)a)->variable - ((const struct request_initial *)b)->variable;
}

/* The experiment's own initial values, and those of the trajectory that it does not give. */
static bool read_own_initial(struct reader *rd, const json_t *v, struct request_experiment *e)
{
    const struct request_trajectory *t = &rd->r->trajectory;
    SGA_FREED unsigned char *taken = sga_calloc((size_t)rd->r->system.variables + 1, 1);
    struct request_initial *own = NULL;
    int owns = 0;
    size_t mark = at_member(rd, "initial");
    if (v) {
        sweep_bind(rd, -1);
        bool ok = read_initial(rd, v, taken, &own, &owns);
        sweep_unbind(rd);
        if (!ok || !open_initial(rd, own, owns))
            return false;
    }
    e->initial = sga_zeros(&rd->r->mem, (size_t)(owns + t->initials) + 1, sizeof *e->initial);
    for (int i = 0; i < owns; i++)
        e->initial[e->initials++] = own[i];
    for (int i = 0; i < t->initials; i++)
        if (!taken[t->initial[i].variable])
            e->initial[e->initials++] = t->initial[i];
    qsort(e->initial, (size_t)e->initials, sizeof *e->initial, by_variable);
    assert(e->initials <= rd->r->system.variables);
    at_back(rd, mark);
    return true;
}

/* Each unknown initial value has a guess. */
static bool guessed(struct reader *rd, const struct request_experiment *e)
{
    const struct request_fit *f = &rd->r->fit;
    for (int i = 0; i < f->initials; i++) {
        struct request_unknown u = f->initial[i];
        bool has = u.has_guess;
        for (int k = 0; k < e->initials && !has; k++)
            if (e->initial[k].variable == u.variable) {
                has = true;
                u.guess = e->initial[k].value;
            }
        if (!has)
            return at_fail(rd, SGA_E_MISSING_MEMBER, "nothing says where the initial value of \"%.100s\" is to be looked for: give a guess in fit.initial, or its value in "
                           "trajectory.initial or in the data's own", u.name);
        if (!within(rd, &u))
            return false;
    }
    return true;
}

static bool read_experiment(struct reader *rd, const json_t *v, const json_t *weights, struct request_experiment *e)
{
    static const char *const members[] = { "times", "columns", "weights", "initial", NULL };
    size_t mark = rd->at.len;
    if (!only_members(rd, v, members))
        return false;
    const json_t *times = need_member(rd, v, "times"), *columns = times ? need_member(rd, v, "columns") : NULL;
    if (!columns)
        return false;
    at_member(rd, "times");
    if (!read_times(rd, times, e))
        return false;
    at_back(rd, mark);
    at_member(rd, "columns");
    if (!read_columns(rd, columns, e))
        return false;
    at_back(rd, mark);
    if (!read_own_initial(rd, json_object_get(v, "initial"), e) || !guessed(rd, e))
        return false;
    const json_t *own = json_object_get(v, "weights");
    if (own)
        return read_weight(rd, own, e);
    if (!weights)
        return true;
    struct sga_buf keep = rd->at;       /* those of all stand elsewhere */
    rd->at = (struct sga_buf){ 0 };
    at_member(rd, "fit");
    bool ok = read_weight(rd, weights, e);
    if (ok) {
        sga_buf_free(&rd->at);
        rd->at = keep;
    } else {
        sga_buf_free(&keep);
    }
    return ok;
}

static bool read_data(struct reader *rd, const json_t *v, const json_t *weights)
{
    struct request_fit *f = &rd->r->fit;
    size_t n = list_size(v), mark = at_member(rd, "data");
    if (n < 1 || n > REQUEST_MAX_EXPERIMENTS)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu experiments; there must be 1 to %d", n, REQUEST_MAX_EXPERIMENTS);
    f->experiment = sga_zeros(&rd->r->mem, n, sizeof *f->experiment);
    f->list = json_is_array(v);
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        if (!read_experiment(rd, list_item(v, i), weights, f->experiment + i))
            return false;
        f->experiments++;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

bool read_fit(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "parameters", "initial", "data", "weights", "starts", NULL };
    struct request_fit *f = &rd->r->fit;
    size_t mark = at_member(rd, "fit");
    if (!only_members(rd, v, members))
        return false;
    const json_t *parameters = json_object_get(v, "parameters"), *initial = json_object_get(v, "initial"), *starts = json_object_get(v, "starts");
    const json_t *data = need_member(rd, v, "data");
    if (!data)
        return false;
    size_t here = at_member(rd, "parameters");
    if (parameters && !read_parameters(rd, parameters))
        return false;
    at_back(rd, here);
    at_member(rd, "initial");
    if (initial && !read_initials(rd, initial))
        return false;
    at_back(rd, here);
    if (!f->parameters && !f->initials)
        return at_fail(rd, SGA_E_EMPTY_SYSTEM, "nothing is to be found; name \"parameters\", \"initial\", or both");
    if (!read_data(rd, data, json_object_get(v, "weights")))
        return false;
    if (starts) {
        long n;
        at_member(rd, "starts");
        if (!read_integer(rd, starts, 0, REQUEST_MAX_FIT_STARTS, &n))
            return false;
        f->starts = (int)n;
    }
    at_back(rd, mark);
    return true;
}
