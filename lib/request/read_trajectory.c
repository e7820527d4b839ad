/* The member `trajectory`: when, from where, what to give, how to fix the gauge. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reader.h"

enum { DEFAULT_SAMPLES = 101 };

static bool read_start(struct reader *rd, const json_t *v, const char *member, double *out, expr_id *exact, bool *has)
{
    const json_t *m = json_object_get(v, member);
    *has = m != NULL;
    if (!m)
        return true;
    size_t mark = at_member(rd, member);
    if (!read_exact(rd, m, out, exact, NULL))
        return false;
    at_back(rd, mark);
    return true;
}

/* start + (stop - start) i/n as decimals have it: -1 to 1 in fifths comes to -0.2, not to -0.19999999999999996. */
static double evenly(double start, double stop, long i, long n)
{
    return (double)(((long double)start * (long double)(n - i) + (long double)stop * (long double)i) / (long double)n);
}

static bool spread_samples(struct reader *rd, const json_t *v, double stop)
{
    struct request_trajectory *t = &rd->r->trajectory;
    const json_t *m = json_object_get(v, "samples");
    long n = DEFAULT_SAMPLES;
    if (m) {
        size_t mark = at_member(rd, "samples");
        if (!read_integer(rd, m, 2, REQUEST_MAX_SAMPLES, &n))
            return false;
        at_back(rd, mark);
    }
    double span = stop - t->start;
    if (!(fabs(span) > 0) || !isfinite(span) || t->start + span / (double)(n - 1) == t->start) {
        at_member(rd, "stop");
        return at_fail(rd, SGA_E_SCHEMA, "from start %.17g to stop %.17g there is no room for %ld different times",
                       t->start, stop, n);
    }
    t->times = sga_take(&rd->r->mem, (size_t)n * sizeof *t->times);
    for (long i = 0; i < n; i++)
        t->times[i] = i == n - 1 ? stop : evenly(t->start, stop, i, n - 1);
    t->samples = (int)n;
    assert(t->times[n - 1] == stop);
    return true;
}

static bool read_times(struct reader *rd, const json_t *v, bool has_start)
{
    struct request_trajectory *t = &rd->r->trajectory;
    size_t mark = at_member(rd, "times"), n = list_size(v);
    if (n < 1 || n > REQUEST_MAX_SAMPLES)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu times; there must be 1 to %d", n, REQUEST_MAX_SAMPLES);
    t->times = sga_take(&rd->r->mem, n * sizeof *t->times);
    t->exact_times = sga_take(&rd->r->mem, n * sizeof *t->exact_times);
    bool ordered = true;
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        if (!read_exact(rd, list_item(v, i), t->times + i, t->exact_times + i, NULL)) {
            if (!at_pass(rd, here))
                return false;
            ordered = false;
        }
        at_back(rd, here);
    }
    if (!ordered)
        return false;
    t->samples = (int)n;
    if (!has_start) {
        t->start = t->times[0];
        t->exact_start = t->exact_times[0];
    }
    bool down = t->times[n - 1] < t->start;
    for (size_t i = 0; i < n; i++) {
        double last = i ? t->times[i - 1] : t->start, now = t->times[i];
        if ((i == 0 && now == last) || (down ? now < last : now > last))
            continue;
        at_item(rd, v, i);
        return at_fail(rd, SGA_E_SCHEMA, "times must go one way from start: %.17g follows %.17g", now, last);
    }
    at_back(rd, mark);
    return true;
}

static bool read_when(struct reader *rd, const json_t *v)
{
    bool has_start, has_stop;
    double stop = 0;
    const json_t *times = json_object_get(v, "times");
    struct request_trajectory *t = &rd->r->trajectory;
    t->exact_start = t->exact_stop = expr_int(&rd->r->store, 0);
    if (!read_start(rd, v, "start", &t->start, &t->exact_start, &has_start)
        || !read_start(rd, v, "stop", &stop, &t->exact_stop, &has_stop))
        return false;
    if (times && (has_stop || json_object_get(v, "samples")))
        return at_member(rd, "times"),
               at_fail(rd, SGA_E_SCHEMA, "give either times, or stop and samples, not both");
    if (times)
        return read_times(rd, times, has_start);
    if (has_stop)
        return spread_samples(rd, v, stop);
    if (rd->r->want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF))
        return at_fail(rd, SGA_E_MISSING_MEMBER, "a trajectory needs \"stop\" or \"times\"");
    return true;
}

