/* A job's system and request, sliced to what the outputs depend on. */
#include "slice.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "expr.h"
#include "form.h"
#include "run_job.h"
#include "mem.h"
#include "request.h"
#include "system.h"

/* Of the motion only outputs are asked for. Forms that keep more than the rows, and answers
 * that speak of the whole system along a motion, are left as they are. */
static bool motion_alone(const struct request *r)
{
    const struct form_hamiltonian *h = r->hamiltonian;
    return r->trajectory.outputs && !r->trajectory.sensitivities.has && !r->trajectory.relations && !r->trajectory.low && r->want & SLICE_MOTION && !r->strata && !r->op.has
        && !(h && (h->restrictions || h->omega));
}

static bool may_slice(const struct request *r)
{
    return motion_alone(r) && !(r->want & ~SLICE_MOTION);
}

/* The energy's drift, which an answer has without being asked, needs the whole motion; a start that is asked for is all of it. */
bool slice_beside(const struct request *r)
{
    static const unsigned whole = REQUEST_CONSTRAINTS | REQUEST_INDEX | REQUEST_VECTOR_FIELD | REQUEST_GAUGE | REQUEST_STRUCTURE | REQUEST_SYMMETRIES
                                  | REQUEST_DERIVATION | REQUEST_DIRAC;
    return motion_alone(r) && r->want & whole && !(r->want & ~(SLICE_MOTION | whole)) && !(r->want & REQUEST_CONSISTENT_INITIAL) && !r->hamiltonian && r->lagrangian == EXPR_UNDEF;
}

/* As beside; of forms whose parts feed outputs in ways that rows show. */
static bool may_feed(const struct request *r)
{
    return motion_alone(r) && !r->mechanical && !r->sweeps;
}

/* A reaction is known where its coordinate is modelled. */
static void add_force(const struct expr_store *st, expr_id reaction, int *map, int coordinate)
{
    if (reaction != EXPR_UNDEF)
        map[st->node[reaction].a] = coordinate;
}

/* The power of all reactions needs all of the system. */
static bool asks_power(const struct expr_cone *cone, expr_id power)
{
    for (int k = 0; power != EXPR_UNDEF && k < cone->count; k++)
        if (cone->list[k] == power)
            return true;
    return false;
}

/* The variables in the expressions of the request's trajectory. */
static void find_needed(const struct job *j, unsigned char *needed)
{
    const struct request_trajectory *t = &j->request->trajectory;
    const struct sys_system *sys = &j->request->system;
    const struct expr_store *st = &j->request->store;
    int roots = 0, *map = sga_malloc(((size_t)st->symbols + 1) * sizeof *map);
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, (size_t)(t->outputs + t->events + t->rates + t->conditions + t->integrals + 1) * sizeof *root);
    struct expr_cone cone;
    for (int s = 0; s < st->symbols; s++)
        map[s] = -1;
    for (int v = 0; v < sys->variables; v++)
        map[sys->variable[v].symbol] = v;
    for (int k = 0; j->request->mechanical && k < j->request->mechanical->coordinates; k++)
        add_force(st, j->request->forces.reaction[k], map, k);
    for (int k = 0; k < t->outputs; k++)
        root[roots++] = t->output[k];
    for (int k = 0; k < t->events; k++) {
        root[roots++] = t->event[k].expression;
        if (t->event[k].sets)      /* what else must move after it is not known before */
            memset(needed, 1, (size_t)sys->variables);
    }
    if (t->sliding)                /* what a slide holds is not known before */
        memset(needed, 1, (size_t)sys->variables);
    for (int k = 0; k < t->conditions; k++)
        root[roots++] = t->condition[k];
    for (int k = 0; k < t->integrals; k++)
        root[roots++] = t->integral[k];
    for (int k = 0; k < t->rates; k++) {
        root[roots++] = t->rate[k].rate;
        needed[t->rate[k].variable] = 1;
    }
    for (int k = 0; k < t->holds; k++)
        needed[t->hold[k]] = 1;
    expr_cone_init(&cone);
    expr_cone_of(st, &cone, root, roots);
    for (int k = 0; k < cone.count; k++) {
        const struct expr_node *node = st->node + cone.list[k];
        int v = node->op == EXPR_SYM ? map[node->a] : -1;
        if (v >= 0)
            needed[v] = 1;
    }
    if (j->request->mechanical && asks_power(&cone, j->request->forces.power))
        memset(needed, 1, (size_t)sys->variables);
    expr_cone_clear(&cone);
    free(map);
}

