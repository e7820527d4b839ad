/* The stage `transfer`: from the given equations where their coefficients are rational numbers, else from the linearization at the start. */
#include "ask.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "ask_work.h"
#include "error.h"
#include "operator_json.h"
#include "reduction.h"
#include "request.h"
#include "run_job.h"
#include "stage_clock.h"
#include "system.h"
#include "transfer_moving.h"
#include "transfer_response.h"
#include "transfer_matrix.h"

static bool refuse(struct job *j, bool inputs_bound, const char *output)
{
    if (inputs_bound)
        return sga_fail_at(j->err, SGA_E_INPUTS, "/transfer/inputs", "the equations ask something of the inputs alone, so that there is no transfer matrix from "
                           "them; leave one of them out of transfer.inputs");
    return sga_fail_at(j->err, SGA_E_INPUTS, "/transfer/outputs", "%.200s is not determined by the inputs: the equations leave more free; name what is free "
                       "among transfer.inputs, or leave this output out", output);
}

static void write_matrix(struct sga_json *w, const struct transfer_matrix *t)
{
    sga_json_key(w, "matrix");
    sga_json_array(w);
    for (int i = 0; i < t->outputs; i++) {
        sga_json_array(w);
        for (int k = 0; k < t->inputs; k++) {
            SGA_ENDS(sga_buf_free) struct sga_buf text = { 0 };
            transfer_entry_text(t, i, k, &text);
            sga_json_string(w, text.data);
        }
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

static void write_columns(const struct ask_work *s, struct sga_json *w)
{
    bool one = s->rq.inputs == 1 && s->rq.outputs == 1;
    sga_json_key(w, "columns");
    sga_json_array(w);
    sga_json_string(w, "omega");
    for (int i = 0; i < s->rq.outputs; i++)
        for (int k = 0; k < s->rq.inputs; k++)
            for (int part = 0; part < 2; part++) {
                SGA_ENDS(sga_buf_free) struct sga_buf name = { 0 };
                sga_buf_puts(&name, part ? "im" : "re");
                if (!one)
                    sga_buf_printf(&name, " %s/%s", s->ports.output[i], s->ports.input[k].name);
                sga_json_string(w, name.data);
            }
    sga_json_end_array(w);
}

/* Rows of doubles, null at a pole. */
static bool write_response(struct ask_work *s, const struct transfer_matrix *t, const struct linearization *l, struct sga_json *w)
{
    const struct request_transfer *r = &s->j->request->transfer;
    double worst = 0;
    if (!r->frequencies)
        return true;
    sga_json_key(w, "response");
    sga_json_object(w);
    write_columns(s, w);
    sga_json_key(w, "rows");
    sga_json_array(w);
    struct transfer_response value;
    transfer_response_init(&value, s->rq.outputs, s->rq.inputs);
    bool ok = true;
    for (int f = 0; f < r->frequencies && ok; f++) {
        if (t)
            transfer_response_exact(&value, t, r->frequency[f]);
        else
            transfer_response_enclosed(&value, l, r->frequency[f]);
        worst = fmax(worst, value.error);
        sga_json_array(w);
        sga_json_double(w, r->frequency[f]);
        for (int k = 0; k < 2 * s->rq.outputs * s->rq.inputs; k++)
            sga_json_double(w, value.number[k]);
        sga_json_end_array(w);
        ok = job_goes_on(s->j) && answer_fits(s->j, w->out);
    }
    transfer_response_clear(&value);
    sga_json_end_array(w);
    sga_json_member_double(w, "relative_error", worst);
    sga_json_end_object(w);
    return ok;
}

static bool write_exact(struct ask_work *s, const struct transfer_equations *e, const char *from)
{
    struct sga_json *w = &s->json;
    struct job *j = s->j;
    struct transfer_matrix t;
    struct spectrum_of poles = { .count = 0 }, zeros = { .count = 0 };
    if (linear_cols(e->A) > TRANSFER_MOST)
        return sga_fail(j->err, SGA_E_LIMIT_VARIABLES, "the system has %d variables beside the inputs; rational transfer matrices are made up to %d",
                        linear_cols(e->A), TRANSFER_MOST);
    enum transfer_status status = transfer_matrix_find(&t, e);
    if (status != TRANSFER_OK)
        return refuse(j, status == TRANSFER_INPUTS_BOUND, s->ports.outputs ? s->ports.output[t.which] : "");
    bool ok = transfer_matrix_poles(&t, &poles, &zeros, j->budget, j->err);
    if (ok) {
        sga_json_object(w);
        linear_write_ports(&s->ports, w);
        write_matrix(w, &t);
        linear_write_spectrum(w, "poles", &poles);
        linear_write_spectrum(w, "zeros", &zeros);
        sga_json_member_bool(w, "proper", transfer_matrix_proper(&t, false));
        sga_json_member_bool(w, "strictly_proper", transfer_matrix_proper(&t, true));
        ok = write_response(s, &t, NULL, w);
        sga_json_key(w, "evidence");
        sga_json_object(w);
        sga_json_member_string(w, "from", from);
        sga_json_member_string(w, "matrix", "exact");
        sga_json_end_object(w);
        sga_json_end_object(w);
    }
    spectrum_of_clear(&poles);
    spectrum_of_clear(&zeros);
    transfer_matrix_clear(&t);
    return ok;
}

/* Poles are the eigenvalues where all of them are reached and shown. */
static bool write_enclosed(struct ask_work *s, const struct linearization *l)
{
    struct sga_json *w = &s->json;
    struct linear_modes m;
    struct spectrum_of none = { .missing = "" };
    bool ok = linear_modes_find(&m, l, s->j->budget, s->j->err);
    if (ok) {
        bool minimal = m.controllable.dimension == l->states && m.observable.dimension == l->states;
        sga_json_object(w);
        linear_write_ports(&s->ports, w);
        sga_json_key(w, "matrix");
        sga_json_null(w);
        linear_write_spectrum(w, "poles", minimal ? &m.eigenvalues : &none);
        linear_write_spectrum(w, "zeros", minimal ? &m.zeros : &none);
        sga_json_member_bool(w, "proper", true);
        sga_json_key(w, "strictly_proper");
        if (l->D.exact)
            sga_json_bool(w, fmpq_mat_is_zero(l->D.q));
        else
            sga_json_null(w);
        ok = write_response(s, NULL, l, w);
        sga_json_key(w, "evidence");
        sga_json_object(w);
        sga_json_member_string(w, "from", "linearization");
        sga_json_member_string(w, "matrix", "enclosed: entries of the state form are no rational numbers");
        if (minimal && m.zeros.missing && m.zeros.missing[0])
            sga_json_member_string(w, "zeros", m.zeros.missing);
        if (!minimal)
            sga_json_member_string(w, "poles", "not told: it is not proved that inputs reach and outputs show all eigenvalues");
        sga_json_end_object(w);
        sga_json_end_object(w);
    }
    linear_modes_clear(&m);
    return ok;
}

/* The linearization at the start, which has to be an equilibrium: elsewhere it changes with time. */
static bool take(struct ask_work *s, const struct linearization *l, bool anywhere)
{
    struct job *j = s->j;
    if (!l->constant && j->solution->depends_on_time)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/want", "the coefficients move with time, so that there is no function of s, nor is there a fraction of operators%s%s: linearize at an instant, by "
                           "want \"linearization\"", *s->why ? ", as " : "", s->why);
    if (anywhere && !l->constant)
        return sga_fail_at(j->err, SGA_E_MISSING_MEMBER, "/transfer", "the system, or an output, is not linear with constant coefficients: say by \"trajectory\" with "
                           "\"initial\" at which equilibrium it is to be linearized");
    if (l->equilibrium != 1 && !l->constant)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/trajectory/initial", "the start is not shown to be an equilibrium: the linearization there changes with time, "
                           "and has no transfer matrix; start at an equilibrium");
    struct transfer_equations e = { .A = &l->A, .B = &l->B, .C = &l->C, .D = &l->D };
    bool exact = l->A.exact && l->B.exact && l->C.exact && l->D.exact;
    return exact ? write_exact(s, &e, "linearization") : write_enclosed(s, l);
}

