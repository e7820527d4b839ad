/* Derivatives of a motion at an event that sets variables: when it happens, what is set, and where the motion goes on. */
#include "jump_slope.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "field.h"
#include "jump_least.h"
#include "mem.h"
#include "print.h"
#include "reduction.h"
#include "signals.h"
#include "system.h"
#include "tape.h"

/* Beside what is added up in them: a function that does not move along the motion; one that does not along a direction; times and values that are one; a function at
 * its zero. */
static const double AT_REST = 1e-9, STILL = 1e-6, TOGETHER = 1e-7, ON = 1e-11;
/* Of a motion: how far ahead switches are looked at; of their arguments there: those that are 0 before. How often what is turned may turn others. */
static const double AHEAD = 1e-8, BESIDE = 1e-3;
enum { TURNS = 3 };
/* Of the largest derivative: one that is 0 but for roundings. */
static const double ROUNDED = 1e-12;

static struct num_tape *tape_of(const struct traj_carried *c, const expr_id *root, int roots, struct sga_error *err)
{
    SGA_FREED int *inputs = field_inputs(c->sys);
    return num_tape_new(c->sys->store, root, roots, inputs, c->sys->variables + 1, err);
}

static bool make_tapes(struct jump_slope *s, const struct traj_carried *c, struct sga_error *err)
{
    const struct traj_request *rq = c->rq;
    const struct traj_slopes *d = rq->slopes;
    int events = rq->events, roots = 0, slopes = 0;
    SGA_ARENA(mem);
    expr_id *root = sga_take(&mem, (size_t)(events + s->sets + s->masses + c->sol->constraints + 1) * sizeof *root);
    expr_id *slope = sga_take(&mem, (size_t)((events + s->sets + s->masses) * s->rows.q + 1) * sizeof *slope);
    for (int e = 0; e < events; e++)
        root[roots++] = rq->event[e].expression;
    for (int e = 0; e < events; e++)
        for (int k = 0; k < rq->event[e].sets; k++)
            root[roots++] = rq->event[e].set[k].value;
    for (int k = 0; k < s->masses; k++)
        root[roots++] = rq->mass->value[k];
    s->rows.first = roots;
    for (int i = 0; i < c->sol->constraints; i++)
        root[roots++] = c->sol->constraint[i].expr;
    for (int k = 0; k < events * s->rows.q; k++)
        slope[slopes++] = d->event[k];
    for (int k = 0; k < s->sets * s->rows.q; k++)
        slope[slopes++] = d->set[k];
    for (int k = 0; k < s->masses * s->rows.q; k++)
        slope[slopes++] = d->mass[k];
    SGA_FREED int *inputs = field_inputs(c->sys);
    num_switches_find(&s->switches, c->sys->store, c->sol->field, s->rows.n);
    s->field = num_tape_new_switched(c->sys->store, &s->switches, c->sol->field, s->rows.n, inputs, c->sys->variables + 1, err);
    s->switching = s->field && s->switches.count ? tape_of(c, s->switches.argument, s->switches.count, err) : NULL;
    s->side = sga_calloc((size_t)s->switches.count + 1, 1);
    if (s->switches.count && !s->switching)
        return false;
    s->slope = s->field ? tape_of(c, slope, slopes, err) : NULL;
    s->along = sga_calloc((size_t)slopes + 1, sizeof *s->along);
    return s->slope && least_rows_init(&s->rows, c->sys->store, root, roots, inputs, err);
}

struct jump_slope *jump_slope_new(const struct jump *j, struct sga_error *err)
{
    const struct traj_carried *c = j->rq->carried;
    struct jump_slope *s = sga_calloc(1, sizeof *s);
    *s = (struct jump_slope){ .of = j, .rows = { .n = c->rq->slopes->base, .q = c->rq->slopes->directions }, .sets = j->sets, .masses = c->rq->mass ? c->rq->mass->entries : 0 };
    assert(s->rows.n == j->n && c->sys->variables == s->rows.n * (1 + s->rows.q) && c->rq->events == j->rq->events);
    if (make_tapes(s, c, err))
        return s;
    jump_slope_free(s);
    return NULL;
}

