/* The stage that differentiates the motion: trajectory.sensitivities. */
#include "vary.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arena.h"
#include "budget.h"
#include "buf.h"
#include "error.h"
#include "mem.h"
#include "points.h"
#include "run_job.h"
#include "stage_clock.h"
#include "system.h"
#include "vary_modes.h"
#include "vary_motion.h"
#include "vary_slides.h"

static const char PLACE[] = "/trajectory/sensitivities";
/* Samples of the same motion, computed in two ways, may differ by so many times their estimated errors, and so much beside their size. */
static const double TIMES = 20, BESIDE = 1e-9;

struct asked {
    struct job *j;
    struct vary_model model;
    struct variation variation;
    struct vary_modes *modes;
    struct vary_slides *slides;
    bool varied;
    struct variation_by *by; int directions;
    struct sga_arena mem;
};

/* What cannot be differentiated. */
static bool possible(const struct job *j)
{
    if (j->strata.moves_on)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, PLACE, "the motion starts on a stratum, which a change of a parameter or of the start leaves: it has no derivative there");
    return true;
}

/* The values are no special ones. */
static bool general(struct asked *a)
{
    const struct sga_solution *one = a->j->solution, *all = a->model.solution;
    if (a->j->request->trajectory.conditions)
        return true;
    int here = one->generations ? one->dimension[one->generations - 1] : -1, there = all->generations ? all->dimension[all->generations - 1] : -1;
    if (one->generations == all->generations && here == there && one->free_columns == all->free_columns)
        return true;
    return sga_fail_at(a->j->err, SGA_E_NOT_SUPPORTED, PLACE, "these values are special: for general values of the parameters the final set has another dimension or more generations, so that "
                       "the motion has no derivative here; leave the parameters out by which that is so");
}

static bool set_directions(struct asked *a)
{
    const struct request_sensitivities *s = &a->j->request->trajectory.sensitivities;
    const struct expr_store *st = &a->model.request.store;
    a->by = sga_zeros(&a->mem, (size_t)(s->parameters + s->initials) + 1, sizeof *a->by);
    for (int k = 0; k < s->parameters; k++)
        a->by[a->directions++] = (struct variation_by){ expr_symbol_find(st, s->parameter[k], strlen(s->parameter[k])), -1 };
    for (int k = 0; k < s->initials; k++)
        a->by[a->directions++] = (struct variation_by){ -1, s->initial[k] };
    return true;
}

static bool make_variation(struct asked *a)
{
    size_t n = (size_t)a->model.request.system.variables;
    expr_id *guess = sga_zeros(&a->mem, n * (size_t)a->directions + 1, sizeof *guess);
    for (int d = 0; d < a->directions; d++)
        vary_model_guess(&a->model, &a->model.rq, a->by[d].parameter, a->by[d].variable, guess + (size_t)d * n);
    a->varied = true;
    return variation_make(&a->variation, &a->model.request.system, a->model.solution, &a->model.rq, a->by, a->directions, guess, a->j->err);
}

static const char *output_name(const struct job *j, int k)
{
    const struct request_trajectory *t = &j->request->trajectory;
    return t->outputs ? t->output_text[k] : answer_variable_name(j, k);
}

/* The motion itself, which was computed along, must be the one that was given. */
static bool same_motion(struct asked *a, const struct vary_motion *m)
{
    const struct traj_result *r = &m->result, *own = a->j->trajectory;
    int first = a->directions * own->columns;
    for (int i = 0; i < r->rows; i++)
        for (int k = 0; k < own->columns; k++) {
            double x = r->value[(size_t)i * (size_t)r->columns + (size_t)(first + k)], y = own->value[(size_t)i * (size_t)own->columns + (size_t)k];
            double off = TIMES * ((r->error ? r->error[i] : 0) + (own->error ? own->error[i] : 0)) + BESIDE * (1 + fabs(y));
            if (!(fabs(x - y) <= off) && (isfinite(x) || isfinite(y)))
                return sga_fail_at(a->j->err, SGA_E_NOT_SUPPORTED, PLACE, "for general values of the parameters the motion is another one (%.100s at sample %d differs by %.3g): the values are special, or "
                                   "the constraints have branches", output_name(a->j, k), i, fabs(x - y));
        }
    return true;
}