static void write_fraction(const struct ask_work *s, const struct op_fraction *f, struct sga_json *w)
{
    const char *time = s->rq.sys->store->symbol[s->rq.sys->time].name;
    sga_json_key(w, "fraction");
    sga_json_object(w);
    sga_json_key(w, "left");
    op_json_ores(w, &f->left, time);
    sga_json_key(w, "right");
    op_json_ores(w, &f->right, time);
    sga_json_end_object(w);
}

/* Coefficients that move with time: a fraction of operators. *linear false: others than rational functions, and nothing is written. */
static bool write_moving(struct ask_work *s, bool *linear, char *why)
{
    struct job *j = s->j;
    struct sga_json *w = &s->json;
    struct op_fraction f;
    enum op_fraction_status status = OP_FRACTION_FAILED;
    bool ok = transfer_moving(&f, &status, s, linear, why, j->err);
    if (ok && status != OP_FRACTION_FOUND) {
        ok = refuse(j, status == OP_FRACTION_INPUTS_BOUND, f.which >= 0 ? s->ports.output[f.which] : "");
    } else if (ok && j->request->transfer.frequencies) {
        ok = sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/transfer/frequencies", "the coefficients move with time: a sine at the input comes out as no sine, so that there is no response "
                         "to frequencies; leave them out");
    } else if (ok) {
        sga_json_object(w);
        linear_write_ports(&s->ports, w);
        sga_json_key(w, "matrix");
        sga_json_null(w);
        write_fraction(s, &f, w);
        sga_json_key(w, "poles");
        sga_json_null(w);
        sga_json_key(w, "zeros");
        sga_json_null(w);
        sga_json_member_bool(w, "proper", op_fraction_proper(&f, false));
        sga_json_member_bool(w, "strictly_proper", op_fraction_proper(&f, true));
        sga_json_key(w, "evidence");
        sga_json_object(w);
        sga_json_member_string(w, "from", "equations");
        sga_json_member_string(w, "matrix", "coefficients move with time: a fraction of operators, exact");
        sga_json_member_string(w, "poles", "systems whose coefficients move with time have none");
        sga_json_end_object(w);
        sga_json_end_object(w);
    }
    op_fraction_clear(&f);
    return ok;
}

