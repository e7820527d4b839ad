/* The member `equilibria`: what is held, what is free, where to search. */
#include <math.h>
#include <string.h>

#include "arena.h"
#include "mem.h"
#include "reader.h"

/* Another name of a variable that is not in `taken`; its index or -1. */
static int variable_once(struct reader *rd, const char *name, unsigned char *taken)
{
    int k = name ? state_variable(rd, name) : -1;
    if (k >= 0 && taken[k])
        return at_fail(rd, SGA_E_DUPLICATE_NAME, "the variable \"%.100s\" is held or free already", name), -1;
    if (k >= 0)
        taken[k] = 1;
    return k;
}

static bool read_free(struct reader *rd, const json_t *v, unsigned char *taken, struct request_equilibria *e)
{
    size_t mark = at_member(rd, "free");
    e->free = sga_zeros(&rd->r->mem, list_size(v) + 1, sizeof *e->free);
    for (size_t i = 0; i < list_size(v); i++) {
        size_t here = at_item(rd, v, i);
        int k = variable_once(rd, read_string(rd, list_item(v, i)), taken);
        if (k < 0)
            return false;
        e->free[e->frees++] = k;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool read_end(struct reader *rd, const json_t *pair, size_t i, double *out)
{
    const json_t *v = json_array_get(pair, i);
    if (json_is_null(v))
        return true;
    size_t mark = at_index(rd, i);
    if (!read_value(rd, v, out, NULL))
        return false;
    at_back(rd, mark);
    return true;
}

static bool read_bound(struct reader *rd, const char *name, const json_t *v, struct request_equilibria *e)
{
    int k = state_variable(rd, name);
    if (k < 0)
        return false;
    if (!json_is_array(v) || json_array_size(v) != 2)
        return expected(rd, "two bounds, null for none", v);
    if (!read_end(rd, v, 0, e->low + k) || !read_end(rd, v, 1, e->high + k))
        return false;
    return e->low[k] <= e->high[k] || at_fail(rd, SGA_E_SCHEMA, "the lower bound %g lies above the upper bound %g", e->low[k], e->high[k]);
}

static bool read_bounds(struct reader *rd, const json_t *v, struct request_equilibria *e)
{
    size_t mark = at_member(rd, "bounds");
    if (v && !json_is_object(v))
        return expected(rd, "an object of variables and bounds", v);
    int n = rd->r->system.variables;
    e->low = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof *e->low);
    e->high = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof *e->high);
    for (int k = 0; k < n; k++) {
        e->low[k] = -INFINITY;
        e->high[k] = INFINITY;
    }
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item) {
        size_t here = at_member(rd, key);
        if (!read_bound(rd, key, item, e))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool read_starts(struct reader *rd, const json_t *v, struct request_equilibria *e)
{
    long starts = REQUEST_STARTS;
    size_t mark = at_member(rd, "starts");
    if (v && !read_integer(rd, v, 1, REQUEST_MAX_STARTS, &starts))
        return false;
    e->starts = (int)starts;
    at_back(rd, mark);
    return true;
}

bool read_equilibria(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "hold", "free", "bounds", "starts", NULL };
    struct request_equilibria *e = &rd->r->equilibria;
    size_t mark = at_member(rd, "equilibria");
    if (v && !only_members(rd, v, members))
        return false;
    SGA_FREED unsigned char *taken = sga_calloc((size_t)rd->r->system.variables + 1, 1);
    const json_t *hold = json_object_get(v, "hold"), *list = json_object_get(v, "free");
    size_t here = at_member(rd, "hold");
    if (hold && !read_initial(rd, hold, taken, &e->hold, &e->holds))
        return false;
    at_back(rd, here);
    if ((list && !read_free(rd, list, taken, e)) || !read_bounds(rd, json_object_get(v, "bounds"), e) || !read_starts(rd, json_object_get(v, "starts"), e))
        return false;
    at_back(rd, mark);
    return true;
}
