/* The member `tables` of a system: functions of time given by samples, for measured signals.
 *
 * Algebra knows a table as a name u whose derivatives are u', u'', ... and of which nothing else
 * is known: what it finds holds for every function u. The samples are met by numbers only. */
#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "reader.h"
#include "signal.h"
#include "table.h"

/* Whole numbers beyond these are no doubles. */
static const double WHOLE = 0x1p53;

/* Numbers that end with the reading, and what those are exactly that are not the decimals of their doubles (NULL: all are). */
struct numbers { double *x; expr_id *exact; int count; };

/* False with an error. */
static bool read_numbers(struct reader *rd, const json_t *table, const char *member, struct numbers *out)
{
    const json_t *v = need_member(rd, table, member);
    if (!v)
        return false;
    size_t mark = at_member(rd, member), n = json_array_size(v);
    if (!json_is_array(v))
        return expected(rd, "a list of numbers", v);
    if (n < 2 || n > REQUEST_MAX_KNOTS)
        return at_fail(rd, SGA_E_SHAPE, "there are %zu %s; a table has 2 to %d", n, member, REQUEST_MAX_KNOTS);
    *out = (struct numbers){ .x = sga_take(&rd->mem, n * sizeof *out->x), .count = (int)n };
    for (size_t i = 0; i < n; i++) {
        const json_t *item = json_array_get(v, i);
        out->x[i] = json_is_number(item) ? json_number_value(item) : NAN;
        if (json_is_real(item) || fabs(out->x[i]) <= WHOLE)        /* a table is long: no detour by exact numbers */
            continue;
        size_t here = at_index(rd, i);
        if (!out->exact)
            out->exact = sga_zeros(&rd->mem, n, sizeof *out->exact);
        if (!read_exact(rd, item, out->x + i, out->exact + i, NULL))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool increasing(struct reader *rd, const double *time, int n)
{
    assert(n >= 2);
    for (int i = 1; i < n; i++) {
        bool step = time[i] == time[i - 1], inside = i > 1 && i + 1 < n, third = i > 1 && time[i] == time[i - 2];
        if (time[i] > time[i - 1] || (step && inside && !third))
            continue;
        at_member(rd, "times");
        at_index(rd, (size_t)i);
        if (step && third)
            return at_fail(rd, SGA_E_SCHEMA, "three samples at the time %.17g: a step has two, one for each side", time[i]);
        if (step)
            return at_fail(rd, SGA_E_SCHEMA, "a step at an end of a table: leave out the sample that has no time of its own");
        return at_fail(rd, SGA_E_SCHEMA, "the times of a table must increase, or two are equal at a step: %.17g follows %.17g", time[i], time[i - 1]);
    }
    return true;
}

/* Numbers of which some power or quotient is no number would be met as such much later. */
static bool usable(struct reader *rd, const struct expr_table *u)
{
    for (int k = 0; k + 1 < u->knots; k++)
        for (int i = 0; i < 4; i++)
            if (!isfinite(u->piece[k][i])) {
                at_member(rd, "values");
                at_index(rd, (size_t)k);
                return at_fail(rd, SGA_E_SCHEMA, "between this sample and the next the table is too steep for a number");
            }
    return true;
}

static bool read_table(struct reader *rd, const json_t *v, struct request_table *t)
{
    static const char *const members[] = { "times", "values", "interpolation", NULL };
    static const char *const words[] = { [EXPR_LINEAR] = "linear", [EXPR_CUBIC] = "cubic" };
    if (!only_members(rd, v, members))
        return false;
    const json_t *word = json_object_get(v, "interpolation");
    int kind = EXPR_CUBIC;
    struct numbers time = { 0 }, value = { 0 };
    if (word) {
        size_t mark = at_member(rd, "interpolation");
        if ((kind = read_word(rd, word, words, 2, "an interpolation")) < 0)
            return false;
        at_back(rd, mark);
    }
    bool ok = read_numbers(rd, v, "times", &time) && read_numbers(rd, v, "values", &value) && increasing(rd, time.x, time.count);
    if (ok && time.count != value.count) {
        at_member(rd, "values");
        ok = at_fail(rd, SGA_E_SHAPE, "there are %d values for %d times", value.count, time.count);
    }
    if (ok) {
        t->values = expr_table_new((enum expr_interpolation)kind, time.count, time.x, value.x);
        expr_table_given(t->values, &rd->r->store, time.exact, value.exact);
        ok = usable(rd, t->values);
    }
    return ok;
}

bool read_tables(struct reader *rd, const json_t *system)
{
    const json_t *v = json_object_get(system, "tables");
    if (!v)
        return true;
    size_t mark = at_member(rd, "tables");
    if (!json_is_object(v))
        return expected(rd, "an object of names and tables", v);
    if (json_object_size(v) > REQUEST_MAX_TABLES)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu tables; the limit is %d", json_object_size(v), REQUEST_MAX_TABLES);
    rd->r->table = sga_zeros(&rd->r->mem, json_object_size(v) + 1, sizeof *rd->r->table);
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item) {
        size_t here = at_member(rd, key);
        struct request_table *t = rd->r->table + rd->r->tables;
        int symbol = new_name(rd, key, EXPR_SIGNAL);
        if (symbol < 0)
            return false;
        t->name = sga_take_text(&rd->r->mem, key);
        rd->r->tables++;
        if (!read_table(rd, item, t))
            return false;
        rd->r->store.symbol[symbol].table = t->values;
        sys_add_signal(&rd->r->system, symbol);
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

/* Each generation of constraints takes one derivative more, and there are at most as many as
 * variables; the field takes one more. */
static bool add_derivatives(struct reader *rd)
{
    struct expr_store *st = &rd->r->store;
    int before = st->symbols;
    for (int k = 0; k < rd->r->system.signals; k++) {
        int symbol = rd->r->system.signal[k], given = 0;
        for (int i = 0; i < before; i++)
            if (st->symbol[i].kind == EXPR_SIGNAL && st->symbol[i].table == st->symbol[symbol].table)
                given = st->symbol[i].order > given ? st->symbol[i].order : given;
        int orders = given + rd->r->system.variables + 2;
        for (int i = 0; i <= orders && symbol >= 0; i++) {
            sys_add_parameter(&rd->r->system, symbol);
            expr_id rate = i < orders && i < EXPR_SIGNAL_ORDERS ? expr_signal_rate(st, symbol) : EXPR_UNDEF;
            symbol = rate ? st->node[rate].a : -1;
        }
    }
    st->signals_fixed = true;
    return store_ok(rd);
}

/* No numbers beyond the samples; the reader is at the time's place. */
static bool covers(struct reader *rd, double at)
{
    for (int k = 0; k < rd->r->tables; k++) {
        const struct expr_table *u = rd->r->table[k].values;
        if (!(at >= u->time[0] && at <= u->time[u->knots - 1]))
            return at_fail(rd, SGA_E_SCHEMA, "the time %.17g lies outside of the table %.100s, which has samples from %.17g to %.17g; nothing is "
                           "extrapolated", at, rd->r->table[k].name, u->time[0], u->time[u->knots - 1]);
    }
    return true;
}

static bool covers_start(struct reader *rd)
{
    at_back(rd, 0);
    at_member(rd, "trajectory");
    size_t mark = at_member(rd, "start");
    bool ok = covers(rd, rd->r->trajectory.start);
    at_back(rd, mark);
    return ok;
}

static bool covers_motion(struct reader *rd)
{
    const struct request_trajectory *m = &rd->r->trajectory;
    if (!covers_start(rd))
        return false;
    at_member(rd, m->exact_times ? "times" : "stop");
    for (int i = 0; i < (m->times ? m->samples : 0); i++)
        if (!covers(rd, m->times[i]))
            return false;
    return true;
}

static bool covers_fit(struct reader *rd)
{
    const struct request_fit *f = &rd->r->fit;
    if (!covers_start(rd))
        return false;
    at_back(rd, 0);
    at_member(rd, "fit");
    at_member(rd, "data");
    for (int e = 0; e < f->experiments; e++) {
        size_t here = f->list ? at_index(rd, (size_t)e) : at_member(rd, "times");
        if (f->list)
            at_member(rd, "times");
        for (int i = 0; i < f->experiment[e].times; i++) {
            size_t mark = at_index(rd, (size_t)i);
            if (!covers(rd, f->experiment[e].time[i]))
                return false;
            at_back(rd, mark);
        }
        at_back(rd, here);
    }
    return true;
}

/* Where a start is given, and at places. Without them the matrices of a system with constant coefficients need no value of a table. */
static bool covers_linearization(struct reader *rd)
{
    const struct request_linearization *l = &rd->r->linearization;
    const struct request_trajectory *m = &rd->r->trajectory;
    if ((m->initials || m->times) && l->at != REQUEST_AT_PLACES && !covers_start(rd))
        return false;
    at_back(rd, 0);
    at_member(rd, "linearization");
    at_member(rd, "at");
    for (int i = 0; i < l->places; i++) {
        size_t mark = at_index(rd, (size_t)i);
        at_member(rd, "time");
        if (!covers(rd, l->place[i].time))
            return false;
        at_back(rd, mark);
    }
    return true;
}

bool read_tables_end(struct reader *rd)
{
    struct request *r = rd->r;
    if (!r->tables)
        return true;
    for (int k = 0; k < r->tables && r->want & REQUEST_SYMMETRIES; k++)
        if (r->table[k].in_system) {
            at_member(rd, "want");
            return at_fail(rd, SGA_E_NOT_SUPPORTED, "symmetries of a system with tables (here %.60s) are not looked for; give the functions of time as "
                           "expressions", r->table[k].name);
        }
    bool moves = r->want & (REQUEST_TRAJECTORY | REQUEST_TRADEOFF | REQUEST_CONSISTENT_INITIAL);
    if ((moves && !covers_motion(rd)) || (r->want & REQUEST_FIT && !covers_fit(rd))
        || (r->want & (REQUEST_LINEARIZATION | REQUEST_TRANSFER) && !covers_linearization(rd)))
        return false;
    return add_derivatives(rd);
}