void jump_slope_free(struct jump_slope *s)
{
    if (!s)
        return;
    least_rows_clear(&s->rows);
    num_tape_free(s->field);
    num_tape_free(s->switching);
    num_switches_clear(&s->switches);
    free(s->side);
    num_tape_free(s->slope);
    free(s->along);
    free(s);
}

bool jump_slope_directions(struct jump_slope *s) { return num_tape_eval(s->slope, s->rows.in, s->along); }

/* Of a root at what was evaluated last: its derivative along the motion; *terms: the sizes of what is added up. */
static double rate_of(const struct jump_slope *s, int root, const double *field, double *g, double *terms)
{
    double rate = least_rows_gradient(&s->rows, root, g), sum = fabs(rate);
    for (int k = 0; k < s->rows.n; k++) {
        rate += g[k] * field[k];
        sum += fabs(g[k] * field[k]);
    }
    *terms = sum;
    return rate;
}

void jump_slope_came(struct jump_slope *s, const struct jump_at *at)
{
    memset(s->side, 0, (size_t)s->switches.count);
    for (int k = 0; k < s->switches.count && at->piece; k++)
        for (int i = 0; i < at->piece->helds; i++)
            if (at->piece->held_argument[i] == s->switches.argument[k])
                s->side[k] = at->piece->held[i];
    num_tape_hold(s->field, s->side);
}

/* What switches are signs of at (t + h, x + h field). */
static void switching(const struct jump_slope *s, double t, const double *x, double h, const double *field, double *in, double *g)
{
    memset(in, 0, ((size_t)s->rows.all + 1) * sizeof *in);
    for (int k = 0; k < s->rows.n; k++)
        in[k] = x[k] + (field ? h * field[k] : 0);
    in[s->rows.all] = t + h;
    num_tape_eval(s->switching, in, g);
}

void jump_slope_goes(struct jump_slope *s, double t, const double *x)
{
    const struct traj_request *rq = s->of->rq;
    size_t n = (size_t)s->rows.n, c = (size_t)s->switches.count;
    num_tape_hold(s->field, NULL);
    if (!s->switching)
        return;
    SGA_ARENA(mem);
    double *in = sga_zeros(&mem, (size_t)s->rows.all + 1, sizeof *in), *field = sga_zeros(&mem, n + 2 * c + 1, sizeof *field), *g = field + n, *ahead = g + c;
    double h = AHEAD * (rq->times[rq->samples - 1] - rq->start);
    switching(s, t, x, 0, NULL, in, g);
    memset(s->side, 0, c);
    for (int turn = 0; turn < TURNS; turn++) {       /* which may turn others */
        switching(s, t, x, 0, NULL, in, ahead);
        num_tape_eval(s->field, in, field);
        switching(s, t, x, h, field, in, ahead);
        for (size_t k = 0; k < c; k++)               /* at their zeros, which roundings have on one side or the other */
            s->side[k] = (signed char)(fabs(g[k]) <= BESIDE * fabs(ahead[k]) ? (ahead[k] > 0) - (ahead[k] < 0) : 0);
        num_tape_hold(s->field, s->side);
    }
}

/* Values, gradients, slopes and the field at (t, x, S). */
static bool look(struct jump_slope *s, double t, const double *x, const double *S, double *field)
{
    bool ok = least_rows_at(&s->rows, t, x, S);
    return num_tape_eval(s->field, s->rows.in, field) && num_tape_eval(s->slope, s->rows.in, s->along) && ok;
}

/* The motion goes on otherwise from event e. */
static bool changes(const struct jump_slope *s, int e) { return s->of->rq->event[e].sets > 0 || s->of->rq->event[e].turns; }

