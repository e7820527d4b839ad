/* The structure's part of the result. */
#include "run_job.h"

#include <stdlib.h>

#include "arena.h"
#include "buf.h"
#include "graph.h"
#include "mem.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "structure.h"
#include "system.h"
#include "warnings.h"
#include "write.h"

/* Each of them may list all equations. */

/* An expression's text, or null where it is longer than `limit` bytes. */
static void member_expression(struct job *j, struct sga_json *w, const char *key, expr_id e, size_t limit)
{
    sga_json_key(w, key);
    expr_json(&j->request->store, e, limit, w);
}

/* Whether the velocity's name is a variable of its own (order reduction). */
static bool is_variable(const struct job *j, int variable)
{
    struct sga_buf name = { 0 };
    sga_buf_printf(&name, "%s'", answer_variable_name(j, variable));
    bool found = expr_symbol_find(&j->request->store, name.data, name.len) >= 0;
    sga_buf_free(&name);
    return found;
}

/* The row as an equation of the grammar: "(a)*x' + y' = alpha"; left out where it is long,
 * and where it only says that the variable x' is the derivative of x. */
static void write_text(struct job *j, struct sga_json *w, int row)
{
    enum { LIMIT = 400 };
    const struct sys_row *r = j->request->system.row + row;
    struct expr_store *st = &j->request->store;
    struct sga_buf text = { 0 };
    bool ok = true;
    for (int k = 0; k < r->entries && ok; k++) {
        ok = !is_variable(j, r->entry[k].col);
        sga_buf_puts(&text, k ? " + " : "");
        if (ok && !expr_is_one(st, r->entry[k].value)) {
            sga_buf_puts(&text, "(");
            ok = expr_print(st, r->entry[k].value, LIMIT, &text);
            sga_buf_puts(&text, ")*");
        }
        sga_buf_printf(&text, "%s'", answer_variable_name(j, r->entry[k].col));
        ok = ok && text.len < LIMIT;
    }
    sga_buf_puts(&text, r->entries ? " = " : "0 = ");
    if (ok && expr_print(st, r->alpha, LIMIT, &text)) {
        sga_json_member_string(w, "text", text.data);
    }
    sga_buf_free(&text);
}

static void write_names(const struct job *j, struct sga_json *w, const char *key, const int *variable, int count)
{
    sga_json_key(w, key);
    sga_json_array(w);
    for (int k = 0; k < count; k++)
        sga_json_string(w, answer_variable_name(j, variable[k]));
    sga_json_end_array(w);
}

