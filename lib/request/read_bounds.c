/* The member `bounds` of a search: {"x": [0, null]}. */
#include <assert.h>
#include <math.h>

#include "arena.h"
#include "error.h"
#include "reader.h"

bool read_bound_end(struct reader *rd, const json_t *pair, size_t i, double *out)
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

static bool read_bound(struct reader *rd, const char *name, const json_t *v, double *low, double *high)
{
    int k = state_variable(rd, name);
    if (k < 0)
        return false;
    if (!json_is_array(v) || json_array_size(v) != 2)
        return expected(rd, "two bounds, null for none", v);
    if (!read_bound_end(rd, v, 0, low + k) || !read_bound_end(rd, v, 1, high + k))
        return false;
    return low[k] <= high[k] || at_fail(rd, SGA_E_SCHEMA, "the lower bound %g lies above the upper bound %g", low[k], high[k]);
}

bool read_bounds(struct reader *rd, const json_t *v, double **low, double **high)
{
    size_t mark = at_member(rd, "bounds");
    if (v && !json_is_object(v))
        return expected(rd, "an object of variables and bounds", v);
    int n = rd->r->system.variables;
    assert(n >= 0);
    *low = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof **low);
    *high = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof **high);
    for (int k = 0; k < n; k++) {
        (*low)[k] = -INFINITY;
        (*high)[k] = INFINITY;
    }
    const char *key;
    json_t *item;
    json_object_foreach((json_t *)v, key, item) {
        size_t here = at_member(rd, key);
        if (!read_bound(rd, key, item, *low, *high) && !at_pass(rd, here))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}
