/* The member `system`: what all forms share, and the table of forms. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "form.h"
#include "mem.h"
#include "reader.h"

static const char *const quasilinear_members[] = { "variables", "A", "alpha", "restrict", "transpose", NULL };
static const char *const equations_members[] = { "variables", "equations", NULL };
static const char *const linear_members[] = { "variables", "A", "B", "C", "inputs", "D", NULL };
static const char *const descriptor_members[] = { "states", "inputs", "outputs", "E", "A", "B", "C", "D", NULL };
static const char *const control_members[] = { "variables", "inputs", "F", "G", "constraints", NULL };
static const char *const hamiltonian_members[] = { "variables", "hamiltonian", "omega", "restrict", NULL };
static const char *const lagrangian_members[] = {
    "coordinates", "lagrangian", "second_order", "forces", "holonomic", NULL
};

static const char *const mechanical_members[] = { "coordinates", "masses", "forces", "constraints", "restrict", NULL };
static const char *const operator_members[] = { "unknowns", "coefficients", "B", "sources", NULL };

/* The forms of the vocabulary. A new form is a reader here and a file in the form folder. */
static const struct form_kind form_table[] = {
    { "quasilinear", read_quasilinear, quasilinear_members },
    { "equations", read_equations, equations_members },
    { "linear", read_linear, linear_members },
    { "descriptor", read_descriptor, descriptor_members },
    { "control", read_control, control_members },
    { "hamiltonian", read_hamiltonian, hamiltonian_members },
    { "lagrangian", read_lagrangian, lagrangian_members },
    { "mechanical", read_mechanical, mechanical_members },
    { "operator", read_operator, operator_members },
};
enum { FORMS = sizeof form_table / sizeof *form_table };

static const struct form_kind *read_form(struct reader *rd, const json_t *system)
{
    const char *word[FORMS];
    SGA_ENDS(sga_buf_free) struct sga_buf ready = { 0 };
    for (int i = 0; i < FORMS; i++) {
        word[i] = form_table[i].name;
        if (form_table[i].read)
            sga_buf_printf(&ready, "%s\"%s\"", ready.len ? ", " : "", word[i]);
    }
    const json_t *v = need_member(rd, system, "form");
    int k = -1;
    if (v) {
        size_t mark = at_member(rd, "form");
        k = read_word(rd, v, word, FORMS, "a form");
        if (k >= 0 && !form_table[k].read) {
            at_fail(rd, SGA_E_NOT_SUPPORTED, "the form \"%s\" is not available yet; available are %s", word[k], ready.data);
            k = -1;
        }
        at_back(rd, mark);
    }
    return k < 0 ? NULL : form_table + k;
}

static bool form_members(struct reader *rd, const json_t *system, const struct form_kind *form)
{
    const char *allowed[16] = { "name", "form", "parameters", "time", "tables", "sizes", "modes" };
    int n = 7;
    for (const char *const *m = form->members; *m; m++)
        allowed[n++] = *m;
    return only_members(rd, system, allowed);
}

static bool read_time(struct reader *rd, const json_t *system)
{
    const json_t *v = json_object_get(system, "time");
    size_t mark = rd->at.len;
    if (v)
        at_member(rd, "time");
    int symbol = v ? read_new_name(rd, v, EXPR_TIME) : new_name(rd, "t", EXPR_TIME);
    if (symbol < 0)
        return false;
    at_back(rd, mark);
    rd->r->system.time = symbol;
    return true;
}

/* Names first, values beside them: a value may use numbers only, so it is read while the
 * store has no names at all. */
static bool read_parameter_values(struct reader *rd, const json_t *parameters, expr_id *value)
{
    const char *key;
    json_t *v;
    size_t i = 0;
    json_object_foreach((json_t *)parameters, key, v) {
        size_t mark = at_member(rd, key);
        double finite;
        value[i] = json_is_null(v) ? EXPR_UNDEF : read_expression(rd, v, NULL);
        if (!json_is_null(v) && !value[i]) {
            if (!at_pass(rd, mark))
                return false;
            value[i] = expr_int(&rd->r->store, 1);
        }
        if (value[i] && !expr_is_const(&rd->r->store, value[i])
            && !constant_value(&rd->r->store, value[i], &finite)) {
            at_fail(rd, SGA_E_EXPR_UNDEFINED, "the value of this parameter is no finite number");
            if (!at_pass(rd, mark))
                return false;
            value[i] = expr_int(&rd->r->store, 1);
        }
        at_back(rd, mark);
        i++;
    }
    return true;
}

/* A digit says as much as a name. */
static bool worth_a_name(const struct expr_store *st, expr_id value)
{
    if (!value || !expr_is_const(st, value))
        return value != EXPR_UNDEF;
    const fmpq *q = expr_const_value(st, value);
    return !fmpz_is_one(fmpq_denref(q)) || fmpz_cmp_si(fmpq_numref(q), 9) > 0 || fmpz_cmp_si(fmpq_numref(q), -9) < 0;
}

static void add_known(struct request *r, int symbol, expr_id value)
{
    SGA_RESERVE(r->known, r->known_cap, r->knowns + 1);
    r->known[r->knowns++] = (struct request_known){ symbol, value };
}

/* The value of a parameter that is opened, and otherwise what the request says. */
static expr_id opened(struct reader *rd, const char *name, expr_id value)
{
    for (int i = 0; i < rd->opens; i++)
        if (!strcmp(rd->open[i].name, name) && (!value || rd->open[i].replaces))
            return expr_double(&rd->r->store, rd->open[i].near);
    return value;
}

