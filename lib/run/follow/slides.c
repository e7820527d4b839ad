/* Switches as modes: systems made from the job's own, in its store. */
#include "slides.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "budget.h"
#include "error.h"
#include "guess.h"
#include "mem.h"
#include "oracle.h"
#include "points.h"
#include "poly.h"
#include "print.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "seeds.h"
#include "surfaces.h"
#include "system.h"
#include "table.h"
#include "trajectory.h"

/* Texts of surfaces in the answer. */
enum { SURFACE_BYTES = 400 };
static const double SIDE[] = { 1, -1 };

/* One choice of switches. */
struct made {
    struct sys_system sys;
    struct sga_solution sol; struct points_oracle oracle; bool reduced;
    struct traj_request rq;
    struct traj_mode mode;
    struct made *next;
};

struct slides {
    struct job *j;
    struct sga_arena own, *mem;   /* own: of one set of a sweep */
    const struct sys_system *sys;
    struct surfaces s;
    struct traj_request rq;   /* of that system, with its switches as modes */
    int events;               /* that were asked for */
    struct traj_modes of;
    struct traj_mode start;
    int *symbol;              /* by surface: what stands for its switch on a slide; -1: there was none yet */
    struct meeting *meetings;
    struct made *first, **last;
    int count;                /* with the start */
};

/* A new name for the switch of a surface. */
static int symbol_of(struct slides *s, int surface)
{
    struct expr_store *st = s->sys->store;
    if (s->symbol[surface] >= 0)
        return s->symbol[surface];
    SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
    sga_buf_printf(&name, "sliding%d", surface + 1);
    while (expr_symbol_find(st, name.data, name.len) >= 0)
        sga_buf_put(&name, "_", 1);
    expr_symbol_add(st, name.data, EXPR_VARIABLE);
    return s->symbol[surface] = expr_symbol_find(st, name.data, name.len);
}

/* By surface what its switch is. */
static void values_of(struct slides *s, const int *choice, expr_id *value)
{
    struct expr_store *st = s->sys->store;
    for (int k = 0; k < s->s.count; k++) {
        int symbol = choice[k] == TRAJ_ALONG ? symbol_of(s, k) : -1;        /* which may move the list of symbols */
        value[k] = choice[k] == TRAJ_AS_WRITTEN ? EXPR_UNDEF : symbol >= 0 ? st->symbol[symbol].node : expr_int(st, choice[k] == TRAJ_ABOVE ? 1 : -1);
        assert(choice[k] == TRAJ_AS_WRITTEN || value[k] || !expr_store_ok(st));
    }
}

/* Replaced, and linear in what slides. */
static void put(struct slides *s, const int *choice, const expr_id *value, expr_id *e, int count)
{
    struct expr_store *st = s->sys->store;
    surfaces_put(&s->s, value, e, count);
    for (int k = 0; k < s->s.count; k++)
        for (int i = 0; choice[k] == TRAJ_ALONG && i < count; i++)
            e[i] = surfaces_chord(st, e[i], s->symbol[k]);
}

/* Whether a coefficient of a derivative has a switch that slides. */
static bool coefficient_slides(struct slides *s, const int *choice, const expr_id *e, int count)
{
    struct expr_cone cone;
    bool any = false;
    expr_cone_init(&cone);
    for (int k = 0; k < s->s.count; k++)
        for (int i = 0; choice[k] == TRAJ_ALONG && i < count && !any; i++)
            any = expr_depends(s->sys->store, &cone, e[i], s->symbol[k]);
    expr_cone_clear(&cone);
    return any;
}

