/* Warnings that an answer raises about its own request: names that nothing uses, numbers of equations, a start that moved. */
#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "free_outputs.h"
#include "mechanical_answer.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "slice.h"
#include "stratum.h"
#include "system.h"
#include "trajectory.h"
#include "warnings.h"
#include "write.h"

/* "a, b, c", and how many more there are. */
enum { NAMED = 12 };

static void name(struct sga_buf *out, int *count, const char *text)
{
    if ((*count)++ < NAMED)
        sga_buf_printf(out, "%s%s", out->len ? ", " : "", text);
}

static void and_more(struct sga_buf *out, int count)
{
    if (count > NAMED)
        sga_buf_printf(out, " and %d more", count - NAMED);
}

/* By symbol: whether the system's equations have it, as a variable or by its derivative. */
static unsigned char *in_equations(const struct sys_system *sys)
{
    const struct expr_store *st = sys->store;
    unsigned char *in = sga_calloc((size_t)st->symbols + 1, 1);
    struct expr_cone cone;
    expr_id *list;
    int count = sys_expressions(sys, &list);
    expr_cone_init(&cone);
    for (int part = 0; part < 2; part++) {
        expr_cone_of(st, &cone, part ? sys->restriction : list, part ? sys->restrictions : count);
        for (int k = 0; k < cone.count; k++)
            if (expr_op_of(st, cone.list[k]) == EXPR_SYM)
                in[st->node[cone.list[k]].a] = 1;
    }
    for (int i = 0; i < sys->rows; i++)
        for (int k = 0; k < sys->row[i].entries; k++)
            in[sys->variable[sys->row[i].entry[k].col].symbol] = 1;
    expr_cone_clear(&cone);
    free(list);
    return in;
}

static void unused_variables(struct job *j)
{
    const struct sys_system *sys = &j->request->system;
    if (j->request->hamiltonian || j->request->mechanical || j->request->op.has || !sys->rows)
        return;      /* rows that are made later, or have all of them */
    unsigned char *in = in_equations(sys);
    for (int k = 0; k < sys->variables; k++)
        if (!in[sys->variable[k].symbol])
            sga_warn(j->budget, SGA_W_UNUSED, "/system", "the variable %s is in no equation: nothing is said of its motion", answer_variable_name(j, k));
    free(in);
}

static bool is_mode(const struct job *j, int symbol)
{
    bool is = false;
    for (int k = 0; k < j->request->modes; k++)
        is |= j->request->mode[k].symbol == symbol;
    return is;
}

/* Modes without an equation, and those that nothing sets. */
static void unused_modes(struct job *j)
{
    const struct request_trajectory *t = &j->request->trajectory;
    for (int k = 0; k < j->request->modes; k++) {
        const struct request_mode *m = j->request->mode + k;
        char place[16 + REQUEST_MAX_NAME];
        bool set = false;
        snprintf(place, sizeof place, "/system/modes/%s", m->name);
        for (int e = 0; e < t->events; e++)
            for (int i = 0; i < t->event[e].sets; i++)
                set |= t->event[e].set[i].variable == -1 - k;
        if (!m->in_system)
            sga_warn(j->budget, SGA_W_MODE_UNUSED, place, "no equation has the mode %s: all its values have the same system; use it in one, or leave it out", m->name);
        if (!set)
            sga_warn(j->budget, SGA_W_MODE_UNUSED, place, "no event sets the mode %s: it stays %.17g, and nothing is said of other values; set it in an event with \"action\": \"set\"",
                     m->name, m->value[m->now]);
    }
}

/* Names with values are gone from the equations: what counts is whether some expression of the request said them. */
void answer_warn_unused(struct job *j)
{
    const struct expr_store *st = &j->request->store;
    unused_variables(j);
    unused_modes(j);
    for (int k = 0; k < st->symbols; k++)
        if (st->symbol[k].kind == EXPR_PARAMETER && !st->symbol[k].mentioned && !is_mode(j, k))
            sga_warn(j->budget, SGA_W_UNUSED, "/system/parameters", "the parameter %s is used nowhere", st->symbol[k].name);
    for (int t = 0; t < j->request->tables; t++) {
        bool used = false;
        for (int k = 0; k < st->symbols; k++)
            used |= st->symbol[k].table == j->request->table[t].values && st->symbol[k].mentioned;
        if (!used)
            sga_warn(j->budget, SGA_W_UNUSED, "/system/tables", "the table %s is used nowhere", j->request->table[t].name);
    }
}

/* Variables whose derivative the free functions enter: by the gauge fields where there are any, which does not depend on the
 * order of the variables; otherwise one choice of them. */
static void free_names(const struct job *j, struct sga_buf *out)
{
    const struct sga_solution *sol = j->solution;
    int n = j->request->system.variables, count = 0;
    for (int i = 0; i < n; i++) {
        bool is_free = false;
        for (int k = 0; k < sol->free_columns; k++)
            is_free |= sol->gauge ? !expr_is_zero(&j->request->store, sol->gauge[(size_t)k * (size_t)n + (size_t)i]) : sol->free_column[k] == i;
        if (is_free)
            name(out, &count, answer_variable_name(j, i));
    }
    and_more(out, count);
}

