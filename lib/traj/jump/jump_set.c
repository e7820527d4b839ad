/* One event that sets variables: assignment, projection, and on which side of the events' zeros the motion goes on. */
#include "jump_set.h"

#include <assert.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "guard_beside.h"
#include "field.h"
#include "jump_impulse.h"
#include "jump_slope.h"
#include "arena.h"
#include "mem.h"
#include "ode.h"
#include "reduction.h"
#include "signals.h"
#include "system.h"
#include "tape.h"

/* Of a state: how far ahead and back an event's function is looked at for its direction; roundings of its values. */
static const double LOOK = 1e-6, ROUNDING = 16 * DBL_EPSILON;
/* Of the largest variable: where jumps of functions are looked for around an event's place. */
static const double JUMP = 1e-4;
/* The same: what the place is known to. */
static const double AT_ZERO = 1e-7;
/* Values that are meant to be one; a variable that stays; positions that a constraint finds where it holds, both by their size. */
static const double SAME_VALUE = 1e-9, STAYS = 1e-9, IN_PLACE = 1e-6;

/* 1 by variable of e. */
static void mark(const struct jump *j, struct expr_cone *cone, expr_id e, unsigned char *used)
{
    const struct expr_store *st = j->sys->store;
    expr_cone_of(st, cone, &e, 1);
    for (int i = 0; i < cone->count; i++)
        if (expr_op_of(st, cone->list[i]) == EXPR_SYM && j->variable[st->node[cone->list[i]].a] >= 0)
            used[j->variable[st->node[cone->list[i]].a]] = 1;
}

static void look_at_system(struct jump *j)
{
    const struct expr_store *st = j->sys->store;
    struct expr_cone cone;
    j->variable = sga_malloc(((size_t)st->symbols + 1) * sizeof *j->variable);
    for (int i = 0; i < st->symbols; i++)
        j->variable[i] = -1;
    for (int k = 0; k < j->n; k++)
        j->variable[j->sys->variable[k].symbol] = k;
    for (int i = 0; i < j->sys->rows; i++)
        for (int k = 0; k < j->sys->row[i].entries; k++)
            j->moving[j->sys->row[i].entry[k].col] = 1;
    for (int k = 0; k < j->rq->rates; k++)
        j->moving[j->rq->rate[k].variable] = 1;
    expr_cone_init(&cone);
    for (int i = 0; i < j->sol->constraints; i++)
        mark(j, &cone, j->sol->constraint[i].expr, j->bound);
    expr_cone_clear(&cone);
    for (int k = 0; k < j->n; k++) {
        expr_id e = j->sol->field[k];
        j->position[k] = j->moving[k] && expr_op_of(st, e) == EXPR_SYM && j->variable[st->node[e].a] >= 0;
    }
}

bool jump_init(struct jump *j, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq, struct sga_error *err)
{
    size_t n = (size_t)sys->variables;
    int roots = 0;
    *j = (struct jump){ .sys = sys, .sol = sol, .rq = rq, .n = sys->variables };
    for (int e = 0; e < rq->events; e++)
        j->sets += rq->event[e].sets;
    expr_id *root = sga_malloc((size_t)(j->sets + rq->events + 1) * sizeof *root);
    for (int e = 0; e < rq->events; e++)
        for (int k = 0; k < rq->event[e].sets; k++)
            root[roots++] = rq->event[e].set[k].value;
    for (int e = 0; e < rq->events; e++)
        root[roots++] = rq->event[e].expression;
    int *inputs = field_inputs(sys);
    j->tape = num_tape_new(sys->store, root, roots, inputs, j->n + 1, err);
    free(inputs);
    free(root);
    j->in = sga_calloc(n + 1, sizeof *j->in);
    j->out = sga_calloc((size_t)roots + 1, sizeof *j->out);
    j->moving = sga_calloc(3 * n + 1, 1);
    j->bound = j->moving + n;
    j->position = j->bound + n;
    look_at_system(j);
    if (!j->tape)
        return false;
    j->slope = rq->carried ? jump_slope_new(j, err) : NULL;
    return !rq->carried || j->slope;
}

int jump_same(const struct jump *from, int k, const struct jump *to)
{
    const char *name = from->sys->store->symbol[from->sys->variable[k].symbol].name;
    int symbol = expr_symbol_find(to->sys->store, name, strlen(name));
    return symbol < 0 ? -1 : to->variable[symbol];
}

void jump_clear(struct jump *j)
{
    jump_slope_free(j->slope);
    num_tape_free(j->tape);
    free(j->in);
    free(j->out);
    free(j->moving);
    free(j->variable);
    *j = (struct jump){ 0 };
}

