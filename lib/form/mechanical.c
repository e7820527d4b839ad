/* Newton's equations with reactions of perfect constraints, and the constraints alone.
 *
 * Source: A. Szatkowski, On the dynamic spaces and on the equations of motion of nonlinear
 * nonholonomic mechanical systems, Arch. Mech. 42 (1990) 151-174, definition 3: the reaction lies in the orthogonal
 * complement of the fibre's tangent space, which the rows of H span. */
#include <assert.h>
#include <stdlib.h>

#include "arena.h"
#include "buf.h"
#include "derive.h"
#include "form.h"
#include "mem.h"
#include "signal.h"

static expr_id node_of(const struct sys_system *s, int symbol)
{
    return s->store->symbol[symbol].node;
}

static void add_named_row(struct sys_system *s, expr_id alpha, const char *what, int symbol)
{
    SGA_ENDS(sga_buf_free) struct sga_buf source = { 0 };
    sga_buf_printf(&source, "%s %s", what, s->store->symbol[symbol].name);
    sys_add_row(s, alpha, source.data);
}

/* 1 for the symbols given; the caller frees it. */
static unsigned char *mark(const struct sys_system *s, const int *symbol, int n)
{
    unsigned char *active = sga_calloc((size_t)s->store->symbols + 1, 1);
    for (int i = 0; i < n; i++)
        active[symbol[i]] = 1;
    return active;
}

expr_id form_fibre_condition(const struct sys_system *s, const struct form_mechanical *in, expr_id h)
{
    struct expr_store *st = s->store;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_FREED unsigned char *velocity = mark(s, in->velocity, in->coordinates);
    expr_cone_init(&cone);
    if (!expr_gradient(st, &cone, h, velocity, &term, &cap)) {
        SGA_FREED unsigned char *coordinate = mark(s, in->coordinate, in->coordinates);
        int terms = expr_gradient(st, &cone, h, coordinate, &term, &cap);
        SGA_FREED int *place = sga_calloc((size_t)st->symbols + 1, sizeof *place);
        h = expr_time_partial(st, h, s->time);
        for (int i = 0; i < in->coordinates; i++)
            place[in->coordinate[i]] = i;
        for (int k = 0; k < terms; k++)
            h = expr_add(st, h, expr_mul(st, term[k].value, node_of(s, in->velocity[place[term[k].symbol]])));
    }
    return h;
}

static void add_definitions(struct sys_system *s, const struct form_mechanical *in)
{
    for (int i = 0; i < in->coordinates; i++) {
        add_named_row(s, node_of(s, in->velocity[i]), "definition of", in->velocity[i]);
        sys_add_entry(s, s->rows - 1, i, expr_int(s->store, 1));
    }
}

static void add_constraints(struct sys_system *s, const struct form_mechanical *in)
{
    for (int i = 0; i < in->constraints; i++) {
        SGA_ENDS(sga_buf_free) struct sga_buf source = { 0 };
        sga_buf_printf(&source, "constraints[%d]", i);
        sys_add_row(s, in->constraint[i], source.data);
    }
}

/* alpha += H^T lambda for one condition. */
static void add_reaction(struct sys_system *s, const struct form_mechanical *in, int first, expr_id condition, int column)
{
    struct expr_store *st = s->store;
    SGA_ENDS(expr_cone_clear) struct expr_cone cone;
    SGA_FREED struct expr_term *term = NULL;
    size_t cap = 0;
    SGA_FREED unsigned char *velocity = mark(s, in->velocity, in->coordinates);
    SGA_FREED int *place = sga_calloc((size_t)st->symbols + 1, sizeof *place);
    for (int i = 0; i < in->coordinates; i++)
        place[in->velocity[i]] = i;
    expr_cone_init(&cone);
    int terms = expr_gradient(st, &cone, condition, velocity, &term, &cap);
    for (int k = 0; k < terms; k++) {
        expr_id *alpha = &s->row[first + place[term[k].symbol]].alpha;
        *alpha = expr_add(st, *alpha, expr_mul(st, term[k].value, node_of(s, s->variable[column].symbol)));
    }
}

void form_mechanical_rows(struct sys_system *s, const struct form_mechanical *in, const expr_id *condition,
                          const int *column, int conditions)
{
    add_definitions(s, in);
    int first = s->rows;
    for (int i = 0; i < in->coordinates; i++)
        add_named_row(s, in->force[i], "equation of", in->coordinate[i]);
    assert(s->rows == first + in->coordinates);
    for (size_t k = 0; k < in->masses; k++)
        sys_add_entry(s, first + in->mass[k].row, in->coordinates + in->mass[k].col, in->mass[k].value);
    for (int i = 0; i < conditions; i++)
        add_reaction(s, in, first, condition[i], column[i]);
    add_constraints(s, in);
}

static void add_state(struct sys_system *s, const struct form_mechanical *in)
{
    for (int i = 0; i < in->coordinates; i++)
        sys_add_variable(s, in->coordinate[i], "variable");
    for (int i = 0; i < in->coordinates; i++)
        sys_add_variable(s, in->velocity[i], "velocity");
}

void form_mechanical(struct sys_system *s, const struct form_mechanical *in)
{
    SGA_ARENA(mem);
    expr_id *condition = sga_zeros(&mem, (size_t)in->constraints + 1, sizeof *condition);
    int *column = sga_zeros(&mem, (size_t)in->constraints + 1, sizeof *column);
    add_state(s, in);
    for (int i = 0; i < in->constraints; i++) {
        sys_add_variable(s, in->multiplier[i], "multiplier");
        condition[i] = form_fibre_condition(s, in, in->constraint[i]);
        column[i] = 2 * in->coordinates + i;
    }
    form_mechanical_rows(s, in, condition, column, in->constraints);
    s->square = s->restrictions == 0;
}

void form_kinematics(struct sys_system *s, const struct form_mechanical *in)
{
    add_state(s, in);
    add_definitions(s, in);
    add_constraints(s, in);
}