static void write_initial(const struct job *j, struct sga_json *w)
{
    const struct structure *s = j->structure;
    const struct sga_solution *sol = j->solution;
    sga_json_key(w, "degrees_of_freedom");
    sga_json_object(w);
    sga_json_member_int(w, "initial", j->request->system.variables - sol->constraints);
    sga_json_member_int(w, "functions", sol->free_columns);
    sga_json_end_object(w);
    if (!s->has_initial) {
        sga_json_key(w, "free_initial");
        sga_json_null(w);
        return;
    }
    write_names(j, w, "free_initial", s->free_initial, s->frees);
    sga_json_key(w, "determined_initial");
    sga_json_array(w);
    for (int k = 0; k < sol->constraints; k++) {
        sga_json_object(w);
        sga_json_member_string(w, "variable", answer_variable_name(j, s->solved_for[k]));
        sga_json_member_int(w, "constraint", k);
        if (s->follow)
            write_names(j, w, "follows_from", s->follow + s->follow_first[k], s->follow_first[k + 1] - s->follow_first[k]);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static const char *role_text(enum structure_role role)
{
    static const char *const text[] = {
        [STRUCTURE_DERIVATIVE] = "derivative", [STRUCTURE_CONSTRAINT] = "constraint",
        [STRUCTURE_CONSEQUENCE] = "consequence", [STRUCTURE_USED] = "used",
    };
    return text[role];
}

static void write_role(const struct job *j, struct sga_json *w, const struct structure_equation *e)
{
    sga_json_member_string(w, "role", role_text(e->role));
    if (e->variable >= 0) {
        sga_json_member_string(w, "derivative_of", answer_variable_name(j, e->variable));
    }
    if (e->constraint >= 0) {
        sga_json_member_int(w, "constraint", e->constraint);
        sga_json_member_int(w, "generation", j->solution->constraint[e->constraint].generation);
    }
}

static void write_consequence(struct job *j, struct sga_json *w, const struct structure_equation *e)
{
    sga_json_key(w, "combination");
    if (e->part) {
        sga_json_array(w);
        for (int k = 0; k < e->parts; k++) {
            sga_json_object(w);
            sga_json_member_int(w, "equation", e->part[k].row);
            member_expression(j, w, "factor", e->part[k].factor, 1000);
            sga_json_end_object(w);
        }
        sga_json_end_array(w);
    } else {
        sga_json_null(w);
    }
    sga_json_member_string(w, "holds", e->everywhere ? "everywhere" : "on_constraints");
    if (!e->everywhere) {
        sga_json_member_int(w, "after_generation", e->holds_on);
    }
}

static void write_equations(struct job *j, struct sga_json *w)
{
    const struct structure *s = j->structure;
    int rows = j->request->system.rows;
    sga_json_key(w, "equations");
    sga_json_array(w);
    for (int i = 0; i < rows; i++) {
        const struct structure_equation *e = s->equation + i;
        sga_json_object(w);
        sga_json_member_int(w, "index", i);
        sga_json_member_string(w, "equation", j->request->system.row[i].source);
        write_text(j, w, i);
        write_role(j, w, e);
        if (e->role == STRUCTURE_CONSEQUENCE)
            write_consequence(j, w, e);
        if (e->derivative_of >= 0) {
            sga_json_member_int(w, "implied_by_derivative_of", e->derivative_of);
        }
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    sga_json_key(w, "differentiated");
    sga_json_array(w);
    for (int i = rows; i < s->equations; i++) {
        sga_json_object(w);
        sga_json_member_int(w, "constraint_differentiated", i - rows);
        write_role(j, w, s->equation + i);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_origin(const struct job *j, struct sga_json *w, int source)
{
    int rows = j->request->system.rows;
    sga_json_object(w);
    if (source < rows) {
        sga_json_member_int(w, "equation", source);
    } else {
        sga_json_member_int(w, "constraint_differentiated", source - rows);
    }
    sga_json_end_object(w);
}

static void write_blocks(const struct job *j, struct sga_json *w)
{
    const struct structure *s = j->structure;
    int n = j->request->system.variables, *first = sga_calloc((size_t)s->blocks + 3, sizeof *first);
    SGA_ARENA(mem);
    int *member = sga_take(&mem, ((size_t)n + 1) * sizeof *member);
    for (int k = 0; k < n; k++)              /* block -1, the free ones, comes first */
        first[s->block[k] + 3]++;
    for (int b = 2; b <= s->blocks + 2; b++)
        first[b] += first[b - 1];
    for (int k = 0; k < n; k++)
        member[first[s->block[k] + 2]++] = k;
    sga_json_key(w, "blocks");
    sga_json_array(w);
    for (int b = -1; b < s->blocks; b++) {
        int count = first[b + 2] - first[b + 1];
        if (!count)
            continue;
        sga_json_object(w);
        write_names(j, w, "derivatives_of", member + first[b + 1], count);
        sga_json_key(w, "from");
        sga_json_array(w);
        for (int k = first[b + 1]; k < first[b + 2] && b >= 0; k++)
            write_origin(j, w, s->matched[member[k]]);
        sga_json_end_array(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    free(first);
}

/* Which equations, differentiated how often, determine the derivatives of each block. */
static void write_determines(const struct job *j, struct sga_json *w)
{
    const struct structure *s = j->structure;
    sga_json_key(w, "determines");
    sga_json_array(w);
    for (int i = 0; i < j->request->system.variables; i++) {
        int b = s->block[i];
        if (b < 0)
            continue;
        sga_json_object(w);
        sga_json_member_string(w, "derivative_of", answer_variable_name(j, i));
        sga_json_key(w, "equations");
        if (s->origin_unknown[b]) {
            sga_json_null(w);
            sga_json_end_object(w);
            continue;
        }
        sga_json_array(w);
        for (int k = s->origin_first[b]; k < s->origin_first[b + 1]; k++) {
            const struct structure_origin *o = s->origin + k;
            sga_json_object(w);
            sga_json_member_int(w, o->equation >= 0 ? "equation" : "restriction", o->equation >= 0 ? o->equation : o->restriction);
            sga_json_member_int(w, "differentiated", o->differentiated);
            sga_json_end_object(w);
        }
        sga_json_end_array(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_motion(const struct job *j, struct sga_json *w)
{
    const struct structure *s = j->structure;
    sga_json_key(w, "motion");
    sga_json_array(w);
    for (int q = 0; q < s->motion.groups; q++) {
        sga_json_object(w);
        write_names(j, w, "variables", s->motion.member + s->motion.first[q], s->motion.first[q + 1] - s->motion.first[q]);
        sga_json_key(w, "needs");
        sga_json_array(w);
        for (int k = s->need_first[q]; k < s->need_first[q + 1]; k++)
            sga_json_int(w, s->need[k]);
        sga_json_end_array(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

/* Members of one coarse part: equations by index, variables by name. */
static void write_part(const struct job *j, struct sga_json *w, const char *key, enum graph_part part)
{
    const struct structure *s = j->structure;
    sga_json_key(w, key);
    sga_json_object(w);
    sga_json_key(w, "equations");
    sga_json_array(w);
    for (int i = 0; i < j->request->system.rows; i++)
        if (s->row_part[i] == part)
            sga_json_int(w, i);
    sga_json_end_array(w);
    sga_json_key(w, "variables");
    sga_json_array(w);
    for (int k = 0; k < j->request->system.variables; k++)
        if (s->col_part[k] == part)
            sga_json_string(w, answer_variable_name(j, k));
    sga_json_end_array(w);
    sga_json_end_object(w);
}

void answer_write_structure(struct job *j, struct sga_json *w)
{
    bool solvable = j->solution->verdict != SGA_INCONSISTENT;
    if (solvable) {
        write_initial(j, w);
        write_equations(j, w);
        write_blocks(j, w);
        if (j->structure->origin && j->request->system.variables <= SGA_MOST_DETERMINED)
            write_determines(j, w);
        else if (j->structure->origin)
            sga_limit_met(j->budget, SGA_LIMIT_DETERMINED);
        write_motion(j, w);
    }
    sga_json_key(w, "predicted");
    sga_json_object(w);
    sga_json_member_int(w, "structural_rank", j->structure->structural_rank);
    write_part(j, w, "overdetermined", GRAPH_OVER);
    write_part(j, w, "underdetermined", GRAPH_UNDER);
    sga_json_end_object(w);
}
