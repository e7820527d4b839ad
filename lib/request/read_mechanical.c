/* The form `mechanical`: coordinates, masses (a list or a matrix), forces and constraints in q and
 * q'. Its parts stay with the request: the geometry of the constraints is worked out later. */
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "error.h"
#include "form.h"
#include "reader.h"

static bool read_masses(struct reader *rd, const json_t *system, struct form_mechanical *m)
{
    const json_t *v = need_member(rd, system, "masses");
    struct read_matrix matrix = { .name = "masses", .rows = m->coordinates, .cols = m->coordinates,
                                  .per_row = "coordinates", .per_col = "coordinates" };
    if (!v)
        return false;
    bool nested = json_is_object(v) || (json_is_array(v) && json_array_size(v) && json_is_array(json_array_get(v, 0)));
    if (nested) {
        bool ok = read_matrix(rd, system, &matrix);
        m->mass = read_matrix_kept(&rd->r->mem, matrix.entry, matrix.entries);
        m->masses = matrix.entries;
        return ok;
    }
    expr_id *list = NULL;
    int count;
    bool ok = read_expression_list(rd, system, "masses", &list, &count);
    if (ok && count != m->coordinates) {
        at_member(rd, "masses");
        ok = at_fail(rd, SGA_E_SHAPE, "there are %d masses, but %d coordinates; give one for each, or a matrix as a list of rows",
                     count, m->coordinates);
    }
    m->mass = sga_zeros(&rd->r->mem, (size_t)m->coordinates + 1, sizeof *m->mass);
    for (int i = 0; ok && i < count; i++)
        m->mass[m->masses++] = (struct form_entry){ i, i, list[i] };
    return ok;
}

static bool read_forces(struct reader *rd, const json_t *system, struct form_mechanical *m)
{
    int count;
    if (!need_member(rd, system, "forces") || !read_expression_list(rd, system, "forces", &m->force, &count))
        return false;
    if (count == m->coordinates)
        return true;
    at_member(rd, "forces");
    return at_fail(rd, SGA_E_SHAPE, "there are %d forces, but %d coordinates", count, m->coordinates);
}

/* Functions of q and q' that vanish on the subset to start from. */
static bool read_restrict(struct reader *rd, const json_t *system)
{
    expr_id *list = NULL;
    int count;
    bool ok = read_expression_list(rd, system, "restrict", &list, &count);
    for (int i = 0; ok && i < count; i++)
        sys_add_restriction(&rd->r->system, list[i]);
    return ok;
}

/* Forces and constraints know q'; masses are functions of q and time. */
static bool read_functions(struct reader *rd, const json_t *system, struct form_mechanical *m)
{
    if (!read_masses(rd, system, m))
        return false;
    rd->grammar.derivative = read_velocity_of;
    rd->grammar.ctx = rd;
    bool ok = read_forces(rd, system, m) && need_member(rd, system, "constraints")
        && read_expression_list(rd, system, "constraints", &m->constraint, &m->constraints)
        && read_restrict(rd, system);
    rd->grammar.derivative = NULL;
    if (m->constraints < 0)
        m->constraints = 0;
    return ok && read_motion_fits(rd, m->coordinates, m->constraints);
}

bool read_mechanical(struct reader *rd, const json_t *system)
{
    struct form_mechanical *m = sga_zeros(&rd->r->mem, 1, sizeof *m);
    m->coordinate = read_variables(rd, system, "coordinates", &m->coordinates);
    if (!m->coordinate || !(m->velocity = read_make_velocities(rd, m->coordinate, m->coordinates))
        || !read_functions(rd, system, m) || !(m->multiplier = read_make_multipliers(rd, m->constraints)))
        return false;
    rd->r->mechanical = m;
    form_mechanical(&rd->r->system, m);
    return true;
}

/* Names that outputs may use beside the variables: put into the store after the system has been
 * read; a name that the request uses itself keeps its meaning. */
static expr_id output_name(struct reader *rd, const char *prefix, const char *name)
{
    struct expr_store *st = &rd->r->store;
    SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
    expr_id e = EXPR_UNDEF;
    sga_buf_printf(&text, "%s%s", prefix, name);
    if (expr_symbol_find(st, text.data, text.len) < 0)
        e = expr_symbol_add(st, text.data, EXPR_FREE);
    return e;
}

void read_mechanical_outputs(struct reader *rd)
{
    struct request *r = rd->r;
    struct request_forces *f = &r->forces;
    int n = r->mechanical->coordinates;
    f->reaction = sga_zeros(&rd->r->mem, (size_t)n + 1, sizeof *f->reaction);
    for (int i = 0; i < n; i++)
        f->reaction[i] = output_name(rd, "reaction_", r->store.symbol[r->mechanical->coordinate[i]].name);
    f->power = output_name(rd, "reaction_", "power");
}
