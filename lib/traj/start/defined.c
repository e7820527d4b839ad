/* Motions of what is left of a system where equations define variables. */
#include "defined.h"
#include "consistent.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "definition.h"
#include "edges.h"
#include "error.h"
#include "facts.h"
#include "field.h"
#include "flow.h"
#include "mem.h"
#include "system.h"
#include "tape.h"

/* Given values are met up to this, relative to 1 + |value|. */
static const double MET = 1e-10;

bool defined_any(const struct sga_solution *sol, const struct traj_request *rq)
{
    for (int i = 0; i < sol->definitions; i++)
        for (int k = 0; k < rq->rates; k++)
            if (rq->rate[k].variable == sol->definition[i].variable)
                return false;
    return sol->definitions > 0;
}

static expr_id put(const struct defined *d, expr_id e)
{
    expr_substitute(d->sys->store, &e, 1, d->map);
    return e;
}

/* What sga/definition.h says of the solution's definitions. */
static void put_in_system(struct defined *d, const struct sga_solution *sol)
{
    const struct sys_system *sys = d->sys;
    struct definition *at = sga_calloc((size_t)sol->definitions + 1, sizeof *at);
    int rows = 0, variables = 0, *row = sga_malloc(((size_t)sys->rows + 1) * sizeof *row);
    unsigned char *gone = sga_calloc((size_t)sys->rows + 1, 1);
    d->place = sga_calloc((size_t)sys->variables + 1, sizeof *d->place);
    d->variable = sga_malloc(((size_t)sys->variables + 1) * sizeof *d->variable);
    d->map = sga_calloc((size_t)sys->store->symbols + 1, sizeof *d->map);
    for (int i = 0; i < sol->definitions; i++) {
        const struct sga_definition *f = sol->definition + i;
        at[i] = (struct definition){ .variable = f->variable, .row = f->row, .value = f->value };
        d->map[sys->variable[f->variable].symbol] = f->value;
        d->place[f->variable] = -1;
        gone[f->row] = 1;
    }
    for (int j = 0; j < sys->variables; j++)
        if (!d->place[j]) {
            d->place[j] = variables;
            d->variable[variables++] = j;
        }
    for (int i = 0; i < sys->rows; i++)
        if (!gone[i])
            row[rows++] = i;
    assert(variables + sol->definitions == sys->variables && rows + sol->definitions == sys->rows);      /* each has a variable and a row of its own */
    struct definitions all = { .at = at, .count = sol->definitions, .variable = d->variable, .row = row };
    definitions_put_in(&all, sys, &d->system);
    free(at);
    free(row);
    free(gone);
}

/* Copies of what a motion looks at, without the definitions, which are the first constraints. */
static void put_in_solution(struct defined *d, const struct sga_solution *from)
{
    struct sga_solution *to = &d->solution;
    int k = from->definitions, n = d->sys->variables, left = n - k;
    *to = *from;
    to->definition = NULL;
    to->definitions = 0;
    assert(from->constraints >= k);
    to->constraints = from->constraints - k;
    to->constraint = sga_malloc(((size_t)to->constraints + 1) * sizeof *to->constraint);
    for (int i = 0; i < to->constraints; i++) {
        to->constraint[i] = from->constraint[k + i];
        to->constraint[i].expr = put(d, from->constraint[k + i].expr);
    }
    to->field = sga_malloc(((size_t)left + 1) * sizeof *to->field);
    for (int j = 0; j < left; j++)
        to->field[j] = put(d, from->field[d->variable[j]]);
    to->pivot = sga_malloc(((size_t)from->pivots + 1) * sizeof *to->pivot);
    to->pivots = 0;
    for (int q = 0; q < from->pivots; q++) {
        struct sga_pivot p = from->pivot[q];
        if (p.col >= 0 && d->place[p.col] < 0)
            continue;
        p.col = p.col < 0 ? -1 : d->place[p.col];
        p.value = put(d, p.value);
        to->pivot[to->pivots++] = p;
    }
    to->free_column = sga_malloc(((size_t)from->free_columns + 1) * sizeof *to->free_column);
    for (int i = 0; i < from->free_columns; i++) {
        to->free_column[i] = d->place[from->free_column[i]];
        assert(to->free_column[i] >= 0);       /* what is defined is not free */
    }
    to->gauge = from->gauge ? sga_malloc(((size_t)from->free_columns * (size_t)left + 1) * sizeof *to->gauge) : NULL;
    for (int i = 0; i < from->free_columns && to->gauge; i++)
        for (int j = 0; j < left; j++)
            to->gauge[(size_t)i * (size_t)left + (size_t)j] = put(d, from->gauge[(size_t)i * (size_t)n + (size_t)d->variable[j]]);
    to->scale = NULL;
}

