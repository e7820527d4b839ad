/* One set of a sweep of parameters: the general answer at numbers, and whether it holds there. */
#include "sweep_case.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "differentials.h"
#include "error.h"
#include "facts.h"
#include "run_job.h"
#include "mem.h"
#include "poly.h"
#include "request.h"
#include "seeds.h"
#include "set_points.h"
#include "sparse.h"
#include "table.h"

/* Balls around a point of the final set have this relative radius; beside it the differentials are told to be independent. */
static const double AROUND = 1e-8, INDEPENDENT = 1e-6;

/* A list of expressions, appended to all others; what it was copied from stays. */
struct roots {
    expr_id *node;
    size_t cap;
    int count;
};

static int append(struct roots *r, const expr_id *from, int n)
{
    int first = r->count;
    SGA_RESERVE(r->node, r->cap, first + n);
    if (n)
        memcpy(r->node + first, from, (size_t)n * sizeof *from);
    r->count += n;
    return first;
}

static int append_one(struct roots *r, expr_id e)
{
    return append(r, &e, 1);
}

/* How many expressions struct traj_slopes has: of events, of what they set, of masses. */
static void slopes_count(const struct traj_request *q, int count[3])
{
    int sets = 0, d = q->slopes->directions;
    for (int i = 0; i < q->events; i++)
        sets += q->event[i].sets;
    count[0] = q->events * d;
    count[1] = sets * d;
    count[2] = q->mass ? q->mass->entries * d : 0;
}

static void gather_slopes(struct roots *r, const struct traj_request *q)
{
    int count[3];
    if (!q->slopes)
        return;
    slopes_count(q, count);
    append(r, q->slopes->event, count[0]);
    append(r, q->slopes->set, count[1]);
    append(r, q->slopes->mass, count[2]);
}

/* Everything that the request asks of the system, in this order. */
static void gather_system(struct roots *r, const struct sys_system *s, const struct traj_request *q)
{
    for (int i = 0; i < s->rows; i++) {
        append_one(r, s->row[i].alpha);
        for (int k = 0; k < s->row[i].entries; k++)
            append_one(r, s->row[i].entry[k].value);
    }
    append(r, s->restriction, s->restrictions);
    append(r, q->output, q->outputs);
    append(r, q->integral, q->integrals);
    for (int i = 0; i < q->events; i++) {
        append_one(r, q->event[i].expression);
        for (int k = 0; k < q->event[i].sets; k++)
            append_one(r, q->event[i].set[k].value);
    }
    append(r, q->mass ? q->mass->value : NULL, q->mass ? q->mass->entries : 0);
    for (int i = 0; i < q->rates; i++)
        append_one(r, q->rate[i].rate);
    for (int i = 0; i < q->relations; i++)
        append_one(r, q->relation[i].value);
    append_one(r, q->exact_start);
    append(r, q->exact_initial, q->exact_initial ? s->variables : 0);
    append(r, q->exact_time, q->exact_time ? q->samples : 0);
    append(r, q->valued, q->valueds);
    if (q->turns) {
        append(r, q->turns->surface, q->turns->surfaces);
        append(r, q->turns->slope, q->turns->surfaces * q->turns->directions);
        append(r, q->turns->rate, q->turns->surfaces);
    }
    gather_slopes(r, q);
}

static void gather_solution(struct roots *r, const struct sga_solution *s, int n)
{
    for (int i = 0; i < s->constraints; i++)
        append_one(r, s->constraint[i].expr);
    append(r, s->field, n);
    append(r, s->gauge, s->gauge ? s->free_columns * n : 0);
    for (int i = 0; i < s->pivots; i++)
        append_one(r, s->pivot[i].value);
    for (int i = 0; i < s->sides; i++)
        append_one(r, s->side[i].function);
    for (int i = 0; i < s->dense_blocks; i++)
        append_one(r, s->determinant[i].value);
    for (int i = 0; i < s->definitions; i++)
        append_one(r, s->definition[i].value);
}

