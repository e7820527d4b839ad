/* The trajectory's part of the result. */
#include <assert.h>
#include <math.h>
#include <string.h>

#include "buf.h"
#include "job_integrals.h"
#include "points_space.h"
#include "request.h"
#include "run_job.h"
#include "stratum.h"
#include "trajectory.h"
#include "write.h"

static void write_columns(const struct job *j, struct sga_json *w)
{
    const struct request_trajectory *t = &j->request->trajectory;
    sga_json_key(w, "columns");
    sga_json_array(w);
    sga_json_string(w, j->request->store.symbol[j->request->system.time].name);
    if (t->outputs)
        for (int k = 0; k < t->outputs; k++)
            sga_json_string(w, t->output_text[k]);
    else
        for (int k = 0; k < j->request->system.variables; k++)
            sga_json_string(w, answer_variable_name(j, k));
    sga_json_end_array(w);
}

/* With all its digits, where it has more than a double. */
static void write_digits(const char *digits, double value, struct sga_json *w)
{
    if (digits)
        sga_json_raw(w, digits, strlen(digits));
    else
        sga_json_double(w, value);
}

static void write_number(const struct traj_result *r, size_t place, struct sga_json *w)
{
    write_digits(r->digits ? r->digits[place] : NULL, r->value[place], w);
}

