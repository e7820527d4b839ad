/* The motions of a fit's experiments as functions of its unknowns. */
#include "fit_work.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "budget.h"
#include "defined.h"
#include "error.h"
#include "mem.h"
#include "run_job.h"
#include "system.h"
#include "vary_modes.h"
#include "vary_slides.h"

/* Motions are computed to this at the least, whatever the request's tolerances: what is fitted is a small difference of them. */
static const double RTOL = 1e-10;

static int by_time(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The times of the data, each once, away from the start. */
static void set_times(struct fit_work *w, struct fit_experiment *e)
{
    const struct request_experiment *d = e->data;
    double start = w->model.rq.start;
    double *time = sga_take(&w->mem, (size_t)d->times * sizeof *time);
    memcpy(time, d->time, (size_t)d->times * sizeof *time);
    qsort(time, (size_t)d->times, sizeof *time, by_time);
    bool down = time[0] < start;
    e->time = sga_take(&w->mem, (size_t)d->times * sizeof *time);
    for (int i = 0; i < d->times; i++) {
        double t = time[down ? d->times - 1 - i : i];
        if (!e->times || e->time[e->times - 1] != t)
            e->time[e->times++] = t;
    }
    e->place = sga_take(&w->mem, (size_t)d->times * sizeof *e->place);
    for (int i = 0; i < d->times; i++)
        for (int low = 0, high = e->times - 1; low <= high;) {
            int middle = (low + high) / 2;
            e->place[i] = middle;
            if (e->time[middle] == d->time[i])
                break;
            if ((e->time[middle] < d->time[i]) != down)
                low = middle + 1;
            else
                high = middle - 1;
        }
}

/* The motion's request: this experiment's start and outputs. */
static void set_request(struct fit_work *w, struct fit_experiment *e)
{
    const struct request_experiment *d = e->data;
    size_t n = (size_t)w->model.request.system.variables;
    double *initial = sga_zeros(&w->mem, n + 1, sizeof *initial);
    unsigned char *given = sga_zeros(&w->mem, n + 1, 1);
    expr_id *exact = sga_zeros(&w->mem, n + 1, sizeof *exact), *output = sga_zeros(&w->mem, (size_t)d->columns + 1, sizeof *output);
    for (int k = 0; k < d->initials; k++) {
        int v = d->initial[k].variable;
        initial[v] = d->initial[k].value;
        exact[v] = d->initial[k].open ? d->initial[k].open : d->initial[k].exact;
        given[v] = 1;
    }
    for (int k = 0; k < w->fit->initials; k++) {
        given[w->fit->initial[k].variable] = 1;
        exact[w->fit->initial[k].variable] = EXPR_UNDEF;
    }
    for (int c = 0; c < d->columns; c++)
        output[c] = d->column[c].output;
    e->rq = w->model.rq;
    e->rq.times = e->time;
    e->rq.samples = e->times;
    e->rq.initial = initial;
    e->rq.given = given;
    e->rq.exact_initial = exact;
    e->rq.exact_time = NULL;
    e->rq.output = output;
    e->rq.outputs = d->columns;
    e->rq.arithmetic = TRAJ_DOUBLE;
    e->rq.rtol = fmin(e->rq.rtol, RTOL);
    if (!e->rq.own_atol)
        e->rq.atol = e->rq.rtol * REQUEST_ATOL_OF_RTOL;
    e->initial = sga_zeros(&w->mem, n + 1, sizeof *e->initial);
    e->x = sga_zeros(&w->mem, n + 1, sizeof *e->x);
}

static bool make_variation(struct fit_work *w, struct fit_experiment *e)
{
    struct vary_model *m = &w->model;
    const struct request_fit *f = w->fit;
    size_t n = (size_t)m->request.system.variables;
    int directions = f->parameters + f->initials;
    struct variation_by *by = sga_zeros(&w->mem, (size_t)directions + 1, sizeof *by);
    expr_id *guess = sga_zeros(&w->mem, n * (size_t)directions + 1, sizeof *guess);
    for (int d = 0; d < directions; d++) {
        by[d] = d < f->parameters ? (struct variation_by){ expr_symbol_find(&m->request.store, f->parameter[d].name, strlen(f->parameter[d].name)), -1 }
                                  : (struct variation_by){ -1, f->initial[d - f->parameters].variable };
        vary_model_guess(m, &e->rq, by[d].parameter, by[d].variable, guess + (size_t)d * n);
    }
    if (!vary_slides_new(w->j, m, &e->rq, by, directions, &e->slides))
        return false;
    e->varied = true;
    e->modes = vary_modes_new(w->j, &(struct vary_modes_of){ m, &e->rq, w->open, f->parameters, by, directions, (int)(e - w->experiment) });
    if (variation_make(&e->variation, &m->request.system, m->solution, &e->rq, by, directions, guess, w->j->err))
        return true;
    if (w->j->err->code == SGA_E_NOT_SUPPORTED)
        snprintf(w->j->err->pointer, sizeof w->j->err->pointer, "/fit");
    return false;
}

/* What the equations leave open must be chosen, or the outputs are not determined. */
static bool determined(struct fit_work *w)
{
    const struct vary_model *m = &w->model;
    if (m->solution->free_columns <= m->rq.rates)
        return true;
    int first = m->solution->free_column[0];
    return sga_fail_at(w->j->err, SGA_E_INPUTS, "/fit/data", "the equations do not determine the motion (%d function%s stay%s free, such as the derivative of %.100s), and so no output to fit: fix "
                       "it by trajectory.gauge, or add the equations that are missing", m->solution->free_columns, m->solution->free_columns > 1 ? "s" : "",
                       m->solution->free_columns > 1 ? "" : "s", answer_variable_name(&m->job, first));
}

static void set_unknowns(struct fit_work *w)
{
    const struct request_fit *f = w->fit;
    size_t all = (size_t)f->parameters + (size_t)f->initials * (size_t)f->experiments;
    w->unknowns = (int)all;
    w->low = sga_zeros(&w->mem, all + 1, sizeof *w->low);
    w->high = sga_zeros(&w->mem, all + 1, sizeof *w->high);
    w->guess = sga_zeros(&w->mem, all + 1, sizeof *w->guess);
    for (size_t k = 0; k < all; k++) {
        int i = (int)k - f->parameters;
        const struct request_unknown *u = i < 0 ? f->parameter + k : f->initial + i % f->initials;
        w->low[k] = u->low;
        w->high[k] = u->high;
        w->guess[k] = u->guess;
        if (i < 0 || u->has_guess)
            continue;
        const struct request_experiment *d = f->experiment + i / f->initials;
        for (int s = 0; s < d->initials; s++)
            if (d->initial[s].variable == u->variable)
                w->guess[k] = d->initial[s].value;
    }
}

bool fit_work_begin(struct fit_work *w, struct job *j)
{
    const struct request_fit *f = &j->request->fit;
    *w = (struct fit_work){ .j = j, .lost = -1 };
    struct request_open *open = sga_zeros(&w->mem, (size_t)f->parameters + 1, sizeof *open);
    for (int k = 0; k < f->parameters; k++)
        open[k] = (struct request_open){ f->parameter[k].name, f->parameter[k].guess, true };
    w->open = open;
    if (j->request->accuracy.arithmetic == REQUEST_BALL || j->request->accuracy.arithmetic == REQUEST_DOUBLE_DOUBLE)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/accuracy/arithmetic", "a fit is computed in double; use \"double\" or \"auto\"");
    if (!vary_model_make(&w->model, j, open, f->parameters, "/fit/parameters") || !determined(w))
        return false;
    w->fit = &w->model.request.fit;
    set_unknowns(w);
    w->experiment = sga_zeros(&w->mem, (size_t)f->experiments + 1, sizeof *w->experiment);
    for (int i = 0; i < f->experiments; i++) {
        struct fit_experiment *e = w->experiment + i;
        e->data = w->fit->experiment + i;
        e->first = f->parameters + i * f->initials;
        set_times(w, e);
        set_request(w, e);
        if (!make_variation(w, e))
            return false;
        w->data += e->data->columns * e->data->times;
        for (int c = 0; c < e->data->columns; c++)
            for (int k = 0; k < e->data->times; k++)
                w->measured += isfinite(e->data->column[c].value[k]) && e->data->column[c].weight[k] > 0;
    }
    return true;
}

