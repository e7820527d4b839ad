/* The member `trajectory.events`: functions whose zeros along the motion are looked for. */
#include <assert.h>
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "reader.h"
#include "same_sign.h"

/* The place of a member's word in a table; 0 where it is left out; -1 with err. */
static int word_of(struct reader *rd, const json_t *v, const char *member, const char *const *words, int n)
{
    const json_t *m = json_object_get(v, member);
    size_t mark = at_member(rd, member);
    int k = m ? read_word(rd, m, words, n, member) : 0;
    if (k >= 0)
        at_back(rd, mark);
    return k;
}

static bool name_is_new(struct reader *rd, const char *name)
{
    const struct request_trajectory *t = &rd->r->trajectory;
    if (!*name || strlen(name) > REQUEST_MAX_NAME)
        return at_fail(rd, SGA_E_SCHEMA, "an event's name has 1 to %d bytes", REQUEST_MAX_NAME);
    for (int i = 0; i < t->events; i++)
        if (!strcmp(name, t->event[i].name))
            return at_fail(rd, SGA_E_DUPLICATE_NAME, "the event \"%.100s\" is given twice", name);
    return true;
}

/* How often it acts. */
static bool read_repetitions(struct reader *rd, const json_t *v, bool sets, struct request_event *e)
{
    const json_t *once = json_object_get(v, "once"), *max = json_object_get(v, "max");
    double most = 0;
    if (!once && !max)
        return true;
    size_t mark = at_member(rd, once ? "once" : "max");
    if (!sets)
        return at_fail(rd, SGA_E_SCHEMA, "\"once\" and \"max\" say how often an event sets something; with \"action\": \"set\" only");
    if (once && max)
        return at_fail(rd, SGA_E_SCHEMA, "\"once\" is \"max\": 1; give one of them");
    if (once && !json_is_boolean(once))
        return expected(rd, "true or false", once);
    if (max && !read_number(rd, max, 1, REQUEST_MAX_SET_TIMES, &most))
        return false;
    if (most != floor(most))
        return at_fail(rd, SGA_E_SCHEMA, "\"max\" is a whole number");
    e->most = once ? json_is_true(once) : (int)most;
    at_back(rd, mark);
    return true;
}

/* What a name stands for: a variable, or -1 - a mode's place. */
static bool read_target(struct reader *rd, const char *name, int *target)
{
    for (int k = 0; k < rd->r->modes; k++)
        if (!strcmp(rd->r->mode[k].name, name)) {
            *target = -1 - k;
            return true;
        }
    *target = state_variable(rd, name);
    return *target >= 0;
}

/* A mode that is set to a number: what names give is known at the event. */
static bool check_mode(struct reader *rd, const json_t *v, const struct request_set *s)
{
    double value;
    for (const char *c = json_string_value(v); c && *c; c++)
        if (isalpha((unsigned char)*c) || *c == '_')
            return true;
    if (s->variable >= 0)
        return true;
    const struct request_mode *m = rd->r->mode + (-1 - s->variable);
    return !constant_value(&rd->r->store, s->value, &value) || read_mode_place(m, value) >= 0 || read_mode_refuse(rd, m, value);
}

/* What it assigns. */
static bool read_set(struct reader *rd, const json_t *v, bool sets, struct request_event *e)
{
    const json_t *set = json_object_get(v, "set"), *value;
    const char *name;
    if (!set && !sets)
        return true;
    if (!set)
        return at_fail(rd, SGA_E_MISSING_MEMBER, "an event with \"action\": \"set\" needs \"set\": {\"variable\": \"expression\"}");
    size_t mark = at_member(rd, "set");
    if (!sets)
        return at_fail(rd, SGA_E_SCHEMA, "\"set\" goes with \"action\": \"set\"");
    if (!json_is_object(set) || !json_object_size(set))
        return expected(rd, "an object of variables and expressions, one at the least", set);
    e->set = sga_zeros(&rd->r->mem, json_object_size(set) + 1, sizeof *e->set);
    json_object_foreach((json_t *)set, name, value) {
        size_t here = at_member(rd, name);
        char *text;
        int variable;
        if (!read_target(rd, name, &variable))
            return false;
        for (int k = 0; k < e->sets; k++)
            if (e->set[k].variable == variable)
                return at_fail(rd, SGA_E_DUPLICATE_NAME, "\"%.100s\" is set twice", name);
        e->set[e->sets].variable = variable;
        if (!(e->set[e->sets].value = read_expression(rd, value, &text)) || !check_mode(rd, value, e->set + e->sets))
            return false;
        e->sets++;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool read_event(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "name", "expression", "direction", "action", "set", "once", "max", NULL };
    static const char *const directions[] = { "any", "up", "down" }, *const actions[] = { "record", "stop", "set" };
    struct request_trajectory *t = &rd->r->trajectory;
    struct request_event *e = t->event + t->events;
    if (!json_is_object(v))
        return expected(rd, "an object with name and expression", v);
    if (!only_members(rd, v, members))
        return false;
    const json_t *name = json_object_get(v, "name"), *expression = json_object_get(v, "expression");
    if (!name || !expression)
        return at_fail(rd, SGA_E_MISSING_MEMBER, "an event needs \"name\" and \"expression\"");
    size_t mark = at_member(rd, "name");
    const char *text = read_string(rd, name);
    if (!text || !name_is_new(rd, text))
        return false;
    at_back(rd, mark);
    int direction = word_of(rd, v, "direction", directions, 3), action = direction < 0 ? -1 : word_of(rd, v, "action", actions, 3);
    if (action < 0)
        return false;
    at_member(rd, "expression");
    if (!(e->expression = read_expression(rd, expression, &e->text)))
        return false;
    e->expression = expr_same_sign(&rd->r->store, e->expression);
    at_back(rd, mark);
    e->name = sga_take_text(&rd->r->mem, text);
    e->direction = direction == 2 ? -1 : direction;
    e->stop = action == 1;
    if (!read_repetitions(rd, v, action == 2, e) || !read_set(rd, v, action == 2, e))
        return false;
    t->events++;
    assert(e->direction >= -1 && e->direction <= 1);
    return true;
}

bool read_events(struct reader *rd, const json_t *v)
{
    struct request_trajectory *t = &rd->r->trajectory;
    if (!json_is_array(v))
        return expected(rd, "a list of events", v);
    if (json_array_size(v) > REQUEST_MAX_EVENTS)
        return at_fail(rd, SGA_E_SCHEMA, "there are %zu events; the limit is %d", json_array_size(v), REQUEST_MAX_EVENTS);
    t->event = sga_zeros(&rd->r->mem, json_array_size(v) + 1, sizeof *t->event);
    for (size_t i = 0; i < json_array_size(v); i++) {
        size_t mark = at_item(rd, v, i);
        if (!read_event(rd, json_array_get(v, i)) && !at_pass(rd, mark))
            return false;
        at_back(rd, mark);
    }
    assert(t->events <= REQUEST_MAX_EVENTS);
    return true;
}