static expr_id *put_list(const struct defined *d, const expr_id *from, int count)
{
    expr_id *to = sga_malloc(((size_t)count + 1) * sizeof *to);
    for (int i = 0; i < count; i++)
        to[i] = put(d, from[i]);
    return to;
}

/* Whether e divides by what may be 0, or is such a function. */
static bool divides(const struct expr_store *st, struct expr_facts *facts, expr_id e)
{
    expr_id divisor = expr_divisor(st, e);
    return expr_op_of(st, e) == EXPR_TAN || (divisor && !(expr_facts_of(facts, st, divisor) & EXPR_NONZERO));
}

/* Whether e has no value in places that a motion may come to. */
static bool has_domain(const struct expr_store *st, expr_id e)
{
    struct expr_cone cone;
    struct expr_facts facts;
    bool has = false;
    expr_cone_init(&cone);
    expr_facts_init(&facts);
    expr_cone_of(st, &cone, &e, 1);
    for (int k = 0; k < cone.count && !has; k++)
        has = expr_op_traits(expr_op_of(st, cone.list[k])) & EXPR_HAS_END || divides(st, &facts, cone.list[k]);
    expr_cone_clear(&cone);
    expr_facts_clear(&facts);
    return has;
}

/* Whether small errors may become large ones in e. */
static bool has_root(const struct expr_store *st, expr_id e)
{
    struct expr_cone cone;
    struct expr_facts facts;
    bool has = false;
    expr_cone_init(&cone);
    expr_facts_init(&facts);
    expr_cone_of(st, &cone, &e, 1);
    for (int k = 0; k < cone.count && !has; k++) {
        has = expr_op_traits(expr_op_of(st, cone.list[k])) & EXPR_IS_STEEP && !(expr_facts_of(&facts, st, st->node[cone.list[k]].a) & EXPR_NONZERO)
              && expr_facts_of(&facts, st, st->node[cone.list[k]].a) & EXPR_HAS_VARIABLE;
    }
    expr_facts_clear(&facts);
    expr_cone_clear(&cone);
    return has;
}