/* The events' functions at t + h, x + h v (v may be NULL). */
static const double *events_at(struct jump *j, double t, const double *x, double h, const double *v)
{
    for (int k = 0; k < j->n; k++)
        j->in[k] = x[k] + (v ? h * v[k] : 0);
    j->in[j->n] = t + h;
    num_tape_eval(j->tape, j->in, j->out);
    return j->out + j->sets;
}

/* One of the functions beside what j->in is; the last argument is time. */
struct beside { struct jump *j; int event; };

static double value_beside(void *ctx, int k, double by)
{
    const struct beside *b = ctx;
    struct jump *j = b->j;
    double keep = k >= 0 ? j->in[k] : 0;
    if (k >= 0)
        j->in[k] += by;
    num_tape_eval(j->tape, j->in, j->out);
    if (k >= 0)
        j->in[k] = keep;
    return j->out[j->sets + b->event];
}

/* By how much roundings of x change function e. */
static double rounding(struct jump *j, int e, double t, const double *x)
{
    double g = events_at(j, t, x, 0, NULL)[e], sum = 4 * DBL_EPSILON * fabs(g);
    const struct guard_beside b = { value_beside, &(struct beside){ j, e }, j->n };
    for (int k = 0; k < j->n; k++)
        sum += guard_beside_change(&b, g, k, ROUNDING * fabs(j->in[k]), NULL);
    return sum;
}

/* -1 for a motion against time. */
static int along(const struct jump *j) { return j->rq->times[j->rq->samples - 1] < j->rq->start ? -1 : 1; }

static double size_of(const struct jump *j, const double *x)
{
    double size = 0;
    for (int k = 0; k < j->n; k++)
        size = fmax(size, fabs(x[k]));
    return size;
}

/* How far along v the functions are looked at. */
static double look_ahead(const struct jump *j, const double *x, const double *v)
{
    double size = size_of(j, x), speed = size_of(j, v), h = LOOK * fabs(j->rq->times[j->rq->samples - 1] - j->rq->start);
    return size > 0 && speed * h > LOOK * size ? LOOK * size / speed : h;
}

double jump_function(struct jump *j, int e, double t, const double *x) { return events_at(j, t, x, 0, NULL)[e]; }

bool jump_at_zero(struct jump *j, int e, double t, const double *x)
{
    double size = size_of(j, x), g = jump_function(j, e, t, x), sum = rounding(j, e, t, x);
    const struct guard_beside b = { value_beside, &(struct beside){ j, e }, j->n };
    events_at(j, t, x, 0, NULL);
    for (int k = 0; k < j->n; k++)
        sum += guard_beside_change(&b, g, k, AT_ZERO * size, NULL);
    return fabs(g) <= sum;
}

bool jump_function_jumps(struct jump *j, int e, double t, const double *x, const double *v, bool *over)
{
    double size = size_of(j, x), h = v ? look_ahead(j, x, v) : 0, g = events_at(j, t, x, 0, NULL)[e];
    bool along = g * events_at(j, t, x, h, v)[e] > 0 && g * events_at(j, t, x, -h, v)[e] > 0;
    const struct guard_beside b = { value_beside, &(struct beside){ j, e }, j->n + 1 };
    SGA_FREED double *around = sga_malloc((size_t)(j->n + 1) * sizeof *around);
    events_at(j, t, x, 0, NULL);
    for (int k = 0; k < j->n; k++)
        around[k] = JUMP * size;
    around[j->n] = JUMP * fmax(fabs(t), fabs(j->rq->times[j->rq->samples - 1] - j->rq->start));
    bool any = guard_beside_jumps(&b, around);
    for (int k = 0; k <= j->n; k++)
        around[k] *= GUARD_BESIDE_NEARER;
    *over = any && !(along && guard_beside_steady(&b, around));
    return any;
}

/* +1: it grows along v; 0: not told from standing. */
static int heads(struct jump *j, int e, double t, const double *x, const double *v)
{
    double h = look_ahead(j, x, v);
    double ahead = events_at(j, t, x, h, v)[e], back = events_at(j, t, x, -h, v)[e], change = ahead - back;
    return fabs(change) <= rounding(j, e, t, x) || isnan(change) ? 0 : change > 0 ? 1 : -1;
}