/* The system with these switches into m->sys. False: it is none that slides are defined for. */
static bool make_system(struct slides *s, struct made *m, const int *choice, const expr_id *value)
{
    const struct sys_system *from = s->sys;
    struct expr_store *st = from->store;
    int most = 1;
    bool ok = true;
    sys_copy(&m->sys, from);
    sys_clear_rows(&m->sys);
    for (int i = 0; i < from->rows; i++)
        most = from->row[i].entries > most ? from->row[i].entries : most;
    SGA_FREED expr_id *e = sga_malloc(((size_t)most + 1) * sizeof *e);
    for (int i = 0; i < from->rows; i++) {
        const struct sys_row *r = from->row + i;
        e[0] = r->alpha;
        put(s, choice, value, e, 1);
        int row = sys_add_row(&m->sys, e[0], r->source);
        for (int k = 0; k < r->entries; k++)
            e[k] = r->entry[k].value;
        surfaces_put(&s->s, value, e, r->entries);
        ok = ok && !coefficient_slides(s, choice, e, r->entries);
        for (int k = 0; k < r->entries; k++)
            sys_add_entry(&m->sys, row, r->entry[k].col, e[k]);
    }
    put(s, choice, value, m->sys.restriction, m->sys.restrictions);
    for (int k = 0; k < s->s.count; k++) {
        expr_id g = s->s.function[k];
        if (choice[k] != TRAJ_ALONG)
            continue;
        put(s, choice, value, &g, 1);
        sys_add_variable(&m->sys, s->symbol[k], "switch");
        sys_add_row(&m->sys, g, "surface of a switch");
    }
    assert(!expr_store_ok(st) || m->sys.variables - from->variables == m->sys.rows - from->rows);       /* an equation for each switch that slides */
    return ok && expr_store_ok(st);
}

/* Surfaces, events and columns of a mode in rq; sliding: by surface its variable or -1. */
static void make_lists(struct slides *s, struct traj_request *rq, const int *choice, const expr_id *value, const int *sliding, const struct sys_system *sys, expr_id **surface)
{
    const struct traj_request *own = &s->rq;
    struct expr_store *st = sys->store;
    int surfaces = s->s.count, events = s->of.own;
    expr_id *g = sga_zeros(s->mem, (size_t)surfaces + 1, sizeof *g), one = expr_int(st, 1);
    struct traj_event *event = sga_zeros(s->mem, (size_t)(events + 2 * surfaces) + 1, sizeof *event);
    memcpy(g, s->s.function, (size_t)surfaces * sizeof *g);
    surfaces_put(&s->s, value, g, surfaces);
    for (int e = 0; e < events; e++) {
        event[e] = own->event[e];
        surfaces_put(&s->s, value, &event[e].expression, 1);
        event[e].sided = event[e].expression != own->event[e].expression;
    }
    for (int k = 0; k < surfaces; k++) {
        struct traj_event *low = event + events + 2 * k, *high = low + 1;
        *low = *high = (struct traj_event){ .expression = one, .turns = true };
        low->expression = g[k];
        if (choice[k] != TRAJ_ALONG)
            continue;
        assert(sliding[k] >= s->sys->variables && sliding[k] < sys->variables);
        expr_id lambda = st->symbol[sys->variable[sliding[k]].symbol].node;
        low->expression = expr_sub(st, lambda, one);
        high->expression = expr_add(st, lambda, one);
    }
    int columns = own->outputs ? own->outputs : s->sys->variables;
    expr_id *output = sga_zeros(s->mem, (size_t)columns + 1, sizeof *output);
    for (int k = 0; k < columns; k++)
        output[k] = own->outputs ? own->output[k] : st->symbol[sys->variable[k].symbol].node;
    put(s, choice, value, output, columns);
    rq->event = event;
    rq->events = events + 2 * surfaces;
    rq->output = output;
    rq->outputs = columns;
    *surface = g;
}