static bool write_rows(struct job *j, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    sga_json_key(w, "rows");
    sga_json_array(w);
    for (int i = 0; i < r->rows; i++) {
        if (i % 64 == 0 && !(answer_goes(j, w->out) && job_goes_on(j)))
            return false;
        sga_json_array(w);
        sga_json_double(w, r->t[i]);
        for (int k = 0; k < r->columns; k++)
            write_number(r, (size_t)i * (size_t)r->columns + (size_t)k, w);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
    return true;
}

/* Balls: how far the true value is at most from what is written, by rows like the rows without time. */
static bool write_radii(struct job *j, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    if (!r->radius)
        return true;
    sga_json_key(w, "radii");
    sga_json_array(w);
    for (int i = 0; i < r->rows; i++) {
        if (i % 64 == 0 && !answer_goes(j, w->out))
            return false;
        sga_json_array(w);
        for (int k = 0; k < r->columns; k++)
            sga_json_double(w, r->radius[(size_t)i * (size_t)r->columns + (size_t)k]);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
    return true;
}

/* By column without time, where there are such numbers. */
static void write_columnwise(struct sga_json *w, const char *key, const double *value, int columns)
{
    if (!value)
        return;
    sga_json_key(w, key);
    sga_json_array(w);
    for (int k = 0; k < columns; k++)
        sga_json_double(w, value[k]);
    sga_json_end_array(w);
}

/* One estimate for each row, and whether all are within the tolerances. */
static bool write_errors(struct job *j, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    sga_json_key(w, "errors");
    sga_json_array(w);
    for (int i = 0; i < r->rows && r->error; i++) {
        if (i % 1024 == 0 && !answer_goes(j, w->out))
            return false;
        sga_json_double(w, r->error[i]);
    }
    sga_json_end_array(w);
    write_columnwise(w, "column_errors", r->column_error, r->columns);
    write_columnwise(w, "units", r->unit, r->columns);
    sga_json_member_bool(w, "accuracy_reached", !r->shortfall);
    if (r->shortfall)
        sga_json_member_string(w, "accuracy_shortfall", r->shortfall);
    if (!r->inputs_examined)
        sga_json_member_string(w, "inputs_not_examined", "functions of time in the equations vary too fast, or are too many, to be searched "
                               "for narrow pulses everywhere: a pulse between steps would be seen in no error estimate");
    return true;
}

/* Where a request has events. */
static bool write_events(struct job *j, struct sga_json *w)
{
    static const char *const directions[] = { "down", "touch", "up" };
    const struct traj_result *r = j->trajectory;
    const struct request_trajectory *t = &j->request->trajectory;
    if (!t->events)
        return true;
    sga_json_key(w, "events");
    sga_json_array(w);
    for (int i = 0; i < r->happened; i++) {
        const struct traj_happening *h = r->happening + i;
        if (i % 64 == 0 && !(answer_goes(j, w->out) && job_goes_on(j)))
            return false;
        sga_json_object(w);
        sga_json_member_string(w, "name", t->event[h->event].name);
        sga_json_key(w, "t");
        write_digits(r->happened_digits ? r->happened_digits[(size_t)i * ((size_t)r->columns + 1)] : NULL, h->t, w);
        sga_json_member_double(w, "error", h->error);
        sga_json_member_string(w, "direction", h->undecided ? "undecided" : directions[h->direction + 1]);
        sga_json_key(w, "values");
        sga_json_array(w);
        for (int k = 0; k < r->columns; k++)
            write_digits(r->happened_digits ? r->happened_digits[(size_t)i * ((size_t)r->columns + 1) + 1 + (size_t)k] : NULL,
                         r->happened_value[(size_t)i * (size_t)r->columns + (size_t)k], w);
        sga_json_end_array(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    return true;
}

static void write_values(const struct job *j, struct sga_json *w, const char *key, const double *value)
{
    sga_json_key(w, key);
    sga_json_object(w);
    for (int k = 0; k < j->request->system.variables; k++) {
        sga_json_key(w, answer_variable_name(j, k));
        sga_json_double(w, value[k]);
    }
    sga_json_end_object(w);
}

/* given, projected, moved, residuals of the start's equations */
static void write_start(const struct job *j, struct sga_json *w, const double *projected, double moved, const double *relation, int relations)
{
    const struct request_trajectory *t = &j->request->trajectory;
    sga_json_key(w, "given");
    sga_json_object(w);
    for (int k = 0; k < t->initials; k++) {
        sga_json_key(w, answer_variable_name(j, t->initial[k].variable));
        sga_json_double(w, t->initial[k].value);
    }
    sga_json_end_object(w);
    write_values(j, w, "projected", projected);
    sga_json_member_double(w, "moved", moved);
    if (relations) {
        sga_json_key(w, "start_equations");
        sga_json_array(w);
        for (int k = 0; k < relations; k++)
            sga_json_double(w, relation[k]);
        sga_json_end_array(w);
    }
    answer_write_slice_start(j, w);
}

void answer_write_initial(const struct job *j, struct sga_json *w)
{
    assert(j->initial->x && j->initial_residuals >= 0);
    const struct traj_initial *r = j->initial;
    sga_json_key(w, "consistent_initial");
    sga_json_object(w);
    write_start(j, w, r->x, r->moved, r->relation, r->relations);
    write_values(j, w, "derivatives", r->derivative);
    sga_json_member_string(w, "gauge", r->gauge);
    sga_json_key(w, "free");
    sga_json_array(w);
    for (int k = 0; k < r->frees; k++)
        sga_json_string(w, answer_variable_name(j, r->free[k]));
    sga_json_end_array(w);
    sga_json_key(w, "residuals");
    sga_json_array(w);
    for (int k = 0; k < j->initial_residuals; k++)
        sga_json_double(w, r->residual[k]);
    sga_json_end_array(w);
    sga_json_end_object(w);
}

bool answer_write_trajectory(struct job *j, struct sga_json *w)
{
    sga_json_key(w, "trajectory");
    sga_json_object(w);
    return answer_write_motion(j, w);
}

static void write_charts(const struct traj_result *r, struct sga_json *w)
{
    if (!r->charts)
        return;
    sga_json_key(w, "charts");
    sga_json_array(w);
    for (int i = 0; i < r->charts; i++) {
        sga_json_object(w);
        sga_json_member_double(w, "t", r->chart[i].t);
        sga_json_member_string(w, "left", r->chart[i].pivot ? r->chart[i].pivot : "");
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_passed(const struct traj_result *r, struct sga_json *w)
{
    if (!r->passes)
        return;
    sga_json_key(w, "passed");
    sga_json_array(w);
    for (int i = 0; i < r->passes; i++) {
        sga_json_object(w);
        sga_json_member_double(w, "t", r->passed[i].t);
        sga_json_member_string(w, "detail", r->passed[i].detail);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_slides(const struct job *j, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    if (!j->slides.surface)
        return;
    sga_json_key(w, "slides");
    sga_json_array(w);
    for (int i = 0; i < r->slides; i++) {
        const struct traj_slide *s = r->slide + i;
        sga_json_object(w);
        sga_json_member_string(w, "surface", j->slides.surface[i]);
        sga_json_member_double(w, "from", s->from);
        sga_json_member_double(w, "to", s->to);
        sga_json_member_double(w, "error", s->error);
        sga_json_member_string(w, "left", s->left > 0 ? "up" : s->left < 0 ? "down" : "not");
        sga_json_key(w, "switch");
        sga_json_array(w);
        sga_json_double(w, s->least);
        sga_json_double(w, s->most);
        sga_json_end_array(w);
        sga_json_member_int(w, "dimension", j->slides.dimension[i]);
        sga_json_member_int(w, "generations", j->slides.generations[i]);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

bool answer_write_motion(struct job *j, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    if (j->strata.moves_on) {
        const struct stratum *s = j->strata.at + (j->strata.moves_on - 1);
        sga_json_key(w, "stratum");
        sga_json_array(w);
        for (int k = 0; k < s->wheres; k++)
            sga_json_string(w, s->text[k]);
        sga_json_end_array(w);
    }
    write_columns(j, w);
    if (!write_rows(j, w) || !write_events(j, w))
        return false;
    sga_json_key(w, "initial");
    sga_json_object(w);
    write_start(j, w, r->initial, r->moved, r->relation, r->relations);
    sga_json_end_object(w);
    sga_json_member_double(w, "error_estimate", r->error_estimate);
    if (!write_errors(j, w) || !write_radii(j, w))
        return false;
    sga_json_member_double(w, "constraint_residual", r->residual);
    answer_write_drift(j, w);
    sga_json_member_string(w, "method", r->method);
    sga_json_member_string(w, "arithmetic", r->arithmetic);
    sga_json_member_string(w, "gauge", r->gauge);
    if (r->gauge_numeric)
        sga_json_member_string(w, "gauge_numeric", r->gauge_numeric);
    if (j->sensitivities) {
        sga_json_key(w, "sensitivities");
        answer_raw(j, w, j->sensitivities);
    }
    answer_write_pieces(j, w);
    write_slides(j, w);
    write_charts(r, w);
    write_passed(r, w);
    sga_json_key(w, "ended");
    if (r->ended) {
        sga_json_object(w);
        sga_json_member_double(w, "t", r->ended_t);
        sga_json_member_double(w, "error", r->ended_error > 0 ? r->ended_error : NAN);
        sga_json_member_string(w, "reason", r->ended_reason);
        if (r->ended_event >= 0)
            sga_json_member_string(w, "name", j->request->trajectory.event[r->ended_event].name);
        sga_json_member_string(w, "detail", r->ended_detail);
        sga_json_end_object(w);
    } else {
        sga_json_null(w);
    }
    sga_json_end_object(w);
    return true;
}

void answer_write_drift(const struct job *j, struct sga_json *w)
{
    const struct traj_result *r = j->trajectory;
    if (!r->drift)
        return;
    sga_json_key(w, "drift");
    sga_json_object(w);
    sga_json_member_double(w, "constraints", r->residual);
    sga_json_key(w, "integrals");
    sga_json_array(w);
    for (int i = 0; j->integrals && i < j->integrals->count; i++) {
        const struct traj_drift *d = r->drift + i;
        enum points_truth truth = j->integrals->truth[i];
        double size = d->start < 0 ? -d->start : d->start;
        sga_json_object(w);
        sga_json_member_string(w, "function", j->integrals->given[i] < 0 ? "energy" : j->request->trajectory.integral_text[j->integrals->given[i]]);
        sga_json_key(w, "conserved");
        if (truth == POINTS_UNKNOWN)
            sga_json_null(w);
        else
            sga_json_bool(w, truth == POINTS_ZERO);
        sga_json_member_double(w, "start", d->start);
        sga_json_member_double(w, "end", d->end);
        sga_json_member_double(w, "largest", d->largest);
        sga_json_key(w, "relative");
        if (size > 0)
            sga_json_double(w, d->largest / size);
        else
            sga_json_null(w);
        sga_json_member_double(w, "t", d->t);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
    sga_json_end_object(w);
}
