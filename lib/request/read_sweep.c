/* The member `sweep`: starts of trajectories that share one analysis. */
#include <stdlib.h>
#include <string.h>

#include "mem.h"
#include "reader.h"

enum { MOST_VALUES = 1000000 };     /* that members take from trajectory.initial, together */

static int by_variable(const void *a, const void *b)
{
    return ((const struct request_initial *)a)->variable - ((const struct request_initial *)b)->variable;
}

/* The values of trajectory.initial that this member does not give. */
static void inherit(const struct request_trajectory *t, const unsigned char *taken, struct request_sweep *s)
{
    s->initial = sga_realloc(s->initial, (size_t)(s->initials + t->initials + 1) * sizeof *s->initial);
    for (int i = 0; i < t->initials; i++)
        if (!taken[t->initial[i].variable]) {
            struct request_initial *to = s->initial + s->initials++;
            *to = t->initial[i];
            to->text = NULL;
        }
    qsort(s->initial, (size_t)s->initials, sizeof *s->initial, by_variable);
}

static bool read_member(struct reader *rd, const json_t *v, unsigned char *taken)
{
    static const char *const members[] = { "initial", "parameters", NULL };
    struct request_sweep *s = rd->r->sweep + rd->r->sweeps++;
    if (!only_members(rd, v, members))
        return false;
    size_t mark = at_member(rd, "parameters");     /* also the mark of the member itself */
    if (json_object_get(v, "parameters"))
        return at_fail(rd, SGA_E_NOT_SUPPORTED, "this version sweeps initial values only; make the parameter a variable p with "
                       "p' = 0, or send one request for each value");
    at_back(rd, mark);
    const json_t *initial = need_member(rd, v, "initial");
    if (!initial)
        return false;
    memset(taken, 0, (size_t)rd->r->system.variables + 1);
    at_member(rd, "initial");
    if (!read_initial(rd, initial, taken, &s->initial, &s->initials))
        return false;
    inherit(&rd->r->trajectory, taken, s);
    at_back(rd, mark);
    return true;
}

bool read_sweep(struct reader *rd, const json_t *v)
{
    size_t mark = at_member(rd, "sweep");
    if (!json_is_array(v))
        return expected(rd, "a list of starts", v);
    if (json_array_size(v) < 1 || json_array_size(v) > REQUEST_MAX_SWEEP)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu starts; there must be 1 to %d", json_array_size(v), REQUEST_MAX_SWEEP);
    if (!(rd->r->want & REQUEST_TRAJECTORY))
        return at_fail(rd, SGA_E_SCHEMA, "a sweep is one of trajectories, which are not wanted");
    if (json_array_size(v) * (size_t)(rd->r->trajectory.initials + 1) > MOST_VALUES)
        return at_fail(rd, SGA_E_SCHEMA, "%zu starts with %d values from trajectory.initial are too many; the limit is %d values",
                       json_array_size(v), rd->r->trajectory.initials, MOST_VALUES);
    rd->r->sweep = sga_calloc(json_array_size(v), sizeof *rd->r->sweep);
    unsigned char *taken = sga_malloc((size_t)rd->r->system.variables + 1);
    bool ok = true;
    for (size_t i = 0; ok && i < json_array_size(v); i++) {
        size_t here = at_item(rd, v, i);
        if ((ok = read_member(rd, json_array_get(v, i), taken)))
            at_back(rd, here);
    }
    free(taken);
    if (ok)
        at_back(rd, mark);
    return ok;
}