static void *duplicate(const void *from, int count, size_t size)
{
    void *to = sga_malloc(((size_t)count + 1) * size);
    if (count)
        memcpy(to, from, (size_t)count * size);
    return to;
}

/* The copies of events, what they set, and masses. */
static const expr_id *place_events(struct sweep_case *c, const struct traj_request *q, const expr_id *e)
{
    struct traj_event *event = duplicate(q->event, q->events, sizeof *event);
    int sets = 0;
    for (int i = 0; i < q->events; i++)
        sets += q->event[i].sets;
    c->set = sga_calloc((size_t)sets + 1, sizeof *c->set);
    c->request.event = event;
    for (int i = sets = 0; i < q->events; i++) {
        event[i].expression = *e++;
        event[i].set = c->set + sets;
        for (int k = 0; k < event[i].sets; k++)
            c->set[sets++] = (struct traj_set){ q->event[i].set[k].variable, *e++ };
    }
    if (!q->mass)
        return e;
    c->mass = *q->mass;
    c->mass.value = e;
    c->request.mass = &c->mass;
    return e + q->mass->entries;
}

static const expr_id *place_slopes(struct sweep_case *c, const struct traj_request *q, const expr_id *e)
{
    int count[3];
    if (!q->slopes)
        return e;
    slopes_count(q, count);
    c->slopes = *q->slopes;
    c->slopes.event = e;
    c->slopes.set = e + count[0];
    c->slopes.mass = e + count[0] + count[1];
    c->request.slopes = &c->slopes;
    return c->slopes.mass + count[2];
}

static const expr_id *place_turns(struct sweep_case *c, const struct traj_request *q, const expr_id *e)
{
    if (!q->turns)
        return e;
    c->turns = *q->turns;
    c->turns.surface = e;
    c->turns.slope = e += q->turns->surfaces;
    c->request.turns = &c->turns;
    c->turns.rate = e += q->turns->surfaces * q->turns->directions;
    return e + q->turns->surfaces;
}

/* Takes the copies, in the order in which they were gathered. */
static const expr_id *place_system(struct sweep_case *c, const struct sys_system *s, const struct traj_request *q, const expr_id *e)
{
    assert(c->system.variables == s->variables || !c->system.variables);
    struct sys_system *to = &c->system;
    sys_init(to, &c->store);
    to->time = s->time;
    to->square = s->square;
    for (int i = 0; i < s->variables; i++)
        sys_add_variable(to, s->variable[i].symbol, s->variable[i].role);
    for (int i = 0; i < s->parameters; i++)
        if (s->store->symbol[s->parameter[i]].kind == EXPR_SIGNAL)
            sys_add_parameter(to, s->parameter[i]);
    for (int i = 0; i < s->signals; i++)
        sys_add_signal(to, s->signal[i]);
    for (int i = 0; i < s->rows; i++) {
        int row = sys_add_row(to, *e++, s->row[i].source);
        for (int k = 0; k < s->row[i].entries; k++)
            sys_add_entry(to, row, s->row[i].entry[k].col, *e++);
    }
    for (int i = 0; i < s->restrictions; i++)
        sys_add_restriction(to, *e++);
    c->request = *q;
    c->request.output = e;
    e += q->outputs;
    c->request.integral = e;
    e += q->integrals;
    e = place_events(c, q, e);
    struct traj_rate *rate = duplicate(q->rate, q->rates, sizeof *rate);
    for (int i = 0; i < q->rates; i++)
        rate[i].rate = *e++;
    c->request.rate = rate;
    struct traj_relation *relation = duplicate(q->relation, q->relations, sizeof *relation);
    for (int i = 0; i < q->relations; i++)
        relation[i].value = *e++;
    c->request.relation = relation;
    c->request.exact_start = *e++;
    c->request.exact_initial = q->exact_initial ? e : NULL;
    e += q->exact_initial ? s->variables : 0;
    c->request.exact_time = q->exact_time ? e : NULL;
    e += q->exact_time ? q->samples : 0;
    c->request.valued = e;
    return place_slopes(c, q, place_turns(c, q, e + q->valueds));
}

