/* The member `trajectory.events`: functions whose zeros along the motion are looked for. */
#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "reader.h"

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

static bool read_event(struct reader *rd, const json_t *v)
{
    static const char *const members[] = { "name", "expression", "direction", "action", NULL };
    static const char *const directions[] = { "any", "up", "down" }, *const actions[] = { "record", "stop" };
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
    int direction = word_of(rd, v, "direction", directions, 3), action = direction < 0 ? -1 : word_of(rd, v, "action", actions, 2);
    if (action < 0)
        return false;
    at_member(rd, "expression");
    if (!(e->expression = read_expression(rd, expression, &e->text)))
        return false;
    at_back(rd, mark);
    e->name = sga_take_text(&rd->r->mem, text);
    e->direction = direction == 2 ? -1 : direction;
    e->stop = action == 1;
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