static int by_initial(const void *a, const void *b)
{
    return ((const struct request_initial *)a)->variable - ((const struct request_initial *)b)->variable;
}

static int by_rate(const void *a, const void *b)
{
    return ((const struct request_rate *)a)->variable - ((const struct request_rate *)b)->variable;
}

/* The variable that a key names, which must not be named twice (x' and der(x)). */
static int new_variable(struct reader *rd, const char *name, unsigned char *taken)
{
    int k = state_variable(rd, name);
    if (k >= 0 && taken[k])
        return at_fail(rd, SGA_E_DUPLICATE_NAME, "the variable \"%.100s\" is given twice", name), -1;
    if (k >= 0)
        taken[k] = 1;
    return k;
}

bool read_initial(struct reader *rd, const json_t *v, unsigned char *taken, struct request_initial **list, int *count)
{
    if (!json_is_object(v))
        return expected(rd, "an object of variables and values", v);
    *list = sga_zeros(&rd->r->mem, json_object_size(v) + 1, sizeof **list);
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item) {
        size_t mark = at_member(rd, key);
        struct request_initial *i = *list + *count;
        i->variable = new_variable(rd, key, taken);
        if (i->variable >= 0 && read_exact(rd, item, &i->value, &i->exact, &i->text))
            ++*count;
        else if (!at_pass(rd, mark))
            return false;
        at_back(rd, mark);
    }
    qsort(*list, (size_t)*count, sizeof **list, by_initial);
    return true;
}

static bool read_hold(struct reader *rd, const json_t *v, unsigned char *taken)
{
    struct request_trajectory *t = &rd->r->trajectory;
    t->hold = sga_zeros(&rd->r->mem, list_size(v) + 1, sizeof *t->hold);
    for (size_t i = 0; i < list_size(v); i++) {
        size_t mark = at_item(rd, v, i);
        const char *name = read_string(rd, list_item(v, i));
        int k = name ? new_variable(rd, name, taken) : -1;
        if (k < 0 && !at_pass(rd, mark))
            return false;
        if (k >= 0)
            t->hold[t->holds++] = k;
        at_back(rd, mark);
    }
    return true;
}

/* A list of expressions with their texts. */
static bool read_expressions(struct reader *rd, const json_t *v, expr_id **e, char ***text, int *count)
{
    size_t n = list_size(v);
    if (n > 16u * REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu expressions; the limit is %d", n,
                       16 * REQUEST_MAX_VARIABLES);
    *e = sga_zeros(&rd->r->mem, n + 1, sizeof **e);
    *text = sga_zeros(&rd->r->mem, n + 1, sizeof **text);
    for (size_t i = 0; i < n; i++) {
        size_t mark = at_item(rd, v, i);
        if (!((*e)[i] = read_listed(rd, list_item(v, i), *text + i)))
            return false;
        ++*count;
        at_back(rd, mark);
    }
    return true;
}

static bool read_rates(struct reader *rd, const json_t *v, unsigned char *taken)
{
    struct request_trajectory *t = &rd->r->trajectory;
    if (!json_is_object(v))
        return expected(rd, "an object of variables and their derivatives", v);
    t->rate = sga_zeros(&rd->r->mem, json_object_size(v) + 1, sizeof *t->rate);
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item) {
        size_t mark = at_member(rd, key);
        struct request_rate *r = t->rate + t->rates;
        r->variable = new_variable(rd, key, taken);
        if (r->variable >= 0 && (r->rate = read_listed(rd, item, &r->text)))
            t->rates++;
        else if (!at_pass(rd, mark))
            return false;
        at_back(rd, mark);
    }
    qsort(t->rate, (size_t)t->rates, sizeof *t->rate, by_rate);
    return true;
}

static bool read_gauge(struct reader *rd, const json_t *v, unsigned char *taken)
{
    static const char *const members[] = { "rates", "conditions", NULL };
    struct request_trajectory *t = &rd->r->trajectory;
    if (!only_members(rd, v, members))
        return false;
    const json_t *rates = json_object_get(v, "rates"), *conditions = json_object_get(v, "conditions");
    size_t mark = at_member(rd, "rates");
    if (rates && !read_rates(rd, rates, taken))
        return false;
    at_back(rd, mark);
    at_member(rd, "conditions");
    if (conditions && !read_expressions(rd, conditions, &t->condition, &t->condition_text, &t->conditions))
        return false;
    at_back(rd, mark);
    return true;
}