static void put_in_request(struct defined *d, const struct traj_request *from)
{
    struct traj_request *to = &d->request;
    int n = d->sys->variables, left = d->system.variables;
    *to = *from;
    d->initial = sga_calloc((size_t)left + 1, sizeof *d->initial);
    d->given = sga_calloc((size_t)left + 1, 1);
    d->held = sga_calloc((size_t)left + 1, 1);
    d->exact = sga_calloc((size_t)left + 1, sizeof *d->exact);
    d->on = sga_calloc((size_t)left + 1, sizeof *d->on);
    for (int j = 0; j < left; j++) {
        int v = d->variable[j];
        d->initial[j] = from->initial[v];
        d->given[j] = from->given[v];
        d->on[j] = from->on ? from->on[v] : 0;
        d->held[j] = from->held ? from->held[v] : 0;
        d->exact[j] = from->exact_initial ? from->exact_initial[v] : EXPR_UNDEF;
    }
    d->rate = sga_malloc(((size_t)from->rates + 1) * sizeof *d->rate);
    for (int k = 0; k < from->rates; k++)
        d->rate[k] = (struct traj_rate){ d->place[from->rate[k].variable], put(d, from->rate[k].rate) };
    d->event = sga_malloc(((size_t)from->events + 1) * sizeof *d->event);
    for (int k = 0; k < from->events; k++) {
        d->event[k] = from->event[k];
        d->event[k].expression = put(d, from->event[k].expression);
    }
    d->integral = put_list(d, from->integral, from->integrals);
    d->output = sga_malloc(((size_t)(from->outputs ? from->outputs : n) + 1) * sizeof *d->output);
    to->outputs = from->outputs ? from->outputs : n;
    d->beside = sga_calloc((size_t)to->outputs + 1, 1);
    for (int i = 0; i < to->outputs; i++)
        d->output[i] = put(d, from->outputs ? from->output[i] : d->sys->store->symbol[d->sys->variable[i].symbol].node);
    to->initial = d->initial;
    to->given = d->given;
    to->on = from->on ? d->on : NULL;
    to->held = from->held ? d->held : NULL;
    for (int i = 0; i < to->outputs; i++)
        d->beside[i] = has_root(d->sys->store, d->output[i]);
    to->beside = d->beside;
    d->valued = sga_malloc(((size_t)d->sol->definitions + 1) * sizeof *d->valued);
    to->valueds = 0;
    for (int i = 0; i < d->sol->definitions; i++)
        if (has_domain(d->sys->store, d->sol->definition[i].value))
            d->valued[to->valueds++] = d->sol->definition[i].value;
    to->valued = d->valued;
    to->rate = d->rate;
    to->event = d->event;
    to->integral = d->integral;
    to->output = d->output;
    to->exact_initial = from->exact_initial ? d->exact : NULL;
}

void defined_init(struct defined *d, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    *d = (struct defined){ .sys = sys, .sol = sol, .rq = rq, .moved = -1 };
    put_in_system(d, sol);
    put_in_solution(d, sol);
    put_in_request(d, rq);
}

void defined_clear(struct defined *d)
{
    sys_clear(&d->system);
    free(d->solution.constraint);
    free(d->solution.field);
    free(d->solution.pivot);
    free(d->solution.free_column);
    free(d->solution.gauge);
    free(d->place);
    free(d->variable);
    free(d->initial);
    free(d->given);
    free(d->on);
    free(d->held);
    free(d->rate);
    free(d->event);
    free(d->beside);
    free(d->output);
    free(d->integral);
    free(d->exact);
    free(d->map);
    free(d->valued);
}

/* Values of expressions at a point of what is left. Where one has none it is NAN or infinite. */
static void values(const struct defined *d, const expr_id *root, int roots, const double *x, double *value)
{
    int n = d->system.variables, *inputs = field_inputs(&d->system);
    double *in = sga_malloc(((size_t)n + 1) * sizeof *in);
    struct sga_error ignored = { 0 };
    struct num_tape *tape = num_tape_new(d->sys->store, root, roots, inputs, n + 1, &ignored);
    memcpy(in, x, (size_t)n * sizeof *in);
    in[n] = d->rq->start;
    for (int i = 0; i < roots && !tape; i++)
        value[i] = NAN;
    if (tape)
        num_tape_eval(tape, in, value);
    num_tape_free(tape);
    free(in);
    free(inputs);
}

double *defined_lift(const struct defined *d, double *x)
{
    int k = d->sol->definitions;
    double *whole = sga_calloc((size_t)d->sys->variables + 1, sizeof *whole), *value = sga_calloc((size_t)k + 1, sizeof *value);
    expr_id *root = sga_malloc(((size_t)k + 1) * sizeof *root);
    for (int i = 0; i < k; i++)
        root[i] = d->sol->definition[i].value;
    values(d, root, k, x, value);
    for (int j = 0; j < d->system.variables; j++)
        whole[d->variable[j]] = x[j];
    for (int i = 0; i < k; i++)
        whole[d->sol->definition[i].variable] = value[i];
    free(x);
    free(value);
    free(root);
    return whole;
}

static bool asked(const struct defined *d, int v)
{
    return d->rq->given[v] || (d->rq->held && d->rq->held[v]);
}