void fit_work_end(struct fit_work *w)
{
    for (int i = 0; w->experiment && w->fit && i < w->fit->experiments; i++) {
        vary_slides_free(w->experiment[i].slides);
        if (w->experiment[i].varied) {
            vary_modes_free(w->experiment[i].modes);
            variation_clear(&w->experiment[i].variation);
        }
    }
    vary_model_clear(&w->model);
    sga_arena_end(&w->mem);
}

/* Values of the swept parameters, in the model's store. */
static expr_id *parameters_at(struct fit_work *w, const double *x, struct sga_arena *mem)
{
    struct request *r = &w->model.request;
    expr_id *value = sga_take(mem, ((size_t)r->swept_count + 1) * sizeof *value);
    for (int i = 0; i < r->swept_count; i++) {
        value[i] = r->swept[i].value;
        for (int k = 0; k < w->fit->parameters; k++)
            if (!strcmp(r->store.symbol[r->swept[i].symbol].name, w->fit->parameter[k].name))
                value[i] = expr_double(&r->store, x[k]);
    }
    return value;
}

/* What a motion that does not come to all of its data is not good for. */
static bool comes_to_data(struct fit_work *w, const struct fit_experiment *e, const struct traj_result *r)
{
    if (r->rows >= e->times)
        return true;
    return sga_fail(&w->why, SGA_E_NO_MOTION, "the motion ends at %.6g (%s: %.200s), before the data do, of which the next are at %.6g", r->ended_t, r->ended_reason ? r->ended_reason : "", r->ended_detail,
                    e->time[r->rows]);
}

