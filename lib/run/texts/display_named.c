/* Parameters by name: the reduction once more, with them left symbolic, as a source of texts. Nothing is decided by it. */
#include "display.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "error.h"
#include "mem.h"
#include "oracle.h"
#include "poly.h"
#include "reduce.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "stage_clock.h"
#include "system.h"

/* Larger systems are shown with numbers: the second reduction should cost no more than is gained. */
enum { MOST_VARIABLES = 60, MOST_NODES = 200000 };
/* Seconds that it may take: so many, and so many times those of the first; but of the time that is left no more than this part. */
static const double LEAST_SECONDS = 0.5, TIMES = 3, PART_OF_LEFT = 0.25;

static struct sga_budget own_budget(const struct job *j)
{
    struct sga_budget b = *j->budget;
    double now = sga_now(), seconds = LEAST_SECONDS + TIMES * j->clock->seconds[STAGE_REDUCTION];
    if (b.deadline)
        seconds = fmin(seconds, PART_OF_LEFT * (b.deadline - now));
    b.deadline = now + fmax(seconds, 0);
    b.warnings = NULL;
    return b;
}

/* Values near which points are drawn: those given. */
static double *values_near(const struct job *j, const struct sys_system *named, struct sga_arena *mem)
{
    double *near = sga_take(mem, (size_t)(named->parameters + 1) * sizeof *near);
    for (int i = 0; i < named->parameters; i++) {
        const char *name = named->store->symbol[named->parameter[i]].name;
        near[i] = NAN;
        for (int k = 0; k < j->request->knowns; k++) {
            const struct request_known *known = j->request->known + k;
            if (strcmp(j->request->store.symbol[known->symbol].name, name) == 0 && expr_is_const(&j->request->store, known->value))
                near[i] = fmpq_get_d(expr_const_value(&j->request->store, known->value));
        }
    }
    return near;
}

static bool same_variables(const struct job *j, const struct job *n)
{
    const struct sys_system *a = &j->request->system, *b = &n->request->system;
    if (a->variables != b->variables)
        return false;
    for (int i = 0; i < a->variables; i++)
        if (strcmp(answer_variable_name(j, i), answer_variable_name(n, i)) != 0)
            return false;
    return true;
}

/* The same dimensions, generation by generation. */
static bool same_shape(const struct sga_solution *a, const struct sga_solution *b)
{
    bool same = a->verdict == b->verdict && a->constraints == b->constraints && a->generations == b->generations
                && a->free_columns == b->free_columns && !a->specials && !b->specials && !a->field == !b->field && !a->gauge == !b->gauge;
    for (int k = 0; k < a->generations && same; k++)
        same = a->dimension[k] == b->dimension[k];
    return same;
}

/* By symbol of the other store: the display's symbol of that name. False: there is none. */
static expr_id *by_symbol(const struct display *d, const struct expr_store *from)
{
    expr_id *map = sga_calloc((size_t)from->symbols + 1, sizeof *map);
    for (int i = 0; i < from->symbols; i++) {
        int s = expr_symbol_find(&d->st, from->symbol[i].name, strlen(from->symbol[i].name));
        if (s < 0) {
            free(map);
            return NULL;
        }
        map[i] = d->st.symbol[s].node;
    }
    return map;
}

/* In the order of the answer's own roots. */
static void put_roots(const struct job *j, const struct sga_solution *sol, expr_id *root, int roots)
{
    int n = j->request->system.variables, c = sol->constraints;
    for (int i = 0; i < c; i++)
        root[i] = sol->constraint[i].expr;
    for (int i = c; i < roots; i++)
        root[i] = i < c + n ? sol->field[i - c] : sol->gauge[i - c - n];
}

/* Whether x is a number times y, not 0: both functions of the display's store. */
static bool proportional(struct display *d, expr_id x, expr_id y, const struct poly_limits *limits)
{
    struct sga_error before = *d->st.error;
    expr_id q = expr_div(&d->st, x, y), normal = EXPR_UNDEF;
    bool ok = q && poly_normal(&d->st, q, limits, &normal) && expr_is_const(&d->st, normal) && !expr_is_zero(&d->st, normal);
    *d->st.error = before;
    return ok;
}

