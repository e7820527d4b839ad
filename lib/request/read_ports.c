/* Inputs and outputs: the members of that name of `linearization` and the like. */
#include <string.h>

#include "arena.h"
#include "error.h"
#include "reader.h"

/* A table by its name; -1: none is called so. */
static int table_symbol(const struct reader *rd, const char *name)
{
    int symbol = expr_symbol_find(&rd->r->store, name, strlen(name));
    return symbol >= 0 && rd->r->store.symbol[symbol].kind == EXPR_SIGNAL ? symbol : -1;
}

static bool read_input(struct reader *rd, const json_t *v, struct request_ports *p)
{
    struct request_input *in = p->input + p->inputs;
    const char *name = read_string(rd, v);
    if (!name)
        return false;
    in->signal = table_symbol(rd, name);
    in->variable = in->signal >= 0 ? -1 : state_variable(rd, name);
    if (in->signal < 0 && in->variable < 0)
        return false;
    for (int k = 0; k < p->inputs; k++)
        if (p->input[k].variable == in->variable && p->input[k].signal == in->signal)
            return at_fail(rd, SGA_E_DUPLICATE_NAME, "the input \"%.100s\" is given twice", name);
    in->name = rd->r->store.symbol[in->signal >= 0 ? in->signal : rd->r->system.variable[in->variable].symbol].name;
    p->inputs++;
    return true;
}

static bool fits(struct reader *rd, const char *what, size_t n)
{
    return n <= REQUEST_MAX_PORTS || at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu %s; the limit is %d", n, what, REQUEST_MAX_PORTS);
}

static bool read_inputs(struct reader *rd, const json_t *v, struct request_ports *p)
{
    size_t mark = at_member(rd, "inputs"), n = list_size(v);
    if (!fits(rd, "inputs", n))
        return false;
    p->says_inputs = true;
    p->input = sga_zeros(&rd->r->mem, n + 1, sizeof *p->input);
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        if (!read_input(rd, list_item(v, i), p))
            return false;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

static bool read_outputs(struct reader *rd, const json_t *v, struct request_ports *p)
{
    size_t mark = at_member(rd, "outputs"), n = list_size(v);
    if (!fits(rd, "outputs", n))
        return false;
    p->output = sga_zeros(&rd->r->mem, n + 1, sizeof *p->output);
    p->output_text = sga_zeros(&rd->r->mem, n + 1, sizeof *p->output_text);
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        if (!(p->output[i] = read_expression(rd, list_item(v, i), p->output_text + i)))
            return false;
        p->outputs++;
        at_back(rd, here);
    }
    at_back(rd, mark);
    return true;
}

bool read_ports(struct reader *rd, const json_t *v, struct request_ports *ports)
{
    const json_t *inputs = json_object_get(v, "inputs"), *outputs = json_object_get(v, "outputs");
    return (!inputs || read_inputs(rd, inputs, ports)) && (!outputs || read_outputs(rd, outputs, ports));
}
