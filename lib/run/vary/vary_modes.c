/* Modes of motions that are differentiated: see vary_modes.h. */
#include "vary_modes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "error.h"
#include "events_of.h"
#include "mem.h"
#include "points.h"
#include "system.h"
#include "variation.h"
#include "vary_copies.h"
#include "vary_motion.h"

/* One that was reached after the start. */
struct reached {
    struct vary_model model;
    struct traj_request rq;
    struct variation_by *by;
    struct variation variation;
    int *choice;
    struct reached *next;
    struct vary_copies copies;    /* at the parameters of this motion */
    bool varied, copied;
    struct traj_mode mode;        /* of these */
    struct sga_error why;         /* it cannot be entered */
};

struct vary_modes {
    struct job *j;
    struct vary_modes_of is;
    struct traj_modes of;
    struct traj_mode start;
    int *choice, *values;
    const char **name;
    const double **value;
    const struct vary_at *at;     /* of this motion */
    struct reached *first, **last;
    int count;                    /* with the start */
    struct sga_arena mem;
};

static bool fail_copy(struct sga_error *to, const struct sga_error *from)
{
    *to = *from;
    return false;
}

/* Columns of the experiment, or of the trajectory. */
static bool set_columns(struct vary_modes *m, struct reached *r, const char *text)
{
    if (m->is.experiment < 0)
        return vary_model_columns(&r->model, &m->is.model->request.system, text, m->j->err);
    const struct request_experiment *d = r->model.request.fit.experiment + m->is.experiment;
    expr_id *output = sga_zeros(&m->mem, (size_t)d->columns + 1, sizeof *output);
    for (int c = 0; c < d->columns; c++)
        output[c] = d->column[c].output;
    r->model.rq.output = output;
    r->model.rq.outputs = d->columns;
    return true;
}

/* By names: what the start of the motion gives, which natural sizes are told from. */
static void set_start(const struct vary_modes *m, const struct reached *r, double *initial, unsigned char *given)
{
    const struct sys_system *start = &m->is.model->request.system, *s = &r->model.request.system;
    for (int k = 0; k < start->variables; k++) {
        const char *name = start->store->symbol[start->variable[k].symbol].name;
        int symbol = m->is.rq->given[k] ? expr_symbol_find(s->store, name, strlen(name)) : -1;
        for (int v = 0; v < s->variables && symbol >= 0; v++)
            if (s->variable[v].symbol == symbol) {
                initial[v] = m->is.rq->initial[k];
                given[v] = 1;
            }
    }
}

static void set_request(struct vary_modes *m, struct reached *r)
{
    const struct traj_request *from = m->is.rq;
    struct job *own = &r->model.job;
    size_t n = (size_t)r->model.request.system.variables;
    double *initial = sga_zeros(&m->mem, n + 1, sizeof *initial);
    unsigned char *given = sga_zeros(&m->mem, n + 1, 1);
    set_start(m, r, initial, given);
    r->rq = r->model.rq;
    r->rq.event = events_of(&r->model.request, &m->mem);
    r->rq.events = r->model.request.trajectory.events;
    r->rq.mass = masses_of(own, &m->mem);
    r->rq.modes = &m->of;
    r->rq.initial = initial;
    r->rq.given = given;
    r->rq.exact_start = EXPR_UNDEF;
    r->rq.exact_initial = r->rq.exact_time = NULL;
    r->rq.on = own->oracle->reals && own->oracle->real[0].variables == r->model.request.system.variables ? own->oracle->real[0].x : NULL;
    r->rq.start = from->start;
    r->rq.times = from->times;
    r->rq.samples = from->samples;
    r->rq.rtol = from->rtol;
    r->rq.atol = from->atol;
    r->rq.own_atol = from->own_atol;
    r->rq.arithmetic = from->arithmetic == TRAJ_AUTO ? TRAJ_DOUBLE : from->arithmetic;
}

