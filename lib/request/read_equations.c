/* The form `equations`: texts left = right, of any order. */
#include <stdlib.h>

#include "arena.h"
#include "equations.h"
#include "error.h"
#include "reader.h"

static bool read_equation(struct reader *rd, struct form_equations *f, const json_t *v)
{
    if (!json_is_string(v))
        return expected(rd, "an equation, a string \"left = right\"", v);
    struct expr_grammar g = rd->grammar;
    g.derivative = form_equations_derivative;
    g.total = form_equations_total;
    g.ctx = f;
    expr_id e = expr_parse_equation(&rd->r->store, json_string_value(v), &g, rd->err);
    if (!e) {
        snprintf(rd->err->pointer, sizeof rd->err->pointer, "%s", rd->at.data);
        return false;
    }
    form_equations_add(f, e);
    return true;
}

static bool read_list(struct reader *rd, struct form_equations *f, int first, const json_t *system)
{
    const json_t *v = need_member(rd, system, "equations");
    if (!v)
        return false;
    size_t mark = at_member(rd, "equations");
    if (list_size(v) == 0)
        return at_fail(rd, SGA_E_EMPTY_SYSTEM, "the system has no equation");
    if (list_size(v) > 16u * REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu equations; the limit is %d", list_size(v),
                       16 * REQUEST_MAX_VARIABLES);
    size_t read = 0;
    struct request *r = rd->r;
    r->equations = (int)list_size(v);
    r->equation = sga_zeros(&r->mem, (size_t)r->equations, sizeof *r->equation);
    for (size_t i = 0; i < list_size(v); i++) {
        size_t here = at_item(rd, v, i);
        if (json_is_string(list_item(v, i)))
            r->equation[i] = sga_take_text(&r->mem, json_string_value(list_item(v, i)));
        if (read_equation(rd, f, list_item(v, i)))
            read++;
        else if (!at_pass(rd, here))
            return false;
        at_back(rd, here);
    }
    if (!read)         /* each has a fault that is listed: the rest is read beside any system of these variables */
        form_equations_add(f, rd->r->store.symbol[first].node);
    if (!form_equations_reduce(f, &rd->r->system, REQUEST_MAX_VARIABLES, rd->err)) {
        snprintf(rd->err->pointer, sizeof rd->err->pointer, "%s", rd->at.data);
        return false;
    }
    at_back(rd, mark);
    return true;
}

bool read_equations(struct reader *rd, const json_t *system)
{
    SGA_ENDS(form_equations_clear) struct form_equations f = { 0 };
    int variables;
    int *variable = read_variables(rd, system, "variables", &variables);
    if (!variable)
        return false;
    form_equations_init(&f, &rd->r->store);
    for (int i = 0; i < variables; i++)
        form_equations_unknown(&f, variable[i]);
    return read_list(rd, &f, variable[0], system);
}