static void write_names(struct asked *a, struct sga_json *w)
{
    const struct request_sensitivities *s = &a->j->request->trajectory.sensitivities;
    const struct job *j = a->j;
    sga_json_key(w, "columns");
    sga_json_array(w);
    sga_json_string(w, j->request->store.symbol[j->request->system.time].name);
    for (int k = 0; k < j->trajectory->columns; k++)
        for (int d = 0; d < a->directions; d++) {
            struct sga_buf name = { 0 };
            sga_buf_printf(&name, "d(%s)/d(%s)", output_name(j, k), d < s->parameters ? s->parameter[d] : answer_variable_name(j, s->initial[d - s->parameters]));
            sga_json_string(w, name.data);
            sga_buf_free(&name);
        }
    sga_json_end_array(w);
}

static double slope_error(const struct vary_motion *m, int row, int column)
{
    return m->slope_error ? m->slope_error[(size_t)row * (size_t)m->result.columns + (size_t)column] : 0;
}

static bool write_rows(struct asked *a, const struct vary_motion *m, struct sga_json *w)
{
    const struct traj_result *r = &m->result;
    int columns = a->directions * a->j->trajectory->columns;
    sga_json_key(w, "rows");
    sga_json_array(w);
    for (int i = 0; i < r->rows; i++) {
        if (i % 64 == 0 && !(answer_fits(a->j, w->out) && job_goes_on(a->j)))
            return false;
        sga_json_array(w);
        sga_json_double(w, r->t[i]);
        for (int k = 0; k < columns; k++) {
            size_t at = (size_t)i * (size_t)r->columns + (size_t)k;
            if (r->digits && r->digits[at] && !m->slope_error)
                sga_json_raw(w, r->digits[at], strlen(r->digits[at]));
            else
                sga_json_double(w, r->value[at]);
        }
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
    return true;
}

/* By row, and by column: the largest. */
static void write_errors(struct asked *a, const struct vary_motion *m, struct sga_json *w)
{
    const struct traj_result *r = &m->result;
    int columns = a->directions * a->j->trajectory->columns;
    sga_json_key(w, "errors");
    sga_json_array(w);
    for (int i = 0; i < r->rows; i++) {
        double worst = 0;
        for (int k = 0; k < columns; k++)
            worst = fmax(worst, slope_error(m, i, k));
        sga_json_double(w, worst + (r->error ? r->error[i] : NAN));
    }
    sga_json_end_array(w);
    sga_json_key(w, "column_errors");
    sga_json_array(w);
    for (int k = 0; k < columns; k++) {
        double worst = 0;
        for (int i = 0; i < r->rows; i++)
            worst = fmax(worst, slope_error(m, i, k));
        sga_json_double(w, worst + (r->column_error ? r->column_error[k] : NAN));
    }
    sga_json_end_array(w);
}

/* In balls: how far each value may be off what is written. */
static void write_radii(struct asked *a, const struct traj_result *r, struct sga_json *w)
{
    int columns = a->directions * a->j->trajectory->columns;
    if (!r->radius)
        return;
    sga_json_key(w, "radii");
    sga_json_array(w);
    for (int i = 0; i < r->rows; i++) {
        sga_json_array(w);
        for (int k = 0; k < columns; k++)
            sga_json_double(w, r->radius[(size_t)i * (size_t)r->columns + (size_t)k]);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

/* What the differences of the start add is within the tolerances too. */
static bool reached(struct asked *a, const struct vary_motion *m)
{
    const struct traj_result *r = &m->result;
    bool ok = !r->shortfall;
    for (int i = 0; i < r->rows && ok; i++)
        for (int k = 0; k < a->directions * a->j->trajectory->columns && ok; k++)
            ok = slope_error(m, i, k) <= a->model.rq.rtol * fabs(r->value[(size_t)i * (size_t)r->columns + (size_t)k]) + a->model.rq.atol;
    return ok;
}

static bool write(struct asked *a, const struct vary_motion *m)
{
    struct sga_json w;
    struct sga_buf out = { 0 };
    const struct traj_result *r = &m->result;
    sga_json_begin(&w, &out);
    sga_json_object(&w);
    write_names(a, &w);
    bool ok = write_rows(a, m, &w);
    if (ok) {
        write_errors(a, m, &w);
        write_radii(a, r, &w);
        sga_json_member_bool(&w, "accuracy_reached", reached(a, m));
        sga_json_member_string(&w, "start", m->exact_start ? "solved" : "differences");
        sga_json_member_string(&w, "method", r->method);
        sga_json_member_string(&w, "arithmetic", r->arithmetic);
        sga_json_key(&w, "ended");
        if (r->ended) {
            sga_json_object(&w);
            sga_json_member_double(&w, "t", r->ended_t);
            sga_json_member_string(&w, "reason", r->ended_reason);
            sga_json_member_string(&w, "detail", r->ended_detail);
            sga_json_end_object(&w);
        } else {
            sga_json_null(&w);
        }
        sga_json_end_object(&w);
    }
    a->j->sensitivities = sga_buf_take(&out);
    return ok;
}

static bool run(struct asked *a)
{
    struct job *j = a->j;
    const struct request_sensitivities *s = &j->request->trajectory.sensitivities;
    struct request_open *open = sga_zeros(&a->mem, (size_t)s->parameters + 1, sizeof *open);
    for (int k = 0; k < s->parameters; k++)
        open[k].name = s->parameter[k];
    if (!vary_model_make(&a->model, j, open, s->parameters, PLACE) || !general(a) || !set_directions(a))
        return false;
    a->model.rq.samples = j->trajectory->rows;
    const double *on = a->model.rq.on;
    const struct points_oracle *o = a->model.job.oracle;
    /* Where switches are looked for at points of the constraints, the points are of the model's own variables. */
    a->model.rq.on = o && o->reals && o->real[0].variables == a->model.request.system.variables ? o->real[0].x : j->trajectory->initial;
    bool sliding = vary_slides_new(j, &a->model, &a->model.rq, a->by, a->directions, &a->slides);
    a->model.rq.on = on;
    if (!sliding || !make_variation(a))
        return false;
    expr_id *parameter = sga_zeros(&a->mem, (size_t)a->model.request.swept_count + 1, sizeof *parameter);
    for (int i = 0; i < a->model.request.swept_count; i++)
        parameter[i] = a->model.request.swept[i].value;
    struct vary_motion m;
    a->modes = vary_modes_new(j, &(struct vary_modes_of){ &a->model, &a->model.rq, open, s->parameters, a->by, a->directions, -1 });
    struct vary_at at = { .rq = &a->model.rq, .parameter = parameter, .x = j->trajectory->initial, .modes = a->modes, .slides = a->slides };
    if (!vary_motion_run(&m, &a->model, &a->variation, &at, j->err)) {
        if (!j->err->pointer[0])
            snprintf(j->err->pointer, sizeof j->err->pointer, "%s", PLACE);
        return false;
    }
    bool ok = same_motion(a, &m) && write(a, &m);
    vary_motion_clear(&m);
    return ok;
}

/* The motion is kept where the time for its derivatives ends. */
static bool in_time(struct asked *a)
{
    struct job *j = a->j;
    double deadline = job_shorten(j);
    bool ok = !j->trajectory->out_of_time && run(a);
    j->budget->deadline = deadline;
    if (ok || !job_leaves_out(j, deadline, PLACE, "sensitivities"))
        return ok;
    free(j->sensitivities);
    j->sensitivities = NULL;
    return true;
}

bool answer_sensitivities(struct job *j)
{
    struct asked a = { .j = j };
    if (!j->trajectory || !possible(j))
        return !j->trajectory;
    stage_begin(j->clock, STAGE_SENSITIVITIES);
    bool ok = j->trajectory->rows == 0 || in_time(&a);
    vary_modes_free(a.modes);
    vary_slides_free(a.slides);
    if (a.varied)
        variation_clear(&a.variation);
    vary_model_clear(&a.model);
    sga_arena_end(&a.mem);
    return ok && job_goes_on(j);
}

void answer_vary_clear(struct job *j)
{
    free(j->sensitivities);
    free(j->fit);
    j->sensitivities = j->fit = NULL;
}