/* The mode's value that is set. */
static bool assign_mode(const struct jump *j, const struct jump_at *at, int mode, double value, const char *place, int *chosen, bool again, struct sga_error *err)
{
    const struct traj_modes *m = j->rq->modes;
    int k = 0;
    while (k < m->values[mode] && !(fabs(m->value[mode][k] - value) <= SAME_VALUE * fmax(fabs(value), fabs(m->value[mode][k]))))
        k++;
    if (k == m->values[mode])
        return sga_fail_at(err, SGA_E_MODE_VALUE, place, "at %.10g the mode %.100s is set to %.10g, which is not among its values; add it to system.modes, or round what is set",
                           at->t, m->name[mode], value);
    if (again && *chosen != k)
        return sga_fail_at(err, SGA_E_EVENT_SET, place, "at %.10g two events happen at once and set the mode %.100s to %.10g and %.10g; "
                           "what happens then is not said: one event for both would say it", at->t, m->name[mode], m->value[mode][*chosen], m->value[mode][k]);
    *chosen = k;
    return true;
}

bool jump_assign(struct jump *j, const struct jump_at *at, double *to, unsigned char *changed, int *choice, struct sga_error *err)
{
    SGA_FREED unsigned char *mode = sga_calloc(j->rq->modes ? (size_t)j->rq->modes->modes + 1 : 1, 1);
    memcpy(to, at->x, (size_t)j->n * sizeof *to);
    memset(changed, 0, (size_t)j->n);
    events_at(j, at->t, at->x, 0, NULL);
    for (int e = 0, i = 0; e < j->rq->events; i += j->rq->event[e++].sets)
        for (int k = 0; k < j->rq->event[e].sets && at->fired[e]; k++) {
            int variable = j->rq->event[e].set[k].variable;
            double value = j->out[i + k];
            assert(i + k < j->sets);       /* in the order of the tape's roots */
            char place[64];
            snprintf(place, sizeof place, "/trajectory/events/%d/set", e);
            const char *name = variable < 0 ? j->rq->modes->name[-1 - variable] : j->sys->store->symbol[j->sys->variable[variable].symbol].name;
            if (!isfinite(value))
                return sga_fail_at(err, SGA_E_EVENT_SET, place, "at %.10g what is set for %.100s has no value", at->t, name);
            if (variable < 0) {
                if (!assign_mode(j, at, -1 - variable, value, place, choice + (-1 - variable), mode[-1 - variable], err))
                    return false;
                mode[-1 - variable] = 1;
                continue;
            }
            if (changed[variable] && fabs(to[variable] - value) > SAME_VALUE * fmax(fabs(value), fabs(to[variable])))
                return sga_fail_at(err, SGA_E_EVENT_SET, place, "at %.10g two events happen at once and set %.100s to %.10g and %.10g; "
                                   "what happens then is not said: one event for both would say it", at->t, name, to[variable], value);
            to[variable] = value;
            changed[variable] = 1;
        }
    for (int k = 0; k < j->n; k++)
        if (changed[k])
            to[k] *= 1 + at->wrong;
    return true;
}

/* 1 for the variables of constraints in which nothing is that moves: moved, and all that no equation differentiates. */
static void untouched(const struct jump *j, const unsigned char *moved, unsigned char *hold)
{
    struct expr_cone cone;
    SGA_FREED unsigned char *used = sga_malloc((size_t)j->n + 1);
    expr_cone_init(&cone);
    for (int i = 0; i < j->sol->constraints; i++) {
        bool touched = false;
        memset(used, 0, (size_t)j->n);
        mark(j, &cone, j->sol->constraint[i].expr, used);
        for (int k = 0; k < j->n; k++)
            touched |= used[k] && (moved[k] || !j->moving[k]);
        for (int k = 0; k < j->n && !touched; k++)
            hold[k] |= used[k];
    }
    expr_cone_clear(&cone);
}

/* moved: what was set becomes all that moves with it, from constraint to constraint, but positions. */
static void reach(const struct jump *j, unsigned char *moved)
{
    struct expr_cone cone;
    SGA_FREED unsigned char *used = sga_malloc((size_t)j->n + 1);
    expr_cone_init(&cone);
    for (bool more = true; more;) {
        more = false;
        for (int i = 0; i < j->sol->constraints; i++) {
            bool touched = false;
            memset(used, 0, (size_t)j->n);
            mark(j, &cone, j->sol->constraint[i].expr, used);
            for (int k = 0; k < j->n; k++)
                touched |= used[k] && moved[k];
            for (int k = 0; k < j->n && touched; k++)
                if (used[k] && !moved[k] && j->moving[k] && !j->position[k])
                    more = true, moved[k] = 1;
        }
    }
    expr_cone_clear(&cone);
}