static const expr_id *place_solution(struct sweep_case *c, const struct sga_solution *s, int n, const expr_id *e)
{
    struct sga_solution *to = &c->solution;
    *to = *s;
    to->constraint = duplicate(s->constraint, s->constraints, sizeof *to->constraint);
    to->pivot = duplicate(s->pivot, s->pivots, sizeof *to->pivot);
    to->side = duplicate(s->side, s->sides, sizeof *to->side);
    to->determinant = duplicate(s->determinant, s->dense_blocks, sizeof *to->determinant);
    for (int i = 0; i < s->constraints; i++)
        to->constraint[i].expr = *e++;
    to->field = duplicate(e, n, sizeof *e);
    e += n;
    to->gauge = s->gauge ? duplicate(e, s->free_columns * n, sizeof *e) : NULL;
    e += s->gauge ? s->free_columns * n : 0;
    for (int i = 0; i < s->pivots; i++)
        to->pivot[i].value = *e++;
    for (int i = 0; i < s->sides; i++)
        to->side[i].function = *e++;
    for (int i = 0; i < s->dense_blocks; i++)
        to->determinant[i].value = *e++;
    to->definition = duplicate(s->definition, s->definitions, sizeof *to->definition);
    for (int i = 0; i < s->definitions; i++)
        to->definition[i].value = *e++;
    return e;
}

static bool all_defined(const expr_id *e, int from, int to, const expr_id *before)
{
    for (int i = from; i < to; i++)
        if (!e[i] && before[i])
            return false;
    return true;
}

bool sweep_case_make(struct sweep_case *c, struct job *j, const struct sga_solution *solution, const struct traj_request *request,
                     const struct request_sweep *set, struct sga_error *err)
{
    return sweep_case_of(c, j->request, &j->request->system, solution, request, set->parameter, err);
}

bool sweep_case_of(struct sweep_case *c, const struct request *of, const struct sys_system *s, const struct sga_solution *solution, const struct traj_request *request,
                   const expr_id *parameter, struct sga_error *err)
{
    const struct expr_store *from = s->store;
    bool has = solution->verdict != SGA_INCONSISTENT;
    *c = (struct sweep_case){ .solved = has };
    expr_store_init(&c->store);
    c->store.max_nodes = from->max_nodes;
    c->store.max_bits = from->max_bits;
    c->store.deadline = from->deadline;
    c->store.seconds = from->seconds;
    expr_copy_symbols(&c->store, from);
    SGA_ARENA(mem);
    expr_id *map = sga_zeros(&mem, (size_t)from->symbols + 1, sizeof *map), *value = duplicate(parameter, of->swept_count, sizeof *value);
    expr_copy(&c->store, from, value, of->swept_count, map);
    for (int i = 0; i < of->swept_count; i++)
        map[of->swept[i].symbol] = value[i];
    struct roots all = { 0 };
    gather_system(&all, s, request);
    int systems = all.count;
    if (has)
        gather_solution(&all, solution, s->variables);
    c->node = duplicate(all.node, all.count, sizeof *c->node);
    expr_copy(&c->store, from, c->node, systems, map);
    bool ok = expr_store_ok(&c->store) && all_defined(c->node, 0, systems, all.node);
    if (!ok)
        sga_fail(err, c->store.error->code == SGA_E_OK ? SGA_E_EXPR_UNDEFINED : c->store.error->code,
                 "an expression of the system has no value at these parameters%s%s", c->store.error->code == SGA_E_OK ? "" : ": ",
                 c->store.error->detail);
    if (ok && has) {
        expr_copy(&c->store, from, c->node + systems, all.count - systems, map);
        c->solved = expr_store_ok(&c->store) && all_defined(c->node, systems, all.count, all.node);
        *c->store.error = (struct sga_error){ 0 };
    }
    const expr_id *end = ok ? place_system(c, s, request, c->node) : NULL;
    assert(!ok || end == c->node + systems);       /* all that was gathered, in the same order */
    end = ok && c->solved ? place_solution(c, solution, s->variables, c->node + systems) : NULL;
    assert(!end || end == c->node + all.count);
    free(all.node);
    free(value);
    return ok;
}

