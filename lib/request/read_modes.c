/* The member `modes` of a system: names whose values events may set, and which are numbers to each reduction. */
#include <math.h>
#include <string.h>

#include "error.h"
#include "reader.h"

static bool read_mode_values(struct reader *rd, const json_t *v, struct request_mode *m)
{
    const json_t *list = need_member(rd, v, "values");
    if (!list)
        return false;
    size_t mark = at_member(rd, "values");
    if (!json_is_array(list) || !json_array_size(list))
        return expected(rd, "a list of numbers, one at the least", list);
    if (json_array_size(list) > REQUEST_MAX_MODE_VALUES)
        return at_fail(rd, SGA_E_SCHEMA, "a mode has %d values at the most, and not %zu", REQUEST_MAX_MODE_VALUES, json_array_size(list));
    m->value = sga_zeros(&rd->r->mem, json_array_size(list) + 1, sizeof *m->value);
    m->exact = sga_zeros(&rd->r->mem, json_array_size(list) + 1, sizeof *m->exact);
    for (size_t i = 0; i < json_array_size(list); i++) {
        size_t here = at_index(rd, i);
        if (!read_exact(rd, json_array_get(list, i), m->value + i, m->exact + i, NULL))
            return false;
        for (int k = 0; k < m->values; k++)
            if (m->value[k] == m->value[i])
                return at_fail(rd, SGA_E_DUPLICATE_NAME, "the value %.17g is given twice", m->value[i]);
        m->values++;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

int read_mode_place(const struct request_mode *m, double value)
{
    for (int k = 0; k < m->values; k++)
        if (fabs(m->value[k] - value) <= 1e-9 * fmax(fabs(m->value[k]), fabs(value)) || m->value[k] == value)
            return k;
    return -1;
}

bool read_mode_refuse(struct reader *rd, const struct request_mode *m, double value)
{
    SGA_ENDS(sga_buf_free) struct sga_buf list = { 0 };
    for (int k = 0; k < m->values && k < 12; k++)
        sga_buf_printf(&list, "%s%.17g", k ? ", " : "", m->value[k]);
    return at_fail(rd, SGA_E_MODE_VALUE, "%.17g is not among the values of the mode \"%.100s\", which are %s; add it to them, or use one of them",
                   value, m->name, list.data);
}

static bool read_mode(struct reader *rd, const char *name, const json_t *v)
{
    static const char *const members[] = { "values", "start", NULL };
    struct request_mode *m = rd->r->mode + rd->r->modes;
    if (!json_is_object(v))
        return expected(rd, "an object with values and start", v);
    if (!only_members(rd, v, members) || !read_mode_values(rd, v, m))
        return false;
    m->name = sga_take_text(&rd->r->mem, name);
    const json_t *start = need_member(rd, v, "start");
    double value;
    if (!start)
        return false;
    size_t mark = at_member(rd, "start");
    if (!read_exact(rd, start, &value, NULL, NULL))
        return false;
    if ((m->start = read_mode_place(m, value)) < 0)
        return read_mode_refuse(rd, m, value);
    at_back(rd, mark);
    m->now = rd->choice ? rd->choice[rd->r->modes] : m->start;
    rd->r->modes++;
    return true;
}

bool read_modes(struct reader *rd, const json_t *system)
{
    const json_t *modes = json_object_get(system, "modes"), *v;
    const char *name;
    if (!modes)
        return true;
    size_t mark = at_member(rd, "modes");
    if (!json_is_object(modes))
        return expected(rd, "an object of names and their values", modes);
    if (json_object_size(modes) > REQUEST_MAX_MODES)
        return at_fail(rd, SGA_E_SCHEMA, "there are %d modes at the most, and not %zu", REQUEST_MAX_MODES, json_object_size(modes));
    rd->r->mode = sga_zeros(&rd->r->mem, json_object_size(modes) + 1, sizeof *rd->r->mode);
    json_object_foreach((json_t *)modes, name, v) {      /* values first: no value is of a mode */
        size_t here = at_member(rd, name);
        if (!read_mode(rd, name, v))
            return false;
        at_back(rd, here);
    }
    for (int k = 0; k < rd->r->modes; k++) {
        struct request_mode *m = rd->r->mode + k;
        size_t here = at_member(rd, m->name);
        m->symbol = new_name(rd, m->name, EXPR_PARAMETER);
        if (m->symbol < 0)
            return false;
        set_value(rd, m->symbol, m->exact[m->now]);
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}
