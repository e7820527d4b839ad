/* The member `symmetries`: fields and maps to check, and what to search. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reader.h"

enum { MOST_CHECKS = 1000, MOST_FUNCTIONS = 1000, MOST_DEGREE = 12 };

static const char *time_name(const struct reader *rd)
{
    return rd->r->store.symbol[rd->r->system.time].name;
}

/* Components by name; the name of time gives the time component. */
static bool read_components(struct reader *rd, const json_t *v, struct request_candidate *c)
{
    int n = rd->r->system.variables;
    if (!json_is_object(v))
        return expected(rd, "an object of variables and expressions", v);
    SGA_FREED unsigned char *taken = sga_calloc((size_t)n + 1, 1);
    bool ok = true;
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item) {
        size_t mark = at_member(rd, key);
        int k = strcmp(key, time_name(rd)) == 0 ? n : state_variable(rd, key);
        if (k >= 0 && taken[k])
            k = (at_fail(rd, SGA_E_DUPLICATE_NAME, "the variable \"%.100s\" is given twice", key), -1);
        ok = k >= 0 && (c->component[k] = read_listed(rd, item, NULL));
        if (!ok && !at_pass(rd, mark))
            break;
        if (ok)
            taken[k] = 1;
        ok = true;
        at_back(rd, mark);
    }
    return ok;
}

static bool read_candidate(struct reader *rd, const json_t *v, struct request_candidate *c)
{
    static const char *const members[] = { "name", "field", "map", NULL };
    int n = rd->r->system.variables;
    struct expr_store *st = &rd->r->store;
    if (!only_members(rd, v, members))
        return false;
    const json_t *name = need_member(rd, v, "name"), *field = json_object_get(v, "field"), *map = json_object_get(v, "map");
    if (!name)
        return false;
    size_t mark = at_member(rd, "name");
    const char *text = read_string(rd, name);
    if (!text)
        return false;
    at_back(rd, mark);
    if (!field == !map)
        return at_fail(rd, field ? SGA_E_SCHEMA : SGA_E_MISSING_MEMBER,
                       "give either \"field\" (an infinitesimal symmetry) or \"map\" (a diffeomorphism)");
    c->name = sga_take_text(&rd->r->mem, text);
    c->is_map = map != NULL;
    c->component = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof *c->component);
    for (int k = 0; k <= n; k++) {
        int symbol = k < n ? rd->r->system.variable[k].symbol : rd->r->system.time;
        c->component[k] = c->is_map ? st->symbol[symbol].node : expr_int(st, 0);
    }
    at_member(rd, map ? "map" : "field");
    if (!read_components(rd, map ? map : field, c))
        return false;
    at_back(rd, mark);
    return true;
}

static bool read_checks(struct reader *rd, const json_t *v)
{
    struct request_symmetries *s = &rd->r->symmetries;
    if (!json_is_array(v))
        return expected(rd, "a list", v);
    if (json_array_size(v) > MOST_CHECKS)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu candidates; the limit is %d", json_array_size(v), MOST_CHECKS);
    s->check = sga_zeros(&rd->r->mem, json_array_size(v) + 1, sizeof *s->check);
    for (size_t i = 0; i < json_array_size(v); i++) {
        size_t mark = at_index(rd, i);
        s->checks++;
        if (!read_candidate(rd, json_array_get(v, i), s->check + i) && !at_pass(rd, mark))
            return false;
        at_back(rd, mark);
    }
    return true;
}

static bool read_degree(struct reader *rd, const json_t *v, const char *member, int *out)
{
    const json_t *m = json_object_get(v, member);
    long degree;
    if (!m)
        return true;
    size_t mark = at_member(rd, member);
    if (!read_integer(rd, m, 0, MOST_DEGREE, &degree))
        return false;
    *out = (int)degree;
    at_back(rd, mark);
    return true;
}

static bool read_search(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "degree", "functions", "time", "integral_degree", NULL };
    struct request_symmetries *s = &rd->r->symmetries;
    if (!only_members(rd, v, members) || !need_member(rd, v, "degree"))
        return false;
    const json_t *time = json_object_get(v, "time");
    s->has_search = true;
    s->integral_degree = -1;
    if (!read_degree(rd, v, "degree", &s->degree) || !read_degree(rd, v, "integral_degree", &s->integral_degree))
        return false;
    if (s->integral_degree < 0)
        s->integral_degree = s->degree + 1;
    if (!read_expression_list(rd, v, "functions", &s->function, &s->functions))
        return false;
    s->functions = s->functions > 0 ? s->functions : 0;
    if (s->functions > MOST_FUNCTIONS)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %d functions; the limit is %d", s->functions, MOST_FUNCTIONS);
    if (!time)
        return true;
    size_t mark = at_member(rd, "time");
    if (!read_boolean(rd, time, &s->time))
        return false;
    s->says_time = true;
    at_back(rd, mark);
    return true;
}

bool read_symmetries(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "check", "search", NULL };
    size_t mark = at_member(rd, "symmetries");
    if (!only_members(rd, v, members))
        return false;
    const json_t *check = json_object_get(v, "check"), *search = json_object_get(v, "search");
    size_t here = at_member(rd, "check");
    if (check && !read_checks(rd, check))
        return false;
    at_back(rd, here);
    at_member(rd, "search");
    if (search && !read_search(rd, search))
        return false;
    at_back(rd, mark);
    return true;
}