/* dt/dk of event e, by direction. False with why. */
static bool time_of(const struct jump_slope *s, int e, const struct jump_at *at, const double *field, double *g, double *tau, char *why, size_t size)
{
    double terms, rate = rate_of(s, e, field, g, &terms);
    const struct traj_carried *c = s->of->rq->carried;
    bool moves = false;
    for (int d = 0; d < s->rows.q; d++)
        moves |= s->along[e * s->rows.q + d] != 0 || (rate == 0 && !expr_is_zero(c->sys->store, c->rq->slopes->event[e * s->rows.q + d]));
    for (int d = 0; d < s->rows.q; d++)
        tau[d] = moves ? -s->along[e * s->rows.q + d] / rate : 0;
    if (!moves || (fabs(rate) > AT_REST * terms && at->crossing[e]))
        return true;
    char *text = expr_text(s->of->sys->store, s->of->rq->event[e].expression, 120);
    snprintf(why, size, "at %.10g the motion only touches %.100s = 0: how its time changes with what is differentiated by has no bound", at->t, text);
    free(text);
    return false;
}

/* That of all events that happen, which must be one. */
static bool times_of(const struct jump_slope *s, const struct jump_at *at, const double *field, double *tau, char *why, size_t size)
{
    SGA_ARENA(mem);
    double *g = sga_zeros(&mem, (size_t)(s->rows.n + s->rows.q) + 1, sizeof *g), *other = g + s->rows.n;
    int first = -1;
    for (int e = 0; e < s->of->rq->events; e++) {
        if (!at->fired[e] || !changes(s, e))
            continue;
        if (!time_of(s, e, at, field, g, first < 0 ? tau : other, why, size))
            return false;
        for (int d = 0; d < s->rows.q && first >= 0; d++)
            if (!(fabs(tau[d] - other[d]) <= TOGETHER * (fabs(tau[d]) + fabs(other[d])))) {
                snprintf(why, size, "at %.10g the events %d and %d happen at once, and what is differentiated by parts them: what is set would be another thing on each side", at->t, first, e);
                return false;
            }
        first = first < 0 ? e : first;
    }
    return true;
}

/* The time moves along no direction, or what it moves through has no knot there. */
static bool clear_of_knots(const struct jump_slope *s, const struct jump_at *at, const double *tau, char *why, size_t size)
{
    const struct jump *j = s->of;
    bool moves = false, bends = false;
    for (int d = 0; d < s->rows.q; d++)
        moves |= tau[d] != 0;
    for (int e = 0; e < j->rq->events && moves; e++)
        if (at->fired[e] && changes(s, e)) {
            bends |= signals_bend(j->sys, j->rq->event[e].expression, 1, at->t);
            for (int k = 0; k < j->rq->event[e].sets; k++)
                bends |= signals_bend(j->sys, j->rq->event[e].set[k].value, 1, at->t);
        }
    for (int k = 0; k < s->rows.n && moves && j->sys->signals; k++)
        bends |= signals_bend(j->sys, j->sol->field[k], 0, at->t);
    if (bends)
        snprintf(why, size, "at %.10g the event happens at a knot of a table, and what is differentiated by moves it to one side or the other, where the table is another function", at->t);
    return !bends;
}

/* y (directions x variables): of values as they are set, in the variables before. */
static bool assigned(const struct jump_slope *s, const struct jump_at *at, const double *field, const double *tau, double *y, char *why, size_t size)
{
    size_t n = (size_t)s->rows.n;
    int root = s->of->rq->events;
    SGA_ARENA(mem);
    double *g = sga_zeros(&mem, n + 1, sizeof *g), terms;
    unsigned char *done = sga_zeros(&mem, n + 1, 1);
    for (int d = 0; d < s->rows.q; d++)
        for (size_t k = 0; k < n; k++)
            y[(size_t)d * n + k] = at->x[n + (size_t)d * n + k] + field[k] * tau[d];
    for (int e = 0; e < s->of->rq->events; e++)
        for (int i = 0; i < s->of->rq->event[e].sets; i++, root++) {
            int v = s->of->rq->event[e].set[i].variable;
            if (!at->fired[e] || v < 0)
                continue;
            double rate = rate_of(s, root, field, g, &terms);
            for (int d = 0; d < s->rows.q; d++) {
                double slope = s->along[root * s->rows.q + d] + rate * tau[d], *to = y + (size_t)d * n + v;
                if (done[v] && !(fabs(slope - *to) <= TOGETHER * (fabs(slope) + fabs(*to)))) {
                    snprintf(why, size, "at %.10g two events happen at once and set %.100s to values that are one only here", at->t, s->of->sys->store->symbol[s->of->sys->variable[v].symbol].name);
                    return false;
                }
                *to = slope * (1 + at->wrong);
            }
            done[v] = 1;
        }
    return true;
}

