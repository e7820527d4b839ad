/* Accelerations, reactions and regularity of the form `mechanical`. */
#include <assert.h>

#include "write.h"

#include "buf.h"
#include "form.h"
#include "reduction.h"
#include "run_job.h"
#include "job_texts.h"
#include "mechanical_answer.h"
#include "print.h"
#include "request.h"

static void write_list(const struct job *j, struct sga_json *w, const char *key, int first)
{
    assert(first >= 0 && first + j->request->mechanical->coordinates <= j->texts->names.roots);
    sga_json_key(w, key);
    sga_json_array(w);
    for (int i = 0; i < j->request->mechanical->coordinates; i++)
        sga_json_string(w, j->texts->names.root[first + i]);
    sga_json_end_array(w);
}

static void write_point(const struct job *j, struct sga_json *w)
{
    const struct mech_regularity *r = &j->mechanical->regularity;
    const struct sys_system *s = &j->request->system;
    sga_json_key(w, "point");
    sga_json_object(w);
    for (int i = 0; i < 2 * j->request->mechanical->coordinates; i++)
        sga_json_member_double(w, s->store->symbol[s->variable[i].symbol].name, r->point[i]);
    if (j->mechanical->fibre.W->depends_on_time)
        sga_json_member_double(w, s->store->symbol[s->time].name, r->t);
    sga_json_end_object(w);
    sga_json_member_bool(w, "certified", r->certified);
    sga_json_member_int(w, "rank_there", r->rank);
    sga_json_member_bool(w, "motion_possible", r->rank == r->augmented);
}

/* Where the conditions are not the request's own: what they are, and whose multiplier is whose. */
static void write_conditions(struct job *j, struct sga_json *w)
{
    const struct mech_fibre *f = &j->mechanical->fibre;
    const struct sys_system *s = &j->request->system;
    sga_json_key(w, "conditions");
    sga_json_array(w);
    for (int i = 0; i < f->conditions; i++) {
        struct sga_buf text = { 0 };
        sga_json_object(w);
        if (expr_print(&j->request->store, f->condition[i], 4000, &text))
            sga_json_member_string(w, "expression", text.data);
        sga_json_member_string(w, "multiplier", s->store->symbol[s->variable[2 * j->request->mechanical->coordinates + f->constraint[i]].symbol].name);
        sga_json_end_object(w);
        sga_buf_free(&text);
    }
    sga_json_end_array(w);
}

static void write_regularity(struct job *j, struct sga_json *w)
{
    const struct mechanical_answer *m = j->mechanical;
    const struct mech_regularity *r = &m->regularity;
    bool full = r->full == MECH_FULL_PROVED || r->full == MECH_FULL_SEARCHED;
    sga_json_member_bool(w, "regular", m->determined && full);
    sga_json_key(w, "regularity");
    sga_json_object(w);
    sga_json_member_int(w, "configuration", 2 * j->request->mechanical->coordinates - m->fibre.W->constraints);
    sga_json_member_bool(w, "determined", m->determined);
    sga_json_member_int(w, "rank", m->fibre.conditions);
    sga_json_member_bool(w, "full_rank", full);
    sga_json_member_string(w, "basis", r->full == MECH_FULL_PROVED ? "proved" : r->full == MECH_FULL_SEARCHED ? "searched"
                           : r->certified ? "point" : "approached");
    sga_json_member_bool(w, "own_conditions", m->fibre.own);
    if (!m->fibre.own && m->fibre.conditions)
        write_conditions(j, w);
    sga_json_key(w, "redundant");
    sga_json_array(w);
    for (int k = 0; k < m->fibre.redundants; k++)
        sga_json_int(w, m->fibre.redundant[k]);
    sga_json_end_array(w);
    sga_json_key(w, "where");
    expr_json_list(&j->request->store, r->where, r->wheres, 4000, w);
    if (r->point)
        write_point(j, w);
    sga_json_end_object(w);
}

void answer_write_mechanical(struct job *j, struct sga_json *w)
{
    const struct mechanical_answer *m = j->mechanical;
    int n = j->request->mechanical->coordinates, first = m->first_root;
    if (m->has_regularity)
        write_regularity(j, w);
    if (!m->has_motion)
        return;
    sga_json_key(w, "acceleration");
    sga_json_object(w);
    write_list(j, w, "total", first);
    write_list(j, w, "tangent", first + n);
    write_list(j, w, "orthogonal", first + 2 * n);
    sga_json_end_object(w);
    write_list(j, w, "reaction", first + 3 * n);
}