/* The request of a mode: columns that were not named are the variables of the start; what is asked of the start is not asked here. */
static void make_request(struct slides *s, struct made *m, const int *choice, const expr_id *value, const int *sliding)
{
    size_t n = (size_t)m->sys.variables, own = (size_t)s->sys->variables;
    double *initial = sga_zeros(s->mem, n + 1, sizeof *initial);
    unsigned char *flag = sga_zeros(s->mem, 2 * n + 2, 1);
    expr_id *surface;
    memcpy(initial, s->rq.initial, own * sizeof *initial);
    memcpy(flag, s->rq.given, own);
    m->rq = s->rq;
    make_lists(s, &m->rq, choice, value, sliding, &m->sys, &surface);
    m->rq.modes = &s->of;
    m->rq.initial = initial;
    m->rq.given = flag;
    m->rq.held = flag + n + 1;
    m->rq.relations = 0;
    m->rq.rate_symbol = NULL;
    m->rq.low = m->rq.high = NULL;
    m->rq.beside = NULL;
    m->rq.exact_start = EXPR_UNDEF;
    m->rq.exact_initial = m->rq.exact_time = NULL;
    m->rq.on = m->reduced && m->oracle.reals && m->oracle.real[0].variables == m->sys.variables ? m->oracle.real[0].x : NULL;
    m->mode.surface = surface;
}

/* What tables are at t; NAN for other parameters. Malloced. */
static double *tables_at(const struct sys_system *sys, double t)
{
    double *value = sga_malloc(((size_t)sys->parameters + 1) * sizeof *value);
    for (int k = 0; k < sys->parameters; k++) {
        const struct expr_symbol *p = sys->store->symbol + sys->parameter[k];
        value[k] = p->table ? expr_table_value(p->table, p->order, t) : NAN;
    }
    return value;
}

/* Reduced near x (of the variables of the start), where there is something to reduce. False: limits. */
static bool reduce(struct slides *s, struct made *m, double t, const double *x, struct sga_error *err)
{
    struct job *j = s->j;
    size_t n = (size_t)m->sys.variables, own = (size_t)s->sys->variables;
    SGA_FREED double *near = sga_calloc(n + 1, sizeof *near);
    SGA_FREED unsigned char *moving = guess_moving(&m->sys);
    SGA_FREED double *tables = tables_at(&m->sys, t);
    struct sga_error why = { 0 };
    memcpy(near, x, own * sizeof *near);
    guess_complete(&m->sys, moving, t, tables, near);
    struct reduction_options options = { .near = near, .near_only = true, .near_given = moving, .near_time = t, .parameter_near = tables, .seed = SGA_SEED_MOTION, .budget = j->budget,
                                         .gauge_fields = true, .gauge_nodes = answer_gauge_nodes(j) };
    points_oracle_init(&m->oracle, 20250103);
    m->reduced = true;
    if (sga_reduce(&m->sys, &options, &m->oracle, &m->sol, &why)) {
        m->mode.sol = m->sol.verdict == SGA_INCONSISTENT ? NULL : &m->sol;
        return true;
    }
    bool none = why.code == SGA_E_NO_REAL_POINT || why.code == SGA_E_IRREGULAR || why.code == SGA_E_UNDECIDED || why.code == SGA_E_SPLIT;
    if (none)
        m->mode.why = "along a surface where a switch jumps, or beyond it, the equations could not be reduced";
    else
        *err = why;
    return none && sga_budget_ok(j->budget, err);
}

static const struct traj_mode *enter(void *ctx, const int *choice, const struct traj_mode *from, double t, const double *x, struct sga_error *err)
{
    struct slides *s = ctx;
    struct expr_store *st = s->sys->store;
    size_t size = (size_t)s->s.count * sizeof *choice;
    (void)from;
    for (struct made *m = s->first; m; m = m->next)
        if (!memcmp(choice, m->mode.choice, size))
            return &m->mode;
    struct made *m = sga_zeros(s->mem, 1, sizeof *m);
    int *own = sga_zeros(s->mem, 2 * (size_t)s->s.count + 2, sizeof *own), *sliding = own + s->s.count + 1, variable = s->sys->variables;
    SGA_FREED expr_id *value = sga_calloc((size_t)s->s.count + 1, sizeof *value);
    memcpy(own, choice, size);
    for (int k = 0; k < s->s.count; k++)
        sliding[k] = choice[k] == TRAJ_ALONG ? variable++ : -1;
    *s->last = m;
    s->last = &m->next;
    m->mode = (struct traj_mode){ .sys = &m->sys, .rq = &m->rq, .choice = own, .sliding = sliding, .place = s->count++ };
    if (variable > s->sys->variables && !s->j->request->trajectory.sliding) {
        m->mode.why = "beyond a surface where a switch jumps the motion may go on along it, which trajectory.sliding allows";
        return &m->mode;
    }
    values_of(s, choice, value);
    bool defined = make_system(s, m, choice, value);
    if (!defined)
        m->mode.why = "the motion would slide along a surface where coefficients of derivatives jump: between both sides they have no value by Filippov's rule";
    bool ok = !defined || reduce(s, m, t, x, err);
    if (ok)
        make_request(s, m, choice, value, sliding);
    if (ok && !expr_store_ok(st)) {
        *err = *st->error;
        ok = false;
    }
    return ok ? &m->mode : NULL;
}

