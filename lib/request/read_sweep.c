/* The member `sweep`: starts and parameters of trajectories that share one analysis. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reader.h"

enum { MOST_VALUES = 1000000 };     /* that members take from trajectory.initial, together */

static int by_variable(const void *a, const void *b)
{
    return ((const struct request_initial *)a)->variable - ((const struct request_initial *)b)->variable;
}

bool read_sweep_names(struct reader *rd, const json_t *v)
{
    rd->swept = json_object();
    bool ok = rd->swept != NULL;
    for (size_t i = 0; i < json_array_size(v); i++) {
        const char *key;
        json_t *item;
        json_object_foreach(json_object_get(json_array_get(v, i), "parameters"), key, item)
            if (!json_object_get(rd->swept, key))
                ok = ok && json_object_set_new(rd->swept, key, json_null()) == 0;
    }
    for (int i = 0; i < rd->opens; i++)
        ok = ok && json_object_set_new(rd->swept, rd->open[i].name, json_null()) == 0;
    if (!ok)
        return sga_fail(rd->err, SGA_E_LIMIT_MEMORY, "no memory is left to read the request; send a smaller one, or try again later");
    rd->r->swept = sga_zeros(&rd->r->mem, json_object_size(rd->swept) + 1, sizeof *rd->r->swept);
    return true;
}

/* The values of one set; *one is where they go. */
static bool read_values(struct reader *rd, const json_t *v, struct request_sweep *one)
{
    const struct request *r = rd->r;
    const char *key;
    json_t *item;
    one->parameter = sga_zeros(&rd->r->mem, (size_t)r->swept_count + 1, sizeof *one->parameter);
    one->parameter_value = sga_zeros(&rd->r->mem, (size_t)r->swept_count + 1, sizeof *one->parameter_value);
    for (int i = 0; i < r->swept_count; i++)
        one->parameter[i] = r->swept[i].value;
    size_t mark = at_member(rd, "parameters");
    if (v && !json_is_object(v))
        return expected(rd, "an object of names and values", v);
    json_object_foreach((json_t *)v, key, item) {
        size_t here = at_member(rd, key);
        int i = 0, symbol = expr_symbol_find(&r->store, key, strlen(key));
        while (i < r->swept_count && r->swept[i].symbol != symbol)
            i++;
        if (i == r->swept_count)
            return at_fail(rd, SGA_E_EXPR_NAME, "\"%.100s\" is not a parameter of the system; give it in system.parameters, with a "
                           "value or null", key);
        if (!read_exact(rd, item, one->parameter_value + i, one->parameter + i, NULL))
            return false;
        at_back(rd, here);
    }
    for (int i = 0; i < r->swept_count; i++)
        if (!one->parameter[i])
            return at_fail(rd, SGA_E_MISSING_MEMBER, "this set gives no value for the parameter \"%.100s\", which is null in "
                           "system.parameters", r->store.symbol[r->swept[i].symbol].name);
    for (int i = 0; i < r->swept_count; i++)
        constant_value(&r->store, one->parameter[i], one->parameter_value + i);
    at_back(rd, mark);
    return true;
}

/* The values of `from` go into request.within.name. */
static void put_values(json_t *request, const char *within, const char *name, json_t *from)
{
    json_t *in = json_object_get(request, within), *to = json_object_get(in, name);
    if (!json_is_object(from))
        return;
    if (!in)
        json_object_set_new(request, within, in = json_object());
    if (!to)
        json_object_set_new(in, name, to = json_object());
    json_object_update(to, from);
}

json_t *sweep_set_alone(const json_t *request, const json_t *set)
{
    json_t *alone = json_deep_copy(request);
    put_values(alone, "system", "parameters", json_object_get(set, "parameters"));
    put_values(alone, "trajectory", "initial", json_object_get(set, "initial"));
    return alone;
}