void jump_request(const struct jump *j, const struct jump_at *at, const struct jump_to *to, int way, unsigned char *hold, struct traj_request *q)
{
    size_t n = (size_t)j->n;
    unsigned char *given = hold + n;
    SGA_FREED unsigned char *moved = memcpy(sga_malloc(n + 1), to->changed, n);
    if (way == JUMP_REACH_POSITIONS || way == JUMP_REACH)
        reach(j, moved);
    if (way != JUMP_HOLD_MOVING && !to->turned)
        untouched(j, moved, hold);
    for (size_t k = 0; k < n; k++) {
        bool positions = way == JUMP_HOLD_POSITIONS || way == JUMP_REACH_POSITIONS;
        hold[k] |= to->changed[k] || (way == JUMP_HOLD_MOVING && j->moving[k] && j->sol->constraints) || (positions && j->position[k]);
        hold[k] &= to->known[k];
        given[k] = (j->moving[k] || to->changed[k] || !j->bound[k]) && to->known[k];
    }
    *q = *j->rq;
    q->start = at->t;
    q->initial = to->x;
    q->held = hold;
    q->given = given;
    q->exact_start = EXPR_UNDEF;
    q->exact_initial = q->exact_time = NULL;
    q->events = 0;
    q->modes = NULL;
    q->carried = NULL;
    q->arithmetic = TRAJ_DOUBLE;
    if (!q->sized_by && j->rq->modes && j->rq->modes->surfaces)        /* what slides leave at 0 is dust, which has no size */
        q->sized_by = j->rq;
}

/* The start nearest to to->x in one of the ways, with its derivative. */
static bool project(struct jump *j, const struct jump_at *at, const struct jump_to *to, int way, struct traj_initial *r, struct sga_error *err)
{
    struct traj_request q;
    SGA_FREED unsigned char *place = sga_calloc(2 * (size_t)j->n + 1, 1);
    jump_request(j, at, to, way, place, &q);
    signals_ahead(j->sys, &q);
    bool ok = traj_consistent(j->sys, j->sol, &q, r, err);
    signals_between(j->sys, NAN, NAN);
    return ok;
}

/* Where the motion before came from, along v. */
static void sides_before(struct jump *j, const struct jump_at *at, const unsigned char *near, signed char *side)
{
    struct traj_initial r;
    struct sga_error ignored = { 0 };
    unsigned char *none = sga_calloc(2 * (size_t)j->n + 1, 1);
    struct jump_to to = { .x = (double *)at->x, .changed = none, .known = none + j->n };
    bool any = false;
    memset(to.known, 1, (size_t)j->n);
    for (int e = 0; e < j->rq->events; e++)
        any |= near[e] && !at->fired[e];
    if (any && project(j, at, &to, JUMP_WAYS, &r, &ignored)) {
        for (int e = 0; e < j->rq->events; e++)
            if (near[e] && !at->fired[e])
                side[e] = (signed char)(-along(j) * heads(j, e, at->t, at->x, r.derivative));
        traj_initial_clear(&r);
    }
    free(none);
}

/* An event whose function is 0 before and after, to the roundings of values and of time, or jumps over 0: where it happened, it goes on to the side that it heads for; where it
 * stands, and where it did not happen, it comes from where it was. */
static void sides_after(const struct jump_turn *turn, const struct traj_initial *to, signed char *side, unsigned char *stands)
{
    struct jump *j = turn->j;
    const struct jump_at *at = turn->at, *before = turn->before;
    int events = j->rq->events;
    unsigned char *near = sga_calloc((size_t)events + 1, 1);
    for (int e = 0; e < events; e++) {
        double slow = fabs(events_at(j, at->t, to->x, ROUNDING * fabs(at->t), to->derivative)[e] - events_at(j, at->t, to->x, 0, NULL)[e]);
        double told = 16 * (rounding(turn->from, e, at->t, before->x) + rounding(j, e, at->t, to->x)) + (isfinite(slow) ? slow : 0);
        double was = fabs(events_at(turn->from, at->t, before->x, 0, NULL)[e]), after = fabs(events_at(j, at->t, to->x, 0, NULL)[e]);
        bool over, jumped, jumped_over;
        jumped = jump_function_jumps(turn->from, e, at->t, before->x, NULL, &jumped_over);
        if (jump_function_jumps(j, e, at->t, to->x, to->derivative, &over))
            near[e] = over && (at->fired[e] || jumped_over || was <= told);
        else
            near[e] = after <= told + (at->fired[e] && !jumped ? 4 * was : 0) && (at->fired[e] || was <= told);
        side[e] = ODE_SIDE_TOLD;
        stands[e] = 0;
        if (near[e] && at->fired[e]) {
            int way = heads(j, e, at->t, to->x, to->derivative);
            side[e] = (signed char)(along(j) * (way ? way : over ? 0 : -at->crossing[e]));
            stands[e] = !way;
        }
    }
    sides_before(turn->from, before, near, side);
    for (int e = 0; e < events && turn->from != j; e++)       /* held at 0 in the mode before: it has to leave first */
        if (near[e] && !at->fired[e] && side[e] == ODE_SIDE_TOLD)
            side[e] = ODE_SIDE_FRESH;
    free(near);
}