/* Whether it does, of two modes; each pair is looked at once. */
struct meeting { const struct traj_mode *from, *to; int surface; bool meets; struct meeting *next; };

static bool meets(void *ctx, const struct traj_mode *from, const struct traj_mode *to, int surface)
{
    struct slides *s = ctx;
    for (const struct meeting *m = s->meetings; m; m = m->next)
        if (m->from == from && m->to == to && m->surface == surface)
            return m->meets;
    struct meeting *m = sga_zeros(s->mem, 1, sizeof *m);
    struct poly_limits limits = poly_limits_of(POLY_AMPLE, s->j->budget);
    *m = (struct meeting){ from, to, surface, true, s->meetings };
    s->meetings = m;
    int count = from->sol->constraints;
    SGA_FREED expr_id *given = sga_malloc(((size_t)count + 1) * sizeof *given);
    for (int i = 0; i < count; i++)
        given[i] = from->sol->constraint[i].expr;
    given[count] = from->surface[surface];
    for (int i = 0; i < to->sol->constraints && m->meets; i++)
        m->meets = poly_vanishes_with(s->sys->store, to->sol->constraint[i].expr, given, count + 1, &limits);
    return m->meets;
}

/* What the switches of a request stand in besides its system. */
static int list_beside(const struct traj_request *rq, expr_id *list)
{
    int count = 0;
    for (int k = 0; k < rq->outputs; k++)
        list[count++] = rq->output[k];
    for (int k = 0; k < rq->events; k++)
        list[count++] = rq->event[k].expression;
    return count;
}

/* Of this system, from a request of it. */
static bool build(struct slides *s, const struct sys_system *sys, const struct sga_solution *solution, const struct traj_request *rq, struct sga_error *err)
{
    SGA_FREED expr_id *beside = sga_malloc((size_t)(rq->outputs + rq->events + 1) * sizeof *beside);
    s->sys = sys;
    s->rq = *rq;
    s->rq.modes = NULL;
    s->rq.events = s->events;     /* those of surfaces, of another set, come after them */
    s->count = 1;
    s->first = NULL;
    s->meetings = NULL;
    s->last = &s->first;
    const struct surfaces_every every = { solution, rq->on, rq->start, s->j->budget };
    bool sliding = s->j->request->trajectory.sliding;
    surfaces_find(&s->s, sys, beside, sliding ? list_beside(&s->rq, beside) : 0, s->j->slides.in_balls ? &every : NULL, s->mem);
    if (!s->s.count)
        return true;
    if (solution->free_columns)
        return sga_fail_at(err, SGA_E_NOT_SUPPORTED, "/trajectory/sliding", "slides are followed where the equations determine the motion, and here they leave %d variables free; leave sliding out, or "
                           "add equations that choose", solution->free_columns);
    size_t surfaces = (size_t)s->s.count;
    const char **name = sga_zeros(s->mem, surfaces + 1, sizeof *name);
    const double **value = sga_zeros(s->mem, surfaces + 1, sizeof *value);
    int *values = sga_zeros(s->mem, surfaces + 1, sizeof *values), *choice = sga_zeros(s->mem, surfaces + 1, sizeof *choice), *none = sga_zeros(s->mem, surfaces + 1, sizeof *none);
    expr_id *written = sga_zeros(s->mem, surfaces + 1, sizeof *written), *surface;
    s->symbol = sga_zeros(s->mem, surfaces + 1, sizeof *s->symbol);
    for (size_t k = 0; k < surfaces; k++) {
        name[k] = "switch";
        value[k] = SIDE;
        values[k] = 2;
        choice[k] = TRAJ_AS_WRITTEN;
        none[k] = s->symbol[k] = -1;
    }
    s->of = (struct traj_modes){ .modes = (int)surfaces, .name = name, .value = value, .values = values, .start = &s->start, .enter = enter, .meets = meets, .ctx = s, .surfaces = (int)surfaces, .own = s->events };
    struct traj_request asked = s->rq;
    make_lists(s, &s->rq, choice, written, none, sys, &surface);
    s->rq.output = asked.output;
    s->rq.outputs = asked.outputs;
    s->start = (struct traj_mode){ .sys = sys, .sol = solution, .rq = &s->rq, .choice = choice, .surface = surface, .sliding = none };
    s->rq.modes = &s->of;
    return true;
}