/* By names from the variables of one mode to those of another: to (directions x its variables). */
static void carry(const struct jump *from, const struct jump *j, int q, const double *y, double *to)
{
    for (int k = 0; k < from->n; k++) {
        int v = jump_same(from, k, j);
        for (int d = 0; d < q && v >= 0; d++)
            to[d * j->n + v] = y[d * from->n + k];
    }
}

/* Whether event e, whose function is 0 at what was evaluated last, may or may not happen next, as what is differentiated by changes: it moves off its zero, to a side from which the
 * motion comes to it in the event's direction. */
static bool ambiguous(const struct jump_slope *s, int e, const double *field, const double *tau, double *g)
{
    const struct traj_request *rq = s->of->rq;
    double terms, rate = rate_of(s, e, field, g, &terms), span = fabs(rq->times[rq->samples - 1] - rq->start), size = 0;
    bool moves = false, rests = fabs(rate) <= AT_REST * terms;
    double most = 0, sum = 0;
    for (int k = s->rows.n; k < s->rows.all; k++)
        most = fmax(most, fabs(s->rows.in[k]));
    for (int k = 0; k < s->rows.n; k++) {
        sum += fabs(g[k]);
        size += fabs(g[k]) * fmax(fabs(s->rows.in[k]), fabs(field[k]) * span);
    }
    if (!(fabs(s->rows.out[e]) <= ON * size))
        return false;
    for (int d = 0; d < s->rows.q; d++) {
        double change = s->along[e * s->rows.q + d] + (tau ? rate * tau[d] : 0), parts = 0;
        for (int k = 0; k < s->rows.n; k++)
            parts += fabs(g[k]) * (fabs(s->rows.in[s->rows.n + d * s->rows.n + k]) + (tau ? fabs(field[k] * tau[d]) : 0));
        moves |= change != 0 && fabs(change) > STILL * parts + ROUNDED * sum * most;
    }
    int way = rq->times[rq->samples - 1] < rq->start ? -1 : 1;
    return moves && (rests || !rq->event[e].direction || rq->event[e].direction * rate * way > 0);
}

/* The first such event that sets something, and has not done so as often as it may, or -1. */
static int first_ambiguous(const struct jump_slope *s, const int *count, const double *field, const double *tau, double *g)
{
    const struct traj_event *event = s->of->rq->event;
    for (int e = 0; e < s->of->rq->events; e++)
        if (changes(s, e) && !(count && event[e].most && count[e] >= event[e].most) && ambiguous(s, e, field, tau, g))
            return e;
    return -1;
}

bool jump_slope_starts(const struct jump *j, double t, const double *x, int *event)
{
    struct jump_slope *s = j->slope;
    SGA_ARENA(mem);
    double *field = sga_zeros(&mem, 2 * (size_t)s->rows.n + 1, sizeof *field);
    jump_slope_goes(s, t, x);
    bool ok = look(s, t, x, x + s->rows.n, field);
    *event = ok ? first_ambiguous(s, NULL, field, NULL, field + s->rows.n) : -1;
    return *event < 0;
}

