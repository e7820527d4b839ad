/* Modes that a motion reaches: read, reduced and told. */
#include "modes.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "buf.h"
#include "error.h"
#include "events_of.h"
#include "oracle.h"
#include "points.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "sweep_case.h"
#include "system.h"
#include "trajectory.h"
#include "vary_model.h"
#include "warnings.h"
#include "write.h"

/* One that was reached after the start. */
struct reached {
    struct vary_model model;
    struct traj_mode mode;
    struct traj_request rq;
    int *choice;
    struct reached *next;
    struct sga_error why;     /* it cannot be entered */
    bool ready;               /* for this set of a sweep; without one it is so once */
    struct sweep_case at; bool has_at;     /* at the parameters of the set */
};

struct modes {
    struct job *j;
    struct sga_arena *mem;
    struct traj_modes of;
    struct traj_mode start;
    int *choice;
    struct reached *first, **last;
    int count;                /* with the start */
    int set;                  /* of the sweep */
};

static int variable_of(const struct sys_system *s, int symbol)
{
    for (int k = 0; k < s->variables; k++)
        if (s->variable[k].symbol == symbol)
            return k;
    return -1;
}

/* "m = 1, k = 2" */
static void choice_text(const struct modes *m, const int *choice, char *out, size_t size)
{
    size_t at = 0;
    for (int k = 0; k < m->of.modes && at + 1 < size; k++)
        at += (size_t)snprintf(out + at, size - at, "%s%.40s = %.10g", k ? ", " : "", m->of.name[k], m->of.value[k][choice[k]]);
}

/* The start of this set, by names; and the mode at the set's parameters. */
static bool make_ready(struct modes *m, struct reached *r, struct sga_error *err)
{
    const struct sys_system *start = m->start.sys, *s = &r->model.request.system;
    const struct traj_request *from = m->start.rq;
    double *initial = sga_zeros(m->mem, (size_t)s->variables + 1, sizeof *initial);
    unsigned char *given = sga_zeros(m->mem, (size_t)s->variables + 1, 1);
    for (int k = 0; k < start->variables; k++) {
        const char *name = start->store->symbol[start->variable[k].symbol].name;
        int symbol = from->given[k] ? expr_symbol_find(s->store, name, strlen(name)) : -1, v = symbol < 0 ? -1 : variable_of(s, symbol);
        if (v >= 0) {
            initial[v] = from->initial[k];
            given[v] = 1;
        }
    }
    r->rq.initial = initial;
    r->rq.given = given;
    r->rq.exact_start = EXPR_UNDEF;
    r->rq.exact_initial = r->rq.exact_time = NULL;
    if (r->model.request.swept_count) {
        r->has_at = true;
        if (!sweep_case_of(&r->at, &r->model.request, s, r->model.solution, &r->rq, r->model.request.sweep[m->set].parameter, err))
            return false;
        if (!r->at.solved)
            return sga_fail(err, SGA_E_EXPR_UNDEFINED, "the reduction of a mode for general parameters has no value at these; send these values as a request of their own");
        r->mode = (struct traj_mode){ .sys = &r->at.system, .sol = &r->at.solution, .rq = &r->at.request, .choice = r->choice, .place = r->mode.place };
    }
    r->ready = true;
    return true;
}

/* Whether the general reduction holds at the set's parameters, seen from where the mode begins. */
static bool landed(void *ctx, const struct traj_mode *mode, double t, const double *x, struct sga_error *err)
{
    struct modes *m = ctx;
    struct reached *r = m->first;
    while (r && &r->mode != mode)
        r = r->next;
    if (!r || !r->has_at)
        return true;
    r->at.request.start = t;
    return sweep_case_holds(&r->at, x, NULL)
           || sga_fail(err, SGA_E_NOT_SUPPORTED, "at %.10g the motion enters a mode whose reduction for general parameters does not hold at these; send these values as a request of their own", t);
}