/* Whether x - y is 0 on the final set: by algebra, or as the reduction decides such things. */
static bool same_on_set(struct display *d, expr_id x, expr_id y, const struct poly_limits *limits)
{
    struct expr_store *st = &d->j->request->store;
    struct sga_error before = *d->st.error, kept = *st->error;
    if (x == y)
        return true;
    expr_id difference = expr_sub(&d->st, x, y);
    bool same = difference && poly_is_zero(&d->st, difference, limits) == POLY_YES;
    if (!same && difference && d->j->oracle->reals) {
        SGA_ARENA(mem);
        expr_id *none = sga_zeros(&mem, (size_t)d->st.symbols + 1, sizeof *none);
        for (int i = 0; i < d->st.symbols; i++)
            none[i] = st->symbol[i].node;
        expr_copy(st, &d->st, &difference, 1, none);
        same = difference && expr_store_ok(st) && points_oracle_zero(d->j->oracle, difference).truth == POINTS_ZERO;
    }
    *d->st.error = before;
    *st->error = kept;
    return same;
}

/* Puts the constraints into the order of the answer's own; false where some has no partner. */
static bool match_constraints(struct display *d, const struct sheet *own, struct sheet *s, const expr_id *value,
                              const struct sga_constraint *constraint, const struct poly_limits *limits)
{
    int c = own->constraints;
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, (size_t)(c + 1) * sizeof *root);
    unsigned char *taken = sga_zeros(&mem, (size_t)c + 1, 1);
    bool ok = true;
    for (int i = 0; i < c && ok; i++) {
        ok = false;
        for (int k = 0; k < c && !ok; k++) {
            if (taken[k] || constraint[k].generation != own->constraint[i].generation || !proportional(d, own->root[i], value[k], limits))
                continue;
            taken[k] = ok = true;
            root[i] = s->root[k];
        }
    }
    if (ok)
        memcpy(s->root, root, (size_t)c * sizeof *root);
    return ok;
}

static bool take_over(struct display *d, const struct job *n, const struct sheet *own, struct sheet *s)
{
    const struct sga_solution *sol = n->solution;
    struct poly_limits limits = poly_limits_of(POLY_READ, n->budget);
    int roots = own->on_set;
    SGA_ARENA(mem);
    expr_id *map = by_symbol(d, &n->request->store), *root = sga_take(&mem, ((size_t)own->roots + 1) * sizeof *root);
    bool ok = map != NULL;
    if (ok) {
        put_roots(n, sol, root, roots);
        ok = display_sheet(d, s, &n->request->store, map, root, roots, own->constraint, own->constraints);
    }
    if (ok) {
        memcpy(root, s->root, (size_t)roots * sizeof *root);
        display_values(d, root, roots);
        ok = match_constraints(d, own, s, root, sol->constraint, &limits);
        for (int i = own->constraints; i < roots && ok; i++)
            ok = root[i] && same_on_set(d, root[i], own->root[i], &limits);
    }
    free(map);
    return ok && expr_store_ok(&d->st);
}

/* A parameter of the request that the second reading left symbolic. */
static bool has_names(const struct job *j, const struct request *r)
{
    for (int i = 0; i < r->system.parameters; i++)
        for (int k = 0; k < j->request->knowns; k++)
            if (strcmp(j->request->store.symbol[j->request->known[k].symbol].name, r->store.symbol[r->system.parameter[i]].name) == 0)
                return true;
    return false;
}

bool display_by_name(struct display *d, const struct sheet *own, struct sheet *by_name)
{
    struct job *j = d->j;
    struct sga_error ignored = { 0 };
    *by_name = (struct sheet){ 0 };
    if (j->place.depth || !j->request_text || !j->request->knowns || j->slice || j->op || j->mechanical
        || j->request->system.variables > MOST_VARIABLES || j->request->store.nodes > MOST_NODES)
        return false;
    struct request again;
    struct sga_budget budget = own_budget(j);
    struct job n = { .err = &ignored, .stage = "texts", .budget = &budget, .request = &again, .start = { .x = j->start.x, .time = j->start.time } };
    n.clock = sga_zeros(&n.mem, 1, sizeof *n.clock);
    if (!request_read_named(n.request, j->request_text, j->request_length, MOST_NODES)) {
        sga_arena_end(&n.mem);
        return false;
    }
    n.request->want = REQUEST_VECTOR_FIELD | REQUEST_GAUGE;
    bool ok = has_names(j, n.request) && same_variables(j, &n);
    n.start.parameter = values_near(j, &n.request->system, &n.mem);
    ok = ok && answer_reduce(&n) && same_shape(j->solution, n.solution) && take_over(d, &n, own, by_name);
    n.start.x = NULL;
    answer_reduce_clear(&n);
    sga_arena_end(&n.mem);
    request_clear(n.request);
    return ok;
}