bool read_sweep_parameters(struct reader *rd, const json_t *v)
{
    struct request *r = rd->r;
    if (!v)
        return true;
    size_t mark = at_member(rd, "sweep"), n = json_array_size(v);
    if (!json_is_array(v))
        return expected(rd, "a list of starts or parameters", v);
    if (n < 1 || n > REQUEST_MAX_SWEEP)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu sets; there must be 1 to %d", n, REQUEST_MAX_SWEEP);
    if (n * (json_object_size(rd->swept) + 1) > MOST_VALUES)
        return at_fail(rd, SGA_E_SCHEMA, "%zu sets of %zu parameters are too many; the limit is %d values", n, json_object_size(rd->swept),
                       MOST_VALUES);
    r->sweep = sga_zeros(&rd->r->mem, n, sizeof *r->sweep);
    r->sweeps = (int)n;
    if (!json_object_size(rd->swept)) {
        at_back(rd, mark);
        return true;
    }
    if (r->want & (REQUEST_CONSISTENT_INITIAL | REQUEST_TRADEOFF))
        return at_fail(rd, SGA_E_NOT_SUPPORTED, "beside a sweep of parameters consistent_initial and tradeoff have no one answer; each "
                       "trajectory has its start in \"initial\"");
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        const json_t *one = json_array_get(v, i);
        if (!read_values(rd, json_object_get(one, "parameters"), r->sweep + i))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

void sweep_bind(struct reader *rd, int k)
{
    const struct request *r = rd->r;
    assert(k < rd->r->sweeps);
    for (int i = 0; i < r->swept_count; i++) {
        expr_id own = k < 0 ? r->swept[i].value : EXPR_UNDEF;
        rd->value[r->swept[i].symbol] = own ? own : r->sweep[k < 0 ? 0 : k].parameter[i];
    }
}

void sweep_unbind(struct reader *rd)
{
    for (int i = 0; i < rd->r->swept_count; i++)
        rd->value[rd->r->swept[i].symbol] = EXPR_UNDEF;
}

/* The values of trajectory.initial that this member does not give; they may depend on parameters that it does. */
static bool inherit(struct reader *rd, const unsigned char *taken, struct request_sweep *s)
{
    assert(s->initials <= rd->r->system.variables);
    const struct request_trajectory *t = &rd->r->trajectory;
    struct expr_store *st = &rd->r->store;
    size_t cap = (size_t)s->initials;
    SGA_RESERVE_IN(&rd->r->mem, s->initial, cap, s->initials + t->initials + 1);
    for (int i = 0; i < t->initials; i++) {
        if (taken[t->initial[i].variable])
            continue;
        struct request_initial *to = s->initial + s->initials++;
        *to = t->initial[i];
        to->text = NULL;
        if (!rd->r->swept_count)
            continue;
        to->exact = expr_parse(st, t->initial[i].text, &rd->grammar, rd->err);
        if (!to->exact || !constant_value(st, to->exact, &to->value))
            return at_fail(rd, SGA_E_EXPR_UNDEFINED, "at these parameters an initial value of trajectory.initial is no finite number: %.200s",
                           t->initial[i].text);
    }
    qsort(s->initial, (size_t)s->initials, sizeof *s->initial, by_variable);
    assert(s->initials <= rd->r->system.variables);
    return true;
}

static bool read_member(struct reader *rd, const json_t *v, unsigned char *taken, int k)
{
    static const char *const members[] = { "initial", "parameters", NULL };
    struct request_sweep *s = rd->r->sweep + k;
    if (!only_members(rd, v, members))
        return false;
    const json_t *initial = json_object_get(v, "initial");
    if (!initial && !json_object_get(v, "parameters") && !need_member(rd, v, "initial"))
        return false;
    memset(taken, 0, (size_t)rd->r->system.variables + 1);
    size_t mark = at_member(rd, "initial");
    sweep_bind(rd, k);
    bool ok = (!initial || read_initial(rd, initial, taken, &s->initial, &s->initials)) && inherit(rd, taken, s);
    sweep_unbind(rd);
    if (ok)
        at_back(rd, mark);
    return ok;
}

bool read_sweep(struct reader *rd, const json_t *v)
{
    size_t mark = at_member(rd, "sweep");
    if (!(rd->r->want & REQUEST_OF_SETS))
        return at_fail(rd, SGA_E_SCHEMA, "a sweep is one of trajectories, linearizations, transfer matrices, equilibria or fits, and none of them is wanted");
    if (json_array_size(v) * (size_t)(rd->r->trajectory.initials + 1) > MOST_VALUES)
        return at_fail(rd, SGA_E_SCHEMA, "%zu sets with %d values from trajectory.initial are too many; the limit is %d values",
                       json_array_size(v), rd->r->trajectory.initials, MOST_VALUES);
    SGA_FREED unsigned char *taken = sga_malloc((size_t)rd->r->system.variables + 1);
    bool ok = true;
    for (size_t i = 0; ok && i < json_array_size(v); i++) {
        size_t here = at_item(rd, v, i);
        if ((ok = read_member(rd, json_array_get(v, i), taken, (int)i)))
            at_back(rd, here);
    }
    if (ok)
        at_back(rd, mark);
    return ok;
}