/* From derivatives along the event to those at its time, in S; and whether the motion goes on clear of other events. */
static bool go_on(struct jump_slope *s, const struct jump_at *at, const double *x, const double *tau, double *S, char *why, size_t size)
{
    size_t n = (size_t)s->rows.n;
    SGA_ARENA(mem);
    double *field = sga_zeros(&mem, 2 * n + 1, sizeof *field);
    jump_slope_goes(s, at->t, x);
    least_rows_load(&s->rows, at->t, x, NULL);
    bool ok = num_tape_eval(s->field, s->rows.in, field);
    for (int d = 0; d < s->rows.q; d++)
        for (size_t k = 0; k < n; k++) {
            double *to = S + (size_t)d * n + k;
            *to -= field[k] * tau[d];
            ok = ok && isfinite(*to);
        }
    ok = ok && look(s, at->t, x, S, field);
    if (!ok) {
        snprintf(why, size, "at %.10g the derivatives have no value after the event", at->t);
        return false;
    }
    int e = first_ambiguous(s, at->count, field, tau, field + n);
    if (e >= 0 && s->of->rq->event[e].turns)
        snprintf(why, size, "after %.10g the motion goes on from another surface where the equations jump, and what is differentiated by moves it to one side or the other of it", at->t);
    else if (e >= 0)
        snprintf(why, size, "after %.10g the motion goes on from the zero of event %d, and what is differentiated by moves it to one side or the other of it", at->t, e);
    return e < 0;
}

/* An event's function jumps over 0: of its time nothing is known but by what it is a function of. */
static bool jumps_over(const struct jump_turn *turn, const struct jump_slope *s, char *why, size_t size)
{
    const struct jump_at *at = turn->before;
    bool over = false;
    int e = 0;
    for (; e < s->of->rq->events && !over; e++)
        if (at->fired[e] && changes(s, e))
            jump_function_jumps(turn->from, e, at->t, at->x, NULL, &over);
    if (!over)
        return false;
    char *text = expr_text(s->of->sys->store, s->of->rq->event[e - 1].expression, 120);
    snprintf(why, size, "at %.10g %.60s jumps over 0, and how the time of that changes with what is differentiated by it does not say: let the event's expression be what changes its sign there", at->t, text);
    free(text);
    return true;
}

bool jump_slope_land(const struct jump_turn *turn, struct jump_to *to, const double *asked, const double *x, int way, struct sga_error *err)
{
    struct jump_slope *from = turn->from->slope, *s = turn->j->slope;
    const struct jump_at *at = turn->before;
    SGA_ARENA(mem);
    double *field = sga_zeros(&mem, (size_t)(from->rows.n + s->rows.q) + 1, sizeof *field), *tau = field + from->rows.n;
    double *y = sga_zeros(&mem, (size_t)(from->rows.n * s->rows.q) + 1, sizeof *y);
    to->slope = sga_calloc((size_t)(s->rows.n * s->rows.q) + 1, sizeof *to->slope);
    jump_slope_came(from, at);
    if (!look(from, at->t, at->x, at->x + from->rows.n, field)) {
        snprintf(to->why, sizeof to->why, "at %.10g what is set has no derivative", at->t);
        return true;
    }
    if (jumps_over(turn, from, to->why, sizeof to->why))
        return true;
    if (!times_of(from, at, field, tau, to->why, sizeof to->why) || !clear_of_knots(from, at, tau, to->why, sizeof to->why) || !assigned(from, at, field, tau, y, to->why, sizeof to->why))
        return true;
    carry(turn->from, turn->j, s->rows.q, y, to->slope);
    struct jump_along along = { turn->j, turn->at, to, tau };
    if ((turn->j->rq->mass && !jump_least_impulse(&along, asked, to->slope)) || !jump_least_start(&along, x, way, to->slope)) {
        snprintf(to->why, sizeof to->why, "at %.10g the point of the constraints that the event leads to is not told well enough to be differentiated", at->t);
        return sga_budget_ok(turn->j->rq->budget, err);
    }
    go_on(s, turn->at, x, tau, to->slope, to->why, sizeof to->why);
    return true;
}