/* Derivatives of the order reduction have an equation each, and are not counted. */
void answer_count_given(const struct job *j, int *equations, int *unknowns)
{
    assert(!j->slice || j->slice->variables >= j->request->system.variables);
    const struct sys_system *sys = &j->request->system;
    int added = 0, chosen = 0;
    for (int k = 0; k < sys->variables && !j->slice; k++)
        added += strcmp(sys->variable[k].role, "derivative") == 0;
    for (int i = 0; i < sys->rows && !j->slice; i++)     /* rows of our own */
        chosen += strncmp(sys->row[i].source, "choice of ", 10) == 0;
    *equations = j->slice ? j->slice->rows : sys->rows - added - chosen;
    *unknowns = j->slice ? j->slice->variables : sys->variables - added;
}

static void warn_count(struct job *j)
{
    const struct sga_solution *sol = j->solution;
    int equations, unknowns, functions = sol->verdict == SGA_INCONSISTENT ? 0 : sol->free_columns;
    struct sga_buf names = { 0 };
    if (j->op)
        return;
    answer_count_given(j, &equations, &unknowns);
    free_names(j, &names);
    if (equations < unknowns && functions)
        sga_warn(j->budget, SGA_W_FEWER_EQUATIONS, "/system", "%d equation%s for %d unknown%s: %d function%s of time can be chosen; free %s %s", equations,
                 equations == 1 ? "" : "s", unknowns, unknowns == 1 ? "" : "s", functions, functions > 1 ? "s" : "", strchr(names.data, ',') ? "are among" : "is", names.data);
    else if (equations < unknowns)
        sga_warn(j->budget, SGA_W_FEWER_EQUATIONS, "/system", "%d equation%s for %d unknown%s%s", equations, equations == 1 ? "" : "s",
                 unknowns, unknowns == 1 ? "" : "s",
                 sol->verdict == SGA_INCONSISTENT ? "" : "; their consequences determine all of them");
    else if (functions)
        sga_warn(j->budget, SGA_W_FREE, "/system", "%d equation%s for %d unknown%s leave %d function%s of time to be chosen; "
                 "free %s %s", equations, equations == 1 ? "" : "s", unknowns, unknowns == 1 ? "" : "s", functions, functions > 1 ? "s" : "",
                 strchr(names.data, ',') ? "are among" : "is", names.data);
    if (equations > unknowns)
        sga_warn(j->budget, SGA_W_MORE_EQUATIONS, "/system", "%d equation%s for %d unknown%s; %d follow%s from the others", equations,
                 equations == 1 ? "" : "s", unknowns, unknowns == 1 ? "" : "s", sol->redundant_rows, sol->redundant_rows == 1 ? "s" : "");
    sga_buf_free(&names);
}

/* Values that were given and did not stay. */
static void warn_moved(struct job *j, const double *x)
{
    const struct request_trajectory *t = &j->request->trajectory;
    struct sga_buf names = { 0 };
    int count = 0;
    /* how far one value moves for the sake of another is a matter of their units; a value that moves alone has to */
    const char *by = ". Of points on the constraints it is the nearest in the units that the values are given in: in other units another one may be; trajectory.hold keeps values";
    for (int k = 0; k < t->initials; k++) {
        double given = t->initial[k].value, now = x[t->initial[k].variable];
        char text[256];
        if (!answer_value_moved(j, t->initial + k, x))
            continue;
        snprintf(text, sizeof text, "%.128s from %.6g to %.6g", answer_variable_name(j, t->initial[k].variable), given, now);
        name(&names, &count, text);
    }
    and_more(&names, count);
    if (count)
        sga_warn(j->budget, SGA_W_START_MOVED, "/trajectory/initial", "the start was moved onto the constraints: %s%s", names.data, count > 1 ? by : "");
    sga_buf_free(&names);
}

static void warn_redundant(struct job *j, const char *list, const int *which, int count)
{
    char pointer[64];
    for (int k = 0; k < count; k++) {
        snprintf(pointer, sizeof pointer, "%s/%d", list, which[k]);
        sga_warn(j->budget, SGA_W_REDUNDANT, pointer, "the constraint follows from the others: its multiplier is chosen to be 0, and neither motion nor "
                 "reaction depends on that");
    }
}

void answer_warn(struct job *j)
{
    if (!j->place.depth)
        warn_count(j);
    struct job *motion = j->part ? j->part : j;
    if (!j->place.depth)
        answer_warn_free_outputs(motion);
    if (motion->initial)
        warn_moved(motion, motion->initial->x);
    if (motion->trajectory && motion->trajectory->initial)
        warn_moved(motion, motion->trajectory->initial);
    warn_redundant(j, "/system/holonomic", j->redundant, j->redundants);
    if (j->mechanical && !j->place.depth)
        warn_redundant(j, "/system/constraints", j->mechanical->fibre.redundant, j->mechanical->fibre.redundants);
    int proved = 0;
    for (int k = 0; k < j->oracle->reals; k++)
        proved += j->oracle->real[k].certified;
    if (j->oracle->reals && !proved)
        sga_warn(j->budget, SGA_W_POINTS_NOT_PROVED, "", "none of the %d points of the constraint set that decisions rest on is proved to lie on it",
                 j->oracle->reals);
    if (j->solution->sides_not_searched)
        sga_limit_met(j->budget, SGA_LIMIT_SIDE_WORK);
    for (int i = 0; i < j->strata.count && j->request->strata; i++)
        if (j->strata.at[i].state == STRATUM_UNSOLVED)
            sga_warn(j->budget, SGA_W_STRATA_NOT_SOLVED, "/strata", "some strata could not be solved: each has a problem that says why");
}
