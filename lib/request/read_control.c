/* The form `control`: F, a row of G for each input, and the constraints to hold. */
#include <stdlib.h>

#include "error.h"
#include "form.h"
#include "reader.h"

/* F has one entry for each variable. */
static bool fits(struct reader *rd, const char *member, int given, int variables)
{
    if (given == variables)
        return true;
    at_member(rd, member);
    return at_fail(rd, SGA_E_SHAPE, "%s has %d entries, but there are %d of variables", member, given, variables);
}

bool read_control(struct reader *rd, const json_t *system)
{
    struct form_control f = { 0 };
    struct read_matrix G = { .name = "G", .per_row = "inputs", .per_col = "variables" };
    expr_id *F = NULL, *constraint = NULL;
    int *input = NULL;
    int given = 0;
    int *variable = read_variables(rd, system, "variables", &f.variables);
    if (variable)
        input = read_variables(rd, system, "inputs", &f.inputs);
    G.rows = f.inputs;
    G.cols = f.variables;
    bool ok = input && need_member(rd, system, "F") && read_expression_list(rd, system, "F", &F, &given)
        && fits(rd, "F", given, f.variables) && read_matrix(rd, system, &G) && need_member(rd, system, "constraints")
        && read_expression_list(rd, system, "constraints", &constraint, &f.constraints);
    if (ok) {
        f.variable = variable;
        f.input = input;
        f.F = F;
        f.G = (struct form_matrix){ .rows = G.rows, .cols = G.cols, .entry = G.entry, .entries = G.entries };
        f.constraint = constraint;
        form_control(&rd->r->system, &f);
    }
    return ok;
}