static bool differentiate(struct vary_modes *m, struct reached *r)
{
    struct expr_store *st = &r->model.request.store;
    const struct expr_store *from = &m->is.model->request.store;
    size_t n = (size_t)r->model.request.system.variables, q = (size_t)m->is.directions;
    expr_id *guess = sga_zeros(&m->mem, n * q + 1, sizeof *guess);
    r->by = sga_zeros(&m->mem, q + 1, sizeof *r->by);
    for (size_t d = 0; d < q; d++) {
        int p = m->is.by[d].parameter;
        const char *name = p < 0 ? NULL : from->symbol[p].name;
        r->by[d] = (struct variation_by){ name ? expr_symbol_find(st, name, strlen(name)) : -1, m->is.by[d].variable };
    }
    for (size_t k = 0; k < n * q; k++)
        guess[k] = expr_int(st, 0);
    r->varied = true;
    if (!variation_make(&r->variation, &r->model.request.system, r->model.solution, &r->rq, r->by, (int)q, guess, m->j->err))
        return false;
    memcpy(r->variation.initial, r->rq.initial, n * sizeof *r->rq.initial);
    memcpy(r->variation.given, r->rq.given, n);
    return true;
}

/* Values of the parameters at this motion, in the mode's store. */
static bool parameters_of(const struct vary_modes *m, struct reached *r, expr_id *to)
{
    const struct request *from = &m->is.model->request;
    struct request *own = &r->model.request;
    for (int i = 0; i < own->swept_count; i++) {
        const char *name = own->store.symbol[own->swept[i].symbol].name;
        to[i] = own->swept[i].value;
        for (int k = 0; k < from->swept_count; k++) {
            double value;
            if (strcmp(from->store.symbol[from->swept[k].symbol].name, name))
                continue;
            if (!variation_constants(&from->store, m->at->parameter + k, 1, &value))
                return false;
            to[i] = m->at->parameter[k];
            expr_copy(&own->store, &from->store, to + i, 1, NULL);
        }
    }
    return true;
}

static bool copy(struct vary_modes *m, struct reached *r, struct sga_error *err)
{
    SGA_ARENA(mem);
    expr_id *parameter = sga_zeros(&mem, (size_t)r->model.request.swept_count + 1, sizeof *parameter);
    if (!parameters_of(m, r, parameter))
        return sga_fail(err, SGA_E_EXPR_UNDEFINED, "a parameter has no finite value");
    r->variation.request.single = m->start.rq->single;
    r->copied = true;
    if (!vary_copies_make(&r->copies, &r->variation, &(struct vary_copied){ &r->model.request, &r->model.request.system, r->model.solution, &r->rq, parameter }, err))
        return false;
    r->copies.c.request.programs = r->model.programs;
    r->mode.sys = &r->copies.own.system;
    r->mode.sol = &r->copies.own.solution;
    r->mode.rq = &r->copies.own.request;
    return true;
}

/* The reduction for general values of the parameters is that at these, as seen from where the mode begins. */
static bool landed(void *ctx, const struct traj_mode *mode, double t, const double *x, struct sga_error *err)
{
    struct vary_modes *m = ctx;
    struct reached *r = m->first;
    while (r && &r->mode != mode)
        r = r->next;
    if (!r)
        return true;
    r->copies.own.request.start = t;
    return sweep_case_holds(&r->copies.own, x, NULL)
           || sga_fail(err, SGA_E_NOT_SUPPORTED, "at %.10g the motion enters a mode whose reduction for general values of the parameters does not hold at these, or is not shown to: the values are "
                       "special; leave parameters out", t);
}

/* "m = 1, k = 2" */
static void choice_text(const struct vary_modes *m, const int *choice, char *out, size_t size)
{
    size_t at = 0;
    for (int k = 0; k < m->of.modes && at + 1 < size; k++)
        at += (size_t)snprintf(out + at, size - at, "%s%.40s = %.10g", k ? ", " : "", m->of.name[k], m->of.value[k][choice[k]]);
}