/* What initial values are where the swept parameters are symbols; there are no faults in them any more. */
bool open_initial(struct reader *rd, struct request_initial *initial, int initials)
{
    for (int i = 0; i < initials && rd->r->swept_count; i++)
        if (!(initial[i].open = expr_parse(&rd->r->store, initial[i].text, &rd->grammar, rd->err)))
            return false;
    return true;
}

/* The members that name variables or hold expressions. */
static bool read_where(struct reader *rd, const json_t *v)
{
    struct request_trajectory *t = &rd->r->trajectory;
    size_t n = (size_t)rd->r->system.variables;
    SGA_FREED unsigned char *taken = sga_malloc(n + 1);
    const json_t *m;
    bool ok = true;
    size_t mark = rd->at.len;
    if (ok && (m = json_object_get(v, "initial"))) {
        at_member(rd, "initial");
        memset(taken, 0, n + 1);
        sweep_bind(rd, -1);
        ok = read_initial(rd, m, taken, &t->initial, &t->initials);
        sweep_unbind(rd);
        ok = (ok && open_initial(rd, t->initial, t->initials)) || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "hold"))) {
        at_back(rd, mark);
        at_member(rd, "hold");
        memset(taken, 0, n + 1);
        ok = read_hold(rd, m, taken) || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "start_equations"))) {
        at_back(rd, mark);
        ok = read_start_equations(rd, m) || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "bounds"))) {
        at_back(rd, mark);
        ok = read_bounds(rd, m, &t->low, &t->high) || at_pass(rd, mark);
        if (!json_object_size(m))
            t->low = t->high = NULL;
    }
    if (ok && (m = json_object_get(v, "outputs"))) {
        at_back(rd, mark);
        at_member(rd, "outputs");
        ok = read_expressions(rd, m, &t->output, &t->output_text, &t->outputs) || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "integrals"))) {
        at_back(rd, mark);
        at_member(rd, "integrals");
        ok = read_expressions(rd, m, &t->integral, &t->integral_text, &t->integrals);
        if (ok && t->integrals > REQUEST_MAX_INTEGRALS)
            ok = at_fail(rd, SGA_E_SCHEMA, "there are %d integrals; the limit is %d", t->integrals, REQUEST_MAX_INTEGRALS);
        ok = ok || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "gauge"))) {
        at_back(rd, mark);
        at_member(rd, "gauge");
        memset(taken, 0, n + 1);
        ok = read_gauge(rd, m, taken) || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "events"))) {
        at_back(rd, mark);
        at_member(rd, "events");
        ok = read_events(rd, m) || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "sliding"))) {
        at_back(rd, mark);
        at_member(rd, "sliding");
        ok = read_boolean(rd, m, &t->sliding) || at_pass(rd, mark);
    }
    if (ok && (m = json_object_get(v, "sensitivities"))) {
        at_back(rd, mark);
        ok = read_sensitivities(rd, m) || at_pass(rd, mark);
    }
    if (ok)
        at_back(rd, mark);
    return ok;
}

bool read_trajectory(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "start", "stop", "samples", "times", "initial", "hold", "start_equations", "bounds", "outputs", "integrals", "gauge", "events", "sliding", "sensitivities", NULL };
    rd->r->trajectory.has = true;
    size_t mark = at_member(rd, "trajectory");
    if (!only_members(rd, v, members) || (!read_when(rd, v) && !at_pass(rd, mark + sizeof "/trajectory" - 1)) || !read_where(rd, v))
        return false;
    at_back(rd, mark);
    return true;
}

expr_id request_exact_time(struct request *r, int k)
{
    const struct request_trajectory *t = &r->trajectory;
    assert(k >= 0 && k < t->samples);
    struct expr_store *st = &r->store;
    if (t->exact_times)
        return t->exact_times[k];
    if (t->samples < 2)
        return t->exact_stop;
    expr_id part = expr_rational(st, k, t->samples - 1), rest = expr_rational(st, t->samples - 1 - k, t->samples - 1);
    return expr_add(st, expr_mul(st, rest, t->exact_start), expr_mul(st, part, t->exact_stop));
}