/* Names and given values of what goes. */
static void note(struct job *j, const struct slice_parts *p)
{
    const struct sys_system *sys = &j->request->system;
    struct model_slice *c = j->slice = sga_zeros(&j->mem, 1, sizeof *c);
    c->tied = p->tied;
    c->variables = sys->variables;
    c->rows = sys->rows + sys->restrictions;
    c->symbol = sga_take(&j->mem, (size_t)(sys->variables + 1) * sizeof *c->symbol);
    c->given = sga_take(&j->mem, (size_t)(j->request->trajectory.initials + 1) * sizeof *c->given);
    for (int v = 0; v < sys->variables; v++) {
        if (p->variable[v] == SLICE_KEPT)
            continue;
        c->symbol[c->gone++] = sys->variable[v].symbol;
        c->apart += p->variable[v] == SLICE_APART;
    }
    for (int r = 0; r < c->rows; r++)
        c->rows_gone += !p->row[r];
    assert(c->apart <= c->gone && c->gone <= c->variables && c->rows_gone <= c->rows);
}

static void slice_system(struct sys_system *sys, const struct slice_parts *p, const int *place)
{
    int rows = 0, restrictions = 0, variables = 0;
    for (int r = 0; r < sys->rows; r++) {
        struct sys_row row = sys->row[r];
        if (!p->row[r]) {
            free(row.entry);
            free((char *)row.source);
            continue;
        }
        for (int k = 0; k < row.entries; k++)
            row.entry[k].col = place[row.entry[k].col];
        sys->row[rows++] = row;
    }
    for (int r = 0; r < sys->restrictions; r++)
        if (p->row[sys->rows + r])
            sys->restriction[restrictions++] = sys->restriction[r];
    for (int v = 0; v < sys->variables; v++)
        if (place[v] >= 0)
            sys->variable[variables++] = sys->variable[v];
    /* the arrays grow by their counts: room for the next power of two is wanted */
    sys->row = sga_realloc(sys->row, 2 * ((size_t)rows + 1) * sizeof *sys->row);
    sys->restriction = sga_realloc(sys->restriction, 2 * ((size_t)restrictions + 1) * sizeof *sys->restriction);
    assert(rows <= sys->rows && restrictions <= sys->restrictions && variables <= sys->variables);
    sys->rows = rows;
    sys->restrictions = restrictions;
    sys->variables = variables;
}

/* The given values of what is kept; those of what goes into `out`, where it is not NULL. */
static void slice_initial(struct request_initial *list, int *count, const int *place, const struct sys_system *sys, struct model_slice *out)
{
    int kept = 0;
    for (int k = 0; k < *count; k++) {
        struct request_initial i = list[k];
        if (place[i.variable] >= 0) {
            i.variable = place[i.variable];
            list[kept++] = i;
            continue;
        }
        if (out) {
            out->given[out->givens++] = (struct slice_given){ sys->variable[i.variable].symbol, i.value };
        }
    }
    *count = kept;
}

/* Of the form's own parts those that belong to what is kept: the system's variables are coordinates, velocities and
 * multipliers, its rows definitions, equations and constraints (form_mechanical). */
static void slice_mechanical(struct request *r, const struct slice_parts *p, const int *place)
{
    struct form_mechanical *m = r->mechanical;
    int n = m->coordinates, coordinates = 0, constraints = 0;
    size_t masses = 0;
    for (int i = 0; i < n; i++) {
        if (place[i] < 0)
            continue;
        m->coordinate[coordinates] = m->coordinate[i];
        m->velocity[coordinates] = m->velocity[i];
        m->force[coordinates] = m->force[i];
        r->forces.reaction[coordinates++] = r->forces.reaction[i];
    }
    for (int i = 0; i < m->constraints; i++)
        if (p->row[2 * n + i]) {
            m->constraint[constraints] = m->constraint[i];
            m->multiplier[constraints++] = m->multiplier[i];
        }
    for (size_t k = 0; k < m->masses; k++) {
        struct form_entry e = m->mass[k];
        if (place[e.row] >= 0)
            m->mass[masses++] = (struct form_entry){ place[e.row], place[e.col], e.value };
    }
    assert(coordinates <= n && constraints <= m->constraints && masses <= m->masses);
    m->coordinates = coordinates;
    m->constraints = constraints;
    m->masses = masses;
}