static bool add_parameters(struct reader *rd, const json_t *parameters, const expr_id *value)
{
    const char *key;
    json_t *v;
    size_t i = 0;
    bool named = true;
    json_object_foreach((json_t *)parameters, key, v) {
        size_t mark = at_member(rd, key);
        int symbol = new_name(rd, key, EXPR_PARAMETER);
        if (symbol < 0) {
            if (!at_pass(rd, mark))
                return false;
            named = false;
            i++;
            continue;
        }
        set_value(rd, symbol, EXPR_UNDEF);
        bool swept = json_object_get(rd->swept, key) != NULL;
        rd->value[symbol] = swept || (rd->by_name && worth_a_name(&rd->r->store, value[i])) ? EXPR_UNDEF : value[i];
        if (value[i] && !swept)
            add_known(rd->r, symbol, value[i]);
        if (!rd->value[symbol]) {
            sys_add_parameter(&rd->r->system, symbol);
            if (!value[i] && rd->fitted && json_object_get(rd->fitted, key))
                strcpy(rd->symbolic, key);
            if (swept)
                rd->r->swept[rd->r->swept_count++] = (struct request_swept){ symbol, opened(rd, key, value[i]) };
            else if (!rd->symbolic[0] && !value[i])
                strcpy(rd->symbolic, key);
        }
        i++;
        at_back(rd, mark);
    }
    return named;
}

static bool read_parameters_and_time(struct reader *rd, const json_t *system)
{
    const json_t *parameters = json_object_get(system, "parameters");
    if (!parameters)
        return read_time(rd, system);
    size_t mark = at_member(rd, "parameters");
    if (!json_is_object(parameters))
        return expected(rd, "an object of names and values", parameters);
    SGA_FREED expr_id *value = sga_calloc(json_object_size(parameters) + 1, sizeof *value);
    bool ok = read_parameter_values(rd, parameters, value);
    if (ok) {
        at_back(rd, mark);
        ok = read_time(rd, system);
    }
    if (ok) {
        at_member(rd, "parameters");
        ok = add_parameters(rd, parameters, value);
    }
    if (ok)
        at_back(rd, mark);
    return ok;
}

int *read_variables(struct reader *rd, const json_t *system, const char *member, int *count)
{
    const json_t *v = need_member(rd, system, member);
    if (!v)
        return NULL;
    size_t mark = at_member(rd, member), n = list_size(v);
    if (n > REQUEST_MAX_VARIABLES)
        return at_fail(rd, SGA_E_LIMIT_VARIABLES, "there are %zu variables; the limit is %d", n, REQUEST_MAX_VARIABLES),
               NULL;
    if (n == 0)
        return at_fail(rd, SGA_E_EMPTY_SYSTEM, "a system needs at least one variable"), NULL;
    int *symbol = sga_take(&rd->r->mem, n * sizeof *symbol);
    bool named = true;
    for (size_t i = 0; i < n; i++) {
        size_t here = at_item(rd, v, i);
        symbol[i] = read_new_name(rd, list_item(v, i), EXPR_VARIABLE);
        if (symbol[i] < 0 && !at_pass(rd, here))
            return NULL;
        named &= symbol[i] >= 0;
        at_back(rd, here);
    }
    at_back(rd, mark);
    *count = (int)n;
    return named ? symbol : NULL;
}

static void index_columns(struct reader *rd)
{
    const struct sys_system *s = &rd->r->system;
    rd->columns = rd->r->store.symbols;
    rd->column = sga_take(&rd->mem, ((size_t)rd->columns + 1) * sizeof *rd->column);
    for (int i = 0; i < rd->columns; i++)
        rd->column[i] = -1;
    for (int j = 0; j < s->variables; j++)
        rd->column[s->variable[j].symbol] = j;
}

bool read_system(struct reader *rd, const json_t *v)
{
    size_t mark = at_member(rd, "system");
    if (!json_is_object(v))
        return expected(rd, "an object", v);
    const struct form_kind *form = read_form(rd, v);
    if (!form || !form_members(rd, v, form))
        return false;
    rd->r->form = form->name;
    if (rd->form)
        *rd->form = form->name;
    const json_t *name = json_object_get(v, "name");
    if (name) {
        size_t here = at_member(rd, "name");
        if (read_string(rd, name))
            rd->r->name = sga_take_text(&rd->r->mem, json_string_value(name));
        else if (!at_pass(rd, here))
            return false;
        at_back(rd, here);
    }
    if (!read_parameters_and_time(rd, v) || !read_modes(rd, v) || !read_tables(rd, v) || !form->read(rd, v))
        return false;
    for (int k = 0; k < rd->r->modes; k++)
        rd->r->mode[k].in_system = rd->r->store.symbol[rd->r->mode[k].symbol].mentioned;
    for (int k = 0; k < rd->r->tables; k++)
        for (int i = 0; i < rd->r->store.symbols; i++)
            rd->r->table[k].in_system |= rd->r->store.symbol[i].table == rd->r->table[k].values && rd->r->store.symbol[i].mentioned;
    index_columns(rd);
    rd->grammar.derivative = state_derivative;
    rd->grammar.ctx = rd;
    at_back(rd, mark);
    return store_ok(rd);
}