/* What the reduction chose among branches near one start is not that of another. */
static bool for_all_starts(const struct modes *m, const struct reached *r, const char *text)
{
    const struct sga_solution *s = r->model.solution;
    bool several = s->branches > 0;
    for (int i = 0; i < s->constraints; i++)
        several |= s->constraint[i].chosen || s->constraint[i].near_point;
    return !several || !m->j->request->sweeps
           || sga_fail_at(m->j->err, SGA_E_NOT_SUPPORTED, "/sweep", "with %s the constraints have branches, so that starts need analyses of their own; send one request for each", text);
}

static const struct traj_mode *again(struct modes *m, struct reached *r, struct sga_error *err)
{
    if (r->why.code == SGA_E_OK)
        return r->ready || make_ready(m, r, err) ? &r->mode : NULL;
    *err = r->why;
    return NULL;
}

static const struct traj_mode *enter(void *ctx, const int *choice, const struct traj_mode *from, double t, const double *x, struct sga_error *err)
{
    struct modes *m = ctx;
    struct job *j = m->j;
    size_t size = (size_t)m->of.modes * sizeof *choice;
    for (int k = 0; k < m->of.modes; k++)
        assert(choice[k] >= 0 && choice[k] < m->of.values[k]);
    if (!memcmp(choice, m->choice, size))
        return &m->start;
    for (struct reached *r = m->first; r; r = r->next)
        if (!memcmp(choice, r->choice, size))
            return again(m, r, err);
    struct reached *r = sga_zeros(m->mem, 1, sizeof *r);
    char text[200];
    r->choice = sga_zeros(m->mem, (size_t)m->of.modes + 1, sizeof *r->choice);
    memcpy(r->choice, choice, size);
    *m->last = r;
    m->last = &r->next;
    choice_text(m, choice, text, sizeof text);
    struct job *own = &r->model.job;
    bool ok = vary_model_mode(&r->model, j, &(struct vary_mode){ choice, from->sys, t, x, NULL, 0 });
    if (ok && own->solution->verdict == SGA_INCONSISTENT)
        ok = sga_fail_at(j->err, SGA_E_EVENT_SET, "/trajectory/events", "at %.10g the motion enters the mode %.100s, whose equations are inconsistent: %.200s; stop there, or set another value", t, text,
                         own->solution->contradiction_why);
    ok = ok && vary_model_columns(&r->model, &j->request->system, text, j->err);
    if (ok) {
        r->rq = r->model.rq;
        r->rq.event = events_of(&r->model.request, m->mem);
        r->rq.events = r->model.request.trajectory.events;
        r->rq.modes = &m->of;
        r->rq.mass = masses_of(own, m->mem);
        r->rq.on = own->oracle->reals && own->oracle->real[0].variables == r->model.request.system.variables ? own->oracle->real[0].x : NULL;
        r->mode = (struct traj_mode){ .sys = &r->model.request.system, .sol = r->model.solution, .rq = &r->rq, .choice = r->choice, .place = m->count++ };
        ok = for_all_starts(m, r, text) && make_ready(m, r, j->err);
    }
    if (!ok)
        r->why = *j->err;
    if (!ok && err != j->err) {   /* of one set of a sweep */
        *err = *j->err;
        *j->err = (struct sga_error){ 0 };
    }
    return ok ? &r->mode : NULL;
}