void sweep_case_clear(struct sweep_case *c)
{
    if (c->solved) {
        free(c->solution.constraint);
        free(c->solution.pivot);
        free(c->solution.side);
        free(c->solution.determinant);
        free(c->solution.definition);
        free(c->solution.field);
        free(c->solution.gauge);
    }
    if (c->has_own) {
        points_oracle_clear(&c->oracle);
        sga_solution_clear(&c->own);
    }
    free((struct traj_event *)c->request.event);
    free(c->set);
    free((struct traj_rate *)c->request.rate);
    free((struct traj_relation *)c->request.relation);
    free(c->node);
    sys_clear(&c->system);
    expr_store_clear(&c->store);
    *c = (struct sweep_case){ 0 };
}

/* Balls at x, time, and what the tables are there. */
static void set_around(const struct sweep_case *c, const double *x, struct num_ball *b)
{
    const struct sys_system *s = &c->system;
    arb_t v;
    arb_init(v);
    for (int i = 0; i < s->variables; i++) {
        arb_set_d(v, x[i]);
        mag_set_d(arb_radref(v), AROUND * (1 + fabs(x[i])));
        num_ball_set(b, s->variable[i].symbol, v);
    }
    num_ball_set_d(b, s->time, c->request.start);
    for (int i = 0; i < s->parameters; i++) {
        const struct expr_symbol *u = s->store->symbol + s->parameter[i];
        num_ball_set_d(b, s->parameter[i], expr_table_value(u->table, u->order, c->request.start));
    }
    arb_clear(v);
}

/* Every value excludes 0. */
static bool all_nonzero(struct num_ball *b, const expr_id *e, int n)
{
    struct expr_cone cone;
    bool ok = true;
    expr_cone_init(&cone);
    expr_cone_of(b->st, &cone, e, n);
    num_ball_list(b, cone.list, cone.count);
    for (int i = 0; i < n && ok; i++)
        ok = arb_is_finite(num_ball_value(b, e[i])) && !arb_contains_zero(num_ball_value(b, e[i]));
    expr_cone_clear(&cone);
    return ok;
}

static bool independent(struct sweep_case *c, struct num_ball *b)
{
    int n = c->system.variables, count = c->solution.constraints;
    struct set_points on;
    struct points_jacobian jac;
    set_points_init(&on, &c->system, &c->solution, count, 0, 0);
    points_jacobian_init(&jac, &on.space);
    points_jacobian_values(&jac, b);
    points_jacobian_entries(&jac, b);
    struct points_row *row = sga_calloc((size_t)count + 1, sizeof *row);
    bool ok = true;
    for (int i = 0; i < count; i++) {
        double big = 0;
        bool some = false;
        row[i].len = row[i].cap = jac.cols[i];
        row[i].col = sga_malloc((size_t)(jac.cols[i] + 1) * sizeof(int));
        row[i].val = sga_malloc((size_t)(jac.cols[i] + 1) * sizeof(double));
        for (int k = 0; k < jac.cols[i]; k++) {
            arb_srcptr v = jac.entry[i] + k;
            row[i].col[k] = jac.col[i][k];
            row[i].val[k] = arf_get_d(arb_midref(v), ARF_RND_NEAR);
            ok = ok && arb_is_finite(v);
            some = some || !arb_contains_zero(v);
            big = fmax(big, fabs(row[i].val[k]));
        }
        for (int k = 0; k < jac.cols[i] && big > 0; k++)
            row[i].val[k] /= big;
        ok = ok && some;
    }
    struct points_lu lu;
    points_lu_factor(&lu, row, count, n, INDEPENDENT);
    ok = ok && lu.rank == count;
    points_lu_clear(&lu);
    points_jacobian_clear(&jac);
    set_points_clear(&on);
    return ok;
}

