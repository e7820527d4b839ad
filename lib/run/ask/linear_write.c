/* The object of one point in `linearization`. */
#include "linear_write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "buf.h"
#include "request.h"
#include "run_job.h"

/* Exact entries are texts of rationals, others numbers. */
static void write_matrix(struct sga_json *w, const char *key, const struct linear_matrix *m)
{
    sga_json_key(w, key);
    sga_json_array(w);
    for (int i = 0; i < linear_rows(m); i++) {
        sga_json_array(w);
        for (int k = 0; k < linear_cols(m); k++) {
            if (!m->exact) {
                sga_json_double(w, linear_matrix_double(m, i, k));
                continue;
            }
            char *text = fmpq_get_str(NULL, 10, fmpq_mat_entry(m->q, i, k));
            sga_json_string(w, text);
            flint_free(text);
        }
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

void linear_write_spectrum(struct sga_json *w, const char *key, const struct spectrum_of *s)
{
    sga_json_key(w, key);
    if (s->missing) {
        sga_json_null(w);
        return;
    }
    sga_json_array(w);
    for (int i = 0; i < s->count; i++) {
        sga_json_array(w);
        sga_json_raw(w, s->value[i].re, strlen(s->value[i].re));
        sga_json_raw(w, s->value[i].im, strlen(s->value[i].im));
        sga_json_int(w, s->value[i].multiplicity);
        sga_json_end_array(w);
    }
    sga_json_end_array(w);
}

static void write_names(const struct job *j, struct sga_json *w, const char *key, const int *variable, int count)
{
    sga_json_key(w, key);
    sga_json_array(w);
    for (int k = 0; k < count; k++)
        sga_json_string(w, answer_variable_name(j, variable[k]));
    sga_json_end_array(w);
}

void linear_write_ports(const struct linear_ports *p, struct sga_json *w)
{
    sga_json_key(w, "inputs");
    sga_json_array(w);
    for (int k = 0; k < p->inputs; k++)
        sga_json_string(w, p->input[k].name);
    sga_json_end_array(w);
    sga_json_key(w, "outputs");
    sga_json_array(w);
    for (int k = 0; k < p->outputs; k++)
        sga_json_string(w, p->output[k]);
    sga_json_end_array(w);
    if (p->gauge)
        sga_json_member_string(w, "gauge", p->gauge);
}

static void write_state(const struct job *j, const struct linearization *l, struct sga_json *w)
{
    sga_json_key(w, "state");
    sga_json_object(w);
    write_names(j, w, "names", l->state, l->states);
    if (l->shifted)
        write_matrix(w, "shift", &l->shift);
    write_matrix(w, "A", &l->A);
    write_matrix(w, "B", &l->B);
    write_matrix(w, "C", &l->C);
    write_matrix(w, "D", &l->D);
    sga_json_end_object(w);
    sga_json_key(w, "descriptor");
    sga_json_object(w);
    write_names(j, w, "names", l->variable, l->variables);
    write_matrix(w, "E", &l->E);
    if (l->rates)
        write_matrix(w, "F", &l->F);
    write_matrix(w, "A", &l->DA);
    write_matrix(w, "B", &l->DB);
    write_matrix(w, "C", &l->DC);
    write_matrix(w, "D", &l->DD);
    sga_json_end_object(w);
}

static void write_point(const struct job *j, const struct linearization *l, bool at_point, struct sga_json *w)
{
    sga_json_key(w, "t");
    if (at_point)
        sga_json_double(w, l->place.t);
    else
        sga_json_null(w);
    sga_json_key(w, "point");
    if (!at_point) {
        sga_json_null(w);
        return;
    }
    sga_json_object(w);
    for (int k = 0; k < j->request->system.variables; k++)
        sga_json_member_double(w, answer_variable_name(j, k), l->place.x[k]);
    sga_json_end_object(w);
}

static void write_reach(struct sga_json *w, const char *key, const char *missed, const struct linear_reach *r)
{
    sga_json_key(w, key);
    sga_json_object(w);
    sga_json_key(w, "dimension");
    if (r->dimension < 0) {
        sga_json_null(w);
        sga_json_member_int(w, "least", r->least);
    } else {
        sga_json_int(w, r->dimension);
    }
    linear_write_spectrum(w, missed, &r->missed);
    sga_json_end_object(w);
}

static void write_stable(struct sga_json *w, enum linear_stability s)
{
    static const char *const word[] = { "asymptotic", "marginal", "unstable" };
    sga_json_key(w, "stable");
    if (s == LINEAR_UNDECIDED)
        sga_json_null(w);
    else
        sga_json_bool(w, s != LINEAR_UNSTABLE);
    sga_json_key(w, "stability");
    if (s == LINEAR_UNDECIDED)
        sga_json_null(w);
    else
        sga_json_string(w, word[s]);
}

static double matrix_error(const struct linearization *l)
{
    const struct linear_matrix *const all[] = { &l->A, &l->B, &l->C, &l->D, &l->E, &l->F, &l->DA, &l->DB, &l->DC, &l->DD, &l->shift };
    double worst = 0;
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        worst = all[k]->exact ? worst : fmax(worst, linear_matrix_error(all[k]));
    return worst;
}

static void write_evidence(const struct linearization *l, const struct linear_modes *m, bool at_point, struct sga_json *w)
{
    static const char *const basis[] = { "exact", "proved", "numeric" };
    bool exact = l->A.exact && l->B.exact && l->C.exact && l->D.exact && l->shift.exact;
    sga_json_key(w, "evidence");
    sga_json_object(w);
    if (at_point)
        sga_json_member_string(w, "point", basis[l->place.basis]);
    sga_json_member_bool(w, "constant", l->constant);
    sga_json_key(w, "equilibrium");
    if (l->equilibrium < 0 || !at_point)
        sga_json_null(w);
    else
        sga_json_bool(w, l->equilibrium);
    sga_json_member_string(w, "matrices", exact ? "exact" : l->place.basis == LINEAR_NUMERIC ? "numeric" : "enclosed");
    if (!exact)
        sga_json_member_double(w, "matrix_error", matrix_error(l));
    sga_json_member_string(w, "eigenvalues", m->eigenvalues.missing ? m->eigenvalues.missing : m->eigenvalues.exact ? "exact" : "enclosed");
    if (!m->eigenvalues.missing && !m->eigenvalues.exact)
        sga_json_member_double(w, "eigenvalue_error", m->eigenvalues.error);
    if (m->zeros.missing)
        sga_json_member_string(w, "zeros", m->zeros.missing);
    sga_json_member_string(w, "stability", m->why);
    sga_json_end_object(w);
}

void linear_write(const struct job *j, const struct linear_ports *ports, const struct linearization *l, const struct linear_modes *m, bool at_point,
                  struct sga_json *w)
{
    sga_json_object(w);
    write_point(j, l, at_point, w);
    linear_write_ports(ports, w);
    write_state(j, l, w);
    linear_write_spectrum(w, "eigenvalues", &m->eigenvalues);
    if (ports->inputs && ports->outputs)
        linear_write_spectrum(w, "zeros", &m->zeros);
    if (ports->inputs)
        write_reach(w, "controllable", "uncontrollable", &m->controllable);
    if (ports->outputs)
        write_reach(w, "observable", "unobservable", &m->observable);
    write_stable(w, m->stability);
    write_evidence(l, m, at_point, w);
    sga_json_end_object(w);
}