/* Modes that were entered, and surfaces. */
static void drop(struct slides *s)
{
    for (struct made *m = s->first; m; m = m->next) {
        if (m->reduced) {
            points_oracle_clear(&m->oracle);
            sga_solution_clear(&m->sol);
        }
        sys_clear(&m->sys);
    }
    surfaces_clear(&s->s);
    s->s = (struct surfaces){ 0 };
    s->first = NULL;
}

bool slides_begin(struct job *j, const struct sga_solution *solution, struct traj_request *rq, struct sga_arena *mem, struct slides **out)
{
    const struct request *q = j->request;
    *out = NULL;
    if (!(q->trajectory.sliding || j->slides.in_balls) || j->place.depth || !(q->want & (REQUEST_TRAJECTORY | REQUEST_FIT)))
        return true;
    struct slides *s = *out = sga_zeros(mem, 1, sizeof *s);
    *s = (struct slides){ .j = j, .mem = mem, .sys = &q->system, .rq = *rq, .events = rq->events };
    if (q->sweeps)                /* each set has its own */
        return true;
    if (!build(s, &q->system, solution, rq, j->err))
        return false;
    *rq = s->rq;
    if (s->s.count)
        s->start.rq = rq;
    return true;
}

const struct traj_request *slides_set(struct slides *s, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err)
{
    assert(s->j->request->sweeps > 0);
    slides_unset(s);
    s->mem = &s->own;
    return build(s, sys, sol, rq, err) ? &s->rq : NULL;
}

void slides_unset(struct slides *s)
{
    drop(s);
    sga_arena_end(&s->own);
}

/* Generations and dimension of the mode in which a slide began. */
static const struct made *made_at(const struct slides *s, int place)
{
    const struct made *m = s->first;
    while (m && m->mode.place != place)
        m = m->next;
    return m;
}

void slides_tell(struct slides *s)
{
    struct job *j = s->j;
    const struct traj_result *r = j->trajectory;
    size_t slides = (size_t)r->slides;
    j->slides.surface = sga_zeros(&j->mem, slides + 1, sizeof *j->slides.surface);
    j->slides.dimension = sga_zeros(&j->mem, 2 * slides + 2, sizeof *j->slides.dimension);
    j->slides.generations = j->slides.dimension + slides + 1;
    for (int i = 0; i < r->slides; i++) {
        const struct made *m = made_at(s, r->slide[i].mode);
        assert(m && m->reduced && r->slide[i].surface < s->s.count);       /* slides are told of modes that were entered */
        char *text = expr_text(s->sys->store, s->s.function[r->slide[i].surface], SURFACE_BYTES);
        j->slides.surface[i] = sga_take_text(&j->mem, text);
        free(text);
        j->slides.dimension[i] = m->sys.variables - m->sol.constraints;
        j->slides.generations[i] = m->sol.generations;
    }
}

void slides_end(struct slides *s, bool ok)
{
    if (!s)
        return;
    if (ok && s->j->trajectory && !s->j->request->sweeps)
        slides_tell(s);
    slides_unset(s);
}