/* Positions do not jump by an impulse: those that a constraint moves are not where it holds. */
static bool in_place(const struct jump *j, const struct jump_at *at, const struct jump_to *to, const double *x, const char *place, struct sga_error *err)
{
    const struct traj_mass *m = j->rq->mass;
    double size = 0, span = fabs(j->rq->times[j->rq->samples - 1] - j->rq->start);
    for (int k = 0; m && k < m->coordinates; k++) {
        size = fmax(size, fmax(fabs(at->x[m->position[k]]), fabs(at->x[m->velocity[k]]) * span));
        if (to->changed[m->position[k]])
            return true;
    }
    for (int k = 0; m && k < m->coordinates; k++) {
        double off = fabs(x[m->position[k]] - to->x[m->position[k]]);
        if (off > IN_PLACE * size)
            return sga_fail_at(err, SGA_E_EVENT_SET, place, "at %.10g the constraints that hold from here on would move the position %.100s by %.3g: no impulse does that; "
                               "let the event happen where they hold, or set positions on them", at->t, j->sys->store->symbol[j->sys->variable[m->position[k]].symbol].name, off);
    }
    return true;
}

/* What moved that was not set. */
static void tell(const struct jump *j, struct jump_to *to, const double *asked, const double *x)
{
    double size = 0;
    to->moved = 0;
    for (int k = 0; k < j->n; k++)
        if (j->moving[k])
            size = fmax(size, fabs(x[k]));
    for (int k = 0; k < j->n; k++)
        if (j->moving[k] && to->known[k] && !to->changed[k] && size > 0)
            to->moved = fmax(to->moved, fabs(x[k] - asked[k]) / size);
    to->how = to->struck ? "impulse" : to->moved > STAYS ? "least movement" : "kept";
}

/* Errors that say that there is no such start. */
static bool says_none(const struct sga_error *why)
{
    return why->code == SGA_E_INITIAL || why->code == SGA_E_NO_MOTION || why->code == SGA_E_UNDECIDED;
}

int jump_start(struct jump *j, const struct jump_at *at, const struct jump_to *to, struct traj_initial *r, struct sga_error *why)
{
    for (int way = 0; way < JUMP_WAYS && (!way || says_none(why)); way++) {
        *why = (struct sga_error){ 0 };
        if (project(j, at, to, way, r, why))
            return way;
    }
    return -1;
}

bool jump_land(const struct jump_turn *turn, struct jump_to *to, signed char *side, unsigned char *stands, struct sga_error *err)
{
    struct jump *j = turn->j;
    const struct jump_at *at = turn->at;
    size_t n = (size_t)j->n;
    struct traj_initial r;
    struct sga_error why = { 0 };
    char place[64];
    int first = 0;
    while (first + 1 < j->rq->events && !(at->fired[first] && j->rq->event[first].sets))
        first++;
    snprintf(place, sizeof place, "/trajectory/events/%d/set", first);
    SGA_FREED double *asked = sga_malloc((n + 1) * sizeof *asked);
    memcpy(asked, to->x, n * sizeof *asked);
    bool ok = !j->rq->mass || jump_impulse(j, at, to, place, err);
    int way = ok ? jump_start(j, at, to, &r, &why) : -1;
    bool there = way >= 0;
    if (ok && !there && !says_none(&why)) {
        *err = why;               /* time is up */
        ok = false;
    }
    if (ok && !there)
        ok = sga_fail_at(err, SGA_E_EVENT_SET, place, "at %.10g the values that are set lie off the constraints, whatever else moves: %.400s", at->t, why.detail);
    ok = ok && in_place(j, at, to, r.x, place, err) && (!j->slope || jump_slope_land(turn, to, asked, r.x, way, err));
    if (ok) {
        memcpy(to->x, r.x, n * sizeof *to->x);
        to->way = way;
        tell(j, to, asked, to->x);
        sides_after(turn, &r, side, stands);
    }
    if (there)
        traj_initial_clear(&r);
    return ok;
}