static void slice_request(struct job *j, const int *place)
{
    struct request *r = j->request;
    struct request_trajectory *t = &r->trajectory;
    slice_initial(t->initial, &t->initials, place, &r->system, j->slice);
    for (int k = 0; k < t->holds; k++)
        t->hold[k] = place[t->hold[k]];
    for (int k = 0; k < t->rates; k++)
        t->rate[k].variable = place[t->rate[k].variable];
    for (int k = 0; k < r->sweeps; k++)
        slice_initial(r->sweep[k].initial, &r->sweep[k].initials, place, &r->system, NULL);
}

/* The job's system and request are cut; the parts go. */
static void cut(struct job *j, struct slice_parts *parts)
{
    SGA_ARENA(mem);
    int n = j->request->system.variables, *place = sga_take(&mem, ((size_t)n + 1) * sizeof *place), kept = 0;
    for (int v = 0; v < n; v++)
        place[v] = parts->variable[v] == SLICE_KEPT ? kept++ : -1;
    note(j, parts);
    /* the energy is that of the whole system: its drift along a part's motion is not known */
    j->request->lagrangian = EXPR_UNDEF;
    if (j->request->hamiltonian)
        j->request->hamiltonian->hamiltonian = EXPR_UNDEF;
    if (j->request->mechanical)
        slice_mechanical(j->request, parts, place);
    slice_request(j, place);
    slice_system(&j->request->system, parts, place);
    slice_parts_clear(parts);
}

void answer_slice(struct job *j, bool tied)
{
    struct request_trajectory *t = &j->request->trajectory;
    size_t n = (size_t)j->request->system.variables + 1;
    struct slice_parts parts;
    if (!may_slice(j->request))
        return;
    SGA_ARENA(mem);
    unsigned char *needed = sga_zeros(&mem, n, 1), *fixed = sga_zeros(&mem, n, 1), *stays = sga_zeros(&mem, n, 1);
    find_needed(j, needed);
    for (int k = 0; k < t->initials; k++) {
        fixed[t->initial[k].variable] = tied && !j->request->sweeps;
        stays[t->initial[k].variable] = 1;
    }
    for (int s = 0; s < j->request->sweeps; s++)
        for (int k = 0; k < j->request->sweep[s].initials; k++)
            stays[j->request->sweep[s].initial[k].variable] = 1;
    /* the geometry of a mechanical system's constraints belongs to a whole part of it */
    struct slice_wish wish = { needed, fixed, stays, j->request->mechanical, tied && !j->request->sweeps };
    if (slice_decide(&j->request->system, &wish, &parts))
        cut(j, &parts);
}

void answer_slice_feeds(struct job *j)
{
    struct slice_parts parts;
    SGA_ARENA(mem);
    unsigned char *needed = sga_zeros(&mem, (size_t)j->request->system.variables + 1, 1);
    if (!may_slice(j->request) || !may_feed(j->request))
        return;
    find_needed(j, needed);
    if (slice_feeds(&j->request->system, needed, &parts))
        cut(j, &parts);
}

bool slice_feeds_less(const struct job *j)
{
    const struct request *r = j->request;
    struct slice_parts parts;
    SGA_ARENA(mem);
    unsigned char *needed = sga_zeros(&mem, (size_t)r->system.variables + 1, 1);
    if (!may_feed(r) || (r->want & ~(REQUEST_TRAJECTORY | REQUEST_TRADEOFF)) || r->hamiltonian || r->lagrangian != EXPR_UNDEF)
        return false;
    find_needed(j, needed);
    if (!slice_feeds(&r->system, needed, &parts))
        return false;
    slice_parts_clear(&parts);
    return true;
}
