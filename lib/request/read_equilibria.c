/* The member `equilibria`: what is held, what is free, where to search. */
#include <math.h>
#include <string.h>

#include "arena.h"
#include "error.h"
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

/* The output of this name; -1: none is called so. */
static int output_of(const struct request *r, const char *name)
{
    for (int k = 0; k < r->outputs; k++)
        if (strcmp(r->output_name[k], name) == 0)
            return k;
    return -1;
}

/* Variables and, of the form descriptor, outputs. */
static bool read_hold(struct reader *rd, const json_t *v, unsigned char *taken, struct request_equilibria *e)
{
    if (!json_is_object(v))
        return expected(rd, "an object of variables and values", v);
    json_t *variables = json_object();
    const char *key;
    json_t *item;
    bool ok = true;
    e->output = sga_zeros(&rd->r->mem, json_object_size(v) + 1, sizeof *e->output);
    json_object_foreach((json_t *)v, key, item) {
        struct request_held *h = e->output + e->outputs;
        size_t here = at_member(rd, key);
        double value;
        h->output = output_of(rd->r, key);
        if (h->output < 0)
            json_object_set(variables, key, item);
        else if (!(ok = read_exact(rd, item, &value, &h->exact, NULL)))
            break;
        e->outputs += h->output >= 0;
        at_back(rd, here);
    }
    ok = ok && read_initial(rd, variables, taken, &e->hold, &e->holds);
    json_decref(variables);
    return ok;
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
    if (hold && !read_hold(rd, hold, taken, e))
        return false;
    at_back(rd, here);
    if ((list && !read_free(rd, list, taken, e)) || !read_bounds(rd, json_object_get(v, "bounds"), &e->low, &e->high) || !read_starts(rd, json_object_get(v, "starts"), e))
        return false;
    at_back(rd, mark);
    return true;
}