struct modes *modes_begin(struct job *j, struct traj_request *rq, struct sga_arena *mem)
{
    const struct request *q = j->request;
    if (!events_set_any(q) || j->place.depth)
        return NULL;
    rq->mass = masses_of(j, mem);
    if (!q->modes)
        return NULL;
    struct modes *m = sga_zeros(mem, 1, sizeof *m);
    const char **name = sga_zeros(mem, (size_t)q->modes + 1, sizeof *name);
    const double **value = sga_zeros(mem, (size_t)q->modes + 1, sizeof *value);
    int *values = sga_zeros(mem, (size_t)q->modes + 1, sizeof *values);
    *m = (struct modes){ .j = j, .mem = mem, .count = 1 };
    m->choice = sga_zeros(mem, (size_t)q->modes + 1, sizeof *m->choice);
    for (int k = 0; k < q->modes; k++) {
        name[k] = q->mode[k].name;
        value[k] = q->mode[k].value;
        values[k] = q->mode[k].values;
        m->choice[k] = q->mode[k].now;
    }
    m->last = &m->first;
    m->start = (struct traj_mode){ .sys = &q->system, .sol = j->solution, .rq = rq, .choice = m->choice };
    m->of = (struct traj_modes){ .modes = q->modes, .name = name, .value = value, .values = values, .start = &m->start, .enter = enter, .landed = landed, .ctx = m };
    rq->modes = &m->of;
    return m;
}

static char *values_text(struct job *j, const struct job *of)
{
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    struct sga_json json;
    sga_json_begin(&json, &out);
    answer_mode_values(of, &json);
    return sga_take_text(&j->mem, out.data);
}

static char *entry_text(struct job *j, struct job *of)
{
    SGA_ENDS(sga_buf_free) struct sga_buf out = { 0 };
    struct sga_json json;
    sga_json_begin(&json, &out);
    sga_json_object(&json);
    answer_write_reduction(of, &json);
    sga_json_end_object(&json);
    return sga_take_text(&j->mem, out.data);
}

/* Values of modes that events set, and that the motion has not had. */
static void warn_missed(const struct modes *m)
{
    for (int k = 0; k < m->of.modes; k++)
        for (int i = 0; i < m->of.values[k]; i++) {
            bool had = m->choice[k] == i;
            char place[16 + REQUEST_MAX_NAME];
            for (const struct reached *r = m->first; r; r = r->next)
                had |= r->choice[k] == i;
            snprintf(place, sizeof place, "/system/modes/%s", m->of.name[k]);
            if (!had)
                sga_warn(m->j->budget, SGA_W_MODE_NOT_REACHED, place, "the motion never has %s = %.17g: its equations were not reduced", m->of.name[k], m->of.value[k][i]);
        }
}

void modes_set(struct modes *m, int set, const struct sys_system *sys, const struct sga_solution *sol, const struct traj_request *rq)
{
    if (!m)
        return;
    assert(set >= 0 && set < m->j->request->sweeps);
    m->set = set;
    m->start = (struct traj_mode){ .sys = sys, .sol = sol, .rq = rq, .choice = m->choice };
    for (struct reached *r = m->first; r; r = r->next) {
        if (r->has_at)
            sweep_case_clear(&r->at);
        r->ready = r->has_at = false;
    }
}

void modes_tell(struct modes *m)
{
    struct job *j = m ? m->j : NULL;
    if (!m || j->modes.count == m->count)
        return;
    int k = 1;
    j->modes.values = sga_zeros(&j->mem, (size_t)m->count + 1, sizeof *j->modes.values);
    j->modes.entry = sga_zeros(&j->mem, (size_t)m->count + 1, sizeof *j->modes.entry);
    j->modes.values[0] = values_text(j, j);
    for (struct reached *r = m->first; r && r->mode.sys; r = r->next, k++) {
        j->modes.values[k] = values_text(j, &r->model.job);
        j->modes.entry[k] = entry_text(j, &r->model.job);
    }
    assert(k <= m->count);       /* one that could not be entered is none */
    j->modes.count = k;
}

void modes_end(struct modes *m, bool ok)
{
    if (!m)
        return;
    if (ok && (m->j->trajectory || m->j->sweep)) {
        modes_tell(m);
        warn_missed(m);
    }
    for (struct reached *r = m->first; r; r = r->next) {
        if (r->has_at)
            sweep_case_clear(&r->at);
        vary_model_clear(&r->model);
    }
}
