/* The strata and the assumptions in the result. */
#include "cases.h"
#include "run_job.h"
#include "print.h"
#include "request.h"
#include "stratum.h"
#include "write.h"

#include <assert.h>
#include <string.h>

#include "error.h"

static void write_texts(struct sga_json *w, const struct stratum *s)
{
    sga_json_array(w);
    for (int i = 0; i < s->wheres; i++)
        sga_json_string(w, s->text[i]);
    sga_json_end_array(w);
}

static void write_problem(struct sga_json *w, const struct sga_error *e)
{
    sga_json_key(w, "problem");
    sga_json_object(w);
    sga_json_member_string(w, "code", sga_code_text(e->code));
    sga_json_member_string(w, "detail", e->detail);
    sga_json_end_object(w);
}

/* A point that was found on it, where functions do not say where it is. */
static void write_described(const struct job *j, struct sga_json *w, const struct stratum *s)
{
    assert(s->description || s->point);
    sga_json_member_string(w, "description", s->description);
    if (!s->point)
        return;
    sga_json_key(w, "point");
    sga_json_object(w);
    for (int i = 0; i < j->request->system.variables; i++) {
        sga_json_key(w, answer_variable_name(j, i));
        sga_json_double(w, s->point[i]);
    }
    sga_json_end_object(w);
    sga_json_member_double(w, "time", s->time);
    sga_json_member_bool(w, "point_proved", !s->approximate);
}

static void write_substituted(const struct job *j, struct sga_json *w, const struct cases_part *part)
{
    const struct expr_store *st = &j->request->store;
    sga_json_key(w, "substituted");
    sga_json_object(w);
    for (int i = 0; i < part->puts; i++) {
        struct sga_buf text = { 0 };
        if (expr_print(st, part->put[i].value, 0, &text))
            sga_json_member_string(w, st->symbol[part->put[i].symbol].name, text.data);
        sga_buf_free(&text);
    }
    sga_json_end_object(w);
}

/* What must not vanish: for this answer, and (in a case of parameters) for what was put in. */
static void write_not_zero(const struct job *j, struct sga_json *w, const expr_id *e, int count)
{
    for (int i = 0; i < count; i++) {
        struct sga_buf text = { 0 };
        if (expr_print(&j->request->store, e[i], 0, &text)) {
            sga_json_object(w);
            sga_json_member_string(w, "expression", text.data);
            sga_json_member_string(w, "kind", "not_zero");
            sga_json_end_object(w);
        }
        sga_buf_free(&text);
    }
}

static void write_stratum(const struct job *j, struct sga_json *w, const struct stratum *s)
{
    sga_json_object(w);
    sga_json_key(w, "where");
    write_texts(w, s);
    sga_json_member_string(w, "kind", s->kind);
    if (s->description)
        write_described(j, w, s);
    if (s->off) {
        sga_json_member_bool(w, "meets_final_set", false);
    }
    if (s->part.puts)
        write_substituted(j, w, &s->part);
    if (s->sample.len) {
        sga_json_key(w, "parameters");
        sga_json_raw(w, s->sample.data, s->sample.len);
    }
    if (s->also.len) {
        sga_json_key(w, "also");
        sga_json_array(w);
        sga_json_raw(w, s->also.data, s->also.len);
        sga_json_end_array(w);
    }
    if (s->state == STRATUM_SOLVED) {
        sga_json_key(w, "result");
        sga_json_raw(w, s->result.data, s->result.len);
    } else if (s->state == STRATUM_SAME) {
        sga_json_key(w, "same_as");
        sga_json_raw(w, s->note.data, s->note.len);
    } else if (s->state == STRATUM_UNSOLVED) {
        write_problem(w, &s->error);
    }
    sga_json_end_object(w);
}

void answer_write_strata(const struct job *j, struct sga_json *w)
{
    sga_json_key(w, "strata");
    sga_json_array(w);
    for (int i = 0; i < j->strata.count; i++) {
        const struct stratum *s = j->strata.at + i;
        bool parameter = strcmp(s->kind, "parameter") == 0;
        bool hidden = s->state == STRATUM_EMPTY || s->state == STRATUM_MERGED || s->state == STRATUM_SKIPPED;
        if (!hidden && !(parameter && s->state == STRATUM_LISTED))
            write_stratum(j, w, s);
    }
    sga_json_end_array(w);
    sga_json_key(w, "assumptions");
    sga_json_array(w);
    write_not_zero(j, w, j->place.not_zero, j->place.not_zeros);
    if (j->place.is_case)
        write_not_zero(j, w, j->place.part->excluded, j->place.part->excludeds);
    if (j->signs)
        sga_json_raw(w, j->signs, strlen(j->signs));
    sga_json_end_array(w);
}

void answer_write_empty_strata(const struct job *j, struct sga_json *w)
{
    bool any = false;
    for (int i = 0; i < j->strata.count; i++)
        any |= j->strata.at[i].state == STRATUM_EMPTY;
    if (!any)
        return;
    sga_json_key(w, "empty_strata");
    sga_json_array(w);
    for (int i = 0; i < j->strata.count; i++) {
        const struct stratum *s = j->strata.at + i;
        if (s->state != STRATUM_EMPTY)
            continue;
        sga_json_object(w);
        sga_json_key(w, "where");
        write_texts(w, s);
        sga_json_member_string(w, "why", s->note.data);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}