static bool make(struct vary_modes *m, struct reached *r, const struct vary_mode *mode)
{
    char text[200];
    struct job *j = m->j;
    choice_text(m, mode->choice, text, sizeof text);
    if (!vary_model_mode(&r->model, j, mode))
        return false;
    if (r->model.solution->verdict == SGA_INCONSISTENT)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/trajectory/events", "the equations of the mode %.100s are inconsistent for general values of the parameters; leave parameters out", text);
    if (!set_columns(m, r, text))
        return false;
    set_request(m, r);
    return differentiate(m, r);
}

static const struct traj_mode *enter(void *ctx, const int *choice, const struct traj_mode *from, double t, const double *x, struct sga_error *err)
{
    struct vary_modes *m = ctx;
    size_t size = (size_t)m->of.modes * sizeof *choice;
    if (!memcmp(choice, m->choice, size))
        return &m->start;
    struct reached *r = m->first;
    while (r && memcmp(choice, r->choice, size))
        r = r->next;
    if (!r) {
        r = sga_zeros(&m->mem, 1, sizeof *r);
        r->choice = memcpy(sga_zeros(&m->mem, (size_t)m->of.modes + 1, sizeof *choice), choice, size);
        *m->last = r;
        m->last = &r->next;
        r->mode = (struct traj_mode){ .choice = r->choice, .place = m->count++ };
        if (!make(m, r, &(struct vary_mode){ choice, from->sys, t, x, m->is.open, m->is.opens }))
            r->why = *m->j->err;
        if (err != m->j->err)
            *m->j->err = (struct sga_error){ 0 };
    }
    if (r->why.code != SGA_E_OK && !fail_copy(err, &r->why))
        return NULL;
    return r->copied || copy(m, r, err) ? &r->mode : NULL;
}

struct vary_modes *vary_modes_new(struct job *j, const struct vary_modes_of *of)
{
    const struct request *q = &of->model->request;
    if (!q->modes || !events_set_any(q))
        return NULL;
    struct vary_modes *m = sga_calloc(1, sizeof *m);
    *m = (struct vary_modes){ .j = j, .is = *of, .count = 1 };
    m->name = sga_zeros(&m->mem, (size_t)q->modes + 1, sizeof *m->name);
    m->value = sga_zeros(&m->mem, (size_t)q->modes + 1, sizeof *m->value);
    m->values = sga_zeros(&m->mem, (size_t)q->modes + 1, sizeof *m->values);
    m->choice = sga_zeros(&m->mem, (size_t)q->modes + 1, sizeof *m->choice);
    for (int k = 0; k < q->modes; k++) {
        m->name[k] = q->mode[k].name;
        m->value[k] = q->mode[k].value;
        m->values[k] = q->mode[k].values;
        m->choice[k] = q->mode[k].now;
    }
    m->last = &m->first;
    m->of = (struct traj_modes){ .modes = q->modes, .name = m->name, .value = m->value, .values = m->values, .start = &m->start, .enter = enter, .landed = landed, .ctx = m };
    return m;
}

static void drop_copies(struct vary_modes *m)
{
    for (struct reached *r = m->first; r; r = r->next) {
        if (r->copied)
            vary_copies_clear(&r->copies);
        r->copied = false;
    }
}

void vary_modes_start(struct vary_modes *m, const struct vary_at *at, struct vary_copies *start)
{
    drop_copies(m);
    m->at = at;
    m->start = (struct traj_mode){ .sys = &start->own.system, .sol = &start->own.solution, .rq = &start->own.request, .choice = m->choice };
    start->own.request.modes = &m->of;
}

void vary_modes_free(struct vary_modes *m)
{
    if (!m)
        return;
    drop_copies(m);
    for (struct reached *r = m->first; r; r = r->next) {
        if (r->varied)
            variation_clear(&r->variation);
        vary_model_clear(&r->model);
    }
    sga_arena_end(&m->mem);
    free(m);
}
