/* The member `sensitivities` of a trajectory: by which parameters and initial values the motion is differentiated. */
#include <string.h>

#include "arena.h"
#include "error.h"
#include "mem.h"
#include "reader.h"
#include "suggest.h"

/* A parameter with a value. False: the place says what is wrong. */
static bool known_parameter(struct reader *rd, const char *name)
{
    const struct request *r = rd->r;
    const struct expr_store *st = &r->store;
    int symbol = expr_symbol_find(st, name, strlen(name));
    for (int i = 0; i < r->knowns; i++)
        if (r->known[i].symbol == symbol)
            return true;
    for (int i = 0; i < r->swept_count; i++)
        if (r->swept[i].symbol == symbol)
            return true;
    if (symbol >= 0 && st->symbol[symbol].kind == EXPR_PARAMETER)
        return at_fail(rd, SGA_E_SCHEMA, "the parameter \"%.100s\" is null in system.parameters; a derivative by it needs its value", name);
    struct suggest s;
    suggest_begin(&s, name, strlen(name));
    for (int i = 0; i < r->knowns; i++)
        suggest_offer(&s, st->symbol[r->known[i].symbol].name);
    return at_fail(rd, SGA_E_EXPR_NAME, "\"%.100s\" is not a parameter of the system%s%s%s", name, s.best ? "; did you mean \"" : "",
                   s.best ? s.best : "", s.best ? "\"?" : "");
}

static bool read_parameters(struct reader *rd, const json_t *v)
{
    struct request_sensitivities *s = &rd->r->trajectory.sensitivities;
    size_t mark = at_member(rd, "parameters");
    s->parameter = sga_zeros(&rd->r->mem, list_size(v) + 1, sizeof *s->parameter);
    for (size_t i = 0; i < list_size(v); i++) {
        size_t here = at_item(rd, v, i);
        const char *name = read_string(rd, list_item(v, i));
        if (!name || !known_parameter(rd, name))
            return false;
        for (int k = 0; k < s->parameters; k++)
            if (!strcmp(s->parameter[k], name))
                return at_fail(rd, SGA_E_DUPLICATE_NAME, "the parameter \"%.100s\" is given twice", name);
        s->parameter[s->parameters++] = sga_take_text(&rd->r->mem, name);
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool given(const struct request_trajectory *t, int variable)
{
    for (int k = 0; k < t->initials; k++)
        if (t->initial[k].variable == variable)
            return true;
    return false;
}

static bool read_initials(struct reader *rd, const json_t *v)
{
    struct request_trajectory *t = &rd->r->trajectory;
    struct request_sensitivities *s = &t->sensitivities;
    size_t mark = at_member(rd, "initial");
    s->initial = sga_zeros(&rd->r->mem, list_size(v) + 1, sizeof *s->initial);
    for (size_t i = 0; i < list_size(v); i++) {
        size_t here = at_item(rd, v, i);
        const char *name = read_string(rd, list_item(v, i));
        int k = name ? state_variable(rd, name) : -1;
        if (k < 0)
            return false;
        if (!given(t, k))
            return at_fail(rd, SGA_E_MISSING_MEMBER, "trajectory.initial gives no value for \"%.100s\": there is nothing to differentiate by; give it there, or leave it out here",
                           name);
        for (int m = 0; m < s->initials; m++)
            if (s->initial[m] == k)
                return at_fail(rd, SGA_E_DUPLICATE_NAME, "the variable \"%.100s\" is given twice", name);
        s->initial[s->initials++] = k;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

bool read_sensitivities(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "parameters", "initial", NULL };
    struct request_sensitivities *s = &rd->r->trajectory.sensitivities;
    size_t mark = at_member(rd, "sensitivities");
    if (!only_members(rd, v, members))
        return false;
    const json_t *parameters = json_object_get(v, "parameters"), *initial = json_object_get(v, "initial");
    if ((parameters && !read_parameters(rd, parameters)) || (initial && !read_initials(rd, initial)))
        return false;
    if (!s->parameters && !s->initials)
        return at_fail(rd, SGA_E_EMPTY_SYSTEM, "nothing is named to differentiate by; give \"parameters\", \"initial\", or both");
    s->has = true;
    at_back(rd, mark);
    return true;
}
