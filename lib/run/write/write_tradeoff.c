/* The member `tradeoff` of the result. */
#include "run_job.h"
#include "tradeoff.h"
#include "write.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LAST_COLUMNS = 16 };

/* The columns at the last sample, where there are few: how the digits settle. */
static void write_last(const struct tradeoff_row *row, struct sga_json *w)
{
    const struct tradeoff_values *v = &row->values;
    if (v->rows == 0 || v->columns > LAST_COLUMNS)
        return;
    const num_dd *last = v->value + (size_t)(v->rows - 1) * (size_t)v->columns;
    sga_json_key(w, "last");
    sga_json_array(w);
    for (int k = 0; k < v->columns; k++) {
        char *text = row->arithmetic == TRAJ_DOUBLE ? NULL : num_dd_text(last[k], NUM_DD_DIGITS);
        if (text)
            sga_json_raw(w, text, strlen(text));
        else
            sga_json_double(w, last[k].hi);
        free(text);
    }
    sga_json_end_array(w);
}

static void write_row(const struct tradeoff_row *row, struct sga_json *w)
{
    sga_json_object(w);
    sga_json_member_string(w, "method", row->method);
    sga_json_member_string(w, "arithmetic", tradeoff_arithmetic(row->arithmetic));
    sga_json_member_double(w, "rtol", row->rtol);
    sga_json_member_double(w, "atol", row->atol);
    sga_json_member_double(w, "seconds", row->seconds);
    sga_json_member_double(w, "evaluations", row->evaluations < 0 ? NAN : (double)row->evaluations);
    sga_json_member_double(w, "error", row->error);
    sga_json_member_double(w, "residual", row->residual);
    if (row->compared) {
        sga_json_member_double(w, "error_at_most", row->error_at_most);
        sga_json_member_double(w, "digits", isnan(row->digits) ? row->digits : floor(row->digits * 10) / 10);
        sga_json_member_bool(w, "within", row->within);
    }
    write_last(row, w);
    if (row->note[0])
        sga_json_member_string(w, "note", row->note);
    sga_json_end_object(w);
}

static void write_best(const struct tradeoff_best *b, struct sga_json *w)
{
    sga_json_key(w, "best");
    if (!b->has) {
        sga_json_null(w);
        return;
    }
    sga_json_object(w);
    sga_json_member_string(w, "method", b->method);
    sga_json_member_string(w, "arithmetic", b->arithmetic);
    sga_json_member_double(w, "rtol", b->rtol);
    sga_json_member_double(w, "error_estimate", b->error_estimate);
    sga_json_end_object(w);
}

static void write_choices(const struct tradeoff *t, struct sga_json *w)
{
    sga_json_key(w, "choices");
    sga_json_array(w);
    for (int k = 0; k < TRADEOFF_CHOICES; k++) {
        sga_json_object(w);
        sga_json_key(w, "digits");
        if (t->choice[k].digits)
            sga_json_int(w, t->choice[k].digits);
        else
            sga_json_null(w);
        sga_json_key(w, "row");
        if (t->choice[k].row >= 0)
            sga_json_int(w, t->choice[k].row);
        else
            sga_json_null(w);
        sga_json_key(w, "reached");
        if (t->choice[k].row >= 0 || t->choice[k].none)
            sga_json_bool(w, !t->choice[k].none);
        else
            sga_json_null(w);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

static void write_left_out(const struct tradeoff *t, struct sga_json *w)
{
    sga_json_key(w, "left_out");
    sga_json_array(w);
    for (int i = 0; i < t->left_outs; i++) {
        sga_json_object(w);
        sga_json_member_string(w, "method", t->left_out[i].method);
        sga_json_member_string(w, "arithmetic", t->left_out[i].arithmetic);
        if (t->left_out[i].from > 0)
            sga_json_member_double(w, "from", t->left_out[i].from);
        sga_json_member_string(w, "reason", t->left_out[i].reason);
        sga_json_end_object(w);
    }
    sga_json_end_array(w);
}

void answer_write_tradeoff(const struct job *j, struct sga_json *w)
{
    const struct tradeoff *t = j->tradeoff;
    sga_json_key(w, "tradeoff");
    sga_json_object(w);
    sga_json_key(w, "rows");
    sga_json_array(w);
    for (int i = 0; i < t->rows; i++)
        write_row(t->row + i, w);
    sga_json_end_array(w);
    sga_json_member_string(w, "advice", t->advice.data);
    write_choices(t, w);
    write_best(&t->best, w);
    write_left_out(t, w);
    sga_json_end_object(w);
}
