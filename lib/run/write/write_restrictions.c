/* Of the form hamiltonian: its 2-form and restrictions. */
#include "write.h"

#include "buf.h"
#include "form.h"
#include "run_job.h"
#include "poly.h"
#include "print.h"
#include "request.h"
#include "warnings.h"

enum { TEXT_BYTES = 400 };

static void write_text(struct job *j, struct sga_json *w, expr_id e)
{
    struct poly_limits limits = poly_limits_of(POLY_MODEST, j->budget);
    expr_id normal;
    if (poly_normal(&j->request->store, e, &limits, &normal))
        e = normal;
    expr_json(&j->request->store, e, TEXT_BYTES, w);
}

static void write_two_form(struct job *j, struct sga_json *w)
{
    sga_json_key(w, "two_form");
    sga_json_object(w);
    sga_json_key(w, "closed");
    if (j->two_form.closed < 0)
        sga_json_null(w);
    else
        sga_json_bool(w, j->two_form.closed);
    if (j->two_form.closed == 0) {
        sga_json_key(w, "component");
        sga_json_array(w);
        for (int k = 0; k < 3; k++)
            sga_json_string(w, answer_variable_name(j, j->two_form.variable[k]));
        sga_json_end_array(w);
        sga_json_key(w, "defect");
        write_text(j, w, j->two_form.defect);
    }
    sga_json_end_object(w);
}

/* The vectors along which the equation was pulled back: row i is "pull-back i". */
static void write_tangent(struct job *j, struct sga_json *w)
{
    int n = j->request->system.variables;
    if (j->primary->count > SGA_MOST_TANGENT_LISTED)
        sga_limit_met(j->budget, SGA_LIMIT_TANGENT_LISTED);
    sga_json_key(w, "pull_back");
    sga_json_array(w);
    for (int i = 0; i < j->primary->count && i < SGA_MOST_TANGENT_LISTED; i++) {
        const expr_id *v = j->primary->vector + (size_t)i * (size_t)n;
        sga_json_object(w);
        for (int k = 0; k < n; k++) {
            if (expr_is_zero(&j->request->store, v[k]))
                continue;
            sga_json_key(w, answer_variable_name(j, k));
            write_text(j, w, v[k]);
        }
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

void answer_write_restrictions(struct job *j, struct sga_json *w)
{
    int n = j->request->system.restrictions;
    if (j->two_form.checked)
        write_two_form(j, w);
    if (j->primary && j->request->want & REQUEST_CONSTRAINTS)
        write_tangent(j, w);
    if (!j->restriction_kept)
        return;
    sga_json_key(w, "redundant_restrictions");
    sga_json_array(w);
    for (int i = 0; i < n; i++)
        if (!j->restriction_kept[i])
            sga_json_int(w, i);
    sga_json_end_array(w);
}
