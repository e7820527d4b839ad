/* The member `linearization`: where, and from what to what. */
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reader.h"

static bool read_place(struct reader *rd, const json_t *v, struct request_place *p)
{
    static const char *const members[] = { "time", "values", NULL };
    if (!only_members(rd, v, members))
        return false;
    const json_t *time = json_object_get(v, "time"), *values = need_member(rd, v, "values");
    if (!values)
        return false;
    size_t mark = at_member(rd, "time");
    p->time = rd->r->trajectory.start;
    if (time && !read_value(rd, time, &p->time, NULL))
        return false;
    at_back(rd, mark);
    at_member(rd, "values");
    SGA_FREED unsigned char *taken = sga_calloc((size_t)rd->r->system.variables + 1, 1);
    if (!read_initial(rd, values, taken, &p->initial, &p->initials))
        return false;
    at_back(rd, mark);
    return true;
}

static bool read_places(struct reader *rd, const json_t *v, struct request_linearization *l)
{
    size_t n = json_array_size(v);
    if (n < 1 || n > REQUEST_MAX_PLACES)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu places; there must be 1 to %d", n, REQUEST_MAX_PLACES);
    l->at = REQUEST_AT_PLACES;
    l->place = sga_zeros(&rd->r->mem, n, sizeof *l->place);
    for (size_t i = 0; i < n; i++) {
        size_t here = at_index(rd, i);
        if (!read_place(rd, json_array_get(v, i), l->place + i))
            return false;
        l->places++;
        at_back(rd, here);
    }
    return true;
}

/* Samples are those of the trajectory. */
static bool read_at(struct reader *rd, const json_t *v, struct request_linearization *l)
{
    static const char *const word[] = { "start", "samples" };
    size_t mark = at_member(rd, "at");
    if (json_is_array(v)) {
        if (!read_places(rd, v, l))
            return false;
    } else {
        int k = read_word(rd, v, word, 2, "a place to linearize at");
        if (k < 0)
            return false;
        l->at = k ? REQUEST_AT_SAMPLES : REQUEST_AT_START;
        if (k && !rd->r->trajectory.times)
            return at_fail(rd, SGA_E_MISSING_MEMBER, "to linearize along a motion, give \"trajectory\" with \"stop\" or \"times\"");
        if (k && rd->r->trajectory.samples > REQUEST_MAX_PLACES)
            return at_fail(rd, SGA_E_SCHEMA, "there are %d samples; at most %d are linearized at", rd->r->trajectory.samples, REQUEST_MAX_PLACES);
    }
    at_back(rd, mark);
    return true;
}

static bool read_symbolic(struct reader *rd, const json_t *v, const json_t *at, struct request_linearization *l)
{
    size_t mark = at_member(rd, "symbolic");
    if (!read_boolean(rd, v, &l->symbolic))
        return false;
    at_back(rd, mark);
    if (!l->symbolic || !at)
        return true;
    at_member(rd, "at");
    return at_fail(rd, SGA_E_SCHEMA, "a symbolic linearization is about any point: leave out \"at\", or \"symbolic\"");
}

static bool read_gauge(struct reader *rd, const json_t *v, struct request_linearization *l)
{
    static const char *const word[] = { "inputs", "least norm" };
    size_t mark = at_member(rd, "gauge");
    int k = read_word(rd, v, word, 2, "a choice of what no input names");
    if (k < 0)
        return false;
    l->least_norm = k == 1;
    at_back(rd, mark);
    return true;
}

bool read_linearization(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "at", "inputs", "outputs", "symbolic", "gauge", NULL };
    struct request_linearization *l = &rd->r->linearization;
    size_t mark = at_member(rd, "linearization");
    if (!only_members(rd, v, members))
        return false;
    const json_t *at = json_object_get(v, "at"), *symbolic = json_object_get(v, "symbolic"), *gauge = json_object_get(v, "gauge");
    l->has = true;
    if ((symbolic && !read_symbolic(rd, symbolic, at, l)) || (gauge && !read_gauge(rd, gauge, l)))
        return false;
    if ((at && !read_at(rd, at, l)) || !read_ports(rd, v, &l->ports))
        return false;
    at_back(rd, mark);
    return true;
}