static bool is_product(struct expr_store *st, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_GLANCE, NULL);
    struct poly_factors q;
    int moving = 0;
    if (poly_shown_irreducible(st, e, NULL) || !poly_numerator_factors(st, e, &limits, &q))
        return false;
    for (int k = 0; k < q.factors; k++)
        moving += !q.factor[k].never_zero && q.factor[k].depends & EXPR_HAS_VARIABLE;
    poly_factors_clear(&q);
    return moving >= 2;
}

/* Some constraint is a product at these parameters: then a start may choose among the branches. */
static bool splits(const struct sweep_case *c, const unsigned char *single)
{
    bool found = false;
    for (int i = 0; i < c->solution.constraints && !found; i++)
        found = !(single && single[i]) && is_product(c->system.store, c->solution.constraint[i].expr);
    return found;
}

unsigned char *sweep_case_single(struct expr_store *st, const struct sga_solution *s)
{
    unsigned char *single = sga_calloc((size_t)s->constraints + 1, 1);
    struct expr_facts facts;
    expr_facts_init(&facts);
    for (int i = 0; i < s->constraints; i++)
        single[i] = !(expr_facts_of(&facts, st, s->constraint[i].expr) & EXPR_HAS_PARAMETER) && !is_product(st, s->constraint[i].expr);
    expr_facts_clear(&facts);
    return single;
}

bool sweep_case_holds(struct sweep_case *c, const double *x, const unsigned char *single)
{
    const struct sga_solution *s = &c->solution;
    /* what was divided by on a larger set is not looked at there; at special places another system was solved */
    if (s->deads || s->specials || splits(c, single))
        return false;
    struct num_ball b;
    struct roots all = { 0 };
    for (int i = 0; i < s->pivots; i++)
        append_one(&all, s->pivot[i].value);
    for (int i = 0; i < s->sides; i++)
        append_one(&all, s->side[i].function);
    for (int i = 0; i < s->dense_blocks; i++)
        append_one(&all, s->determinant[i].value);
    num_ball_init(&b, &c->store, 100);
    set_around(c, x, &b);
    bool ok = all_nonzero(&b, all.node, all.count) && independent(c, &b);
    for (int i = 0; i < s->sides && ok; i++)
        ok = (arb_is_positive(num_ball_value(&b, s->side[i].function)) != 0) == (s->side[i].sign > 0);
    num_ball_clear(&b);
    free(all.node);
    return ok;
}

bool sweep_case_solve(struct sweep_case *c, struct job *j, const struct traj_request *start, struct sga_error *err)
{
    if (j->primary || j->mechanical || j->op)
        return sga_fail(err, SGA_E_NOT_SUPPORTED, "at these parameters the analysis for general ones does not hold, and this form is "
                        "prepared for general ones; send these values as a request of their own");
    struct reduction_options options = { .near = start->initial, .near_given = start->given, .near_time = c->request.start, .parameter_near = j->start.parameter, .seed = SGA_SEED_REDUCTION,
                                   .budget = j->budget, .gauge_fields = true, .gauge_nodes = answer_gauge_nodes(j) };
    assert(c->system.parameters <= j->request->system.parameters);
    if (j->start.parameter)       /* those of the tables come last */
        options.parameter_near += j->request->system.parameters - c->system.parameters;
    points_oracle_init(&c->oracle, 20250101);
    c->has_own = true;
    if (!sga_reduce(&c->system, &options, &c->oracle, &c->own, err))
        return false;
    return c->own.verdict != SGA_INCONSISTENT
           || sga_fail(err, SGA_E_NO_MOTION, "the system is inconsistent in this set: %.500s", c->own.contradiction_why);
}