static bool ports(struct ask_work *s)
{
    if (s->rq.inputs && s->rq.outputs)
        return true;
    return sga_fail_at(s->j->err, SGA_E_MISSING_MEMBER, "/transfer", "a transfer matrix needs inputs and outputs: name them in transfer.inputs and transfer.outputs");
}

static bool run(struct ask_work *s)
{
    struct job *j = s->j;
    struct linearization given;
    bool constant = false;
    if (j->request->op.has)
        return sga_fail_at(j->err, SGA_E_NOT_SUPPORTED, "/want", "the form operator answers with the series of its transfer matrix and a state form by itself; for "
                           "rational functions give form \"descriptor\" or \"linear\"");
    if (!ask_possible(j) || !ports(s))
        return false;
    bool ok = linear_given(&given, &s->rq, &constant, j->err);
    struct transfer_equations e = { &given.E, &given.F, &given.DA, &given.DB, &given.DC, &given.DD };
    if (ok && constant)
        ok = write_exact(s, &e, "equations");
    linearization_clear(&given);
    if (!ok || constant)
        return ok;
    bool moving = false;
    if (j->solution->depends_on_time)
        ok = write_moving(s, &moving, s->why);
    return moving ? ok : ask_at_start(s);
}

/* What linearizing says of its inputs is about the transfer matrix's here. */
static void point_to_transfer(struct sga_error *err)
{
    static const char from[] = "/linearization/";
    char rest[sizeof err->pointer];
    if (strncmp(err->pointer, from, strlen(from)) != 0)
        return;
    snprintf(rest, sizeof rest, "%s", err->pointer + strlen(from));
    if (strcmp(rest, "at") == 0)         /* the start is where it is linearized */
        snprintf(err->pointer, sizeof err->pointer, "/trajectory/initial");
    else
        snprintf(err->pointer, sizeof err->pointer, "/transfer/%.200s", rest);
}

bool answer_transfer(struct job *j)
{
    struct ask_work s;
    stage_begin(j->clock, STAGE_TRANSFER);
    j->ask = j->ask ? j->ask : sga_zeros(&j->mem, 1, sizeof *j->ask);
    ask_begin(&s, j, &j->request->transfer.ports, &j->ask->transfer);
    s.take = take;
    s.rq.said_in = "transfer.inputs";
    bool ok = run(&s);
    if (!ok)
        point_to_transfer(j->err);
    sga_arena_end(&s.mem);
    return ok;
}
