/* The member `symmetries` of the result. */
#include "run_job.h"
#include "buf.h"
#include "job_symmetries.h"
#include "print.h"
#include "request.h"
#include "sym.h"
#include "system.h"
#include "warnings.h"
#include "write.h"

static void member_truth(struct sga_json *w, const char *key, enum sym_truth truth)
{
    sga_json_key(w, key);
    if (truth == SYM_UNKNOWN)
        sga_json_null(w);
    else
        sga_json_bool(w, truth == SYM_TRUE);
}

static void expression(struct job *j, struct sga_json *w, expr_id e)
{
    if (!expr_json(&j->request->store, e, SGA_MOST_SYMMETRY_BYTES, w) && e != EXPR_UNDEF)
        sga_limit_met(j->budget, SGA_LIMIT_SYMMETRY_BYTES);
}

static const char *component_name(const struct job *j, int k)
{
    const struct sys_system *s = &j->request->system;
    return j->request->store.symbol[k < s->variables ? s->variable[k].symbol : s->time].name;
}

static void write_defects(struct job *j, struct sga_json *w, const struct sym_check *c)
{
    sga_json_key(w, "defects");
    sga_json_array(w);
    for (int k = 0; k < c->defects; k++) {
        sga_json_object(w);
        sga_json_member_string(w, "condition", c->defect[k].condition);
        sga_json_key(w, "expression");
        expression(j, w, c->defect[k].expr);
        sga_json_member_bool(w, "decided", c->defect[k].nonzero);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_check(struct job *j, struct sga_json *w, int k)
{
    static const struct sym_check none = { SYM_UNKNOWN, SYM_UNKNOWN, SYM_UNKNOWN, SYM_UNKNOWN, SYM_UNKNOWN, .defects = 0 };
    const struct sym_check *c = j->symmetries->has ? j->symmetries->check + k : &none;
    sga_json_object(w);
    sga_json_member_string(w, "name", j->request->symmetries.check[k].name);
    member_truth(w, "symmetry", c->symmetry);
    member_truth(w, "tangent", c->tangent);
    member_truth(w, "preserves_T", c->preserves_T);
    member_truth(w, "preserves_alpha", c->preserves_alpha);
    member_truth(w, "gauge", c->gauge);
    sga_json_key(w, "defect");       /* of the first condition that fails */
    if (c->defects)
        expression(j, w, c->defect[0].expr);
    else
        sga_json_null(w);
    write_defects(j, w, c);
    sga_json_end_object(w);
}

static void write_components(struct job *j, struct sga_json *w, const expr_id *component)
{
    sga_json_key(w, "field");
    sga_json_object(w);
    for (int k = 0; k <= j->request->system.variables; k++) {
        if (expr_is_zero(&j->request->store, component[k]))
            continue;
        sga_json_key(w, component_name(j, k));
        expression(j, w, component[k]);
    }
    sga_json_end_object(w);
}

static void write_field(struct job *j, struct sga_json *w, const struct sym_field *f)
{
    sga_json_object(w);
    write_components(j, w, f->component);
    sga_json_member_bool(w, "gauge", f->gauge);
    member_truth(w, "along_motion", f->along_motion);
    sga_json_end_object(w);
}

static void write_commutator(struct job *j, struct sga_json *w, const struct sym_commutator *c)
{
    sga_json_object(w);
    sga_json_member_int(w, "left", c->left);
    sga_json_member_int(w, "right", c->right);
    sga_json_key(w, "combination");
    if (c->closed) {
        sga_json_array(w);
        for (int k = 0; k < j->symmetries->found.fields; k++) {
            if (expr_is_zero(&j->request->store, c->factor[k]))
                continue;
            sga_json_object(w);
            sga_json_member_int(w, "field", k);
            sga_json_key(w, "factor");
            expression(j, w, c->factor[k]);
            sga_json_end_object(w);
        }
        sga_json_end_array(w);
    } else {
        sga_json_null(w);
    }
    sga_json_end_object(w);
}

static void write_evidence(struct sga_json *w, const char *key, const struct sym_evidence *e)
{
    sga_json_key(w, key);
    sga_json_object(w);
    sga_json_member_bool(w, "complete", e->complete);
    sga_json_key(w, "reason");
    if (e->why_not)
        sga_json_string(w, e->why_not);
    else
        sga_json_null(w);
    sga_json_member_int(w, "unknowns", e->unknowns);
    sga_json_member_int(w, "modular_points", e->points);
    if (e->reals)
        sga_json_member_int(w, "real_points", e->reals);
    sga_json_member_int(w, "primes", e->primes);
    sga_json_member_int(w, "dropped", e->dropped);
    sga_json_end_object(w);
}

static void write_search(struct job *j, struct sga_json *w)
{
    const struct sym_result *r = &j->symmetries->found;
    sga_json_key(w, "found");
    sga_json_array(w);
    for (int k = 0; k < r->fields; k++)
        write_field(j, w, r->field + k);
    sga_json_end_array(w);
    sga_json_key(w, "commutators");
    sga_json_array(w);
    for (int k = 0; k < r->commutators; k++)
        write_commutator(j, w, r->commutator + k);
    sga_json_end_array(w);
    sga_json_key(w, "first_integrals");
    sga_json_array(w);
    for (int k = 0; k < r->integrals; k++)
        expression(j, w, r->integral[k]);
    sga_json_end_array(w);
    sga_json_key(w, "search");
    sga_json_object(w);
    sga_json_member_int(w, "degree", j->request->symmetries.degree);
    sga_json_member_int(w, "integral_degree", j->request->symmetries.integral_degree);
    sga_json_member_bool(w, "time", j->symmetries->time);
    write_evidence(w, "fields", &r->of_fields);
    write_evidence(w, "integrals", &r->of_integrals);
    sga_json_end_object(w);
}

static void write_noether(struct job *j, struct sga_json *w)
{
    const struct sym_result *r = &j->symmetries->found;
    sga_json_key(w, "noether");
    sga_json_array(w);
    for (int k = 0; k < r->noethers; k++) {
        sga_json_object(w);
        write_components(j, w, r->noether[k].component);
        sga_json_key(w, "integral");
        expression(j, w, r->noether[k].integral);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

void answer_write_symmetries(struct job *j, struct sga_json *w)
{
    const struct sym_result *r = &j->symmetries->found;
    sga_json_key(w, "symmetries");
    sga_json_object(w);
    sga_json_key(w, "checked");
    sga_json_array(w);
    for (int k = 0; k < j->request->symmetries.checks; k++)
        write_check(j, w, k);
    sga_json_end_array(w);
    if (j->symmetries->has) {
        sga_json_key(w, "presymplectic");
        sga_json_object(w);
        member_truth(w, "antisymmetric", r->antisymmetric);
        member_truth(w, "closed", r->closed);
        member_truth(w, "alpha_closed", r->alpha_closed);
        sga_json_end_object(w);
        member_truth(w, "gauge_closed", r->gauge_closed);
        if (j->request->symmetries.has_search) {
            write_search(j, w);
            write_noether(j, w);
        }
    }
    sga_json_end_object(w);
}