/* Whether what is defined has values at the start of what is left, those that are given. */
static bool fits(const struct defined *d, struct sga_error *ignored)
{
    struct flow f;
    int n = d->system.variables;
    double moved, *x = sga_calloc((size_t)n + 1, sizeof *x);
    bool ok = flow_init(&f, &d->system, &d->solution, &d->request, ignored)
              && flow_start(&f, &d->system, &d->solution, &d->request, x, &moved, ignored);
    flow_clear(&f);
    x = defined_lift(d, x);
    for (int i = 0; i < d->sol->definitions && ok; i++) {
        int v = d->sol->definition[i].variable;
        ok = isfinite(x[v]) && (!asked(d, v) || fabs(x[v] - d->rq->initial[v]) <= MET * (1 + fabs(x[v])));
    }
    free(x);
    return ok;
}

/* From the start of the whole. */
static bool start_of_whole(struct defined *d, struct sga_error *err)
{
    struct flow f;
    double moved, *x = sga_calloc((size_t)d->sys->variables + 1, sizeof *x);
    bool ok = flow_init(&f, d->sys, d->sol, d->rq, err) && flow_start(&f, d->sys, d->sol, d->rq, x, &moved, err);
    flow_clear(&f);
    for (int j = 0; j < d->system.variables && ok; j++) {
        double value = x[d->variable[j]];
        d->exact[j] = value == d->initial[j] ? d->exact[j] : EXPR_UNDEF;
        d->initial[j] = value;
    }
    if (ok)
        d->moved = moved;
    free(x);
    return ok;
}

bool defined_start(struct defined *d, struct sga_error *err)
{
    bool any = false, held = false;
    struct sga_error ignored = { 0 };
    for (int i = 0; i < d->sol->definitions; i++) {
        int v = d->sol->definition[i].variable;
        any |= asked(d, v);
        held |= d->rq->held && d->rq->held[v];
    }
    if ((!any && !d->request.valueds) || fits(d, &ignored))
        return true;
    bool ok = any && start_of_whole(d, held ? err : &ignored);
    return edges_start(d, ok ? d->moved : INFINITY) || ok || !held;
}

bool defined_in_doubles(const struct defined *d, const double *x, struct sga_error *err)
{
    bool in = true;
    for (int i = 0; i < d->sol->definitions && in; i++)
        in = !isinf(x[d->sol->definition[i].variable]);
    return in || consistent_too_large(err);
}

double defined_moved(const struct defined *d, const double *x, double moved)
{
    if (d->moved >= 0)
        return d->moved;
    double sum = moved * moved;
    for (int i = 0; i < d->sol->definitions; i++) {
        int v = d->sol->definition[i].variable;
        double far = d->rq->given[v] ? x[v] - d->rq->initial[v] : 0;
        sum += fabs(far) <= MET * (1 + fabs(x[v])) ? 0 : far * far;
    }
    return sqrt(sum);
}

bool defined_initial(const struct defined *d, struct traj_initial *r, struct sga_error *err)
{
    int k = d->sol->definitions, left = d->system.variables, c = d->solution.constraints;
    double *rate = sga_calloc((size_t)d->sys->variables + 1, sizeof *rate), *residual = sga_calloc((size_t)(k + c) + 1, sizeof *residual);
    double *along = sga_calloc((size_t)k + 1, sizeof *along);
    expr_id *root = sga_malloc(((size_t)k + 1) * sizeof *root);
    for (int i = 0; i < k; i++)
        root[i] = put(d, d->sol->field[d->sol->definition[i].variable]);
    values(d, root, k, r->x, along);
    for (int j = 0; j < left; j++)
        rate[d->variable[j]] = r->derivative[j];
    for (int i = 0; i < k; i++)
        rate[d->sol->definition[i].variable] = along[i];
    memcpy(residual + k, r->residual, (size_t)c * sizeof *residual);
    for (int i = 0; i < r->frees; i++)
        r->free[i] = d->variable[r->free[i]];
    r->x = defined_lift(d, r->x);
    r->moved = defined_moved(d, r->x, r->moved);
    free(r->derivative);
    free(r->residual);
    free(along);
    free(root);
    r->derivative = rate;
    r->residual = residual;
    return expr_store_ok(d->sys->store) ? defined_in_doubles(d, r->x, err) : (*err = *d->sys->store->error, false);
}