static bool motion_at(struct fit_work *w, struct fit_experiment *e, const double *x, struct vary_motion *to)
{
    SGA_ARENA(mem);
    const struct request_fit *f = w->fit;
    double *own = sga_zeros(&mem, (size_t)w->model.request.system.variables + 1, sizeof *own);
    for (int i = 0; i < f->initials; i++)
        own[f->initial[i].variable] = x[e->first + i];
    struct vary_at at = { .rq = &e->rq, .parameter = parameters_at(w, x, &mem), .initial = own, .modes = e->modes, .slides = e->slides };
    if (!vary_start_at(&w->model, &at, e->x, e->initial, &w->why))
        return false;
    at.initial = e->initial;
    at.x = e->x;
    for (int j = 0; j < e->variation.n; j++)
        e->variation.guess[j] = e->initial[e->variation.of_defined ? e->variation.defined->variable[j] : j];
    e->variation.request.single = !w->estimate;
    bool ok = vary_motion_run(to, &w->model, &e->variation, &at, &w->why);
    vary_slides_again(e->slides);
    if (!ok)
        return false;
    if (comes_to_data(w, e, &to->result))
        return true;
    vary_motion_clear(to);
    return false;
}

/* The lines of one experiment, from *at on. */
static void fill(struct fit_work *w, const struct fit_experiment *e, const struct vary_motion *m, double *r, double *J, int *at, double *noise)
{
    const struct request_fit *f = w->fit;
    const struct traj_result *t = &m->result;
    int directions = f->parameters + f->initials, columns = e->data->columns;
    for (int c = 0; c < columns; c++)
        for (int k = 0; k < e->data->times; k++, ++*at) {
            const double *row = t->value + (size_t)e->place[k] * (size_t)t->columns;
            double root = sqrt(e->data->column[c].weight[k]), measured = e->data->column[c].value[k], value = row[directions * columns + c];
            double *line = J + (size_t)*at * (size_t)w->unknowns;
            memset(line, 0, (size_t)w->unknowns * sizeof *line);
            if (w->sample)
                w->sample[*at] = value;
            r[*at] = 0;
            if (!isfinite(measured) || !(root > 0))
                continue;
            r[*at] = root * (value - measured);
            for (int d = 0; d < directions; d++)
                line[d < f->parameters ? d : e->first + d - f->parameters] = root * row[c * directions + d];
            *noise += pow(root * (t->error && w->estimate ? fmax(t->error[e->place[k]], 0) : 1e-11 * fabs(value)), 2);
        }
}

bool fit_work_value(void *work, const double *x, double *r, double *J)
{
    struct fit_work *w = work;
    int at = 0;
    double noise = 0;
    for (int i = 0; i < w->fit->experiments; i++) {
        struct vary_motion m;
        w->why = (struct sga_error){ 0 };
        w->lost = i;
        if (!motion_at(w, w->experiment + i, x, &m))
            return false;
        fill(w, w->experiment + i, &m, r, J, &at, &noise);
        vary_motion_clear(&m);
    }
    w->lost = -1;
    w->noise = sqrt(noise);
    return true;
}

bool fit_work_goes_on(void *work)
{
    return job_has_left(((struct fit_work *)work)->j);
}

bool fit_work_estimate(struct fit_work *w, const double *x, double *r, double *J)
{
    w->estimate = true;
    bool ok = fit_work_value(w, x, r, J);
    w->estimate = false;
    return ok;
}
